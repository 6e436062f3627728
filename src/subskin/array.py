"""Where the sensors are and how each turns what it measures into a reading."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from ._declared import Noun, Real, Ruled
from ._presets import SENSORS, named
from ._shown import Presets
from .errors import GeometryError, InvalidValueError
from .lattice import LaidOut, named_layout
from .transducer import MeanPressure, NormalStrain, Transducer

__all__ = ["SensorArray"]

_KIND = "transducer=MeanPressure()"


def _kinds(name: str, given: Any) -> Transducer | tuple[Transducer, ...]:
    """One transducer for all sensors, or one for each."""
    return given if isinstance(given, Transducer) else _check.several(name, given, Transducer, _KIND)


_AIR = 101_325.0
"""The standard atmosphere [Pa]: what a barometer reads where nothing presses."""


_WIDEST = 50.0  # depths


@dataclass(frozen=True, eq=False)
class SensorArray(LaidOut, Noun):
    """Sensors in the skin, in a row or on an area.

    A sensor reads gain * (the quantity of its transducer, averaged over its width) + lift * (the normal force) + offset
    + noise, held within [low, high] and rounded to its resolution. Each parameter is one number for all sensors, or one
    for each sensor. Several sensors may stand at one position: the channels of one device.

    Parameters
    ----------
    y : array_like, shape (n,)
        Positions along the surface [m].
    depth : array_like
        Depths [m], > 0.
    transducer : Transducer or sequence of Transducer, optional
        What each measures.
    gain : array_like, optional
        Reading per unit measured [reading/unit]. 0 marks a dead sensor: it is left out of every estimate.
    offset : array_like, optional
        Reading of the untouched skin [reading].
    noise : array_like, optional
        Standard deviation of a reading [reading], >= 0.
    width : array_like, optional
        Width along y over which the quantity is averaged [m], >= 0.
    low, high : array_like, optional
        Range of a reading [reading]; at either end the sensor is saturated.
    resolution : array_like, optional
        Step to which a reading is rounded [reading], >= 0; 0 for none.
    z : array_like, optional
        Positions across y [m]; 0 for a row, which is all that a skin of a plane takes.
    lift : array_like, optional
        What a load adds to the reading wherever it presses, per unit of its normal force [reading/(N/m), on an area
        reading/N]: of a skin whose field does not fade as the model's does. `calibrate` fits it to presses.

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; parameters that do not match the number of sensors.

    Examples
    --------
    >>> array = SensorArray.line(count=4, pitch=6e-3, depth=5e-3, noise=1e-4)
    >>> len(array), (array.y * 1e3).round(6).tolist()
    (4, [-9.0, -3.0, 3.0, 9.0])
    >>> SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3).points.shape
    (16, 2)
    """

    y: Annotated[npt.ArrayLike, Real("m")]
    depth: Annotated[npt.ArrayLike, Real("m", above=0.0, fix="depth is measured into the skin")]
    transducer: Annotated[Transducer | Sequence[Transducer], Ruled(_kinds)] = field(default_factory=NormalStrain)
    gain: npt.ArrayLike = 1.0
    offset: npt.ArrayLike = 0.0
    noise: Annotated[npt.ArrayLike, Real(at_least=0.0)] = 0.0
    width: Annotated[npt.ArrayLike, Real("m", at_least=0.0)] = 0.0
    low: Annotated[npt.ArrayLike, Real(finite=False)] = -np.inf
    high: Annotated[npt.ArrayLike, Real(finite=False)] = np.inf
    resolution: Annotated[npt.ArrayLike, Real(at_least=0.0)] = 0.0
    z: Annotated[npt.ArrayLike, Real("m")] = 0.0
    lift: npt.ArrayLike = 0.0

    EXAMPLE: ClassVar = "SensorArray.line(count=4, pitch=6e-3, depth=5e-3)"

    def __post_init__(self) -> None:
        super().__post_init__()
        own = self.__dict__
        own["y"] = y = np.atleast_1d(own["y"])
        if y.ndim != 1 or not y.size:
            rule = "one position a sensor is needed, shape (n,)"
            raise GeometryError(f"y of shape {y.shape}", rule, "y=[-1e-3, 1e-3]")
        for name, values in self._numbers().items():
            if values.shape not in ((), (1,), y.shape):
                seen, rule = f"{name} of shape {values.shape}", f"one value, or one for each of the {y.size} sensors,"
                raise GeometryError(seen, f"{rule} is needed", f"{name}=[...] with {y.size} values")
            own[name] = np.broadcast_to(values, y.shape)
        wide, deep = np.asarray(self.width), np.asarray(self.depth)
        if (wide > _WIDEST * deep).any():
            worst = int(np.argmax(wide / deep))
            seen = f"width = {wide[worst]:.6g} m at a depth of {deep[worst]:.6g} m"
            raise InvalidValueError(seen, f"a sensor may be up to {_WIDEST:g} depths wide", "several sensors")
        if not (np.asarray(self.low) < np.asarray(self.high)).all():
            raise InvalidValueError(f"low = {self.low}, high = {self.high}", "low has to be < high", "swap them")
        one = self.transducer
        each = (one,) * y.size if isinstance(one, Transducer) else one
        if len(each) != y.size:
            rule = f"one Transducer, or one for each of the {y.size} sensors, is needed"
            raise GeometryError(f"transducer = {_check.shown(one)}", rule, _KIND)
        own["transducer"] = each
        if self.lifted and not all(kind.linear for kind in self.transducers):
            rule = "what a load adds is known of sensors whose readings are proportional to it"
            raise InvalidValueError(f"lift = {_check.shown(self.lift)}", rule, "lift=0.0, or another transducer")
        ends = np.isfinite(np.array([self.low, self.high]))
        own["_limited"] = bool(ends.any() or np.any(np.asarray(self.resolution)))

    def _numbers(self) -> dict[str, FloatArray]:
        """What is a number of each sensor."""
        return {f.name: self.__dict__[f.name] for f in fields(self) if f.name != "transducer"}

    def __add__(self, other: object) -> SensorArray:
        """The sensors of both, first those of the one, then those of the other."""
        if not isinstance(other, SensorArray):
            return NotImplemented
        each = other._numbers()
        both = {name: np.concatenate([values, each[name]]) for name, values in self._numbers().items()}
        return SensorArray(transducer=(*self.transducers, *other.transducers), **both)

    @staticmethod
    def preset(name: str) -> dict[str, Any]:
        """What a barometer or a gauge in the skin is to `SensorArray`: transducer, noise, range and offset.

        A barometer's offset is the air's pressure. A gauge reads the strain along the depth.

        `SensorArray.presets()` lists them, with their sources.

        Parameters
        ----------
        name : str
            E.g. "BMP280", "HX711 80 Hz".

        Raises
        ------
        InvalidValueError
            A name that is not known.

        Examples
        --------
        >>> array = SensorArray.line(count=4, pitch=6e-3, depth=5e-3, **SensorArray.preset("LPS25HB"))
        >>> float(array.noise[0]), array.transducers[0], float(array.high[0])
        (1.0, MeanPressure(), 126000.0)
        >>> SensorArray.preset("HX711 80 Hz")["high"]
        0.008
        """
        found = named(name, SENSORS, "sensor")
        gauge = found.unit == "strain"
        reads = {"transducer": NormalStrain() if gauge else MeanPressure(), "offset": 0.0 if gauge else _AIR}
        return {**reads, "noise": found.noise, "low": found.low, "high": found.high}

    @staticmethod
    def presets() -> Presets:
        """The barometers and gauges that `preset` knows: noise and range of a reading [unit], source; a table.

        Examples
        --------
        >>> SensorArray.presets()["MS5611"]["noise"]
        1.2
        """
        columns = ("noise", "low", "high", "unit", "source")
        return Presets({name: {c: getattr(found, c) for c in columns} for name, found in SENSORS.items()}, {})

    def __len__(self) -> int:
        return len(np.asarray(self.y))

    def __repr__(self) -> str:
        y, depth = np.asarray(self.y), np.unique(np.asarray(self.depth))
        kinds = ", ".join(dict.fromkeys(repr(kind) for kind in self.transducers))
        deep = " to ".join(f"{x:.4g}" for x in dict.fromkeys((depth[0], depth[-1])))
        where = f"y = {y.min():.4g} to {y.max():.4g} m"
        if self.on_area:
            z = np.asarray(self.z)
            where = self.layout or f"{where}, z = {z.min():.4g} to {z.max():.4g} m"
        return f"SensorArray({len(self)} sensors, {kinds}, {where}, depth = {deep} m)"

    @property
    def points(self) -> FloatArray:
        """Positions (y, z) of the sensors [m], shape (n, 2)."""
        return _check.read_only(np.stack([np.asarray(self.y), np.asarray(self.z)], axis=-1))

    @cached_property
    def on_area(self) -> bool:
        """Whether some sensor stands beside the row z = 0."""
        return bool(np.any(self.z))

    def refuse_area(self) -> None:
        """Refuse sensors on an area for what is solved in a plane.

        Raises
        ------
        GeometryError
            Some sensor stands beside the row z = 0.
        """
        if self.on_area:
            seen = f"sensors on an area ({self.layout or f'{len(self)} at (y, z)'})"
            rule = "this is solved in a plane and takes sensors in a row, at z = 0"
            raise GeometryError(
                seen, rule, "finger.locate, finger.fit and finger.observable take them, or SensorArray.line(...)"
            )

    def refuse_offset(self) -> None:
        """Refuse offsets of what reads differences from the free skin.

        Raises
        ------
        InvalidValueError
            Some sensor has an offset.
        """
        offset = np.asarray(self.offset)
        if offset.any():
            seen = f"offset = {offset[np.argmax(np.abs(offset))]:.6g} of a finger that reads differences"
            rule = "differences have no offset: what presses add to them is the lift, and goes with their force"
            fix = 'calibrate again with lift: --fit gain,lift,depth,origin, or fit=("gain", "lift", "depth", "origin")'
            raise InvalidValueError(seen, rule, fix)

    @property
    def layout(self) -> str:
        """What a person calls where they are, "4 x 4 grid, pitch 3 mm"; "" where they are not set out evenly."""
        return named_layout(np.asarray(self.y), np.asarray(self.z))

    @cached_property
    def transducers(self) -> tuple[Transducer, ...]:
        """The transducer of each sensor."""
        return tuple(self.transducer) if not isinstance(self.transducer, Transducer) else (self.transducer,)

    @cached_property
    def live(self) -> npt.NDArray[np.bool_]:
        """Which sensors have a gain, shape (n,); a dead one has gain 0."""
        live = np.asarray(np.asarray(self.gain) != 0)
        live.flags.writeable = False
        return live

    @cached_property
    def lifted(self) -> bool:
        """Whether some live sensor has a lift."""
        return bool(np.any(np.asarray(self.lift)[self.live]))

    def select(self, sensors: npt.ArrayLike) -> SensorArray:
        """Some of the sensors as an array of their own.

        Parameters
        ----------
        sensors : array_like
            Indices of the sensors, or a mask of shape (n,).

        Examples
        --------
        >>> SensorArray.line(count=4, pitch=6e-3, depth=5e-3).select([0, 2]).y.tolist()
        [-0.009000000000000001, 0.003]
        """
        index = _check.of_sensors(sensors, len(self))
        if np.array_equal(index, np.arange(len(self))):
            return self
        chosen = {name: values[index] for name, values in self._numbers().items()}
        return replace(self, transducer=tuple(self.transducers[i] for i in index), **chosen)

    def digitise(
        self, measured: FloatArray, rng: np.random.Generator | None = None, normal_force: npt.ArrayLike = 0.0
    ) -> FloatArray:
        """Readings from measured quantities: gain, lift, offset, noise, range, resolution, in this order.

        Parameters
        ----------
        measured : ndarray, shape (..., n)
            What the transducers measure [`unit` of each].
        rng : numpy.random.Generator, optional
            Adds each sensor's noise; without it there is none.
        normal_force : array_like, shape (...), optional
            Of the load under which this is measured [N/m or N]: each sensor's `lift` adds to the reading.

        Returns
        -------
        ndarray, shape (..., n)
            In the unit of the readings.

        Raises
        ------
        InvalidValueError, GeometryError
            What is no number; another number of values than sensors.

        Examples
        --------
        >>> array = SensorArray(y=[0.0, 1e-3], depth=2e-3, gain=10.0, offset=1.0, high=5.0, resolution=0.5)
        >>> array.digitise([0.13, 0.6]).tolist()
        [2.5, 5.0]
        """
        _check.generator(rng)
        values = _check.readings(measured, "measured")
        if values.shape[-1:] != (len(self),):
            rule = f"(..., {len(self)}) is needed, a value for each sensor"
            raise GeometryError(f"measured of shape {values.shape}", rule, "finger.measure(contact)")
        readings: FloatArray = np.asarray(self.gain) * values + np.asarray(self.offset)
        if self.lifted:
            loads = _check.real("normal_force", normal_force, finite=False)[..., None]
            _check.broadcast(measured=values, normal_force=loads)
            readings = readings + np.asarray(self.lift) * loads
        if rng is not None:
            readings = readings + np.asarray(self.noise) * rng.standard_normal(readings.shape)
        if not self.__dict__["_limited"]:
            return readings
        step, low, high = (np.asarray(limit) for limit in (self.resolution, self.low, self.high))
        rounded = np.round(readings / np.where(step > 0, step, 1.0)) * step
        # what lies beyond the range reads as its end, be that a multiple of the resolution or not
        within = (readings > low) & (readings < high)
        return np.asarray(np.clip(np.where(within & (step > 0), rounded, readings), low, high))

    def usable(self, readings: FloatArray) -> npt.NDArray[np.bool_]:
        """Which `readings`, shape (..., n), can be used: finite, within the range, of a live sensor.

        Examples
        --------
        >>> array = SensorArray(y=[0.0, 1e-3, 2e-3, 3e-3], depth=2e-3, gain=[0.0, 1.0, 1.0, 1.0], high=5.0)
        >>> array.usable(np.array([1.0, 1.0, np.nan, 5.0])).tolist()
        [False, True, False, False]
        """
        return np.asarray(self.inside(readings) & self.live)

    def inside(self, readings: FloatArray) -> npt.NDArray[np.bool_]:
        """Which `readings`, shape (..., n), are finite and within the range, be the sensor live or not."""
        readings = _check.readings(readings)
        if readings.shape[-1:] != (len(self),):
            rule = f"the last axis has to be the {len(self)} sensors"
            raise GeometryError(f"readings of shape {readings.shape}", rule, f"shape (frames, {len(self)})")
        within = (readings > np.asarray(self.low)) & (readings < np.asarray(self.high))
        return np.asarray(within & np.isfinite(readings))
