"""Hessian and gradient of the pressure on an area, compiled: thousands of elements, of which a touch needs some dozens.

A level holds: tables of pressure and drags one behind another (1 or 3, L); where a sensor's begins in them, the length
of its rows and its gain, each up to a multiple of eight sensors (`hats.Hats.flat`); the stencil of K (2, 2); the
numbers of elements (ny, nz, rim); cost (N,); the area of an element and the largest column.

The work of an area: the tables at the drag (L,); x, gradient (N,); residual (n,); factor (C, C); numbers and values of
what is > 0 (N,) twice, and scratch (N,); columns of elements by part (1 or 3, C, n), at the drag (C, n), and their
products (C, C); in which row of the first an element is (N + 1,), in which of the second (N + 1,), -1 for none, behind
them how many rows are taken; and the residual times the gains, up to a multiple of eight.
"""

from __future__ import annotations

from ..._compiled import compiled
from .hats import TOGETHER


@compiled(borrows=True)
def lean(level, t, work):
    """Go to the drag t: columns at another one, and their products, no longer hold."""
    parts, table, place = level[0], work[0], work[12]
    if parts.shape[0] == 1:
        for i in range(table.size):
            table[i] = parts[0, i]
    else:
        for i in range(table.size):
            table[i] = parts[0, i] + t[0] * parts[1, i] + t[1] * parts[2, i]
    for j in range(place.size - 1):
        place[j] = -1
    place[place.size - 1] = 0


@compiled(borrows=True)
def forget(work):
    """Take no columns as known."""
    rows = work[11]
    for j in range(rows.size - 1):
        rows[j] = -1
    rows[rows.size - 1] = 0


@compiled(borrows=True)
def crowded(work):
    """Whether there was no room for all columns that were asked for."""
    rows, room = work[11], len(work[9])
    return room < rows.size - 1 and rows[rows.size - 1] == room


@compiled(borrows=True)
def _column(level, work, j):
    """The row in which the columns of the element j are by part, or -1 where there is no room."""
    parts, start, length, gain, nz = level[0], level[1], level[2], level[3], level[5][1]
    own, rows = work[8], work[11]
    if rows[j] < 0:
        row = rows[rows.size - 1]
        if row == own.shape[1]:
            return -1
        rows[j], rows[rows.size - 1] = row, row + 1
        y, z = j // nz, j % nz
        for part in range(parts.shape[0]):
            for i in range(own.shape[2]):
                own[part, row, i] = gain[i] * parts[part, start[i] + y * length[i] + z]
    return rows[j]


@compiled(borrows=True)
def _products(columns, products, first, last):
    """Products of the columns from `first` to `last` with each other and with all before, by two and four of them."""
    n = columns.shape[1]
    for a in range(first, last, 2):
        b = min(a + 1, last - 1)
        one, two = columns[a], columns[b]
        for c in range(0, b + 1, 4):
            d, e, f = min(c + 1, b), min(c + 2, b), min(c + 3, b)
            p, q, r, s = columns[c], columns[d], columns[e], columns[f]
            ap = aq = ar = at = bp = bq = br = bt = 0.0
            for k in range(n):
                u, v = one[k], two[k]
                ap += u * p[k]
                aq += u * q[k]
                ar += u * r[k]
                at += u * s[k]
                bp += v * p[k]
                bq += v * q[k]
                br += v * r[k]
                bt += v * s[k]
            products[a, c] = products[c, a] = ap
            products[a, d] = products[d, a] = aq
            products[a, e] = products[e, a] = ar
            products[a, f] = products[f, a] = at
            products[b, c] = products[c, b] = bp
            products[b, d] = products[d, b] = bq
            products[b, e] = products[e, b] = br
            products[b, f] = products[f, b] = bt


@compiled(borrows=True)
def hessian(level, t, w, work, count):
    """The Hessian of the elements in `index` into the factor, up to its diagonal; False where there is no room."""
    stencil, nz = level[4], level[5][1]
    lower, index, own, columns, products, place = work[4], work[5], work[8], work[9], work[10], work[12]
    if count > len(lower):
        work[11][work[11].size - 1] = len(lower)
        return False
    first = place[place.size - 1]
    for k in range(count):
        j = index[k]
        if place[j] >= 0:
            continue
        row, at = _column(level, work, j), place[place.size - 1]
        if row < 0:
            return False
        place[j], place[place.size - 1] = at, at + 1
        if own.shape[0] == 1:
            for i in range(own.shape[2]):
                columns[at, i] = own[0, row, i]
        else:
            for i in range(own.shape[2]):
                columns[at, i] = own[0, row, i] + t[0] * own[1, row, i] + t[1] * own[2, row, i]
    _products(columns, products, first, place[place.size - 1])
    for i in range(count):
        a, row = index[i], lower[i]
        part = products[place[a]]
        for k in range(i + 1):
            row[k] = part[place[index[k]]]
        # index ascends: neighbours before a are a itself, the one on its left, and three in the line before
        row[i] += w * stencil[0, 0]
        before = max(a - nz - 1, 0)
        k = i - 1
        while k >= 0 and index[k] >= before:
            c = index[k]
            apart = abs(c % nz - a % nz)
            line = a // nz - c // nz
            if apart <= 1 and line <= 1:
                row[k] += w * stencil[line, apart]
            k -= 1
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
def seen(level, work, r, sign, out):
    """Add to `out` (N,) every column at the drag times `sign` r (n,)."""
    start, length, gain, sizes = level[1], level[2], level[3], level[5]
    table, pull = work[0], work[13]
    nz = sizes[1]
    for i in range(pull.size):
        pull[i] = sign * gain[i] * r[i] if i < r.size else 0.0
    for y in range(sizes[0]):
        for g in range(0, pull.size, TOGETHER):
            a, b, c, d = pull[g], pull[g + 1], pull[g + 2], pull[g + 3]
            e, f, h, k = pull[g + 4], pull[g + 5], pull[g + 6], pull[g + 7]
            i, j = start[g] + y * length[g], start[g + 1] + y * length[g + 1]
            m, n = start[g + 2] + y * length[g + 2], start[g + 3] + y * length[g + 3]
            p, q = start[g + 4] + y * length[g + 4], start[g + 5] + y * length[g + 5]
            u, v = start[g + 6] + y * length[g + 6], start[g + 7] + y * length[g + 7]
            for z in range(nz):
                one = a * table[i + z] + b * table[j + z] + c * table[m + z] + d * table[n + z]
                two = e * table[p + z] + f * table[q + z] + h * table[u + z] + k * table[v + z]
                out[y * nz + z] += one + two


@compiled(borrows=True)
def slopes(level, w, b, work):
    """Residual A x - b into r and the gradient of J into `slope`; every element that is > 0 is in the Hessian."""
    stencil, sizes, cost = level[4], level[5], level[6]
    x, slope, r, columns, place = work[1], work[2], work[3], work[9], work[12]
    ny, nz = sizes[0], sizes[1]
    for i in range(r.size):
        r[i] = -b[i]
    for j in range(x.size):
        slope[j] = cost[j]
    for j in range(x.size):
        if x[j] == 0.0:
            continue
        y, z, one = j // nz, j % nz, x[j]
        for dy in range(-1, 2):
            for dz in range(-1, 2):
                if 0 <= y + dy < ny and 0 <= z + dz < nz:
                    slope[j + dy * nz + dz] += w * stencil[abs(dy), abs(dz)] * one
        column = columns[place[j]]
        for i in range(r.size):
            r[i] += one * column[i]
    seen(level, work, r, 1.0, slope)
