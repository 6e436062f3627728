"""Round long bodies: the Hertz contact (memo eqs. 16, 17), and that which sticks in the middle (Cattaneo, Mindlin)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from .._declared import Real
from ..errors import InvalidValueError
from ..material import Material
from .base import Spectrum, Transforms
from .functions import Pair, inverse, jinc, joined, root, times
from .spread import SpreadContact, pressing

__all__ = ["Hertz", "PartialSlip"]


def hertz(xp: Any, x: Any, y: Any, a: Any) -> tuple[Pair, Pair]:
    """F = -2 / (z + s) and F' = 2 / (s (z + s)), s^2 = z^2 - a^2, of unit load (memo eq. 16; `ProportionalContact`)."""
    s = root(xp, x, y, a)
    w = y + s[0], x + s[1]
    return inverse(w, -2.0), inverse(times(s, w), 2.0)


def sticking(xp: Any, x: Any, y: Any, a: Any, inset: Any, c: Any, sticks: Any) -> tuple[Pair, Pair]:
    """The same of the drag of one that sticks for |y| < c = a - inset, of unit drag: mu N (F_a - (c/a)^2 F_c).

    mu N = T / (1 - c^2/a^2) is divided out: no difference is left to be small.
    """
    s, r = root(xp, x, y, a), root(xp, x, y, a, inset)
    w, v, both = (y + s[0], x + s[1]), (y + r[0], x + r[1]), (s[0] + r[0], s[1] + r[1])
    zone = inverse(times(both, times(w, v)), c * c)
    turned = times(times(zone, (w[0] + r[0], w[1] + r[1])), inverse(times(s, r)))
    f, df = hertz(xp, x, y, a)
    return (
        (f[0] - 2 * xp.where(sticks, zone[0], 0.0), f[1] - 2 * xp.where(sticks, zone[1], 0.0)),
        (df[0] + 2 * xp.where(sticks, turned[0], 0.0), df[1] + 2 * xp.where(sticks, turned[1], 0.0)),
    )


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
    FORM = staticmethod(hertz)

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

    def unit_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        return jinc(k * self._a)

    def unit_pressure(self, y: FloatArray) -> FloatArray:  # noqa: D102
        a = self._a
        return np.asarray(2 / (np.pi * a**2) * np.sqrt(np.maximum((a - y) * (a + y), 0.0)))

    def singular_points(self) -> tuple[FloatArray, ...]:
        """None: the pressure falls to 0 at the edges."""
        return ()


