"""The compiled heart of `evidence`: how probable the readings are under each kind of contact, one frame at a time.

The evidence of a kind is the integral of likelihood times prior over position y, half width a, and forces N, T. Where
the readings fix position and width but roughly, it is a sum over a grid of both, the forces being integrated at each.
Where they fix them closely it is Gaussian in position and forces about the best position at each width, and a sum, or
a Gaussian, over widths. Best positions are found as in `project.py`. Two touches: `_pair.py`. None of these: the kinds
again, with an error of the model beside the noise, and other shapes, which are climbed to from what fits of the kinds.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..kinds import WIDE_FIT, Wide
from ..project import whitened
from ..scan import MOST_CHI2, highest, scan
from ..varpro import Limits
from ._integrals import (
    NEGLIGIBLE,
    SAME,
    Sought,
    Survey,
    Valleys,
    add,
    broad,
    climbed,
    gaussian,
    over_widths,
    surveyed,
    valley,
)
from ._pair import PairRoom, pair_room, weigh_pairs
from .base import CHI2, HALF_WIDTH, LOG_EVIDENCE, NORMAL, POSITION, STATUS, TANGENTIAL

_PEAKS, BEST = 4, 0
"""Peaks that are kept of each kind; the highest comes first."""
_OK, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 2.0, 3.0, -1.0
ERRORS = np.array([0.01, 0.03, 0.1, 0.3])
"""Model errors of what is none of the kinds, alike probable, in shares of the readings' root mean square."""
_ALONE = 6.0
"""Chi-square up to which one touch is not asked whether it was two."""

_PARTS = ("bases", "edges", "squares", "tables", "fines", "nodes", "rows")
KINDS = np.dtype(
    (
        np.record,
        [
            *((name, float) for name in ("start", "step", "widest")),  # of the table
            ("ends", float, (4,)),  # of y, and of q, the square of the half width
            ("moment", float),  # second moment of a pressure of unit half width
            *((name, float) for name in ("share", "left", "spare")),  # logs of its share, of what it leaves; readings
            *((name, int) for name in ("column", "whole")),  # first column in the row; whose part it is: -1 is none
            *((name, int) for name in ("scanned", "cells", "widths", "surveyed")),  # sizes
            *((name, int) for name in _PARTS),  # where its part of the `Tables` begins
        ],
    )
)
"""What is told of each kind, then of what is part of a kind, then of other shapes: first come those with a scan.

share: of a kind, in what is near to a kind but off; of the others, in the kind that it is part of, or in none of these.
spare: readings beyond the unknowns.
"""


class Tables(NamedTuple):
    """What the sensors read of each kind, and then of each that is climbed to without a scan.

    bases, edges, squares, tables as in `project_frames`, and fines, nodes, rows as in `Survey`: all kinds' one after
    the other, so that any number of kinds is one compilation. positions (m,): of the scans, with so many steps of the
    survey to each.
    """

    bases: npt.NDArray[np.float32]
    edges: npt.NDArray[np.float32]
    squares: FloatArray
    tables: FloatArray
    fines: FloatArray
    nodes: FloatArray
    rows: FloatArray
    positions: FloatArray
    steps: int


class KindsAsked(NamedTuple):
    """The cone; chi-squares: explained by what is a contact, left by one kind, and left by two touches.

    scanned, parts: how many kinds there are, and how many with what is part of one. two, none: the first columns of two
    touches and of none of these, -1 where not asked for; two_share, two_spare: as of `KINDS`; off: log of the share of
    model errors in none of these.
    """

    friction: float
    detection: float
    largest: float
    largest_pair: float
    scanned: int
    parts: int
    two: int
    none: int
    two_share: float
    two_spare: float
    off: float


class WeighingRoom(NamedTuple):
    """Scratch: readings, in single precision too, a scan and its sums, nodes to climb from, the field, and fits.

    seeds (2, 2): where other shapes are climbed to from, and second moments there. counts, fits (kinds,): the peaks of
    each kind.
    """

    w: FloatArray
    single: npt.NDArray[np.float32]
    scans: npt.NDArray[np.float32]
    sums: npt.NDArray[np.float32]
    score: FloatArray
    at: FloatArray
    seeds: FloatArray
    rows: FloatArray
    shares: FloatArray
    spare: npt.NDArray[np.void]
    valleys: Valleys
    counts: npt.NDArray[np.int64]
    fits: npt.NDArray[np.void]
    both: PairRoom


