"""Compiled: the load that explains a frame by a response measured in place, whose doubt is weighed with the noise."""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..layout import AREA
from .climb import FIT, _curvature
from .cone import eliminate
from .judge import covariance, widest_variance

_MOST, _STEPS, _SWEEPS = 8, 25, 3
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_FORCES, _RESIDUAL, _RIVAL = AREA.components, AREA.residual, AREA.rival
_RIVAL_CHI2, _STATUS = AREA.rival_chi2, AREA.status


@compiled()
def _eliminated(g, b, mu, low, high, fit):
    """The best admissible components into fit; S of these. `low` and `high` bound N of a load that has no drag."""
    eliminate(g[0], g[1], g[2], g[3], g[4], g[5], b[0], b[1], b[2], mu, fit)
    if mu == 0.0 and g[0] > 0.0 and not low <= fit[0] <= high:
        fit[0] = min(max(b[0] / g[0], low), high)
        fit[3], fit[4] = fit[0] * (2.0 * b[0] - g[0] * fit[0]), 0.0


@compiled()
def _doubt(variance, i, load):
    """Variance of the mixed reading i: 1 of the noise and, of a `load` (3,), the doubt of the response (n, c)."""
    v = 1.0
    for j in range(variance.shape[1]):
        v += load[j] * load[j] * variance[i, j]
    return v


@compiled()
def _cost(r, common, values, variance, load, mu, low, high, g, b, fit):
    """Chi-square left of a frame r (n,) at a node; the components into fit.

    The errors' covariance is that of the independent ones and `common` (n,) times its transpose, by whose part
    everything is less (Sherman and Morrison).
    """
    for k in range(6):
        g[k] = 0.0
    b[0] = b[1] = b[2] = 0.0
    out, size, along = 0.0, 1.0, 0.0
    s0 = s1 = s2 = 0.0
    for i in range(r.size):
        v = _doubt(variance, i, load)
        w, a0 = 1.0 / v, values[i, 0]
        wc = w * common[i]
        size += wc * common[i]
        along += wc * r[i]
        s0 += wc * a0
        g[0] += w * a0 * a0
        b[0] += w * a0 * r[i]
        if values.shape[1] == 3:
            a1, a2 = values[i, 1], values[i, 2]
            g[1] += w * a0 * a1
            g[2] += w * a0 * a2
            g[3] += w * a1 * a1
            g[4] += w * a1 * a2
            g[5] += w * a2 * a2
            b[1] += w * a1 * r[i]
            b[2] += w * a2 * r[i]
            s1 += wc * a1
            s2 += wc * a2
        out += w * r[i] * r[i]
    out -= along * along / size
    b[0] -= along * s0 / size
    b[1] -= along * s1 / size
    b[2] -= along * s2 / size
    g[0] -= s0 * s0 / size
    g[1] -= s0 * s1 / size
    g[2] -= s0 * s2 / size
    g[3] -= s1 * s1 / size
    g[4] -= s1 * s2 / size
    g[5] -= s2 * s2 / size
    _eliminated(g, b, mu, low, high, fit)
    return out - fit[3]


@compiled(inline=True)
def _at(p, size):
    """The second of four nodes about p, and how far from it."""
    second = min(max(int(p), 1), size - 3)
    return second, p - second


@compiled(inline=True)
def _cubic(t):
    """Weights of four nodes at -1, 0, 1, 2 (Lagrange), and their slopes."""
    return (
        (
            -t * (t - 1.0) * (t - 2.0) / 6.0,
            0.5 * (t * t - 1.0) * (t - 2.0),
            -0.5 * t * (t + 1.0) * (t - 2.0),
            t * (t * t - 1.0) / 6.0,
        ),
        (
            -(3.0 * t * t - 6.0 * t + 2.0) / 6.0,
            0.5 * (3.0 * t * t - 4.0 * t - 1.0),
            -0.5 * (3.0 * t * t - 2.0 * t - 2.0),
            (3.0 * t * t - 1.0) / 6.0,
        ),
    )


@compiled()
def _between(table, p, q, out):
    """Values of a table (k, l, n, c) between its nodes, and their slopes a node: out (3, n, c), by cubics."""
    j, s = _at(p, table.shape[0])
    k, t = _at(q, table.shape[1])
    a, da = _cubic(s)
    b, db = _cubic(t)
    out[:] = 0.0
    for e in range(4):
        for f in range(4):
            u, v, w = a[e] * b[f], da[e] * b[f], a[e] * db[f]
            for i in range(table.shape[2]):
                for c in range(table.shape[3]):
                    x = table[j + e - 1, k + f - 1, i, c]
                    out[0, i, c] += u * x
                    out[1, i, c] += v * x
                    out[2, i, c] += w * x


