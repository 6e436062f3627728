"""The compiled heart of placement: a row of sensors against touches, without a search for each.

The readings of a load at f are A(f) c, c = force (cos angle, sin angle). The best admissible load at another position g
leaves of them

    L(g) = |A(f) c|^2 - S(g),

the chi-square by which it is a rival where L has a minimum of its own. Without the cone L is a quadratic form of c,
c^T G(f, g) c with G = A(f)^T (I - A(g) A(g)^+) A(f), so one 2 x 2 matrix for a pair of positions serves every angle:
positions at which it is too large at all angles of the cone are left out before any touch is looked at.

Only arrays and numbers go in and out; `_table.py` prepares them.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ...estimate.kinds import LINE_FIT, LINE_ROWS, Along, Line, climb_line, line_field, until
from ...estimate.varpro import Limits
from ._bounds_kernel import _SINGULAR, _bounds, _grams

# Rows of the output.
POSITION, FORCE, ANGLE, LOG_DET, AMBIGUOUS, WRONG, UNFELT = range(7)

_SURE_AT_ALL = 8.0
_SURE = 4.75  # standard deviations: a rival farther off than this wins, or ties, once in a million touches

_PARABOLA = 30.0  # a parabola has risen by 36 at six standard deviations
_FAR = 120.0  # and this is too much for noise to make up


@compiled()
def _scan_basis(model, scan_start, scan_step, mu, basis, edges):
    """Orthonormal columns of A at each position of the scan, (n, 2, m), and unit edges of the cone in them, (4, m)."""
    n, _, m = basis.shape
    a = model.rows
    for j in range(m):
        line_field(model, Along(scan_start + j * scan_step))
        size = along = 0.0
        for i in range(n):
            size += a[0, i] * a[0, i]
        size = math.sqrt(size)
        over = 1.0 / size if size > 0.0 else 0.0
        for i in range(n):
            basis[i, 0, j] = a[0, i] * over
            along += basis[i, 0, j] * a[1, i]
        across = 0.0
        for i in range(n):
            rest = a[1, i] - along * basis[i, 0, j]
            basis[i, 1, j] = rest
            across += rest * rest
        across = math.sqrt(across)
        over = 1.0 / across if across > 0.0 else 0.0
        for i in range(n):
            basis[i, 1, j] *= over
        for side in range(2):
            t = mu if side else -mu
            e1, e2 = size + t * along, t * across
            length = math.hypot(e1, e2)
            over = 1.0 / length if length > 0.0 else 0.0
            edges[2 * side, j], edges[2 * side + 1, j] = e1 * over, e2 * over


@compiled()
def _half_turns(basis, edges, turns):
    """Sines of half the largest angle by which the plane of A, and it or an edge of the cone, turn to the next.

    turns (2, m), each the larger one of both sides. Between two positions of the scan the root of L changes by no more
    than that share of the readings' size.
    """
    n, _, m = basis.shape
    for j in range(m):
        turns[0, j] = turns[1, j] = 0.0
    for j in range(m - 1):
        g11 = g12 = g21 = g22 = 0.0
        for i in range(n):
            g11 += basis[i, 0, j] * basis[i, 0, j + 1]
            g12 += basis[i, 0, j] * basis[i, 1, j + 1]
            g21 += basis[i, 1, j] * basis[i, 0, j + 1]
            g22 += basis[i, 1, j] * basis[i, 1, j + 1]
        # the least singular value of g is the cosine of the plane's turn
        sum2, det = g11 * g11 + g12 * g12 + g21 * g21 + g22 * g22, g11 * g22 - g12 * g21
        least = 0.5 * (sum2 - math.sqrt(max(sum2 * sum2 - 4.0 * det * det, 0.0)))
        plane = math.sqrt(max(0.5 * (1.0 - math.sqrt(max(least, 0.0))), 0.0))
        most = plane
        for e in (0, 2):
            a1, a2, b1, b2 = edges[e, j], edges[e + 1, j], edges[e, j + 1], edges[e + 1, j + 1]
            cosine = a1 * (g11 * b1 + g12 * b2) + a2 * (g21 * b1 + g22 * b2)
            most = max(most, math.sqrt(max(0.5 * (1.0 - cosine), 0.0)))
        for k in (j, j + 1):
            turns[0, k], turns[1, k] = max(turns[0, k], plane), max(turns[1, k], most)


@compiled()
def _project(basis, a, b):
    """B (4, m): normal and tangential field at a position, in the basis of each position of the scan."""
    n, _, m = basis.shape
    for j in range(m):
        b[0, j] = b[1, j] = b[2, j] = b[3, j] = 0.0
    for i in range(n):
        an, at = a[0, i], a[1, i]
        for j in range(m):
            q1, q2 = basis[i, 0, j], basis[i, 1, j]
            b[0, j] += q1 * an
            b[1, j] += q1 * at
            b[2, j] += q2 * an
            b[3, j] += q2 * at


@compiled()
def _possible(b, k11, k12, k22, cone, least, turns, possible):
    """Mark the positions of the scan beside which a load may leave a root of L of less than `least` per force."""
    m = b.shape[1]
    cos, sin = math.cos(cone), math.sin(cone)
    cos2, sin2 = math.cos(2 * cone), math.sin(2 * cone)
    narrow = cone <= 0.25 * math.pi
    size = math.sqrt(0.5 * (k11 + k22) + math.sqrt(0.25 * (k11 - k22) ** 2 + k12 * k12))
    for j in range(m):
        g11 = k11 - b[0, j] * b[0, j] - b[2, j] * b[2, j]
        g12 = k12 - b[0, j] * b[1, j] - b[2, j] * b[3, j]
        g22 = k22 - b[1, j] * b[1, j] - b[3, j] * b[3, j]
        half = 0.5 * (g11 - g22)
        lowest = 0.5 * (g11 + g22) - math.sqrt(half * half + g12 * g12)
        ends = g11 * cos * cos + g22 * sin * sin - 2 * abs(g12) * cos * sin
        # a quadratic form is a wave of twice the angle: its trough is in the cone where it falls at one end of the
        # cone and rises at the other
        trough = (half * sin2 + g12 * cos2 < 0.0) & (-half * sin2 + g12 * cos2 > 0.0)
        value = lowest if trough or not narrow else ends
        bound = least + turns[0, j] * size
        possible[j] = value < bound * bound


@compiled(inline=True)
def _left(b1, b2, m1, m2, p1, p2, total):
    """Chi-square that the best admissible load leaves, from the readings in the basis there."""
    low, high = b1 * m1 + b2 * m2, b1 * p1 + b2 * p2
    along = low if low > high else high
    along = along if along > 0.0 else 0.0
    before, beyond = m1 * b2 - m2 * b1, b1 * p2 - b2 * p1
    inside = before if before < beyond else beyond
    return total - (b1 * b1 + b2 * b2 if inside > 0.0 else along * along)


@compiled()
def _minima(near, cone, asked, count, c, s, total, left, minimum):
    """L at the first `count` columns of B and the cone's edges (4, m), into left[1:], and a 1 at each asked minimum."""
    for q in range(count):
        b1, b2 = near[0, q] * c + near[1, q] * s, near[2, q] * c + near[3, q] * s
        left[q + 1] = _left(b1, b2, cone[0, q], cone[1, q], cone[2, q], cone[3, q], total)
    left[count + 1] = math.inf
    for q in range(count):
        minimum[q] = asked[q] & (left[q + 1] < left[q]) & (left[q + 1] <= left[q + 2])
    for q in range(count, min(count + 8, minimum.size)):
        minimum[q] = 0


