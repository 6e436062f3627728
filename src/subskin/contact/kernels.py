"""The families of a load of 1 N on a point, of which all other contacts are sums (docs/local_contacts.md)."""

from __future__ import annotations

import numpy as np

from .._check import ComplexArray, FloatArray

__all__ = ["point_core", "point_family", "point_radial"]


def point_family(order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray:
    """`ShapedContact.unit_family` of a point load."""
    big = np.sqrt(x * x + zeta.real**2 + zeta.imag**2)
    w = -zeta / (big + x)
    factors = _factors(order, x, big)
    out = np.empty((len(factors), *w.shape), dtype=np.complex128)
    power: ComplexArray | float = 1.0
    for m, factor in enumerate(factors):
        out[m, ...] = power * factor
        power = power * w
    return out


def point_radial(order: int, x: FloatArray, r: FloatArray) -> list[FloatArray]:
    """The family at the distance r from the load, all but its direction (-e)^m: real."""
    big = np.sqrt(x * x + r * r)
    t, factors = r / (big + x), _factors(order, x, big)
    powers = (np.ones(()), t, t * t, t * t * t)
    return [np.asarray(power * factor) for power, factor in zip(powers, factors, strict=False)]


def _factors(order: int, x: FloatArray, big: FloatArray) -> list[FloatArray]:
    """What stands behind (-w)^m."""
    half = 0.5 / np.pi
    if order == -1:
        return [-half / big] * 3
    if order == 0:
        share = half / (big * big * big)
        return [(x + m * big) * share for m in range(4)]
    square = big * big
    share = -half / (square * square * big)
    return [((m * m - 1) * square + 3 * m * x * big + 3 * x * x) * share for m in range(4)]


def point_core(x: FloatArray, zeta: ComplexArray) -> ComplexArray:
    """W_0 + x W_0'/2 of a point load, 3 x r^2 / (4 pi R^5): on the axis both parts cancel."""
    square = zeta.real**2 + zeta.imag**2
    big = np.hypot(x, np.sqrt(square))
    return np.asarray(0.75 / np.pi * x * square / big**5, dtype=np.complex128)
