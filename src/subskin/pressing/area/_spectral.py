"""Loops over spectra, in place. A spectrum is given as real numbers: real and imaginary parts in turn along a row."""

from __future__ import annotations

from ..._compiled import compiled

__all__ = ["scaled", "turned"]


@compiled(entry=True, borrows=True)
def scaled(waves, by):
    """A spectrum times a real one."""
    for i in range(by.shape[0]):
        for j in range(by.shape[1]):
            waves[i, 2 * j] *= by[i, j]
            waves[i, 2 * j + 1] *= by[i, j]


@compiled(entry=True, borrows=True)
def turned(waves, yy, zz, yz):
    """Spectra of two components times a symmetric matrix of real ones."""
    for i in range(yy.shape[0]):
        for j in range(yy.shape[1]):
            for part in range(2 * j, 2 * j + 2):
                y, z = waves[0, i, part], waves[1, i, part]
                waves[0, i, part] = yy[i, j] * y + yz[i, j] * z
                waves[1, i, part] = yz[i, j] * y + zz[i, j] * z
