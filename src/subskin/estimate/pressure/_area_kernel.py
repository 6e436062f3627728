"""The pressure >= 0 on an area, and the drag along y and z with which it fits best, compiled: exact, for one frame.

The pressure at a drag is that of `_solver`; the drag follows by Newton's method, within the cone of friction.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from . import columns as column
from ._solver import forward, minimise, variance_of

_OK, _AMBIGUOUS, _UNEXPLAINED = 0.0, 1.0, 3.0
_EDGE = 0.02  # of the force
_TURNS = 40


@compiled()
def _least(level, t, w, b, along, on, downhill, work):
    """The p >= 0 of least J at the drag t: how many elements are > 0, and J, less a constant.

    along (1 or 3, N): columns of pressure and drags times the readings.
    """
    cost, x = level[4], work[1]
    for j in range(x.size):
        downhill[j] = along[0, j] - cost[j]
    if along.shape[0] > 1:
        for j in range(x.size):
            downhill[j] += t[0] * along[1, j] + t[1] * along[2, j]
    count = minimise(level, t, w, b, downhill, on, work)
    value = 0.0
    for k in range(count):
        j = work[5][k]
        value -= 0.5 * downhill[j] * x[j]
    return count, value


@compiled()
def _turn(parts, t, work, count, along, crossed):
    """Slope (2,) and curvature (3,) of the minimum over x in the drag t; L^-1 d2J/dx dt goes into `crossed` (2, N)."""
    _, x, _, r, lower, index, _, _ = work
    n = r.size
    along[:] = 0.0
    out = np.zeros(5)
    for k in range(count):
        j = index[k]
        for part in range(2):
            for i in range(n):
                along[part, i] += parts[1 + part, j, i] * x[j]
    for i in range(n):
        for part in range(2):
            out[part] += along[part, i] * r[i]
        out[2] += along[0, i] * along[0, i]
        out[3] += along[0, i] * along[1, i]
        out[4] += along[1, i] * along[1, i]
    for part in range(2):
        for k in range(count):
            j, s = index[k], 0.0
            for i in range(n):
                column = parts[0, j, i] + t[0] * parts[1, j, i] + t[1] * parts[2, j, i]
                s += column * along[part, i] + parts[1 + part, j, i] * r[i]
            crossed[part, k] = s
        forward(lower, count, crossed[part])
    for k in range(count):
        out[2] -= crossed[0, k] * crossed[0, k]
        out[3] -= crossed[0, k] * crossed[1, k]
        out[4] -= crossed[1, k] * crossed[1, k]
    return out


@compiled()
def _next(t, turned, most, new):
    """The drag that Newton's method tries next, within the cone; how far that is, in standard deviations."""
    a, c, d = turned[2], turned[3], turned[4]
    lean = math.hypot(t[0], t[1])
    if lean >= most * (1.0 - 1e-9) and turned[0] * t[0] + turned[1] * t[1] < 0.0:
        # on the cone, and pressed against it: along it
        ey, ez = -t[1] / lean, t[0] / lean
        slope = turned[0] * ey + turned[1] * ez
        curve = a * ey * ey + 2.0 * c * ey * ez + d * ez * ez - (turned[0] * t[0] + turned[1] * t[1]) / lean / lean
        step = -slope / curve if curve > 0.0 else math.copysign(0.25 * most, -slope)
        step = min(max(step, -0.5 * most), 0.5 * most)
        new[0], new[1] = t[0] + step * ey, t[1] + step * ez
        size = most / math.hypot(new[0], new[1])
        new[0], new[1] = size * new[0], size * new[1]
    else:
        # where J curves the wrong way, as much is added to its curvature as makes it right
        middle, half = 0.5 * (a + d), math.hypot(0.5 * (a - d), c)
        more = max(0.0, 1e-3 * (abs(middle) + half) - (middle - half))
        a, d = a + more, d + more
        det = a * d - c * c
        new[0] = t[0] - (d * turned[0] - c * turned[1]) / det
        new[1] = t[1] - (a * turned[1] - c * turned[0]) / det
        size = math.hypot(new[0], new[1])
        if size > most:
            new[0], new[1] = new[0] * most / size, new[1] * most / size
    dy, dz = new[0] - t[0], new[1] - t[1]
    return math.sqrt(max(a * dy * dy + 2.0 * c * dy * dz + d * dz * dz, 0.0))


