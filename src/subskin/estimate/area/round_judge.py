"""Compiled: how sure the best round contact of a frame is: other tops, the width's interval, the search's sides."""

from __future__ import annotations

import math

from ..._compiled import compiled
from .judge import FINE
from .round_climb import round_climb, round_curvature
from .scan import taken, within

MORE = 6
"""Climbs of `further_tops`."""
_SURE, _SURE2 = 1.959964, 3.841459
"""Standard deviations of a 95 % interval, and the rise of chi-square at its ends."""
_TRIES = 5
_LEAST = 0.2
"""Least rise of chi-square that says how it rises further."""


@compiled(borrows=True)
def _one(first, other, h, apart):
    """Whether two tops are one: within a standard deviation, by the information h of the first, or near each other."""
    dy, dz, dq = other[36] - first[36], other[37] - first[37], other[38] - first[38]
    far = h[0, 0] * dy * dy + h[1, 1] * dz * dz + h[2, 2] * dq * dq
    far += 2.0 * (h[0, 1] * dy * dz + h[0, 2] * dy * dq + h[1, 2] * dz * dq)
    wider = abs(math.sqrt(other[38]) - math.sqrt(first[38]))
    return far < 1.0 or (abs(dy) + abs(dz) < apart and wider < apart)


@compiled(borrows=True)
def ranked(tops, count, h, apart):
    """Best and second-best of the first `count` tops, -1 where there is none; the best one's information into h."""
    best = second = -1
    for p in range(count):
        if best < 0 or tops[p, 3] > tops[best, 3]:
            best = p
    if best < 0:
        return best, second
    round_curvature(tops[best], h)
    for p in range(count):
        if (second < 0 or tops[p, 3] > tops[second, 3]) and not _one(tops[best], tops[p], h, apart):
            second = p
    return best, second


@compiled(borrows=True)
def further_tops(w, model, mu, box, away, best, count, room, tops, trial):
    """Climb again from four sides of the best top, and from the least and the largest width; how many tops there are.

    Few sensors leave pairs of tops near each other.
    """
    y, z, q = tops[best, 36], tops[best, 37], tops[best, 38]
    for side in range(MORE):
        to_y = y + (away if side == 0 else -away if side == 1 else 0.0)
        to_z = z + (away if side == 2 else -away if side == 3 else 0.0)
        to_q = box[4] if side == 4 else box[5] if side == 5 else q
        if side < 4 or abs(math.sqrt(to_q) - math.sqrt(q)) > away:
            round_climb(w, model, mu, box, to_y, to_z, to_q, FINE, room, tops[count], trial)
            count += 1
    return count


@compiled(borrows=True)
def width_profile(w, model, mu, box, best, h, only, room, trials, sides):
    """The 95 % interval of q into sides[:2, 6], and how far the others move with a standard deviation of it, sides[2].

    At each end chi-square is 1.96^2 above the least, all but q fitted anew, or the search for q ends. best: a top; h:
    its information; only (6,), sides (3, 7): scratch, the last of the others being the moment. False where S is larger
    at another width: trials[0] is there.
    """
    fit = trials[0]
    minor = h[0, 0] * h[1, 1] - h[0, 1] * h[0, 1]
    first, second = h[1, 1] * h[0, 2] - h[0, 1] * h[1, 2], h[0, 0] * h[1, 2] - h[0, 1] * h[0, 2]
    told = h[2, 2] - (h[0, 2] * first + h[1, 2] * second) / minor
    q, whole = best[38], box[5] - box[4]
    reach = _SURE / math.sqrt(told) if told * whole * whole > _SURE2 else whole
    for k in range(4):
        only[k] = box[k]
    shut = 0
    for side in range(2):
        sign, limit = (1.0 if side else -1.0), box[4 + side]
        sides[side, 6], closed, drop = limit, True, 0.0
        to, y, z = q + sign * reach, best[36], best[37]
        for k in range(6):
            sides[side, k] = 0.0
        for _ in range(_TRIES if limit != q else 0):
            here = min(max(to, box[4]), box[5])
            only[4] = only[5] = here
            round_climb(w, model, mu, only, y, z, here, 0.1 * FINE, room, fit, trials[1])
            drop, y, z = best[3] - fit[3], fit[36], fit[37]
            if drop < -0.1:
                return False
            sides[side, 6], closed = here, here == limit and drop < _SURE2
            if closed or abs(drop - _SURE2) < 0.05 * _SURE2:
                break
            to = q + (here - q) * min(max(math.sqrt(_SURE2 / max(drop, _LEAST)), 0.3), 3.0)
        if closed:
            shut += 1 + side
        else:
            longer = math.sqrt(_SURE2 / max(drop, _LEAST))
            sides[side, 6] = min(max(q + (sides[side, 6] - q) * longer, box[4]), box[5])
        if limit != q:
            deviations = sign * (_SURE if closed else math.sqrt(max(drop, _LEAST)))
            for k in range(6):
                at = 36 + k if k < 2 else k - 2 if k < 5 else 39
                sides[side, k] = (fit[at] - best[at]) / deviations
    for k in range(6):  # the side that the search cuts short says less than the other one
        low, high = sides[0, k], sides[1, k]
        larger = high if abs(high) > abs(low) else low
        sides[2, k] = high if shut == 1 else low if shut == 2 else larger if shut == 3 else 0.5 * (low + high)
    return True


@compiled(borrows=True)
def contact_outside(
    w, single, model, mu, tiles, nodes, t, widths, least, seen, boxes, box, only, picked, room, c, s, trials
):  # fmt: skip
    """Whether S reaches `least` at a side of the search, or beyond, at any width, tried where the scan is over `seen`.

    picked (4, 4): scratch, of each box the best node of the scans: what S may be near it, y, z, q; trials: two fits.
    """
    index, origin, _, _, shapes = tiles
    for b in range(4):
        picked[b, 0] = seen
        picked[b, 3] = -1.0
    for j in range(widths.size):
        e = t + j * (w.size + 1)
        m, count, start = index[e, 3], index[e, 6], int(origin[e, 0])
        if count == 0:
            continue
        taken(single, single, tiles, e, c, c)
        within(shapes[index[e, 4] : index[e, 4] + 9 * m].reshape((9, m)), mu, c, s[:m])
        for p in range(count):
            b = int(nodes[start + p, 2])
            if s[p] >= nodes[start + p, 3] * picked[b, 0]:
                picked[b, 0] = s[p] / nodes[start + p, 3]
                picked[b, 1], picked[b, 2], picked[b, 3] = nodes[start + p, 0], nodes[start + p, 1], widths[j]
    only[4], only[5] = box[4], box[5]
    for b in range(4):
        if picked[b, 3] >= 0.0:
            for k in range(4):
                only[k] = boxes[b, k]
            y, z, q = picked[b, 1], picked[b, 2], picked[b, 3]
            round_climb(w, model, mu, only, y, z, q, 0.05, room, trials[0], trials[1])
            if trials[0, 3] > least:
                return True
    return False
