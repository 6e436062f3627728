"""Integrals over a contact's unknowns, compiled: of a Gaussian with edges, and by sums over a grid."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._check import FloatArray
from ..._compiled import compiled
from ..climb import climb_wide, project_wide, slopes

_REACH = 5.0
_NEGLIGIBLE = 40.0
_LOG_2PI = math.log(2 * math.pi)
_T, _W = np.polynomial.legendre.leggauss(10)

N, T, S = 0, 1, 2
"""What a fit begins with: the forces, and the chi-square that they explain."""


class KindField(NamedTuple):
    """What the sensors read of one family of contacts, and where such a contact may be.

    table, start, step, square: as of `project_wide`; ends (4,): of y, and of q, the square of the half width.
    """

    table: FloatArray
    start: float
    step: float
    square: float
    ends: FloatArray


class Survey(NamedTuple):
    """A fine grid of positions and widths, which has some steps to each of the scan's.

    fine (n, 2, r, m): A on it; nodes (4, r, m): the inverse of A^T A and log(2 pi) less half the log of its
    determinant; rows (3, r): half width, its square, weight; step: of the positions.
    """

    fine: FloatArray
    nodes: FloatArray
    rows: FloatArray
    step: float


class WeighingRoom(NamedTuple):
    """Scratch: a (2, 6, 2 n) and c as of `climb_wide`, a fit, the matrix and mean of a Gaussian, and of each peak.

    Of each peak where it is first seen, how high it is there, the widths (least, most) that count about it, where its
    valley goes at a width, and where it went; ends (4,) at that width.
    """

    a: FloatArray
    c: FloatArray
    fit: FloatArray
    info: FloatArray
    mean: FloatArray
    first: FloatArray
    score: FloatArray
    spans: FloatArray
    begin: FloatArray
    found: FloatArray
    ends: FloatArray


@compiled(inline=True)
def climbed(w, field, mu, y, q, ends, room):
    """Where the climb from (y, q) within `ends` comes to; its fit is the room's."""
    return climb_wide(
        w, field.table, field.start, field.step, field.square, mu, y, q, ends, room.c, room.a, room.fit, 0.0, math.inf
    )


@compiled(inline=True)
def projected(w, field, mu, y, q, room, fit):
    """The best forces at (y, q) into `fit`; the field there is the room's."""
    project_wide(w, field.table, field.start, field.step, field.square, mu, y, q, room.c, room.a[0], fit, 0.0, math.inf)


@compiled()
def log_below(x):
    """Log of the probability that a standard normal variable is below x."""
    if x > -5.0:
        return math.log(0.5 * math.erfc(-x * 0.7071067811865476))
    square = 1.0 / (x * x)
    return -0.5 * x * x - math.log(-x) - 0.5 * _LOG_2PI + math.log1p(-square * (1.0 - 3.0 * square))


@compiled(borrows=True)
def log_weight(w, fit, mu, y, ends, a, info, mean):
    """Log of the integral over positions and forces about (y, N, T), the fit being that of `projected` there.

    The integrand is Gaussian but for its edges, the cone's and the search's; each is taken in turn, and what it leaves
    is again replaced by the Gaussian of the same mean and covariance. a: the field there; info (3, 3), mean (3,):
    scratch.
    """
    n = w.size
    normal, tangential = fit[N], fit[T]
    size = math.hypot(normal, tangential)
    g0 = g1 = g2 = 0.0
    info[:] = 0.0
    for i in range(n):
        an, at = a[0, i], a[0, n + i]
        u = a[1, i] * normal + a[1, n + i] * tangential
        rho = w[i] - an * normal - at * tangential
        g0 += u * rho
        g1 += an * rho
        g2 += at * rho
        info[0, 0] += u * u
        info[0, 1] += u * an
        info[0, 2] += u * at
        info[1, 1] += an * an
        info[1, 2] += an * at
        info[2, 2] += at * at
    if mu == 0.0:  # no drag: one unknown less, which is kept out of the way
        g2 = info[0, 2] = info[1, 2] = 0.0
        info[2, 2] = 1.0
    det = _invert(info)
    mean[0] = info[0, 0] * g0 + info[0, 1] * g1 + info[0, 2] * g2
    mean[1] = info[1, 0] * g0 + info[1, 1] * g1 + info[1, 2] * g2
    mean[2] = info[2, 0] * g0 + info[2, 1] * g1 + info[2, 2] * g2
    out = 0.5 * (fit[S] + g0 * mean[0] + g1 * mean[1] + g2 * mean[2] + _LOG_2PI - math.log(det))
    out += _LOG_2PI if mu > 0.0 else 0.5 * _LOG_2PI
    mean[0] += y
    mean[1] += normal
    mean[2] += tangential
    # equally probable in the logarithm of the magnitude and in the angle: 1 / P^2 in the plane of (N, T)
    out -= (2.0 if mu > 0.0 else 1.0) * math.log(max(size, 1e-300))
    e1, e2 = (mu, 1.0) if 0.0 < mu < math.inf else (1.0, 0.0)
    out += _cut(info, mean, 0.0, e1, -e2, 0.0)
    if 0.0 < mu < math.inf:
        out += _cut(info, mean, 0.0, e1, e2, 0.0)
    out += _cut(info, mean, 1.0, 0.0, 0.0, -ends[0])
    return out + _cut(info, mean, -1.0, 0.0, 0.0, ends[1])


