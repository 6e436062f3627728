"""What a search hands over: fingers to build, what was wanted of them and what they do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...finger import Finger
from ..blind_spots import BlindSpots
from ..placement import PlacementQuality
from ..tolerance import Outcome, ToleranceBudget
from ..two_point import AreaLimen, TwoPointLimen
from .goals import Goals, Row
from .grid import Criterion, DesignGrid
from .refine import apart
from .remedy import Remedy

__all__ = ["Check", "DesignStudy", "DesignedFinger"]


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
    remedies : tuple of Remedy
        Where no design of the grid will do: which single change would let one.
    """

    grid: DesignGrid
    fingers: tuple[DesignedFinger, ...]
    looked: dict[tuple[int, int, int], tuple[Check, ...]]
    remedies: tuple[Remedy, ...] = ()

    @property
    def goals(self) -> Goals:
        """What was wanted."""
        return self.grid.goals
