"""Compiled: whitened readings under unit forces at (y, z), and their slopes, from radial tables.

Tables are those of `RadialResponse.cubics`. Where a reading is N f(u) + (Ty dy + Tz dz) g(u), d from the load to the
sensor, f, g and their slopes in u are all that is kept; else the nine columns are.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled

ROWS = 14
"""Rows of scratch a sensor needs."""
CELLS, ONE, REST = 64.0, np.int64(1023 << 52), np.int64((1 << 46) - 1)
"""Cells of an octave; the bits of 1.0; those that say where in its cell a number is."""
_SHIFT, _EXPONENT = np.int64(46), np.int64(0x7FF << 52)
_FIRST, _TWICE = np.int64(1023 << 6), np.int64(2046 << 52)


@compiled(inline=True)
def cell_of(bits, last):
    """The cell in which a number of these bits lies, the `last` one at most."""
    cell = (bits >> _SHIFT) - _FIRST
    return cell if cell < last else last


@compiled(inline=True)
def coefficients(table, k):
    """The four of f and the four of g in a row of the tables."""
    return table[k, 0], table[k, 1], table[k, 2], table[k, 3], table[k, 4], table[k, 5], table[k, 6], table[k, 7]


@compiled(inline=True)
def field_at(sensors, first, table, terms, y, z, a, whole):
    """Fill a (14, n): 0 dy, 1 dz, 5 f, 6 the slope of f over -2 dy or -2 dz, 7 g, 8 the same of g; or 5 to 13 columns.

    sensors (4, n): y, z, 1 / depth^2, scale; table (kinds cells, 4 functions): powers 0 to 3 of each function in turn;
    first (n + 1,): the first row of each sensor's kind, then the last cell; terms (terms, 5), or none for harmonics
    0 and 1 alone. whole is the same memory as a, as integers.

    The first six digits of v = 1 + u / depth^2 behind its leading one count the cells of an octave, the rest says
    where in the cell (`radial.CELLS`). Where the last cell is the first one, its numbers are those of v^(-3/2) to
    v^(-9/2) (`RadialResponse.series`).
    """
    n = sensors.shape[1]
    last = first[n]
    if last == 0:
        _series(sensors, table, y, z, a)
    else:
        _cells(sensors, first, table, terms, y, z, a, whole)


@compiled(inline=True)
def _series(sensors, table, y, z, a):
    """Rows 0, 1 and 5 to 8 by the series."""
    f0, f1, f2, f3, g0, g1, g2, g3 = coefficients(table, 0)
    for i in range(sensors.shape[1]):
        dy, dz, q = sensors[0, i] - y, sensors[1, i] - z, sensors[2, i]
        x = 1.0 / (1.0 + (dy * dy + dz * dz) * q)
        size = sensors[3, i] * x * math.sqrt(x)
        slope = size * x * q
        a[0, i], a[1, i] = dy, dz
        a[5, i] = size * (f0 + x * (f1 + x * (f2 + x * f3)))
        a[6, i] = slope * (3.0 * f0 + x * (5.0 * f1 + x * (7.0 * f2 + x * (9.0 * f3))))
        a[7, i] = size * (g0 + x * (g1 + x * (g2 + x * g3)))
        a[8, i] = slope * (3.0 * g0 + x * (5.0 * g1 + x * (7.0 * g2 + x * (9.0 * g3))))


@compiled(inline=True)
def _cells(sensors, first, table, terms, y, z, a, whole):
    """All rows by the tables' cells."""
    n = sensors.shape[1]
    last = first[n]
    for i in range(n):
        dy, dz = sensors[0, i] - y, sensors[1, i] - z
        a[0, i], a[1, i] = dy, dz
        a[2, i] = 1.0 + (dy * dy + dz * dz) * sensors[2, i]
    for i in range(n):
        bits = whole[2, i]
        whole[3, i] = first[i] + cell_of(bits, last)
        whole[4, i] = _TWICE - (bits & _EXPONENT)
        whole[2, i] = (bits & REST) | ONE
    if terms.shape[0] == 0:
        for i in range(n):
            k, t = np.uint64(whole[3, i]), a[2, i] * CELLS - (CELLS + 0.5)
            f1, f2, f3 = table[k, 1], table[k, 2], table[k, 3]
            g1, g2, g3 = table[k, 5], table[k, 6], table[k, 7]
            a[5, i], a[6, i] = table[k, 0] + t * (f1 + t * (f2 + t * f3)), f1 + t * (2.0 * f2 + 3.0 * t * f3)
            a[7, i], a[8, i] = table[k, 4] + t * (g1 + t * (g2 + t * g3)), g1 + t * (2.0 * g2 + 3.0 * t * g3)
        for i in range(n):
            scale = sensors[3, i]
            slope = -2.0 * CELLS * scale * a[4, i] * sensors[2, i]
            a[5, i], a[6, i], a[7, i], a[8, i] = scale * a[5, i], slope * a[6, i], scale * a[7, i], slope * a[8, i]
    else:
        _harmonics(sensors, table, terms, a, whole)


@compiled(borrows=True)
def _harmonics(sensors, table, terms, a, whole):
    """Rows 5 to 7 the readings under unit N, Ty, Tz, 8 to 10 their slopes in y, 11 to 13 in z, of any harmonics."""
    for i in range(sensors.shape[1]):
        for row in range(5, 14):
            a[row, i] = 0.0
        k, t, dy, dz = whole[3, i], a[2, i] * CELLS - (CELLS + 0.5), a[0, i], a[1, i]
        steep = 2.0 * CELLS * a[4, i] * sensors[2, i]
        for j in range(terms.shape[0]):
            row, order, part, scale = 5 + terms[j, 0], terms[j, 1], terms[j, 2], sensors[3, i] * terms[j, 4]
            e = 4 * terms[j, 3]
            c1, c2, c3 = table[k, e + 1], table[k, e + 2], table[k, e + 3]
            f = scale * (table[k, e] + t * (c1 + t * (c2 + t * c3)))
            df = scale * steep * (c1 + t * (2.0 * c2 + 3.0 * t * c3))
            re, im, below_re, below_im = 1.0, 0.0, 0.0, 0.0  # zeta^order and zeta^(order - 1)
            for _ in range(order):
                below_re, below_im = re, im
                re, im = re * dy - im * dz, re * dz + im * dy
            shape = im if part else re
            by_y = order * (below_im if part else below_re)
            by_z = order * (below_re if part else -below_im)
            a[row, i] += f * shape
            a[3 + row, i] -= df * dy * shape + f * by_y
            a[6 + row, i] -= df * dz * shape + f * by_z
