"""What each tolerance of a finger costs in millimetres, degrees and force, and how tight it has to be."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, TypeAlias

import numpy as np

from ... import _check
from ..._declared import Friction, Length, Real, Ruled, checked
from ...errors import InvalidValueError, SubskinError
from ...finger import Finger
from .._common import Count, Seed
from ..touches import Touches
from ._calibrated import METHODS, recoveries, terms_for
from ._costs import Costs, combined
from ._study import Study
from .sources import Amounts, Cost, Needed, Recovery, checked_tolerances

__all__ = ["ToleranceBudget", "tolerance_budget"]

Lean: TypeAlias = Annotated[float, Real("rad", above=0.0)]
Portion: TypeAlias = Annotated[float, Real(above=0.0, at_most=1.0)]

_NO_PART = 1e-3
"""Share of a wanted accuracy below which a source takes no part in it."""
_WIDEST = 10.0
_CLOSE = 0.02
_ROUNDS = 6


def _named(name: str, given: Any) -> Any:
    """Kinds of self-calibration, each by a name that there is."""
    named = (given,) if isinstance(given, str) else _check.several(name, given, str, 'self_calibration=("known",)')
    for one in named:
        _check.choice(name, one, METHODS)
    return given if isinstance(given, Mapping) else named


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
        With self-calibration: one for each source that it could remove, and all together at the end.
    quantile : float
        What share of the fingers the worst errors hold for [-].
    draws : int
        Fingers or frames drawn for each source.
    """

    finger: Finger
    touches: Touches
    rows: tuple[Cost, ...]
    total: Cost
    together: Cost
    recovered: tuple[Recovery, ...]
    quantile: float
    draws: int
    _costs: Costs = field(repr=False)

    @checked
    def kept(self, share: Portion = 0.95, sources: Sequence[str] | None = None) -> tuple[float, float, float]:
        """Errors of position [m], angle [rad] and force [-] that a `share` of the touches keep, to first order.

        At each touch the covariances of all `sources`, or of those named, add up. The error of a position on an area is
        its standard deviation in the direction in which it is worst.

        Raises
        ------
        InvalidValueError
            A share that is not in (0, 1), a source that is not in the budget.
        """
        amounts = {row.source: row.amount for row in self.rows}
        chosen = amounts if sources is None else sources
        for name in chosen:
            if name not in amounts:
                raise InvalidValueError(f"source {name!r}", f"the budget has {', '.join(amounts)}", "one of these")
        square = np.sum([self._costs.linear(name, amounts[name]) for name in chosen], axis=0)
        position, force, angle = np.quantile(self._costs.spread(square), share, axis=(0, 1), method="higher")[:3]
        return float(position), float(angle), float(force)

    @checked
    def needed(
        self, position: Length | None = None, angle: Lean | None = None, *, keep: Sequence[str] = ()
    ) -> tuple[Needed, ...]:
        """How tight each tolerance has to be for a wanted rms error of `position` [m], of `angle` [rad], or both.

        Each amount is found by locating again with it, until the error is within 2 % of what it may be.

        Parameters
        ----------
        position, angle : float, optional
            Wanted root mean square errors [m, rad], > 0.
        keep : sequence of str, optional
            Sources that stay as they are, such as the noise: what they cost is taken off the wanted accuracy first, and
            they are not among the answers.

        Raises
        ------
        InvalidValueError
            Nothing wanted, a source that has no row, or one kept that costs more than what is wanted.
        """
        wanted = {name: value for name, value in (("position", position), ("angle", angle)) if value is not None}
        if not wanted:
            raise InvalidValueError("no accuracy wanted", "position, angle or both are needed", "position=1e-4")
        named = [row.source for row in self.rows]
        for source in keep:
            if source not in named:
                raise InvalidValueError(f"keep = {source!r}", f"there are {', '.join(named)}", f"keep={named[:1]}")
        kept, free = ([r for r in self.rows if (r.source in keep) is side] for side in (True, False))
        left = {}
        for name, value in wanted.items():
            rest = value**2 - sum(_rms(row, name) ** 2 for row in kept)
            if not rest > 0:
                rule = f"{', '.join(keep)} alone cost more than that"
                raise InvalidValueError(f"{name} = {value:.6g}", rule, "tighten these too")
            left[name] = float(np.sqrt(rest))
        parts = {name: max(sum(_rms(row, name) > _NO_PART * value for row in free), 1) for name, value in left.items()}
        share = {name: value / np.sqrt(parts[name]) for name, value in left.items()}
        return tuple(
            Needed(row.source, row.amount, row.unit, self._amount(row, left), self._amount(row, share)) for row in free
        )

    def _amount(self, row: Cost, allowed: dict[str, float]) -> float:
        """The amount at which the first of the `allowed` errors is reached, by secants in the logarithms."""

        def used(cost: Cost) -> float:
            return max(_rms(cost, name) / value for name, value in allowed.items())

        amount, power, now, most = row.amount, 1.0, used(row), _WIDEST * row.amount
        for _ in range(_ROUNDS):
            if not now > _NO_PART / _WIDEST:
                return np.inf
            if abs(now - 1) < _CLOSE:
                break
            following = amount * float(np.clip(now ** (-1 / power), 1e-3, _WIDEST))
            if following > most and amount >= most:
                return np.inf
            following = min(following, most)
            try:
                before, now = now, used(self._costs.cost(row.source, following))
            except SubskinError:  # no finger can be off by so much
                return np.inf
            if now > 0 and following != amount:
                power = float(np.clip(np.log(now / before) / np.log(following / amount), 0.5, 4.0))
            amount = following
        return amount


