"""The compiled heart of `evidence`: how probable the readings are under each kind of contact, one frame at a time.

The evidence of a kind is the integral of likelihood times prior over position y, half width a, and forces N, T. Where
the readings fix position and width but roughly, it is a sum over a grid of both, the forces being integrated at each.
Where they fix them closely it is Gaussian in position and forces about the best position at each width, and a sum, or
a Gaussian, over widths. Best positions are found as in `project.py`. Two touches: `_pair.py`. None of these: the kinds
again, with an error of the model beside the noise, and other shapes, which are climbed to from what fits of the kinds.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..climb import climb_wide, project_wide, slopes
from ..scan import MOST_CHI2, highest, scan
from ._integrals import _LOG_2PI, _NEGLIGIBLE, _REACH, _add, _broad, _interval, _log_weight, _survey, _valley
from ._pair import weigh_pairs
from .columns import CHI2, EACH, HALF_WIDTH, KIND, LOG_EVIDENCE, NORMAL, POSITION, STATUS, TANGENTIAL

_PEAKS = 4
_NODES = 10
_OK, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 2.0, 3.0, -1.0
_ERRORS = (0.01, 0.03, 0.1, 0.3)
"""Model errors of what is none of the kinds, alike probable, in shares of the readings' root mean square."""
_ALONE = 6.0
"""Chi-square up to which one touch is not asked whether it was two."""
_T, _W = np.polynomial.legendre.leggauss(_NODES)


@compiled()
def _keep(y, q, fit, kept, apart, at, fits):
    """Put a position among the `kept` best, unless it is there already: their number."""
    for e in range(kept):
        if abs(at[e, 0] - y) <= apart[0] and abs(at[e, 1] - q) <= apart[1]:
            return kept
    e = kept
    while e > 0 and fit[2] > fits[e - 1, 2]:
        e -= 1
    if e == _PEAKS:
        return kept
    for k in range(min(kept, _PEAKS - 1), e, -1):
        at[k], fits[k] = at[k - 1], fits[k - 1]
    at[e, 0], at[e, 1] = y, q
    fits[e] = fit
    return min(kept + 1, _PEAKS)


@compiled()
def _peaks(w, s, positions, squares, table, g, mu, ends, thorough, c, a, score, at, fits, fit):
    """The highest positions of S over y and q, refined, the best first and each once: their number.

    g: start and step of the table, the square of its widest. With `thorough`, from the best position of each width.
    """
    start, step, square = g[0], g[1], g[2]
    apart = (0.05 * step, 1e-3 * square)
    kept = 0
    if thorough:
        for j in range(squares.size):
            k = 0
            for p in range(1, positions.size):
                k = p if s[j, p] > s[j, k] else k
            y, q = climb_wide(
                w, table, start, step, square, mu, positions[k], squares[j], ends, c, a, fit, 0.0, math.inf
            )
            kept = _keep(y, q, fit, kept, apart, at, fits)
        return kept
    first = np.empty((_PEAKS, 2))
    for p in range(highest(s, positions[0], positions[1] - positions[0], squares, score, first)):
        y, q = climb_wide(w, table, start, step, square, mu, first[p, 0], first[p, 1], ends, c, a, fit, 0.0, math.inf)
        kept = _keep(y, q, fit, kept, apart, at, fits)
    return kept


@compiled()
def _climbed(w, table, g, mu, ends, seeds, count, moment, c, a, at, fits, fit):
    """The peaks that are reached from `seeds`, positions and second moments of the pressure: their number.

    moment: the second moment of a pressure of unit half width.
    """
    apart = (0.05 * g[1], 1e-3 * g[2])
    kept = 0
    for p in range(count):
        q = min(max(seeds[p, 1] / moment, ends[2]), ends[3])
        y, q = climb_wide(w, table, g[0], g[1], g[2], mu, seeds[p, 0], q, ends, c, a, fit, 0.0, math.inf)
        kept = _keep(y, q, fit, kept, apart, at, fits)
    return kept


