"""The pressure >= 0 on an area, and the drag along y and z with which it fits best, compiled: exact, for one frame.

At a drag the pressure is that of `_solver`. Which elements are > 0 and the drag are sought together: where the drag
moves, the pressure that follows it says which elements come next. Both settle in about as many rounds as the first
would need at a known drag. Where they do not, the pressure is found at each drag in turn.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from . import _on_area as on_area
from ._solver import TOLERANCE, backward, factored, forward, minimise

_TURNS, _ROUNDS = 60, 50
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


@compiled()
def _turn(level, work, count, gone, along, crossed, turned):
    """Slope (2) and curvature (3) of the minimum over x in the drag, `turned`; L^-1 d2J/dx dt into `crossed` (2, N).

    gone: directions of `work` in which x stays.
    """
    x, r, lower, index, own, columns, rows, order, away = (
        work[1], work[3], work[4], work[5], work[8], work[9], work[11], work[12], work[16],
    )  # fmt: skip
    n = r.size
    along[:] = 0.0
    turned[:] = 0.0
    last = count - 1
    for k in range(0, count, 2):  # two elements at once: what they share is fetched half as often
        h = min(k + 1, last)
        one, two = x[index[k]], x[index[h]] if h > k else 0.0
        a, c, d, e = own[0, rows[index[k]]], own[1, rows[index[k]]], own[0, rows[index[h]]], own[1, rows[index[h]]]
        s = u = v = z = 0.0
        for i in range(n):
            along[0, i] += one * a[i] + two * d[i]
            along[1, i] += one * c[i] + two * e[i]
            s += a[i] * r[i]
            u += c[i] * r[i]
            v += d[i] * r[i]
            z += e[i] * r[i]
        crossed[0, k], crossed[1, k], crossed[0, h], crossed[1, h] = s, u, v, z
    for i in range(n):
        turned[0] += along[0, i] * r[i]
        turned[1] += along[1, i] * r[i]
        turned[2] += along[0, i] * along[0, i]
        turned[3] += along[0, i] * along[1, i]
        turned[4] += along[1, i] * along[1, i]
    for k in range(0, count, 2):
        h = min(k + 1, last)
        one, two = columns[order[index[k]]], columns[order[index[h]]]
        s = u = v = z = 0.0
        for i in range(n):
            s += one[i] * along[0, i]
            u += one[i] * along[1, i]
            v += two[i] * along[0, i]
            z += two[i] * along[1, i]
        crossed[0, k] += s
        crossed[1, k] += u
        if h > k:
            crossed[0, h] += v
            crossed[1, h] += z
    for part in range(2):
        forward(lower, count, crossed[part])
        stay(away, gone, count, crossed[part])
    for k in range(count):
        turned[2] -= crossed[0, k] * crossed[0, k]
        turned[3] -= crossed[0, k] * crossed[1, k]
        turned[4] -= crossed[1, k] * crossed[1, k]


@compiled()
def _next(t, turned, most, new):
    """The drag that Newton's method tries next, within the cone; how far that is, in standard deviations."""
    a, c, d = turned[2], turned[3], turned[4]
    lean = math.hypot(t[0], t[1])
    if lean >= most * (1.0 - 1e-9) and turned[0] * t[0] + turned[1] * t[1] < 0.0:
        # on the cone, and pressed against it: along it
        ey, ez = -t[1] / lean, t[0] / lean
        slope = turned[0] * ey + turned[1] * ez
        curve = a * ey * ey + 2.0 * c * ey * ez + d * ez * ez - (turned[0] * t[0] + turned[1] * t[1]) / lean / lean
        step = -slope / curve if curve > 0.0 else math.copysign(0.25 * most, -slope)
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
        new[0] = t[0] - (d * turned[0] - c * turned[1]) / det
        new[1] = t[1] - (a * turned[1] - c * turned[0]) / det
        share = _STRIDE / max(math.hypot(new[0] - t[0], new[1] - t[1]), _STRIDE)
        new[0], new[1] = t[0] + share * (new[0] - t[0]), t[1] + share * (new[1] - t[1])
        size = math.hypot(new[0], new[1])
        if size > most:
            new[0], new[1] = new[0] * most / size, new[1] * most / size
    dy, dz = new[0] - t[0], new[1] - t[1]
    return math.sqrt(max(a * dy * dy + 2.0 * c * dy * dz + d * dz * dz, 0.0))


