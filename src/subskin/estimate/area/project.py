"""The compiled heart of `locate` on an area: variable projection of each frame.

Frames of one strongest sensor go one after another (`scan.by_strongest`): its tile is then read from near by, and what
is asked of all alike is asked of eight. Scan S over that tile (`scan.py`), climb from its highest nodes
(`judge.tops_of`); where what is left is more than noise, over the whole grid, then over a finer one. Where no load
further out could explain the readings (`far.py`), a tile over the sensors is enough.
Judge, look round the top, at the sides of the search and beyond, and write a row. Only arrays and numbers go in and
out: `locator.py` prepares them, `estimate/layout.py` names the columns.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..._lanes import EIGHT, fetch
from ..layout import AREA
from ..varpro import Ending, Limits
from .fall import LANES, look_round, widest_variance
from .far import FEW as LANED
from .far import Far, crowded, regions_left
from .judge import (
    FINE,
    MOST,
    Beyond,
    Scratch,
    Search,
    Settings,
    beside,
    is_broad,
    nearby,
    outside,
    tops_of,
    unsure,
)  # fmt: skip
from .moments import FEW_SENSORS, moments
from .point import FIT, Point, climb, covariance, in_room
from .scan import by_strongest, taken, whitened
from .tiles import Tiles

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
_FORCES, _COVARIANCE, _RESIDUAL = AREA.components, AREA.covariance, AREA.residual
_Y, _Z = 0, 1
_RIVAL, _RIVAL_CHI2, _STATUS = AREA.rival, AREA.rival_chi2, AREA.status


@compiled(borrows=True)
def _settle(w, single, total, tile, over, search, room, row, size, c):
    """Fill the row of a frame but for what loads beyond the search say: what these are to explain; infinite if nothing.

    over: whether a tile over the sensors is enough; size, c: what `scan.taken` gave of the first tile.
    """
    n, settings, tiles, fits, more, trial = w.size, search.settings, search.tiles, room.fits, room.more, room.trials[0]
    limits, box, model = settings.limits, settings.box, search.model
    fine, spread = Ending(FINE, settings.smallest, 0.0, -math.inf), row[_COVARIANCE:_RESIDUAL]
    base = tiles.table.shape[0] - n - 2  # tiles that are looked at first, where there are any
    best = second = -1
    left = bound = settings.largest
    for attempt in range(2 if n <= _BARE else 0 if over else 1, 3):
        t, most, share = (base + n + 1, MOST, 0.05) if attempt == 2 else (base * attempt + tile, FEW, 0.25)
        if attempt != (0 if over else 1):
            size = taken(single, single, tiles, t, c, c)[0]
        best, second = tops_of(w, search, room, t, size, c, most, share)
        left, bound = total, settings.largest
        if best >= 0:
            fit = fits[best]
            left = fit.left
            if attempt > 0:
                bound += settings.error * (fit.n**2 + fit.ty**2 + fit.tz**2)
        if left <= bound:
            break
    row[_RESIDUAL] = left
    if left > bound:
        row[_STATUS] = _UNEXPLAINED
        return math.inf
    explained = fits[best].explained if best >= 0 else 0.0
    if explained < settings.detection:
        row[_STATUS] = _NO_CONTACT
        return math.inf
    if second >= 0 and explained - fits[second].explained < settings.ambiguity:
        other = fits[second]  # it was climbed roughly, maybe to the same top
        climb(w, model, limits, box, Point(other.y, other.z), fine, other, trial)
        if other.explained > explained:
            best, second = second, best
        if abs(fits[second].y - fits[best].y) + abs(fits[second].z - fits[best].z) < settings.apart:
            second = -1
    more[0] = more[1] = more[2] = 0.0
    few = n <= _TINY or explained * settings.told < _TOLD
    if few:
        covariance(fits[best], limits, more, spread)
        best, second = beside(w, search, room, best, second, spread)
    fit, status, shape = fits[best], _OK, 0
    for _ in range(_AGAIN):
        covariance(fit, limits, more, spread)
        widest = widest_variance(spread)
        if not (settings.curved * settings.curved < widest < settings.broad * settings.broad * 100.0):
            break
        near_w, near = nearby(w, model, tiles, t, room.part)
        shape = look_round(w, near_w, near, search, room, fit, spread)
        if shape >= 0:
            break
        higher = room.trials[1]
        climb(w, model, limits, box, Point(higher.y, higher.z), fine, fit, trial)
        more[0] = more[1] = more[2] = 0.0
    if more[0] != 0.0 or shape < 0:
        covariance(fit, limits, more, spread)
    explained, row[_RESIDUAL] = fit.explained, fit.left
    row[_Y], row[_Z] = fit.y, fit.z
    row[_FORCES], row[_FORCES + 1], row[_FORCES + 2] = fit.n, fit.ty, fit.tz
    if second >= 0:
        other, rival = fits[second], row[_RIVAL:]
        rival[0], rival[1], rival[2], rival[3], rival[4] = other.y, other.z, other.n, other.ty, other.tz
        worse = max(explained - other.explained, 0.0)
        row[_RIVAL_CHI2] = worse
        if worse < settings.ambiguity:
            status = _AMBIGUOUS
    margin = 2.0 * settings.apart
    if not (box[0] + margin < fit.y < box[1] - margin and box[2] + margin < fit.z < box[3] - margin):
        status = _AMBIGUOUS
    if shape < 0 or shape > 1:
        status = _AMBIGUOUS
    if unsure(fit, spread, widest, box) or (
        (shape == 1 or few)
        and 6.0 * math.sqrt(widest) > settings.broad
        and is_broad(single[:n], tiles, base + n + 1, Point(fit.y, fit.z), explained, spread, widest, settings)
    ):
        status = _AMBIGUOUS
    if n <= FEW_SENSORS:
        moments(w, model, limits, box, fit, room.root, trial, spread)
    row[_STATUS] = status
    return explained - settings.ambiguity if status == _OK else math.inf


@compiled(inline=True)
def _frames(kept, found):
    """The frames that regions were left of, as bits."""
    frames = 0
    for i in range(found):
        frames |= kept[i, 1]
    return frames


class _Turn(NamedTuple):
    """Scratch of up to eight frames that go side by side.

    hot, order: as of `by_strongest`; wide (n, 8), asked (3, 8), kept: as of `regions_left`; sums (3, 8): chi-square of
    their readings, what loads beyond are to explain, and chi-square of those that count; fulls, singles (8, n + 1):
    their readings; shares: what `taken` gives of each; tried: as of `outside`.
    """

    hot: npt.NDArray[np.int64]
    order: npt.NDArray[np.int64]
    wide: npt.NDArray[np.float32]
    asked: npt.NDArray[np.float32]
    kept: npt.NDArray[np.int64]
    sums: FloatArray
    fulls: FloatArray
    singles: npt.NDArray[np.float32]
    shares: npt.NDArray[np.float32]
    tried: npt.NDArray[np.float32]


@compiled(borrows=True)
def _each(readings, rows, search, beyond, ring, far, room, scratch, out):
    """As `project_frames`, with its scratch.

    Up to eight frames of one strongest sensor go side by side where regions are asked, and two where nodes are.
    """
    n, tiles, settings = readings.shape[1], search.tiles, search.settings
    hot, order, wide, asked, kept, sums, fulls, singles, shares, tried = scratch
    least = settings.largest + settings.ambiguity
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
        inner = tile < n and tiles.table.shape[0] > n + 2 and ring.table.shape[0] > 0
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
            if inner and not crowded(single, total, total - least, tile, ring):
                asked[1, k] = total - least
        may = _ALL
        if inner:
            may = _frames(kept, regions_left(singles, wide, asked, tile, ring, kept))
        base = tiles.table.shape[0] - n - 2
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
                    fulls[k, :n], single, total, tile, (may >> k) & 1 == 0, search, room, out[order[begin + k]],
                    sums[2, k], shares[k],
                )  # fmt: skip
            sums[1, k] = asked[1, k] = needed
            if needed < math.inf and crowded(single, total, needed, tile, far):
                asked[1, k] = math.inf
        found, kept[0, 0], kept[0, 1] = 1, 0, _ALL  # of no region: all nodes, as of one
        if far.table.shape[0] > 0:
            found = regions_left(singles, wide, asked, tile, far, kept)
        may = _frames(kept, found)
        for k in range(count):
            if (may >> k) & 1 and sums[1, k] < math.inf and outside(
                fulls[k, :n], singles[k], search, beyond, kept[:found], k, sums[1, k], tried, room
            ):  # fmt: skip
                out[order[begin + k], _STATUS] = _AMBIGUOUS
        begin += count


@compiled(inline=True)
def named_settings(settings):
    """Settings that came without their names."""
    return Settings(Limits(*settings[0]), *settings[1:])


@compiled(inline=True)
def named_beyond(beyond):
    """What is beyond, that came without its names."""
    return Beyond(Tiles(*beyond[0]), *beyond[1:])


@compiled(inline=True)
def room_of(widest, lead, n):
    """Scratch for a search in tiles of so many nodes, in rows of so many."""
    heights = np.empty(widest + 2 * lead, dtype=np.float32)
    for p in range(lead):
        heights[p] = np.float32(-1)
    score, at, fits, trials = np.empty(MOST), np.empty((MOST, 2)), np.empty(MOST + 6, FIT), np.zeros(4, FIT)
    return Scratch(
        lead, heights, np.empty(n + 1), score, at, fits, trials, np.empty(LANES), np.empty(8), np.empty(3), np.zeros(3)
    )


@compiled(frames="readings")
def project_frames(readings, rows, model, tiles, beyond, ring, far, sizes, settings, out):
    """Fill `out`, one row a frame; frames that are beyond reckoning or lack a sensor are left with status -1.

    readings (f, n), raw; rows (4, n): offset, 1 / noise, low and high end of the range; model: without its scratch;
    tiles: of the search; beyond: of what is outside it; ring, far: `Far` of the search but its part over the sensors,
    and of what is beyond; sizes: most nodes, and the longest row of all tiles. All of these without their names, as of
    `judge.plain`.
    """
    n, (widest, lead) = readings.shape[1], (sizes[0], sizes[1])
    inner, outer, known = Far(*ring), Far(*far), named_settings(settings)
    turns = np.empty((2, readings.shape[0] + n + 2), dtype=np.int64)
    hot, order, start = turns[0, n + 2 :], turns[1, n + 2 :], turns[0, : n + 2]
    by_strongest(readings, rows, known.strong, hot, start, order)
    turn = _Turn(
        hot, order, np.zeros((n, EIGHT), dtype=np.float32), np.zeros((3, EIGHT), dtype=np.float32),
        np.empty((max(inner.left.size, outer.left.size) + 1, 2), dtype=np.int64), np.empty((3, EIGHT)),
        np.zeros((EIGHT, n + 1)), np.zeros((EIGHT, n + 1), dtype=np.float32),
        np.empty((EIGHT, 3 * widest + 2 * n + 4), dtype=np.float32), np.empty(widest, dtype=np.float32),
    )  # fmt: skip
    search = Search(in_room(model, n), Tiles(*tiles), known)
    _each(readings, rows, search, named_beyond(beyond), inner, outer, room_of(widest, lead, n), turn, out)
