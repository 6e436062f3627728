"""Hessian and gradient of the pressure on an area, compiled: thousands of elements, of which a touch needs some dozens.

A level holds: tables of pressure and drags in a line (1 or 3, L), where a sensor's begins in it and its gain, both up
to a multiple of `AT_ONCE` sensors, and the length of a row (`hats.Hats.flat`); the stencil of K (2, 2); the numbers of
elements (ny, nz, rim); cost (N,); the area of an element and the largest column.

The work of an area: the line at the drag (L,); x, gradient (N,); residual (n,); factor (C, C); numbers and values of
what is > 0 (N,) twice, and scratch (N,); readings of elements' drags in single precision (0 or 2, C, n), columns at the
drag (C, n), and their products (C, C); in which row of the first an element is (N + 1,), in which of the second
(N + 2,), -1 for none, behind them how many rows are taken, and of the second how many are multiplied; and in single
precision the line at the drag, the residual times the gains, and some columns times this; directions in which x stays
(C, C), in which row of the second columns each of what is > 0 is (N,), and these columns in single precision (C, n).
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ._windows import windows
from .hats import LANES, REGISTERS

_SINGLE = 2e-5  # error of a slope in single precision, of the largest column times the residual


@compiled(borrows=True)
def lean(level, t, work):
    """Go to the drag t: columns at another one, and their products, no longer hold."""
    parts, line, order, single = level[0], work[0], work[12], work[13]
    if parts.shape[0] == 1:
        for i in range(line.size):
            line[i] = parts[0, i]
    else:
        for i in range(line.size):
            line[i] = parts[0, i] + t[0] * parts[1, i] + t[1] * parts[2, i]
    for i in range(line.size):
        single[i] = line[i]
    for j in range(order.size - 2):
        order[j] = -1
    order[order.size - 2] = order[order.size - 1] = 0


@compiled(borrows=True)
def forget(work):
    """Take no columns as known."""
    rows = work[11]
    for j in range(rows.size - 1):
        rows[j] = -1
    rows[rows.size - 1] = 0


@compiled(borrows=True)
def unmultiplied(work):
    """Take no products as known."""
    order = work[12]
    order[order.size - 1] = 0


@compiled(borrows=True)
def crowded(work):
    """Whether there was no room for all columns that were asked for."""
    rows, room = work[11], len(work[9])
    return room < rows.size - 1 and rows[rows.size - 1] == room


@compiled(inline=True)
def by_four(one, two, three, four, p, q, r, s, count):
    """Products of each of four rows with each of four: each number is fetched a quarter as often."""
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
    return ap, aq, ar, at, bp, bq, br, bt, cp, cq, cr, ct, dp, dq, dr, dt


@compiled(borrows=True)
def multiply(columns, products, first, last):
    """Products of the columns from `first` to `last` with each other and with all before, by four and four of them."""
    n = columns.shape[1]
    for i in range(first, last, 4):
        i1, i2, i3 = min(i + 1, last - 1), min(i + 2, last - 1), min(i + 3, last - 1)
        one, two, three, four = columns[i], columns[i1], columns[i2], columns[i3]
        for j in range(0, i3 + 1, 4):
            j1, j2, j3 = min(j + 1, i3), min(j + 2, i3), min(j + 3, i3)
            p, q, r, s = columns[j], columns[j1], columns[j2], columns[j3]
            ap, aq, ar, at, bp, bq, br, bt, cp, cq, cr, ct, dp, dq, dr, dt = by_four(
                one, two, three, four, p, q, r, s, n
            )
            products[i, j] = products[j, i] = ap
            products[i, j1] = products[j1, i] = aq
            products[i, j2] = products[j2, i] = ar
            products[i, j3] = products[j3, i] = at
            products[i1, j] = products[j, i1] = bp
            products[i1, j1] = products[j1, i1] = bq
            products[i1, j2] = products[j2, i1] = br
            products[i1, j3] = products[j3, i1] = bt
            products[i2, j] = products[j, i2] = cp
            products[i2, j1] = products[j1, i2] = cq
            products[i2, j2] = products[j2, i2] = cr
            products[i2, j3] = products[j3, i2] = ct
            products[i3, j] = products[j, i3] = dp
            products[i3, j1] = products[j1, i3] = dq
            products[i3, j2] = products[j2, i3] = dr
            products[i3, j3] = products[j3, i3] = dt


@compiled(borrows=True)
def gather(level, work, count, every):
    """The columns at the line's drag of the elements in `index`, or of those whose x is not 0; False without room."""
    parts, start, gain, length, nz = level[0], level[1], level[2], level[3], level[5][1]
    line, x, index, own, columns, rows, order = work[0], work[1], work[5], work[8], work[9], work[11], work[12]
    n = columns.shape[1]
    for k in range(count):
        j = index[k]
        if order[j] >= 0 or (x[j] == 0.0 and not every):
            continue
        first = j // nz * length + j % nz
        if rows[j] < 0:
            row = rows[rows.size - 1]
            if row == len(columns):
                return False
            rows[j], rows[rows.size - 1] = row, row + 1
            if parts.shape[0] > 1:
                for i in range(n):
                    at = start[i] + first
                    own[0, row, i] = gain[i] * parts[1, at]
                    own[1, row, i] = gain[i] * parts[2, at]
        at = order[order.size - 2]
        order[j], order[order.size - 2] = at, at + 1
        for i in range(n):
            columns[at, i] = gain[i] * line[start[i] + first]
    return True


