"""The error that sensors make between them: of a row sampled, joined again and compared; of a lattice by its waves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, overload

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._declared import Length, checked
from ...contact import Contact, LocalContact
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from .._common import Found, Several
from ._endless import EndlessLattice, EndlessRow, lattice_of

__all__ = ["AliasingError", "LatticeError", "aliasing_error"]

_BEYOND = 15.0
"""Depths beyond the contact up to which every sample counts in full; further out the readings are smooth."""
_TAPER, _REACH = 8.0, 6.0
"""Width of the taper at the end of the row, in samples, and how many of these it takes to fall to nothing."""
_DENSEST = 0.02
_WINDOW = 4.0
"""Depths on either side of the contact in which the error is looked for."""
_STEPS = 16
_DEEP = 1e6
"""Attenuation up to which the spectrum is followed beyond the Nyquist wavenumber."""
_BLOCK = 1 << 22

Lattice: TypeAlias = Literal["row", "square", "hexagonal"] | None


@dataclass(frozen=True, eq=False)
class AliasingError(Found):
    """What `aliasing_error` found, m positions along the skin and p shifts of the row.

    Attributes
    ----------
    finger : Finger
        The skin, with the one sensor that the row repeats, at y = 0.
    contact : Contact
    pitch : float
        Pitch of the sensors [m].
    position : ndarray, shape (m,)
        Positions along the skin [m].
    reading : ndarray, shape (m,)
        What a sensor there would read [its unit].
    shift : ndarray, shape (p,)
        How far the row is shifted [m]: sensors at shift + j pitch, from the contact's centre.
    error : ndarray, shape (p, m)
        Reading recovered from the row's samples, less the true one.
    full_scale : float
        Largest size of a reading anywhere [its unit].
    bound : float
        No error is larger, whatever the shift: 2 / pi times the integral of the spectrum's size beyond the Nyquist
        wavenumber, over `full_scale`.
    at_nyquist : float
        Largest spectral value beyond the Nyquist wavenumber over the largest at all [-]: 1 / attenuation, the memo's
        measure.
    """

    finger: Finger
    contact: Contact
    pitch: float
    position: FloatArray
    reading: FloatArray
    shift: FloatArray
    error: FloatArray
    full_scale: float
    bound: float
    at_nyquist: float

    @property
    def largest(self) -> float:
        """Largest error, over all positions and shifts, in shares of the full scale."""
        return float(np.abs(self.error).max()) / self.full_scale

    @property
    def rms(self) -> float:
        """Root mean square over the shifts where it is largest, in shares of the full scale."""
        return float(np.sqrt((self.error**2).mean(axis=0)).max()) / self.full_scale


@dataclass(frozen=True, eq=False)
class LatticeError(Found):
    """What `aliasing_error` found of a lattice on an area; of a contact, or of tractions that are white.

    Attributes
    ----------
    finger : Finger
        The skin, with the one sensor that the lattice repeats, at (0, 0).
    contact : LocalContact or None
        What presses; None for pressure and drags along y and along z that hold all waves alike.
    lattice : str
        "square" or "hexagonal".
    pitch : float
        Pitch of the sensors [m].
    beyond : float or ndarray, shape (3,)
        Root mean square of what is read of waves beyond the first zone, over that within it [-]; without a contact of
        the pressure and of each drag.
    """

    finger: Finger
    contact: LocalContact | None
    lattice: str
    pitch: float
    beyond: FloatArray

    @property
    def rms(self) -> FloatArray:
        """Root mean square error of the readings recovered between the sensors, over that of the readings [-].

        Over all positions, and all shifts of the lattice: the waves beyond the first zone are missing, and others are
        taken for them, so it is the root of 2 b^2 / (1 + b^2), b being `beyond`.
        """
        return _check.read_only(np.sqrt(2 / (1 + self.beyond**2)) * self.beyond)


@overload
def aliasing_error(
    finger: Finger,
    contact: Contact,
    pitch: float | None = None,
    *,
    sensor: int = 0,
    shifts: int = 16,
    lattice: Lattice = None,
) -> AliasingError: ...
@overload
def aliasing_error(
    finger: Finger,
    contact: LocalContact | None = None,
    pitch: float | None = None,
    *,
    sensor: int = 0,
    shifts: int = 16,
    lattice: Lattice = None,
) -> LatticeError: ...
@checked
def aliasing_error(
    finger: Finger,
    contact: Any = None,
    pitch: Length | None = None,
    *,
    sensor: int = 0,
    shifts: Several = 16,
    lattice: Lattice = None,
) -> AliasingError | LatticeError:
    """What is lost between sensors: their samples joined by sinc functions, against the true reading.

    The row has no end, and is free of noise. It is shifted through one pitch, for a contact can press anywhere
    between two sensors. The error has two halves, the short waves that are missing and the longer ones for which they
    are taken, so it is at most twice the spectrum's integral beyond the Nyquist wavenumber: the bound. What is
    recovered here is the reading between the sensors, of a contact of which nothing is known. A contact of known shape
    has a few unknowns, and a few sensors find them (docs/locating.md).

    On an area, or with a `lattice` named, the error is worked out of the waves beyond the lattice's first zone, as a
    root mean square over all positions and shifts: of a contact, or without one of pressure and drags that are white.

    Parameters
    ----------
    finger : Finger
        Any skin, any transducer that is linear or has a linear part.
    contact : Contact
        A single one; pressure and shear as given. On an area a local one, or none.
    pitch : float, optional
        Pitch of the sensors [m]; the finger's own where its sensors are evenly spaced. On a round finger the next
        smaller one of which a whole number goes round.
    sensor : int, optional
        Which sensor of the finger is repeated.
    shifts : int, optional
        Number of shifts of the row, >= 2; of no account on an area.
    lattice : {"row", "square", "hexagonal"}, optional
        How the sensors lie; as those of the finger do if left out.

    Returns
    -------
    AliasingError or LatticeError
        The latter of a lattice on an area.

    Raises
    ------
    InvalidValueError
        A row without a contact; a lattice on a skin that is solved in a plane; a pitch below a fiftieth of the depth,
        too few shifts, a sensor that is not there or reads nothing.
    GeometryError
        A batch of contacts; no pitch, and a finger whose sensors have none.
    NotLinearError
        A transducer that has no linear part.

    Examples
    --------
    The memo's density, under a line load: the error is a little less than one part in a thousand of the peak.

    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.5))
    >>> finger = ss.Finger(skin, ss.SensorArray(y=[0.0], depth=2e-3))
    >>> found = ss.design.aliasing_error(finger, ss.LineLoad(force=40.0), pitch=2e-3 / 3.2574)
    >>> f"{found.at_nyquist:.2e} {found.largest:.2e} {found.bound:.2e}"
    '1.00e-03 8.08e-04 8.08e-04'

    On an area, of strain along the depth: what is read beyond the first zone over what is read within it.

    >>> space = ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.5))
    >>> pad = ss.Finger(space, ss.SensorArray(y=[0.0], depth=2e-3))
    >>> found = ss.design.aliasing_error(pad, pitch=1e-3, lattice="square")
    >>> found.beyond.round(3).tolist()
    [0.027, 0.04, 0.04]
    """
    kind = lattice_of(finger, lattice)
    if kind != "row":
        return _lattice_error(finger, contact, pitch, sensor=sensor, lattice=kind)
    if not isinstance(contact, Contact):
        seen, rule = f"contact = {contact!r} over a row", "a long contact is needed"
        raise InvalidValueError(seen, rule, 'Hertz(force=40.0, half_width=2e-3), or lattice="square"')
    row = EndlessRow.of(finger, sensor, contact)
    step = _sparse(_pitch(finger) if pitch is None else pitch, row.depth)
    skin, around = row.finger.skin, 0
    if skin.curvature:
        around = max(int(np.ceil(skin.period / step * (1 - 1e-12))), 1)
        step = skin.period / around
    window = row.half_width + _WINDOW * row.depth + step
    half = int(np.ceil(_STEPS * window / step))
    positions = np.linspace(-half, half, 2 * half + 1) * (step / _STEPS)
    if around:
        positions = positions[np.abs(positions) <= 0.5 * skin.period]
    truth = row.readings(row.centre + positions)
    offsets = step / shifts * np.arange(shifts, dtype=np.float64)
    error = np.stack([_recovered(row, positions, offset, step, around) for offset in offsets]) - truth
    scale = float(np.abs(truth).max())
    if not scale > 0:
        seen, rule = f"a sensor at {row.depth:.6g} m", "it reads nothing of the contact"
        raise InvalidValueError(seen, rule, "another depth, or contact")
    bound, at_nyquist = _spectral(row, np.pi / step)
    return AliasingError(
        row.finger, contact, step, row.centre + positions, truth, offsets, error, scale, bound / scale, at_nyquist
    )  # fmt: skip


def _sparse(pitch: float, depth: float) -> float:
    """The pitch, which is not so small that no error is left to find."""
    if pitch < _DENSEST * depth:
        rule = f"sensors nearer than {_DENSEST:g} depths leave no error to find"
        raise InvalidValueError(f"pitch = {pitch:.6g} m", rule, "a larger pitch")
    return pitch


def _pitch(finger: Finger) -> float:
    """The pitch of the finger's own row."""
    gaps = np.diff(np.sort(np.asarray(finger.array.y)))
    if not gaps.size or not gaps.min() > 0 or np.ptp(gaps) > 1e-9 * gaps.max():
        seen = f"sensors at {np.asarray(finger.array.y).tolist()} m"
        raise GeometryError(seen, "they are not evenly spaced", "pitch=")
    return float(gaps.mean())


