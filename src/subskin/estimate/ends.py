"""Compiled: whether a contact at an end of the search, or beyond it, explains a frame nearly as well as the best.

What lies beyond may well look like something within: a load two depths beside the row like one at its other side. So
S is compared with S at the ends, where it is known exactly, and at a few positions beyond, far apart as readings there
hardly change. docs/locating.md.
"""

from __future__ import annotations

from .._compiled import compiled
from . import climb as _climb
from .climb import climb_wide, eliminate, project

_SINGLE = 1e-4
"""Share of S by which the scan, in single precision, may be wrong at most."""
_BETWEEN = 0.8
"""Share of S at its top below which no node of the scan lies near it."""


@compiled()
def outside(w, fields, single, mu, low, high, least):
    """Whether S reaches `least` at a position beyond the search.

    fields (k, n, 2): whitened responses there; single (k,): S there by the scan, without the range of the force.
    """
    for k in range(single.size):
        if single[k] * (1.0 + _SINGLE) < least:
            continue
        g11 = g12 = g22 = b1 = b2 = 0.0
        for i in range(w.size):
            an, at = fields[k, i, 0], fields[k, i, 1]
            g11 += an * an
            g12 += an * at
            g22 += at * at
            b1 += an * w[i]
            b2 += at * w[i]
        if eliminate(g11, g12, g22, b1, b2, mu, low, high)[2] > least:
            return True
    return False


@compiled(built_on=(_climb,))
def at_end(w, table, options, s, least, scratch, fit):
    """Whether S reaches `least` at an end of the search; s (m,): the scan."""
    for side in range(2):
        single, y = (s[0], options[11]) if side == 0 else (s[-1], options[12])
        if single * (1.0 + _SINGLE) >= least:
            project(w, table, options[0], options[1], options[4], options[15], options[16], y, scratch, fit)
            if fit[2] > least:
                return True
    return False


@compiled(built_on=(_climb,))
def at_end_wide(w, table, options, s, squares, least, c, a, fit):
    """The same with a contact of any half width; s (widths, m), squares (widths,): the scan."""
    held = options[11:15].copy()
    for side in range(2):
        k, y = (0, options[11]) if side == 0 else (s.shape[1] - 1, options[12])
        best = 0
        for j in range(1, squares.size):
            best = j if s[j, k] > s[best, k] else best
        if s[best, k] >= _BETWEEN * least:
            held[0] = held[1] = y
            climb_wide(
                w, table, options[0], options[1], options[10], options[4], y, squares[best], held, c, a, fit,
                options[15], options[16],
            )  # fmt: skip
            if fit[2] > least:
                return True
    return False
