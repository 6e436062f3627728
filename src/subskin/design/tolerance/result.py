"""A budget of tolerances: what each source costs, all of them, and how tight each has to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ... import _check
from ...errors import InvalidValueError, SubskinError
from ...finger import Finger
from ..touches import Touches

if TYPE_CHECKING:
    from ._costs import Costs

__all__ = ["Cost", "Needed", "Recovery", "ToleranceBudget"]

_NO_PART = 1e-3
"""Share of a wanted accuracy below which a source takes no part in it."""

_WIDEST = 10.0
_CLOSE = 0.02
_ROUNDS = 6


@dataclass(frozen=True)
class Cost:
    """What a source of error costs in locating: one row of a budget.

    Parameters
    ----------
    source : str
        One of `SOURCES`, or "total" or "together".
    amount : float
        Its standard deviation, in `unit`: metres, readings, or "" for shares and for Poisson's ratio. Of `width`, the
        value itself; of `resolution`, the step.
    spread : {"finger", "fixed", "sensor", "reading"}
        Whether it is one number for the whole finger, one that is the same in all of them, each sensor's own, or each
        reading's.
    position_rms, angle_rms, force_rms : float
        Root mean square over touches and fingers [m, rad, share of the force].
    position_worst, angle_worst, force_worst : float
        At the worst touch, the error that the budget's `quantile` of the fingers (of the frames, for the noise) stay
        within; for `resolution` and `width` simply the largest.
    lost : float
        Share of the frames that are not OK any more.
    position_linear, angle_linear, force_linear : float
        Root mean square to first order: (J^T W J)^-1 J^T W times the change of the readings. Infinite where J is
        singular at one of the touches.
    """

    source: str
    amount: float
    unit: str
    spread: str
    position_rms: float
    position_worst: float
    angle_rms: float
    angle_worst: float
    force_rms: float
    force_worst: float
    lost: float
    position_linear: float
    angle_linear: float
    force_linear: float


@dataclass(frozen=True)
class Needed:
    """How tight a tolerance has to be.

    Parameters
    ----------
    source, amount, unit
        As of `Cost`: as given.
    alone : float
        Amount with which this source alone would use up the wanted accuracy; infinite where that is more than ten times
        what was given.
    shared : float
        Amount with which it takes an equal share of the variance, beside the others that matter.
    """

    source: str
    amount: float
    unit: str
    alone: float
    shared: float


@dataclass(frozen=True)
class Recovery:
    """What self-calibration wins back of the errors that a source makes.

    Parameters
    ----------
    source : str
        One of `SOURCES`, or "together".
    drawn : Cost
        With the finger as drawn, on the same fingers.
    known, blind : Cost or None
        After calibrating at known positions, and from touches of which nothing is known; None where that was not asked.
    failed : tuple of (str, int)
        How many calibrations of each kind did not settle; these fingers count as drawn.
    """

    source: str
    drawn: Cost
    known: Cost | None
    blind: Cost | None
    failed: tuple[tuple[str, int], ...]


@dataclass(frozen=True, eq=False)
class ToleranceBudget:
    """What `tolerance_budget` found.

    Parameters
    ----------
    finger : Finger
        As drawn, by which readings of the fingers as made are located.
    touches : Touches
        What presses.
    rows : tuple of Cost
        One a source.
    total : Cost
        Root of the sum of squares of each column. NaN for what is lost: misfits add up, and what each source leaves
        explained all of them together may not.
    together : Cost
        All sources at once, by drawing fingers and frames: what the total should be.
    recovered : tuple of Recovery
        With self-calibration, one a source that it could remove, and all together at the end.
    quantile, draws, seed : float, int, int
        Of the draws.
    """

    finger: Finger
    touches: Touches
    rows: tuple[Cost, ...]
    total: Cost
    together: Cost
    recovered: tuple[Recovery, ...]
    quantile: float
    draws: int
    seed: int
    _costs: Costs = field(repr=False)

    def kept(self, share: float = 0.95, sources: Sequence[str] | None = None) -> tuple[float, float, float]:
        """Standard errors of position [m], angle [rad] and force [-] that a share of the touches keep, to first order.

        At each touch the sources add up as squares; of all of the budget, or of those named.

        Raises
        ------
        InvalidValueError
            A share that is not in (0, 1), a source that is not in the budget.
        """
        part = _check.scalar("share", share, above=0.0, at_most=1.0)
        amounts = {row.source: row.amount for row in self.rows}
        for name in sources or ():
            if name not in amounts:
                raise InvalidValueError(f"source {name!r}", f"the budget has {', '.join(amounts)}")
        chosen = amounts if sources is None else {name: amounts[name] for name in sources}
        square = sum(self._costs.linear(name, amount) ** 2 for name, amount in chosen.items())
        position, force, angle = np.quantile(np.sqrt(square), part, axis=(0, 1), method="higher")
        return float(position), float(angle), float(force)

    def needed(
        self, position: float | None = None, angle: float | None = None, *, keep: Sequence[str] = ()
    ) -> tuple[Needed, ...]:
        """How tight each tolerance has to be for a wanted rms error of `position` [m], of `angle` [rad], or both.

        Each amount is found by locating again with it, until the error is within 2 % of what it may be.

        Parameters
        ----------
        position, angle : float, optional
            Wanted root mean square errors, > 0.
        keep : sequence of str, optional
            Sources that stay as they are, such as the noise: what they cost is taken off the wanted accuracy first, and
            they are not among the answers.

        Raises
        ------
        InvalidValueError
            Nothing wanted, a source that has no row, or one kept that costs more than what is wanted.
        """
        wanted = {
            name: _check.scalar(name, value, above=0.0, unit=unit)
            for name, value, unit in (("position", position, "m"), ("angle", angle, "rad"))
            if value is not None
        }
        if not wanted:
            raise InvalidValueError("no accuracy wanted", "position, angle or both are needed", "position=1e-4")
        named = {row.source: row for row in self.rows}
        for source in keep:
            if source not in named:
                raise InvalidValueError(f"keep = {source!r}", f"there are {', '.join(named)}")
        kept, free = ([r for r in self.rows if (r.source in keep) is side] for side in (True, False))
        left = {}
        for name, value in wanted.items():
            rest = value**2 - sum(_rms(row, name) ** 2 for row in kept)
            if not rest > 0:
                raise InvalidValueError(
                    f"{name} = {value:.6g}", f"{', '.join(keep)} alone cost more than that", "tighten these too"
                )
            left[name] = float(np.sqrt(rest))
        parts = {name: max(sum(_rms(row, name) > _NO_PART * value for row in free), 1) for name, value in left.items()}
        share = {name: value / np.sqrt(parts[name]) for name, value in left.items()}
        return tuple(
            Needed(row.source, row.amount, row.unit, self._amount(row, left), self._amount(row, share)) for row in free
        )

    def _amount(self, row: Cost, allowed: dict[str, float]) -> float:
        """The amount at which the first of the `allowed` errors is reached, by secants in the logarithms."""
        amount, power, cost = row.amount, 1.0, row
        for _ in range(_ROUNDS):
            used = max(_rms(cost, name) / value for name, value in allowed.items())
            if not used > _NO_PART / _WIDEST:
                return np.inf
            if abs(used - 1) < _CLOSE:
                break
            following = amount * float(np.clip(used ** (-1 / power), 1e-3, _WIDEST))
            if following > _WIDEST * row.amount and amount >= _WIDEST * row.amount:
                return np.inf
            following = min(following, _WIDEST * row.amount)
            try:
                cost = self._costs.cost(row.source, following)
            except SubskinError:  # no finger can be off by so much
                return np.inf
            now = max(_rms(cost, name) / value for name, value in allowed.items())
            if now > 0 and following != amount:
                power = float(np.clip(np.log(now / used) / np.log(following / amount), 0.5, 4.0))
            amount = following
        return amount


def _rms(row: Cost, name: str) -> float:
    return float(getattr(row, f"{name}_rms"))
