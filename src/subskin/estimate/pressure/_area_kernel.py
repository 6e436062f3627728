"""The compiled loop of an image of the pressure: weight, pressure, drag, and what is told of them, a frame at a time.

A search begins on elements twice as wide, from the smoothest solution of any sign and from no drag: of 390 touches none
had a lesser J where it began at the true drag.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from . import _on_area as on_area
from . import columns as column
from ._area_solver import in_turn, stay, together
from ._frame import AMBIGUOUS, EDGE, OK, UNEXPLAINED, begun, next_factor
from ._solver import forward
from ._weight import HIGHEST, LOWEST, weigh
from .hats import COARSE

_NEAR = 0.05
"""Where the search for the drag ends, in its standard deviations."""
_ROUGHLY = 0.01
"""A step of the drag's tangent after which coarse elements have said enough."""
_BRIGHT = 0.05
"""Share of the largest height from which a coarse element is thought to be pressed, and what lies about it too."""


@compiled()
def weight_of(basis, squares, b, kind, seen):
    """The rule's weight; U^T b goes into `seen`."""
    n = b.size
    power = np.empty(n)
    for i in range(n):
        s = 0.0
        for k in range(n):
            s += basis[i, k] * b[k]
        seen[i] = s
        power[i] = s * s
    return math.exp(weigh(power, squares, kind))


@compiled()
def _guess(basis, squares, spread, seen, w, on):
    """Which coarse elements are > 0, from the smoothest solution of any sign."""
    n = seen.size
    inner = np.zeros(n)
    for i in range(n):
        s = seen[i] / (squares[i] + w)
        for k in range(n):
            inner[k] += s * basis[i, k]
    heights, largest = np.empty(on.size), 0.0
    for j in range(on.size):
        s = 0.0
        for i in range(n):
            s += spread[j, i] * inner[i]
        heights[j] = s
        largest = max(largest, s)
    for j in range(on.size):
        on[j] = heights[j] > _BRIGHT * largest


@compiled()
def _as_at(drag, t, b, work, out):
    """Readings b, of a drag t, as they were at another `drag`, by the coarse pressure: a weight is known there.

    Sensors that see drags well would else take the difference for a rough pressure.
    """
    x, own, rows = work[1], work[8], work[11]
    by_y, by_z = drag[0] - t[0], drag[1] - t[1]
    out[:] = b
    for j in range(x.size):
        if x[j] > 0.0:
            row = rows[j]
            for i in range(b.size):
                out[i] += x[j] * (by_y * own[0, row, i] + by_z * own[1, row, i])


