"""Compiled: whether a load far from the sensors could explain a frame, by bounds alone (`far.py`)."""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled

_ROUNDING = 1.0 - 2e-5
"""Sums in single precision are sure to fewer digits."""


@compiled(inline=True)
def crowded(single, total, least, tile, cluster, share):
    """Whether a frame's strongest sensors have more of it than any load far away gives them, beside all of `least`."""
    out = False
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
def region_from(i, single, total, least, tile, table, left, directions, seen):
    """The first of the last regions, from region i on, of which a load may explain `least`; their number if none."""
    regions, n = table.shape[0], directions.shape[1]
    while i < regions:
        if seen[tile, i] == 0:
            i = table[i, 2]
            continue
        begin, count = table[i, 0], table[i, 1]
        if count > 0:
            taken = np.float32(0)
            for j in range(begin, begin + count):
                along = np.float32(0)
                for e in range(n):
                    along += directions[j, e] * single[e]
                taken += along * along
            rest, square = total - taken, left[i]
            # the bound is (sqrt(taken (1 - square)) + sqrt(rest square))^2; compared without its roots
            over = _ROUNDING * least - taken * (1.0 - square) - rest * square
            if rest > square * total and over > 0.0 and over * over > 4.0 * taken * (1.0 - square) * rest * square:
                i = table[i, 2]
                continue
        if table[i, 3] == 1:
            return i
        i += 1
    return regions


@compiled(borrows=True)
def may_reach(single, total, least, tile, table, left, directions, seen, cluster, share):
    """Whether chi-square explained by a load of any region may be `least`; of no region: it may.

    single (n + 1,): readings in units of noise, whose squares add up to `total`; tile: the strongest of them, n where
    it is not sure; the others as of `far.Far`.
    """
    regions = table.shape[0]
    if regions == 0:
        return True
    if crowded(single, total, least, tile, cluster, share):
        return False
    return region_from(0, single, total, least, tile, table, left, directions, seen) < regions
