"""The pressure and the free drag on an area, each within the cone of friction, compiled: exact, for one frame.

With whitened columns A, in the heights of `_free_parts`,

    J = 1/2 |A x - b|^2 + 1/2 w (x_0^T K x_0 + x_1^T K x_1 + x_2^T K x_2) + cost x_0

is strictly convex. A round solves for the heights of all elements that are not out by Newton's method, on the rim with
the cone's own curvature; elements that left their cone are put back on it; and those change their state whose slope is
not that of a minimum. It is the semismooth Newton method of contact with friction (Christensen, Klarbring, Pang and
Stromberg 1998). Where J has not fallen for some rounds, `_free_inside` finds the states.
"""

from __future__ import annotations

import math

from ..._compiled import compiled
from . import _on_area as on_area
from ._free_inside import from_inside
from ._free_parts import INSIDE, OUT, RIM, along, gather, hessian, listed, settle_in, slopes
from ._solver import backward, factored, forward

TOLERANCE = 1e-10  # of a slope, of the largest that there is at x = 0
_ROUNDS = 80
_PATIENCE = 4
_TIMES = 8
_ROUGHLY, _ENOUGH = 1e-6, 1e-5
"""As TOLERANCE: while states are sought from the inside, and where the rounds after do not settle."""
_TURN = 0.5
"""Largest turn of a ray in a round [rad]."""
_HALF = math.sqrt(0.5)


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


@compiled()
def _from_inside(level, w, b, work, reach):
    """Find the states from the inside of the cones, and once more while elements are missing; False without room."""
    for _ in range(_TIMES):
        if not from_inside(level, w, b, work, reach):
            return False
        slopes(level, w, b, work, _ROUGHLY * reach)
        _pushed(work)
        if _exchange(level, work, _ROUGHLY * reach) == 0:
            break
    return True


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
    count = listed(work)
    if not gather(level, work, count):
        return -2, 0, 0.0, reach
    least, waited, sought = slopes(level, w, b, work, tolerance), 0, False
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
            if sought:
                break
            if not _from_inside(level, w, b, work, reach):
                return -2, 0, 0.0, reach
            least, waited, sought = slopes(level, w, b, work, tolerance), 0, True
            best[:] = x
            _pushed(work)
        _exchange(level, work, tolerance)
        count = listed(work)
        if not gather(level, work, count):
            return -2, 0, 0.0, reach
    if not sought:
        return -1, 0, 0.0, reach
    # as near as the inside comes
    slopes(level, w, b, work, tolerance)
    _pushed(work)
    worst = 0.0
    for j in range(state.size):
        worst = max(worst, breach(work, j))
    count = listed(work)
    many = hessian(level, w, work, count)
    if worst > _ENOUGH * reach or not factored(lower, many):
        return -1, 0, 0.0, reach
    return count, many, worst, reach
