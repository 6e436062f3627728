"""Integrals over a contact, for pressures that may be zero or infinite at its edges like a square root."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from .._check import FloatArray
from ..errors import GeometryError

__all__ = ["over_contact"]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


def over_contact(
    function: Callable[[FloatArray], FloatArray],
    a1: float,
    a2: float,
    near: Iterable[float] = (),
    closest: float = 1e-6,
) -> float:
    """Integral of `function` from a1 to a2: Gauss's rule on panels that shrink towards each position in `near`.

    The substitution s = centre + half * sin(phi) takes away square roots at the edges. `closest` is the
    distance on which the function varies near those positions.

    Raises
    ------
    GeometryError
        a2 <= a1.
    """
    if not a2 > a1:
        seen = f"a1 = {a1:.6g}, a2 = {a2:.6g}"
        raise GeometryError(seen, "the right edge has to lie right of the left one", "swap them")
    centre, half = 0.5 * (a1 + a2), 0.5 * (a2 - a1)
    levels = int(np.clip(np.ceil(np.log(16 * half / closest) / np.log(4)), 3, 60))
    reach = np.pi * 0.25 ** np.arange(levels)
    cuts = {-0.5 * np.pi, 0.5 * np.pi, 0.0}
    for position in near:
        foot = float(np.arcsin(np.clip((position - centre) / half, -1, 1)))
        cuts |= {foot, *(float(foot + side * r) for r in reach for side in (-1, 1))}
    edges = np.array(sorted(c for c in cuts if abs(c) <= 0.5 * np.pi))
    width = 0.5 * np.diff(edges)[:, None]
    phi = 0.5 * (edges[1:] + edges[:-1])[:, None] + width * _NODES
    values = np.asarray(function(centre + half * np.sin(phi)))
    return float((width * _WEIGHTS * values * half * np.cos(phi)).sum())
