"""Compiled: whether a contact at an end of the search, or beyond it, explains a frame nearly as well as the best.

What lies beyond may well look like something within: a load two depths beside the row like one at its other side. So
the best S is compared with S at the ends, where it is known exactly, and with the highest that line loads reach beyond
them. docs/locating.md.
"""

from __future__ import annotations

from .._compiled import compiled
from .climb import climb_between, climb_wide, project_between

SINGLE = 1e-4
"""Share of S by which the scan, in single precision, may be wrong at most."""


@compiled()
def outside(w, tables, options, single, least, scratch, fit):
    """Whether S reaches `least` at a position beyond the search.

    tables (stretches, cells, 5, 2, n), whitened; options as of `project_frames`; single (stretches k,): S by the scan
    at the k nodes of each stretch, without the range of the force.
    """
    nodes = options[23:]
    k, mu, low, high = nodes.size, options[4], options[15], options[16]
    for j in range(tables.shape[0]):
        s = single[j * k : (j + 1) * k]
        for p in range(k):
            before, after = max(p - 1, 0), min(p + 1, k - 1)
            if s[p] < options[22] * least or s[before] > s[p] or s[after] > s[p]:
                continue
            start, step, first, last = options[19], options[20], nodes[before], nodes[after]
            climb_between(w, tables[j], start, step, mu, low, high, nodes[p], first, last, 1e-2, scratch, fit)
            if fit[2] > least:
                return True
    return False


@compiled()
def at_end(w, table, options, s, least, scratch, fit):
    """Whether S reaches `least` at an end of the search; s (m,): the scan."""
    for side in range(2):
        single, y = (s[0], options[11]) if side == 0 else (s[-1], options[12])
        if single * (1.0 + SINGLE) >= least:
            project_between(w, table, options[0], options[1], options[4], options[15], options[16], y, scratch, fit)
            if fit[2] > least:
                return True
    return False


@compiled()
def at_end_wide(w, table, options, s, squares, least, c, a, fit):
    """The same with a contact of any half width; s (widths, m), squares (widths,): the scan."""
    held = options[11:15].copy()
    rows = squares.size
    for side in range(2):
        k, y = (0, options[11]) if side == 0 else (s.shape[1] - 1, options[12])
        best = 0
        for j in range(1, rows):
            best = j if s[j, k] > s[best, k] else best
        top = float(s[best, k])
        # between nodes S rises by less than it differs at the next ones
        rise = max(top - s[max(best - 1, 0), k], top - s[min(best + 1, rows - 1), k])
        if top * (1.0 + SINGLE) + rise >= least:
            held[0] = held[1] = y
            climb_wide(
                w, table, options[0], options[1], options[10], options[4], y, squares[best], held, c, a, fit,
                options[15], options[16],
            )  # fmt: skip
            if fit[2] > least:
                return True
    return False
