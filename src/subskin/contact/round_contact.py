"""Local contacts whose shape is the same in all directions about their centre: a point, and those on a disc."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from .. import _check, _hooks
from .._check import ComplexArray, FloatArray
from .._declared import Real
from ..errors import InvalidValueError
from .kernels import RealForm, point_core, point_family, point_parts
from .local import RadialTerm
from .shaped import ShapedContact

__all__ = ["AxialContact", "PointLoad", "RoundContact"]


@dataclass(frozen=True, eq=False, init=False)
class AxialContact(ShapedContact):
    """A contact whose shape f(r) depends on the distance from its centre alone.

    One on a disc is a `RoundContact`. Parameters as in `ShapedContact`.

    Examples
    --------
    >>> import subskin as ss
    >>> isinstance(ss.PointLoad(force=1.0), ss.contact.AxialContact)
    True
    """

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        _hooks.check_members(cls, _MEMBERS)

    @abstractmethod
    def unit_radial_pressure(self, r: FloatArray) -> FloatArray:
        """The shape f [1/m^2] at the distance `r` [m] from its centre."""

    @abstractmethod
    def unit_radial_spectrum(self, k: FloatArray) -> FloatArray:
        """Hankel transform, 2 pi times the integral of f(r) J_0(k r) r dr, at `k` >= 0 [1/m]; 1 at 0."""

    def unit_radial_slope(self, r: FloatArray) -> FloatArray:
        """The slope df/dr [1/m^3] at the distance `r` [m], by which a moment drags.

        Raises
        ------
        InvalidValueError
            A shape that does not say it.
        """
        raise InvalidValueError(f"the drag of a moment on a {type(self).__name__}", "its class has to say how it falls")

    def unit_pressure(self, y: FloatArray, z: FloatArray) -> FloatArray:  # noqa: D102
        return self.unit_radial_pressure(np.hypot(y, z))

    def unit_slope(self, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        r = np.hypot(y, z)
        slope, away = self.unit_radial_slope(r), np.where(r > 0, r, 1.0)
        with np.errstate(invalid="ignore"):
            return np.where(y == 0, 0.0, slope * y / away), np.where(z == 0, 0.0, slope * z / away)

    def unit_spectrum(self, ky: FloatArray, kz: FloatArray) -> FloatArray:  # noqa: D102
        return self.unit_radial_spectrum(np.hypot(ky, kz))

    @property
    def radial_terms(self) -> tuple[RadialTerm, ...]:  # noqa: D102
        return (RadialTerm(self.components, self.moment, self.position, self.unit_radial_spectrum),)


_MEMBERS = dict.fromkeys(
    ("unit_radial_pressure", "unit_radial_spectrum", "unit_radial_slope", "disc_slope"), _hooks.field(real=True)
)


_WIDTH = "give half of the contact's width in metres; one of no width is a PointLoad"


@dataclass(frozen=True, eq=False, init=False)
class RoundContact(AxialContact):
    """A contact on a disc, the same in all directions.

    A subclass gives its functions for a disc of radius 1: `disc_pressure`, `disc_slope`, `disc_spectrum`, and where it
    has a closed form `disc_family` and `disc_core`.

    Parameters
    ----------
    force, angle, azimuth, position, components, moment : array_like
        As in `ShapedContact` [N], [rad], [rad], [m], [N], [N m].
    half_width : array_like
        Radius a of the disc [m], > 0, of a shape that broadcasts against theirs; required.

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; shapes that do not broadcast.

    Examples
    --------
    A contact of one's own: a pressure that fades out smoothly at the rim.

    >>> import numpy as np, subskin as ss
    >>> from scipy.special import spherical_jn
    >>> class Soft(ss.contact.RoundContact):
    ...     def disc_pressure(self, r):
    ...         return 2.5 / np.pi * np.maximum(1 - r**2, 0) ** 1.5
    ...     def disc_spectrum(self, k):
    ...         return 15 * spherical_jn(2, k) / np.maximum(k, 1e-6) ** 2
    >>> touch = Soft(force=1.0, half_width=1e-3)
    >>> round(float(ss.HalfSpace(ss.Material(young=0.4e6)).stress(touch, x=1e-3, y=0.0, z=0.0).xx))
    -283451
    """

    OUTLINE: ClassVar[Literal["rectangle", "ellipse"]] = "ellipse"

    # required: NaN is refused
    half_width: Annotated[FloatArray, Real("m", above=0.0, fix=_WIDTH)] = np.nan  # type: ignore[assignment]

    @abstractmethod
    def disc_pressure(self, r: FloatArray) -> FloatArray:
        """The shape at the distance `r` from the centre, the radius and the load being 1."""

    def disc_slope(self, r: FloatArray) -> FloatArray:
        """The slope df/dr of `disc_pressure`, by which a moment drags.

        Raises
        ------
        InvalidValueError
            A shape that does not say it.
        """
        raise InvalidValueError(f"the drag of a moment on a {type(self).__name__}", "its class has to say `disc_slope`")

    @abstractmethod
    def disc_spectrum(self, k: FloatArray) -> FloatArray:
        """Hankel transform of the shape of radius 1 at `k` >= 0; 1 at 0."""

    def disc_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray | None:
        """`ShapedContact.unit_family` for a radius of 1."""
        return None

    def unit_radial_pressure(self, r: FloatArray) -> FloatArray:  # noqa: D102
        t = np.asarray(r / self.half_width)
        own = _check.returned(f"{type(self).__name__}.disc_pressure", self.disc_pressure(t), t.shape)
        return np.asarray(own / self.half_width**2)

    def unit_radial_slope(self, r: FloatArray) -> FloatArray:  # noqa: D102
        return np.asarray(self.disc_slope(r / self.half_width) / self.half_width**3)

    def unit_radial_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        a = self.half_width
        if a.size > 1 and (a == a.flat[0]).all():  # a batch of one radius is one spectrum
            return np.broadcast_to(
                self._disc_spectrum(np.asarray(k * a.flat[0])), np.broadcast_shapes(k.shape, a.shape)
            )
        return self._disc_spectrum(np.asarray(k * a))

    def _disc_spectrum(self, k: FloatArray) -> FloatArray:
        said, own = f"{type(self).__name__}.disc_spectrum", self.disc_spectrum(k)
        found: FloatArray = _check.returned(said, own, k.shape, exactly=True)
        return found

    def unit_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray | None:  # noqa: D102
        a = self.half_width
        depth, away = np.asarray(x / a), np.asarray(zeta / a)
        found = self.disc_family(order, depth, away)
        if found is None:
            return None
        rule = _hooks.field(before=(3 + (order >= 0),))
        found = rule(f"{type(self).__name__}.disc_family", self, found, (depth, away))
        return np.asarray(found / a ** (2 + order))

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        reach = self.half_width[..., None]
        return self.position - reach, self.position + reach


@dataclass(frozen=True, eq=False, init=False)
class PointLoad(AxialContact, name="point"):
    """A force on a point, V_m = (-w)^m / (2 pi R), w = (y + i z) / (R + x) (Boussinesq 1885, Cerruti 1882).

    Source: docs/local_contacts.md; Johnson, Contact Mechanics (1985), sections 3.2 and 3.6. Parameters as in
    `ShapedContact`.

    Examples
    --------
    >>> touch = PointLoad(force=1.5, angle=0.3, azimuth=0.8, position=(1e-3, -2e-3))
    >>> touch.components.round(4).tolist()
    [1.433, 0.3088, 0.318]
    >>> PointLoad(components=(1.0, 0.0, 0.2), moment=1e-3).azimuth.round(4).tolist()
    1.5708
    """

    def unit_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray:  # noqa: D102
        return point_family(order, x, zeta)

    @staticmethod
    def FORM() -> RealForm:
        """The real form of a point load."""
        return RealForm(point_parts)

    def real_form(self) -> RealForm:  # noqa: D102
        return self.FORM()

    def unit_core(self, x: FloatArray, zeta: ComplexArray, w: ComplexArray, dw: ComplexArray) -> ComplexArray:  # noqa: D102
        return point_core(x, zeta)

    def unit_radial_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        return np.ones_like(k)

    def unit_radial_pressure(self, r: FloatArray) -> FloatArray:  # noqa: D102
        return np.where(r == 0, np.inf, 0.0)

    def unit_radial_slope(self, r: FloatArray) -> FloatArray:  # noqa: D102
        return np.where(r == 0, -np.inf, 0.0)

    def singular(self, y: FloatArray, z: FloatArray) -> npt.NDArray[np.bool_]:
        """As `LocalContact.singular`: where it acts."""
        return np.asarray(self._zeta(y, z) == 0)
