"""What a calibration from unlabelled touches says: each number before and after, and what no touch can determine."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..estimate.estimate import Estimate
from ..finger import Finger
from ._learning import Learning
from .calibration import Fitted, Health, Parameter

__all__ = ["BlindCalibration", "BlindParameter", "ErrorRatio", "Known"]

_LEARNT, _DRAWN = 0.5, 0.95
_SURPRISE = 4.0
_MISFIT = 1.5
_MOST_LEFT_OUT = 0.3


class Known(IntEnum):
    """Where a number of the finger is known from."""

    AS_DRAWN = 0
    """The touches said next to nothing: its standard deviation is more than 0.95 of the prior's."""
    PARTLY = 1
    """In between."""
    LEARNT = 2
    """Half of what touches can remove of the prior's standard deviation is gone, or more."""


@dataclass(frozen=True, kw_only=True)
class BlindParameter(Parameter):
    """A fitted number of a `BlindCalibration`, before and after; the rest is as of a `Parameter`.

    Parameters
    ----------
    drawn, prior : float
        The value as drawn, and the standard deviation given for it [`unit`].
    limit : float
        The standard deviation that endless touches would leave [`unit`], 0 where they leave none.
    """

    drawn: float
    prior: float
    limit: float

    @property
    def known(self) -> Known:
        """Whether the touches taught it."""
        if self.std > _DRAWN * self.prior:
            return Known.AS_DRAWN
        # of variances: what may be learnt of a gain is not its share in the common scale
        left, most = self.std**2 - self.limit**2, self.prior**2 - self.limit**2
        return Known.LEARNT if left <= _LEARNT**2 * most else Known.PARTLY


@dataclass(frozen=True)
class ErrorRatio:
    """RMS errors over those that a finger known exactly makes.

    Parameters
    ----------
    position : float
        Ratio for positions [-], up to what no touches can determine: a common shift, on an area a turn, on a half plane
        or half space a scale.
    angle : float
        Ratio for angles [-], on an area for directions of the force; NaN where loads are normal.
    """

    position: float
    angle: float


@dataclass(frozen=True, eq=False, repr=False)
class BlindCalibration(Fitted):
    """What `calibrate_blind` found.

    Parameters
    ----------
    finger : Finger
        The finger with the values found; its noise is `misfit` times as large as drawn, dead sensors have gain 0.
    parameters : tuple of BlindParameter
        Every fitted number.
    covariance : ndarray, shape (k, k)
        Covariance of the k parameters, in the units of each, given the readings and the drawing.
    touches : Estimate
        Each touch on the finger found, shape (m,).
    used : ndarray of bool, shape (m,)
        Which touches were used: those that are OK, with readings of enough sensors.
    health : tuple of Health
        State of each sensor.
    misfit : float
        Ratio of the residuals to what the noise explains, >= 1: more than that, the model does not fit.
    steady : bool
        Whether locating the touches and fitting the finger, in turns, came to rest.
    unknown : tuple of str
        What no number of touches of this kind can determine, and is held as drawn: the null directions of the Fisher
        information. On an area a moment of the touches too, which is held at none.
    """

    finger: Finger
    parameters: tuple[BlindParameter, ...]
    covariance: FloatArray
    touches: Estimate
    used: npt.NDArray[np.bool_]
    health: tuple[Health, ...]
    misfit: float
    steady: bool
    unknown: tuple[str, ...]
    _learning: Learning = field(repr=False)

    def _title(self) -> str:
        return f"BlindCalibration on {int(self.used.sum())} of {self.used.size} touches: {self._sensors()}"

    @property
    def rank(self) -> int:
        """How many of the fitted numbers touches of this kind determine, alone or combined."""
        return len(self.parameters) - int(self._learning.null.shape[1])

    def std(self, touches: float) -> FloatArray:
        """Standard deviation of each parameter after `touches` of this kind in all, shape (k,)."""
        count = _check.scalar("touches", touches, at_least=0.0, finite=False)
        return _check.read_only(self._learning.std(count))

    def touches_for(self, parameter: int, std: float) -> float:
        """How many touches of this kind it takes, in all, until a parameter's standard deviation is at most `std`.

        It falls as the root of their number, from the prior's down to `limit`. Infinite where that is above `std`.

        Parameters
        ----------
        parameter : int
            Index of one of `parameters`.
        std : float
            Standard deviation that is wanted, in its units of the parameter.

        Raises
        ------
        InvalidValueError
            No such parameter, a `std` that is not > 0.
        """
        parameter = _check.whole(
            "parameter", parameter, at_least=0, at_most=len(self.parameters) - 1, fix="parameter=0"
        )
        wanted = _check.scalar("std", std, above=0.0, unit=self.parameters[parameter].unit)
        return self._learning.touches_for(parameter, wanted)

    def error_ratio(self, touches: float | None = None) -> ErrorRatio:
        """What the uncertain finger makes of errors in locating, after `touches` of this kind or those there were.

        By propagation of the covariance; for loads that are spread as those used here.
        """
        count = None if touches is None else _check.scalar("touches", touches, at_least=0.0, finite=False)
        return ErrorRatio(*self._learning.error_ratio(count))

    def touches_for_ratio(self, ratio: float = 1.3) -> float:
        """How many touches of this kind, in all, until both of `error_ratio` are at most `ratio`.

        Raises
        ------
        InvalidValueError
            A ratio that is not > 1, which no number of touches reaches.
        """
        return self._learning.touches_for_ratio(_check.scalar("ratio", ratio, above=1.0))

    @property
    def doubts(self) -> tuple[str, ...]:
        """What these touches leave open or speak against, a sentence each; beside `unknown`."""
        said = []
        if self.misfit > _MISFIT:
            said.append(
                f"residuals are {self.misfit:.3g} times the noise: the model does not fit, and standard deviations "
                "may be too small"
            )
        if not self.steady:
            said.append("the touches used and the finger still changed each other in the last round")
        out = int((~self.used).sum())
        if out > _MOST_LEFT_OUT * self.used.size:
            said.append(f"{out} of {self.used.size} touches were left out")
        unlearnt: dict[str, dict[str, float]] = {}
        for i, p in enumerate(self.parameters):
            off = abs(p.value - p.drawn) / p.prior
            if off > _SURPRISE:
                said.append(
                    f"{p.called} is {off:.1f} standard deviations from the drawing: allow it a larger error, or check "
                    "the sensors"
                )
            if p.known is Known.AS_DRAWN and p.limit < _DRAWN * p.prior:
                half = np.sqrt(p.limit**2 + _LEARNT**2 * (p.prior**2 - p.limit**2))
                unlearnt.setdefault(p.name, {})[p.called] = self.touches_for(i, half)
        for touches in unlearnt.values():
            names, most = tuple(touches), max(touches.values())
            listed = names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
            said.append(f"as drawn: {listed}; {_count(most)} touches like those used would determine them")
        return tuple(said)


def _count(touches: float) -> str:
    return "more than 10^15" if np.isinf(touches) else f"about {float(f'{touches:.2g}'):,.0f}"
