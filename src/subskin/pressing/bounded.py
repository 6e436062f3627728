"""The least of x K x / 2 + f x with every x between its bounds and some of its sums given.

Both halves of a contact are of this kind: the pressure, which is not negative and carries the force, and the shear,
which friction bounds and which carries the drag. Which unknowns are at a bound is guessed, the others are found by
conjugate gradients, those that break a rule change sides, and so on: Newton's method for the complementarity
conditions (primal-dual active set; Hintermueller, Ito and Kunisch 2003). The gradients' preconditioner is the
circulant inverse of K on the free nodes alone, with the sums kept (Gould, Hribar and Nocedal 2001): two or three steps
a guess, whatever the number of nodes. A guess that is too wide halves its excess each time; so the guess on a grid
comes from one four times as coarse, with the nodes between free and fixed ones free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from .influence import Influence

__all__ = ["BoolArray", "Problem", "Solution", "finer"]

BoolArray = npt.NDArray[np.bool_]

_STEPS = 60
"""Conjugate gradients before a guess is given up; seven or so are enough."""
_CHANGES = 300
_LOOSE = 0.03
"""A guess is solved to this share of what breaks its bounds: it is about to change."""


@dataclass(frozen=True)
class Solution(Frozen):
    """Unknowns, the multipliers of the sums, who is between the bounds, and the steps that it took."""

    x: FloatArray
    multipliers: FloatArray
    free: BoolArray
    steps: int


@dataclass(frozen=True)
class Problem(Frozen):
    """min x K x / 2 + f x, low <= x <= high, sums @ x = targets; K is `influence`[part, part].

    f, low, high have the shape (n,), sums (c, n), targets (c,), c being 0, 1 or 2. Nodes with low = high stay there.
    """

    influence: Influence
    part: int
    f: FloatArray
    low: FloatArray
    high: FloatArray
    sums: FloatArray
    targets: FloatArray

    def minimise(self, start: FloatArray, free: BoolArray, limit: float) -> Solution:
        """Solve from `start`, with a first guess of who is free; the gradient of those to `limit`."""
        from ._compiled import minimise

        op = self.influence
        spectrum, table = op.forward(self.part)
        inverse, inverse_table = op.backward(self.part)
        own = float(op.rows[self.part, self.part, 0] - op.rows[self.part, self.part, 1])
        x, gradient, still = np.array(start), np.empty(start.size), free & (self.high > self.low)
        sums, targets = np.ascontiguousarray(self.sums), np.ascontiguousarray(self.targets)
        multipliers, steps = minimise(
            spectrum, table, inverse, inverse_table, own, self.f, self.low, self.high, sums, targets,
            x, still, gradient, limit, _LOOSE, _STEPS, _CHANGES,
        )  # fmt: skip
        return Solution(x, multipliers, still, int(steps))


def finer(values: FloatArray, count: int, by: int, periodic: bool) -> FloatArray:
    """The straight lines through every `by`-th node, at all `count` nodes; 0 beyond the last."""
    if not values.any():
        return np.zeros(count)
    out = np.empty((values.size, by))
    step = np.empty(values.size)
    step[:-1] = values[1:] - values[:-1]
    step[-1] = (values[0] if periodic else 0.0) - values[-1]
    np.multiply(step[:, None], np.arange(by) / by, out=out)
    out += values[:, None]
    return out.reshape(-1)[:count]
