"""The pitch that a wanted attenuation asks for (memo section 6.0, eq. 26), and the samples that sliding adds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Fix, Real, Ruled, checked
from ...array import SensorArray
from ...contact import Contact
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from .._common import Found, index_of
from ._endless import EndlessLattice, EndlessRow, lattice_of

__all__ = ["SensorDensity", "SlidingSamples", "sensor_density", "sliding_samples"]

_GROWS = 3.0
"""A response that grows by more than this from one long wave to one ten times as long has no largest value."""
_NOTHING = 1e-12
"""Share of the largest reading below which a load is not read at all."""
_SPARSER = {"row": 1.0, "square": 1.0, "hexagonal": 2 / np.sqrt(3)}
"""Pitch times the Nyquist wavenumber over pi; and, on an area, sensors per area times the pitch squared."""


Sensors: TypeAlias = EndlessRow | EndlessLattice
_Speed: TypeAlias = Annotated[float, Real("m/s")]


@dataclass(frozen=True, eq=False)
class SensorDensity(Found):
    """What `sensor_density` found, for attenuations of shape (...); the last axis is the component of the load.

    In a row these are the normal and the tangential load, l = 2; on an area N, Ty and Tz, l = 3.

    Attributes
    ----------
    finger : Finger
        The skin, with the one sensor that the row repeats, at y = 0.
    contact : Contact or None
        What presses; None for the worst case.
    attenuation : ndarray, shape (...)
        As wanted [-].
    pitch : ndarray, shape (..., l)
        Largest pitch of the sensors [m]; NaN where the response to long waves has no bound.
    error_pitch : ndarray, shape (..., l)
        Largest pitch at which no reading recovered between the sensors can be off by more than full scale /
        attenuation [m]: the bound of `aliasing_error`. Full scale is the largest reading under the contact; without
        one, under a line load; on an area under a point load.
    peak : ndarray, shape (l,)
        Wavenumber at which most is read [rad/m].
    largest : ndarray, shape (l,)
        What is read there: per Pa in the worst case, else times the contact's pressure spectrum [N/m].
    lattice : str
        How the sensors lie: "row", "square" or "hexagonal".
    """

    finger: Finger
    contact: Contact | None
    attenuation: FloatArray
    pitch: FloatArray
    error_pitch: FloatArray
    peak: FloatArray
    largest: FloatArray
    lattice: str = "row"

    @property
    def density(self) -> FloatArray:
        """Sensors per metre, [1/m], shape (..., l), the memo's s in s d > 3.2; on an area per area [1/m^2]."""
        return _check.read_only(1 / self.pitch if self.lattice == "row" else _SPARSER[self.lattice] / self.pitch**2)

    @property
    def nyquist(self) -> FloatArray:
        """Wavenumber from which on all is attenuated [rad/m], shape (..., l)."""
        return _check.read_only(np.pi * _SPARSER[self.lattice] / self.pitch)

    @checked
    def relative(self, wavenumber: Annotated[npt.ArrayLike, Real("rad/m", at_least=0.0)]) -> FloatArray:
        """Size of what is read of waves of `wavenumber` [rad/m], over the largest, shape (..., l).

        On an area in the direction in which most is read.
        """
        k = np.asarray(wavenumber)
        flat = k.reshape(-1)
        if self.lattice == "row":
            sizes = EndlessRow(self.finger, self.contact).sizes(flat)
        else:
            sizes = EndlessLattice(self.finger).sizes(np.maximum(flat, 1e-12))
        return _check.read_only((sizes / self.largest).reshape(*k.shape, -1))

    @checked
    def rate(self, speed: _Speed) -> FloatArray:
        """Samples per second [Hz] with which one sensor that slides at `speed` [m/s] is as good as the row."""
        return _check.read_only(abs(speed) / self.pitch)


