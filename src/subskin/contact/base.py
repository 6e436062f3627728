"""What every contact has to say: its traction, where it acts, and its spectrum.

All fields follow from these. A layered or a round skin answers wavenumber by wavenumber, and asks for the spectrum, the
integral of p(t) exp(-i k t) dt (docs/skins.md). In a half plane the Cauchy transform of a pressure, F(z) = integral of
p(t) / (t - z) dt with z = y + i x, gives the whole field (docs/theory.md): from a closed form where a contact has one,
and otherwise from its traction.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from functools import cached_property, reduce
from typing import ClassVar, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from .._registry import Named
from ..errors import GeometryError, InvalidValueError
from .functions import shear_field
from .quadrature import cauchy

__all__ = ["Contact", "ContactSum", "ProportionalContact", "Spectrum", "Transforms", "transforms_of"]


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


def resolve(force: npt.ArrayLike, angle: npt.ArrayLike) -> FloatArray:
    """N = P cos(angle) and T = P sin(angle), shape (..., 2); at a right angle N is 0, which cos(pi/2) is not."""
    p, alpha = np.asarray(force, dtype=np.float64), np.asarray(angle, dtype=np.float64)
    both = np.empty((*np.broadcast_shapes(p.shape, alpha.shape), 2))
    np.multiply(p, np.where(np.abs(alpha) == np.pi / 2, 0.0, np.cos(alpha)), out=both[..., 0])
    np.multiply(p, np.sin(alpha), out=both[..., 1])
    return _check.read_only(both)


def scaled(force: FloatArray, unit: FloatArray) -> FloatArray:
    """A force times a unit pressure: no force makes nothing, even of an infinite one."""
    with np.errstate(invalid="ignore"):
        return _check.read_only(np.where(force == 0, 0.0, force * unit))


class Contact(Named, ABC):
    """Traction on the skin's surface. Pressure presses in (+x), shear drags the surface towards +y.

    Parameters may be arrays: a contact is then a batch, whose `shape` broadcasts against the points of a field. One
    that has a closed form in a half plane gives it as a method `transforms`, as `ProportionalContact` does.

    Examples
    --------
    A contact of one's own: a ridge whose pressure rises and falls like a cosine, without drag.

    >>> import numpy as np, subskin as ss
    >>> class Cosine(ss.Contact):
    ...     components, support = np.array([2.0, 0.0]), (np.array(-1e-3), np.array(1e-3))  # N/m, m
    ...     def pressure(self, y):
    ...         return np.where(np.abs(y) <= 1e-3, 1e3 * (1 + np.cos(1e3 * np.pi * np.asarray(y))), 0.0)
    ...     def shear(self, y):
    ...         return np.zeros(np.shape(y))
    ...     def spectrum(self, k):
    ...         s = np.asarray(1e-3 * k / np.pi)
    ...         near = np.isclose(s, 1)
    ...         p = np.where(near, 0.5, np.sinc(s) / np.where(near, 1, 1 - s**2))
    ...         return ss.contact.Spectrum(2 * p + 0j, 0j * p)
    >>> skin = ss.Layered(ss.Layer(ss.Material(young=0.4e6), thickness=6e-3))
    >>> round(float(skin.strain(Cosine(), x=2e-3, y=0.0).xx), 6)
    -0.001176
    """

    @property
    @abstractmethod
    def components(self) -> FloatArray:
        """Integrals of the pressure, N, and of the shear, T, positive towards +y [N/m], shape (..., 2)."""

    @abstractmethod
    def spectrum(self, k: FloatArray) -> Spectrum:
        """Fourier transforms at the wavenumbers k >= 0 [1/m], broadcast against the batch."""

    @property
    @abstractmethod
    def support(self) -> tuple[FloatArray, FloatArray]:
        """Positions y [m] between which the contact lies, each of the batch's shape."""

    @abstractmethod
    def pressure(self, y: npt.ArrayLike) -> FloatArray:
        """Pressure on the surface [Pa] at y [m], positive in compression; infinite at a singularity."""

    @abstractmethod
    def shear(self, y: npt.ArrayLike) -> FloatArray:
        """Shear on the surface [Pa] at y [m], positive where it drags the skin towards +y."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch; () for a single contact."""
        return self.components.shape[:-1]

    @property
    def normal_force(self) -> FloatArray:
        """Integral of the pressure, N [N/m]."""
        return self.components[..., 0]

    @property
    def tangential_force(self) -> FloatArray:
        """Integral of the shear, T [N/m], positive towards +y."""
        return self.components[..., 1]

    def singular_points(self) -> tuple[FloatArray, ...]:
        """Positions y [m] on the surface where the stress is infinite, each of the batch's shape; NaN where none is."""
        return ()

    @property
    def breaks(self) -> FloatArray:
        """Positions y [m], ascending, between which the traction is smooth, shape (..., k): its ends at least."""
        low, high = self.support
        inner = [np.where(np.isnan(y), low, y) for y in self.singular_points()]
        return np.sort(np.stack(np.broadcast_arrays(low, high, *inner), axis=-1), axis=-1)

    def expand(self, axes: int = 1) -> Self:
        """The same contact, its batch lengthened by `axes` axes of length one, to broadcast against points.

        Raises
        ------
        InvalidValueError
            A batch whose class does not say how.
        """
        if self.shape:
            raise InvalidValueError(f"a batch of {type(self).__name__}", "its class has to define `expand`")
        return self

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