@compiled()
def _heights(level, w, exact, b, on, work):
    """The heights that are `on`, into z: how many, -1 where they are not determined, and their largest slope at x = 0.

    Leaves in the scratch z times L^T. exact: as in `_on_area.hessian`.
    """
    lower, index, z, half, columns, order = work[4], work[5], work[6], work[7], work[9], work[12]
    count, reach = 0, 0.0
    for j in range(on.size):
        if on[j]:
            index[count] = j
            count += 1
    if not on_area.hessian(level, w, exact, work, count) or not factored(lower, count):
        return -1, reach
    for k in range(count):
        column, s = columns[order[index[k]]], -level[6][index[k]]
        for i in range(b.size):
            s += column[i] * b[i]
        z[k], reach = s, max(reach, abs(s))
    forward(lower, count, z)
    for k in range(count):
        half[k] = z[k]
    backward(lower, count, z)
    return count, reach


@compiled(borrows=True)
def stay(away, gone, count, z):
    """Take out of z = L^T x the orthonormal directions `away`, so that x stays in as many elements."""
    for m in range(gone):
        q, s = away[m], 0.0
        for k in range(count):
            s += q[k] * z[k]
        for k in range(count):
            z[k] -= s * q[k]


@compiled(borrows=True)
def _leave(on, count, work):
    """Put to 0 all heights that came out < 0, and find the others anew with the same factor: how many left.

    x_k = 0 says that z = L^T x is at right angles to L^-1 e_k.
    """
    lower, index, z, half, away = work[4], work[5], work[6], work[7], work[16]
    gone = 0
    for k in range(count):
        if z[k] >= 0.0:
            continue
        on[index[k]] = False
        q = away[gone]
        for i in range(k):
            q[i] = 0.0
        q[k] = lower[k, k]
        for i in range(k + 1, count):
            s = 0.0
            for m in range(k, i):
                s += lower[i, m] * q[m]
            q[i] = -s * lower[i, i]
        stay(away, gone, count, q)
        size = 0.0
        for i in range(count):
            size += q[i] * q[i]
        size = 1.0 / math.sqrt(size)
        for i in range(count):
            q[i] *= size
        gone += 1
    if gone == 0:
        return 0
    for k in range(count):
        z[k] = half[k]
    stay(away, gone, count, z)
    backward(lower, count, z)
    for k in range(count):
        if not on[index[k]]:
            z[k] = 0.0
    return gone


@compiled()
def _follow(level, t, new, on, count, crossed, work):
    """Go to the drag `new`; x follows to first order, by what `_turn` left. False where there is no room."""
    x, lower, index, z = work[1], work[4], work[5], work[6]
    for k in range(count):
        z[k] = (t[0] - new[0]) * crossed[0, k] + (t[1] - new[1]) * crossed[1, k]
    backward(lower, count, z)
    for k in range(count):
        if on[index[k]]:
            x[index[k]] += z[k]
    t[:] = new
    on_area.lean(level, t, work)
    return on_area.gather(level, work, count, False)


