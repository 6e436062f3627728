"""The analytic functions that closed forms are made of, each free of cancellation wherever it is evaluated.

Points are z = y + i x [m] about the contact's centre, x >= 0 being the depth.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .._check import ComplexArray, FloatArray

__all__ = ["FAR", "far_shear_field", "gap", "hertz_spectrum", "jinc", "log_ratio", "root", "shear_field"]

FAR = 40.0
"""Beyond this many half widths from its centre a contact's `hq` comes from its moments."""

_TINY = float(np.finfo(np.float64).tiny)
_NEAREST = 1e-140
"""Nearest [m] that a point comes to an end: its square, and a quotient of it, are still numbers."""


def root(z: ComplexArray, a: FloatArray, inset: FloatArray | None = None) -> ComplexArray:
    """sqrt(z^2 - b^2), b = a - inset, about z far away; its cut is the contact itself.

    Of two principal roots. In their product all parts of the imaginary one are >= 0; the real one is a
    difference that loses the little that matters deep beneath the contact, but re * im = x y.
    """
    left, right = z - a, z + a
    if inset is not None:
        left, right = left + inset, right - inset
    s: ComplexArray = np.asarray(np.sqrt(left) * np.sqrt(right))
    np.divide(z.imag * z.real, s.imag, out=s.real, where=s.imag > 0)
    return s


def gap(x: FloatArray, from_start: FloatArray, from_end: FloatArray, from_centre: FloatArray) -> ComplexArray:
    """(z - start) (z - end), z^2 - a^2 for a contact: both parts without cancellation deep beneath it."""
    value = np.empty(np.broadcast_shapes(x.shape, from_start.shape), dtype=np.complex128)
    value.real = from_start * from_end - x**2
    value.imag = 2 * x * from_centre
    return value


def log_ratio(
    x: FloatArray, from_start: FloatArray, from_end: FloatArray, from_centre: FloatArray, h: FloatArray
) -> ComplexArray:
    """log((z - end) / (z - start)) for a stretch of half length `h`.

    Its imaginary part is the angle that the stretch subtends. The point is given by its depth and its distances along y
    from the start, the end and the centre, which only the caller can find without loss. On the surface at an end the
    angle is pi/2 and the logarithm finite, so that the infinities of neighbouring stretches cancel.
    """
    to_start = np.maximum(from_start**2 + x**2, _NEAREST**2)
    to_end = np.maximum(from_end**2 + x**2, _NEAREST**2)
    ratio = to_end / to_start
    # log1p where the two distances are nearly equal, log where they are not
    near_one = np.where((ratio > 0.5) & (ratio < 2.0), -4 * h * from_centre / to_start, 0.0)
    value = np.empty(np.broadcast_shapes(ratio.shape, near_one.shape), dtype=np.complex128)
    value.real = 0.5 * np.where(near_one == 0, np.log(ratio), np.log1p(near_one))
    value.imag = np.arctan2(2 * h * x + _TINY, x**2 + from_start * from_end)
    return value


def jinc(x: FloatArray) -> FloatArray:
    """2 J1(x) / x, the spectrum of a semi-ellipse; 1 at 0."""
    from scipy.special import j1

    return np.where(x > 0, 2 * j1(x) / np.where(x > 0, x, 1.0), 1.0)


def hertz_spectrum(x: FloatArray) -> FloatArray:
    """3 (sin x - x cos x) / x^3, the spectrum of a half ellipsoid; 1 at 0."""
    small, square = np.abs(x) < 0.1, x * x
    far = np.where(small, 1.0, x)
    series = 1 - square / 10 * (1 - square / 28 * (1 - square / 54 * (1 - square / 88)))
    return np.where(small, series, 3 * (np.sin(far) - far * np.cos(far)) / far**3)


def shear_field(z: ComplexArray, f: ComplexArray, df: ComplexArray) -> FloatArray:
    """Im(F + i x F'); on the surface Im F, for there F' grows more slowly than 1/x (save at singular points)."""
    x = z.imag
    h = np.asarray(f.imag + x * df.real, dtype=np.float64)
    return h if np.count_nonzero(x) == x.size else np.where(x == 0, f.imag, h)


def far_shear_field(z: ComplexArray, moments: Sequence[FloatArray]) -> FloatArray:
    """Im(F + i x F') far away, from the moments m_k = integral of t^k p(t) dt about the origin of z.

    F = -sum of m_k / z^(k+1), so F + i x F' = -sum of m_k (y - i k x) / z^(k+2): the part that cancels, i x, is gone.
    """
    inverse = 1 / z
    total = np.zeros_like(z)
    for k in reversed(range(len(moments))):
        total = total * inverse + moments[k] * (z.real - 1j * k * z.imag)
    return np.asarray(-(total * inverse**2).imag)
