"""The point load: Boussinesq's and Cerruti's, and a point torque."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._check import ComplexArray, FloatArray
from .axial import AxialContact
from .kernels import RealForm, point_core, point_family, point_parts

__all__ = ["PointLoad"]


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

    def real_form(self) -> RealForm:  # noqa: D102
        return RealForm(point_parts)

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
