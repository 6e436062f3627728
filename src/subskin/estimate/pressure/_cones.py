"""Heights of elements within their cones of friction, compiled: Hessian, and what is in and out.

An element has three heights x = (p, q_y / mu, q_z / mu), within the cone |(x_1, x_2)| <= x_0. It is out (x = 0), inside
its cone, or on its rim, at a height along a ray that may turn.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ._elements import Level, gather, multiplied

OUT, INSIDE, RIM = 0, 1, 2

HALF = math.sqrt(0.5)
_LOCKED = 1e30
_WITHIN = 1.0 - 1e-13


class Cones(NamedTuple):
    """What the loops fill, beside `Work`, of N elements.

    Parameters
    ----------
    state, ray, push : ndarray, shapes (N,), (2, N) and (N,)
        `OUT`, `INSIDE` or `RIM`; on the rim its direction, and the slope across it.
    at : ndarray, shape (N + 1,)
        Where the unknowns of each element in the factor begin.
    best : ndarray, shape (3, N)
        The x of the least J so far.
    held, step, turn : ndarray, shape (3, N)
        From the inside: a slope within the cone, and the steps of x and of it.
    gains : ndarray, shape (N,)
        Scratch.
    """

    state: npt.NDArray[np.int8]
    ray: FloatArray
    push: FloatArray
    at: npt.NDArray[np.int64]
    best: FloatArray
    held: FloatArray
    step: FloatArray
    turn: FloatArray
    gains: FloatArray

    @classmethod
    def of(cls, level: Level) -> Cones:
        """All out."""
        total = level.cost.size
        return cls(
            np.zeros(total, np.int8), np.zeros((2, total)), np.zeros(total), np.empty(total + 1, np.int64),
            np.empty((3, total)), np.empty((3, total)), np.empty((3, total)), np.empty((3, total)), np.empty(total),
        )  # fmt: skip


@compiled(borrows=True)
def _stiff(level, w, one, other):
    """The smoothness between two elements."""
    nz = level.nz
    dy, dz = abs(one // nz - other // nz), abs(one % nz - other % nz)
    return w * level.stencil[dy, dz] if dy <= 1 and dz <= 1 else 0.0


@compiled(borrows=True)
def along(cones, j, part, k):
    """Component `k` of the direction of the unknown `part` of an element: an axis; on the rim the ray, or across."""
    ray = cones.ray
    if cones.state[j] == INSIDE:
        return 1.0 if part == k else 0.0
    if part == 0:
        return HALF if k == 0 else HALF * ray[k - 1, j]
    return 0.0 if k == 0 else -ray[1, j] if k == 1 else ray[0, j]


@compiled(borrows=True)
def onto(cones, values, k, j, z):
    """Put to z what three values (3, N) of the element j, the k-th in the factor, are along its unknowns."""
    first = cones.at[k]
    for part in range(cones.at[k + 1] - first):
        s = 0.0
        for i in range(3):
            s += along(cones, j, part, i) * values[i, j]
        z[first + part] = s


@compiled(borrows=True)
def hessian(level, w, work, cones, count):
    """The Hessian of the unknowns of the listed elements into the factor, up to its diagonal: how many unknowns."""
    products, lower, index, order, at = work.products, work.lower, work.listed, work.order, cones.at
    multiplied(work)
    at[0] = 0
    for i in range(count):
        at[i + 1] = at[i] + (3 if cones.state[index[i]] == INSIDE else 2)
    for i in range(count):
        one, here = index[i], 3 * order[index[i]]
        for k in range(i + 1):
            other, there, smooth = index[k], 3 * order[index[k]], _stiff(level, w, index[i], index[k])
            for a in range(at[i + 1] - at[i]):
                u, v, t = along(cones, one, a, 0), along(cones, one, a, 1), along(cones, one, a, 2)
                p, q, r = products[here], products[here + 1], products[here + 2]
                first = u * (p[there] + smooth) + v * q[there] + t * r[there]
                second = u * p[there + 1] + v * (q[there + 1] + smooth) + t * r[there + 1]
                third = u * p[there + 2] + v * q[there + 2] + t * (r[there + 2] + smooth)
                for c in range(at[k + 1] - at[k]):
                    lower[at[i] + a, at[k] + c] = (
                        first * along(cones, other, c, 0)
                        + second * along(cones, other, c, 1)
                        + third * along(cones, other, c, 2)
                    )
        if cones.state[one] == RIM:
            size = work.x[0, one] / HALF
            lower[at[i] + 1, at[i] + 1] += max(cones.push[one], 0.0) / size if size > 0.0 else _LOCKED
    return at[count]


@compiled(borrows=True)
def settle_in(work, cones, j, p, u, v):
    """Put an element to (p, u, v), or to what is next to it in its cone; whether it was in it."""
    x, state, ray = work.x, cones.state, cones.ray
    size = math.hypot(u, v)
    if size < _WITHIN * p:
        x[0, j], x[1, j], x[2, j], state[j] = p, u, v, INSIDE
        return True
    if size <= -p or size == 0.0:
        x[0, j] = x[1, j] = x[2, j] = 0.0
        state[j] = OUT
        return False
    ray[0, j], ray[1, j], state[j] = u / size, v / size, RIM
    x[0, j] = 0.5 * (p + size)
    x[1, j], x[2, j] = x[0, j] * ray[0, j], x[0, j] * ray[1, j]
    return False


@compiled(borrows=True)
def taken_in(level, work, cones):
    """List what is not out, with its columns; how many, -1 where there is no room."""
    count = 0
    for j in range(cones.state.size):
        if cones.state[j] != OUT:
            work.listed[count] = j
            count += 1
    return count if gather(level, work, count) else -1
