"""Compiled: S on a grid of positions (y, z) in single precision, and the highest points of it, to climb from.

Readings that name one sensor as the strongest allow loads near that sensor alone; so the grid is cut into tiles, one a
sensor, beside one of the whole (`tiles.py`). Columns of A stand in an orthonormal basis; outside the cone of friction
the better of two loads on it or in it is taken, which is at most what the cone allows.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..._lanes import EIGHT, alike, answers, eight, first_of, put, where
from .tiles import BASIS, COUNT, NEAR, NODES

TINY = np.float32(1e-30)
_R22, _OVER = 5, 6
"""Rows of shapes: the last entry of the columns, and where 1 over those of the diagonal begin."""
_SIZE, _WORD, _INDEX = np.int64(0x7FFFFFFF), np.int64(32), np.int64(0xFFFFFFFF)
HALF, ONE, TWO, NOUGHT = np.float32(0.5), np.float32(1), np.float32(2), np.float32(0)


@compiled(inline=True)
def whitened(frame, rows, w, single):
    """Fill w and single (n + 1,), readings in units of noise, and give the sum of their squares; NaN if one is out."""
    total, usable = 0.0, True
    n = frame.size
    for i in range(n):
        r = frame[i]
        usable &= rows[2, i] < r < rows[3, i]
        w[i] = (r - rows[0, i]) * rows[1, i]
        single[i] = w[i]
        total += w[i] * w[i]
    return total if usable else math.nan


@compiled(inline=True)
def strongest(single, bits, n):
    """The sensor with the largest reading, and its square; bits: the readings as integers, which are as quick to rank.

    Numbers without their sign rank as their bits do.
    """
    largest = np.int64(0)
    for i in range(n):  # the first of equals
        largest = max(largest, (np.int64(bits[i] & _SIZE) << _WORD) + (n - 1 - i))
    hot = n - 1 - (largest & _INDEX)
    return hot, single[hot] * single[hot]


@compiled(borrows=True)
def by_strongest(readings, rows, strong, hot, start, order):
    """Each frame's strongest sensor into hot, and the frames into order: first those of sensor 0, then those of 1.

    A frame that reads less than `strong` noises comes last, its sensor is n. start (n + 2,): scratch.
    """
    frames, n = readings.shape
    for i in range(n + 2):
        start[i] = 0
    for f in range(frames):
        frame, largest, here = readings[f], -1.0, 0
        for i in range(n):
            size = abs((frame[i] - rows[0, i]) * rows[1, i])
            here = i if size > largest else here
            largest = size if size > largest else largest
        here = here if largest >= strong else n
        hot[f] = here
        start[here + 1] += 1
    for i in range(n + 1):
        start[i + 1] += start[i]
    for f in range(frames):
        order[start[hot[f]]] = f
        start[hot[f]] += 1


@compiled(inline=True)
def shares_of_eight(w, n, basis, at):
    """What the basis (k, 3, 8) of eight nodes side by side takes of n readings; it begins at `at`."""
    c0, c1, c2 = alike(NOUGHT), alike(NOUGHT), alike(NOUGHT)
    for i in range(n):
        r, here = w[i], at + 3 * EIGHT * i
        c0 += eight(basis, here) * r
        c1 += eight(basis, here + EIGHT) * r
        c2 += eight(basis, here + 2 * EIGHT) * r
    return c0, c1, c2


@compiled(exact=True, borrows=True)
def _shares(readings, k, basis, at, nodes, c, d):
    """The same of two frames and a whole basis (nodes / 8, k, 3, 8), into c and d (3 nodes,).

    readings: k of the one, then k of the other.
    """
    for p in range(0, nodes, EIGHT):
        c0, c1, c2, d0, d1, d2 = (
            alike(NOUGHT), alike(NOUGHT), alike(NOUGHT), alike(NOUGHT), alike(NOUGHT), alike(NOUGHT)
        )  # fmt: skip
        for i in range(k):
            here = at + 3 * (k * p + EIGHT * i)
            r, s, b0, b1, b2 = (
                readings[i], readings[k + i], eight(basis, here), eight(basis, here + EIGHT),
                eight(basis, here + 2 * EIGHT),
            )  # fmt: skip
            c0 += b0 * r
            c1 += b1 * r
            c2 += b2 * r
            d0 += b0 * s
            d1 += b1 * s
            d2 += b2 * s
        put(c, p, c0)
        put(c, nodes + p, c1)
        put(c, 2 * nodes + p, c2)
        put(d, p, d0)
        put(d, nodes + p, d1)
        put(d, 2 * nodes + p, d2)


@compiled(borrows=True)
def taken(w, v, tiles, t, c, d):
    """What the basis of each node of tile t takes of two frames w and v (n + 1,), into c and d: 3 nodes and scratch.

    The table is read once for both; one frame may be both. Given are the squares of the readings that count.
    """
    index, near, basis = tiles.table, tiles.near, tiles.basis
    i0, k, at, m = index[t, NEAR], index[t, COUNT], index[t, BASIS], index[t, NODES]
    readings, total, other = c[3 * m :], NOUGHT, NOUGHT
    for i in range(k):
        r, s = w[near[i0 + i]], v[near[i0 + i]]
        readings[i], readings[k + i] = r, s
        total += r * r
        other += s * s
    _shares(readings, k, basis, at, m, c, d)
    return total, other


@compiled(inline=True)
def within(shapes, mu, c, s):
    """S at each node into s (nodes,), for loads that press within the cone, of what the basis takes, c.

    shapes (9, nodes): columns of A in the basis, 00 01 02 11 12 22, and 1 over 00, 11, 22.
    """
    m = s.size
    steep = np.float32(mu) if mu < math.inf else ONE
    one, square = (ONE if mu < math.inf else NOUGHT), np.float32(mu * mu)
    for p in range(m):
        c0, c1, c2 = c[p], c[m + p], c[2 * m + p]
        r00, r01, r02, r11, r12, r22 = (
            shapes[0, p], shapes[1, p], shapes[2, p], shapes[3, p], shapes[4, p], shapes[_R22, p]
        )  # fmt: skip
        tz = c2 * shapes[_OVER + 2, p]
        ty = (c1 - r12 * tz) * shapes[_OVER + 1, p]
        n = (c0 - r01 * ty - r02 * tz) * shapes[_OVER, p]
        t2 = ty * ty + tz * tz
        lean = steep / np.sqrt(t2 + TINY)
        ey, ez = lean * ty, lean * tz
        e0, e1, e2 = one * r00 + r01 * ey + r02 * ez, r11 * ey + r12 * ez, r22 * ez
        along = c0 * e0 + c1 * e1 + c2 * e2
        along = along if along > NOUGHT else NOUGHT
        straight = c0 if c0 > NOUGHT else NOUGHT
        on, up = along * along / (e0 * e0 + e1 * e1 + e2 * e2 + TINY), straight * straight
        bound = on if on > up else up
        free = c0 * c0 + c1 * c1 + c2 * c2
        s[p] = free if (n > NOUGHT) & (t2 <= square * n * n) else bound


@compiled(inline=True)
def _angle2(s, over):
    """Square of the angle between the readings and the best load at a node, which has explained s of 1 / over.

    It grows with the square of the distance from the top much further than S falls so.
    """
    x = min(max(ONE - s * over, NOUGHT), ONE)
    return x * (ONE + x * (np.float32(1 / 3) + np.float32(8 / 45) * x))


@compiled(inline=True)
def _largest(a, b, c, d):
    """Of four lanes."""
    a, b = where(a > b, a, b), where(c > d, c, d)
    return where(a > b, a, b)


@compiled(inline=True)
def _vertex(heights, q, stride, total, over):
    """Where the parabola through node q and its neighbours has its top, in rows and columns from it, and its height."""
    here = heights[q]
    height, mj, mk, least = here, NOUGHT, NOUGHT, here
    for j in range(-1, 2):
        for k in range(-1, 2):
            least = min(least, heights[q + j * stride + k])
    if least > NOUGHT:
        up, down = _angle2(heights[q + stride], over), _angle2(heights[q - stride], over)
        left, right, middle = _angle2(heights[q + 1], over), _angle2(heights[q - 1], over), _angle2(here, over)
        gj, gk = HALF * (up - down), HALF * (left - right)
        hjj, hkk = up - TWO * middle + down, left - TWO * middle + right
        hjk = np.float32(0.25) * (
            _angle2(heights[q + stride + 1], over) - _angle2(heights[q + stride - 1], over)
            - _angle2(heights[q - stride + 1], over) + _angle2(heights[q - stride - 1], over)
        )  # fmt: skip
        det = hjj * hkk - hjk * hjk
        if hjj > NOUGHT and det > np.float32(0.05) * hjj * hkk:
            mj, mk = (hjk * gk - hkk * gj) / det, (hjk * gj - hjj * gk) / det
            mj, mk = min(max(mj, -ONE), ONE), min(max(mk, -ONE), ONE)
            height = max(height, height - total * HALF * (gj * mj + gk * mk))
    return height, mj, mk


@compiled(borrows=True)
def peaks(heights, lead, m, stride, total, share, score, at):
    """Nodes above their eight neighbours, the best first, at the top of the parabola through these: their number.

    S stands in heights from `lead` on, m nodes in rows of `stride`, of which the last is none, with less than 0 before
    and after. total: what could be explained; nodes below `share` of the highest are left out; score (most,), at
    (most, 2): row and column.
    """
    most, count, over = score.size, 0, ONE / (total + TINY)
    for p in range(lead, lead + m, EIGHT):
        here, under, beyond = eight(heights, p), p - stride, p + stride
        before = _largest(
            eight(heights, under - 1), eight(heights, under), eight(heights, under + 1), eight(heights, p - 1)
        )
        after = _largest(
            eight(heights, p + 1), eight(heights, beyond - 1), eight(heights, beyond), eight(heights, beyond + 1)
        )
        above = answers((here > before) & (here >= after) & (here > NOUGHT))
        while above > 0:
            q = p + first_of(above)
            above &= above - 1
            height, mj, mk = _vertex(heights, q, stride, total, over)
            rank = count
            while rank > 0 and score[rank - 1] < height:
                rank -= 1
            if rank < most:
                for e in range(min(count, most - 1), rank, -1):
                    score[e] = score[e - 1]
                    at[e, 0], at[e, 1] = at[e - 1, 0], at[e - 1, 1]
                score[rank] = height
                at[rank, 0], at[rank, 1] = (q - lead) // stride + mj, (q - lead) % stride + mk
                count = min(count + 1, most)
    while count > 0 and score[count - 1] < share * score[0]:
        count -= 1
    return count
