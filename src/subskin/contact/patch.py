"""The rectangular patch, uniform or bilinear."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt

from .._check import ComplexArray, FloatArray
from .._declared import Real
from .corners import Corner, rectangle_parts
from .kernels import Parts, RealForm, point_core, point_family, point_parts
from .profile import spherical_j1
from .shaped import Row, ShapedContact

__all__ = ["HALF_WIDTHS", "Patch"]

HALF_WIDTHS = Row(2, "m", "(a_y, a_z)", above=0.0, fix="half_widths=(1e-3, 2e-3) in metres, along y and along z")

_FAR = 8.0
_FAR_REAL = 30.0
"""Of a uniform patch W_0 and W_1 lose no more than 3e-13 to cancellation up to so many half widths."""
_ROUNDING = 1e-12
"""Of half a width, within which a point is on an edge."""
_T, _W = np.polynomial.legendre.leggauss(8)
_FEW = np.polynomial.legendre.leggauss(4)


def _form(a: Any, b: Any, *turn: Any) -> RealForm:
    """The real form of a uniform rectangle.

    Parameters
    ----------
    a, b : float or array of any namespace
        Half widths along y and z before it is turned [m].
    *turn : float or array of any namespace, optional
        Angle by which it is turned [rad].
    """
    far = _FAR_REAL * 0.5 * (a + b + abs(a - b))
    if turn:
        return RealForm(partial(_turned_parts, rectangle_parts), (a, b, *turn), far, partial(_turned_parts, _far_parts))
    return RealForm(rectangle_parts, (a, b), far, _far_parts)


def _turned_parts(
    parts: Callable[..., Parts], xp: Any, orders: Sequence[int], x: Any, y: Any, z: Any, ty: Any, tz: Any, *sizes: Any
) -> Parts:
    """`RealForm.parts` of a rectangle, the last of whose sizes is its turn: those seen along its own sides."""
    *sides, turn = sizes
    c, s = xp.cos(turn), xp.sin(turn)
    return parts(xp, orders, x, c * y + s * z, c * z - s * y, c * ty + s * tz, c * tz - s * ty, *sides)


@dataclass(frozen=True, eq=False, init=False)
class Patch(ShapedContact, name="patch"):
    """A rectangle |y'| <= a_y, |z'| <= a_z about `position`, its traction in proportion to a bilinear function.

    That is 1 + s_y y' + s_z z' + s_yz y' z', with s = `slopes`. Source: docs/local_contacts.md; Love 1929. On the edges
    the stress is infinite under drag, and the pressure jumps.
    Parameters force, angle, azimuth, position, components and moment as in `ShapedContact`.

    Parameters
    ----------
    half_widths : array_like, shape (..., 2)
        Half the widths along y and along z before it is turned [m], > 0; required.
    slopes : array_like, shape (..., 3), optional
        Of the traction per y' [1/m], per z' [1/m] and per y' z' [1/m^2], relative to its mean.
    turn : array_like, optional
        Angle by which the rectangle is turned, its y' and z' with it, from +y towards +z [rad].

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; shapes that do not broadcast.

    Examples
    --------
    >>> pad = Patch(force=1.0, half_widths=(2e-3, 1e-3), slopes=(100.0, 0.0, 0.0))
    >>> pad.pressure([-1e-3, 0.0, 1e-3, 3e-3], 0.0).round(3).tolist()
    [112500.0, 125000.0, 137500.0, 0.0]
    """

    RANKS: ClassVar[dict[str, int]] = {"components": 1, "position": 1, "half_widths": 1, "slopes": 1}

    half_widths: Annotated[FloatArray, HALF_WIDTHS] = (np.nan, np.nan)  # type: ignore[assignment]
    slopes: Annotated[FloatArray, Row(3, "1/m", "(per y, per z, per yz)")] = (0.0, 0.0, 0.0)  # type: ignore[assignment]
    turn: Annotated[FloatArray, Real("rad")] = 0.0  # type: ignore[assignment]

    def _sizes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Both half widths in units of the larger one, and that."""
        a = self.half_widths
        size = a.max(axis=-1)
        return a[..., 0] / size, a[..., 1] / size, size

    def unit_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray:  # noqa: D102
        a, b, size = self._sizes()
        s, along = self.slopes, np.exp(1j * self.turn)
        zeta = zeta * np.conj(along)
        arrays = (x / size, zeta.real / size, zeta.imag / size, a, b, s[..., 0] * size, s[..., 1] * size)
        x, y, z, a, b, by_y, by_z, by_yz = np.broadcast_arrays(*arrays, s[..., 2] * size**2)
        far = x * x + y * y + z * z > _FAR**2
        out = np.empty((3 if order == -1 else 4, *x.shape), dtype=np.complex128)
        for chosen, family in ((far, _far_family), (~far, _near_family)):
            if chosen.any():
                out[:, chosen] = family(order, *(v[chosen] for v in (x, y, z, a, b, by_y, by_z, by_yz)))
        m = np.arange(len(out)).reshape(-1, *(1,) * x.ndim)
        return np.asarray(out * along**m / size ** (2 + order))

    FORM = staticmethod(_form)

    def real_form(self) -> RealForm | None:  # noqa: D102
        if self.slopes.any():
            return None
        turn = (self.turn,) if self.turn.any() else ()
        return self.FORM(self.half_widths[..., 0], self.half_widths[..., 1], *turn)

    def unit_core(self, x: FloatArray, zeta: ComplexArray, w: ComplexArray, dw: ComplexArray) -> ComplexArray:  # noqa: D102
        core = super().unit_core(x, zeta, w, dw)
        a, b, size = self._sizes()
        zeta = zeta * np.exp(-1j * self.turn)
        far = np.broadcast_to((x * x + np.abs(zeta) ** 2) / size**2 > _FAR**2, core.shape)
        if far.any():
            s = self.slopes
            arrays = (x / size, zeta / size, a, b, s[..., 0] * size, s[..., 1] * size, s[..., 2] * size**2, size)
            x, zeta, a, b, by_y, by_z, by_yz, size = (np.broadcast_to(v, core.shape)[far] for v in arrays)
            total = np.zeros(x.shape, dtype=np.complex128)
            for y, z, share in _nodes(a, b, by_y, by_z, by_yz):
                total += share * point_core(x, zeta - (y + 1j * z))
            core[far] = total / size**2
        return core

    def unit_spectrum(self, ky: FloatArray, kz: FloatArray) -> ComplexArray:  # noqa: D102
        a, b, s = self.half_widths[..., 0], self.half_widths[..., 1], self.slopes
        ky, kz = self._own(ky, kz)
        even_y, even_z = np.sinc(ky * a / np.pi), np.sinc(kz * b / np.pi)
        odd_y, odd_z = -1j * a * spherical_j1(np.asarray(ky * a)), -1j * b * spherical_j1(np.asarray(kz * b))
        first = s[..., 0] * odd_y * even_z + s[..., 1] * even_y * odd_z
        return np.asarray(even_y * even_z + first + s[..., 2] * odd_y * odd_z)

    def _own(self, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """A vector's parts along the sides."""
        c, s = np.cos(self.turn), np.sin(self.turn)
        return np.asarray(c * y + s * z), np.asarray(c * z - s * y)

    def unit_pressure(self, y: FloatArray, z: FloatArray) -> FloatArray:  # noqa: D102
        a, b, s = self.half_widths[..., 0], self.half_widths[..., 1], self.slopes
        y, z = self._own(y, z)
        inside = (np.abs(y) <= a) & (np.abs(z) <= b)
        return np.where(inside, 1 + s[..., 0] * y + s[..., 1] * z + s[..., 2] * y * z, 0.0) / (4 * a * b)

    def unit_slope(self, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """As `ShapedContact.unit_slope`, within the patch; those on its edges, which are infinite, are left out."""
        a, b, s = self.half_widths[..., 0], self.half_widths[..., 1], self.slopes
        y, z = self._own(y, z)
        share = np.where((np.abs(y) <= a) & (np.abs(z) <= b), 1 / (4 * a * b), 0.0)
        along, across, c, n = s[..., 0] + s[..., 2] * z, s[..., 1] + s[..., 2] * y, np.cos(self.turn), np.sin(self.turn)
        return share * (c * along - n * across), share * (n * along + c * across)

    @property
    def torque(self) -> FloatArray:  # noqa: D102
        arms = self.slopes[..., :2] * self.half_widths**2 / 3
        ty, tz = self._own(self.components[..., 1], self.components[..., 2])
        return np.asarray(self.moment + tz * arms[..., 0] - ty * arms[..., 1])

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        a, b = self.half_widths[..., 0], self.half_widths[..., 1]
        c, s = np.abs(np.cos(self.turn)), np.abs(np.sin(self.turn))
        reach = np.stack([c * a + s * b, s * a + c * b], axis=-1)
        return self.position - reach, self.position + reach

    def singular(self, y: FloatArray, z: FloatArray) -> npt.NDArray[np.bool_]:
        """As `LocalContact.singular`: the edges, where the traction jumps."""
        a, b, away = self.half_widths[..., 0], self.half_widths[..., 1], self._zeta(y, z)
        y, z = (np.abs(part) for part in self._own(away.real, away.imag))
        on_y, on_z = (np.isclose(at, side, rtol=_ROUNDING, atol=0) for at, side in ((y, a), (z, b)))
        return np.asarray((on_y & (on_z | (z < b))) | (on_z & (y < a)))


def _near_family(
    order: int,
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    a: FloatArray,
    b: FloatArray,
    by_y: FloatArray,
    by_z: FloatArray,
    by_yz: FloatArray,
) -> ComplexArray:
    """The sum over the corners."""
    total = np.zeros((), dtype=np.complex128)
    for side_y in (-1, 1):
        for side_z in (-1, 1):
            at_y, at_z = side_y * a, side_z * b
            corner = Corner(x, y - at_y, z - at_z)
            one = 1 + by_y * at_y + by_z * at_z + by_yz * at_y * at_z
            part = corner.bilinear(order, one, by_y + by_yz * at_z, by_z + by_yz * at_y, by_yz)
            total = total + side_y * side_z * part
    return np.asarray(total / (8 * np.pi * a * b))


def _far_family(
    order: int, x: FloatArray, y: FloatArray, z: FloatArray, a: FloatArray, b: FloatArray, *slopes: FloatArray
) -> ComplexArray:
    """The sum over point loads: far away the corners cancel."""
    zeta, total = y + 1j * z, np.zeros((), dtype=np.complex128)
    for at_y, at_z, share in _nodes(a, b, *slopes):
        total = total + share * point_family(order, x, zeta - (at_y + 1j * at_z))
    return np.asarray(total)


def _far_parts(
    xp: Any, orders: Sequence[int], x: Any, y: Any, z: Any, ty: Any, tz: Any, a: Any, b: Any
) -> list[tuple[Any, Any]]:
    """`RealForm.parts` of a uniform patch as a sum over point loads."""
    total: list[tuple[Any, Any]] = [(0.0, 0.0)] * len(orders)
    for s, ws in zip(*_FEW, strict=True):
        for t, wt in zip(*_FEW, strict=True):
            share, parts = 0.25 * ws * wt, point_parts(xp, orders, x, y - a * s, z - b * t, ty, tz)
            total = [(w + share * dw, h + share * dh) for (w, h), (dw, dh) in zip(total, parts, strict=True)]
    return total


def _nodes(
    a: FloatArray, b: FloatArray, by_y: FloatArray, by_z: FloatArray, by_yz: FloatArray
) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Gauss's points, and the share of the load on each."""
    rows = []
    for s, ws in zip(_T, _W, strict=True):
        for t, wt in zip(_T, _W, strict=True):
            y, z = a * s, b * t
            rows.append((y, z, 0.25 * ws * wt * (1 + by_y * y + by_z * z + by_yz * y * z)))
    return rows
