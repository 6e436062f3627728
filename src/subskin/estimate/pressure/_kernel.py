"""The compiled loop of a map or an image of the pressure: weight, pressure, drag, and what is told of them, by frames.

A search begins on elements two or three times as wide, from the smoothest solution of any sign; along a row at the drag
of the best even strip, on an area at none: of 390 touches none had a lesser J where it began at the true drag.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..scan import MOST_CHI2
from . import _elements as elements
from . import columns as column
from ._algebra import forward
from ._cones import Cones, onto
from ._elements import Level, Work
from ._free_solver import minimise
from ._solver import Turn, settle, stay, together
from ._task import Nodes, Task
from ._weight import HIGHEST, LOWEST, weigh

OK, AMBIGUOUS, NO_CONTACT, UNEXPLAINED, PENDING = 0.0, 1.0, 2.0, 3.0, -1.0

NORMAL, DRAG_Y, DRAG_Z, AT_Y, AT_Z, ALONG, ACROSS, MOMENT = 0, 1, 2, 3, 4, 5, 6, 7
"""Totals: force and drags, centre of pressure, tangent along the drag and across it, and the moment of the drag."""

_EDGE = 0.02
"""Share of the force at the edge of the search from which some may lie beyond it."""
_COARSELY = 0.05
"""Where the search for the drag on coarse elements ends, in its standard deviations."""
_ROUGHLY = 0.01
"""A step of the drag's tangent after which coarse elements have said enough."""
_BRIGHT = 0.05
"""Share of the largest height from which a coarse element is thought to be pressed, and what lies about it too."""


@compiled()
def _begun(reading, task, row, b):
    """Whether a frame has a pressure to be found; its whitened readings into b, what else is to be said into `row`."""
    sensors = task.sensors
    row[:] = math.nan
    usable, power = True, 0.0
    for i in range(b.size):
        usable &= sensors[2, i] < reading[i] < sensors[3, i]
        b[i] = (reading[i] - sensors[0, i]) * sensors[1, i]
        power += b[i] * b[i]
    if not (usable and power < MOST_CHI2):
        row[column.STATUS] = PENDING
        return False
    row[column.STATUS], row[column.RESIDUAL] = NO_CONTACT, power
    return power > task.largest


@compiled()
def _first_lean(task, b):
    """The tangent of the one strip, of a few widths at many positions, that explains most."""
    strips, gauges, most = task.strips, task.gauges, task.friction
    best = lean = 0.0
    for k in range(gauges.shape[0]):
        one = two = 0.0
        for i in range(b.size):
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
def _weighed(task, lean, b, seen):
    """The rule's weight at a drag; U^T b goes into `seen`."""
    basis, n = task.basis[lean], b.size
    power = np.empty(n)
    for i in range(n):
        s = 0.0
        for k in range(n):
            s += basis[i, k] * b[k]
        seen[i] = s
        power[i] = s * s
    return math.exp(weigh(power, task.squares[lean], task.rule))


@compiled()
def _smoothest(task, lean, seen, w):
    """Heights of the smoothest solution of any sign, at the coarse elements, by part."""
    basis, squares, n = task.basis[lean], task.squares[lean], seen.size
    inner = np.zeros(n)
    for i in range(n):
        s = seen[i] / (squares[i] + w)
        for k in range(n):
            inner[k] += s * basis[i, k]
    parts = np.empty(task.spread.shape[:2])
    for part in range(parts.shape[0]):
        for j in range(parts.shape[1]):
            s = 0.0
            for i in range(n):
                s += task.spread[part, j, i] * inner[i]
            parts[part, j] = s
    return parts


@compiled()
def _nearest(drags, t):
    best = 0
    for k in range(1, len(drags)):
        if math.hypot(t[0] - drags[k, 0], t[1] - drags[k, 1]) < math.hypot(
            t[0] - drags[best, 0], t[1] - drags[best, 1]
        ):
            best = k
    return best


