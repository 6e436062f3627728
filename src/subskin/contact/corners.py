"""Families of a bilinear traction on a rectangle, as sums over its corners (docs/local_contacts.md; Love 1929).

A corner at the distance (Y, Z) from the point's projection on the surface adds a function of (x, Y, Z), with the
product of the corner's two signs, here times 2 pi. Of f = 1 under a load without slopes W_0, W_1 and their derivatives
are real functions of an array namespace `xp`. `Corner` has all of the family, and the moments that f = y', z' and y' z'
need (`along`, `across`, `both`); there complex numbers are the shorter form, and lose nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .._check import ComplexArray, FloatArray
from .kernels import Parts

__all__ = ["Corner", "CornerSeen", "angle", "from_edge", "rectangle_parts", "sides", "slopes"]

_TINY = 1e-300


class CornerSeen(NamedTuple):
    """A corner seen from points: Y = y - y_corner, Z = z - z_corner, x >= 0; sqrt(Y^2 + x^2), sqrt(Z^2 + x^2) and R."""

    x: Any
    y: Any
    z: Any
    along: Any
    across: Any
    r: Any


def from_edge(xp: Any, x: Any, away: Any) -> Any:
    """The distance from an edge, or rather from the line on which it lies; never 0."""
    return xp.sqrt(xp.maximum(away * away + x * x, _TINY))


def angle(xp: Any, c: CornerSeen) -> Any:
    """W_0: the solid angle."""
    return xp.atan2(c.y * c.z, c.x * c.r)


def sides(xp: Any, c: CornerSeen) -> tuple[Any, Any]:
    """Real and imaginary part of W_1, E and F."""
    return xp.asinh(c.z / c.along), xp.asinh(c.y / c.across)


def slopes(xp: Any, c: CornerSeen) -> tuple[Any, Any, Any, Any]:
    """E' and F', which are W_1', and p and q, of which W_0' is the sum."""
    r = xp.maximum(c.r, _TINY)
    by_y, by_z = -1 / (r * (c.along * c.along)), -1 / (r * (c.across * c.across))
    both = c.y * c.z
    return c.x * c.z * by_y, c.x * c.y * by_z, both * by_y, both * by_z


def rectangle_parts(xp: Any, orders: Sequence[int], x: Any, y: Any, z: Any, ty: Any, tz: Any, a: Any, b: Any) -> Parts:
    """`RealForm.parts` of a rectangle |y'| <= a, |z'| <= b."""
    ys, zs = ([(s, from_edge(xp, x, s)) for s in (away + half, away - half)] for away, half in ((y, a), (z, b)))
    (one, two), (three, four) = (
        [CornerSeen(x, y, z, along, across, xp.sqrt(along * along + z * z)) for z, across in zs] for y, along in ys
    )
    out = []
    for order in orders:
        each = [
            (angle(xp, corner), *sides(xp, corner)) if order == 0 else _first_slopes(xp, corner)
            for corner in (one, two, three, four)
        ]
        even, by_y, by_z = (k - m - n + o for k, m, n, o in zip(*each, strict=True))
        share = (0.125 / np.pi) / (a * b)
        out.append((share * even, share * (ty * by_y + tz * by_z)))
    return out


def _first_slopes(xp: Any, c: CornerSeen) -> tuple[Any, Any, Any]:
    along, across, p, q = slopes(xp, c)
    return p + q, along, across


class Corner:
    """One corner, seen from points: Y = y - y_corner, Z = z - z_corner, x >= 0."""

    def __init__(self, x: FloatArray, y: FloatArray, z: FloatArray) -> None:
        self.x, self.y, self.z, self.r = x, y, z, np.sqrt(x * x + y * y + z * z)
        self._seen = seen = CornerSeen(x, y, z, from_edge(np, x, y), from_edge(np, x, z), self.r)
        self.w = np.maximum(self.r + x, _TINY)
        self.e, self.f = sides(np, seen)
        self.at = angle(np, seen)
        less = (y * y + z * z) / self.w  # R - x
        self.p = np.arctan2(-y * z * less, y * y * self.r + x * z * z)
        self.q = np.arctan2(-y * z * less, z * z * self.r + x * y * y)
        self.log = np.log(self.w)
        self.ze = y + 1j * z

    def one(self, order: int) -> list[ComplexArray]:
        """-V_m, W_m or W_m' of f = 1."""
        if order == -1:
            return self._summed(self.one(0), 1, [0.0, 0.0, 0.0])
        if order == 0:
            w1 = self.e + 1j * self.f
            return [self.at + 0j, w1, self.p - self.q - 2j * self.log, -np.conj(w1) - 4j * self.ze / self.w]
        r, (de, df, dp, dq) = self._safe, self._slopes
        d1 = de + 1j * df
        return [dp + dq + 0j, d1, dq - dp - 2j / r, 4j * self.ze / (self.w * r) - np.conj(d1)]

    def along(self, order: int) -> list[ComplexArray]:
        """Those of f = y - y', y being the point's and y' the traction's."""
        if order == -1:
            return self._summed(self.along(0), 2, [self.y * v for v in self.one(-1)], 0.5)
        return self._first(order, self.y, self.z, self.e, self.f, self.p, self.q, *self._slopes)

    def bilinear(
        self, order: int, one: FloatArray, by_y: FloatArray, by_z: FloatArray, by_yz: FloatArray
    ) -> ComplexArray:
        """Those of f = one + by_y y' + by_z z' + by_yz y' z', y' and z' being counted from the corner, shape (4, ...).

        Of order -1 the shape is (3, ...).
        """
        y, z = self.y, self.z
        out = [(one + by_y * y + by_z * z + by_yz * y * z) * f for f in self.one(order)]
        along, across = -(by_y + by_yz * z), -(by_z + by_yz * y)
        for slope, family in ((along, self.along), (across, self.across), (by_yz, self.both)):
            if np.any(slope):
                out = [total + slope * f for total, f in zip(out, family(order), strict=True)]
        return np.stack(out)

    def across(self, order: int) -> list[ComplexArray]:
        """Those of f = z - z': y and z exchanged, and conjugate."""
        if order == -1:
            return self._summed(self.across(0), 2, [self.z * v for v in self.one(-1)], 0.5j)
        de, df, dp, dq = self._slopes
        swapped = self._first(order, self.z, self.y, self.f, self.e, self.q, self.p, df, de, dq, dp)
        return [1j**m * np.conj(value) for m, value in enumerate(swapped)]

    def both(self, order: int) -> list[ComplexArray]:
        """Those of f = (y - y') (z - z')."""
        if order == -1:
            more = [self.y * b + self.z * a for a, b in zip(self.along(-1), self.across(-1), strict=True)]
            v = self._summed(self.both(0), 3, more)
            v[2] = v[2] + 5j / 6 * self.x * self.y * self.z
            return v
        x, y, z, r, w, e, f, at = self.x, self.y, self.z, self._safe, self.w, self.e, self.f, self.at
        ze = self.ze
        yx2, zx2 = y * y + x * x, z * z + x * x
        if order == 0:
            third = -(ze**3) / w - 1.5 * np.conj(ze) * r - 1.5 * zx2 * f + 1.5j * yx2 * e
            turned = y * y * self.p + z * z * self.q - x * x * at
            second = -(y * y - z * z) * self.log - 1j * y * z - 1j * turned
            return [-x * r + 0j, 0.5 * (ze * r - zx2 * f - 1j * yx2 * e), second, third]
        return [
            -r - x * x / r + 0j,
            x * (ze / r - f - 1j * e),
            -ze * ze / r + 2j * x * at,
            ze**3 / (r * w) - 3 * x * (f - 1j * e),
        ]

    @property
    def _safe(self) -> FloatArray:
        return np.maximum(self.r, _TINY)

    @property
    def _slopes(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """E', F', p, q."""
        return slopes(np, self._seen)

    def _first(
        self,
        order: int,
        y: FloatArray,
        z: FloatArray,
        e: FloatArray,
        f: FloatArray,
        p: FloatArray,
        q: FloatArray,
        de: FloatArray,
        df: FloatArray,
        dp: FloatArray,
        dq: FloatArray,
    ) -> list[ComplexArray]:
        x, r, w, at, log = self.x, self._safe, self.w, self.at, self.log
        if order == 0:
            third = x * p - 3 * x * q - 3 * z * f + 4 * y * z / w
            return [
                -x * e + 0j,
                -z * f + x * at + 1j * r,
                2 * z * log + x * e + 2j * x * f - 2j * z * q,
                third + 4j * (r - x * log) + 1j * (z * z - 3 * y * y) / w,
            ]
        third = p - x * dp - 3 * z * df - 3 * q + 3 * x * dq - 4 * y * z / (r * w)
        return [
            -e - x * de + 0j,
            -z * df + at + x * (dp + dq) + 1j * x / r,
            2 * z / r + e + x * de + 2j * f + 2j * x * df + 2j * z * dq,
            third - 4j * log - 1j * (z * z - 3 * y * y) / (r * w),
        ]

    def _summed(
        self, w: list[ComplexArray], degree: int, more: Sequence[ComplexArray | float], lift: complex = 0.0
    ) -> list[ComplexArray]:
        """-V_m from W_m by Euler's theorem, V_m being homogeneous but for Y Z log w, which lifts it.

        For f = 1, V_m' = -W_m, L V_m = W_{m+1} and L* V_m = -W_{m-1}; `more` is what the derivatives of f add to -V_m.
        """
        back, ze = [-np.conj(w[1]), *w], self.ze
        v = [(self.x * w[m] + more[m] - 0.5 * (np.conj(ze) * w[m + 1] - ze * back[m])) / degree for m in range(3)]
        v[1] = v[1] + lift * self.y * self.z
        return v
