"""Two line loads at once, compiled: the best pair, and its evidence by Laplace's method.

Pairs on a grid of midpoints and half distances first, their forces eliminated and cut back into the cones; then a climb
from the best of them, over position, half distance and both angles, the magnitudes being eliminated; then a Gaussian in
midpoint, half distance and the four forces about each of the pairs found, cut by cones and ends, an edge at a time.
What the readings do not tell of a pair spreads as far as search, distances and force allow.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..kinds import LINE_ROWS, Along, Line, line_field
from ..varpro import Ending, Limits, kernel
from ._integrals import LOG_2PI, Gaussian, add, cut, gaussian, settled
from .base import HALF_WIDTH, NORMAL, POSITION, TANGENTIAL

_STARTS = 3
_SIZE = 6
MIDDLE, HALF, FIRST, SECOND = 0, 1, 2, 4
"""Unknowns of a pair's Gaussian: midpoint, half distance, and where the components of each touch begin."""
_TEN = 10
"""Rows of a pair's field: readings under its two components, and their slopes in four unknowns."""
_FINE = 1e-4
"""What the last step of a climb may gain."""
_QUADRANT = Limits(1.0, 0.0, math.inf)
"""Both magnitudes are 0 or more where their difference is no larger than their sum."""


class TouchPairs(NamedTuple):
    """What the sensors read of two line loads at once, and where these may be.

    grid (2, m): midpoints and half distances; basis (n, 4, m): orthonormal columns of each pair's A = Q R; tri, back
    (4, 4, m): R and its inverse; table, start, step: of each touch, as of `Line`; near: the least depth; ends (4,): the
    search, then least and largest half distance.
    """

    grid: FloatArray
    basis: npt.NDArray[np.float32]
    tri: npt.NDArray[np.float32]
    back: npt.NDArray[np.float32]
    table: FloatArray
    start: float
    step: float
    near: float
    ends: FloatArray


class Both(NamedTuple):
    """Where two touches are: what share of the room before and behind is before them; half distance; their angles.

    Their components are half the sum of both magnitudes, and half of what the first has more.
    """

    share: float
    half: float
    first: float
    second: float


class BothModel(NamedTuple):
    """Readings under two touches: of each, as of `kinds.Line`; rows (10, n): scratch; ends (4,): as of `TouchPairs`."""

    one: Line
    two: Line
    rows: FloatArray
    ends: FloatArray


@compiled(borrows=True)
def _both_field(model, at):
    """Rows of readings under the components of two touches, then their slopes in the unknowns."""
    rows, length = model.rows, model.ends[1] - model.ends[0]
    before = model.ends[0] + at.share * (length - 2.0 * at.half)
    line_field(model.one, Along(before))
    line_field(model.two, Along(before + 2.0 * at.half))
    a, b, room = model.one.rows, model.two.rows, length - 2.0 * at.half
    c1, s1, c2, s2 = math.cos(at.first), math.sin(at.first), math.cos(at.second), math.sin(at.second)
    for i in range(rows.shape[1]):
        u, v = c1 * a[0, i] + s1 * a[1, i], c2 * b[0, i] + s2 * b[1, i]
        by_u, by_v = c1 * a[2, i] + s1 * a[3, i], c2 * b[2, i] + s2 * b[3, i]
        turned_u, turned_v = c1 * a[1, i] - s1 * a[0, i], c2 * b[1, i] - s2 * b[0, i]
        wider_u, wider_v = -2.0 * at.share * by_u, (2.0 - 2.0 * at.share) * by_v
        each = (
            u + v, u - v, room * (by_u + by_v), room * (by_u - by_v), wider_u + wider_v, wider_u - wider_v,
            turned_u, turned_u, turned_v, -turned_v,
        )  # fmt: skip
        for k in range(_TEN):
            rows[k, i] = each[k]


BOTH_FIT, _, _, _, _, climb, _ = kernel(Both, _both_field, 2)


