"""The compiled heart of placement on an area: touches against every other load that would read like them.

As `_kernel.py` has it for rows: the readings of a touch, free of noise, leave a chi-square L at every other position,
with the forces there eliminated and held within the cone, exactly, by the loops of `locate`. Where L has a minimum of
its own stands a rival.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ...estimate.area.fall import drops, root_of
from ...estimate.area.point import FIT, ROWS, Point, PointModel, climb
from ...estimate.cone import eliminate_three
from ...estimate.varpro import Ending, Limits

_SURE = 4.75  # standard deviations: a rival farther off than this wins, or ties, once in a million touches
_FINE = 1e-4
_BROAD, _TINY = 6.1, 12  # standard deviations beyond which a load has to fit worse, where sensors are so few
_FAR, _LEVEL = 4.0, 4.0  # as of `judge.look_round`: standard deviations off the top, and the least fall there
_CURVED = 0.2  # of the distance within which two are not far apart: from there on the top need be no parabola
_MOST = 24


@compiled()
def _normal(z):
    """Standard normal distribution function."""
    return 0.5 * math.erfc(-0.7071067811865476 * z)


@compiled()
def survey(readings, truth, spread, model, fields, forms, grid, mu, box, limits, out):
    """Fill `out` (touches, 3): probability that `locate` calls it AMBIGUOUS, that a rival wins, that it is not noticed.

    readings (touches, n): in units of noise; truth (touches, 2); spread (touches, 3): variances yy, yz, zz of the
    position found, infinite where it is not determined; model: without its scratch; fields (nodes, 3, n): readings
    under unit forces at the nodes where loads are looked for, those along z beside each other; forms (2, nodes, 3, 3):
    A^T A and its inverse; grid (2, 3): first, step and count of y and of z; box: ends of y and z; limits: least
    chi-square of a contact, `ambiguity`, distance within which two minima are one, and within which they are not far
    apart.
    """
    n = readings.shape[1]
    rows, columns = int(grid[0, 2]), int(grid[1, 2])
    first_y, step_y, first_z, step_z = grid[0, 0], grid[0, 1], grid[1, 0], grid[1, 1]
    nodes = rows * columns
    detection, ambiguity, apart, wide = limits[0], limits[1], limits[2], limits[3]
    cap = (_SURE + math.sqrt(_SURE * _SURE + ambiguity)) ** 2
    left, at, rivals_at = np.empty(nodes), np.empty(_MOST, dtype=np.int64), np.empty((_MOST, 2))
    fits, scratch, cone = np.empty(3, FIT), np.empty((ROWS, n)), Limits(mu, 0.0, math.inf)
    fit, trial, best = fits[0], fits[1], fits[2]
    root, fall, side = np.empty(3), np.empty(8), np.empty(4)
    mine = PointModel(model.sensors, model.first, model.table, model.terms, scratch, scratch.view(np.int64))
    for f in range(readings.shape[0]):
        w = readings[f]
        y, z, yy, yz, zz = truth[f, 0], truth[f, 1], spread[f, 0], spread[f, 1], spread[f, 2]
        total = 0.0
        for i in range(n):
            total += w[i] * w[i]
        over = math.sqrt(total + 3.0) - math.sqrt(detection)
        unfelt = _normal(-over) if over < 8.0 else 0.0
        det, unsure, widened = yy * zz - yz * yz, 1.0, math.inf
        if yy + zz < math.inf and det > 0.0:
            inside_y, inside_z = min(y - box[0], box[1] - y), min(z - box[2], box[3] - z)
            unsure = max(_normal(-inside_y / math.sqrt(yy)), _normal(-inside_z / math.sqrt(zz)))
            if yy + zz > _CURVED * _CURVED * wide * wide:  # the top may be no parabola: `judge.look_round`
                root_of(yy, yz, zz, root)
                fit.y, fit.z, fit.explained, best.explained = y, z, total, math.inf
                drops(w, mine, cone, box, fit, root, _FAR, trial, best, fall)
                widened = 0.0
                for k in range(fall.size):
                    unsure = 1.0 if fall[k] < _LEVEL else unsure
                    widened += min(max(_FAR * _FAR / max(fall[k], 1e-9), 0.1), 9.0) / fall.size
                widened = max(widened, 1.0)
        # S is bounded by that of any force, which is quick; what is left out leaves half of the readings
        least = min(0.5 * total, total - 2.0 * cap)
        for m in range(nodes):
            b0 = b1 = b2 = 0.0
            for i in range(n):
                b0 += w[i] * fields[m, 0, i]
                b1 += w[i] * fields[m, 1, i]
                b2 += w[i] * fields[m, 2, i]
            g, h = forms[0, m], forms[1, m]
            free = b0 * (h[0, 0] * b0 + 2.0 * (h[0, 1] * b1 + h[0, 2] * b2)) + b1 * (h[1, 1] * b1 + 2.0 * h[1, 2] * b2)
            left[m] = total
            if free + h[2, 2] * b2 * b2 > least:
                _, _, _, explained, _, _, _, _, _, _, _ = eliminate_three(
                    g[0, 0], g[0, 1], g[0, 2], g[1, 1], g[1, 2], g[2, 2], b0, b1, b2, mu
                )
                left[m] = total - explained
        enough = Ending(0.05, 1e-3 * apart, 0.0, total - ambiguity)
        count = 0
        for j in range(rows):
            for k in range(columns):
                here = left[j * columns + k]
                if not here < total - least:
                    continue
                if here < 4.0 * cap and unsure < 1.0:  # as good, and far beyond the errors of the best: a broad top
                    dy, dz = first_y + j * step_y - y, first_z + k * step_z - z
                    far = (zz * dy * dy - 2.0 * yz * dy * dz + yy * dz * dz) / det
                    if far > 36.0 and dy * dy + dz * dz > wide * wide:
                        unsure = max(unsure, _normal((ambiguity - here) / (2.0 * math.sqrt(max(here, 1e-12)))))
                lowest = True
                for e in range(max(j - 1, 0), min(j + 2, rows)):
                    for d in range(max(k - 1, 0), min(k + 2, columns)):
                        lowest &= not left[e * columns + d] < here
                if lowest and count < _MOST:
                    at[count] = j * columns + k
                    count += 1
        for q in range(4 if n <= _TINY else 0):  # a top as a banana is: as good far along y or z, the other one free
            if unsure == 1.0 or not widened < math.inf:
                break
            off = (2 * (q % 2) - 1) * _BROAD * math.sqrt(widened * (yy if q < 2 else zz))
            to_y, to_z = (y + off, z + off * yz / yy) if q < 2 else (y + off * yz / zz, z + off)
            if not (box[0] < to_y < box[1] and box[2] < to_z < box[3] and abs(off) > wide):
                continue
            side[:] = box
            side[2 * (q // 2)] = side[2 * (q // 2) + 1] = to_y if q < 2 else to_z
            climb(w, mine, cone, side, Point(to_y, to_z), enough, fit, trial)
            unsure = 1.0 if total - fit.explained < ambiguity else unsure
        for q in range(4):  # as good at a side of the search
            if unsure == 1.0:
                break
            side[:] = box
            low, at_y, at_z = total - least, 0.0, 0.0
            for e in range(columns if q < 2 else rows):
                j, k = (e, (columns - 1) * (q % 2)) if q > 1 else ((rows - 1) * (q % 2), e)
                if left[j * columns + k] < low:
                    low, at_y, at_z = left[j * columns + k], first_y + j * step_y, first_z + k * step_z
            if not low < total - least:
                continue
            side[2 * (q // 2)] = side[2 * (q // 2) + 1] = box[q]
            climb(w, mine, cone, side, Point(at_y, at_z), enough, fit, trial)
            unsure = 1.0 if total - fit.explained < ambiguity else unsure
        clear, odds, rivals = 1.0, 0.0, 0
        for c in range(count):
            j, k = at[c] // columns, at[c] % columns
            start = Point(first_y + j * step_y, first_z + k * step_z)
            climb(w, mine, cone, box, start, Ending(_FINE, 1e-3 * apart, 0.0, total - 4.0 * cap), fit, trial)
            here, off = max(total - fit.explained, 1e-12), math.hypot(fit.y - y, fit.z - z)
            if here > cap or off < apart:
                continue
            again = False  # two starts may end at one rival
            for d in range(rivals):
                again |= math.hypot(fit.y - rivals_at[d, 0], fit.z - rivals_at[d, 1]) < 5.0 * apart
            if again:
                continue
            rivals_at[rivals, 0], rivals_at[rivals, 1] = fit.y, fit.z
            rivals += 1
            far = math.sqrt(here)
            clear *= 1.0 - (_normal((ambiguity - here) / (2.0 * far)) - _normal((-ambiguity - here) / (2.0 * far)))
            if off > wide:
                wins = _normal(-0.5 * far)
                odds += wins / (1.0 - wins)
        out[f, 0] = (1.0 - unfelt) * (1.0 - (1.0 - unsure) * clear)
        out[f, 1] = (1.0 - unfelt) * odds / (1.0 + odds)
        out[f, 2] = unfelt