@compiled()
def _normal(z):
    """Standard normal distribution function."""
    return 0.5 * math.erfc(-0.7071067811865476 * z)


@compiled()
def _rise(b, edges, j, c, s, total):
    """Chi-square at the j-th position of the scan."""
    b1, b2 = b[0, j] * c + b[1, j] * s, b[2, j] * c + b[3, j] * s
    return _left(b1, b2, edges[0, j], edges[1, j], edges[2, j], edges[3, j], total)


@compiled()
def _widened(b, edges, scan, c, s, f, total, variance):
    """The variance of the position, widened to where chi-square has risen by 1.96^2 on either side."""
    start, step, m = scan[0], scan[1], int(scan[2])
    if variance < 0.25 * step * step:
        return variance
    width = 0.0
    for side in range(2):
        k = math.floor((f - start) / step) + side
        before, at, far = 0.0, f, math.nan
        while 0 <= k < m:
            here = math.sqrt(max(_rise(b, edges, k, c, s, total), 0.0))
            position = start + k * step
            if here >= 1.96:
                far = at + (position - at) * (1.96 - before) / (here - before)
                break
            before, at = here, position
            k += 2 * side - 1
        width += abs(far - f) if far == far else 1.96 * math.sqrt(variance)
    return max((0.5 * width / 1.96) ** 2, variance)


