"""What a calibration says: each fitted number with its error, each sensor's health, and how well it all fits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .. import _check
from .._axes import on_finger, turned
from .._check import FloatArray
from .._frozen import Frozen
from .._shown import Tabled, many_of, parameter_rows
from ..errors import GeometryError, InvalidValueError
from ..finger import Finger
from ._forward import Forward
from .uncertainty import Misfit

__all__ = [
    "FEWEST_SPARE", "WEAK_SHARE", "Calibration", "Fitted", "Health", "Parameter", "Score", "checked_readings",
    "checked_touches", "score", "weak",
]  # fmt: skip

WEAK_SHARE, WEAK_SIGMA = 0.5, 2.0
"""Gain, as a share of the median's, below which a sensor is weak."""
FEWEST_SPARE = 2
"""Spare readings that a sensor, or a frame, needs before a misfit is noticed: one may fit by chance."""
_WILD = 1e100
"""A reading whose square is no float any more, with the sums that a fit takes of it."""
_SPANS = 100.0
"""Extents of the sensors that touches may span."""
_PLACES = ("origin", "origin_y", "origin_z", "turn")
_LOOSE, _LOST, _HOPELESS, _TIED = 0.1, 0.5, 10, 0.95

_SPANNED, _TOLD = 0.5, 0.9
"""Share of the sensors' span, and R^2, from which touches show the order of the sensors."""


class Health(IntEnum):
    """What a calibration says of a sensor."""

    OK = 0
    WEAK = 1
    """Its gain is below half of the median of its kind; in `SensorHealth`, it has also lost a tenth or more."""
    DEAD = 2
    """Its gain is zero within its error and its readings do not move, or it gave none; the finger leaves it out."""


@dataclass(frozen=True)
class Parameter:
    """A fitted number of a `Calibration`.

    Parameters
    ----------
    name : str
        What it is.
    sensor : int or None
        Whose; None where it holds for the whole finger.
    value, std : float
        The number and its standard error [`unit`].
    unit : str
        Unit of both; empty for numbers without a unit and for readings.
    at_end : bool
        Whether it lies at an end of the range that was searched; its standard error then says little.
    """

    name: str
    sensor: int | None
    value: float
    std: float
    unit: str
    at_end: bool = False

    @property
    def called(self) -> str:
        """Its name, with the sensor's number."""
        return self.name if self.sensor is None else f"{self.name} of sensor {self.sensor}"


@dataclass(frozen=True, eq=False)
class Score(Frozen):
    """How well a finger explains touches at known positions.

    Parameters
    ----------
    r2 : float
        1 - residual / variance about each sensor's mean [-], over all live sensors.
    r2_sensor, residual_std : ndarray, shape (n,)
        The same of each sensor [-], and the standard deviation of its residuals [reading]; NaN for a dead one.
    touches : int
        Number of touches.
    """

    r2: float
    r2_sensor: FloatArray
    residual_std: FloatArray
    touches: int


