"""Ridges on the skin: the pitch that a sensor reads most, and the gain that they bring (memo section 6.1, Fig. 16)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Fix, checked
from ...contact import Contact
from ...contact.line import LineLoads, line_loads
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...response import Response, tabulate
from .._common import Found, index_of, refuse_ridges
from ..response import spatial_response
from .shape import Ridges

__all__ = ["Gains", "RidgeGain", "RidgePitch", "best_ridge_pitch", "read_ridged", "ridge_gain"]

Pressing: TypeAlias = Annotated[Contact, Fix("Hertz(40.0, half_width=2e-3)")]

_LEAST, _MOST, _SCAN = 1e-3, 60.0, 481
_NEARER, _ROUNDS = 41, 6
_SHARE = 0.5
"""A maximum has to have this share of the largest reading: a wide sensor has others, ever smaller."""


@dataclass(frozen=True, eq=False)
class RidgePitch(Found):
    """What `best_ridge_pitch` found, for each of the n sensors.

    Attributes
    ----------
    pitch : ndarray, shape (n,)
        The best pitch [m]; infinite where a pressure without ridges reads most.
    normal, tangential : ndarray, shape (n,)
        Size of the reading of a wave of pressure and of a wave of shear of that pitch [its unit / Pa].
    """

    pitch: FloatArray
    normal: FloatArray
    tangential: FloatArray


@checked
def best_ridge_pitch(finger: Finger) -> RidgePitch:
    """The finest pitch at which the reading of a wave of pressure has a maximum, sensor by sensor.

    For normal strain on a half plane it is pi / nu depths, 2 pi at nu = 1/2 (memo section 6.1), and a wave of shear of
    that pitch is not read at all. On any other finger it is found from
    `spatial_response`. A layer that is squeezed, or a ring bent oval, has a coarser maximum as well, of waves longer
    than the skin is thick; the finer one is meant, if it has half the size. On a round finger a whole number of ridges
    goes round. It is the best of waves without end: a contact that spans few ridges shifts it (`ridge_gain`).

    Raises
    ------
    NotLinearError
        A transducer that is not linear.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> best = best_ridge_pitch(ss.Finger(skin, ss.SensorArray(y=[0.0], depth=0.5e-3)))
    >>> (best.pitch * 1e3).round(4).tolist(), bool(best.tangential[0] < 1e-6 * best.normal[0])
    ([3.1416], True)
    """
    refuse_ridges(finger.skin, "the best pitch of ridges")
    depth = np.asarray(finger.array.depth)
    shortest = _MOST / float(depth.min())
    if turn := finger.skin.curvature:
        k = turn * np.arange(max(int(shortest / turn), 4))
        sizes = spatial_response(finger, k).magnitude
        at = _finest(sizes[..., 0])
        return _found(np.asarray(k[at]), sizes[at, np.arange(depth.size)], at == 0)
    logs = np.linspace(np.log(_LEAST / float(depth.max())), np.log(shortest), _SCAN)
    at = _finest(spatial_response(finger, np.exp(logs)).magnitude[..., 0])
    best, half, own = logs[at], logs[1] - logs[0], np.arange(depth.size)
    for _ in range(_ROUNDS):
        near = best[:, None] + half * np.linspace(-1, 1, _NEARER)
        sizes = spatial_response(finger, np.exp(near)).magnitude[own, :, own]
        best = near[own, np.argmax(sizes[..., 0], axis=1)]
        half *= 3 / _NEARER
    return _found(np.asarray(np.exp(best)), spatial_response(finger, np.exp(best)).magnitude[own, own], at == 0)


def _finest(sizes: FloatArray) -> npt.NDArray[np.intp]:
    """Index of the last large maximum of each column (waves, n); 0 where it is largest at its start."""
    rises = np.diff(sizes, axis=0, prepend=np.inf, append=0.0)
    tops = (rises[:-1] > 0) & (rises[1:] <= 0) & (sizes >= _SHARE * sizes.max(axis=0))
    last = len(sizes) - 1 - np.argmax(tops[::-1], axis=0)
    return np.where(np.argmax(sizes, axis=0) == 0, 0, last)


def _found(k: FloatArray, sizes: FloatArray, endless: npt.NDArray[np.bool_]) -> RidgePitch:
    pitch = np.where(endless, np.inf, 2 * np.pi / np.where(endless, 1.0, k))
    return RidgePitch(pitch, sizes[:, 0].copy(), sizes[:, 1].copy())


_BEYOND, _PER_DEPTH, _CLOSER = 2.5, 5, 65
"""How far beyond the contact is tried, in depths; how many positions a depth, and about the largest reading."""

_FARTHEST = 1000.0
_BLOCK = 1 << 18


class Gains(NamedTuple):
    """Largest readings under ridges over the largest one without, each of the batch's shape.

    `peak`: wherever it lies. `beneath`: of a sensor straight beneath a crest. `between`: of one midway between two.
    `ripple`: of what the ridges add to a smooth contact that carries as much as they do on average.
    """

    peak: FloatArray
    beneath: FloatArray
    between: FloatArray
    ripple: FloatArray


@dataclass(frozen=True, eq=False)
class RidgeGain(Found):
    """What `ridge_gain` found. Arrays have the shape to which contact and ridges broadcast.

    Attributes
    ----------
    finger : Finger
    contact : Contact
    ridges : Ridges
    sensor : int
        Index of the sensor whose kind this is about.
    pitch, half_width : ndarray
        Pitch of the ridges, and half width of the contact [m].
    smooth : ndarray
        Largest size of a reading without ridges [its unit].
    load_ratio : ndarray
        Force of the smooth contact over that of the ridged one, at the same peak pressure [-]; infinite where ridges
        carry nothing there.
    equal_peak : Gains
        Both with the same peak pressure, or rather the same pressure at the crests (the memo's).
    """

    finger: Finger
    contact: Contact
    ridges: Ridges
    sensor: int
    pitch: FloatArray
    half_width: FloatArray
    smooth: FloatArray
    load_ratio: FloatArray
    equal_peak: Gains

    @property
    def equal_load(self) -> Gains:
        """The gains where both have the same force: `load_ratio` times as much."""
        with np.errstate(invalid="ignore"):
            return Gains(*(_check.read_only(self.load_ratio * g) for g in self.equal_peak))

    @property
    def depth(self) -> float:
        """Depth of the sensor [m]."""
        return float(np.asarray(self.finger.array.depth)[self.sensor])


@checked
def ridge_gain(finger: Finger, contact: Pressing, ridges: Ridges, *, sensor: int = 0) -> RidgeGain:
    """How much more a sensor reads where ridges break up the pressure of a contact.

    The pressure, and the drag with it, is that of the smooth contact times the ridges' share. One sensor is tried at
    all positions along the skin: its depth, transducer and width count, its own position does not. The contact becomes
    line loads, by Gauss's rule between the positions where anything is not smooth, exact to about 1e-8. Source: memo
    section 6.1, Fig. 16; docs/ridges.md.

    Parameters
    ----------
    finger : Finger
        Any skin; a linear transducer.
    contact : Contact
        The smooth one; a batch broadcasts against the ridges.
    ridges : Ridges
        Several pitches or crests are a batch.
    sensor : int, optional
        Index of the sensor.

    Raises
    ------
    InvalidValueError, GeometryError
        No such sensor, a contact that it does not read; a contact or a pitch of a thousand depths; shapes that do not
        broadcast.
    NotLinearError
        A transducer that is not linear.
    ConvergenceError
        A contact that is not smooth where it says it is.

    Examples
    --------
    The memo's example, a cylinder over about three ridges of its best pitch: 1.5 times the load, twice the strain.

    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray(y=[0.0], depth=0.5e-3))
    >>> touch = ss.Hertz(force=40.0, half_width=5e-3)
    >>> gain = ridge_gain(finger, touch, Ridges(pitch=np.pi * 1e-3))
    >>> round(float(gain.load_ratio), 3), round(float(gain.equal_peak.peak), 3)
    (1.564, 2.017)
    """
    sensor = index_of(finger.array, sensor)
    refuse_ridges(finger.skin, "the gain of ridges")
    alone = replace(finger, array=replace(finger.array.select([sensor]), y=[0.0]))
    depth = float(np.asarray(alone.array.depth)[0])
    (low, high), lines, shares = _broken_up(contact, ridges, depth)
    shape = low.shape
    pitch, crest = (np.broadcast_to(v, shape) for v in (ridges.pitch, ridges.crest))
    far = float((high - low + 0.5 * pitch).max(initial=0.0)) + (_BEYOND + 1) * depth
    if far > _FARTHEST * depth:
        seen, rule = f"a contact and half a pitch of {far:.6g} m", f"beyond {_FARTHEST:g} depths sensors read nothing"
        raise GeometryError(f"{seen} together", rule, "lengths in metres, such as pitch=3e-3")
    reach = min(far, 0.5 * finger.skin.period)
    field = Response.from_function(alone.receptive_field, -reach, reach, step=depth / 32)
    out = {name: np.empty(shape) for name in ("smooth", "load_ratio", *Gains._fields)}
    for index in np.ndindex(shape):
        load, share = LineLoads(*(values[index] for values in lines)), shares[index]
        ends = float(low[index]), float(high[index])
        both = np.stack([np.ones_like(share), share, share - ridges.mean])
        read = partial(_readings, field, finger.skin.period, load, both)
        smooth, gains = largest(read, ends, depth, float(pitch[index]), float(crest[index]))
        if not smooth > 0:
            seen, rule = (
                f"a smooth contact that sensor {sensor} does not read",
                "a gain needs something to compare with",
            )
            raise InvalidValueError(seen, rule, "another sensor, or a transducer that reads the contact")
        force = load.normal if load.normal.any() else load.tangential
        left = float((force * share).sum())
        ratio = float(force.sum()) / left if left else np.inf
        numbers: tuple[Any, ...] = (smooth, ratio, *gains)
        for array, value in zip(out.values(), numbers, strict=True):
            array[index] = value
    equal_peak = Gains(*(out.pop(name) for name in Gains._fields))
    return RidgeGain(finger, contact, ridges, sensor, pitch.copy(), 0.5 * (high - low), **out, equal_peak=equal_peak)


@checked
def read_ridged(
    finger: Finger, contact: Pressing, ridges: Ridges, rng: np.random.Generator | None = None
) -> FloatArray:
    """Readings of the sensors under a contact whose pressure and drag ridges break up.

    As `Finger.read`; `finger.locate` takes them. Their shape is that to which contact and ridges broadcast, and (n,).

    Raises
    ------
    InvalidValueError, GeometryError, NotLinearError, ConvergenceError
        As `ridge_gain`; a contact wider than the row by more than 100 depths.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(3, pitch=1e-3, depth=0.5e-3))
    >>> touch = ss.Hertz(force=40.0, half_width=3e-3)
    >>> read_ridged(finger, touch, Ridges(pitch=2e-3)).round(4).tolist()
    [0.0019, -0.0068, 0.0019]
    """
    refuse_ridges(finger.skin, "readings under ridges")
    depth = float(np.asarray(finger.array.depth).min())
    (low, high), lines, shares = _broken_up(contact, ridges, depth)
    margin = 1e-3 * depth  # a line load has no width
    table = tabulate(finger, (float(low.min()) - margin, float(high.max()) + margin))
    out = np.empty((*low.shape, len(finger.array)))
    for index in np.ndindex(low.shape):
        y, *forces = (values[index] for values in lines)
        answer = table(y)
        out[index] = sum(f * shares[index] @ answer[..., i] for i, f in enumerate(forces))
    gain = np.asarray(finger.array.gain)
    return finger.array.digitise(out / np.where(gain == 0, 1.0, gain), rng)


def _broken_up(
    contact: Contact, ridges: Ridges, depth: float
) -> tuple[tuple[FloatArray, FloatArray], LineLoads, FloatArray]:
    """The contact's ends, the contact as line loads, and the ridges' share of each, all of the batch's shape."""
    shape = _check.broadcast(contact=np.empty(contact.shape), ridges=np.empty(ridges.batch))
    low, high = (np.broadcast_to(end, shape) for end in contact.support)
    lines = line_loads(contact, ridges.breaks(low, high), depth)
    wide = replace(ridges, pitch=np.asarray(ridges.pitch)[..., None], crest=np.asarray(ridges.crest)[..., None])
    return (low, high), lines, wide.share(lines.y)


