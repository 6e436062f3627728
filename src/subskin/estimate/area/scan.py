"""Compiled: S on a grid of positions (y, z) in single precision, and the highest points of it, to climb from.

Readings that name one sensor as the strongest allow loads near that sensor alone; so the grid is cut into tiles, one a
sensor, beside one of the whole (`tiles.py`). Columns of A stand in an orthonormal basis; outside the cone of friction
the better of two loads on it or in it is taken, which is at most what the cone allows.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled

TINY = np.float32(1e-30)
HALF, ONE, TWO, NOUGHT = np.float32(0.5), np.float32(1), np.float32(2), np.float32(0)


@compiled(inline=True)
def scan(w, near, basis, shapes, mu, c, s):
    """S at each node into s (nodes,).

    w (n,), single; near (k,): the sensors that count, k even; basis (k, 3, nodes); shapes (9, nodes): columns of A in
    the basis, 00 01 02 11 12 22, and 1 over 00, 11, 22; c (3, at least nodes): scratch.
    """
    k, _, m = basis.shape
    for p in range(m):
        c[0, p] = c[1, p] = c[2, p] = NOUGHT
    for i in range(0, k, 2):
        w0, w1 = w[near[i]], w[near[i + 1]]
        for p in range(m):
            c[0, p] += w0 * basis[i, 0, p] + w1 * basis[i + 1, 0, p]
            c[1, p] += w0 * basis[i, 1, p] + w1 * basis[i + 1, 1, p]
            c[2, p] += w0 * basis[i, 2, p] + w1 * basis[i + 1, 2, p]
    steep = np.float32(mu) if mu < math.inf else ONE
    one, square = (ONE if mu < math.inf else NOUGHT), np.float32(mu * mu)
    for p in range(m):
        c0, c1, c2 = c[0, p], c[1, p], c[2, p]
        r00, r01, r02, r11, r12, r22 = (
            shapes[0, p], shapes[1, p], shapes[2, p], shapes[3, p], shapes[4, p], shapes[5, p]
        )  # fmt: skip
        tz = c2 * shapes[8, p]
        ty = (c1 - r12 * tz) * shapes[7, p]
        n = (c0 - r01 * ty - r02 * tz) * shapes[6, p]
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


@compiled()
def peaks(s, rows, columns, share, score, at):
    """Nodes above their eight neighbours, the best first, with the height of the parabola through these: their number.

    s (rows columns,); those below `share` of the highest are left out. score (most,), at (most, 2): row and column.
    """
    most, count = score.size, 0
    top = NOUGHT
    for p in range(rows * columns):
        top = max(top, s[p])
    if not top > NOUGHT:
        return 0
    least = np.float32(share) * top
    for p in range(rows * columns):
        if s[p] < least:
            continue
        here, j, k = s[p], p // columns, p % columns
        lower = True
        for dj in range(-1, 2):
            for dk in range(-1, 2):
                a, b = j + dj, k + dk
                if (dj != 0 or dk != 0) and 0 <= a < rows and 0 <= b < columns:
                    other = s[a * columns + b]
                    before = dj < 0 or (dj == 0 and dk < 0)
                    lower &= not (other > here or (before and other == here))
        if not lower:
            continue
        height, row, column = float(here), float(j), float(k)
        if 0 < j < rows - 1 and 0 < k < columns - 1:
            up, down, left, right = s[p + columns], s[p - columns], s[p + 1], s[p - 1]
            gj, gk = HALF * (up - down), HALF * (left - right)
            hjj, hkk = up - TWO * here + down, left - TWO * here + right
            hjk = np.float32(0.25) * (s[p + columns + 1] - s[p + columns - 1] - s[p - columns + 1] + s[p - columns - 1])
            det = hjj * hkk - hjk * hjk
            if hjj < NOUGHT and det > np.float32(0.05) * hjj * hkk:
                mj, mk = (hjk * gk - hkk * gj) / det, (hjk * gj - hjj * gk) / det
                mj, mk = min(max(mj, -ONE), ONE), min(max(mk, -ONE), ONE)
                row, column = j + mj, k + mk
                height += 0.5 * (gj * mj + gk * mk)
        rank = count
        while rank > 0 and score[rank - 1] < height:
            rank -= 1
        if rank < most:
            for e in range(min(count, most - 1), rank, -1):
                score[e] = score[e - 1]
                at[e, 0], at[e, 1] = at[e - 1, 0], at[e - 1, 1]
            score[rank] = height
            at[rank, 0], at[rank, 1] = row, column
            count = min(count + 1, most)
    return count
