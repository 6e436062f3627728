"""The compiled heart of `locate` on an area: variable projection, one frame at a time.

Frames of one strongest sensor go one after another: its tile is then read from near by. Scan S over that tile
(`scan.py`), climb from its highest nodes (`climb.py`); where what is left is more than noise, over the whole grid, then
over a finer one. Where no load further out could explain the readings (`reach.py`), a tile over the sensors is enough.
Judge, look round the top, at the sides of the search and beyond, and write a row. Only arrays and numbers go in and
out: `locator.py` prepares them, `estimate/layout.py` names the columns.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..layout import AREA
from .climb import FIT, climb
from .fall import LANES
from .field import ROWS
from .judge import FINE, MOST, beside, covariance, is_broad, look_round, outside, unsure, widest_variance
from .reach import may_reach
from .scan import peaks, scan

FEW, _AGAIN = 4, 3
MOST_CHI2 = 1e30
_SIZE, _WORD, _INDEX = np.int64(0x7FFFFFFF), np.int64(32), np.int64(0xFFFFFFFF)
_TINY = 12
"""Sensors that may leave two tops near each other."""
_SMALL = 24
"""Sensors of which all are fitted at once; of more, first those near the strongest."""
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_FORCES, _RESIDUAL = AREA.components, AREA.residual
_RIVAL, _RIVAL_CHI2, _STATUS = AREA.rival, AREA.rival_chi2, AREA.status


@compiled(inline=True)
def nearby(w, sensors, first, near_sensors, near_first, index, t, part):
    """Readings, sensors and rows of tables of those that count in tile t, where these are few; else all."""
    i0, k = index[t, 0], index[t, 1]
    near = w, sensors, first
    if 4 * k < 3 * w.size and w.size > _SMALL:
        its_first = near_first[i0 + t : i0 + t + k + 1]
        near = part[:k], near_sensors[4 * i0 : 4 * (i0 + k)].reshape((4, k)), its_first
    return near


@compiled(borrows=True)
def search(
    w, single, sensors, first, table, terms, tiles, near_sensors, near_first, t, most, share, options, scratch, whole,
    c, heights, lead, words, peak, score, at, fits, part,
):  # fmt: skip
    """Best and second-best top of S from the highest nodes of tile t, as rows of `fits`; -1 where there is none.

    Of many sensors first those that count are fitted, then all; `part` keeps the readings of these.
    """
    index, origin, near, basis, shapes = tiles
    mu, apart, smallest, box = options[0], options[4], options[8], options[9:13]
    i0, k, m, stride = index[t, 0], index[t, 1], index[t, 3], index[t, 6]
    total = scan(
        single,
        near[i0 : i0 + k],
        basis[index[t, 2] : index[t, 2] + 3 * k * m].reshape((k, 3 * m)),
        shapes[index[t, 4] : index[t, 4] + 9 * m].reshape((9, m)),
        mu,
        c,
        heights[lead : lead + m],
        index[t, 7] == 1,
    )
    for p in range(lead + m, lead + m + stride + 2):
        heights[p] = np.float32(-1)
    near_w, its_sensors, its_first = nearby(w, sensors, first, near_sensors, near_first, index, t, part)
    few = near_w.size < w.size
    straight = 0.02 * options[5] if few else 0.0
    if few:
        for i in range(k):
            e = near[i0 + i]
            near_w[i] = w[e] if e < w.size else 0.0
    best = second = -1
    spare = MOST
    count = peaks(heights, lead, m, stride, total, share, words, peak, score[:most], at)
    for q in range(count + 1):
        # a maximum clearly lower than both already found cannot become the best or the rival
        last = q == count or (second >= 0 and score[q] < 0.8 * fits[second, 3])
        if last and best <= 0:
            break
        p = best if last else q  # at last the best, if it was climbed roughly
        tolerance, needed = FINE, -math.inf
        if not last and q > 0:
            tolerance = 1e-2 * max(fits[best, 3] - score[p], 0.1)
            needed = fits[second, 3] if second >= 0 else needed
        y, z = origin[t, 0] + at[p, 0] * origin[t, 2], origin[t, 1] + at[p, 1] * origin[t, 3]
        for every in range(0 if few else 1, 2):
            v, layout, kinds = (w, sensors, first) if every else (near_w, its_sensors, its_first)
            climb(
                v, layout, kinds, table, terms, mu, box, y, z, tolerance, smallest, straight,
                needed if every else -math.inf, scratch, whole, fits[p], fits[spare],
            )  # fmt: skip
            y, z = fits[p, 29], fits[p, 30]
        if last:
            break
        if best < 0:
            best = p
        elif abs(fits[p, 29] - fits[best, 29]) + abs(fits[p, 30] - fits[best, 30]) < apart:
            if fits[p, 3] > fits[best, 3]:
                best = p
        elif fits[p, 3] > fits[best, 3]:
            best, second = p, best
        elif second < 0 or fits[p, 3] > fits[second, 3]:
            second = p
    return best, second


@compiled(inline=True)
def whitened(frame, rows, w, single):
    """Fill w and single (n + 1,), readings in units of noise, and give the sum of their squares; NaN if one is out."""
    total, usable = 0.0, True
    n = frame.size
    for i in range(n):
        r = frame[i]
        usable &= rows[2, i] < r < rows[3, i]
        w[i] = (r - rows[0, i]) * rows[1, i]
        single[i] = w[i]
        total += w[i] * w[i]
    return total if usable else math.nan


@compiled(inline=True)
def strongest(single, bits, n):
    """The sensor with the largest reading, and its square; bits: the readings as integers, which are as quick to rank.

    Numbers without their sign rank as their bits do.
    """
    largest = np.int64(0)
    for i in range(n):  # the first of equals
        largest = max(largest, (np.int64(bits[i] & _SIZE) << _WORD) + (n - 1 - i))
    hot = n - 1 - (largest & _INDEX)
    return hot, single[hot] * single[hot]


@compiled(borrows=True)
def by_strongest(readings, rows, hot, start, order):
    """Each frame's strongest sensor into hot, and the frames into order: first those of sensor 0, then those of 1.

    start (n + 1,): scratch.
    """
    frames, n = readings.shape
    for i in range(n + 1):
        start[i] = 0
    for f in range(frames):
        frame, largest, here = readings[f], -1.0, 0
        for i in range(n):
            size = abs((frame[i] - rows[0, i]) * rows[1, i])
            here = i if size > largest else here
            largest = size if size > largest else largest
        hot[f] = here
        start[here + 1] += 1
    for i in range(n):
        start[i + 1] += start[i]
    for f in range(frames):
        order[start[hot[f]]] = f
        start[hot[f]] += 1


@compiled(borrows=True)
def _each(
    readings, rows, sensors, first, table, terms, tiles, near_sensors, near_first, outer, nodes, boxes, far, options,
    out, hot, order, c, s, heights, lead, words, peak, full, single, part, scratch, whole, score, at, fits, trials,
    lanes, ratio, more,
):  # fmt: skip
    """As `project_frames`, with its scratch; hot, order: as of `by_strongest`."""
    n = readings.shape[1]
    w = full[:n]
    detection, largest, ambiguity, strong = options[1], options[2], options[3], options[6]
    ring, beyond, held, members = far
    base = tiles[0].shape[0] - n - 2  # tiles that are looked at first, where there are any
    for turn in range(order.size):
        f = order[turn]
        row = out[f]
        total = whitened(readings[f], rows, full, single)
        for i in range(row.size):
            row[i] = math.nan
        row[_RIVAL_CHI2] = math.inf
        if not total < MOST_CHI2:
            row[_STATUS] = _PENDING
            continue
        top = single[hot[f]]
        tile = hot[f] if top * top >= strong * strong else n
        least = total - largest - ambiguity
        over = tile < n and base > 0 and not may_reach(single, total, least, tile, *ring)
        best = second = -1
        left = bound = largest
        for attempt in range(0 if over else 1, 3):
            t, most, share = (base + n + 1, MOST, 0.05) if attempt == 2 else (base * attempt + tile, FEW, 0.25)
            best, second = search(
                w, single, sensors, first, table, terms, tiles, near_sensors, near_first, t, most, share, options,
                scratch, whole, c, heights, lead, words, peak, score, at, fits, part,
            )  # fmt: skip
            left, bound = total, largest
            if best >= 0:
                left = fits[best, 17]
                if attempt > 0:
                    bound += options[13] * (fits[best, 0] ** 2 + fits[best, 1] ** 2 + fits[best, 2] ** 2)
            if left <= bound:
                break
            over = False
        row[_RESIDUAL] = left
        if left > bound:
            row[_STATUS] = _UNEXPLAINED
            continue
        explained = fits[best, 3] if best >= 0 else 0.0
        if explained < detection:
            row[_STATUS] = _NO_CONTACT
            continue
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
        if n <= _TINY:
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
            (shape == 1 or n <= _TINY)
            and 6.0 * math.sqrt(spread) > options[5]
            and is_broad(single[:n], tiles, fit, row, spread, options, trials[0])
        ):
            status = _AMBIGUOUS
        least = explained - ambiguity
        if status == _OK and outside(
            w, single, total, sensors, first, table, terms, outer, nodes, beyond, held, members, tile, least, options,
            boxes, scratch, whole, s, trials,
        ):  # fmt: skip
            status = _AMBIGUOUS
        row[_STATUS] = status


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
    error.
    """
    n = readings.shape[1]
    widest, lead = sizes[0], sizes[1]
    c, s = np.empty(3 * widest, dtype=np.float32), np.empty(widest, dtype=np.float32)
    heights = np.empty(widest + 2 * lead, dtype=np.float32)
    for p in range(lead):
        heights[p] = np.float32(-1)
    words = np.zeros(widest // 8 + 1, dtype=np.uint64)
    peak = words.view(np.uint8)
    full, single, part = np.zeros(n + 1), np.zeros(n + 1, dtype=np.float32), np.empty(n + 1)
    scratch = np.empty((ROWS, n + 1))
    turns = np.empty((2, readings.shape[0] + n + 1), dtype=np.int64)
    hot, order, start = turns[0, n + 1 :], turns[1, n + 1 :], turns[0, : n + 1]
    by_strongest(readings, rows, hot, start, order)
    score, at, fits, trials = np.empty(MOST), np.empty((MOST, 2)), np.empty((MOST + 5, FIT)), np.empty((3, FIT))
    lanes, ratio, more = np.empty(LANES), np.empty(8), np.zeros(3)
    _each(
        readings, rows, sensors, first, table, terms, tiles, near_sensors, near_first, outer, nodes, boxes, far,
        options, out, hot, order, c, s, heights, lead, words, peak, full, single, part, scratch,
        scratch.view(np.int64), score, at, fits, trials, lanes, ratio, more,
    )  # fmt: skip
