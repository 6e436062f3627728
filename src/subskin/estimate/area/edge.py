"""Compiled: an edge, as the fitting kernel wants it.

An edge is a force spread evenly along a straight stretch, of half length l, and across it as narrow spheres of half
width a are: Gauss and Legendre's rule along the stretch, over round contacts of that width (`round_contact.py`). After
half a turn an edge is the same.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._check import FloatArray
from ..._compiled import compiled
from ..varpro import kernel
from .point import BY_Y, BY_Z
from .round_contact import BY_Q, MOMENT, RoundModel, add_field, shares_of

ROWS = 18
"""Rows of scratch a sensor needs: readings under N, Ty and Tz, and their slopes in each unknown."""
FEWEST = 4
"""Least number of nodes along an edge."""
_TURN, _LENGTH, _Q = 9, 12, 15
"""Rows at which slopes in these begin."""


class EdgeAt(NamedTuple):
    """The middle of an edge [m], its direction [rad], half length [m], and the square of its half width [m2]."""

    y: float
    z: float
    direction: float
    length: float
    q: float


class EdgeModel(NamedTuple):
    """Some sensors, and what they read of edges.

    contact: of round contacts, whose rows are scratch; rules: on (-1, 1), nodes and weights of so many nodes, shape
    (rules, 2, nodes); depth: the least one; digits: how many nodes a rule needs, over 1 / arsinh of that depth in half
    lengths; rows (ROWS, n): scratch.
    """

    contact: RoundModel
    rules: FloatArray
    depth: float
    digits: float
    rows: FloatArray


@compiled(borrows=True)
def edge_field(model, at):
    """Rows 0 to 2 the readings under unit N, Ty, Tz, then their slopes in the unknowns."""
    contact, b, one = model.contact, model.rows, model.contact.rows
    n, c, s = b.shape[1], math.cos(at.direction), math.sin(at.direction)
    shares_of(at.q, contact.most, contact.shares)
    count = min(max(int(model.digits / math.asinh(model.depth / at.length)) + 1, FEWEST), model.rules.shape[0] - 1)
    rule = model.rules[count]
    for row in range(ROWS):
        for i in range(n):
            b[row, i] = 0.0
    for node in range(count):
        along, share = rule[0, node], 0.5 * rule[1, node]
        away = along * at.length
        for row in range(MOMENT):
            for i in range(n):
                one[row, i] = 0.0
        add_field(contact, contact.sums, contact.terms, at.y + away * c, at.z + away * s, one, 3)
        for row in range(3):
            for i in range(n):
                by_y, by_z = share * one[BY_Y + row, i], share * one[BY_Z + row, i]
                b[row, i] += share * one[row, i]
                b[BY_Y + row, i] += by_y
                b[BY_Z + row, i] += by_z
                b[_TURN + row, i] += away * (c * by_z - s * by_y)
                b[_LENGTH + row, i] += along * (c * by_y + s * by_z)
                b[_Q + row, i] += share * one[BY_Q + row, i]


FIT, project, slopes, information, keep, climb, covariance = kernel(EdgeAt, edge_field, direction=0.5)
