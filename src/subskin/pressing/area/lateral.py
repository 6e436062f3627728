"""The drag beneath a rigid body: the least of q K q / 2 + w q with |q| <= friction times p and some sums of q given.

As beneath the pressure it is guessed which nodes stick; the others have the greatest drag, of a direction that is
found. The slip, K q + w less the body's motion, vanishes where they stick and is against the drag where they slip:
Newton's method for those conditions, each step by conjugate gradients over both components where nodes stick and over
the turn of the drag where they slip (Alart and Curnier 1991 have the conditions).
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
from .normal import finer

__all__ = ["Dragged", "dragged", "finer_drag"]

_STEPS = 40
_CHANGES = 60
_LOOSE = 0.5
_SINGLE = 3e5
_AT_BOUND = 1e-9
"""A drag nearer to the greatest than this share of it is the greatest."""
_ROUNDING = 1e-7
_TYPICAL = 0.85
_SOFT = 0.3
"""Share of its stiffness against turning by which a node that slips answers less; measured, 29 products for 35."""

Single = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Dragged(Frozen):
    """Drag (2, n, k), the multipliers of the sums, who sticks, products by K, and whether every rule holds."""

    shear: FloatArray
    multipliers: FloatArray
    sticks: BoolArray
    products: int
    settled: bool


def dragged(
    op: AreaInfluence,
    w: FloatArray,
    held: FloatArray,
    sums: Sequence[FloatArray],
    targets: FloatArray,
    start: FloatArray,
    sticks: BoolArray,
    limit: float,
) -> Dragged:
    """Solve from `start` with a first guess of who sticks; creep to `limit` [m].

    w and start have the shape (2, n, k), held (n, k), targets (c,); `sums` are c weights that broadcast to (2, n, k).
    """
    touch = held > 0
    own = float(op.rows[1, 0, 0] - op.rows[1, 0, 1])
    stick = sticks & touch
    q, change = np.zeros(w.shape), _onto(np.where(touch, start, 0.0), held, touch & ~stick)
    gradient, products, length, drift = w, 0, 1.0, 0.0
    slip, multipliers = w, np.zeros(len(sums))
    for _ in range(_CHANGES):
        guess = _Guess(op, q + change, slip, held, stick, touch, sums)
        restored = guess.restored(targets - _totals(sums, q + change))
        change = change + restored
        guess.turn(restored)
        direction, before, blind, settled = np.zeros(w.shape, np.float32), 1.0, bool(change.any()), False
        for step in range(_STEPS + 1):
            if not products:
                q, gradient, products, blind, length = change, w + op.lateral(change), 1, False, _TYPICAL
                multipliers = guess.mean(gradient)
                slip = gradient - _shift(multipliers, sums)
                guess.stiffen(slip)
                guess.turned[:] = 0.0
                continue
            residual, z, multipliers = guess.answer(gradient, multipliers)
            error, now = float(np.abs(residual).max()), float(np.vdot(residual, z))
            if blind:
                guess.turn(-length * z)
                change = change - length * z
                q, gradient = q + change, gradient + op.lateral(change)
                products, blind, before = products + 1, False, 1.0
                continue
            size = np.hypot(*q)
            over = _most(size - held, touch)
            settled = error <= limit
            if settled and drift > limit:
                gradient, products, drift, before = w + op.lateral(q), products + 1, 0.0, 1.0
                direction[:] = 0.0
                continue
            if settled or error <= _LOOSE * own * over or step == _STEPS or not now > 0:
                break
            direction *= now / before
            direction -= z
            before = now
            exact = error > _SINGLE * limit
            moved = op.lateral(direction.astype(np.float64) if exact else direction)
            products += 1
            curve = float(np.vdot(direction, moved)) + guess.bend(direction)
            if not curve > 0:
                break
            length = now / curve
            moved *= length
            drift += 0.0 if exact else _ROUNDING * float(np.abs(moved).max())
            gradient = gradient + moved
            q = q + length * direction
            guess.turn(length * direction)
        slip = gradient - _shift(multipliers, sums)
        size = np.hypot(*q)
        out = stick & (size > held)
        along = (q * slip).sum(axis=0) / np.maximum(size, 1e-300)
        back = touch & ~stick & (along > max(limit, error))  # less than what is left is noise
        across = np.where(touch & ~stick, q[0] * slip[1] - q[1] * slip[0], 0.0) / np.maximum(size, 1e-300)
        straight = np.abs(across).max() <= limit  # a turn is solved for as if it were small
        if settled and straight and not back.any() and own * _most(size - held, touch) <= limit:
            return Dragged(_onto(q, held, touch & ~(stick & ~out)), multipliers, stick & ~out, products, True)
        stick = (stick & ~out) | back
        change = _onto(q, held, touch & ~stick) - q
    over = np.hypot(*q) > held
    return Dragged(_onto(q, held, over | (touch & ~stick)), multipliers, stick & ~over, products, False)


class _Guess:
    """The preconditioner for a guess of who sticks, on what may change, with the sums kept."""

    def __init__(
        self,
        op: AreaInfluence,
        q: FloatArray,
        slip: FloatArray,
        held: FloatArray,
        stick: BoolArray,
        touch: BoolArray,
        sums: Sequence[FloatArray],
    ) -> None:
        self.op, self.sums, self.held = op, sums, held
        self.stick, self.slides = stick.astype(np.float32), touch & ~stick
        size = np.maximum(np.hypot(*q), 1e-300)
        self.normal = np.where(self.slides, q / size, 0.0)
        self.exact = np.stack([-self.normal[1], self.normal[0]])
        self.tangent = self.exact.astype(np.float32)
        unit = np.zeros(q.shape, dtype=np.float32)
        unit[0, 0, 0] = 1.0
        self.typical = float(op.nearly_lateral(unit)[0, 0, 0])
        self.turned = np.zeros(held.shape)
        self.stiffen(slip)

    def stiffen(self, slip: FloatArray) -> None:
        """Where it slips, a drag that turns by itself turns against the slip: slip over drag is its stiffness."""
        lag = np.maximum(-(slip * self.normal).sum(axis=0), 0.0)
        self.stiff = np.where(self.slides, lag / np.where(self.slides, self.held, 1.0), 0.0).astype(np.float32)
        self.soft = (1 / np.sqrt(1 + _SOFT * self.typical * self.stiff)).astype(np.float32)
        self.spread = [self._solved(self.kept(np.broadcast_to(one, (2, *self.held.shape)))) for one in self.sums]
        rows = [_totals(self.sums, one) for one in self.spread]
        self.gram = np.linalg.pinv(np.array(rows).T) if rows else np.zeros((0, 0))

    def kept(self, v: FloatArray) -> Single:
        """The part of a map that may change: all where it sticks, what is across the drag where it slips."""
        out = v.astype(np.float32)
        across = out[0] * self.tangent[0] + out[1] * self.tangent[1]
        out *= self.stick
        out += across * self.tangent
        return out

    def _solved(self, masked: Single) -> Single:
        return self.kept(self.op.nearly_lateral(masked * self.soft) * self.soft)

    def restored(self, missing: FloatArray) -> FloatArray:
        """The change that brings in what is missing of the sums."""
        total = np.zeros((2, *self.held.shape))
        for one, share in zip(self.spread, self.gram @ missing, strict=True):
            total += share * one
        return total

    def mean(self, gradient: FloatArray) -> FloatArray:
        """Multipliers to begin with."""
        weights = [self.kept(np.broadcast_to(one, gradient.shape)).astype(np.float64) for one in self.sums]
        rows = np.array([_totals(self.sums, one) for one in weights]).reshape(len(weights), len(weights))
        return np.asarray(np.linalg.lstsq(rows, _totals(weights, gradient), rcond=1e-12)[0]) if weights else np.zeros(0)

    def turn(self, moved: npt.NDArray[Any]) -> None:
        """Remember how far the drag has turned where it slips."""
        self.turned = self.turned + (moved * self.tangent).sum(axis=0)

    def bend(self, direction: Single) -> float:
        """What turning costs."""
        return float((self.stiff * (direction * self.tangent).sum(axis=0) ** 2).sum())

    def answer(self, gradient: FloatArray, multipliers: FloatArray) -> tuple[Single, Single, FloatArray]:
        """What is left of the slip where it may not be, its answer, and the multipliers that leave it."""
        # the slip is along the drag but for rounding, and what is across it is told in double precision
        slip = gradient - _shift(multipliers, self.sums)
        across = (slip * self.exact).sum(axis=0) + self.stiff * self.turned
        masked = (slip * self.stick + across * self.exact).astype(np.float32)
        z = self._solved(masked)
        more = self.gram @ _totals(self.sums, z)
        for share, one, spread in zip(more, self.sums, self.spread, strict=True):
            z -= np.float32(share) * spread
            masked -= self.kept(np.broadcast_to(share * one, masked.shape))
        return masked, z, multipliers + more


def finer_drag(shear: FloatArray, held: FloatArray, finer_held: FloatArray) -> tuple[FloatArray, BoolArray]:
    """A start on a grid twice as fine, and who may stick there, for the drag friction holds there.

    What friction still holds falls to 0 at the end of the stick zone as the pressure does at the rim (`finer`).
    """
    left = held - np.hypot(*shear)
    left, sticks = finer(np.where(left > _AT_BOUND * held, left, 0.0))
    parts = []
    for part in shear:
        wide = np.pad(part, ((0, 1), (0, 1)), mode="edge")
        out = np.empty(finer_held.shape)
        out[::2, ::2], out[1::2, ::2] = part, 0.5 * (wide[:-1, :-1] + wide[1:, :-1])
        out[::2, 1::2] = 0.5 * (wide[:-1, :-1] + wide[:-1, 1:])
        out[1::2, 1::2] = 0.25 * (wide[:-1, :-1] + wide[1:, :-1] + wide[:-1, 1:] + wide[1:, 1:])
        parts.append(out)
    q = np.stack(parts)
    size = np.hypot(*q)
    length = np.maximum(finer_held - np.where(sticks, left, 0.0), 0.0)
    return q * np.where(size > 0, length / np.where(size > 0, size, 1.0), 0.0), sticks & (finer_held > 0)


def _most(values: FloatArray, where: BoolArray) -> float:
    return float(values.max(initial=0.0, where=where))


def _onto(q: FloatArray, held: FloatArray, where: BoolArray) -> FloatArray:
    """Drags of the greatest size `where` they slip, in their own direction."""
    size = np.hypot(*q)
    return np.asarray(q * np.where(where, held / np.maximum(size, 1e-300), 1.0))


def _totals(sums: Sequence[FloatArray], q: npt.NDArray[Any]) -> FloatArray:
    return np.array([float((one * q).sum()) for one in sums])


def _shift(multipliers: FloatArray, sums: Sequence[FloatArray]) -> FloatArray | float:
    return sum((share * one for share, one in zip(multipliers, sums, strict=True)), start=0.0)