@compiled(inline=True)
def _sought(told, tables, friction, room):
    """What the sensors read of a kind."""
    size, t = 10 * room.w.size, told.tables
    table = tables.tables[t : t + told.cells * told.widths * size].reshape(told.cells, told.widths, size)
    model = Wide(table, told.start, told.step, told.widest, room.rows, room.shares)
    return Sought(model, Limits(friction, 0.0, math.inf), told.ends)


@compiled(inline=True)
def _scanned(told, tables, room):
    """The scan of a kind, (squares, m), and its squares."""
    n, m, count, sums, s = room.w.size, tables.positions.size, told.scanned, room.sums, room.scans
    b, e, q, size = told.bases, told.edges, told.squares, told.scanned * tables.positions.size
    basis, edges = tables.bases[b : b + 2 * n * size].reshape(n, 2, size), tables.edges[e : e + 4 * size]
    scan(room.single, basis, edges.reshape(4, size), sums[: 2 * size].reshape(2, size), s[:size])
    return s[:size].reshape(count, m), tables.squares[q : q + count]


@compiled(inline=True)
def _survey(told, tables, n):
    """The survey of a kind."""
    fine, wide = tables.steps * (tables.positions.size - 1) + 1, told.surveyed
    f, e, r = told.fines, told.nodes, told.rows
    return Survey(
        tables.fines[f : f + 2 * n * wide * fine].reshape(n, 2, wide, fine),
        tables.nodes[e : e + 4 * wide * fine].reshape(4, wide, fine),
        tables.rows[r : r + 3 * wide].reshape(3, wide),
        (tables.positions[-1] - tables.positions[0]) / (fine - 1),
    )


@compiled(borrows=True)
def _climbed_from(sought, at, room, fits):
    """The peaks that are reached from `at`, (y, q) each, the best first and each once: their number."""
    kept, y_apart, q_apart = 0, SAME * sought.model.step, 1e-3 * sought.model.widest**2
    fit, ends = room.spare[0], sought.ends
    for p in range(len(at)):
        climbed(room.w, sought, ends, at[p, 0], min(max(at[p, 1], ends[2]), ends[3]), fit, room.spare[1])
        e, new = kept, True
        for d in range(kept):
            new &= abs(fits[d].y - fit.y) > y_apart or abs(fits[d].q - fit.q) > q_apart
        while e > 0 and fit.explained > fits[e - 1].explained:
            e -= 1
        if new and e < _PEAKS:
            for k in range(min(kept, _PEAKS - 1), e, -1):
                fits[k] = fits[k - 1]
            fits[e] = fit
            kept = min(kept + 1, _PEAKS)
    return kept


@compiled(borrows=True)
def _tops(s, squares, positions, thorough, room):
    """The highest positions of a scan over y and q into the room's: their number.

    With `thorough`, the best position of each width.
    """
    at = room.at
    if not thorough:
        return highest(s, positions[0], positions[1] - positions[0], squares, room.score[:_PEAKS], at)
    for j in range(squares.size):
        k = 0
        for p in range(1, positions.size):
            k = p if s[j, p] > s[j, k] else k
        at[j, 0], at[j, 1] = positions[k], squares[j]
    return squares.size


@compiled(borrows=True)
def _seeds(total, counts, fits, kinds, far, at):
    """Where other shapes are climbed to from, and second moments there: their number.

    These are the best of the kinds, and the best that is `far` from it; that only where it fits about as well.
    """
    found, least = 0, math.inf
    for _ in range(2):
        best = -1
        for k in range(counts.size):
            if counts[k] > 0 and (found == 0 or abs(fits[k, BEST].y - at[0, 0]) > far):
                best = k if best < 0 or fits[k, BEST].explained > fits[best, BEST].explained else best
        if best < 0 or total - fits[best, BEST].explained > 4.0 * least + NEGLIGIBLE:
            break
        at[found, 0], at[found, 1] = fits[best, BEST].y, kinds[best].moment * fits[best, BEST].q
        found, least = found + 1, total - fits[best, BEST].explained
    return found