@compiled()
def _seeds(total, counts, at, fits, moments, far, seeds):
    """Where other shapes are climbed to from: the best of the kinds, and the best that is `far` from it: their number.

    The second only where it fits about as well.
    """
    found, least = 0, math.inf
    for _ in range(2):
        best = -1
        for k in range(counts.size):
            if counts[k] > 0 and (found == 0 or abs(at[k, 0, 0] - seeds[0, 0]) > far):
                best = k if best < 0 or fits[k, 0, 2] > fits[best, 0, 2] else best
        if best < 0 or total - fits[best, 0, 2] > 4.0 * least + _NEGLIGIBLE:
            break
        seeds[found, 0], seeds[found, 1] = at[best, 0, 0], moments[best] * at[best, 0, 1]
        found, least = found + 1, total - fits[best, 0, 2]
    return found


@compiled()
def _evidence(w, table, start, step, square, mu, ends, count, at, fits, spans, c, a, fit, hold, info, mean):
    """Log of the evidence from the peaks `at`, without what all kinds have in common."""
    low, high = ends[2], ends[3]
    total = -math.inf
    prior = -math.log(math.sqrt(high) - math.sqrt(low)) if high > low else 0.0  # all widths as probable
    for p in range(count):
        y, q = at[p, 0], at[p, 1]
        project_wide(w, table, start, step, square, mu, y, q, c, a[0], fits[p], 0.0, math.inf)
        _, gq, yy, yq, qq, _, _, _ = slopes(w, a[0], fits[p])
        spans[p, 0] = spans[p, 1] = q
        if high > low:
            curvature = max(qq - yq * yq / max(yy, 1e-300), 1e-300)
            inside = low < q < high
            spans[p, 0], spans[p, 1] = _interval(0.0 if inside else gq, curvature, q, low, high)
            half = math.sqrt(q)
            spread = 1.0 / math.sqrt(curvature) / max(2.0 * half, 1e-300)
            apart = True
            for e in range(count):
                apart &= e == p or abs(at[e, 1] - q) > 4.0 * _REACH / math.sqrt(curvature)
            if apart and low < spans[p, 0] and spans[p, 1] < high and spread < 0.01 * half:
                here = _log_weight(w, a[0], fits[p], mu, y, ends, info, mean) + 0.5 * _LOG_2PI + math.log(spread)
                total = _add(total, here + prior)
                spans[p, 1] = -1.0  # done
        else:
            total = _add(total, _log_weight(w, a[0], fits[p], mu, y, ends, info, mean))
    if not high > low:
        return total
    for p in range(count):
        if spans[p, 1] < 0.0:
            continue
        # spans that overlap are one stretch of widths, along which each peak's valley is followed
        first, last = spans[p, 0], spans[p, 1]
        grown = True
        while grown:
            grown = False
            for e in range(count):
                if spans[e, 1] >= first and spans[e, 0] <= last and (spans[e, 0] < first or spans[e, 1] > last):
                    first, last, grown = min(first, spans[e, 0]), max(last, spans[e, 1]), True
        members = 0
        for e in range(count):
            if spans[e, 1] >= first and spans[e, 0] <= last:
                hold[0, members] = at[e, 0]
                members += 1
                spans[e, 1] = -1.0
        one, two = math.sqrt(first), math.sqrt(last)
        for k in range(_NODES):
            half = 0.5 * (one + two + (two - one) * _T[k])
            q = half * half
            hold[2, 0], hold[2, 1], hold[2, 2], hold[2, 3] = ends[0], ends[1], q, q
            share = math.log(0.5 * (two - one) * _W[k]) + prior
            for e in range(members):
                y, _ = climb_wide(w, table, start, step, square, mu, hold[0, e], q, hold[2], c, a, fit, 0.0, math.inf)
                hold[0, e] = hold[1, e] = y
                project_wide(w, table, start, step, square, mu, y, q, c, a[0], fit, 0.0, math.inf)
                new = True
                for d in range(e):
                    new &= abs(hold[1, d] - y) > 0.05 * step
                if new:
                    total = _add(total, _log_weight(w, a[0], fit, mu, y, ends, info, mean) + share)
    return total


