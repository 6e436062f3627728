"""One sensor repeated for ever, along a row or on a lattice: what it reads of every wave, and of a contact."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ... import _check
from ..._check import ComplexArray, FloatArray
from ...array import SensorArray
from ...contact import Contact, LocalContact
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...tensor import Displacements, State, Strain, Stress
from .._common import index_of, refuse_ridges
from ..response import spatial_response

__all__ = ["EndlessLattice", "EndlessRow", "lattice_of", "zone_of"]

LATTICES = ("row", "square", "hexagonal")
"""How the sensors lie that are thought of: along a row, or on an area."""

_TAIL = 30.0
"""Waves are followed for so many depths (as k d) beyond those wanted: what falls as exp(-k d) is then gone."""
_FINE = 0.02
"""Step of the wavenumbers, as a phase over depth, width and half the contact."""
_SHORTEST = 1e-12
"""Waves without end are those of so small a wavenumber, as k d: a wave of drag across has no limit in displacement."""
_MOST, _BLOCK, _TABLE = 1 << 19, 1 << 14, 1 << 22
_DIRECTIONS = 12
_NODES, _PANELS, _TURNS = 16, 8, 4
_WINDOW, _POSITIONS = 4.0, 32
"""Depths on either side of a contact where the largest reading is looked for, and positions per depth."""


def lattice_of(finger: Finger, lattice: str | None) -> str:
    """The lattice that is meant: as the sensors lie if none is named, square on an area that is no hexagonal grid."""
    if lattice is None:
        return ("hexagonal" if "hexagonal" in finger.array.layout else "square") if finger.array.on_area else "row"
    _check.choice("lattice", lattice, LATTICES)
    return lattice


def zone_of(lattice: str, pitch: float, phi: FloatArray) -> FloatArray:
    """The largest wavenumber in the directions phi that sensors a pitch apart tell from longer waves [rad/m].

    The border of the first zone: a square, or a hexagon.
    """
    if lattice == "square":
        return np.asarray(np.pi / pitch / np.maximum(np.abs(np.cos(phi)), np.abs(np.sin(phi))))
    normals = np.pi / 6 + np.pi / 3 * np.arange(6)
    return np.asarray(2 * np.pi / (np.sqrt(3) * pitch) / np.cos(phi[..., None] - normals).max(axis=-1))


class _Endless:
    """One sensor of a finger, in the middle, and what it is asked for whatever its like are set out on."""

    finger: Finger

    @property
    def depth(self) -> float:
        """Depth of the sensor [m]."""
        return float(np.asarray(self.finger.array.depth)[0])

    @property
    def width(self) -> float:
        """Its width [m]."""
        return float(np.asarray(self.finger.array.width)[0])


def _one_of(finger: Finger, sensor: int) -> Finger:
    """The finger with one of its sensors, which has to live, at (0, 0)."""
    one = finger.array.select([index_of(finger.array, sensor)])
    if not one.live[0]:
        raise InvalidValueError(f"sensor {sensor}", "it is dead, of gain 0", "name another")
    one.transducers[0].linearise(np.zeros(0))  # refuses what cannot be made linear
    return Finger(finger.skin, replace(one, y=[0.0], z=[0.0]))


def _left_over(parts: FloatArray) -> FloatArray:
    """Sums of all parts from each on."""
    return np.asarray(np.cumsum(parts[::-1])[::-1])


@dataclass(frozen=True)
class EndlessRow(_Endless):
    """One sensor of a finger, at y = 0, standing for a row of its like, under a contact (None: all waves alike)."""

    finger: Finger
    contact: Contact | None

    @classmethod
    def of(cls, finger: Finger, sensor: int, contact: Contact | None) -> EndlessRow:
        """The row of a finger's sensor, which has to live, under a single contact."""
        refuse_ridges(finger.skin, "the sampling")
        if contact is not None:
            _check.noun("contact", contact, (Contact, LocalContact), "LineLoad(force=40.0)")
        if contact is not None and contact.shape != ():
            seen = f"contacts of shape {contact.shape}"
            raise GeometryError(seen, "a single one is needed", "give contacts one by one")
        return cls(_one_of(finger, sensor), contact)

    loads = ("pressure", "shear")

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
        scale = self.depth + self.half_width + self.width
        step = _FINE / scale
        if last / step > _MOST:
            seen = f"a contact of half width {self.half_width:.6g} m over a sensor at {self.depth:.6g} m"
            rule = "it is too wide for its spectrum to be followed"
            raise GeometryError(seen, rule, "a narrower contact, or its edges alone")
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
            return _left_over(2 / np.pi * turn * spectrum)
        return np.append(_left_over(1 / np.pi * (spectrum[1:] + spectrum[:-1]) * np.diff(k)), 0.0)

    def sizes(self, k: FloatArray) -> FloatArray:
        """Size of what is read of waves k, shape (m, 2)."""
        return np.abs(self.arriving(k))

    def surveyed(self, k: FloatArray) -> tuple[FloatArray, FloatArray]:
        """`sizes`, and the largest reading along the skin under the pressure alone and under the shear alone, (2,)."""
        waves, reach = self.arriving(k), self.half_width + _WINDOW * self.depth
        positions = self.centre + np.linspace(-reach, reach, 2 * int(np.ceil(_POSITIONS * reach / self.depth)) + 1)
        if turn := self.finger.skin.curvature:
            weights = np.where(k == 0, 0.5, 1.0) * turn / np.pi
        else:
            steps = np.diff(k, prepend=0.0)
            weights = 0.5 * (steps + np.append(steps[1:], 0.0)) / np.pi
        found, size = np.zeros(2), max(1, _TABLE // k.size)
        for i in range(0, positions.size, size):
            part = np.exp(1j * np.outer(positions[i : i + size], k)) @ (weights[:, None] * waves)
            found = np.maximum(found, np.abs(part.real).max(axis=0))
        return np.abs(waves), found

    def readings(self, positions: FloatArray) -> FloatArray:
        """Readings of the sensor at positions of shape (m,), without offset and noise."""
        assert self.contact is not None
        one = self.finger.array
        kinds = (one.transducers[0],) * positions.size
        many = SensorArray(positions, one.depth, kinds, width=one.width, gain=one.gain)
        measured = Finger(self.finger.skin, many).measure(self.contact, linear=True)
        return np.asarray(np.asarray(one.gain) * measured)


@dataclass(frozen=True)
class EndlessLattice(_Endless):
    """One sensor of a finger, at (0, 0), standing for a lattice of its like; components are p, q_y and q_z."""

    finger: Finger

    @classmethod
    def of(cls, finger: Finger, sensor: int) -> EndlessLattice:
        """The lattice of a finger's sensor, which has to live, on a skin that takes local contacts."""
        if not finger.skin.takes_local:
            seen = f"a lattice of sensors in {finger.skin}"
            raise InvalidValueError(seen, "it is solved in a plane", "HalfSpace(material), or Layered(...)")
        return cls(_one_of(finger, sensor))

    loads = ("pressure", "drag along y", "drag along z")

    def waves(self, attenuation: float) -> FloatArray:
        """Wavenumbers that resolve the response [rad/m], up to where `attenuation` is far exceeded."""
        last = (np.log(attenuation) + _TAIL) / self.depth
        step = _FINE / (self.depth + self.width)
        fine = step * np.arange(1, int(last / step) + 1)
        return np.unique(np.concatenate([np.geomspace(_SHORTEST, 1.0, 400) * last, fine]))

    def filters(self, k: FloatArray, phi: FloatArray) -> ComplexArray:
        """Reading per Pa of a wave exp(i k l) of p, q_y and q_z, l in the direction phi; shapes (m,), (..., m, 3)."""
        skin, array = self.finger.skin, self.finger.array
        depth = np.array([self.depth])
        wave, across = skin.wave(k, depth), skin.wave_across(k, depth)[:, :, 0]
        soft = 1 / (2 * skin.material_at(self.depth).shear)
        c, s = np.cos(phi), np.sin(phi)
        kind = array.transducers[0].linear_part
        gain = float(np.asarray(array.gain)[0])
        out = np.empty((*np.broadcast_shapes(k.shape, phi.shape), 3), dtype=np.complex128)
        # what is even in l goes with p and leads q by a quarter of a wave, what is odd the other way about
        zero = np.zeros_like(k)
        turned = 0.5j / soft * k * across[1]  # stress lt, i G k u_t
        loads: list[tuple[float, float | FloatArray, float | FloatArray]]
        loads = [(1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c)]
        for load, (p, ql, qt) in enumerate(loads):
            parts = []
            for tensor, share in ((wave.stress, 1.0), (wave.strain, soft)):
                even = [p * one[:, 0, 0] + 1j * ql * one[:, 0, 1] for one in (tensor.xx, tensor.yy, tensor.zz)]
                xl = -1j * p * tensor.xy[:, 0, 0] + ql * tensor.xy[:, 0, 1]
                xt, lt = share * qt * across[0], share * qt * turned
                xx, ll, tt = even
                yy = ll * c * c + tt * s * s - 2 * lt * c * s
                zz = ll * s * s + tt * c * c + 2 * lt * c * s
                yz = (ll - tt) * c * s + lt * (c * c - s * s)
                parts.append([xx, yy, zz, xl * c - xt * s, xl * s + xt * c, yz])
            ux = p * wave.ux[:, 0, 0] + 1j * ql * wave.ux[:, 0, 1]
            ul, ut = -1j * p * wave.uy[:, 0, 0] + ql * wave.uy[:, 0, 1], qt * across[1]
            moved = [ux, ul * c - ut * s, ul * s + ut * c]
            read = []
            for part in (np.real, np.imag):
                stress, strain = (([part(one) + zero for one in tensor]) for tensor in parts)
                felt = Displacements(*(part(one) + zero for one in moved))
                read.append(kind.measure(State(Stress(*stress), Strain(*strain), displacement=felt)))
            out[..., load] = gain * (read[0] + 1j * read[1])
        out *= np.sinc(k * c * self.width / (2 * np.pi))[..., None]
        return out

    def sizes(self, k: FloatArray) -> FloatArray:
        """Largest reading per Pa of waves k in any direction, shape (m, 3)."""
        phi = np.pi / _DIRECTIONS * np.arange(_DIRECTIONS)[:, None]
        waves = np.tile(k, _DIRECTIONS)
        read = self.filters(waves, np.repeat(phi, k.size))
        return np.asarray(np.abs(read).reshape(_DIRECTIONS, k.size, 3).max(axis=0))

    def beyond(self, k: FloatArray, sizes: FloatArray) -> FloatArray:
        """Largest error if the waves from each k on are taken for others: twice their integral over the plane."""
        return np.append(_left_over(0.5 / np.pi * (sizes[1:] * k[1:] + sizes[:-1] * k[:-1]) * np.diff(k)), 0.0)

    def surveyed(self, k: FloatArray) -> tuple[FloatArray, FloatArray]:
        """`sizes`, and the largest reading under a unit point load of each component, or beside it, shape (3,)."""
        at = self.depth * np.linspace(-3, 3, 97)
        grid = np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)
        return self.sizes(k), np.abs(self.finger.receptive_field(grid, "point")[:, 0]).max(axis=0)

    def powers(self, lattice: str, pitch: float, contact: LocalContact | None = None) -> FloatArray:
        """Integral of what is read squared within the first zone and beyond, (2, 3); of a contact (2, 1).

        Without a contact of pressure and drags that are white, alike at all wavenumbers.
        """
        turn, weight = np.polynomial.legendre.leggauss(_NODES)
        # sectors between the corners and the middles of the sides, of both zones
        ends = np.pi / 12 * np.arange(25)
        middles, half = 0.5 * (ends[1:] + ends[:-1]), np.pi / 24
        nodes, weights = np.polynomial.legendre.leggauss(_TURNS)
        phi, by_phi = (middles[:, None] + half * nodes).reshape(-1), np.tile(half * weights, 24)
        edge = zone_of(lattice, pitch, phi)
        out = []
        for low, high in ((0.0 * edge, edge), (edge, edge + 0.5 * _TAIL / self.depth)):
            cuts = low + (high - low) * np.linspace(0, 1, _PANELS + 1)[:, None]
            k = 0.5 * (cuts[1:] + cuts[:-1])[..., None] + 0.5 * (cuts[1:] - cuts[:-1])[..., None] * turn
            area = 0.5 * (cuts[1:] - cuts[:-1])[..., None] * weight * k * by_phi[:, None]
            turns = np.broadcast_to(phi[:, None], k.shape)
            read = self.filters(k.reshape(-1), turns.reshape(-1))
            if contact is not None:
                spectrum = contact.spectrum(*((k * one(turns)).reshape(-1) for one in (np.cos, np.sin)))
                read = np.sum([part * read[:, i] for i, part in enumerate(spectrum)], axis=0)[:, None]
            out.append((np.abs(read) ** 2 * area.reshape(-1)[:, None]).sum(axis=0))
        return np.stack(out)
