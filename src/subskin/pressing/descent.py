"""The loop shared by pressure and drag: who is at a bound is guessed, the others are found by conjugate gradients.

Those that break a rule then change sides, and so on, as in a plane (row.py). Here a product costs most of the time,
so none is spent on a change of the guess: what that takes off is brought in with the next step, whose length is that of
the step before. A guess is given up as soon as what is left is less than what breaks its rules: it is about to change.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from .case import Answered, BoolArray
from .quarter import Parity

__all__ = ["Descent", "Problem", "descended"]

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
Part = tuple[slice, slice]
_MAPS = ("w", "bound", "start", "free")


@dataclass(frozen=True, eq=False)
class Problem(Frozen):
    """The least of x K x / 2 + w x with x within bounds and some sums of it given, from a start.

    Of a pressure x >= 0, where the body is, x and w have the shape (n, k), and the sums are those of p, p y and p z; of
    a drag |x| <= held, the shape (2, n, k), and the sums those of q_y, q_z and q_z y - q_y z. `bound` (n, k) is the
    body's or what is held, `nodes` are y (n,) and z (k,) [m], `targets` (3,) [Pa, Pa m] are NaN where none is given,
    `free` (n, k) is a first guess of who is not at a bound. What is left comes to `limit` [m].
    """

    op: Any
    w: FloatArray
    bound: npt.NDArray[Any]
    nodes: tuple[FloatArray, ...]
    targets: FloatArray
    start: FloatArray
    free: BoolArray
    limit: float

    def on(self, part: Part) -> Problem:
        """The same on a part of the grid."""
        maps: dict[str, Any] = {name: np.ascontiguousarray(getattr(self, name)[..., *part]) for name in _MAPS}
        nodes = self.nodes[0][part[0]], self.nodes[1][part[1]]
        return replace(self, op=self.op.cropped((nodes[0].size, nodes[1].size)), nodes=nodes, **maps)


class Descent(ABC):
    """Tractions `x` of a problem, the displacements they leave, and a guess of which of them are at a bound.

    By `motion` the body moves beyond what w knows of. `answered` is what nearly makes what `answer` found left,
    `breaks` how far x breaks its bounds, as a displacement. `parities` are those that a map may have beneath each of
    the sums.
    """

    parities: tuple[Parity, ...]
    x: FloatArray
    motion: FloatArray
    answered: Single
    breaks: float

    @abstractmethod
    def __init__(self, given: Problem) -> None: ...

    @abstractmethod
    def found(self) -> Answered:
        """The solution."""

    @abstractmethod
    def product(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Displacements by tractions, in their precision, maybe wider than the grid."""

    @abstractmethod
    def placed(self, moved: npt.NDArray[Any]) -> None:
        """Take the displacements of x itself."""

    @abstractmethod
    def answer(self) -> tuple[float, float, float]:
        """Greatest displacement left, its product with its answer, and what is broken where nothing is free [m]."""

    @abstractmethod
    def curve(self, direction: Single, moved: npt.NDArray[Any]) -> float:
        """What a step costs in the square of its length."""

    @abstractmethod
    def advance(self, direction: npt.NDArray[Any], moved: npt.NDArray[Any], length: float) -> float:
        """Step, and return the greatest displacement of it."""

    @abstractmethod
    def changed(self, error: float, settled: bool) -> FloatArray | None:
        """Change the guess; what it changes x by, and None where every rule holds."""


def descended(problem: Descent, limit: float) -> int:
    """Bring what is left to `limit` [m] with every rule kept, if that can be; the number of products."""
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
            return products
        if not change.any():
            change = None
    return products