def _ridges_at(pitch: float, crest: float, ends: tuple[float, float], shift: float) -> FloatArray:
    """Crests (shift 0) or troughs (shift 1/2) beneath the contact, and the nearest to its middle."""
    start = crest + shift * pitch
    first, last = (int(np.ceil((ends[0] - start) / pitch)), int(np.floor((ends[1] - start) / pitch)))
    nearest = int(np.round((0.5 * (ends[0] + ends[1]) - start) / pitch))
    return np.asarray(start + pitch * np.arange(min(first, nearest), max(last, nearest) + 1))


def _readings(field: Response, period: float, load: LineLoads, shares: FloatArray, positions: FloatArray) -> FloatArray:
    """Readings at `positions` of each of the shares (s, lines) of the load, shape (s, positions)."""
    felt = (load.normal != 0) | (load.tangential != 0)
    y, forces = load.y[felt], (load.normal[felt], load.tangential[felt])
    out = np.zeros((len(shares), positions.size))
    size = max(1, _BLOCK // max(1, y.size))
    for start in range(0, positions.size, size):
        part = slice(start, start + size)
        distance = y - positions[part, None]
        if np.isfinite(period):
            distance = distance - period * np.round(distance / period)
        answer = field(distance)[..., 0, :]
        for i, force in enumerate(forces):
            if force.any():
                out[:, part] += (force * shares[:, felt]) @ answer[..., i].T
    return out


def largest(
    read: Callable[[FloatArray], FloatArray], ends: tuple[float, float], depth: float, pitch: float, crest: float
) -> tuple[float, Gains]:
    """Largest reading about a smooth contact, and the gains by ridges; where it lies is looked at more closely.

    `read` has three rows: without ridges, with them, and their ripple.
    """
    low, high = ends
    start, stop = low - _BEYOND * depth, high + _BEYOND * depth
    along = np.linspace(start, stop, int(np.ceil((stop - start) / depth * _PER_DEPTH)) + 1)
    closer = (along[1] - along[0]) * np.linspace(-1, 1, _CLOSER)
    tops = along[np.argmax(np.abs(read(along)), axis=1)]
    smooth, peak, ripple = (float(np.abs(read(top + closer)[i]).max()) for i, top in enumerate(tops))
    beneath, between = (float(np.abs(read(_ridges_at(pitch, crest, ends, s))[1]).max()) for s in (0.0, 0.5))
    with np.errstate(divide="ignore", invalid="ignore"):
        return smooth, Gains(*(np.divide((max(peak, beneath, between), beneath, between, ripple), smooth)))
