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
    """The finger x, the positions of the touches (m,) [m], and the model there."""

    x: FloatArray
    positions: FloatArray
    near: Linearised


def settle(
    model: BlindModel, touches: Whitened, x: FloatArray, positions: FloatArray, ends: tuple[float, float], factor: float
) -> Settled:
    """Minimise sum |rest|^2 / factor^2 + |x|^2 over the finger x and the touches' positions, these within `ends`.

    Forces are eliminated exactly at every trial (variable projection; Golub and Pereyra 1973, with the derivative of
    Kaufman 1975), and the positions, one to a touch, from each step's linear system: a Schur complement whose blocks
    are 1 by 1. What is left is as large as x.
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
            moved = np.clip(positions + np.clip(by_position, -longest, longest), *ends)
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
        self.own = (position**2).sum(axis=1)
        self.mixed = np.einsum("mn,mnp->mp", position, finger)
        self.full = np.einsum("mnp,mnq->pq", finger, finger)
        self.pull_position = (position * near.rest).sum(axis=1)
        self.pull_finger = np.einsum("mnp,mn->p", finger, near.rest)

    def solve(self, damping: float) -> tuple[FloatArray, FloatArray, float]:
        """Changes of x and of the positions, and the fall of chi-square that they promise."""
        own = self.own * (1 + damping)
        own[own == 0] = 1.0
        left = self.weight * (self.full - self.mixed.T @ (self.mixed / own[:, None]))
        left[np.diag_indices_from(left)] += 1.0 + damping * self.weight * np.diag(self.full)
        right = self.weight * (self.pull_finger - self.mixed.T @ (self.pull_position / own)) - self.x
        by_finger = np.linalg.solve(left, right)
        by_position = (self.pull_position - self.mixed @ by_finger) / own
        promised = float(right @ by_finger) + self.weight * float((self.pull_position**2 / own).sum())
        return by_finger, by_position, promised
