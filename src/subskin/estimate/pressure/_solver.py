"""The pressure >= 0 at a weight, and the drag with which it fits best, compiled: exact, for one frame.

For whitened readings b and columns A, in the unknown heights x >= 0 of the elements,

    J = 1/2 |A x - b|^2 + 1/2 w x^T K x + cost x        with K the integral of (dp/dy)^2, or of |grad p|^2

is strictly convex. Where the traction leans, A = A_p + t_y A_y + t_z A_z. Which elements are > 0 and the drag t are
sought together: those that came out < 0 leave, those at which J falls are taken in (Portugal, Judice and Vicente 1994;
Kim and Park 2011), and where the drag moves by Newton's method, the pressure that follows it says which come next. Both
settle in about as many rounds as the first would need at a known drag. Where they do not, the pressure is found at each
drag in turn by Lawson and Hanson's way (1974), which always arrives. A drag that is free at each element is `_cones`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._check import FloatArray
from ..._compiled import compiled
from . import _elements as elements
from ._algebra import backward, factored, forward

TOLERANCE = 1e-11  # of a slope, of the largest that there is at x = 0
_TURNS, _ROUNDS, _STEPS = 60, 50, 300
_PATIENCE = 15  # rounds in which no fewer elements are wrong
_STRIDE = 0.3
"""Longest step of a drag's tangent."""
_LONG = 0.05
"""Step of a drag's tangent which is too long for the pressure to follow to first order."""
_FEW = 2.0
"""Fewer elements than the root of so many times all: a Hessian at another drag costs less than a round of slopes.

Among more the drag waits for the second round on fine elements: in the first too many are wrong.
"""

_MANY = 64
"""Readings from which products in single precision save time; these do on coarse elements, and until a fine drag moves.
"""


class Turn(NamedTuple):
    """How J's minimum over x changes with the drag.

    Parameters
    ----------
    along, crossed : ndarray, shapes (2, n) and (2, N)
        Readings of a tangent of 1, and L^-1 d2J/dx dt of the elements in the factor; rows by direction.
    slope, bend : ndarray, shapes (2,) and (3,)
        Of the minimum: dJ/dt, and its curvature yy, yz, zz. Of a drag in one direction, zz is yy.
    new : ndarray, shape (2,)
        The drag that is tried next.
    """

    along: FloatArray
    crossed: FloatArray
    slope: FloatArray
    bend: FloatArray
    new: FloatArray


@compiled()
def turn(work, count, turned):
    """Slope and curvature of the minimum over x in the drag."""
    x, r, lower, index, drags = work.x[0], work.residual, work.lower, work.listed, work.drags
    along, crossed, slope, bend = turned.along, turned.crossed, turned.slope, turned.bend
    n, last = r.size, count - 1
    for part in range(drags.shape[0]):
        slope[part] = 0.0
        for i in range(n):
            along[part, i] = 0.0
        for k in range(0, count, 2):  # two elements at once: what they share is fetched half as often
            h = min(k + 1, last)
            p, q = x[index[k]], x[index[h]] if h > k else 0.0
            one, two = drags[part, work.rows[index[k]]], drags[part, work.rows[index[h]]]
            s = u = 0.0
            for i in range(n):
                along[part, i] += p * one[i] + q * two[i]
                s += one[i] * r[i]
                u += two[i] * r[i]
            crossed[part, k], crossed[part, h] = s, u
        for i in range(n):
            slope[part] += along[part, i] * r[i]
        for k in range(0, count, 2):
            h = min(k + 1, last)
            one, two = work.columns[work.order[index[k]]], work.columns[work.order[index[h]]]
            s = u = 0.0
            for i in range(n):
                s += one[i] * along[part, i]
                u += two[i] * along[part, i]
            crossed[part, k] += s
            if h > k:
                crossed[part, h] += u
        forward(lower, count, crossed[part])
        stay(work, count, crossed[part])
    at = 0
    for part in range(drags.shape[0]):
        for other in range(part, drags.shape[0]):
            s = 0.0
            for i in range(n):
                s += along[part, i] * along[other, i]
            for k in range(count):
                s -= crossed[part, k] * crossed[other, k]
            bend[at] = s
            at += 1
    if drags.shape[0] == 1:
        bend[2] = bend[0]


