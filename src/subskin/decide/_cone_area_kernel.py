"""How much of a Gaussian load with two components of drag lies beyond the friction cone: a compiled loop."""

from __future__ import annotations

import math

from .._check import FloatArray
from .._compiled import compiled

__all__ = ["fill_beyond"]

_HALF = math.sqrt(0.5)
_SURE = 8.3
"""Standard deviations beyond which a load slips, or holds, for certain: the rest is 5e-17."""
_LIGHT = 1e-14
"""Weights of the rule below which its nodes are passed over: all of them together are 1e-11."""
_CELL = 0.5 / math.sqrt(3.0)
"""Gauss and Legendre's two nodes in a cell of the density of mu, from its middle, in widths of the cell."""


@compiled(inline=True, exact=True)
def _above(z: float) -> float:
    """Phi(z)."""
    return 0.5 * math.erfc(-_HALF * z) if z > -_SURE else 0.0


@compiled(entry=True, exact=True)
def fill_beyond(
    load: FloatArray, edges: FloatArray, masses: FloatArray, scale: FloatArray,
    nodes: FloatArray, weights: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """P(|T| > scale mu N) of each frame; load (frames, 8) as `AreaForces`, edges (frames or 1, k + 1), masses alike.

    nodes and weights are those of Gauss and Hermite's rule, for the drag across and for N; the drag along has the
    normal distribution's tails, and mu Gauss and Legendre's rule in each cell. The more friction, the less slips: of
    the cells only those are looked at in which it is not certain.
    """
    for f in range(out.size):
        row = min(f, edges.shape[0] - 1)
        ends, mass = edges[row], masses[row]
        n, t, nn, nt, tt, nc, tc, cc = load[f]
        share = nc / cc if cc > 0 else 0.0
        turn = tc / cc if cc > 0 else 0.0
        rest_nn, rest_nt, rest_tt = nn - share * nc, nt - share * tc, tt - turn * tc
        floor = 1e-24 * (n * n + t * t) + 1e-300
        lean = rest_nt / rest_nn if rest_nn > floor else 0.0
        spread = math.sqrt(max(rest_tt - lean * rest_nt, floor))
        root, wide = math.sqrt(max(cc, 0.0)), math.sqrt(max(rest_nn, 0.0))
        total = 0.0
        for i in range(nodes.size):
            across = root * nodes[i]
            square = across * across
            for j in range(nodes.size):
                weight = weights[i] * weights[j]
                if weight < _LIGHT:
                    continue
                normal = scale[f] * max(n + share * across + wide * nodes[j], 0.0)
                middle = abs(t + turn * across + lean * (wide * nodes[j]))
                slides, holds = middle - _SURE * spread, middle + _SURE * spread
                least = square + slides * slides if slides > 0 else -1.0
                most = square + holds * holds
                slipped = 0.0
                for k in range(mass.size):
                    low, high = normal * ends[k], normal * ends[k + 1]
                    if high * high <= least or normal == 0:
                        slipped += mass[k]
                        continue
                    if low * low >= most:
                        break
                    for side in (-1.0, 1.0):
                        hold = 0.5 * (low + high) + side * _CELL * (high - low)
                        cut = math.sqrt(max(hold * hold - square, 0.0))
                        slipped += 0.5 * mass[k] * (_above((middle - cut) / spread) + _above((-middle - cut) / spread))
                total += weight * slipped
        out[f] = min(max(total, 0.0), 1.0)
