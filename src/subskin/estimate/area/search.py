"""Where loads on an area are looked for: ends of a search, its steps, and how far a response has to reach for it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ... import _check
from ..._check import FloatArray
from ...array import SensorArray
from ...errors import InvalidValueError

__all__ = ["reach_of", "search_of", "step_of"]

_BEYOND = 8.0
"""Depths beside the default search up to which a load is thought of."""
_STEP, _REACH = 0.4, 1.5
_MOST_NODES = 2_000_000


def reach_of(array: SensorArray, box: FloatArray, beyond: float = 0.0) -> float:
    """How far a response has to reach for loads in the box (2, 2), and `beyond` it [m]."""
    return float(np.sqrt(2.0) * (max(float(np.abs(array.points - corner).max()) for corner in box.T) + beyond))


def step_of(array: SensorArray, search: Any, scan_step: float | None) -> float:
    """The steps of a search [m], which are not to be too many."""
    usual = _STEP * float(np.asarray(array.depth).min())
    step = _check.scalar("scan_step", usual if scan_step is None else scan_step, unit="m", above=0.0)
    sides = np.ptp(np.asarray(search), axis=1)
    if not sides[0] / step <= _MOST_NODES / max(sides[1] / step, 1.0):
        seen = f"a search of {sides[0]:.4g} by {sides[1]:.4g} m in steps of {step:.4g} m"
        rule = f"at most {_MOST_NODES} positions are looked at"
        raise InvalidValueError(seen, rule, "a narrower search; all lengths are in m: 6e-3")
    return step


def search_of(array: SensorArray, search: Any) -> tuple[FloatArray, float]:
    """The ends of a search ((y low, y high), (z low, z high)) and how far loads are thought of beyond it [m].

    The default goes 1.5 depths beyond the outermost sensors.
    """
    deepest, points = float(np.asarray(array.depth).max()), array.points
    if search is None:
        low, high = points.min(axis=0) - _REACH * deepest, points.max(axis=0) + _REACH * deepest
        return np.stack([low, high], axis=-1), _BEYOND * deepest
    box = _check.real("search", search, unit="m")
    if box.shape != (2, 2) or not (box[:, 0] < box[:, 1]).all():
        rule = "the ends of y and those of z are needed, ascending"
        raise InvalidValueError(f"search = {_check.shown(search)}", rule, "search=((-5e-3, 5e-3), (-5e-3, 5e-3))")
    return box, 0.0