@compiled()
def _next(t, turned, most):
    """The drag that Newton's method tries next, within the cone; how far that is, in standard deviations."""
    slope, new = turned.slope, turned.new
    a, c, d = turned.bend[0], turned.bend[1], turned.bend[2]
    lean = math.hypot(t[0], t[1])
    if lean >= most * (1.0 - 1e-9) and slope[0] * t[0] + slope[1] * t[1] < 0.0:
        # on the cone, and pressed against it: along it
        ey, ez = -t[1] / lean, t[0] / lean
        down = slope[0] * ey + slope[1] * ez
        curve = a * ey * ey + 2.0 * c * ey * ez + d * ez * ez - (slope[0] * t[0] + slope[1] * t[1]) / lean / lean
        step = -down / curve if curve > 0.0 else math.copysign(0.25 * most, -down)
        step = min(max(step, -0.5 * most), 0.5 * most)
        new[0], new[1] = t[0] + step * ey, t[1] + step * ez
        size = most / math.hypot(new[0], new[1])
        new[0], new[1] = size * new[0], size * new[1]
    else:
        # where J curves the wrong way, as much is added to its curvature as makes it right
        middle, half = 0.5 * (a + d), math.hypot(0.5 * (a - d), c)
        more = max(0.0, 1e-3 * (abs(middle) + half) - (middle - half))
        a, d = a + more, d + more
        det = a * d - c * c
        new[0] = t[0] - (d * slope[0] - c * slope[1]) / det
        new[1] = t[1] - (a * slope[1] - c * slope[0]) / det
        share = _STRIDE / max(math.hypot(new[0] - t[0], new[1] - t[1]), _STRIDE)
        new[0], new[1] = t[0] + share * (new[0] - t[0]), t[1] + share * (new[1] - t[1])
        size = math.hypot(new[0], new[1])
        if size > most:
            new[0], new[1] = new[0] * most / size, new[1] * most / size
    dy, dz = new[0] - t[0], new[1] - t[1]
    return math.sqrt(max(a * dy * dy + 2.0 * c * dy * dz + d * dz * dz, 0.0))


@compiled()
def heights(level, w, b, on, work):
    """The heights that are `on`, into z: how many, -1 where they are not determined, and their largest slope at x = 0.

    Leaves z times L^T in `half`.
    """
    lower, index, z, columns = work.lower, work.listed, work.z, work.columns
    count, reach = 0, 0.0
    for j in range(on.size):
        if on[j]:
            index[count] = j
            count += 1
    if not elements.hessian(level, w, work, count) or not factored(lower, count):
        return -1, reach
    for k in range(count):
        column, s = columns[work.order[index[k]]], -level.cost[index[k]]
        for i in range(b.size):
            s += column[i] * b[i]
        z[k], reach = s, max(reach, abs(s))
    forward(lower, count, z)
    for k in range(count):
        work.half[k] = z[k]
    backward(lower, count, z)
    return count, reach


@compiled(borrows=True)
def stay(work, count, z):
    """Take out of z = L^T x the orthonormal directions `away`, so that x stays in as many elements."""
    for m in range(work.taken[elements.AWAY]):
        q, s = work.away[m], 0.0
        for k in range(count):
            s += q[k] * z[k]
        for k in range(count):
            z[k] -= s * q[k]


@compiled(borrows=True)
def leave(on, count, work):
    """Put to 0 all heights that came out < 0, and find the others anew with the same factor.

    x_k = 0 says that z = L^T x is at right angles to L^-1 e_k.
    """
    lower, index, z, taken = work.lower, work.listed, work.z, work.taken
    taken[elements.AWAY] = 0
    for k in range(count):
        if z[k] >= 0.0:
            continue
        on[index[k]] = False
        q = work.away[taken[elements.AWAY]]
        for i in range(k):
            q[i] = 0.0
        q[k] = lower[k, k]
        for i in range(k + 1, count):
            s = 0.0
            for m in range(k, i):
                s += lower[i, m] * q[m]
            q[i] = -s * lower[i, i]
        stay(work, count, q)
        size = 0.0
        for i in range(count):
            size += q[i] * q[i]
        size = 1.0 / math.sqrt(size)
        for i in range(count):
            q[i] *= size
        taken[elements.AWAY] += 1
    if taken[elements.AWAY] == 0:
        return
    for k in range(count):
        z[k] = work.half[k]
    stay(work, count, z)
    backward(lower, count, z)
    for k in range(count):
        if not on[index[k]]:
            z[k] = 0.0


@compiled()
def follow(level, t, on, count, turned, work):
    """Go to the drag that is tried next; x follows to first order. False where there is no room."""
    x, index, z, new, crossed = work.x[0], work.listed, work.z, turned.new, turned.crossed
    for k in range(count):
        z[k] = 0.0
        for part in range(work.drags.shape[0]):
            z[k] += (t[part] - new[part]) * crossed[part, k]
    backward(work.lower, count, z)
    for k in range(count):
        if on[index[k]]:
            x[index[k]] += z[k]
    t[:] = new
    elements.lean(level, t, work)
    return elements.gather(level, work, count)


@compiled(borrows=True)
def _breach(work):
    """How far a slope is from that of a minimum."""
    x, slope, worst = work.x, work.slope, 0.0
    for j in range(x.shape[1]):
        worst = max(worst, abs(slope[0, j]) if x[0, j] > 0.0 else -slope[0, j])
    return worst


