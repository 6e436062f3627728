"""Compiled: a point load on an area, or a round touch of some size, settled by all errors (`estimate/settle.py`)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._compiled import compiled
from ..cone import eliminate_three
from ..layout import SIZED
from ..settle import COMMON, room_of, second_moment, size_of, spread_of, stepped
from .judge import unsure
from .point import ROWS
from .variants import SettlingCase, Q, lay_out, settle

_TAKEN, _NARROW, _FAR, _WIDE = 16.0, 0.05, 40.0, 0.2
"""What a size has to explain beside a point, in chi-square, to be taken; the standard deviation of q up to which
readings change in proportion to it; the chi-square from which a size is out of the question; and the standard deviation
of a position [least depths] from which it is not known."""
_HALF_WIDTHS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Of which each is as likely before the readings are seen, in those of the largest."""
_FEW, _SLACK = 4, 30.0
"""Nodes that are climbed; and how much a node may leave more than the load near it."""
_SEEN = 120.0
"""Least chi-square of the readings of a frame that is scaled: less is no contact."""
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED = 0.0, 1.0, 2.0, 3.0
_RIVAL, _RIVAL_CHI2, _STATUS, _RESIDUAL, _COVARIANCE = (
    SIZED.rival, SIZED.rival_chi2, SIZED.status, SIZED.residual, SIZED.covariance,
)  # fmt: skip
_SIZE = SIZED.size


class _Forces(NamedTuple):
    """Components of a load, by the names that `judge.unsure` knows."""

    n: float
    ty: float
    tz: float


@compiled(borrows=True)
def _start(room, row, at, scale):
    room.at[0], room.at[1], room.size[0] = row[at], row[at + 1], 0.0
    for c in range(3):
        room.load[c] = scale * row[at + 2 + c]


@compiled(borrows=True)
def _put(room, row, at):
    row[at], row[at + 1] = room.at[0], room.at[1]
    for c in range(3):
        row[at + 2 + c] = room.load[c]


@compiled(borrows=True)
def _elsewhere(w, case, nodes, fields, sized, row, room, other, along, best):
    """Whether a load more than six standard deviations off explains a frame about as well as that of `room`.

    nodes (nodes, 2), fields (nodes, 3, n): where is looked, and readings there; errors are those at the load of `room`.
    The nodes that leave least are climbed. along (3, n + 1), best (FEW, 2): scratch.
    """
    told, n, spread, weight = case.told, w.size, row[_COVARIANCE:_RESIDUAL], room.weight
    widest = 0.5 * (spread[0] + spread[5]) + math.hypot(0.5 * (spread[0] - spread[5]), spread[1])
    reach = max(6.0 * math.sqrt(widest), 5.0 * told.apart)
    enough = row[_RESIDUAL] + told.ambiguity
    # the errors in common: C^-1 = W - V V^T, one after the other
    common = room.rows.shape[0] - Q - 1
    for e in range(common):
        size = 1.0
        for i in range(n):
            along[e, i] = weight[i] * room.rows[Q + 1 + e, i]
        for d in range(e):
            both = 0.0
            for i in range(n):
                both += along[d, i] * room.rows[Q + 1 + e, i]
            for i in range(n):
                along[e, i] -= both * along[d, i]
        for i in range(n):
            size += along[e, i] * room.rows[Q + 1 + e, i]
        for i in range(n):
            along[e, i] /= math.sqrt(size)
    for e in range(_FEW):
        best[e, 0], best[e, 1] = math.inf, -1.0
    total = 0.0
    for i in range(n):
        total += w[i] * w[i] * weight[i]
    for e in range(common):
        along[e, n] = 0.0  # what it takes of the readings
        for i in range(n):
            along[e, n] += along[e, i] * w[i]
        total -= along[e, n] ** 2
    for p in range(nodes.shape[0]):
        if math.hypot(nodes[p, 0] - row[0], nodes[p, 1] - row[1]) < reach:
            continue
        g00 = g01 = g02 = g11 = g12 = g22 = b0 = b1 = b2 = 0.0
        for i in range(n):
            a0, a1, a2, x = fields[p, 0, i], fields[p, 1, i], fields[p, 2, i], weight[i]
            g00 += a0 * a0 * x
            g01 += a0 * a1 * x
            g02 += a0 * a2 * x
            g11 += a1 * a1 * x
            g12 += a1 * a2 * x
            g22 += a2 * a2 * x
            b0 += a0 * w[i] * x
            b1 += a1 * w[i] * x
            b2 += a2 * w[i] * x
        for e in range(common):
            u0 = u1 = u2 = 0.0
            for i in range(n):
                u0 += along[e, i] * fields[p, 0, i]
                u1 += along[e, i] * fields[p, 1, i]
                u2 += along[e, i] * fields[p, 2, i]
            v = along[e, n]
            g00 -= u0 * u0
            g01 -= u0 * u1
            g02 -= u0 * u2
            g11 -= u1 * u1
            g12 -= u1 * u2
            g22 -= u2 * u2
            b0 -= u0 * v
            b1 -= u1 * v
            b2 -= u2 * v
        _, _, _, explained, _, _, _, _, _, _, _ = eliminate_three(
            g00, g01, g02, g11, g12, g22, b0, b1, b2, told.friction
        )
        here = total - explained
        if here < enough + _SLACK:
            rank = _FEW
            while rank > 0 and best[rank - 1, 0] > here:
                rank -= 1
            for e in range(_FEW - 1, rank, -1):
                best[e, 0], best[e, 1] = best[e - 1, 0], best[e - 1, 1]
            if rank < _FEW:
                best[rank, 0], best[rank, 1] = here, float(p)
    for e in range(_FEW):
        p = int(best[e, 1])
        if p < 0:
            break
        other.at[0], other.at[1], other.size[0] = nodes[p, 0], nodes[p, 1], 0.0
        force = 0.0
        for c in range(3):
            force += room.load[c] ** 2
        for c in range(3):
            other.load[c] = math.sqrt(force) if c == 0 else 0.0
        left = settle(w, case, told.beyond, sized, other)
        if left < enough and math.hypot(other.at[0] - row[0], other.at[1] - row[1]) > reach:
            return True
    return False


