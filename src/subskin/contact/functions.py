"""The analytic functions that closed forms are made of, each free of cancellation, and integrals where there are none.

Points are z = y + i x [m] about the contact's centre, x >= 0 being the depth. Closed forms are pure functions of an
array namespace `xp`, NumPy's here: they write nothing in place and do not ask for values. A complex number is the pair
of its parts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from .._check import ComplexArray, FloatArray

__all__ = [
    "FAR",
    "Pair",
    "cauchy",
    "far_shear_field",
    "gap",
    "hertz_spectrum",
    "inverse",
    "jinc",
    "joined",
    "line",
    "line_shear",
    "log_ratio",
    "root",
    "shear_field",
    "times",
]

Pair: TypeAlias = tuple[Any, Any]
"""Real and imaginary part."""

FAR = 40.0
"""Beyond this many half widths from its centre a contact's `hq` comes from its moments."""

_TINY = float(np.finfo(np.float64).tiny)
_NEAREST = 1e-140
"""Nearest [m] that a point comes to an end: its square, and a quotient of it, are still numbers."""


def times(u: Pair, v: Pair) -> Pair:
    """The product of two complex numbers."""
    return u[0] * v[0] - u[1] * v[1], u[0] * v[1] + u[1] * v[0]


def inverse(u: Pair, share: Any = 1.0) -> Pair:
    """A share of one over a complex number."""
    over = share / (u[0] * u[0] + u[1] * u[1])
    return u[0] * over, -(u[1] * over)


def joined(u: Pair) -> ComplexArray:
    """The array of complex numbers of such parts."""
    re, im = u
    out = np.empty(re.shape if re.shape == im.shape else (re + im).shape, dtype=np.complex128)
    out.real, out.imag = re, im
    return out


def line(xp: Any, x: Any, y: Any) -> tuple[Pair, Pair]:
    """F = -1/z and F' = 1/z^2 of a line load of unit force (memo eqs. 1 to 4; `ProportionalContact`)."""
    r: Pair = inverse((y, x))
    return (-r[0], -r[1]), times(r, r)


def line_shear(x: Any, re: Any) -> Any:
    """Im(F + i x F') of it, 2 x y^2 / r^4, from the real part of F."""
    return 2 * x * re * re


def root(xp: Any, x: Any, y: Any, a: Any, inset: Any = None) -> Pair:
    """The root s of z^2 - b^2, b = a - inset, that is about z far away; its cut is the contact itself.

    s^2 = A + 2 i B; of the two parts the larger one is a sum, and the other B over it, so that neither is lost.
    """
    left, right = (y - a, y + a) if inset is None else (y - a + inset, y + a - inset)
    across, along = xp.abs(x * y), left * right - x * x
    large = xp.sqrt(0.5 * (xp.sqrt(along * along + 4 * (across * across)) + xp.abs(along)))
    small, outside = across / xp.maximum(large, _NEAREST), along > 0
    return xp.copysign(xp.where(outside, large, small), y), xp.where(outside, small, large)


def gap(x: Any, from_start: Any, from_end: Any, from_centre: Any) -> Pair:
    """(z - start) (z - end), z^2 - a^2 for a contact: both parts without cancellation deep beneath it."""
    return from_start * from_end - x * x, 2 * x * from_centre


def log_ratio(xp: Any, x: Any, from_start: Any, from_end: Any, from_centre: Any, h: Any) -> Pair:
    """log((z - end) / (z - start)) for a stretch of half length `h`.

    Its imaginary part is the angle that the stretch subtends. The point is given by its depth and its distances along y
    from the start, the end and the centre, which only the caller can find without loss. On the surface at an end the
    angle is pi/2 and the logarithm finite, so that the infinities of neighbouring stretches cancel.
    """
    to_start = xp.maximum(from_start * from_start + x * x, _NEAREST**2)
    to_end = xp.maximum(from_end * from_end + x * x, _NEAREST**2)
    ratio = to_end / to_start
    # log1p where the two distances are nearly equal, log where they are not
    near_one = xp.where((ratio > 0.5) & (ratio < 2.0), -4 * h * from_centre / to_start, 0.0)
    length = 0.5 * xp.where(near_one == 0, xp.log(ratio), xp.log1p(near_one))
    return length, xp.atan2(2 * h * x + _TINY, x * x + from_start * from_end)


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


