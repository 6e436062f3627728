"""What the evidence of an edge goes by: readings of narrow round contacts along a stretch of it."""

from __future__ import annotations

import math

import numpy as np

from ..._check import FloatArray
from ...array import SensorArray
from ...radial_round import RoundResponse
from ..area.edge import FEWEST, EdgeModel
from ..area.round_contact import model_of
from .kind import Kind

__all__ = ["edge_box", "edge_model", "pair_models"]

_RULE_ERROR = 3e-5
"""Error of the rule along the edge, as a share of the reading."""
_WIDTH_ERROR = 3e-5
"""Share of the readings that is left of the higher powers of the half width."""
_NARROW = 0.1
"""Depths up to which half widths are looked at in any case."""
_FORCES = (0.5, 0.3, 0.7)
"""Of two touches, the share of the force on the first."""


def edge_model(response: RoundResponse, array: SensorArray, kind: Kind) -> EdgeModel:
    """What climbs over edges go by.

    Parameters
    ----------
    response : RoundResponse
        Readings of spheres by the sensors of `array`, as far off as an edge's end may be.
    array : SensorArray
        Their noise.
    kind : Kind
        An edge's half widths and half lengths.
    """
    contact = model_of(response, array)
    depth = float(np.asarray(array.depth).min())
    most = max(kind.half_width[1], _NARROW * depth) ** 2
    # readings are analytic as near as the sensors are deep: so fast does Gauss's rule along the edge converge
    digits = -0.5 * math.log(_RULE_ERROR)
    largest = max(int(digits / math.asinh(depth / kind.half_length[1])) + 1, FEWEST)
    rules = np.zeros((largest + 1, 2, largest))
    for count in range(1, largest + 1):
        rules[count, :, :count] = np.polynomial.legendre.leggauss(count)
    narrow = contact._replace(sums=_powers(contact.sums, contact.most, most), most=most)
    return EdgeModel(narrow, rules, depth, digits, np.empty((0, 0)))


def pair_models(model: EdgeModel) -> list[EdgeModel]:
    """The same of two touches, in place of an edge's two ends, about the middle of their force.

    Parameters
    ----------
    model : EdgeModel
        That of an edge, as of `edge_model`.
    """
    found = []
    for share in _FORCES:
        middle = 1 - 2 * share
        rules = np.zeros((3, 2, 2))
        rules[2] = [[-1 - middle, 1 - middle], [2 * share, 2 - 2 * share]]
        found.append(model._replace(rules=rules))
    return found


def edge_box(search: FloatArray, kind: Kind) -> FloatArray:
    """Least and largest y, z, direction, half length, and square of the half width of an edge, shape (10,).

    Parameters
    ----------
    search : ndarray, shape (2, 2)
        Ends of y and of z [m].
    kind : Kind
        An edge's half widths and half lengths.
    """
    return np.array([*search.reshape(-1), -np.inf, np.inf, *kind.half_length, *np.square(kind.half_width)])


def _powers(sums: FloatArray, widest: float, most: float) -> FloatArray:
    """Chebyshev sums over squares of half widths to `widest`, as fewer to `most`: these change little."""
    nodes = np.cos(np.pi * (np.arange(sums.shape[-1]) + 0.5) / sums.shape[-1])
    there = np.polynomial.chebyshev.chebvander(most / widest * (1 + nodes) - 1, sums.shape[-1] - 1)
    to = np.linalg.solve(np.polynomial.chebyshev.chebvander(nodes, sums.shape[-1] - 1), there)
    short = sums @ to.T
    values = np.abs(short[:, ::4]).max(axis=0)  # of each function, in the middle of its cells
    left = np.cumsum((values / values[:, :1]).max(axis=0)[::-1])[::-1]
    count = max(int((left > _WIDTH_ERROR).sum()), 2)
    return np.ascontiguousarray(short[..., :count])
