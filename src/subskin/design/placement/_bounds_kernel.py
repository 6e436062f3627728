"""Compiled: a row's receptive field, and the bounds of Cramer and Rao for touches on it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._compiled import compiled
from ...estimate.kinds import LINE_ROWS, Along, Line, line_field

_SINGULAR = 1e-24
_UNTOLD = 1e6


class Grams(NamedTuple):
    """Products of a row's field: of A with A (k), of A with its slope (m), of the slope with itself (h)."""

    k11: float
    k12: float
    k22: float
    m11: float
    m12: float
    m21: float
    m22: float
    h11: float
    h12: float
    h22: float


class Bounds(NamedTuple):
    """Fisher information of position u, logarithm of the force f and angle a, its determinant; and the variances.

    Those are infinite where they are beyond all sense: there the Jacobian is singular, but for the rounding of the
    table.
    """

    uu: float
    uf: float
    ua: float
    ff: float
    fa: float
    aa: float
    det: float
    position: float
    force: float
    angle: float


@compiled()
def row_table(field, field_start, field_step, positions, start, step, table):
    """Fill `table` (cells, 5, 2, n): a row's receptive field from that of one sensor at y = 0.

    field (c, 5, 2): of one sensor; positions (n,) of each. Both are polynomials of degree 4 in a cell; those of the row
    go through five points of each cell.
    """
    cells, _, _, n = table.shape
    most, v = field.shape[0], np.empty(5)
    for cell in range(cells):
        centre = start + step * (cell + 0.5)
        for i in range(n):
            for side in range(2):
                for node in range(5):
                    t = (centre + (node - 2) * 0.25 * step - positions[i] - field_start) / field_step
                    k = min(max(int(t), 0), most - 1)
                    t -= k + 0.5
                    f = field[k]
                    v[node] = f[0, side] + t * (f[1, side] + t * (f[2, side] + t * (f[3, side] + t * f[4, side])))
                # the polynomial through values at t = -1/2, -1/4, 0, 1/4, 1/2
                odd1, odd2 = 0.5 * (v[3] - v[1]), 0.5 * (v[4] - v[0])
                even1, even2 = 0.5 * (v[3] + v[1]) - v[2], 0.5 * (v[4] + v[0]) - v[2]
                table[cell, 0, side, i] = v[2]
                table[cell, 1, side, i] = (16.0 * odd1 - 2.0 * odd2) / 3.0
                table[cell, 2, side, i] = (64.0 * even1 - 4.0 * even2) / 3.0
                table[cell, 3, side, i] = (32.0 * odd2 - 64.0 * odd1) / 3.0
                table[cell, 4, side, i] = (64.0 * even2 - 256.0 * even1) / 3.0


@compiled()
def _grams(a):
    """Products of rows of a: the field A, normal and tangential, and its slope, as `line_field` has them."""
    k11 = k12 = k22 = m11 = m12 = m21 = m22 = h11 = h12 = h22 = 0.0
    for i in range(a.shape[1]):
        an, at, dn, dt = a[0, i], a[1, i], a[2, i], a[3, i]
        k11 += an * an
        k12 += an * at
        k22 += at * at
        m11 += an * dn
        m12 += an * dt
        m21 += at * dn
        m22 += at * dt
        h11 += dn * dn
        h12 += dn * dt
        h22 += dt * dt
    return Grams(k11, k12, k22, m11, m12, m21, m22, h11, h12, h22)


@compiled()
def _bounds(grams, c, s, mu, farthest):
    """`Bounds` of a touch with normal and tangential force c and s."""
    k11, k12, k22, m11, m12, m21, m22, h11, h12, h22 = grams
    ff = k11 * c * c + 2 * k12 * c * s + k22 * s * s
    uu = h11 * c * c + 2 * h12 * c * s + h22 * s * s
    u1, u2 = m11 * c + m12 * s, m21 * c + m22 * s
    uf, ua = u1 * c + u2 * s, u2 * c - u1 * s
    fa = c * s * (k22 - k11) + k12 * (c * c - s * s)
    aa = k11 * s * s - 2 * k12 * c * s + k22 * c * c
    ff_aa = ff * aa - fa * fa
    if mu > 0.0:
        det = uu * ff_aa - uf * (uf * aa - ua * fa) + ua * (uf * fa - ua * ff)
        inverse = 1.0 / det
        v_y, v_f, v_a = ff_aa * inverse, (uu * aa - ua * ua) * inverse, (uu * ff - uf * uf) * inverse
    else:  # the angle is known
        det = uu * ff - uf * uf
        v_y, v_f, v_a = ff / det, uu / det, 0.0
    if not (det > 0.0 and ff_aa >= 0.0):
        v_y = v_f = v_a = math.inf
    v_y = v_y if 0.0 <= v_y < _UNTOLD * farthest * farthest else math.inf
    v_f = v_f if 0.0 <= v_f < _UNTOLD else math.inf
    v_a = v_a if 0.0 <= v_a < _UNTOLD else math.inf
    return Bounds(uu, uf, ua, ff, fa, aa, det, v_y, v_f, v_a)


@compiled()
def uphill(table, start, step, mu, force, which, touch, size, ends):
    """Largest standard deviation of position, force or angle (`which` 0, 1, 2) uphill from a touch.

    touch, size (2,): position and angle to begin with, and first step of each; ends (2, 2): of both. The nearest eight
    are tried, then steps halve; at a singular touch the way up ends in infinity or, between two floats, far up.
    """
    model = Line(table, start, step, np.empty((LINE_ROWS, table.shape[3])))
    farthest = step * table.shape[0]
    best = -1.0
    y, angle, dy, da = touch[0], touch[1], size[0], size[1]
    for _ in range(400):
        here_y, here_angle = y, angle
        for q in range(9):
            at = min(max(here_y + (q // 3 - 1) * dy, ends[0, 0]), ends[0, 1])
            lean = min(max(here_angle + (q % 3 - 1) * da, ends[1, 0]), ends[1, 1])
            line_field(model, Along(at))
            told = _bounds(_grams(model.rows), force * math.cos(lean), force * math.sin(lean), mu, farthest)
            found = (told.position, told.force, told.angle)[which]
            if found > best:
                best, y, angle = found, at, lean
        if best == math.inf:
            break
        if y == here_y and angle == here_angle:
            dy, da = 0.5 * dy, 0.5 * da
            if dy < 1e-7 * farthest:
                break
    return math.sqrt(best)
