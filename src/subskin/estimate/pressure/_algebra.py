"""Cholesky factors and products of columns, compiled, by four rows and four columns at once.

Each number is so fetched a quarter as often.
"""

from __future__ import annotations

import math

from ..._compiled import compiled


@compiled(inline=True)
def _by_four(one, two, three, four, p, q, r, s, count):
    """Products of each of four rows with each of four."""
    ap = aq = ar = at = bp = bq = br = bt = one.dtype.type(0)
    cp = cq = cr = ct = dp = dq = dr = dt = one.dtype.type(0)
    for k in range(count):
        u, v, w, x = one[k], two[k], three[k], four[k]
        ap += u * p[k]
        aq += u * q[k]
        ar += u * r[k]
        at += u * s[k]
        bp += v * p[k]
        bq += v * q[k]
        br += v * r[k]
        bt += v * s[k]
        cp += w * p[k]
        cq += w * q[k]
        cr += w * r[k]
        ct += w * s[k]
        dp += x * p[k]
        dq += x * q[k]
        dr += x * r[k]
        dt += x * s[k]
    return (ap, aq, ar, at), (bp, bq, br, bt), (cp, cq, cr, ct), (dp, dq, dr, dt)


@compiled(borrows=True)
def multiply(columns, products, first, last):
    """Products of the columns from `first` to `last` with each other and with all before."""
    n = columns.shape[1]
    for i in range(first, last, 4):
        i1, i2, i3 = min(i + 1, last - 1), min(i + 2, last - 1), min(i + 3, last - 1)
        one, two, three, four = columns[i], columns[i1], columns[i2], columns[i3]
        for j in range(0, i3 + 1, 4):
            j1, j2, j3 = min(j + 1, i3), min(j + 2, i3), min(j + 3, i3)
            p, q, r, s = columns[j], columns[j1], columns[j2], columns[j3]
            a, b, c, d = _by_four(one, two, three, four, p, q, r, s, n)
            for row, sums in ((i, a), (i1, b), (i2, c), (i3, d)):
                products[row, j] = products[j, row] = sums[0]
                products[row, j1] = products[j1, row] = sums[1]
                products[row, j2] = products[j2, row] = sums[2]
                products[row, j3] = products[j3, row] = sums[3]


@compiled(borrows=True)
def _divided(row, j, p, q, r, s, taken):
    """Four numbers of a row of the factor, from j on, by four rows above; taken: what the numbers before take away."""
    row[j] = (row[j] - taken[0]) * p[j]
    row[j + 1] = (row[j + 1] - taken[1] - row[j] * q[j]) * q[j + 1]
    row[j + 2] = (row[j + 2] - taken[2] - row[j] * r[j] - row[j + 1] * r[j + 1]) * r[j + 2]
    row[j + 3] = (row[j + 3] - taken[3] - row[j] * s[j] - row[j + 1] * s[j + 1] - row[j + 2] * s[j + 2]) * s[j + 3]


@compiled(borrows=True)
def factored(lower, count):
    """Put its Cholesky factor in the place of a matrix; False where it has none. The diagonal is kept inverted."""
    for i in range(0, count, 4):
        end = min(i + 4, count)
        one, two = lower[i], lower[min(i + 1, count - 1)]
        three, four = lower[min(i + 2, count - 1)], lower[min(i + 3, count - 1)]
        for j in range(0, i, 4):
            p, q, r, s = lower[j], lower[j + 1], lower[j + 2], lower[j + 3]
            a, b, c, d = _by_four(one, two, three, four, p, q, r, s, j)
            _divided(one, j, p, q, r, s, a)
            if end > i + 1:
                _divided(two, j, p, q, r, s, b)
            if end > i + 2:
                _divided(three, j, p, q, r, s, c)
            if end > i + 3:
                _divided(four, j, p, q, r, s, d)
        for h in range(i, end):
            row = lower[h]
            for j in range(i, h):
                before = 0.0
                for k in range(j):
                    before += row[k] * lower[j, k]
                row[j] = (row[j] - before) * lower[j, j]
            pivot = row[h]
            for k in range(h):
                pivot -= row[k] * row[k]
            if not pivot > 1e-15 * row[h]:
                return False
            row[h] = 1.0 / math.sqrt(pivot)
    return True


@compiled()
def forward(lower, count, z):
    """Solve L z = z in place."""
    for i in range(count):
        s = 0.0
        for k in range(i):
            s += lower[i, k] * z[k]
        z[i] = (z[i] - s) * lower[i, i]


@compiled()
def backward(lower, count, z):
    """Solve L^T z = z in place."""
    for i in range(count - 1, -1, -1):
        z[i] *= lower[i, i]
        for k in range(i):
            z[k] -= lower[i, k] * z[i]
