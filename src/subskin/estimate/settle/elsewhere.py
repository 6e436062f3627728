"""Compiled: whether a load far from the best one explains a frame about as well, by all errors."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._check import FloatArray
from ..._compiled import compiled
from ..area.fall import widest_variance
from ..cone import eliminate_three, eliminate_two
from .normal import NONE, copied, volume_of
from .variants import STEPS, settle

FEW, _SLACK = 4, 30.0
"""Nodes that are climbed; and how much a node may leave more than the load near it."""
FEW_SPARE = 2
"""Spare readings up to which a touch of some size may read like a load without one that is far from it."""


class Scanning(NamedTuple):
    """Scratch: along (lines, n + 1): errors in common, and what each takes of the readings; part (n,); g (F, F), b,
    taken (F,): normal equations of a node; force (F,): its best load; best (few, 2): what the best nodes leave, and
    which these are.
    """

    along: FloatArray
    part: FloatArray
    g: FloatArray
    b: FloatArray
    taken: FloatArray
    force: FloatArray
    best: FloatArray


@compiled()
def scanning(components, n, lines):
    """Scratch for so many components, sensors, and errors in common and components of other loads."""
    return Scanning(
        np.empty((lines, n + 1)), np.empty(n), np.empty((components, components)), np.empty(components),
        np.empty(components), np.empty(components), np.empty((FEW, 2)),
    )  # fmt: skip


@compiled()
def variance_of(spread, positions):
    """The largest variance of a position of so many coordinates; spread: the upper triangle of the covariance."""
    if positions == 1:
        return spread[0]
    return widest_variance(spread)


@compiled(inline=True)
def told_apart(told):
    """By how many coordinates two positions are told apart."""
    return 1 if told.aside > 0.0 else told.box.size // 2


@compiled(borrows=True)
def _explained(g, b, friction, force):
    """What the best load within the cone, `force`, explains by its normal equations; g: the upper triangle."""
    if b.size == 2:
        force[0], force[1], explained, _, _, _, _ = eliminate_two(
            g[0, 0], g[0, 1], g[1, 1], b[0], b[1], friction, 0.0, math.inf
        )
    else:
        force[0], force[1], force[2], explained, _, _, _, _, _, _, _ = eliminate_three(
            g[0, 0], g[0, 1], g[0, 2], g[1, 1], g[1, 2], g[2, 2], b[0], b[1], b[2], friction
        )
    return explained


@compiled(borrows=True)
def whiten(w, room, loads, along):
    """C^-1 = W - V V^T: fill V with the errors in common, one after the other; what is left of the readings by C^-1.

    loads: V has the components of the loads of `room` as well, of which nothing is known. along (lines, n + 1): V, and
    what each takes of the readings. Returns how many these are, too.
    """
    n, weight, first = w.size, room.weight, room.at.size
    size_row, total, count = first + room.load.size, 0.0, 0
    for i in range(n):
        total += w[i] * w[i] * weight[i]
    for e in range(first if loads else size_row + 1, room.rows.shape[0]):
        if e == size_row:
            continue
        row, size, taken = room.rows[e], 0.0, 0.0
        for i in range(n):
            along[count, i] = weight[i] * row[i]
            size += along[count, i] * row[i]
        least = 0.0 if e > size_row else 1e-9 * size
        size = 1.0 if e > size_row else 0.0
        for d in range(count):
            both = 0.0
            for i in range(n):
                both += along[d, i] * row[i]
            for i in range(n):
                along[count, i] -= both * along[d, i]
        for i in range(n):
            size += along[count, i] * row[i]
        if not size > least:
            continue
        for i in range(n):
            along[count, i] /= math.sqrt(size)
            taken += along[count, i] * w[i]
        along[count, n] = taken
        total -= taken * taken
        count += 1
    return total, count


@compiled(borrows=True)
def taken_at(field, weight, w, common, friction, scan):
    """What the best load at a node, `scan.force`, explains by its `field` (F, n); `common` lines of `scan` are free."""
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
    return _explained(g, b, friction, scan.force)


@compiled(borrows=True)
def distance(one, other, positions):
    """Between positions, the first of what `one` and `other` hold."""
    total = 0.0
    for j in range(positions):
        total += (one[j] - other[j]) ** 2
    return math.sqrt(total)


@compiled(borrows=True)
def rank_node(nodes, p, left, near, positions, best):
    """Take up node p, which leaves so much, among the best, of which no two are near each other in `positions`."""
    rank = 0
    while rank < FEW and best[rank, 0] <= left:
        if distance(nodes[p], nodes[int(best[rank, 1])], positions) < near:
            return
        rank += 1
    if rank == FEW:
        return
    last = rank
    while last < FEW - 1 and (best[last, 1] < 0.0 or distance(nodes[p], nodes[int(best[last, 1])], positions) >= near):
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
    told, at, weight, best = case.told, case.told.columns, room.weight, scan.best
    positions, every = told_apart(told), room.at.size + room.load.size
    spread = row[at.covariance : at.residual]
    reach = max(6.0 * math.sqrt(variance_of(spread, positions)), 5.0 * told.apart)
    enough, (total, common) = row[at.residual] + told.ambiguity, whiten(w, room, False, scan.along)
    slack = math.inf if sized and w.size <= every + FEW_SPARE else _SLACK
    for e in range(FEW):
        best[e, 0], best[e, 1] = math.inf, -1.0
    for p in range(nodes.shape[0]):
        if distance(nodes[p], row, positions) < reach:
            continue
        left = total - taken_at(fields[p], weight, w, common, told.friction, scan)
        if left < enough + slack:
            rank_node(nodes, p, left, told.longest, positions, best)
    enough += volume_of(room)
    force = 0.0
    for c in range(room.load.size):
        force += room.load[c] ** 2
    for e in range(FEW):
        p = int(best[e, 1])
        if p < 0:
            break
        copied(nodes[p], other.at)
        other.load[:], other.size[0] = 0.0, 0.0
        other.shared[:] = 0.0
        other.load[0] = math.sqrt(force)
        left = settle(w, case, told.beyond, sized, STEPS, NONE, other)
        if left < math.inf and left + volume_of(other) < enough and distance(other.at, row, positions) > reach:
            return True
    return False
