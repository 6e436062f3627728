"""Cauchy transforms from the traction alone, for contacts that have no closed form in a half plane."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .._check import ComplexArray, FloatArray

__all__ = ["cauchy"]

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