class PairRoom(NamedTuple):
    """Scratch: the model, sums and heights of the scan, the pairs found, fits, a Gaussian and readings' slopes."""

    model: BothModel
    c: npt.NDArray[np.float32]
    s: npt.NDArray[np.float32]
    box: FloatArray
    tops: FloatArray
    fits: npt.NDArray[np.void]
    gauss: Gaussian
    jac: FloatArray


@compiled(inline=True)
def pair_room(pairs):
    """Room for the pairs of a frame."""
    n, m = pairs.basis.shape[0], pairs.grid.shape[1]
    one = Line(pairs.table, pairs.start, pairs.step, np.empty((LINE_ROWS, n)))
    two = Line(pairs.table, pairs.start, pairs.step, np.empty((LINE_ROWS, n)))
    return PairRoom(
        BothModel(one, two, np.empty((_TEN, n)), pairs.ends), np.empty((4, m), dtype=np.float32),
        np.empty(m, dtype=np.float32), np.empty(8), np.empty((_STARTS, 2)), np.empty(3, BOTH_FIT), gaussian(_SIZE),
        np.empty((_SIZE, n)),
    )  # fmt: skip


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


@compiled(inline=True)
def _middle(fit, ends):
    """The midpoint of two touches."""
    return ends[0] + fit.half + fit.share * (ends[1] - ends[0] - 2.0 * fit.half)


@compiled(borrows=True)
def _weigh(w, fit, mu, lean, room):
    """Log of the integral over midpoint, half distance and forces about a pair, where chi-square is least."""
    gauss, jac, ends, a, b = room.gauss, room.jac, room.model.ends, room.model.one.rows, room.model.two.rows
    info, slope, mean, edge = gauss.info, gauss.slope, gauss.mean, gauss.edge
    _both_field(room.model, Both(fit.share, fit.half, fit.first, fit.second))
    p1, p2, n, middle = fit.n + fit.t, fit.n - fit.t, w.size, _middle(fit, ends)
    n1, t1 = p1 * math.cos(fit.first), p1 * math.sin(fit.first)
    n2, t2 = p2 * math.cos(fit.second), p2 * math.sin(fit.second)
    size, length, wide, chi2 = p1 + p2, ends[1] - ends[0], ends[3] - ends[2], 0.0
    slope[:] = 0.0
    info[:] = 0.0
    for i in range(n):
        y1, y2 = n1 * a[2, i] + t1 * a[3, i], n2 * b[2, i] + t2 * b[3, i]
        jac[MIDDLE, i], jac[HALF, i] = y1 + y2, y2 - y1
        for k in range(2):
            none = mu == 0.0 and k == 1  # there is no drag
            jac[FIRST + k, i], jac[SECOND + k, i] = (0.0, 0.0) if none else (a[k, i], b[k, i])
        rho = w[i] - n1 * a[0, i] - t1 * a[1, i] - n2 * b[0, i] - t2 * b[1, i]
        chi2 += rho * rho
        for j in range(_SIZE):
            slope[j] += jac[j, i] * rho
    for j in range(_SIZE):
        for k in range(j + 1):
            for i in range(n):
                info[j, k] += jac[j, i] * jac[k, i]
    # no wider than search, distances and force
    info[MIDDLE, MIDDLE] += 12.0 / (length * length)
    held = 1.0 / (size * size + 1e-300)
    info[HALF, HALF] += 12.0 / (wide * wide) if wide > 0.0 else held + 1e12 / (length * length)
    for k in (FIRST, SECOND):
        info[k, k] += held
        info[k + 1, k + 1] += held if mu > 0.0 else 2.0 * math.pi
    out = settled(gauss) - 0.5 * chi2
    for j, value in enumerate((middle, fit.half, n1, t1, n2, t2)):
        mean[j] += value
    leans = 0.0 < mu < math.inf
    for k in (FIRST, SECOND):
        for side in range(2 if leans else 1):
            edge[:] = 0.0
            edge[k], edge[k + 1] = (mu, 2.0 * side - 1.0) if leans else (1.0, 0.0)
            out += cut(gauss, 0.0)
    for side in range(2):  # the outer touches within the search
        edge[:] = 0.0
        edge[MIDDLE], edge[HALF] = 1.0 - 2.0 * side, -1.0
        out += cut(gauss, -edge[MIDDLE] * ends[side])
    for side in range(2 if wide > 0.0 else 0):
        edge[:] = 0.0
        edge[HALF] = 1.0 - 2.0 * side
        out += cut(gauss, -edge[HALF] * ends[2 + side])
    one, two = math.hypot(mean[FIRST], mean[FIRST + 1]), math.hypot(mean[SECOND], mean[SECOND + 1])
    # alike: midpoints, half distances, shares of the force, angles; the whole on a logarithmic scale
    out += math.log(length / max(length - 2.0 * fit.half, 1e-3 * length))
    out -= math.log(wide) if wide > 0.0 else 0.5 * (LOG_2PI - math.log(1e12 / (length * length)))
    out -= 2.0 * math.log(max(one + two, 1e-300))
    if mu > 0.0:
        out -= math.log(2.0 * lean) + math.log(max(one, 1e-300)) + math.log(max(two, 1e-300))
    return out


