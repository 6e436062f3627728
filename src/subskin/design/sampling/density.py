"""The pitch of sensors that a wanted attenuation at the Nyquist frequency asks for (memo section 6.0, eq. 26)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import ComplexArray, FloatArray
from ..._frozen import Frozen
from ...contact import Contact
from ...errors import InvalidValueError
from ...finger import Finger
from ._row import EndlessRow

__all__ = ["SensorDensity", "sensor_density"]

_GROWS = 3.0
"""A response that grows by more than this from one long wave to one ten times as long has no largest value."""
_WINDOW, _POSITIONS = 4.0, 32
"""Depths on either side of a contact where the largest reading is looked for, and positions per depth."""
_BLOCK = 1 << 22


@dataclass(frozen=True, eq=False)
class SensorDensity(Frozen):
    """What `sensor_density` found, for attenuations of shape (...); the last axis is the normal, the tangential load.

    Attributes
    ----------
    finger : Finger
        The skin, with the one sensor that the row repeats, at y = 0.
    contact : Contact or None
        What presses; None for the worst case.
    attenuation : ndarray, shape (...)
        As wanted [-].
    pitch : ndarray, shape (..., 2)
        Largest pitch of the sensors [m]; NaN where the response to long waves has no bound.
    error_pitch : ndarray, shape (..., 2)
        Largest pitch at which no reading recovered between the sensors can be off by more than full scale /
        attenuation [m]: the bound of `aliasing_error`. Full scale is the largest reading under the contact; without
        one, under a line load.
    peak : ndarray, shape (2,)
        Wavenumber at which most is read [rad/m].
    largest : ndarray, shape (2,)
        What is read there: per Pa in the worst case, else times the contact's pressure spectrum [N/m].
    """

    finger: Finger
    contact: Contact | None
    attenuation: FloatArray
    pitch: FloatArray
    error_pitch: FloatArray
    peak: FloatArray
    largest: FloatArray

    @property
    def density(self) -> FloatArray:
        """Sensors per metre, 1 / pitch [1/m], shape (..., 2); the memo's s in s d > 3.2."""
        return _check.read_only(1 / self.pitch)

    @property
    def nyquist(self) -> FloatArray:
        """Wavenumber pi / pitch from which on all is attenuated [rad/m], shape (..., 2)."""
        return _check.read_only(np.pi / self.pitch)

    def relative(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """Size of what is read of waves of `wavenumber` [rad/m], over the largest, shape (..., 2)."""
        k = _check.real("wavenumber", wavenumber, unit="rad/m", at_least=0.0)
        row = EndlessRow(self.finger, self.contact)
        flat = k.reshape(-1)
        sizes = np.abs(row.arriving(flat)) / self.largest
        return _check.read_only(sizes.reshape(*k.shape, 2))

    def rate(self, speed: float) -> FloatArray:
        """Samples per second [Hz] with which one sensor that slides at `speed` [m/s] is as good as the row."""
        return _check.read_only(abs(_check.scalar("speed", speed, unit="m/s")) / self.pitch)


def sensor_density(
    finger: Finger, attenuation: npt.ArrayLike = 1e3, *, contact: Contact | None = None, sensor: int = 0
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

    Parameters
    ----------
    finger : Finger
        Any skin, any transducer that is linear or has a linear part.
    attenuation : array_like, shape (...)
        Wanted ratio, > 1.
    contact : Contact, optional
        What presses; its force and position do not matter.
    sensor : int, optional
        Which sensor of the finger is repeated.

    Raises
    ------
    InvalidValueError
        An attenuation that is not > 1; a sensor that is not there, or reads nothing.
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
    """
    wanted = _check.real("attenuation", attenuation, above=1.0)
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
    arrays = [_check.read_only(a) for a in (*pitches, peak, largest)]
    return SensorDensity(row.finger, contact, wanted, *arrays)


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
    at = int(np.flatnonzero(errors > level)[-1])
    if turn := row.finger.skin.curvature:
        return _between(turn, k[at])
    share = np.log(errors[at] / level) / np.log(errors[at] / errors[at + 1])
    return float(k[at] + share * (k[at + 1] - k[at]))


def _between(turn: float, k: float) -> float:
    """The Nyquist wavenumber of 2 n + 1 sensors round a finger: these tell n waves and fewer apart."""
    return float((np.round(k / turn) + 0.5) * turn)
