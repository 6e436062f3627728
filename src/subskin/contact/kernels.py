"""The family of a load of 1 N on a point, of which all other contacts are sums (docs/local_contacts.md).

Pure functions of an array namespace `xp`: NumPy's here; they write nothing in place and do not ask for values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .._check import ComplexArray, FloatArray

__all__ = [
    "Parts",
    "PointSeen",
    "RealForm",
    "point_core",
    "point_factor",
    "point_family",
    "point_parts",
    "point_radial",
    "point_seen",
]

Parts: TypeAlias = list[tuple[Any, Any]]
"""W_0 and Re(tau* W_1) of a shape of unit load under a drag tau, or their derivatives along x: one pair each order."""


class RealForm(NamedTuple):
    """A shape's real functions: `parts(xp, orders, x, y, z, ty, tz, *sizes)`, of points at (y, z) from its centre.

    Where x^2 + y^2 + z^2 > `far`^2 those of `parts_far`, for `parts` would cancel.
    """

    parts: Callable[..., Parts]
    sizes: tuple[FloatArray, ...] = ()
    far: FloatArray | None = None
    parts_far: Callable[..., Parts] | None = None


class PointSeen(NamedTuple):
    """A point load seen from points at (y, z) from it: R, 1/(2 pi R^3) and 1/(2 pi R^5)."""

    x: Any
    y: Any
    z: Any
    big: Any
    cube: Any
    fifth: Any


def point_seen(xp: Any, x: Any, y: Any, z: Any) -> PointSeen:
    """What all members of the family have in common."""
    square = x * x + (y * y + z * z)
    big = xp.sqrt(square)
    cube = (0.5 / np.pi) / (square * big)
    return PointSeen(x, y, z, big, cube, cube / square)


def point_factor(at: PointSeen, order: int, m: int) -> Any:
    """What stands behind (-(y + i z))^m in -V_m, W_m or W_m'; order as in `ShapedContact.unit_family`."""
    x, big = at.x, at.big
    if order == -1:
        return -(0.5 / np.pi) / (big * _power(big + x, m))
    if order == 0:
        return at.cube if m == 1 else at.cube * (x if m == 0 else (x + m * big) / _power(big + x, m))
    if m == 3:
        return -at.fifth * (8 * big * big + 9 * x * big + 3 * x * x) / _power(big + x, 3)
    return at.fifth * (big * big - 3 * x * x if m == 0 else -3 * x if m == 1 else -3.0)


def _power(base: Any, m: int) -> Any:
    """A product: the power of an array by a number takes ten times as long."""
    return 1.0 if m == 0 else base if m == 1 else base * base if m == 2 else base * base * base


def point_parts(xp: Any, orders: Sequence[int], x: Any, y: Any, z: Any, ty: Any, tz: Any) -> Parts:
    """`RealForm.parts` of a point load."""
    at, away = point_seen(xp, x, y, z), -(ty * y + tz * z)
    return [(point_factor(at, order, 0), away * point_factor(at, order, 1)) for order in orders]


def point_family(order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray:
    """`ShapedContact.unit_family` of a point load."""
    at = point_seen(np, x, zeta.real, zeta.imag)
    out = np.empty((3 + (order >= 0), *np.shape(at.big)), dtype=np.complex128)
    power: ComplexArray | float = 1.0
    back = -zeta
    for m in range(len(out)):
        out[m] = power * point_factor(at, order, m)
        power = power * back
    return out


def point_radial(order: int, x: FloatArray, r: FloatArray) -> list[FloatArray]:
    """The family at the distance r from the load, all but its direction (-e)^m: real."""
    at = point_seen(np, x, r, 0.0)
    return [np.asarray(_power(r, m) * point_factor(at, order, m)) for m in range(3 + (order >= 0))]


def point_core(x: FloatArray, zeta: ComplexArray) -> ComplexArray:
    """W_0 + x W_0'/2 of a point load, 3 x r^2 / (4 pi R^5): on the axis both parts cancel."""
    at = point_seen(np, x, zeta.real, zeta.imag)
    return np.asarray(1.5 * x * (at.y * at.y + at.z * at.z) * at.fifth, dtype=np.complex128)
