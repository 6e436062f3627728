"""What the contacts of finite width have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt

from .. import _check, _hooks
from .._check import ComplexArray, FloatArray
from .._declared import Real
from ..errors import InvalidValueError
from .functions import FAR, far_shear_field
from .proportional import ProportionalContact
from .quadrature import cauchy

__all__ = ["SpreadContact"]

_POINTS = 40
_WIDTH = "give half of the contact's width in metres; one of no width is a LineLoad"


@dataclass(frozen=True, eq=False)
class SpreadContact(ProportionalContact):
    """A symmetric contact on |y - position| <= half_width.

    A subclass gives `unit_pressure` and `unit_spectrum`. One with a closed form adds `unit_transform`, and `SERIES`,
    the even moments of its pressure for unit resultant and unit half width (docs/theory.md): F = -(1/z) sum of
    SERIES[k] (a/z)^(2k). Far away they take the place of the closed form where that would cancel. One with a name,
    `class Mine(SpreadContact, name="mine")`, is a family that fits, decisions and simulations know.

    Parameters
    ----------
    force, angle, position : array_like
        Magnitude [N/m], angle [rad] and centre [m], as in `ProportionalContact`.
    half_width : array_like
        Half the contact's width a [m], > 0, of a shape that broadcasts against theirs; required.

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; shapes that do not broadcast.

    Examples
    --------
    A family of one's own, whose pressure falls to both sides in a straight line.

    >>> import numpy as np, subskin as ss
    >>> class Ramp(ss.contact.SpreadContact):
    ...     def unit_pressure(self, y):
    ...         return np.maximum(1 - np.abs(y) / self.half_width, 0.0) / self.half_width
    ...     def unit_spectrum(self, k):
    ...         return np.sinc(0.5 * k * self.half_width / np.pi) ** 2
    >>> float(Ramp(force=40.0, half_width=1e-3).pressure(0.0))
    40000.0
    """

    # required: NaN is refused, and the order of arguments kept
    half_width: Annotated[npt.ArrayLike, Real("m", above=0.0, fix=_WIDTH)] = np.nan

    SERIES: ClassVar[tuple[float, ...]] = ()

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        _hooks.check_members(cls, {"as_line_loads": _lines})

    @property
    def _a(self) -> FloatArray:
        return np.asarray(self.half_width, dtype=np.float64)

    def _unit_moments(self, a: FloatArray) -> list[FloatArray]:
        """The moments of the shear with unit resultant, for the half widths `a`."""
        zero = np.zeros_like(a)
        return [zero if k % 2 else self.SERIES[k // 2] * a**k for k in range(2 * len(self.SERIES) - 1)]

    def unit_shear_field(self, z: ComplexArray, f: ComplexArray, df: ComplexArray) -> FloatArray:  # noqa: D102
        h = super().unit_shear_field(z, f, df)
        far = np.abs(z) > FAR * self._a
        if not np.count_nonzero(far):
            return h
        far = np.broadcast_to(far, h.shape)
        if self.SERIES:
            moments = [np.broadcast_to(m, h.shape)[far] for m in self._unit_moments(self._a)]
            h[far] = far_shear_field(np.broadcast_to(z, h.shape)[far], moments)
        else:
            h[far] = cauchy(self.unit_pressure, self.breaks - np.asarray(self.position)[..., None], z)[2][far]
        return h

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        centre = np.asarray(self.position, dtype=np.float64)
        return np.broadcast_to(centre - self._a, self.shape), np.broadcast_to(centre + self._a, self.shape)

    @classmethod
    def as_line_loads(cls) -> tuple[FloatArray, FloatArray]:
        """Positions in half widths and weights of line loads that make the contact of unit force.

        t = sin(psi), whose slope takes up a root at the ends, and psi crowded towards 0, where a wedge has its tip.
        """
        v, weight = np.polynomial.legendre.leggauss(_POINTS)
        v, weight = 0.5 * (1 + v), 0.5 * weight
        psi = 0.5 * np.pi * v**3
        t = np.sin(psi)
        inside = np.minimum(t, np.nextafter(1.0, 0.0))
        pressure = cls(force=1.0, half_width=1.0).pressure(inside)
        weights = pressure * np.cos(psi) * 1.5 * np.pi * v**2 * weight
        both = np.concatenate([-t[::-1], t]), np.concatenate([weights[::-1], weights])
        return both[0], both[1] / both[1].sum()


_ROW = _hooks.numbers("a row of them", ndim=1)


def _lines(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
    """Positions and weights of as many line loads."""
    lines, weights = _hooks.each_of((_ROW, _hooks.numbers("one or two for each line load")), "two arrays")(
        said, own, given, args
    )
    if weights.shape not in (lines.shape, (*lines.shape, 2)) or not lines.size:
        raise _hooks.wrong(f"{said}[1]", given[1], "a weight, or two, for each of some line loads is needed")
    return lines, weights


def pressing(force: npt.ArrayLike, angle: npt.ArrayLike, name: str) -> FloatArray:
    """N = P cos(angle), refused unless it presses: only then do load and body decide on the width."""
    alpha = _check.real("angle", angle, unit="rad")
    normal = np.where(np.abs(alpha) < np.pi / 2, _check.real("force", force, unit="N/m") * np.cos(alpha), 0.0)
    if not (normal > 0).all():
        seen = f"normal force = {float(np.min(normal)):.6g} N/m"
        rule = f"the width of a {name} follows from its load only where that presses: force > 0, |angle| < pi/2"
        raise InvalidValueError(seen, rule, "give half_width yourself")
    return normal