def _recovered(row: EndlessRow, positions: FloatArray, offset: float, step: float, around: int) -> FloatArray:
    """The samples at offset + j step from the contact's centre, joined by sinc functions, or their like on a ring."""
    if around:
        at = offset + step * np.arange(around, dtype=np.float64)
    else:
        full = (row.half_width + _BEYOND * row.depth) / step + _REACH * _TAPER
        last = int(np.ceil(full + _REACH * _TAPER))
        at = offset + step * np.arange(-last, last + 1, dtype=np.float64)
    samples = row.readings(row.centre + at)
    if not around:
        # far out samples fall as slowly as 1/y and the sinc's signs alternate: a smooth end sums them as none would
        from scipy.special import erfc

        samples = samples * 0.5 * erfc((np.abs(at) / step - full) / _TAPER)
    out = np.empty(positions.size)
    size = max(1, _BLOCK // at.size)
    for i in range(0, positions.size, size):
        t = (positions[i : i + size, None] - at) / step
        out[i : i + size] = (_periodic(t, around) if around else np.sinc(t)) @ samples
    return out


def _periodic(t: FloatArray, count: int) -> FloatArray:
    """Sum of the sincs of `count` samples round a ring, t in samples; the middle of the two where count is even."""
    turn = np.pi * t / count
    under = np.sin(turn) if count % 2 else np.tan(turn)
    near = np.abs(np.sin(turn)) < 1e-12
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(near, 1.0, np.sin(np.pi * t) / (count * np.where(near, 1.0, under)))


def _spectral(row: EndlessRow, nyquist: float) -> tuple[float, float]:
    """The bound on the error, and the spectrum beyond the Nyquist wavenumber over its largest value."""
    beyond, wanted = row.waves(_DEEP, start=nyquist), row.waves(_DEEP)
    sizes = np.abs(row.spectrum(beyond))
    largest = float(np.abs(row.spectrum(wanted)).max())
    if not beyond.size:
        return 0.0, 0.0
    return float(row.beyond(beyond, sizes)[0]), float(sizes.max()) / largest


def _lattice_error(finger: Finger, contact: object, pitch: float | None, *, sensor: int, lattice: str) -> LatticeError:
    """`aliasing_error` of a square or hexagonal lattice."""
    if contact is not None and not isinstance(contact, LocalContact):
        seen, rule = f"a {type(contact).__name__} over a {lattice} lattice", "a local contact is needed, or none"
        raise InvalidValueError(seen, rule, "RoundHertz(force=1.0, half_width=2e-3)")
    if contact is not None and contact.shape != ():
        raise GeometryError(f"contacts of shape {contact.shape}", "a single one is needed", "give contacts one by one")
    sensors = EndlessLattice.of(finger, sensor)
    step = _sparse(_lattice_pitch(finger, lattice) if pitch is None else pitch, sensors.depth)
    within, beyond = sensors.powers(lattice, step, contact)
    if not (within + beyond > 0).all():
        seen, rule = f"a sensor at {sensors.depth:.6g} m", "it reads nothing of the load"
        raise InvalidValueError(seen, rule, "another depth or transducer")
    ratio = np.sqrt(beyond / within)
    return LatticeError(sensors.finger, contact, lattice, step, ratio[0] if contact else ratio)


def _lattice_pitch(finger: Finger, lattice: str) -> float:
    """The pitch of the finger's own lattice."""
    layout, points = finger.array.layout, np.unique(finger.array.points, axis=0)
    own = "" if not layout or "along" in layout else "hexagonal" if "hexagonal" in layout else "square"
    if own != lattice or len(points) < 2:
        seen = f"sensors that are {f'a {layout}' if layout else 'not set out evenly'}"
        raise GeometryError(seen, f"no {lattice} lattice follows from them", "pitch=2e-3")
    return float(np.hypot(*(points[1:] - points[0]).T).min())