@checked
def sensor_density(
    finger: Finger,
    attenuation: Annotated[npt.ArrayLike, Real(above=1.0)] = 1e3,
    *,
    contact: Annotated[Contact | None, Ruled(lambda _, contact: contact)] = None,
    sensor: int = 0,
    lattice: Literal["row", "square", "hexagonal"] | None = None,
) -> SensorDensity:
    """How closely sensors have to lie for the continuous reading to be recovered from theirs.

    A row of equal sensors `pitch` apart samples the reading along the skin. Waves shorter than two pitches, beyond
    the Nyquist wavenumber pi / pitch, appear as longer ones. Wanted is that all of these are down by `attenuation`
    from the wave that is read most: abs(P H) beyond the Nyquist wavenumber against its own largest value, H being the
    response of skin and sensor and P the pressure's spectrum. All waves beyond count, not only the one at the Nyquist
    wavenumber, which may be one that a contact happens not to contain. Normal and tangential load are taken one by one,
    each against its own largest value; the shear has the shape of the pressure.

    Without a `contact` all waves are pressed alike, as by a line load: the worst case, and the memo's. For a half plane
    with nu = 1/2 and normal strain at depth d that is f exp(1 - f) = 1 / attenuation with f = k d, and density times
    depth is f / pi: 3.2574 for 1000, where the memo's eq. (26) has 3.2 (`subskin.memo.eq26_corrected`). This number is
    no error of the reading; `aliasing_error` finds that one. On a round finger a whole number of sensors goes round.

    On an area waves run in all directions, and what a lattice tells apart is its first zone. Wanted is that all waves
    outside a circle within it are down by `attenuation`, K being their wavenumber in the direction in which most is
    read: sensors on a square lattice are then pi / K apart, on a hexagonal one 2 pi / (sqrt(3) K), which takes 13.4 %
    fewer. Pressure and both drags are taken one by one (docs/density.md).

    Parameters
    ----------
    finger : Finger
        Any skin, any transducer that is linear or has a linear part.
    attenuation : array_like, shape (...)
        Wanted ratio, > 1.
    contact : Contact, optional
        What presses; its force and position do not matter. Not on an area, where the worst case is found.
    sensor : int, optional
        Which sensor of the finger is repeated.
    lattice : {"row", "square", "hexagonal"}, optional
        How the sensors lie; as those of the finger do if left out.

    Raises
    ------
    InvalidValueError
        An attenuation that is not > 1; a sensor that is not there, or reads nothing; a lattice on a skin that is solved
        in a plane, or with a contact.
    GeometryError
        A batch of contacts, or one thousands of depths wide.
    NotLinearError
        A transducer that has no linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.5))
    >>> finger = ss.Finger(skin, ss.SensorArray(y=[0.0], depth=2e-3))
    >>> found = ss.design.sensor_density(finger, [10, 1000])
    >>> (found.density[:, 0] * 2e-3).round(4).tolist()
    [1.5564, 3.2574]
    >>> roller = ss.Hertz(force=40.0, half_width=2e-3)
    >>> round(float(ss.design.sensor_density(finger, contact=roller).pitch[0]) * 1e3, 2)
    0.95

    On an area, of barometers that read pressure: sensors in a square of the depth.

    >>> space = ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.5))
    >>> pad = ss.Finger(space, ss.SensorArray(y=[0.0], depth=2e-3, transducer=ss.MeanPressure()))
    >>> for lattice in ("square", "hexagonal"):
    ...     found = ss.design.sensor_density(pad, 1000, lattice=lattice)
    ...     print(round(float(found.density[0]) * 2e-3**2, 2))
    4.83
    4.19
    """
    wanted = np.asarray(attenuation)
    kind = lattice_of(finger, lattice)
    if kind != "row" and contact is not None:
        seen, rule = f"a {type(contact).__name__} over a {kind} lattice", "on an area the worst case is found"
        raise InvalidValueError(seen, rule, "leave out contact; aliasing_error takes one")
    sensors: Sensors
    sensors = EndlessRow.of(finger, sensor, contact) if kind == "row" else EndlessLattice.of(finger, sensor)
    k, ratios = sensors.waves(float(wanted.max(initial=2.0))), wanted.reshape(-1)
    sizes, scales = sensors.surveyed(k)
    nyquist, peak, largest = np.empty((2, ratios.size, len(scales))), np.empty(len(scales)), np.empty(len(scales))
    for load, name in enumerate(sensors.loads):
        own = sizes[:, load]
        if not own.max() > _NOTHING * sizes.max():
            seen, fix = f"a sensor at {sensors.depth:.6g} m", "another depth or transducer"
            raise InvalidValueError(seen, f"it reads nothing of a {name}", fix)
        peak[load], largest[load] = _summit(sensors, k, own, load)
        nyquist[0, :, load] = [_crossing(sensors, k, own, largest[load] / ratio, load) for ratio in ratios]
        errors = sensors.beyond(k, own) / scales[load]
        nyquist[1, :, load] = [_fallen(sensors, k, errors, 1 / ratio) for ratio in ratios]
    by_size, by_error = (np.pi * _SPARSER[kind] / nyquist).reshape(2, *wanted.shape, len(scales))
    return SensorDensity(sensors.finger, contact, wanted, by_size, by_error, peak, largest, kind)


