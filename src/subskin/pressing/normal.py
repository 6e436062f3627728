"""The pressure beneath a rigid body: the least of p K p / 2 + f p with p >= 0 and some sums of p given.

Which nodes touch is guessed, and their pressures are found by conjugate gradients (descent.py). The preconditioner is
the inverse of a circulant on the nodes that touch.
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
from .quarter import Quarter

__all__ = ["Pressed", "between", "finer", "pressed"]


@dataclass(frozen=True)
class Pressed(Frozen):
    """Pressure, the body's rigid motion (3,), who touches, products by K, and whether every rule holds."""

    pressure: FloatArray
    motion: FloatArray
    touches: BoolArray
    products: int
    settled: bool


def pressed(
    op: Influence | Quarter,
    f: FloatArray,
    body: BoolArray,
    nodes: tuple[FloatArray, FloatArray],
    targets: FloatArray,
    start: FloatArray,
    touches: BoolArray,
    limit: float,
) -> Pressed:
    """Solve from `start` with a first guess of who touches; gap and overlap to `limit` [m].

    f, body, start and touches have the shape (n, k), `nodes` are y (n,) and z (k,) [m]. `targets` (3,) are the sums of
    p, p y and p z [Pa, Pa m], NaN where none is given; by how much the body then sinks and leans is its motion, which f
    leaves out. Nothing presses where no body is.
    """
    free = touches & body
    if not free.any():
        free = body & (f <= f[body].min() + limit)
    problem = _Pressing(op, f, body, nodes, targets, start, free, limit)
    products, settled = descended(problem, limit)
    return Pressed(np.maximum(problem.x, 0.0), problem.motion, problem.free, products, settled)


class _Pressing:
    """The problem with its guess of who touches (descent.py)."""

    def __init__(
        self,
        op: Influence | Quarter,
        f: FloatArray,
        body: BoolArray,
        nodes: tuple[FloatArray, FloatArray],
        targets: FloatArray,
        start: FloatArray,
        free: BoolArray,
        limit: float,
    ) -> None:
        self.op, self.f, self.body, self.limit = op, f, body, limit
        self.y, self.z = nodes
        self.found = np.isfinite(targets)
        self.targets = targets
        self.motion = np.zeros(3)
        self.residual, self.answered = np.empty(f.shape, np.float32), np.empty(f.shape, np.float32)
        self.x = np.where(free, np.maximum(start, 0.0), 0.0)
        self._guess(free)
        self.x += self._missing(self.x)
        self.breaks = op.own * max(0.0, -float(self.x.min()))

    def _guess(self, free: BoolArray) -> None:
        """Let these nodes touch."""
        self.free, self.weight, self.outside = free, free.astype(np.float32), self.body & ~free
        rows, columns = free.sum(axis=1), free.sum(axis=0)
        total, y, z = float(rows.sum()), float(rows @ self.y), float(columns @ self.z)
        both = float(self.y @ (free @ self.z))
        gram = np.array([[total, y, z], [y, rows @ self.y**2, both], [z, both, columns @ self.z**2]])
        self.inverse = np.zeros((3, 3))
        at = np.ix_(self.found, self.found)
        if self.found.any():
            self.inverse[at] = np.linalg.pinv(gram[at])

    def _sums(self, values: npt.NDArray[Any]) -> FloatArray:
        return np.array(kernel.sums(values, self.weight, self.y, self.z))

    def _missing(self, x: FloatArray) -> FloatArray:
        """An even change that brings in what is missing of the sums."""
        if not self.found.any():
            return np.zeros(x.shape)
        level, by_y, by_z = self.inverse @ np.where(self.found, self.targets - self._sums(x), 0.0)
        return np.asarray((level + by_y * self.y[:, None] + by_z * self.z) * self.weight)

    def product(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return self.op.normal_wide(values)

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
    out = between(square)
    return np.sqrt(np.maximum(out, 0.0)), out > 0


def between(values: FloatArray) -> FloatArray:
    """Bilinear values (..., 2 n, 2 k) at nodes of half the step, of which two stand about each node."""
    for axis in (-2, -1):
        values = np.moveaxis(values, axis, 0)
        out = np.empty((2 * len(values), *values.shape[1:]))
        shares = 0.25 * np.concatenate([values[:1], values, values[-1:]])
        np.add(shares[:-2], 3 * shares[1:-1], out=out[::2])
        np.add(shares[2:], 3 * shares[1:-1], out=out[1::2])
        values = np.moveaxis(out, 0, axis)
    return np.ascontiguousarray(values)