@compiled()
def together(level, t, most, w, b, on, near, enough, work, turned):
    """The p >= 0 and the drag of least J, sought together from guesses: how many elements the factor has, -1 for none.

    And the largest slope at x = 0 of these. Those at 0 among them are `away`.

    t (2,) and `on` are put right. near: the step of the drag that ends the search, in its standard deviations; enough:
    the step of the tangent after which elements have said enough that are coarse, 0 where they are not.
    """
    x, slope, index = work.x[0], work.slope[0], work.listed
    leans, rough = level.parts.shape[0] > 1, enough > 0.0
    work.taken[elements.SINGLE] = b.size >= _MANY and (leans or rough)
    fewest, waited = on.size + 1, 0
    elements.lean(level, t, work)
    for search in range(_ROUNDS):
        count, reach = heights(level, w, b, on, work)
        exact = work.taken[elements.SINGLE] == 0
        if count < 0:
            if exact or elements.crowded(work):
                break
            elements.make_exact(work)
            continue
        leave(on, count, work)
        tolerance = TOLERANCE * reach
        x[:] = 0.0
        for k in range(count):
            x[index[k]] = work.z[k]
        elements.residual(b, work)
        asked = leans and (rough or search > 0 or count * count < _FEW * on.size)
        moves, step = False, math.inf
        if asked:
            turn(work, count, turned)
            moves = _next(t, turned, most) >= near
            step = math.hypot(turned.new[0] - t[0], turned.new[1] - t[1])
        follows = moves and (step < _LONG or search == 0)
        if follows:
            if not follow(level, t, on, count, turned, work):
                break
            elements.residual(b, work)
        elements.slopes(level, w, work)
        if follows:
            for k in range(count):
                if on[index[k]]:
                    slope[index[k]] = 0.0  # as it is once x has followed exactly
        wrong = 0
        for j in range(on.size):
            wrong += x[j] < 0.0 if on[j] else slope[j] < -tolerance
        done = wrong == 0 and not moves and asked == leans
        if (done and (exact or rough)) or (wrong <= 2 and step < enough):
            return count, reach
        waited = 0 if wrong < fewest else waited + 1
        fewest = min(fewest, wrong)
        if waited > _PATIENCE:
            break
        for j in range(on.size):
            if on[j]:
                on[j] = x[j] >= 0.0
            else:
                on[j] = slope[j] < -tolerance and elements.steepest(level, slope, j)
        if moves and not follows:
            t[:] = turned.new
            elements.lean(level, t, work)
        if (moves or done) and not (exact or rough):
            elements.make_exact(work)
    return -1, 0.0


@compiled()
def descend(level, t, w, b, on, work):
    """The p >= 0 of least J at the drag t by Lawson and Hanson's way, one height more > 0 at a time, from a guess.

    How many elements are > 0, -1 for none, and their largest slope at x = 0.
    """
    x, slope, index, z = work.x[0], work.slope[0], work.listed, work.z
    elements.lean(level, t, work)
    work.taken[elements.AWAY] = work.taken[elements.SINGLE] = 0
    x[:] = 0.0
    reach = 0.0
    for _ in range(_STEPS):
        count, largest = heights(level, w, b, on, work)
        if count < 0:
            break
        reach = max(reach, largest)
        share, first = 1.0, -1
        for k in range(count):
            if z[k] < 0.0 and x[index[k]] <= share * (x[index[k]] - z[k]):
                share, first = x[index[k]] / (x[index[k]] - z[k]), k
        for k in range(count):
            j = index[k]
            x[j] += share * (z[k] - x[j])
            if k == first or x[j] < 0.0 or (share == 0.0 and x[j] == 0.0 and z[k] < 0.0):
                x[j], on[j] = 0.0, False
        if first >= 0:
            continue
        elements.residual(b, work)
        elements.slopes(level, w, work)
        steep = -1
        for j in range(on.size):
            if not on[j] and slope[j] < -TOLERANCE * reach and (steep < 0 or slope[j] < slope[steep]):
                steep = j
        if steep < 0:
            return count, reach
        on[steep] = True
    return -1, reach


@compiled(inline=True)
def in_turn(level, t, most, w, b, on, near, work, turned):
    """As `together`, from the same guesses: the pressure of each drag before the next drag."""
    trial = np.empty(2)
    count, reach = descend(level, t, w, b, on, work)
    value = elements.least(level, work)
    if level.parts.shape[0] == 1 or count < 0:
        return count, reach
    for _ in range(_TURNS):
        turn(work, count, turned)
        if _next(t, turned, most) < near:
            break
        share, found = 1.0, math.inf
        while share > 1e-3:
            for i in range(2):
                trial[i] = t[i] + share * (turned.new[i] - t[i])
            count, reach = descend(level, trial, w, b, on, work)
            found = elements.least(level, work)
            if count < 0 or found <= value + 1e-12 * abs(value):
                break
            share *= 0.5
        if count >= 0 and not found <= value + 1e-12 * abs(value):
            count, reach = descend(level, t, w, b, on, work)
            if count >= 0:
                turn(work, count, turned)
            break
        t[:] = trial
        if count < 0:
            break
        value = found
    return count, reach


@compiled(inline=True)
def settle(level, t, most, w, b, on, near, work, turned):
    """The least of J from guesses: how many elements the factor has, -1 where it was not found.

    And how far a slope is from that of a minimum, of the largest at x = 0.
    """
    drag = t.copy()
    count, reach = together(level, t, most, w, b, on, near, 0.0, work, turned)
    if count < 0 and not elements.crowded(work):
        t[:] = drag
        count, reach = in_turn(level, t, most, w, b, on, near, work, turned)
    return count, _breach(work) / reach if count > 0 else 0.0
