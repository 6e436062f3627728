"""How much of a Gaussian load on an area lies beyond the cone, friction being as uncertain as it is: compiled loops.

What slips for one ratio |T| / N (`_drag_lines.py`) is nearly a straight line as a normal deviate over the ratio's
logarithm. So it is found at some ratios, and a table of Chebyshev's polynomials serves for the rest: for all cells of
the density of mu, and while a load is looked for that slips as often as is wanted.
"""

from __future__ import annotations

import math

import numpy as np

from .._check import FloatArray
from .._compiled import compiled
from ._cone_kernel import AMBIGUOUS, CANNOT_TELL, CUT_OFF, EDGE, OK, UNSURE, VERDICT, fill_row, put_judged
from ._drag_lines import FEW_LINES, GUESS_LINES, LEAST, above, certain, deviate, lines_of, shares

__all__ = ["DOUBLINGS", "FARTHEST", "drag_frames", "fill_beyond", "fill_levels", "judge_drags"]

_QUICK, _FEW, _SOME, _MANY = 4, 8, 12, 40
_NARROW, _BROAD = math.log(1.5), math.log(6.0)
"""Nodes of the table over log |T| / N: for a first guess, where its ends are no further apart than this, or this, and
else."""
_WIDER = 1.15
"""By how much longer a table is made at either end that is looked into more than once."""
_COARSE = 0.05
"""Part of the table's length up to which two nodes serve in a cell of the density of mu."""
_TWO, _SEVERAL = (np.stack(np.polynomial.legendre.leggauss(k)) for k in (2, 20))
_TRIED, DOUBLINGS, _EXACT = 100, 80, 1e-10
_STEPS, _ENOUGH = 6, 3e-7
FARTHEST = math.log(1e9)
"""Of the logarithm of |T| / (mu N)."""


def _clenshaw(count: int) -> tuple[FloatArray, FloatArray]:
    """Chebyshev's nodes in (-1, 1), and the matrix that makes coefficients of the values at them."""
    k = np.arange(count)
    angle = math.pi * (k + 0.5) / count
    matrix = 2.0 / count * np.cos(np.outer(k, angle))
    matrix[0] *= 0.5
    return np.cos(angle), matrix


_QUICK_POINTS, _QUICK_MATRIX = _clenshaw(_QUICK)
_FEW_POINTS, _FEW_MATRIX = _clenshaw(_FEW)
_POINTS, _MATRIX = _clenshaw(_SOME)
_MANY_POINTS, _MANY_MATRIX = _clenshaw(_MANY)


@compiled(exact=True)
def _tabled(mean, c, lines, low, high, table):
    """Fill `table`: logarithms of the ends, how many coefficients, then these, of the deviate over log |T| / N."""
    first, last = math.log(low), math.log(high)
    points, matrix = _MANY_POINTS, _MANY_MATRIX
    if lines[0] == GUESS_LINES[0]:
        points, matrix = _QUICK_POINTS, _QUICK_MATRIX
    elif last - first < _NARROW:
        points, matrix = _FEW_POINTS, _FEW_MATRIX
    elif last - first < _BROAD:
        points, matrix = _POINTS, _MATRIX
    table[0], table[1], table[2] = first, last, points.size
    for k in range(points.size):
        table[3 + k] = 0.0
    for i in range(points.size):
        q = math.exp(0.5 * (first + last) + 0.5 * (last - first) * points[i])
        slips, holds = shares(mean, c, q, lines)
        z = deviate(slips, holds)
        for k in range(points.size):
            table[3 + k] += matrix[k, i] * z


@compiled(inline=True, exact=True)
def _told(table, q):
    """P(|T| > q N) by the table."""
    x = (2.0 * math.log(q) - table[0] - table[1]) / (table[1] - table[0])
    one = two = 0.0
    for k in range(int(table[2]) - 1, 0, -1):
        one, two = 2.0 * x * one - two + table[3 + k], one
    return above(x * one - two + table[3])


@compiled(exact=True)
def _mixed(mean, c, lines, edges, masses, scale, wide, table):
    """P(|T| > scale mu N) over the density of mu; `table` has room for one, or for the cells of a row.

    One of this load is used again where it reaches far enough; a new one is `wide` times as long at either end.
    """
    if mean.size == 2:
        fill_row(mean[0], mean[1], c[0, 0], c[0, 1], c[1, 1], edges, scale, table[: masses.size])
        total = 0.0
        for k in range(masses.size):
            total += min(table[k], 1.0) * masses[k]
        return min(total, 1.0)
    if edges[0] == edges[-1]:
        return min(shares(mean, c, scale * edges[0], lines)[0], 1.0)
    low, high = certain(mean, c)
    if scale * edges[-1] <= low:
        return 1.0
    if scale * edges[0] >= high:
        return 0.0
    first, last = max(low, scale * edges[0]), min(high, scale * edges[-1])
    if not (table[2] > 0.0 and table[0] <= math.log(first) and math.log(last) <= table[1]):
        _tabled(mean, c, lines, max(low, first / wide), min(high, last * wide), table)
    low, high = first, last
    total = 0.0
    for k in range(masses.size):
        first, last = scale * edges[k], scale * edges[k + 1]
        if first >= high:
            break
        if first == last:
            total += masses[k] * (1.0 if last <= low else _told(table, first))
            continue
        begin, end = min(max(first, low), last), min(last, high)
        total += masses[k] * (begin - first) / (last - first)
        if end > begin:
            rule, share = _TWO if end - begin < _COARSE * (high - low) else _SEVERAL, (end - begin) / (last - first)
            for i in range(rule.shape[1]):
                q = 0.5 * (begin + end) + 0.5 * (end - begin) * rule[0, i]
                total += masses[k] * share * 0.5 * rule[1, i] * _told(table, q)
    return min(max(total, 0.0), 1.0)