@compiled(borrows=True)
def _near(fits, explained):
    """How many of the peaks explain about as much as the best of all."""
    near = 0
    while near < fits.size and fits[near].explained > explained - 2.0 * NEGLIGIBLE:
        near += 1
    return near


@compiled(borrows=True)
def _none(row, kinds, asked, power):
    """Log of the evidence of what is near to one of the kinds: of their mean, were the noise larger by a model error.

    Half of it is near to two touches, where these are asked for. power: mean square of the readings. Forces, positions
    and widths that fit are as many more as the noise is larger, so that only the spare readings pay.
    """
    sums = -math.inf
    for e in range(ERRORS.size):
        inflated = 1.0 + ERRORS[e] * ERRORS[e] * power
        for k in range(asked.scanned + (asked.two >= 0)):
            one = k < asked.scanned
            column, share, spare = asked.two, asked.two_share, asked.two_spare
            if one:
                column, share, spare = kinds[k].column, kinds[k].share, kinds[k].spare
            log = row[column + LOG_EVIDENCE]
            if log > -math.inf:
                here = log + 0.5 * row[column + CHI2] * (1.0 - 1.0 / inflated)
                sums = add(sums, here + share - 0.5 * spare * math.log(inflated))
    return sums - math.log(float(ERRORS.size))


@compiled(borrows=True)
def _say(row, column, total, fit):
    """The best contact of a kind."""
    row[column + CHI2], row[column + POSITION] = max(total - fit.explained, 0.0), fit.y
    row[column + NORMAL], row[column + TANGENTIAL] = fit.n, fit.t
    row[column + HALF_WIDTH] = math.sqrt(fit.q)


@compiled(inline=True)
def _climbs(thorough, kinds, tables, asked, room):
    """The peaks of each kind, and of what is part of one: how much the best of all explains."""
    explained, counts, fits = 0.0, room.counts, room.fits
    for k in range(asked.parts):
        told, at = kinds[k], room.at
        sought, tops = _sought(told, tables, asked.friction, room), 0
        if k < asked.scanned:
            s, squares = _scanned(told, tables, room)
            tops = _tops(s, squares, tables.positions, thorough, room)
        else:
            whole = told.whole
            tops = counts[whole]
            for p in range(tops):
                fit = fits[whole, p]
                at[p, 0], at[p, 1] = fit.y, kinds[whole].moment * fit.q / told.moment
        counts[k] = _climbed_from(sought, at[:tops], room, fits[k])
        if counts[k] > 0:
            explained = max(explained, fits[k, BEST].explained)
    return explained


@compiled(inline=True)
def _weigh_kind(told, tables, asked, explained, room, fits):
    """Log of the evidence of a kind from its peaks, less half of what is `explained`; -inf without any."""
    sought, survey = _sought(told, tables, asked.friction, room), _survey(told, tables, room.w.size)
    near, log = _near(fits, explained), -math.inf
    if near > 0 and broad(room.w, sought, fits[BEST], survey):
        s, squares = _scanned(told, tables, room)
        log = surveyed(room.w, s, squares, explained, asked.friction, survey)
    elif near > 0:
        log = over_widths(room.w, sought, fits[:near], room.spare, room.valleys)
    return log - 0.5 * explained


@compiled(inline=True)
def _others(total, known, explained, kinds, tables, asked, room, row):
    """Log of the evidence of other shapes; and to the row, that of what is part of a kind."""
    shaped, parts, found, seeds, at, counts, fits = (
        -math.inf,
        asked.parts,
        0,
        room.seeds,
        room.at,
        room.counts,
        room.fits,
    )
    if parts < kinds.size:
        found = _seeds(total, counts[:parts], fits, kinds, 4.0 * kinds[0].step, seeds)
    for k in range(asked.scanned, kinds.size):
        told = kinds[k]
        sought = _sought(told, tables, asked.friction, room)
        if k >= parts:
            for p in range(found):
                at[p, 0], at[p, 1] = seeds[p, 0], seeds[p, 1] / told.moment
            counts[k] = _climbed_from(sought, at[:found], room, fits[k])
        here = -math.inf
        for p in range(_near(fits[k, : counts[k]], known)):
            here = add(here, valley(room.w, sought, fits[k, p], room.valleys.gauss))
        here += told.share - 0.5 * explained
        if k >= parts:
            shaped = add(shaped, here)
            continue
        column = kinds[told.whole].column
        before = row[column + LOG_EVIDENCE] + told.left
        row[column + LOG_EVIDENCE] = add(before, here)
        if here > before:
            _say(row, column, total, fits[k, BEST])
    return shaped


