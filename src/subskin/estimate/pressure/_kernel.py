"""The compiled loop of `pressure_map`: weight, pressure, angle, and what is told of them, a frame at a time.

A search begins on elements four times as wide, from the smoothest solution of any sign and, where an angle is sought,
from that of the best even strip.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from . import columns as column
from ._frame import AMBIGUOUS, EDGE, OK, UNEXPLAINED, begun, next_factor
from ._solver import settle, turn, variance_of
from ._weight import HIGHEST, LOWEST, weigh

_SETTLED, _NEAR = 0.01, 0.03  # of the tangent's standard deviation, on fine and on coarse elements


@compiled()
def _guess(shapes, power, squares, w, blocks, on):
    """Which coarse elements are > 0, from the smoothest solution; shapes (rows, n), power U^T b."""
    rows, n = shapes.shape
    m = rows // blocks
    largest = 0.0
    value = np.empty(rows)
    for j in range(rows):
        s = 0.0
        for i in range(n):
            s += shapes[j, i] * power[i] / (squares[i] + w)
        value[j] = s
    if blocks == 2:
        for j in range(m):
            value[j], value[m + j] = value[j] + value[m + j], value[j] - value[m + j]
    for j in range(rows):
        largest = max(largest, value[j])
    for j in range(rows):
        on[j] = value[j] > 0.05 * largest


@compiled()
def _finer(coarse, blocks, ratio, fine):
    """Which elements lie at or beside those coarse ones that are > 0."""
    mc, m = coarse.size // blocks, fine.size // blocks
    for block in range(blocks):
        for j in range(m):
            left, rest = (j + 1) // ratio, (j + 1) % ratio
            here = left > 0 and coarse[block * mc + left - 1] > 0.0
            if rest > 0 and left < mc:
                here |= coarse[block * mc + left] > 0.0
            fine[block * m + j] = here


@compiled()
def _project(basis, b, out):
    n = b.size
    for i in range(n):
        s = 0.0
        for k in range(n):
            s += basis[i, k] * b[k]
        out[i] = s


@compiled()
def _first_lean(strips, gauges, b, most):
    """The tangent of the one strip, of a few widths at many positions, that explains most; strips (2, M, n)."""
    best = lean = 0.0
    n = b.size
    for k in range(gauges.shape[0]):
        one = two = 0.0
        for i in range(n):
            one += strips[0, k, i] * b[i]
            two += strips[1, k, i] * b[i]
        g11, g12, g22 = gauges[k, 0], gauges[k, 1], gauges[k, 2]
        normal, tangential = g22 * one - g12 * two, g11 * two - g12 * one
        t = min(max(tangential / normal, -most), most) if normal > 0.0 else math.copysign(most, tangential)
        along = one + t * two
        explained = along * along / (g11 + t * (2.0 * g12 + t * g22)) if along > 0.0 else 0.0
        if explained > best:
            best, lean = explained, t
    return lean


@compiled()
def _nearest(tangents, t):
    best = 0
    for k in range(tangents.size):
        if abs(tangents[k] - t) < abs(tangents[best] - t):
            best = k
    return best


@compiled()
def _totals(row, level, work, count, t, b, surface, sums, along):
    """Forces, angle and centre with their standard deviations, how well the minimum is met, and the status."""
    parts, cost = level[0], level[4]
    columns, x, slope, _, lower, index, z, c = work
    y, scales = surface[0], surface[1]
    step, friction, blocks, ratio = scales[0], scales[1], int(scales[2]), int(scales[3])
    total, n = columns.shape
    m = y.size
    reach = worst = normal = tangential = moment = edge = 0.0
    for j in range(total):
        s = -cost[j]
        for i in range(n):
            s += columns[j, i] * b[i]
        reach = max(reach, abs(s))
        worst = max(worst, abs(slope[j]) if x[j] > 0.0 else -slope[j])
        position = j % m
        lean = friction * (1.0 - 2.0 * (j // m)) if blocks == 2 else t
        sums[0, j], sums[1, j] = step, step * lean
        normal += step * x[j]
        tangential += step * x[j] * lean
        moment += step * x[j] * y[position]
        if min(position, m - 1 - position) < ratio:
            edge += step * x[j]
    centre, tangent = moment / normal, tangential / normal
    row[column.OPTIMALITY] = worst / reach
    row[column.FORCES], row[column.FORCES + 1], row[column.CENTRE] = normal, tangential, centre
    row[column.ANGLE], row[column.ANGLE_STD] = math.atan(tangent), 0.0
    for j in range(total):
        sums[2, j] = step * (y[j % m] - centre) / normal
        sums[3, j] = (sums[1, j] - tangent * sums[0, j]) / normal
    curve = math.inf
    if parts.shape[0] > 1:
        curve = turn(parts, work, count, along)[1]
    for k in range(4):
        variance = variance_of(lower, count, index, sums[k], z)
        if parts.shape[0] > 1:
            pull = normal if k == 1 else 1.0 if k == 3 else 0.0  # by t itself, and by what follows from t
            for i in range(count):
                pull -= z[i] * c[i]
            variance += pull * pull / curve
        sums[k, 0] = math.sqrt(variance)
    row[column.FORCE_STD], row[column.FORCE_STD + 1], row[column.CENTRE_STD] = sums[0, 0], sums[1, 0], sums[2, 0]
    row[column.ANGLE_STD] = sums[3, 0] / (1.0 + tangent * tangent)
    # what lies at the edge may lie beyond it; and the angle may be any
    row[column.STATUS] = AMBIGUOUS if edge > EDGE * normal or not row[column.ANGLE_STD] < 1.0 else OK


@compiled()
def _curves(row, x, shares, squares, prior, w, surface):
    """Pressure and shear along the surface, and their standard deviations."""
    scales = surface[1]
    friction, blocks, m = scales[1], int(scales[2]), surface[0].size
    at = column.WIDTH
    known = 1.0 / (squares + w)
    for block in range(blocks):
        row[at] = row[at + m + 1] = row[at + m + 2] = row[at + 2 * m + 3] = 0.0
        for j in range(m):
            one = x[j]
            if blocks == 2:
                one = x[j] + x[m + j] if block == 0 else friction * (x[j] - x[m + j])
            row[at + 1 + j] = one
            s = prior[block * m + j]
            for i in range(squares.size):
                s -= shares[block * m + j, i] * known[i]
            row[at + m + 3 + j] = math.sqrt(max(s, 0.0) / w) * (friction if block == 1 else 1.0)
        at += 2 * (m + 2)


@compiled()
def map_frames(readings, sensors, factors, fine, coarse, surface, options, out):
    """Fill `out`, a row of `WIDTH` columns and the nodes' values for each frame of `readings` (frames, n).

    sensors (4, n): offset, 1 / noise, ends of the range. factors: tangents (T,), U^T (T, n, n), S^2 (T, n), squares of
    V (T, rows, n), diagonal of C (rows,), V at the coarse nodes (T, coarse rows, n). fine, coarse: as in `settle`.
    surface: y of the
    inner nodes; step, friction, blocks, elements in a coarse one; strips (2, M, n) and their products (M, 3).
    options: rule, no contact below, unexplained above.
    """
    tangents, basis, squares, shares, prior, starts = factors
    _, scales, strips, gauges = surface
    blocks, ratio = int(scales[2]), int(scales[3])
    kind, silent, largest = int(options[0]), options[1], options[2]
    frames, n = readings.shape
    total, total_c = fine[2].size, coarse[2].size
    turns = fine[0].shape[0] > 1
    b, r, power, squared = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    x, on, lower = np.empty(total), np.empty(total, dtype=np.bool_), np.empty((total, total))
    x_c, on_c, lower_c = np.empty(total_c), np.empty(total_c, dtype=np.bool_), np.empty((total_c, total_c))
    index, z, c = np.empty(total, dtype=np.int64), np.empty(total), np.empty(total)
    work = (fine[0][0].copy(), x, np.empty(total), r, lower, index, z, c)
    work_c = (coarse[0][0].copy(), x_c, np.empty(total_c), r, lower_c, index, z, c)
    along, sums = np.empty(n), np.zeros((4, total))
    for f in range(frames):
        row = out[f]
        if not begun(readings[f], sensors, silent, row, b):
            continue
        t = _first_lean(strips, gauges, b, tangents[-1]) if turns else 0.0
        for level in range(2 if turns else 1):
            lean = _nearest(tangents, t)
            _project(basis[lean], b, power)
            for i in range(n):
                squared[i] = power[i] * power[i]
            w = math.exp(weigh(squared, squares[lean], kind))
            if level == 0:
                _guess(starts[lean], power, squares[lean], w, blocks, on_c)
                t, count = settle(coarse, t, tangents[0], tangents[-1], w, b, on_c, work_c, _NEAR)
        if count < 0:
            x_c[:] = 1.0
        _finer(x_c, blocks, ratio, on)
        chi2, factor = math.inf, 1.0
        lowest, highest = math.exp(LOWEST) * squares[lean, n - 1], math.exp(HIGHEST) * squares[lean, n - 1]
        while True:
            t, count = settle(fine, t, tangents[0], tangents[-1], w, b, on, work, _SETTLED)
            chi2 = 0.0
            for i in range(n):
                chi2 += r[i] * r[i]
            factor = next_factor(factor, count, chi2, largest)
            if not lowest <= w * factor <= highest:
                break
            w *= factor
        row[column.RESIDUAL], row[column.WEIGHT], row[column.LEAN] = chi2, w, lean
        if count < 0 or not chi2 <= largest:
            row[column.STATUS] = UNEXPLAINED
            continue
        _totals(row, fine, work, count, t, b, surface, sums, along)
        _curves(row, x, shares[lean], squares[lean], prior, w, surface)
