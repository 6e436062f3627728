"""Heights of elements within their cones of friction, compiled: columns, Hessian, gradient, and what is in and out.

An element has three heights x = (p, q_y / mu, q_z / mu), within the cone |(x_1, x_2)| <= x_0. It is out (x = 0), inside
its cone, or on its rim, at a height along a ray that may turn.

The work: x (3, N), slope (3, N); state (N,), ray (2, N) and push (N,), the slope across the rim; residual (n,); in
which row an element is (N + 1,), -1 for none, behind them how many rows are taken; columns of elements, three rows each
(3 C, n), and their products (3 C, 3 C); factor (3 C, 3 C); numbers of what is not out (N,), and where the unknowns of
each begin (N + 1,); scratch (3 N,), (3, N), (3, N); in single precision the line of each component (3, L), the residual
times the gains, and some columns times this; and scratch (N,), (3, N), (3, N).
"""

from __future__ import annotations

import math

from ..._compiled import compiled
from . import _on_area as on_area

OUT, INSIDE, RIM = 0, 1, 2

_LOCKED = 1e30
_HALF = math.sqrt(0.5)
_WITHIN = 1.0 - 1e-13


@compiled(borrows=True)
def forget(work):
    """Take no columns as known."""
    rows = work[6]
    for j in range(rows.size):
        rows[j] = -1
    rows[rows.size - 1] = 0


@compiled(borrows=True)
def gather(level, work, count):
    """Columns and products of the elements in `index`; False where there is no room for them."""
    parts, start, gain, length, nz = level[0], level[1], level[2], level[3], level[5][1]
    rows, own, products, index = work[6], work[7], work[8], work[10]
    before = rows[rows.size - 1]
    for k in range(count):
        j = index[k]
        if rows[j] >= 0:
            continue
        row = rows[rows.size - 1]
        if 3 * row == len(own):
            return False
        rows[j], rows[rows.size - 1] = row, row + 1
        first = j // nz * length + j % nz
        for part in range(3):
            column = own[3 * row + part]
            for i in range(own.shape[1]):
                column[i] = gain[i] * parts[part, start[i] + first]
    if rows[rows.size - 1] > before:
        on_area.multiply(own, products, 3 * before, 3 * rows[rows.size - 1])
    return True


@compiled(borrows=True)
def _stiff(level, w, one, other):
    """The smoothness between two elements."""
    stencil, nz = level[4], level[5][1]
    dy, dz = abs(one // nz - other // nz), abs(one % nz - other % nz)
    return w * stencil[dy, dz] if dy <= 1 and dz <= 1 else 0.0


@compiled(borrows=True)
def along(work, j, part, k):
    """Component `k` of the direction of the unknown `part` of an element: an axis; on the rim the ray, or across."""
    state, ray = work[2], work[3]
    if state[j] == INSIDE:
        return 1.0 if part == k else 0.0
    if part == 0:
        return _HALF if k == 0 else _HALF * ray[k - 1, j]
    return 0.0 if k == 0 else -ray[1, j] if k == 1 else ray[0, j]


@compiled(borrows=True)
def hessian(level, w, work, count):
    """The Hessian of the unknowns of the elements in `index` into the factor, up to its diagonal: how many unknowns."""
    x, state, push, rows, products, lower, index, at = (
        work[0], work[2], work[4], work[6], work[8], work[9], work[10], work[11],
    )  # fmt: skip
    at[0] = 0
    for i in range(count):
        at[i + 1] = at[i] + (3 if state[index[i]] == INSIDE else 2)
    for i in range(count):
        one, here = index[i], 3 * rows[index[i]]
        for k in range(i + 1):
            other, there, smooth = index[k], 3 * rows[index[k]], _stiff(level, w, index[i], index[k])
            for a in range(at[i + 1] - at[i]):
                u, v, t = along(work, one, a, 0), along(work, one, a, 1), along(work, one, a, 2)
                p, q, r = products[here], products[here + 1], products[here + 2]
                first = u * (p[there] + smooth) + v * q[there] + t * r[there]
                second = u * p[there + 1] + v * (q[there + 1] + smooth) + t * r[there + 1]
                third = u * p[there + 2] + v * q[there + 2] + t * (r[there + 2] + smooth)
                for c in range(at[k + 1] - at[k]):
                    lower[at[i] + a, at[k] + c] = (
                        first * along(work, other, c, 0)
                        + second * along(work, other, c, 1)
                        + third * along(work, other, c, 2)
                    )
        if state[one] == RIM:
            size = x[0, one] / _HALF
            lower[at[i] + 1, at[i] + 1] += max(push[one], 0.0) / size if size > 0.0 else _LOCKED
    return at[count]


@compiled(borrows=True)
def slopes(level, w, b, work, tolerance):
    """The residual, the gradient of J, and J; of what is out only as far as it is seen to stay out."""
    stencil, sizes, cost = level[4], level[5], level[6]
    x, slope, state, r, rows, own, spread = work[0], work[1], work[2], work[5], work[6], work[7], work[13]
    ny, nz = sizes[0], sizes[1]
    for i in range(r.size):
        r[i] = -b[i]
    for part in range(3):
        for j in range(cost.size):
            spread[part, j] = 0.0
    for j in range(cost.size):
        if state[j] == OUT:
            continue
        y, z = j // nz, j % nz
        for part in range(3):
            one, column = x[part, j], own[3 * rows[j] + part]
            for i in range(r.size):
                r[i] += one * column[i]
            for dy in range(-1, 2):
                for dz in range(-1, 2):
                    if 0 <= y + dy < ny and 0 <= z + dz < nz:
                        spread[part, j + dy * nz + dz] += w * stencil[abs(dy), abs(dz)] * one
    value = 0.0
    for i in range(r.size):
        value += 0.5 * r[i] * r[i]
    for j in range(cost.size):
        value += cost[j] * x[0, j]
        for part in range(3):
            value += 0.5 * x[part, j] * spread[part, j]
            slope[part, j] = spread[part, j]
        slope[0, j] += cost[j]
    doubt = 0.0
    for part in range(3):
        doubt = max(doubt, on_area.roughly(level, work[15][part], work[16], work[17], r, slope[part]))
    for j in range(cost.size):
        if state[j] == OUT:
            if math.hypot(slope[1, j], slope[2, j]) - slope[0, j] > tolerance - 3.0 * doubt:
                for part in range(3):
                    slope[part, j] = spread[part, j] + on_area.seen(level, level[0][part], r, j)
                slope[0, j] += cost[j]
            continue
        for part in range(3):
            column, s = own[3 * rows[j] + part], spread[part, j] + (cost[j] if part == 0 else 0.0)
            for i in range(r.size):
                s += column[i] * r[i]
            slope[part, j] = s
    return value


@compiled(borrows=True)
def settle_in(work, j, p, u, v):
    """Put an element to (p, u, v), or to what is next to it in its cone; whether it was in it."""
    x, state, ray = work[0], work[2], work[3]
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
def listed(work):
    """List what is not out; how many."""
    state, index = work[2], work[10]
    count = 0
    for j in range(state.size):
        if state[j] != OUT:
            index[count] = j
            count += 1
    return count
