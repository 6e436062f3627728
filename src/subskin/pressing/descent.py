"""The loop shared by pressure and drag: who is at a bound is guessed, the others are found by conjugate gradients.

Those that break a rule then change sides, and so on, as in a plane (row.py). Here a product costs most of the time,
so none is spent on a change of the guess: what that takes off is brought in with the next step, whose length is that of
the step before. A guess is given up as soon as what is left is less than what breaks its rules: it is about to change.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from .._check import FloatArray

__all__ = ["Bounded", "descended"]

_STEPS = 60
"""Conjugate gradients before a guess is given up."""
_CHANGES = 100
_LOOSE = 1.0
"""A guess is solved to this share of what breaks its rules."""
_SINGLE = 3e5
"""Up to so many times the limit what is left is small enough for products in single precision."""
_ROUNDING = 1e-7
"""Share of a displacement that a product in single precision is off by."""
_TYPICAL = 0.85
"""Length of a first step, before there is another to go by."""

Single = npt.NDArray[np.float32]


class Bounded(Protocol):
    """Tractions `x`, the displacements they leave, and a guess of which of them are at a bound.

    `answered` is what nearly makes what `answer` found left, `breaks` how far x breaks its bounds, as a displacement.
    """

    x: FloatArray
    answered: Single
    breaks: float

    def product(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Displacements by tractions, in their precision, maybe wider than the grid."""
        ...

    def placed(self, moved: npt.NDArray[Any]) -> None:
        """Take the displacements of x itself."""
        ...

    def answer(self) -> tuple[float, float, float]:
        """Greatest displacement left, its product with its answer, and what is broken where nothing is free [m]."""
        ...

    def curve(self, direction: Single, moved: npt.NDArray[Any]) -> float:
        """What a step costs in the square of its length."""
        ...

    def advance(self, direction: npt.NDArray[Any], moved: npt.NDArray[Any], length: float) -> float:
        """Step, and return the greatest displacement of it."""
        ...

    def changed(self, error: float, settled: bool) -> FloatArray | None:
        """Change the guess; what it changes x by, and None where every rule holds."""
        ...


def descended(problem: Bounded, limit: float) -> tuple[int, bool]:
    """Bring what is left to `limit` [m] with every rule kept; the number of products, and whether that was done."""
    problem.placed(problem.product(problem.x))
    products, length, drift = 1, _TYPICAL, 0.0
    direction = np.empty(problem.x.shape, np.float32)
    change = None
    for _ in range(_CHANGES):
        direction[...] = 0.0
        before, settled, error = 1.0, False, 0.0
        for step in range(_STEPS + 1):
            error, now, broken = problem.answer()
            exact = error > _SINGLE * limit
            if change is not None:
                change -= length * problem.answered
                moved = problem.product(change if exact else change.astype(np.float32))
                far = problem.advance(change, moved, 1.0)
                products, change, before = products + 1, None, 1.0
                drift += 0.0 if exact else _ROUNDING * far
                continue
            settled = error <= limit
            if settled and drift > limit:
                problem.placed(problem.product(problem.x))
                products, drift, before = products + 1, 0.0, 1.0
                direction[...] = 0.0
                continue
            if settled or error <= _LOOSE * max(problem.breaks, broken) or step == _STEPS or not now > 0:
                break
            direction *= now / before
            direction -= problem.answered
            before = now
            moved = problem.product(direction.astype(np.float64) if exact else direction)
            products += 1
            curve = problem.curve(direction, moved)
            if not curve > 0:  # rounding is all that is left
                break
            length = now / curve
            far = problem.advance(direction, moved, length)
            drift += 0.0 if exact else _ROUNDING * far
        change = problem.changed(error, settled)
        if change is None:
            return products, True
        if not change.any():
            change = None
    return products, False