@compiled()
def _broad(b, basis, edges, scan, c, s, f, ambiguity, wide, a, told):
    """Probability that chi-square is found too low at six standard deviations, on either side.

    Noise along what a load near the true one can take up moves the best load and its surroundings alike; what is left
    of the misfit across that, times the noise, is what changes its chi-square against the best one's.
    a: of `line_field` at f; told: of `_bounds`.
    """
    start, step, m = scan[0], scan[1], int(scan[2])
    uu, uf, ua, ff, fa, aa, det, variance, _, _ = told
    reach = max(6.0 * math.sqrt(variance), wide)
    for trial in range(2):
        before = math.floor((f - reach - start) / step)
        after = math.ceil((f + reach - start) / step)
        low = _rise(b, edges, before, c, s, ff) if before >= 0 else math.inf
        high = _rise(b, edges, after, c, s, ff) if after < m else math.inf
        if trial == 0:
            if min(low, high) > _PARABOLA:
                return 0.0
            reach = max(6.0 * math.sqrt(_widened(b, edges, scan, c, s, f, ff, variance)), wide)
    clear = 1.0
    for side in range(2):
        j, rise = (after, high) if side else (before, low)
        if not rise < _FAR:
            continue
        b1, b2 = b[0, j] * c + b[1, j] * s, b[2, j] * c + b[3, j] * s
        m1, m2, p1, p2 = edges[0, j], edges[1, j], edges[2, j], edges[3, j]
        if not min(m1 * b2 - m2 * b1, b1 * p2 - b2 * p1) > 0.0:
            on_low, on_high = b1 * m1 + b2 * m2, b1 * p1 + b2 * p2
            if on_low > on_high:
                b1, b2 = max(on_low, 0.0) * m1, max(on_low, 0.0) * m2
            else:
                b1, b2 = max(on_high, 0.0) * p1, max(on_high, 0.0) * p2
        ru = rf = ra = 0.0
        for i in range(a.shape[1]):
            w = a[0, i] * c + a[1, i] * s
            r = w - basis[i, 0, j] * b1 - basis[i, 1, j] * b2
            ru += r * (a[2, i] * c + a[3, i] * s)
            rf += r * w
            ra += r * (a[1, i] * c - a[0, i] * s)
        along = ru * ru * (ff * aa - fa * fa) + rf * rf * (uu * aa - ua * ua) + ra * ra * (uu * ff - uf * uf)
        along += 2 * ru * rf * (ua * fa - uf * aa) + 2 * ru * ra * (uf * fa - ua * ff)
        along += 2 * rf * ra * (ua * uf - uu * fa)
        across = math.sqrt(max(rise - along / det, 1e-12))
        clear *= 1.0 - _normal((ambiguity - rise) / (2 * across))
    return 1.0 - clear


