"""All tolerances of a finger at once: what is left of its touches as made, and after it was calibrated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ... import _check
from ..._check import FloatArray
from ...errors import InvalidValueError
from ...estimate import Locator, Status
from ...finger import Finger
from .._common import whole
from ..touches import Touches
from ._calibrated import after_calibration
from ._costs import Costs
from ._recovery import METHODS
from ._study import Study
from .sources import SOURCES, checked_tolerances

__all__ = ["ErrorsKept", "Outcome", "tolerance_outcome"]

_ALIKE = 1.05
"""Up to this ratio to the noise a misfit is as good as none."""


@dataclass(frozen=True)
class ErrorsKept:
    """Errors that tolerances add to those of the noise, and the touches that are lost with both.

    Parameters
    ----------
    position, angle, force : float
        Error that a share of the touches keeps, as a standard deviation over fingers: [m], [rad], relative to the
        force. Infinite where first order means nothing at too many touches.
    lost : float
        Share of the frames, with noise, that are not OK: ambiguous, not noticed, or not explained.
    """

    position: float
    angle: float
    force: float
    lost: float


@dataclass(frozen=True)
class Outcome:
    """What fingers do that are off by all tolerances at once.

    Parameters
    ----------
    as_made : ErrorsKept
        Located by the finger as drawn.
    calibrated : ErrorsKept
        Located by the same fingers after calibration.
    method : {"known", "blind"}
        Kind of the calibration.
    amounts : mapping of str to float
        The tolerances, the noise among them.
    """

    as_made: ErrorsKept
    calibrated: ErrorsKept
    method: str
    amounts: Mapping[str, float]


def tolerance_outcome(
    finger: Finger,
    touches: Touches,
    tolerances: Mapping[str, float] | None = None,
    *,
    method: str = "known",
    share: float = 0.95,
    positions: int = 12,
    angles: int = 6,
    draws: int = 50,
    rng: int = 0,
    search: tuple[float, float] | None = None,
) -> Outcome:
    """What all tolerances at once leave of a finger's touches, before and after it is calibrated.

    The calibration is one of least squares, to first order about the finger as it is: 60 presses straight down at known
    positions with a known force, or 200 touches of which only the tolerances are known. It fits what
    `tolerance_budget(self_calibration=...)` fits. What it cannot fit stays, and what it fits bends to make up for it.
    So dozens of fingers take less time than one calibration by `calibrate`.

    Parameters
    ----------
    finger : Finger
        As drawn, with the noise of its sensors.
    touches : Touches
        What presses: force, friction and span.
    tolerances : mapping of str to float, optional
        As in `tolerance_budget`.
    method : {"known", "blind"}, optional
        The calibration.
    share : float, optional
        Share of the touches for which the errors hold [-].
    positions, angles, draws : int, optional
        Touches, and fingers that are drawn.
    rng : int, optional
        Seed of all draws.
    search : (float, float), optional
        Where loads are looked for, y [m].

    Raises
    ------
    InvalidValueError, GeometryError, NotLinearError
        As in `tolerance_budget`.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.line(count=8, pitch=1.5e-3, depth=2e-3, noise=5e-5)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    >>> found = tolerance_outcome(finger, ss.design.Touches(force=20.0, friction=0.8), {"depth": 0.1e-3, "noise": 5e-5})
    >>> found.as_made.lost > 0.3, found.calibrated.lost
    (True, 0.0)
    """
    amounts = checked_tolerances(finger, tolerances)
    for name, count in {"positions": positions, "angles": angles, "draws": draws}.items():
        whole(name, count)
    if method not in METHODS:
        raise InvalidValueError(f'method "{method}"', f"there are {', '.join(METHODS)}", 'method="known"')
    part = _check.scalar("share", share, above=0.0, at_most=1.0)
    position, angle = touches.grid(positions, angles, finger)
    study = Study(finger, touches, position, angle, touches.friction, search)
    costs = Costs(study, draws, 0.95, whole("rng", rng, 0))
    off = {name: amount for name, amount in amounts.items() if SOURCES[name].spread != "reading"}
    linear = sum((costs.linear(name, amount) ** 2 for name, amount in off.items()), np.zeros((positions, angles, 3)))
    made = _kept(np.sqrt(linear), costs.together(amounts).lost, part)
    if not off:
        return Outcome(made, made, method, amounts)
    left, misfit = after_calibration(costs, off, method)
    frames = costs.with_reading_errors(costs.drawn_readings + left, amounts, costs.rng("together", draws))
    square = (np.einsum("pakn,dpan->dpak", costs.slope, left) ** 2).mean(axis=0)
    square[costs.singular & (np.abs(left).max(axis=(0, -1)) > 0)] = np.inf
    after = _kept(np.sqrt(square), _lost(study, frames, misfit), part)
    return Outcome(made, after, method, amounts)


def _kept(errors: FloatArray, lost: float, share: float) -> ErrorsKept:
    position, force, angle = np.quantile(errors, share, axis=(0, 1), method="higher")
    return ErrorsKept(float(position), float(angle), float(force), lost)


def _lost(study: Study, frames: FloatArray, misfit: FloatArray) -> float:
    """Share of frames (draws, p, a, n) that are not OK, on fingers that believe in `misfit` (draws, n) noises."""
    array, ok = study.finger.array, []
    alike = misfit.max(axis=1) < _ALIKE
    if alike.any():
        ok.append(study.locator(frames[alike]).status == Status.OK)
    for own, seen in zip(misfit[~alike], frames[~alike], strict=True):
        noisy = replace(array, noise=own * np.asarray(array.noise))
        locator = Locator(study.locator.response, noisy, friction=study.friction)
        ok.append(locator(seen[None]).status == Status.OK)
    return float(1 - np.concatenate(ok).mean())
