"""The line load: a knife edge across the skin (memo eqs. 1 to 4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._check import ComplexArray, FloatArray
from .base import ProportionalContact

__all__ = ["LineLoad"]


@dataclass(frozen=True)
class LineLoad(ProportionalContact):
    """A load on a line of no width, F(z) = -1/z (Flamant 1892; memo eqs. 1 to 4).

    Parameters
    ----------
    force : array_like
        Magnitude P [N/m], >= 0.
    angle : array_like, optional
        Angle from the inward normal [rad], positive where it drags the skin towards +y.
    position : array_like, optional
        Place y [m].

    Examples
    --------
    >>> knife = LineLoad(force=40.0, angle=0.3, position=0.8e-3)
    >>> round(float(knife.normal_force), 3), round(float(knife.tangential_force), 3)
    (38.213, 11.821)
    """

    def unit_transform(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:  # noqa: D102
        r = 1 / z
        return -r, r * r

    def unit_shear_field(self, z: ComplexArray, f: ComplexArray, df: ComplexArray) -> FloatArray:  # noqa: D102
        return np.asarray(2 * z.imag * (z.real * (f.real**2 + f.imag**2)) ** 2, dtype=np.float64)

    def unit_pressure(self, y: FloatArray) -> FloatArray:  # noqa: D102
        return np.where(y == 0, np.inf, 0.0)

    def singular_points(self) -> tuple[FloatArray, ...]:  # noqa: D102
        return (np.broadcast_to(np.asarray(self.position, dtype=np.float64), self.shape),)
