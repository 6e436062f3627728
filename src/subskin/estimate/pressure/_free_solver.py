"""The pressure and the free drag on an area, each within the cone of friction, compiled: exact, for one frame.

An element has three heights x = (p, q_y / mu, q_z / mu), within the cone |(x_1, x_2)| <= x_0. With whitened columns A

    J = 1/2 |A x - b|^2 + 1/2 w (x_0^T K x_0 + x_1^T K x_1 + x_2^T K x_2) + cost x_0

is strictly convex. An element is out (x = 0), inside its cone, or on its rim, at a length along a ray that may turn. A
round solves for all of these at once by Newton's method, on the rim with the cone's own curvature; elements that left
the cone are put back on it; and those change their state whose slope is not that of a minimum. It is the semismooth
Newton method of the conditions of a minimum (Christensen, Klarbring, Pang and Stromberg 1998, for contact with
friction). Where J has not fallen for some rounds, block descent sets it right, an element at a time, which always
falls (Jourdan, Alart and Jean 1998), and the rounds go on from there.

The work: x (3, N), slope (3, N); state (N,), ray (2, N) and push (N,), the slope across the rim; residual (n,); in
which row an element is (N + 1,), -1 for none, behind them how many rows are taken; columns of elements, three rows each
(3 C, n), and their products (3 C, 3 C); factor (3 C, 3 C); numbers of what is not out (N,), and where the unknowns of
each begin (N + 1,); scratch (3 N,), (3, N), (3, N) and (N,); in single precision the line of each component (3, L), the
residual times the gains, and all columns times this (ny rows).
"""

from __future__ import annotations

import math

from ..._compiled import compiled
from . import _on_area as on_area
from ._solver import backward, factored, forward

OUT, INSIDE, RIM = 0, 1, 2

TOLERANCE = 1e-10  # of a slope, of the largest that there is at x = 0
_ROUNDS = 80
_PATIENCE = 4
_SWEEPS = 30
_TURN = 0.5
"""Largest turn of a ray in a round [rad]."""
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
def breach(work, j):
    """How far the slope at an element is from that of a minimum."""
    slope, state, ray = work[1], work[2], work[3]
    s, u, v = slope[0, j], slope[1, j], slope[2, j]
    if state[j] == OUT:
        return max(math.hypot(u, v) - s, 0.0)
    if state[j] == RIM:
        along, across = u * ray[0, j] + v * ray[1, j], v * ray[0, j] - u * ray[1, j]
        return max(abs(s + along) * _HALF, abs(across), (along - s) * _HALF)
    return max(abs(s), math.hypot(u, v))


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
def _step(work, count):
    """Go by the step in the scratch; how many elements changed their state."""
    x, state, ray, index, at, z = work[0], work[2], work[3], work[10], work[11], work[12]
    changed = 0
    for k in range(count):
        j, first = index[k], at[k]
        if state[j] == INSIDE:
            changed += not settle_in(work, j, x[0, j] + z[first], x[1, j] + z[first + 1], x[2, j] + z[first + 2])
            continue
        height = x[0, j] + _HALF * z[first]
        if height <= 0.0:
            x[0, j] = x[1, j] = x[2, j] = 0.0
            state[j] = OUT
            changed += 1
            continue
        turn = min(max(math.atan2(z[first + 1], height), -_TURN), _TURN)
        cos, sin, u, v = math.cos(turn), math.sin(turn), ray[0, j], ray[1, j]
        ray[0, j], ray[1, j] = u * cos - v * sin, v * cos + u * sin
        x[0, j], x[1, j], x[2, j] = height, height * ray[0, j], height * ray[1, j]
    return changed


@compiled(borrows=True)
def _pushed(work):
    """The slope across the rim, where an element is on it."""
    slope, state, ray, push = work[1], work[2], work[3], work[4]
    for j in range(state.size):
        if state[j] == RIM:
            push[j] = _HALF * (slope[0, j] - ray[0, j] * slope[1, j] - ray[1, j] * slope[2, j])


@compiled(borrows=True)
def _exchange(level, work, tolerance):
    """Let go inwards what the rim does not hold, and take in what is out and would fall; how many are wrong.

    Of what is out the steepest in its neighbourhood is taken.
    """
    slope, state, ray, push, gains = work[1], work[2], work[3], work[4], work[18]
    ny, nz = level[5][0], level[5][1]
    wrong = 0
    for j in range(state.size):
        gains[j] = math.hypot(slope[1, j], slope[2, j]) - slope[0, j] if state[j] == OUT else -math.inf
        if state[j] == RIM and push[j] < -tolerance:
            state[j] = INSIDE
            wrong += 1
    for j in range(state.size):
        if not gains[j] > tolerance:
            continue
        wrong += 1
        y, z, steepest = j // nz, j % nz, True
        for dy in range(-1, 2):
            for dz in range(-1, 2):
                if 0 <= y + dy < ny and 0 <= z + dz < nz and gains[j + dy * nz + dz] > gains[j]:
                    steepest = False
        if steepest:
            size = math.hypot(slope[1, j], slope[2, j])
            state[j] = INSIDE if size < -slope[0, j] else RIM
            ray[0, j], ray[1, j] = (-slope[1, j] / size, -slope[2, j] / size) if size > 0.0 else (1.0, 0.0)
    return wrong


