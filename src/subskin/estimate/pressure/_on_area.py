"""Hessian and gradient of the pressure on an area, compiled: thousands of elements, of which a touch needs some dozens.

A level holds: columns of pressure and drags (1 or 3, N, n); their products by 1, ty, tz, ty^2, ty tz, tz^2 (1 or 6, N,
N), or none where they are too many; the stencil of K (2, 2); the numbers of elements (ny, nz, rim); cost (N,);
the columns in single precision; the largest column and the area of an element.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled

_SINGLE = 1e-5  # error of a slope in single precision, of the largest column times the residual


@compiled(borrows=True)
def assemble(level, t, w, index, i, row):
    """Row i of the Hessian of the elements `index`, up to its diagonal."""
    parts, grams, stencil, sizes = level[0], level[1], level[2], level[3]
    nz, a = sizes[1], index[i]
    if grams.shape[0] == 0:
        for j in range(i + 1):
            c, s = index[j], 0.0
            if parts.shape[0] == 1:
                for k in range(parts.shape[2]):
                    s += parts[0, a, k] * parts[0, c, k]
            else:
                for k in range(parts.shape[2]):
                    one = parts[0, a, k] + t[0] * parts[1, a, k] + t[1] * parts[2, a, k]
                    s += one * (parts[0, c, k] + t[0] * parts[1, c, k] + t[1] * parts[2, c, k])
            row[j] = s
    else:
        part = grams[0, a]
        for j in range(i + 1):
            row[j] = part[index[j]]
        if grams.shape[0] > 1:
            ty, tz, yy, yz, zz = grams[1, a], grams[2, a], grams[3, a], grams[4, a], grams[5, a]
            for j in range(i + 1):
                c = index[j]
                row[j] += t[0] * (ty[c] + t[0] * yy[c] + t[1] * yz[c]) + t[1] * (tz[c] + t[1] * zz[c])
    # index ascends: neighbours before a are a itself, the one on its left, and three in the line before
    row[i] += w * stencil[0, 0]
    at_z = a % nz
    first = max(a - nz - 1, 0)
    j = i - 1
    while j >= 0 and index[j] >= first:
        c = index[j]
        apart = abs(c % nz - at_z)
        if apart <= 1:
            line = a // nz - c // nz
            if line <= 1:
                row[j] += w * stencil[line, apart]
        j -= 1


@compiled(borrows=True)
def steepest(level, slope, j):
    """Whether no neighbour of the element j has a lesser slope.

    Elements are taken one in a neighbourhood: what lies about one that is taken mostly comes right with it, and would
    else have to be let go again.
    """
    ny, nz = level[3][0], level[3][1]
    y, z = j // nz, j % nz
    for dy in range(-1, 2):
        for dz in range(-1, 2):
            if 0 <= y + dy < ny and 0 <= z + dz < nz and slope[j + dy * nz + dz] < slope[j]:
                return False
    return True


@compiled()
def residual(level, t, b, count, index, x, r):
    """A x - b of the elements `index` into r."""
    parts = level[0]
    for i in range(r.size):
        r[i] = -b[i]
    for k in range(count):
        j = index[k]
        one = x[j]
        for i in range(r.size):
            r[i] += one * parts[0, j, i]
        if parts.shape[0] > 1:
            two, three = one * t[0], one * t[1]
            for i in range(r.size):
                r[i] += two * parts[1, j, i] + three * parts[2, j, i]


@compiled()
def slopes(level, t, w, b, work):
    """Residual A x - b into r and the gradient of J into `slope`, first in single precision.

    Where an element's slope is far uphill that is enough; where it is not, it is found once more.
    """
    parts, stencil, sizes, cost, single, scales = level[0], level[2], level[3], level[4], level[5], level[6]
    _, x, slope, r, _, index, _, _ = work
    ny, nz = sizes[0], sizes[1]
    total, count = x.size, 0
    slope[:] = cost
    for j in range(total):
        if x[j] == 0.0:
            continue
        index[count] = j
        count += 1
        y, z = j // nz, j % nz
        for dy in range(-1, 2):
            for dz in range(-1, 2):
                if 0 <= y + dy < ny and 0 <= z + dz < nz:
                    slope[j + dy * nz + dz] += w * stencil[abs(dy), abs(dz)] * x[j]
    residual(level, t, b, count, index, x, r)
    rough = r.astype(np.float32)
    length = 0.0
    for i in range(r.size):
        length += r[i] * r[i]
    doubt = _SINGLE * scales[0] * math.sqrt(length)
    for j in range(total):
        s = np.float32(0.0)
        for i in range(r.size):
            s += single[0, j, i] * rough[i]
        seen = np.float64(s)
        if parts.shape[0] > 1:
            one = two = np.float32(0.0)
            for i in range(r.size):
                one += single[1, j, i] * rough[i]
                two += single[2, j, i] * rough[i]
            seen += t[0] * np.float64(one) + t[1] * np.float64(two)
        if x[j] == 0.0 and slope[j] + seen > doubt:
            slope[j] += seen
            continue
        seen = 0.0
        for i in range(r.size):
            seen += parts[0, j, i] * r[i]
        if parts.shape[0] > 1:
            for i in range(r.size):
                seen += (t[0] * parts[1, j, i] + t[1] * parts[2, j, i]) * r[i]
        slope[j] += seen
