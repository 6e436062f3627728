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
from ..climb import slopes
from ..scan import MOST_CHI2, highest
from ._integrals import (
    _LOG_2PI,
    _NEGLIGIBLE,
    _REACH,
    N,
    S,
    T,
    WeighingRoom,
    add,
    broad,
    climbed,
    interval,
    log_weight,
    projected,
    surveyed,
    valley,
)  # fmt: skip
from ._pair import FIRST, FIRST_ANGLE, HALF, MIDDLE, SECOND, SECOND_ANGLE, weigh_pairs
from ._tables import STEP, field_of, scanned, survey_of
from .columns import CHI2, EACH, HALF_WIDTH, KIND, LOG_EVIDENCE, NORMAL, POSITION, STATUS, TANGENTIAL

_PEAKS, BEST = 4, 0
"""Peaks that are kept of each kind; the highest comes first."""
_NODES = 10
_OK, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 2.0, 3.0, -1.0
_ERRORS = (0.01, 0.03, 0.1, 0.3)
"""Model errors of what is none of the kinds, alike probable, in shares of the readings' root mean square."""
_ALONE = 6.0
"""Chi-square up to which one touch is not asked whether it was two."""
_T, _W = np.polynomial.legendre.leggauss(_NODES)


class Odds(NamedTuple):
    """How the kinds share what is known before.

    slots (kinds,): the kinds' numbers; two, none: those of two touches and of none of these, -1 where not asked for.
    weights, spare (kinds + 1,): log of the share in what is none of these, and readings beyond the unknowns, the last
    of two touches. Of what is climbed to without a scan, first what is part of a kind, then of none of these, (others,)
    each: which kind or -1, log of its share, log of what is left to the kind. moments (kinds + others,): second moments
    of pressures of unit half width. off: log of the share of model errors in none of these.
    """

    slots: npt.NDArray[np.intp]
    two: int
    none: int
    weights: FloatArray
    spare: FloatArray
    whole: npt.NDArray[np.intp]
    share: FloatArray
    left: FloatArray
    moments: FloatArray
    off: float


class Thresholds(NamedTuple):
    """The cone, and the chi-squares: explained by what is a contact, left by one kind, and left by two touches."""

    mu: float
    detection: float
    largest: float
    largest_pair: float


class _Peaks(NamedTuple):
    """The best positions y and q of a kind, (_PEAKS, 2), and their fits."""

    at: FloatArray
    fits: FloatArray


@compiled(borrows=True)
def _keep(y, q, fit, kept, apart, at, fits):
    """Put a position among the `kept` best, unless it is there already: their number."""
    for e in range(kept):
        if abs(at[e, 0] - y) <= apart[0] and abs(at[e, 1] - q) <= apart[1]:
            return kept
    e = kept
    while e > 0 and fit[S] > fits[e - 1, S]:
        e -= 1
    if e == _PEAKS:
        return kept
    for k in range(min(kept, _PEAKS - 1), e, -1):
        for j in range(fits.shape[1]):
            fits[k, j] = fits[k - 1, j]
        at[k, 0], at[k, 1] = at[k - 1, 0], at[k - 1, 1]
    for j in range(fits.shape[1]):
        fits[e, j] = fit[j]
    at[e, 0], at[e, 1] = y, q
    return min(kept + 1, _PEAKS)


@compiled(borrows=True)
def _peaks(w, s, positions, squares, field, mu, thorough, room, peaks):
    """The highest positions of S over y and q, refined, the best first and each once: their number.

    With `thorough`, from the best position of each width.
    """
    kept, apart = 0, (0.05 * field.step, 1e-3 * field.square)
    if thorough:
        for j in range(squares.size):
            k = 0
            for p in range(1, positions.size):
                k = p if s[j, p] > s[j, k] else k
            y, q = climbed(w, field, mu, positions[k], squares[j], field.ends, room)
            kept = _keep(y, q, room.fit, kept, apart, peaks.at, peaks.fits)
        return kept
    first, score = room.first, room.score
    for p in range(highest(s, positions[0], positions[1] - positions[0], squares, score, first)):
        y, q = climbed(w, field, mu, first[p, 0], first[p, 1], field.ends, room)
        kept = _keep(y, q, room.fit, kept, apart, peaks.at, peaks.fits)
    return kept


