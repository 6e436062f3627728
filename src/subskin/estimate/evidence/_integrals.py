"""Integrals over a contact's unknowns, compiled: of a Gaussian with edges, and by sums over a grid."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._check import FloatArray
from ..._compiled import compiled
from ..kinds import Across, Wide, climb_wide, project_wide, until, wide_information, wide_slopes
from ..varpro import Limits

REACH = 5.0
"""Standard deviations up to which widths about a peak count."""
NEGLIGIBLE = 40.0
"""Logarithms of the odds that count as none."""
LOG_2PI = math.log(2 * math.pi)
SAME = 0.05
"""Steps of the table within which two climbs have come to one position."""
_T, _W = np.polynomial.legendre.leggauss(10)
_FINE = 1e-7
"""What the last step of a climb may gain."""
_MORE = 1.0 + 1e-12
"""What the readings say nothing of is infinite within rounding, not an error."""
_FIRST, _LAST, LEAST, MOST = range(4)
"""Ends of y, and of q."""


class Sought(NamedTuple):
    """What the sensors read of a kind of contact, its cone, and ends (4,) of y and of q, its half width squared."""

    model: Wide
    limits: Limits
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


class Gaussian(NamedTuple):
    """Of d unknowns the information (d, d) and slope (d,), then covariance and mean; edge, pull (d,): scratch."""

    info: FloatArray
    slope: FloatArray
    cov: FloatArray
    mean: FloatArray
    edge: FloatArray
    pull: FloatArray


class Valleys(NamedTuple):
    """Scratch, of each peak: the widths (least, most) that count about it, where its valley goes, and where it went.

    ends (4,): as of `Sought`, at one width; of (y, N, T): a Gaussian.
    """

    spans: FloatArray
    begin: FloatArray
    found: FloatArray
    ends: FloatArray
    gauss: Gaussian


@compiled(inline=True)
def gaussian(size):
    """Room for a Gaussian."""
    return Gaussian(
        np.zeros((size, size)), np.zeros(size), np.zeros((size, size)), np.zeros(size), np.zeros(size), np.zeros(size)
    )


@compiled(inline=True)
def climbed(w, sought, ends, y, q, fit, trial):
    """Climb from (y, q) within `ends` into `fit`."""
    climb_wide(w, sought.model, sought.limits, ends, Across(y, q), until(_FINE), fit, trial)


@compiled(inline=True)
def fitted(w, sought, y, q, fit):
    """The best forces at (y, q) into `fit`; gives how S / 2 is curved in y and, along its valley, in q."""
    project_wide(w, sought.model, sought.limits, Across(y, q), fit)
    wide_slopes(w, sought.model, fit)
    told = wide_information(fit)
    return told.y_y, max(told.q_q - told.y_q * told.y_q / max(told.y_y, 1e-300), 1e-300)


@compiled()
def log_below(x):
    """Log of the probability that a standard normal variable is below x."""
    if x > -5.0:
        return math.log(0.5 * math.erfc(-x * 0.7071067811865476))
    square = 1.0 / (x * x)
    return -0.5 * x * x - math.log(-x) - 0.5 * LOG_2PI + math.log1p(-square * (1.0 - 3.0 * square))


@compiled(borrows=True)
def settled(gauss):
    """Log of the integral of exp(slope.x - x.info x / 2), whose mean and covariance are filled in; by Cholesky."""
    info, slope, cov, mean = gauss.info, gauss.slope, gauss.cov, gauss.mean
    size, log = slope.size, 0.5 * slope.size * LOG_2PI
    for i in range(size):
        for j in range(i + 1):
            v = info[i, j]
            for k in range(j):
                v -= info[i, k] * info[j, k]
            if i == j:
                info[i, i] = math.sqrt(max(v, 1e-300))
                log -= math.log(info[i, i])
            else:
                info[i, j] = v / info[j, j]
    for c in range(size):  # a column of the inverse, by two triangles
        for r in range(c, size):
            v = 1.0 if r == c else 0.0
            for k in range(c, r):
                v -= info[r, k] * cov[c, k]
            cov[c, r] = v / info[r, r]
        for r in range(size - 1, c - 1, -1):
            v = cov[c, r]
            for k in range(r + 1, size):
                v -= info[k, r] * cov[c, k]
            cov[c, r] = cov[r, c] = v / info[r, r]
    for i in range(size):
        mean[i] = 0.0
        for j in range(size):
            mean[i] += cov[i, j] * slope[j]
        log += 0.5 * slope[i] * mean[i]
    return log


@compiled(borrows=True)
def cut(gauss, offset):
    """Log of the share of a Gaussian where edge.x + offset > 0; mean and covariance become those of that share."""
    cov, mean, edge, v = gauss.cov, gauss.mean, gauss.edge, gauss.pull
    at, square, size = offset, 0.0, mean.size
    for i in range(size):
        v[i] = 0.0
        for j in range(size):
            v[i] += cov[i, j] * edge[j]
        at += edge[i] * mean[i]
        square += edge[i] * v[i]
    spread = math.sqrt(max(square, 1e-300))
    z = at / spread
    if z > 6.0:
        return 0.0
    share = log_below(z)
    pull = math.exp(-0.5 * z * z - 0.5 * LOG_2PI - share)
    for i in range(size):
        mean[i] += v[i] * pull / spread
        for j in range(size):
            cov[i, j] -= v[i] * v[j] * pull * (pull + z) / (spread * spread)
    return share


@compiled(inline=True)
def _edged(gauss, y, n, t, offset):
    """The same with the edge (y, n, t)."""
    gauss.edge[0], gauss.edge[1], gauss.edge[2] = y, n, t
    return cut(gauss, offset)


@compiled(borrows=True)
def log_weight(w, sought, fit, gauss):
    """Log of the integral over positions and forces about (y, N, T), the fit being that of `fitted` there.

    The integrand is Gaussian but for its edges, the cone's and the search's; each is taken in turn, and what it leaves
    is again replaced by the Gaussian of the same mean and covariance.
    """
    rows, mu, info, slope = sought.model.rows, sought.limits.friction, gauss.info, gauss.slope
    n, t = fit.n, fit.t
    slope[0], slope[1], slope[2] = fit.by_y, 0.0, 0.0
    for i in range(w.size):
        rho = w[i] - rows[0, i] * n - rows[1, i] * t
        slope[1] += rows[0, i] * rho
        slope[2] += rows[1, i] * rho
    info[0, 0], info[1, 0], info[2, 0] = _MORE * fit.u_y_y, fit.a_y_n, fit.a_y_t
    info[1, 1], info[2, 1], info[2, 2] = _MORE * fit.g_n_n, fit.g_n_t, _MORE * fit.g_t_t
    if mu == 0.0:  # no drag: one unknown less, which is kept out of the way
        slope[2] = info[2, 0] = info[2, 1] = 0.0
        info[2, 2] = 2.0 * math.pi
    out = 0.5 * fit.explained + settled(gauss)
    gauss.mean[0] += fit.y
    gauss.mean[1] += n
    gauss.mean[2] += t
    # equally probable in the logarithm of the magnitude and in the angle: 1 / P^2 in the plane of (N, T)
    out -= (2.0 if mu > 0.0 else 1.0) * math.log(max(math.hypot(n, t), 1e-300))
    if 0.0 < mu < math.inf:
        out += _edged(gauss, 0.0, mu, -1.0, 0.0) + _edged(gauss, 0.0, mu, 1.0, 0.0)
    else:
        out += _edged(gauss, 0.0, 1.0, 0.0, 0.0)
    return out + _edged(gauss, 1.0, 0.0, 0.0, -sought.ends[_FIRST]) + _edged(gauss, -1.0, 0.0, 0.0, sought.ends[_LAST])


@compiled()
def interval(gradient, curvature, q, low, high):
    """Where along the valley the integrand is within exp(-REACH^2 / 2) of its height at q."""
    fall = 0.5 * REACH * REACH
    reach = (math.sqrt(gradient * gradient + 2.0 * fall * curvature) + abs(gradient)) / max(curvature, 1e-300)
    toward = 2.0 * fall / (math.sqrt(gradient * gradient + 2.0 * fall * curvature) + abs(gradient))
    up, down = (reach, toward) if gradient > 0.0 else (toward, reach)
    return max(q - down, low), min(q + up, high)


@compiled(borrows=True)
def broad(w, sought, fit, survey):
    """Whether position and width are known no closer than the survey's grid tells, at the peak `fit`.

    Sums over a grid of step h are exact to 2 exp(-2 pi^2 / (h / spread)^2): 3e-3 at spread = 0.57 h.
    """
    q, least, most = fit.q, sought.ends[LEAST], sought.ends[MOST]
    told, curvature = fitted(w, sought, fit.y, q, fit)
    if not told * (0.57 * survey.step) ** 2 < 1.0:
        return False
    if not most > least:
        return True
    low, high = interval(0.0 if least < q < most else fit.by_q, curvature, q, -math.inf, math.inf)
    nearest = (q - low if q >= most else high - q) / REACH  # a spread, of the side that is in the range
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
            if near < explained - 2.0 * NEGLIGIBLE:
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
                if here < -NEGLIGIBLE:
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
                        shift = math.exp(-0.5 * z * z - 0.5 * LOG_2PI - share) / spread
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
def valley(w, sought, fit, gauss):
    """Log of the evidence about the peak `fit`, the valley along the widths being a parabola about its top."""
    least, most, q = sought.ends[LEAST], sought.ends[MOST], fit.q
    _, curvature = fitted(w, sought, fit.y, q, fit)
    slope = 0.0 if least < q < most else fit.by_q
    low, high = interval(slope, curvature, q, least, most)
    one, two = math.sqrt(low), math.sqrt(high)
    total = 0.0
    for k in range(_T.size):
        half = 0.5 * (one + two + (two - one) * _T[k])
        move = half * half - q
        total += 0.5 * (two - one) * _W[k] * math.exp(slope * move - 0.5 * curvature * move * move)
    share = math.log(max(total, 1e-300) / (math.sqrt(most) - math.sqrt(least)))
    return log_weight(w, sought, fit, gauss) + share


@compiled(borrows=True)
def over_widths(w, sought, fits, spare, room):
    """Log of the evidence about the peaks `fits`, each width being fitted anew; without what all kinds have in common.

    spare (2,): fits for scratch; room: `Valleys`.
    """
    least, most, spans, gauss, count = sought.ends[LEAST], sought.ends[MOST], room.spans, room.gauss, fits.size
    total = -math.inf
    prior = -math.log(math.sqrt(most) - math.sqrt(least)) if most > least else 0.0  # all widths as probable
    for p in range(count):
        fit = fits[p]
        q = spans[p, 0] = spans[p, 1] = fit.q
        _, curvature = fitted(w, sought, fit.y, q, fit)
        if not most > least:
            total = add(total, log_weight(w, sought, fit, gauss))
            continue
        spans[p, 0], spans[p, 1] = interval(0.0 if least < q < most else fit.by_q, curvature, q, least, most)
        half = math.sqrt(q)
        spread = 1.0 / math.sqrt(curvature) / max(2.0 * half, 1e-300)
        apart = True
        for e in range(count):
            apart &= e == p or abs(fits[e].q - q) > 4.0 * REACH / math.sqrt(curvature)
        if apart and least < spans[p, 0] and spans[p, 1] < most and spread < 0.01 * half:
            total = add(total, log_weight(w, sought, fit, gauss) + 0.5 * LOG_2PI + math.log(spread) + prior)
            spans[p, 1] = -1.0  # done
    if not most > least:
        return total
    for p in range(count):
        if spans[p, 1] >= 0.0:
            first, last, members = _stretch(p, fits, room)
            total = add(total, prior + _along(w, sought, math.sqrt(first), math.sqrt(last), members, spare, room))
    return total


@compiled(borrows=True)
def _stretch(p, fits, room):
    """The widths that the spans overlapping that of peak p cover, and how many they are; these begin there."""
    spans, count = room.spans, fits.size
    first, last, grown, members = spans[p, 0], spans[p, 1], True, 0
    while grown:
        grown = False
        for e in range(count):
            if spans[e, 1] >= first and spans[e, 0] <= last and (spans[e, 0] < first or spans[e, 1] > last):
                first, last, grown = min(first, spans[e, 0]), max(last, spans[e, 1]), True
    for e in range(count):
        if spans[e, 1] >= first and spans[e, 0] <= last:
            room.begin[members] = fits[e].y
            members += 1
            spans[e, 1] = -1.0
    return first, last, members


@compiled(borrows=True)
def _along(w, sought, one, two, members, spare, room):
    """Log of the integral over half widths from `one` to `two`, along which each member's valley is followed."""
    ends, found, total, fit = room.ends, room.found, -math.inf, spare[0]
    ends[_FIRST], ends[_LAST] = sought.ends[_FIRST], sought.ends[_LAST]
    for k in range(_T.size):
        half = 0.5 * (one + two + (two - one) * _T[k])
        q = ends[LEAST] = ends[MOST] = half * half
        share = math.log(0.5 * (two - one) * _W[k])
        for e in range(members):
            climbed(w, sought, ends, room.begin[e], q, fit, spare[1])
            room.begin[e] = found[e] = fit.y
            new = True
            for d in range(e):
                new &= abs(found[d] - fit.y) > SAME * sought.model.step
            if new:
                fitted(w, sought, fit.y, q, fit)
                total = add(total, log_weight(w, sought, fit, room.gauss) + share)
    return total


@compiled()
def add(x, y):
    """log(exp(x) + exp(y))."""
    high, low = max(x, y), min(x, y)
    return high if low == -math.inf else high + math.log1p(math.exp(low - high))
