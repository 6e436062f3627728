"""A row of one sensor repeated for ever: its filter, what arrives of a contact, and what it reads along the skin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ... import _check
from ..._check import ComplexArray, FloatArray
from ...array import SensorArray
from ...contact import Contact, LocalContact
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from .._common import index_of, refuse_ridges
from ..response import spatial_response

_TAIL = 30.0
"""Waves are followed for so many depths (as k d) beyond those wanted: what falls as exp(-k d) is then gone."""
_FINE = 0.02
"""Step of the wavenumbers, as a phase over depth, width and half the contact."""
_MOST = 1 << 19
_BLOCK = 1 << 14


@dataclass(frozen=True)
class EndlessRow:
    """One sensor of a finger, at y = 0, standing for a row of its like, under a contact (None: all waves alike)."""

    finger: Finger
    contact: Contact | None

    @classmethod
    def of(cls, finger: Finger, sensor: int, contact: Contact | None) -> EndlessRow:
        """The row of a finger's sensor, which has to live, under a single contact."""
        refuse_ridges(finger.skin, "the sampling")
        one = finger.array.select([index_of(finger.array, sensor)])
        if not one.live[0]:
            raise InvalidValueError(f"sensor {sensor}", "it is dead, of gain 0", "name another")
        if contact is not None:
            _check.noun("contact", contact, (Contact, LocalContact), "LineLoad(force=40.0)")
        if contact is not None and contact.shape != ():
            raise GeometryError(
                f"contacts of shape {contact.shape}", "a single one is needed", "give contacts one by one"
            )
        return cls(Finger(finger.skin, replace(one, y=[0.0])), contact)

    @property
    def depth(self) -> float:
        """Depth of the sensor [m]."""
        return float(np.asarray(self.finger.array.depth)[0])

    @property
    def half_width(self) -> float:
        """Half the contact's width [m]; 0 where there is none."""
        return 0.0 if self.contact is None else float(np.subtract(*self.contact.support[::-1])) / 2

    @property
    def centre(self) -> float:
        """Middle of the contact [m]."""
        return 0.0 if self.contact is None else float(np.add(*self.contact.support)) / 2

    def waves(self, attenuation: float, start: float = 0.0) -> FloatArray:
        """Wavenumbers from `start` on [rad/m] that resolve the spectrum, up to where `attenuation` is far exceeded.

        On a round finger all that close round it, from `start` on.
        """
        last = max((np.log(attenuation) + _TAIL) / self.depth, 2 * start)
        if turn := self.finger.skin.curvature:
            first, end = (np.ceil(k / turn * (1 - 1e-12)) for k in (start, last))
            return turn * np.arange(first, end + 1)
        scale = self.depth + self.half_width + float(np.asarray(self.finger.array.width)[0])
        step = _FINE / scale
        if last / step > _MOST:
            raise GeometryError(
                f"a contact of half width {self.half_width:.6g} m over a sensor at {self.depth:.6g} m",
                "it is too wide for its spectrum to be followed",
                "a narrower contact, or its edges alone",
            )
        fine = start + step * np.arange(1, int((last - start) / step) + 1)
        # a bonded layer thick beside the depth shows at waves far longer than the depth
        coarse = start + np.geomspace(1e-12, 1.0, 400) * last
        return np.unique(np.concatenate([[start] if start else [], coarse, fine]))

    def filters(self, k: FloatArray) -> ComplexArray:
        """Reading per Pa of a wave of pressure and of shear, shape (m, 2)."""
        parts = [spatial_response(self.finger, k[i : i + _BLOCK]).amplitude[:, 0] for i in range(0, k.size, _BLOCK)]
        return np.concatenate(parts)

    def arriving(self, k: FloatArray) -> ComplexArray:
        """What is read of each wave under the pressure alone and under a shear of its shape, shape (m, 2).

        The transform over the sensor's position s, integral of reading(s) exp(-i k s) ds; per Pa if there is no
        contact.
        """
        filters = self.filters(k)
        if self.contact is None:
            return filters
        parts = [self.contact.spectrum(k[i : i + _BLOCK]).p for i in range(0, k.size, _BLOCK)]
        return np.asarray(np.concatenate(parts)[:, None] * filters)

    def spectrum(self, k: FloatArray) -> ComplexArray:
        """The same under the contact as it is, its own shear included, shape (m,)."""
        assert self.contact is not None
        p, q = self.contact.spectrum(k)
        filters = self.filters(k)
        return np.asarray(p * filters[:, 0] + q * filters[:, 1])

    def beyond(self, k: FloatArray, spectrum: FloatArray) -> FloatArray:
        """Largest error if the waves from each k on are taken for others: 2 / pi times the integral from there."""
        if turn := self.finger.skin.curvature:
            parts = 2 / np.pi * turn * spectrum
            return np.asarray(np.cumsum(parts[::-1])[::-1])
        parts = 1 / np.pi * (spectrum[1:] + spectrum[:-1]) * np.diff(k)
        return np.concatenate([np.cumsum(parts[::-1])[::-1], [0.0]])

    def readings(self, positions: FloatArray) -> FloatArray:
        """Readings of the sensor at positions of shape (m,), without offset and noise."""
        assert self.contact is not None
        one = self.finger.array
        kinds = (one.transducers[0],) * positions.size
        many = SensorArray(positions, one.depth, kinds, width=one.width, gain=one.gain)
        measured = Finger(self.finger.skin, many).measure(self.contact, linear=True)
        return np.asarray(np.asarray(one.gain) * measured)
