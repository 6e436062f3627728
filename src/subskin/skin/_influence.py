"""Displacement of the surface at a distance from a hat of traction: the half plane's, and what a skin adds to it."""

from __future__ import annotations

import numpy as np

from .._check import FloatArray

__all__ = ["arranged", "hat_mean", "hat_spectrum", "wave_sum"]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_BLOCK = 1 << 22


def hat_spectrum(k: FloatArray, step: float) -> FloatArray:
    """Fourier transform [m] of a hat that falls from 1 to 0 within one step on either side."""
    return np.asarray(step * np.sinc(0.5 * k * step / np.pi) ** 2)


def hat_mean(function: object, step: float, count: int) -> FloatArray:
    """Integral of the hat at 0 times a function of the distance, at distances j * step: smooth save perhaps at 0."""
    t = 0.5 * (1 + _NODES)
    total = np.zeros(count)
    for side in (-1, 1):
        for position, weight in zip(side * t, 0.5 * _WEIGHTS * (1 - t), strict=True):
            total += step * weight * function((np.arange(count) - position) * step)  # type: ignore[operator]
    return total


def wave_sum(
    k: FloatArray, even: FloatArray, odd: FloatArray, step: float, count: int
) -> tuple[FloatArray, FloatArray]:
    """Sums over k of even * cos(k y), shape (..., k) to (..., count), and of odd * sin(k y), at y = j * step."""
    cosines, sines = np.empty((*even.shape[:-1], count)), np.empty((*odd.shape[:-1], count))
    size = max(1, _BLOCK // k.size)
    for first in range(0, count, size):
        phase = k[:, None] * (step * np.arange(first, min(first + size, count)))
        cosines[..., first : first + size] = even @ np.cos(phase)
        sines[..., first : first + size] = odd @ np.sin(phase)
    return cosines, sines


def arranged(xx: FloatArray, yy: FloatArray, odd: FloatArray) -> FloatArray:
    """Influence (2, 2, count): u_x and u_y (first index) of a pressure and of a shear; `odd` is u_y of a pressure."""
    return np.array([[xx, -odd], [odd, yy]])
