"""How much of a load on an area lies beyond the friction cone: its drag has two components, and so have its errors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..loads import Load
from ._cone_area_kernel import fill_beyond

__all__ = ["AreaForces", "area_forces", "beyond_on_area"]

_NODES = 32
_T, _WEIGHTS = np.polynomial.hermite_e.hermegauss(_NODES)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()


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
    out = np.empty(load.normal.size)
    given = (np.stack(load, axis=-1), edges, masses, scale, _T, _WEIGHTS)
    fill_beyond(*(np.array(v, dtype=np.float64, order="C") for v in given), out)  # compiled for what can be written
    return out