@compiled(borrows=True)
def _profiled(w, case, at, load, room, tried, out):
    """Fill `out` (15,) with the mean, over all half widths as the readings leave them, of moves from `at` and `load`.

    The moves' products, upper triangle; tried (widths, 6): scratch; `room` begins at a load, and is used.
    """
    lowest, total = math.inf, 0.0
    for k in range(_HALF_WIDTHS.size):
        room.size[0] = _HALF_WIDTHS[k] ** 2
        left = settle(w, case, case.told.box, False, room)
        tried[k, 5], lowest = left, min(left, lowest)
        for j in range(2):
            tried[k, j] = room.at[j] - at[j]
        for c in range(3):
            tried[k, 2 + c] = room.load[c] - load[c]
        if not left < lowest + _FAR:
            for e in range(k + 1, _HALF_WIDTHS.size):
                tried[e, 5] = math.inf
            break
    out[:] = 0.0
    for k in range(_HALF_WIDTHS.size):
        share = math.exp(-0.5 * (tried[k, 5] - lowest)) if tried[k, 5] < math.inf else 0.0
        if share > 0.0:
            share *= 0.5 if k == 0 or k == _HALF_WIDTHS.size - 1 else 1.0
            total += share
            e = 0
            for i in range(5):
                for j in range(i, 5):
                    out[e] += share * tried[k, i] * tried[k, j]
                    e += 1
    for e in range(out.size):
        out[e] /= total


@compiled(inline=True)
def _copied(room, other):
    """The state of a room, to another."""
    for j in range(2):
        other.at[j] = room.at[j]
    for c in range(3):
        other.load[c] = room.load[c]
    other.size[0] = room.size[0]


@compiled(borrows=True)
def _with_size(w, case, sized, left, worse, room, other, third, moves, tried, more):
    """Settle `room` and `other`, its rival, once more with a size, if that is needed to explain the readings.

    `more` (15,) is what sizes that explain them as well add to the covariance. Returns what room and other leave, and
    whether they have a size.
    """
    told, only = case.told, sized
    if not sized:  # to first order, what a size would explain
        lay_out(w, case, True, room)
        stepped(room, told.friction, True)
        best, deviation = size_of(room, moves)
        if left <= told.largest and not best > 4.0 * deviation:
            _copied(room, third)
            third.size[0] = 1.0
            far = settle(w, case, told.box, False, third) if deviation < _NARROW else left
            if far > left + _FAR:
                extra, e = second_moment(best, deviation), 0
                for i in range(5):
                    for j in range(i, 5):
                        more[e] = extra * moves[i] * moves[j]
                        e += 1
                lay_out(w, case, False, room)
                stepped(room, told.friction, False)
                return left, worse, False
    _copied(room, third)
    found = left if only else settle(w, case, told.box, True, third)
    if not only and (found < left - _TAKEN or not left <= told.largest):
        left, sized = found, True
        _copied(third, room)
        if worse < math.inf:
            worse = min(worse, settle(w, case, told.box, True, other))
    lay_out(w, case, True, room)
    stepped(room, told.friction, sized)
    deviation = 1.0
    if sized and 0.0 < room.size[0] < 1.0:
        _, deviation = size_of(room, moves)
    if deviation > _NARROW:
        _profiled(w, case, room.at, room.load, third, tried, more)
        lay_out(w, case, False, room)
        stepped(room, told.friction, False)
    return left, worse, sized


