"""Compiled: whether a load far from the best one explains a frame about as well, by all errors."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._check import FloatArray
from ..._compiled import compiled
from ..area.fall import widest_variance
from ..cone import eliminate_three, eliminate_two
from .normal import COMMON, copied, volume_of
from .variants import STEPS, settle

_FEW, _SLACK = 4, 30.0
"""Nodes that are climbed; and how much a node may leave more than the load near it."""
FEW_SPARE = 2
"""Spare readings up to which a touch of some size may read like a load without one that is far from it."""


class Scanning(NamedTuple):
    """Scratch: along (errors, n + 1): those in common, and what each takes of the readings; part (n,); g (F, F), b,
    taken (F,): normal equations of a node; best (few, 2): what the best nodes leave, and which these are.
    """

    along: FloatArray
    part: FloatArray
    g: FloatArray
    b: FloatArray
    taken: FloatArray
    best: FloatArray


@compiled()
def scanning(components, n):
    """Scratch for so many components and sensors."""
    g = np.empty((components, components))
    return Scanning(
        np.empty((COMMON, n + 1)), np.empty(n), g, np.empty(components), np.empty(components), np.empty((_FEW, 2))
    )


@compiled()
def variance_of(spread, positions):
    """The largest variance of a position; spread: the upper triangle of the covariance."""
    if positions == 1:
        return spread[0]
    return widest_variance(spread)


@compiled(borrows=True)
def _explained(table, g, b, friction):
    """What the best load within the cone explains, by its normal equations; the upper triangle of g."""
    if table.ndim == 5:
        _, _, explained, _, _, _, _ = eliminate_two(g[0, 0], g[0, 1], g[1, 1], b[0], b[1], friction, 0.0, math.inf)
    else:
        _, _, _, explained, _, _, _, _, _, _, _ = eliminate_three(
            g[0, 0], g[0, 1], g[0, 2], g[1, 1], g[1, 2], g[2, 2], b[0], b[1], b[2], friction
        )
    return explained


@compiled(borrows=True)
def _whiten(w, room, along):
    """C^-1 = W - V V^T: fill V with the errors in common, one after the other; what is left of the readings by C^-1.

    along (errors, n + 1): V, and what each takes of the readings.
    """
    n, weight, first = w.size, room.weight, room.at.size + room.load.size + 1
    total = 0.0
    for i in range(n):
        total += w[i] * w[i] * weight[i]
    for e in range(room.rows.shape[0] - first):
        row, size, taken = room.rows[first + e], 1.0, 0.0
        for i in range(n):
            along[e, i] = weight[i] * row[i]
        for d in range(e):
            both = 0.0
            for i in range(n):
                both += along[d, i] * row[i]
            for i in range(n):
                along[e, i] -= both * along[d, i]
        for i in range(n):
            size += along[e, i] * row[i]
        for i in range(n):
            along[e, i] /= math.sqrt(size)
            taken += along[e, i] * w[i]
        along[e, n] = taken
        total -= taken * taken
    return total


@compiled(borrows=True)
def _taken_at(field, weight, w, common, friction, table, scan):
    """What the best load at a node explains by its `field` (F, n); scan: with the errors in common in `along`."""
    n, components, g, b = w.size, field.shape[0], scan.g, scan.b
    for c in range(components):
        b[c] = 0.0
        for i in range(n):
            scan.part[i] = field[c, i] * weight[i]
            b[c] += scan.part[i] * w[i]
        for d in range(c, components):
            total = 0.0
            for i in range(n):
                total += scan.part[i] * field[d, i]
            g[c, d] = total
    for e in range(common):
        for c in range(components):
            total = 0.0
            for i in range(n):
                total += scan.along[e, i] * field[c, i]
            scan.taken[c] = total
            b[c] -= total * scan.along[e, n]
            for d in range(c + 1):
                g[d, c] -= total * scan.taken[d]
    return _explained(table, g, b, friction)


@compiled(borrows=True)
def _distance(one, other, positions):
    """Between positions, the first of what `one` and `other` hold."""
    total = 0.0
    for j in range(positions):
        total += (one[j] - other[j]) ** 2
    return math.sqrt(total)


@compiled(borrows=True)
def _rank(nodes, p, left, near, best):
    """Take up node p, which leaves so much, among the best, of which no two are near each other."""
    rank = 0
    while rank < _FEW and best[rank, 0] <= left:
        if _distance(nodes[p], nodes[int(best[rank, 1])], nodes.shape[1]) < near:
            return
        rank += 1
    if rank == _FEW:
        return
    last = rank
    while last < _FEW - 1 and (
        best[last, 1] < 0.0 or _distance(nodes[p], nodes[int(best[last, 1])], nodes.shape[1]) >= near
    ):
        last += 1
    for e in range(last, rank, -1):
        best[e, 0], best[e, 1] = best[e - 1, 0], best[e - 1, 1]
    best[rank, 0], best[rank, 1] = left, float(p)


@compiled(borrows=True)
def elsewhere(w, case, nodes, fields, sized, row, room, other, scan):
    """Whether a load more than six standard deviations off explains a frame about as well as that of `room`.

    nodes (nodes, P), fields (nodes, F, n): where is looked, and readings there; errors are those at the load of `room`.
    The nodes that leave least are climbed, in `other`.
    """
    told, at, table, weight, best = case.told, case.told.columns, case.variants.table, room.weight, scan.best
    positions, every = room.at.size, room.at.size + room.load.size
    spread = row[at.covariance : at.residual]
    reach = max(6.0 * math.sqrt(variance_of(spread, positions)), 5.0 * told.apart)
    enough, common = row[at.residual] + told.ambiguity, room.rows.shape[0] - every - 1
    total, slack = _whiten(w, room, scan.along), math.inf if sized and w.size <= every + FEW_SPARE else _SLACK
    for e in range(_FEW):
        best[e, 0], best[e, 1] = math.inf, -1.0
    for p in range(nodes.shape[0]):
        if _distance(nodes[p], row, positions) < reach:
            continue
        left = total - _taken_at(fields[p], weight, w, common, told.friction, table, scan)
        if left < enough + slack:
            _rank(nodes, p, left, told.longest, best)
    enough += volume_of(room)
    force = 0.0
    for c in range(room.load.size):
        force += room.load[c] ** 2
    for e in range(_FEW):
        p = int(best[e, 1])
        if p < 0:
            break
        copied(nodes[p], other.at)
        other.load[:], other.size[0] = 0.0, 0.0
        other.shared[:] = 0.0
        other.load[0] = math.sqrt(force)
        left = settle(w, case, told.beyond, sized, STEPS, other)
        if left < math.inf and left + volume_of(other) < enough and _distance(other.at, row, positions) > reach:
            return True
    return False
