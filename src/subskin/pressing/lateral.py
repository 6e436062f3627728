"""The drag beneath a rigid body: the least of q K q / 2 + w q with |q| <= friction times p and some sums of q given.

As beneath the pressure it is guessed which nodes stick (descent.py); the others have the greatest drag, of a direction
that is found. The slip, K q + w less the body's motion, vanishes where they stick and is against the drag where they
slip: Newton's method for those conditions, each step by conjugate gradients over both components where nodes stick and
over the turn of the drag where they slip (Alart and Curnier 1991 have the conditions).

A drag that turns by itself turns against the slip, so slip over drag is a stiffness S against turning, added to K. The
preconditioner is D C D + E. C is the inverse of K's circulant, c a node's own entry of it, D^2 = 1 / (1 + (s c S)^2),
E = (1 - D^2) / (S + 1/c): C where S is little, 1 / S where it is much and K adds little. E leaves 12 products of 28.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from . import _area_kernel as kernel
from .case import BoolArray
from .descent import descended
from .influence import Influence
from .normal import between, finer
from .quarter import Quarter

__all__ = ["Dragged", "dragged", "finer_drag"]

_AT_BOUND = 1e-9
"""A drag nearer to the greatest than this share of it is the greatest."""
_SOFT = 0.3
"""s: the smaller, the more nodes that slip are answered as if they stuck; from 0.15 to 0.6 it matters little."""

_NOISE = 0.3
"""Share of what is left beneath which a slip the wrong way is taken for noise."""

Single = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Dragged(Frozen):
    """Drag (2, n, k), the body's rigid motion (3,), who sticks, products by K, and whether every rule holds."""

    shear: FloatArray
    motion: FloatArray
    sticks: BoolArray
    products: int
    settled: bool


def dragged(
    op: Influence | Quarter,
    w: FloatArray,
    held: FloatArray,
    nodes: tuple[FloatArray, FloatArray],
    targets: FloatArray,
    start: FloatArray,
    sticks: BoolArray,
    limit: float,
) -> Dragged:
    """Solve from `start` with a first guess of who sticks; creep to `limit` [m].

    w and start have the shape (2, n, k), held (n, k), `nodes` are y (n,) and z (k,) [m]. `targets` (3,) are the sums of
    q_y, q_z and q_z y - q_y z [Pa, Pa m], NaN where none is given; by how much the body then slides along y and z and
    turns is its motion, which w leaves out.
    """
    problem = _Dragging(op, w, held, nodes, targets, start, sticks & (held > 0), limit)
    products, settled = descended(problem, limit)
    return Dragged(problem.ended(), problem.motion, problem.sticks, products, settled)


class _Dragging:
    """The problem with its guess of who sticks (descent.py)."""

    def __init__(
        self,
        op: Influence | Quarter,
        w: FloatArray,
        held: FloatArray,
        nodes: tuple[FloatArray, FloatArray],
        targets: FloatArray,
        start: FloatArray,
        sticks: BoolArray,
        limit: float,
    ) -> None:
        self.op, self.w, self.held, self.limit = op, w, np.ascontiguousarray(held), limit
        self.y, self.z = nodes
        self.own = op.own_lateral
        self.at = np.flatnonzero(np.isfinite(targets))
        self.targets = targets[self.at]
        self.motion = np.zeros(3)
        self.sticks, self.gradient = sticks, np.zeros(w.shape)
        self.tangent, self.stiff, self.turned = np.zeros(w.shape), np.zeros(held.shape), np.zeros(held.shape)
        self.residual, self.softened, self.answered = (np.empty(w.shape, np.float32) for _ in range(3))
        self.change = np.zeros(w.shape)
        self.x = np.where(held > 0, start, 0.0)
        self._sort(0.0)
        self.x += self.change
        self._weigh(self._motions())
        self.x += self._missing(self.x)
        self.breaks, self.begun = 0.0, False

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
        return self.op.lateral_wide(values)

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

    def ended(self) -> FloatArray:
        """The drag, brought to the greatest where it slips."""
        return self.x + self.change


def finer_drag(shear: FloatArray, held: FloatArray, finer_held: FloatArray) -> tuple[FloatArray, BoolArray]:
    """A start on a grid twice as fine, and who may stick there, for the drag friction holds there.

    What friction still holds falls to 0 at the end of the stick zone as the pressure does at the rim (`finer`). The
    direction is that of the coarse drag, also one node beyond it.
    """
    size = np.sqrt((shear**2).sum(axis=0))
    left = held - size
    left, sticks = finer(np.where(left > _AT_BOUND * held, left, 0.0))
    unit = shear / np.where(size > 0, size, np.inf)
    wide = np.pad(unit, ((0, 0), (1, 1), (1, 1)))
    rows = wide[:, :-2] + wide[:, 1:-1] + wide[:, 2:]
    unit = np.where(size > 0, unit, rows[..., :-2] + rows[..., 1:-1] + rows[..., 2:])
    unit /= np.maximum(np.sqrt((unit**2).sum(axis=0)), 1e-300)
    q = between(unit)
    size = np.sqrt((q**2).sum(axis=0))
    length = np.maximum(finer_held - np.where(sticks, left, 0.0), 0.0)
    return q * (length / np.where(size > 0, size, np.inf)), sticks & (finer_held > 0)
