"""Compiled: the best and the second-best top of S from the highest nodes of a tile."""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..varpro import Ending
from .judge import FINE, MOST
from .point import Point, PointModel, climb
from .scan import peaks, within
from .tiles import COUNT, NEAR, NODES, SHAPES, STRIDE

_SMALL = 24
"""Sensors of which all are fitted at once; of more, first those near the strongest."""


@compiled(inline=True)
def nearby(w, model, tiles, t, part):
    """Readings and model of the sensors that count in tile t, where these are few; else of all."""
    i0, k = tiles.table[t, NEAR], tiles.table[t, COUNT]
    near_w, near = w, model
    if 4 * k < 3 * w.size and w.size > _SMALL:
        near_w, first = part[:k], tiles.first[i0 + t : i0 + t + k + 1]
        sensors = tiles.sensors[4 * i0 : 4 * (i0 + k)].reshape((4, k))
        near = PointModel(sensors, first, model.table, model.terms, model.rows, model.bits)
    return near_w, near


@compiled(borrows=True)
def tops_of(w, search, room, t, total, c, most, share):
    """Best and second-best top of S from the highest nodes of tile t, as rows of `room.fits`; -1 where there is none.

    Of many sensors first those that count are fitted, then all; `room.part` keeps the readings of these. total, c: as
    of `scan.taken`; most, share: as of `scan.peaks`.
    """
    tiles, settings, model, fits, heights, lead = (
        search.tiles, search.settings, search.model, room.fits, room.heights, room.lead
    )  # fmt: skip
    index, origin, at, score = tiles.table, tiles.origin, room.at, room.score
    i0, k, m, stride = index[t, NEAR], index[t, COUNT], index[t, NODES], index[t, STRIDE]
    shapes = tiles.shapes[index[t, SHAPES] : index[t, SHAPES] + 9 * m].reshape((9, m))
    within(shapes, settings.limits.friction, c, heights[lead : lead + m])
    for p in range(lead + m, lead + m + stride + 2):
        heights[p] = np.float32(-1)
    near_w, near = nearby(w, model, tiles, t, room.part)
    few = near_w.size < w.size
    straight = 0.02 * settings.broad if few else 0.0
    if few:
        for i in range(k):
            e = tiles.near[i0 + i]
            near_w[i] = w[e] if e < w.size else 0.0
    best = second = -1
    count = peaks(heights, lead, m, stride, total, share, score[:most], at)
    for q in range(count + 1):
        # a maximum clearly lower than both already found cannot become the best or the rival
        last = q == count or (second >= 0 and score[q] < 0.8 * fits[second].explained)
        if last and best <= 0:
            break
        p = best if last else q  # at last the best, if it was climbed roughly
        tolerance, needed = FINE, -math.inf
        if not last and q > 0:
            tolerance = 1e-2 * max(fits[best].explained - score[p], 0.1)
            needed = fits[second].explained if second >= 0 else needed
        start = Point(origin[t, 0] + at[p, 0] * origin[t, 2], origin[t, 1] + at[p, 1] * origin[t, 3])
        if few:
            ending = Ending(tolerance, settings.smallest, straight, -math.inf)
            climb(near_w, near, settings.limits, settings.box, start, ending, fits[p], fits[MOST])
            start = Point(fits[p].y, fits[p].z)
        ending = Ending(tolerance, settings.smallest, straight, needed)
        climb(w, model, settings.limits, settings.box, start, ending, fits[p], fits[MOST])
        if last:
            break
        if best < 0:
            best = p
        elif abs(fits[p].y - fits[best].y) + abs(fits[p].z - fits[best].z) < settings.apart:
            if fits[p].explained > fits[best].explained:
                best = p
        elif fits[p].explained > fits[best].explained:
            best, second = p, best
        elif second < 0 or fits[p].explained > fits[second].explained:
            second = p
    return best, second
