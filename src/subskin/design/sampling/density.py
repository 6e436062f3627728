"""The pitch of sensors that a wanted attenuation at the Nyquist frequency asks for (memo section 6.0, eq. 26)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import ComplexArray, FloatArray
from ..._frozen import Result
from ...contact import Contact
from ...errors import InvalidValueError
from ...finger import Finger, finger_needed
from ._plane import EndlessLattice, lattice_of
from ._row import EndlessRow

__all__ = ["SensorDensity", "sensor_density"]

_GROWS = 3.0
"""A response that grows by more than this from one long wave to one ten times as long has no largest value."""
_WINDOW, _POSITIONS = 4.0, 32
"""Depths on either side of a contact where the largest reading is looked for, and positions per depth."""
_BLOCK = 1 << 22
_SPARSER = {"row": 1.0, "square": 1.0, "hexagonal": 2 / np.sqrt(3)}
"""Pitch times the Nyquist wavenumber over pi; and, on an area, sensors per area times the pitch squared."""


@dataclass(frozen=True, eq=False)
class SensorDensity(Result):
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

    def relative(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """Size of what is read of waves of `wavenumber` [rad/m], over the largest, shape (..., l).

        On an area in the direction in which most is read.
        """
        k = _check.real("wavenumber", wavenumber, unit="rad/m", at_least=0.0)
        flat = k.reshape(-1)
        if self.lattice == "row":
            sizes = np.abs(EndlessRow(self.finger, self.contact).arriving(flat))
        else:
            sizes = EndlessLattice(self.finger).sizes(np.maximum(flat, 1e-12))
        return _check.read_only((sizes / self.largest).reshape(*k.shape, -1))

    def rate(self, speed: float) -> FloatArray:
        """Samples per second [Hz] with which one sensor that slides at `speed` [m/s] is as good as the row."""
        return _check.read_only(abs(_check.scalar("speed", speed, unit="m/s")) / self.pitch)


def sensor_density(
    finger: Finger,
    attenuation: npt.ArrayLike = 1e3,
    *,
    contact: Contact | None = None,
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
    finger_needed(finger)
    wanted = _check.real("attenuation", attenuation, above=1.0)
    kind = lattice_of(finger, lattice)
    if kind != "row":
        if contact is not None:
            seen, rule = f"a {type(contact).__name__} over a {kind} lattice", "on an area the worst case is found"
            raise InvalidValueError(seen, rule, "leave out contact; aliasing_error takes one")
        return _on_area(EndlessLattice.of(finger, sensor), wanted, kind)
    row = EndlessRow.of(finger, sensor, contact)
    k = row.waves(float(wanted.max(initial=2.0)))
    waves = row.arriving(k)
    sizes, scales = np.abs(waves), _full_scale(row, k, waves)
    ratios = wanted.reshape(-1)
    nyquist = np.empty((2, ratios.size, 2))
    peak, largest = np.empty(2), np.empty(2)
    for load in (0, 1):
        if not sizes[:, load].any():
            name = ("pressure", "shear")[load]
            raise InvalidValueError(
                f"a sensor at {row.depth:.6g} m", f"it reads nothing of a {name}", "another depth or transducer"
            )
        own = sizes[:, load]
        peak[load], largest[load] = _summit(row, k, own, load)
        nyquist[0, :, load] = [_crossing(row, k, own, largest[load] / ratio, load) for ratio in ratios]
        errors = row.beyond(k, own) / scales[load]
        nyquist[1, :, load] = [_fallen(row, k, errors, 1 / ratio) for ratio in ratios]
    pitches = (np.pi / nyquist).reshape(2, *wanted.shape, 2)
    return _density(row.finger, contact, wanted, pitches, peak, largest, "row")


def _on_area(sensors: EndlessLattice, wanted: FloatArray, lattice: str) -> SensorDensity:
    """The density of a lattice of sensors."""
    from scipy.optimize import brentq

    k = sensors.waves(float(wanted.max(initial=2.0)))
    sizes, scales = sensors.sizes(k), sensors.full_scale()
    ratios = wanted.reshape(-1)
    nyquist, peak, largest = np.empty((2, ratios.size, 3)), np.empty(3), np.empty(3)
    for load in range(3):
        own = sizes[:, load]
        at = int(np.argmax(own))
        if not own[at] > 1e-12 * sizes.max():
            name = ("pressure", "drag along y", "drag along z")[load]
            raise InvalidValueError(
                f"a sensor at {sensors.depth:.6g} m", f"it reads nothing of a {name}", "another depth or transducer"
            )
        fine = np.linspace(k[max(at - 1, 0)], k[min(at + 1, k.size - 1)], 257)
        near = sensors.sizes(fine)[:, load]
        peak[load], largest[load] = fine[near.argmax()], near.max()
        if at == 0:  # long waves are read most; without bound, if those ten times as long are read more
            unbounded = own[0] > _GROWS * sensors.sizes(10 * k[:1])[0, load]
            peak[load], largest[load] = (np.nan, np.nan) if unbounded else (0.0, own[0])
        errors = sensors.beyond(k, own) / scales[load]
        for i, ratio in enumerate(ratios):
            nyquist[0, i, load] = nyquist[1, i, load] = np.nan
            level = largest[load] / ratio
            if not np.isnan(level):
                last = int(np.flatnonzero(own > level)[-1])
                nyquist[0, i, load] = brentq(
                    lambda one, level=level, load=load: float(sensors.sizes(np.array([one]))[0, load]) - level,
                    k[last], k[last + 1], xtol=1e-13 * k[last + 1],
                )  # fmt: skip
            nyquist[1, i, load] = _reached(k, errors, 1 / ratio)
    pitches = (np.pi * _SPARSER[lattice] / nyquist).reshape(2, *wanted.shape, 3)
    return _density(sensors.finger, None, wanted, pitches, peak, largest, lattice)


def _density(
    finger: Finger,
    contact: Contact | None,
    wanted: FloatArray,
    pitches: FloatArray,
    peak: FloatArray,
    largest: FloatArray,
    lattice: str,
) -> SensorDensity:
    by_size, by_error, peak, largest = (_check.read_only(a) for a in (*pitches, peak, largest))
    return SensorDensity(finger, contact, wanted, by_size, by_error, peak, largest, lattice)


def _size(row: EndlessRow, k: float, load: int) -> float:
    return float(np.abs(row.arriving(np.array([k]))[0, load]))


def _full_scale(row: EndlessRow, k: FloatArray, waves: ComplexArray) -> FloatArray:
    """Largest reading along the skin under the pressure alone and under the shear alone, shape (2,)."""
    reach = row.half_width + _WINDOW * row.depth
    positions = row.centre + np.linspace(-reach, reach, 2 * int(np.ceil(_POSITIONS * reach / row.depth)) + 1)
    if turn := row.finger.skin.curvature:
        weights = np.where(k == 0, 0.5, 1.0) * turn / np.pi
    else:
        steps = np.diff(k, prepend=0.0)
        weights = 0.5 * (steps + np.append(steps[1:], 0.0)) / np.pi
    found, size = np.zeros(2), max(1, _BLOCK // k.size)
    for i in range(0, positions.size, size):
        part = np.exp(1j * np.outer(positions[i : i + size], k)) @ (weights[:, None] * waves)
        found = np.maximum(found, np.abs(part.real).max(axis=0))
    return found


def _summit(row: EndlessRow, k: FloatArray, sizes: FloatArray, load: int) -> tuple[float, float]:
    """Where the response is largest, and how large; NaN where it grows without bound towards long waves."""
    from scipy.optimize import minimize_scalar

    at = int(np.argmax(sizes))
    if row.finger.skin.curvature:
        return float(k[at]), float(sizes[at])
    if at == 0:
        unbounded = sizes[0] > _GROWS * _size(row, 10 * k[0], load)
        return (np.nan, np.nan) if unbounded else (0.0, float(sizes[0]))
    ends = (k[at - 1], k[min(at + 1, k.size - 1)])
    found = minimize_scalar(
        lambda wave: -_size(row, wave, load), bounds=ends, method="bounded", options={"xatol": 1e-9 * ends[1]}
    )
    return float(found.x), -float(found.fun)


def _crossing(row: EndlessRow, k: FloatArray, sizes: FloatArray, level: float, load: int) -> float:
    """The Nyquist wavenumber beyond which the response stays below `level`."""
    from scipy.optimize import brentq

    if np.isnan(level):
        return np.nan
    at = int(np.flatnonzero(sizes > level)[-1])
    if turn := row.finger.skin.curvature:
        return _between(turn, k[at])
    root = brentq(lambda wave: _size(row, wave, load) - level, k[at], k[at + 1], xtol=1e-13 * k[at + 1])
    return float(root)


def _fallen(row: EndlessRow, k: FloatArray, errors: FloatArray, level: float) -> float:
    """The Nyquist wavenumber at which the falling `errors` reach `level`."""
    if turn := row.finger.skin.curvature:
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