@compiled()
def _settle(r, common, values, variance, mu, low, high, p, q, load, fit, g, b, here, doubt):
    """From node (p, q) to the best position, where it ends in fit[29], fit[30], in nodes; fit is that of `climb.py`.

    Gauss-Newton steps; the doubt changes with the position too. A step that worsens it is halved. The likelihood would
    have the logarithm of the variances as well: it draws loads to where touches have been, and is left out. Returns the
    chi-square left.
    """
    last = math.inf
    step_p = step_q = 0.0
    top_p, top_q = values.shape[0] - 1.0, values.shape[1] - 1.0
    for _ in range(_STEPS):
        _between(values, p, q, here)
        _between(variance, p, q, doubt)
        for i in range(r.size):
            for c in range(values.shape[3]):
                doubt[0, i, c] = max(doubt[0, i, c], 0.0)
        cost = _cost(r, common, here[0], doubt[0], load, mu, low, high, g, b, fit)
        if cost > last + 1e-9 and abs(step_p) + abs(step_q) > 1e-6:
            p, q, step_p, step_q = p - 0.5 * step_p, q - 0.5 * step_q, 0.5 * step_p, 0.5 * step_q
            continue
        done = last - cost < 1e-4
        last = cost
        for k in range(17, 29):
            fit[k] = 0.0
        gp = gq = 0.0
        size, level, cp, cq = 1.0, 0.0, 0.0, 0.0
        for i in range(r.size):
            rest = r[i]
            for c in range(values.shape[3]):
                rest -= fit[c] * here[0, i, c]
            wc = common[i] / _doubt(doubt[0], i, load)
            size += wc * common[i]
            level += wc * rest
        level /= size  # the likeliest error in common
        fit[17] = level * level
        for c in range(3):
            b[c] = 0.0
        for i in range(r.size):
            v = _doubt(doubt[0], i, load)
            rest, dv, dw = r[i] - level * common[i], 0.0, 0.0
            up = uq = 0.0
            for c in range(values.shape[3]):
                rest -= fit[c] * here[0, i, c]
                up += fit[c] * here[1, i, c]
                uq += fit[c] * here[2, i, c]
                dv += load[c] * load[c] * doubt[1, i, c]
                dw += load[c] * load[c] * doubt[2, i, c]
            more = -0.5 * rest * rest / (v * v)
            gp += rest * up / v - more * dv
            gq += rest * uq / v - more * dw
            fit[17] += rest * rest / v
            fit[20] += up * up / v
            fit[21] += up * uq / v
            fit[22] += uq * uq / v
            cp += common[i] * up / v
            cq += common[i] * uq / v
            for c in range(values.shape[3]):
                fit[23 + c] += here[0, i, c] * up / v
                fit[26 + c] += here[0, i, c] * uq / v
                b[c] += common[i] * here[0, i, c] / v
        fit[20] -= cp * cp / size
        fit[21] -= cp * cq / size
        fit[22] -= cq * cq / size
        for c in range(values.shape[3]):
            fit[23 + c] -= b[c] * cp / size
            fit[26 + c] -= b[c] * cq / size
        for k in range(6):
            fit[11 + k] = g[k]
        fit[29], fit[30] = p, q
        if done:
            break
        hpp, hpq, hqq = _curvature(fit)[:3]
        det = hpp * hqq - hpq * hpq
        det = det if det > 1e-9 * hpp * hqq else hpp * hqq + 1e-300
        step_p, step_q = (hqq * gp - hpq * gq) / det, (hpp * gq - hpq * gp) / det
        long = math.hypot(step_p, step_q)
        if long > 1.5:
            step_p, step_q = 1.5 * step_p / long, 1.5 * step_q / long
        before_p, before_q = p, q
        p, q = min(max(p + step_p, 0.0), top_p), min(max(q + step_q, 0.0), top_q)
        step_p, step_q = p - before_p, q - before_q
    return last