@compiled()
def _finer(coarse, few, share, many, on):
    """Which fine elements lie at coarse ones that are > 0, or half way to one; of a faint one, that in its middle."""
    share[:] = 0.0
    largest = 0.0
    for j in range(coarse.size):
        largest = max(largest, coarse[j])
    for j in range(coarse.size):
        if not coarse[j] > 0.0:
            continue
        y, z = COARSE * (j // few[1]) + COARSE - 1, COARSE * (j % few[1]) + COARSE - 1
        if coarse[j] <= _BRIGHT * largest:
            share[y * many[1] + z] += 1.0
            continue
        for dy in range(1 - COARSE, COARSE):
            for dz in range(1 - COARSE, COARSE):
                part = (1.0 - abs(dy) / COARSE) * (1.0 - abs(dz) / COARSE)
                share[(y + dy) * many[1] + z + dz] += part
    for j in range(on.size):
        on[j] = share[j] >= 0.5


@compiled()
def _totals(row, level, work, count, gone, t, turned, crossed, reach, y, z):
    """Forces, direction and centre with their standard deviations, how well the minimum is met, and the status."""
    sizes, area = level[5], level[7]
    x, slope, lower, index, scratch, away = work[1], work[2], work[4], work[5], work[6], work[16]
    leaning = level[0].shape[0] > 1
    nz, rim = sizes[1], sizes[2]
    total = x.size
    sums = np.zeros((7, total))
    force, moment, worst, edge = np.zeros(3), np.zeros(2), 0.0, 0.0
    for j in range(total):
        worst = max(worst, abs(slope[j]) if x[j] > 0.0 else -slope[j])
        if x[j] == 0.0:
            continue
        at_y, at_z = j // nz, j % nz
        sums[0, j] = area
        sums[1, j], sums[2, j] = area * t[0], area * t[1]
        for i in range(3):
            force[i] += sums[i, j] * x[j]
        moment[0] += area * x[j] * y[at_y]
        moment[1] += area * x[j] * z[at_z]
        if min(at_y, sizes[0] - 1 - at_y, at_z, nz - 1 - at_z) < rim:
            edge += area * x[j]
    normal = force[0]
    centre, leans = moment / normal, force[1:] / normal
    tangent = math.hypot(leans[0], leans[1])
    ey, ez = (leans[0] / tangent, leans[1] / tangent) if tangent > 0.0 else (1.0, 0.0)
    for k in range(count):
        j = index[k]
        sums[3, j] = area * (y[j // nz] - centre[0]) / normal
        sums[4, j] = area * (z[j % nz] - centre[1]) / normal
        by_y, by_z = (sums[1, j] - leans[0] * area) / normal, (sums[2, j] - leans[1] * area) / normal
        sums[5, j], sums[6, j] = ey * by_y + ez * by_z, ey * by_z - ez * by_y
    std = np.zeros(7)
    a, c, d = turned[2], turned[3], turned[4]
    known = a > 0.0 and a * d - c * c > 0.0
    for i in range(7):
        for k in range(count):
            scratch[k] = sums[i, index[k]]
        forward(lower, count, scratch)
        stay(away, gone, count, scratch)
        variance = 0.0
        for k in range(count):
            variance += scratch[k] * scratch[k]
        if leaning:
            # by t itself, and by what follows from t
            py = normal if i == 1 else ey if i == 5 else -ez if i == 6 else 0.0
            pz = normal if i == 2 else ez if i == 5 else ey if i == 6 else 0.0
            for k in range(count):
                py -= scratch[k] * crossed[0, k]
                pz -= scratch[k] * crossed[1, k]
            variance += (d * py * py - 2.0 * c * py * pz + a * pz * pz) / (a * d - c * c) if known else math.inf
        std[i] = math.sqrt(variance)
    row[column.OPTIMALITY] = worst / reach
    row[column.FORCES], row[column.FORCES + 1], row[column.ACROSS] = force[0], force[1], force[2]
    row[column.FORCE_STD], row[column.FORCE_STD + 1], row[column.ACROSS_STD] = std[0], std[1], std[2]
    row[column.CENTRE], row[column.CENTRE_Z] = centre[0], centre[1]
    row[column.CENTRE_STD], row[column.CENTRE_Z_STD] = std[3], std[4]
    row[column.ANGLE], row[column.ANGLE_STD] = math.atan(tangent), std[5] / (1.0 + tangent * tangent)
    row[column.AZIMUTH_STD] = std[6] / tangent if tangent > 0.0 else math.inf
    row[column.MOMENT] = row[column.MOMENT_STD] = 0.0  # of a drag in one direction, about the centre of pressure
    # what lies at the edge may lie beyond it; and the angle may be any
    sure = edge <= EDGE * normal and max(row[column.ANGLE_STD], std[6]) < 1.0
    row[column.STATUS] = OK if sure else AMBIGUOUS


@compiled()
def _settle(level, t, most, w, b, on, work, scratch):
    """The least of J on fine elements from guesses: what `together` says of it."""
    first, lean = on.copy(), t.copy()
    count, reach, gone = together(level, t, most, w, b, on, _NEAR, 0.0, work, scratch)
    if count < 0 and not on_area.crowded(work):
        on[:] = first
        t[:] = lean
        count, reach = in_turn(level, t, most, w, b, on, _NEAR, work, scratch)
        gone = 0
    return count, reach, gone


@compiled()
def map_frames(begin, readings, sensors, limits, drags, basis, squares, spread, coarse, fine, y, z, rough, work, out):
    """Fill a row of `out` for each frame from `begin`; the first one for which there was no room, or their number.

    sensors (4, n): offset, 1 / noise, range. limits: chi-square above which there is a contact, and an image is
    unexplained; friction; number of the rule. drags (T, 2), U^T (T, n, n), S^2 (T, n), C A^T of the pressure at the
    coarse elements. coarse, fine, rough, work: levels and their work, as in `_on_area`. y, z: inner nodes.
    """
    largest, most, kind = limits[0], limits[1], int(limits[2])
    n, leans = readings.shape[1], fine[0].shape[0] > 1
    b, seen, t, turned = np.empty(n), np.empty(n), np.empty(2), np.zeros(5)
    on_coarse, on = np.empty(rough[1].size, dtype=np.bool_), np.empty(work[1].size, dtype=np.bool_)
    along, crossed, new = np.empty((2, n)), np.empty((2, on.size)), np.empty(2)
    scratch = along, crossed, turned, new
    for f in range(begin, len(readings)):
        row = out[f]
        if not begun(readings[f], sensors, largest, row, b):
            continue
        on_area.forget(rough)
        on_area.forget(work)
        t[:] = 0.0
        lean, w = 0, weight_of(basis[0], squares[0], b, kind, seen)
        _guess(basis[0], squares[0], spread, seen, w, on_coarse)
        together(coarse, t, most, w, b, on_coarse, _NEAR, _ROUGHLY, rough, scratch)
        if on_area.crowded(rough):
            return f
        if leans:
            for k in range(1, len(drags)):
                if math.hypot(t[0] - drags[k, 0], t[1] - drags[k, 1]) < math.hypot(
                    t[0] - drags[lean, 0], t[1] - drags[lean, 1]
                ):
                    lean = k
            _as_at(drags[lean], t, b, rough, along[0])
            w = weight_of(basis[lean], squares[lean], along[0], kind, seen)
        top = squares[lean, n - 1]
        lowest, highest = math.exp(LOWEST) * top, math.exp(HIGHEST) * top
        _finer(rough[1], coarse[5], work[2], fine[5], on)
        factor, chi2 = 1.0, math.inf
        while True:
            count, reach, gone = _settle(fine, t, most, w, b, on, work, scratch)
            if on_area.crowded(work):
                return f
            chi2 = 0.0
            for i in range(n):
                chi2 += work[3][i] * work[3][i]
            factor = next_factor(factor, count, chi2, largest)
            if not lowest <= w * factor <= highest:
                break
            w *= factor
        row[column.RESIDUAL], row[column.WEIGHT], row[column.LEAN] = chi2, w, lean
        if count < 0 or not chi2 <= largest:
            row[column.STATUS] = UNEXPLAINED
            continue
        _totals(row, fine, work, count, gone, t, turned, crossed, reach, y, z)
        row[column.AREA_WIDTH :] = work[1]
    return len(readings)
