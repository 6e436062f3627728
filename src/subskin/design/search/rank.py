"""From the grid to the fingers to build: refined, looked at closely, ranked, each with its reasons."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from threading import Event
from typing import NamedTuple

import numpy as np

from ...errors import ConvergenceError
from ...finger import Finger
from ..placement import PlacementQuality, placement_quality
from ..tolerance import ToleranceBudget, tolerance_budget, usual_tolerances
from .goals import Goals, Row
from .grid import Criterion, DesignGrid
from .reasons import reasons_of
from .refine import Aim, apart, limen

__all__ = ["Check", "DesignStudy", "DesignedFinger", "rank_fingers"]

_MADE = ("position_95", "angle_95", "force_95")
"""What tolerances add to."""


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
        Accuracy and ambiguity over positions and angles.
    budget : ToleranceBudget or None
        What the tolerances cost; None where none were stated.
    point, wide : float
        Distance at which 95 % of pairs of touches are told from one, and from one wide contact [m].
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

    For each skin and kind the fewest sensors that meet the goals are found by halving the counts; one more and one less
    are looked at too. One depth and pitch, the best, stands for each count.

    Parameters
    ----------
    grid : DesignGrid
        From `search_grid`.
    workers : int, optional
        How many skins and kinds at a time; as many as there are cores if left out. The result does not depend on it.
    progress : callable, optional
        Called after each skin and kind.

    Raises
    ------
    ConvergenceError
        No design of the grid has room, or is felt at all.
    """
    pairs = _pairs(grid)
    if not pairs:
        if np.isnan(grid.excess).all():
            raise ConvergenceError(
                "no row has room",
                "sensors overlap, go round the finger, or take more than the longest row at every pitch that was tried",
                "narrower sensors, fewer of them, or a longer row",
            )
        raise ConvergenceError(
            "no row feels the touches", "at the weakest force noise hides them", "less noise or a larger force"
        )
    stopped = Event()
    found: list[DesignedFinger] = []
    pool = ThreadPoolExecutor(max_workers=workers or os.cpu_count() or 1)
    try:
        for fingers in pool.map(lambda pair: _fewest(grid, pair[0], pair[1], stopped), pairs):
            found += fingers
            if progress is not None:
                progress()
        found.sort(key=lambda f: (not f.meets, f.row.count if f.meets else 0, f.excess))
        kept = found[: grid.goals.effort.keep]
        wide = list(pool.map(lambda f: apart(limen(f.finger, grid.goals, "wide", positions=9)), kept))
    finally:
        stopped.set()
        pool.shutdown(wait=True, cancel_futures=True)
    looked = {f.row.which(grid.goals): f.checks for f in found}
    return DesignStudy(
        grid,
        tuple(
            replace(f, wide=value, reasons=reasons_of(grid, f.row, looked)) for f, value in zip(kept, wide, strict=True)
        ),
    )


def _pairs(grid: DesignGrid) -> list[tuple[int, int]]:
    """Skins and kinds that have room for some row that feels the touches."""
    finite = np.isfinite(grid.excess).any(axis=(2, 3, 4))
    return [(int(k), int(m)) for k, m in np.argwhere(finite)]


def _fewest(grid: DesignGrid, k: int, m: int, stopped: Event) -> list[DesignedFinger]:
    """Close looks at rows of one skin and kind: the fewest sensors that meet the goals, and their neighbours."""
    excess = np.where(np.isfinite(grid.excess[k, m]), grid.excess[k, m], np.inf).min(axis=(0, 1))
    looked: dict[int, DesignedFinger] = {}

    def meets(n: int) -> bool:
        if n not in looked and not stopped.is_set():
            looked[n] = _looked_at(grid, (k, m, n))
        return n in looked and looked[n].meets

    would = np.flatnonzero(excess <= 1)
    if would.size:
        low, high = int(would[0]), int(would[-1]) + 1
        while low < high:
            middle = (low + high) // 2
            low, high = (low, middle) if excess[middle] <= 1 and meets(middle) else (middle + 1, high)
        near = (low - 1, low, low + 1)
    else:
        nearest = int(np.argmin(excess))
        near = (nearest - 1, nearest, nearest + 1)
    for n in near:
        if 0 <= n < excess.size and np.isfinite(excess[n]):
            meets(n)
    return [looked[n] for n in sorted(looked)]


def _looked_at(grid: DesignGrid, which: tuple[int, int, int]) -> DesignedFinger:
    """The best row of a skin, kind and count; where tolerances spoil it, the best one that reckons with them."""
    finger = _designed(grid, Aim(grid, *which))
    spoilt = any(check.ratio > 1 for check in finger.checks if check.criterion.name in _MADE)
    if finger.budget is None or not spoilt:
        return finger
    other = _designed(grid, Aim(grid, *which, made=_made(finger.budget)))
    return min(finger, other, key=lambda f: f.excess)


def _designed(grid: DesignGrid, aim: Aim) -> DesignedFinger:
    best, goals = aim.best(), grid.goals
    finger = goals.finger(best.row)
    quality = placement_quality(finger, goals.touches)
    has = usual_tolerances(finger)  # a half plane has no thickness that could be off
    amounts = {name: amount for name, amount in goals.tolerances.items() if name in has}
    budget = None
    if amounts:
        amounts["noise"] = goals.sensors[best.row.sensor].error
        budget = tolerance_budget(
            finger,
            goals.touches,
            amounts,
            positions=12,
            angles=6,
            draws=50,
            seed=goals.effort.seed,
            search=quality.search,
        )
    point = apart(limen(finger, goals, "point"))
    checks = _checks(grid, best.values, {} if budget is None else _made(budget), point)
    return DesignedFinger(best.row, finger, best.values, quality, budget, point, np.nan, checks, ())


def _made(budget: ToleranceBudget) -> dict[str, float]:
    """What the tolerances of a finger's making add, in squares, to the errors that 95 % of the touches keep."""
    both, noise = budget.kept(0.95), budget.kept(0.95, ["noise"])
    pairs = zip(_MADE, both, noise, strict=True)
    return {
        name: float(np.sqrt(max(all_of_it**2 - own**2, 0.0))) if np.isfinite(all_of_it) else np.inf
        for name, all_of_it, own in pairs
    }


def _checks(grid: DesignGrid, values: dict[str, float], made: dict[str, float], point: float) -> tuple[Check, ...]:
    """What was wanted against what the finger does, the tolerances of its making among it."""
    checks = [Check(c, float(np.hypot(values[c.name], made.get(c.name, 0.0)))) for c in grid.criteria]
    feature = grid.goals.accuracy.feature
    if feature is not None:
        checks.append(Check(Criterion("feature", "distance of two touches told from one", "m", feature), point))
    return tuple(checks)
