"""Loops over a grid for the pressure beneath a body (normal.py). Maps by transforms may be wider than the grid.

A body may sink and lean: rigid motions are level + lean_y y + lean_z z, and their multipliers come as three numbers.
"""

from __future__ import annotations

import numpy as np

from ..._compiled import compiled

__all__ = ["advance", "inner", "left", "open_beyond", "projected", "sums"]


@compiled(entry=True, borrows=True)
def sums(values, free, y, z):
    """Sums of a map over the nodes that touch: plain, times y, times z."""
    plain, by_y, by_z = 0.0, 0.0, 0.0
    for i in range(free.shape[0]):
        row, across = 0.0, 0.0
        for j in range(free.shape[1]):
            value = values[i, j] * free[i, j]
            row += value
            across += value * z[j]
        plain += row
        by_y += row * y[i]
        by_z += across
    return plain, by_y, by_z


@compiled(entry=True, borrows=True)
def left(gradient, free, y, z, level, lean_y, lean_z, residual):
    """The gap where nodes touch, 0 elsewhere."""
    for i in range(free.shape[0]):
        base = level + lean_y * y[i]
        for j in range(free.shape[1]):
            residual[i, j] = (gradient[i, j] - base - lean_z * z[j]) * free[i, j]


@compiled(entry=True, borrows=True)
def open_beyond(gradient, outside, y, z, level, lean_y, lean_z):
    """The deepest overlap of the bodies where nodes do not touch."""
    least = 0.0
    for i in range(outside.shape[0]):
        base = level + lean_y * y[i]
        for j in range(outside.shape[1]):
            if outside[i, j]:
                least = min(least, gradient[i, j] - base - lean_z * z[j])
    return -least


@compiled(entry=True, borrows=True)
def projected(answer, residual, free, y, z, level, lean_y, lean_z, out):
    """The answer where nodes touch less a rigid motion, and its product with the residual."""
    total = 0.0
    for i in range(free.shape[0]):
        base = level + lean_y * y[i]
        for j in range(free.shape[1]):
            value = np.float32((answer[i, j] - base - lean_z * z[j]) * free[i, j])
            out[i, j] = value
            total += value * residual[i, j]
    return total


@compiled(entry=True, borrows=True)
def inner(one, wide):
    """Sum of products of two maps, of which the second may be wider."""
    total = 0.0
    for i in range(one.shape[0]):
        for j in range(one.shape[1]):
            total += one[i, j] * wide[i, j]
    return total


@compiled(entry=True)
def advance(x, gradient, direction, moved, length):
    """One step along a direction: the greatest displacement by it, and the least pressure after it."""
    n, k = x.shape
    most, least = np.zeros(k), np.zeros(k)
    for i in range(n):
        for j in range(k):
            by = length * moved[i, j]
            gradient[i, j] += by
            x[i, j] += length * direction[i, j]
            most[j] = max(most[j], abs(by))
            least[j] = min(least[j], x[i, j])
    return most.max(), least.min()
