"""The best depth and pitch for one skin, kind and layout, in steps that can be put on a drawing; and free positions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np

from ..._check import FloatArray
from ..._frozen import Frozen
from ...finger import Finger
from ..placement import Arrangement
from ..two_point import AreaLimen, TwoPointLimen, two_point_limen
from .goals import Goals, Row
from .grid import DesignGrid, loaded, studied

__all__ = ["freed"]

_DEPTHS = 2.0
"""Two points are tried up to so many depths apart."""
_FEW = 6
"""Depths, and pitches at each, between which the best array on an area is refined."""
_CELLS, _PITCHES = 16, 3
"""How many designs of the grid, and at each depth of the refinement, are asked for their two points at most."""


class Tried(NamedTuple):
    """A row, what it does, and by how much the worst of that misses what is wanted: with two points, and without."""

    worst: float
    excess: float
    row: Row
    values: dict[str, float]


@dataclass(frozen=True, eq=False)
class Aim(Frozen):
    """The best row of one skin, kind and count, by their indices; `made` is added to errors as root sum of squares."""

    grid: DesignGrid
    skin: int
    sensor: int
    n: int
    made: Mapping[str, float] = field(default_factory=dict)

    def best(self) -> Tried:
        """The best row.

        The depth is found by halving steps, for a receptive field is tabulated for each; pitches then cost little. Two
        points are asked for only where nothing else makes the row worse than the best so far.
        """
        grid, room = self.grid, self.grid.goals.room
        own = grid.depths[self.skin]
        d, s = self._start()
        longest = float((self.grid.goals.extent / np.maximum(self._layout.size, 1e-9)).min())
        pitches = _between(_round_values(grid.pitches, s), room.least_pitch, longest, grid.pitches[[s]])
        depths = _between(_round_values(own, d), room.depth[0], float(own[-1]), own[[d]])
        if self.grid.goals.on_area:  # each costs twenty times one of a row
            pitches, depths = (_thinned(v, _FEW) for v in (pitches, depths))
        at, step = int(np.argmin(np.abs(depths - own[d]))), max(depths.size // 4, 1)
        tried: dict[int, Tried] = {}
        while step >= 1:
            for i in (at, at - step, at + step):
                if 0 <= i < depths.size and i not in tried:
                    so_far = min((t.worst for t in tried.values()), default=np.inf)
                    tried[i] = self._at_depth(float(depths[i]), pitches, so_far)
            at = min(tried, key=lambda i: tried[i][:2])
            step //= 2
        return tried[at]

    @property
    def _layout(self) -> Arrangement:
        return self.grid.goals.layouts[self.n]

    def _row(self, depth: float, pitch: float) -> Row:
        return Row(self.skin, self.sensor, self._layout, depth, pitch)

    def _excess(self, values: Mapping[str, float | FloatArray]) -> FloatArray:
        """Largest ratio of values to what is wanted of them; infinite where one is none."""
        ratios = [np.hypot(values[c.name], self.made.get(c.name, 0.0)) / c.wanted for c in self.grid.criteria]
        return np.asarray(np.nan_to_num(np.max(ratios, axis=0), nan=np.inf, posinf=np.inf))

    def _apart(self, row: Row, positions: int) -> float:
        """Distance at which two points are told, over what is wanted; 0 where nothing is."""
        goals = self.grid.goals
        if goals.accuracy.feature is None or goals.on_area:  # there it is looked at of the best alone
            return 0.0
        return apart(limen(goals.finger(row), goals, "point", positions)) / goals.accuracy.feature

    def _start(self) -> tuple[int, int]:
        """The best depth and pitch of the grid."""
        grid = self.grid
        excess = self._excess({name: v[self.skin, self.sensor, :, :, self.n] for name, v in grid.values.items()})
        cells = [(int(d), int(s)) for d, s in np.argwhere(np.isfinite(excess))]
        cells.sort(key=lambda cell: float(excess[cell]))
        if grid.goals.accuracy.feature is None or grid.goals.on_area:
            return cells[0]
        # those that would do come in any order but their own: two points may be told best where all else is tight
        good = sum(excess[cell] <= 1 for cell in cells)
        rng = np.random.default_rng(grid.goals.effort.seed)
        cells = [cells[i] for i in rng.permutation(good)] + cells[good:]
        best, chosen = (np.inf, np.inf), cells[0]
        for cell in cells[:_CELLS]:
            own = float(excess[cell])
            if own < best[0]:
                depth, pitch = float(grid.depths[self.skin, cell[0]]), float(grid.pitches[cell[1]])
                value = max(own, self._apart(self._row(depth, pitch), 9)), own
                if value < best:
                    best, chosen = value, cell
        return chosen

    def _at_depth(self, depth: float, pitches: FloatArray, so_far: float) -> Tried:
        """The best pitch, if it is better than what was found `so_far`."""
        goals = self.grid.goals
        found = studied(goals, self.skin, self.sensor, depth, pitches, [self._layout])
        under_load = loaded(goals, self.skin, self.sensor, depth)
        rows = []
        for j, pitch in enumerate(pitches):
            values = {name: float(value[j, 0]) for name, value in found.items()} | under_load
            row = self._row(depth, float(pitch))
            rows.append((float(self._excess(values)), row, values))
        rows.sort(key=lambda row: row[0])
        best = Tried(np.inf, *rows[0])
        for excess, row, values in rows[:_PITCHES]:
            if excess < min(best.worst, so_far):
                one = Tried(max(excess, self._apart(row, 17)), excess, row, values)
                best = min(best, one, key=lambda t: t[:2])
        return best


def limen(finger: Finger, goals: Goals, against: Literal["point", "wide"], positions: int = 17) -> TwoPointLimen:
    """Distances at which two touches of the weakest force read as two, in 90 % of frames at 1 % of false alarms.

    Angles are unknown; the touches have those of the middle and the ends of the cone.
    """
    angle: Literal["free", "normal"] = "free" if goals.touches.friction > 0 else "normal"
    largest = _DEPTHS * float(np.asarray(finger.array.depth).min())
    if goals.accuracy.feature is not None:  # a distance counts where all larger ones are told too, a quarter beyond
        largest = max(largest, 1.25 * goals.accuracy.feature)
    return two_point_limen(
        finger, goals.touches, against=against, angle=angle, positions=positions, angles=3, largest=largest
    )


def apart(found: TwoPointLimen | AreaLimen) -> float:
    """Distance at which 95 % of the pairs of touches read as two [m]."""
    return float(np.quantile(found.separation, 0.95, method="higher"))


def _round_values(grid: FloatArray, i: int) -> FloatArray:
    """Round values between the neighbours of the i-th of the grid, 0.5 to 5 % apart."""
    step = 10.0 ** np.floor(np.log10(float(grid[i]))) / 20
    first, last = float(grid[max(i - 1, 0)]), float(grid[min(i + 1, grid.size - 1)])
    return np.asarray(step * np.arange(np.ceil(first / step - 1e-9), np.floor(last / step + 1e-9) + 1))


def _thinned(values: FloatArray, most: int) -> FloatArray:
    """So many of the values at most, evenly chosen."""
    return np.asarray(values[np.unique(np.linspace(0, values.size - 1, min(most, values.size)).round().astype(int))])


def _between(values: FloatArray, low: float, high: float, otherwise: FloatArray) -> FloatArray:
    within = values[(values >= low * (1 - 1e-9)) & (values <= high * (1 + 1e-9))]
    return within if within.size else otherwise


_ROUNDS, _SHRINK, _STEP, _SAMPLES = 4, 0.5, 0.3, 100
"""How often all sensors are moved, by how much less each time, by how many pitches at first; touches of a trial."""


def freed(grid: DesignGrid, row: Row, values: Mapping[str, float]) -> tuple[Row, dict[str, float]]:
    """The array with its sensors where the worst ratio to what is wanted is least, and what it does.

    Each sensor in turn is tried a step to each of four sides, in a row of two, with its mirror images in the middle
    lines where it has such, and stays where that is better; then steps halve. It is local: what is found is never worse
    than `row`, and another array far from it may be better.
    """
    goals = grid.goals
    sides = [(1.0, 0.0), (-1.0, 0.0), *([(0.0, 1.0), (0.0, -1.0)] if goals.on_area else [])]
    unit, worst = row.layout.unit, _excess(grid, values)
    best, known = unit, dict(values)
    half, least = 0.5 * goals.extent / row.pitch, goals.room.least_pitch / row.pitch
    step = _STEP
    for _ in range(_ROUNDS):
        for i in range(len(unit)):
            for side in sides:
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
