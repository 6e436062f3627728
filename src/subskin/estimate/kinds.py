"""Compiled: what a row of sensors reads under a line load and under a contact of some width, and the fits of both.

A kind is its field and the names of its unknowns; all else is made by `varpro`. Of a width the unknown is its
square, q: readings are smooth in it down to no width at all. docs/locating.md, docs/fitting.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._compiled import compiled
from .varpro import Ending, kernel

LINE_ROWS = 6
"""Rows of a line load's field: A_N and A_T, their slopes, and their second slopes."""


class Along(NamedTuple):
    """Where a line load presses."""

    y: float


class Line(NamedTuple):
    """Readings under line loads: table (cells, 5, 2, n), whitened, its start and step; rows (LINE_ROWS, n): scratch."""

    table: npt.NDArray[np.float64]
    start: float
    step: float
    rows: npt.NDArray[np.float64]


class Across(NamedTuple):
    """Where a contact presses, and the square of its half width."""

    y: float
    q: float


class Wide(NamedTuple):
    """Readings under contacts of any width up to a `widest`: table (cells, widths, 10 n), whitened, its start and step.

    In each cell stand the powers of t, for N and T each, as Chebyshev sums in 2 q / widest^2 - 1. rows (12, n) and
    sums (3, 10 n + widths + 3): scratch.
    """

    table: npt.NDArray[np.float64]
    start: float
    step: float
    widest: float
    rows: npt.NDArray[np.float64]
    sums: npt.NDArray[np.float64]


@compiled(inline=True)
def line_at(model, at):
    """The cell of a `Line` in which `at` lies, where in it, and how much of it a length is."""
    position = (at.y - model.start) / model.step
    cell = min(max(int(position), 0), model.table.shape[0] - 1)
    return cell, position - cell - 0.5, 1.0 / model.step


@compiled(inline=True)
def line_read(model, here, i):
    """A_N and A_T of sensor i, their slopes and their second slopes in y."""
    cell, t, d1 = here
    table, d2 = model.table, d1 * d1
    n0, n1, n2, n3, n4 = (
        table[cell, 0, 0, i], table[cell, 1, 0, i], table[cell, 2, 0, i], table[cell, 3, 0, i], table[cell, 4, 0, i]
    )  # fmt: skip
    t0, t1, t2, t3, t4 = (
        table[cell, 0, 1, i], table[cell, 1, 1, i], table[cell, 2, 1, i], table[cell, 3, 1, i], table[cell, 4, 1, i]
    )  # fmt: skip
    return (
        n0 + t * (n1 + t * (n2 + t * (n3 + t * n4))), t0 + t * (t1 + t * (t2 + t * (t3 + t * t4))),
        d1 * (n1 + t * (2 * n2 + t * (3 * n3 + t * (4 * n4)))), d1 * (t1 + t * (2 * t2 + t * (3 * t3 + t * (4 * t4)))),
        d2 * (2 * n2 + t * (6 * n3 + t * (12 * n4))), d2 * (2 * t2 + t * (6 * t3 + t * (12 * t4))),
    )  # fmt: skip


@compiled(borrows=True)
def line_field(model, at):
    """The same of all sensors, into the rows of a `Line`."""
    a, here = model.rows, line_at(model, at)
    for i in range(a.shape[1]):
        a[0, i], a[1, i], a[2, i], a[3, i], a[4, i], a[LINE_ROWS - 1, i] = line_read(model, here, i)