@compiled(exact=True, frames="mean")
def fill_beyond(mean, covariance, edges, masses, scale, out):
    """P(|T| > scale mu N) of loads on an area; edges (frames or 1, k + 1), masses alike, scale and out (frames,).

    mean (frames, 3), covariance (frames, 3, 3): of N, the drag along what was found, and the drag across it.
    """
    table = np.empty(3 + _MANY)
    for f in range(out.size):
        row = min(f, edges.shape[0] - 1)
        table[2], lines = 0.0, lines_of(mean[f], covariance[f])
        out[f] = _mixed(mean[f], covariance[f], lines, edges[row], masses[row], scale[f], 1.0, table)


@compiled(exact=True)
def _left(x, by_scale, load, c, lines, edges, masses, wanted, table):
    """By how much less than wanted slips, in deviates: with |T| / (mu N) = exp(x) times as large, or N = x."""
    scale, wide = math.exp(x) if by_scale else 1.0, _WIDER
    if not by_scale:
        load[0], wide, table[2] = x, 1.0, 0.0
    p = _mixed(load, c, lines, edges, masses, scale, wide, table)
    return deviate(p, 1.0 - p) - wanted


@compiled(exact=True)
def _crossing(start, step, floor, most, by_scale, load, c, lines, edges, masses, wanted, table):
    """Where what slips falls to what is wanted: `floor` where it is less there, infinite where it is more at `most`.

    Chandrupatla, Adv. Eng. Software 28, 145 (1997), between ends that are looked for from `start` on.
    """
    a = b = start
    fa = fb = _left(start, by_scale, load, c, lines, edges, masses, wanted, table)
    while fa >= 0.0:  # of ends a < b with fa < 0 <= fb
        if a <= floor:
            return floor
        b, fb = a, fa
        a, step = max(a - step, floor), 2.0 * step
        fa = _left(a, by_scale, load, c, lines, edges, masses, wanted, table)
    while fb < 0.0:
        if b >= most:
            return math.inf
        a, fa = b, fb
        b, step = min(b + step, most), 2.0 * step
        fb = _left(b, by_scale, load, c, lines, edges, masses, wanted, table)
    share, last, f_last = 0.5, a, fa
    for _ in range(_TRIED):
        near, f_near = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        tolerance = _EXACT * (1.0 if by_scale else abs(near)) + LEAST
        if f_near == 0.0 or abs(b - a) <= 2.0 * tolerance:
            return near
        least = tolerance / abs(b - a)
        x = a + min(max(share, least), 1.0 - least) * (b - a)
        fx = _left(x, by_scale, load, c, lines, edges, masses, wanted, table)
        if (fx < 0.0) == (fa < 0.0):
            last, f_last = a, fa
        else:
            last, f_last, b, fb = b, fb, a, fa
        a, fa = x, fx
        xi, phi = (a - b) / (last - b), (fa - fb) / (f_last - fb)
        share = 0.5
        if phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi:
            share = fa / (fb - fa) * f_last / (fb - f_last)
            share += (last - a) / (b - a) * fa / (f_last - fa) * fb / (f_last - fb)
    return a


@compiled(exact=True)
def _near(start, step, floor, most, by_scale, load, c, lines, edges, masses, wanted, table):
    """As `_crossing`, to 1e-6: from where a guess by few lines has it, along the straight line that it nearly is.

    NaN where this does not get there.
    """
    quick = GUESS_LINES
    x = _crossing(start, step, floor, most, by_scale, load, c, quick, edges, masses, wanted, table)
    if not floor < x < most:
        return math.nan
    apart = 0.1 * step
    one = _left(x - apart, by_scale, load, c, quick, edges, masses, wanted, table)
    two = _left(x + apart, by_scale, load, c, quick, edges, masses, wanted, table)
    slope = (two - one) / (2.0 * apart)
    table[2], before, f_before = 0.0, x, 0.0
    for k in range(_STEPS):
        f = _left(x, by_scale, load, c, lines, edges, masses, wanted, table)
        if k > 0:
            slope = (f - f_before) / (x - before)
        move = -f / slope
        if not (slope > 0.0 and abs(move) < 4.0 * step):
            return math.nan
        # what a step leaves falls with its square, and with that before it
        error = abs(move) * (abs(move) + (abs(x - before) if k > 0 else step)) / step
        before, f_before, x = x, f, x + move
        if error < _ENOUGH * (1.0 if by_scale else abs(x)):
            return x
    return math.nan