@compiled(borrows=True)
def hessian(level, w, exact, work, count):
    """The Hessian of the elements in `index` into the factor, up to its diagonal; False where there is no room.

    exact: whether products that are not known yet are made in double precision.
    """
    stencil, nz = level[4], level[5][1]
    lower, index, columns, products, order, slot, short = (
        work[4], work[5], work[9], work[10], work[12], work[17], work[18],
    )  # fmt: skip
    if count > len(lower):
        work[11][work[11].size - 1] = len(lower)
        return False
    if not gather(level, work, count, True):
        return False
    first, last = order[order.size - 1], order[order.size - 2]
    if exact:
        multiply(columns, products, first, last)
    else:
        for at in range(first, last):
            for i in range(columns.shape[1]):
                short[at, i] = columns[at, i]
        multiply(short, products, first, last)
    order[order.size - 1] = last
    for i in range(count):
        slot[i] = order[index[i]]
    before = 0
    for i in range(count):
        a, row, part = index[i], lower[i], products[slot[i]]
        for k in range(i + 1):
            row[k] = part[slot[k]]
        # index ascends: neighbours before a are a itself, the one on its left, and three in the line before
        row[i] += w * stencil[0, 0]
        z = a % nz
        if z > 0 and i > 0 and index[i - 1] == a - 1:
            row[i - 1] += w * stencil[0, 1]
        while index[before] < a - nz - 1:
            before += 1
        for k in range(before, min(before + 3, i)):
            apart = index[k] - (a - nz)
            if apart <= 1 and 0 <= z + apart < nz:
                row[k] += w * stencil[1, abs(apart)]
    return True


@compiled(borrows=True)
def steepest(level, slope, j):
    """Whether no neighbour of the element j has a lesser slope.

    Elements are taken one in a neighbourhood: what lies about one that is taken mostly comes right with it, and would
    else have to be let go again.
    """
    ny, nz = level[5][0], level[5][1]
    y, z = j // nz, j % nz
    for dy in range(-1, 2):
        for dz in range(-1, 2):
            if 0 <= y + dy < ny and 0 <= z + dz < nz and slope[j + dy * nz + dz] < slope[j]:
                return False
    return True


@compiled(borrows=True)
def seen(level, line, r, j):
    """The column of the element j, from a line of the tables, times r (n,)."""
    start, gain, nz = level[1], level[2], level[5][1]
    at, s = j // nz * level[3] + j % nz, 0.0
    for i in range(r.size):
        s += gain[i] * r[i] * line[start[i] + at]
    return s


@compiled(borrows=True)
def roughly(level, line, pull, field, r, out):
    """Add to `out` (N,) every column, from a line in single precision, times r (n,); how far that may be off.

    pull, field: scratch, as in the work of an area.
    """
    start, gain, length, sizes, largest = level[1], level[2], level[3], level[5], level[8]
    size = 0.0
    for i in range(r.size):
        size += r[i] * r[i]
    size = math.sqrt(size)
    if size == 0.0:
        return 0.0
    for i in range(pull.size):
        pull[i] = gain[i] * r[i] / size if i < r.size else 0.0
    nz = sizes[1]
    for y in range(sizes[0]):
        for z in range(0, nz, LANES * REGISTERS):
            many = min(nz - z, LANES * REGISTERS)
            windows(line, start, pull, y * length + z, (many + LANES - 1) // LANES, field)
            for k in range(many):
                out[y * nz + z + k] += size * np.float64(field[k])
    return _SINGLE * size * largest


@compiled(borrows=True)
def residual(b, work):
    """A x - b into r; the columns of all that is not 0 are gathered."""
    x, r, columns, order, slot = work[1], work[3], work[9], work[12], work[17]
    for i in range(r.size):
        r[i] = -b[i]
    many = 0
    for j in range(x.size):
        slot[many] = j
        many += x[j] != 0.0
    for k in range(0, many, 4):  # four columns at once: r is fetched a quarter as often
        more = min(4, many - k)
        one, p = columns[order[slot[k]]], x[slot[k]]
        two, q = (columns[order[slot[k + 1]]], x[slot[k + 1]]) if more > 1 else (one, 0.0)
        three, u = (columns[order[slot[k + 2]]], x[slot[k + 2]]) if more > 2 else (one, 0.0)
        four, v = (columns[order[slot[k + 3]]], x[slot[k + 3]]) if more > 3 else (one, 0.0)
        for i in range(r.size):
            r[i] += p * one[i] + q * two[i] + (u * three[i] + v * four[i])


@compiled(borrows=True)
def slopes(level, w, work):
    """The gradient of J at the residual into `slope`; the columns of all that is not 0 are gathered.

    Where an element is not > 0 and its slope far from level, single precision is enough; where not, it is found again.
    """
    stencil, sizes, cost = level[4], level[5], level[6]
    x, slope, r, spread, columns, order = work[1], work[2], work[3], work[7], work[9], work[12]
    ny, nz = sizes[0], sizes[1]
    for j in range(x.size):
        spread[j] = cost[j]
    for j in range(x.size):
        if x[j] == 0.0:
            continue
        y, z, one = j // nz, j % nz, x[j]
        for dy in range(-1, 2):
            for dz in range(-1, 2):
                if 0 <= y + dy < ny and 0 <= z + dz < nz:
                    spread[j + dy * nz + dz] += w * stencil[abs(dy), abs(dz)] * one
    for j in range(x.size):
        slope[j] = spread[j]
    doubt = roughly(level, work[13], work[14], work[15], r, slope)
    for j in range(x.size):
        if x[j] != 0.0:
            column, s = columns[order[j]], spread[j]
            for i in range(r.size):
                s += column[i] * r[i]
            slope[j] = s
        elif abs(slope[j]) <= doubt:
            slope[j] = spread[j] + seen(level, work[0], r, j)
