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
from ..area.edge_climb import COLUMNS, SIZE, UNKNOWNS, edge_climb, edge_project
from ._area_kernel import log_integral

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
    for j in range(UNKNOWNS):
        for k in range(UNKNOWNS):
            m[j, k] = fit[28 + UNKNOWNS * j + k]
    for p in range(UNKNOWNS):
        j = order[p]
        told[j] = max(m[j, j], 1e-300)
        if j > 2 and (fit[23 + j] <= box[2 * j] or fit[23 + j] >= box[2 * j + 1]):
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
    _parabola(fit[27], fit[22], told[4], box[8], box[9], True, nodes, weights, said)
    log = said[0] + _log_turned(told[2])
    said[1], said[2] = fit[25] + slope * (said[1] - fit[27]), 1.0 / (told[2] + _FREE) + slope * slope * said[2]
    for j in range(2):
        for k in range(2):
            m[j, k] = fit[28 + UNKNOWNS * j + k]
    said[0] = log + log_integral(fit, m, mu)


@compiled()
def _best_tops(w, model, mu, box, y, z, room, tops, trial, scan, start):
    """The best edges near (y, z) in tops[0]."""
    low, high = box[6], box[7]
    for p in range(_TURNS):
        scan[p, 0] = -1.0
        for length in range(2):
            start[0], start[1], start[2] = y, z, math.pi * p / _TURNS
            start[3] = low + (0.2 + 0.5 * length) * (high - low)
            start[4] = box[8] + 0.3 * (box[9] - box[8])
            edge_project(w, model, mu, start, room, trial)
            if trial[3] > scan[p, 0]:
                scan[p, 0], scan[p, 1] = trial[3], start[3]
    tops[0, 3] = -1.0
    for _ in range(_TOPS):
        p = 0
        for e in range(1, _TURNS):
            if scan[e, 0] > scan[p, 0]:
                p = e
        start[0], start[1], start[2], start[3] = y, z, math.pi * p / _TURNS, scan[p, 1]
        edge_climb(w, model, mu, box, start, _FINE, room, tops[1], trial)
        if tops[1, 3] > tops[0, 3]:
            for k in range(SIZE):
                tops[0, k] = tops[1, k]
        for e in (p, (p + 1) % _TURNS, (p + _TURNS - 1) % _TURNS):
            scan[e, 0] = -2.0


@compiled()
def _over_lengths(w, model, mu, box, only, best, nodes, weights, room, fit, trial, told, start, last, said):
    """As `_at_length`, over all lengths; all of the box but its lengths is in `only`."""
    m, low, high, length = room[3], box[6], box[7], best[26]
    _told(best, (0, 1, 2, 4, 3), box, m, told)
    long, largest, total, first, second = told[3], -math.inf, 0.0, 0.0, 0.0
    for side in range(2):
        end = high if side else low
        pull = abs(best[21]) if end != length else 0.0
        to = min(length + _reach(pull, long), end) if side else max(length - _reach(pull, long), end)
        if to == length:
            continue
        before = length
        for k in range(UNKNOWNS):
            start[k] = last[k] = best[23 + k]
        for k in range(nodes.size):
            only[6] = only[7] = here = length + (to - length) * nodes[k]
            edge_climb(w, model, mu, only, start, _FINE, room, fit, trial)
            _at_length(fit, only, mu, nodes, weights, m, told, said)
            ahead = length + (to - length) * nodes[min(k + 1, nodes.size - 1)]
            for j in range(UNKNOWNS):  # on along the valley
                start[j] = fit[23 + j] + (fit[23 + j] - last[j]) * (ahead - here) / (here - before)
                last[j] = fit[23 + j]
            before = here
            if said[0] > largest:
                kept = math.exp(largest - said[0]) if total > 0.0 else 0.0
                total, first, second, largest = total * kept, first * kept, second * kept, said[0]
            if said[0] > -math.inf:
                share = weights[k] * abs(to - length) / (high - low) * math.exp(said[0] - largest)
                turn = said[1] - best[25]
                total += share
                first += share * turn
                second += share * (turn * turn + said[2])
    if not total > 0.0:
        said[0] = -math.inf
        return
    said[0], said[1] = largest + math.log(total), best[25] + first / total
    said[2] = second / total - (first / total) ** 2


@compiled()
def weigh_edge(frames, found, model, mu, box, floor, nodes, weights, out):
    """Fill out (f, 11): as `weigh_kind`, then half length, direction and its standard error.

    frames, nodes, weights: as of `weigh_kind`; found (f, 2): y, z of a contact near by, or (f, 4), then the direction
    and the half length of an edge; model, box: as of `edge_climb`; floor (f,): log of another kind's evidence.
    """
    n, sums = frames.shape[1], model[2]
    room = (
        np.empty((2, sums.shape[2])), np.empty((sums.shape[1] // 4, 3)), np.empty((COLUMNS, n)),
        np.empty((UNKNOWNS, UNKNOWNS + 1)), np.empty(2 * UNKNOWNS), np.empty(UNKNOWNS),
    )  # fmt: skip
    fits, only, told, said = np.empty((4, SIZE)), box.copy(), np.empty(UNKNOWNS), np.empty(3)
    scan, start, last = np.empty((_TURNS, 2)), np.empty(UNKNOWNS), np.empty(UNKNOWNS)
    best = fits[0]
    for f in range(frames.shape[0]):
        w, row = frames[f], out[f]
        for k in range(row.size):
            row[k] = math.nan
        row[0] = -math.inf
        y, z = found[f, 0], found[f, 1]
        if not math.isfinite(y):
            continue
        if found.shape[1] == 2:
            _best_tops(w, model, mu, box, y, z, room, fits, fits[3], scan, start)
        else:
            start[0], start[1], start[2], start[3], start[4] = y, z, found[f, 2], found[f, 3], box[8]
            edge_climb(w, model, mu, box, start, _FINE, room, best, fits[3])
        _at_length(best, box, mu, nodes, weights, room[3], told, said)
        log, turn, spread = said[0], said[1], said[2]
        _parabola(best[26], best[21], told[3], box[6], box[7], False, nodes, weights, said)
        said[0], said[1], said[2] = said[0] + log, turn, spread
        if box[7] > box[6] and said[0] > floor[f] - _FAR:
            _over_lengths(
                w, model, mu, box, only, best, nodes, weights, room, fits[2], fits[3], told, start, last, said
            )
        row[0], row[1], row[2], row[3], row[7], row[8] = (
            said[0], best[17], best[23], best[24], math.sqrt(best[27]), best[26],
        )  # fmt: skip
        row[4], row[5], row[6] = best[0], best[1], best[2]
        turn = said[1] % math.pi
        row[9], row[10] = turn if turn < math.pi else 0.0, min(math.sqrt(said[2]), _ANY)
