"""Polynomials of degree 4 in equal cells: of which a `Response` is made."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ._check import FloatArray
from .errors import GeometryError

__all__ = ["DEGREE", "NODES", "TO_POWERS", "cells_of", "mean", "polynomial", "within"]

DEGREE = 4
"""Degree of the polynomial in a cell."""
NODES = -0.5 * np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)
"""Chebyshev-Lobatto points of a cell [-1/2, 1/2]: with the ends among them, neighbours agree where they meet."""
TO_POWERS = np.linalg.inv(np.vander(NODES, increasing=True))
"""From the values there to the coefficients."""
_MOST = 1e6


def cells_of(length: float, step: float) -> int:
    """How many cells of about a `step` [m] there are in a `length` [m]."""
    if not length < _MOST * step:
        seen, rule = f"{length:.3g} m in steps of {step:.3g} m", f"at most {_MOST:.0e} cells are tabulated"
        raise GeometryError(seen, rule, "deeper sensors, a shorter row, or a narrower search")
    return max(int(np.ceil(length / step * (1 - 1e-12))), 1)


def within(steps: FloatArray, cells: int) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """The cell in which each position lies, in `steps` from the start, and how far from its centre, (..., 1, 1)."""
    cell = np.clip(np.floor(steps).astype(np.intp), 0, cells - 1)
    return cell, (steps - cell - 0.5)[..., None, None]


def mean(c: FloatArray) -> FloatArray:
    """Of the polynomials with the coefficients c (cells, 5, n, 2), over their cells."""
    return np.asarray(c[:, 0] + c[:, 2] / 12 + c[:, 4] / 80)


def polynomial(c: FloatArray, t: FloatArray, derivative: int = 0) -> FloatArray:
    """Value, or a derivative, of the polynomials with the coefficients c (..., 5, n, 2)."""
    total = np.zeros(c.shape[:-3] + c.shape[-2:])
    for k in range(DEGREE, derivative - 1, -1):
        factor = float(np.prod(np.arange(k, k - derivative, -1)))
        total = total * t + factor * c[..., k, :, :]
    return total
