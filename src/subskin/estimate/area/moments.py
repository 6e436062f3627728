"""Compiled: the covariance of a point load that few sensors felt, where chi-square is no parabola.

With one to four readings to spare the curvature at the top says too little: a joint 95 % region by it holds 66 to 94 %
of loads (`benchmarks/study_joint.py`). So it is the second moment about the top of exp(S / 2) over positions on a grid,
each with the best forces there and their own covariance (docs/locating_area.md).
"""

from __future__ import annotations

import math

from ..._compiled import compiled
from ..cone import cofactors
from .fall import root_of
from .point import Point, project

__all__ = ["FEW_SENSORS", "moments"]

FEW_SENSORS = 9
_REACH = 4
"""Standard deviations to either side of the top, one apart: sums over a bell that go by its width are exact."""
_STEEP = 9.0
"""Fall of S, to a deviation on both sides of the top, from which they are too far apart."""
_YY, _YZ, _ZZ, _UNKNOWNS = 0, 1, 5, 5


@compiled(borrows=True)
def moments(w, model, limits, box, fit, root, trial, spread):
    """Make the covariance `spread` (15,) of (y, z, N, Ty, Tz) at the top in fit that of all that explain the frame.

    box (4,): ends of y, then of z; root (3,), trial: scratch.
    """
    widest_y, widest_z = (box[1] - box[0]) / (2.0 * _REACH), (box[3] - box[2]) / (2.0 * _REACH)
    if not (0.0 < spread[_YY] < widest_y * widest_y and 0.0 < spread[_ZZ] < widest_z * widest_z):
        return  # the sum would end with the search
    root_of(spread[_YY], spread[_YZ], spread[_ZZ], root)
    steep, aside = 0, 0
    for side in (-1.0, 1.0):
        project(w, model, limits, Point(fit.y + side * root[0], fit.z + side * root[1]), trial)
        steep += fit.explained - trial.explained > _STEEP
        project(w, model, limits, Point(fit.y + side * root[1], fit.z + side * root[2]), trial)
        aside += fit.explained - trial.explained > _STEEP
    if steep == 2 or aside == 2:  # S falls far more steeply than the deviations say
        return
    total = 0.0
    for k in range(spread.size):  # what it was is in root
        spread[k] = 0.0
    for i in range(-_REACH, _REACH + 1):
        for j in range(-_REACH, _REACH + 1):
            dy, dz = root[0] * i + root[1] * j, root[1] * i + root[2] * j
            at = Point(fit.y + dy, fit.z + dz)
            if not (box[0] <= at.y <= box[1] and box[2] <= at.z <= box[3]):
                continue
            project(w, model, limits, at, trial)
            nn, n_ty, n_tz, ty_ty, ty_tz, tz_tz, det = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, trial.g_n_n
            if limits.friction > 0.0:
                nn, n_ty, n_tz, ty_ty, ty_tz, tz_tz, det = cofactors(
                    trial.g_n_n, trial.g_n_ty, trial.g_n_tz, trial.g_ty_ty, trial.g_ty_tz, trial.g_tz_tz
                )
            if not det > 0.0:
                continue
            share = math.exp(0.5 * (trial.explained - fit.explained)) / math.sqrt(det)
            total += share
            away, k = (dy, dz, trial.n - fit.n, trial.ty - fit.ty, trial.tz - fit.tz), 0
            own = (
                0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
                nn / det, n_ty / det, n_tz / det, ty_ty / det, ty_tz / det, tz_tz / det,
            )  # fmt: skip
            for p in range(_UNKNOWNS):
                for q in range(p, _UNKNOWNS):
                    spread[k] += share * (away[p] * away[q] + own[k])
                    k += 1
    over = 1.0 / total if total > 0.0 else math.inf
    for k in range(spread.size):
        spread[k] *= over
