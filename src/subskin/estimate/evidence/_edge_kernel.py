"""Compiled: the evidence of an edge with its direction, in frames whose contact was found by another kind.

From the position that another kind found, edges of a few directions and lengths are tried, and the best are climbed
from. Then Gauss and Legendre's rule over the length about the top: at each length all the rest is fitted anew. Position
and forces are integrated over by Laplace's method; the direction as exp(k cos 2 delta), which wraps, of the same
curvature; the width as a parabola in its square, between the ends of its range. Where another kind is far more
probable, the length is one too.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..area.edge import FIT, ROWS, EdgeAt, EdgeModel, climb, information, keep, project
from ..area.round_contact import in_room
from ..varpro import Ending, Limits
from ._area_kernel import log_integral

UNKNOWNS = 5
_FINE = 0.003
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
def _told(fit, order, box, m, told):
    """Information on each unknown into `told` (5,), once those before it in `order` are free; m: scratch.

    The width and the length are held where they are at an end of the box; the direction is never freer than any.
    """
    whole, at = information(fit), EdgeAt(fit.y, fit.z, fit.direction, fit.length, fit.q)
    m[0, 0], m[0, 1], m[0, 2], m[0, 3], m[0, 4] = (
        whole.y_y, whole.y_z, whole.y_direction, whole.y_length, whole.y_q
    )  # fmt: skip
    m[1, 1], m[1, 2], m[1, 3], m[1, 4] = whole.z_z, whole.z_direction, whole.z_length, whole.z_q
    m[2, 2], m[2, 3], m[2, 4] = whole.direction_direction, whole.direction_length, whole.direction_q
    m[3, 3], m[3, 4], m[4, 4] = whole.length_length, whole.length_q, whole.q_q
    for j in range(UNKNOWNS):
        for k in range(j):
            m[j, k] = m[k, j]
    for p in range(UNKNOWNS):
        j = order[p]
        told[j] = max(m[j, j], 1e-300)
        if j > 2 and (at[j] <= box[2 * j] or at[j] >= box[2 * j + 1]):
            continue
        over = 1.0 / (told[j] + (_FREE if j == 2 else 0.0))
        for e in range(p + 1, UNKNOWNS):
            i = order[e]
            ratio = m[i, j] * over
            for d in range(p + 1, UNKNOWNS):
                m[i, order[d]] -= ratio * m[j, order[d]]


@compiled()
def _reach(pull, told):
    """How far a parabola falls by half of `_DEEP`, from where it slopes down by `pull`."""
    return (math.sqrt(pull * pull + _DEEP * told) - pull) / told


@compiled()
def _parabola(at, pull, told, low, high, root, nodes, weights, out):
    """Of exp(S/2), a parabola about `at`: log of its mean from low to high, mean and variance there; into out (3,).

    S is largest at `at`; where that is an end, it falls from there by `pull`. Where `root` is set, the mean is one over
    the root of what S is a parabola in.
    """
    out[0], out[1], out[2] = 0.0, at, 0.0
    if not high > low:
        return
    total = first = second = 0.0
    for side in range(2):
        end = high if side else low
        steep = abs(pull) if end != at else 0.0
        to = min(at + _reach(steep, told), end) if side else max(at - _reach(steep, told), end)
        begin, stop = (math.sqrt(at), math.sqrt(to)) if root else (at, to)
        for k in range(nodes.size):
            by = begin + (stop - begin) * nodes[k]
            by = (by * by if root else by) - at
            share = weights[k] * abs(stop - begin) * math.exp(-abs(by) * (steep + 0.5 * told * abs(by)))
            total += share
            first += share * by
            second += share * by * by
    if total > 0.0:
        out[0] = math.log(total / (math.sqrt(high) - math.sqrt(low) if root else high - low))
        out[1], out[2] = at + first / total, max(second / total - (first / total) ** 2, 0.0)


@compiled()
def _at_length(fit, box, mu, nodes, weights, m, told, said):
    """Log of the integral over all but the length; mean and variance of the direction at it, into `said` (3,)."""
    _told(fit, (0, 1, 2, 4, 3), box, m, told)
    slope = -m[2, 4] / (told[2] + _FREE)  # of the direction, as the width's square grows
    _parabola(fit.q, fit.by_q, told[4], box[8], box[9], True, nodes, weights, said)
    log = said[0] + _log_turned(told[2])
    said[1], said[2] = fit.direction + slope * (said[1] - fit.q), 1.0 / (told[2] + _FREE) + slope * slope * said[2]
    whole = information(fit)
    said[0] = log + log_integral(fit, whole.y_y, whole.y_z, whole.z_z, mu)


@compiled(inline=True)
def _set(fit, at):
    """The unknowns of a fit into `at` (5,)."""
    at[0], at[1], at[2], at[3], at[4] = fit.y, fit.z, fit.direction, fit.length, fit.q


@compiled()
def _best_tops(w, model, limits, box, y, z, tops, scan):
    """The best edges near (y, z) in tops[0]."""
    low, high = box[6], box[7]
    for p in range(_TURNS):
        scan[p, 0] = -1.0
        for length in range(2):
            long, q = low + (0.2 + 0.5 * length) * (high - low), box[8] + 0.3 * (box[9] - box[8])
            project(w, model, limits, EdgeAt(y, z, math.pi * p / _TURNS, long, q), tops[3])
            if tops[3].explained > scan[p, 0]:
                scan[p, 0], scan[p, 1] = tops[3].explained, long
    tops[0].explained = -1.0
    for _ in range(_TOPS):
        p = 0
        for e in range(1, _TURNS):
            if scan[e, 0] > scan[p, 0]:
                p = e
        start = EdgeAt(y, z, math.pi * p / _TURNS, scan[p, 1], box[8] + 0.3 * (box[9] - box[8]))
        climb(w, model, limits, box, start, Ending(_FINE, 0.0, 0.0, -math.inf), tops[1], tops[3])
        if tops[1].explained > tops[0].explained:
            keep(tops[1], tops[0])
        for e in (p, (p + 1) % _TURNS, (p + _TURNS - 1) % _TURNS):
            scan[e, 0] = -2.0


@compiled()
def _over_lengths(w, model, limits, box, rule, fits, room, said):
    """As `_at_length`, over all lengths; all of the box but its lengths is in the room's."""
    (nodes, weights), (m, told, only, start, last) = rule, room
    best, fit, mu = fits[0], fits[2], limits.friction
    low, high, length = box[6], box[7], best.length
    _told(best, (0, 1, 2, 4, 3), box, m, told)
    long, largest, total, first, second = told[3], -math.inf, 0.0, 0.0, 0.0
    for side in range(2):
        end = high if side else low
        pull = abs(best.by_length) if end != length else 0.0
        to = min(length + _reach(pull, long), end) if side else max(length - _reach(pull, long), end)
        if to == length:
            continue
        before = length
        _set(best, start)
        _set(best, last)
        for k in range(nodes.size):
            only[6] = only[7] = here = length + (to - length) * nodes[k]
            at = EdgeAt(start[0], start[1], start[2], start[3], start[4])
            climb(w, model, limits, only, at, Ending(_FINE, 0.0, 0.0, -math.inf), fit, fits[3])
            _at_length(fit, only, mu, nodes, weights, m, told, said)
            ahead = length + (to - length) * nodes[min(k + 1, nodes.size - 1)]
            _set(fit, start)
            for j in range(UNKNOWNS):  # on along the valley
                step = start[j] - last[j]
                last[j] = start[j]
                start[j] += step * (ahead - here) / (here - before)
            before = here
            if said[0] > largest:
                kept = math.exp(largest - said[0]) if total > 0.0 else 0.0
                total, first, second, largest = total * kept, first * kept, second * kept, said[0]
            if said[0] > -math.inf:
                share = weights[k] * abs(to - length) / (high - low) * math.exp(said[0] - largest)
                turn = said[1] - best.direction
                total += share
                first += share * turn
                second += share * (turn * turn + said[2])
    if not total > 0.0:
        said[0] = -math.inf
        return
    said[0], said[1] = largest + math.log(total), best.direction + first / total
    said[2] = second / total - (first / total) ** 2


