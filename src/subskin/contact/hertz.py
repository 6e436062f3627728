"""The Hertz contact: a round body on a flat skin, or the other way round (memo eqs. 16 and 17)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from ..material import Material
from .functions import jinc, root
from .spread import SpreadContact, pressing

__all__ = ["Hertz"]

_WIDEST = 0.3
"""Half width / radius beyond which `from_radius` warns: the parabola that stands for the circle, y^2/(2R), is
then already 2 % off at the edge of the contact, and the surface slopes by 0.3."""


@dataclass(frozen=True, eq=False)
class Hertz(SpreadContact, name="hertz"):
    """A cylinder on the skin: pressure 2N/(pi a^2) sqrt(a^2 - y^2), F(z) = -2/(z + s), s = sqrt(z^2 - a^2).

    Source: memo eq. (16); docs/theory.md; Johnson, Contact Mechanics (1985), section 4.2. Parameters as of
    `SpreadContact`. The drag is proportional to the pressure: the contact slides. Where it sticks in the middle see
    `PartialSlip`.

    Examples
    --------
    >>> touch = Hertz(force=40.0, angle=0.3, position=0.8e-3, half_width=0.6e-3)
    >>> round(float(touch.pressure(0.8e-3)), 1), float(touch.pressure(1.5e-3))
    (40545.7, 0.0)
    """

    GROWTH = 0.5
    SERIES = (1.0, 1 / 4, 1 / 8, 5 / 64, 7 / 128)

    @classmethod
    def from_radius(
        cls,
        force: npt.ArrayLike,
        radius: npt.ArrayLike,
        material: Material,
        angle: npt.ArrayLike = 0.0,
        position: npt.ArrayLike = 0.0,
        **parameters: npt.ArrayLike,
    ) -> Self:
        """A rigid cylinder of `radius` R [m] on a skin of `material`, in plane strain.

        a = 2 sqrt(N R (1 - nu^2) / (pi E)) with N = P cos(angle). The memo's eq. (17) is twice this, the full
        width (docs/errata.md). `parameters` are the subclass's own, the others as in `SpreadContact`.

        Raises
        ------
        InvalidValueError
            radius <= 0, or a load that does not press (N <= 0).

        Warns
        -----
        ValidityWarning
            half width > 0.3 R: the theory takes the cylinder for a parabola and the slopes for small.

        Examples
        --------
        >>> finger_tip = Hertz.from_radius(force=40.0, radius=8e-3, material=Material(young=0.4e6))
        >>> round(1e3 * float(finger_tip.half_width), 4)
        0.874
        """
        _check.noun("material", material, Material, "Material(young=0.4e6)")
        n = pressing(force, angle, "Hertz contact")
        r = _check.real("radius", radius, unit="m", above=0.0)
        a = 2 * np.sqrt(n * r / (np.pi * material.plane_strain_modulus))
        if (a / r > _WIDEST).any():
            message = (
                f"half width / radius = {float(np.max(a / r)):.3g}: above {_WIDEST} Hertz's parabola is no "
                "longer the cylinder and the slopes are not small; take less force or a stiffer skin"
            )
            _check.warn(message)
        return cls(force=force, angle=angle, position=position, half_width=a, **parameters)

    def unit_transform(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:  # noqa: D102
        s = root(z, self._a)
        w = z + s
        return -2 / w, 2 / (s * w)

    def unit_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        return jinc(k * self._a)

    def unit_pressure(self, y: FloatArray) -> FloatArray:  # noqa: D102
        a = self._a
        return np.asarray(2 / (np.pi * a**2) * np.sqrt(np.maximum((a - y) * (a + y), 0.0)))

    def singular_points(self) -> tuple[FloatArray, ...]:
        """None: the pressure falls to 0 at the edges."""
        return ()
