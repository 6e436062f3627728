"""Compiled: a round contact that sticks in its middle, climbed to from what a fit with a set share of slip has found.

Readings are r = N A_N(y, q) + T U(y, q, t) with q = a^2 and t = |T| / (mu N). The shear of Cattaneo and Mindlin is mu
times the Hertz pressure of half width a less that of the stick zone, c^2 = q (1 - t), so that with G(q) = q A_T(q), A_T
being the response to a drag in proportion to the pressure,

    U = (G(q) - G(c^2)) / (q t) = the mean of G' over the squares from c^2 to q.

No difference of near numbers is left at small t. A little more drag at the same N adds dr/dT = G'(c^2), the shear of a
rigid flat on the stick zone. From t = 1 on the contact slides, and U = A_T. docs/fitting.md; `PartialSlip`.
"""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled
from . import uncertainty as _uncertainty
from .layout import WIDE
from .uncertainty import uncertainty

_STEPS = 60
_GAIN = 1e-7
"""Rise of -chi-square / 2 by which a step ends the climb."""
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED = 0.0, 1.0, 2.0, 3.0
_HALF_WIDTH, _RESIDUAL, _STATUS = WIDE.half_width, WIDE.residual, WIDE.status
_INTERVAL, _COVARIANCE, _RIVAL, _RIVAL_CHI2 = WIDE.interval, WIDE.covariance, WIDE.rival, WIDE.rival_chi2


@compiled()
def _sums(x, slope, q, slip, nodes, weights, h, sums):
    """Weights of the table's Chebyshev sums (5, widths): A and A_q at q; U and U_q at q and t; G' at c^2.

    nodes, weights: Gauss and Legendre's on (0, 1), exact for the table's polynomials; h (3, widths): scratch.
    """
    widths = sums.shape[1]
    _chebyshev(x, h)
    for k in range(widths):
        sums[0, k], sums[1, k] = h[0, k], slope * h[1, k]
        sums[2, k] = sums[3, k] = sums[4, k] = 0.0
    if slip >= 1.0:
        sums[2], sums[3], sums[4] = sums[0], sums[1], sums[0]
        return
    for j in range(nodes.size):
        u = 1.0 - slip * nodes[j]
        part = slope * u * q
        _chebyshev(u * (x + 1.0) - 1.0, h)
        for k in range(widths):
            sums[2, k] += weights[j] * (h[0, k] + part * h[1, k])
            sums[3, k] += weights[j] * u * slope * (2 * h[1, k] + part * h[2, k])
    part = slope * (1.0 - slip) * q
    _chebyshev((1.0 - slip) * (x + 1.0) - 1.0, h)
    for k in range(widths):
        sums[4, k] = h[0, k] + part * h[1, k]


@compiled()
def _chebyshev(x, h):
    """Chebyshev polynomials and their first two derivatives."""
    h[0, 0], h[1, 0], h[2, 0], h[0, 1], h[1, 1], h[2, 1] = 1.0, 0.0, 0.0, x, 1.0, 0.0
    for k in range(2, h.shape[1]):
        h[0, k] = 2 * x * h[0, k - 1] - h[0, k - 2]
        h[1, k] = 2 * h[0, k - 1] + 2 * x * h[1, k - 1] - h[1, k - 2]
        h[2, k] = 4 * h[1, k - 1] + 2 * x * h[2, k - 1] - h[2, k - 2]


@compiled()
def _model(w, table, start, step, square, nodes, weights, mu, p, h, sums, v, rho, columns):
    """Fill rho = w - r and columns = dr/d(y, N, T, q, mu) (5, n) at p = (y, N, T, q, friction); gives rho^2.

    table (cells, widths, 10 n), as of `project_wide`; v (5, 5 n): scratch.
    """
    n = w.size
    y, normal, tangential, q = p[0], p[1], p[2], p[3]
    slip = min(abs(tangential) / (p[4] * normal), 1.0) if normal > 0.0 else 1.0
    x, slope = 2.0 * q / square - 1.0, 2.0 / square
    _sums(x, slope, q, slip, nodes, weights, h, sums)
    position = (y - start) / step
    cell = min(max(int(position), 0), table.shape[0] - 1)
    t = position - cell - 0.5
    v[:] = 0.0
    for k in range(table.shape[1]):
        c = table[cell, k]
        s0, s1, s2, s3, s4 = sums[0, k], sums[1, k], sums[2, k], sums[3, k], sums[4, k]
        for d in range(5):
            for i in range(n):
                pressed, dragged = c[2 * n * d + i], c[2 * n * d + n + i]
                v[0, n * d + i] += s0 * pressed
                v[1, n * d + i] += s1 * pressed
                v[2, n * d + i] += s2 * dragged
                v[3, n * d + i] += s3 * dragged
                v[4, n * d + i] += s4 * dragged
    total = 0.0
    for i in range(n):
        a, aq, u, uq, edge = _at(v[0], i, n, t), _at(v[1], i, n, t), _at(v[2], i, n, t), _at(v[3], i, n, t), 0.0
        edge = _at(v[4], i, n, t)
        rho[i] = w[i] - normal * a - tangential * u
        total += rho[i] * rho[i]
        columns[0, i] = (normal * _slope(v[0], i, n, t) + tangential * _slope(v[2], i, n, t)) / step
        columns[1, i] = a - (tangential / normal * (edge - u) if slip < 1.0 else 0.0)
        columns[2, i] = edge
        columns[3, i] = normal * aq + tangential * uq
        columns[4, i] = -tangential / p[4] * (edge - u) if slip < 1.0 else 0.0
    return total