@compiled(frames="frames")
def weigh_edge(frames, found, model, mu, box, floor, nodes, weights, out):
    """Fill out (f, 11): as `weigh_kind`, then half length, direction and its standard error.

    frames, nodes, weights: as of `weigh_kind`; found (f, 2): y, z of a contact near by, or (f, 4), then the
    direction and the half length of an edge; model: as of `edge`, without its scratch; box (10,): ends of its
    unknowns; floor (f,): log of another kind's evidence.
    """
    contact, limits, rule = in_room(model.contact), Limits(mu, 0.0, math.inf), (nodes, weights)
    mine = EdgeModel(contact, model.rules, model.depth, model.digits, np.empty((ROWS, frames.shape[1])))
    fits, told, said, scan = np.empty(4, FIT), np.empty(UNKNOWNS), np.empty(3), np.empty((_TURNS, 2))
    m, room = np.empty((UNKNOWNS, UNKNOWNS)), np.empty((2, UNKNOWNS))
    whole, best = (m, told, box.copy(), room[0], room[1]), fits[0]
    for f in range(frames.shape[0]):
        w, row = frames[f], out[f]
        for k in range(row.size):
            row[k] = math.nan
        row[0] = -math.inf
        y, z = found[f, 0], found[f, 1]
        if not math.isfinite(y):
            continue
        if found.shape[1] == 2:
            _best_tops(w, mine, limits, box, y, z, fits, scan)
        else:
            at = EdgeAt(y, z, found[f, 2], found[f, 3], box[8])
            climb(w, mine, limits, box, at, Ending(_FINE, 0.0, 0.0, -math.inf), best, fits[3])
        _at_length(best, box, mu, nodes, weights, m, told, said)
        log, turn, spread = said[0], said[1], said[2]
        _parabola(best.length, best.by_length, told[3], box[6], box[7], False, nodes, weights, said)
        said[0], said[1], said[2] = said[0] + log, turn, spread
        if box[7] > box[6] and said[0] > floor[f] - _FAR:
            _over_lengths(w, mine, limits, box, rule, fits, whole, said)
        row[0], row[1], row[2], row[3], row[7], row[8] = (
            said[0], best.left, best.y, best.z, math.sqrt(best.q), best.length,
        )  # fmt: skip
        row[4], row[5], row[6] = best.n, best.ty, best.tz
        turn = said[1] % math.pi
        row[9], row[10] = turn if turn < math.pi else 0.0, min(math.sqrt(said[2]), _ANY)
