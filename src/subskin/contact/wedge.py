"""The blunt wedge (memo eq. 15)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from ..errors import InvalidValueError
from ..material import Material
from .functions import root
from .spread import SpreadContact, pressing

__all__ = ["Wedge"]

_STEEPEST = 0.3
"""Slope beyond which `from_angle` warns: linear theory drops the square of the slope, here 9 %."""


@dataclass(frozen=True, eq=False)
class Wedge(SpreadContact, name="wedge"):
    """A blunt rigid wedge: pressure N/(pi a) arccosh(a/|y|), F(z) = -arcsin(a/z) / a.

    Source: memo eq. (15); docs/theory.md; Johnson, Contact Mechanics (1985), section 5.2. Parameters as of
    `SpreadContact`; the tip is at `position`.

    Examples
    --------
    >>> wedge = Wedge(force=40.0, half_width=1e-3)
    >>> wedge.pressure([0.1e-3, 0.5e-3, 1e-3]).round(1).tolist()
    [38110.9, 16768.0, 0.0]
    """

    GROWTH = 1.0
    SERIES = (1.0, 1 / 6, 3 / 40, 5 / 112, 35 / 1152)

    @classmethod
    def from_angle(
        cls,
        force: npt.ArrayLike,
        vertex_angle: npt.ArrayLike,
        material: Material,
        angle: npt.ArrayLike = 0.0,
        position: npt.ArrayLike = 0.0,
    ) -> Self:
        """A wedge of `vertex_angle` theta [rad] on a skin of `material`, in plane strain.

        a = N tan(theta/2) (1 - nu^2) / E with N = P cos(angle): the load that goes with the memo's eq. (15).
        Other parameters as in `SpreadContact`.

        Raises
        ------
        InvalidValueError
            A vertex angle outside (0, pi), or a load that does not press (N <= 0).

        Warns
        -----
        ValidityWarning
            The surface along the flanks slopes by cot(theta/2) > 0.3 (theta < 146.6 degrees): linear theory
            is for small slopes.

        Examples
        --------
        >>> wedge = Wedge.from_angle(40.0, np.deg2rad(160), Material(young=0.4e6))
        >>> round(1e3 * float(wedge.half_width), 4)
        0.4253
        """
        _check.noun("material", material, Material, "Material(young=0.4e6)")
        theta = _check.real("vertex_angle", vertex_angle, unit="rad")
        if not ((theta > 0) & (theta < np.pi)).all():
            worst = float(theta[()] if not theta.ndim else theta[~((theta > 0) & (theta < np.pi))][0])
            fix = "angles are in radians: np.deg2rad(160)"
            raise InvalidValueError(f"vertex_angle = {worst:.6g}", "has to be in (0, pi) [rad]", fix)
        slope = 1 / np.tan(theta / 2)
        if (slope > _STEEPEST).any():
            message = (
                f"the wedge's flanks slope by cot(theta/2) = {float(np.max(slope)):.3g}: linear theory is "
                f"for small slopes, up to about {_STEEPEST}; take a blunter wedge (vertex_angle > 2.56 rad)"
            )
            _check.warn(message)
        a = pressing(force, angle, "wedge") / (slope * material.plane_strain_modulus)
        return cls(force=force, angle=angle, position=position, half_width=a)

    def unit_transform(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:  # noqa: D102
        # arcsin(a/z) in elliptic coordinates, s = +-n + i m: sums of positive terms only, so that neither
        # part is lost where the other is large (near the surface) or where a/z is near 1 (at the edges)
        a, x, y = self._a, z.imag, z.real
        s = root(z, a)
        m, n = s.imag, np.abs(s.real)
        c = a * m / (m**2 + y**2)
        f = np.empty(c.shape, dtype=np.complex128)
        f.real = -np.copysign(np.arctan2(a * np.abs(y) * (1 + c), n * np.abs(y) + (m + a) * x), y) / a
        f.imag = np.log1p(2 * a * m * (1 + c) / (x**2 + y**2)) / (2 * a)
        return f, 1 / (z * s)

    def unit_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        # a wedge is made of punches of all half widths up to a: the mean of their J0, by Struve functions
        from scipy.special import j0, j1, struve

        x = np.asarray(k * self._a)
        struves = 0.5 * np.pi * (j1(x) * struve(0, x) - j0(x) * struve(1, x))
        return np.asarray(j0(x) + struves)

    def unit_pressure(self, y: FloatArray) -> FloatArray:  # noqa: D102
        a = self._a
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.sqrt(np.maximum((a - y) * (a + y), 0.0)) / np.abs(y)
        return np.asarray(np.arcsinh(ratio) / (np.pi * a))

    def singular_points(self) -> tuple[FloatArray, ...]:
        """The tip: the stress grows like a logarithm."""
        return (np.broadcast_to(np.asarray(self.position, dtype=np.float64), self.shape),)
