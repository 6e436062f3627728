"""All real roots of the determinant behind eq. (13) of the memo, to full precision."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial as P

from .._check import FloatArray

__all__ = ["SAME", "BlindPair", "Determinant", "RealRoot", "real_roots"]

SAME = 1e-10
"""Relative accuracy to which two distances count as equal."""
# No tolerance below what rounding does to readings and positions that were computed.
_ROUNDING = 64 * float(np.finfo(float).eps)
_FINEST = 4 * float(np.finfo(float).eps)


class Jet(NamedTuple):
    """A function's value, first derivative and half its second derivative at a point."""

    v: float
    d: float
    h: float


class RealRoot(NamedTuple):
    """A root's position, in depths, and how often it counts."""

    position: float
    multiplicity: int


class BlindPair(NamedTuple):
    """Two sensors, by index, that are both blind to the position halfway between them [depths]."""

    low: int
    high: int
    position: float


class _Term(NamedTuple):
    """coefficient * (1 + t^2)^2 * product of (1 + slope (position - f)), with t = s - f and slope = +-a."""

    coefficient: float
    s: float
    factors: tuple[tuple[float, float], ...]  # position, slope


class Determinant:
    """f -> sum over cyclic (i, j, k) of e_i (s_k - s_j) q_i h_j h_k, less the factors common to all terms.

    Here t_i = s_i - f, q = (1 + t^2)^2 and h = 1 - kappa t^2 = (1 + a t)(1 - a t), a = sqrt(kappa). At nu =
    1/2 in plane strain (kappa = 1) with equal pitch b this is -b times the f(y) of memo eq. (13).

    Parameters
    ----------
    s : ndarray, shape (3,)
        Positions of the sensors, ascending, in depths.
    e : ndarray, shape (3,)
        Readings, the largest of size 1.
    kappa : float
        nu/(1 - nu) in plane strain, nu in plane stress.
    """

    def __init__(self, s: FloatArray, e: FloatArray, kappa: float) -> None:
        self.kappa = kappa
        a = float(np.sqrt(kappa))
        positions = [float(v) for v in s]
        self.blind_pairs = tuple(
            BlindPair(low, high, 0.5 * (positions[low] + positions[high]))
            for low, high in ((0, 1), (0, 2), (1, 2))
            if abs(a * (positions[high] - positions[low]) / 2 - 1) <= SAME
        )
        terms = []
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            coefficient = float(e[i]) * (positions[k] - positions[j])
            factors = [(m, sign * a) for m in (j, k) for sign in (1.0, -1.0)] if a > 0 else []
            for pair in self.blind_pairs:
                # 1 + a t_low and 1 - a t_high are each other's negative: divide by the latter
                if (pair.low, a) in factors:
                    factors.remove((pair.low, a))
                    coefficient = -coefficient
                else:
                    factors.remove((pair.high, -a))
            terms.append(_Term(coefficient, positions[i], tuple((positions[m], sign) for m, sign in factors)))
        self.terms = tuple(terms)

    def __call__(self, f: float) -> tuple[Jet, float]:
        """The jet at f, and the sum of the terms' sizes: what cancellation has to be measured against."""
        value = first = second = size = 0.0
        for c, s, factors in self.terms:
            t = s - f
            q = 1 + t * t
            v, d, h = c * q * q, -4 * c * t * q, c * (2 * q + 4 * t * t)
            for position, slope in factors:
                u = 1 + slope * (position - f)
                v, d, h = v * u, d * u - v * slope, h * u - d * slope
            value, first, second, size = value + v, first + d, second + h, size + abs(v)
        return Jet(value, first, second), size

    def expand(self) -> tuple[FloatArray, FloatArray]:
        """Coefficients of the powers of f, ascending, and the sums of the terms' sizes in each."""
        table = np.zeros((3, 5 + max(len(term.factors) for term in self.terms)))
        for row, (coefficient, s, factors) in zip(table, self.terms, strict=True):
            square = [1 + s**2, -2 * s, 1.0]
            poly = coefficient * P.polymul(square, square)
            for position, slope in factors:
                poly = P.polymul(poly, [1 + slope * position, -slope])
            row[: len(poly)] = poly
        return table.sum(axis=0), np.abs(table).sum(axis=0)