@compiled(borrows=True)
def _invert(m):
    """Invert a symmetric 3 x 3 matrix given by its upper half, in place; returns its determinant."""
    a, b, c, d, e, f = m[0, 0], m[0, 1], m[0, 2], m[1, 1], m[1, 2], m[2, 2]
    # what the readings say nothing of is infinite within rounding, not an error
    a, d, f = a * (1.0 + 1e-12) + 1e-300, d * (1.0 + 1e-12) + 1e-300, f * (1.0 + 1e-12) + 1e-300
    x, y, z = d * f - e * e, c * e - b * f, b * e - c * d
    det = max(a * x + b * y + c * z, 1e-300)
    m[0, 0], m[0, 1], m[0, 2] = x / det, y / det, z / det
    m[1, 1], m[1, 2], m[2, 2] = (a * f - c * c) / det, (b * c - a * e) / det, (a * d - b * b) / det
    m[1, 0], m[2, 0], m[2, 1] = m[0, 1], m[0, 2], m[1, 2]
    return det


@compiled(borrows=True)
def _cut(cov, mean, c0, c1, c2, offset):
    """Log of the share of a Gaussian where c x + offset > 0; mean and covariance become those of that share."""
    v0 = cov[0, 0] * c0 + cov[0, 1] * c1 + cov[0, 2] * c2
    v1 = cov[1, 0] * c0 + cov[1, 1] * c1 + cov[1, 2] * c2
    v2 = cov[2, 0] * c0 + cov[2, 1] * c1 + cov[2, 2] * c2
    spread = math.sqrt(max(c0 * v0 + c1 * v1 + c2 * v2, 1e-300))
    z = (c0 * mean[0] + c1 * mean[1] + c2 * mean[2] + offset) / spread
    if z > 6.0:
        return 0.0
    share = log_below(z)
    pull = math.exp(-0.5 * z * z - 0.5 * _LOG_2PI - share)
    narrow = pull * (pull + z) / (spread * spread)
    shift = pull / spread
    v = (v0, v1, v2)
    for i in range(3):
        mean[i] += v[i] * shift
        for j in range(3):
            cov[i, j] -= v[i] * v[j] * narrow
    return share


@compiled()
def interval(gradient, curvature, q, low, high):
    """Where along the valley the integrand is within exp(-_REACH^2 / 2) of its height at q."""
    fall = 0.5 * _REACH * _REACH
    reach = (math.sqrt(gradient * gradient + 2.0 * fall * curvature) + abs(gradient)) / max(curvature, 1e-300)
    toward = 2.0 * fall / (math.sqrt(gradient * gradient + 2.0 * fall * curvature) + abs(gradient))
    up, down = (reach, toward) if gradient > 0.0 else (toward, reach)
    return max(q - down, low), min(q + up, high)


@compiled(borrows=True)
def broad(w, field, mu, at, fit, survey, room):
    """Whether position and width are known no closer than the survey's grid tells, at the peak `at`.

    Sums over a grid of step h are exact to 2 exp(-2 pi^2 / (h / spread)^2): 3e-3 at spread = 0.57 h.
    """
    y, q, ends = at[0], at[1], field.ends
    projected(w, field, mu, y, q, room, fit)
    _, gq, yy, yq, qq, _, _, _ = slopes(w, room.a[0], fit)
    if not yy * (0.57 * survey.step) ** 2 < 1.0:
        return False
    if not ends[3] > ends[2]:
        return True
    curvature = max(qq - yq * yq / yy, 1e-300)
    inside = ends[2] < q < ends[3]
    low, high = interval(0.0 if inside else gq, curvature, q, -math.inf, math.inf)
    nearest = (q - low if q >= ends[3] else high - q) / _REACH  # a spread, of the side that is in the range
    return nearest > 2.0 * math.sqrt(q) * 0.57 * (survey.rows[0, 1] - survey.rows[0, 0])


