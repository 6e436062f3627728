"""The finger and all touches at once: Levenberg-Marquardt, each touch's own unknowns eliminated."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._check import FloatArray
from ._blind_model import BlindModel, Linearised, Whitened

__all__ = ["Settled", "settle"]

_STEPS = 60
_SETTLED = 1e-7
"""Fall of chi-square that a further step promises; its root is that step in standard deviations."""
_STUCK = 1e10
_LONGEST = 0.25
"""Furthest that one step moves a touch, in depths."""


class Settled(NamedTuple):
    """The finger x, the positions of the touches (m, d) [m], and the model there."""

    x: FloatArray
    positions: FloatArray
    near: Linearised


def settle(
    model: BlindModel, touches: Whitened, x: FloatArray, positions: FloatArray, ends: FloatArray, factor: float
) -> Settled:
    """Minimise sum |rest|^2 / factor^2 + |x|^2 over the finger x and the touches' positions (m, d).

    `ends` (d, 2) bound the positions. Forces are eliminated exactly at every trial (variable projection; Golub and
    Pereyra 1973, with the derivative of Kaufman 1975), and the positions from each step's linear system: a Schur
    complement whose blocks, one a touch, are d by d. What is left is as large as x.
    """
    weight = 1 / factor**2
    longest = _LONGEST * float(np.asarray(model.drawn.array.depth).min())
    near = model.linearise(touches, x, positions)
    cost = weight * float((near.rest**2).sum()) + float(x @ x)
    damping = 1e-3
    for _ in range(_STEPS):
        step = _Step(near, x, weight)
        following = np.inf
        while damping < _STUCK:
            by_finger, by_position, promised = step.solve(damping)
            if promised < _SETTLED:
                return Settled(x, positions, near)
            trial = np.clip(x + by_finger, model.low, model.high)
            moved = np.clip(positions + np.clip(by_position, -longest, longest), *ends.T)
            rest = model.fit_forces(touches, trial, moved)[3]
            following = weight * float((rest**2).sum()) + float(trial @ trial)
            if following < cost:
                break
            damping *= 4
        else:  # rounding hides what is left to be gained
            break
        damping = max(0.2 * damping, 1e-9)
        x, positions, cost = trial, moved, following
        near = model.linearise(touches, x, positions)
    return Settled(x, positions, near)


class _Step:
    """The linear system of a step, for any damping."""

    def __init__(self, near: Linearised, x: FloatArray, weight: float) -> None:
        position, finger = near.free()
        self.x, self.weight = x, weight
        across = np.swapaxes(position, 1, 2)
        self.own, self.mixed = across @ position, across @ finger
        self.full = np.einsum("mnp,mnq->pq", finger, finger)
        self.pull_position = across @ near.rest[..., None]
        self.pull_finger = np.einsum("mnp,mn->p", finger, near.rest)

    def solve(self, damping: float) -> tuple[FloatArray, FloatArray, float]:
        """Changes of x and of the positions, and the fall of chi-square that they promise."""
        own, each = self.own.copy(), np.arange(self.own.shape[1])
        own[:, each, each] *= 1 + damping
        own[:, each, each] += own[:, each, each] == 0
        inverse = np.linalg.inv(own)
        pulled, mixed = inverse @ self.pull_position, inverse @ self.mixed
        left = self.weight * (self.full - np.einsum("mdp,mdq->pq", self.mixed, mixed))
        left[np.diag_indices_from(left)] += 1.0 + damping * self.weight * np.diag(self.full)
        right = self.weight * (self.pull_finger - np.einsum("mdp,md->p", self.mixed, pulled[..., 0])) - self.x
        by_finger = np.linalg.solve(left, right)
        by_position = pulled[..., 0] - mixed @ by_finger
        promised = float(right @ by_finger) + self.weight * float((self.pull_position * pulled).sum())
        return by_finger, by_position, promised