@compiled(borrows=True)
def _climbed_from(w, field, mu, seeds, count, moment, room, peaks):
    """The peaks that are reached from `seeds`, positions and second moments of the pressure: their number.

    moment: the second moment of a pressure of unit half width.
    """
    kept, apart = 0, (0.05 * field.step, 1e-3 * field.square)
    for p in range(count):
        q = min(max(seeds[p, 1] / moment, field.ends[2]), field.ends[3])
        y, q = climbed(w, field, mu, seeds[p, 0], q, field.ends, room)
        kept = _keep(y, q, room.fit, kept, apart, peaks.at, peaks.fits)
    return kept


@compiled(borrows=True)
def _seeds(total, counts, at, fits, moments, far, seeds):
    """Where other shapes are climbed to from: the best of the kinds, and the best that is `far` from it: their number.

    The second only where it fits about as well.
    """
    found, least = 0, math.inf
    for _ in range(2):
        best = -1
        for k in range(counts.size):
            if counts[k] > 0 and (found == 0 or abs(at[k, BEST, 0] - seeds[0, 0]) > far):
                best = k if best < 0 or fits[k, BEST, S] > fits[best, BEST, S] else best
        if best < 0 or total - fits[best, BEST, S] > 4.0 * least + _NEGLIGIBLE:
            break
        seeds[found, 0], seeds[found, 1] = at[best, BEST, 0], moments[best] * at[best, BEST, 1]
        found, least = found + 1, total - fits[best, BEST, S]
    return found


@compiled(borrows=True)
def _near(count, peaks, explained):
    """How many of the peaks explain about as much as the best of all."""
    near = 0
    while near < count and peaks.fits[near, S] > explained - 2.0 * _NEGLIGIBLE:
        near += 1
    return near


@compiled(borrows=True)
def _evidence(w, field, mu, count, peaks, room):
    """Log of the evidence from the peaks, without what all kinds have in common."""
    low, high = field.ends[2], field.ends[3]
    at, fits, spans = peaks.at, peaks.fits, room.spans
    a, info, mean = room.a[0], room.info, room.mean
    total = -math.inf
    prior = -math.log(math.sqrt(high) - math.sqrt(low)) if high > low else 0.0  # all widths as probable
    for p in range(count):
        y, q = at[p, 0], at[p, 1]
        projected(w, field, mu, y, q, room, fits[p])
        _, gq, yy, yq, qq, _, _, _ = slopes(w, a, fits[p])
        spans[p, 0] = spans[p, 1] = q
        if high > low:
            curvature = max(qq - yq * yq / max(yy, 1e-300), 1e-300)
            inside = low < q < high
            spans[p, 0], spans[p, 1] = interval(0.0 if inside else gq, curvature, q, low, high)
            half = math.sqrt(q)
            spread = 1.0 / math.sqrt(curvature) / max(2.0 * half, 1e-300)
            apart = True
            for e in range(count):
                apart &= e == p or abs(at[e, 1] - q) > 4.0 * _REACH / math.sqrt(curvature)
            if apart and low < spans[p, 0] and spans[p, 1] < high and spread < 0.01 * half:
                here = log_weight(w, fits[p], mu, y, field.ends, a, info, mean) + 0.5 * _LOG_2PI + math.log(spread)
                total = add(total, here + prior)
                spans[p, 1] = -1.0  # done
        else:
            total = add(total, log_weight(w, fits[p], mu, y, field.ends, a, info, mean))
    if not high > low:
        return total
    begin, found, ends = room.begin, room.found, room.ends
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
                begin[members] = at[e, 0]
                members += 1
                spans[e, 1] = -1.0
        one, two = math.sqrt(first), math.sqrt(last)
        for k in range(_NODES):
            half = 0.5 * (one + two + (two - one) * _T[k])
            q = half * half
            ends[0], ends[1], ends[2], ends[3] = field.ends[0], field.ends[1], q, q
            share = math.log(0.5 * (two - one) * _W[k]) + prior
            for e in range(members):
                y, _ = climbed(w, field, mu, begin[e], q, ends, room)
                begin[e] = found[e] = y
                projected(w, field, mu, y, q, room, room.fit)
                new = True
                for d in range(e):
                    new &= abs(found[d] - y) > 0.05 * field.step
                if new:
                    total = add(total, log_weight(w, room.fit, mu, y, ends, a, info, mean) + share)
    return total


