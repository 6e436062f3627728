"""The Cattaneo-Mindlin contact: a round body that sticks in the middle and slips at the edges."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from .._declared import Real
from ..errors import InvalidValueError
from .base import Spectrum, Transforms
from .functions import jinc, root
from .hertz import Hertz

__all__ = ["PartialSlip"]


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
        f, df = self.unit_transform(z)
        # mu N (F_a - (c/a)^2 F_c) with mu N = T / (1 - c^2/a^2) divided out: no difference is left to be small
        s, r = root(z, a), root(z, a, self._inset)
        sticks = (c > 0) & (self._slip > 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            zone = np.where(sticks, c**2 / ((s + r) * (z + s) * (z + r)), 0.0)
            dzone = np.where(sticks, zone * (z + s + r) / (s * r), 0.0)
        g, dg = f - 2 * zone, df + 2 * dzone
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
