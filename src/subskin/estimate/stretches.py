"""Both stretches beyond a search along a row: how far loads are thought of there, and what sensors read of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..finger import Finger
from ..response import Response
from .frames import packed, scan_geometry

__all__ = ["Stretches", "beyond", "reached", "stretches"]

_FARTHEST = 8.0
"""Depths beside the row up to which a load is thought of where no search is stated."""
_FEWEST, _MOST = 11, 44
"""Positions to start from: as many as it takes for one to lie near any load, as thin layers need more."""
_ERROR = 1e-6
_DIRECTIONS, _BETWEEN = 9, 8
_MARGIN, _NEAR = 0.95, 0.95


class Stretches(NamedTuple):
    """Both stretches beyond the search as compiled loops want them.

    fields (2 k, n, 2) at the k `nodes`, whitened as are the `tables` (2, cells, 5, 2, n), which have one `start` and
    `step`; `near`: share of S at its top that the nearest node reaches at least.
    """

    fields: FloatArray
    nodes: FloatArray
    tables: FloatArray
    start: float
    step: float
    near: float


def beyond(finger: Finger, table: Response) -> Response | None:
    """Readings on either side beyond the default search, by the distance from the row; None where nothing is beyond."""
    y, (low, high) = np.asarray(finger.array.y), reached(finger, table)
    near, far = 0.5 * (table.stop - table.start - np.ptp(y)), 0.5 * (high - low - np.ptp(y))
    if not far > near * (1.0 + 1e-6):
        return None

    def both(distance: FloatArray) -> FloatArray:
        sides = finger.receptive_field(np.stack([y.min() - distance, y.max() + distance]))
        return np.concatenate(list(sides), axis=-2)

    return Response.from_function(both, near, far, step=0.25 * float(np.max(finger.array.depth)), tolerance=_ERROR)


def reached(finger: Finger, table: Response) -> tuple[float, float]:
    """Ends of where a load is thought of [m] if no search is stated; about a round finger what is far comes back."""
    y = np.asarray(finger.array.y)
    far = min(_FARTHEST * float(np.max(finger.array.depth)), 0.5 * (finger.skin.period - float(np.ptp(y))))
    return min(float(y.min()) - far, table.start), max(float(y.max()) + far, table.stop)


def stretches(far: Response | None, pattern: npt.NDArray[np.bool_], scale: FloatArray, friction: float) -> Stretches:
    """Of `beyond`, for the sensors of a pattern, whitened by `scale` (n,); empty where nothing is beyond."""
    n = int(pattern.sum())
    if far is None:
        return Stretches(np.empty((0, n, 2)), np.empty(0), np.empty((0, 1, 5, 2, n)), 0.0, 1.0, 1.0)
    sides = far.sensors // len(pattern)
    far, stop = far.select(np.tile(pattern, sides)), far.stop

    def fields(distance: FloatArray) -> list[FloatArray]:
        """On each side, (distances, n, 2)."""
        return [side * scale[:, None] for side in np.split(far(distance), sides, axis=1)]

    count, near = _FEWEST, 0.0
    while near < _NEAR and count <= _MOST:
        nodes, between = (np.geomspace(far.start, stop, k) for k in (count, _BETWEEN * (count - 1) + 1))
        at_nodes = fields(nodes)
        near = min(_nearest(*both, friction) for both in zip(at_nodes, fields(between), strict=True))
        count *= 2
    tables = np.stack(np.split(packed(far, np.tile(scale, sides)), sides, axis=-1))
    return Stretches(np.concatenate(at_nodes), nodes, tables, far.start, far.step, _MARGIN * near)


def _nearest(nodes: FloatArray, between: FloatArray, friction: float) -> float:
    """Least share of what a load beyond explains that the best of the nodes explains, loads of any angle."""
    angles = np.arctan(friction) * np.linspace(-1, 1, _DIRECTIONS)
    w = (between @ np.stack([np.cos(angles), np.sin(angles)])).transpose(0, 2, 1)  # (positions, directions, n)
    basis, (m1, m2, p1, p2), _ = scan_geometry(nodes, friction)
    c1, c2 = (w @ basis[:, i].astype(float) for i in range(2))
    inside = (m1 * c2 - m2 * c1 > 0) & (c1 * p2 - c2 * p1 > 0)
    along = np.maximum(np.maximum(c1 * m1 + c2 * m2, c1 * p1 + c2 * p2), 0.0)
    explained, total = np.where(inside, c1**2 + c2**2, along**2).max(axis=-1), np.square(w).sum(axis=-1)
    return float(np.min(np.divide(explained, total, out=np.ones_like(total), where=total > 0)))
