"""Local contacts whose shape is the same in all directions about their centre."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _hooks
from .._check import FloatArray
from ..errors import InvalidValueError
from .local import RadialTerm
from .shaped import ShapedContact

__all__ = ["AxialContact"]


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
