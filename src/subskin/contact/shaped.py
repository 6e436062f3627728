"""Local contacts of one shape, whose drag is in proportion to their pressure; their arguments."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import Field, dataclass, fields
from functools import cache
from inspect import Parameter, Signature, signature
from typing import Annotated, Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from .. import _check, _hooks
from .._check import ComplexArray, FloatArray
from .._declared import Noun, Real, Ruled
from ..errors import GeometryError, InvalidValueError
from .kernels import RealForm
from .local import LocalContact, LocalSpectrum, LocalTransforms, Potentials

__all__ = ["Row", "ShapedContact", "SignatureOf", "resolved"]

_TURN = 2.0 * np.pi


def Row(count: int, unit: str, what: str, above: float | None = None, fix: str = "") -> Ruled:
    """A declaration: an array whose last axis has `count` numbers."""

    def rule(name: str, value: Any) -> FloatArray:
        array = _check.real(name, value, unit=unit, above=above, fix=fix)
        if array.shape[-1:] != (count,):
            raise GeometryError(f"{name} of shape {array.shape}", f"(..., {count}) is needed, {what} [{unit}]", fix)
        return array

    return Ruled(rule)


class SignatureOf:
    """The signature of a class of contacts, for `help` and editors: a force, where it acts, and the class's lengths."""

    def __init__(self, *first: str) -> None:
        self._first = first  # what comes before the force

    def __get__(self, contact: object, kind: Any) -> Signature:
        either, alone = Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY
        own = kind._lengths()
        first = [Parameter(name, either) for name in self._first]
        first += [Parameter(name, either, default=None) for name in ("force", "angle", "azimuth")]
        first += [Parameter("position", either, default=(0.0, 0.0))]
        first += [Parameter(f.name, either, default=f.default) for f in own if not f.kw_only]
        last = [Parameter(f.name, alone, default=f.default) for f in own if f.kw_only]
        last += [Parameter("components", alone, default=None), Parameter("moment", alone, default=0.0)]
        return Signature([*first, *last])


def resolved(
    force: npt.ArrayLike | None,
    angle: npt.ArrayLike | None,
    azimuth: npt.ArrayLike | None,
    components: npt.ArrayLike | None,
) -> npt.ArrayLike:
    """(N, Ty, Tz) from either form."""
    if components is not None:
        if any(value is not None for value in (force, angle, azimuth)):
            raise InvalidValueError("components and force, angle or azimuth", "they say the same: one form is needed")
        return components
    if force is None:
        fix = "force=1.5, angle=0.3, azimuth=0.8, or components=(1.4, 0.3, 0.3)"
        raise InvalidValueError("no force", "a magnitude, or its components, is needed", fix)
    p = _check.real("force", force, unit="N", at_least=0.0, fix="turn the angle instead")
    fix = "angles are in radians, from the inward normal: np.deg2rad(30); the azimuth says to which side"
    alpha = _check.real("angle", 0.0 if angle is None else angle, unit="rad", at_least=0.0, at_most=np.pi, fix=fix)
    fix = "angles are in radians: np.deg2rad(90)"
    given = 0.0 if azimuth is None else azimuth
    theta = _check.real("azimuth", given, unit="rad", at_least=-_TURN, at_most=_TURN, fix=fix)
    out = np.empty((*_check.broadcast(force=p, angle=alpha, azimuth=theta), 3))
    out[..., 0] = p * np.where(alpha == 0.5 * np.pi, 0.0, np.cos(alpha))
    drag = p * np.where(alpha == np.pi, 0.0, np.sin(alpha))
    out[..., 1], out[..., 2] = drag * np.cos(theta), drag * np.sin(theta)
    return out


