"""Compiled: S of a point load along its crest, where each distance beside the row has its best position.

S of a row of strains may have two tops there, or hardly fall: then neither the scan nor the curvature at the top knows
of the other end, and a parabola does not say how far the position is in doubt.
"""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled
from .climb import climb_wide
from .layout import BESIDE
from .project import whitened

_STEPS = 12
"""Distances that are looked at on each side of the one that was found."""
_APART = 4.0
"""Standard errors beyond which another position contradicts the answer."""
_OK, _AMBIGUOUS = 0.0, 1.0
_STATUS, _AWAY, _RESIDUAL = BESIDE.status, BESIDE.half_width, BESIDE.residual
_VARIANCE, _WITH_AWAY, _OF_AWAY = BESIDE.covariance, int(BESIDE.square[0, 3]), int(BESIDE.square[3, 3])


@compiled()
def look_along(readings, sensors, table, options, pace, out):
    """Make frames of `out` AMBIGUOUS whose crest is as high elsewhere, and widen the variance of y of the others.

    It becomes that at one distance and the second moment of exp(S / 2) along the crest, if that is more. pace [m]: from
    one distance to the next; all else as of `project.project_frames`, of points beside a row.
    """
    n = readings.shape[1]
    w, fit = np.empty(n), np.empty(14)
    a, c = np.empty((2, 6, 2 * n)), np.empty((3, 10 * n + table.shape[1] + 3))
    held = options[11:15].copy()
    y_at, q_at, height = np.empty(_STEPS + 2), np.empty(_STEPS + 2), np.empty(_STEPS + 2)
    for f in range(len(readings)):
        row = out[f]
        if row[_STATUS] != _OK:
            continue
        highest = whitened(readings[f], sensors, w) - row[_RESIDUAL]
        enough, apart = highest - options[7], _APART * math.sqrt(row[_VARIANCE])
        weight, moment = 1.0, 0.0
        for side in range(2):
            y, before, count = row[0], row[_AWAY], 0
            for k in range(_STEPS):
                z = row[_AWAY] + (k + 1) * (pace if side == 0 else -pace)
                if z * z > options[14] or (side == 1 and before <= 0.0):
                    break
                z = before = max(z, 0.0)
                held[2] = held[3] = z * z
                y, q = climb_wide(
                    w, table, options[0], options[1], options[10], options[4], y, z * z, held, c, a, fit, options[15],
                    options[16],
                )  # fmt: skip
                y_at[count], q_at[count], height[count] = y, q, fit[2]
                share = math.exp(0.5 * min(fit[2] - highest, 0.0))
                weight += share
                moment += share * (y - row[0]) ** 2
                count += 1
            for k in range(count):
                top = (k == 0 or height[k] >= height[k - 1]) and (k == count - 1 or height[k] >= height[k + 1])
                y, s = y_at[k], height[k]
                if top and s <= enough:  # the crest is narrow: its top lies between two distances
                    y, _ = climb_wide(
                        w, table, options[0], options[1], options[10], options[4], y, q_at[k], options[11:15], c, a,
                        fit, options[15], options[16],
                    )  # fmt: skip
                    s = fit[2]
                if s > enough and abs(y - row[0]) > apart:
                    row[_STATUS] = _AMBIGUOUS
        across = row[_VARIANCE] - row[_WITH_AWAY] ** 2 / row[_OF_AWAY]
        if across > 0.0:
            row[_VARIANCE] = max(row[_VARIANCE], across + moment / weight)