@compiled()
def _settle(level, t, most, w, b, along, on, near, work, scratch):
    """The least of J over p >= 0 and over the drag within the cone, from guesses: how many elements are > 0.

    t (2,) is put right. Also what `_turn` says there.
    """
    downhill, moved, crossed = scratch
    parts, turned = level[0], np.zeros(5)
    count, value = _least(level, t, w, b, along, on, downhill, work)
    if parts.shape[0] == 1 or count < 0:
        return count, turned
    new, trial = np.empty(2), np.empty(2)
    for _ in range(_TURNS):
        turned = _turn(parts, t, work, count, moved, crossed)
        if _next(t, turned, most, new) < near:
            break
        share, found = 1.0, math.inf
        while share > 1e-3:
            for i in range(2):
                trial[i] = t[i] + share * (new[i] - t[i])
            count, found = _least(level, trial, w, b, along, on, downhill, work)
            if count < 0 or found <= value + 1e-12 * abs(value):
                break
            share *= 0.5
        if count >= 0 and not found <= value + 1e-12 * abs(value):
            count, value = _least(level, t, w, b, along, on, downhill, work)
            if count >= 0:
                turned = _turn(parts, t, work, count, moved, crossed)
            break
        t[:] = trial
        if count < 0:
            break
        value = found
    return count, turned


@compiled()
def _totals(row, level, work, count, t, turned, crossed, downhill, y, z):
    """Forces, direction and centre with their standard deviations, how well the minimum is met, and the status."""
    sizes, scales = level[3], level[6]
    _, x, slope, _, lower, index, scratch, _ = work
    leaning = level[0].shape[0] > 1
    nz, rim, area = sizes[1], sizes[2], scales[1]
    total = x.size
    sums = np.zeros((7, total))
    force, moment, reach, worst, edge = np.zeros(3), np.zeros(2), 0.0, 0.0, 0.0
    for j in range(total):
        reach = max(reach, abs(downhill[j]))
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
        variance = variance_of(lower, count, index, sums[i], scratch)
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
    # what lies at the edge may lie beyond it; and the angle may be any
    sure = edge <= _EDGE * normal and max(row[column.ANGLE_STD], std[6]) < 1.0
    row[column.STATUS] = _OK if sure else _AMBIGUOUS


@compiled()
def settle_frames(frames, along, weights, drags, guess, level, options, y, z, out):
    """The least of J in each frame; with rows in `out` also what is told of it.

    frames (f, n) whitened; along (f, 1 or 3, N): columns of pressure and drags times these; weights (f,); drags (f, 2)
    and guess (f, N), > 0 where an element is, are put right: guess becomes the heights. level: as in `_on_area`.
    options: largest tangent, near, unexplained above, lowest and highest weight. y, z: inner nodes.
    """
    most, near, largest, lowest, highest = options
    total, n = guess.shape[1], frames.shape[1]
    on, x, r, lower = np.empty(total, dtype=np.bool_), np.empty(total), np.empty(n), np.empty((total, total))
    work = (r, x, np.empty(total), r, lower, np.empty(total, dtype=np.int64), np.empty(total), x)
    scratch = np.empty(total), np.empty((2, n)), np.empty((2, total))
    for f in range(len(frames)):
        b, t, w = frames[f], drags[f], weights[f]
        for j in range(total):
            on[j] = guess[f, j] > 0.0
        factor, chi2 = 1.0, math.inf
        while True:
            count, turned = _settle(level, t, most, w, b, along[f], on, near, work, scratch)
            chi2 = 0.0
            for i in range(n):
                chi2 += r[i] * r[i]
            if len(out) == 0:
                break
            if count < 0:
                factor = 9.0  # too little smoothness for the arithmetic
            elif chi2 <= largest or factor > 1.0:
                break
            else:
                factor = 1.0 / 9.0  # too smooth for these readings
            if not lowest <= w * factor <= highest:
                break
            w *= factor
        for j in range(total):
            guess[f, j] = x[j] if count >= 0 else 0.0
        if len(out) == 0:
            continue
        row = out[f]
        row[column.RESIDUAL], row[column.WEIGHT] = chi2, w
        if count < 0 or not chi2 <= largest:
            row[column.STATUS] = _UNEXPLAINED
            continue
        _totals(row, level, work, count, t, turned, scratch[2], scratch[0], y, z)
        row[column.AREA_WIDTH :] = x
