"""All tolerances of a finger at once: what is left of its touches as made, and after it was calibrated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np

from ..._check import FloatArray
from ..._declared import Real, Whole, checked
from ...finger import Finger
from .._common import Count
from ..touches import Touches
from ._calibrated import after_calibration, count_of
from ._costs import Costs
from ._study import Study
from .sources import SOURCES, Amounts, checked_tolerances

__all__ = ["ErrorsKept", "Outcome", "tolerance_outcome"]

_FEW = 20
"""Fingers on an area of which frames are located: each of a layered skin has fields of its own to work out."""
_ALIKE = 1.05
"""Up to this ratio to the noise a misfit is as good as none."""


@dataclass(frozen=True)
class ErrorsKept:
    """Errors that tolerances add to those of the noise, and the touches that are lost with both.

    Parameters
    ----------
    position, angle, force : float
        Error that a share of the touches keeps, as a standard deviation over fingers: [m], [rad], relative to the
        force; on an area in the direction in which it is worst. Infinite where first order means nothing at too many
        touches.
    lost : float
        Share of the frames, with noise, that are not OK: ambiguous, not noticed, or not explained.
    radius : float
        The error of the radius of touches that have one [m]; NaN of others.
    """

    position: float
    angle: float
    force: float
    lost: float
    radius: float = np.nan


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
    presses : int
        Touches of it.
    amounts : mapping of str to float
        The tolerances, the noise among them.
    """

    as_made: ErrorsKept
    calibrated: ErrorsKept
    method: str
    presses: int
    amounts: Mapping[str, float]


@checked
def tolerance_outcome(
    finger: Finger,
    touches: Touches,
    tolerances: Amounts = None,
    *,
    method: Literal["known", "blind"] = "known",
    share: Annotated[float, Real(above=0.0, at_most=1.0)] = 0.95,
    positions: Count | None = None,
    angles: Count = 6,
    draws: Count = 50,
    rng: Annotated[int, Whole(0, 2**63)] = 0,
    search: Any = None,
) -> Outcome:
    """What all tolerances at once leave of a finger's touches, before and after it is calibrated.

    The calibration is one of least squares, to first order about the finger as it is: 60 presses straight down at known
    positions with a known force, on an area about 64 on a grid; or 200 touches (on an area on points) of which only
    the tolerances are known.
    It fits what `tolerance_budget(self_calibration=...)` fits. What it cannot fit stays, and what it fits bends to make
    up for it. So dozens of fingers take less time than one calibration by `calibrate`.

    Parameters
    ----------
    finger : Finger
        As drawn, with the noise of its sensors.
    touches : Touches
        What presses: force, friction, and span or area.
    tolerances : mapping of str to float, optional
        As in `tolerance_budget`.
    method : {"known", "blind"}, optional
        The calibration.
    share : float, optional
        Share of the touches for which the errors hold [-].
    positions, angles, draws : int, optional
        Touches (12 positions, on an area 36), and fingers that are drawn; on an area 20 of them locate.
    rng : int, optional
        Seed of all draws.
    search : optional
        Where loads are looked for [m], as in `Finger.locate`.

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
    count = touches.usual_positions(12) if positions is None else positions
    study = Study(finger, touches, *touches.loads(count, angles, finger), touches.friction, search)
    costs = Costs(study, draws, 0.95, rng)
    off = {name: amount for name, amount in amounts.items() if SOURCES[name].spread != "reading"}
    linear = np.sum([costs.linear(name, amount) for name, amount in off.items()], axis=0)
    few = draws if touches.area is None else min(draws, _FEW)
    made = _kept(costs, linear, costs.lost(amounts, few), share)
    presses = count_of(study, method)
    if not off:
        return Outcome(made, made, method, presses, amounts)
    left, misfit = after_calibration(costs, off, method)
    frames = costs.with_reading_errors(
        costs.drawn_readings + left[:few], amounts, costs.rng("together", draws), len(left[:few])
    )
    errors = np.einsum("pakn,dpan->dpak", costs.slope, left)
    square = np.einsum("dpak,dpaj->pakj", errors, errors) / draws
    square[costs.singular & (np.abs(left).max(axis=(0, -1)) > 0)] = np.inf
    return Outcome(made, _kept(costs, square, _lost(study, frames, misfit[:few]), share), method, presses, amounts)


def _kept(costs: Costs, square: FloatArray, lost: float, share: float) -> ErrorsKept:
    each = np.quantile(costs.spread(square), share, axis=(0, 1), method="higher")
    return ErrorsKept(lost=lost, **dict(zip(costs.study.told, each.tolist(), strict=True)))


def _lost(study: Study, frames: FloatArray, misfit: FloatArray) -> float:
    """Share of frames (draws, p, a, n) that are not OK, on fingers that believe in `misfit` (draws, n) noises."""
    believed = np.where(misfit.max(axis=1, keepdims=True) < _ALIKE, 1.0, misfit)
    each = [study.share_ok(f.reshape(-1, f.shape[-1]), own) for f, own in zip(frames, believed, strict=True)]
    return float(1 - np.mean(each))
