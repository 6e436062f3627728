"""Families of axisymmetric shapes by a shift of their source into the complex (docs/local_contacts.md).

A point load's family, taken at the depth x - i t, has the flat punch of radius t as its imaginary part; any shape that
is the same in all directions is a sum of punches, f = integral of punch_t g(t) dt. Lengths are in units of the
contact's radius.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from .._check import ComplexArray, FloatArray
from .._frozen import Frozen

__all__ = ["ShiftedSource", "axial_family", "punch_core", "punches_over", "source_at"]

_T, _W = np.polynomial.legendre.leggauss(10)


class ShiftedSource(Frozen):
    """A point seen from a source at the depth Z = x - i t: R = sqrt(r^2 + Z^2), Re R >= 0 >= Im R."""

    def __init__(self, r: FloatArray, depth: ComplexArray, distance: ComplexArray) -> None:
        self.r, self.depth, self.distance = r, depth, distance
        total = distance + depth
        ratio = np.asarray(r / np.where(total == 0, 1.0, total))  # 0 on the axis
        # by products: its small imaginary part keeps its accuracy
        self.powers = [np.ones_like(ratio), ratio]
        for _ in range(4):
            self.powers.append(np.asarray(self.powers[-1] * ratio))
        self._kept: dict[tuple[int, int], ComplexArray] = {}

    @cached_property
    def _log(self) -> ComplexArray:
        return np.asarray(np.log(self.distance + self.depth))

    @cached_property
    def _inverse(self) -> ComplexArray:
        return np.asarray(1 / self.distance)

    def member(self, n: int, m: int) -> ComplexArray:
        """C(n, m): the n-th integral over the depth of the m-th member of a point load's family; n = -2 ... 3."""
        if (n, m) not in self._kept:
            self._kept[n, m] = np.asarray(self._member(n, m))
        return self._kept[n, m]

    def _member(self, n: int, m: int) -> ComplexArray:
        depth, far = self.depth, self.distance
        if n == 0:
            return self.powers[m] * self._inverse
        if n == 1:
            return -self._log if m == 0 else np.asarray(self.powers[m] / m, dtype=np.complex128)
        if n > 1 and m > 0:
            return self.r / (2 * m) * (self.member(n - 1, m - 1) + self.member(n - 1, m + 1))
        if n == 2:
            return depth * self._log - far
        if n == 3:
            return -(0.5 * depth * depth - 0.25 * self.r**2) * self._log + 0.75 * depth * far
        cube = self._inverse * self._inverse * self._inverse
        if n == -1:
            return self.powers[m] * (depth + m * far) * cube
        up = (m * m - 1) * far * far + 3 * m * depth * far + 3 * depth * depth
        return self.powers[m] * up * cube * self._inverse * self._inverse


def source_at(x: FloatArray, r: FloatArray, t: FloatArray | float) -> ShiftedSource:
    """The point (x, r) seen from a source at the depth x - i t."""
    x, r, t = np.broadcast_arrays(x, r, t)
    depth, far = np.empty(x.shape, dtype=np.complex128), np.empty(x.shape, dtype=np.complex128)
    depth.real, depth.imag = x, -t
    real = (r - t) * (r + t) + x * x
    size = np.hypot(real, 2 * t * x)
    large = np.sqrt(0.5 * (size + np.abs(real)))
    small = t * x / np.where(large > 0, large, 1.0)
    far.real, far.imag = np.where(real >= 0, large, small), -np.where(real >= 0, small, large)
    return ShiftedSource(r, depth, far)


Row = Callable[[int, int], FloatArray]
"""op(n, m) of a shape: real; V_m is op(0, m) times (-e)^m / (2 pi), each derivative along x lowers n by one."""


def axial_family(order: int, zeta: ComplexArray, r: FloatArray, row: Row) -> ComplexArray:
    """`ShapedContact.unit_family` of a shape from its row."""
    e = np.where(r > 0, zeta, 1.0) / np.where(r > 0, r, 1.0)
    members = [(-e) ** m * row(-1 - order, m) for m in range(3 if order == -1 else 4)]
    return np.asarray((-1.0) ** order / (2 * np.pi) * np.stack(members))


def punches_over(order: int, x: FloatArray, zeta: ComplexArray, low: FloatArray, power: int) -> ComplexArray:
    """The family of punches of all radii t from `low` to 1, weighed as t^power, of unit load: at points beyond."""
    r = np.abs(zeta)
    total, weight = np.zeros((), dtype=np.complex128), np.zeros(())
    for t, w in zip(_T, _W, strict=True):
        at = 0.5 * (1 + low) + 0.5 * (1 - low) * t
        source, share = source_at(x, r, at), w * at**power
        total = total + share * axial_family(order, zeta, r, lambda n, m: source.member(n + 1, m).imag / at)  # noqa: B023
        weight = weight + share
    return np.asarray(total / weight)


def punch_core(x: FloatArray, r: FloatArray, t: FloatArray | float) -> FloatArray:
    """W_0 + x W_0'/2 of a punch of radius t; no two terms cancel.

    With R = alpha - i beta it is x (3 alpha^2 (alpha^2 - x^2) + beta^2 (alpha^2 + 2 beta^2 + x^2)) / (4 pi alpha
    |R|^6) (docs/local_contacts.md).
    """
    far = source_at(x, r, t).distance
    alpha, beta = far.real, -far.imag
    b, c = x * x + (t - r) * (t + r), 2 * r * x
    size = np.hypot(b, c)
    total = np.where(b >= 0, b + size, 1.0)
    beyond = np.where(b >= 0, 0.5 * c * c / np.where(total > 0, total, 1.0), 0.5 * (size - b))
    a2, b2 = alpha * alpha, beta * beta
    return np.asarray(x * (3 * a2 * beyond + b2 * (a2 + 2 * b2 + x * x)) / (4 * np.pi * alpha * (a2 + b2) ** 3))


def punches_core(x: FloatArray, r: FloatArray, low: FloatArray, power: int) -> FloatArray:
    """`punch_core` of the punches of `punches_over`."""
    total, weight = np.zeros(()), np.zeros(())
    for t, w in zip(_T, _W, strict=True):
        at = 0.5 * (1 + low) + 0.5 * (1 - low) * t
        total, weight = total + w * at**power * punch_core(x, r, at), weight + w * at**power
    return np.asarray(total / weight)
