"""Compiled: the evidence of a contact on an area, in frames whose contact was found by another kind.

Forces and position are integrated over by Laplace's method wherever the rest is held; what else is unknown in turn. Of
a round contact that is the half width: a climb from the position found, then Gauss and Legendre's rule over the width
about its top, all else being fitted anew at each. Of an edge, edges of a few directions and lengths are tried, and the
best are climbed from; the rule goes over the length. The direction is integrated over as exp(k cos 2 delta), which
wraps, of the same curvature; the width as a parabola in its square, between the ends of its range. Where another kind
is far more probable, the length is one too.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..area import rectangle, round_contact
from ..area.point import in_room
from ..area.rectangle import RectangleAt, RectangleModel, even
from ..area.round_contact import RoundAt
from ..area.round_contact import in_room as contact_in_room
from ..cone import cofactors
from ..varpro import Ending, Limits
from ._integrals import LOG_2PI, add

climb_edge, keep_edge, edge_information, project_edge = (
    rectangle.climb, rectangle.keep, rectangle.information, rectangle.project
)  # fmt: skip
EDGE_FIT, EDGE_ROWS, ROUND_FIT = rectangle.FIT, rectangle.ROWS, round_contact.FIT
climb_round, keep_round, round_information = round_contact.climb, round_contact.keep, round_contact.information

WEIGHED = np.dtype(
    (
        np.record,
        [
            (name, float)
            for name in (
                *("log_evidence", "chi2", "y", "z", "n", "ty", "tz", "half_width"),
                *("length", "direction", "direction_std"),  # of an edge
            )
        ],
    )
)
"""What is filled for a kind; the log of the evidence but for chi-square at no load."""
FOUND = np.dtype((np.record, [(name, float) for name in ("y", "z", "half_width", "direction", "length")]))
"""A contact near by: NaN where there is none, or no direction and length where it is no edge."""

UNKNOWNS = len(RectangleAt._fields)
_TURN, _LENGTH, _SQUARE = (RectangleAt._fields.index(name) for name in ("direction", "length", "q"))
_LEAST, _MOST = (2 * RoundAt._fields.index("q") + side for side in range(2))
_SHORTEST, _LONGEST = 2 * _LENGTH, 2 * _LENGTH + 1
_NARROWEST, _WIDEST = 2 * _SQUARE, 2 * _SQUARE + 1
"""Where the ends of these stand in a box."""
_FINE = Ending(0.003)
"""What the last step of a climb may gain."""
_DEEP = 24.0
"""Fall of S at which an integral ends."""
_TURNS = 6
"""Directions tried over half a turn, at each of two lengths."""
_TOPS = 2
"""How many of them are climbed from."""
_FREE = 12.0 / math.pi**2
"""Information on a direction that may be any: that of an even chance over half a turn [1/rad^2]."""
_ANY = math.pi / math.sqrt(12.0)
_FAR = 20.0
"""Logarithms of the odds beyond which an edge need not be weighed more closely."""


@compiled(borrows=True)
def _log_integral(fit, told, mu):
    """Log of the integral of exp(S / 2) over position and forces; forces alike on a logarithmic scale.

    told: the information of the position.
    """
    det = told.y_y * told.z_z - told.y_z * told.y_z
    force2 = fit.n * fit.n + fit.ty * fit.ty + fit.tz * fit.tz
    free = 5.0
    if mu == 0.0:
        det, force2, free = det * fit.g_n_n, force2 ** (1.0 / 3.0), 3.0
    else:
        det *= cofactors(fit.g_n_n, fit.g_n_ty, fit.g_n_tz, fit.g_ty_ty, fit.g_ty_tz, fit.g_tz_tz)[-1]
    if not (det > 0.0 and force2 > 0.0):
        return -math.inf
    return 0.5 * (fit.explained + free * LOG_2PI - math.log(det) - 3.0 * math.log(force2))


@compiled()
def _reach(at, pull, told, low, high, side):
    """How far an integral about the top `at` goes to a side: to an end, or where S has fallen by `_DEEP`.

    S is a parabola of this information; where the top is an end, S falls from there by `pull`.
    """
    end = high if side else low
    steep = abs(pull) if end != at else 0.0
    way = (math.sqrt(steep * steep + _DEEP * told) - steep) / told
    return steep, (min(at + way, end) if side else max(at - way, end))


@compiled()
def _emptied(row):
    row.log_evidence = -math.inf
    row.chi2 = row.y = row.z = row.n = row.ty = row.tz = row.half_width = math.nan
    row.length = row.direction = row.direction_std = math.nan


@compiled()
def _say(row, fit):
    row.chi2, row.y, row.z, row.half_width = fit.left, fit.y, fit.z, math.sqrt(fit.q)
    row.n, row.ty, row.tz = fit.n, fit.ty, fit.tz


@compiled(frames="frames")
def weigh_round(frames, found, model, mu, box, ratio, rule, out):
    """Fill out (f,), records of `WEIGHED`.

    frames (f, n), in units of noise; found (f,): `FOUND`; model: as of `round_contact`, without its scratch; box: ends
    of y, z and q; ratio: of the kind's half width to that one, where their readings are most alike; rule (2, nodes):
    Gauss and Legendre's nodes and weights on (0, 1).
    """
    model, limits, held, (nodes, weights) = contact_in_room(model), Limits(mu, 0.0, math.inf), box.copy(), rule
    fits = np.empty(3, ROUND_FIT)
    best, fit, trial, least, most = fits[0], fits[1], fits[2], box[_LEAST], box[_MOST]
    for f in range(frames.shape[0]):
        w, row, near = frames[f], out[f], found[f]
        _emptied(row)
        if not math.isfinite(near.y):
            continue
        best.explained = -1.0
        for start in range(3 if most > least else 1):
            q = (ratio * near.half_width) ** 2 if start == 0 else least if start == 1 else most
            climb_round(w, model, limits, box, RoundAt(near.y, near.z, q), _FINE, fit, trial)
            if fit.explained > best.explained:
                keep_round(fit, best)
        told = round_information(best)
        if not most > least:
            row.log_evidence = _log_integral(best, told, mu)
        else:
            minor = told.y_y * told.z_z - told.y_z * told.y_z
            first, second = told.z_z * told.y_q - told.y_z * told.z_q, told.y_y * told.z_q - told.y_z * told.y_q
            alone = max(told.q_q - (told.y_q * first + told.z_q * second) / minor, 1e-300)
            for side in range(2):
                _, to = _reach(best.q, best.by_q, alone, least, most, side)
                begin, stop = math.sqrt(best.q), math.sqrt(to)
                y, z = best.y, best.z
                for k in range(nodes.size if begin != stop else 0):
                    q = held[_LEAST] = held[_MOST] = (begin + (stop - begin) * nodes[k]) ** 2
                    climb_round(w, model, limits, held, RoundAt(y, z, q), _FINE, fit, trial)
                    y, z = fit.y, fit.z
                    share = weights[k] * abs(stop - begin) / (math.sqrt(most) - math.sqrt(least))
                    here = _log_integral(fit, round_information(fit), mu) + math.log(share)
                    row.log_evidence = add(row.log_evidence, here)
        _say(row, best)


@compiled()
def _log_turned(told):
    """Log of the share of half a turn that a direction of this information is spread over: exp(-k) I_0(k), k = told/4.

    Source: Abramowitz and Stegun (1964), 9.8.1 and 9.8.2.
    """
    k = 0.25 * max(told, 0.0)
    if k < 3.75:
        t = (k / 3.75) ** 2
        value = 1.0 + t * (
            3.5156229 + t * (3.0899424 + t * (1.2067492 + t * (0.2659732 + t * (0.0360768 + t * 0.0045813))))
        )
        return math.log(value) - k
    t = 3.75 / k
    value = 0.39894228 + t * (0.01328592 + t * (0.00225319 + t * (-0.00157565 + t * 0.00916281)))
    value += t**5 * (-0.02057706 + t * (0.02635537 + t * (-0.01647633 + t * 0.00392377)))
    return math.log(value / math.sqrt(k))


@compiled(borrows=True)
def _told(fit, whole, box, m, told):
    """Information on each unknown into `told` (5,): once those before it are free, the length after the width.

    The width and the length are held where they are at an end of the box; the direction is never freer than any.
    whole: of all; m: scratch.
    """
    order, e = (0, 1, _TURN, _SQUARE, _LENGTH), 0  # the pressure does not lean
    at = (fit.y, fit.z, fit.direction, fit.length, fit.q)
    for j in range(UNKNOWNS):
        for k in range(j, UNKNOWNS):
            m[j, k] = m[k, j] = whole[e]
            e += 1
    for p in range(len(order)):
        j = order[p]
        told[j] = max(m[j, j], 1e-300)
        if j > _TURN and (at[j] <= box[2 * j] or at[j] >= box[2 * j + 1]):
            continue
        over = 1.0 / (told[j] + (_FREE if j == _TURN else 0.0))
        for e in range(p + 1, len(order)):
            i = order[e]
            ratio = m[i, j] * over
            for d in range(p + 1, len(order)):
                m[i, order[d]] -= ratio * m[j, order[d]]


@compiled()
def _parabola(at, pull, told, low, high, root, rule):
    """Of exp(S/2), a parabola about `at`: log of its mean from low to high, mean and variance there.

    S is largest at `at`; where that is an end, it falls from there by `pull`. Where `root` is set, the mean is one over
    the root of what S is a parabola in.
    """
    nodes, weights = rule
    log, mean, variance = 0.0, at, 0.0
    total = first = second = 0.0
    for side in range(2 if high > low else 0):
        steep, to = _reach(at, pull, told, low, high, side)
        begin, stop = (math.sqrt(at), math.sqrt(to)) if root else (at, to)
        for k in range(nodes.size):
            by = begin + (stop - begin) * nodes[k]
            by = (by * by if root else by) - at
            share = weights[k] * abs(stop - begin) * math.exp(-abs(by) * (steep + 0.5 * told * abs(by)))
            total += share
            first += share * by
            second += share * by * by
    if total > 0.0:
        log = math.log(total / (math.sqrt(high) - math.sqrt(low) if root else high - low))
        mean, variance = at + first / total, max(second / total - (first / total) ** 2, 0.0)
    return log, mean, variance


@compiled()
def _at_length(fit, box, mu, rule, m, told):
    """Log of the integral over all but the length; mean and variance of the direction at it."""
    whole = edge_information(fit)
    _told(fit, whole, box, m, told)
    known = told[_TURN] + _FREE
    slope = -m[_TURN, _SQUARE] / known  # of the direction, as the width's square grows
    log, mean, variance = _parabola(fit.q, fit.by_q, told[_SQUARE], box[_NARROWEST], box[_WIDEST], True, rule)
    log += _log_turned(told[_TURN]) + _log_integral(fit, whole, mu)
    return log, fit.direction + slope * (mean - fit.q), 1.0 / known + slope * slope * variance


@compiled()
def _best_top(w, model, limits, box, y, z, tops, scan):
    """The best edge near (y, z) in tops[0]."""
    low, high, q = box[_SHORTEST], box[_LONGEST], box[_NARROWEST] + 0.3 * (box[_WIDEST] - box[_NARROWEST])
    for p in range(_TURNS):
        scan[p, 0] = -1.0
        for length in range(2):
            long = low + (0.2 + 0.5 * length) * (high - low)
            project_edge(w, model, limits, even(y, z, math.pi * p / _TURNS, long, q), tops[3])
            if tops[3].explained > scan[p, 0]:
                scan[p, 0], scan[p, 1] = tops[3].explained, long
    tops[0].explained = -1.0
    for _ in range(_TOPS):
        p = np.argmax(scan[:, 0])
        start = even(y, z, math.pi * p / _TURNS, scan[p, 1], q)
        climb_edge(w, model, limits, box, start, _FINE, tops[1], tops[3])
        if tops[1].explained > tops[0].explained:
            keep_edge(tops[1], tops[0])
        for e in (p, (p + 1) % _TURNS, (p + _TURNS - 1) % _TURNS):
            scan[e, 0] = -2.0


@compiled()
def _over_lengths(w, model, limits, box, rule, fits, m, told):
    """As `_at_length`, over all lengths; told (5,): of the best fit, by `_at_length`."""
    (nodes, weights), held, (best, fit, trial) = rule, box.copy(), (fits[0], fits[2], fits[3])
    low, high, long = box[_SHORTEST], box[_LONGEST], told[_LENGTH]
    total, mean, square = -math.inf, 0.0, 0.0
    for side in range(2):
        _, to = _reach(best.length, best.by_length, long, low, high, side)
        before, last = best.length, even(best.y, best.z, best.direction, best.length, best.q)
        start = last
        for k in range(nodes.size if to != best.length else 0):
            here = held[_SHORTEST] = held[_LONGEST] = best.length + (to - best.length) * nodes[k]
            climb_edge(w, model, limits, held, start, _FINE, fit, trial)
            log, turn, variance = _at_length(fit, held, limits.friction, rule, m, told)
            now = even(fit.y, fit.z, fit.direction, fit.length, fit.q)
            on = (best.length + (to - best.length) * nodes[min(k + 1, nodes.size - 1)] - here) / (here - before)
            start = even(  # on along the valley
                now.y + on * (now.y - last.y), now.z + on * (now.z - last.z),
                now.direction + on * (now.direction - last.direction), now.length + on * (now.length - last.length),
                now.q + on * (now.q - last.q),
            )  # fmt: skip
            before, last, turn = here, now, turn - best.direction
            log += math.log(weights[k] * abs(to - best.length) / (high - low))
            if log > -math.inf:
                total = add(total, log)
                share = math.exp(log - total)
                mean += share * (turn - mean)
                square += share * (turn * turn + variance - square)
    return total, best.direction + mean, square - mean * mean


@compiled(frames="frames")
def weigh_edge(frames, found, model, mu, box, floor, rule, out):
    """Fill out (f,) as `weigh_round` does.

    model: a `RectangleModel` without its scratch; box (16,): ends of its unknowns; floor (f,): log of another kind's
    evidence.
    """
    limits, n = Limits(mu, 0.0, math.inf), frames.shape[1]
    points, rows = in_room(model.points, n), np.empty((EDGE_ROWS, n))
    mine = RectangleModel(points, model.along, model.across, model.depth, 0.0, rows)
    fits, told, scan = np.empty(4, EDGE_FIT), np.empty(UNKNOWNS), np.empty((_TURNS, 2))
    m, best, low, high = np.empty((UNKNOWNS, UNKNOWNS)), fits[0], box[_SHORTEST], box[_LONGEST]
    for f in range(frames.shape[0]):
        w, row, near = frames[f], out[f], found[f]
        _emptied(row)
        if not math.isfinite(near.y):
            continue
        if math.isfinite(near.length):
            at = even(near.y, near.z, near.direction, near.length, box[_NARROWEST])
            climb_edge(w, mine, limits, box, at, _FINE, best, fits[3])
        else:
            _best_top(w, mine, limits, box, near.y, near.z, fits, scan)
        log, turn, variance = _at_length(best, box, mu, rule, m, told)
        log += _parabola(best.length, best.by_length, told[_LENGTH], low, high, False, rule)[0]
        if high > low and log > floor[f] - _FAR:
            log, turn, variance = _over_lengths(w, mine, limits, box, rule, fits, m, told)
        _say(row, best)
        turn = turn % math.pi
        row.log_evidence, row.length = log, best.length
        row.direction, row.direction_std = turn if turn < math.pi else 0.0, min(math.sqrt(max(variance, 0.0)), _ANY)
