"""Compiled: point loads beside a row: how far the position is open along their crest, where each distance has its best
position; and columns of `BESIDE` as those of the loop that settles, and back.

In that loop the second coordinate is z^2 / aside, which the readings are smooth in.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..layout import BESIDE
from .given import SettledColumns
from .normal import NONE, copy_state, volume_of
from .variants import STEPS, lay_out, settle

_CONTACT = ("y", "away", "n", "t")
_FIELDS = [
    *((name, float) for name in _CONTACT), ("covariance", float, (10,)), ("residual", float),
    *((f"rival_{name}", float) for name in _CONTACT), *((name, float) for name in ("rival_chi2", "status", "size")),
]  # fmt: skip
SETTLED = np.dtype((np.record, _FIELDS))
"""A row of the loop that settles, of a point load beside a row; `away` is z^2 / aside."""
COLUMNS = SettledColumns(
    **{name: SETTLED.fields["rival_y" if name == "rival" else name][1] // 8 for name in SettledColumns._fields}  # type: ignore[index]
)
_ORDER = np.array([BESIDE.square[i, j] - BESIDE.covariance for i, j in
                   ((0, 0), (0, 3), (0, 1), (0, 2), (3, 3), (1, 3), (2, 3), (1, 1), (1, 2), (2, 2))])  # fmt: skip
"""Where the covariances of (y, away, n, t) stand among those of (y, n, t, z)."""
_OF_AWAY = np.array([0, 1, 0, 0, 2, 1, 1, 0, 0, 0])
"""How often `away` is in each."""
_SPREAD = 1.959964
_PACE, _HELD, _FAR, _BETTER = 0.5, 4, 40.0, 0.1
"""From one distance to the next [longest steps], steps at each, the chi-square from which one is out of the question,
and how much less of it another has to leave to be taken."""


@compiled()
def to_settled(found, aside, out):
    """Rows (f,) of `BESIDE` into those of `SETTLED`."""
    for f in range(len(found)):
        one, row = found[f], out[f]
        row.y, row.away, row.n, row.t = one.y, one.half_width**2 / aside, one.n, one.t
        row.rival_y, row.rival_away = one.rival_y, one.rival_half_width**2 / aside
        row.rival_n, row.rival_t, row.rival_chi2 = one.rival_n, one.rival_t, one.rival_chi2
        row.residual, row.status = one.residual, one.status
        row.covariance[:] = math.nan


@compiled()
def from_settled(rows, aside, out):
    """Rows (f,) of `SETTLED` into those of `BESIDE`."""
    for f in range(len(rows)):
        row, one = rows[f], out[f]
        square = row.away * aside
        z, spread = math.sqrt(square), _SPREAD * aside * math.sqrt(row.covariance[4])
        one.y, one.n, one.t, one.half_width = row.y, row.n, row.t, z
        one.low, one.high = math.sqrt(max(square - spread, 0.0)), min(math.sqrt(square + spread), aside)
        # near the row the readings know the square alone: the interval says how far the distance is known
        straight = 0.5 / z if z > 0.0 else math.inf
        about = straight
        if spread > 0.0:
            about = 0.5 * (math.sqrt(square + spread) - math.sqrt(max(square - spread, 0.0))) / spread
        turn = min(straight, about) * aside
        for k in range(10):
            one.covariance[_ORDER[k]] = row.covariance[k] * turn ** _OF_AWAY[k]
        one.rival_y, one.rival_n, one.rival_t = row.rival_y, row.rival_n, row.rival_t
        one.rival_half_width, one.rival_chi2 = math.sqrt(row.rival_away * aside), row.rival_chi2
        one.residual, one.status = row.residual, row.status


@compiled(borrows=True)
def _walked(w, case, side, left, least, room, best, trial):
    """Walk along the crest to one side of the load of `room`, which leaves so much.

    Returns how much more the best load leaves, if that is less than `least`, and the sums of exp(-more / 2) and of it
    times the square of the move in y. `best` becomes that load.
    """
    told, own = case.told, left + volume_of(room)
    weight, moment = 0.0, 0.0
    copy_state(room, trial)
    z = math.sqrt(room.at[1] * told.aside)
    while (side < 0.0 and z > 0.0) or (side > 0.0 and z < told.aside):
        z = min(max(z + side * _PACE * told.longest, 0.0), told.aside)
        trial.at[1] = z * z / told.aside
        more = settle(w, case, told.box, False, _HELD, 1, trial) + volume_of(trial) - own
        if not more < least + _FAR:
            break
        share = math.exp(-0.5 * max(more, -_FAR))
        weight += share
        moment += share * (trial.at[0] - room.at[0]) ** 2
        if more < least:
            least = more
            copy_state(trial, best)
    return least, weight, moment


@compiled(borrows=True)
def along_crest(w, case, left, room, best, trial):
    """Move `room` to the best load along its crest: what that leaves, and the mean square of the moves in y from it."""
    told = case.told
    if not left < math.inf:
        left = settle(w, case, told.box, False, STEPS, 1, room)
    moment = 0.0
    lay_out(w, case, False, room)  # its errors; of an exact finger nothing has done that
    for again in range(2):
        copy_state(room, best)
        least, weight, moment = _walked(w, case, -1.0, left, 0.0, room, best, trial)
        least, more, square = _walked(w, case, 1.0, left, least, room, best, trial)
        moment = (moment + square) / (1.0 + weight + more)
        if again or not least < -_BETTER:
            break
        copy_state(best, room)
        left = settle(w, case, told.box, False, STEPS, NONE, room)
        if not left < math.inf:
            copy_state(best, room)
            left = settle(w, case, told.box, False, STEPS, 1, room)
    return left, moment