@compiled(borrows=True)
def _none(row, odds, total, n):
    """Log of the evidence of what is near to one of the kinds: of their mean, were the noise larger by a model error.

    Half of it is near to two touches, where these are asked for.

    Forces, positions and widths that fit are as many more as the noise is larger, so that only the spare readings pay.
    """
    sums, kinds = -math.inf, odds.slots.size
    for e in range(len(_ERRORS)):
        inflated = 1.0 + _ERRORS[e] * _ERRORS[e] * total / n
        for k in range(kinds + (odds.two >= 0)):
            part = _part(row, odds.slots[k] if k < kinds else odds.two)
            if part[LOG_EVIDENCE] > -math.inf:
                here = part[LOG_EVIDENCE] + 0.5 * part[CHI2] * (1.0 - 1.0 / inflated)
                sums = add(sums, here + odds.weights[k] - 0.5 * odds.spare[k] * math.log(inflated))
    return sums - math.log(float(len(_ERRORS)))


@compiled(inline=True)
def _part(row, slot):
    """The columns of a kind."""
    return row[KIND + slot * EACH : KIND + (slot + 1) * EACH]


@compiled(borrows=True)
def _say(part, total, peaks):
    """The best contact of a kind."""
    at, fits = peaks
    part[CHI2] = max(total - fits[BEST, S], 0.0)
    part[POSITION], part[NORMAL], part[TANGENTIAL] = at[BEST, 0], fits[BEST, N], fits[BEST, T]
    part[HALF_WIDTH] = math.sqrt(at[BEST, 1])


@compiled(borrows=True)
def _say_pair(part, log, chi2, best):
    """The best two touches."""
    part[LOG_EVIDENCE], part[CHI2] = log, chi2
    if log > -math.inf:
        one, two = best[FIRST_ANGLE], best[SECOND_ANGLE]
        part[POSITION], part[HALF_WIDTH] = best[MIDDLE], best[HALF]
        part[NORMAL] = best[FIRST] * math.cos(one) + best[SECOND] * math.cos(two)
        part[TANGENTIAL] = best[FIRST] * math.sin(one) + best[SECOND] * math.sin(two)