def _size(sensors: Sensors, k: float, load: int) -> float:
    return float(sensors.sizes(np.array([k]))[0, load])


def _summit(sensors: Sensors, k: FloatArray, sizes: FloatArray, load: int) -> tuple[float, float]:
    """Where the response is largest, and how large; NaN where it grows without bound towards long waves."""
    from scipy.optimize import minimize_scalar

    at = int(np.argmax(sizes))
    if sensors.finger.skin.curvature:
        return float(k[at]), float(sizes[at])
    if at == 0:
        unbounded = sizes[0] > _GROWS * _size(sensors, 10 * k[0], load)
        return (np.nan, np.nan) if unbounded else (0.0, float(sizes[0]))
    ends = (k[at - 1], k[min(at + 1, k.size - 1)])
    found = minimize_scalar(
        lambda wave: -_size(sensors, wave, load), bounds=ends, method="bounded", options={"xatol": 1e-9 * ends[1]}
    )
    return float(found.x), -float(found.fun)


def _crossing(sensors: Sensors, k: FloatArray, sizes: FloatArray, level: float, load: int) -> float:
    """The Nyquist wavenumber beyond which the response stays below `level`."""
    from scipy.optimize import brentq

    if np.isnan(level):
        return np.nan
    at = int(np.flatnonzero(sizes > level)[-1])
    if turn := sensors.finger.skin.curvature:
        return _between(turn, k[at])
    root = brentq(lambda wave: _size(sensors, wave, load) - level, k[at], k[at + 1], xtol=1e-13 * k[at + 1])
    return float(root)


def _fallen(sensors: Sensors, k: FloatArray, errors: FloatArray, level: float) -> float:
    """The Nyquist wavenumber at which the falling `errors` reach `level`."""
    if turn := sensors.finger.skin.curvature:
        return _between(turn, k[int(np.flatnonzero(errors > level)[-1])])
    return _reached(k, errors, level)


def _reached(k: FloatArray, errors: FloatArray, level: float) -> float:
    """Where falling errors, far apart in size, reach a level."""
    at = int(np.flatnonzero(errors > level)[-1])
    share = np.log(errors[at] / level) / np.log(errors[at] / errors[at + 1])
    return float(k[at] + share * (k[at + 1] - k[at]))


def _between(turn: float, k: float) -> float:
    """The Nyquist wavenumber of 2 n + 1 sensors round a finger: these tell n waves and fewer apart."""
    return float((np.round(k / turn) + 0.5) * turn)


_SAME = 1e-9
"""Samples closer than this share of a step lie at one position."""


