"""Readings of a row of sensors about the centre of a contact: value, slope and bend there, and what makes them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...array import SensorArray
from ...contact import LineLoad, ProportionalContact
from ...contact.families import Family
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ..frames import check_noise

__all__ = ["LEAST", "Changes", "Frames", "count_of", "stencil", "unit_loads"]

LEAST = 3
"""Sensors that a slope takes."""

_STEP, _FARTHEST = 1e-4, 1e3

Mask = npt.NDArray[np.bool_]


class Frames(NamedTuple):
    """What was measured (..., n), its noise (n,), which can be used (..., n) or (n,); the centre and its std (...)."""

    measured: FloatArray
    noise: FloatArray
    usable: Mask
    position: FloatArray
    position_std: FloatArray

    @classmethod
    def of(
        cls, finger: Finger, readings: npt.ArrayLike, position: npt.ArrayLike, position_std: npt.ArrayLike
    ) -> Frames:
        """Checked, linear, without gain and offset; a NaN of position or its std takes away the frame's sensors."""
        array = finger.array
        kinds = set(array.transducers)
        if len(kinds) > 1:
            rule = "a slope is a difference of sensors of one kind"
            fix = "ss.Finger(finger.skin, finger.array.select(...)), or finger.fit"
            raise InvalidValueError(f"{len(kinds)} kinds of transducer in one array", rule, fix)
        if array.lifted:
            rule = "what a load adds to all sensors is no part of a slope under a load that is not known"
            raise InvalidValueError("sensors with a lift", rule, "finger.fit, or a finger calibrated without lift")
        check_noise(array, "an angle's error comes from the sensors' noise", "SensorArray(..., noise=1e-4)")
        raw = _check.readings(readings)
        if raw.ndim == 0 or raw.shape[-1] != len(array):
            raise GeometryError(
                f"readings of shape {raw.shape}",
                f"the last axis has to be the {len(array)} sensors",
                f"shape (frames, {len(array)})",
            )
        centre, spread, known = known_only(position=position, position_std=position_std)
        gain = np.where(array.live, np.asarray(array.gain), 1.0)
        with np.errstate(invalid="ignore"):
            measured = kinds.pop().linearise((raw - np.asarray(array.offset)) / gain)
        usable = array.usable(raw) & np.isfinite(measured)
        _check.broadcast(readings=measured[..., 0], position=centre, position_std=spread)
        same = (usable == array.live).all() and known.all()  # one stencil serves all frames of one contact
        usable = array.live if same else usable & known[..., None]
        noise = np.where(array.live, array.noise, np.inf) / np.abs(gain)
        return cls(np.where(np.isfinite(measured), measured, 0.0), noise, usable, centre, spread)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch."""
        return np.broadcast_shapes(self.measured.shape[:-1], self.position.shape, self.position_std.shape)

    @property
    def used_noise(self) -> FloatArray:
        """The noise of the sensors that can be used, 0 for the others."""
        return np.where(self.usable, self.noise, 0.0)

    def beyond(self, columns: FloatArray, false_alarm: float) -> Mask:
        """Frames of which `columns` (..., n, c), c >= 0, leave more than noise would; False where none can."""
        from scipy.special import chdtri

        scale = np.where(self.usable, 1 / self.noise, 0.0)
        count = columns.shape[-1]
        with np.errstate(over="ignore", invalid="ignore"):  # what is beyond all floats is beyond the noise
            seen = self.measured * scale
            if count:
                weighed = columns * scale[..., None]
                size = np.linalg.norm(weighed, axis=-2, keepdims=True)
                basis, _ = np.linalg.qr(weighed / np.where(size > 0, size, 1.0))
                seen = seen - np.einsum("...nc,...mc,...m->...n", basis, basis, seen)
            left = (seen**2).sum(axis=-1)
        spare = self.usable.sum(axis=-1) - count
        return np.asarray(~(left <= chdtri(np.maximum(spare, 1), false_alarm)) & (spare > 0))


def known_only(**values: npt.ArrayLike) -> tuple[FloatArray, FloatArray, Mask]:
    """A length and its standard deviation, 0 where either is NaN, and where both are known."""
    (name, value), (std_name, std) = values.items()
    lengths, spread = _check.real(name, value, finite=False), _check.real(std_name, std, finite=False)
    known = ~(np.isnan(lengths) | np.isnan(spread))
    lengths = _check.real(name, np.where(np.isnan(lengths), 0.0, lengths), unit="m")
    return lengths, _check.real(std_name, np.where(np.isnan(spread), 0.0, spread), unit="m", at_least=0.0), known


def count_of(sensors: int, available: int) -> int:
    """Number of sensors in a stencil."""
    wanted = _check.whole("sensors", sensors, at_least=LEAST, at_most=10**6, fix="sensors=5")
    if available < LEAST:
        raise GeometryError(
            f"{available} live sensors in a row", f"a slope takes {LEAST}", "more live sensors, or finger.fit"
        )
    return min(wanted, available)


def stencil(array: SensorArray, usable: Mask, position: FloatArray, count: int) -> FloatArray:
    """Weights (..., 3, n) of the readings that make value, slope and bend at `position`.

    Those of the polynomial through the `count` nearest sensors that can be used; each one missing takes a power away.
    """
    y, scale = np.asarray(array.y), float(np.asarray(array.depth).mean())
    away = np.where(usable, (y - position[..., None]) / scale, np.inf)
    far = np.abs(np.where(np.isfinite(away), away, 0.0)).min(axis=-1)
    if far.max(initial=0.0) > _FARTHEST:
        at = float(np.broadcast_to(position, far.shape).flat[int(far.argmax())])
        rule = f"it lies at most {_FARTHEST:g} depths from a sensor"
        raise GeometryError(f"position = {at:.6g} m", rule, "the position in metres")
    nearest = np.argsort(np.abs(away), axis=-1, kind="stable")[..., :count]
    t = np.take_along_axis(away, nearest, axis=-1)
    held = np.isfinite(t)
    powers = np.where(held, t, 0.0)[..., None, :] ** np.arange(count)[:, None]
    # a row of the system for each power: the last ones give way to "no weight" of the sensors that are not there
    matrix = np.where(held[..., :, None], powers * held[..., None, :], np.eye(count))
    wanted = np.eye(count)[:, :3] * [1.0, 1 / scale, 2 / scale**2]
    local = np.linalg.solve(matrix, np.broadcast_to(wanted, (*matrix.shape[:-1], 3)))
    out = np.zeros((*away.shape, 3))
    np.put_along_axis(out, nearest[..., None], np.where(held[..., None], local, 0.0), axis=-2)
    return np.swapaxes(out, -1, -2)


def unit_loads(family: Family, position: npt.ArrayLike, half_width: FloatArray | None) -> ProportionalContact:
    """A normal and a tangential load of 1 N/m, the last axis of the batch; lines have no half width."""
    if half_width is None or issubclass(family, LineLoad):
        return LineLoad.of_components(np.eye(2), position)
    return family.of_components(np.eye(2), position, half_width=half_width)


class Changes(NamedTuple):
    """Readings (..., n, 2) under a unit normal and a unit tangential force, before gain, and their changes."""

    unit: FloatArray
    by_position: FloatArray
    by_width: FloatArray

    @classmethod
    def of(cls, finger: Finger, family: Family, position: FloatArray, half_width: FloatArray | None) -> Changes:
        """By central differences."""
        h = _STEP * float(np.asarray(finger.array.depth).mean())
        if half_width is None:
            unit, after, before = unit_readings(finger, family, np.stack([position, position + h, position - h]), None)
            return cls(unit, (after - before) / (2 * h), np.zeros_like(unit))
        y, a = np.broadcast_arrays(position, half_width)
        positions = np.stack([y, y + h, y - h, y, y])
        widths = np.stack([a, a, a, a * (1 + _STEP), a * (1 - _STEP)])
        unit, after, before, more, less = unit_readings(finger, family, positions, widths)
        return cls(unit, (after - before) / (2 * h), (more - less) / (2 * _STEP * a[..., None, None]))


def unit_readings(finger: Finger, family: Family, position: FloatArray, half_width: FloatArray | None) -> FloatArray:
    """Readings (..., n, 2) under a unit normal and a unit tangential force, before gain."""
    width = None if half_width is None else half_width[..., None]
    fields = finger.measure(unit_loads(family, position[..., None], width), linear=True)
    return np.swapaxes(fields, -1, -2)