@compiled(frames="readings")
def scaled_frames(readings, rows, told, sized, scale, out):
    """Frames as if the noise were that of all errors, into out (f, n); by how much each is divided, into scale (f,)."""
    share = told.share_sized if sized else told.share
    for f in range(readings.shape[0]):
        largest, total, inside = 0.0, 0.0, True
        for i in range(readings.shape[1]):
            inside &= rows[2, i] < readings[f, i] < rows[3, i]
            w = (readings[f, i] - rows[0, i]) * rows[1, i]
            largest, total = max(largest, w * w), total + w * w
        square = told.level + share * largest
        scale[f] = math.sqrt(max(min(square, total / _SEEN), told.level))
        for i in range(readings.shape[1]):
            out[f, i] = rows[0, i] + (readings[f, i] - rows[0, i]) / scale[f] if inside else math.nan


@compiled(frames="readings")
def settle_frames(readings, rows, variants, errors, told, nodes, fields, scale, sized_only, out):
    """Settle what the loop over scaled frames found, in `out`; sized_only: as touches of some size alone."""
    n = readings.shape[1]
    common = COMMON if errors.poisson > 0.0 else 2 if errors.common > 0.0 else 0
    room, other, third = room_of(2, 3, common, n), room_of(2, 3, common, n), room_of(2, 3, common, n)
    numbers = np.empty((variants.table.shape[0], ROWS, n + 1))
    case = SettlingCase(variants, errors, told, numbers, numbers.view(np.int64))
    moves, tried, more = np.empty(5), np.empty((_HALF_WIDTHS.size, 6)), np.empty(15)
    w, along, least = np.empty(n), np.empty((COMMON, n + 1)), np.empty((_FEW, 2))
    for f in range(readings.shape[0]):
        row = out[f]
        status, row[_SIZE] = row[_STATUS], 0.0
        if status > _AMBIGUOUS or status < _OK:
            row[_SIZE] = math.nan
            continue
        for i in range(n):
            w[i] = (readings[f, i] - rows[0, i]) * rows[1, i]
        sized, worse = sized_only, math.inf
        _start(room, row, 0, scale[f])
        exact = told.share == 0.0 and told.level == 1.0 and not sized_only
        if exact:
            left, worse = row[_RESIDUAL], row[_RESIDUAL] + row[_RIVAL_CHI2]
            if worse < math.inf:
                _start(other, row, _RIVAL, scale[f])
        else:
            left = settle(w, case, told.box, sized, room)
        if not exact and not math.isnan(row[_RIVAL]):
            _start(other, row, _RIVAL, scale[f])
            worse = settle(w, case, told.box, sized, other)
            if math.hypot(other.at[0] - room.at[0], other.at[1] - room.at[1]) < 5 * told.apart:
                worse = math.inf
            elif worse < left:
                left, worse, room, other = worse, left, other, room
        more[:] = 0.0
        if variants.sizes >= 0 and left < math.inf:
            left, worse, sized = _with_size(w, case, sized, left, worse, room, other, third, moves, tried, more)
        row[_RESIDUAL] = left
        if not left <= told.largest:
            for j in range(row.size):
                row[j] = math.nan
            row[_RIVAL_CHI2], row[_RESIDUAL], row[_STATUS] = math.inf, left, _UNEXPLAINED
            continue
        spread = row[_COVARIANCE:_RESIDUAL]
        spread_of(room, spread)
        for e in range(more.size):
            spread[e] += more[e]
        _put(room, row, 0)
        row[_SIZE] = told.widest * math.sqrt(room.size[0])
        row[_RIVAL_CHI2] = math.inf
        for j in range(_RIVAL, _RIVAL_CHI2):
            row[j] = math.nan
        if worse < math.inf:
            _put(other, row, _RIVAL)
            row[_RIVAL_CHI2] = max(worse - left, 0.0)
        box, margin = told.box, 2.0 * told.apart
        widest = 0.5 * (spread[0] + spread[5]) + math.hypot(0.5 * (spread[0] - spread[5]), spread[1])
        known = math.sqrt(widest) < 2.0 * _WIDE * told.longest
        open_ = (
            not known
            or row[_RIVAL_CHI2] < told.ambiguity
            or unsure(_Forces(row[2], row[3], row[4]), spread, widest, box)
        )
        open_ |= not (box[0] + margin < row[0] < box[1] - margin and box[2] + margin < row[1] < box[3] - margin)
        if exact and not row[_SIZE] > 0.0:
            open_ |= status == _AMBIGUOUS
        elif not open_ and (status == _AMBIGUOUS or sized_only or exact):
            open_ = _elsewhere(w, case, nodes, fields, sized_only, row, room, other, along, least)
        row[_STATUS] = _AMBIGUOUS if open_ else _OK
