"""Two line loads at once, compiled: the best pair, and its evidence by Laplace's method.

Pairs on a grid of midpoints and half distances first, their forces eliminated and cut back into the cones; then Newton
and Levenberg from the best of them, in midpoint, half distance, and each touch's magnitude and angle; then a Gaussian
in midpoint, half distance and the four forces about each of the pairs found, cut by cones and ends, an edge at a time.
What the readings do not tell of a pair spreads as far as search, distances and force allow.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..climb import field_at
from ._integrals import _LOG_2PI, add, log_below

_STARTS = 3
_STEPS = 40
_SIZE = 6
MIDDLE, HALF, FIRST, FIRST_ANGLE, SECOND, SECOND_ANGLE = range(_SIZE)
"""Unknowns of a pair: midpoint, half distance, and magnitude and angle of each touch."""


class LineTable(NamedTuple):
    """What the sensors read of one line load, as of `field_at`."""

    table: FloatArray
    start: float
    step: float


class TouchPairs(NamedTuple):
    """What the sensors read of two line loads at once, and where these may be.

    grid (2, m): midpoints and half distances; basis (n, 4, m): orthonormal columns of each pair's A = Q R; tri, back
    (4, 4, m): R and its inverse; line: of each touch; near: the least depth; ends (4,): the search,
    then least and largest half distance.
    """

    grid: FloatArray
    basis: npt.NDArray[np.float32]
    tri: npt.NDArray[np.float32]
    back: npt.NDArray[np.float32]
    line: LineTable
    near: float
    ends: FloatArray


class PairRoom(NamedTuple):
    """Scratch: fields a (2, 4, n) of both touches, residuals and slopes of two pairs, and those of a Gaussian."""

    a: FloatArray
    rho: FloatArray
    jac: FloatArray
    info: FloatArray
    cov: FloatArray
    mean: FloatArray
    to: FloatArray
    step: FloatArray
    grad: FloatArray
    edge: FloatArray
    pull: FloatArray


@compiled(borrows=True)
def _scan(w, pairs, mu, c, s):
    """Chi-square explained by each pair, forces that leave the cones being cut back: a lower bound, into s (m,).

    w (n,); c (4, m): scratch.
    """
    basis, tri, back = pairs.basis, pairs.tri, pairs.back
    n, _, m = basis.shape
    for j in range(4):
        for p in range(m):
            c[j, p] = np.float32(0)
        for i in range(n):
            for p in range(m):
                c[j, p] += w[i] * basis[i, j, p]
    for p in range(m):
        c0, c1, c2, c3 = c[0, p], c[1, p], c[2, p], c[3, p]
        n1, t1, n2, t2 = _forces(back, c, p)
        k1, k2 = max(n1, np.float32(0)), max(n2, np.float32(0))
        d1, d3 = min(max(t1, -mu * k1), mu * k1) - t1, min(max(t2, -mu * k2), mu * k2) - t2
        d0, d2 = k1 - n1, k2 - n2
        e0 = tri[0, 0, p] * d0 + tri[0, 1, p] * d1 + tri[0, 2, p] * d2 + tri[0, 3, p] * d3
        e1 = tri[1, 1, p] * d1 + tri[1, 2, p] * d2 + tri[1, 3, p] * d3
        e2, e3 = tri[2, 2, p] * d2 + tri[2, 3, p] * d3, tri[3, 3, p] * d3
        s[p] = c0 * c0 + c1 * c1 + c2 * c2 + c3 * c3 - (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)


@compiled(inline=True)
def _forces(back, c, p):
    """N and T of both touches of a pair, without the cones."""
    return (
        back[0, 0, p] * c[0, p] + back[0, 1, p] * c[1, p] + back[0, 2, p] * c[2, p] + back[0, 3, p] * c[3, p],
        back[1, 1, p] * c[1, p] + back[1, 2, p] * c[2, p] + back[1, 3, p] * c[3, p],
        back[2, 2, p] * c[2, p] + back[2, 3, p] * c[3, p],
        back[3, 3, p] * c[3, p],
    )


@compiled(borrows=True)
def _model(w, line, x, a, rho, jac):
    """Chi-square of a pair x; residuals rho (n,), slopes jac (6, n)."""
    n = w.size
    field_at(line.table, line.start, line.step, x[MIDDLE] - x[HALF], a[0])
    field_at(line.table, line.start, line.step, x[MIDDLE] + x[HALF], a[1])
    p1, p2 = x[FIRST], x[SECOND]
    c1, s1, c2, s2 = (
        math.cos(x[FIRST_ANGLE]),
        math.sin(x[FIRST_ANGLE]),
        math.cos(x[SECOND_ANGLE]),
        math.sin(x[SECOND_ANGLE]),
    )
    total = 0.0
    for i in range(n):
        u1, u2 = c1 * a[0, 0, i] + s1 * a[0, 1, i], c2 * a[1, 0, i] + s2 * a[1, 1, i]
        y1, y2 = p1 * (c1 * a[0, 2, i] + s1 * a[0, 3, i]), p2 * (c2 * a[1, 2, i] + s2 * a[1, 3, i])
        rho[i] = w[i] - p1 * u1 - p2 * u2
        total += rho[i] * rho[i]
        jac[MIDDLE, i], jac[HALF, i] = y1 + y2, y2 - y1
        jac[FIRST, i], jac[FIRST_ANGLE, i] = u1, p1 * (c1 * a[0, 1, i] - s1 * a[0, 0, i])
        jac[SECOND, i], jac[SECOND_ANGLE, i] = u2, p2 * (c2 * a[1, 1, i] - s2 * a[1, 0, i])
    return total


@compiled(borrows=True)
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


@compiled(borrows=True)
def _inverse(factor, size, out):
    """The inverse of a matrix of this factor, a column by two triangles, into out (size, size)."""
    for i in range(size):
        for r in range(size):
            v = 1.0 if r == i else 0.0
            for k in range(r):
                v -= factor[r, k] * out[i, k]
            out[i, r] = v / factor[r, r]
        for r in range(size - 1, -1, -1):
            v = out[i, r]
            for k in range(r + 1, size):
                v -= factor[k, r] * out[i, k]
            out[i, r] = v / factor[r, r]


@compiled(borrows=True)
def _clamp(x, ends, lean):
    """Back into the search: half distance, midpoint, magnitudes, angles."""
    x[HALF] = min(max(x[HALF], ends[2]), ends[3], 0.5 * (ends[1] - ends[0]))
    x[MIDDLE] = min(max(x[MIDDLE], ends[0] + x[HALF]), ends[1] - x[HALF])
    for k in (FIRST, SECOND):
        x[k] = max(x[k], 0.0)
        x[k + 1] = min(max(x[k + 1], -lean), lean)


@compiled(borrows=True)
def _climb(w, line, ends, lean, x, room):
    """Least chi-square from x, which is moved there."""
    rho, jac, info, y, grad, pull, move = (
        room.rho, room.jac, room.info, room.to, room.grad, room.pull, room.step,
    )  # fmt: skip
    chi2, damping = _model(w, line, x, room.a, rho[0], jac[0]), 1e-3
    for _ in range(_STEPS):
        for i in range(_SIZE):
            grad[i] = 0.0
            for k in range(w.size):
                grad[i] += jac[0, i, k] * rho[0, k]
        held = (
            (x[MIDDLE] <= ends[0] + x[HALF] and grad[MIDDLE] < 0.0)
            or (x[MIDDLE] >= ends[1] - x[HALF] and grad[MIDDLE] > 0.0),
            (x[HALF] <= ends[2] and grad[HALF] < 0.0) or (x[HALF] >= ends[3] and grad[HALF] > 0.0),
            x[FIRST] <= 0.0 and grad[FIRST] < 0.0,
            lean == 0.0 or (abs(x[FIRST_ANGLE]) >= lean and grad[FIRST_ANGLE] * x[FIRST_ANGLE] > 0.0),
            x[SECOND] <= 0.0 and grad[SECOND] < 0.0,
            lean == 0.0 or (abs(x[SECOND_ANGLE]) >= lean and grad[SECOND_ANGLE] * x[SECOND_ANGLE] > 0.0),
        )
        done = True
        while damping < 1e10:
            for i in range(_SIZE):
                for j in range(i + 1):
                    v = 0.0
                    for k in range(w.size):
                        v += jac[0, i, k] * jac[0, j, k]
                    info[i, j] = 0.0 if held[i] or held[j] else v
                info[i, i] = 1.0 if held[i] else info[i, i] * (1.0 + damping) + 1e-12
                pull[i] = 0.0 if held[i] else grad[i]
            _solve(info, pull, _SIZE, move)
            for i in range(_SIZE):
                y[i] = x[i] + move[i]
            _clamp(y, ends, lean)
            now = _model(w, line, y, room.a, rho[1], jac[1])
            if now < chi2:
                done = chi2 - now < 1e-4 * (1.0 + 0.01 * now)
                chi2 = now
                for k in range(w.size):
                    rho[0, k] = rho[1, k]
                for i in range(_SIZE):
                    x[i] = y[i]
                    for k in range(w.size):
                        jac[0, i, k] = jac[1, i, k]
                damping = max(0.1 * damping, 1e-9)
                break
            damping *= 10.0
        if done:
            break
    return chi2


@compiled(borrows=True)
def _weigh(w, pairs, mu, lean, x, room):
    """Log of the integral over midpoint, half distance and forces about x, where chi-square is least."""
    n, ends, a, rho, jac, info, cov, mean, grad, edge = (
        w.size, pairs.ends, room.a, room.rho[0], room.jac[0], room.info, room.cov, room.mean, room.grad, room.edge,
    )  # fmt: skip
    chi2 = _model(w, pairs.line, x, a, rho, jac)
    size, length, wide = x[FIRST] + x[SECOND], ends[1] - ends[0], ends[3] - ends[2]
    for i in range(n):  # of the components in place of magnitudes and angles
        jac[FIRST, i], jac[FIRST + 1, i], jac[SECOND, i], jac[SECOND + 1, i] = (
            a[0, 0, i],
            a[0, 1, i],
            a[1, 0, i],
            a[1, 1, i],
        )
    for i in range(_SIZE):
        none = mu == 0.0 and (i == FIRST + 1 or i == SECOND + 1)
        grad[i] = 0.0
        for k in range(n):
            grad[i] += 0.0 if none else jac[i, k] * rho[k]
        for j in range(i + 1):
            v = 0.0
            for k in range(n):
                v += jac[i, k] * jac[j, k]
            info[i, j] = 0.0 if none or (mu == 0.0 and j == FIRST + 1) else v
        # no wider than search, distances and force
        if i == MIDDLE:
            info[i, i] += 12.0 / (length * length)
        elif i == HALF:
            info[i, i] += (
                12.0 / (wide * wide) if wide > 0.0 else 1.0 / (size * size + 1e-300) + 1e12 / (length * length)
            )
        else:
            info[i, i] += 1.0 if none else 1.0 / (size * size + 1e-300)
    logdet = _solve(info, grad, _SIZE, mean)
    out = -0.5 * chi2 - 0.5 * logdet + (3.0 if mu > 0.0 else 2.0) * _LOG_2PI
    for i in range(_SIZE):
        out += 0.5 * grad[i] * mean[i]
    _inverse(info, _SIZE, cov)
    mean[MIDDLE] += x[MIDDLE]
    mean[HALF] += x[HALF]
    for k in (FIRST, SECOND):
        mean[k] += x[k] * math.cos(x[k + 1])
        mean[k + 1] += x[k] * math.sin(x[k + 1])
    leans = 0.0 < mu < math.inf
    for k in (FIRST, SECOND):
        for side in range(2 if leans else 1):
            edge[:] = 0.0
            edge[k], edge[k + 1] = (mu, 2.0 * side - 1.0) if leans else (1.0, 0.0)
            out += _cut(cov, mean, edge, 0.0, room.pull)
    for side in range(2):  # the outer touches within the search
        edge[:] = 0.0
        edge[MIDDLE], edge[HALF] = 1.0 - 2.0 * side, -1.0
        out += _cut(cov, mean, edge, -edge[MIDDLE] * ends[side], room.pull)
    for side in range(2 if wide > 0.0 else 0):
        edge[:] = 0.0
        edge[HALF] = 1.0 - 2.0 * side
        out += _cut(cov, mean, edge, -edge[HALF] * ends[2 + side], room.pull)
    one, two = math.hypot(mean[FIRST], mean[FIRST + 1]), math.hypot(mean[SECOND], mean[SECOND + 1])
    # alike: midpoints, half distances, shares of the force, angles; the whole on a logarithmic scale
    out += math.log(length / max(length - 2.0 * x[HALF], 1e-3 * length))
    out -= math.log(wide) if wide > 0.0 else 0.5 * (_LOG_2PI - math.log(1e12 / (length * length)))
    out -= 2.0 * math.log(max(one + two, 1e-300))
    if mu > 0.0:
        out -= math.log(2.0 * lean) + math.log(max(one, 1e-300)) + math.log(max(two, 1e-300))
    return out


@compiled(borrows=True)
def _cut(cov, mean, edge, offset, v):
    """Log of the share of a Gaussian where edge x + offset > 0; mean and covariance become those of that share."""
    at, square = offset, 0.0
    for i in range(_SIZE):
        v[i] = 0.0
        for j in range(_SIZE):
            v[i] += cov[i, j] * edge[j]
        at += edge[i] * mean[i]
    for i in range(_SIZE):
        square += edge[i] * v[i]
    spread = math.sqrt(max(square, 1e-300))
    z = at / spread
    if z > 6.0:
        return 0.0
    share = log_below(z)
    pull = math.exp(-0.5 * z * z - 0.5 * _LOG_2PI - share)
    for i in range(_SIZE):
        mean[i] += v[i] * pull / spread
        for j in range(_SIZE):
            cov[i, j] -= v[i] * v[j] * pull * (pull + z) / (spread * spread)
    return share


@compiled()
def weigh_pairs(w, w_single, pairs, mu, best):
    """Log of the evidence of two touches, as `_evidence` counts it but for chi-square; the least chi-square.

    best (6,): that pair.
    """
    n, m = w.size, pairs.grid.shape[1]
    c, s = np.empty((4, m), dtype=np.float32), np.empty(m, dtype=np.float32)
    lean = math.atan(mu)
    _scan(w_single, pairs, np.float32(min(mu, 1e6)), c, s)
    xs, chi2s, grid = np.empty((_STARTS, _SIZE)), np.empty(_STARTS), pairs.grid
    room = PairRoom(
        np.empty((2, 4, n)), np.empty((2, n)), np.empty((2, _SIZE, n)), np.empty((_SIZE, _SIZE)),
        np.empty((_SIZE, _SIZE)), np.empty(_SIZE), np.empty(_SIZE), np.empty(_SIZE), np.empty(_SIZE), np.empty(_SIZE),
        np.empty(_SIZE),
    )  # fmt: skip
    total, least, kept = -math.inf, math.inf, 0
    for _ in range(_STARTS):
        p = 0
        for k in range(m):
            p = k if s[k] > s[p] else p
        if not s[p] > 0.0:
            break
        x = xs[kept]
        x[MIDDLE], x[HALF] = grid[0, p], grid[1, p]
        for k in range(m):  # its neighbours climb to the same
            if abs(grid[0, k] - x[MIDDLE]) + abs(grid[1, k] - x[HALF]) < 0.4 * pairs.near:
                s[k] = -1.0
        n1, t1, n2, t2 = _forces(pairs.back, c, p)
        x[FIRST], x[SECOND] = max(float(n1), 0.0), max(float(n2), 0.0)
        some = 1e-3 * (x[FIRST] + x[SECOND])
        x[FIRST], x[SECOND] = max(x[FIRST], some), max(x[SECOND], some)
        x[FIRST_ANGLE], x[SECOND_ANGLE] = math.atan(float(t1) / x[FIRST]), math.atan(float(t2) / x[SECOND])
        _clamp(x, pairs.ends, lean)
        chi2s[kept] = _climb(w, pairs.line, pairs.ends, lean, x, room)
        new = True
        for e in range(kept):
            new &= abs(xs[e, MIDDLE] - x[MIDDLE]) + abs(xs[e, HALF] - x[HALF]) > 0.05 * pairs.near
        if not new:
            continue
        if chi2s[kept] < least:
            best[:] = x
            least = chi2s[kept]
        if chi2s[kept] < least + 80.0:
            total = add(total, _weigh(w, pairs, mu, lean, x, room))
        kept += 1
    return total, least
