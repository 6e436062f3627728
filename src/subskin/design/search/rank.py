"""From the grid to the fingers to build: refined, looked at closely, ranked, each with its reasons."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from ..._check import FloatArray
from ...errors import ConvergenceError
from ...finger import Finger
from ..placement import PlacementQuality, placement_quality, study_row
from ..tolerance import ToleranceBudget, tolerance_budget, usual_tolerances
from ..two_point import TwoPointLimen, two_point_limen
from .goals import Goals, Row
from .grid import Criterion, DesignGrid, loaded
from .reasons import reasons_of

__all__ = ["Check", "DesignStudy", "DesignedFinger", "limen", "most_looked_at", "rank_fingers"]

_TRIED = 4
"""Designs looked at closely, for each that is kept."""


class Check(NamedTuple):
    """One thing that was wanted, and what the finger does."""

    criterion: Criterion
    value: float

    @property
    def ratio(self) -> float:
        """Value over what was wanted: at most 1 will do."""
        return self.value / self.criterion.wanted


@dataclass(frozen=True, eq=False)
class DesignedFinger:
    """A finger to build.

    Attributes
    ----------
    row : Row
        Which skin, kind, count, depth [m] and pitch [m].
    finger : Finger
    values : dict of float
        As those of `DesignGrid`, for this design.
    quality : PlacementQuality
        Accuracy and ambiguity over places and angles.
    budget : ToleranceBudget or None
        What the tolerances cost; None where none were stated.
    point, wide : float
        Least distance at which two touches are told from one, and from one wide contact [m].
    checks : tuple of Check
        What was wanted, and what it does.
    reasons : tuple of str
        Why it is as it is.
    """

    row: Row
    finger: Finger
    values: dict[str, float]
    quality: PlacementQuality
    budget: ToleranceBudget | None
    point: float
    wide: float
    checks: tuple[Check, ...]
    reasons: tuple[str, ...]

    @property
    def excess(self) -> float:
        """Largest ratio of a value to what was wanted."""
        return max(check.ratio for check in self.checks)

    @property
    def meets(self) -> bool:
        """Whether all that was wanted is there."""
        return self.excess <= 1


@dataclass(frozen=True, eq=False)
class DesignStudy:
    """The result of `design_fingers`.

    Attributes
    ----------
    grid : DesignGrid
        All designs that were tried.
    fingers : tuple of DesignedFinger
        Ranked: those that meet the goals first, the fewest sensors first among them; then by how far they fall short.
    """

    grid: DesignGrid
    fingers: tuple[DesignedFinger, ...]

    @property
    def goals(self) -> Goals:
        """What was wanted."""
        return self.grid.goals


def rank_fingers(
    grid: DesignGrid, *, workers: int | None = None, progress: Callable[[], object] | None = None
) -> DesignStudy:
    """Refine the best designs of the grid, look at each closely, and rank them.

    At most one design for each skin, kind and count is looked at.

    Parameters
    ----------
    grid : DesignGrid
        From `search_grid`.
    workers : int, optional
        How many designs at a time; as many as there are cores if left out. The result does not depend on it.
    progress : callable, optional
        Called after each design that was looked at; there are at most `most_looked_at(grid)`.

    Raises
    ------
    ConvergenceError
        No design of the grid has room, or is felt at all.
    """
    keep, most = grid.goals.effort.keep, most_looked_at(grid)
    indices = list(_best_first(grid))[:most]
    if not indices:
        raise ConvergenceError(
            "no design has room for its sensors and feels the touches",
            "the goals leave nothing to choose from",
        )
    cores = workers or len(os.sched_getaffinity(0))
    found: list[DesignedFinger] = []
    met = 0
    with ThreadPoolExecutor(max_workers=cores) as pool:
        for first in range(0, len(indices), cores):
            for finger in pool.map(lambda index: _looked_at(grid, index), indices[first : first + cores]):
                if met < keep:  # what is beyond was looked at only because there are several cores
                    found.append(finger)
                    met += finger.meets
                if progress is not None:
                    progress()
            if met >= keep:
                break
        found.sort(key=lambda f: (not f.meets, f.row.count if f.meets else 0, f.excess))
        kept = found[:keep]
        wide = pool.map(lambda f: limen(f.finger, grid.goals, "wide").worst, kept)
        fingers = tuple(replace(f, wide=value) for f, value in zip(kept, wide, strict=True))
    return DesignStudy(grid, fingers)


def most_looked_at(grid: DesignGrid) -> int:
    """How many designs `rank_fingers` looks at, at most."""
    return min(_TRIED * grid.goals.effort.keep, len(list(_best_first(grid))))


def _best_first(grid: DesignGrid) -> Iterator[tuple[int, ...]]:
    """Index of the best depth and pitch for each skin, kind and count: those that meet the goals, fewest sensors
    first, then the others, the nearest first.
    """
    excess = np.where(np.isfinite(grid.excess), grid.excess, np.inf)
    kinds, sensors, depths, pitches, counts = excess.shape
    best = []
    for k, m, n in np.ndindex(kinds, sensors, counts):
        d, s = np.unravel_index(int(np.argmin(excess[k, m, :, :, n])), (depths, pitches))
        value = float(excess[k, m, d, s, n])
        if np.isfinite(value):
            best.append(
                (value > 1, int(grid.counts[n]) if value <= 1 else 0, value, (k, m, int(d), int(s), n))
            )
    return (index for *_, index in sorted(best))


def _refined(grid: DesignGrid, index: tuple[int, ...]) -> tuple[Row, dict[str, float]]:
    """The best row near that of the grid, with a depth and a pitch that can be put on a drawing.

    The depth by halving steps, for a receptive field is tabulated for each; pitches then cost little.
    """
    goals = grid.goals
    k, m, d, s, n = index
    kind, room, effort, count = goals.sensors[m], goals.room, goals.effort, int(grid.counts[n])
    pitches = _round_values(grid.pitches, s)
    pitches = pitches[
        (pitches >= room.least_pitch * (1 - 1e-9)) & (pitches * (count - 1) <= room.longest_row * (1 + 1e-9))
    ]
    if not pitches.size:
        pitches = grid.pitches[[s]]
    depths = _round_values(grid.depths[k], d)
    depths = depths[(depths >= room.depths[0] * (1 - 1e-9)) & (depths <= grid.depths[k, -1] * (1 + 1e-9))]
    if not depths.size:
        depths = grid.depths[k, [d]]
    tried: dict[int, tuple[float, Row, dict[str, float]]] = {}

    def best_at(i: int) -> float:
        if i not in tried:
            depth = float(depths[i])
            found = study_row(
                goals.skins[k].skin, kind.transducer, depth, pitches, [count], goals.touches, noise=kind.error,
                width=kind.width, seed=effort.seed, samples=effort.touches,
            )  # fmt: skip
            under_load = loaded(goals, k, m, depth)
            rows = []
            for j, pitch in enumerate(pitches):
                values = {name: float(value[j, 0]) for name, value in found.items()} | under_load
                values["unsure"] = values["ambiguous"] + values["unfelt"]
                excess = max(_or_inf(values[c.name] / c.wanted) for c in grid.criteria)
                rows.append((excess, Row(k, m, count, depth, float(pitch)), values))
            tried[i] = min(rows, key=lambda row: row[0])
        return tried[i][0]

    at = int(np.argmin(np.abs(depths - grid.depths[k, d])))
    step = max(depths.size // 4, 1)
    while step >= 1:
        at = min((i for i in (at, at - step, at + step) if 0 <= i < depths.size), key=best_at)
        step //= 2
    return tried[at][1], tried[at][2]


def _or_inf(ratio: float) -> float:
    return ratio if np.isfinite(ratio) else np.inf


def _round_values(grid: FloatArray, i: int) -> FloatArray:
    """Round values between the neighbours of the i-th of the grid, 0.5 to 5 % apart."""
    step = 10.0 ** np.floor(np.log10(float(grid[i]))) / 20
    first, last = float(grid[max(i - 1, 0)]), float(grid[min(i + 1, grid.size - 1)])
    return np.asarray(step * np.arange(np.ceil(first / step - 1e-9), np.floor(last / step + 1e-9) + 1))


def _looked_at(grid: DesignGrid, index: tuple[int, ...]) -> DesignedFinger:
    row, values = _refined(grid, index)
    goals = grid.goals
    finger = goals.finger(row)
    quality = placement_quality(finger, goals.touches)
    has = usual_tolerances(finger)  # a half plane has no thickness that could be off
    amounts = {name: amount for name, amount in goals.tolerances.items() if name in has}
    budget = None
    if amounts:
        amounts["noise"] = goals.sensors[row.sensor].error
        budget = tolerance_budget(finger, goals.touches, amounts, seed=goals.effort.seed)
    point = limen(finger, goals, "point").worst
    checks = _checks(grid, values, budget, point)
    return DesignedFinger(
        row, finger, values, quality, budget, point, np.nan, checks, reasons_of(grid, row, checks)
    )


def limen(finger: Finger, goals: Goals, against: Literal["point", "wide"]) -> TwoPointLimen:
    """Distance at which two touches of the weakest force are told from one, its angle being unknown."""
    angle: Literal["free", "normal"] = "free" if goals.touches.friction > 0 else "normal"
    places = 9 if against == "wide" else 17  # a wide contact takes seconds
    return two_point_limen(finger, goals.touches, against=against, angle=angle, places=places)


def _checks(
    grid: DesignGrid, values: dict[str, float], budget: ToleranceBudget | None, point: float
) -> tuple[Check, ...]:
    """What was wanted against what the finger does, the tolerances of its making among it."""
    made = {}
    if budget is not None:
        rest = [cost for cost in budget.rows if cost.source != "noise"]
        for name in ("position", "angle", "force"):
            made[f"{name}_95"] = float(np.sqrt(sum(getattr(cost, f"{name}_rms") ** 2 for cost in rest)))
    checks = [Check(c, float(np.hypot(values[c.name], made.get(c.name, 0.0)))) for c in grid.criteria]
    feature = grid.goals.accuracy.feature
    if feature is not None:
        checks.append(
            Check(Criterion("feature", "distance of two touches told from one", "m", feature), point)
        )
    return tuple(checks)