def shear_field(xp: Any, x: Any, f: Pair, df: Pair, surface: bool = True) -> Any:
    """Im(F + i x F'); on the surface Im F, for there F' grows more slowly than 1/x (save at singular points)."""
    h = f[1] + x * df[0]
    return xp.where(x == 0, f[1], h) if surface else h


def far_shear_field(x: Any, y: Any, moments: Sequence[Any]) -> Any:
    """Im(F + i x F') far away, from the moments m_k = integral of t^k p(t) dt about the origin of z.

    F = -sum of m_k / z^(k+1), so F + i x F' = -sum of m_k (y - i k x) / z^(k+2): the part that cancels, i x, is gone.
    """
    back: Pair = inverse((y, x))
    total: Pair = (0.0 * y, 0.0 * x)
    for k in reversed(range(len(moments))):
        total = times(total, back)
        total = total[0] + moments[k] * y, total[1] - k * moments[k] * x
    return -times(times(back, back), total)[1]


# A stretch is mapped to the whole line, t = low + length / (1 + exp(-v)), and summed by the trapezoidal rule. Roots and
# logarithms at its ends then fade exponentially, and a point z is a pole whose height is pi less the angle under which
# it sees the stretch: pi/2 or more outside the circle over it (Thales). So the error is exp(-2 pi (pi/2) / step),
# 1e-16; a point within the circle splits the stretch above it. The last nodes are 1e-28 of the length from its ends: a
# point at a depth of 1e-13 lengths still sees the traction above it as a plane.
_STEP = 0.27
_V = _STEP * np.arange(-240, 241)
_SHARE, _REST = 1 / (1 + np.exp(-_V)), 1 / (1 + np.exp(_V))
_WEIGHT = _STEP * _SHARE * _REST
_BLOCK = 1 << 16


def cauchy(
    traction: Callable[[FloatArray], FloatArray], breaks: FloatArray, z: ComplexArray
) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """F(z) = integral of p(t) / (t - z) dt, its derivative, and Im(F + i x F') at z = y + i x, x >= 0.

    To about 1e-12 of the largest traction; 1e-7 where that grows like a root at an end, for no number next to the end
    tells how near it is.

    Parameters
    ----------
    traction : callable
        p(t) [Pa] at positions t [m], broadcast against the batch.
    breaks : ndarray, shape (..., k)
        Positions [m], ascending, between which p is smooth; 0 beyond the first and the last.
    z : ndarray
        Points [m], broadcast against the batch.
    """
    x, y = z.imag, z.real
    shape = np.broadcast_shapes(z.shape, breaks.shape[:-1])
    f, df, h = np.zeros(shape, dtype=np.complex128), np.zeros(shape, dtype=np.complex128), np.zeros(shape)
    size = max(1, _BLOCK // max(1, int(np.prod(shape))))
    nodes = tuple(a.reshape(-1, *(1,) * len(shape)) for a in (_SHARE, _REST, _WEIGHT))
    surface = x == 0
    for low, high in zip(*(np.moveaxis(breaks, -1, 0)[part] for part in (np.s_[:-1], np.s_[1:])), strict=True):
        own = np.zeros(())
        if surface.any():  # the principal value, and half a turn about the point
            on = surface & (low <= y) & (y <= high)
            value = traction(np.where(on, y, 0.5 * (low + high)))
            own = np.where(on & np.isfinite(value), value, 0.0)
            right, left = high > y, low < y
            log = np.log(np.where(right, high - y, 1.0)) - np.log(np.where(left, y - low, 1.0))
            f += own * (log + 0.5j * np.pi * (right.astype(float) + left))
        within = (y - low) * (y - high) + x * x < 0
        middle = np.clip(y, low, high)
        for start, end in ((low, middle), (middle, high)) if within.any() else ((low, high),):
            length = end - start
            inner, outer = np.nextafter(start, end), np.nextafter(end, start)
            for first in range(0, _V.size, size):
                share, rest, weight = (a[first : first + size] for a in nodes)
                near = share < 0.5
                at = np.clip(np.where(near, start + length * share, end - length * rest), inner, outer)
                away = np.where(near, (start - y) + length * share, (end - y) - length * rest)
                value = traction(at)
                value = np.where(np.isfinite(value) & (length > 0), weight * length * (value - own), 0.0)
                r = 1 / (away - 1j * x)
                f += (value * r).sum(axis=0)
                df += (value * r * r).sum(axis=0)
                h += (value * 2 * x * (away * (r.real**2 + r.imag**2)) ** 2).sum(axis=0)
    return f, df, np.where(surface, f.imag, h)
