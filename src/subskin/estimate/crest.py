"""Compiled: S of a point load along its crest, where each distance beside the row has its best position.

S of a row of strains may have two tops there, or hardly fall: then neither the scan nor the curvature at the top knows
of the other end, and a parabola does not say how far the position is in doubt.
"""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled
from .kinds import LINE_FIT, LINE_ROWS, WIDE_FIT, Across, Along, Line, climb_line, climb_wide, modelled, until
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
def look_along(readings, sensors, table, settings, nodes, pace, stride, out):
    """Leave frames of `out` open whose crest is as high elsewhere, and widen the variance of y of the others.

    It becomes that at one distance and the second moment of exp(S / 2) along the crest, if that is more. nodes
    (distances, cells, 5, 2, n): whitened tables of points at each distance beside the row, `pace` [m] apart from 0 on,
    every `stride` of which is looked at; all else as of `project.project_frames`, of points beside a row.
    """
    told, w, n = settings[0], np.empty(readings.shape[1]), readings.shape[1]
    fits, wide = np.zeros(2, LINE_FIT), np.zeros(2, WIDE_FIT)
    model, cone, ending = modelled(table, told), Limits(told.friction, told.least, told.most), until(1e-7)
    ends = np.array([told.first, told.last, told.least_square, told.most_square])
    held, fit, free, rows = ends[:2].copy(), fits[0], wide[0], np.empty((LINE_ROWS, n))
    y_at, z_at, height = np.empty(_STEPS + 2), np.empty(_STEPS + 2), np.empty(_STEPS + 2)
    for f in range(len(readings)):
        row = out[f]
        if row.status != _OK:
            continue
        highest = whitened(readings[f], sensors, w) - row.residual
        enough, apart = highest - told.ambiguity, _APART * math.sqrt(row.covariance[0])
        weight, moment = 1.0, 0.0
        for side in range(2):
            y, count = row.y, 0
            here = row.half_width / pace
            k = math.floor(here) + 1 if side == 0 else math.ceil(here) - 1
            while count < _STEPS and 0 <= k < len(nodes):
                climb_line(w, Line(nodes[k], told.start, told.step, rows), cone, held, Along(y), ending, fit, fits[1])
                y = y_at[count] = fit.y
                z_at[count], height[count] = k * pace, fit.explained
                share = math.exp(0.5 * min(fit.explained - highest, 0.0))
                weight += share
                moment += share * (y - row.y) ** 2
                count += 1
                k += stride if side == 0 else -stride
            for k in range(count):
                top = (k == 0 or height[k] >= height[k - 1]) and (k == count - 1 or height[k] >= height[k + 1])
                y, s = y_at[k], height[k]
                if top and s <= enough:  # the crest is narrow: its top lies between two distances
                    climb_wide(w, model, cone, ends, Across(y, z_at[k] ** 2), ending, free, wide[1])
                    y, s = free.y, free.explained
                if s > enough and abs(y - row.y) > apart:
                    row.status = _LEFT_OPEN
        c = row.covariance
        across = c[0] - c[_WITH_AWAY] ** 2 / c[_OF_AWAY]
        if across > 0.0:
            c[0] = max(c[0], across + moment / weight)
