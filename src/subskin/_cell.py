"""Of what a `Response` is made: polynomials of degree 4 in equal cells, from one end of a search to the other."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from .errors import GeometryError, InvalidValueError
from .finger import Finger

__all__ = [
    "DEGREE", "NODES", "TO_POWERS", "cells_of", "ends_of", "from_crest_to_crest", "mean", "polynomial", "within",
]  # fmt: skip

DEGREE = 4
"""Degree of the polynomial in a cell."""
NODES = -0.5 * np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)
"""Chebyshev-Lobatto points of a cell [-1/2, 1/2]: with the ends among them, neighbours agree where they meet."""
TO_POWERS = np.linalg.inv(np.vander(NODES, increasing=True))
"""From the values there to the coefficients."""
_MOST = 1e6
_FARTHEST = 100.0
"""Depths by which a search may be wider than the row."""


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


def ends_of(finger: Finger, search: tuple[float, float] | None) -> tuple[float, float]:
    """The ends of a search, checked."""
    y, deepest, period = np.asarray(finger.array.y), float(np.max(finger.array.depth)), finger.skin.period
    if search is None:
        whole = (y.min() - 1.5 * deepest, y.max() + 1.5 * deepest)
        middle = 0.5 * (whole[0] + whole[1])
        half = min(0.5 * (whole[1] - whole[0]), 0.5 * period)
        return float(middle - half), float(middle + half)
    low, high = _check.pair("search", search, "search=(-5e-3, 5e-3)", "m")
    if not low < high:
        raise InvalidValueError(f"search = {search!r}", "two ascending positions are needed", "search=(-5e-3, 5e-3)")
    if high - low > period * (1 + 1e-12):
        rule = f"the finger is {period:.6g} m about, and positions repeat after that"
        raise InvalidValueError(f"search = {search!r}", rule, "a narrower search")
    if high - low > np.ptp(y) + _FARTHEST * deepest:
        rule = f"it is wider than the row by more than {_FARTHEST:g} depths, beyond which sensors read nothing"
        raise InvalidValueError(f"search = {search!r} m", rule, "search in metres, such as (-5e-3, 5e-3)")
    return low, high


def from_crest_to_crest(
    low: float, high: float, step: float, crest: float, pitch: float, period: float
) -> tuple[float, float, float]:
    """Ends on crests, and a step of which a pitch is a whole number: what ridges bear is smooth from crest to crest."""
    first, last = np.floor((low - crest) / pitch + 1e-9), np.ceil((high - crest) / pitch - 1e-9)
    last = min(last, first + np.round(period / pitch)) if np.isfinite(period) else last
    return float(crest + pitch * first), float(crest + pitch * last), pitch / np.ceil(pitch / step)
