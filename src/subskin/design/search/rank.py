"""From the grid to the fingers to build: refined, looked at closely, ranked."""

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
from ..two_point import TwoPointLimen
from .goals import Goals, Row
from .grid import Criterion, DesignGrid
from .refine import Aim, apart, limen

__all__ = ["Check", "DesignStudy", "DesignedFinger", "rank_fingers"]

_MADE = ("position_95", "angle_95", "force_95")
"""What tolerances add to."""


class Check(NamedTuple):
    """One `criterion`, and the `value` [its unit] that a finger has."""

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
    values : dict of str to float
        As those of `DesignGrid`, for this design [m, rad, -].
    quality : PlacementQuality
        Accuracy and ambiguity over positions and angles.
    budget : ToleranceBudget or None
        What the tolerances cost; None where none were stated.
    two_points : TwoPointLimen
        From which distance on two touches are told from one.
    wide : float
        Distance at which 95 % of pairs of touches are told from one wide contact [m].
    checks : tuple of Check
        What was wanted, and what it does.
    """

    row: Row
    finger: Finger
    values: dict[str, float]
    quality: PlacementQuality
    budget: ToleranceBudget | None
    two_points: TwoPointLimen
    wide: float
    checks: tuple[Check, ...]

    @property
    def point(self) -> float:
        """Distance at which 95 % of pairs of touches are told from one [m]."""
        return apart(self.two_points)

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
    """What `rank_fingers` found.

    Attributes
    ----------
    grid : DesignGrid
        All designs that were tried.
    fingers : tuple of DesignedFinger
        Ranked: those that meet the goals first, the fewest sensors first among them; then by how far they fall short.
    looked : dict of (int, int, int) to tuple of Check
        Every design that was looked at closely, by the indices of its skin, kind and count.
    """

    grid: DesignGrid
    fingers: tuple[DesignedFinger, ...]
    looked: dict[tuple[int, int, int], tuple[Check, ...]]

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

    Examples
    --------
    >>> import subskin as ss
    >>> from subskin.design.search import Accuracy, Effort, Room, SensorKind, SkinChoice
    >>> goals = ss.design.Goals(
    ...     ss.design.Touches(force=20.0, friction=0.0, span=(-1e-3, 1e-3)), strongest=100.0,
    ...     accuracy=Accuracy(position=0.1e-3), sensors=(SensorKind("gauge", ss.NormalStrain(), noise=2e-4),),
    ...     skins=(SkinChoice("silicone", ss.HalfPlane(ss.Material(young=0.4e6))),),
    ...     room=Room(count=(3, 4), depth=(2e-3, 2e-3), least_pitch=1e-3), effort=Effort(1, 3, touches=200),
    ... )
    >>> study = ss.design.rank_fingers(ss.design.search_grid(goals))
    >>> [(f.row.count, f.meets) for f in study.fingers]
    [(3, True), (4, True)]
    """
    pairs = [(int(k), int(m)) for k, m in np.argwhere(np.isfinite(grid.excess).any(axis=(2, 3, 4)))]
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
    best = tuple(replace(finger, wide=value) for finger, value in zip(kept, wide, strict=True))
    return DesignStudy(grid, best, {f.row.which(grid.goals): f.checks for f in found})


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
    else:
        low = int(np.argmin(excess))
    for n in (low - 1, low, low + 1):
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
            finger, goals.touches, amounts, positions=12, angles=6, draws=50, rng=goals.effort.seed,
            search=quality.search,
        )  # fmt: skip
    found = limen(finger, goals, "point")
    checks = _checks(grid, best.values, {} if budget is None else _made(budget), apart(found))
    return DesignedFinger(best.row, finger, best.values, quality, budget, found, np.nan, checks)


def _made(budget: ToleranceBudget) -> dict[str, float]:
    """What the tolerances of a finger's making add, in squares, to the errors that 95 % of the touches keep."""
    both, noise = budget.kept(0.95), budget.kept(0.95, ["noise"])
    return {
        name: float(np.sqrt(max(whole**2 - own**2, 0.0))) if np.isfinite(whole) else np.inf
        for name, whole, own in zip(_MADE, both, noise, strict=True)
    }


def _checks(grid: DesignGrid, values: dict[str, float], made: dict[str, float], point: float) -> tuple[Check, ...]:
    """What was wanted against what the finger does, the tolerances of its making among it."""
    checks = [Check(c, float(np.hypot(values[c.name], made.get(c.name, 0.0)))) for c in grid.criteria]
    feature = grid.goals.accuracy.feature
    if feature is not None:
        checks.append(Check(Criterion("feature", "distance of two touches told from one", "m", feature), point))
    return tuple(checks)