@dataclass(frozen=True, eq=False)
class SlidingSamples(Found):
    """What `sliding_samples` found.

    Attributes
    ----------
    step : float
        How far the skin slides from one frame to the next [m].
    distance : float
        How far it slides in all [m].
    position : ndarray, shape (m,)
        Different positions sampled on the stretch that every sensor passes over, one step of it [m], ascending.
    visits : float
        Mean number of samples at each of these positions: more than 1 where sensors follow in others' tracks.
    pitch : float
        The widest gap between neighbouring positions [m]: what the row's pitch is to be replaced by.
    mean_pitch : float
        Step over the number of positions [m]; smaller than `pitch` where samples come in bunches.
    noise_gain : float
        Noise of the readings recovered between the samples over that of as many samples spaced evenly, if all waves up
        to pi / mean_pitch are recovered [-]: 1 for even samples, large for bunches.
    """

    step: float
    distance: float
    position: FloatArray
    visits: float
    pitch: float
    mean_pitch: float
    noise_gain: float


@checked
def sliding_samples(
    array: Annotated[SensorArray, Fix("finger.array")],
    speed: _Speed,
    rate: Annotated[float, Real("Hz", above=0.0)],
    *,
    sensor: int = 0,
) -> SlidingSamples:
    """Where on a thing that slides past the sensors sample it.

    In frame j a sensor at y samples the thing at y + j speed / rate, a step further on each time. One sensor samples
    one position a step; n sensors sample n, where their positions differ once whole steps are taken off. Sensors a
    whole number of steps apart follow in each other's tracks, and add nothing but a mean of their noise. Sensors count
    that are like the one named: of its depth, width and transducer. This takes for granted that the thing slides over
    the whole row and one step more, without sticking and without turning, at a force that stays; and that the speed is
    known: one wrong by a share e puts a sample e times the way slid off its position.

    Parameters
    ----------
    array : SensorArray
        The row.
    speed : float
        Speed of the object along the skin [m/s], not 0.
    rate : float
        Frames per second [Hz], > 0.
    sensor : int, optional
        The sensor whose like are counted.

    Raises
    ------
    InvalidValueError
        A speed of 0, a rate that is not > 0, a sensor that is not there.
    GeometryError
        A sensor that is dead, and so are its like.

    Examples
    --------
    Four sensors 1 mm apart and a step of 0.8 mm: every 0.2 mm is sampled.

    >>> import subskin as ss
    >>> row = ss.SensorArray.line(count=4, pitch=1e-3, depth=2e-3)
    >>> found = ss.design.sliding_samples(row, speed=0.08, rate=100.0)
    >>> round(found.pitch * 1e3, 6), round(found.noise_gain, 6)
    (0.2, 1.0)
    """
    if speed == 0:
        raise InvalidValueError("speed = 0 m/s", "what does not slide adds no samples", "speed=0.05")
    sensor = index_of(array, sensor)
    kinds = [
        (kind.linear_part, float(depth), float(width))
        for kind, depth, width in zip(array.transducers, np.asarray(array.depth), np.asarray(array.width), strict=True)
    ]
    alike = np.array([kind == kinds[sensor] for kind in kinds]) & array.live
    if not alike.any():
        raise GeometryError(f"sensor {sensor}", "it is dead, of gain 0, and so are its like", "name another")
    y = np.asarray(array.y)[alike]
    step = abs(speed) / rate
    rest = np.sort(np.mod(y - y.max(), step) / step)
    rest = np.sort(np.where(rest > 1 - _SAME, 0.0, rest))
    rest = rest[np.concatenate([[True], np.diff(rest) > _SAME])]
    gaps = np.diff(np.concatenate([rest, [rest[0] + 1]]))
    # waves that the step alone confuses, told apart by the positions in it; evenly spaced, these are a Fourier matrix
    waves = np.exp(2j * np.pi * np.outer(rest, np.arange(rest.size))) / np.sqrt(rest.size)
    gain = float(np.sqrt((np.abs(np.linalg.inv(waves)) ** 2).sum() / rest.size))
    position = y.max() + step * rest
    widest, mean = step * float(gaps.max()), step / rest.size
    return SlidingSamples(step, float(np.ptp(y)) + step, position, y.size / rest.size, widest, mean, noise_gain=gain)
