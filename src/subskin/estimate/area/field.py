"""Compiled: whitened readings under unit forces at (y, z), and their slopes, from radial tables."""

from __future__ import annotations

import numpy as np

from ..._compiled import compiled

_SHIFT, _ONE, _EXPONENT = np.int64(48), np.int64(1023 << 52), np.int64(0x7FF << 52)
_REST, _FIRST, _TWICE = np.int64((1 << 48) - 1), np.int64(1023 << 4), np.int64(2046 << 52)


@compiled(inline=True)
def _cells(sensors, first, size, y, z, last, a, whole):
    """Of each sensor: the two parts of delta, where the coefficients of its cell begin, how far in it, and dt/du.

    The first four digits of v = 1 + u / depth^2 behind its leading one count the cells of an octave, the rest says
    where in the cell (`radial.PER_OCTAVE`). first: where the table of its kind begins; size: numbers a cell.
    """
    n = sensors.shape[1]
    for i in range(n):
        dy, dz = sensors[0, i] - y, sensors[1, i] - z
        a[9, i], a[10, i] = dy, dz
        a[11, i] = 1.0 + (dy * dy + dz * dz) * sensors[2, i]
    for i in range(n):
        bits = whole[11, i]
        cell = (bits >> _SHIFT) - _FIRST
        whole[12, i] = first[i] + size * (cell if cell < last else last)
        whole[13, i] = _TWICE - (bits & _EXPONENT)
        whole[11, i] = (bits & _REST) | _ONE
    for i in range(n):
        a[11, i] = (a[11, i] - 1.0) * 16.0 - 0.5
        a[13, i] *= 32.0 * sensors[2, i]


@compiled()
def field_at(sensors, first, flat, terms, y, z, a, whole):
    """Fill a: rows 0 to 2 the readings under unit N, Ty, Tz at (y, z), 3 to 5 their slopes in y, 6 to 8 in z.

    sensors (4, n): y, z, 1 / depth^2, scale; flat: the tables (kinds, cells, functions, 6) one number after the other;
    first (n + 2,): where each sensor's kind begins in them, then how many numbers a cell has, and the last cell;
    terms (terms, 5), or none for harmonics 0 and 1 alone. a (18, n), whole the same memory as integers.
    """
    n = sensors.shape[1]
    _cells(sensors, first, first[n], y, z, first[n + 1], a, whole)
    if terms.shape[0] == 0:
        for i in range(n):
            k, t = whole[12, i], a[11, i]
            f = df = g = dg = 0.0
            for j in range(5, -1, -1):
                df, dg = df * t + f, dg * t + g
                f, g = f * t + flat[k + j], g * t + flat[k + 6 + j]
            a[14, i], a[15, i], a[16, i], a[17, i] = f, df, g, dg
        for i in range(n):
            dy, dz, scale = a[9, i], a[10, i], sensors[3, i]
            slope = -scale * a[13, i]
            g, df, dg = scale * a[16, i], slope * a[15, i], slope * a[17, i]
            a[0, i], a[1, i], a[2, i] = scale * a[14, i], dy * g, dz * g
            a[3, i], a[6, i] = dy * df, dz * df
            cross = dy * dz * dg
            a[4, i], a[5, i], a[7, i], a[8, i] = dy * dy * dg - g, cross, cross, dz * dz * dg - g
        return
    for i in range(n):
        for row in range(9):
            a[row, i] = 0.0
        t, slope, dy, dz = a[11, i], a[13, i], a[9, i], a[10, i]
        for j in range(terms.shape[0]):
            row, order, part, scale = terms[j, 0], terms[j, 1], terms[j, 2], sensors[3, i] * terms[j, 4]
            k = whole[12, i] + 6 * terms[j, 3]
            f = df = 0.0
            for e in range(5, -1, -1):
                df = df * t + f
                f = f * t + flat[k + e]
            f, df = scale * f, scale * slope * df
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
