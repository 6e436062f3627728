"""The best depth and pitch for one skin, kind and count: from the grid, then in steps that can be put on a drawing."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from ..._check import FloatArray
from ...finger import Finger
from ..placement import study_row
from ..two_point import TwoPointLimen, two_point_limen
from .goals import Goals, Row
from .grid import DesignGrid, loaded

__all__ = ["Aim", "Tried", "apart", "limen"]

_DEPTHS = 2.0
"""Two points are tried up to so many depths apart."""
_CELLS, _PITCHES = 16, 3
"""How many designs of the grid, and at each depth of the refinement, are asked for their two points at most."""


class Tried(NamedTuple):
    """A row, what it does, and by how much the worst of that misses what is wanted: with two points, and without."""

    worst: float
    excess: float
    row: Row
    values: dict[str, float]


@dataclass(frozen=True, eq=False)
class Aim:
    """What a row of one skin, kind and count should do best.

    Attributes
    ----------
    grid : DesignGrid
    skin, sensor, n : int
        Which skin, kind and count of the grid.
    made : dict of str to float
        What tolerances add to the values of these names, as root sum of squares.
    """

    grid: DesignGrid
    skin: int
    sensor: int
    n: int
    made: dict[str, float] = field(default_factory=dict)

    def best(self) -> Tried:
        """The best row.

        The depth is found by halving steps, for a receptive field is tabulated for each; pitches then cost little. Two
        points are asked for only where nothing else makes the row worse than the best so far.
        """
        depths, pitches, at = self._choices(*self._start())
        tried: dict[int, Tried] = {}
        step = max(depths.size // 4, 1)
        while step >= 1:
            for i in (at, at - step, at + step):
                if 0 <= i < depths.size and i not in tried:
                    tried[i] = self._at_depth(
                        float(depths[i]), pitches, min(tried.values(), key=lambda t: t[:2], default=None)
                    )
            at = min(tried, key=lambda i: tried[i][:2])
            step //= 2
        return tried[at]

    def _row(self, depth: float, pitch: float) -> Row:
        return Row(self.skin, self.sensor, int(self.grid.counts[self.n]), depth, pitch)

    def _excess(self, values: dict[str, float]) -> float:
        ratios = [np.hypot(values[c.name], self.made.get(c.name, 0.0)) / c.wanted for c in self.grid.criteria]
        return float(max(ratio if np.isfinite(ratio) else np.inf for ratio in ratios))

    def _apart(self, row: Row, positions: int) -> float:
        """Distance at which two points are told, over what is wanted; 0 where nothing is."""
        goals = self.grid.goals
        if goals.accuracy.feature is None:
            return 0.0
        return apart(limen(goals.finger(row), goals, "point", positions)) / goals.accuracy.feature

    def _start(self) -> tuple[int, int]:
        """The best depth and pitch of the grid."""
        grid = self.grid
        planes = {name: value[self.skin, self.sensor, :, :, self.n] for name, value in grid.values.items()}
        excess = np.array(
            [
                [self._excess({name: float(p[d, s]) for name, p in planes.items()}) for s in range(grid.pitches.size)]
                for d in range(grid.depths.shape[1])
            ]
        )
        cells = [(d, s) for d, s in np.ndindex(excess.shape) if np.isfinite(excess[d, s])]
        cells.sort(key=lambda cell: float(excess[cell]))
        if grid.goals.accuracy.feature is None:
            return cells[0]
        # those that would do come in any order but their own: two points may be told best where all else is tight
        good = sum(excess[cell] <= 1 for cell in cells)
        rng = np.random.default_rng(grid.goals.effort.seed)
        cells = [cells[i] for i in rng.permutation(good)] + cells[good:]
        best, chosen = (np.inf, np.inf), cells[0]
        for d, s in cells[:_CELLS]:
            if excess[d, s] < best[0]:
                row = self._row(float(grid.depths[self.skin, d]), float(grid.pitches[s]))
                value = max(float(excess[d, s]), self._apart(row, positions=9)), float(excess[d, s])
                if value < best:
                    best, chosen = value, (d, s)
        return chosen

    def _choices(self, d: int, s: int) -> tuple[FloatArray, FloatArray, int]:
        """Round depths and pitches about those of the grid that have room, and which depth is nearest."""
        grid, room = self.grid, self.grid.goals.room
        own = grid.depths[self.skin]
        longest = room.longest_row / max(int(grid.counts[self.n]) - 1, 1)
        pitches = _between(_round_values(grid.pitches, s), room.least_pitch, longest, grid.pitches[[s]])
        depths = _between(_round_values(own, d), room.depth[0], float(own[-1]), own[[d]])
        return depths, pitches, int(np.argmin(np.abs(depths - own[d])))

    def _at_depth(self, depth: float, pitches: FloatArray, so_far: Tried | None) -> Tried:
        goals = self.grid.goals
        kind, effort = goals.sensors[self.sensor], goals.effort
        found = study_row(
            goals.skins[self.skin].skin, kind.transducer, depth, pitches, [int(self.grid.counts[self.n])],
            goals.touches, noise=kind.error, width=kind.width, seed=effort.seed, samples=effort.touches,
        )  # fmt: skip
        under_load = loaded(goals, self.skin, self.sensor, depth)
        rows = []
        for j, pitch in enumerate(pitches):
            values = {name: float(value[j, 0]) for name, value in found.items()} | under_load
            values["unsure"] = values["ambiguous"] + values["unfelt"]
            rows.append((self._excess(values), self._row(depth, float(pitch)), values))
        rows.sort(key=lambda row: row[0])
        best = Tried(np.inf, *rows[0])
        for excess, row, values in rows[:_PITCHES]:
            if excess < min(best.worst, np.inf if so_far is None else so_far.worst):
                one = Tried(max(excess, self._apart(row, positions=17)), excess, row, values)
                best = min(best, one, key=lambda t: t[:2])
        return best


def limen(finger: Finger, goals: Goals, against: Literal["point", "wide"], positions: int = 17) -> TwoPointLimen:
    """Distances at which two touches of the weakest force are told from one, in 90 % of frames at 1 % of false alarms.

    Angles are unknown; the touches have those of the middle and the ends of the cone.
    """
    angle: Literal["free", "normal"] = "free" if goals.touches.friction > 0 else "normal"
    largest = _DEPTHS * float(np.asarray(finger.array.depth).min())
    if goals.accuracy.feature is not None:  # a distance counts where all larger ones are told too, a quarter beyond
        largest = max(largest, 1.25 * goals.accuracy.feature)
    return two_point_limen(
        finger, goals.touches, against=against, angle=angle, positions=positions, angles=3, largest=largest
    )


def apart(found: TwoPointLimen) -> float:
    """Distance at which 95 % of the pairs of touches are told from one [m]."""
    return float(np.quantile(found.separation, 0.95, method="higher"))


def _round_values(grid: FloatArray, i: int) -> FloatArray:
    """Round values between the neighbours of the i-th of the grid, 0.5 to 5 % apart."""
    step = 10.0 ** np.floor(np.log10(float(grid[i]))) / 20
    first, last = float(grid[max(i - 1, 0)]), float(grid[min(i + 1, grid.size - 1)])
    return np.asarray(step * np.arange(np.ceil(first / step - 1e-9), np.floor(last / step + 1e-9) + 1))


def _between(values: FloatArray, low: float, high: float, otherwise: FloatArray) -> FloatArray:
    within = values[(values >= low * (1 - 1e-9)) & (values <= high * (1 + 1e-9))]
    return within if within.size else otherwise
