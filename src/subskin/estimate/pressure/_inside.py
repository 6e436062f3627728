"""The least J of `_free_solver` from the inside of the cones, compiled: slower, and in as many rounds whatever it is.

A primal-dual interior-point method with the scaling of Nesterov and Todd (1997), as for any second-order cone: x and a
slope s within their cones, x . s = mu, and mu to 0. With x^-1 = (x_0, -x_1, -x_2) / det x, det x = x_0^2 - x_1^2 -
x_2^2, and W the scaling of both, a step is

    (H + W^-2) dx = -gradient + sigma mu x^-1,        ds = sigma mu x^-1 - s - W^-2 dx
"""

from __future__ import annotations

import math

from ..._compiled import compiled
from ._algebra import backward, factored, forward
from ._cones import INSIDE, OUT, RIM, hessian, settle_in, taken_in
from ._elements import residual, slopes

_ROUNDS = 60
_NEAR = 1e-12  # of the mean of x . s, of the largest there may be
_SHORT = 0.99  # of the way to the nearest cone
_OFF = 0.1  # of the largest height, that all are moved inwards at first
_STEEP = 1e-2


@compiled(borrows=True)
def _room_left(x, step, j):
    """How far an element may go along a step before it leaves its cone."""
    p, u, v, dp, du, dv = x[0, j], x[1, j], x[2, j], step[0, j], step[1, j], step[2, j]
    a, b, c = dp * dp - du * du - dv * dv, p * dp - u * du - v * dv, p * p - u * u - v * v
    root = b * b - a * c
    if root < 0.0 or (a >= 0.0 and b >= 0.0):
        return math.inf
    return c / (math.sqrt(root) - b)


@compiled(borrows=True)
def _scaled(x, held, j, k):
    """Component k of J w and the size of the scaling, W^-2 = (2 (J w)(J w)^T - J) / size."""
    one = math.sqrt(x[0, j] ** 2 - x[1, j] ** 2 - x[2, j] ** 2)
    two = math.sqrt(held[0, j] ** 2 - held[1, j] ** 2 - held[2, j] ** 2)
    both = (x[0, j] * held[0, j] + x[1, j] * held[1, j] + x[2, j] * held[2, j]) / (one * two)
    share = 0.5 / math.sqrt(0.5 * (1.0 + both))
    sign = 1.0 if k == 0 else -1.0
    return share * (sign * x[k, j] / one + held[k, j] / two), one / two


@compiled(borrows=True)
def _aim(work, cones, count, many, pull):
    """The steps of x and of its slope, towards x . s = pull."""
    x, z, held, step, turn = work.x, work.z, cones.held, cones.step, cones.turn
    for i in range(count):
        j = work.listed[i]
        size = x[0, j] ** 2 - x[1, j] ** 2 - x[2, j] ** 2
        for k in range(3):
            z[3 * i + k] = pull * (x[k, j] if k == 0 else -x[k, j]) / size - work.slope[k, j]
    forward(work.lower, many, z)
    backward(work.lower, many, z)
    for i in range(count):
        j = work.listed[i]
        size = x[0, j] ** 2 - x[1, j] ** 2 - x[2, j] ** 2
        p, ratio = _scaled(x, held, j, 0)
        u, v = _scaled(x, held, j, 1)[0], _scaled(x, held, j, 2)[0]
        along = p * z[3 * i] + u * z[3 * i + 1] + v * z[3 * i + 2]
        for k in range(3):
            sign, way = (1.0, p) if k == 0 else (-1.0, u if k == 1 else v)
            step[k, j] = z[3 * i + k]
            scaled = (2.0 * way * along - sign * z[3 * i + k]) / ratio
            turn[k, j] = pull * sign * x[k, j] / size - held[k, j] - scaled


@compiled(borrows=True)
def _longest(work, cones, count):
    """How far all may go along both steps."""
    share = math.inf
    for i in range(count):
        j = work.listed[i]
        share = min(share, _room_left(work.x, cones.step, j), _room_left(cones.held, cones.turn, j))
    return share


@compiled(borrows=True)
def _widened(level, work, cones):
    """Take in what lies beside what is not out, all of it inside its cone."""
    x, state, ny, nz = work.x, cones.state, level.ny, level.nz
    largest = 0.0
    for j in range(state.size):
        largest = max(largest, x[0, j])
    for j in range(state.size):
        near, y, z = False, j // nz, j % nz
        for dy in range(-1, 2):
            for dz in range(-1, 2):
                if 0 <= y + dy < ny and 0 <= z + dz < nz:
                    near |= state[j + dy * nz + dz] == INSIDE or state[j + dy * nz + dz] == RIM
        cones.gains[j] = 1.0 if near else 0.0
    for j in range(state.size):
        state[j] = INSIDE if cones.gains[j] > 0.0 else OUT
        if state[j] == INSIDE:
            x[0, j] += _OFF * largest
    return largest


@compiled(borrows=True)
def from_inside(level, w, b, work, cones, reach):
    """Put x and the states to the least J among what is not out and what lies beside it; False without room."""
    x, slope, state, ray, lower, index, held = (
        work.x, work.slope, cones.state, cones.ray, work.lower, work.listed, cones.held,
    )  # fmt: skip
    largest = _widened(level, work, cones)
    count = taken_in(level, work, cones)
    if count < 0:
        return False
    residual(b, work)
    slopes(level, w, work)
    for i in range(count):
        j = index[i]
        for k in range(3):
            held[k, j] = slope[k, j]
        held[0, j] = max(slope[0, j], math.hypot(slope[1, j], slope[2, j]) + _STEEP * reach)
    for _ in range(_ROUNDS):
        mean = 0.0
        for i in range(count):
            for k in range(3):
                mean += x[k, index[i]] * held[k, index[i]] / count
        if mean < _NEAR * reach * largest:
            break
        many = hessian(level, w, work, cones, count)
        for i in range(count):
            j = index[i]
            for a in range(3):
                one, ratio = _scaled(x, held, j, a)
                for c in range(a + 1):
                    lower[3 * i + a, 3 * i + c] += 2.0 * one * _scaled(x, held, j, c)[0] / ratio
                lower[3 * i + a, 3 * i + a] += (-1.0 if a == 0 else 1.0) / ratio
        if not factored(lower, many):
            break
        _aim(work, cones, count, many, 0.0)
        share = max((1.0 - min(_longest(work, cones, count), 1.0)) ** 3, 1e-4)
        _aim(work, cones, count, many, share * mean)
        share = min(_SHORT * _longest(work, cones, count), 1.0)
        for i in range(count):
            for k in range(3):
                x[k, index[i]] += share * cones.step[k, index[i]]
                held[k, index[i]] += share * cones.turn[k, index[i]]
        residual(b, work)
        slopes(level, w, work)
    for i in range(count):
        j, ratio = index[i], largest / reach
        p, u, v = x[0, j], x[1, j], x[2, j]
        settle_in(work, cones, j, p - ratio * held[0, j], u - ratio * held[1, j], v - ratio * held[2, j])
        if state[j] == INSIDE:
            x[0, j], x[1, j], x[2, j] = p, u, v
        elif state[j] == RIM:
            x[0, j], x[1, j], x[2, j] = p, p * ray[0, j], p * ray[1, j]
    return True
