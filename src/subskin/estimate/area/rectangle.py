"""Compiled: a rectangle, as the fitting kernel wants it: a patch, or, where it is narrow, an edge.

A force is spread over a rectangle, evenly or not, by a rule of Gauss's along its sides and across, over point loads
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

ROWS = 24
"""Rows of scratch a sensor needs: readings under N, Ty and Tz, and their slopes in each unknown."""
_FEWEST = 2
"""Least number of nodes along a side: then readings depend on its length."""
_Y, _Z, _TURN, _LENGTH, _Q, _LEAN, _TILT = range(3, ROWS, 3)
"""Rows at which slopes in these begin."""
RULE_ERROR = 3e-5
"""Error of the rule, as a share of the reading."""


class RectangleAt(NamedTuple):
    """The middle of a rectangle [m], its direction [rad], half length [m], and the square of its half width [m2].

    lean, tilt: by how much the pressure is more at the end of the length, and of the width, than in the middle [-].
    """

    y: float
    z: float
    direction: float
    length: float
    q: float
    lean: float
    tilt: float


class RectangleModel(NamedTuple):
    """Some sensors, and what they read of rectangles.

    points: of point loads; along, across (k + 1, 2, k): nodes on (-1, 1) and weights, whose sum is 2, of so many nodes;
    depth: the least one; leans: 1 where slopes in lean and tilt are asked for, else 0; rows (ROWS, n): scratch.
    """

    points: PointModel
    along: FloatArray
    across: FloatArray
    depth: float
    leans: float
    rows: FloatArray


def rules(half: float, depth: float, profile: tuple[FloatArray, FloatArray] | None = None) -> FloatArray:
    """Rules for sides up to `half` [m], over the least `depth` [m], as `RectangleModel` has them.

    Parameters
    ----------
    half, depth : float
        The longest half side, and the shallowest sensor [m].
    profile : (ndarray, ndarray), optional
        Many points of (-1, 1), and what the pressure has there; even in them, and alike if it is left out.
    """
    at, mass = np.polynomial.legendre.leggauss(_DENSE) if profile is None else profile
    largest = _needed(half, depth)
    out = np.zeros((largest + 1, 2, largest))
    root, before, beta = np.sqrt(mass / mass.sum()), np.zeros_like(at), list[float]()
    for count in range(1, largest + 1):  # Lanczos: polynomials that are orthogonal under the profile
        t, turned = np.linalg.eigh(np.diag(beta, 1) + np.diag(beta, -1))
        out[count, 0, :count], out[count, 1, :count] = t, 2 * turned[0] ** 2
        after = at * root - (beta[-1] if beta else 0.0) * before
        beta.append(float(np.linalg.norm(after)))
        root, before = after / beta[-1], root
    return out


_DENSE = 200
"""Nodes by which an even pressure is told."""
_DIGITS = -0.5 * math.log(RULE_ERROR)


def _needed(half: float, depth: float) -> int:
    """How many nodes a half side needs: readings are analytic as near to it as the sensors are deep."""
    return max(int(_DIGITS / math.asinh(depth / half)) + 1, _FEWEST)


_nodes = compiled(inline=True)(_needed)


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
        even = 0.25 * model.along[long, 1, p // wide] * model.across[wide, 1, p % wide]
        share = even * (1.0 + at.lean * u + at.tilt * v)
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
            if model.leans > 0.0:
                b[_LEAN, i] += even * u * r_n
                b[_LEAN + 1, i] += even * u * r_y
                b[_LEAN + 2, i] += even * u * r_z
                b[_TILT, i] += even * v * r_n
                b[_TILT + 1, i] += even * v * r_y
                b[_TILT + 2, i] += even * v * r_z


FIT, project, slopes, information, keep, climb, covariance = kernel(RectangleAt, rectangle_field, direction=0.5)
