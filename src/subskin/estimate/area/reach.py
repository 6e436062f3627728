"""Compiled: whether a load far from the sensors could explain a frame, by bounds alone (`far.py`)."""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled

_ROUNDING = 1.0 - 2e-5
"""Sums in single precision are sure to fewer digits."""


@compiled(entry=True, borrows=True)
def may_reach(single, total, least, table, left, directions):
    """Whether chi-square explained by a load of any region may be `least`; of no region: it may.

    single (n + 1,): readings in units of noise, whose squares add up to `total`; the others as of `far.Far`.
    """
    regions, n = table.shape[0], directions.shape[1]
    if regions == 0:
        return True
    goal = _ROUNDING * least
    i = 0
    while i < regions:
        begin, count = table[i, 0], table[i, 1]
        if count > 0:
            taken = np.float32(0)
            for j in range(begin, begin + count):
                along = np.float32(0)
                for e in range(n):
                    along += directions[j, e] * single[e]
                taken += along * along
            rest = total - taken
            if rest > left[i, 0] * left[i, 0] * total:
                bound = math.sqrt(taken) * left[i, 1] + math.sqrt(rest) * left[i, 0]
                if bound * bound < goal:
                    i = table[i, 2]
                    continue
        if table[i, 3] == 1:
            return True
        i += 1
    return False