@compiled(borrows=True)
def surveyed(w, scan, squares, explained, mu, survey):
    """Log of the evidence by sums over a fine grid of positions and widths, where known no closer than its steps."""
    fine, nodes, rows = survey.fine, survey.nodes, survey.rows
    n, _, count, m = fine.shape
    steps = (m - 1) // (scan.shape[1] - 1)
    total, highest = 0.0, -math.inf
    for j in range(count):
        below = 0
        while below + 2 < squares.size and squares[below + 1] < rows[1, j]:
            below += 1
        above = min(below + 1, squares.size - 1)
        for cell in range(scan.shape[1] - 1):
            near = max(scan[below, cell], scan[below, cell + 1], scan[above, cell], scan[above, cell + 1])
            if near < explained - 2.0 * _NEGLIGIBLE:
                continue
            last = steps + (cell == scan.shape[1] - 2)  # a cell has its left end; the last cell has both
            for k in range(cell * steps, cell * steps + last):
                b1 = b2 = 0.0
                for i in range(n):
                    b1 += fine[i, 0, j, k] * w[i]
                    b2 += fine[i, 1, j, k] * w[i]
                i11, i12, i22 = nodes[0, j, k], nodes[1, j, k], nodes[2, j, k]
                normal, tangential = i11 * b1 + i12 * b2, i12 * b1 + i22 * b2
                here = 0.5 * (b1 * normal + b2 * tangential - explained)
                if here < -_NEGLIGIBLE:
                    continue
                here += nodes[3, j, k]
                for side in range(2):
                    e1, e2 = (mu, 1.0 - 2.0 * side) if 0.0 < mu < math.inf else (1.0, 0.0)
                    v1, v2 = i11 * e1 + i12 * e2, i12 * e1 + i22 * e2
                    spread = math.sqrt(e1 * v1 + e2 * v2)
                    z = (e1 * normal + e2 * tangential) / spread
                    if z < 6.0:
                        share = log_below(z)
                        here += share
                        shift = math.exp(-0.5 * z * z - 0.5 * _LOG_2PI - share) / spread
                        normal, tangential = normal + v1 * shift, tangential + v2 * shift
                    if e2 == 0.0:
                        break
                size = max(normal * normal + tangential * tangential, 1e-300)
                here -= math.log(size) if mu > 0.0 else 0.5 * math.log(size)
                weight = rows[2, j] * (0.5 if k == 0 or k == m - 1 else 1.0)
                if here > highest:
                    total *= math.exp(highest - here)
                    highest = here
                total += weight * math.exp(here - highest)
    return math.log(survey.step * total) + highest + 0.5 * explained if total > 0.0 else -math.inf


@compiled(borrows=True)
def valley(w, field, mu, at, room):
    """Log of the evidence about the peak `at`, the valley along the widths being taken for the parabola at its top."""
    y, q, ends, fit = at[0], at[1], field.ends, room.fit
    projected(w, field, mu, y, q, room, fit)
    _, gq, yy, yq, qq, _, _, _ = slopes(w, room.a[0], fit)
    curvature = max(qq - yq * yq / max(yy, 1e-300), 1e-300)
    slope = 0.0 if ends[2] < q < ends[3] else gq
    low, high = interval(slope, curvature, q, ends[2], ends[3])
    one, two = math.sqrt(low), math.sqrt(high)
    total = 0.0
    for k in range(_T.size):
        half = 0.5 * (one + two + (two - one) * _T[k])
        move = half * half - q
        total += 0.5 * (two - one) * _W[k] * math.exp(slope * move - 0.5 * curvature * move * move)
    share = math.log(max(total, 1e-300) / (math.sqrt(ends[3]) - math.sqrt(ends[2])))
    return log_weight(w, fit, mu, y, ends, room.a[0], room.info, room.mean) + share


@compiled()
def add(x, y):
    """log(exp(x) + exp(y))."""
    high, low = max(x, y), min(x, y)
    return high if low == -math.inf else high + math.log1p(math.exp(low - high))
