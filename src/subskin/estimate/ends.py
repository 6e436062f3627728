"""Compiled: whether a contact at an end of the search, or beyond it, explains a frame nearly as well as the best.

What lies beyond may well look like something within: a load two depths beside the row like one at its other side. So
the best S is compared with S at the ends, where it is known exactly, and with the highest that line loads reach beyond
them. docs/locating.md.
"""

from __future__ import annotations

from .._compiled import compiled
from .kinds import Along, Line, climb_line, top_from, until

_SINGLE = 1e-4
"""Share of S by which the scan, in single precision, may be wrong at most."""


@compiled(inline=True)
def outside(w, tables, nodes, told, cone, box, single, least, rows, fits):
    """Whether S reaches `least` at a position beyond the search.

    tables (stretches, cells, 5, 2, n), whitened; nodes (k,): where to climb from; told: settings; single
    (stretches k,): S by the scan at the nodes of each stretch, without the range of the force; the others: scratch.
    """
    k, ending = nodes.size, until(1e-2)
    for j in range(tables.shape[0]):
        s = single[j * k : (j + 1) * k]
        model = Line(tables[j], told.far_start, told.far_step, rows)
        for p in range(k):
            before, after = max(p - 1, 0), min(p + 1, k - 1)
            if s[p] < told.near * least or s[before] > s[p] or s[after] > s[p]:
                continue
            box[0], box[1] = nodes[before], nodes[after]
            climb_line(w, model, cone, box, Along(nodes[p]), ending, fits[0], fits[1])
            if fits[0].explained > least:
                return True
    return False


@compiled(inline=True)
def at_end(w, table, model, cone, held, told, s, squares, least, fit, trial):
    """Whether S reaches `least` at an end of the search, with any half width.

    s (widths, m), squares (widths,): the scan; held (4,): as the ends of `top_from`, those of y are written over.
    """
    rows = squares.size
    for side in range(2):
        k, y = (0, told.first) if side == 0 else (s.shape[1] - 1, told.last)
        best = 0
        for j in range(1, rows):
            best = j if s[j, k] > s[best, k] else best
        top = float(s[best, k])
        # between nodes S rises by less than it differs at the next ones
        rise = max(top - s[max(best - 1, 0), k], top - s[min(best + 1, rows - 1), k])
        if top * (1.0 + _SINGLE) + rise >= least:
            held[0] = held[1] = y
            top_from(w, table, model, cone, held, y, squares[best], until(1e-7), fit, trial)
            if fit.explained > least:
                return True
    return False
