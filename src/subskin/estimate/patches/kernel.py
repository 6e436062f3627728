"""The compiled heart of a fit of patches: the rectangle that explains a frame best, and what comes near it.

Climbs start from the centre and the second moments that the resultant finds, in some shapes of these, where these do
not do from a bank of rectangles, then round by round from shapes about the best top.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..area.point import in_room
from ..area.rectangle import FIT, ROWS, RectangleAt, RectangleModel, climb, covariance, project, rectangle_field
from ..project import whitened
from ..scan import MOST_CHI2
from ..varpro import Ending, Limits

__all__ = ["FOUND", "UNKNOWNS", "PatchSearch", "fit_patches"]

SHAPE = np.dtype((np.record, [(name, float) for name in ("mark", *RectangleAt._fields)]))
"""A rectangle to climb from, and the chi-square that it explains as it is."""
UNKNOWNS = (*RectangleAt._fields, "n", "ty", "tz")
_ALONE = len(RectangleAt._fields) * (len(RectangleAt._fields) + 1) // 2
"""Numbers of a covariance of the unknowns alone, and of all."""
_SQUARE = len(UNKNOWNS) * (len(UNKNOWNS) + 1) // 2
_ENTRY = np.zeros(2 * (len(UNKNOWNS),), np.int64)
_ENTRY[np.triu_indices(len(UNKNOWNS))] = np.arange(_SQUARE)
_LOAD = np.array([UNKNOWNS.index(name) for name in ("y", "z", "n", "ty", "tz")])
"""Where a covariance has two unknowns, and where these are position and components."""
FOUND = np.dtype(
    (
        np.record,
        [(name, float) for name in UNKNOWNS]
        + [("covariance", float, (_SQUARE,)), ("residual", float)]
        + [(f"rival_{name}", float) for name in UNKNOWNS]
        + [("rival_chi2", float), ("status", float)],
    )
)
"""What is filled of a frame: unknowns and components, the upper triangle of their covariance, and of the rival."""
_FINE = Ending(0.003)
_TOPS, _SCANNED, _ROUNDS = 3, 6, 8
"""Shapes that are climbed from at first, and of the bank; rounds, the first of which these are."""
_MOVED = (0.4, 0.8, -0.4, -0.8, -9.0)
"""Depths by which a round moves each side, out or in, but in by at most 0.6 half sides: the last is that far."""
_MOMENT, _FAR = 4.0 / 45.0, 0.7
"""How the second moment of a pressure along a side, in half sides, grows as it is hollow; shares of the ends tried."""
_GROUPS, _MOVES = len(_MOVED) + 1, 4 * len(_MOVED) + 3
"""Ways of moving a side, and the turns, of each of which the best is climbed from; all that a round looks at."""
_SHAPES = (
    (0.0, 1.0, 1.0), (0.0, 0.7, 0.7), (0.0, 1.3, 1.3), (0.0, 1.3, 0.75), (0.0, 0.75, 1.3),
    (0.25, 1.0, 1.0), (0.25, 0.8, 0.8), (0.25, 1.2, 1.2), (0.25, 1.3, 0.75), (0.25, 0.75, 1.3),
)  # fmt: skip
"""Half turns by which they are turned, and factors of both sides."""
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_ANY = 48.0 / math.pi**2
"""Information on a turn that may be any, up to a quarter [1/rad2]."""
_HELD = 1e200
"""Information on what is held."""
_SAME = 0.01
"""Chi-square within which two climbs ended on one top."""
_SMALL, _LIKE = 0.15, 0.05
"""Depths that a first half width is at least; shares of the force, and of a depth, within which two tops are one."""


class PatchBank(NamedTuple):
    """Rectangles to start from: classes (c + 1,), the first of each size and turn; shapes (k,), records of `SHAPE`.

    basis (k, 3, n): orthonormal columns of what it makes the sensors read, the first along N, in units of noise.
    """

    classes: npt.NDArray[np.int64]
    shapes: npt.NDArray[np.void]
    basis: npt.NDArray[np.float32]


class PatchSearch(NamedTuple):
    """Where rectangles are looked for: settings as of `judge.Settings`, and ends of the unknowns, box (16,).

    usual: chi-square up to which a top is taken for the best one; low, high: the ends by name.
    """

    model: RectangleModel
    bank: PatchBank
    limits: Limits
    detection: float
    largest: float
    usual: float
    ambiguity: float
    error: float
    box: FloatArray
    low: RectangleAt
    high: RectangleAt


@compiled(inline=True)
def _rectangle(shape):
    """The rectangle that a `SHAPE` names."""
    return RectangleAt(shape.y, shape.z, shape.direction, shape.length, shape.q, shape.lean, shape.tilt, shape.hollow)


@compiled(borrows=True)
def _shapes(y, z, direction, length, half, shapes):
    """Rectangles like one, into shapes."""
    mean = math.sqrt(length * half)
    for k in range(len(_SHAPES)):
        turn, first, second = _SHAPES[k]
        long, wide = (length, half) if turn == 0.0 else (mean, mean)
        shape = shapes[k]
        shape.y, shape.z, shape.direction = y, z, direction + math.pi * turn
        shape.length, shape.q = first * long, (second * wide) ** 2
        shape.lean = shape.tilt = shape.hollow = 0.0


@compiled(borrows=True)
def _sides(top, depth, shapes):
    """Rectangles like a top but for one side, which is moved out or in, or for a turn."""
    half, c, s = math.sqrt(top.q), math.cos(top.direction), math.sin(top.direction)
    for k in range(_MOVES):
        long, wide, along, across, turn = top.length, half, 0.0, 0.0, 0.0
        if k < 4 * len(_MOVED):
            side = long if k % 4 < 2 else wide
            out = max(_MOVED[k // 4] * depth, -0.6 * side)
            away = 0.5 * out * (1.0 if k % 2 == 0 else -1.0)
            if k % 4 < 2:
                long, along = long + 0.5 * out, away
            else:
                wide, across = wide + 0.5 * out, away
        elif k < _MOVES - 1:
            turn = min(depth / max(long, wide), 0.4) * (1.0 if k == _MOVES - 2 else -1.0)
        else:
            turn = 0.25 * math.pi
            long = wide = math.sqrt(long * wide)
        shape = shapes[k]
        shape.y, shape.z = top.y + along * c - across * s, top.z + along * s + across * c
        shape.direction, shape.length, shape.q = top.direction + turn, long, wide * wide
        shape.lean, shape.tilt, shape.hollow = top.lean, top.tilt, top.hollow


@compiled(borrows=True)
def _bowl(top, hollow, shape):
    """A rectangle of the same second moments whose pressure is as hollow."""
    ratio2 = (1.0 / 3.0 + _MOMENT * top.hollow) / (1.0 / 3.0 + _MOMENT * hollow)
    shape.y, shape.z, shape.direction, shape.lean, shape.tilt = top.y, top.z, top.direction, top.lean, top.tilt
    shape.length, shape.q, shape.hollow = top.length * math.sqrt(ratio2), top.q * ratio2, hollow


@compiled(borrows=True)
def _marked(w, search, shapes, fits):
    """Mark shapes with what they explain."""
    trial = fits[fits.size - 1]
    for k in range(shapes.size):
        project(w, search.model, search.limits, _rectangle(shapes[k]), trial)
        shapes[k].mark = trial.explained


@compiled(borrows=True)
def _from_best(w, search, shapes, most, fits, count):
    """Climb from the shapes of the highest mark, into the fits behind `count`; how many there are then."""
    trial = fits[fits.size - 1]
    for _ in range(min(most, shapes.size)):
        best = 0
        for k in range(1, shapes.size):
            if shapes[k].mark > shapes[best].mark:
                best = k
        climb(w, search.model, search.limits, search.box, _rectangle(shapes[best]), _FINE, fits[count], trial)
        shapes[best].mark = -1.0
        count += 1
    return count


@compiled(borrows=True)
def _scanned(w, bank, shapes):
    """Of each size and turn in the bank the rectangle that explains most, into shapes, marked with that."""
    n = w.size
    for c in range(bank.classes.size - 1):
        best, most = bank.classes[c], np.float32(0.0)
        for k in range(bank.classes[c], bank.classes[c + 1]):
            one = two = three = np.float32(0.0)
            for i in range(n):
                value = np.float32(w[i])
                one += bank.basis[k, 0, i] * value
                two += bank.basis[k, 1, i] * value
                three += bank.basis[k, 2, i] * value
            explained = one * one + two * two + three * three
            if one > 0.0 and explained > most:
                best, most = k, explained
        shapes[c] = bank.shapes[best]
        shapes[c].mark = most


@compiled()
def fill_bank(shapes, model, basis):
    """Fill the `basis` of a `PatchBank` for its `shapes`; model: without its scratch."""
    n, (points, along, across, depth, _, _) = basis.shape[2], model
    mine = RectangleModel(in_room(points, n), along, across, depth, 0.0, np.empty((ROWS, n)))
    for k in range(shapes.size):
        rectangle_field(mine, _rectangle(shapes[k]))
        for row in range(3):
            one = mine.rows[row]
            for before in range(row):
                taken = 0.0
                for i in range(n):
                    taken += one[i] * mine.rows[before, i]
                for i in range(n):
                    one[i] -= taken * mine.rows[before, i]
            size = 0.0
            for i in range(n):
                size += one[i] * one[i]
            over = 1.0 / math.sqrt(size) if size > 0.0 else 0.0
            for i in range(n):
                one[i] *= over
                basis[k, row, i] = one[i]


@compiled(inline=True)
def _best_of(fits, count):
    best = 0
    for p in range(1, count):
        if fits[p].explained > fits[best].explained:
            best = p
    return best


@compiled(borrows=True)
def _weighted(fit, low, high):
    """Add what is known of the unknowns before a reading: each as likely all over its range, or held.

    Of the length, as of the width, that is its square.
    """
    fit.u_direction_direction += _ANY if high.direction > low.direction else _HELD
    long2, wide2 = high.length * high.length - low.length * low.length, high.q - low.q
    fit.u_length_length += 48.0 * (fit.length / long2) ** 2 if long2 > 0.0 else _HELD
    fit.u_q_q += 12.0 / (wide2 * wide2) if wide2 > 0.0 else _HELD
    fit.u_lean_lean += 3.0 if high.lean > low.lean else _HELD
    fit.u_tilt_tilt += 3.0 if high.tilt > low.tilt else _HELD
    bowl = high.hollow - low.hollow
    fit.u_hollow_hollow += 12.0 / (bowl * bowl) if bowl > 0.0 else _HELD


@compiled(borrows=True)
def _said(fit, row):
    row.y, row.z, row.direction, row.length, row.q = fit.y, fit.z, fit.direction, fit.length, fit.q
    row.lean, row.tilt, row.hollow, row.n, row.ty, row.tz = fit.lean, fit.tilt, fit.hollow, fit.n, fit.ty, fit.tz


@compiled(borrows=True)
def _spread(fits, count, top, square):
    """Add to the covariance of position and components how far other tops are, each by its likelihood."""
    whole = 1.0
    for chosen in range(2):
        for p in range(count):
            fit = fits[p]
            known = top.explained - fit.explained < _SAME
            for e in range(p):  # climbs that end on one top
                known |= abs(fits[e].explained - fit.explained) < _SAME
            if known:
                continue
            share = math.exp(0.5 * (fit.explained - top.explained))
            if chosen == 0:
                whole += share
                continue
            away = (fit.y - top.y, fit.z - top.z, fit.n - top.n, fit.ty - top.ty, fit.tz - top.tz)
            for j in range(_LOAD.size):
                for k in range(j, _LOAD.size):
                    square[_ENTRY[_LOAD[j], _LOAD[k]]] += share / whole * away[j] * away[k]


@compiled(borrows=True)
def _frame(w, start, search, fits, shapes, marks, none, row):
    """Fill the row of a frame; marks: which fits a round has set out from; none: a covariance of nothing."""
    depth, low, high = search.model.depth, search.low, search.high
    y, z, mean = start.y, start.z, 0.5 * (start.yy + start.zz)
    length = half = depth
    direction = 0.0
    if not math.isnan(start.y):
        root = math.hypot(0.5 * (start.yy - start.zz), start.yz)
        direction = 0.5 * math.atan2(2.0 * start.yz, start.yy - start.zz)
        length, half = math.sqrt(3.0 * max(mean + root, 0.0)), math.sqrt(3.0 * max(mean - root, 0.0))
    else:
        y, z = 0.5 * (low.y + high.y), 0.5 * (low.z + high.z)
    length, half = max(length, _SMALL * depth), max(half, _SMALL * depth)
    if math.isfinite(low.direction):  # a direction that is known tells one side from the other
        quarter = np.rint((direction - 0.5 * (low.direction + high.direction)) / (0.5 * math.pi))
        direction -= 0.5 * math.pi * quarter
        if quarter % 2.0 != 0.0:
            length, half = half, length
    count = best = 0
    marks[:] = 0.0
    for turn in range(_ROUNDS):
        if turn == 0:
            _shapes(y, z, direction, length, half, shapes)
            _marked(w, search, shapes[: len(_SHAPES)], fits)
            count = _from_best(w, search, shapes[: len(_SHAPES)], _TOPS, fits, count)
            if fits[_best_of(fits, count)].left > search.usual:
                _scanned(w, search.bank, shapes)
                count = _from_best(w, search, shapes[: search.bank.classes.size - 1], _SCANNED, fits, count)
        else:
            base, most = 0, -1.0
            for p in range(count):  # the best that was not yet tried from
                if marks[p] == 0.0 and fits[p].explained > most:
                    base, most = p, fits[p].explained
            marks[base] = 1.0
            _sides(fits[base], depth, shapes)
            _marked(w, search, shapes[:_MOVES], fits)
            for group in range(_GROUPS):  # of each way of moving a side the best
                count = _from_best(w, search, shapes[4 * group : min(4 * group + 4, _MOVES)], 1, fits, count)
            for side in range(2 if high.hollow > low.hollow else 0):
                _bowl(fits[base], _FAR * (high.hollow if side else low.hollow), shapes[0])
                shapes[0].mark = 1.0
                count = _from_best(w, search, shapes[:1], 1, fits, count)
        best = _best_of(fits, count)
        if turn > 0 and fits[best].left < search.usual:
            break
    top = fits[best]
    row.residual = top.left
    bound = search.largest + search.error * (top.n * top.n + top.ty * top.ty + top.tz * top.tz)
    if top.left > bound or top.explained < search.detection:
        row.status = _UNEXPLAINED if top.left > bound else _NO_CONTACT
        return
    _said(top, row)
    row.status = _OK
    second, far = -1, _LIKE * top.n
    for p in range(count):
        away = abs(fits[p].y - top.y) + abs(fits[p].z - top.z)
        other = away > _LIKE * depth or abs(fits[p].n - top.n) > far
        if other and (second < 0 or fits[p].explained > fits[second].explained):
            second = p
    if second >= 0:
        rival = fits[second]
        row.rival_y, row.rival_z, row.rival_direction = rival.y, rival.z, rival.direction
        row.rival_length, row.rival_q, row.rival_lean, row.rival_tilt = rival.length, rival.q, rival.lean, rival.tilt
        row.rival_hollow = rival.hollow
        row.rival_n, row.rival_ty, row.rival_tz = rival.n, rival.ty, rival.tz
        row.rival_chi2 = top.explained - rival.explained
        if row.rival_chi2 < search.ambiguity:
            row.status = _AMBIGUOUS
    _weighted(top, search.low, search.high)
    covariance(top, search.limits, none, row.covariance)
    _spread(fits, count, top, row.covariance)


@compiled(frames="readings")
def fit_patches(readings, sensors, starts, search, out):
    """Fill out (f,), records of `FOUND`; frames beyond reckoning, or that lack a sensor, are left with status -1.

    readings (f, n), raw; sensors (4, n) as of `whitened`; starts (f,): a centre, and second moments about it over the
    force, NaN where there is none; search: a `PatchSearch` without names and scratch.
    """
    n = readings.shape[1]
    of, its_bank, its_limits, detection, largest, usual, ambiguity, error, box, low, high = search
    points, along, across, depth, uneven, _ = of
    model = RectangleModel(in_room(points, n), along, across, depth, uneven, np.empty((ROWS, n)))
    bank, limits = PatchBank(*its_bank), Limits(*its_limits)
    whole = PatchSearch(
        model, bank, limits, detection, largest, usual, ambiguity, error, box, RectangleAt(*low), RectangleAt(*high)
    )
    w, fits = np.empty(n), np.zeros(_TOPS + _SCANNED + (_ROUNDS - 1) * (_GROUPS + 2) + 1, FIT)
    shapes = np.empty(max(len(_SHAPES), bank.classes.size - 1, _MOVES), SHAPE)
    none, marks = np.zeros(_ALONE), np.zeros(fits.size)
    for f in range(readings.shape[0]):
        row = out[f]
        if whitened(readings[f], sensors, w) < MOST_CHI2:
            _frame(w, starts[f], whole, fits, shapes, marks, none, row)
        else:
            row.status = _PENDING
