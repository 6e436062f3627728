"""From the grid to the fingers to build: refined, looked at closely, ranked, each with its reasons."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
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

__all__ = ["Check", "DesignStudy", "DesignedFinger", "most_looked_at", "rank_fingers"]

_TRIED = 2
"""Designs looked at closely, for each that is kept."""
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
        Accuracy and ambiguity over places and angles.
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

    One design for each skin, kind and count is looked at, the most promising of these first.

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
    indices = _best_first(grid)[:most]
    if not indices:
        if np.isnan(grid.excess).all():
            raise ConvergenceError(
                "no row has room",
                "sensors overlap, go round the finger, or take more than the longest row at every pitch that was tried",
                "narrower sensors, fewer of them, or a longer row",
            )
        raise ConvergenceError(
            "no row feels the touches",
            "at the weakest force noise hides them",
            "less noise or a larger force",
        )
    cores = workers or os.cpu_count() or 1
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
        wide = pool.map(lambda f: apart(limen(f.finger, grid.goals, "wide", places=9)), kept)
        looked = {f.row.which(grid.goals): f.checks for f in found}
        fingers = tuple(
            replace(f, wide=value, reasons=reasons_of(grid, f.row, looked))
            for f, value in zip(kept, wide, strict=True)
        )
    return DesignStudy(grid, fingers)


def most_looked_at(grid: DesignGrid) -> int:
    """How many designs `rank_fingers` looks at, at most."""
    return min(_TRIED * grid.goals.effort.keep, len(_best_first(grid)))


def _best_first(grid: DesignGrid) -> list[tuple[int, int, int]]:
    """Skin, kind and count of those that have room: first where all that was searched for is met, the fewest sensors
    first, then the others, the nearest first.
    """
    excess = np.where(np.isfinite(grid.excess), grid.excess, np.inf).min(axis=(2, 3))
    best = []
    for k, m, n in np.ndindex(excess.shape):
        value = float(excess[k, m, n])
        if np.isfinite(value):
            best.append((value > 1, n if value <= 1 else 0, value, (k, m, n)))
    return [which for *_, which in sorted(best)]


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
            places=12,
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


def _checks(
    grid: DesignGrid, values: dict[str, float], made: dict[str, float], point: float
) -> tuple[Check, ...]:
    """What was wanted against what the finger does, the tolerances of its making among it."""
    checks = [Check(c, float(np.hypot(values[c.name], made.get(c.name, 0.0)))) for c in grid.criteria]
    feature = grid.goals.accuracy.feature
    if feature is not None:
        checks.append(
            Check(Criterion("feature", "distance of two touches told from one", "m", feature), point)
        )
    return tuple(checks)