@compiled()
def _as_at(drag, t, b, work, out):
    """Readings b, of a drag t, as they were at another `drag`, by the coarse pressure: a weight is known there.

    Sensors that see drags well would else take the difference for a rough pressure.
    """
    x, drags = work.x[0], work.drags
    out[:] = b
    for j in range(x.size):
        if x[j] > 0.0:
            for part in range(drags.shape[0]):
                by = x[j] * (drag[part] - t[part])
                for i in range(b.size):
                    out[i] += by * drags[part, work.rows[j], i]


@compiled()
def _between(coarse, nodes, nz, bright, out):
    """Values at coarse elements, drawn to those between them; of one that is not `bright`, the middle alone is 1."""
    wide_y, wide_z = nodes.wide_y, nodes.wide_z
    out[:] = 0.0
    for j in range(coarse.size):
        if coarse[j] == 0.0:
            continue
        y, z = wide_y * (j // nodes.few_z) + wide_y - 1, wide_z * (j % nodes.few_z) + wide_z - 1
        if abs(coarse[j]) <= bright:
            out[y * nz + z] += 1.0
            continue
        for dy in range(1 - wide_y, wide_y):
            for dz in range(1 - wide_z, wide_z):
                share = (1.0 - abs(dy) / wide_y) * (1.0 - abs(dz) / wide_z)
                out[(y + dy) * nz + z + dz] += share * (coarse[j] if bright < 0.0 else 1.0)


@compiled(inline=True)
def _searched(task, coarse, nodes, nz, b, seen, t, on, rough, turned, scratch):
    """Weight, drag and pressed elements to begin with, by coarse elements: the number of the drag, and the weight."""
    on_coarse = np.empty(rough.x.shape[1], dtype=np.bool_)
    leans = coarse.parts.shape[0] > 1
    t[0], t[1] = _first_lean(task, b) if leans else 0.0, 0.0
    lean = _nearest(task.drags, t)
    w = _weighed(task, lean, b, seen)
    parts = _smoothest(task, lean, seen, w)
    largest = 0.0
    for j in range(on_coarse.size):
        for part in range(1, len(parts)):
            parts[0, j] += task.drags[lean, part - 1] * parts[part, j]
        largest = max(largest, parts[0, j])
    for j in range(on_coarse.size):
        on_coarse[j] = parts[0, j] > _BRIGHT * largest
    count = together(coarse, t, task.friction, w, b, on_coarse, _COARSELY, _ROUGHLY, rough, turned)[0]
    if elements.crowded(rough):
        return lean, w
    if leans:
        lean, same = _nearest(task.drags, t), b
        if not nodes.row:
            same = turned.along[0]
            _as_at(task.drags[lean], t, b, rough, same)
        w = _weighed(task, lean, same, seen)
    for j in range(on_coarse.size):
        rough.x[0, j] = max(rough.x[0, j], 0.0) if count >= 0 or not nodes.row else 1.0
    _between(rough.x[0], nodes, nz, _BRIGHT * rough.x.max(), scratch)
    for j in range(on.size):
        on[j] = scratch[j] >= 0.5
    return lean, w


@compiled()
def _guessed(task, nodes, nz, b, seen, first):
    """The weight, and the smoothest solution of any sign; 0 where it is faint."""
    w = _weighed(task, 0, b, seen)
    parts = _smoothest(task, 0, seen, w)
    for part in range(3):
        _between(parts[part], nodes, nz, -1.0, first[part])
    faint = _BRIGHT * first[0].max()
    for j in range(first.shape[1]):
        if not first[0, j] > faint:
            first[0, j] = first[1, j] = first[2, j] = 0.0
    return w


@compiled()
def _totals(row, task, nodes, t, x, index, count):
    """Forces, direction, centre and moment; and what each total changes by the heights in the factor, (8, h, count)."""
    force, first, edge = np.zeros(3), np.zeros(2), 0.0
    drags = len(x) > 1
    sums = np.zeros((8, len(x), count))
    for k in range(count):
        j = index[k]
        sums[NORMAL, 0, k], sums[DRAG_Y, 0, k] = nodes.area, nodes.area * (t[0] + nodes.own[j])
        sums[DRAG_Z, 0, k] = nodes.area * t[1]
        if drags:
            sums[DRAG_Y, 1, k] = sums[DRAG_Z, 2, k] = nodes.area * task.friction
        for i in range(3):
            for part in range(len(x)):
                force[i] += sums[i, part, k] * x[part, j]
        first[0] += nodes.area * x[0, j] * nodes.y[j]
        first[1] += nodes.area * x[0, j] * nodes.z[j]
        edge += nodes.area * x[0, j] if nodes.rim[j] else 0.0
    normal = force[0]
    centre, leans = first / normal, force[1:] / normal
    tangent = leans[0] if nodes.row else math.hypot(leans[0], leans[1])
    ey, ez = (leans[0] / tangent, leans[1] / tangent) if tangent != 0.0 else (1.0, 0.0)
    moment = 0.0
    for k in range(count):
        j = index[k]
        dy, dz = nodes.y[j] - centre[0], nodes.z[j] - centre[1]
        sums[AT_Y, 0, k], sums[AT_Z, 0, k] = nodes.area * dy / normal, nodes.area * dz / normal
        for part in range(len(x)):
            by_y = (sums[DRAG_Y, part, k] - leans[0] * sums[NORMAL, part, k]) / normal
            by_z = (sums[DRAG_Z, part, k] - leans[1] * sums[NORMAL, part, k]) / normal
            sums[ALONG, part, k], sums[ACROSS, part, k] = ey * by_y + ez * by_z, ey * by_z - ez * by_y
        if drags:  # those in one direction have none about the centre, which moves with the pressure
            moment += dy * sums[DRAG_Z, 2, k] * x[2, j] - dz * sums[DRAG_Y, 1, k] * x[1, j]
            sums[MOMENT, 0, k] = nodes.area * (force[1] * dz - force[2] * dy) / normal
            sums[MOMENT, 1, k], sums[MOMENT, 2, k] = -dz * sums[DRAG_Y, 1, k], dy * sums[DRAG_Z, 2, k]
    row[column.FORCES], row[column.FORCES + 1], row[column.ACROSS] = force[0], force[1], force[2]
    row[column.CENTRE], row[column.CENTRE_Z] = centre[0], centre[1]
    row[column.ANGLE], row[column.MOMENT] = math.atan(tangent), moment
    # what lies at the edge may lie beyond it
    row[column.STATUS] = OK if edge <= _EDGE * normal else AMBIGUOUS
    return sums, tangent, ey, ez


@compiled()
def _deviations(sums, work, count, turned, normal, ey, ez, std):
    """Standard deviations of the totals of a pressure, and of a drag in proportion to it."""
    z, a, c, d = work.z, turned.bend[0], turned.bend[1], turned.bend[2]
    known = a > 0.0 and a * d - c * c > 0.0
    directions = work.drags.shape[0]
    std[MOMENT] = 0.0
    for i in range(MOMENT):
        z[:count] = sums[i, 0]
        forward(work.lower, count, z)
        stay(work, count, z)
        variance = 0.0
        for k in range(count):
            variance += z[k] * z[k]
        if directions > 0:
            # by t itself, and by what follows from t
            py = normal if i == DRAG_Y else ey if i == ALONG else -ez if i == ACROSS else 0.0
            pz = normal if i == DRAG_Z else ez if i == ALONG else ey if i == ACROSS else 0.0
            for k in range(count):
                py -= z[k] * turned.crossed[0, k]
                if directions > 1:
                    pz -= z[k] * turned.crossed[1, k]
            if directions == 1:
                pz = 0.0
            variance += (d * py * py - 2.0 * c * py * pz + a * pz * pz) / (a * d - c * c) if known else math.inf
        std[i] = math.sqrt(variance)


@compiled()
def _free_deviations(sums, work, cones, count, many, std):
    """The same of a drag that is free."""
    weights = np.empty(cones.best.shape)
    for i in range(8):
        for k in range(count):
            for part in range(3):
                weights[part, work.listed[k]] = sums[i, part, k]
            onto(cones, weights, k, work.listed[k], work.z)
        forward(work.lower, many, work.z)
        s = 0.0
        for k in range(many):
            s += work.z[k] * work.z[k]
        std[i] = math.sqrt(s)


@compiled()
def _doubts(row, std, tangent):
    """Standard deviations into the row; where the angle may be any, its status."""
    row[column.FORCE_STD], row[column.FORCE_STD + 1], row[column.ACROSS_STD] = std[NORMAL], std[DRAG_Y], std[DRAG_Z]
    row[column.CENTRE_STD], row[column.CENTRE_Z_STD] = std[AT_Y], std[AT_Z]
    row[column.ANGLE_STD], row[column.MOMENT_STD] = std[ALONG] / (1.0 + tangent * tangent), std[MOMENT]
    row[column.AZIMUTH_STD] = std[ACROSS] / abs(tangent) if tangent != 0.0 else math.inf
    if not max(row[column.ANGLE_STD], std[ACROSS]) < 1.0:
        row[column.STATUS] = AMBIGUOUS


@compiled()
def _next_factor(factor, count, chi2, largest):
    """By what the weight has to change, after a change by `factor`: 0 where it will do."""
    if count < 0:
        return 9.0  # too little smoothness for the arithmetic
    return 0.0 if chi2 <= largest or factor > 1.0 else 1.0 / 9.0  # too smooth for these readings


@compiled(frames="readings")
def map_frames(begin, readings, given, wide, narrow, placed, works, fill, out):
    """Fill a row of `out` for each frame from `begin`; the first one for which there was no room, or their number.

    given, wide, narrow, placed: fields of the `Task`, of the coarse and the fine `Level`, of the `Nodes`. works: those
    of the coarse and the fine `Work`; fill: those of the `Cones` of a free drag, else None.
    """
    task, coarse, fine, nodes = Task(*given), Level(*wide), Level(*narrow), Nodes(*placed)
    rough, work = Work(*works[0]), Work(*works[1])
    n, m = readings.shape[1], fine.cost.size
    b, seen, t, on, scratch = np.empty(n), np.empty(n), np.zeros(2), np.empty(m, dtype=np.bool_), np.empty(m)
    turned = Turn(np.empty((2, n)), np.empty((2, m)), np.zeros(2), np.zeros(3), np.zeros(2))
    std, first, x = np.zeros(8), np.empty_like(work.x), work.x
    for f in range(begin, len(readings)):
        row = out[f]
        if not _begun(readings[f], task, row, b):
            continue
        lean = 0
        elements.forget(work)
        if fill is None:
            elements.forget(rough)
            lean, w = _searched(task, coarse, nodes, fine.nz, b, seen, t, on, rough, turned, scratch)
            if elements.crowded(rough):
                return f
        else:
            cones = Cones(*fill)
            w = _guessed(task, nodes, fine.nz, b, seen, first)
            x[:] = first
        top = task.squares[lean, n - 1]
        lowest, highest = math.exp(LOWEST) * top, math.exp(HIGHEST) * top
        factor, chi2 = 1.0, math.inf
        while True:
            if fill is None:
                count, worst = settle(fine, t, task.friction, w, b, on, task.near, work, turned)
            else:
                count, many, worst = minimise(fine, w, b, work, cones)
                if count < 0:
                    x[:] = first
            if elements.crowded(work):
                return f
            chi2 = 0.0
            for i in range(n):
                chi2 += work.residual[i] * work.residual[i]
            factor = _next_factor(factor, count, chi2, task.largest)
            if not lowest <= w * factor <= highest:
                break
            w *= factor
        row[column.RESIDUAL], row[column.WEIGHT], row[column.LEAN] = chi2, w, lean
        if count <= 0 or not chi2 <= task.largest:
            row[column.STATUS] = UNEXPLAINED
            continue
        row[column.OPTIMALITY] = worst
        sums, tangent, ey, ez = _totals(row, task, nodes, t, x, work.listed, count)
        if fill is None:
            _deviations(sums, work, count, turned, row[column.FORCES], ey, ez, std)
        else:
            _free_deviations(sums, work, cones, count, many, std)
        _doubts(row, std, tangent)
        for part in range(len(x)):
            scale = 1.0 if part == 0 else task.friction
            for j in range(m):
                row[column.WIDTH + part * m + j] = scale * x[part, j]
    return len(readings)