@compiled()
def together(level, t, most, w, b, on, near, enough, work, scratch):
    """The p >= 0 and the drag of least J, sought together from guesses: how many elements the factor has, -1 for none.

    And the largest slope at x = 0 of these, and in how many directions of `work` x stays: those at 0 among them.

    t (2,) and `on` are put right; scratch: what `_turn` leaves. enough: a step of the tangent after which elements have
    said enough that are coarse; 0 where they are not.
    """
    x, slope, index, z = work[1], work[2], work[5], work[6]
    along, crossed, turned, new = scratch
    leans, rough = level[0].shape[0] > 1, enough > 0.0
    exact = b.size < _MANY or not (leans or rough)
    on_area.lean(level, t, work)
    for search in range(_ROUNDS):
        count, reach = _heights(level, w, exact, b, on, work)
        if count < 0:
            if exact or on_area.crowded(work):
                break
            exact = True
            on_area.unmultiplied(work)
            continue
        gone, tolerance = _leave(on, count, work), TOLERANCE * reach
        x[:] = 0.0
        for k in range(count):
            x[index[k]] = z[k]
        on_area.residual(b, work)
        asked = leans and (rough or search > 0 or count * count < _FEW * on.size)
        moves, step = False, math.inf
        if asked:
            _turn(level, work, count, gone, along, crossed, turned)
            moves = _next(t, turned, most, new) >= near
            step = math.hypot(new[0] - t[0], new[1] - t[1])
        follows = moves and (step < _LONG or search == 0)
        if follows:
            if not _follow(level, t, new, on, count, crossed, work):
                break
            on_area.residual(b, work)
        on_area.slopes(level, w, work)
        if follows:
            for k in range(count):
                if on[index[k]]:
                    slope[index[k]] = 0.0  # as it is once x has followed exactly
        wrong = 0
        for j in range(on.size):
            wrong += x[j] < 0.0 if on[j] else slope[j] < -tolerance
        done = wrong == 0 and not moves and asked == leans
        if (done and (exact or rough)) or (wrong <= 2 and step < enough):
            return count, reach, gone
        for j in range(on.size):
            if on[j]:
                on[j] = x[j] >= 0.0
            else:
                on[j] = slope[j] < -tolerance and on_area.steepest(level, slope, j)
        if moves and not follows:
            t[:] = new
            on_area.lean(level, t, work)
        if (moves or done) and not (exact or rough):
            exact = True
            on_area.unmultiplied(work)
    return -1, 0.0, 0


@compiled()
def _least(level, t, w, b, on, downhill, work):
    """The p >= 0 of least J at the drag t: how many elements are > 0, and J, less a constant."""
    cost, x = level[6], work[1]
    on_area.lean(level, t, work)
    for j in range(x.size):
        downhill[j] = on_area.seen(level, work[0], b, j) - cost[j]
    count = minimise(level, t, w, b, downhill, on, work)
    value = 0.0
    for k in range(count):
        j = work[5][k]
        value -= 0.5 * downhill[j] * x[j]
    return count, value


@compiled()
def in_turn(level, t, most, w, b, on, near, work, scratch):
    """As `together`, from the same guesses: the pressure of each drag before the next drag."""
    along, crossed, turned, new = scratch
    downhill, trial = np.empty(on.size), np.empty(2)
    count, value = _least(level, t, w, b, on, downhill, work)
    if level[0].shape[0] == 1 or count < 0:
        return count, np.abs(downhill).max()
    for _ in range(_TURNS):
        _turn(level, work, count, 0, along, crossed, turned)
        if _next(t, turned, most, new) < near:
            break
        share, found = 1.0, math.inf
        while share > 1e-3:
            for i in range(2):
                trial[i] = t[i] + share * (new[i] - t[i])
            count, found = _least(level, trial, w, b, on, downhill, work)
            if count < 0 or found <= value + 1e-12 * abs(value):
                break
            share *= 0.5
        if count >= 0 and not found <= value + 1e-12 * abs(value):
            count, value = _least(level, t, w, b, on, downhill, work)
            if count >= 0:
                _turn(level, work, count, 0, along, crossed, turned)
            break
        t[:] = trial
        if count < 0:
            break
        value = found
    return count, np.abs(downhill).max()
