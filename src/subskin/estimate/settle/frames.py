"""Compiled: loads that a loop found, settled by all errors: a point load on an area, a line load on a row."""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from .aside import along_crest
from .elsewhere import FEW_SPARE, elsewhere, scanning, told_apart, variance_of
from .given import Errors
from .normal import COMMON, NONE, copy_state, room_of, second_moment, size_of, spread_of, stepped, volume_of
from .variants import STEPS, case_of, common_of, lay_out, settle

_TAKEN, _NARROW, _FAR, _WIDE = 16.0, 0.05, 40.0, 0.2
"""What a size has to explain beside a point, in chi-square, to be taken; the standard deviation of q up to which
readings change in proportion to it; the chi-square from which a size is out of the question; and the standard deviation
of a position [least depths] from which it is not known."""
_HALF_WIDTHS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Of which each is as likely before the readings are seen, in those of the largest."""
_PROFILED = 2
"""Steps to each of these from the one before."""
_LOOKED_AT = np.array([0.1, 1.0])
"""Squares of half widths that are tried before readings are taken to change in proportion to the square."""
_ONE = 0.6
"""Half width [least depths] beyond which a touch on a row may be two, of which the middle is too far from either."""
_SEEN = 120.0
"""Least chi-square of the readings of a frame that is scaled: less is no contact."""
_OK, _AMBIGUOUS, _UNEXPLAINED = 0.0, 1.0, 3.0


@compiled(borrows=True)
def _start(room, row, at, scale):
    positions = room.at.size
    room.size[0] = 0.0
    room.shared[:] = 0.0
    for j in range(positions):
        room.at[j] = row[at + j]
    for c in range(room.load.size):
        room.load[c] = scale * row[at + positions + c]


@compiled(borrows=True)
def _put(room, row, at):
    positions = room.at.size
    for j in range(positions):
        row[at + j] = room.at[j]
    for c in range(room.load.size):
        row[at + positions + c] = room.load[c]


@compiled(borrows=True)
def _direction_open(room, spread):
    """Whether the readings leave open the direction of the force by a radian; spread: the covariance of all."""
    load, positions = room.load, room.at.size
    every = positions + load.size
    square = trace = along = 0.0
    for c in range(load.size):
        square += load[c] ** 2
        for d in range(c, load.size):
            i = positions + c
            value = spread[i * (2 * every + 1 - i) // 2 + d - c]
            trace += value if c == d else 0.0
            along += (1.0 if c == d else 2.0) * load[c] * load[d] * value
    return not trace * square - along < square * square


@compiled(borrows=True)
def _profiled(w, case, base, room, tried, out):
    """Add to `out` the mean, over all half widths as the readings leave them, of the moves from `base`.

    The moves' products (K (K + 1) / 2,), K = P + F; tried (widths, K + 1): scratch; `room` begins at a load, and is
    used.
    """
    lowest, total, positions, last = math.inf, 0.0, room.at.size, tried.shape[1] - 1
    tried[:, last] = math.inf
    for k in range(_HALF_WIDTHS.size):
        room.size[0] = _HALF_WIDTHS[k] ** 2
        left = settle(w, case, case.told.box, False, _PROFILED, NONE, room)
        tried[k, last], lowest = left, min(left, lowest)
        for j in range(positions):
            tried[k, j] = room.at[j] - base.at[j]
        for c in range(last - positions):
            tried[k, positions + c] = room.load[c] - base.load[c]
        if not left < lowest + _FAR:
            break
    for k in range(_HALF_WIDTHS.size):  # the ends stand for half as much
        share = math.exp(-0.5 * (tried[k, last] - lowest)) if tried[k, last] < math.inf else 0.0
        tried[k, last] = share * (0.5 if k == 0 or k == _HALF_WIDTHS.size - 1 else 1.0)
        total += tried[k, last]
    for k in range(_HALF_WIDTHS.size):
        if tried[k, last] > 0.0:
            _add_products(tried[k, :last], tried[k, last] / total, out)


@compiled(borrows=True)
def _add_products(moves, share, out):
    """Add a share of the products of moves (K,) to the upper triangle `out`."""
    e = 0
    for i in range(moves.size):
        for j in range(i, moves.size):
            out[e] += share * moves[i] * moves[j]
            e += 1


@compiled(borrows=True)
def _with_size(w, case, sized, left, worse, room, other, third, moves, tried, more):
    """Settle `room` and `other`, its rival, once more with a size, if that is needed to explain the readings.

    `more`, which is zero, becomes what sizes that explain them as well add to the covariance. Returns what room and
    other leave, and whether they have a size.
    """
    told, only, begin = case.told, sized, 0.0
    if not sized:  # to first order, what a size would explain
        lay_out(w, case, True, room)
        stepped(room, told.friction, told.forces, True, NONE)
        best, deviation = size_of(room, moves)
        if left <= told.largest and not best > 4.0 * deviation and deviation < _NARROW:
            for q in _LOOKED_AT:  # readings may bend back to where a larger touch explains them too
                begin = q
                copy_state(room, third)
                third.size[0] = q
                if (
                    settle(w, case, told.box, False, 1, NONE, third) <= left + 4.0 * _FAR
                    and settle(w, case, told.box, False, STEPS, NONE, third) <= left + _FAR
                ):
                    break
                begin = 0.0
            if begin == 0.0:
                _add_products(moves, second_moment(best, deviation), more)
                lay_out(w, case, False, room)
                stepped(room, told.friction, told.forces, False, NONE)
                return left, worse, False
    if begin == 0.0:
        copy_state(room, third)
    found = left if only else settle(w, case, told.box, True, STEPS, NONE, third)
    if not only and (found < left - _TAKEN or not left <= told.largest):
        left, sized = found, True
        copy_state(third, room)
        if worse < math.inf:
            worse = min(worse, settle(w, case, told.box, True, STEPS, NONE, other))
    elif not only and found < left + _FAR:
        for j in range(room.at.size):
            moves[j] = third.at[j] - room.at[j]
        for c in range(room.load.size):
            moves[room.at.size + c] = third.load[c] - room.load[c]
        _add_products(moves, 1.0 / (1.0 + math.exp(0.5 * (found - left))), more)
    lay_out(w, case, True, room)
    stepped(room, told.friction, told.forces, sized, NONE)
    deviation = 1.0
    if sized and 0.0 < room.size[0] < 1.0:
        _, deviation = size_of(room, moves)
    if deviation > _NARROW:
        _profiled(w, case, room, third, tried, more)
        lay_out(w, case, False, room)
        stepped(room, told.friction, told.forces, False, NONE)
    return left, worse, sized


@compiled(frames="readings")
def scaled_frames(readings, doubt, rows, told, sized, scale, out):
    """Frames as if the noise were that of all errors, into out (f, n); by how much each is divided, into scale (f,).

    doubt (f, n), or of no frame: standard deviations of single readings beside all others [reading].
    """
    share, n = told.share_sized if sized else told.share, readings.shape[1]
    for f in range(readings.shape[0]):
        largest, total, inside, level = 0.0, 0.0, True, told.level
        for i in range(n):
            inside &= rows[2, i] < readings[f, i] < rows[3, i]
            w = (readings[f, i] - rows[0, i]) * rows[1, i]
            largest, total = max(largest, w * w), total + w * w
            if doubt.shape[0] > 0:
                level += (doubt[f, i] * rows[1, i]) ** 2 / n
        square = level + share * largest
        scale[f] = math.sqrt(max(min(square, total / _SEEN), level))
        for i in range(n):
            out[f, i] = rows[0, i] + (readings[f, i] - rows[0, i]) / scale[f] if inside else math.nan


@compiled(frames="readings")
def settle_frames(readings, doubt, rows, given, scale, sized_only, out):
    """Settle what the loop over scaled frames found, in `out`; sized_only: as touches of some size alone.

    given: what `Uncertain.to_settle` made; doubt as of `scaled_frames`.
    """
    variants, drawn, told, nodes, fields = given
    still = drawn.still.copy()
    errors = Errors(still, drawn.gain, drawn.position, drawn.own, drawn.common, drawn.ratios)
    n, positions, components, at = readings.shape[1], nodes.shape[1], fields.shape[1], told.columns
    every, apart_by = positions + components, told_apart(told)
    common, case = common_of(variants, errors), case_of(variants, errors, told, positions, n)
    room = room_of(positions, components, common, errors.ratios, n)
    other = room_of(positions, components, common, errors.ratios, n)
    third = room_of(positions, components, common, errors.ratios, n)
    fourth, scan = room_of(positions, components, common, errors.ratios, n), scanning(components, n, COMMON)
    if told.aside > 0.0:
        for one in (room, other, third, fourth):
            one.away[0], one.away[1] = 0.0, told.aside
    moves, tried, more = np.empty(every), np.empty((_HALF_WIDTHS.size, every + 1)), np.empty(every * (every + 1) // 2)
    w = np.empty(n)
    for f in range(readings.shape[0]):
        row = out[f]
        status, row[at.size] = row[at.status], 0.0
        if status > _AMBIGUOUS or status < _OK:
            row[at.size] = math.nan
            continue
        for i in range(n):
            w[i] = (readings[f, i] - rows[0, i]) * rows[1, i]
            if doubt.shape[0] > 0:
                still[i] = math.hypot(drawn.still[i], doubt[f, i] * rows[1, i])
        sized, worse = sized_only, math.inf
        _start(room, row, 0, scale[f])
        exact = (
            variants.sizes >= 0 and told.share == 0.0 and told.level == 1.0 and doubt.shape[0] == 0 and not sized_only
        )
        rival = not math.isnan(row[at.rival])
        if rival:
            _start(other, row, at.rival, scale[f])
        if exact:
            left, worse = row[at.residual], row[at.residual] + row[at.rival_chi2]
        else:
            left = settle(w, case, told.box, sized, STEPS, NONE, room)
            if rival:
                worse = settle(w, case, told.box, sized, STEPS, NONE, other)
                apart = 0.0
                for j in range(apart_by):
                    apart += (other.at[j] - room.at[j]) ** 2
                if apart < (5.0 * told.apart) ** 2:
                    worse = math.inf
                elif worse < math.inf and worse + volume_of(other) < left + volume_of(room):
                    left, worse, room, other = worse, left, other, room
        more[:] = 0.0
        along = 0.0
        if told.aside > 0.0:
            left, along = along_crest(w, case, left, room, third, fourth)
        if variants.sizes >= 0 and left < math.inf:
            left, worse, sized = _with_size(w, case, sized, left, worse, room, other, third, moves, tried, more)
        if not left <= told.largest:
            row[:] = math.nan
            row[at.rival_chi2], row[at.residual], row[at.status] = math.inf, left, _UNEXPLAINED
            continue
        spread = row[at.covariance : at.residual]
        spread_of(room, spread)
        for e in range(more.size):
            spread[e] += more[e]
        if along > 0.0:
            spread[0] = max(spread[0], spread[0] - spread[1] ** 2 / spread[every] + along)
        _put(room, row, 0)
        row[at.residual], row[at.size] = left, told.widest * math.sqrt(room.size[0])
        row[at.rival : at.rival_chi2] = math.nan
        row[at.rival_chi2] = math.inf
        if worse < math.inf:
            _put(other, row, at.rival)
            more_errors = 0.0 if exact else volume_of(other) - volume_of(room)
            row[at.rival_chi2] = max(worse - left + more_errors, 0.0)
        known = math.sqrt(variance_of(spread, apart_by)) < 2.0 * _WIDE * told.longest
        open_ = not known or row[at.rival_chi2] < told.ambiguity or _direction_open(room, spread)
        for j in range(apart_by):
            margin = 2.0 * told.apart
            open_ |= not told.box[2 * j] + margin < row[j] < told.box[2 * j + 1] - margin
        few = variants.sizes >= 0 and n <= every + FEW_SPARE
        # a depth beside the row and farther, few readings do not tell a heavy press from a pull
        open_ |= few and told.aside > 0.0 and room.at[1] * told.aside > (2.0 * told.longest) ** 2
        if row[at.size] > 0.0:  # it needs one reading more
            open_ |= not n > every + 1 or (apart_by == 1 and row[at.size] > 2.0 * _ONE * told.longest)
        if exact and not row[at.size] > 0.0 and not few:
            open_ |= status == _AMBIGUOUS
        elif not open_ and (status == _AMBIGUOUS or sized_only or exact or few):
            open_ = elsewhere(w, case, nodes, fields, sized_only or few, row, room, other, scan)
        row[at.status] = _AMBIGUOUS if open_ else _OK
