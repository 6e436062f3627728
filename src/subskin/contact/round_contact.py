"""What the local contacts on a disc have in common."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from .. import _check, _hooks
from .._check import ComplexArray, FloatArray
from .._declared import Real
from ..errors import InvalidValueError
from .axial import AxialContact

__all__ = ["RoundContact"]

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
