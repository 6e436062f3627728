"""How nearly a touch reads like another one close by: where that is near, more climbs look for the second top."""

from __future__ import annotations

import numpy as np

from ..._check import FloatArray
from ..cone import eliminate_three
from .tiles import Response

__all__ = ["least_told_apart"]

_AWAY = (0.25, 0.4, 0.55)
"""Depths from a load to the one that reads like it: nearer ones are one top, farther ones the scan tells apart."""
_TURNS = 2 * np.pi * np.arange(12) / 12
_OVER = np.array([0.2, 0.4, 0.6, 0.8])
"""Where loads stand, in shares of the sensors' box."""
_LEANS = 0.5
"""Drag over the normal force, or the friction where that is less."""


def least_told_apart(response: Response, points: FloatArray, scale: FloatArray, depth: float, friction: float) -> float:
    """The least share of a load's squared readings that no load about half a depth away explains.

    points (n, 2): the sensors [m]; scale (n,): 1 / noise; depth [m]. Loads press, and lie within the cone of friction.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    at = np.stack(np.meshgrid(*(low[i] + (high[i] - low[i]) * _OVER for i in (0, 1))), axis=-1).reshape(-1, 2)
    ring = depth * np.concatenate([r * np.stack([np.cos(_TURNS), np.sin(_TURNS)], axis=-1) for r in _AWAY])
    lean = min(_LEANS, friction)
    forces = np.array([(1, 0, 0), (1, lean, 0), (1, -lean, 0), (1, 0, lean), (1, 0, -lean)])
    seen = forces @ (response(at) * scale[:, None]).swapaxes(1, 2)  # positions, forces, sensors
    near = (response((at[:, None] + ring).reshape(-1, 2)) * scale[:, None]).reshape(len(at), len(ring), len(points), 3)
    gram = near.swapaxes(2, 3) @ near
    along = np.einsum("prnk,pfn->prfk", near, seen)
    size, least = (seen**2).sum(axis=2), 1.0
    for p, r in np.ndindex(gram.shape[:2]):
        g = gram[p, r]
        for f in range(len(forces)):
            _, _, _, explained, *_ = eliminate_three(*g[np.triu_indices(3)], *along[p, r, f], friction)
            least = min(least, 1.0 - explained / size[p, f])
    return float(least)
