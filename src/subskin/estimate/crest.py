"""Compiled: S of a point load along its crest, where each distance beside the row has its best position.

S of a row of strains may have two tops there, or hardly fall: then neither the scan nor the curvature at the top knows
of the other end, and a parabola does not say how far the position is in doubt.
"""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled
from .kinds import WIDE_FIT, Across, climb_wide, modelled, until
from .layout import BESIDE
from .project import whitened
from .varpro import Limits

_STEPS = 12
"""Distances that are looked at on each side of the one that was found."""
_APART = 4.0
"""Standard errors beyond which another position contradicts the answer."""
_OK, _LEFT_OPEN = 0.0, 0.5  # as of `beside`, which imports this file
_WITH_AWAY, _OF_AWAY = (int(BESIDE.square[i, 3]) - BESIDE.covariance for i in (0, 3))
"""Where the covariance of y and the distance, and the distance's variance, stand."""


@compiled()
def look_along(readings, sensors, table, settings, pace, out):
    """Leave frames of `out` open whose crest is as high elsewhere, and widen the variance of y of the others.

    It becomes that at one distance and the second moment of exp(S / 2) along the crest, if that is more. pace [m]: from
    one distance to the next; all else as of `project.project_frames`, of points beside a row.
    """
    told, w, fits = settings[0], np.empty(readings.shape[1]), np.zeros(2, WIDE_FIT)
    model, cone, ending = modelled(table, told), Limits(told.friction, told.least, told.most), until(1e-7)
    ends = np.array([told.first, told.last, told.least_square, told.most_square])
    held, fit = ends.copy(), fits[0]
    y_at, q_at, height = np.empty(_STEPS + 2), np.empty(_STEPS + 2), np.empty(_STEPS + 2)
    for f in range(len(readings)):
        row = out[f]
        if row.status != _OK:
            continue
        highest = whitened(readings[f], sensors, w) - row.residual
        enough, apart = highest - told.ambiguity, _APART * math.sqrt(row.covariance[0])
        weight, moment = 1.0, 0.0
        for side in range(2):
            y, before, count = row.y, row.half_width, 0
            for k in range(_STEPS):
                z = row.half_width + (k + 1) * (pace if side == 0 else -pace)
                if z * z > told.most_square or (side == 1 and before <= 0.0):
                    break
                z = before = max(z, 0.0)
                held[2] = held[3] = z * z
                climb_wide(w, model, cone, held, Across(y, z * z), ending, fit, fits[1])
                y = y_at[count] = fit.y
                q_at[count], height[count] = fit.q, fit.explained
                share = math.exp(0.5 * min(fit.explained - highest, 0.0))
                weight += share
                moment += share * (y - row.y) ** 2
                count += 1
            for k in range(count):
                top = (k == 0 or height[k] >= height[k - 1]) and (k == count - 1 or height[k] >= height[k + 1])
                y, s = y_at[k], height[k]
                if top and s <= enough:  # the crest is narrow: its top lies between two distances
                    climb_wide(w, model, cone, ends, Across(y, q_at[k]), ending, fit, fits[1])
                    y, s = fit.y, fit.explained
                if s > enough and abs(y - row.y) > apart:
                    row.status = _LEFT_OPEN
        c = row.covariance
        across = c[0] - c[_WITH_AWAY] ** 2 / c[_OF_AWAY]
        if across > 0.0:
            c[0] = max(c[0], across + moment / weight)
