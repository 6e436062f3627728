"""Compiled: a round contact of some half width, as the fitting kernel wants it.

Its unknowns are y, z and q, the square of the half width, in which readings are analytic. Tables are those of
`RoundResponse.cubics`, sums over Chebyshev's polynomials of q, whose values at one q are its shares. A moment about the
normal is one more component, which nothing binds.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ...array import SensorArray
from ...radial_round import RoundResponse
from ..varpro import kernel
from . import point
from .point import CELLS, harmonic, laid_out

ROWS = 16
"""Rows of scratch a sensor needs: readings under N, Ty and Tz, their slopes in y, z and q; the same of a moment."""


BY_Q, MOMENT = 9, 12
"""Rows at which slopes in q begin, and those of a moment."""
_PAIR = np.array([[0, 0, 0, 0, 1], [1, 1, 0, 1, 1], [2, 1, 1, 1, 1]])
"""Terms of a response that is but f and g."""


class RoundAt(NamedTuple):
    """Where a contact presses [m], and the square of its half width [m2]."""

    y: float
    z: float
    q: float


class RoundModel(NamedTuple):
    """Some sensors, and what they read of contacts.

    sensors, first: as of `PointModel`; sums (rows, numbers, widths) and terms: of forces; most: the largest q of these;
    turns and turned: the same of a moment, no terms where there is none; shares (2, widths), part (functions, 3) and
    rows (ROWS, n): scratch, rows of a moment that is not there being 0.
    """

    sensors: FloatArray
    first: npt.NDArray[np.int64]
    sums: FloatArray
    terms: npt.NDArray[np.int64]
    most: float
    turns: FloatArray
    turned: npt.NDArray[np.int64]
    shares: FloatArray
    part: FloatArray
    rows: FloatArray


_MADE = RoundModel._fields.index("shares")
"""Fields of a model that are no scratch."""


def model_of(response: RoundResponse, array: SensorArray) -> RoundModel:
    """What climbs over round contacts go by, without a moment and without the loop's scratch.

    Parameters
    ----------
    response : RoundResponse
        Readings under unit forces of the sensors of `array`.
    array : SensorArray
        Their noise.
    """
    return tables_of(response, array)[0]


def tables_of(response: RoundResponse, array: SensorArray) -> tuple[RoundModel, float, npt.NDArray[Any], int]:
    """As `model_of`; the error of its tables, the terms of point loads that read so, and the cells of a kind."""
    response, none = response.separate(), np.empty((0, 0))
    sums, error = response.cubics()
    sums, terms, cells = laid_out(response.table, sums)
    own = point.model_of(response.table, np.asarray(array.noise), cells, sums, terms if len(terms) else _PAIR)
    model = RoundModel(
        own.sensors, own.first, sums, own.terms, response.widest**2, sums[:0], own.terms[:0], none, none, none
    )
    return model, error, terms, cells


@compiled(inline=True)
def in_room(model):
    """The model with scratch of its own."""
    shares = np.empty((2, model.sums.shape[2]))
    part = np.empty((max(model.sums.shape[1], model.turns.shape[1]) // 4, 3))
    rows = np.zeros((ROWS, model.sensors.shape[1]))
    return RoundModel(*model[:_MADE], shares, part, rows)


@compiled(borrows=True)
def shares_of(q, most, shares):
    """Chebyshev's polynomials of 2 q / most - 1, and their slopes in q; shares (2, widths)."""
    x, slope = 2.0 * q / most - 1.0, 2.0 / most
    shares[0, 0], shares[1, 0] = 1.0, 0.0
    shares[0, 1], shares[1, 1] = x, slope
    for j in range(2, shares.shape[1]):
        shares[0, j] = 2.0 * x * shares[0, j - 1] - shares[0, j - 2]
        shares[1, j] = 2.0 * (slope * shares[0, j - 1] + x * shares[1, j - 1]) - shares[1, j - 2]


@compiled(borrows=True)
def at_width(model, q, table):
    """The table of point loads that reads as contacts of one width do."""
    sums, shares = model.sums, model.shares
    shares_of(q, model.most, shares)
    for k in range(sums.shape[0]):
        for e in range(sums.shape[1]):
            total = 0.0
            for j in range(sums.shape[2]):
                total += sums[k, e, j] * shares[0, j]
            table[k, e] = total


@compiled(borrows=True)
def add_field(model, sums, terms, y, z, rows, spaced):
    """Add the readings under unit loads to `rows`, and their slopes in y, z and q, each so many rows on; by shares."""
    sensors, first, shares, part, n = model.sensors, model.first, model.shares, model.part, model.sensors.shape[1]
    last = first[n]
    for i in range(n):
        dy, dz = sensors[0, i] - y, sensors[1, i] - z
        share, octave = math.frexp(1.0 + (dy * dy + dz * dz) * sensors[2, i])
        at = (2.0 * share - 1.0) * CELLS
        cell = int(at)
        k, t = first[i] + min(64 * (octave - 1) + cell, last), at - cell - 0.5
        steep = math.ldexp(2.0 * CELLS, 1 - octave) * sensors[2, i]
        for e in range(sums.shape[1] // 4):
            value = slope = wider = 0.0
            for j in range(shares.shape[1]):
                c1, c2, c3 = sums[k, 4 * e + 1, j], sums[k, 4 * e + 2, j], sums[k, 4 * e + 3, j]
                here = sums[k, 4 * e, j] + t * (c1 + t * (c2 + t * c3))
                value += here * shares[0, j]
                wider += here * shares[1, j]
                slope += (c1 + t * (2.0 * c2 + 3.0 * t * c3)) * shares[0, j]
            part[e, 0], part[e, 1], part[e, 2] = value, steep * slope, wider
        for j in range(terms.shape[0]):
            row, e, scale = terms[j, 0], terms[j, 3], sensors[3, i] * terms[j, 4]
            shape, by_y, by_z = harmonic(terms[j, 1], terms[j, 2], dy, dz)
            f, df = scale * part[e, 0], scale * part[e, 1]
            rows[row, i] += f * shape
            rows[spaced + row, i] -= df * dy * shape + f * by_y
            rows[2 * spaced + row, i] -= df * dz * shape + f * by_z
            rows[3 * spaced + row, i] += scale * part[e, 2] * shape


@compiled(borrows=True)
def round_field(model, at):
    """Rows 0 to 2 the readings under unit N, Ty, Tz, then their slopes in y, z and q; 12 to 15 those of a moment."""
    rows = model.rows
    for row in range(MOMENT if model.turned.shape[0] == 0 else ROWS):
        for i in range(rows.shape[1]):
            rows[row, i] = 0.0
    shares_of(at.q, model.most, model.shares)
    add_field(model, model.sums, model.terms, at.y, at.z, rows, 3)
    if model.turned.shape[0] > 0:
        add_field(model, model.turns, model.turned, at.y, at.z, rows[MOMENT:], 1)


FIT, project, slopes, information, keep, climb, covariance = kernel(RoundAt, round_field, free="moment")
