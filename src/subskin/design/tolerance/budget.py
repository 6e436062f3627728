"""What each tolerance of a finger costs in millimetres, degrees and force."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ... import _check
from ...errors import InvalidValueError
from ...estimate.frames import checked_friction
from ...finger import Finger
from ..touches import Touches
from ._costs import Costs, combined
from ._recovery import METHODS, recoveries, terms_for
from ._study import Study
from .result import ToleranceBudget
from .sources import checked_tolerances

__all__ = ["tolerance_budget"]


def tolerance_budget(
    finger: Finger,
    touches: Touches,
    tolerances: Mapping[str, float] | None = None,
    *,
    positions: int = 24,
    angles: int = 12,
    draws: int = 200,
    quantile: float = 0.95,
    seed: int = 0,
    friction: float | None = None,
    search: tuple[float, float] | None = None,
    self_calibration: str | Sequence[str] | Mapping[str, Sequence[str]] = (),
    calibration_draws: int = 3,
    calibration_touches: int = 200,
    calibration_presses: int = 60,
    progress: Callable[[], object] | None = None,
) -> ToleranceBudget:
    """What each source of error costs in locating the touches that a finger is made for.

    Readings of the finger as made, off by one source, are located by the finger as drawn. They are free of noise but
    where noise is the source, so every error is that source's. Errors are those of `locate` itself: frames that it
    calls unexplained count as lost, and with the load that fits them best in the errors. Errors to first order stand
    beside them. What is one number for the whole finger is taken off by its amount to either side, or to the one that
    there is (Poisson's ratio ends at 1/2); what each sensor has of its own is drawn `draws` times.

    Parameters
    ----------
    finger : Finger
        As drawn, with the noise of its sensors.
    touches : Touches
        What presses: force, friction and span.
    tolerances : mapping of str to float, optional
        Amount of each source of `SOURCES` to look at, a standard deviation [m, readings or shares];
        `usual_tolerances(finger)` if left out. 0 leaves a source out.
    positions, angles : int, optional
        Touches: middles of equal parts of the span and of the cone. An odd number of both puts one where three sensors
        are singular.
    draws : int, optional
        Fingers or frames drawn for each source that is random from sensor to sensor or from reading to reading.
    quantile : float, optional
        What share of the fingers the worst errors hold for.
    seed : int, optional
        Of all draws.
    friction : float, optional
        Of `locate`; that of the touches if left out.
    search : (float, float), optional
        Where loads are looked for, y [m]; as of `Finger.locate`.
    self_calibration : str, sequence or mapping, optional
        "known": calibrate each finger by presses straight down at known positions along the span, their force being
        known, before it is located. "blind": by touches like these of which nothing is known, the tolerances being what
        is known beforehand. Each fits all that has a tolerance and can be fitted; a mapping says otherwise, as
        {"blind": ("gain", "depth", "position")}.
    calibration_draws, calibration_touches, calibration_presses : int, optional
        Fingers calibrated for each source; touches of each blind calibration, and presses of each at known positions.
    progress : callable, optional
        Called after each row, and after each calibration.

    Returns
    -------
    ToleranceBudget

    Raises
    ------
    InvalidValueError
        An unknown source, or one that the skin has not; amounts or counts out of range; sensors without noise, too few
        of them.
    GeometryError
        Touches without a span, or beyond the search.
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
    counts = {
        "positions": positions, "angles": angles, "draws": draws,
        "calibration_draws": calibration_draws, "calibration_touches": calibration_touches,
        "calibration_presses": calibration_presses,
    }  # fmt: skip
    for name, count in counts.items():
        if isinstance(count, bool) or int(count) != count or count < 1:
            raise InvalidValueError(f"{name} = {count!r}", "a whole number >= 1 is needed")
    share = _check.scalar("quantile", quantile, above=0.0)
    if not share < 1:
        raise InvalidValueError(f"quantile = {share:.6g}", "has to be < 1", "quantile=0.95")
    if isinstance(seed, bool) or int(seed) != seed or seed < 0:
        raise InvalidValueError(f"seed = {seed!r}", "a whole number >= 0 is needed")
    methods = _methods(self_calibration, terms_for(finger, amounts))
    mu = touches.friction if friction is None else checked_friction(friction)
    position, angle = touches.grid(positions, angles, finger)
    costs = Costs(Study(finger, touches, position, angle, mu, search), draws, share, seed)
    advance = progress or (lambda: None)
    rows = []
    for name, amount in amounts.items():
        rows.append(costs.cost(name, amount))
        advance()
    together = costs.together(amounts)
    advance()
    recovered = recoveries(
        costs, amounts, methods, calibration_draws,
        {"known": calibration_presses, "blind": calibration_touches}, advance,
    )  # fmt: skip
    return ToleranceBudget(
        finger, touches, tuple(rows), combined(tuple(rows)), together, recovered, share, draws, seed, costs
    )


def _methods(
    given: str | Sequence[str] | Mapping[str, Sequence[str]], usual: tuple[str, ...]
) -> dict[str, tuple[str, ...]]:
    """What each kind of self-calibration fits, in the order of `METHODS`."""
    named = (given,) if isinstance(given, str) else tuple(given)
    for name in named:
        if name not in METHODS:
            raise InvalidValueError(f"self_calibration = {name!r}", f"there are {', '.join(METHODS)}")
    own = given if isinstance(given, Mapping) else {}
    return {name: tuple(own.get(name, usual)) for name in METHODS if name in named}