@dataclass(frozen=True, eq=False)
class PartialSlip(Hertz):
    """A Hertz contact that is dragged by less than friction can hold: it sticks for |y - position| < c and
    slips beyond.

    The shear is mu times the Hertz pressure, less the same on the narrower stick zone, c = a sqrt(1 - |T|/(mu
    N)). Source: docs/theory.md; Johnson, Contact Mechanics (1985),
    section 7.2. It holds for a force that presses first and then drags, |tan(angle)| <= friction. Other
    parameters as in `SpreadContact`.

    Parameters
    ----------
    friction : array_like
        Coefficient of friction mu [-], > 0; required.

    Raises
    ------
    InvalidValueError, GeometryError
        |T| > mu N: it slides (then it is a `Hertz`); a value out of range; shapes that do not broadcast.

    Examples
    --------
    >>> touch = PartialSlip(force=40.0, angle=0.3, half_width=0.6e-3, friction=0.6)
    >>> round(1e3 * float(touch.stick_half_width), 4)
    0.4176
    """

    # required, as half_width is
    friction: Annotated[npt.ArrayLike, Real(above=0.0, fix="rubber on glass: 1; a dry finger: 0.5")] = np.nan

    def __post_init__(self) -> None:
        super().__post_init__()
        pulled, held = np.abs(self.tangential_force), np.asarray(self.friction) * self.normal_force
        rounding = 1e-12 * np.asarray(self.force)  # angle = arctan(mu) is on the edge of the cone, not beyond
        slides = pulled > held + rounding
        if slides.any():
            at = np.unravel_index(int(np.argmax(slides)), slides.shape)
            seen = f"|T| = {np.broadcast_to(pulled, slides.shape)[at]:.6g}, mu N = {held[at]:.6g} N/m"
            raise InvalidValueError(seen, "|T| <= mu N, else the contact slides", "Hertz(...), or a smaller angle")

    @property
    def _slip(self) -> FloatArray:
        """|T| / (mu N), in [0, 1]."""
        held = np.asarray(self.friction) * self.normal_force
        return np.asarray(np.minimum(np.abs(self.tangential_force) / np.where(held > 0, held, 1.0), 1.0))

    @property
    def stick_half_width(self) -> FloatArray:
        """Half the width c of the zone that sticks [m]; 0 where the contact is about to slide."""
        return _check.read_only(self._a * np.sqrt(1 - self._slip))

    @property
    def _inset(self) -> FloatArray:
        """Width a - c of each zone that slips, to its own accuracy."""
        return np.asarray(self._a * self._slip / (1 + np.sqrt(1 - self._slip)))

    def _unit_moments(self, a: FloatArray) -> list[FloatArray]:
        # (a^(k+2) - c^(k+2)) / (a^2 - c^2), the difference divided out
        c = self.stick_half_width
        zero = np.zeros(np.broadcast_shapes(a.shape, c.shape))
        even = [sum((a ** (2 * (k - j)) * c ** (2 * j) for j in range(k + 1)), zero) for k in range(len(self.SERIES))]
        return [zero if k % 2 else self.SERIES[k // 2] * even[k // 2] for k in range(2 * len(even) - 1)]

    def transforms(self, z: ComplexArray) -> Transforms:  # noqa: D102
        z = self._centred(z)
        normal, tangential, a, c = self.normal_force, self.tangential_force, self._a, self.stick_half_width
        with np.errstate(divide="ignore", invalid="ignore"):
            press = hertz(np, z.imag, z.real, a)
            drag = sticking(np, z.imag, z.real, a, self._inset, c, (c > 0) & (self._slip > 0))
        f, df, g, dg = (joined(part) for part in (*press, *drag))
        h = self.unit_shear_field(z, g, dg)
        return Transforms(normal * f, normal * df, tangential * g, tangential * dg, tangential * h)

    def spectrum(self, k: FloatArray) -> Spectrum:  # noqa: D102
        sticks, share = self.stick_half_width, 1 - self._slip
        outer = jinc(k * self._a)
        # mu N (outer - (c/a)^2 inner); where nothing slips, nothing drags
        zone = (outer - share * jinc(k * sticks)) / np.where(self._slip > 0, self._slip, 1.0)
        shift = self._shifted(k)
        return Spectrum(np.asarray(self.normal_force * outer * shift), np.asarray(self.tangential_force * zone * shift))

    def shear(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        y = self._from_centre(y)
        a, inset = self._a, self._inset
        outer = np.sqrt(np.maximum((a - y) * (a + y), 0.0))
        inner = np.sqrt(np.maximum((a - y - inset) * (a + y - inset), 0.0))
        # where it slips, q = mu p; where it sticks, the difference of the two roots divided out
        slips = 2 / (np.pi * a**2 * np.where(self._slip > 0, self._slip, 1.0)) * outer
        sticks = 2 / (np.pi * np.where(inner > 0, outer + inner, 1.0))
        return _check.read_only(self.tangential_force * np.where(inner > 0, sticks, slips))

    @property
    def breaks(self) -> FloatArray:
        """The ends of the contact and of the zone that sticks."""
        y, a, c = np.broadcast_arrays(np.asarray(self.position), self._a, self.stick_half_width)
        return np.stack([y - a, y - c, y + c, y + a], axis=-1)

    def singular_points(self) -> tuple[FloatArray, ...]:
        """None: pressure and shear are continuous."""
        return ()
