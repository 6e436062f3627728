"""Compiled: a point load, as the fitting kernel wants it: its unknowns y and z, and its field from radial tables.

Tables are those of `RadialResponse.cubics`. Where a reading is N f(u) + (Ty dy + Tz dz) g(u), d from the load to the
sensor, f, g and their slopes in u are all that is read off them.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ...array import SensorArray
from ...radial import RadialResponse
from ..varpro import kernel

ROWS = 14
"""Rows of scratch a sensor needs: readings under N, Ty and Tz, their slopes in y, in z, and five more."""
CELLS, ONE, REST = 64.0, np.int64(1023 << 52), np.int64((1 << 46) - 1)
"""Cells of an octave; the bits of 1.0; those that say where in its cell a number is."""
BY_Y, BY_Z = 3, 6
"""Rows at which slopes begin."""
_DY, _DZ, _V, _CELL, _OCTAVE = 9, 10, 11, 12, 13
_G = 4
"""Column of the tables at which the second function begins."""
_SHIFT, _EXPONENT = np.int64(46), np.int64(0x7FF << 52)
_FIRST, _TWICE = np.int64(1023 << 6), np.int64(2046 << 52)


class Point(NamedTuple):
    """Where a load presses [m]."""

    y: float
    z: float


class PointModel(NamedTuple):
    """Some sensors, and what they read of loads.

    sensors (4, n): y, z, 1 / depth^2, scale; first (n + 1,): the first row of each sensor's kind, then the last cell;
    table (kinds cells, 4 functions): powers 0 to 3 of each function in turn; terms (terms, 5), or none for harmonics
    0 and 1 alone; rows (ROWS, n or more): scratch, and bits: the same memory as integers.
    """

    sensors: FloatArray
    first: npt.NDArray[np.int64]
    table: FloatArray
    terms: npt.NDArray[np.int64]
    rows: FloatArray
    bits: npt.NDArray[np.int64]


def laid_out(
    response: RadialResponse, table: FloatArray, pairs: bool = True
) -> tuple[FloatArray, npt.NDArray[Any], int]:
    """Tables (kinds, cells, functions, 4, ...) of a response as loops want them, their terms, and the cells of a kind.

    Of harmonics 0 and 1 alone f and g, as `read` takes them, and no terms, unless `pairs` is False.
    """
    terms, cells = response.terms, table.shape[1]
    if pairs and response.pair is not None:
        table = np.stack([sign * table[:, :, function] for function, sign in response.pair], axis=2)
        terms = terms[:0]
    rows, functions = table.shape[0] * cells, 4 * table.shape[2]
    return np.ascontiguousarray(table.reshape(rows, functions, *table.shape[4:])), terms, cells


def model_of(
    response: RadialResponse, noise: FloatArray, cells: int, table: FloatArray, terms: npt.NDArray[Any]
) -> PointModel:
    """What sensors of such a response and noise (n,) read, in tables of so many cells; without the loop's scratch."""
    sensors = np.stack([*response.points.T, response.depth**-2.0, response.gain / noise])
    first = np.append(response.kind * cells, cells - 1).astype(np.int64)
    terms, none = np.ascontiguousarray(terms).astype(np.int64), np.empty((0, 0))
    return PointModel(np.ascontiguousarray(sensors), first, table, terms, none, none.view(np.int64))


def tabulated(response: RadialResponse, array: SensorArray) -> tuple[PointModel, float]:
    """What the sensors of `array` read by a response, without the loop's scratch; and the error of its tables."""
    response = response.separate()
    table, error = response.cubics()
    series = response.series() if response.pair is not None else None
    if series is not None:  # one cell holds all distances
        table, error = series[0][None, None], series[1]
    table, terms, cells = laid_out(response, table)
    return model_of(response, np.asarray(array.noise), cells, table, terms), error


@compiled(inline=True)
def in_room(model, n):
    """A `PointModel` that came without its names and scratch, with scratch for n sensors."""
    rows = np.empty((ROWS, n + 1))
    return PointModel(*model[:4], rows, rows.view(np.int64))


@compiled(inline=True)
def cell_of(bits, last):
    """The cell in which a number of these bits lies, the `last` one at most."""
    cell = (bits >> _SHIFT) - _FIRST
    return cell if cell < last else last


@compiled(inline=True)
def coefficients(table, k):
    """The four of f and the four of g in a row of the tables."""
    return (
        table[k, 0], table[k, 1], table[k, 2], table[k, 3],
        table[k, _G], table[k, _G + 1], table[k, _G + 2], table[k, _G + 3],
    )  # fmt: skip


@compiled(inline=True)
def read(model, _, i):
    """What sensor i reads under N, Ty and Tz, and the slopes of that in y and in z: of f and g, or of any harmonics."""
    rows = model.rows
    if model.terms.shape[0] == 0:
        dy, dz, g, slope, steep = rows[_DY, i], rows[_DZ, i], rows[1, i], rows[2, i], rows[BY_Y, i]
        return (
            rows[0, i], dy * g, dz * g, dy * slope, dy * dy * steep - g, dy * dz * steep,
            dz * slope, dy * dz * steep, dz * dz * steep - g,
        )  # fmt: skip
    return (
        rows[0, i], rows[1, i], rows[2, i], rows[BY_Y, i], rows[BY_Y + 1, i], rows[BY_Y + 2, i],
        rows[BY_Z, i], rows[BY_Z + 1, i], rows[BY_Z + 2, i],
    )  # fmt: skip


