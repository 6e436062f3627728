"""Compiled: whether a load far from the sensors could explain a frame, by bounds alone (`far.py`).

Eight frames go through the tree of regions side by side, each in its lane: which region is next is then asked once for
all of them, and a lane that is done with a part of the tree waits for the others.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..._lanes import alike, answers, eight, first_of, where

AT_ONCE = 4
"""Directions whose sums are added up side by side."""
FEW = 48
"""Sensors below which frames stand in lanes; of more, a frame by itself keeps the lanes full."""
_ROUNDING = np.float32(1.0 - 2e-5)
"""Sums in single precision are sure to fewer digits."""
_NOUGHT, _ONE, _FOUR, _NEVER = np.float32(0), np.float32(1), np.float32(4), np.float32(math.inf)


@compiled(inline=True)
def crowded(single, total, least, tile, far):
    """Whether a frame's strongest sensors have more of it than any load far away gives them, beside all of `least`."""
    cluster, share, out = far.cluster, far.share, False
    if share[tile] < 1.0:
        here = np.float32(0)
        for k in range(cluster.shape[1]):
            w = single[cluster[tile, k]]
            here += w * w
        if here > share[tile] * total:
            bound = math.sqrt(here * share[tile]) + math.sqrt(max(total - here, 0.0) * (1.0 - share[tile]))
            out = bound * bound < _ROUNDING * least
    return out


@compiled(borrows=True)
def _taken_by_one(directions, begin, count, single):
    """The squares of what `count` directions from `begin` on take of one frame."""
    n, taken = directions.shape[1], np.float32(0)
    for j in range(begin, begin + count):
        along = np.float32(0)
        for i in range(n):
            along += directions[j, i] * single[i]
        taken += along * along
    return taken


@compiled(inline=True)
def _taken(directions, begin, count, wide):
    """The squares of what `count` directions from `begin` on take of eight frames."""
    n, taken = directions.shape[1], alike(_NOUGHT)
    for j in range(begin, begin + count, AT_ONCE):
        c0, c1, c2, c3 = alike(_NOUGHT), alike(_NOUGHT), alike(_NOUGHT), alike(_NOUGHT)
        for i in range(n):
            w = eight(wide, 8 * i)
            c0 += w * directions[j, i]
            c1 += w * directions[j + 1, i]
            c2 += w * directions[j + 2, i]
            c3 += w * directions[j + 3, i]
        taken += (c0 * c0 + c1 * c1) + (c2 * c2 + c3 * c3)
    return taken


@compiled(exact=True, borrows=True)
def regions_left(singles, wide, asked, tile, far, kept):
    """The last regions of which a load may explain enough, into kept (regions, 2), and of which frames: how many.

    singles (8, n + 1): readings of eight frames in units of noise, and wide (n, 8) as well where there are less than
    `FEW` sensors; asked (3, 8): their squares added up, what is enough, infinite for a frame that is not asked, and
    scratch; tile: their strongest sensor, n where it is not sure; far: a `far.Far`; frames: as bits.
    """
    table, left, directions, seen = far.table, far.left, far.directions, far.seen
    total, least, until = eight(asked, 0), eight(asked, 8), alike(_NOUGHT)
    until = where(least < _NEVER, until, _NEVER)
    least = least * _ROUNDING
    i = found = 0
    regions = table.shape[0]
    while i < regions:
        here, after = np.float32(i), table[i, 2]
        asks = until <= here
        if seen[tile, i] == 0 or answers(asks) == 0:
            i = after
            continue
        square = left[i]
        if directions.shape[1] < FEW:
            taken = _taken(directions, table[i, 0], table[i, 1], wide)
        else:
            others = answers(asks)
            while others > 0:
                lane = first_of(others)
                others &= others - 1
                asked[2, lane] = _taken_by_one(directions, table[i, 0], table[i, 1], singles[lane])
            taken = eight(asked, 16)
        rest = total - taken
        # the bound is (sqrt(taken (1 - square)) + sqrt(rest square))^2; compared without its roots
        a, b = taken * (_ONE - square), rest * square
        over = least - a - b
        lower = asks & (rest > total * square) & (over > _NOUGHT) & (over * over > a * b * _FOUR)
        until = where(lower, np.float32(after), until)
        may = answers(until <= here)
        if may == 0:
            i = after
            continue
        if table[i, 3] == 1:
            kept[found, 0], kept[found, 1] = i, may
            found += 1
            if far.once == 1:
                until = where(until <= here, _NEVER, until)
                if answers(until < _NEVER) == 0:
                    break
        i += 1
    return found
