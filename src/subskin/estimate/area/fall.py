"""Compiled: how far S falls round its top, at eight positions at once.

Near the top a sensor's functions of the distance are cubics in 1 / v (`field.py`), about the middle of the cell in
which v lies at the top: where readings fall off with a power of the distance, as they do, these hold far beyond the
cell; a series that holds at all distances is asked itself. Sums run over what the best load leaves of the readings, so
that no digits are lost.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from .climb import ROUND, project, slopes
from .cone import cofactors, on_cone
from .field import CELLS, ONE, REST, cell_of

LANES = 136
"""Numbers of scratch, eight a row: fall, room in the cone, y, z, chi-square left, A^T rho (3), A^T A (6); then the sums
of `beyond_near`."""
_OTHERS = 112
_MIDDLE, _DIGITS = np.int64(1 << 45), np.int64((1 << 52) - 1)


@compiled(borrows=True)
def beyond_near(v, sensors, first, table, terms, mu, fit, a, whole, trial, lanes):
    """What sensors that are not in v add to the sums at the top, where nothing binds the forces, into lanes[112:133].

    These are chi-square left, A^T rho (3), A^T A (6), U^T rho (2), U^T U (3), A^T U (6); rho is what the load leaves.
    """
    project(v, sensors, first, table, terms, mu, fit[29], fit[30], a, whole, trial)
    trial[0], trial[1], trial[2] = fit[0], fit[1], fit[2]
    slopes(v, terms, a, trial)
    b0 = b1 = b2 = 0.0
    for i in range(v.size):
        a1, a2 = a[0, i] * a[7, i], a[1, i] * a[7, i]
        rho = v[i] - a[5, i] * fit[0] - a1 * fit[1] - a2 * fit[2]
        b0 += a[5, i] * rho
        b1 += a1 * rho
        b2 += a2 * rho
    others = lanes[_OTHERS:]
    others[0], others[1], others[2], others[3] = fit[17] - trial[17], -b0, -b1, -b2
    for j in range(6):
        others[4 + j] = fit[11 + j] - trial[11 + j]
    for j in range(11):
        others[10 + j] = fit[18 + j] - trial[18 + j]


@compiled(borrows=True)
def falls(v, sensors, first, table, mu, box, fit, root, reach, a, whole, trial, best, lanes):
    """How much lower S is than at the top in fit, `reach` standard deviations round it: into lanes[:8]; and the least.

    root: Cholesky's of the covariance of (y, z), three numbers; lanes: as of `LANES`. A position higher than that in
    `best` goes there. Outside the box S is taken to fall as at the top.
    """
    n, ty, tz = fit[0], fit[1], fit[2]
    for k in range(8):
        c, s = reach * ROUND[k, 0], reach * ROUND[k, 1]
        dy, dz = root[0] * c, root[1] * c + root[2] * s
        lanes[16 + k], lanes[24 + k] = fit[29] + dy, fit[30] + dz
        curved = lanes[124] * dy * dy + 2.0 * lanes[125] * dy * dz + lanes[126] * dz * dz
        lanes[32 + k] = lanes[112] - 2.0 * (lanes[122] * dy + lanes[123] * dz) + curved
        for j in range(3):
            lanes[40 + 8 * j + k] = lanes[113 + j] - lanes[127 + j] * dy - lanes[130 + j] * dz
        for j in range(6):
            lanes[64 + 8 * j + k] = lanes[116 + j]
    one = first[v.size] == 0
    if not one:
        for i in range(v.size):
            dy, dz = sensors[0, i] - fit[29], sensors[1, i] - fit[30]
            a[0, i] = 1.0 + (dy * dy + dz * dz) * sensors[2, i]
        for i in range(v.size):
            bits = whole[0, i]
            whole[1, i] = first[i] + cell_of(bits, first[v.size])
            middle = (bits & ~REST) | _MIDDLE
            whole[0, i], whole[2, i] = middle, (middle & _DIGITS) | ONE
    for i in range(v.size):
        row, scale, r = 0 if one else whole[1, i], sensors[3, i], v[i]
        y, z, q = sensors[0, i], sensors[1, i], sensors[2, i]
        f0, f1, f2, f3 = scale * table[row, 0], scale * table[row, 1], scale * table[row, 2], scale * table[row, 3]
        g0, g1, g2, g3 = scale * table[row, 4], scale * table[row, 5], scale * table[row, 6], scale * table[row, 7]
        middle, less = 1.0, 0.0
        if not one:
            middle, less, share = a[0, i], 1.0, CELLS * a[2, i]
            cube = share * share * share
            f1, f2, g1, g2 = share * f1, share * share * f2, share * g1, share * share * g2
            f1, f2, f3 = -f1, f1 + f2, -(f1 + 2.0 * f2 + cube * f3)
            g1, g2, g3 = -g1, g1 + g2, -(g1 + 2.0 * g2 + cube * g3)
        for k in range(8):
            dy, dz = y - lanes[16 + k], z - lanes[24 + k]
            x = middle / (1.0 + (dy * dy + dz * dz) * q) - less
            size = x * math.sqrt(x) if one else 1.0
            a0, g = size * (f0 + x * (f1 + x * (f2 + x * f3))), size * (g0 + x * (g1 + x * (g2 + x * g3)))
            a1, a2 = dy * g, dz * g
            rho = r - a0 * n - a1 * ty - a2 * tz
            lanes[32 + k] += rho * rho
            lanes[40 + k] += a0 * rho
            lanes[48 + k] += a1 * rho
            lanes[56 + k] += a2 * rho
            lanes[64 + k] += a0 * a0
            lanes[72 + k] += a0 * a1
            lanes[80 + k] += a0 * a2
            lanes[88 + k] += a1 * a1
            lanes[96 + k] += a1 * a2
            lanes[104 + k] += a2 * a2
    for k in range(lanes.size // 17):
        b0, b1, b2 = lanes[40 + k], lanes[48 + k], lanes[56 + k]
        g00, g01, g02 = lanes[64 + k], lanes[72 + k], lanes[80 + k]
        g11, g12, g22 = lanes[88 + k], lanes[96 + k], lanes[104 + k]
        c00, c01, c02, c11, c12, c22, det = cofactors(g00, g01, g02, g11, g12, g22)
        inverse = 1.0 / det
        m = (c00 * b0 + c01 * b1 + c02 * b2) * inverse
        my = (c01 * b0 + c11 * b1 + c12 * b2) * inverse
        mz = (c02 * b0 + c12 * b1 + c22 * b2) * inverse
        lanes[k] = lanes[32 + k] - (b0 * m + b1 * my + b2 * mz) - fit[17]
        sy, sz, most = ty + my, tz + mz, mu * (n + m)
        lanes[8 + k] = min(det - 1e-13 * g00 * g11 * g22, n + m, most * most - sy * sy - sz * sz)
    least = reach * reach
    for k in range(8):
        y, z = lanes[16 + k], lanes[24 + k]
        if not (box[0] <= y <= box[1] and box[2] <= z <= box[3]):
            lanes[k] = reach * reach
            continue
        if not lanes[8 + k] >= 0.0:  # the cone binds
            b0, b1, b2 = lanes[40 + k], lanes[48 + k], lanes[56 + k]
            g00, g01, g02 = lanes[64 + k], lanes[72 + k], lanes[80 + k]
            g11, g12, g22 = lanes[88 + k], lanes[96 + k], lanes[104 + k]
            w0 = b0 + g00 * n + g01 * ty + g02 * tz
            w1 = b1 + g01 * n + g11 * ty + g12 * tz
            w2 = b2 + g02 * n + g12 * ty + g22 * tz
            on_cone(g00, g01, g02, g11, g12, g22, w0, w1, w2, mu, ty, tz, trial)
            gain = trial[3] - n * (b0 + w0) - ty * (b1 + w1) - tz * (b2 + w2)
            lanes[k] = lanes[32 + k] - gain - fit[17]
        if fit[3] - lanes[k] > best[3]:
            best[3], best[29], best[30] = fit[3] - lanes[k], y, z
        least = min(least, lanes[k])
    return least