@compiled(inline=True)
def _at(v, i, n, t):
    return v[i] + t * (v[n + i] + t * (v[2 * n + i] + t * (v[3 * n + i] + t * v[4 * n + i])))


@compiled(inline=True)
def _slope(v, i, n, t):
    return v[n + i] + t * (2 * v[2 * n + i] + t * (3 * v[3 * n + i] + t * (4 * v[4 * n + i])))


@compiled()
def _climb(w, table, grid, nodes, weights, cone, low, high, guess, prior, p, h, sums, v, rho, columns):
    """Levenberg and Marquardt from p = (y, N, T, q, mu) between `low` and `high` (5,) and |T| <= cone N.

    grid: start and step of the table, square of its widest; guess, prior: mean of mu and 1 over its standard deviation.
    What stands at an end and would go on beyond stays there; on the cone T goes with N. Gives chi-square, the guess
    being one more reading, and leaves p there, and rho and columns as of `_model`.
    """
    start, step, square = grid[0], grid[1], grid[2]
    n = w.size
    g, m, free = np.empty(5), np.empty((5, 5)), np.empty(5, dtype=np.bool_)
    old, trial = np.empty(5), np.empty((5, 6))
    chi2 = _model(w, table, start, step, square, nodes, weights, p[4], p, h, sums, v, rho, columns)
    chi2 += (prior * (guess - p[4])) ** 2
    damping, current = 1e-4, True
    for _ in range(_STEPS):
        if not current:
            _model(w, table, start, step, square, nodes, weights, p[4], p, h, sums, v, rho, columns)
        for j in range(5):
            g[j] = 0.0
            for i in range(n):
                g[j] += columns[j, i] * rho[i]
            for k in range(j + 1):
                m[j, k] = 0.0
                for i in range(n):
                    m[j, k] += columns[j, i] * columns[k, i]
                m[k, j] = m[j, k]
        g[4] += prior * prior * (guess - p[4])
        m[4, 4] += prior * prior
        sign = 1.0 if p[2] > 0.0 else -1.0
        bound = cone < math.inf and abs(p[2]) >= cone * p[1] * (1.0 - 1e-12) and sign * g[2] > 0.0
        if bound:  # one unknown for N and T
            lean = sign * cone
            g[1] += lean * g[2]
            m[1, 1] += 2 * lean * m[1, 2] + lean * lean * m[2, 2]
            for k in (0, 3, 4):
                m[1, k] += lean * m[2, k]
                m[k, 1] = m[1, k]
        for j in range(5):
            free[j] = low[j] < high[j] and not (p[j] <= low[j] and g[j] < 0.0) and not (p[j] >= high[j] and g[j] > 0.0)
        free[2] = free[2] and not bound
        done = True
        old[:] = p
        while damping < 1e10:
            _solve(m, g, free, damping, trial)
            for j in range(5):
                p[j] = min(max(old[j] + (trial[j, 5] if free[j] else 0.0), low[j]), high[j])
            if cone < math.inf:
                p[2] = sign * cone * p[1] if bound else min(max(p[2], -cone * p[1]), cone * p[1])
            promised = 0.0
            for j in range(5):
                if free[j]:
                    promised += abs(g[j] * (p[j] - old[j]))
            small = not promised > _GAIN
            new = _model(w, table, start, step, square, nodes, weights, p[4], p, h, sums, v, rho, columns)
            new += (prior * (guess - p[4])) ** 2
            if new < chi2:
                chi2, current = new, True
                damping = max(0.1 * damping, 1e-9)
                done = small
                break
            p[:] = old
            current = False
            if small:
                break
            damping *= 10.0
        if done:
            break
    if not current:
        _model(w, table, start, step, square, nodes, weights, p[4], p, h, sums, v, rho, columns)
    return chi2


