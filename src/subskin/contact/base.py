"""What every contact has to say: its traction, where it acts, and its spectrum.

All fields follow from these. A layered or a round skin answers wavenumber by wavenumber, and asks for the spectrum, the
integral of p(t) exp(-i k t) dt (docs/skins.md). In a half plane the Cauchy transform of a pressure, F(z) = integral of
p(t) / (t - z) dt with z = y + i x, gives the whole field (docs/theory.md): from a closed form where a contact has one,
and otherwise from its traction.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from .. import _check, _hooks
from .._check import ComplexArray, FloatArray
from .._frozen import Named
from ..errors import InvalidValueError
from .functions import cauchy

__all__ = ["Contact", "ContactSum", "Spectrum", "Transforms", "sum_of"]


class Transforms(NamedTuple):
    """Cauchy transforms of the pressure (`p`) and of the shear (`q`), and their derivatives (`dp`, `dq`).

    `hq` is Im(q + i x dq). Deep beneath a contact its two parts cancel all but a share of (half width / depth)^2, which
    is then all the stress that a drag causes there; so each contact says how to find it without that loss.
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


class Contact(Named, ABC):
    """Traction on the skin's surface. Pressure presses in (+x), shear drags the surface towards +y.

    Parameters may be arrays: a contact is then a batch, whose `shape` broadcasts against the points of a field. One
    that has a closed form in a half plane gives it as its `transforms`.

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

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        _hooks.check_members(cls, _MEMBERS)

    @property
    @abstractmethod
    def components(self) -> FloatArray:
        """Integrals of the pressure, N, and of the shear, T, positive towards +y [N/m], shape (..., 2)."""

    @abstractmethod
    def spectrum(self, k: FloatArray) -> Spectrum:
        """Fourier transforms at the wavenumbers `k` >= 0 [1/m], broadcast against the batch.

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> ss.LineLoad(force=40.0).spectrum(np.array([0.0, 500.0])).p.real.tolist()
        [40.0, 40.0]
        """

    @property
    @abstractmethod
    def support(self) -> tuple[FloatArray, FloatArray]:
        """Positions y [m] between which the contact lies, each of the batch's shape."""

    @abstractmethod
    def pressure(self, y: npt.ArrayLike) -> FloatArray:
        """Pressure on the surface [Pa] at `y` [m], positive in compression; infinite at a singularity."""

    @abstractmethod
    def shear(self, y: npt.ArrayLike) -> FloatArray:
        """Shear on the surface [Pa] at `y` [m], positive where it drags the skin towards +y."""

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

    def transforms(self, z: ComplexArray) -> Transforms:
        """Cauchy transforms, by quadrature of the traction where a contact gives no closed form.

        Parameters
        ----------
        z : ndarray
            Points y + i x [m], x >= 0, of a shape that broadcasts against the batch.

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> ss.LineLoad(force=2.0).transforms(np.array(4j)).p.imag.tolist()
        0.5
        """
        (p, dp, _), (q, dq, hq) = (cauchy(traction, self.breaks, z) for traction in (self.pressure, self.shear))
        return Transforms(p, dp, q, dq, hq)

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
            raise InvalidValueError(
                f"a batch of {type(self).__name__}",
                "its class has to define `expand`",
                "define expand, or give one contact at a time",
            )
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


def _points(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> tuple[Any, ...]:
    if not isinstance(given, tuple | list):
        raise _hooks.wrong(said, given, "positions are needed, an array for each", "return (self.position,)")
    return tuple(_PER_CONTACT(f"{said}[{i}]", own, part, ()) for i, part in enumerate(given))


_FIELD, _REAL = _hooks.field(), _hooks.field(real=True)
_PER_CONTACT = _REAL  # of no arguments
_MEMBERS: dict[str, _hooks.Rule] = {
    "shape": _hooks.batch_shape,
    "components": _hooks.numbers("N and T on the last axis", last=2),
    "support": _hooks.each_of((_PER_CONTACT, _PER_CONTACT), "two ends"),
    "pressure": _REAL,
    "shear": _REAL,
    "spectrum": _hooks.each_of((_FIELD,) * 2, "two arrays, of pressure and shear,", Spectrum),
    "transforms": _hooks.each_of((_FIELD,) * 4 + (_REAL,), "five arrays, p, dp, q, dq and hq,", Transforms),
    "singular_points": _points,
    "expand": _hooks.expanded(Contact),
}


def sum_of(parts: list[Transforms]) -> Transforms:
    """Transforms of several contacts at once."""
    p, dp, q, dq, hq = (np.asarray(reduce(np.add, same)) for same in zip(*parts, strict=True))
    return Transforms(p, dp, q, dq, hq)


def _parts(contact: Contact) -> tuple[Contact, ...]:
    return contact.parts if isinstance(contact, ContactSum) else (contact,)


@dataclass(frozen=True, eq=False)
class ContactSum(Contact):
    """Several contacts at once, its `parts`: tractions add, so do the fields.

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
        return sum_of([part.transforms(z) for part in self._terms])

    def spectrum(self, k: FloatArray) -> Spectrum:  # noqa: D102
        parts = [part.spectrum(k) for part in self.parts]
        return Spectrum(np.asarray(sum(s.p for s in parts)), np.asarray(sum(s.q for s in parts)))

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        lows, highs = zip(*(part.support for part in self.parts), strict=True)
        low, high = reduce(np.minimum, lows), reduce(np.maximum, highs)
        return np.broadcast_to(low, self.shape), np.broadcast_to(high, self.shape)

    def pressure(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return _check.read_only(sum(part.pressure(y) for part in self.parts))

    def shear(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return _check.read_only(sum(part.shear(y) for part in self.parts))

    def singular_points(self) -> tuple[FloatArray, ...]:  # noqa: D102
        return tuple(point for part in self.parts for point in part.singular_points())

    def expand(self, axes: int = 1) -> ContactSum:  # noqa: D102
        return ContactSum(tuple(part.expand(axes) for part in self.parts))
