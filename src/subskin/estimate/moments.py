"""Compiled: the covariance of a line load whose position is known to no better than a sixtieth of a depth.

Chi-square is no parabola there. A joint 95 % region by its curvature holds 65 to 86 % of loads where strains are read
1.5 depths apart with 1 to 3 % noise, for force and angle change with the position (`benchmarks/study_joint.py`).
`area.moments` does the same on an area (docs/locating.md).
"""

from __future__ import annotations

import math

from .._compiled import compiled
from .kinds import Along, project_line

__all__ = ["line_moments", "widened"]

_REACH, _UNKNOWNS = 4, 3
"""Standard deviations to either side, one apart, over which loads are summed."""
_STEEP = 9.0
"""Fall of S, to a deviation on both sides of the top, from which the nodes of the sum are too far apart."""


@compiled()
def line_moments(w, model, fit, cone, told, trial, c):
    """Make the covariance c of (y, N, T) the second moment about the top of exp(S / 2), over loads of all positions.

    Each position has its best force, and that one's own covariance. The variance of y becomes no less than it was.
    told: settings; trial: scratch.
    """
    variance = c[0]
    deviation, total = math.sqrt(variance), 0.0
    # a parabola within what the scan resolves; and a sum that would end with the search
    if not 0.5 * told.pace <= deviation <= (told.last - told.first) / (2.0 * _REACH):
        return
    steep = 0
    for side in (-1.0, 1.0):
        project_line(w, model, cone, Along(fit.y + side * deviation), trial)
        steep += fit.explained - trial.explained > _STEEP
    if steep == 2:  # S falls far more steeply than that deviation says
        return
    for k in range(c.size):
        c[k] = 0.0
    for i in range(-_REACH, _REACH + 1):
        dy = deviation * i
        if not told.first <= fit.y + dy <= told.last:
            continue
        project_line(w, model, cone, Along(fit.y + dy), trial)
        nn, n_t, tt, det = 1.0, 0.0, 0.0, trial.g_n_n
        if cone.friction > 0.0:
            nn, n_t, tt, det = trial.g_t_t, -trial.g_n_t, trial.g_n_n, trial.g_n_n * trial.g_t_t - trial.g_n_t**2
        if not det > 0.0:
            continue
        share = math.exp(0.5 * (trial.explained - fit.explained)) / math.sqrt(det)
        total += share
        away, own, k = (dy, trial.n - fit.n, trial.t - fit.t), (0.0, 0.0, 0.0, nn / det, n_t / det, tt / det), 0
        for p in range(_UNKNOWNS):
            for q in range(p, _UNKNOWNS):
                c[k] += share * (away[p] * away[q] + own[k])
                k += 1
    over = 1.0 / total if total > 0.0 else math.inf
    for k in range(c.size):
        c[k] *= over
    widened(c, variance)


@compiled(inline=True)
def widened(c, variance):
    """Widen the covariance c of (y, N, T) along with y to a `variance` of y, where that is more."""
    if not variance > c[0] > 0.0:
        return
    y, n, t, extra = c[0], c[1], c[2], (variance / c[0] - 1.0) / c[0]
    first, k = (y, n, t), 0
    for i in range(_UNKNOWNS):
        for j in range(i, _UNKNOWNS):
            c[k] += extra * first[i] * first[j]
            k += 1
