"""The compiled heart of `fit` on an area: a round contact of some half width, one frame at a time.

For each of some widths the scan and the climb of point loads (`project.py`), whose table is then that of the width;
from their tops a climb over the width as well (`round_climb.py`). At the best width the contact is judged as a point
load is; the interval of the width is where chi-square rises by 1.96^2, all else fitted anew, and what the other
unknowns do there is what the width adds to their covariance. Where a moment is fitted, the scans do not know of it:
then a second search follows on what it leaves of the readings, and the contact is judged on these.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..layout import AREA, ROUND, TWIST, Layout
from .climb import FIT, climb
from .fall import LANES
from .field import ROWS
from .judge import FINE, MOST, covariance, is_broad, look_round, unsure, widest_variance
from .order import strongest, whitened
from .project import FEW, MOST_CHI2
from .round_climb import COLUMNS, SIZE, at_width, round_climb, round_curvature, round_project, shares_of
from .round_judge import MORE, contact_outside, further_tops, ranked, width_profile
from .scan import taken
from .tops import search

_TOPS = 8
"""Tops over position and width that are climbed to from the scan."""
_AGAIN = 3
_NEAR = 2.5
"""How near one start of a climb stands for another, over the width from which a profile counts as broad."""
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_POINT, _POINT_COLUMNS = AREA.covariance, AREA.columns


def _where(layout: Layout) -> tuple[int, ...]:
    return layout.covariance, layout.interval, layout.residual, layout.rival, layout.rival_chi2, layout.status


_PLAIN, _TWISTED = _where(ROUND), _where(TWIST)
"""Columns: covariance, interval, residual, the rival and how much worse it is, status."""


@compiled(borrows=True)
def _starts(
    w, single, sensors, first, tables, terms, tiles, near_sensors, near_first, widths, tile, most, share, options,
    scratch, whole, c, heights, lead, score, at, fits, part, starts, levels,
):  # fmt: skip
    """Best and second-best top of each width into starts (2 widths, 4): S, y, z, q, the highest first; how many.

    levels (widths,): S of the best top of each width.
    """
    count = 0
    for j in range(widths.size):
        t = tile + j * (w.size + 2)
        total = taken(single, single, tiles, t, c, c)[0]
        best, second = search(
            w, sensors, first, tables[j], terms, tiles, near_sensors, near_first, t, most, share, options, scratch,
            whole, total, c, heights, lead, score, at, fits, part,
        )  # fmt: skip
        levels[j] = fits[best, 3] if best >= 0 else 0.0
        for other in range(2):
            p = second if other else best
            if p < 0:
                continue
            rank = count
            while rank > 0 and starts[rank - 1, 0] < fits[p, 3]:
                for k in range(4):
                    starts[rank, k] = starts[rank - 1, k]
                rank -= 1
            starts[rank, 0], starts[rank, 1] = fits[p, 3], fits[p, 29]
            starts[rank, 2], starts[rank, 3] = fits[p, 30], widths[j]
            count += 1
    return count


@compiled(borrows=True)
def _climbed(w, model, mu, box, starts, count, near, room, tops, found, trial):
    """Tops over position and width from the starts that are not near a higher one, behind those `found`: how many."""
    highest = 0.0
    for p in range(count):
        y, z, fresh = starts[p, 1], starts[p, 2], starts[p, 0] > 0.8 * highest
        for e in range(p):
            if starts[e, 0] >= 0.0 and abs(y - starts[e, 1]) + abs(z - starts[e, 2]) < near:
                fresh = False
        if not fresh or found == _TOPS:
            starts[p, 0] = -1.0
            continue
        round_climb(w, model, mu, box, y, z, starts[p, 3], FINE, room, tops[found], trial)
        highest = max(highest, tops[found, 3] if model[6].shape[0] == 0 else starts[p, 0])  # a moment adds to the tops
        found += 1
    return found


@compiled(borrows=True)
def _untwisted(w, model, mu, top, room, fit, v):
    """What the moment of a top leaves of the readings into v."""
    round_project(w, model, mu, top[36], top[37], top[38], room, fit)
    for i in range(w.size):
        v[i] = w[i] - fit[39] * room[5][12, i]


@compiled(borrows=True)
def _spread_of_moment(top, fit, point, moves, row, at):
    """The covariance of the moment with (y, z, N, Ty, Tz), with the width and with itself into row.

    point: the covariance of these five at one width; moves: how far all six move with a standard deviation of the
    width; at: where the row's covariance begins.
    """
    g = fit[:5]
    g[0], g[1], g[2], g[3], g[4] = top[44], top[45], top[41], top[42], top[43]
    over = 1.0 / top[40] if top[40] > 0.0 else math.inf
    own = over
    for j in range(5):
        total = 0.0
        for k in range(5):
            low, high = min(j, k), max(j, k)
            total += point[_POINT + low * (9 - low) // 2 + high] * g[k]
        own += over * over * total * g[j]
        row[at + j * (13 - j) // 2 + 6] = moves[5] * moves[j] - over * total
    row[at + 27] = own + moves[5] * moves[5]


@compiled(borrows=True)
def _each(
    readings, rows, sensors, first, tables, terms, sums, harmonics, turns, turned, tiles, near_sensors, near_first,
    outer, nodes, boxes, widths, far, options, box, most, out, c, s, heights, lead, full, single, bits,
    part, scratch, whole, score, at, fits, trials, lanes, ratio, more, starts, levels, room, flat, tops, others,
    only, sides, point, bare, columns,
):  # fmt: skip
    """As `project_round`, with its scratch."""
    frames, n = readings.shape
    w, h, shares, model = full[:n], room[0], room[2], (sensors, first, sums, harmonics, most, turns, turned)
    mu, detection, largest, ambiguity, apart, broad, strong = options[:7]
    free, twists = box[5] > box[4], turned.shape[0] > 0
    at_covariance, at_interval, at_residual, at_rival, at_worse, at_status = columns
    v = bare[:n] if twists else w
    for f in range(frames):
        row = out[f]
        total = whitened(readings[f], rows, full, single)
        for i in range(row.size):
            row[i] = math.nan
        row[at_worse] = math.inf
        if not total < MOST_CHI2:
            row[at_status] = _PENDING
            continue
        hot, top = strongest(single, bits, n)
        tile = hot if top >= strong * strong else n
        best = second = -1
        count = 0
        for attempt in range(2):
            tile, few, share = (tile, FEW, 0.25) if attempt == 0 else (n + 1, MOST, 0.05)
            begun = _starts(
                w, single, sensors, first, tables, terms, tiles, near_sensors, near_first, widths, tile, few, share,
                options, scratch, whole, c, heights, lead, score, at, fits, part, starts, levels,
            )  # fmt: skip
            count = _climbed(w, model, mu, box, starts, begun, _NEAR * broad, room, tops, 0, others[0])
            best, second = ranked(tops, count, h, apart)
            if twists and best >= 0:
                _untwisted(w, model, mu, tops[best], room, others[0], v)
                for i in range(n):
                    single[i] = v[i]
                again = n + 1
                if attempt == 0:
                    hot, top = strongest(single, bits, n)
                    again = hot if top >= strong * strong else n
                begun = _starts(
                    v, single, sensors, first, tables, terms, tiles, near_sensors, near_first, widths, again, few,
                    share, options, scratch, whole, c, heights, lead, score, at, fits, part, starts,
                    levels,
                )  # fmt: skip
                count = _climbed(w, model, mu, box, starts, begun, _NEAR * broad, room, tops, count, others[0])
                best, second = ranked(tops, count, h, apart)
                for i in range(n):
                    single[i] = w[i]
            left, bound = total, largest
            if best >= 0:
                left = tops[best, 17]
                bound += options[13] * (tops[best, 0] ** 2 + tops[best, 1] ** 2 + tops[best, 2] ** 2)
            if left <= bound:
                break
        row[at_residual] = left
        if left > bound:
            row[at_status] = _UNEXPLAINED
            continue
        if best < 0 or tops[best, 3] < detection:
            row[at_status] = _NO_CONTACT
            continue
        count = further_tops(w, model, mu, box, 2.0 * broad, best, count, room, tops, others[0])
        best, second = ranked(tops, count, h, apart)
        shape, spread, told = 0, 0.0, True
        fit, found = fits[0], tops[best]
        for _ in range(_AGAIN):
            shares_of(found[38], most, shares)
            at_width(sums, shares, flat)
            if twists:
                _untwisted(w, model, mu, found, room, others[0], v)
            climb(
                v, sensors, first, flat, terms, mu, options[9:13], found[36], found[37], FINE, options[8], 0.0,
                -math.inf, scratch, whole, fit, fits[1],
            )  # fmt: skip
            more[0] = more[1] = more[2] = 0.0
            shape = 0
            covariance(fit, mu, more, point)
            spread = widest_variance(point)
            if options[7] * options[7] < spread < broad * broad * 100.0:
                shape = look_round(
                    v, (v, sensors, first), sensors, first, flat, terms, options, fit, point, scratch, whole, trials,
                    lanes, ratio, more,
                )  # fmt: skip
            told = True
            y, z, q = trials[2, 29], trials[2, 30], found[38]
            if shape >= 0 and free:
                round_curvature(found, h)
                told = width_profile(w, model, mu, box, found, h, only, room, others, sides)
                y, z, q = others[0, 36], others[0, 37], others[0, 38]
            if shape >= 0 and told:
                break
            round_climb(w, model, mu, box, y, z, q, FINE, room, others[0], others[1])
            if others[0, 3] > found[3]:
                for k in range(SIZE):
                    found[k] = others[0, k]
        status = _OK if told and (shape == 0 or shape == 1) and n > 5 + free + twists else _AMBIGUOUS
        top = fit[3]
        if twists:  # what the readings say of position and forces where the moment is not known
            for k in range(6):
                fit[11 + k], fit[23 + k] = found[11 + k], found[27 + k]
            fit[20], fit[21], fit[22] = found[21], found[22], found[24]
        covariance(fit, mu, more, point)
        half = math.sqrt(found[38])
        width_std = 0.0
        row[at_interval] = row[at_interval + 1] = half
        if free:
            low, high = math.sqrt(min(sides[0, 6], found[38])), math.sqrt(max(sides[1, 6], found[38]))
            row[at_interval], row[at_interval + 1], width_std = low, high, (high - low) / (2.0 * 1.959964)
            if found[38] >= box[5] or (box[4] > 0.0 and found[38] <= box[4]):
                status = _AMBIGUOUS
        if twists:
            _spread_of_moment(found, trials[0], point, sides[2], row, at_covariance)
            row[6], row[at_covariance + 26] = found[39], sides[2, 5] * width_std
        at_point, at_round = _POINT, at_covariance
        for j in range(5):
            for k in range(j, 5):
                if free:
                    point[at_point] += sides[2, j] * sides[2, k]
                row[at_round] = point[at_point]
                at_point, at_round = at_point + 1, at_round + 1
            row[at_round] = sides[2, j] * width_std if free else 0.0
            at_round += 1 + twists
        row[at_round] = width_std * width_std
        row[at_residual] = found[17]
        row[0], row[1], row[5] = found[36], found[37], half
        row[2], row[3], row[4] = found[0], found[1], found[2]
        best, second = ranked(tops, count, h, apart)
        if second >= 0:
            row[at_rival], row[at_rival + 1], row[at_rival + 5] = (
                tops[second, 36],
                tops[second, 37],
                math.sqrt(tops[second, 38]),
            )
            for k in range(3):
                row[at_rival + 2 + k] = tops[second, k]
            if twists:
                row[at_rival + 6] = tops[second, 39]
            row[at_worse] = max(found[3] - tops[second, 3], 0.0)
            if row[at_worse] < ambiguity:
                status = _AMBIGUOUS
        margin = 2.0 * apart
        if not (
            options[9] + margin < row[0] < options[10] - margin and options[11] + margin < row[1] < options[12] - margin
        ):
            status = _AMBIGUOUS
        spread = widest_variance(point)
        if unsure(fit, point, spread, options):
            status = _AMBIGUOUS
        for j in range(7 if twists else 0):  # where the moment leaves a combination open, rounding may be less than 0
            own = at_covariance + j * (15 - j) // 2
            if j != 5 and not row[own] > 0.0 and not (mu == 0.0 and 2 < j < 5):
                row[own], status = math.inf, _AMBIGUOUS
        if status == _OK and 6.0 * math.sqrt(spread) > broad:
            nearest = 0
            for j in range(widths.size):
                if abs(widths[j] - found[38]) < abs(widths[nearest] - found[38]):
                    nearest = j
            index, origin, near, basis, shapes = tiles
            trials[1, 3], trials[1, 29], trials[1, 30] = min(levels[nearest], found[3]), found[36], found[37]
            if twists:
                climb(
                    v, sensors, first, tables[nearest], terms, mu, options[9:13], found[36], found[37], FINE,
                    options[8], 0.0, -math.inf, scratch, whole, fits[0], fits[1],
                )  # fmt: skip
                trials[1, 3] = min(fits[0, 3], top)
            if is_broad(
                v, (index[: (nearest + 1) * (n + 2)], origin, near, basis, shapes), trials[1], point, spread, options,
                trials[0],
            ):  # fmt: skip
                status = _AMBIGUOUS
        if status == _OK and contact_outside(
            w, single, model, mu, outer, nodes, min(tile, n), far, found[3] - ambiguity,
            0.0 if twists else found[3] - ambiguity, boxes, box, only,
            starts[2 * widths.size :], room, c, s, others,
        ):  # fmt: skip
            status = _AMBIGUOUS
        row[at_status] = status


@compiled()
def project_round(
    readings, rows, sensors, first, tables, terms, sums, harmonics, turns, turned, tiles, near_sensors, near_first,
    outer, nodes, boxes, sizes, widths, far, limits, options, out,
):  # fmt: skip
    """Fill `out`, one row a frame, as `project.project_frames` does, in the columns of `ROUND`, or of `TWIST`.

    widths (k,), far: squares of the half widths that are scanned in the search and beyond it; tables (k, rows,
    numbers): those of `widths`, and terms, as of `project_frames`; sums (rows, numbers, widths) and harmonics: of
    any width; turns and turned: the same under a moment, no terms where it is not fitted; limits: the least and the
    largest q of the search, and the largest of the sums.
    """
    n = readings.shape[1]
    widest, lead = sizes[0], sizes[1]
    c, s = np.empty(3 * widest + 2 * n + 4, dtype=np.float32), np.empty(widest, dtype=np.float32)
    heights = np.empty(widest + 2 * lead, dtype=np.float32)
    for p in range(lead):
        heights[p] = np.float32(-1)
    full, single, part = np.zeros(n + 1), np.zeros(n + 1, dtype=np.float32), np.empty(n + 1)
    scratch, bits = np.empty((ROWS, n + 1)), single.view(np.int32)
    score, at, fits, trials = np.empty(MOST), np.empty((MOST, 2)), np.empty((MOST + 5, FIT)), np.empty((3, FIT))
    lanes, ratio, more = np.empty(LANES), np.empty(8), np.zeros(3)
    starts, levels = np.empty((2 * widths.size + 4, 4)), np.empty(widths.size)
    room = (
        np.empty((3, 3)), np.empty((8, 4)), np.empty((2, sums.shape[2])), np.empty((sums.shape[1] // 4, 3)),
        np.empty((turns.shape[1] // 4, 3)), np.empty((COLUMNS, n)),
    )  # fmt: skip
    flat, tops = np.empty((sums.shape[0], sums.shape[1])), np.empty((_TOPS + MORE, SIZE))
    others, only, sides, point = np.empty((2, SIZE)), np.empty(6), np.zeros((3, 7)), np.empty(_POINT_COLUMNS)
    box = np.array([options[9], options[10], options[11], options[12], limits[0], limits[1]])
    columns = _TWISTED if turned.shape[0] > 0 else _PLAIN
    _each(
        readings, rows, sensors, first, tables, terms, sums, harmonics, turns, turned, tiles, near_sensors, near_first,
        outer, nodes, boxes, widths, far, options, box, limits[2], out, c, s, heights, lead, full, single,
        bits, part, scratch, scratch.view(np.int64), score, at, fits, trials, lanes, ratio, more, starts, levels, room,
        flat, tops, others, only, sides, point, np.empty(n + 1), columns,
    )  # fmt: skip
