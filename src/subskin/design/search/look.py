"""A close look at one design: what it does of what is wanted, what tolerances leave, what it cannot object to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from ...finger import Finger
from ..blind_spots import BlindSpots, blind_spots
from ..placement import PlacementQuality, placement_quality
from ..tolerance import ErrorsKept, Outcome, ToleranceBudget, tolerance_budget, tolerance_outcome, usual_tolerances
from ..two_point import AreaLimen, TwoPointLimen, edge_direction, two_point_area
from .goals import Goals, Row
from .grid import Criterion, DesignGrid
from .refine import Aim, apart, freed, limen

__all__ = ["Check", "DesignedFinger", "explained", "finished", "freed_from", "looked_at"]


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
    outcome : Outcome or None
        What the tolerances leave as made and after calibration; None where only noise counts.
    budget : ToleranceBudget or None
        What each tolerance costs, of the first finger alone.
    unopposed : BlindSpots or None
        What it cannot object to: of the first finger, and of all where a goal asks for it.
    two_points : TwoPointLimen, AreaLimen or None
        The distance from which on two touches read as two; on an area None where no goal asks for it.
    edge : float
        Error that 95 % of the edges on an area keep of their direction [rad]; NaN where no goal asks for it.
    wide : float
        Distance at which 95 % of pairs of touches do not read like one wide contact [m].
    checks : tuple of Check
        What was wanted, and what it does: the finger that the goals say is judged.
    as_made, calibrated : tuple of Check
        The same of the finger before and after it is calibrated; alike where only noise counts.
    """

    row: Row
    finger: Finger
    values: dict[str, float]
    quality: PlacementQuality
    outcome: Outcome | None
    budget: ToleranceBudget | None
    unopposed: BlindSpots | None
    two_points: TwoPointLimen | AreaLimen | None
    wide: float
    checks: tuple[Check, ...]
    as_made: tuple[Check, ...]
    calibrated: tuple[Check, ...]
    edge: float = np.nan

    @property
    def point(self) -> float:
        """Distance at which 95 % of pairs of touches read as two [m]; NaN where there are none."""
        return np.nan if self.two_points is None else apart(self.two_points)

    @property
    def excess(self) -> float:
        """Largest ratio of a value to what was wanted."""
        return max(check.ratio for check in self.checks)

    @property
    def meets(self) -> bool:
        """Whether all that was wanted is there."""
        return self.excess <= 1


_MADE = {"position_95": "position", "angle_95": "angle", "force_95": "force", "radius_95": "radius"}
"""What tolerances add to, and what they add."""
_OUTSIDE = 300
"""Touches of each kind outside the model."""


def looked_at(grid: DesignGrid, which: tuple[int, int, int]) -> DesignedFinger:
    """The best row of a skin, kind and count; where tolerances spoil it, the best one that reckons with them."""
    finger = _designed(grid, Aim(grid, *which))
    spoilt = any(check.ratio > 1 for check in finger.checks if check.criterion.name in _MADE)
    if finger.outcome is None or not spoilt:
        return finger
    left = _judged(grid, finger.outcome)
    made = {name: getattr(left, part) for name, part in _added(left).items()}
    other = _designed(grid, Aim(grid, *which, made=made))
    return min(finger, other, key=lambda f: f.excess)


def _designed(grid: DesignGrid, aim: Aim) -> DesignedFinger:
    """The best row that `aim` finds; what noise alone spoils is looked at no further until it is among the kept."""
    best, goals = aim.best(), grid.goals
    finger = goals.finger(best.row)
    quality = placement_quality(finger, goals.touches)
    nothing = (None, None, None, _two_touches(goals, finger, quality), np.nan)
    design = DesignedFinger(best.row, finger, best.values, quality, *nothing, (), (), (), _edge(goals, finger))
    return _tried(grid, _checked(grid, design))


def _two_touches(goals: Goals, finger: Finger, quality: PlacementQuality) -> TwoPointLimen | AreaLimen | None:
    """When two touches read as two; on an area where a goal asks for it and a single touch is told."""
    feature = goals.accuracy.feature
    if not goals.on_area:
        return limen(finger, goals, "point")
    if feature is None or not np.isfinite(quality["position_95"]):
        return None
    largest = max(1.25 * feature, 2.0 * float(np.asarray(finger.array.depth).min()))
    return two_point_area(finger, goals.touches, largest=largest, search=quality.search, rng=goals.effort.seed)


def _edge(goals: Goals, finger: Finger) -> float:
    """Error that 95 % of the edges on an area keep of their direction [rad]; NaN where no goal asks for it."""
    if goals.accuracy.edge_length is None:
        return np.nan
    return float(np.quantile(edge_direction(finger, goals.touches, goals.accuracy.edge_length), 0.95, method="higher"))


def freed_from(grid: DesignGrid, finger: DesignedFinger) -> DesignedFinger | None:
    """The finger with its sensors at free positions, where they are better than its own."""
    row, values = freed(grid, finger.row, finger.values)
    if row == finger.row:
        return None
    made = grid.goals.finger(row)
    values = {**finger.values, **values}
    quality = placement_quality(made, grid.goals.touches)
    moved = replace(
        finger, row=row, finger=made, values=values, quality=quality, outcome=None, unopposed=None,
        edge=_edge(grid.goals, made), two_points=_two_touches(grid.goals, made, quality),
    )  # fmt: skip
    return _tried(grid, _checked(grid, moved))