@compiled()
def _none(row, slots, weights, spare, total, n):
    """Log of the evidence of what is near to one of the kinds: of their mean, were the noise larger by a model error.

    Half of it is near to two touches, where these are asked for.

    Forces, positions and widths that fit are as many more as the noise is larger, so that only the spare readings pay.
    """
    sums = -math.inf
    for e in range(len(_ERRORS)):
        inflated = 1.0 + _ERRORS[e] * _ERRORS[e] * total / n
        for k in range(slots.size):
            part = row[KIND + slots[k] * EACH : KIND + (slots[k] + 1) * EACH]
            if part[LOG_EVIDENCE] > -math.inf:
                here = part[LOG_EVIDENCE] + 0.5 * part[CHI2] * (1.0 - 1.0 / inflated)
                sums = _add(sums, here + weights[k] - 0.5 * spare[k] * math.log(inflated))
    return sums - math.log(float(len(_ERRORS)))


@compiled(inline=True)
def _of_kind(k, n, m, bases, edges, squares, tables, starts, shapes):
    """A kind's part of what all kinds have one after the other: bases, edges, squares, and its table."""
    rows, cells, wides = shapes[k, 0], shapes[k, 1], shapes[k, 2]
    b, e, q, t = starts[k, 0], starts[k, 1], starts[k, 2], starts[k, 3]
    return (
        bases[b : b + 2 * n * rows * m].reshape(n, 2, rows * m),
        edges[e : e + 4 * rows * m].reshape(4, rows * m),
        squares[q : q + rows],
        tables[t : t + cells * wides * 10 * n].reshape(cells, wides, 10 * n),
    )


@compiled(inline=True)
def _table(k, n, tables, starts, shapes):
    """The table alone, of what has no scan."""
    cells, wides, t = shapes[k, 1], shapes[k, 2], starts[k, 3]
    return tables[t : t + cells * wides * 10 * n].reshape(cells, wides, 10 * n)