@compiled()
def in_place_frames(readings, rows, mix, common, y, z, values, variance, typical, options, out):
    """Fill `out`, one row a frame; those that lack a sensor are left with status -1.

    readings (f, n), raw; rows (4, n): offset, 1 / noise, low and high end of the range; mix (n, n): what makes readings
    of errors that are independent, of variance 1 by noise; common (n,): standard deviations of the error that they have
    in common; y, z: first node and step; values, variance (k, l, n, c), of mixed readings; typical (3,): a load like
    the calibration's; options: mu, least and largest N, nodes from one to the next of the scan, the thresholds of
    detection and of chi-square, ambiguity, and the chi-square from which a frame is scanned again at every node.
    """
    frames, n = readings.shape
    mu, low, high = options[0], options[1], options[2]
    detection, largest, ambiguity, doubtful = options[4], options[5], options[6], options[7]
    r, load = np.empty(n), np.empty(3)
    g, b = np.zeros(6), np.zeros(3)
    cost, score, at = np.empty(values.shape[:2]), np.empty(_MOST), np.empty((_MOST, 2), dtype=np.int64)
    fits, here, doubt = np.zeros((_MOST, FIT)), np.empty((3, n, values.shape[3])), np.empty((3, n, values.shape[3]))
    fit, ends, more = np.zeros(FIT), np.empty(_MOST), np.zeros(3)
    for f in range(frames):
        row = out[f]
        row[:] = math.nan
        row[_RIVAL_CHI2] = math.inf
        total, size, along, usable = 0.0, 1.0, 0.0, True
        for i in range(n):
            usable &= rows[2, i] < readings[f, i] < rows[3, i]
            r[i] = 0.0
            for j in range(n):
                r[i] += mix[i, j] * (readings[f, j] - rows[0, j])
            total += r[i] * r[i]
            size += common[i] * common[i]
            along += common[i] * r[i]
        total -= along * along / size
        if not (usable and total < 1e30):
            row[_STATUS] = _PENDING
            continue
        apart, top, rival = int(options[3]), 0, -1
        while True:
            first, second = (values.shape[0] - 1) // apart + 1, (values.shape[1] - 1) // apart + 1
            load[:] = typical
            count = 0
            for _ in range(_SWEEPS):
                best = math.inf
                for j in range(first):
                    for k in range(second):
                        p, q = j * apart, k * apart
                        cost[j, k] = _cost(r, common, values[p, q], variance[p, q], load, mu, low, high, g, b, fit)
                        if cost[j, k] < best:
                            best = cost[j, k]
                            score[0], score[1], score[2] = fit[0], fit[1], fit[2]
                size, moved = 0.0, 0.0
                for j in range(3):
                    moved += (abs(score[j]) - abs(load[j])) ** 2
                    size += score[j] ** 2
                if not moved > 0.01 * size:
                    break
                for j in range(3):
                    load[j] = score[j]
            for j in range(first):  # the lowest nodes of the scan, each lower than its neighbours
                for k in range(second):
                    here_is = cost[j, k]
                    lower = True
                    for e in range(max(j - 1, 0), min(j + 2, first)):
                        for d in range(max(k - 1, 0), min(k + 2, second)):
                            lower &= not cost[e, d] < here_is
                    if not lower:
                        continue
                    rank = count
                    while rank > 0 and score[rank - 1] > here_is:
                        rank -= 1
                    if rank < _MOST:
                        for e in range(min(count, _MOST - 1), rank, -1):
                            score[e] = score[e - 1]
                            at[e, 0], at[e, 1] = at[e - 1, 0], at[e - 1, 1]
                        score[rank], at[rank, 0], at[rank, 1] = here_is, j * apart, k * apart
                        count = min(count + 1, _MOST)
            top = rival = -1
            for e in range(count):
                p, q = float(at[e, 0]), float(at[e, 1])
                ends[e] = _settle(r, common, values, variance, mu, low, high, p, q, load, fits[e], g, b, here, doubt)
                if top < 0 or ends[e] < ends[top]:
                    top = e
            for e in range(count):
                away = math.hypot(fits[e, 29] - fits[top, 29], fits[e, 30] - fits[top, 30])
                if away > 1.0 and (rival < 0 or ends[e] < ends[rival]):
                    rival = e
            if apart == 1 or not fits[top][17] > doubtful:
                break
            apart = 1  # what the scan hardly explains may lie in a narrow valley between its nodes
        one = fits[top]
        row[_RESIDUAL] = one[17]
        if one[17] > largest:
            row[_STATUS] = _UNEXPLAINED
            continue
        if total - ends[top] < detection:
            row[_STATUS] = _NO_CONTACT
            continue
        if mu == 0.0 and one[4] == 0.0:
            one[11] = math.inf  # the force is not free
        row[0], row[1] = y[0] + one[29] * y[1], z[0] + one[30] * z[1]
        row[_FORCES], row[_FORCES + 1], row[_FORCES + 2] = one[0], one[1], one[2]
        for k, scale in ((20, y[1] * y[1]), (21, y[1] * z[1]), (22, z[1] * z[1])):
            one[k] /= scale
        for k in range(3):
            one[23 + k] /= y[1]
            one[26 + k] /= z[1]
        covariance(one, mu, more, row)
        wide = widest_variance(row)
        status = _OK
        if rival >= 0:
            row[_RIVAL], row[_RIVAL + 1] = y[0] + fits[rival, 29] * y[1], z[0] + fits[rival, 30] * z[1]
            for c in range(3):
                row[_RIVAL + 2 + c] = fits[rival, c]
            row[_RIVAL_CHI2] = max(ends[rival] - ends[top], 0.0)
            if ends[rival] - ends[top] < ambiguity:
                status = _AMBIGUOUS
        p, q = one[29], one[30]
        if not (0.5 < p < values.shape[0] - 1.5 and 0.5 < q < values.shape[1] - 1.5):
            status = _AMBIGUOUS
        reach = 6.0 * math.sqrt(wide) + 0.75 * apart * max(y[1], z[1])
        if not reach < math.inf:
            status = _AMBIGUOUS
        elif status == _OK:
            for j in range(first):
                for k in range(second):
                    away = math.hypot((j * apart - p) * y[1], (k * apart - q) * z[1])
                    if away > reach and cost[j, k] < ends[top] + ambiguity:
                        status = _AMBIGUOUS
        row[_STATUS] = status
