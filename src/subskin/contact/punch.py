"""Long bodies with an edge: the flat punch (memo eq. 14), the uniform strip, the blunt wedge (memo eq. 15)."""

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
from .functions import Pair, gap, inverse, jinc, joined, log_ratio, root, times
from .spread import SpreadContact, pressing, scaled

__all__ = ["FlatPunch", "Strip", "Wedge"]


def punch(xp: Any, x: Any, y: Any, a: Any) -> tuple[Pair, Pair]:
    """F = -1/s and F' = z/s^3, s = sqrt(z^2 - a^2), of unit load (memo eq. 14; `ProportionalContact`)."""
    s = root(xp, x, y, a)
    return inverse(s, -1.0), times((y, x), inverse(times(s, times(s, s))))


def tilt(xp: Any, x: Any, y: Any, a: Any) -> tuple[Pair, Pair]:
    """F = -2 / (s (z + s)) and F' = 2/s^3 of a unit moment on a flat punch."""
    s = root(xp, x, y, a)
    return inverse(times(s, (y + s[0], x + s[1])), -2.0), inverse(times(s, times(s, s)), 2.0)


def strip(xp: Any, x: Any, y: Any, a: Any) -> tuple[Pair, Pair]:
    """F = log((z - a) / (z + a)) / (2 a) and F' = 1 / (z^2 - a^2) (docs/theory.md; `ProportionalContact`)."""
    length, angle = log_ratio(xp, x, y + a, y - a, y, a)
    return (length / (2 * a), angle / (2 * a)), inverse(gap(x, y + a, y - a, y))


def wedge(xp: Any, x: Any, y: Any, a: Any) -> tuple[Pair, Pair]:
    """F = -arcsin(a/z) / a and F' = 1 / (z s) of unit load (memo eq. 15; `ProportionalContact`).

    In elliptic coordinates, s = +-n + i m: sums of positive terms only, so that neither part is lost where the other is
    large (near the surface) or where a/z is near 1 (at the edges).
    """
    s = root(xp, x, y, a)
    n, m, away = xp.abs(s[0]), s[1], xp.abs(y)
    c = a * m / (m * m + y * y)
    angle = -xp.copysign(xp.atan2(a * away * (1 + c), n * away + (m + a) * x), y) / a
    return (angle, xp.log1p(2 * a * m * (1 + c) / (x * x + y * y)) / (2 * a)), inverse(times((y, x), s))


@dataclass(frozen=True, eq=False)
class FlatPunch(SpreadContact, name="punch"):
    """A rigid flat punch: pressure (N + 2 M y / a^2) / (pi sqrt(a^2 - y^2)), y from its centre.

    F(z) = -1/s for a unit force, -2/(s (z + s)) for a unit moment, s = sqrt(z^2 - a^2). Source: memo eq.
    (14); docs/theory.md; Johnson, Contact Mechanics (1985), section
    2.8. The shear has the shape of the force's part alone: a moment tilts, it does not drag. Other
    parameters and errors as in `SpreadContact`.

    Parameters
    ----------
    moment : array_like, optional
        Moment M of the pressure about the centre [N m/m], positive where it presses harder towards +y. By keyword.

    Warns
    -----
    ValidityWarning
        |moment| > |N| half_width / 2: one edge would have to pull on the skin, where a real punch lifts.

    Examples
    --------
    >>> punch = FlatPunch(force=40.0, half_width=1e-3, moment=0.01)
    >>> punch.pressure([-0.5e-3, 0.0, 0.5e-3]).round(1).tolist()
    [11026.6, 12732.4, 18377.6]
    """

    moment: Annotated[npt.ArrayLike, Real("N m/m")] = 0.0

    GROWTH = 0.0
    SERIES = (1.0, 1 / 2, 3 / 8, 5 / 16, 35 / 128)
    FORM = staticmethod(punch)

    def __post_init__(self) -> None:
        super().__post_init__()
        most = np.abs(self.normal_force) * self._a / 2
        if (np.abs(self._m) > most * (1 + 1e-12)).any():
            message = (
                "|moment| > normal force * half_width / 2: one edge of the punch pulls on the skin; a punch "
                "that does not stick lifts there, and its contact is narrower than given"
            )
            _check.warn(message)

    @property
    def _m(self) -> FloatArray:
        return np.asarray(self.moment, dtype=np.float64)

    def transforms(self, z: ComplexArray) -> Transforms:  # noqa: D102
        t = super().transforms(z)
        if not self._m.any():
            return t
        z = self._centred(z)
        f, df = (joined(part) for part in tilt(np, z.imag, z.real, self._a))
        return t._replace(p=t.p + self._m * f, dp=t.dp + self._m * df)

    def unit_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        from scipy.special import j0

        return np.asarray(j0(k * self._a))

    def spectrum(self, k: FloatArray) -> Spectrum:  # noqa: D102
        s = super().spectrum(k)
        if not self._m.any():
            return s
        return s._replace(p=s.p - 1j * k * self._m * jinc(k * self._a) * self._shifted(k))

    def unit_pressure(self, y: FloatArray) -> FloatArray:  # noqa: D102
        a = self._a
        under = np.sqrt(np.maximum((a - y) * (a + y), 0.0))
        with np.errstate(divide="ignore"):
            return np.where(np.abs(y) <= a, 1 / (np.pi * under), 0.0)

    def pressure(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        centred = self._from_centre(y)
        return scaled(self.normal_force + 2 * self._m * centred / self._a**2, self.unit_pressure(centred))

    def singular_points(self) -> tuple[FloatArray, ...]:
        """Both edges: the stress grows like 1/sqrt(distance)."""
        return self.support


@dataclass(frozen=True, eq=False)
class Strip(SpreadContact, name="strip"):
    """Uniform pressure and shear over |y - position| <= half_width, F(z) = log((z - a) / (z + a)) / (2 a).

    Source: docs/theory.md; Johnson, Contact Mechanics (1985), section 2.5. For a pressure
    that varies along the contact see `PressureProfile`. Parameters as in `SpreadContact`.

    Examples
    --------
    >>> strip = Strip(force=40.0, half_width=1e-3)
    >>> strip.pressure([0.0, 0.5e-3, 2e-3]).round(6).tolist()
    [20000.0, 20000.0, 0.0]
    """

    SERIES = (1.0, 1 / 3, 1 / 5, 1 / 7, 1 / 9)
    FORM = staticmethod(strip)

    def unit_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        return np.asarray(np.sinc(k * self._a / np.pi))

    def unit_pressure(self, y: FloatArray) -> FloatArray:  # noqa: D102
        return np.where(np.abs(y) <= self._a, 1 / (2 * self._a), 0.0)

    def singular_points(self) -> tuple[FloatArray, ...]:
        """Both ends: the pressure jumps there, and under drag sigma_y grows like a logarithm."""
        return self.support


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
    FORM = staticmethod(wedge)

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
