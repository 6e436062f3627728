"""Compiled: round contacts that stick in their middle: what sensors read of them, and the climb to one of them.

Readings are r = N A_N(y, q) + T U(y, q, t) with q = a^2 and t = |T| / (mu N). The shear of Cattaneo and Mindlin is mu
times the Hertz pressure of half width a less that of the stick zone, c^2 = q (1 - t), so that with G(q) = q A_T(q), A_T
being the response to a drag in proportion to the pressure,

    U = (G(q) - G(c^2)) / (q t) = the mean of G' over the squares from c^2 to q.

No difference of near numbers is left at small t. A little more drag at the same N adds dr/dT = G'(c^2), the shear of a
rigid flat on the stick zone. From t = 1 on the contact slides, and U = A_T. docs/fitting.md; `PartialSlip`.

So all unknowns move together (Levenberg and Marquardt), from a fit with a set share of slip. Another drag of the other
sign, or nearer to slipping, may explain the readings as well: the climb starts from several shares of slip, and the
second of the contacts that it ends in is the rival.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._compiled import compiled
from .kinds import WIDE_FIT
from .project import WIDE_SQUARE, angle_told, whitened, wide_uncertainty
from .varpro import Limits

Y, N, T, Q, MU = range(5)
"""The unknowns: position, normal force, drag, square of the half width, coefficient of friction."""
NODES, WEIGHTS = (0.5 * part for part in np.polynomial.legendre.leggauss(8))
NODES += 0.5
"""Gauss and Legendre's on (0, 1), exact for a table's polynomials."""


class Sticking(NamedTuple):
    """Readings under contacts with a drag in proportion to their pressure, as of `kinds.Wide`, and what they add up to.

    rho (n,): what a contact leaves of the readings; columns (5, n): derivatives by its unknowns. h (3, widths), sums
    (5, widths) and v (5, 5 n): scratch.
    """

    table: npt.NDArray[np.float64]
    start: float
    step: float
    widest: float
    rho: npt.NDArray[np.float64]
    columns: npt.NDArray[np.float64]
    h: npt.NDArray[np.float64]
    sums: npt.NDArray[np.float64]
    v: npt.NDArray[np.float64]


@compiled()
def sticking(table, told):
    """The model of a table (cells, widths, 10 n); told: its start and step, and its widest."""
    widths, n = table.shape[1], table.shape[2] // 10
    h, sums, v = np.empty((3, widths)), np.empty((5, widths)), np.empty((5, 5 * n))
    return Sticking(table, told.start, told.step, told.widest, np.empty(n), np.empty((5, n)), h, sums, v)


@compiled()
def _sums(x, slope, q, slip, h, sums):
    """Weights of the table's Chebyshev sums (5, widths): A and A_q at q; U and U_q at q and t; G' at c^2."""
    widths = sums.shape[1]
    _chebyshev(x, h)
    for k in range(widths):
        sums[0, k], sums[1, k] = h[0, k], slope * h[1, k]
        sums[2, k], sums[3, k], sums[4, k] = (sums[0, k], sums[1, k], sums[0, k]) if slip >= 1.0 else (0.0, 0.0, 0.0)
    if slip >= 1.0:
        return
    for j in range(NODES.size):
        u = 1.0 - slip * NODES[j]
        part = slope * u * q
        _chebyshev(u * (x + 1.0) - 1.0, h)
        for k in range(widths):
            sums[2, k] += WEIGHTS[j] * (h[0, k] + part * h[1, k])
            sums[3, k] += WEIGHTS[j] * u * slope * (2 * h[1, k] + part * h[2, k])
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
def modelled(w, model, p):
    """Fill rho = w - r and columns = dr/d(y, N, T, q, mu) of a `Sticking` at p (5,); gives rho^2."""
    table, rho, columns, sums, v = model.table, model.rho, model.columns, model.sums, model.v
    n, step = w.size, model.step
    normal, tangential, q, mu = p[N], p[T], p[Q], p[MU]
    slip = min(abs(tangential) / (mu * normal), 1.0) if normal > 0.0 else 1.0
    slope = 2.0 / (model.widest * model.widest)
    _sums(slope * q - 1.0, slope, q, slip, model.h, sums)
    position = (p[Y] - model.start) / step
    cell = min(max(int(position), 0), table.shape[0] - 1)
    t = position - cell - 0.5
    for d in range(5):
        for i in range(5 * n):
            v[d, i] = 0.0
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
        a, aq, edge = _at(v[0], i, n, t), _at(v[1], i, n, t), _at(v[4], i, n, t)
        u, uq = _at(v[2], i, n, t), _at(v[3], i, n, t)
        rho[i] = w[i] - normal * a - tangential * u
        total += rho[i] * rho[i]
        columns[Y, i] = (normal * _slope(v[0], i, n, t) + tangential * _slope(v[2], i, n, t)) / step
        columns[N, i] = a - (tangential / normal * (edge - u) if slip < 1.0 else 0.0)
        columns[T, i] = edge
        columns[Q, i] = normal * aq + tangential * uq
        columns[MU, i] = -tangential / mu * (edge - u) if slip < 1.0 else 0.0
    return total


@compiled(inline=True)
def _at(v, i, n, t):
    return v[i] + t * (v[n + i] + t * (v[2 * n + i] + t * (v[3 * n + i] + t * v[4 * n + i])))


@compiled(inline=True)
def _slope(v, i, n, t):
    return v[n + i] + t * (2 * v[2 * n + i] + t * (3 * v[3 * n + i] + t * (4 * v[4 * n + i])))


_STEPS = 60
_GAIN = 1e-7
"""Rise of -chi-square / 2 by which a step ends the climb."""
_APART = 0.05
"""Difference in |T| / (mu N) from which two minima are two contacts."""
_SHARES = np.array([-0.9, -0.3, 0.3, 0.9])
"""Shares of slip that are climbed from: the readings may have one minimum more for another drag."""
_AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED = 1.0, 2.0, 3.0


class Within(NamedTuple):
    """What the unknowns keep to: low and high (5,), |T| <= cone N; mu is a guess, `prior` 1 over its standard error."""

    low: npt.NDArray[np.float64]
    high: npt.NDArray[np.float64]
    cone: float
    guess: float
    prior: float


@compiled()
def _climb(w, model, within, p):
    """Levenberg and Marquardt from p = (y, N, T, q, mu), which is left at the top; gives chi-square.

    What stands at an end and would go on beyond stays there; on the cone T goes with N. The guess of mu counts as one
    more reading. Leaves what the `model` is told at p.
    """
    low, high, cone, guess, prior = within
    n, columns, rho = w.size, model.columns, model.rho
    g, m, free = np.empty(5), np.empty((5, 5)), np.empty(5, dtype=np.bool_)
    old, trial = np.empty(5), np.empty((5, 6))
    chi2 = modelled(w, model, p) + (prior * (guess - p[MU])) ** 2
    damping, current = 1e-4, True
    for _ in range(_STEPS):
        if not current:
            modelled(w, model, p)
        for j in range(5):
            g[j] = 0.0
            for i in range(n):
                g[j] += columns[j, i] * rho[i]
            for k in range(j + 1):
                m[j, k] = 0.0
                for i in range(n):
                    m[j, k] += columns[j, i] * columns[k, i]
                m[k, j] = m[j, k]
        g[MU] += prior * prior * (guess - p[MU])
        m[MU, MU] += prior * prior
        sign = 1.0 if p[T] > 0.0 else -1.0
        bound = cone < math.inf and abs(p[T]) >= cone * p[N] * (1.0 - 1e-12) and sign * g[T] > 0.0
        if bound:  # one unknown for N and T
            lean = sign * cone
            g[N] += lean * g[T]
            m[N, N] += 2 * lean * m[N, T] + lean * lean * m[T, T]
            for k in (Y, Q, MU):
                m[N, k] += lean * m[T, k]
                m[k, N] = m[N, k]
        for j in range(5):
            free[j] = low[j] < high[j] and not (p[j] <= low[j] and g[j] < 0.0) and not (p[j] >= high[j] and g[j] > 0.0)
            old[j] = p[j]
        free[T] = free[T] and not bound
        done = True
        while damping < 1e10:
            _solve(m, g, free, damping, trial)
            for j in range(5):
                p[j] = min(max(old[j] + (trial[j, -1] if free[j] else 0.0), low[j]), high[j])
            if cone < math.inf:
                p[T] = sign * cone * p[N] if bound else min(max(p[T], -cone * p[N]), cone * p[N])
            promised = 0.0
            for j in range(5):
                if free[j]:
                    promised += abs(g[j] * (p[j] - old[j]))
            small = not promised > _GAIN
            new = modelled(w, model, p) + (prior * (guess - p[MU])) ** 2
            current = new < chi2
            if current:
                chi2, damping, done = new, max(0.1 * damping, 1e-9), small
                break
            for j in range(5):
                p[j] = old[j]
            if small:
                break
            damping *= 10.0
        if done:
            break
    if not current:
        modelled(w, model, p)
    return chi2


@compiled()
def _solve(m, g, free, damping, a):
    """The step (m + damping diag m)^-1 g of what is `free`, in the last column of a (5, 6), by elimination."""
    for j in range(5):
        for k in range(5):
            a[j, k] = m[j, k] if free[j] and free[k] else 0.0
        a[j, j] = m[j, j] * (1.0 + damping) if free[j] and m[j, j] > 0.0 else 1.0
        a[j, -1] = g[j] if free[j] else 0.0
    for j in range(5):
        for i in range(j + 1, 5):
            ratio = a[i, j] / a[j, j]
            for k in range(j, 6):
                a[i, k] -= ratio * a[j, k]
    for j in range(4, -1, -1):
        for k in range(j + 1, 5):
            a[j, -1] -= a[j, k] * a[k, -1]
        a[j, -1] /= a[j, j]


@compiled()
def _put(values, to):
    for i in range(values.size):
        to[i] = values[i]


@compiled()
def _same(p, other, apart, mu):
    """Whether two climbs have come to one contact: of one position, half width and share of slip, by friction mu."""
    near = abs(p[Y] - other[Y]) <= apart and abs(math.sqrt(p[Q]) - math.sqrt(other[Q])) <= apart
    return near and abs(p[T] / p[N] - other[T] / other[N]) <= _APART * mu


@compiled()
def _fitted(p, columns, within, g, fit):
    """What `wide_uncertainty` asks of a fit, of the contact p whose readings have these derivatives; g (5, 5): scratch.

    A friction that is guessed is an error that all readings share, m of it a standard deviation: noise of covariance
    1 + m m^T, which (1 - b m m^T) whitens.
    """
    n = columns.shape[1]
    for j in range(5):
        for k in range(5):
            g[j, k] = 0.0
            for i in range(n):
                g[j, k] += columns[j, i] * columns[k, i]
    square = g[MU, MU] / (within.prior * within.prior) if within.low[MU] < within.high[MU] else 0.0
    share = (1.0 - 1.0 / math.sqrt(1.0 + square)) / (square * within.prior * within.prior) if square > 0.0 else 0.0
    for j in range(4):  # of (1 - b m m^T) columns
        for k in range(4):
            g[j, k] += share * (share * g[MU, MU] - 2.0) * g[j, MU] * g[k, MU]
    fit.y, fit.q, fit.n, fit.t = p[Y], p[Q], p[N], p[T]
    fit.g_n_n, fit.g_n_t, fit.g_t_t = g[N, N], g[N, T], g[T, T]
    fit.u_y_y, fit.u_y_q, fit.u_q_q = g[Y, Y], g[Y, Q], g[Q, Q]
    fit.a_y_n, fit.a_y_t, fit.a_q_n, fit.a_q_t = g[Y, N], g[Y, T], g[Q, N], g[Q, T]


@compiled(frames="readings")
def stick_frames(readings, sensors, table, settings, mus, low, high, guess, prior, out):
    """Bring what `project_frames` found with a set share of slip to the contact that sticks in its middle.

    readings, sensors, settings and out as there; table (cells, widths, 10 n): responses to a drag in proportion to the
    pressure, whose start, step and widest the settings name; mus: coefficients of friction that are climbed from as
    well; low, high (5,), guess, prior: as of `Within`.
    """
    told, n = settings[0], readings.shape[1]
    model, within, room = sticking(table, told), Within(low.copy(), high, told.friction, guess, prior), np.empty((5, 5))
    bottom, ends, fit = within.low, np.array([0.0, 0.0, low[Q], high[Q]]), np.zeros(1, WIDE_FIT)[0]
    free, covariance = Limits(math.inf, 0.0, math.inf), np.empty(10)
    w, p, best, second, columns = np.empty(n), np.empty(5), np.ones(5), np.empty(5), np.empty((5, n))
    for f in range(readings.shape[0]):
        row = out[f]
        total = whitened(readings[f], sensors, w)
        lacking = _NO_CONTACT if told.least > 0.0 and total <= told.nothing else _UNEXPLAINED
        if math.isnan(row.y):
            if row.status == _NO_CONTACT and row.residual > told.largest:
                row.status = lacking
            continue
        chi2 = other = math.inf
        starts = (row.y, row.n, row.t, row.half_width), (row.rival_y, row.rival_n, row.rival_t, row.rival_half_width)
        row.rival_y = row.rival_n = row.rival_t = row.rival_half_width = math.nan
        row.rival_chi2 = math.inf
        for k in range(2 + mus.size * _SHARES.size):
            y, normal, tangential, half = starts[1] if k == 1 else starts[0]
            if math.isnan(y):
                continue
            bottom[N] = max(low[N], 1e-9 * (abs(normal) + abs(tangential)))
            p[Y], p[N], p[T], p[Q], p[MU] = y, max(normal, bottom[N]), tangential, half * half, guess
            p[Q] = min(max(p[Q], low[Q]), high[Q])
            if k > 1:  # the same contact with another share of slip: another drag may explain as much
                p[MU] = mus[(k - 2) // _SHARES.size]
                p[T] = min(max(_SHARES[(k - 2) % _SHARES.size] * p[MU], -told.friction), told.friction) * p[N]
            here = _climb(w, model, within, p)
            same = _same(p, best, told.apart, guess)
            if here < chi2:
                if not same and chi2 < math.inf:
                    _put(best, second)
                    other = chi2
                chi2 = here
                _put(p, best)
                _put(model.columns.reshape(-1), columns.reshape(-1))
            elif not same and here < other:
                _put(p, second)
                other = here
        if other < math.inf:
            row.rival_y, row.rival_n, row.rival_t = second[Y], second[N], second[T]
            row.rival_half_width, row.rival_chi2 = math.sqrt(second[Q]), other - chi2
        normal, tangential = best[N], best[T]
        force2 = normal * normal + tangential * tangential
        row.residual = chi2
        if chi2 > told.largest + told.fine * force2:
            row.y = row.n = row.t = row.half_width = row.low = row.high = math.nan
            row.rival_y = row.rival_n = row.rival_t = row.rival_half_width = math.nan
            for k in range(row.covariance.size):
                row.covariance[k] = math.nan
            row.rival_chi2, row.status = math.inf, lacking
            continue
        row.y, row.n, row.t = best[Y], normal, tangential
        _fitted(best, columns, within, room, fit)
        sure = wide_uncertainty(fit, free, ends, covariance, row)
        sure &= told.first < best[Y] < told.last and abs(tangential) < told.friction * normal * (1.0 - 1e-9)
        sure &= (low[N] <= 0.0 or normal > low[N]) and normal < high[N]
        if not (sure and row.rival_chi2 >= told.ambiguity and angle_told(row, WIDE_SQUARE)):
            row.status = _AMBIGUOUS
