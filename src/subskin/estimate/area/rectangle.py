"""Compiled: a rectangle, as the fitting kernel wants it: a patch, or, where it is narrow, an edge.

A force is spread over a rectangle, evenly or not, by Gauss and Legendre's rule along and across, over point loads
(`point.py`). After half a turn a rectangle is the same. Readings are smooth in the square of the half width.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._check import FloatArray
from ..._compiled import compiled
from ..varpro import kernel
from .point import Point, PointModel, point_field, read

ROWS = 27
"""Rows of scratch a sensor needs: readings under N, Ty and Tz, and their slopes in each unknown."""
_FEWEST = 2
"""Least number of nodes along a side: then readings depend on its length."""
_Y, _Z, _TURN, _LENGTH, _Q, _LEAN, _TILT, _HOLLOW = range(3, ROWS, 3)
"""Rows at which slopes in these begin."""
_RULE_ERROR = 3e-6
"""Where the digits of the rule end."""
FIELD_ERROR = 2e-4
"""What that leaves of a reading of strain at most, as a share of the largest (tests/verification/test_patches.py)."""


class RectangleAt(NamedTuple):
    """The middle of a rectangle [m], its direction [rad], half length [m], and the square of its half width [m2].

    lean, tilt, hollow: of the pressure 1 + lean u + tilt v + hollow (u^2 + v^2 - 2/3), over its mean, at (u, v) of half
    the length and the width [-].
    """

    y: float
    z: float
    direction: float
    length: float
    q: float
    lean: float
    tilt: float
    hollow: float


class RectangleModel(NamedTuple):
    """Some sensors, and what they read of rectangles.

    points: of point loads; along, across (k + 1, 2, k): nodes on (-1, 1) and weights, whose sum is 2, of so many nodes;
    depth: the least one; uneven: 1 where slopes in lean, tilt and hollow are asked for, else 0; rows (ROWS, n):
    scratch.
    """

    points: PointModel
    along: FloatArray
    across: FloatArray
    depth: float
    uneven: float
    rows: FloatArray


def rules(half: float, depth: float) -> FloatArray:
    """Gauss and Legendre's rules for sides up to `half` [m], the least `depth` [m] above sensors, as of a model."""
    largest = _needed(half, depth)
    out = np.zeros((largest + 1, 2, largest))
    for count in range(1, largest + 1):
        out[count, :, :count] = np.polynomial.legendre.leggauss(count)
    return out


_DIGITS = -0.5 * math.log(_RULE_ERROR)


def _needed(half: float, depth: float) -> int:
    """How many nodes a half side needs: readings are analytic as near to it as the sensors are deep."""
    return max(int(_DIGITS / math.asinh(depth / half)) + 1, _FEWEST)


_nodes = compiled(inline=True)(_needed)


@compiled(inline=True)
def even(y, z, direction, length, q):
    """A rectangle whose pressure is even."""
    return RectangleAt(y, z, direction, length, q, 0.0, 0.0, 0.0)


@compiled(borrows=True)
def rectangle_field(model, at):
    """Rows 0 to 2 the readings under unit N, Ty, Tz, then their slopes in the unknowns."""
    points, b = model.points, model.rows
    n, c, s, half = b.shape[1], math.cos(at.direction), math.sin(at.direction), max(math.sqrt(at.q), 1e-6 * model.depth)
    long = min(_nodes(at.length, model.depth), model.along.shape[0] - 1)
    wide = min(_nodes(half, model.depth), model.across.shape[0] - 1)
    for row in range(ROWS):
        for i in range(n):
            b[row, i] = 0.0
    for p in range(long * wide):
        u, v = model.along[long, 0, p // wide], model.across[wide, 0, p % wide]
        mean = 0.25 * model.along[long, 1, p // wide] * model.across[wide, 1, p % wide]
        bowl = u * u + v * v - 2.0 / 3.0
        share = mean * (1.0 + at.lean * u + at.tilt * v + at.hollow * bowl)
        by, bz = u * at.length * c - v * half * s, u * at.length * s + v * half * c
        point_field(points, Point(at.y + by, at.z + bz))
        wider, longer = 0.5 * share * v / half, share * u
        for i in range(n):
            r_n, r_y, r_z, y_n, y_y, y_z, z_n, z_y, z_z = read(points, 0, i)
            b[0, i] += share * r_n
            b[1, i] += share * r_y
            b[2, i] += share * r_z
            b[_Y, i] += share * y_n
            b[_Y + 1, i] += share * y_y
            b[_Y + 2, i] += share * y_z
            b[_Z, i] += share * z_n
            b[_Z + 1, i] += share * z_y
            b[_Z + 2, i] += share * z_z
            b[_TURN, i] += share * (by * z_n - bz * y_n)
            b[_TURN + 1, i] += share * (by * z_y - bz * y_y)
            b[_TURN + 2, i] += share * (by * z_z - bz * y_z)
            b[_LENGTH, i] += longer * (c * y_n + s * z_n)
            b[_LENGTH + 1, i] += longer * (c * y_y + s * z_y)
            b[_LENGTH + 2, i] += longer * (c * y_z + s * z_z)
            b[_Q, i] += wider * (c * z_n - s * y_n)
            b[_Q + 1, i] += wider * (c * z_y - s * y_y)
            b[_Q + 2, i] += wider * (c * z_z - s * y_z)
            if model.uneven > 0.0:
                b[_LEAN, i] += mean * u * r_n
                b[_LEAN + 1, i] += mean * u * r_y
                b[_LEAN + 2, i] += mean * u * r_z
                b[_TILT, i] += mean * v * r_n
                b[_TILT + 1, i] += mean * v * r_y
                b[_TILT + 2, i] += mean * v * r_z
                b[_HOLLOW, i] += mean * bowl * r_n
                b[_HOLLOW + 1, i] += mean * bowl * r_y
                b[_HOLLOW + 2, i] += mean * bowl * r_z


FIT, project, slopes, information, keep, climb, covariance = kernel(RectangleAt, rectangle_field, direction=0.5)