@dataclass(frozen=True, eq=False, init=False)
class ShapedContact(LocalContact, Noun):
    """A local contact of one shape f(y, z), whose integral is 1: pressure N f, drag (Ty, Tz) f.

    A moment M about the inward normal adds the drag -(M/2) i (d/dy + i d/dz) f, q_y + i q_z (docs/local_contacts.md).
    A subclass gives `unit_pressure` and `unit_spectrum`, and where it has a closed form `unit_family`.

    Parameters
    ----------
    force : array_like, optional
        Magnitude of the resultant [N], >= 0.
    angle : array_like, optional
        Its angle from the inward normal [rad], in [0, pi]; beyond pi/2 it pulls.
    azimuth : array_like, optional
        Direction of the drag, from +y towards +z [rad].
    position : array_like, shape (..., 2), optional
        Centre of the contact (y, z) [m].
    components : array_like, shape (..., 3), optional
        (N, Ty, Tz) [N], instead of force, angle and azimuth; kept exactly.
    moment : array_like, optional
        Moment about the inward normal [N m], positive from +y to +z.

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; both forms of a force, or neither; shapes that do not broadcast.

    Examples
    --------
    A shape of one's own: a hill that falls off like Gauss's bell, on a square wide enough for it.

    >>> import numpy as np, subskin as ss
    >>> class Bell(ss.contact.ShapedContact):
    ...     support = (np.full(2, -4e-3), np.full(2, 4e-3))
    ...     def unit_pressure(self, y, z):
    ...         return np.exp(-(y**2 + z**2) / 1e-6) / (np.pi * 1e-6)
    ...     def unit_spectrum(self, ky, kz):
    ...         return np.exp(-(ky**2 + kz**2) * 1e-6 / 4)
    >>> touch = Bell(force=1.0, angle=0.3)
    >>> round(float(ss.HalfSpace(ss.Material(young=0.4e6)).stress(touch, x=3e-3, y=0.0, z=0.0).xx))
    -40338
    """

    RANKS: ClassVar[dict[str, int]] = {"components": 1, "position": 1}
    """Axes that a parameter has for itself, behind those of the batch: 0 if it is not listed."""

    __signature__ = SignatureOf()

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        _hooks.check_members(cls, _MEMBERS)

    components: Annotated[FloatArray, Row(3, "N", "(N, Ty, Tz)")] = None  # type: ignore[assignment]
    position: Annotated[FloatArray, Row(2, "m", "(y, z)")] = (0.0, 0.0)  # type: ignore[assignment]
    moment: Annotated[FloatArray, Real("N m")] = 0.0  # type: ignore[assignment]

    def __init__(
        self,
        force: npt.ArrayLike | None = None,
        angle: npt.ArrayLike | None = None,
        azimuth: npt.ArrayLike | None = None,
        position: npt.ArrayLike = (0.0, 0.0),
        *lengths: npt.ArrayLike,
        components: npt.ArrayLike | None = None,
        moment: npt.ArrayLike = 0.0,
        **more: npt.ArrayLike,
    ) -> None:
        own = self._lengths()
        given = dict(zip((f.name for f in own if not f.kw_only), lengths, strict=False))
        if len(given) < len(lengths) or not more.keys() <= {f.name for f in own} - given.keys():
            signature(type(self)).bind(force, angle, azimuth, position, *lengths, **more)  # says what is wrong
        self.__dict__.update({f.name: f.default for f in own} | given | more)
        self.__dict__.update(components=resolved(force, angle, azimuth, components), position=position, moment=moment)
        self.__post_init__()

    def __post_init__(self) -> None:
        super().__post_init__()
        parameters = self._parameters()
        shape = _check.broadcast(**{n: np.empty(a.shape[: a.ndim - self._rank(n)]) for n, a in parameters.items()})
        for name, value in parameters.items():
            own = value.shape[value.ndim - self._rank(name) :]
            self.__dict__[name] = np.broadcast_to(value, shape + own)

    @classmethod
    def _lengths(cls) -> list[Field[Any]]:
        """The parameters of the shape, in the order of arguments."""
        return [f for f in fields(cls) if f.name not in ("components", "position", "moment")]

    @classmethod
    def _rank(cls, name: str) -> int:
        return cls.RANKS.get(name, 0)

    def _parameters(self) -> dict[str, FloatArray]:
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @abstractmethod
    def unit_pressure(self, y: FloatArray, z: FloatArray) -> FloatArray:
        """The shape f [1/m^2] at `y`, `z` [m] about its centre."""

    @abstractmethod
    def unit_spectrum(self, ky: FloatArray, kz: FloatArray) -> ComplexArray | FloatArray:
        """Fourier transform of the shape at (`ky`, `kz`) [1/m]; 1 at 0."""

    def unit_slope(self, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The derivatives of the shape along y and z [1/m^3] at `y`, `z` [m], by which a moment drags.

        Raises
        ------
        InvalidValueError
            A shape that does not say them.
        """
        seen = f"the drag of a moment on a {type(self).__name__}"
        raise InvalidValueError(seen, "its class has to define `unit_slope`", "moment=0")

    def unit_drag(self, y: FloatArray, z: FloatArray) -> FloatArray:
        """The shape of the drag [1/m^2] at `y`, `z` [m]; that of the pressure, if nothing else is said."""
        return self.unit_pressure(y, z)

    def pressure(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        away = self._from_centre(y, z)
        return _times(self.normal_force, self._returned("unit_pressure", self.unit_pressure(*away), *away))

    def shear(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        away = self._from_centre(y, z)
        drag = _times(self.tangential_force, self._returned("unit_drag", self.unit_drag(*away), *away)[..., None])
        if not self.moment.any():
            return drag
        by_y, by_z = self.unit_slope(*away)
        return _check.read_only(drag + _times(0.5 * self.moment[..., None], np.stack([by_z, -by_y], axis=-1)))

    def _returned(self, hook: str, values: Any, first: FloatArray, second: FloatArray) -> Any:
        shape = np.broadcast_shapes(first.shape, second.shape, self.shape)
        return _check.returned(f"{type(self).__name__}.{hook}", values, shape)

    def spectrum(self, ky: FloatArray, kz: FloatArray) -> LocalSpectrum:  # noqa: D102
        ky, kz = np.asarray(ky, dtype=np.float64), np.asarray(kz, dtype=np.float64)
        centre, load = self.position, self.components
        own = self._returned("unit_spectrum", self.unit_spectrum(ky, kz), ky, kz)
        unit = own * np.exp(-1j * (ky * centre[..., 0] + kz * centre[..., 1]))
        turn = 0.5j * self.moment
        n, ty, tz = (load[..., i] for i in range(3))
        return LocalSpectrum(n * unit, (ty + turn * kz) * unit, (tz - turn * ky) * unit)

    def unit_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray | None:
        """The family of the shape at the points x, y + i z = `zeta` about its centre, or a derivative of it along x.

        Parameters
        ----------
        order : int
            Derivatives along x: 0 for W_m, 1 for W_m'; -1 for -V_m, whose derivative is W_m.
        x, zeta : ndarray
            Points [m], x >= 0, of shapes that broadcast.

        Returns
        -------
        ndarray, shape (4, ...), or None
            For m = 0 ... 3 [1/m^(2 + order)], of order -1 for m = 0 ... 2; None without a closed form.
        """
        return None

    FORM: ClassVar[Callable[..., RealForm] | None] = None
    """The real form of its sizes, numbers or arrays of any namespace; None where there is none."""

    def real_form(self) -> RealForm | None:
        """W_0 and Re(tau* W_1) of the shape as real functions, of which pressure and strain along x are made.

        None where there are none.
        """
        return None

    @property
    def known_form(self) -> RealForm | None:
        """`real_form`, where no class has put another family in place of that to which it belongs."""
        return self.real_form() if _keeps_its_family(type(self)) else None

    def unit_core(self, x: FloatArray, zeta: ComplexArray, w: ComplexArray, dw: ComplexArray) -> ComplexArray:
        """W_0 + x W_0'/2 of `drag_family`, `w` and `dw` at `x`, `zeta` [1/m^2]; replaced where they cancel."""
        return np.asarray(w[0] + 0.5 * x * dw[0])

    def drag_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray | None:
        """`unit_family` of the drag; None where it is that of the pressure."""
        return None

    def transforms(self, x: FloatArray, y: FloatArray, z: FloatArray) -> LocalTransforms | None:
        """As `local_transforms_of`; None without a closed form."""
        shape, (n, tau) = self._shapes(), self._load
        zeta = shape._zeta(y, z)
        own, down = shape.unit_family(0, x, zeta), shape.unit_family(1, x, zeta)
        if own is None or down is None:
            return None
        w, dw = shape.drag_family(0, x, zeta), shape.drag_family(1, x, zeta)
        w, dw = own if w is None else w, down if dw is None else dw
        sq = tau * shape.unit_core(x, zeta, w, dw) if tau.any() else np.zeros_like(w[0])
        back = np.conj(tau)
        turned = self._turned_by_moment(down[1:3])
        return LocalTransforms(n * own, n * down, tau * w, tau * dw, back * w, back * dw, sq, turned)

    def potentials(self, x: FloatArray, y: FloatArray, z: FloatArray) -> Potentials | None:
        """As `local_potentials_of`, at `x`, `y`, `z`; None without a closed form."""
        shape, (n, tau) = self._shapes(), self._load
        zeta = shape._zeta(y, z)
        own, w = shape.unit_family(-1, x, zeta), shape.unit_family(0, x, zeta)
        if own is None or w is None:
            return None
        drag = shape.drag_family(-1, x, zeta)
        v = -(own if drag is None else drag)
        return Potentials(-n * own, tau * v, np.conj(tau) * v, self._turned_by_moment(w[1]))

    def _shapes(self) -> Self:
        """The same contacts, once where a batch has them with several loads: their families are the same."""
        values = self._parameters()
        shapes = [value for name, value in values.items() if name not in ("components", "moment")]
        once = [i for i, size in enumerate(self.shape) if size > 1 and all(v.strides[i] == 0 for v in shapes)]
        if not once:
            return self
        cut = tuple(slice(0, 1) if i in once else slice(None) for i in range(len(self.shape)))
        return self.altered(**{name: value[cut] for name, value in values.items()})

    def _turned_by_moment(self, family: ComplexArray) -> ComplexArray:
        """A moment times i/2 of a family; no moment makes nothing, even of an infinite one."""
        return np.where(self.moment == 0, 0.0, 0.5j * self.moment * family)

    @property
    def _load(self) -> tuple[FloatArray, ComplexArray]:
        """N, and Ty + i Tz."""
        return self.components[..., 0], self.components[..., 1] + 1j * self.components[..., 2]

    def _zeta(self, y: FloatArray, z: FloatArray) -> ComplexArray:
        away = np.empty(np.broadcast_shapes(y.shape, z.shape, self.shape), dtype=np.complex128)
        away.real, away.imag = y - self.position[..., 0], z - self.position[..., 1]
        return away

    def _from_centre(self, y: npt.ArrayLike, z: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        ys, zs = _check.real("y", y, unit="m"), _check.real("z", z, unit="m")
        away = self._zeta(ys, zs)
        return away.real, away.imag

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        return self.position, self.position

    def expand(self, axes: int = 1) -> Self:  # noqa: D102
        values = {}
        for name, value in self._parameters().items():
            at = value.ndim - self._rank(name)
            values[name] = value.reshape(value.shape[:at] + (1,) * axes + value.shape[at:])
        return self.altered(**values)


def _family(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
    """W_m, m = 0 ... 3, of the order that comes first in `args`; of order -1 one less."""
    return _hooks.optional(_hooks.field(before=(3 + (args[0] >= 0),)))(said, own, given, args[1:])


@cache
def _keeps_its_family(kind: type[ShapedContact]) -> bool:
    own = next(i for i, base in enumerate(kind.__mro__) if "real_form" in vars(base))
    names = ("transforms", "unit_family", "disc_family", "drag_family", "unit_core")
    return not any(name in vars(base) for base in kind.__mro__[:own] for name in names)


_REAL = _hooks.field(real=True)
_MEMBERS: dict[str, _hooks.Rule] = {
    "unit_slope": _hooks.each_of((_REAL, _REAL), "two arrays, along y and along z,"),
    "unit_family": _family,
    "drag_family": _family,
    "unit_core": lambda said, own, given, args: _hooks.field()(said, own, given, args[:2]),
}


def _times(force: FloatArray, unit: FloatArray) -> FloatArray:
    """A force times a unit traction: no force makes nothing, even of an infinite one."""
    with np.errstate(invalid="ignore"):
        return _check.read_only(np.where(force == 0, 0.0, force * unit))