@compiled()
def _solve(m, g, free, damping, a):
    """The step (m + damping diag m)^-1 g of what is `free`, in a[:, 5], by elimination; a (5, 6) is filled."""
    for j in range(5):
        for k in range(5):
            a[j, k] = m[j, k] if free[j] and free[k] else 0.0
        a[j, j] = m[j, j] * (1.0 + damping) if free[j] and m[j, j] > 0.0 else 1.0
        a[j, 5] = g[j] if free[j] else 0.0
    for j in range(5):
        for i in range(j + 1, 5):
            ratio = a[i, j] / a[j, j]
            for k in range(j, 6):
                a[i, k] -= ratio * a[j, k]
    for j in range(4, -1, -1):
        for k in range(j + 1, 5):
            a[j, 5] -= a[j, k] * a[k, 5]
        a[j, 5] /= a[j, j]


@compiled(built_on=(_uncertainty,))
def stick_frames(readings, sensors, table, nodes, weights, low, high, options, out):
    """Bring the rows of `out`, those of a fit with a set share of slip, to the contact that sticks in its middle.

    readings, sensors, table and out as of `project_frames`; nodes and weights as of `_sums`; low, high (5,): ends of
    position, N, T, square of the half width, and friction; options: start and step of the table, square of its widest,
    the estimator's cone, friction as guessed and 1 over the guess's standard deviation, then the thresholds as of
    `StickLocator._prepare`. Rows without a contact are left as they are.
    """
    frames, n = readings.shape
    widths = table.shape[1]
    grid, cone, guess, prior = options[0:3], options[3], options[4], options[5]
    largest, ambiguity, apart, fine, nothing = options[6], options[7], options[8], options[9], options[10]
    w, rho, h, sums, v = np.empty(n), np.empty(n), np.empty((3, widths)), np.empty((5, widths)), np.empty((5, 5 * n))
    columns, told, p, best = np.empty((5, n)), np.empty((5, n)), np.empty(5), np.empty(5)
    wide, guessed = low[3] < high[3], low[4] < high[4]
    size = 3 + wide + guessed
    bottom, top = low.copy(), high.copy()
    for f in range(frames):
        row = out[f]
        if math.isnan(row[0]):
            continue
        total = 0.0
        for i in range(n):
            w[i] = (readings[f, i] - sensors[0, i]) * sensors[1, i]
            total += w[i] * w[i]
        chi2 = math.inf
        again = row[_RIVAL : _RIVAL + 4].copy()
        row[_RIVAL : _RIVAL + 4] = math.nan
        row[_RIVAL_CHI2] = math.inf
        for k in range(2):
            if k == 0:
                p[0], p[1], p[2], p[3] = row[0], row[1], row[2], row[_HALF_WIDTH] ** 2
            else:
                p[0], p[1], p[2], p[3] = again[0], again[1], again[2], again[3] ** 2
            if math.isnan(p[0]):
                continue
            p[3] = min(max(p[3], low[3]), high[3])
            p[4] = guess
            bottom[1] = max(low[1], 1e-9 * (abs(p[1]) + abs(p[2])))
            p[1] = max(p[1], bottom[1])
            here = _climb(
                w, table, grid, nodes, weights, cone, bottom, top, guess, prior, p, h, sums, v, rho, columns
            )  # fmt: skip
            nearer = here < chi2
            same = k == 1 and abs(p[0] - best[0]) <= apart and abs(math.sqrt(p[3]) - math.sqrt(best[3])) <= apart
            if k == 1 and not same:
                second, worse = (best, chi2 - here) if nearer else (p, here - chi2)
                row[_RIVAL], row[_RIVAL + 1], row[_RIVAL + 2] = second[0], second[1], second[2]
                row[_RIVAL + 3], row[_RIVAL_CHI2] = math.sqrt(second[3]), worse
            if nearer:
                chi2 = here
                best[:], told[:] = p, columns
        normal, tangential = best[1], best[2]
        force2 = normal * normal + tangential * tangential
        row[_RESIDUAL] = chi2
        if chi2 > largest + fine * force2:
            status = _NO_CONTACT if low[1] > 0.0 and total <= nothing else _UNEXPLAINED
            row[:_RESIDUAL] = math.nan
            row[_RIVAL:_RIVAL_CHI2] = math.nan
            row[_RIVAL_CHI2], row[_STATUS] = math.inf, status
            continue
        row[0], row[1], row[2], row[_HALF_WIDTH] = best[0], normal, tangential, math.sqrt(best[3])
        if not wide:
            told[3] = told[4]
        uncertainty(told[:size], prior, wide, True, best[3], low[3], high[3], row)
        inside = low[0] < best[0] < high[0] and abs(tangential) < cone * normal * (1.0 - 1e-9)
        inside &= not wide or (best[3] < high[3] and not 0.0 < best[3] <= low[3])
        inside &= low[1] <= 0.0 or normal > low[1]
        inside &= normal < high[1]
        c = _COVARIANCE
        nn, nt, tt = row[c + 4], row[c + 5], row[c + 7]
        turned = normal * normal * tt - 2 * normal * tangential * nt + tangential * tangential * nn
        if not inside or row[_RIVAL_CHI2] < ambiguity or not turned < force2 * force2:
            row[_STATUS] = _AMBIGUOUS
