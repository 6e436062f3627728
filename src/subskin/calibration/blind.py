"""Unlabelled touches -> the finger's gains, depth, sensors' positions: no motor, no balance, readings alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Annotated, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Positive, Real, checked
from ..errors import GeometryError, InvalidValueError, NotLinearError
from ..estimate.area.search import search_of
from ..estimate.estimate import Estimate
from ..estimate.frames import check_noise
from ..finger import Finger, finger_needed
from ..response import tabulate
from ._blind_model import TERMS, UnknownTouch
from ._blind_rounds import Rounds
from ._forward import checked_names
from ._learning import Learning
from .calibration import WEAK_SHARE, Fitted, Health, Parameter, checked_readings

__all__ = ["BlindCalibration", "BlindParameter", "ErrorRatio", "Known", "calibrate_blind"]

_Count: TypeAlias = Annotated[float, Real(at_least=0.0, finite=False)]

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

    @checked
    def std(self, touches: _Count) -> FloatArray:
        """Standard deviation of each parameter after `touches` of this kind in all, shape (k,)."""
        return _check.read_only(self._learning.std(touches))

    @checked
    def touches_for(self, parameter: int, std: Positive) -> float:
        """How many touches of this kind it takes, in all, until a parameter's standard deviation is at most `std`.

        It falls as the root of their number, from the prior's down to `limit`. Infinite where that is above `std`.

        Parameters
        ----------
        parameter : int
            Index of one of `parameters`.
        std : float
            Standard deviation that is wanted, in its units of the parameter.
        """
        parameter = _check.whole(
            "parameter", parameter, at_least=0, at_most=len(self.parameters) - 1, fix="parameter=0"
        )
        return self._learning.touches_for(parameter, std)

    @checked
    def error_ratio(self, touches: _Count | None = None) -> ErrorRatio:
        """What the uncertain finger makes of errors in locating, after `touches` of this kind or those there were.

        By propagation of the covariance; for loads that are spread as those used here.
        """
        return ErrorRatio(*self._learning.error_ratio(touches))

    @checked
    def touches_for_ratio(self, ratio: Annotated[float, Real(above=1.0)] = 1.3) -> float:
        """How many touches of this kind, in all, until both of `error_ratio` are at most `ratio`."""
        return self._learning.touches_for_ratio(ratio)

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


_TORSION = "a moment of a touch about the normal: there is taken to be none"


def calibrate_blind(
    finger: Finger,
    readings: npt.ArrayLike,
    *,
    fit: Sequence[str] = ("gain", "depth", "position"),
    gain_error: npt.ArrayLike = 0.05,
    depth_error: npt.ArrayLike = 0.05,
    position_error: npt.ArrayLike = 0.02,
    poisson_error: float | None = None,
    thickness_error: float | None = None,
    offset_error: npt.ArrayLike | None = None,
    friction: float = 1.0,
    half_width: float = 0.0,
    search: tuple[float, float] | tuple[tuple[float, float], tuple[float, float]] | None = None,
) -> BlindCalibration:
    """Fit a finger to touches of which only the readings are known.

    Each touch is a line load of its own position, normal and tangential force; on an area a load on a point (y, z) with
    its (N, Ty, Tz). With one sensor more than unknowns, every touch also says something about the finger. All touches
    and the finger are estimated at once (maximum a posteriori, Gaussian priors about the finger as drawn). After each
    round touches are located again, over the whole of `search`, and touches that are not OK are left out.

    Parameters
    ----------
    finger : Finger
        As drawn; its sensors' noise has to be known. What is not fitted is kept, but for a response measured in place.
    readings : array_like, shape (m, n)
        One touch a row, tared; NaN where a sensor gave none.
    fit : sequence of str, optional
        Any of "gain" (each sensor's), "depth" (one shift of all), "depths" (each sensor's), "position" (each sensor's
        along the row, on an area along y and z), "poisson" (of a skin of one material), "thickness" (of a skin of one
        layer), "offset" (each sensor's).
    gain_error, depth_error, position_error, poisson_error, thickness_error, offset_error : float, optional
        Standard deviation of what is as drawn. Gains: a share of each. Depth and position: shares of the mean depth.
        Thickness: a share of what lies beneath the deepest sensor. Poisson's ratio: itself. Offset: in readings. The
        last three have no default. A number of each sensor may be given for each sensor.
    friction : float, optional
        Touches lean at most by atan(friction). 0: they press straight down, and have one unknown less.
    half_width : float, optional
        Half width of every touch [m]: a Hertz contact, long or round; 0 for a line or a point. A wrong one bends depths
        and lengths and may pass without a misfit.
    search : (float, float) or ((float, float), (float, float)), optional
        Where touches are looked for, y [m], on an area y and z; the default reaches 1.5 depths beyond the outermost
        sensors. Touches at its ends are left out: the array itself leaves out those beyond it.

    Returns
    -------
    BlindCalibration

    Raises
    ------
    InvalidValueError, GeometryError
        Unknown names in `fit`, an error that is missing or not > 0, a sensor without noise, shapes that do not match;
        on an area, live sensors on one straight line.
    NotLinearError
        A transducer that is not linear.
    ConvergenceError
        Too few sensors or touches for what is to be found.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin, rng = ss.HalfPlane(ss.Material(young=0.4e6)), np.random.default_rng(0)
    >>> row = {"pitch": 1.5e-3, "depth": 2e-3, "noise": 5e-5}
    >>> drawn = ss.Finger(skin, ss.SensorArray.line(6, **row))
    >>> real = ss.Finger(skin, ss.SensorArray.line(6, gain=[1.05, 0.97, 1.02, 0.94, 1.03, 0.99], **row))
    >>> loads = ss.LineLoad(rng.uniform(50, 200, 200), rng.uniform(-0.6, 0.6, 200), rng.uniform(-4e-3, 4e-3, 200))
    >>> found = ss.calibrate_blind(drawn, real.read(loads, rng))
    >>> ratio = np.asarray(found.finger.array.gain) / np.asarray(real.array.gain)
    >>> bool(np.ptp(ratio) < 0.01), found.unknown[0]
    (True, 'the common scale of the gains: forces are found up to a factor')
    >>> plate = {"shape": (3, 3), "pitch": 3e-3, "depth": 3e-3, "transducer": ss.MeanPressure(), "noise": 20.0}
    >>> tip = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), ss.SensorArray.grid(**plate))
    >>> points = ss.PointLoad(force=rng.uniform(0.5, 2, 40), position=rng.uniform(-3e-3, 3e-3, (40, 2)))
    >>> found = ss.calibrate_blind(tip, tip.read(points, rng), friction=0)
    >>> found.rank, len(found.parameters), found.touches.position.shape
    (23, 28, (40, 2))
    """
    finger_needed(finger)
    names = checked_names(fit, TERMS, "leave it out: without known positions there is none")
    given = {
        "gain": gain_error, "depth": depth_error, "depths": depth_error, "position": position_error,
        "poisson": poisson_error, "thickness": thickness_error, "offset": offset_error,
    }  # fmt: skip
    shares = {name: _share(name, given[name], len(finger.array)) for name in names}
    mu = _check.friction(friction)
    for kind in finger.array.transducers:
        if not kind.linear:
            seen = f"transducer {type(kind).__name__}"
            rule = "its reading is not proportional to the load, which a calibration without positions needs"
            raise NotLinearError(seen, rule, "a linear transducer, or calibrate at known positions")
    data = checked_readings(readings, len(finger.array))
    fix = "SensorArray(..., noise=1e-4): the spread of readings of the untouched skin"
    check_noise(finger.array, "touches and drawing are weighed by the sensors' noise", fix)
    if finger.array.on_area:
        ends = search_of(finger.array, search)[0]
    else:
        table = tabulate(finger, _check.ends("search", search, "search=(-5e-3, 5e-3)"))
        ends = np.array([[table.start, table.stop]])
    width = _check.scalar("half_width", half_width, unit="m", at_least=0.0)
    return _result(Rounds(finger, data, shares, UnknownTouch(len(ends), mu, width), ends), finger, data)


def _share(name: str, error: npt.ArrayLike | None, n: int) -> FloatArray:
    """A prior's standard deviation as given, one a sensor where it is a sensor's."""
    label = "depth_error" if name == "depths" else f"{name}_error"
    if error is None:
        seen = f"fit has {name}, without {label}"
        raise InvalidValueError(seen, "say how far the drawing can be off", f"{label}=...")
    values = _check.real(label, error, above=0.0)
    shape = (n,) if name in ("gain", "offset", "depths", "position") else ()
    if values.shape not in ((), shape):
        rule = f"one number, or one for each of the {n} sensors, is needed" if shape else "one number is needed"
        raise GeometryError(f"{label} of shape {values.shape}", rule, f"{label}=0.05")
    return np.broadcast_to(values, shape)


def _result(rounds: Rounds, finger: Finger, data: FloatArray) -> BlindCalibration:
    settled, used = rounds.run()
    used.flags.writeable = False
    model, live, factor = rounds.model, np.flatnonzero(rounds.live), rounds.factor
    fitted = model.finger(settled.x)
    whole, part = finger.array, fitted.array
    names = ("y", "z", "depth", "gain", "offset", "noise")
    fields: dict[str, Any] = {name: np.array(getattr(whole, name)) for name in names}
    fields["gain"][:] = 0.0
    for name in names[:-1]:
        fields[name][live] = np.asarray(getattr(part, name))
    change = fields["gain"][live] / np.asarray(whole.gain)[live]
    found = replace(finger, skin=fitted.skin, array=replace(whole, **fields), measured=None)
    touches = rounds.locate(found, np.asarray(data))
    fields["noise"][live] *= factor
    health = [Health.DEAD] * len(whole)
    for i, ratio in zip(live, change, strict=True):
        health[i] = Health.WEAK if ratio < WEAK_SHARE * np.median(change) else Health.OK
    learning = Learning(model, settled.x, settled.near, factor)
    sensors = {None: None} | dict(enumerate(live.tolist()))
    rows = zip(
        model.reported(np.zeros(model.size)),
        np.sqrt((model.turn(np.zeros(model.size)) ** 2).sum(axis=1)),
        model.reported(settled.x),
        learning.std(),
        learning.std(np.inf),
        strict=True,
    )
    parameters = tuple(
        BlindParameter(name, sensors[i], value, float(std), unit, drawn=drawn, prior=float(prior), limit=float(limit))
        for (name, i, drawn, unit), prior, (_, _, value, _), std, limit in rows
    )
    return BlindCalibration(
        finger=replace(found, array=replace(whole, **fields)),
        parameters=parameters,
        covariance=_check.read_only(learning.turn @ learning.covariance() @ learning.turn.T),
        touches=touches,
        used=used,
        health=tuple(health),
        misfit=factor,
        steady=rounds.steady,
        unknown=learning.unknown([p.called for p in parameters]) + (_TORSION,) * (model.dim == 2),
        _learning=learning,
    )
