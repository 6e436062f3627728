"""Compiled: what sensors read under a round contact that sticks in its middle, with derivatives by its unknowns.

Readings are r = N A_N(y, q) + T U(y, q, t) with q = a^2 and t = |T| / (mu N). The shear of Cattaneo and Mindlin is mu
times the Hertz pressure of half width a less that of the stick zone, c^2 = q (1 - t), so that with G(q) = q A_T(q), A_T
being the response to a drag in proportion to the pressure,

    U = (G(q) - G(c^2)) / (q t) = the mean of G' over the squares from c^2 to q.

No difference of near numbers is left at small t. A little more drag at the same N adds dr/dT = G'(c^2), the shear of a
rigid flat on the stick zone. From t = 1 on the contact slides, and U = A_T. docs/fitting.md; `PartialSlip`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._compiled import compiled

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