@compiled(frames="readings")
def weigh_frames(readings, sensors, kinds, tables, asked, pairs, out):
    """Fill `out`, one row a frame; the columns are named in `base.py`.

    kinds, tables, asked, pairs: `KINDS`, `Tables`, `KindsAsked`, `TouchPairs`.
    """
    n, count = readings.shape[1], kinds.size
    most, wides = kinds["scanned"].max() * tables.positions.size, kinds["widths"].max()
    valleys = Valleys(np.empty((_PEAKS, 2)), np.empty(_PEAKS), np.empty(_PEAKS), np.empty(4), gaussian(3))
    room = WeighingRoom(
        np.empty(n), np.empty(n, dtype=np.float32), np.empty(most, dtype=np.float32),
        np.empty(2 * most, dtype=np.float32), np.empty(_PEAKS), np.empty((max(kinds["scanned"].max(), _PEAKS), 2)),
        np.empty((2, 2)), np.empty((12, n)), np.empty((3, 10 * n + wides + 3)), np.empty(2, WIDE_FIT), valleys,
        np.zeros(count, np.int64), np.empty((count, _PEAKS), WIDE_FIT), pair_room(pairs),
    )  # fmt: skip
    _each(readings, sensors, kinds, tables, asked, pairs, room, out)


@compiled(borrows=True)
def _each(readings, sensors, kinds, tables, asked, pairs, room, out):
    """Frame by frame; arguments as of `weigh_frames`."""
    w, counts, fits, n = room.w, room.counts, room.fits, readings.shape[1]
    for f in range(len(readings)):
        row = out[f]
        row[:] = math.nan
        total = whitened(readings[f], sensors, w)
        if not total < MOST_CHI2:
            row[STATUS] = _PENDING
            continue
        for i in range(n):
            room.single[i] = w[i]
        explained = 0.0
        for attempt in range(2):
            # before a frame is called unexplained, the best position of each width is tried
            if attempt == 0 or total - explained > asked.largest:
                explained = max(explained, _climbs(attempt == 1, kinds, tables, asked, room))
        two, chi2_pair, explains = -math.inf, total, total - explained <= asked.largest
        if asked.two >= 0:
            if total - explained > _ALONE and total >= asked.detection:
                two, chi2_pair = weigh_pairs(w, room.single, pairs, asked.friction, room.both, row, asked.two)
                explains |= chi2_pair <= asked.largest_pair
            row[asked.two + LOG_EVIDENCE], row[asked.two + CHI2] = two + 0.5 * (total - explained), chi2_pair
        needed = max(explained, total - asked.largest_pair if asked.two >= 0 else 0.0)
        row[STATUS] = _OK if explains and needed >= asked.detection else _NO_CONTACT if explains else _UNEXPLAINED
        if row[STATUS] != _OK:
            continue
        for k in range(asked.scanned):
            column = kinds[k].column
            row[column + LOG_EVIDENCE], row[column + CHI2] = -math.inf, total
            if counts[k] > 0:
                _say(row, column, total, fits[k, BEST])
                peaks = fits[k, : counts[k]]
                row[column + LOG_EVIDENCE] = _weigh_kind(kinds[k], tables, asked, explained, room, peaks)
        known = max(explained, total - chi2_pair)
        shaped = _others(total, known, explained, kinds, tables, asked, room, row)
        if asked.none >= 0:
            row[asked.none + LOG_EVIDENCE] = add(_none(row, kinds, asked, total / n) + asked.off, shaped)