class Fitted(Tabled, Frozen):
    """A finger and what was fitted of it, which is shown as a table."""

    finger: Finger
    parameters: tuple[Parameter, ...]
    health: tuple[Health, ...]

    _HEADS = ("parameter", "sensor", "value")

    def _shown(self) -> list[tuple[str, str, str]]:
        return parameter_rows(self.parameters)

    def _sensors(self) -> str:
        return f"sensors {many_of(Counter(h.name for h in self.health).items())}"


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Fitted):
    """What `calibrate` found.

    Parameters
    ----------
    finger : Finger
        The finger with the fitted values; its noise is the residuals' standard deviation, and no less than it was
        before; dead sensors have gain 0. Where residuals are no noise it has a `spread`, measured on touches held out.
    origin : float, or ndarray of shape (2,)
        Where the finger's y = 0 lies on the motor's axis [m]: y = position - origin. On an area where its (0, 0) lies.
    parameters : tuple of Parameter
        Every fitted number with its standard error.
    covariance : ndarray, shape (k, k)
        Covariance of the k parameters, in the units of each: the inverse Fisher information, larger where
        residuals of neighbouring touches are correlated. A parameter of which the touches say nothing has an infinite
        variance.
    health : tuple of Health
        State of each sensor.
    score : Score
        On the touches used.
    spare : int
        Readings more than fitted numbers.
    misfit : Misfit
        What is left unexplained, and whether it is noise.
    force, angle : ndarray, shape (m,)
        Load of each touch [N/m], [rad].
    held_out : (int, int)
        Positions of touches held out, each twice, by which the finger's `spread` was measured: those that are OK, of
        straight and of leaning loads; 0 where they were too few, or residuals are noise.
    turn : float
        On an area, by how much the finger's y lies turned from the motor's, towards z [rad].
    left_out : tuple of (int, int)
        Readings, each by its touch and sensor, that are so far off what all others say that they were left out.
    load : {"line", "point"}
        What pressed.
    tells_order : bool
        Whether the touches show which way round the sensors are: the model explains them, and they span half of the
        sensors and more. Sensors in reversed order, mirrored or swapped would read them otherwise (`orient`).
    """

    finger: Finger
    origin: Any
    parameters: tuple[Parameter, ...]
    covariance: FloatArray
    health: tuple[Health, ...]
    score: Score
    spare: int
    misfit: Misfit
    force: FloatArray
    angle: FloatArray
    held_out: tuple[int, int] = (0, 0)
    turn: float = 0.0
    left_out: tuple[tuple[int, int], ...] = ()
    load: Literal["line", "point"] = "line"
    tells_order: bool = False

    @property
    def r2(self) -> float:
        """R^2 on the touches used."""
        return self.score.r2

    def _title(self) -> str:
        points = " by points on the row" if self.load == "point" and not self.finger.array.on_area else ""
        return f"Calibration on {self.score.touches} touches{points}: R^2 {self.r2:.5f}; {self._sensors()}"

    @property
    def weak(self) -> npt.NDArray[np.bool_]:
        """Which sensors are weak or dead, shape (n,)."""
        return np.array([h != Health.OK for h in self.health])

    @property
    def doubts(self) -> tuple[str, ...]:
        """What these touches do not determine of the finger: a sentence each.

        First, readings that were left out. Then too few spare readings: fewer than fitted numbers, or than two for each
        sensor. Then what has come to the end of its range; and, from the Fisher information, gains that are not known
        to a half, numbers of the whole finger whose standard error exceeds a tenth of them, and pairs of these that are
        hardly separable (correlation above 0.95).
        """
        whole = [i for i, p in enumerate(self.parameters) if p.sensor is None and p.name not in _PLACES]
        said = [
            f"the reading of sensor {i} at touch {t} is far off what all others say, and is left out"
            for t, i in self.left_out
        ]
        live = int(self.finger.array.live.sum())
        if self.spare < max(len(self.parameters), FEWEST_SPARE * live):
            said.append(
                f"too few touches to check the fit: {self.spare} spare readings for {len(self.parameters)} fitted "
                f"numbers and {live} sensors; R^2 and standard errors say little"
            )
        made = any(p.name == "gain" for p in self.parameters)
        if made and self.finger.spread is not None and not any(self.held_out):
            said.append("too few touches to hold some out: how far positions are off is not measured")
        said += [f"{p.called} is at the end of its range ({p.value:.4g} {p.unit}".rstrip() + ")" for p in self.ends]
        said += [
            f"{p.called} is not determined: its standard error is {_share(p)}"
            for p in self.parameters
            if p.name == "gain" and not p.std < _LOST * abs(p.value)
        ]
        for i in whole:
            p = self.parameters[i]
            if not p.std < _LOOSE * abs(p.value):
                how = "known only roughly" if p.std < _LOST * abs(p.value) else "not determined"
                said.append(f"{p.name} is {how}: its standard error is {_share(p)}")
        std = np.sqrt(np.diag(self.covariance))
        for n, i in enumerate(whole):
            for j in whole[n + 1 :]:
                known = np.isfinite(std[[i, j]]).all() and std[i] > 0 and std[j] > 0
                r = float(self.covariance[i, j] / (std[i] * std[j])) if known else 0.0
                if abs(r) > _TIED:
                    one, two = self.parameters[i].name, self.parameters[j].name
                    alone = np.sqrt(1 - min(abs(r), 1.0) ** 2)
                    said.append(
                        f"{one} and {two} are hardly separable (correlation {r:.3f}): were one of them known, the "
                        f"other's standard error would be {alone:.2g} times as large"
                    )
        return tuple(said)

    @property
    def ends(self) -> tuple[Parameter, ...]:
        """The parameters that have come to an end of the range in which they are looked for."""
        return tuple(p for p in self.parameters if p.at_end)

    def spare_readings(self, friction: float = 1.0) -> int:
        """How many readings of a frame can speak against a single load: live sensors less the load's unknowns.

        With fewer than two, `locate` answers OK to nearly anything. `friction` as in `Finger.locate`: with 0 a load has
        one unknown less, two on an area.
        """
        d = 2 if self.finger.array.on_area else 1
        return int(self.finger.array.live.sum()) - (d + 1 if _check.friction(friction) == 0 else 2 * d + 1)

    def on_finger(self, positions: npt.ArrayLike) -> FloatArray:
        """Positions of the motor as they lie on the finger [m].

        Parameters
        ----------
        positions : array_like, shape (...) or (..., 2)
            On the motor's axis, or axes (y, z) [m].

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(4, pitch=6e-3, depth=5e-3))
        >>> positions = np.linspace(0, 30e-3, 16)
        >>> found = ss.calibrate(finger, finger.read(ss.LineLoad(1.0, position=positions - 15e-3)), positions)
        >>> round(float(found.on_finger(16e-3)) * 1e3, 3)
        1.0
        """
        return on_finger(positions, self.origin, self.turn)

    def evaluate(
        self,
        readings: npt.ArrayLike,
        positions: npt.ArrayLike,
        *,
        force: npt.ArrayLike | None = None,
        angle: npt.ArrayLike = 0.0,
        azimuth: npt.ArrayLike = 0.0,
    ) -> Score:
        """The score on touches held out; `readings`, `positions` and the loads as in `calibrate`."""
        loads = (1.0 if force is None else force, angle, azimuth)
        data, y, load = checked_touches(self.finger, readings, positions, *loads)
        if np.ndim(self.origin):
            load = np.column_stack([load[:, :1], load[:, 1:] @ turned(self.turn)])
        y = self.on_finger(y)
        measured = self.finger.measured
        if measured is None:
            points = self.load == "point" and not self.finger.array.on_area
            model = Forward(self.finger, (), points=points).readings(np.empty(0), y, load)
        else:
            model = (measured(y) * load[:, None, : measured.components]).sum(axis=-1) + measured.offset
        return score(data, model, self.finger.array.live)


