"""What a stack of layers adds to a half space under a radial load: functions of the distance, as tables.

A load at the origin, seen from the polar angle theta, e = exp(i theta): every component is a sum of N, tau = Ty + i Tz,
its conjugate or the moment, times e^m, times a Hankel transform of order m of one of the answers to a wave
(docs/skins.md): ten make stress and strain, five the displacement, three more those of a moment. Each is kept as
f_m / r^m over r^2, smooth and without an angle, in pieces of Chebyshev polynomials.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .._check import FloatArray
from ._layer_modes import Stack, antiplane
from ._synthesis import panels

__all__ = [
    "DISPLACEMENTS",
    "FIELDS",
    "NODES",
    "ORDER",
    "STATE",
    "TAIL",
    "TILT",
    "TO_TERMS",
    "RadialSpectrum",
    "RadialTable",
    "decay_length",
    "point_table",
    "polynomials",
    "radial_table",
    "wave_answers",
    "waves_for",
]

ORDER = 32
"""Terms of a piece."""
NODES = np.cos(np.pi * (np.arange(ORDER) + 0.5) / ORDER)
TO_TERMS = np.cos(np.pi * np.arange(ORDER)[:, None] * (np.arange(ORDER) + 0.5) / ORDER) * 2 / ORDER
TO_TERMS[0] /= 2
TAIL = 1e-14
"""Last terms, beside the size of what was summed, with which a piece is fine enough."""
_TOGETHER = 2048


def polynomials(terms: FloatArray, t: FloatArray) -> FloatArray:
    """Sums of Chebyshev polynomials at t, shape (columns of `terms`, n)."""
    out, rows = np.empty((terms.shape[1], t.size)), np.empty((ORDER, min(t.size, _TOGETHER)))
    for first in range(0, t.size, _TOGETHER):
        part = slice(first, first + _TOGETHER)
        at = t[part]
        basis = rows[:, : at.size]
        basis[0], basis[1] = 1.0, at
        for n in range(2, ORDER):
            np.multiply(2 * at, basis[n - 1], out=basis[n])
            basis[n] -= basis[n - 2]
        out[:, part] = terms.T @ basis
    return out


_DECAY = 42.0
"""exp(-42) is far below rounding, also with the polynomials of k that stand before it."""

FIELDS, DISPLACEMENTS = slice(0, 12), slice(12, 18)

_GROWTH = 3.0
"""Each piece reaches so many times as far as the last from where the function is singular, r^2 = -length^2."""
_FINEST = 1 / 64
_BLOCK = 1 << 20
_LARGE = 20_000
"""Wavenumbers, of more than which no answers are kept."""


def decay_length(stack: Stack, x: FloatArray) -> FloatArray:
    """Length [m] such that what is summed falls as exp(-k length): an echo in the first layer, all of it deeper."""
    top = stack.layers[0].thickness
    return np.where(x <= top, 2 * top - x, x)


def wave_answers(stack: Stack, k: FloatArray, x: FloatArray) -> FloatArray:
    """The stack's answers at depths x to waves of p, of the drag along them and across, shape (10, x, k).

    For p, q_l and q_t times exp(i k l): s_xx = A_n p + i A_t q_l, s_xl = i C_n p + C_t q_l, s_xt = c q_t, and
    2 G k u_x = U_n p + i U_t q_l, 2 G k u_l = i L_n p + L_t q_l, G k u_t = b q_t, G of the first layer, in the order A,
    C, L, U (n, t), c, b. In the first layer they are less those of a half space of its material.
    """
    y = np.moveaxis(stack.amplitudes(k, x, remainder=True), (2, 3), (0, 1))
    across = np.moveaxis(antiplane(stack, k, x), 2, 0)
    rows = [y[2, 0], y[2, 1], -y[3, 0], y[3, 1], -k * y[1, 0], k * y[1, 1], k * y[0, 0], k * y[0, 1], *across]
    return np.stack(rows)


def quotients(x: FloatArray) -> FloatArray:
    """J_m(x) / x^m for m = 0 ... 3, shape (4, ...)."""
    from scipy.special import j0, j1

    small = x < 2.0
    at = np.where(small, 2.0, x)
    zero, one = j0(x), j1(at)
    two = 2 * one / at - zero
    three = 4 * two / at - one
    out = np.stack([zero, one / at, two / at**2, three / at**3])
    square = -0.25 * x[small] ** 2
    for m, first in ((1, 1 / 2), (2, 1 / 8), (3, 1 / 48)):
        total = np.ones_like(square)
        for j in range(14, 0, -1):
            total = 1 + total * square / (j * (j + m))
        out[m, small] = first * total
    return out


class Functions(NamedTuple):
    """The order m of each of some functions, and what their Hankel transforms are of, but for k / (2 pi)."""

    orders: tuple[int, ...]
    of: Callable[[FloatArray, FloatArray], list[FloatArray]]


@dataclass(frozen=True)
class RadialSpectrum:
    """The Hankel transform of a shape of unit load, known by a few of its values."""

    key: bytes
    reach: float = field(compare=False)
    """Radius of the shape [m]."""
    of: Callable[[FloatArray], FloatArray] = field(compare=False)


def _of_state(answers: FloatArray, k: FloatArray) -> list[FloatArray]:
    an, at, cn, ct, ln, lt, un, ut, c, b = answers
    here, there = 0.5 * lt + b, 0.5 * lt - b
    fields = [an, -at, -ln, -lt, -cn, 0.5 * (ct + c), 0.5 * (c - ct), ln, -here, there, 0.5 * k * c, -k * b]
    return [*fields, un / k, -ut / k, -ln / k, here / k, -there / k, b]


def _of_tilt(answers: FloatArray, k: FloatArray) -> list[FloatArray]:
    un, ut = answers[6], answers[7]
    return [-un, -0.5 * ut, 0.5 * ut]


STATE = Functions((0, 1, 0, 1, 1, 0, 2, 2, 1, 3, 1, 2, 0, 1, 1, 0, 2, 1), _of_state)
TILT = Functions((1, 0, 2), _of_tilt)


@dataclass(eq=False)
class RadialTable:
    """f_m / r^m of some functions over r^2 at one depth, as far as they were asked for.

    Of `STATE` the first twelve make stress and strain: s_xx and 2 G (eps_yy + eps_zz) of N and of the drag; s_xy + i
    s_xz of N, tau and its conjugate; 2 G (eps_yy - eps_zz + 2 i eps_yz) of the same; and the last two of the moment.
    Six more make the displacement: 2 G u_x of N and of the drag; 2 G (u_y + i u_z) of N, tau, its conjugate and the
    moment. The three of `TILT` make 2 G L u_x, L = d/dy + i d/dz: of N, tau and its conjugate.
    """

    stack: Stack
    depth: float
    spectrum: RadialSpectrum
    functions: Functions

    def __post_init__(self) -> None:
        self._length = float(decay_length(self.stack, np.array(self.depth)))
        self._orders = np.array(self.functions.orders)
        self._edges = np.zeros(1)
        self._pieces: list[FloatArray] = []
        self._asked = 0

    def at(self, u: FloatArray, which: slice) -> FloatArray:
        """The functions at u = r^2 [m^2], shape (functions, n)."""
        if not u.size:
            return np.zeros((self._orders[which].size, 0))
        farthest = float(u.max())
        if farthest >= self._edges[-1] and self._asked + u.size < ORDER:  # so few are quicker one by one
            self._asked += u.size
            return self._summed(np.sqrt(u), float(np.sqrt(farthest)))[0][which]
        self._reach(farthest)
        piece = np.searchsorted(self._edges[1:-1], u, side="right")
        used = np.unique(piece)
        out = np.empty((self._orders[which].size, u.size))
        for j in used:
            chosen = slice(None) if used.size == 1 else np.flatnonzero(piece == j)
            low, high = self._edges[j : j + 2]
            t = (2 * u[chosen] - (low + high)) / (high - low)
            out[:, chosen] = polynomials(self._pieces[j][:, which], t)
        return out

    def _reach(self, u: float) -> None:
        square = self._length**2
        while not self._pieces or self._edges[-1] < u:
            low = float(self._edges[-1])
            self._add(low, _GROWTH * (low + square) - square)

    def _add(self, low: float, high: float) -> None:
        terms, scale = self._terms(low, high)
        size = np.sqrt(high) ** self._orders
        off = np.abs(terms[-3:]).max(axis=0) * size > TAIL * scale
        if off.any() and high - low > _FINEST * (low + self._length**2):
            middle = 0.5 * (low + high)
            self._add(low, middle)
            self._add(middle, high)
            return
        self._edges = np.append(self._edges, high)
        self._pieces.append(terms)

    def _terms(self, low: float, high: float) -> tuple[FloatArray, FloatArray]:
        """Chebyshev terms (order, functions) between two values of r^2, and the sizes of what was summed."""
        r = np.sqrt(0.5 * (low + high) + 0.5 * (high - low) * NODES)
        values, size = self._summed(r, float(np.sqrt(high)))
        return TO_TERMS @ values.T, size

    def _summed(self, r: FloatArray, far: float) -> tuple[FloatArray, FloatArray]:
        """The functions at distances up to `far`, (functions, n), and the sizes of what was summed."""
        k, weights = waves_for(self.stack, self._length, far + self.spectrum.reach)
        kernels = np.stack(self.functions.of(_answers_at(self.stack, self.depth, k), k)) * k / (2 * np.pi)
        kernels = kernels * (weights * self.spectrum.of(k))
        values, step = np.zeros((self._orders.size, r.size)), max(1, _BLOCK // r.size)
        for first in range(0, k.size, step):
            part = slice(first, first + step)
            bessel = quotients(k[part, None] * r)
            for m in range(4):
                same = self._orders == m
                values[same] += (kernels[same, part] * k[part] ** m) @ bessel[m]
        return values, np.abs(kernels).sum(axis=1)


@lru_cache(maxsize=512)
def radial_table(stack: Stack, depth: float, spectrum: RadialSpectrum, functions: Functions) -> RadialTable:
    """The table of some functions at a depth [m] under a shape."""
    return RadialTable(stack, depth, spectrum, functions)


def point_table(stack: Stack, depth: float) -> RadialTable:
    """The table of the state at a depth [m] under a point load."""
    return radial_table(stack, depth, RadialSpectrum(b"", 0.0, np.ones_like), STATE)


def waves_for(stack: Stack, length: float, reach: float) -> tuple[FloatArray, FloatArray]:
    """Wavenumbers and weights, for points within `reach` [m] of all of the contact."""
    total = float(stack.tops[-1])
    return panels(_DECAY / length, max(reach, total) + 2 * total)


@lru_cache(maxsize=16)
def _known(stack: Stack, depth: float, k: bytes) -> FloatArray:
    return wave_answers(stack, np.frombuffer(k), np.array([depth]))[:, 0]


def _answers_at(stack: Stack, depth: float, k: FloatArray) -> FloatArray:
    """`wave_answers` at one depth, shape (10, k), kept."""
    if k.size > _LARGE:
        return wave_answers(stack, k, np.array([depth]))[:, 0]
    return _known(stack, depth, k.tobytes())
