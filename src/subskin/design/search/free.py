"""Free positions on an area: the sensors of the best array moved until none of what is wanted can be bettered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..._check import FloatArray
from ..placement import Arrangement
from .goals import Row
from .grid import DesignGrid, studied

__all__ = ["freed"]

_ROUNDS, _SHRINK, _STEP, _SAMPLES = 4, 0.5, 0.3, 100
"""How often all sensors are moved, by how much less each time, by how many pitches at first; touches of a trial."""


def freed(grid: DesignGrid, row: Row, values: Mapping[str, float]) -> tuple[Row, dict[str, float]]:
    """The array with its sensors where the worst ratio to what is wanted is least, and what it does.

    Each sensor in turn is tried a step to each of four sides, with its mirror images in the middle lines where it has
    such, and stays where that is better; then steps halve. It is local: what is found is never worse than `row`, and
    another array far from it may be better.
    """
    goals = grid.goals
    if not goals.on_area:
        return row, dict(values)
    unit, worst = row.layout.unit, _excess(grid, values)
    best, known = unit, dict(values)
    half, least = 0.5 * goals.extent / row.pitch, goals.room.least_pitch / row.pitch
    step = _STEP
    for _ in range(_ROUNDS):
        for i in range(len(unit)):
            for side in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
                tried = _moved(best, i, step * np.array(side))
                apart = np.linalg.norm(tried[:, None] - tried, axis=-1) + np.diag(np.full(len(tried), np.inf))
                if (np.abs(tried) > half * (1 + 1e-9)).any() or apart.min() < least * (1 - 1e-9):
                    continue
                found = _does(grid, row, tried, _SAMPLES)
                if _excess(grid, found) < worst - 1e-6:
                    best, worst = tried, _excess(grid, found)
        step *= _SHRINK
    if best is unit:
        return row, known
    known = _does(grid, row, np.round(best * row.pitch, 5) / row.pitch, goals.counted)
    return replace(row, layout=_layout(row, np.round(best * row.pitch, 5) / row.pitch)), known


def _moved(unit: FloatArray, i: int, by: FloatArray) -> FloatArray:
    """A sensor moved, and those that mirror it in the middle lines of the array, each in its mirror."""
    out = unit.copy()
    for signs in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
        other = np.flatnonzero(np.abs(unit - np.array(signs) * unit[i]).max(axis=1) < 1e-6)
        for j in other:
            free = np.where((np.abs(unit[i]) < 1e-9) & (np.array(signs) < 0), 0.0, 1.0)
            out[j] = unit[j] + np.array(signs) * by * free
    return out


def _layout(row: Row, unit: FloatArray) -> Arrangement:
    return Arrangement("free", (row.count,), tuple((float(y), float(z)) for y, z in unit))


def _does(grid: DesignGrid, row: Row, unit: FloatArray, samples: int) -> dict[str, float]:
    found = studied(
        grid.goals, row.skin, row.sensor, row.depth, np.array([row.pitch]), [_layout(row, unit)], samples
    )  # fmt: skip
    return {name: float(value[0, 0]) for name, value in found.items()}


def _excess(grid: DesignGrid, values: Mapping[str, float]) -> float:
    """The largest ratio that positions can change: not the strain beneath a touch, nor the range."""
    ratios = [values[c.name] / c.wanted for c in grid.criteria if c.name not in ("strain", "range")]
    return float(np.nan_to_num(np.max(ratios), nan=np.inf, posinf=np.inf))