def _tried(grid: DesignGrid, design: DesignedFinger) -> DesignedFinger:
    """Looked at for as long as it meets the goals; tolerances last, for they take longest."""
    for more in (_opposed, _studied):
        design = more(grid, design) if design.meets else design
    return design


def _opposed(grid: DesignGrid, design: DesignedFinger) -> DesignedFinger:
    """With its blind spots, where they are judged."""
    if grid.goals.accuracy.outside == 1 or design.unopposed is not None or not _locates(design):
        return design
    return _checked(grid, replace(design, unopposed=_unopposed(grid, design)))


def _studied(grid: DesignGrid, design: DesignedFinger) -> DesignedFinger:
    """With what its tolerances leave."""
    goals, amounts = grid.goals, _amounts(grid, design)
    if not amounts or design.outcome is not None or not _locates(design):
        return design
    method: Literal["known", "blind"] = "blind" if goals.accuracy.calibrated == "blind" else "known"
    search, seed = design.quality.search, goals.effort.seed
    outcome = tolerance_outcome(design.finger, goals.touches, amounts, method=method, rng=seed, search=search)
    return _checked(grid, replace(design, outcome=outcome))


def finished(grid: DesignGrid, design: DesignedFinger) -> DesignedFinger:
    """All that the table of fingers says."""
    design = _studied(grid, _opposed(grid, design))
    if grid.goals.on_area:
        return design
    return replace(design, wide=apart(limen(design.finger, grid.goals, "wide", positions=9)))


def explained(grid: DesignGrid, design: DesignedFinger) -> DesignedFinger:
    """All that the report says of the first finger."""
    if not _locates(design):
        return design
    goals, amounts = grid.goals, _amounts(grid, design)
    if amounts:
        positions, draws = (25, 20) if goals.on_area else (12, 50)
        budget = tolerance_budget(
            design.finger, goals.touches, amounts, positions=positions, angles=6, draws=draws, rng=goals.effort.seed,
            search=design.quality.search,
        )  # fmt: skip
        design = replace(design, budget=budget)
    return design if design.unopposed is not None else replace(design, unopposed=_unopposed(grid, design))


def _locates(design: DesignedFinger) -> bool:
    """Whether `locate` finds the touches that the finger is for: of local ones sensors in a row make lines."""
    return design.finger.array.on_area or design.quality.touches.dim == 1


def _amounts(grid: DesignGrid, design: DesignedFinger) -> dict[str, float]:
    """The tolerances of a finger and its noise; nothing where only noise is to count."""
    stated, has = grid.goals.tolerances, usual_tolerances(design.finger)
    # a half plane has no thickness that could be off, and steps of the readings are among the noise
    amounts = has if stated is None else {name: amount for name, amount in stated.items() if name in has}
    amounts = {name: amount for name, amount in amounts.items() if name not in ("noise", "resolution") and amount > 0}
    # of several kinds, which have units of their own, as the noise of the array is shared out
    ratio = max(kind.error / kind.noise for kind in grid.goals.choices[design.row.sensor].kinds)
    return amounts | {"noise": ratio * has["noise"]} if amounts else {}


def _unopposed(grid: DesignGrid, design: DesignedFinger) -> BlindSpots:
    goals = grid.goals
    lines = None if design.finger.array.on_area else "line"  # for which rows are designed
    return blind_spots(
        design.finger, goals.touches, lines, count=_OUTSIDE, rng=goals.effort.seed, search=design.quality.search
    )


def _judged(grid: DesignGrid, outcome: Outcome) -> ErrorsKept:
    return outcome.as_made if grid.goals.accuracy.calibrated == "none" else outcome.calibrated


def _added(left: ErrorsKept) -> dict[str, str]:
    """What of `_MADE` there is of these touches."""
    return {name: part for name, part in _MADE.items() if not np.isnan(getattr(left, part))}


def _checked(grid: DesignGrid, design: DesignedFinger) -> DesignedFinger:
    """With what was wanted against what it does, as judged and as made."""
    outcome = design.outcome
    made = _checks(grid, design, None if outcome is None else outcome.as_made)
    after = _checks(grid, design, None if outcome is None else outcome.calibrated)
    judged = made if grid.goals.accuracy.calibrated == "none" else after
    return replace(design, checks=judged, as_made=made, calibrated=after)


def _checks(grid: DesignGrid, design: DesignedFinger, left: ErrorsKept | None) -> tuple[Check, ...]:
    """What was wanted against what the finger does, with what the tolerances leave."""
    values, accuracy = dict(design.values), grid.goals.accuracy
    if not _locates(design):
        values["unsure"] = 1.0
    if left is not None:
        values |= {name: float(np.hypot(values[name], getattr(left, part))) for name, part in _added(left).items()}
        values["unsure"] = max(values["unsure"], left.lost)  # noise is in both
    checks = [Check(c, values[c.name]) for c in grid.criteria]
    if accuracy.feature is not None:
        feature = Criterion("feature", "distance that two touches need", "m", accuracy.feature)
        checks.append(Check(feature, design.point if np.isfinite(design.point) else np.inf))
    if accuracy.edge is not None:
        checks.append(Check(Criterion("edge", "error of an edge's direction", "rad", accuracy.edge), design.edge))
    if accuracy.outside < 1 and design.unopposed is not None:
        outside = Criterion("blind_spots", "touches outside the model OK and wrong", "", accuracy.outside)
        checks.append(Check(outside, design.unopposed.wrong))
    return tuple(checks)