@compiled(borrows=True)
def _listed(work):
    """List what is not out; how many."""
    state, index = work[2], work[10]
    count = 0
    for j in range(state.size):
        if state[j] != OUT:
            index[count] = j
            count += 1
    return count


@compiled(borrows=True)
def descend(level, w, work, count, sweeps):
    """Block descent among the elements in `index`, whose slopes are known: each in turn to the least within its cone.

    Of a bound of J at the element, so that J falls with each.
    """
    x, slope, rows, products, index = work[0], work[1], work[6], work[8], work[10]
    for _ in range(sweeps):
        for i in range(count):
            j = index[i]
            here = 3 * rows[j]
            bound = _stiff(level, w, j, j)
            for part in range(3):
                bound += products[here + part, here + part]
            p, u, v = x[0, j], x[1, j], x[2, j]
            settle_in(work, j, p - slope[0, j] / bound, u - slope[1, j] / bound, v - slope[2, j] / bound)
            p, u, v = x[0, j] - p, x[1, j] - u, x[2, j] - v
            if p == 0.0 and u == 0.0 and v == 0.0:
                continue
            for k in range(count):
                other, smooth = index[k], _stiff(level, w, j, index[k])
                there = 3 * rows[other]
                for part in range(3):
                    row = products[there + part]
                    slope[part, other] += row[here] * p + row[here + 1] * u + row[here + 2] * v
                slope[0, other] += smooth * p
                slope[1, other] += smooth * u
                slope[2, other] += smooth * v


@compiled()
def minimise(level, w, b, work):
    """The least J from the x of the work: how many elements are not out, -1 where not found, -2 where there is no room.

    And how many unknowns these have, the largest breach of the conditions of a minimum, and the largest slope at x = 0.
    Leaves the factor of the Hessian.
    """
    x, state, lower, index, z, best = work[0], work[2], work[9], work[10], work[12], work[14]
    for j in range(state.size):
        settle_in(work, j, x[0, j], x[1, j], x[2, j])
    downhill, reach = work[13], 0.0
    for part in range(3):
        for j in range(state.size):
            downhill[part, j] = -level[6][j] if part == 0 else 0.0
        on_area.roughly(level, work[15][part], work[16], work[17], b, downhill[part])
        for j in range(state.size):
            reach = max(reach, abs(downhill[part, j]))
    tolerance = TOLERANCE * reach
    count = _listed(work)
    if not gather(level, work, count):
        return -2, 0, 0.0, reach
    least, waited, sweeps = slopes(level, w, b, work, tolerance), 0, _SWEEPS
    best[:] = x
    _pushed(work)
    for _ in range(_ROUNDS):
        many = hessian(level, w, work, count)
        if not factored(lower, many):
            return -1, 0, 0.0, reach
        for k in range(count):
            j = index[k]
            for part in range(work[11][k + 1] - work[11][k]):
                s = 0.0
                for i in range(3):
                    s -= along(work, j, part, i) * work[1][i, j]
                z[work[11][k] + part] = s
        forward(lower, many, z)
        backward(lower, many, z)
        changed = _step(work, count)
        value = slopes(level, w, b, work, tolerance)
        _pushed(work)
        worst = 0.0
        for j in range(state.size):
            worst = max(worst, breach(work, j))
        if worst <= tolerance and changed == 0:
            return count, many, worst, reach
        if value < least:
            least, waited = value, 0
            best[:] = x
        else:
            waited += 1
        if waited > _PATIENCE:
            for j in range(state.size):
                settle_in(work, j, best[0, j], best[1, j], best[2, j])
            slopes(level, w, b, work, tolerance)
        _pushed(work)
        _exchange(level, work, tolerance)
        count = _listed(work)
        if not gather(level, work, count):
            return -2, 0, 0.0, reach
        if waited > _PATIENCE:
            descend(level, w, work, count, sweeps)
            sweeps, waited = 2 * sweeps, 0
            least = slopes(level, w, b, work, tolerance)
            best[:] = x
            _pushed(work)
            count = _listed(work)
    return -1, 0, 0.0, reach