@compiled(borrows=True)
def wide_field(model, at):
    """The same of a `Wide`: A_N and A_T, their slopes in y and q, then those in yy, yq and qq."""
    table, c, a = model.table, model.sums, model.rows
    cells, widths, size = table.shape
    n = size // 10
    position = (at.y - model.start) / model.step
    cell = min(max(int(position), 0), cells - 1)
    t = position - cell - 0.5
    slope = 2.0 / (model.widest * model.widest)
    x = slope * at.q - 1.0
    v0, v1, v2 = c[0], c[1], c[2]  # the sums, and their first and second derivatives in x
    for j in range(size):
        v0[j] = v1[j] = v2[j] = 0.0
    h0, h1, h2 = v0[size:], v1[size:], v2[size:]  # Chebyshev polynomials, and their derivatives
    h0[0], h1[0], h2[0], h0[1], h1[1], h2[1] = 1.0, 0.0, 0.0, x, 1.0, 0.0
    for k in range(2, widths):
        h0[k] = 2 * x * h0[k - 1] - h0[k - 2]
        h1[k] = 2 * h0[k - 1] + 2 * x * h1[k - 1] - h1[k - 2]
        h2[k] = 4 * h1[k - 1] + 2 * x * h2[k - 1] - h2[k - 2]
    for k in range(widths, widths + 3):
        h0[k] = h1[k] = h2[k] = 0.0
    for k in range(0, widths, 4):  # four at once: the sums go through memory less often
        r0, r1 = table[cell, k], table[cell, min(k + 1, widths - 1)]
        r2, r3 = table[cell, min(k + 2, widths - 1)], table[cell, min(k + 3, widths - 1)]
        p0, p1, p2, p3 = h0[k], h0[k + 1], h0[k + 2], h0[k + 3]
        q0, q1, q2, q3 = h1[k], h1[k + 1], h1[k + 2], h1[k + 3]
        s0, s1, s2, s3 = h2[k], h2[k + 1], h2[k + 2], h2[k + 3]
        for j in range(size):
            t0, t1, t2, t3 = r0[j], r1[j], r2[j], r3[j]
            v0[j] += (p0 * t0 + p1 * t1) + (p2 * t2 + p3 * t3)
            v1[j] += (q0 * t0 + q1 * t1) + (q2 * t2 + q3 * t3)
            v2[j] += (s0 * t0 + s1 * t1) + (s2 * t2 + s3 * t3)
    d1 = 1.0 / model.step
    d2 = d1 * d1
    two_n = 2 * n
    for side in range(2):
        for i in range(n):
            j = side * n + i
            c1, c2, c3, c4 = v0[two_n + j], v0[2 * two_n + j], v0[3 * two_n + j], v0[4 * two_n + j]
            a[side, i] = v0[j] + t * (c1 + t * (c2 + t * (c3 + t * c4)))
            a[2 + side, i] = d1 * (c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4))))
            a[_YY + side, i] = d2 * (2 * c2 + t * (6 * c3 + t * (12 * c4)))
            c1, c2, c3, c4 = v1[two_n + j], v1[2 * two_n + j], v1[3 * two_n + j], v1[4 * two_n + j]
            a[4 + side, i] = slope * (v1[j] + t * (c1 + t * (c2 + t * (c3 + t * c4))))
            a[_YQ + side, i] = slope * d1 * (c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4))))
            c1, c2, c3, c4 = v2[two_n + j], v2[2 * two_n + j], v2[3 * two_n + j], v2[4 * two_n + j]
            a[_QQ + side, i] = slope * slope * (v2[j] + t * (c1 + t * (c2 + t * (c3 + t * c4))))


_YY, _YQ, _QQ = 6, 8, 10
"""Rows of the second slopes in y and q."""

_LINE = kernel(Along, None, 2, bent=True, read=line_read, where=line_at)
_WIDE = kernel(Across, wide_field, 2, bent=True)
LINE_FIT, climb_line, line_covariance, project_line = _LINE.fit, _LINE.climb, _LINE.covariance, _LINE.project
WIDE_FIT, climb_wide, wide_covariance = _WIDE.fit, _WIDE.climb, _WIDE.covariance
project_wide, wide_slopes, wide_information = _WIDE.project, _WIDE.slopes, _WIDE.information


@compiled()
def modelled(table, told):
    """The model of a table: a `Wide` of one with three axes, else a `Line`; told: settings."""
    n = table.shape[2] // 10 if table.ndim == 3 else table.shape[3]
    if table.ndim == 3:
        sums = np.empty((3, table.shape[2] + table.shape[1] + 3))
        return Wide(table, told.start, told.step, told.widest, np.empty((12, n)), sums)
    return Line(table, told.start, told.step, np.empty((LINE_ROWS, n)))


@compiled(inline=True)
def until(gain):
    """A climb ends with a step that raises S by less than this, which is still made."""
    return Ending(gain, 0.0, 0.0, -math.inf)


@compiled()
def top_from(w, table, model, cone, ends, y, q, ending, fit, trial):
    """Climb from y, and the square q of the half width, within `ends`, low and high of each, into `fit`."""
    if table.ndim == 3:
        climb_wide(w, model, cone, ends, Across(y, q), ending, fit, trial)
    else:
        climb_line(w, model, cone, ends, Along(y), ending, fit, trial)


@compiled()
def width_of(table, fit):
    """Half width of what was found; 0 of a line load."""
    if table.ndim == 3:
        return math.sqrt(fit.q)
    return 0.0
