"""The compiled heart of `locate` on an area: variable projection of each frame.

Frames of one strongest sensor go one after another (`order.py`): its tile is then read from near by, and what is asked
of all alike is asked of eight. Scan S over that tile (`scan.py`), climb from its highest nodes (`tops.py`); where what
is left is more than noise, over the whole grid, then over a finer one. Where no load further out could explain the
readings (`reach.py`), a tile over the sensors is enough.
Judge, look round the top, at the sides of the search and beyond, and write a row. Only arrays and numbers go in and
out: `locator.py` prepares them, `estimate/layout.py` names the columns.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..._lanes import EIGHT, fetch
from ..layout import AREA
from .climb import FIT, climb
from .fall import LANES
from .field import ROWS
from .judge import FINE, MOST, beside, covariance, is_broad, look_round, outside, unsure, widest_variance
from .order import by_strongest, whitened
from .reach import FEW as LANED
from .reach import crowded, regions_left
from .scan import taken
from .tops import nearby, search

FEW, _AGAIN = 4, 3
MOST_CHI2 = 1e30
_TINY = 12
"""Sensors that may leave two tops near each other, whatever they read."""
_TOLD = 1000.0
"""Chi-square by which a load has to be told from those half a depth away, so that no second top is looked for."""
_BARE = 7
"""Sensors at which the finest scan looks at each frame: with one or two spare readings a wrong top explains as well."""
_ALL = (1 << EIGHT) - 1
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_FORCES, _RESIDUAL = AREA.components, AREA.residual
_RIVAL, _RIVAL_CHI2, _STATUS = AREA.rival, AREA.rival_chi2, AREA.status


@compiled(borrows=True)
def _settle(
    w, single, total, tile, over, sensors, first, table, terms, tiles, near_sensors, near_first, options, row, size, c,
    heights, lead, part, scratch, whole, score, at, fits, trials, lanes, ratio, more,
):  # fmt: skip
    """Fill the row of a frame but for what loads beyond the search say: what these are to explain; infinite if nothing.

    over: whether a tile over the sensors is enough; size, c: what `scan.taken` gave of the first tile.
    """
    n = w.size
    detection, largest, ambiguity = options[1], options[2], options[3]
    base = tiles[0].shape[0] - n - 2  # tiles that are looked at first, where there are any
    best = second = -1
    left = bound = largest
    for attempt in range(2 if n <= _BARE else 0 if over else 1, 3):
        t, most, share = (base + n + 1, MOST, 0.05) if attempt == 2 else (base * attempt + tile, FEW, 0.25)
        if attempt != (0 if over else 1):
            size = taken(single, single, tiles, t, c, c)[0]
        best, second = search(
            w, sensors, first, table, terms, tiles, near_sensors, near_first, t, most, share, options, scratch, whole,
            size, c, heights, lead, score, at, fits, part,
        )  # fmt: skip
        left, bound = total, largest
        if best >= 0:
            left = fits[best, 17]
            if attempt > 0:
                bound += options[13] * (fits[best, 0] ** 2 + fits[best, 1] ** 2 + fits[best, 2] ** 2)
        if left <= bound:
            break
    row[_RESIDUAL] = left
    if left > bound:
        row[_STATUS] = _UNEXPLAINED
        return math.inf
    explained = fits[best, 3] if best >= 0 else 0.0
    if explained < detection:
        row[_STATUS] = _NO_CONTACT
        return math.inf
    if second >= 0 and explained - fits[second, 3] < ambiguity:  # it was climbed roughly, maybe to the same top
        climb(
            w, sensors, first, table, terms, options[0], options[9:13], fits[second, 29], fits[second, 30], FINE,
            options[8], 0.0, -math.inf, scratch, whole, fits[second], trials[0],
        )  # fmt: skip
        if fits[second, 3] > explained:
            best, second = second, best
        if abs(fits[second, 29] - fits[best, 29]) + abs(fits[second, 30] - fits[best, 30]) < options[4]:
            second = -1
    more[0] = more[1] = more[2] = 0.0
    few = n <= _TINY or explained * options[14] < _TOLD
    if few:
        covariance(fits[best], options[0], more, row)
        best, second = beside(
            w, sensors, first, table, terms, options, best, second, row, scratch, whole, fits
        )  # fmt: skip
    fit, status, shape = fits[best], _OK, 0
    for _ in range(_AGAIN):
        covariance(fit, options[0], more, row)
        spread = widest_variance(row)
        if not (options[7] * options[7] < spread < options[5] * options[5] * 100.0):
            break
        near = nearby(w, sensors, first, near_sensors, near_first, tiles[0], t, part)
        shape = look_round(
            w, near, sensors, first, table, terms, options, fit, row, scratch, whole, trials, lanes, ratio, more
        )  # fmt: skip
        if shape >= 0:
            break
        y, z = trials[2, 29], trials[2, 30]
        climb(
            w, sensors, first, table, terms, options[0], options[9:13], y, z, FINE, options[8], 0.0, -math.inf,
            scratch, whole, fit, trials[0],
        )  # fmt: skip
        more[0] = more[1] = more[2] = 0.0
    if more[0] != 0.0 or shape < 0:
        covariance(fit, options[0], more, row)
    explained, row[_RESIDUAL] = fit[3], fit[17]
    row[0], row[1] = fit[29], fit[30]
    row[_FORCES], row[_FORCES + 1], row[_FORCES + 2] = fit[0], fit[1], fit[2]
    if second >= 0:
        row[_RIVAL], row[_RIVAL + 1] = fits[second, 29], fits[second, 30]
        row[_RIVAL + 2], row[_RIVAL + 3], row[_RIVAL + 4] = fits[second, 0], fits[second, 1], fits[second, 2]
        worse = max(explained - fits[second, 3], 0.0)
        row[_RIVAL_CHI2] = worse
        if worse < ambiguity:
            status = _AMBIGUOUS
    margin = 2.0 * options[4]
    if not (
        options[9] + margin < row[0] < options[10] - margin and options[11] + margin < row[1] < options[12] - margin
    ):
        status = _AMBIGUOUS
    if shape < 0 or shape > 1:
        status = _AMBIGUOUS
    if unsure(fit, row, spread, options) or (
        (shape == 1 or few)
        and 6.0 * math.sqrt(spread) > options[5]
        and is_broad(single[:n], tiles, fit, row, spread, options, trials[0])
    ):
        status = _AMBIGUOUS
    row[_STATUS] = status
    return explained - ambiguity if status == _OK else math.inf


@compiled(inline=True)
def _frames(kept, found):
    """The frames that regions were left of, as bits."""
    frames = 0
    for i in range(found):
        frames |= kept[i, 1]
    return frames


@compiled(borrows=True)
def _each(
    readings, rows, sensors, first, table, terms, tiles, near_sensors, near_first, outer, nodes, boxes, far, options,
    out, hot, order, wide, asked, sums, kept, fulls, singles, shares, s, heights, lead, part, scratch, whole,
    score, at, fits, trials, lanes, ratio, more,
):  # fmt: skip
    """As `project_frames`, with its scratch; hot, order: as of `by_strongest`.

    Up to eight frames of one strongest sensor go side by side where regions are asked, and two where nodes are. sums
    (3, 8) keeps chi-square of their readings, what loads beyond are to explain, and chi-square of those that count;
    asked (3, 8) what `regions_left` is given.
    """
    n = readings.shape[1]
    least = options[2] + options[3]
    ring, beyond, held, members = far
    begin = 0
    while begin < order.size:
        tile, count = hot[order[begin]], 1
        while count < EIGHT and begin + count < order.size and hot[order[begin + count]] == tile:
            count += 1
        for turn in range(begin + count, min(begin + count + EIGHT, order.size)):  # those that come next
            for i in range(0, n, EIGHT):
                fetch(readings, n * order[turn] + i)
            for i in range(0, out.shape[1], EIGHT):
                fetch(out, out.shape[1] * order[turn] + i)
        inner = tile < n and tiles[0].shape[0] > n + 2 and ring[0].shape[0] > 0
        for k in range(EIGHT):
            asked[0, k], asked[1, k] = 0.0, math.inf
        for k in range(count):
            f, single = order[begin + k], singles[k]
            row = out[f]
            sums[0, k] = total = whitened(readings[f], rows, fulls[k], single)
            for i in range(row.size):
                row[i] = math.nan
            row[_RIVAL_CHI2] = math.inf
            if not total < MOST_CHI2:
                row[_STATUS] = _PENDING
                continue
            asked[0, k] = total
            for i in range(n if n < LANED else 0):
                wide[i, k] = single[i]
            if inner and not crowded(single, total, total - least, tile, ring[4], ring[5]):
                asked[1, k] = total - least
        may = _ALL
        if inner:
            may = _frames(
                kept, regions_left(singles, wide, asked, tile, ring[0], ring[1], ring[2], ring[3], True, kept)
            )
        base = tiles[0].shape[0] - n - 2
        for wider in range(2):
            one = -1
            for k in range(count):
                if (may >> k) & 1 == wider:
                    if one >= 0:
                        sums[2, one], sums[2, k] = taken(
                            singles[one], singles[k], tiles, base * wider + tile, shares[one], shares[k]
                        )
                        one = -1
                    else:
                        one = k
            if one >= 0:
                single = singles[one]
                sums[2, one] = taken(single, single, tiles, base * wider + tile, shares[one], shares[one])[0]
        for k in range(count):
            total, single, needed = sums[0, k], singles[k], math.inf
            if total < MOST_CHI2:
                needed = _settle(
                    fulls[k, :n], single, total, tile, (may >> k) & 1 == 0, sensors, first, table, terms, tiles,
                    near_sensors, near_first, options, out[order[begin + k]], sums[2, k], shares[k], heights, lead,
                    part, scratch, whole, score, at, fits, trials, lanes, ratio, more,
                )  # fmt: skip
            sums[1, k] = asked[1, k] = needed
            if needed < math.inf and crowded(single, total, needed, tile, beyond[4], beyond[5]):
                asked[1, k] = math.inf
        found, kept[0, 0], kept[0, 1] = 1, 0, _ALL  # of no region: all nodes, as of one
        if beyond[0].shape[0] > 0:
            found = regions_left(singles, wide, asked, tile, beyond[0], beyond[1], beyond[2], beyond[3], False, kept)
        may = _frames(kept, found)
        for k in range(count):
            if (may >> k) & 1 and sums[1, k] < math.inf and outside(
                fulls[k, :n], singles[k], sensors, first, table, terms, outer, nodes, held, members, kept[:found], k,
                sums[1, k], options, boxes, scratch, whole, s, trials,
            ):  # fmt: skip
                out[order[begin + k], _STATUS] = _AMBIGUOUS
        begin += count


@compiled()
def project_frames(
    readings, rows, sensors, first, table, terms, tiles, near_sensors, near_first, outer, nodes, boxes, sizes, far,
    options, out,
):  # fmt: skip
    """Fill `out`, one row a frame; frames that are beyond reckoning or lack a sensor are left with status -1.

    readings (f, n), raw; rows (4, n): offset, 1 / noise, low and high end of the range; sensors, first, table, terms:
    as of `field.field_at`, then those of the sensors near each tile; tiles, outer: `Tiles` of the search and of what is
    beyond, whose nodes (nodes, 4) lie in `boxes`; sizes: most nodes, and the longest row of these and two; far: `Far`
    of the search but its part over the sensors, and of what is beyond, then the nodes of its regions (`far.nodes_of`);
    options: mu, the thresholds of detection and of chi-square, ambiguity, apart, broad, the reading from which the
    strongest names a tile, the deviation from which S need be no parabola, the smallest step, the search, the table's
    error, and the least share of a load by which others near it differ; infinite where that is large.
    """
    n = readings.shape[1]
    widest, lead = sizes[0], sizes[1]
    shares = np.empty((EIGHT, 3 * widest + 2 * n + 4), dtype=np.float32)
    s = np.empty(widest, dtype=np.float32)
    heights = np.empty(widest + 2 * lead, dtype=np.float32)
    for p in range(lead):
        heights[p] = np.float32(-1)
    fulls, singles, part = np.zeros((EIGHT, n + 1)), np.zeros((EIGHT, n + 1), dtype=np.float32), np.empty(n + 1)
    wide, asked = np.zeros((n, EIGHT), dtype=np.float32), np.zeros((3, EIGHT), dtype=np.float32)
    sums, kept = np.empty((3, EIGHT)), np.empty((max(far[0][1].size, far[1][1].size) + 1, 2), dtype=np.int64)
    scratch = np.empty((ROWS, n + 1))
    turns = np.empty((2, readings.shape[0] + n + 2), dtype=np.int64)
    hot, order, start = turns[0, n + 2 :], turns[1, n + 2 :], turns[0, : n + 2]
    by_strongest(readings, rows, options[6], hot, start, order)
    score, at, fits, trials = np.empty(MOST), np.empty((MOST, 2)), np.empty((MOST + 6, FIT)), np.empty((3, FIT))
    lanes, ratio, more = np.empty(LANES), np.empty(8), np.zeros(3)
    _each(
        readings, rows, sensors, first, table, terms, tiles, near_sensors, near_first, outer, nodes, boxes, far,
        options, out, hot, order, wide, asked, sums, kept, fulls, singles, shares, s, heights, lead, part,
        scratch, scratch.view(np.int64), score, at, fits, trials, lanes, ratio, more,
    )  # fmt: skip