def _rms(row: Cost, name: str) -> float:
    return float(getattr(row, f"{name}_rms"))


@checked
def tolerance_budget(
    finger: Finger,
    touches: Touches,
    tolerances: Amounts = None,
    *,
    positions: Count | None = None,
    angles: Count = 12,
    draws: Count = 200,
    quantile: Annotated[float, Real(above=0.0)] = 0.95,
    rng: Seed = 0,
    friction: Friction | None = None,
    search: Any = None,
    self_calibration: Annotated[str | Sequence[str] | Mapping[str, Sequence[str]], Ruled(_named)] = (),
    calibration_draws: Count = 3,
    calibration_touches: Count = 200,
    calibration_presses: Count = 60,
    progress: Callable[[], object] | None = None,
) -> ToleranceBudget:
    """What each source of error costs in locating the touches that a finger is made for.

    Readings of the finger as made, off by one source, are located by the finger as drawn. They are free of noise but
    where noise is the source. Frames that `locate` calls unexplained count as lost, and with the load that fits them
    best in the errors; errors to first order stand beside them. What is one number for the whole finger is off by its
    amount to either side, or to the one that there is; what each sensor has of its own is drawn `draws` times.

    Parameters
    ----------
    finger : Finger
        As drawn, with the noise of its sensors.
    touches : Touches
        What presses: force, friction, and span or area.
    tolerances : mapping of str to float, optional
        Amount of each source of `SOURCES` to look at, a standard deviation [m, readings or shares];
        `usual_tolerances(finger)` if left out. 0 leaves a source out.
    positions, angles : int, optional
        Touches: middles of equal parts of the span (24) and of the cone. An odd number of both puts one where three
        sensors are singular. On an area about so many cells (36), and directions.
    draws : int, optional
        Fingers or frames drawn for each source that is random from sensor to sensor or from reading to reading.
    quantile : float, optional
        What share of the fingers the worst errors hold for.
    rng : Generator or int, optional
        Random generator, or its seed.
    friction : float, optional
        Coefficient of friction of `locate`; that of the touches if left out.
    search : optional
        Where loads are looked for [m]; as in `Finger.locate`.
    self_calibration : str, sequence or mapping, optional
        "known": calibrate each finger first by presses straight down, of known force at known positions. "blind": by
        touches like these (on an area on points) of which only the tolerances are known. Each fits all that has a
        tolerance and can be fitted; a mapping says otherwise, as {"blind": ("gain", "depth", "position")}.
    calibration_draws, calibration_touches, calibration_presses : int, optional
        Fingers calibrated for each source; touches of each blind calibration, and presses of each at known positions.
    progress : callable, optional
        Called after each row, and after each calibration.

    Raises
    ------
    InvalidValueError
        An unknown source, or one that the skin has not; amounts or counts out of range; sensors without noise, too few
        of them.
    GeometryError
        Touches without a span, or beyond the search; touches on an area and sensors in a row, or the reverse.
    NotLinearError
        A transducer with no linear part.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=8, pitch=2e-3, depth=2e-3, noise=1e-5))
    >>> touches = ss.design.Touches(force=20.0)
    >>> budget = ss.design.tolerance_budget(finger, touches, {"poisson": 0.05, "young": 0.1})
    >>> wrong, softer = sorted(budget.rows, key=lambda row: -row.angle_rms)
    >>> wrong.source, round(float(np.rad2deg(wrong.angle_linear)), 1), bool(softer.angle_rms < 1e-6)
    ('poisson', 6.6, True)
    """
    amounts = checked_tolerances(finger, tolerances)
    if not quantile < 1:
        raise InvalidValueError(f"quantile = {quantile:.6g}", "has to be < 1", "quantile=0.95")
    root = int(rng.integers(2**63)) if isinstance(rng, np.random.Generator) else int(rng)
    usual, own = terms_for(finger, amounts), self_calibration if isinstance(self_calibration, Mapping) else {}
    methods = {name: tuple(own.get(name, usual)) for name in METHODS if name in self_calibration}
    position, load = touches.loads(touches.usual_positions(24) if positions is None else positions, angles, finger)
    mu = touches.friction if friction is None else friction
    costs = Costs(Study(finger, touches, position, load, mu, search), draws, quantile, root)
    advance = progress or (lambda: None)
    rows = []
    for name, amount in amounts.items():
        rows.append(costs.cost(name, amount))
        advance()
    together = costs.together(amounts)
    advance()
    presses = {"known": calibration_presses, "blind": calibration_touches}
    recovered = recoveries(costs, amounts, methods, calibration_draws, presses, advance)
    return ToleranceBudget(finger, touches, tuple(rows), combined(rows), together, recovered, quantile, draws, costs)