@compiled()
def weigh_pairs(w, single, pairs, mu, room, row, column):
    """Log of the evidence of two touches, as that of a kind but for chi-square; the least chi-square.

    The best pair goes to the row, from `column` on. single (n,): w in single precision.
    """
    grid, ends, c, s, tops = pairs.grid, pairs.ends, room.c, room.s, room.tops
    m, lean, box, fit = s.size, math.atan(mu), room.box, room.fits[0]
    _scan(single, pairs, np.float32(min(mu, 1e6)), c, s)
    length = ends[1] - ends[0]
    for k, end in enumerate((0.0, 1.0, ends[2], min(ends[3], 0.5 * length), -lean, lean, -lean, lean)):
        box[k] = end
    total, least, kept = -math.inf, math.inf, 0
    for _ in range(_STARTS):
        p = 0
        for k in range(m):
            p = k if s[k] > s[p] else p
        if not s[p] > 0.0:
            break
        middle, half = grid[0, p], grid[1, p]
        for k in range(m):  # its neighbours climb to the same
            if abs(grid[0, k] - middle) + abs(grid[1, k] - half) < 0.4 * pairs.near:
                s[k] = -1.0
        n1, t1, n2, t2 = _forces(pairs.back, c, p)
        n1, n2 = max(float(n1), 0.0), max(float(n2), 0.0)
        some = 1e-3 * (n1 + n2)
        room_left = length - 2.0 * half
        start = Both(
            (middle - half - ends[0]) / room_left if room_left > 0.0 else 0.5, half,
            math.atan(float(t1) / max(n1, some)), math.atan(float(t2) / max(n2, some)),
        )  # fmt: skip
        climb(w, room.model, _QUADRANT, box, start, Ending(_FINE, 0.0, 0.0, -math.inf), fit, room.fits[1])
        middle, new = _middle(fit, ends), True
        for e in range(kept):
            new &= abs(tops[e, 0] - middle) + abs(tops[e, 1] - fit.half) > 0.05 * pairs.near
        if not new:
            continue
        tops[kept, 0], tops[kept, 1] = middle, fit.half
        kept += 1
        if fit.left < least:
            least = fit.left
            p1, p2 = fit.n + fit.t, fit.n - fit.t
            row[column + POSITION], row[column + HALF_WIDTH] = middle, fit.half
            row[column + NORMAL] = p1 * math.cos(fit.first) + p2 * math.cos(fit.second)
            row[column + TANGENTIAL] = p1 * math.sin(fit.first) + p2 * math.sin(fit.second)
        if fit.left < least + 80.0:
            total = add(total, _weigh(w, fit, mu, lean, room))
    return total, least
