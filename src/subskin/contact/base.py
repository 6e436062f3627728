"""What every contact has to say: its pressure and shear, their Cauchy transforms and their spectra.

With z = y + i x the transform of a pressure p is F(z) = integral of p(t) / (t - z) dt; it alone, with its
derivative, gives the whole field in a half plane (docs/theory.md). Other skins answer wavenumber by
wavenumber, and ask for the spectrum, the integral of p(t) exp(-i k t) dt (docs/skins.md).
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from functools import cached_property
from typing import ClassVar, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from .._registry import Named

__all__ = ["Contact", "ContactSum", "ProportionalContact", "Spectrum", "Transforms"]


class Transforms(NamedTuple):
    """Cauchy transforms of the pressure (`p`) and of the shear (`q`), and their derivatives (`dp`, `dq`).

    `hq` is Im(q + i x dq). Deep beneath a contact its two parts cancel all but a share of (half width /
    depth)^2, which is then all the stress that a drag causes there; so each contact says how to find it
    without that loss.
    """

    p: ComplexArray
    dp: ComplexArray
    q: ComplexArray
    dq: ComplexArray
    hq: FloatArray


class Spectrum(NamedTuple):
    """Fourier transforms of the pressure (`p`) and of the shear (`q`): integral of p(t) exp(-i k t) dt [N/m]."""

    p: ComplexArray
    q: ComplexArray


def times_depth(z: ComplexArray, derivative: ComplexArray) -> ComplexArray:
    """The depth times F'; 0 on the surface, where F' grows more slowly than 1/x (save at singular points)."""
    product = np.asarray(z.imag * derivative)
    surface = z.imag == 0
    return np.where(surface, 0.0, product) if surface.any() else product


def resolve(force: npt.ArrayLike, angle: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """N = P cos(angle) and T = P sin(angle); np.pi / 2 stands for the right angle that it rounds, np.pi likewise."""
    p, alpha = np.asarray(force, dtype=np.float64), np.asarray(angle, dtype=np.float64)
    size = np.abs(alpha)
    normal = p * np.where(size == np.pi / 2, 0.0, np.cos(alpha))
    return _check.read_only(normal), _check.read_only(p * np.where(size == np.pi, 0.0, np.sin(alpha)))


def scaled(force: FloatArray, unit: FloatArray) -> FloatArray:
    """A force times a unit pressure: no force makes nothing, even of an infinite one."""
    with np.errstate(invalid="ignore"):
        return _check.read_only(np.where(force == 0, 0.0, force * unit))


class Contact(Named, ABC):
    """Traction on the skin's surface. Pressure presses in (+x), shear drags the surface towards +y.

    Parameters may be arrays: a contact is then a batch, whose `shape` broadcasts against the points of a
    field.
    """

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch; () for a single contact."""

    @property
    @abstractmethod
    def normal_force(self) -> FloatArray:
        """Integral of the pressure, N [N/m]."""

    @property
    @abstractmethod
    def tangential_force(self) -> FloatArray:
        """Integral of the shear, T [N/m], positive towards +y."""

    @abstractmethod
    def transforms(self, z: ComplexArray) -> Transforms:
        """Cauchy transforms at z = y + i x (x >= 0), broadcast against the batch."""

    @abstractmethod
    def spectrum(self, k: FloatArray) -> Spectrum:
        """Fourier transforms at the wavenumbers k >= 0 [1/m], broadcast against the batch."""

    @property
    @abstractmethod
    def support(self) -> tuple[FloatArray, FloatArray]:
        """Places y [m] between which the contact lies, each of the batch's shape."""

    @abstractmethod
    def pressure(self, y: npt.ArrayLike) -> FloatArray:
        """Pressure on the surface [Pa] at y [m], positive in compression; infinite at a singularity."""

    @abstractmethod
    def shear(self, y: npt.ArrayLike) -> FloatArray:
        """Shear on the surface [Pa] at y [m], positive where it drags the skin towards +y."""

    @abstractmethod
    def singular_points(self) -> tuple[FloatArray, ...]:
        """Places y [m] on the surface where the stress is infinite, each of the batch's shape."""

    @abstractmethod
    def expand(self, axes: int = 1) -> Self:
        """The same contact, its batch lengthened by `axes` axes of length one, to broadcast against
        points.
        """

    @classmethod
    def joined(cls, parts: list[Contact]) -> list[Contact]:
        """Contacts of this kind whose sum is that of `parts`: the same, or fewer that are quicker to evaluate."""
        return parts

    def __add__(self, other: object) -> ContactSum:
        if not isinstance(other, Contact):
            return NotImplemented
        return ContactSum((*_parts(self), *_parts(other)))

    def __radd__(self, other: object) -> Contact:
        # sum([...]) starts from the integer 0
        return self if isinstance(other, int) and other == 0 else NotImplemented


