"""Compiled: the last step of a fit where the finger, and the size of a touch, are not known exactly.

An error of the finger changes readings in proportion to the load, so what readings leave open is known at a load
alone. From the best load by the noise a few steps of Gauss and Newton lead to the best one by all errors: those of
each sensor add to its variance; those that all have in common, each of standard deviation 1, are unknowns of their own,
with that as a prior; so is the square of the half width, between 0 and the largest (docs/real_fingers.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._check import FloatArray
from ..._compiled import compiled

COMMON = 3
"""Errors that sensors may have in common: of gain, of depth, of Poisson's ratio."""
NONE, ALL = -1, -2
"""Coordinates of positions that a step holds where they are."""
_FIXED = 1e12
"""Weight of what is as good as exact."""


class SettlingRoom(NamedTuple):
    """Scratch and state: at (P,), load (F,): the unknowns; size (1,): q, from 0 to 1; shared (errors,): those in
    common, in their deviations; ratios (2,): ends of the last of them; away (2,): of the last coordinate; rows (m, n):
    slopes of what is predicted in all these; rest, weight, part (n,); matrix, inverse, free (m, m); right, step, scale,
    prior, cone (m,).
    """

    at: FloatArray
    load: FloatArray
    size: FloatArray
    shared: FloatArray
    ratios: FloatArray
    away: FloatArray
    rows: FloatArray
    rest: FloatArray
    weight: FloatArray
    part: FloatArray
    matrix: FloatArray
    inverse: FloatArray
    free: FloatArray
    right: FloatArray
    step: FloatArray
    scale: FloatArray
    prior: FloatArray
    cone: FloatArray


@compiled()
def room_of(positions, components, common, ratios, n):
    """Scratch for so many coordinates, components, errors in common and sensors."""
    m = positions + components + 1 + common
    return SettlingRoom(
        np.zeros(positions), np.zeros(components), np.zeros(1), np.zeros(common), ratios,
        np.array([-math.inf, math.inf]), np.zeros((m, n)),
        np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((m, m)), np.zeros((m, m)), np.zeros((m, m)),
        np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m),
    )  # fmt: skip


@compiled(inline=True)
def copied(values, out):
    """Write values over `out`, both (n,)."""
    for i in range(out.size):
        out[i] = values[i]


@compiled(borrows=True)
def copy_state(room, out):
    """All unknowns of a room, to another."""
    copied(room.at, out.at)
    copied(room.load, out.load)
    copied(room.shared, out.shared)
    out.size[0] = room.size[0]


@compiled(borrows=True)
def _factored(a, m):
    """Cholesky's factor in the lower triangle, in place; whether there is one."""
    for j in range(m):
        for k in range(j):
            for i in range(j, m):
                a[i, j] -= a[i, k] * a[j, k]
        if not a[j, j] > 1e-13:
            return False
        root = 1.0 / math.sqrt(a[j, j])
        for i in range(j, m):
            a[i, j] *= root
    return True


@compiled(borrows=True)
def _normal(room):
    """Normal equations, each unknown in units that make the diagonal 1."""
    rows, a, b, scale, n = room.rows, room.matrix, room.right, room.scale, room.rest.size
    m = b.size
    for j in range(m):
        total = 0.0
        for i in range(n):
            room.part[i] = rows[j, i] * room.weight[i]
            total += room.part[i] * room.rest[i]
        b[j] = total
        for k in range(j + 1):
            total = 0.0
            for i in range(n):
                total += room.part[i] * rows[k, i]
            a[j, k] = total
        a[j, j] += room.prior[j]
    for e in range(room.shared.size):  # they are zero, up to 1
        b[m - room.shared.size + e] -= room.shared[e]
    for j in range(m):
        scale[j] = 1.0 / math.sqrt(a[j, j]) if a[j, j] > 0.0 else 1.0
        if not a[j, j] > 0.0:
            a[j, j] = 1.0
    for j in range(m):
        b[j] *= scale[j]
        for k in range(j + 1):
            a[j, k] *= scale[j] * scale[k]


@compiled(borrows=True)
def _back(a, x):
    """Solve by Cholesky's factor a, x in place."""
    m = x.size
    for j in range(m):
        for k in range(j):
            x[j] -= a[j, k] * x[k]
        x[j] /= a[j, j]
    for r in range(m):
        j = m - 1 - r
        for i in range(j + 1, m):
            x[j] -= a[i, j] * x[i]
        x[j] /= a[j, j]


@compiled(borrows=True)
def _solved(room):
    """The step of normal equations, in its own units; whether there is one. The factor stays in `inverse`."""
    a, x, m = room.inverse, room.step, room.right.size
    for j in range(m):
        x[j] = room.right[j]
        for k in range(j + 1):
            a[j, k] = room.matrix[j, k]
    if not _factored(a, m):
        return False
    _back(a, x)
    for j in range(m):
        x[j] *= room.scale[j]
    return True


@compiled(borrows=True)
def bound(room, row, aim):
    """Hold a sum of steps, `row` (m,), at `aim`, by a prior as good as exact."""
    a, m = room.matrix, room.right.size
    for j in range(m):
        for k in range(j + 1):
            a[j, k] += _FIXED * row[j] * room.scale[j] * row[k] * room.scale[k]
        room.right[j] += _FIXED * row[j] * room.scale[j] * aim


@compiled(borrows=True)
def _copied_factor(one, out):
    for j in range(one.shape[0]):
        for k in range(j + 1):
            out[j, k] = one[j, k]