def sum_of(parts: list[Transforms]) -> Transforms:
    """Transforms of several contacts at once."""
    p, dp, q, dq, hq = (np.asarray(reduce(np.add, same)) for same in zip(*parts, strict=True))
    return Transforms(p, dp, q, dq, hq)


def _parts(contact: Contact) -> tuple[Contact, ...]:
    return contact.parts if isinstance(contact, ContactSum) else (contact,)


def transforms_of(contact: Contact, z: ComplexArray) -> Transforms:
    """Cauchy transforms at z = y + i x (x >= 0), broadcast against the batch: a closed form, else by quadrature."""
    if hasattr(contact, "transforms"):
        closed: Transforms = contact.transforms(z)
        return closed
    (p, dp, _), (q, dq, hq) = (cauchy(traction, contact.breaks, z) for traction in (contact.pressure, contact.shear))
    return Transforms(p, dp, q, dq, hq)


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
    def components(self) -> FloatArray:  # noqa: D102
        return _check.read_only(sum(part.components for part in self.parts))

    @cached_property
    def _terms(self) -> tuple[Contact, ...]:
        """The parts, those of one kind joined where that kind has a quicker way of adding many."""
        kinds: dict[type[Contact], list[Contact]] = {}
        for part in self.parts:
            kinds.setdefault(type(part), []).append(part)
        return tuple(term for kind, group in kinds.items() for term in kind.joined(group))

    def transforms(self, z: ComplexArray) -> Transforms:  # noqa: D102
        return sum_of([transforms_of(part, z) for part in self._terms])

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

    A subclass gives `unit_pressure` and `unit_spectrum`, for N = 1 N/m at position 0, and `unit_transform` where it has
    a closed form. One with a part that is not proportional (a punch's moment, a zone that sticks) adds it in
    `transforms`, `spectrum`, `pressure` and `shear`.

    Parameters
    ----------
    force : array_like
        Magnitude P of the resultant [N/m], >= 0.
    angle : array_like, optional
        Angle of the resultant from the inward normal [rad], in [-pi, pi]: N = P cos(angle), T = P sin(angle)
        towards +y. Beyond pi/2 the load pulls. A right angle is rounded; `of_components` is exact.
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
        fix = "turn the angle instead"
        self._set("force", _check.real("force", self.force, unit="N/m", at_least=0.0, fix=fix))
        fix = "angles are in radians: np.deg2rad(30)"
        angle = _check.real("angle", self.angle, unit="rad", at_least=-np.pi, at_most=np.pi, fix=fix)
        self._set("angle", angle)
        self._set("position", _check.real("position", self.position, unit="m"))
        self._set("_shape", _check.broadcast(**self._parameters()))
        self._set("_components", resolve(self.force, self.angle))

    @classmethod
    def of_components(
        cls, components: npt.ArrayLike, position: npt.ArrayLike = 0.0, **parameters: npt.ArrayLike
    ) -> Self:
        """Contacts of given normal and tangential force, which are kept exactly.

        Parameters
        ----------
        components : array_like, shape (..., 2)
            Normal force N and tangential force T [N/m].
        position : array_like, optional
            Centre of the contact y [m].
        **parameters
            The subclass's own, such as `half_width`.

        Raises
        ------
        InvalidValueError, GeometryError
            A value out of range; shapes that do not broadcast, components that are not two.

        Examples
        --------
        >>> from subskin.contact import LineLoad
        >>> drag = LineLoad.of_components([0.0, 40.0])
        >>> float(drag.normal_force), float(drag.force), round(float(drag.angle), 4)
        (0.0, 40.0, 1.5708)
        """
        both = _check.real("components", components, unit="N/m")
        if both.shape[-1:] != (2,):
            raise GeometryError(f"components of shape {both.shape}", "(..., 2) is needed, N and T", "[40.0, 0.0]")
        n, t = both[..., 0], both[..., 1]
        made = cls(np.hypot(n, t), np.arctan2(t, n), position, **parameters)
        made._set("_components", both)
        return made

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _parameters(self) -> dict[str, FloatArray]:
        return {f.name: np.asarray(getattr(self, f.name), dtype=np.float64) for f in fields(self) if f.init}

    @property
    def shape(self) -> tuple[int, ...]:  # noqa: D102
        shape: tuple[int, ...] = self.__dict__["_shape"]
        return shape

    @property
    def components(self) -> FloatArray:  # noqa: D102
        both: FloatArray = self.__dict__["_components"]
        return both

    @abstractmethod
    def unit_pressure(self, y: FloatArray) -> FloatArray:
        """The pressure with unit resultant, centred at 0 [1/m]."""

    @abstractmethod
    def unit_spectrum(self, k: FloatArray) -> FloatArray:
        """Fourier transform of the pressure with unit resultant, centred at 0: real, for it is symmetric."""

    def unit_transform(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray] | None:
        """F and dF/dz of the pressure with unit resultant, centred at 0; None without a closed form."""
        return None

    def unit_shear_field(self, z: ComplexArray, f: ComplexArray, df: ComplexArray) -> FloatArray:
        """Im(F + i x F') of `unit_transform`; a subclass replaces it where the two parts cancel."""
        return shear_field(z, f, df)

    def transforms(self, z: ComplexArray) -> Transforms:
        """Cauchy transforms at z = y + i x (x >= 0), broadcast against the batch."""
        z = self._centred(z)
        closed = self.unit_transform(z)
        if closed is None:
            f, df, h = cauchy(self.unit_pressure, self.breaks - np.asarray(self.position)[..., None], z)
        else:
            f, df = closed
            h = self.unit_shear_field(z, f, df)
        normal, tangential = self.normal_force, self.tangential_force
        return Transforms(normal * f, normal * df, tangential * f, tangential * df, tangential * h)

    def spectrum(self, k: FloatArray) -> Spectrum:  # noqa: D102
        unit = self.unit_spectrum(k) * self._shifted(k)
        return Spectrum(np.asarray(self.normal_force * unit), np.asarray(self.tangential_force * unit))

    def _shifted(self, k: FloatArray) -> ComplexArray:
        """The factor by which a contact's position changes its spectrum."""
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
        shape, tail = self.shape, (1,) * axes
        wide = copy.copy(self)  # not `replace`: what has been checked, and warned of, once is not checked again
        for name, value in self._parameters().items():
            wide._set(name, _check.read_only(np.broadcast_to(value, shape).reshape(shape + tail)))
        both = np.broadcast_to(self.components, (*shape, 2)).reshape((*shape, *tail, 2))
        wide._set("_components", _check.read_only(both))
        wide._set("_shape", shape + tail)
        return wide