def _parts(contact: Contact) -> tuple[Contact, ...]:
    return contact.parts if isinstance(contact, ContactSum) else (contact,)


@dataclass(frozen=True, eq=False)
class ContactSum(Contact):
    """Several contacts at once: tractions add, so do the fields.

    Examples
    --------
    >>> from subskin.contact.line import LineLoad
    >>> two = LineLoad(force=3.0, angle=0.0, position=-1e-3) + LineLoad(force=1.0, angle=0.0, position=1e-3)
    >>> float(two.normal_force)
    4.0
    """

    parts: tuple[Contact, ...]

    @property
    def shape(self) -> tuple[int, ...]:  # noqa: D102
        return np.broadcast_shapes(*(part.shape for part in self.parts))

    @property
    def normal_force(self) -> FloatArray:  # noqa: D102
        return _check.read_only(sum(part.normal_force for part in self.parts))

    @property
    def tangential_force(self) -> FloatArray:  # noqa: D102
        return _check.read_only(sum(part.tangential_force for part in self.parts))

    @cached_property
    def _terms(self) -> tuple[Contact, ...]:
        """The parts, those of one kind joined where that kind has a quicker way of adding many."""
        kinds: dict[type[Contact], list[Contact]] = {}
        for part in self.parts:
            kinds.setdefault(type(part), []).append(part)
        return tuple(term for kind, group in kinds.items() for term in kind.joined(group))

    def transforms(self, z: ComplexArray) -> Transforms:  # noqa: D102
        first, *rest = self._terms
        total = first.transforms(z)
        for part in rest:
            more = part.transforms(z)
            p, dp, q, dq = (np.asarray(a + b) for a, b in zip(total[:4], more[:4], strict=True))
            total = Transforms(p, dp, q, dq, np.asarray(total.hq + more.hq))
        return total

    def spectrum(self, k: FloatArray) -> Spectrum:  # noqa: D102
        parts = [part.spectrum(k) for part in self.parts]
        return Spectrum(np.asarray(sum(s.p for s in parts)), np.asarray(sum(s.q for s in parts)))

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        lows, highs = zip(*(part.support for part in self.parts), strict=True)
        low, high = lows[0], highs[0]
        for a, b in zip(lows[1:], highs[1:], strict=True):
            low, high = np.minimum(low, a), np.maximum(high, b)
        return np.broadcast_to(low, self.shape), np.broadcast_to(high, self.shape)

    def pressure(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return _check.read_only(sum(part.pressure(y) for part in self.parts))

    def shear(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return _check.read_only(sum(part.shear(y) for part in self.parts))

    def singular_points(self) -> tuple[FloatArray, ...]:  # noqa: D102
        return tuple(point for part in self.parts for point in part.singular_points())

    def expand(self, axes: int = 1) -> ContactSum:  # noqa: D102
        return ContactSum(tuple(part.expand(axes) for part in self.parts))


@dataclass(frozen=True, eq=False)
class ProportionalContact(Contact):
    """A contact whose shear is everywhere the same multiple of its pressure: q = p tan(angle).

    A subclass gives `unit_transform` (two formulas), `unit_pressure` and `unit_spectrum`, for N = 1 N/m at position 0.
    One with a part that is not proportional (a punch's moment, a zone that sticks) adds it in `transforms`,
    `spectrum`, `pressure` and `shear`.

    Parameters
    ----------
    force : array_like
        Magnitude P of the resultant [N/m], >= 0.
    angle : array_like, optional
        Angle of the resultant from the inward normal [rad], in [-pi, pi]: N = P cos(angle), T = P sin(angle)
        towards +y. Beyond pi/2 the load pulls.
    position : array_like, optional
        Centre of the contact y [m].

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; shapes that do not broadcast.
    """

    GROWTH: ClassVar[float | None] = None
    """Power of the normal force with which a pressed body's half width grows; None where no body is meant."""

    force: npt.ArrayLike
    angle: npt.ArrayLike = 0.0
    position: npt.ArrayLike = 0.0

    def __post_init__(self) -> None:
        self._set(
            "force", _check.real("force", self.force, unit="N/m", at_least=0.0, fix="turn the angle instead")
        )
        fix = "angles are in radians: np.deg2rad(30)"
        self._set(
            "angle", _check.real("angle", self.angle, unit="rad", at_least=-np.pi, at_most=np.pi, fix=fix)
        )
        self._set("position", _check.real("position", self.position, unit="m"))
        _check.broadcast(**self._parameters())

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _parameters(self) -> dict[str, FloatArray]:
        return {f.name: np.asarray(getattr(self, f.name), dtype=np.float64) for f in fields(self) if f.init}

    @property
    def shape(self) -> tuple[int, ...]:  # noqa: D102
        return np.broadcast_shapes(*(a.shape for a in self._parameters().values()))

    @property
    def normal_force(self) -> FloatArray:  # noqa: D102
        return resolve(self.force, self.angle)[0]

    @property
    def tangential_force(self) -> FloatArray:  # noqa: D102
        return resolve(self.force, self.angle)[1]

    @abstractmethod
    def unit_transform(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """F and dF/dz of the pressure with unit resultant, centred at 0."""

    @abstractmethod
    def unit_pressure(self, y: FloatArray) -> FloatArray:
        """The pressure with unit resultant, centred at 0 [1/m]."""

    @abstractmethod
    def unit_spectrum(self, k: FloatArray) -> FloatArray:
        """Fourier transform of the pressure with unit resultant, centred at 0: real, for it is symmetric."""

    def unit_shear_field(self, z: ComplexArray, f: ComplexArray, df: ComplexArray) -> FloatArray:
        """Im(F + i x F') of `unit_transform`; a subclass replaces it where the two parts cancel."""
        return np.asarray(f.imag + times_depth(z, df).real, dtype=np.float64)

    def transforms(self, z: ComplexArray) -> Transforms:  # noqa: D102
        z = self._centred(z)
        f, df = self.unit_transform(z)
        h = self.unit_shear_field(z, f, df)
        normal, tangential = self.normal_force, self.tangential_force
        return Transforms(normal * f, normal * df, tangential * f, tangential * df, tangential * h)

    def spectrum(self, k: FloatArray) -> Spectrum:  # noqa: D102
        unit = self.unit_spectrum(k) * self._shifted(k)
        return Spectrum(np.asarray(self.normal_force * unit), np.asarray(self.tangential_force * unit))

    def _shifted(self, k: FloatArray) -> ComplexArray:
        """The factor by which a contact's place changes its spectrum."""
        return np.asarray(np.exp(-1j * k * np.asarray(self.position, dtype=np.float64)))

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        at = np.broadcast_to(np.asarray(self.position, dtype=np.float64), self.shape)
        return at, at

    def pressure(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return scaled(self.normal_force, self.unit_pressure(self._from_centre(y)))

    def shear(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return scaled(self.tangential_force, self.unit_pressure(self._from_centre(y)))

    def _centred(self, z: ComplexArray) -> ComplexArray:
        return np.asarray(z - np.asarray(self.position, dtype=np.float64))

    def _from_centre(self, y: npt.ArrayLike) -> FloatArray:
        return np.asarray(_check.real("y", y, unit="m") - np.asarray(self.position, dtype=np.float64))

    def expand(self, axes: int = 1) -> Self:  # noqa: D102
        shape = self.shape
        tail = (1,) * axes
        wide = copy.copy(
            self
        )  # not `replace`: what has been checked, and warned of, once is not checked again
        for name, value in self._parameters().items():
            wide._set(name, _check.read_only(np.broadcast_to(value, shape).reshape(shape + tail)))
        return wide
