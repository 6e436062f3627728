"""Compiled: the best and the second-best top of S from the highest nodes of a tile."""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from .climb import climb
from .judge import FINE, MOST
from .scan import peaks, within

_SMALL = 24
"""Sensors of which all are fitted at once; of more, first those near the strongest."""


@compiled(inline=True)
def nearby(w, sensors, first, near_sensors, near_first, index, t, part):
    """Readings, sensors and rows of tables of those that count in tile t, where these are few; else all."""
    i0, k = index[t, 0], index[t, 1]
    near = w, sensors, first
    if 4 * k < 3 * w.size and w.size > _SMALL:
        its_first = near_first[i0 + t : i0 + t + k + 1]
        near = part[:k], near_sensors[4 * i0 : 4 * (i0 + k)].reshape((4, k)), its_first
    return near


@compiled(borrows=True)
def search(
    w, sensors, first, table, terms, tiles, near_sensors, near_first, t, most, share, options, scratch, whole, total, c,
    heights, lead, score, at, fits, part,
):  # fmt: skip
    """Best and second-best top of S from the highest nodes of tile t, as rows of `fits`; -1 where there is none.

    Of many sensors first those that count are fitted, then all; `part` keeps the readings of these. total, c: as of
    `scan.taken`.
    """
    index, origin, near, _, shapes = tiles
    mu, apart, smallest, box = options[0], options[4], options[8], options[9:13]
    i0, k, m, stride = index[t, 0], index[t, 1], index[t, 3], index[t, 6]
    within(shapes[index[t, 4] : index[t, 4] + 9 * m].reshape((9, m)), mu, c, heights[lead : lead + m])
    for p in range(lead + m, lead + m + stride + 2):
        heights[p] = np.float32(-1)
    near_w, its_sensors, its_first = nearby(w, sensors, first, near_sensors, near_first, index, t, part)
    few = near_w.size < w.size
    straight = 0.02 * options[5] if few else 0.0
    if few:
        for i in range(k):
            e = near[i0 + i]
            near_w[i] = w[e] if e < w.size else 0.0
    best = second = -1
    spare = MOST
    count = peaks(heights, lead, m, stride, total, share, score[:most], at)
    for q in range(count + 1):
        # a maximum clearly lower than both already found cannot become the best or the rival
        last = q == count or (second >= 0 and score[q] < 0.8 * fits[second, 3])
        if last and best <= 0:
            break
        p = best if last else q  # at last the best, if it was climbed roughly
        tolerance, needed = FINE, -math.inf
        if not last and q > 0:
            tolerance = 1e-2 * max(fits[best, 3] - score[p], 0.1)
            needed = fits[second, 3] if second >= 0 else needed
        y, z = origin[t, 0] + at[p, 0] * origin[t, 2], origin[t, 1] + at[p, 1] * origin[t, 3]
        for every in range(0 if few else 1, 2):
            v, layout, kinds = (w, sensors, first) if every else (near_w, its_sensors, its_first)
            climb(
                v, layout, kinds, table, terms, mu, box, y, z, tolerance, smallest, straight,
                needed if every else -math.inf, scratch, whole, fits[p], fits[spare],
            )  # fmt: skip
            y, z = fits[p, 29], fits[p, 30]
        if last:
            break
        if best < 0:
            best = p
        elif abs(fits[p, 29] - fits[best, 29]) + abs(fits[p, 30] - fits[best, 30]) < apart:
            if fits[p, 3] > fits[best, 3]:
                best = p
        elif fits[p, 3] > fits[best, 3]:
            best, second = p, best
        elif second < 0 or fits[p, 3] > fits[second, 3]:
            second = p
    return best, second