@compiled()
def survey(table, start, step, scan, mu, lean, force, limits, positions, directions, bounds, out):
    """Fill `out` (7, p, k): the errors of each touch, and how probably it is mistaken; rows are named above.

    table (cells, 5, 2, n): whitened receptive field, with its start and step; scan: start, step and number of the
    positions at which loads are looked for; limits: least chi-square of a contact, `ambiguity`, distance within which
    two minima are one, distance within which they are not far apart; positions (p,), directions (2, p, k): cosine and
    sine of each touch's angle; bounds: whether to fill the first four rows.
    """
    n = table.shape[3]
    scan_start, scan_step, m = scan[0], scan[1], int(scan[2])
    detection, ambiguity, apart, wide = limits[0], limits[1], limits[2], limits[3]
    cap = _SURE + math.sqrt(_SURE * _SURE + ambiguity)  # of the root of L
    root_detection = math.sqrt(detection)
    scan_stop = scan_start + (m - 1) * scan_step
    reach_all = scan_stop - scan_start
    model, other = (
        Line(table, start, step, np.empty((LINE_ROWS, n))), Line(table, start, step, np.empty((LINE_ROWS, n)))
    )  # fmt: skip
    a, cone, ends, fits = model.rows, Limits(mu, 0.0, math.inf), np.empty(2), np.zeros(2, LINE_FIT)
    basis, edges = np.empty((n, 2, m)), np.empty((4, m))
    _scan_basis(model, scan_start, scan_step, mu, basis, edges)
    turns = np.empty((2, m))
    _half_turns(basis, edges, turns)
    b = np.empty((4, m))
    possible = np.zeros(m, dtype=np.bool_)
    index = np.empty(m, dtype=np.int64)
    near, near_edges = np.empty((4, m)), np.empty((4, m))
    left = np.full(m + 2, math.inf)
    asked = np.empty(m, dtype=np.uint8)
    words = np.zeros((m + 7) // 8, dtype=np.uint64)
    minimum = words.view(np.uint8)
    w, fit, trial = np.empty(n), fits[0], fits[1]
    for p in range(positions.size):
        f = positions[p]
        line_field(model, Along(f))
        grams = _grams(a)
        _project(basis, a, b)
        _possible(b, grams.k11, grams.k12, grams.k22, lean, cap / force, turns, possible)
        count = 0
        for j in range(m):
            if possible[j] or (j > 0 and possible[j - 1]) or (j < m - 1 and possible[j + 1]):
                index[count], asked[count] = j, possible[j]
                for q in range(4):
                    near[q, count], near_edges[q, count] = b[q, j], edges[q, j]
                count += 1
        for k in range(directions.shape[2]):
            c, s = force * directions[0, p, k], force * directions[1, p, k]
            told = _bounds(grams, c, s, mu, reach_all)
            total, v_y, v_a = told.ff, told.position, told.angle
            if bounds:
                out[POSITION, p, k], out[FORCE, p, k] = math.sqrt(v_y), math.sqrt(told.force)
                out[ANGLE, p, k] = math.sqrt(v_a)
                size = total + told.aa
                out[LOG_DET, p, k] = math.log(max(told.det, _SINGULAR * told.uu * size * (size if mu > 0.0 else 1.0)))
            over = math.sqrt(total + 2.0) - root_detection
            unfelt = _normal(-over) if over < _SURE_AT_ALL else 0.0
            # what else the readings would fit, as `locate` judges it
            if v_y < reach_all * reach_all and v_a < 1.0:
                unsure = _broad(b, basis, edges, scan, c, s, f, ambiguity, wide, a, told)
                # the best position lies at the search's edge
                inside = min(f - scan_start, scan_stop - f)
                if inside * inside < _SURE * _SURE * v_y:
                    unsure = max(unsure, _normal(-inside / math.sqrt(v_y)))
            else:  # neither position nor angle is determined
                unsure = 1.0
            _minima(near, near_edges, asked, count, c, s, total, left, minimum)
            clear, odds, size = 1.0, 0.0, math.sqrt(total)
            for word in range((count + 7) // 8):
                if words[word] == 0:
                    continue
                for q in range(8 * word, 8 * word + 8):
                    if minimum[q] == 0:
                        continue
                    j, here = index[q], left[q + 1]
                    y = scan_start + j * scan_step
                    if abs(y - f) < scan_step:  # the touch itself
                        continue
                    if math.sqrt(max(here, 0.0)) - turns[1, j] * size > cap:
                        continue
                    for i in range(n):
                        w[i] = a[0, i] * c + a[1, i] * s
                    ends[0], ends[1] = max(y - 1.5 * scan_step, scan_start), min(y + 1.5 * scan_step, scan_stop)
                    climb_line(w, other, cone, ends, Along(y), until(1e-3), fit, trial)
                    y = fit.y
                    if abs(y - f) < apart:
                        continue
                    distance = math.sqrt(max(total - fit.explained, 1e-12))
                    clear *= 1.0 - (
                        _normal((ambiguity - distance * distance) / (2 * distance))
                        - _normal((-ambiguity - distance * distance) / (2 * distance))
                    )
                    if abs(y - f) > wide:
                        wins = _normal(-0.5 * distance)
                        odds += wins / (1.0 - wins)
            out[AMBIGUOUS, p, k] = (1.0 - unfelt) * (1.0 - (1.0 - unsure) * clear)
            out[WRONG, p, k] = (1.0 - unfelt) * odds / (1.0 + odds)
            out[UNFELT, p, k] = unfelt