@compiled(frames="readings")
def weigh_frames(readings, sensors, tables, odds, limits, pairs, out):
    """Fill `out`, one row a frame; the columns are named in `columns.py`.

    tables, odds, limits, pairs: `Tables`, `Odds`, `Thresholds`, `TouchPairs`.
    """
    frames, n = readings.shape
    mu, slots, whole = limits.mu, odds.slots, odds.whole
    kinds, others = slots.size, whole.size
    parts = kinds
    for e in range(others):
        parts += whole[e] >= 0
    best = np.empty(6)
    w = np.empty(n)
    w_single = np.empty(n, dtype=np.float32)
    room = WeighingRoom(
        np.empty((2, 6, 2 * n)), np.empty((3, 10 * n + tables.sizes.widths.max() + 3)), np.empty(6), np.empty((3, 3)),
        np.empty(3), np.empty((_PEAKS, 2)), np.empty(_PEAKS), np.empty((_PEAKS, 2)), np.empty(_PEAKS), np.empty(_PEAKS),
        np.empty(4),
    )  # fmt: skip
    at, fits = np.empty((kinds + others, _PEAKS, 2)), np.empty((kinds + others, _PEAKS, 6))
    seeds, counts = np.empty((_PEAKS, 2)), np.empty(kinds + others, dtype=np.int64)
    most = tables.sizes.squares.max() * tables.positions.size
    scans, sums = np.empty(most, dtype=np.float32), np.empty(2 * most, dtype=np.float32)
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
            if attempt == 1 and total - explained <= limits.largest:
                break
            for k in range(parts):
                field, peaks = field_of(tables, k, n), _Peaks(at[k], fits[k])
                if k < kinds:
                    s, squares = scanned(w_single, tables, k, n, sums, scans)
                    counts[k] = _peaks(w, s, tables.positions, squares, field, mu, attempt == 1, room, peaks)
                else:
                    e = whole[k - kinds]
                    seeds[:, 0], seeds[:, 1] = at[e, :, 0], odds.moments[e] * at[e, :, 1]
                    counts[k] = _climbed_from(w, field, mu, seeds, counts[e], odds.moments[k], room, peaks)
                if counts[k] > 0:
                    explained = max(explained, fits[k, BEST, S])
        row[STATUS] = _OK
        chi2_pair, explains = total, total - explained <= limits.largest
        if odds.two >= 0:
            log = -math.inf
            if total - explained > _ALONE and total >= limits.detection:
                log, chi2_pair = weigh_pairs(w, w_single, pairs, mu, best)
                log += 0.5 * (total - explained)
                explains |= chi2_pair <= limits.largest_pair
            _say_pair(_part(row, odds.two), log, chi2_pair, best)
        needed = max(explained, total - limits.largest_pair if odds.two >= 0 else 0.0)
        if not explains or needed < limits.detection:
            row[STATUS] = _UNEXPLAINED if not explains else _NO_CONTACT
            continue
        for k in range(kinds):
            part, field, peaks = _part(row, slots[k]), field_of(tables, k, n), _Peaks(at[k], fits[k])
            part[LOG_EVIDENCE], part[CHI2] = -math.inf, total
            if counts[k] > 0:
                _say(part, total, peaks)
            count = _near(counts[k], peaks, explained)
            if count == 0:
                continue
            survey = survey_of(tables, k, n)
            if broad(w, field, mu, at[k, BEST], fits[k, BEST], survey, room):
                s, squares = scanned(w_single, tables, k, n, sums, scans)
                part[LOG_EVIDENCE] = surveyed(w, s, squares, explained, mu, survey)
            else:
                part[LOG_EVIDENCE] = _evidence(w, field, mu, count, peaks, room)
            part[LOG_EVIDENCE] -= 0.5 * explained
        known = max(explained, total - chi2_pair)
        shaped, found = -math.inf, 0
        if parts < kinds + others:
            found = _seeds(total, counts[:parts], at, fits, odds.moments, 4.0 * tables.geometry[0, STEP], seeds)
        for k in range(kinds, kinds + others):
            field, peaks = field_of(tables, k, n), _Peaks(at[k], fits[k])
            if k >= parts:
                counts[k] = _climbed_from(w, field, mu, seeds, found, odds.moments[k], room, peaks)
            here = -math.inf
            for p in range(_near(counts[k], peaks, known)):
                here = add(here, valley(w, field, mu, at[k, p], room))
            here += odds.share[k - kinds] - 0.5 * explained
            if k >= parts:
                shaped = add(shaped, here)
                continue
            part = _part(row, slots[whole[k - kinds]])
            before = part[LOG_EVIDENCE] + odds.left[k - kinds]
            part[LOG_EVIDENCE] = add(before, here)
            if here > before:
                _say(part, total, peaks)
        if odds.none >= 0:
            row[KIND + odds.none * EACH] = add(_none(row, odds, total, n) + odds.off, shaped)