def tells_order(points: FloatArray, positions: FloatArray, r2: float) -> bool:
    """Whether touches at `positions` (m,) or (m, 2) could not be read so by sensors in another order."""
    touched = np.ptp(positions.reshape(len(positions), -1), axis=0)
    spanned = touched >= _SPANNED * np.ptp(points[:, : touched.size], axis=0)
    return bool(spanned.all() and len(points) > 1 and r2 > _TOLD)


def weak(gain: FloatArray, kinds: Sequence[object], std: FloatArray | float = 0.0) -> npt.NDArray[np.bool_]:
    """Which gains (n,) are below half of the median of their kind, by two standard errors, shape (n,)."""
    size, out = np.abs(gain), np.zeros(len(gain), dtype=bool)
    most = size + WEAK_SIGMA * std
    for kind in set(kinds):
        same = np.array([k == kind for k in kinds])
        out[same] = most[same] < WEAK_SHARE * np.median(size[same])
    return out


def _share(parameter: Parameter) -> str:
    """A standard error as a percentage of the value."""
    ratio = parameter.std / abs(parameter.value) if parameter.value else np.inf
    return f"{100 * ratio:.0f} % of it" if ratio < _HOPELESS else f"more than {_HOPELESS} times the value"


def checked_readings(readings: npt.ArrayLike, sensors: int) -> FloatArray:
    """Readings (m, n), checked; NaN and infinity stay."""
    data = _check.read_only(np.array(_check.readings(readings)))
    if data.ndim != 2 or data.shape[1] != sensors:
        rule = f"one touch a row, one of the {sensors} sensors a column"
        raise GeometryError(f"readings of shape {data.shape}", rule, f"shape (touches, {sensors})")
    wild = np.argwhere(np.isfinite(data) & (np.abs(data) > _WILD))
    if wild.size:
        i, j = wild[0]
        fix = "NaN for a reading that is missing, or leave the touch out"
        raise InvalidValueError(f"readings[{i}, {j}] = {data[i, j]:.6g}", f"no sensor reads more than {_WILD:g}", fix)
    return data


