"""How much of a load on an area lies beyond the friction cone: its drag has two components, and so have its errors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..loads import Load

__all__ = ["AreaForces", "area_forces", "beyond_on_area"]

_NODES = 32
_T, _WEIGHTS = np.polynomial.hermite_e.hermegauss(_NODES)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()
_CELL = 0.5 / np.sqrt(3.0)
"""Gauss and Legendre's two nodes in a cell of the density of mu, from its middle, in widths of the cell."""
_BLOCK = 1 << 21


class AreaForces(NamedTuple):
    """N, |T| and the errors of N, of T along the drag and of T across it (n, t, c) [N, N^2], of the frames' shape."""

    normal: FloatArray
    tangential: FloatArray
    nn: FloatArray
    nt: FloatArray
    tt: FloatArray
    nc: FloatArray
    tc: FloatArray
    cc: FloatArray

    def at(self, index: npt.NDArray[np.intp]) -> AreaForces:
        """The frames of a flat index."""
        return AreaForces(*(v.reshape(-1)[index] for v in self))


def area_forces(load: Load) -> AreaForces:
    """Components (N, Ty, Tz) and their covariance in axes along the drag that was found and across it."""
    parts, square = np.asarray(load.components), np.asarray(load.covariance)[..., 2:, 2:]
    drag = np.hypot(parts[..., 1], parts[..., 2])
    known = drag > 0
    y, z = (np.where(known, parts[..., k] / np.where(known, drag, 1.0), 2.0 - k) for k in (1, 2))
    turn = np.zeros((*drag.shape, 3, 3))
    turn[..., 0, 0] = 1.0
    turn[..., 1, 1], turn[..., 1, 2], turn[..., 2, 1], turn[..., 2, 2] = y, z, -z, y
    c = turn @ square @ np.swapaxes(turn, -1, -2)
    errors = (c[..., i, j] for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)))
    return AreaForces(parts[..., 0], drag, *errors)


def beyond_on_area(load: AreaForces, edges: FloatArray, masses: FloatArray, scale: FloatArray) -> FloatArray:
    """P(|T| > scale mu N), shape (frames,); edges (frames or 1, k + 1), masses (frames or 1, k).

    Gauss and Hermite's rule over the drag across and over N, the normal distribution's tails for the drag along, Gauss
    and Legendre's rule over mu in each cell.
    """
    from scipy.special import ndtr

    frames, cells = load.normal.size, masses.shape[-1]
    out = np.empty(frames)
    step = max(1, _BLOCK // (2 * cells * _NODES**2))
    for first in range(0, frames, step):
        part = slice(first, first + step)
        ends, weights = (v if v.shape[0] == 1 else v[part] for v in (edges, masses))
        n, t, nn, nt, tt, nc, tc, cc = (v[part, None, None] for v in load)
        across = np.sqrt(np.maximum(cc, 0.0)) * _T[:, None]
        share = np.where(cc > 0, nc / np.where(cc > 0, cc, 1.0), 0.0)
        turn = np.where(cc > 0, tc / np.where(cc > 0, cc, 1.0), 0.0)
        rest_nn, rest_nt, rest_tt = nn - share * nc, nt - share * tc, tt - turn * tc
        floor = 1e-24 * (n * n + t * t) + 1e-300
        normal = n + share * across + np.sqrt(np.maximum(rest_nn, 0.0)) * _T
        lean = np.where(rest_nn > floor, rest_nt / np.where(rest_nn > floor, rest_nn, 1.0), 0.0)
        middle = t + turn * across + lean * (normal - n - share * across)
        spread = np.sqrt(np.maximum(rest_tt - lean * rest_nt, floor))
        half, width = 0.5 * (ends[:, :-1] + ends[:, 1:]), np.diff(ends, axis=-1)
        total = np.zeros(len(n))
        for node in (-_CELL, _CELL):
            mu = (scale[part, None] * (half + node * width))[:, :, None, None]
            hold = mu * np.maximum(normal, 0.0)[:, None]
            cut = np.sqrt(np.maximum(hold**2 - across[:, None] ** 2, 0.0))
            p = ndtr((middle[:, None] - cut) / spread[:, None]) + ndtr((-middle[:, None] - cut) / spread[:, None])
            total += 0.5 * np.einsum("fkij,fk,i,j->f", p, np.broadcast_to(weights, p.shape[:2]), _WEIGHTS, _WEIGHTS)
        out[part] = total
    return np.clip(out, 0.0, 1.0)
