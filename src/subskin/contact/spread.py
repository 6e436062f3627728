"""What the contacts have in common whose drag is a share of their pressure, and those of finite width among them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Annotated, Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from .. import _check, _hooks
from .._check import ComplexArray, FloatArray
from .._declared import Noun, Real
from ..errors import GeometryError, InvalidValueError
from .base import Contact, Spectrum, Transforms
from .functions import FAR, Pair, cauchy, far_shear_field, joined, shear_field

__all__ = ["ProportionalContact", "SpreadContact", "scaled"]

_OURS = __name__.partition(".")[0] + "."
"""Modules whose classes need no check of what they give."""

_ANGLE = Real("rad", at_least=-np.pi, at_most=np.pi, fix="angles are in radians: np.deg2rad(30)")


def resolve(force: npt.ArrayLike, angle: npt.ArrayLike) -> FloatArray:
    """N = P cos(angle) and T = P sin(angle), shape (..., 2); at a right angle N is 0, which cos(pi/2) is not."""
    p, alpha = np.asarray(force, dtype=np.float64), np.asarray(angle, dtype=np.float64)
    both = np.empty((*np.broadcast_shapes(p.shape, alpha.shape), 2))
    np.multiply(p, np.where(np.abs(alpha) == np.pi / 2, 0.0, np.cos(alpha)), out=both[..., 0])
    np.multiply(p, np.sin(alpha), out=both[..., 1])
    both.flags.writeable = False
    return both


def scaled(force: FloatArray, unit: FloatArray) -> FloatArray:
    """A force times a unit pressure: no force makes nothing, even of an infinite one."""
    with np.errstate(invalid="ignore"):
        return _check.read_only(np.where(force == 0, 0.0, force * unit))


@dataclass(frozen=True, eq=False)
class ProportionalContact(Contact, Noun):
    """A contact whose shear is everywhere the same multiple of its pressure: q = p tan(angle), by definition.

    A subclass gives `unit_pressure` and `unit_spectrum`, for N = 1 N/m at position 0. Where it has a closed form, that
    is its `FORM`, a pure function of an array namespace `xp`, the depth `x` and the distance `y` from the centre [m],
    and the half width `a` [m]: F and F', each as its real and imaginary part. One with a part that is not proportional
    (a punch's moment, a zone that sticks) adds it in `transforms`, `spectrum`, `pressure` and `shear`.

    Parameters
    ----------
    force : array_like
        Magnitude P of the resultant [N/m], >= 0.
    angle : array_like, optional
        Angle of the resultant from the inward normal [rad], in [-pi, pi]: N = P cos(angle), T = P sin(angle)
        towards +y. Beyond pi/2 the load pulls. A right angle is rounded; `of_components` is exact.
    position : array_like, optional
        Centre of the contact y [m].

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; shapes that do not broadcast.
    """

    GROWTH: ClassVar[float | None] = None
    """Power of the normal force with which a pressed body's half width grows; None where no body is meant."""

    FORM: ClassVar[Callable[..., tuple[Pair, Pair]] | None] = None
    """F and F' of unit resultant at y + i x as a pure function (xp, x, y, half width), where there is a closed form."""

    force: Annotated[npt.ArrayLike, Real("N/m", at_least=0.0, fix="turn the angle instead")]
    angle: Annotated[npt.ArrayLike, _ANGLE] = 0.0
    position: Annotated[npt.ArrayLike, Real("m")] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.__dict__.update(_shape=self._common_shape(), _components=resolve(self.force, self.angle))

    @classmethod
    def of_components(
        cls, components: npt.ArrayLike, position: npt.ArrayLike = 0.0, **parameters: npt.ArrayLike
    ) -> Self:
        """Contacts of given normal and tangential force, which are kept exactly.

        Parameters
        ----------
        components : array_like, shape (..., 2)
            Normal force N and tangential force T [N/m].
        position : array_like, optional
            Centre of the contact y [m].
        **parameters
            The subclass's own, such as `half_width`.

        Raises
        ------
        InvalidValueError, GeometryError
            A value out of range; shapes that do not broadcast, components that are not two.

        Examples
        --------
        >>> from subskin.contact import LineLoad
        >>> drag = LineLoad.of_components([0.0, 40.0])
        >>> float(drag.normal_force), float(drag.force), round(float(drag.angle), 4)
        (0.0, 40.0, 1.5708)
        """
        both = _check.real("components", components, unit="N/m")
        if both.shape[-1:] != (2,):
            raise GeometryError(f"components of shape {both.shape}", "(..., 2) is needed, N and T", "[40.0, 0.0]")
        n, t = both[..., 0], both[..., 1]
        made = cls(np.hypot(n, t), np.arctan2(t, n), position, **parameters)
        made.__dict__["_components"] = both
        return made

    @property
    def shape(self) -> tuple[int, ...]:  # noqa: D102
        shape: tuple[int, ...] = self.__dict__["_shape"]
        return shape

    @property
    def components(self) -> FloatArray:  # noqa: D102
        both: FloatArray = self.__dict__["_components"]
        return both

    @abstractmethod
    def unit_pressure(self, y: FloatArray) -> FloatArray:
        """The pressure [1/m] at `y` [m] with unit resultant, centred at 0."""

    @abstractmethod
    def unit_spectrum(self, k: FloatArray) -> FloatArray:
        """Fourier transform at `k` [1/m] of the pressure with unit resultant, centred at 0: real."""

    def unit_transform(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray] | None:
        """F and dF/dz at `z` [m] of the pressure with unit resultant, centred at 0; None without a closed form."""
        if self.FORM is None:
            return None
        f, df = self.FORM(np, z.imag, z.real, *self._sizes)
        return joined(f), joined(df)

    @property
    def _sizes(self) -> tuple[FloatArray, ...]:
        """What `FORM` takes besides points."""
        return ()

    def unit_shear_field(self, z: ComplexArray, f: ComplexArray, df: ComplexArray) -> FloatArray:
        """Im(F + i x F') of `unit_transform`, `f` and `df` at `z`; a subclass replaces it where these cancel."""
        x = z.imag
        return np.asarray(shear_field(np, x, (f.real, f.imag), (df.real, df.imag), not x.all()))

    def transforms(self, z: ComplexArray) -> Transforms:  # noqa: D102
        z = self._centred(z)
        closed, who = self.unit_transform(z), type(self).__name__
        if closed is None:
            f, df, h = cauchy(self.unit_pressure, self.breaks - np.asarray(self.position)[..., None], z)
        else:
            if not isinstance(closed, tuple) or len(closed) != 2:
                seen, rule = f"{who}.unit_transform gave {_check.shown(closed)}", "F and dF/dz are needed, or None"
                raise InvalidValueError(seen, rule, "return f, df")
            f, df = closed
            if type(self).__module__.startswith(_OURS):
                h = self.unit_shear_field(z, f, df)
            else:
                full = np.broadcast_shapes(z.shape, self.shape)
                f, df = (_check.returned(f"{who}.unit_transform", part, full) for part in closed)
                h = _check.returned(f"{who}.unit_shear_field", self.unit_shear_field(z, f, df), full)
        normal, tangential = self.components[..., 0], self.components[..., 1]
        return Transforms(normal * f, normal * df, tangential * f, tangential * df, tangential * h)

    def spectrum(self, k: FloatArray) -> Spectrum:  # noqa: D102
        own = self._returned("unit_spectrum", self.unit_spectrum(k), np.shape(k))
        unit = own * self._shifted(k)
        return Spectrum(np.asarray(self.normal_force * unit), np.asarray(self.tangential_force * unit))

    def _shifted(self, k: FloatArray) -> ComplexArray:
        """The factor by which a contact's position changes its spectrum."""
        phase = np.asarray(k * np.asarray(self.position, dtype=np.float64))
        out = np.empty(phase.shape, dtype=np.complex128)
        out.real, out.imag = np.cos(phase), -np.sin(phase)
        return out

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        at = np.broadcast_to(np.asarray(self.position, dtype=np.float64), self.shape)
        return at, at

    def pressure(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return scaled(self.normal_force, self._own_pressure(self._from_centre(y)))

    def shear(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return scaled(self.tangential_force, self._own_pressure(self._from_centre(y)))

    def _own_pressure(self, y: FloatArray) -> FloatArray:
        return self._returned("unit_pressure", self.unit_pressure(y), y.shape)

    def _returned(self, hook: str, values: Any, shape: tuple[int, ...]) -> FloatArray:
        found: FloatArray = _check.returned(
            f"{type(self).__name__}.{hook}", values, np.broadcast_shapes(shape, self.shape)
        )
        return found

    def _centred(self, z: ComplexArray) -> ComplexArray:
        return np.asarray(z - np.asarray(self.position, dtype=np.float64))

    def _from_centre(self, y: npt.ArrayLike) -> FloatArray:
        return np.asarray(_check.real("y", y, unit="m") - np.asarray(self.position, dtype=np.float64))

    def moved(self, position: FloatArray) -> Self:
        """The same contacts at other positions [m], of a shape that broadcasts; these are not checked."""
        return self.altered(position=position, _shape=np.broadcast_shapes(self.shape, position.shape))

    def expand(self, axes: int = 1) -> Self:  # noqa: D102
        shape, tail = self.shape, (1,) * axes
        values = {f.name: np.asarray(getattr(self, f.name)) for f in fields(self) if f.init}
        longer = {k: v.reshape((1,) * (len(shape) - v.ndim) + v.shape + tail) for k, v in values.items()}
        both = np.broadcast_to(self.components, (*shape, 2)).reshape(*shape, *tail, 2)
        return self.altered(**longer, _components=both, _shape=shape + tail)


_POINTS = 40
_WIDTH = "give half of the contact's width in metres; one of no width is a LineLoad"


@dataclass(frozen=True, eq=False)
class SpreadContact(ProportionalContact):
    """A symmetric contact on |y - position| <= half_width.

    A subclass gives `unit_pressure` and `unit_spectrum`. One with a closed form adds it as `FORM`, and `SERIES`,
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

    @property
    def _sizes(self) -> tuple[FloatArray, ...]:
        return (self._a,)

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
            away = np.broadcast_to(z, h.shape)[far]
            h[far] = far_shear_field(away.imag, away.real, moments)
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
