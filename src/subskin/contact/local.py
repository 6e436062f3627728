"""What every local contact has to say: one that acts on an area of the surface, with forces in N.

Pressure presses in (+x), drag moves the surface along +y and +z. A field needs of a traction f only its family W_m:
f continued harmonically into the skin (m = 0), and its Riesz transforms. In two dimensions of Fourier, with
k = (k cos phi, k sin phi),

    W_m  <->  i^m e^{i m phi} e^{-k x} f^(k),    V_m = integral of W_m from x to infinity  <->  W_m / k

(docs/local_contacts.md). A drag q = q_y + i q_z is complex; its conjugate has a family of its own.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from .. import _check, _hooks
from .._check import ComplexArray, FloatArray
from .._frozen import Named
from ..errors import InvalidValueError
from .area import area_families

__all__ = [
    "LocalContact",
    "LocalSpectrum",
    "LocalSum",
    "LocalTransforms",
    "Potentials",
    "RadialTerm",
    "local_potentials_of",
    "local_transforms_of",
]


class LocalTransforms(NamedTuple):
    """The families W_m, m = 0 ... 3, of the pressure (`p`), of the drag q_y + i q_z (`q`) and of its conjugate (`r`).

    Each has the shape (4, ...); `dp`, `dq` and `dr` are their derivatives along x. `sq` is W_0 + x W_0'/2 of the drag:
    beneath a narrow contact its two parts cancel, so each contact says how to find it without that loss. A moment M on
    a shape has a drag whose families need no derivative: `t` is (i M / 2) W_m' of the shape, m = 1, 2, shape (2, ...).
    """

    p: ComplexArray
    dp: ComplexArray
    q: ComplexArray
    dq: ComplexArray
    r: ComplexArray
    dr: ComplexArray
    sq: ComplexArray
    t: ComplexArray


class Potentials(NamedTuple):
    """V_m, m = 0 ... 2, of the pressure (`p`), the drag (`q`) and its conjugate (`r`), each of the shape (3, ...).

    `t` is (i M / 2) W_1 of the shape on which a moment M acts, shape (...).
    """

    p: ComplexArray
    q: ComplexArray
    r: ComplexArray
    t: ComplexArray


class LocalSpectrum(NamedTuple):
    """Fourier transforms of the pressure (`p`) and the drag (`qy`, `qz`): integral of p(y, z) exp(-i k.(y, z)) [N]."""

    p: ComplexArray
    qy: ComplexArray
    qz: ComplexArray


class RadialTerm(NamedTuple):
    """A part of a contact whose shape is the same in all directions about a centre.

    Parameters
    ----------
    components : ndarray, shape (..., 3)
        N, Ty, Tz [N], each spread as the shape is.
    moment : ndarray, shape (...)
        Moment about the inward normal [N m], whose drag is -(moment / 2) i (d/dy + i d/dz) of the shape.
    position : ndarray, shape (..., 2)
        The centre [m].
    spectrum : callable
        Hankel transform of the shape of unit load, as a function of the wavenumber k >= 0 [1/m]; 1 at k = 0.
    """

    components: FloatArray
    moment: FloatArray
    position: FloatArray
    spectrum: Callable[[FloatArray], FloatArray]


class LocalContact(Named, ABC):
    """Traction on an area of the skin's surface.

    Parameters may be arrays: a contact is then a batch, whose `shape` broadcasts against the points of a field. One
    that has a closed form in a half space gives it as two methods, `transforms` and `potentials`; without them the
    traction is integrated (`OUTLINE` says where it is smooth).

    Examples
    --------
    A contact of one's own: a pressure that rises like a hill on a square, without drag.

    >>> import numpy as np, subskin as ss
    >>> class Hill(ss.LocalContact):
    ...     components, moment, position = np.array([1.0, 0.0, 0.0]), np.array(0.0), np.zeros(2)  # N, N m, m
    ...     support = (np.full(2, -1e-3), np.full(2, 1e-3))  # m
    ...     def pressure(self, y, z):
    ...         y, z = np.asarray(y) / 1e-3, np.asarray(z) / 1e-3
    ...         return 9e6 / 16 * np.maximum(1 - y**2, 0) * np.maximum(1 - z**2, 0)
    ...     def shear(self, y, z):
    ...         return np.zeros((*np.broadcast_shapes(np.shape(y), np.shape(z)), 2))
    >>> skin = ss.HalfSpace(ss.Material(young=0.4e6))
    >>> round(float(skin.stress(Hill(), x=1e-3, y=0.0, z=0.0).xx))
    -245245
    """

    OUTLINE: ClassVar[Literal["rectangle", "ellipse"]] = "rectangle"
    """Where the traction is smooth: in all of `support`, or in the ellipse that fills it."""

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        _hooks.check_members(cls, _MEMBERS)

    @property
    @abstractmethod
    def components(self) -> FloatArray:
        """Resultant (N, Ty, Tz) [N], shape (..., 3): N presses in, Ty and Tz drag towards +y and +z."""

    @property
    @abstractmethod
    def position(self) -> FloatArray:
        """Where the contact is: its centre (y, z) [m], shape (..., 2)."""

    @property
    @abstractmethod
    def moment(self) -> FloatArray:
        """Moment about the inward normal at `position` [N m], shape (...), positive from +y to +z."""

    @property
    def torque(self) -> FloatArray:
        """Moment of all the drag about the inward normal at `position` [N m], shape (...): with what its slopes add."""
        return self.moment

    @property
    @abstractmethod
    def support(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest (y, z) [m] of a rectangle that holds the contact, each of shape (..., 2)."""

    @abstractmethod
    def pressure(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:
        """Pressure on the surface [Pa] at `y`, `z` [m], positive in compression; infinite at a singularity."""

    @abstractmethod
    def shear(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:
        """Drag (q_y, q_z) on the surface [Pa] at `y`, `z` [m], shape (..., 2)."""

    def spectrum(self, ky: FloatArray, kz: FloatArray) -> LocalSpectrum:
        """Fourier transforms at the wave vectors (`ky`, `kz`) [1/m], broadcast against the batch; for layers and maps.

        Raises
        ------
        InvalidValueError
            A contact of one's own whose class does not say it.
        """
        seen, rule = f"the spectrum of a {type(self).__name__}", "layers and maps need it, and its class says none"
        raise InvalidValueError(seen, rule, "define `spectrum(ky, kz)` in its class")

    @property
    def radial_terms(self) -> tuple[RadialTerm, ...] | None:
        """The contact as a sum of parts that are the same in all directions about their centres; None if it is none."""
        return None

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch; () for a single contact."""
        return self.components.shape[:-1]

    @property
    def normal_force(self) -> FloatArray:
        """Integral of the pressure, N [N]."""
        return self.components[..., 0]

    @property
    def tangential_force(self) -> FloatArray:
        """Integral of the drag, (Ty, Tz) [N], shape (..., 2)."""
        return self.components[..., 1:]

    @property
    def force(self) -> FloatArray:
        """Magnitude of the resultant [N]."""
        return np.hypot(self.normal_force, np.hypot(self.components[..., 1], self.components[..., 2]))

    @property
    def angle(self) -> FloatArray:
        """Angle of the resultant from the inward normal [rad], in [0, pi]."""
        return np.arctan2(np.hypot(self.components[..., 1], self.components[..., 2]), self.normal_force)

    @property
    def azimuth(self) -> FloatArray:
        """Direction of the drag from +y towards +z [rad]."""
        return np.arctan2(self.components[..., 2], self.components[..., 1])

    def singular(self, y: FloatArray, z: FloatArray) -> npt.NDArray[np.bool_]:
        """Whether the stress is infinite on the surface at `y`, `z` [m], of shapes that broadcast."""
        return np.zeros(np.broadcast_shapes(self.shape, y.shape, z.shape), dtype=bool)

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

    def __add__(self, other: object) -> LocalSum:
        if not isinstance(other, LocalContact):
            return NotImplemented
        return LocalSum((*_parts(self), *_parts(other)))

    def __radd__(self, other: object) -> LocalContact:
        # sum([...]) starts from the integer 0
        return self if isinstance(other, int) and other == 0 else NotImplemented


def _terms(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
    if not isinstance(given, tuple | list) or not all(isinstance(term, RadialTerm) for term in given):
        raise _hooks.wrong(said, given, "a tuple of RadialTerm, or None, is needed")
    return tuple(given)


def _outline(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
    _check.choice(said, given, ("rectangle", "ellipse"))
    return given


_FIELD, _REAL = _hooks.field(), _hooks.field(real=True)
_PAIR = _hooks.field(after=(2,), real=True)
_FAMILIES = _hooks.field(before=(4,))
_V = _hooks.field(before=(3,))
_TRANSFORMS = (*(_FAMILIES,) * 6, _FIELD, _hooks.field(before=(2,)))
_MEMBERS: dict[str, _hooks.Rule] = {
    "shape": _hooks.batch_shape,
    "components": _hooks.numbers("N, Ty and Tz on the last axis", last=3),
    "position": _hooks.numbers("y and z on the last axis", last=2),
    "moment": _REAL,
    "support": _hooks.each_of((_PAIR, _PAIR), "two corners (y, z)"),
    "pressure": _REAL,
    "shear": _PAIR,
    "spectrum": _hooks.each_of((_FIELD,) * 3, "three arrays, p, qy and qz,", LocalSpectrum),
    "transforms": _hooks.optional(_hooks.each_of(_TRANSFORMS, "the arrays of LocalTransforms", LocalTransforms)),
    "potentials": _hooks.optional(_hooks.each_of((_V, _V, _V, _FIELD), "the four arrays of Potentials", Potentials)),
    "radial_terms": _hooks.optional(_terms),
    "singular": _hooks.truths,
    "OUTLINE": _outline,
    "expand": _hooks.expanded(LocalContact),
}


def _parts(contact: LocalContact) -> tuple[LocalContact, ...]:
    return contact.parts if isinstance(contact, LocalSum) else (contact,)


def local_transforms_of(contact: LocalContact, x: FloatArray, y: FloatArray, z: FloatArray) -> LocalTransforms:
    """Families of a contact at points: a closed form where it has one, else by quadrature.

    Parameters
    ----------
    contact : LocalContact
        What presses.
    x, y, z : ndarray
        Points [m], x >= 0, of one shape, which broadcasts against the batch. At x = 0 derivatives are not defined.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> x, zero = np.array(1.0), np.array(0.0)
    >>> round(float(local_transforms_of(ss.PointLoad(force=1.0), x, zero, zero).p[0].real * 2 * np.pi), 12)
    1.0
    """
    if hasattr(contact, "transforms"):
        closed: LocalTransforms | None = contact.transforms(x, y, z)
        if closed is not None:
            return closed
    (p, a, b), (dp, da, db) = area_families(contact, (0, 1), x, y, z)
    q, dq = a + 1j * b, da + 1j * db
    none = np.zeros((2, *p.shape[1:]), dtype=np.complex128)
    return LocalTransforms(p, dp, q, dq, a - 1j * b, da - 1j * db, np.asarray(q[0] + 0.5 * x * dq[0]), none)


def local_potentials_of(contact: LocalContact, x: FloatArray, y: FloatArray, z: FloatArray) -> Potentials:
    """V_m of a contact at points, for displacements; parameters as in `local_transforms_of`: `x`, `y`, `z` [m].

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> x, zero = np.array(2.0), np.array(0.0)
    >>> round(float(local_potentials_of(ss.PointLoad(force=1.0), x, zero, zero).p[0].real * 2 * np.pi), 12)
    0.5
    """
    if hasattr(contact, "potentials"):
        closed: Potentials | None = contact.potentials(x, y, z)
        if closed is not None:
            return closed
    p, a, b = -area_families(contact, (-1,), x, y, z)[0]
    return Potentials(p, a + 1j * b, a - 1j * b, np.zeros_like(p[0]))


@dataclass(frozen=True, eq=False)
class LocalSum(LocalContact):
    """Several local contacts at once, its `parts`: tractions add, so do the fields.

    Examples
    --------
    >>> import subskin as ss
    >>> two = ss.PointLoad(force=3.0, position=(-1e-3, 0.0)) + ss.PointLoad(force=1.0, position=(1e-3, 0.0))
    >>> float(two.normal_force)
    4.0
    """

    parts: tuple[LocalContact, ...]

    @property
    def shape(self) -> tuple[int, ...]:  # noqa: D102
        return np.broadcast_shapes(*(part.shape for part in self.parts))

    @property
    def components(self) -> FloatArray:  # noqa: D102
        return _check.read_only(sum(part.components for part in self.parts))

    @property
    def position(self) -> FloatArray:
        """The centre of the support [m], shape (..., 2)."""
        low, high = self.support
        return _check.read_only(0.5 * (low + high))

    @property
    def moment(self) -> FloatArray:
        """Moment about the inward normal at `position` [N m]: the parts' own, and that of their drags."""
        total, at = np.zeros(self.shape), self.position
        for part in self.parts:
            arm, drag = part.position - at, part.tangential_force
            total = total + part.torque + arm[..., 0] * drag[..., 1] - arm[..., 1] * drag[..., 0]
        return _check.read_only(total)

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        lows, highs = zip(*(part.support for part in self.parts), strict=True)
        low, high = reduce(np.minimum, lows), reduce(np.maximum, highs)
        return np.broadcast_to(low, (*self.shape, 2)), np.broadcast_to(high, (*self.shape, 2))

    def pressure(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return _check.read_only(sum(part.pressure(y, z) for part in self.parts))

    def shear(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return _check.read_only(sum(part.shear(y, z) for part in self.parts))

    def spectrum(self, ky: FloatArray, kz: FloatArray) -> LocalSpectrum:  # noqa: D102
        each = (part.spectrum(ky, kz) for part in self.parts)
        return LocalSpectrum(*(np.asarray(reduce(np.add, same)) for same in zip(*each, strict=True)))

    @property
    def radial_terms(self) -> tuple[RadialTerm, ...] | None:  # noqa: D102
        each = [part.radial_terms for part in self.parts]
        known = [terms for terms in each if terms is not None]
        return sum(known, ()) if len(known) == len(each) else None

    def transforms(self, x: FloatArray, y: FloatArray, z: FloatArray) -> LocalTransforms:
        """As `local_transforms_of`."""
        points = self._of_all(x, y, z)
        each = (local_transforms_of(part, *points) for part in self.parts)
        return reduce(lambda one, two: LocalTransforms(*map(np.add, one, two)), each)

    def potentials(self, x: FloatArray, y: FloatArray, z: FloatArray) -> Potentials:
        """As `local_potentials_of`, at `x`, `y`, `z`."""
        points = self._of_all(x, y, z)
        each = (local_potentials_of(part, *points) for part in self.parts)
        return reduce(lambda one, two: Potentials(*map(np.add, one, two)), each)

    def _of_all(self, *points: FloatArray) -> list[FloatArray]:
        """Coordinates in the shape of the whole sum: beside a batch a single contact answers for each of it."""
        shape = np.broadcast_shapes(self.shape, *(part.shape for part in points))
        return [np.broadcast_to(part, shape) for part in points]

    def singular(self, y: FloatArray, z: FloatArray) -> npt.NDArray[np.bool_]:  # noqa: D102
        return reduce(np.logical_or, (part.singular(y, z) for part in self.parts))

    def expand(self, axes: int = 1) -> LocalSum:  # noqa: D102
        return LocalSum(tuple(part.expand(axes) for part in self.parts))
