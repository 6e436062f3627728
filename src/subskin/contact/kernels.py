"""The family of a load of 1 N on a point, of which all other contacts are sums, and real forms of shapes on a disc.

Pure functions of an array namespace `xp`: NumPy's here; they write nothing in place and do not ask for values. Source:
docs/local_contacts.md. The forms on a disc are what pressure and strain along x are made of: real and imaginary parts
of the complex shift of `shifted`, written out. With R = alpha - i beta, seen from a source at the depth x - i t; the
radius of the disc is 1, r^2 the square of the distance from its axis. Each gives W_0 and -W_1 / (y + i z), or their
derivatives along x, for each of the orders.
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
    "cone_disc",
    "disc_form",
    "hertz_disc",
    "point_core",
    "point_factor",
    "point_family",
    "point_parts",
    "point_radial",
    "point_seen",
    "punch_disc",
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


Disc: TypeAlias = Callable[[Any, Sequence[int], Any, Any], Parts]

_FAR = 2.0
"""Radii beyond which Hertz's and the cone's closed forms cancel: there they are sums of punches."""
_T, _W = np.polynomial.legendre.leggauss(10)
_T = 0.5 * (1 + _T)


class _Shift(NamedTuple):
    """Of a source at x - i t: alpha, beta, |R|^2, R^2's real part, and R + Z = a - i b with |R + Z|^2."""

    alpha: Any
    beta: Any
    size: Any
    square: Any
    a: Any
    b: Any
    total: Any


def _shift(xp: Any, x: Any, r2: Any, t: Any) -> _Shift:
    square, across = r2 - t * t + x * x, t * x
    size = xp.sqrt(square * square + 4 * across * across)
    large = xp.sqrt(0.5 * (size + xp.abs(square)))
    small = across / large
    front = square >= 0
    alpha, beta = xp.where(front, large, small), xp.where(front, small, large)
    a, b = alpha + x, beta + t
    return _Shift(alpha, beta, size, square, a, b, a * a + b * b)


def punch_disc(xp: Any, orders: Sequence[int], x: Any, r2: Any, t: Any = 1.0) -> Parts:
    """A flat punch of radius t."""
    s = _shift(xp, x, r2, t)
    alpha, beta, size = s.alpha, s.beta, s.size
    out, share = [], 0.5 / (np.pi * t)
    for order in orders:
        if order == 0:
            # Im(1 / R), and Im(1 / (R (R + Z)))
            scale, w, h = share, beta / size, (alpha * s.b + beta * s.a) / (size * s.total)
        else:
            # -Im(Z / R^3), and -Im(1 / R^3)
            scale, h = share / (size * size * size), -beta * (3 * alpha * alpha - beta * beta)
            w = s.square * (t * alpha - x * beta) - 2 * x * t * (x * alpha + t * beta)
        out.append((scale * w, scale * h))
    return out


def hertz_disc(xp: Any, orders: Sequence[int], x: Any, r2: Any) -> Parts:
    """Hertz's half ellipsoid."""
    s = _shift(xp, x, r2, 1.0)
    turn, share = xp.atan2(s.b, s.a), 1.5 / np.pi
    out = []
    for order in orders:
        if order == 0:
            h = 0.5 * turn + 0.5 * r2 * s.a * s.b / (s.total * s.total) - s.a / s.total
            out.append((share * (s.beta - x * turn), share * h))
        else:
            back = (s.alpha * s.a - s.beta * s.b) / (s.size * s.total)  # Re(1 / (R (R + Z)))
            out.append((share * (s.alpha / s.size - turn), share * (back - s.b / s.total)))
    return out


def cone_disc(xp: Any, orders: Sequence[int], x: Any, r2: Any) -> Parts:
    """A cone: its tip less its rim."""
    s, tip = _shift(xp, x, r2, 1.0), xp.sqrt(r2 + x * x)
    out = []
    for order in orders:
        if order == 0:
            w, h = 0.5 * xp.log(s.total) - xp.log(tip + x), 1 / (tip + x) - s.a / s.total
        else:
            back = (s.alpha * s.a - s.beta * s.b) / (s.size * s.total)
            w, h = s.alpha / s.size - 1 / tip, back - 1 / (tip * (tip + x))
        out.append((w / np.pi, h / np.pi))
    return out


def _punches(power: int) -> Disc:
    """Punches of all radii up to 1, weighed as t^power."""
    weights = _W * _T**power / (_W * _T**power).sum()

    def disc(xp: Any, orders: Sequence[int], x: Any, r2: Any) -> Parts:
        total: Parts = [(0.0, 0.0)] * len(orders)
        for t, share in zip(_T.tolist(), weights.tolist(), strict=True):
            parts = punch_disc(xp, orders, x, r2, t)
            total = [(w + share * dw, h + share * dh) for (w, h), (dw, dh) in zip(total, parts, strict=True)]
        return total

    return disc


def _of_disc(disc: Disc) -> Callable[..., Parts]:
    """`RealForm.parts` of a shape on a disc of radius a."""

    def parts(xp: Any, orders: Sequence[int], x: Any, y: Any, z: Any, ty: Any, tz: Any, a: Any) -> Parts:
        y, z, scale = y / a, z / a, 1 / (a * a)
        away = -(ty * y + tz * z)
        each = zip(orders, disc(xp, orders, x / a, y * y + z * z), strict=True)
        return [(scale / a**order * w, scale / a**order * away * h) for order, (w, h) in each]

    return parts


def disc_form(disc: Disc, power: int | None = None) -> Callable[[Any], RealForm]:
    """The real form of a shape as a function of the radius; far away as punches weighed as t^power, or as it is."""
    near, far = _of_disc(disc), None if power is None else _of_disc(_punches(power))

    def form(a: Any) -> RealForm:
        """The real form of a shape on a disc.

        Parameters
        ----------
        a : float or array of any namespace
            Its radius [m].
        """
        return RealForm(near, (a,), None if far is None else _FAR * a, far)

    return form
