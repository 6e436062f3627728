"""Compiled: the climb to a round contact that sticks in its middle, from a fit with a set share of slip.

The readings are no longer linear in the drag, so that all unknowns move together (Levenberg and Marquardt), by the
model and the derivatives of `stick_model`. Another drag of the other sign, or nearer to slipping, may explain them as
well: so the climb starts from several shares of slip, and the second of the contacts that it ends in is the rival.
"""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled
from .layout import WIDE
from .project import _uncertainty, project_frames
from .stick_model import modelled

_STEPS = 60
_GAIN = 1e-7
"""Rise of -chi-square / 2 by which a step ends the climb."""
_APART = 0.05
"""Difference in |T| / (mu N) from which two minima are two contacts."""
_AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED = 1.0, 2.0, 3.0
_HALF_WIDTH, _RESIDUAL, _STATUS = WIDE.half_width, WIDE.residual, WIDE.status
_INTERVAL, _COVARIANCE, _RIVAL, _RIVAL_CHI2 = WIDE.interval, WIDE.covariance, WIDE.rival, WIDE.rival_chi2


@compiled()
def _climb(w, table, grid, nodes, weights, cone, low, high, guess, prior, p, h, sums, v, rho, columns):
    """Levenberg and Marquardt from p = (y, N, T, q, mu) between `low` and `high` (5,) and |T| <= cone N.

    grid: start and step of the table, square of its widest; guess, prior: mean of mu and 1 over its standard deviation.
    What stands at an end and would go on beyond stays there; on the cone T goes with N. Gives chi-square, the guess
    being one more reading, and leaves p there, and rho and columns as in `modelled`.
    """
    start, step, square = grid[0], grid[1], grid[2]
    n = w.size
    g, m, free = np.empty(5), np.empty((5, 5)), np.empty(5, dtype=np.bool_)
    old, trial = np.empty(5), np.empty((5, 6))
    chi2 = modelled(w, table, start, step, square, nodes, weights, p, h, sums, v, rho, columns)
    chi2 += (prior * (guess - p[4])) ** 2
    damping, current = 1e-4, True
    for _ in range(_STEPS):
        if not current:
            modelled(w, table, start, step, square, nodes, weights, p, h, sums, v, rho, columns)
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
            new = modelled(w, table, start, step, square, nodes, weights, p, h, sums, v, rho, columns)
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
        modelled(w, table, start, step, square, nodes, weights, p, h, sums, v, rho, columns)
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


@compiled()
def _same(p, other, apart, mu):
    """Whether two climbs have come to one contact: of one position, half width and share of slip, by friction mu."""
    near = abs(p[0] - other[0]) <= apart and abs(math.sqrt(p[3]) - math.sqrt(other[3])) <= apart
    return near and abs(p[2] / p[1] - other[2] / other[1]) <= _APART * mu


@compiled()
def _derivatives(columns, prior, guessed, a):
    """Derivatives of the readings in (y, N, T, q) into `a`, where `project_wide` has them of a unit normal force.

    A friction that is guessed is an error that all readings share, m of it a standard deviation: noise of covariance
    1 + m m^T, which (1 - b m m^T) whitens.
    """
    n = columns.shape[1]
    square = 0.0
    for i in range(n):
        square += (columns[4, i] / prior) ** 2 if guessed else 0.0
    share = (1.0 - 1.0 / math.sqrt(1.0 + square)) / (square * prior * prior) if square > 0.0 else 0.0
    for k in range(4):
        along = 0.0
        for i in range(n):
            along += columns[k, i] * columns[4, i]
        for i in range(n):
            columns[k, i] -= share * along * columns[4, i]
    for i in range(n):
        a[1, i], a[0, i], a[0, n + i], a[2, i] = columns[0, i], columns[1, i], columns[2, i], columns[3, i]


