"""The pressure and the drag beneath a rigid body on an area, each the solution of a `Problem` (descent.py).

Which nodes touch is guessed, and their pressures are found by conjugate gradients. The preconditioner is the inverse of
a circulant on those nodes. Of the drag it is guessed which nodes stick; the others have the greatest drag, of a
direction that is found. The slip, K q + w less the body's motion, vanishes where they stick and is against the drag
where they slip: Newton's method for those conditions, each step by conjugate gradients over both components where nodes
stick and over the turn of the drag where they slip (Alart and Curnier 1991 have the conditions).

A drag that turns by itself turns against the slip, so slip over drag is a stiffness S against turning, added to K. The
preconditioner is D C D + E. C is the inverse of K's circulant, c a node's own entry of it, D^2 = 1 / (1 + (s c S)^2),
E = (1 - D^2) / (S + 1/c): C where S is little, 1 / S where it is much and K adds little. E leaves 12 products of 28.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from . import _area_kernel as kernel
from .case import Answered, BoolArray
from .descent import Descent, Problem, Single, descended
from .quarter import centred, corner, quarter, unfolded, with_parity

__all__ = ["solved"]

_AT_BOUND = 1e-9
"""A drag nearer to the greatest than this share of it is the greatest."""
_SOFT = 0.3
"""s: the smaller, the more nodes that slip are answered as if they stuck; from 0.15 to 0.6 it matters little."""

_NOISE = 0.3
"""Share of what is left beneath which a slip the wrong way is taken for noise."""

_SAME = 1e-3
"""Share of the limit by which both sides may differ and are still called the same."""


def solved(given: Problem) -> Answered:
    """The solution, on a quarter where that says all: what is asked for and what moves have one parity."""
    way: type[Descent] = _Pressing if given.w.ndim == 2 else _Dragging
    if centred(given.nodes) and with_parity(given.bound, (False, False), 0.0):
        for kept, odd in enumerate(way.parities):
            asked = np.nan_to_num(np.delete(given.targets, kept)).any()
            if asked or not with_parity(given.w, odd, _SAME * given.limit):
                continue
            maps: dict[str, Any] = {name: corner(getattr(given, name)) for name in ("w", "bound", "start", "free")}
            targets = np.full(3, np.nan)
            targets[kept] = 0.25 * given.targets[kept]
            maps["nodes"] = tuple(at[at.size // 2 :] for at in given.nodes)
            found = way(replace(given, op=quarter(given.op, odd), targets=targets, **maps)).found()
            return replace(found, x=unfolded(found.x, odd), free=unfolded(found.free))
    return way(given).found()


class _Pressing(Descent):
    """The pressure with a guess of who touches: 0 where no body is; the body's motion is that it sinks and leans."""

    parities = ((False, False),)

    def __init__(self, given: Problem) -> None:
        self.op, self.f, self.body, self.limit = given.op, given.w, given.bound, given.limit
        self.y, self.z = given.nodes
        self.found_sums = np.isfinite(given.targets)
        self.targets = given.targets
        self.motion = np.zeros(3)
        self.residual, self.answered = np.empty(self.f.shape, np.float32), np.empty(self.f.shape, np.float32)
        free = given.free & self.body
        if not free.any():
            free = self.body & (self.f <= self.f[self.body].min() + self.limit)
        self.x = np.where(free, np.maximum(given.start, 0.0), 0.0)
        self._guess(free)
        self.x += self._missing(self.x)
        self.breaks = self.op.own * max(0.0, -float(self.x.min()))

    def found(self) -> Answered:
        products = descended(self, self.limit)
        return Answered(np.maximum(self.x, 0.0), self.motion, self.free, products)

    def _guess(self, free: BoolArray) -> None:
        """Let these nodes touch."""
        self.free, self.weight, self.outside = free, free.astype(np.float32), self.body & ~free
        rows, columns = free.sum(axis=1), free.sum(axis=0)
        total, y, z = float(rows.sum()), float(rows @ self.y), float(columns @ self.z)
        both = float(self.y @ (free @ self.z))
        gram = np.array([[total, y, z], [y, rows @ self.y**2, both], [z, both, columns @ self.z**2]])
        self.inverse = np.zeros((3, 3))
        at = np.ix_(self.found_sums, self.found_sums)
        if self.found_sums.any():
            self.inverse[at] = np.linalg.pinv(gram[at])

    def _sums(self, values: npt.NDArray[Any]) -> FloatArray:
        return np.array(kernel.sums(values, self.weight, self.y, self.z))

    def _missing(self, x: FloatArray) -> FloatArray:
        """An even change that brings in what is missing of the sums."""
        if not self.found_sums.any():
            return np.zeros(x.shape)
        level, by_y, by_z = self.inverse @ np.where(self.found_sums, self.targets - self._sums(x), 0.0)
        return np.asarray((level + by_y * self.y[:, None] + by_z * self.z) * self.weight)

    def product(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.asarray(self.op.normal_wide(values))

    def placed(self, moved: npt.NDArray[Any]) -> None:
        self.gradient = self.f + moved[:, : self.f.shape[1]]

    def answer(self) -> tuple[float, float, float]:
        self._leave()
        more = self.inverse @ self._sums(self.residual)
        if more.any():
            self.motion += more
            self._leave()
        error = max(float(self.residual.max()), -float(self.residual.min()))
        beyond = kernel.open_beyond(self.gradient, self.outside, self.y, self.z, *self.motion)
        nearly = self.op.nearly_wide(self.residual)
        over = self.inverse @ self._sums(nearly)
        now = kernel.projected(nearly, self.residual, self.weight, self.y, self.z, *over, self.answered)
        return error, now, beyond if beyond > self.limit else 0.0

    def _leave(self) -> None:
        kernel.left(self.gradient, self.weight, self.y, self.z, *self.motion, self.residual)

    def curve(self, direction: npt.NDArray[np.float32], moved: npt.NDArray[Any]) -> float:
        return float(kernel.inner(direction, moved))

    def advance(self, direction: npt.NDArray[Any], moved: npt.NDArray[Any], length: float) -> float:
        far, least = kernel.advance(self.x, self.gradient, direction, moved, length)
        self.breaks = -self.op.own * least
        return float(far)

    def changed(self, error: float, settled: bool) -> FloatArray | None:
        level, by_y, by_z = self.motion
        gap = self.gradient - (level + by_y * self.y[:, None] + by_z * self.z)
        back = self.outside & (gap < -self.limit)
        if settled and not back.any() and self.breaks <= self.limit:
            return None
        out = self.free & (self.x < 0)
        free = (self.free & ~out) | back
        if not free.any():
            free = self.body & (gap <= gap[self.body].min() + self.limit)
        change = np.where(out, -self.x, 0.0)
        self._guess(free)
        return change + self._missing(self.x + change)


class _Dragging(Descent):
    """The drag with a guess of who sticks; the body's motion is that it slides along y and z and turns."""

    parities = (False, False), (True, True), (False, True)

    def __init__(self, given: Problem) -> None:
        self.op, self.w, self.limit = given.op, given.w, given.limit
        self.held = held = np.ascontiguousarray(given.bound)
        self.y, self.z = given.nodes
        self.own = self.op.own_lateral
        self.at = np.flatnonzero(np.isfinite(given.targets))
        self.targets = given.targets[self.at]
        self.motion = np.zeros(3)
        shape = self.w.shape
        self.sticks, self.gradient = given.free & (held > 0), np.zeros(shape)
        self.tangent, self.stiff, self.turned = np.zeros(shape), np.zeros(held.shape), np.zeros(held.shape)
        self.residual, self.softened, self.answered = (np.empty(shape, np.float32) for _ in range(3))
        self.change = np.zeros(shape)
        self.x = np.where(held > 0, given.start, 0.0)
        self._sort(0.0)
        self.x += self.change
        self._weigh(self._motions())
        self.x += self._missing(self.x)
        self.breaks, self.begun = 0.0, False

    def found(self) -> Answered:
        products = descended(self, self.limit)
        # where it slips the drag is brought to the greatest
        return Answered(self.x + self.change, self.motion, self.sticks, products)

    def _motions(self) -> Single:
        """The part that may change of the rigid motions whose sums are given, (c, 2, n, k)."""
        motions = np.zeros((3, *self.w.shape), np.float32)
        motions[0, 0] = motions[1, 1] = 1.0
        motions[2, 0], motions[2, 1] = -self.z, self.y[:, None]
        motions = motions[self.at]
        kernel.keep(motions, self.stick, self.tangent)
        return motions

    def _sums(self, q: npt.NDArray[Any]) -> FloatArray:
        rows, columns = q.sum(axis=2, dtype=np.float64), q[0].sum(axis=0, dtype=np.float64)
        return np.array([rows[0].sum(), rows[1].sum(), rows[1] @ self.y - columns @ self.z])[self.at]

    def _weigh(self, weights: Single) -> None:
        """By which weights what is missing of the sums is brought in."""
        self.weights = weights
        gram = np.array([self._sums(one) for one in weights]).reshape(len(weights), len(weights))
        self.inverse = np.linalg.pinv(gram.T) if len(weights) else gram

    def _missing(self, q: FloatArray) -> FloatArray:
        """A change that brings in what is missing of the sums."""
        shares = self.inverse @ (self.targets - self._sums(q))
        return np.asarray(np.tensordot(shares, self.weights, axes=1), dtype=np.float64)

    def _sort(self, least: float) -> tuple[int, float]:
        """Guess again who sticks, and set up the preconditioner."""
        found: tuple[int, float] = kernel.sorted_out(
            self.x, self.gradient, self.y, self.z, self.motion, self.held, self.sticks, least,
            self.tangent, self.stiff, self.change,
        )  # fmt: skip
        self.turned[:] = 0.0
        self.stick, self.slides = self.sticks.astype(np.float32), (self.held > 0) & ~self.sticks
        self._soften()
        return found

    def _soften(self) -> None:
        typical = self.op.typical
        share = 1 / (1 + (_SOFT * typical * self.stiff) ** 2)
        self.soft = np.sqrt(share).astype(np.float32)
        self.direct = ((1 - share) / (self.stiff + 1 / typical)).astype(np.float32)

    def product(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.asarray(self.op.lateral_wide(values))

    def placed(self, moved: npt.NDArray[Any]) -> None:
        self.gradient = self.w + moved[..., : self.held.shape[1]]
        if self.begun:
            return
        self.begun = True
        self.motion[self.at] += self.inverse.T @ self._left()
        slide_y, slide_z, twist = self.motion
        lag = (self.gradient[1] - slide_z - twist * self.y[:, None]) * self.tangent[0]
        lag -= (self.gradient[0] - slide_y + twist * self.z) * self.tangent[1]
        self.stiff = np.where(self.slides, np.maximum(lag, 0.0) / np.where(self.slides, self.held, 1.0), 0.0)
        self.turned[:] = 0.0
        self._soften()
        answers = []
        for one in self._motions():
            self.residual[...] = one
            kernel.less(self.residual, self.stick, self.tangent, self.y, self.z, np.zeros(3), self.soft, self.softened)
            self._solve()
            answers.append(self.answered.copy())
        self._weigh(np.array(answers, dtype=np.float32).reshape(len(answers), *self.w.shape))

    def _left(self) -> FloatArray:
        totals = np.zeros(len(self.weights))
        kernel.drag_left(
            self.gradient, self.stick, self.tangent, self.stiff, self.turned, self.y, self.z, self.motion, self.weights,
            self.residual, totals,
        )  # fmt: skip
        return totals

    def _solve(self) -> FloatArray:
        """The answer to what is left, and its sums."""
        nearly = self.op.nearly_lateral_wide(self.softened)
        return np.array(
            kernel.answered(
                nearly, self.residual, self.stick, self.tangent, self.soft, self.direct, self.y, self.z, self.answered
            )
        )[self.at]

    def answer(self) -> tuple[float, float, float]:
        more = np.zeros(3)
        more[self.at] = self.inverse.T @ self._left()
        self.motion += more
        kernel.less(self.residual, self.stick, self.tangent, self.y, self.z, more, self.soft, self.softened)
        error = max(float(self.residual.max()), -float(self.residual.min()))
        wrong = kernel.wrong_way(self.gradient, self.y, self.z, self.motion, self.slides, self.tangent)
        now = kernel.drag_projected(self.answered, self.residual, self.weights, self.inverse @ self._solve())
        return error, now, wrong if wrong > self.limit else 0.0

    def curve(self, direction: npt.NDArray[np.float32], moved: npt.NDArray[Any]) -> float:
        return float(kernel.curve(direction, moved, self.tangent, self.stiff))

    def advance(self, direction: npt.NDArray[Any], moved: npt.NDArray[Any], length: float) -> float:
        far, over = kernel.drag_advance(
            self.x, self.gradient, self.turned, direction, moved, length, self.tangent, self.held
        )
        self.breaks = self.own * over
        return float(far)

    def changed(self, error: float, settled: bool) -> FloatArray | None:
        kept = settled and self.breaks <= self.limit
        back, across = self._sort(max(self.limit, _NOISE * error))
        if kept and not back and across <= self.limit:
            return None
        kernel.keep(self.weights, self.stick, self.tangent)
        self._weigh(self.weights)
        return self.change + self._missing(self.x + self.change)