def real_roots(determinant: Determinant, tolerance: float) -> tuple[list[RealRoot], int]:
    """All real roots of `determinant` and the degree of the polynomial with the shared factors put back.

    The eigenvalues of the companion matrices of the polynomial and of its derivative cut the axis into
    intervals; the product form, which does not suffer from the expansion, then shows which of them hold a
    change of sign, and Brent's method finds it. A position where the derivative
    vanishes and the value is as small as a relative change `tolerance` of the readings could make it is a
    double root.
    """
    from scipy.optimize import brentq

    tol = max(tolerance, _ROUNDING)
    coefficients, sizes = determinant.expand()
    degree = len(coefficients) - 1
    while degree > 0 and abs(coefficients[degree]) <= tol * sizes[degree]:
        degree -= 1
    full_degree = degree + len(determinant.blind_pairs)
    if degree == 0:
        return [], full_degree
    poly = coefficients[: degree + 1]
    near, turns = P.polyroots(poly), P.polyroots(P.polyder(poly))
    bound = 2 * float(max(1.0, np.abs(near).max()))
    cuts = {-bound, bound, *(float(r.real) for r in near)}
    doubles: list[float] = []
    for turn in turns:
        position = float(turn.real)
        if abs(turn.imag) <= 0.1 * (1 + abs(position)):
            turned = _polish_turn(determinant, position)
            if turned is not None:
                position = turned
                jet, size = determinant(position)
                if abs(jet.v) <= tol * size:
                    doubles.append(position)
        cuts.add(position)
    brackets = _sign_changes(determinant, sorted(cuts))
    simple = [float(brentq(lambda f: determinant(f)[0].v, *ends, xtol=1e-300, rtol=_FINEST)) for ends in brackets]
    return _merge(determinant, simple, doubles, tol), full_degree


def _sign_changes(determinant: Determinant, cuts: list[float]) -> list[tuple[float, float]]:
    # a cut that is a root itself is left out: its neighbours differ in sign
    signed = [(f, value > 0) for f in cuts if (value := determinant(f)[0].v) != 0]
    return [(lo, hi) for (lo, below), (hi, above) in pairwise(signed) if below != above]


def _polish_turn(determinant: Determinant, start: float) -> float | None:
    """A zero of the derivative near `start`, by Newton's method; None where it does not settle near."""
    position = start
    for _ in range(60):
        jet, size = determinant(position)
        reach = 1 + abs(position)
        if abs(jet.d) * reach <= _ROUNDING * size:
            return position
        if jet.h == 0:
            return None
        step = jet.d / (2 * jet.h)
        position -= step
        if not abs(position - start) <= 0.1 * (1 + abs(start)):
            return None
        if abs(step) <= 1e-15 * reach:
            return position
    return None


def _merge(determinant: Determinant, simple: list[float], doubles: list[float], tol: float) -> list[RealRoot]:
    """Simple and double roots in order; what the readings' accuracy cannot tell apart becomes one root."""
    marked = sorted([(position, 1) for position in simple] + [(position, 2) for position in doubles])
    groups: list[list[tuple[float, int]]] = []
    for item in marked:
        if groups:
            before = groups[-1][-1]
            jet, size = determinant(0.5 * (before[0] + item[0]))
            if (item[1] == 2 or before[1] == 2) and abs(jet.v) <= tol * size:
                groups[-1].append(item)
                continue
        groups.append([item])
    roots = []
    for group in groups:
        turning = [position for position, kind in group if kind == 2]
        roots.append(RealRoot(float(np.mean(turning)) if turning else group[0][0], len(turning) + 1))
    return roots
