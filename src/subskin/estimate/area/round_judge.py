"""Compiled: how sure the best round contact of a frame is: other tops, the width's interval, the search's sides."""

from __future__ import annotations

import math

from ..._compiled import compiled
from ..varpro import Ending
from .judge import FINE, best_beyond
from .round_contact import RoundAt, climb, information

LOW, HIGH = 4, 5
"""Where a box has the ends of q."""
TURN, END, MOVES = 5, 6, 7
"""Where a side has the move of a moment, and the end of q; before these stand the moves of y, z, N, Ty and Tz."""
MORE = 6
"""Climbs of `further_tops`."""
_SURE, _SURE2 = 1.959964, 3.841459
"""Standard deviations of a 95 % interval, and the rise of chi-square at its ends."""
_TRIES = 5
_LEAST = 0.2
"""Least rise of chi-square that says how it rises further."""


@compiled(inline=True)
def uphill(gain):
    """A climb over position and width ends with a step that raises S by less than this."""
    return Ending(gain, 0.0, 0.0, -math.inf)


@compiled(borrows=True)
def _one(first, other, apart):
    """Whether two tops are one: within a standard deviation, by the information of the first, or near each other."""
    dy, dz, dq, told = other.y - first.y, other.z - first.z, other.q - first.q, information(first)
    far = told.y_y * dy * dy + told.z_z * dz * dz + told.q_q * dq * dq
    far += 2.0 * (told.y_z * dy * dz + told.y_q * dy * dq + told.z_q * dz * dq)
    wider = abs(math.sqrt(other.q) - math.sqrt(first.q))
    return far < 1.0 or (abs(dy) + abs(dz) < apart and wider < apart)


@compiled(borrows=True)
def ranked(tops, count, apart):
    """Best and second-best of the first `count` tops, -1 where there is none."""
    best = second = -1
    for p in range(count):
        if best < 0 or tops[p].explained > tops[best].explained:
            best = p
    for p in range(count):
        if (second < 0 or tops[p].explained > tops[second].explained) and not _one(tops[best], tops[p], apart):
            second = p
    return best, second


@compiled(borrows=True)
def further_tops(w, model, limits, box, away, best, count, tops, trial):
    """Climb again from four sides of the best top, and from the least and the largest width; how many tops there are.

    Few sensors leave pairs of tops near each other.
    """
    top = tops[best]
    y, z, q = top.y, top.z, top.q
    for side in range(MORE):
        to_y = y + (away if side == 0 else -away if side == 1 else 0.0)
        to_z = z + (away if side == 2 else -away if side == 3 else 0.0)
        to_q = box[LOW] if side == 4 else box[HIGH] if side == 5 else q
        if side < 4 or abs(math.sqrt(to_q) - math.sqrt(q)) > away:
            climb(w, model, limits, box, RoundAt(to_y, to_z, to_q), uphill(FINE), tops[count], trial)
            count += 1
    return count


@compiled(inline=True)
def _moved(fit, best, deviations, moves):
    """How far a standard deviation of the width moves y, z, N, Ty, Tz and the moment."""
    over = 1.0 / deviations
    moves[0], moves[1] = over * (fit.y - best.y), over * (fit.z - best.z)
    moves[2], moves[3], moves[4] = over * (fit.n - best.n), over * (fit.ty - best.ty), over * (fit.tz - best.tz)
    moves[TURN] = over * (fit.moment - best.moment)


@compiled(borrows=True)
def width_profile(w, model, limits, box, best, only, trials, sides):
    """The 95 % interval of q into sides[:2, 6], and how far the others move with a standard deviation of it, sides[2].

    At each end chi-square is 1.96^2 above the least, all but q fitted anew, or the search for q ends. best: a top;
    only (6,), sides (3, 7): scratch, the last of the others being the moment. False where S is larger at another width:
    trials[0] is there.
    """
    fit, told = trials[0], information(best)
    minor = told.y_y * told.z_z - told.y_z * told.y_z
    first, second = told.z_z * told.y_q - told.y_z * told.z_q, told.y_y * told.z_q - told.y_z * told.y_q
    alone = told.q_q - (told.y_q * first + told.z_q * second) / minor
    q, whole = best.q, box[HIGH] - box[LOW]
    reach = _SURE / math.sqrt(alone) if alone * whole * whole > _SURE2 else whole
    for k in range(4):
        only[k] = box[k]
    shut = 0
    for side in range(2):
        sign, limit = (1.0 if side else -1.0), box[LOW + side]
        sides[side, END], closed, drop = limit, True, 0.0
        to, y, z = q + sign * reach, best.y, best.z
        for k in range(6):
            sides[side, k] = 0.0
        for _ in range(_TRIES if limit != q else 0):
            here = min(max(to, box[LOW]), box[HIGH])
            only[LOW] = only[HIGH] = here
            climb(w, model, limits, only, RoundAt(y, z, here), uphill(0.1 * FINE), fit, trials[1])
            drop, y, z = best.explained - fit.explained, fit.y, fit.z
            if drop < -0.1:
                return False
            sides[side, END], closed = here, here == limit and drop < _SURE2
            if closed or abs(drop - _SURE2) < 0.05 * _SURE2:
                break
            to = q + (here - q) * min(max(math.sqrt(_SURE2 / max(drop, _LEAST)), 0.3), 3.0)
        if closed:
            shut += 1 + side
        else:
            longer = math.sqrt(_SURE2 / max(drop, _LEAST))
            sides[side, END] = min(max(q + (sides[side, END] - q) * longer, box[LOW]), box[HIGH])
        if limit != q:
            _moved(fit, best, sign * (_SURE if closed else math.sqrt(max(drop, _LEAST))), sides[side])
    for k in range(6):  # the side that the search cuts short says less than the other one
        low, high = sides[0, k], sides[1, k]
        larger = high if abs(high) > abs(low) else low
        sides[2, k] = high if shut == 1 else low if shut == 2 else larger if shut == 3 else 0.5 * (low + high)
    return True


@compiled(borrows=True)
def contact_outside(w, model, limits, beyond, widths, seen, least, mine, room):
    """Whether S reaches `least` at a side of the search, or beyond, at any width, tried where the scan is over `seen`.

    widths: the squares that are scanned there; mine: a `round_project._RoundRoom`; room: a `judge.Scratch`.
    """
    top, best, only, fit, single = room.ratio[:4], room.ratio[4:], mine.only, mine.others[0], mine.single
    for b in range(4):
        top[b], best[b] = seen, -1.0
    for i in range(w.size):
        single[i] = w[i]
    for j in range(widths.size):
        best_beyond(single, w.size, beyond, j, mine.kept, 0, limits.friction, mine.tried, top, best)
    only[LOW], only[HIGH] = mine.box[LOW], mine.box[HIGH]
    for b in range(4):
        if best[b] >= 0.0:
            p = int(best[b])
            for k in range(4):
                only[k] = beyond.boxes[b, k]
            at = RoundAt(beyond.nodes[p, 0], beyond.nodes[p, 1], widths[p // (beyond.nodes.shape[0] // widths.size)])
            climb(w, model, limits, only, at, uphill(0.05), fit, mine.others[1])
            if fit.explained > least:
                return True
    return False