@compiled()
def weigh_frames(
    readings, sensors, bases, edges, positions, squares, tables, fines, nodes, rows, starts, shapes, geometry, options,
    slots, weights, spare, more, moments, pairs, basis_pairs, tri, back, line, ends_pair, out,
):  # fmt: skip
    """Fill `out`, one row a frame; the columns are named in `columns.py`.

    bases, edges, squares, tables, as in `project_frames`, and fines, nodes, rows, as in `_survey`: all kinds' one after
    the other, so that any number of kinds is one compilation. starts (kinds, 7): where each kind's begin; shapes
    (kinds, 4): number of squares, of the table's cells and widths, of the survey's widths. geometry (kinds + 1, 7):
    start and step of the table, the square of its widest, and the ends of y and q, the last for pairs. options: mu, the
    thresholds, the survey's steps to one of the scan's, the log of the share of model errors in none of these. slots
    (kinds + 2,): the kinds' numbers, the last but one that of two touches, the last that of none of these, -1 where it
    is not asked for. weights, spare (kinds + 1,): log of the share in what is none of these, and readings beyond the
    unknowns. more (others, 3): of what is climbed to without a scan, behind the kinds in all the above, first what is
    part of a kind, then of none of these: which kind or -1, log of its share, log of what is left to the kind.
    moments (kinds + others,): second moments of pressures of unit half width. Then as in `weigh_pairs`.
    """
    frames, n = readings.shape
    kinds, others = slots.size - 2, more.shape[0]
    parts = kinds
    for e in range(others):
        parts += more[e, 0] >= 0.0
    mu, detection, largest, largest_pair = options[0], options[1], options[2], options[3]
    fines_per_cell = int(options[4])
    two, none = slots[kinds], slots[kinds + 1]
    best = np.empty(7)
    w = np.empty(n)
    w_single = np.empty(n, dtype=np.float32)
    a, c = np.empty((2, 6, 2 * n)), np.empty((3, 10 * n + shapes[:, 2].max() + 3))
    fits, fit = np.empty((kinds + others, _PEAKS, 6)), np.empty(6)
    at, score = np.empty((kinds + others, _PEAKS, 2)), np.empty(_PEAKS)
    seeds = np.empty((_PEAKS, 2))
    spans, hold = np.empty((_PEAKS, 2)), np.empty((3, max(_PEAKS, 4)))
    info, mean = np.empty((3, 3)), np.empty(3)
    counts = np.empty(kinds + others, dtype=np.int64)
    most, m = shapes[:, 0].max(), positions.size
    fine = fines_per_cell * (m - 1) + 1
    step = (positions[-1] - positions[0]) / (fine - 1)
    scans, sums = np.empty(most * m, dtype=np.float32), np.empty((2, most * m), dtype=np.float32)
    for f in range(frames):
        row = out[f]
        row[:] = math.nan
        total, usable = 0.0, True
        for i in range(n):
            r = readings[f, i]
            usable &= sensors[2, i] < r < sensors[3, i]
            w[i] = (r - sensors[0, i]) * sensors[1, i]
            total += w[i] * w[i]
        if not (usable and total < MOST_CHI2):
            row[STATUS] = _PENDING
            continue
        for i in range(n):
            w_single[i] = w[i]
        explained = 0.0
        for attempt in range(2):
            # before a frame is called unexplained, the best position of each width is tried
            if attempt == 1 and total - explained <= largest:
                break
            for k in range(kinds):
                g, ends = geometry[k, :3], geometry[k, 3:]
                basis, edge, square, table = _of_kind(k, n, m, bases, edges, squares, tables, starts, shapes)
                size = square.size * m
                scan(w_single, basis, edge, sums[:, :size], scans[:size])
                s = scans[:size].reshape(square.size, m)
                counts[k] = _peaks(
                    w, s, positions, square, table, g, mu, ends, attempt == 1, c, a, score, at[k], fits[k], fit
                )
                if counts[k] > 0:
                    explained = max(explained, fits[k, 0, 2])
            for k in range(kinds, parts):
                whole = int(more[k - kinds, 0])
                seeds[:, 0], seeds[:, 1] = at[whole, :, 0], moments[whole] * at[whole, :, 1]
                table = _table(k, n, tables, starts, shapes)
                counts[k] = _climbed(
                    w, table, geometry[k, :3], mu, geometry[k, 3:], seeds, counts[whole], moments[k], c, a, at[k],
                    fits[k], fit,
                )  # fmt: skip
                if counts[k] > 0:
                    explained = max(explained, fits[k, 0, 2])
        row[STATUS] = _OK
        part = row[KIND + two * EACH : KIND + (two + 1) * EACH]
        chi2_pair = total
        explains = total - explained <= largest
        if two >= 0:
            part[LOG_EVIDENCE], part[CHI2] = -math.inf, total
        if two >= 0 and total - explained > _ALONE and total >= detection:
            weight = weigh_pairs(
                w, w_single, pairs, basis_pairs, tri, back, line, geometry[kinds + others, :3], ends_pair, mu, best
            )  # fmt: skip
            part[CHI2] = chi2_pair = best[6]
            explains |= best[6] <= largest_pair
            if weight > -math.inf:
                part[LOG_EVIDENCE] = weight + 0.5 * (total - explained)
                part[POSITION], part[HALF_WIDTH] = best[0], best[1]
                part[NORMAL] = best[2] * math.cos(best[3]) + best[4] * math.cos(best[5])
                part[TANGENTIAL] = best[2] * math.sin(best[3]) + best[4] * math.sin(best[5])
        if not explains or max(explained, total - largest_pair if two >= 0 else 0.0) < detection:
            row[STATUS] = _UNEXPLAINED if not explains else _NO_CONTACT
            continue
        for k in range(kinds):
            part = row[KIND + slots[k] * EACH : KIND + (slots[k] + 1) * EACH]
            part[LOG_EVIDENCE], part[CHI2] = -math.inf, total
            if counts[k] > 0:
                normal, tangential = fits[k, 0, 0], fits[k, 0, 1]
                part[CHI2] = max(total - fits[k, 0, 2], 0.0)
                part[POSITION], part[NORMAL], part[TANGENTIAL] = at[k, 0, 0], normal, tangential
                part[HALF_WIDTH] = math.sqrt(at[k, 0, 1])
            g, ends = geometry[k, :3], geometry[k, 3:]
            count = 0
            while count < counts[k] and fits[k, count, 2] > explained - 2.0 * _NEGLIGIBLE:
                count += 1
            if count == 0:
                continue
            basis, edge, square, table = _of_kind(k, n, m, bases, edges, squares, tables, starts, shapes)
            wide, begin = shapes[k, 3], starts[k, 6]
            widths = rows[begin : begin + 3 * wide].reshape(3, wide)
            if _broad(w, table, g, mu, at[k, 0], fits[k, 0], ends, widths, step, c, a[0]):
                size = square.size * m
                scan(w_single, basis, edge, sums[:, :size], scans[:size])
                s = scans[:size].reshape(square.size, m)
                grid = fines[starts[k, 4] : starts[k, 4] + 2 * n * wide * fine].reshape(n, 2, wide, fine)
                node = nodes[starts[k, 5] : starts[k, 5] + 4 * wide * fine].reshape(4, wide, fine)
                part[LOG_EVIDENCE] = _survey(w, s, square, explained, mu, grid, node, widths, step)
            else:
                part[LOG_EVIDENCE] = _evidence(
                    w, table, g[0], g[1], g[2], mu, ends, count, at[k], fits[k], spans, c, a, fit, hold, info, mean
                )
            part[LOG_EVIDENCE] -= 0.5 * explained
        known = max(explained, total - chi2_pair)
        shaped, found = -math.inf, 0
        if parts < kinds + others:
            far = 4.0 * geometry[0, 1]
            found = _seeds(total, counts[:parts], at, fits, moments, far, seeds)
        for k in range(kinds, kinds + others):
            g, ends = geometry[k, :3], geometry[k, 3:]
            table = _table(k, n, tables, starts, shapes)
            if k >= parts:
                counts[k] = _climbed(
                    w, table, g, mu, ends, seeds, found, moments[k], c, a, at[k], fits[k], fit
                )  # fmt: skip
            count = 0
            while count < counts[k] and fits[k, count, 2] > known - 2.0 * _NEGLIGIBLE:
                count += 1
            here = -math.inf
            for p in range(count):
                here = _add(here, _valley(w, table, g, mu, at[k, p], ends, c, a[0], fit, info, mean))
            here += more[k - kinds, 1] - 0.5 * explained
            if k >= parts:
                shaped = _add(shaped, here)
                continue
            slot = slots[int(more[k - kinds, 0])]
            part = row[KIND + slot * EACH : KIND + (slot + 1) * EACH]
            before = part[LOG_EVIDENCE] + more[k - kinds, 2]
            part[LOG_EVIDENCE] = _add(before, here)
            if here > before:
                part[CHI2] = max(total - fits[k, 0, 2], 0.0)
                part[POSITION], part[NORMAL], part[TANGENTIAL] = at[k, 0, 0], fits[k, 0, 0], fits[k, 0, 1]
                part[HALF_WIDTH] = math.sqrt(at[k, 0, 1])
        if none >= 0:
            off = _none(row, slots[: kinds + (two >= 0)], weights, spare, total, n)
            row[KIND + none * EACH] = _add(off + options[5], shaped)