@compiled(exact=True, frames="mean")
def fill_levels(mean, covariance, edges, masses, wanted, by_scale, out):
    """Where loads slip with the probability `wanted`: at which |T| / (mu N), or at which N instead.

    Arguments as of `fill_beyond`; of a row (frames, 2), and of loads that press for certain there. 0 where the load
    slips less than that at the least of these, infinite where it slips more at the largest.
    """
    area = mean.shape[1] > 2
    table, load = np.empty(max(3 + _MANY, masses.shape[1])), np.empty(mean.shape[1])
    asked = deviate(wanted, 1.0 - wanted)
    for f in range(out.size):
        row, c = min(f, edges.shape[0] - 1), covariance[f]
        ends, mass = edges[row], masses[row]
        load[:], table[2] = mean[f], 0.0
        lines = lines_of(load, c) if area else FEW_LINES
        middle = 0.0
        for k in range(mass.size):
            middle += 0.5 * mass[k] * (ends[k] + ends[k + 1])
        middle = max(middle, 1e-12)
        error = math.sqrt(c[1, 1] + (c[2, 2] if area else 0.0))
        size = abs(load[1]) + error
        # relative errors together: of the drag, of the normal force, of friction
        spread = math.sqrt((error / size) ** 2 + (ends[-1] - ends[0]) ** 2 / 12 / middle**2) + 1e-9
        if by_scale:
            spread += math.sqrt(c[0, 0]) / max(abs(load[0]), 1e-3 * size)
            start = math.log(size / (middle * load[0])) + asked * spread if load[0] > 0.0 else 0.0
            start = min(max(start, -FARTHEST), FARTHEST)
            step, least, most = 0.5 * spread, -FARTHEST, FARTHEST
        else:
            start = size / middle * (1.0 + max(asked, 0.0) * spread)
            step, least, most = 0.3 * spread * start, 0.0, start * 2.0**DOUBLINGS
        found = math.nan
        if area and ends[0] != ends[-1]:  # else there is no table to be made
            found = _near(start, step, least, most, by_scale, load, c, lines, ends, mass, asked, table)
            table[2], load[0] = 0.0, mean[f, 0]
        if math.isnan(found):
            found = _crossing(start, step, least, most, by_scale, load, c, lines, ends, mass, asked, table)
        if by_scale:
            found = 0.0 if found == least else math.exp(found)
        out[f] = found


@compiled(exact=True, frames="table")
def drag_frames(table, columns, widest, mean, covariance, told, edge):
    """The loads of an estimate's table on an area as `forces_of` gives them, along the drag that was found and across.

    columns (11,): of N, of the status, then those of the covariance of (N, Ty, Tz); told, edge (frames,).
    """
    at, status = columns[0], columns[1]
    turn, own = np.zeros((3, 3)), np.empty((3, 3))
    turn[0, 0] = 1.0
    for f in range(told.size):
        row = table[f]
        n, y, z = row[at], row[at + 1], row[at + 2]
        drag = math.hypot(y, z)
        y, z = (y / drag, z / drag) if drag > 0.0 else (1.0, 0.0)
        turn[1, 1], turn[1, 2], turn[2, 1], turn[2, 2] = y, z, -z, y
        total = n + drag
        for i in range(3):
            for j in range(3):
                own[i, j] = row[columns[2 + 3 * i + j]]
                total += own[i, j]
        for i in range(3):
            for j in range(3):
                value = 0.0
                for k in range(3):
                    for m in range(3):
                        value += turn[i, k] * own[k, m] * turn[j, m]
                covariance[f, i, j] = value
        mean[f, 0], mean[f, 1], mean[f, 2] = n, drag, 0.0
        found = row[status] == OK or row[status] == AMBIGUOUS
        # where the estimator was told that there is no friction, the drag was not measured
        told[f] = found and abs(total) < math.inf and covariance[f, 1, 1] > 0.0
        edge[f] = found and math.isfinite(widest) and drag >= widest * n * (1.0 - EDGE)


@compiled(exact=True, frames="mean")
def judge_drags(mean, covariance, told, edge, status, widest, edges, masses, facts, limits, out):
    """Each load on an area beside the cone of friction, as `judge_frames` does of a row; loads of `drag_frames`."""
    table = np.empty(3 + _MANY)
    for f in range(told.size):
        row, c, n, t = min(f, edges.shape[0] - 1), covariance[f], mean[f, 0], mean[f, 1]
        out[f] = math.nan
        out[f, CUT_OFF], out[f, VERDICT], out[f, UNSURE] = edge[f], CANNOT_TELL, 0.0
        if not (told[f] and n > 0.0) or (edge[f] and widest < facts[row, 2]):
            continue
        table[2] = 0.0
        total = _mixed(mean[f], c, lines_of(mean[f], c), edges[row], masses[row], 1.0, 1.0, table)
        put_judged(out[f], n, t, c[0, 0], c[0, 1], c[1, 1], facts[row], total, limits, status[f] == OK)
