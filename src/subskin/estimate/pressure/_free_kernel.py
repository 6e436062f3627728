"""The compiled loop of an image of the pressure and of a free drag: a frame at a time, as that of one direction.

A search begins from the smoothest solution of any sign, put back into the cones.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from . import columns as column
from ._area_kernel import weight_of
from ._frame import AMBIGUOUS, EDGE, OK, UNEXPLAINED, begun, next_factor
from ._free_parts import along, forget
from ._free_solver import minimise
from ._solver import forward
from ._weight import HIGHEST, LOWEST
from .hats import COARSE

_BRIGHT = 0.05
"""Share of the largest height from which an element is thought to be pressed."""


@compiled()
def _guess(basis, squares, spread, seen, w, few, many, x):
    """The smoothest solution of any sign, between the coarse elements; out where it is faint."""
    n = seen.size
    inner = np.zeros(n)
    for i in range(n):
        s = seen[i] / (squares[i] + w)
        for k in range(n):
            inner[k] += s * basis[i, k]
    x[:] = 0.0
    for part in range(3):
        for j in range(spread.shape[1]):
            s = 0.0
            for i in range(n):
                s += spread[part, j, i] * inner[i]
            y, z = COARSE * (j // few[1]) + COARSE - 1, COARSE * (j % few[1]) + COARSE - 1
            for dy in range(1 - COARSE, COARSE):
                for dz in range(1 - COARSE, COARSE):
                    share = (1.0 - abs(dy) / COARSE) * (1.0 - abs(dz) / COARSE)
                    x[part, (y + dy) * many[1] + z + dz] += share * s
    least = _BRIGHT * x[0].max()
    for j in range(x.shape[1]):
        if not x[0, j] > least:
            for part in range(3):
                x[part, j] = 0.0


@compiled(borrows=True)
def _variance(work, count, weights):
    """The variance of a sum of the heights with these weights (3, N)."""
    index, at, z = work[10], work[11], work[12]
    for k in range(count):
        j = index[k]
        for part in range(at[k + 1] - at[k]):
            s = 0.0
            for i in range(3):
                s += along(work, j, part, i) * weights[i, j]
            z[at[k] + part] = s
    forward(work[9], at[count], z)
    s = 0.0
    for i in range(at[count]):
        s += z[i] * z[i]
    return s


@compiled()
def _totals(row, level, work, count, friction, y, z):
    """Forces, direction, centre and moment with their standard deviations, and the status."""
    sizes, area, x, index = level[5], level[7], work[0], work[10]
    nz, rim, total = sizes[1], sizes[2], x.shape[1]
    force, first, edge = np.zeros(3), np.zeros(2), 0.0
    for k in range(count):
        j = index[k]
        at_y, at_z = j // nz, j % nz
        force[0] += area * x[0, j]
        force[1] += area * friction * x[1, j]
        force[2] += area * friction * x[2, j]
        first[0] += area * x[0, j] * y[at_y]
        first[1] += area * x[0, j] * z[at_z]
        if min(at_y, sizes[0] - 1 - at_y, at_z, nz - 1 - at_z) < rim:
            edge += area * x[0, j]
    normal = force[0]
    centre, leans = first / normal, force[1:] / normal
    tangent = math.hypot(leans[0], leans[1])
    ey, ez = (leans[0] / tangent, leans[1] / tangent) if tangent > 0.0 else (1.0, 0.0)
    sums, drag, moment = np.zeros((8, 3, total)), area * friction, 0.0
    for k in range(count):
        j = index[k]
        dy, dz = y[j // nz] - centre[0], z[j % nz] - centre[1]
        moment += drag * (dy * x[2, j] - dz * x[1, j])
        sums[0, 0, j] = area
        sums[1, 1, j] = sums[2, 2, j] = drag
        sums[3, 0, j], sums[4, 0, j] = area * dy / normal, area * dz / normal
        sums[5, 0, j], sums[5, 1, j], sums[5, 2, j] = -tangent * area / normal, ey * drag / normal, ez * drag / normal
        sums[6, 1, j], sums[6, 2, j] = -ez * drag / normal, ey * drag / normal
        # the centre moves with the pressure
        sums[7, 0, j] = area * (force[1] * dz - force[2] * dy) / normal
        sums[7, 1, j], sums[7, 2, j] = -drag * dz, drag * dy
    std = np.empty(8)
    for i in range(8):
        std[i] = math.sqrt(_variance(work, count, sums[i]))
    row[column.FORCES], row[column.FORCES + 1], row[column.ACROSS] = force[0], force[1], force[2]
    row[column.FORCE_STD], row[column.FORCE_STD + 1], row[column.ACROSS_STD] = std[0], std[1], std[2]
    row[column.CENTRE], row[column.CENTRE_Z] = centre[0], centre[1]
    row[column.CENTRE_STD], row[column.CENTRE_Z_STD] = std[3], std[4]
    row[column.ANGLE], row[column.ANGLE_STD] = math.atan(tangent), std[5] / (1.0 + tangent * tangent)
    row[column.AZIMUTH_STD] = std[6] / tangent if tangent > 0.0 else math.inf
    row[column.MOMENT], row[column.MOMENT_STD] = moment, std[7]
    # what lies at the edge may lie beyond it; and the angle may be any
    sure = edge <= EDGE * normal and max(row[column.ANGLE_STD], std[6]) < 1.0
    row[column.STATUS] = OK if sure else AMBIGUOUS


@compiled()
def map_free_frames(begin, readings, sensors, limits, basis, squares, spread, few, level, y, z, work, out):
    """Fill a row of `out` for each frame from `begin`; the first one for which there was no room, or their number.

    sensors, limits, y, z: as of `map_frames`. U^T (n, n), S^2 (n,), C A^T of each height at the coarse elements
    (3, coarse m, n), and the numbers of these (2,). level, work: as in `_free_parts`.
    """
    largest, friction, kind = limits[0], limits[1], int(limits[2])
    n, m, x = readings.shape[1], level[6].size, work[0]
    b, seen = np.empty(n), np.empty(n)
    first, top = np.empty_like(x), squares[n - 1]
    lowest, highest = math.exp(LOWEST) * top, math.exp(HIGHEST) * top
    for f in range(begin, len(readings)):
        row = out[f]
        if not begun(readings[f], sensors, largest, row, b):
            continue
        if 2 * work[6][m] * 3 > len(work[7]):
            forget(work)  # columns are kept from frame to frame while there is room
        w = weight_of(basis, squares, b, kind, seen)
        _guess(basis, squares, spread, seen, w, few, level[5], first)
        factor, chi2 = 1.0, math.inf
        x[:] = first
        while True:
            count, _, worst, reach = minimise(level, w, b, work)
            if count == -2:
                return f
            chi2 = 0.0
            for i in range(n):
                chi2 += work[5][i] * work[5][i]
            if count < 0:
                x[:] = first
            factor = next_factor(factor, count, chi2, largest)
            if not lowest <= w * factor <= highest:
                break
            w *= factor
        row[column.RESIDUAL], row[column.WEIGHT], row[column.LEAN] = chi2, w, 0.0
        if count <= 0 or not chi2 <= largest:
            row[column.STATUS] = UNEXPLAINED
            continue
        _totals(row, level, work, count, friction, y, z)
        row[column.OPTIMALITY] = worst / reach
        for j in range(m):
            row[column.AREA_WIDTH + j] = x[0, j]
            row[column.AREA_WIDTH + m + j] = friction * x[1, j]
            row[column.AREA_WIDTH + 2 * m + j] = friction * x[2, j]
    return len(readings)