@compiled(entry=True)
def stick_frames(
    readings, sensors, basis, edges, shapes, squares, far, searched, search,
    table, nodes, weights, shares, mus, low, high, options, out,
):  # fmt: skip
    """Fill `out` by a fit with a set share of slip, then bring its rows to the contact that sticks in its middle.

    All up to search, and out, as in `project_frames`, searched and search being its table and options; table:
    responses to a drag in proportion to the pressure; nodes and weights as in `modelled`; shares of slip and
    coefficients of friction mus: what is climbed from as well; low, high (5,): ends of position, N, T, square of the
    half width, and friction; options: start and step of the table, square of its widest, the estimator's cone, friction
    as guessed and 1 over the guess's standard deviation, then the thresholds as in `StickLocator._prepare`.
    """
    project_frames(readings, sensors, basis, edges, shapes, squares, far, searched, search, out)
    frames, n = readings.shape
    widths = table.shape[1]
    grid, cone, guess, prior = options[0:3], options[3], options[4], options[5]
    largest, ambiguity, apart, fine, nothing = options[6], options[7], options[8], options[9], options[10]
    w, rho, h, sums, v = np.empty(n), np.empty(n), np.empty((3, widths)), np.empty((5, widths)), np.empty((5, 5 * n))
    columns, told, p = np.empty((5, n)), np.empty((5, n)), np.empty(5)
    best, second, found = np.ones(5), np.ones(5), np.empty((2, 4))
    wide, guessed = low[3] < high[3], low[4] < high[4]
    a, unit = np.zeros((6, 2 * n)), np.array([1.0, 0.0])
    bottom, top = low.copy(), high.copy()
    for f in range(frames):
        row = out[f]
        total = 0.0
        for i in range(n):
            w[i] = (readings[f, i] - sensors[0, i]) * sensors[1, i]
            total += w[i] * w[i]
        lacking = _NO_CONTACT if low[1] > 0.0 and total <= nothing else _UNEXPLAINED
        if math.isnan(row[0]):
            if row[_STATUS] == _NO_CONTACT and row[_RESIDUAL] > largest:
                row[_STATUS] = lacking
            continue
        chi2 = other = math.inf
        found[0, 0], found[0, 1], found[0, 2], found[0, 3] = row[0], row[1], row[2], row[_HALF_WIDTH] ** 2
        found[1] = row[_RIVAL : _RIVAL + 4]
        found[1, 3] = found[1, 3] ** 2
        row[_RIVAL : _RIVAL + 4] = math.nan
        row[_RIVAL_CHI2] = math.inf
        for k in range(2 + mus.size * shares.size):
            p[:4] = found[1 if k == 1 else 0]
            if math.isnan(p[0]):
                continue
            p[3] = min(max(p[3], low[3]), high[3])
            p[4] = guess
            bottom[1] = max(low[1], 1e-9 * (abs(p[1]) + abs(p[2])))
            p[1] = max(p[1], bottom[1])
            if k > 1:  # the same contact with another share of slip: another drag may explain as much
                p[4] = mus[(k - 2) // shares.size]
                p[2] = min(max(shares[(k - 2) % shares.size] * p[4], -cone), cone) * p[1]
            here = _climb(
                w, table, grid, nodes, weights, cone, bottom, top, guess, prior, p, h, sums, v, rho, columns
            )  # fmt: skip
            same = _same(p, best, apart, guess)
            if here < chi2:
                if not same and chi2 < math.inf:
                    second[:], other = best, chi2
                chi2 = here
                best[:], told[:] = p, columns
            elif not same and here < other:
                second[:], other = p, here
        if other < math.inf:
            row[_RIVAL], row[_RIVAL + 1], row[_RIVAL + 2] = second[0], second[1], second[2]
            row[_RIVAL + 3], row[_RIVAL_CHI2] = math.sqrt(second[3]), other - chi2
        normal, tangential = best[1], best[2]
        force2 = normal * normal + tangential * tangential
        row[_RESIDUAL] = chi2
        if chi2 > largest + fine * force2:
            row[:_RESIDUAL] = math.nan
            row[_RIVAL:_RIVAL_CHI2] = math.nan
            row[_RIVAL_CHI2], row[_STATUS] = math.inf, lacking
            continue
        row[0], row[1], row[2], row[_HALF_WIDTH] = best[0], normal, tangential, math.sqrt(best[3])
        _derivatives(told, prior, guessed, a)
        _uncertainty(a, search, best[2:4], unit, row)
        inside = low[0] < best[0] < high[0] and abs(tangential) < cone * normal * (1.0 - 1e-9)
        inside &= not wide or (best[3] < high[3] and not 0.0 < best[3] <= low[3])
        inside &= low[1] <= 0.0 or normal > low[1]
        inside &= normal < high[1]
        c = _COVARIANCE
        nn, nt, tt = row[c + 4], row[c + 5], row[c + 7]
        turned = normal * normal * tt - 2 * normal * tangential * nt + tangential * tangential * nn
        if not inside or row[_RIVAL_CHI2] < ambiguity or not turned < force2 * force2:
            row[_STATUS] = _AMBIGUOUS
