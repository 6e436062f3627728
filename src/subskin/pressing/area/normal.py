"""The pressure beneath a rigid body: the least of p K p / 2 + f p with p >= 0 and some sums of p given.

Which nodes touch is guessed, their pressures are found by conjugate gradients, those that break a rule change sides,
and so on, as in a plane (bounded.py). Here a product costs most of the time, so none is spent on a change of the guess:
what that takes off is brought in with the next step, whose length is that of the step before. The preconditioner is the
inverse of a circulant on the nodes that touch, less at the rim, where beyond it nothing answers back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen
from ..bounded import BoolArray
from .influence import AreaInfluence

__all__ = ["Pressed", "finer", "pressed"]

_STEPS = 60
"""Conjugate gradients before a guess is given up."""
_CHANGES = 100
_LOOSE = 1.0
"""A guess is solved to this share of what breaks its bounds: it is about to change."""
_RIM = 0.75
"""Share of what neighbours beyond the rim would answer that is taken off there."""
_SINGLE = 3e5
"""Up to so many times the limit what is left is small enough for products in single precision."""
_ROUNDING = 1e-7
"""Share of a displacement that a product in single precision is off by."""
_TYPICAL = 0.85
"""Length of a first step, before there is another to go by."""


@dataclass(frozen=True)
class Pressed(Frozen):
    """Pressure, the multipliers of the sums, who touches, products by K, and whether every rule holds."""

    pressure: FloatArray
    multipliers: FloatArray
    touches: BoolArray
    products: int
    settled: bool


def pressed(
    op: AreaInfluence,
    f: FloatArray,
    body: BoolArray,
    sums: Sequence[FloatArray],
    targets: FloatArray,
    start: FloatArray,
    touches: BoolArray,
    limit: float,
) -> Pressed:
    """Solve from `start` with a first guess of who touches; gap and overlap to `limit` [m].

    f, body, start and touches have the shape (n, k), targets (c,); `sums` are c weights of shapes that broadcast to
    (n, k). Nothing presses where no body is.
    """
    free, own, rim = touches & body, op.own, _Rim(op)
    if not free.any():
        free = body & (f <= f[body].min() + limit)
    x = np.where(free, np.maximum(start, 0.0), 0.0)
    gradient, change, products, length, drift = f, x, 0, 1.0, 0.0
    multipliers, back = np.zeros(len(sums)), np.zeros(x.shape, dtype=bool)
    x = np.zeros(x.shape)
    for _ in range(_CHANGES):
        guess = _Guess(op, free, rim.of(free), sums)
        change = change + guess.restored(targets - _totals(sums, x + change))
        direction, before, blind, settled = np.zeros(x.shape, np.float32), 1.0, bool(change.any()), False
        for step in range(_STEPS + 1):
            if products:
                residual, z, multipliers = guess.answer(gradient, multipliers)
                error, now = max(float(residual.max()), -float(residual.min())), float(np.vdot(residual, z))
            if not products:  # the first: what the start itself moves
                x, gradient, products, blind = change, f + op.normal(change), 1, False
                multipliers = guess.mean(gradient)
                length = _TYPICAL
                continue
            if blind:
                change = change - length * z
                x, gradient = x + change, gradient + op.normal(change)
                products, blind, before = products + 1, False, 1.0
                continue
            breaks = max(0.0, -float(x.min()))
            settled = error <= limit
            if settled and drift > limit:
                gradient, products, drift, before = f + op.normal(x), products + 1, 0.0, 1.0
                direction[:] = 0.0
                continue
            if settled or error <= _LOOSE * own * breaks or step == _STEPS or not now > 0:
                break
            direction *= now / before
            direction -= z
            before = now
            exact = error > _SINGLE * limit
            moved = op.normal(direction.astype(np.float64) if exact else direction)
            products += 1
            curve = float(np.vdot(direction, moved))
            if not curve > 0:  # rounding is all that is left
                break
            length = now / curve
            moved *= length
            drift += 0.0 if exact else _ROUNDING * max(float(moved.max()), -float(moved.min()))
            gradient += moved
            x += length * direction
        gap = gradient - _shift(multipliers, sums)
        out, back = free & (x < 0), body & ~free & (gap < -limit)
        if settled and not back.any() and own * max(0.0, -float(x.min())) <= limit:
            return Pressed(np.maximum(x, 0.0), multipliers, free, products, True)
        change = np.where(out, -x, 0.0)
        free = (free & ~out) | back
        if not free.any():
            free = body & (gap <= gap[body].min() + limit)
    return Pressed(np.maximum(x, 0.0), multipliers, free, products, False)


class _Guess:
    """The preconditioner on the nodes that are guessed to touch, with the sums kept."""

    def __init__(self, op: AreaInfluence, free: BoolArray, less: FloatArray, sums: Sequence[FloatArray]) -> None:
        self.op, self.sums = op, sums
        self.free, self.less = free.astype(np.float32), less.astype(np.float32)
        self.spread = [self._solved((one * self.free).astype(np.float32)) for one in sums]
        rows = [_totals(sums, one) for one in self.spread]
        self.gram = np.linalg.inv(np.array(rows).T) if rows else np.zeros((0, 0))

    def _solved(self, masked: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        z = self.op.nearly(masked)
        z -= self.less * masked
        z *= self.free
        return z

    def restored(self, missing: FloatArray) -> FloatArray:
        """The change that brings in what is missing of the sums."""
        total = np.zeros(self.free.shape)
        for one, share in zip(self.spread, self.gram @ missing, strict=True):
            total += share * one
        return total

    def mean(self, gradient: FloatArray) -> FloatArray:
        """Multipliers to begin with."""
        weights = [one * self.free for one in self.sums]
        rows = np.array([_totals(self.sums, one) for one in weights]).reshape(len(weights), len(weights))
        return np.linalg.solve(rows, _totals(weights, gradient)) if weights else np.zeros(0)

    def answer(
        self, gradient: FloatArray, multipliers: FloatArray
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], FloatArray]:
        """What is left of the gradient where nodes touch, its answer, and the multipliers that leave it."""
        # less the multipliers so far what is left is small, and single precision enough for it
        masked = np.empty_like(self.free)
        np.subtract(gradient, _shift(multipliers, self.sums), out=masked, casting="same_kind")
        masked *= self.free
        z = self._solved(masked)
        more = self.gram @ _totals(self.sums, z)
        for share, one, spread in zip(more, self.sums, self.spread, strict=True):
            z -= np.float32(share) * spread
            masked -= (np.float32(share) * one.astype(np.float32)) * self.free
        return masked, z, multipliers + more


def _totals(sums: Sequence[FloatArray], x: npt.NDArray[Any]) -> FloatArray:
    return np.array([float((one * x).sum()) for one in sums])


def _shift(multipliers: FloatArray, sums: Sequence[FloatArray]) -> FloatArray | float:
    return sum((share * one for share, one in zip(multipliers, sums, strict=True)), start=0.0)


class _Rim:
    """What the preconditioner has less on nodes with neighbours that do not touch."""

    def __init__(self, op: AreaInfluence) -> None:
        _, self.straight, self.across = op.nearest()

    def of(self, free: BoolArray) -> FloatArray:
        wide = np.pad(~free, 1, mode="edge").astype(np.float64)
        across = wide[:-2] + wide[2:]
        straight = (wide[:-2] + wide[2:])[:, 1:-1] + (wide[1:-1, :-2] + wide[1:-1, 2:])
        corners = across[:, :-2] + across[:, 2:]
        return np.asarray(_RIM * free * (self.straight * straight + self.across * corners))


def finer(pressure: FloatArray) -> tuple[FloatArray, BoolArray]:
    """A start on a grid twice as fine, and who may touch there.

    At the rim the square of the pressure falls in a straight line, so the square is interpolated; beyond the rim it is
    continued by that line, below 0, and tells where between two nodes the contact ends.
    """
    square = pressure**2
    n, k = square.shape
    wide = np.pad(square, 2)
    rim = np.zeros((n, k), dtype=bool)
    touch = wide > 0
    outside = ~touch[2:-2, 2:-2]
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            if i or j:
                rim |= touch[2 + i : 2 + i + n, 2 + j : 2 + j + k]
    rim &= outside
    at = np.flatnonzero(rim)
    row, column = np.unravel_index(at, (n, k))
    total, lines = np.zeros(at.size), np.zeros(at.size)
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            if i or j:
                one = wide[row + 2 + i, column + 2 + j]
                two = wide[row + 2 + 2 * i, column + 2 + 2 * j]
                both = (one > 0) & (two > 0)
                total += np.where(both, 2 * one - two, 0.0)
                lines += both
    square.flat[at] = np.minimum(total / np.maximum(lines, 1.0), 0.0)
    out = np.empty((2 * n, 2 * k))
    last = np.concatenate([square, square[:, -1:]], axis=1)
    last = np.concatenate([last, last[-1:]], axis=0)
    by_y = 0.5 * (last[:-1] + last[1:])
    out[::2, ::2], out[1::2, ::2] = square, by_y[:, :-1]
    out[::2, 1::2] = 0.5 * (last[:-1, :-1] + last[:-1, 1:])
    out[1::2, 1::2] = 0.5 * (by_y[:, :-1] + by_y[:, 1:])
    return np.sqrt(np.maximum(out, 0.0)), out > 0
