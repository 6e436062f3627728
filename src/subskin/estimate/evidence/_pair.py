"""Two line loads at once, compiled: the best pair, and its evidence by Laplace's method.

Pairs on a grid of midpoints and half distances first, their forces eliminated and cut back into the cones; then Newton
and Levenberg from the best of them, in midpoint, half distance, and each touch's magnitude and angle; then a Gaussian
in midpoint, half distance and the four forces about each of the pairs found, cut by cones and ends, an edge at a time.
What the readings do not tell of a pair spreads as far as search, distances and force allow.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..climb import field_at
from ._integrals import _LOG_2PI, _add, _log_below

_STARTS = 3
_STEPS = 40


@compiled()
def scan_pairs(w, basis, tri, back, mu, c, s):
    """Chi-square explained by each pair, forces that leave the cones being cut back: a lower bound, into s (pairs,).

    w (n,); basis (n, 4, pairs): orthonormal columns of the pair's A = Q R; tri, back (10, pairs): R and its inverse, by
    rows; c (4, pairs): scratch.
    """
    n, _, m = basis.shape
    for j in range(4):
        for p in range(m):
            c[j, p] = np.float32(0)
        for i in range(n):
            for p in range(m):
                c[j, p] += w[i] * basis[i, j, p]
    for p in range(m):
        c0, c1, c2, c3 = c[0, p], c[1, p], c[2, p], c[3, p]
        n1 = back[0, p] * c0 + back[1, p] * c1 + back[2, p] * c2 + back[3, p] * c3
        t1 = back[4, p] * c1 + back[5, p] * c2 + back[6, p] * c3
        n2 = back[7, p] * c2 + back[8, p] * c3
        t2 = back[9, p] * c3
        k1, k2 = max(n1, np.float32(0)), max(n2, np.float32(0))
        d1, d3 = min(max(t1, -mu * k1), mu * k1) - t1, min(max(t2, -mu * k2), mu * k2) - t2
        d0, d2 = k1 - n1, k2 - n2
        e0 = tri[0, p] * d0 + tri[1, p] * d1 + tri[2, p] * d2 + tri[3, p] * d3
        e1 = tri[4, p] * d1 + tri[5, p] * d2 + tri[6, p] * d3
        e2, e3 = tri[7, p] * d2 + tri[8, p] * d3, tri[9, p] * d3
        s[p] = c0 * c0 + c1 * c1 + c2 * c2 + c3 * c3 - (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)


@compiled()
def _model(w, table, g, x, a, rho, jac):
    """Chi-square of x = (midpoint, half distance, P1, angle 1, P2, angle 2); residuals rho (n,), columns jac (6, n)."""
    n = w.size
    field_at(table, g[0], g[1], x[0] - x[1], a[:4])
    field_at(table, g[0], g[1], x[0] + x[1], a[4:])
    c1, s1, c2, s2 = math.cos(x[3]), math.sin(x[3]), math.cos(x[5]), math.sin(x[5])
    total = 0.0
    for i in range(n):
        u1, u2 = c1 * a[0, i] + s1 * a[1, i], c2 * a[4, i] + s2 * a[5, i]
        y1, y2 = x[2] * (c1 * a[2, i] + s1 * a[3, i]), x[4] * (c2 * a[6, i] + s2 * a[7, i])
        rho[i] = w[i] - x[2] * u1 - x[4] * u2
        total += rho[i] * rho[i]
        jac[0, i], jac[1, i] = y1 + y2, y2 - y1
        jac[2, i], jac[3, i] = u1, x[2] * (c1 * a[1, i] - s1 * a[0, i])
        jac[4, i], jac[5, i] = u2, x[4] * (c2 * a[5, i] - s2 * a[4, i])
    return total


@compiled()
def _solve(m, b, size, out):
    """Solve m x = b by Cholesky, m (size, size) positive, overwritten by its factor; log of its determinant."""
    logdet = 0.0
    for i in range(size):
        for j in range(i + 1):
            v = m[i, j]
            for k in range(j):
                v -= m[i, k] * m[j, k]
            if i == j:
                m[i, i] = math.sqrt(max(v, 1e-300))
                logdet += 2.0 * math.log(m[i, i])
            else:
                m[i, j] = v / m[j, j]
    for i in range(size):
        v = b[i]
        for k in range(i):
            v -= m[i, k] * out[k]
        out[i] = v / m[i, i]
    for i in range(size - 1, -1, -1):
        v = out[i]
        for k in range(i + 1, size):
            v -= m[k, i] * out[k]
        out[i] = v / m[i, i]
    return logdet


@compiled()
def _clamp(x, ends, lean):
    """Back into the search: half distance, midpoint, magnitudes, angles."""
    x[1] = min(max(x[1], ends[2]), ends[3], 0.5 * (ends[1] - ends[0]))
    x[0] = min(max(x[0], ends[0] + x[1]), ends[1] - x[1])
    for k in range(2, 6, 2):
        x[k] = max(x[k], 0.0)
        x[k + 1] = min(max(x[k + 1], -lean), lean)


@compiled()
def _climb_pair(w, table, g, ends, lean, x, y, a, rho, jac, info, step):
    """Least chi-square from x, which is moved there. rho (2, n), jac (12, n): of x, then of what is tried."""
    chi2, damping = _model(w, table, g, x, a, rho[0], jac), 1e-3
    grad = step[1]
    for _ in range(_STEPS):
        for i in range(6):
            grad[i] = 0.0
            for k in range(w.size):
                grad[i] += jac[i, k] * rho[0, k]
        held = (
            (x[0] <= ends[0] + x[1] and grad[0] < 0.0) or (x[0] >= ends[1] - x[1] and grad[0] > 0.0),
            (x[1] <= ends[2] and grad[1] < 0.0) or (x[1] >= ends[3] and grad[1] > 0.0),
            x[2] <= 0.0 and grad[2] < 0.0,
            lean == 0.0 or (abs(x[3]) >= lean and grad[3] * x[3] > 0.0),
            x[4] <= 0.0 and grad[4] < 0.0,
            lean == 0.0 or (abs(x[5]) >= lean and grad[5] * x[5] > 0.0),
        )
        done = True
        while damping < 1e10:
            for i in range(6):
                for j in range(i + 1):
                    v = 0.0
                    for k in range(w.size):
                        v += jac[i, k] * jac[j, k]
                    info[i, j] = 0.0 if held[i] or held[j] else v
                info[i, i] = 1.0 if held[i] else info[i, i] * (1.0 + damping) + 1e-12
                step[2, i] = 0.0 if held[i] else grad[i]
            _solve(info, step[2], 6, step[0])
            for i in range(6):
                y[i] = x[i] + step[0, i]
            _clamp(y, ends, lean)
            now = _model(w, table, g, y, a, rho[1], jac[6:])
            if now < chi2:
                done = chi2 - now < 1e-4 * (1.0 + 0.01 * now)
                x[:] = y
                chi2 = now
                rho[0], jac[:6] = rho[1], jac[6:]
                damping = max(0.1 * damping, 1e-9)
                break
            damping *= 10.0
        if done:
            break
    return chi2


@compiled()
def _weigh_pair(w, table, g, ends, mu, lean, x, a, rho, jac, info, cov, mean, step):
    """Log of the integral over midpoint, half distance and forces about x, where chi-square is least."""
    n = w.size
    chi2 = _model(w, table, g, x, a, rho[0], jac)
    size = x[2] + x[4]
    for i in range(n):
        jac[2, i], jac[3, i], jac[4, i], jac[5, i] = a[0, i], a[1, i], a[4, i], a[5, i]
    grad = step[1]
    length = ends[1] - ends[0]
    for i in range(6):
        none = mu == 0.0 and (i == 3 or i == 5)
        grad[i] = 0.0
        for k in range(n):
            grad[i] += 0.0 if none else jac[i, k] * rho[0, k]
        for j in range(i + 1):
            v = 0.0
            for k in range(n):
                v += jac[i, k] * jac[j, k]
            info[i, j] = 0.0 if none or (mu == 0.0 and j == 3) else v
        # no wider than search, distances and force
        wide = length if i == 0 else (ends[3] - ends[2] if i == 1 else 0.0)
        info[i, i] += 12.0 / (wide * wide) if i < 2 and wide > 0.0 else (1.0 if none else 1.0 / (size * size + 1e-300))
        if i == 1 and not wide > 0.0:
            info[i, i] += 1e12 / (length * length)
    logdet = _solve(info, grad, 6, mean)
    out = -0.5 * chi2 - 0.5 * logdet + (3.0 if mu > 0.0 else 2.0) * _LOG_2PI
    for i in range(6):
        out += 0.5 * grad[i] * mean[i]
        step[2] = 0.0
        step[2, i] = 1.0
        # `info` is its factor now: a column of the inverse by two triangles
        for r in range(6):
            v = step[2, r]
            for k in range(r):
                v -= info[r, k] * cov[i, k]
            cov[i, r] = v / info[r, r]
        for r in range(5, -1, -1):
            v = cov[i, r]
            for k in range(r + 1, 6):
                v -= info[k, r] * cov[i, k]
            cov[i, r] = v / info[r, r]
    mean[0] += x[0]
    mean[1] += x[1]
    mean[2] += x[2] * math.cos(x[3])
    mean[3] += x[2] * math.sin(x[3])
    mean[4] += x[4] * math.cos(x[5])
    mean[5] += x[4] * math.sin(x[5])
    edge = step[2]
    for k in range(2, 6, 2):
        for side in range(2):
            edge[:] = 0.0
            edge[k] = mu if 0.0 < mu < math.inf else 1.0
            edge[k + 1] = (2.0 * side - 1.0) if 0.0 < mu < math.inf else 0.0
            if side == 0 or edge[k + 1] != 0.0:
                out += _cut(cov, mean, edge, 0.0, step[3])
    for k in range(4):
        edge[:] = 0.0
        if k < 2:  # the outer touches within the search
            edge[0], edge[1] = 1.0 - 2.0 * k, -1.0
            out += _cut(cov, mean, edge, (2.0 * k - 1.0) * ends[k], step[3])
        elif ends[3] > ends[2]:
            edge[1] = 5.0 - 2.0 * k
            out += _cut(cov, mean, edge, -edge[1] * ends[k], step[3])
    one, two = math.hypot(mean[2], mean[3]), math.hypot(mean[4], mean[5])
    # alike: midpoints, half distances, shares of the force, angles; the whole on a logarithmic scale
    out += math.log(length / max(length - 2.0 * x[1], 1e-3 * length))
    out -= math.log(ends[3] - ends[2]) if ends[3] > ends[2] else 0.5 * (_LOG_2PI - math.log(1e12 / (length * length)))
    out -= 2.0 * math.log(max(one + two, 1e-300))
    if mu > 0.0:
        out -= math.log(2.0 * lean) + math.log(max(one, 1e-300)) + math.log(max(two, 1e-300))
    return out


@compiled()
def _cut(cov, mean, edge, offset, v):
    """Log of the share of a Gaussian where edge x + offset > 0; mean and covariance become those of that share."""
    at, square = offset, 0.0
    for i in range(6):
        v[i] = 0.0
        for j in range(6):
            v[i] += cov[i, j] * edge[j]
        at += edge[i] * mean[i]
    for i in range(6):
        square += edge[i] * v[i]
    spread = math.sqrt(max(square, 1e-300))
    z = at / spread
    if z > 6.0:
        return 0.0
    share = _log_below(z)
    pull = math.exp(-0.5 * z * z - 0.5 * _LOG_2PI - share)
    for i in range(6):
        mean[i] += v[i] * pull / spread
        for j in range(6):
            cov[i, j] -= v[i] * v[j] * pull * (pull + z) / (spread * spread)
    return share


@compiled()
def weigh_pairs(w, w_single, pairs, basis, tri, back, table, g, ends, mu, best):
    """Log of the evidence of two touches, as `_evidence` counts it but for chi-square; `best`: x, then its chi-square.

    pairs (2, m): midpoints and half distances of the grid; ends: search, then least and largest half distance.
    """
    n, m = w.size, pairs.shape[1]
    c, s = np.empty((4, m), dtype=np.float32), np.empty(m, dtype=np.float32)
    lean = math.atan(mu)
    single = np.float32(min(mu, 1e6))
    scan_pairs(w_single, basis, tri, back, single, c, s)
    xs, chi2s = np.empty((_STARTS, 6)), np.empty(_STARTS)
    a, rho, jac = np.empty((8, n)), np.empty((2, n)), np.empty((12, n))
    info, cov, mean, step = np.empty((6, 6)), np.empty((6, 6)), np.empty(6), np.empty((4, 6))
    y = np.empty(6)
    total, kept = -math.inf, 0
    best[6] = math.inf
    for _ in range(_STARTS):
        p = 0
        for k in range(m):
            p = k if s[k] > s[p] else p
        if not s[p] > 0.0:
            break
        x = xs[kept]
        x[0], x[1] = pairs[0, p], pairs[1, p]
        for k in range(m):  # its neighbours climb to the same
            if abs(pairs[0, k] - x[0]) + abs(pairs[1, k] - x[1]) < 0.4 * g[2]:
                s[k] = -1.0
        c3 = c[3, p]
        t2 = back[9, p] * c3
        n2 = back[7, p] * c[2, p] + back[8, p] * c3
        t1 = back[4, p] * c[1, p] + back[5, p] * c[2, p] + back[6, p] * c3
        n1 = back[0, p] * c[0, p] + back[1, p] * c[1, p] + back[2, p] * c[2, p] + back[3, p] * c3
        x[2], x[4] = max(float(n1), 0.0), max(float(n2), 0.0)
        least = 1e-3 * (x[2] + x[4])
        x[2], x[4] = max(x[2], least), max(x[4], least)
        x[3], x[5] = math.atan(float(t1) / x[2]), math.atan(float(t2) / x[4])
        _clamp(x, ends, lean)
        chi2s[kept] = _climb_pair(w, table, g, ends, lean, x, y, a, rho, jac, info, step)
        new = True
        for e in range(kept):
            new &= abs(xs[e, 0] - x[0]) + abs(xs[e, 1] - x[1]) > 0.05 * g[2]
        if not new:
            continue
        if chi2s[kept] < best[6]:
            best[:6] = x
            best[6] = chi2s[kept]
        if chi2s[kept] < best[6] + 80.0:
            total = _add(total, _weigh_pair(w, table, g, ends, mu, lean, x, a, rho, jac, info, cov, mean, step))
        kept += 1
    return total