def checked_touches(
    finger: Finger,
    readings: npt.ArrayLike,
    positions: npt.ArrayLike,
    force: npt.ArrayLike,
    angle: npt.ArrayLike,
    azimuth: npt.ArrayLike = 0.0,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Readings (m, n), positions (m,) and loads (N, T) (m, 2), checked; on an area (m, 2) and (N, Ty, Tz) (m, 3)."""
    data = checked_readings(readings, len(finger.array))
    if not len(data):
        raise GeometryError(f"readings of shape {data.shape}", "a finger learns from touches", "a row for each touch")
    y = _check.real("positions", positions, unit="m")
    if finger.array.on_area:
        if y.shape != (len(data), 2):
            rule = f"the sensors are on an area: one position (y, z) for each of the {len(data)} touches"
            raise GeometryError(f"positions of shape {y.shape}", rule, f"shape ({len(data)}, 2)")
    elif _check.real("azimuth", azimuth, unit="rad").any():
        rule = "a row of sensors knows loads along it: angle says how they lean"
        raise GeometryError(f"azimuth = {_check.shown(azimuth)}", rule, "leave it out")
    elif y.shape != data.shape[:1]:
        seen = f"positions of shape {y.shape}"
        raise GeometryError(seen, f"one position for each of the {len(data)} touches", f"shape ({len(data)},)")
    _refuse_span(finger, y)
    p = _check.for_each("force", _check.real("force", force, unit="N/m", at_least=0.0), len(data), "touch")
    a = _check.for_each("angle", _check.real("angle", angle, unit="rad"), len(data), "touch")
    usable = np.where(finger.array.inside(data), data, np.nan)
    if finger.array.on_area:
        b = _check.for_each("azimuth", _check.real("azimuth", azimuth, unit="rad"), len(data), "touch")
        return usable, y, np.stack([p * np.cos(a), p * np.sin(a) * np.cos(b), p * np.sin(a) * np.sin(b)], axis=-1)
    return usable, y, np.stack([p * np.cos(a), p * np.sin(a)], axis=-1)


def _refuse_span(finger: Finger, positions: FloatArray) -> None:
    """Refuse positions that span so many arrays that they are millimetres, taken for metres."""
    array, span = finger.array, float(np.ptp(positions, axis=0).max())
    size = float(np.ptp(array.points, axis=0).max()) + 2 * float(np.asarray(array.depth).max())
    if span > _SPANS * size:
        seen = f"touches over {span:.6g} m, by sensors over {size:.6g} m"
        rule = f"touches a finger feels lie within {_SPANS:g} times its sensors; in mm these would span {span:.6g} mm"
        fix = 'positions in m (1e-3 * positions); for segment, [recording] position = {column = "x", unit = "mm"}'
        raise InvalidValueError(seen, rule, fix)


def score(data: FloatArray, model: FloatArray, live: npt.NDArray[np.bool_]) -> Score:
    """Compare readings and model, both (m, n), on the sensors that are alive; NaN readings do not count."""
    residual = data - model
    count = np.isfinite(data).sum(axis=0)
    seen = live & (count > 0)
    r2, std = np.full(live.size, np.nan), np.full(live.size, np.nan)
    rest = np.nansum(residual**2, axis=0)
    mean = np.nansum(data, axis=0) / np.maximum(count, 1)
    spread = np.nansum((data - mean) ** 2, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        r2[seen] = 1 - rest[seen] / spread[seen]
        std[seen] = np.sqrt(rest[seen] / count[seen])
        total = 1 - rest[seen].sum() / spread[seen].sum()
    return Score(float(total), _check.read_only(r2), _check.read_only(std), len(data))