@compiled(borrows=True)
def _within(room, k, now, ends):
    """Solve again with step k held where it leads from `now` to beyond its ends (2,); whether there is a step."""
    aim = now + room.step[k]
    if ends[0] <= aim <= ends[1]:
        return True
    room.cone[:] = 0.0
    room.cone[k] = 1.0 / room.scale[k]
    bound(room, room.cone, ((ends[0] if aim < ends[0] else ends[1]) - now) / room.scale[k])
    return _solved(room)


@compiled(borrows=True)
def stepped(room, friction, forces, sized, held):
    """Solve for the next step of a frame whose rows are laid out, within the cone; the chi-square left.

    forces: components of each load; sized: whether q is free; without, its prior holds it where it is; held: the
    coordinate of which that is so too, `ALL` or `NONE`. Negative where there is no step. Of a Poisson's ratio, or a
    distance, at an end of what may be the covariance is that of a free one: it may yet be off the end.
    """
    positions, components = room.at.size, room.load.size
    first, q = positions, positions + components
    for j in range(room.prior.size):
        room.prior[j] = 1.0 if j > q else _FIXED * 1e6 if j == held or (j < positions and held == ALL) else 0.0
    if not sized:
        room.prior[q] = _FIXED * 1e6
    _normal(room)
    if friction == 0.0:
        for c in range(components):
            if c % forces == 0:
                continue
            room.cone[:] = 0.0
            room.cone[first + c] = 1.0 / room.scale[first + c]
            bound(room, room.cone, -room.load[c] / room.scale[first + c])
    if not _solved(room):
        return -1.0
    x = room.step
    if sized and not 0.0 <= room.size[0] + x[q] <= 1.0:
        room.cone[:] = 0.0
        room.cone[q] = 1.0 / room.scale[q]
        bound(room, room.cone, ((0.0 if room.size[0] + x[q] < 0.0 else 1.0) - room.size[0]) / room.scale[q])
        if not _solved(room):
            return -1.0
    for begin in range(0, components if 0.0 < friction < math.inf else 0, forces):
        drag, at = 0.0, first + begin
        for c in range(1, forces):
            drag += (room.load[begin + c] + x[at + c]) ** 2
        drag = math.sqrt(drag)
        if drag > friction * (room.load[begin] + x[at]):
            room.cone[:] = 0.0
            unit = room.scale[at]
            room.cone[at] = -friction / unit
            aim = friction * room.load[begin] / unit
            for c in range(1, forces):
                share = (room.load[begin + c] + x[at + c]) / drag
                room.cone[at + c] = share / unit
                aim -= share * room.load[begin + c] / unit
            bound(room, room.cone, aim)
            if not _solved(room):
                return -1.0
    n, m = room.rest.size, x.size
    _copied_factor(room.inverse, room.free)
    if not _within(room, positions - 1, room.at[positions - 1], room.away):
        return -1.0
    if room.shared.size == COMMON and not _within(room, m - 1, room.shared[COMMON - 1], room.ratios):
        return -1.0
    _copied_factor(room.free, room.inverse)
    left = 0.0
    for i in range(n):
        rest = room.rest[i]
        for j in range(m):
            rest -= room.rows[j, i] * x[j]
        left += rest * rest * room.weight[i]
    for e in range(room.shared.size):
        left += (room.shared[e] + x[q + 1 + e]) ** 2
    return left


@compiled(borrows=True)
def volume_of(room):
    """Minus the logarithm of the weights' product: a load with more errors has to explain so much more of chi-square.

    The likelihood of readings has the determinant of their covariance, which grows with the load.
    """
    total = 0.0
    for i in range(room.weight.size):
        total -= math.log(room.weight[i])
    return total


@compiled(borrows=True)
def _column(room, column):
    """A column of the covariance of all unknowns, from the factor of the last step, into `right`."""
    x = room.right
    x[:] = 0.0
    x[column] = room.scale[column]
    _back(room.inverse, x)
    for j in range(x.size):
        x[j] *= room.scale[j]


@compiled(borrows=True)
def spread_of(room, out):
    """The covariance of position and components, upper triangle."""
    k, e = room.at.size + room.load.size, 0
    for column in range(k):
        _column(room, column)
        for j in range(column, k):
            out[e] = room.right[j]
            e += 1


@compiled(borrows=True)
def size_of(room, out):
    """What the readings say of q in a step that has it free: the best one, and its standard deviation.

    Fills `out` (P + F,): how position and components change with q.
    """
    k = room.at.size + room.load.size
    _column(room, k)
    for j in range(k):
        out[j] = room.right[j] / room.right[k]
    return room.size[0] + room.step[k], math.sqrt(room.right[k])


@compiled()
def second_moment(best, deviation):
    """Mean of q^2 where q is normal, N(best, deviation^2), cut to 0 to 1."""
    low, high = -best / deviation, (1.0 - best) / deviation
    if low > 8.0:  # all of it at 0: as of an exponential
        return 2.0 * (deviation / low) ** 2
    p_low, p_high = math.exp(-0.5 * low * low), math.exp(-0.5 * high * high)
    root = math.sqrt(2.0)
    mass = 0.5 * (math.erf(high / root) - math.erf(low / root)) * math.sqrt(2.0 * math.pi)
    if not mass > 1e-12:
        return 1.0 if best > 0.5 else 0.0
    mean = best + deviation * (p_low - p_high) / mass
    variance = deviation**2 * (1.0 + (low * p_low - high * p_high) / mass - ((p_low - p_high) / mass) ** 2)
    return max(variance, 0.0) + mean * mean