@compiled(inline=True)
def _series(sensors, table, at, rows):
    """All rows by the series."""
    f0, f1, f2, f3, g0, g1, g2, g3 = coefficients(table, 0)
    for i in range(sensors.shape[1]):
        dy, dz, q = sensors[0, i] - at.y, sensors[1, i] - at.z, sensors[2, i]
        x = 1.0 / (1.0 + (dy * dy + dz * dz) * q)
        size = sensors[3, i] * x * math.sqrt(x)
        slope = size * x * q
        f, f_slope = f0 + x * (f1 + x * (f2 + x * f3)), 3.0 * f0 + x * (5.0 * f1 + x * (7.0 * f2 + x * (9.0 * f3)))
        g, g_slope = g0 + x * (g1 + x * (g2 + x * g3)), 3.0 * g0 + x * (5.0 * g1 + x * (7.0 * g2 + x * (9.0 * g3)))
        rows[_DY, i], rows[_DZ, i] = dy, dz
        rows[0, i], rows[1, i], rows[2, i], rows[BY_Y, i] = size * f, size * g, slope * f_slope, slope * g_slope


@compiled(borrows=True)
def _harmonics(sensors, table, terms, rows, bits):
    """All rows, of any harmonics."""
    for i in range(sensors.shape[1]):
        for row in range(9):
            rows[row, i] = 0.0
        k, t, dy, dz = bits[_CELL, i], rows[_V, i] * CELLS - (CELLS + 0.5), rows[_DY, i], rows[_DZ, i]
        steep = 2.0 * CELLS * rows[_OCTAVE, i] * sensors[2, i]
        for j in range(terms.shape[0]):
            row, order, part, scale = terms[j, 0], terms[j, 1], terms[j, 2], sensors[3, i] * terms[j, 4]
            e = 4 * terms[j, 3]
            c1, c2, c3 = table[k, e + 1], table[k, e + 2], table[k, e + 3]
            f = scale * (table[k, e] + t * (c1 + t * (c2 + t * c3)))
            df = scale * steep * (c1 + t * (2.0 * c2 + 3.0 * t * c3))
            shape, by_y, by_z = harmonic(order, part, dy, dz)
            rows[row, i] += f * shape
            rows[BY_Y + row, i] -= df * dy * shape + f * by_y
            rows[BY_Z + row, i] -= df * dz * shape + f * by_z


@compiled(inline=True)
def harmonic(order, imaginary, dy, dz):
    """The real or imaginary part of (dy + i dz)^order, and its slopes."""
    re, im, below_re, below_im = 1.0, 0.0, 0.0, 0.0
    for _ in range(order):
        below_re, below_im = re, im
        re, im = re * dy - im * dz, re * dz + im * dy
    if imaginary:
        return im, order * below_im, order * below_re
    return re, order * below_re, -order * below_im


@compiled(inline=True)
def point_field(model, at):
    """Rows 0 to 2 the readings under unit N, Ty, Tz, 3 to 5 their slopes in y, 6 to 8 in z, of any harmonics.

    Without terms rows 0 and 1 are f and g, 2 and 3 their slopes over -2 dy or -2 dz: `read` makes the others of these.

    The first six digits of v = 1 + u / depth^2 behind its leading one count the cells of an octave, the rest says
    where in the cell (`radial.CELLS`). Where the last cell is the first one, its numbers are those of v^(-3/2) to
    v^(-9/2) (`RadialResponse.series`).
    """
    sensors, first, table, rows, bits = model.sensors, model.first, model.table, model.rows, model.bits
    n = sensors.shape[1]
    last = first[n]
    if last == 0:
        _series(sensors, table, at, rows)
        return
    for i in range(n):
        dy, dz = sensors[0, i] - at.y, sensors[1, i] - at.z
        rows[_DY, i], rows[_DZ, i], rows[_V, i] = dy, dz, 1.0 + (dy * dy + dz * dz) * sensors[2, i]
    for i in range(n):
        v = bits[_V, i]
        bits[_CELL, i] = first[i] + cell_of(v, last)
        bits[_OCTAVE, i] = _TWICE - (v & _EXPONENT)
        bits[_V, i] = (v & REST) | ONE
    if model.terms.shape[0] > 0:
        _harmonics(sensors, table, model.terms, rows, bits)
        return
    for i in range(n):
        k, t = np.uint64(bits[_CELL, i]), rows[_V, i] * CELLS - (CELLS + 0.5)
        f0, f1, f2, f3, g0, g1, g2, g3 = coefficients(table, k)
        rows[0, i], rows[2, i] = f0 + t * (f1 + t * (f2 + t * f3)), f1 + t * (2.0 * f2 + 3.0 * t * f3)
        rows[1, i], rows[BY_Y, i] = g0 + t * (g1 + t * (g2 + t * g3)), g1 + t * (2.0 * g2 + 3.0 * t * g3)
    for i in range(n):
        scale = sensors[3, i]
        slope = -2.0 * CELLS * scale * rows[_OCTAVE, i] * sensors[2, i]
        rows[0, i], rows[1, i] = scale * rows[0, i], scale * rows[1, i]
        rows[2, i], rows[BY_Y, i] = slope * rows[2, i], slope * rows[BY_Y, i]


FIT, project, slopes, information, keep, climb, covariance = kernel(Point, point_field, read=read, looks=False)
