"""Compiled: how probable each kind of contact is that a row may feel, and what all of them say of the position.

Laplace's method: chi-square, and how much of what was thought possible the readings leave. docs/locating_row.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .._check import FloatArray
from .._compiled import compiled
from .layout import BESIDE

__all__ = ["ANSWER", "Company", "weigh"]

_COLUMNS = ("position", "error", "probability", "likeliest", "status", "force_apart")
ANSWER = np.dtype((np.record, [(name, float) for name in _COLUMNS]))
"""What `weigh` says of a frame: a position [m], how probable a point is, which of the three is likeliest, a status, and
by how much the force of the other point may differ, as a standard deviation."""

_OK, _LEFT_OPEN, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _INCOMPLETE = 0.0, 0.5, 1.0, 2.0, 3.0, 4.0
_DECADES = 3.0 * math.log(10.0)
_LEANING, _STEEP, _ACROSS = 10.0, 1e3, 64
_LOG_TWO_PI = math.log(2 * math.pi)
_SMALL = 1e-100
_FAR = 100.0
_OF_SIZE = math.log(0.025)
"""What a size costs: where the readings need one they know its square to about a hundredth of what was possible."""
_OF_DRAG = int(BESIDE.square[2, 2]) - BESIDE.covariance
"""Where the variance of the drag stands among those of `BESIDE`."""


class Company(NamedTuple):
    """What the contacts have in common: a line, a point on the row, and a point beside it.

    scan [m]: how long the search of each is; beside [m]: how far beside the row a point may press; depth [m]; priors:
    logarithms of how probable each is before the touch; unknowns of each; friction; near [m]: farther off is another
    position; most: the probability that one may have; open [m]: a larger standard error leaves the position open;
    sure: chi-square by readings to spare up to which a contact is believed; settled: whether the variance of a point on
    the row does not yet count the distances beside it, as of a finger with tolerances.
    """

    scan: FloatArray
    beside: float
    depth: float
    priors: FloatArray
    unknowns: FloatArray
    friction: float
    near: float
    most: float
    open: float
    sure: FloatArray
    settled: bool


@compiled(frames="out")
def weigh(lines, on, beside, sensors, sized, ambiguity, told, out):
    """What the three tables (f,) of `LINE`, `ON_ROW` and `BESIDE` say together, into `out` (f,) of `ANSWER`.

    sensors (3, f): how many each used; sized (3, f): whether each took a size; ambiguity: a
    rival's chi-square is within it; told: a `Company`.
    """
    log, at, std, weight, square = np.empty(3), np.empty(6), np.empty(6), np.empty(6), np.empty((4, 4))
    for f in range(len(out)):
        row, line, point = out[f], lines[f], on[f]
        away = beside[f]
        statuses = (line.status, point.status, away.status)
        log[0] = _evidence(line, 0, told, square) + (_OF_SIZE if sized[0, f] else 0.0)
        log[1] = _evidence(point, 1, told, square) + (_OF_SIZE if sized[1, f] else 0.0)
        log[2] = _evidence_beside(away, told, square) + (_OF_SIZE if sized[2, f] else 0.0)
        highest = max(log[0], log[1], log[2])
        row.position = row.error = row.probability = row.likeliest = row.force_apart = math.nan
        if highest == -math.inf:
            row.status = _none(statuses)
            continue
        worse = (line.rival_chi2, point.rival_chi2, away.rival_chi2)
        variances = (line.covariance[0], point.covariance[0] + _counted_beside(point, away, told), away.covariance[0])
        where = (line.y, point.y, away.y, line.rival_y, point.rival_y, away.rival_y)
        for k in range(6):
            at[k], std[k] = where[k], math.sqrt(variances[k % 3])
        total, believed, ends, best = 0.0, 0.0, 0.0, 0
        for k in range(3):
            weight[k] = math.exp(log[k] - highest)
            weight[k + 3] = 0.0
            if at[k + 3] == at[k + 3]:
                weight[k + 3] = weight[k] * math.exp(-0.5 * worse[k])
            total += weight[k] + weight[k + 3]
            best = k if weight[k] > weight[best] else best
            left = (line.residual, point.residual, away.residual)[k]
            spare = sensors[k, f] - int(told.unknowns[k])
            believed += weight[k] if spare > 0 and left <= told.sure[spare] else 0.0
            # for another reason than a rival: a load at an end of the search, or beyond it
            ends += weight[k] if statuses[k] == _AMBIGUOUS and not worse[k] < ambiguity else 0.0
        elsewhere, near, mean, second = 0.0, 0.0, 0.0, 0.0
        for k in range(6):
            if weight[k] > 0.0:
                if abs(at[k] - at[best]) > told.near:
                    elsewhere += weight[k]
                else:
                    near += weight[k]
                    mean += weight[k] * at[k]
        mean /= near
        for k in range(6):
            if weight[k] > 0.0 and abs(at[k] - at[best]) <= told.near:
                second += weight[k] * (std[k] ** 2 + (at[k] - mean) ** 2)
        row.position, row.error = mean, math.sqrt(second / near)
        row.probability = 1.0 - (weight[0] + weight[3]) / total
        row.likeliest = best
        row.force_apart = 0.0
        if best > 0 and log[3 - best] > -math.inf:
            share = _share(point, away) if best == 1 else 1.0 - _share(point, away)
            row.force_apart = math.sqrt(share) * abs(math.hypot(away.n, away.t) - math.hypot(point.n, point.t))
        sure = elsewhere < told.most * total and ends < told.most * total and row.error < told.open
        # three contacts explain much that is none of them, though seldom well
        sure = sure and believed > 0.5 * total
        row.status = _OK if sure else _AMBIGUOUS


@compiled(inline=True)
def _share(point, away):
    """Of the point beside the row, beside the one on it, by chi-square alone: as if its distance had been stated."""
    return 1.0 / (1.0 + math.exp(0.5 * min(max(away.residual - point.residual, -_FAR), _FAR)))


@compiled(inline=True)
def _counted_beside(point, away, told):
    """What the best point beside the row adds to the variance of one on it, by chi-square alone."""
    if not told.settled or not away.status <= _AMBIGUOUS:
        return 0.0
    return _share(point, away) * ((away.y - point.y) ** 2 + away.covariance[0])


@compiled(inline=True)
def _none(statuses):
    """The status where no contact explains a frame."""
    line, point, away = statuses
    if line == _INCOMPLETE or point == _INCOMPLETE or away == _INCOMPLETE:
        return _INCOMPLETE
    return _NO_CONTACT if line == _NO_CONTACT or point == _NO_CONTACT or away == _NO_CONTACT else _UNEXPLAINED


@compiled(inline=True)
def _evidence(row, kind, told, square):
    """Logarithm of the probability of the readings, of a line or of a point on the row; -inf: it explains nothing."""
    if not (row.status == _OK or row.status == _AMBIGUOUS):
        return -math.inf
    force = max(math.hypot(row.n, row.t), _SMALL)
    scan, drags, c = told.scan[kind], 2.0 * min(told.friction, _LEANING) * force, row.covariance
    sizes = (scan, force * _DECADES, drags)
    count = 3 if told.friction > 0.0 else 2
    k = 0
    for i in range(3):
        for j in range(i, 3):
            if j < count:
                square[i, j] = square[j, i] = c[k] / (sizes[i] * sizes[j])
            k += 1
    return told.priors[kind] + _laplace(row.residual, square, count)


@compiled(inline=True)
def _evidence_beside(row, told, square):
    """The same of a point beside the row."""
    if not (row.status == _OK or row.status == _LEFT_OPEN or row.status == _AMBIGUOUS):
        return -math.inf
    force = max(math.hypot(row.n, row.t), _SMALL)
    c, mu = row.covariance, told.friction
    drags = _leant(row, told) if mu > 0.0 else 1.0
    sizes, kept = (told.scan[2], force * _DECADES, drags, told.beside), (0, 1, 2, 3)
    count = 4
    if mu == 0.0:
        sizes, kept, count = (told.scan[2], force * _DECADES, told.beside, 1.0), (0, 1, 3, 0), 3
    for i in range(count):
        for j in range(i, count):
            a, b = kept[i], kept[j]
            # where (a, b) stands in the upper triangle
            value = c[a * 4 - a * (a - 1) // 2 + b - a]
            if a == 1 and b == 1:  # what a drag across the row leaves open is no matter of the readings
                spread = max(row.half_width, row.high) if row.high == row.high else row.half_width
                value -= (min(mu, _STEEP) * spread / told.depth * row.n) ** 2 / 3
            square[i, j] = square[j, i] = value / (sizes[i] * sizes[j])
    return told.priors[2] + _laplace(row.residual, square, count)


@compiled()
def _leant(row, told):
    """The range in which the drag of a point would be as likely everywhere as it is where it was found [N].

    Of all drags in the cone, (ty, tz) N, each as likely, the row reads T / A = ty / (1 - tz |z| / depth) and
    A = N (1 - tz |z| / depth). The best within two standard errors counts.
    """
    mu = min(told.friction, _LEANING)
    a = max(abs(row.n), _SMALL)
    ratio = max(abs(row.t) - 2 * math.sqrt(row.covariance[_OF_DRAG]), 0.0) / a
    best = 0.0
    for side in range(2):
        z, held = row.half_width if side == 0 else row.high, 0.0
        for k in range(_ACROSS):
            tz = mu * (k + 0.5) * 2 / _ACROSS - mu
            rest = max(1 - tz * z / told.depth, 0.0)
            if (ratio * rest) ** 2 + tz * tz <= mu * mu:
                held += rest
        best = max(best, held * (2 * mu / _ACROSS) / (math.pi * mu * mu))
    return a / max(best, _SMALL)


@compiled()
def _laplace(residual, square, count):
    """By chi-square and a covariance (count, count) in units of what was possible, whose own variance is 1/12."""
    known = _log_det(square, count, 12.0, 1.0) - _log_det(square, count, 1.0, 0.0)
    value = -0.5 * (residual + known - count * _LOG_TWO_PI)
    return value if value == value else -math.inf


@compiled()
def _log_det(square, count, times, more):
    """Of times * square + more, by Cholesky; NaN where it is not positive."""
    root, total = np.empty((4, 4)), 0.0
    for i in range(count):
        for j in range(i + 1):
            value = times * square[i, j] + (more if i == j else 0.0)
            for k in range(j):
                value -= root[i, k] * root[j, k]
            if i == j:
                if not 0.0 < value < math.inf:
                    return math.nan
                root[i, i] = math.sqrt(value)
                total += 2.0 * math.log(root[i, i])
            else:
                root[i, j] = value / root[j, j]
    return total
