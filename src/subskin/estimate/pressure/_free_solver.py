"""The pressure and the free drag on an area, each within the cone of friction, compiled: exact, for one frame.

With whitened columns A, in the heights of `_cones`,

    J = 1/2 |A x - b|^2 + 1/2 w (x_0^T K x_0 + x_1^T K x_1 + x_2^T K x_2) + cost x_0

is strictly convex. A round solves for the heights of all elements that are not out by Newton's method, on the rim with
the cone's own curvature; elements that left their cone are put back on it; and those change their state whose slope is
not that of a minimum. It is the semismooth Newton method of contact with friction (Christensen, Klarbring, Pang and
Stromberg 1998). Where J has not fallen for some rounds, `_inside` finds the states.
"""

from __future__ import annotations

import math

from ..._compiled import compiled
from . import _elements as elements
from ._algebra import backward, factored, forward
from ._cones import HALF, INSIDE, OUT, RIM, hessian, onto, settle_in, taken_in
from ._inside import from_inside

TOLERANCE = 1e-10  # of a slope, of the largest that there is at x = 0
_ROUNDS = 80
_PATIENCE = 4
_TIMES = 8
_ROUGHLY, _ENOUGH = 1e-6, 1e-5
"""As TOLERANCE: while states are sought from the inside, and where the rounds after do not settle."""
_TURN = 0.5
"""Largest turn of a ray in a round [rad]."""


@compiled(borrows=True)
def breach(work, cones):
    """How far a slope is from that of a minimum."""
    slope, state, ray, worst = work.slope, cones.state, cones.ray, 0.0
    for j in range(state.size):
        s, u, v = slope[0, j], slope[1, j], slope[2, j]
        if state[j] == OUT:
            worst = max(worst, elements.falls(slope, j))
        elif state[j] == RIM:
            along, across = u * ray[0, j] + v * ray[1, j], v * ray[0, j] - u * ray[1, j]
            worst = max(worst, abs(s + along) * HALF, abs(across), (along - s) * HALF)
        else:
            worst = max(worst, abs(s), math.hypot(u, v))
    return worst


@compiled(borrows=True)
def _judge(level, w, b, work, cones):
    """The gradient at x, the slope across the rim where an element is on it, and J."""
    slope, ray = work.slope, cones.ray
    elements.residual(b, work)
    elements.slopes(level, w, work)
    for j in range(cones.state.size):
        if cones.state[j] == RIM:
            cones.push[j] = HALF * (slope[0, j] - ray[0, j] * slope[1, j] - ray[1, j] * slope[2, j])
    return elements.least(level, work)


@compiled(borrows=True)
def _step(work, cones, count):
    """Go by the step in the scratch; how many elements changed their state."""
    x, z, state, ray = work.x, work.z, cones.state, cones.ray
    changed = 0
    for k in range(count):
        j, first = work.listed[k], cones.at[k]
        if state[j] == INSIDE:
            changed += not settle_in(
                work, cones, j, x[0, j] + z[first], x[1, j] + z[first + 1], x[2, j] + z[first + 2]
            )  # fmt: skip
            continue
        height = x[0, j] + HALF * z[first]
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
def _exchange(level, work, cones, tolerance):
    """Let go inwards what the rim does not hold, and take in what is out and would fall; how many are wrong.

    Of what is out the steepest in its neighbourhood is taken.
    """
    slope, state, ray, push, gains = work.slope, cones.state, cones.ray, cones.push, cones.gains
    wrong = 0
    for j in range(state.size):
        gains[j] = -elements.falls(slope, j) if state[j] == OUT else math.inf
        if state[j] == RIM and push[j] < -tolerance:
            state[j] = INSIDE
            wrong += 1
    for j in range(state.size):
        if not gains[j] < -tolerance:
            continue
        wrong += 1
        if elements.steepest(level, gains, j):
            size = math.hypot(slope[1, j], slope[2, j])
            state[j] = INSIDE if size < -slope[0, j] else RIM
            ray[0, j], ray[1, j] = (-slope[1, j] / size, -slope[2, j] / size) if size > 0.0 else (1.0, 0.0)
    return wrong


@compiled()
def _from_inside(level, w, b, work, cones, reach):
    """Find the states from the inside of the cones, and once more while elements are missing; False without room."""
    for _ in range(_TIMES):
        if not from_inside(level, w, b, work, cones, reach):
            return False
        _judge(level, w, b, work, cones)
        if _exchange(level, work, cones, _ROUGHLY * reach) == 0:
            break
    return True


@compiled()
def _largest(level, b, work):
    """The largest slope at x = 0."""
    downhill, reach = work.spread, 0.0
    for part in range(3):
        for j in range(downhill.shape[1]):
            downhill[part, j] = -level.cost[j] if part == 0 else 0.0
        elements.roughly(level, work, part, b, downhill[part])
        for j in range(downhill.shape[1]):
            reach = max(reach, abs(downhill[part, j]))
    return reach


@compiled()
def minimise(level, w, b, work, cones):
    """The least J from the x of the work: how many elements are not out, -1 where not found or where there is no room.

    And how many unknowns these have, and how far a slope is from that of a minimum, of the largest at x = 0. Leaves the
    factor of the Hessian.
    """
    x, lower, z = work.x, work.lower, work.z
    for j in range(x.shape[1]):
        settle_in(work, cones, j, x[0, j], x[1, j], x[2, j])
    reach = _largest(level, b, work)
    tolerance = TOLERANCE * reach
    count = taken_in(level, work, cones)
    if count < 0:
        return -1, 0, 0.0
    least, waited, sought = _judge(level, w, b, work, cones), 0, False
    cones.best[:] = x
    for _ in range(_ROUNDS):
        many = hessian(level, w, work, cones, count)
        if not factored(lower, many):
            return -1, 0, 0.0
        for k in range(count):
            onto(cones, work.slope, k, work.listed[k], z)
        for k in range(many):
            z[k] = -z[k]
        forward(lower, many, z)
        backward(lower, many, z)
        changed = _step(work, cones, count)
        value = _judge(level, w, b, work, cones)
        worst = breach(work, cones)
        if worst <= tolerance and changed == 0:
            return count, many, worst / reach
        if value < least:
            least, waited = value, 0
            cones.best[:] = x
        else:
            waited += 1
        if waited > _PATIENCE:
            best = cones.best
            for j in range(x.shape[1]):
                settle_in(work, cones, j, best[0, j], best[1, j], best[2, j])
            if sought:
                break
            if not _from_inside(level, w, b, work, cones, reach):
                return -1, 0, 0.0
            least, waited, sought = _judge(level, w, b, work, cones), 0, True
            cones.best[:] = x
        _exchange(level, work, cones, tolerance)
        count = taken_in(level, work, cones)
        if count < 0:
            return -1, 0, 0.0
    if not sought:
        return -1, 0, 0.0
    # as near as the inside comes
    _judge(level, w, b, work, cones)
    worst = breach(work, cones)
    count = taken_in(level, work, cones)
    many = hessian(level, w, work, cones, count)
    if worst > _ENOUGH * reach or not factored(lower, many):
        return -1, 0, 0.0
    return count, many, worst / reach
