"""Bounds on what loads far from the sensors could explain, so that most frames need no scan there.

The default search goes well beyond the array, and loads are thought of further out still; most touches stand over the
sensors. What any load of some region makes the sensors read lies nearly in a few directions; so chi-square explained
by such a load is at most what those directions take up of the readings, and a little of the rest. Regions form a tree:
where the bound of one is too high, its halves are asked. `reach.py` goes through it.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from .tiles import Response, orthonormal

__all__ = ["INNER", "Far", "far_from"]

INNER = 0.65
"""Depths beside the outermost sensors from which a load is far."""
_AWAY = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.4, 1.8, 2.4, 3.4, 4.7, 6.3, 8.0, 10.0)
"""Depths beyond these at which positions are looked at."""
_LEFT, _MARGIN = 0.03, 1.2
"""What the directions of a region may leave of a unit reading, squared; how much more than is seen counts."""
_FEW = 6
"""Directions of a region that is not halved."""
_SAMPLE, _WIDEST = 64, 96
"""Positions from which directions are made; most directions that are worth while."""
_BESIDE = 9
"""A position and those next to it."""
_Indices: TypeAlias = npt.NDArray[np.intp]


class Far(NamedTuple):
    """Regions, each before its halves; as `reach.may_reach` wants them.

    table (regions, 4): its first direction, how many (none: ask the halves), the region to go on with where the bound
    rules this one out, and whether it is a last one; left (regions, 2): the root of what its directions leave, and of
    what they take; directions (all of them, n), of length one.
    """

    table: npt.NDArray[np.int64]
    left: FloatArray
    directions: npt.NDArray[np.float32]


def far_from(
    response: Response, scale: FloatArray, inner: FloatArray, outer: FloatArray, depth: float, friction: float
) -> Far:
    """The tree of the positions between two boxes ((y low, y high), (z low, z high)); empty where there are none.

    scale (n,): 1 / noise.
    """
    from scipy.spatial import KDTree

    at = _positions(inner, outer, depth)
    n = response.sensors
    if not len(at) or n <= _FEW:
        return Far(np.empty((0, 4), dtype=np.int64), np.empty((0, 2)), np.empty((0, n), dtype=np.float32))
    basis = orthonormal(response(at) * scale[:, None])[0].swapaxes(1, 2)[:, : 3 if friction > 0 else 1]
    beside = np.asarray(KDTree(at).query(at, _BESIDE)[1])
    rows: list[list[float]] = []
    found: list[FloatArray] = []
    _divide(np.arange(len(at)), at, beside, basis, rows, found)
    table = np.array(rows)
    counts = np.array([len(part) for part in found])
    index = np.column_stack([np.cumsum(counts) - counts, counts, table[:, 0], table[:, 1]]).astype(np.int64)
    left = np.ascontiguousarray(table[:, 2:])  # as where the tree is empty: each kind of array is a compilation
    return Far(index, left, np.concatenate(found).astype(np.float32))


def _positions(inner: FloatArray, outer: FloatArray, depth: float) -> FloatArray:
    """Positions (m, 2) round the inner box, closer near it."""
    (y0, y1), (z0, z1) = inner
    room = np.abs(outer - inner).max()
    out = []
    for away in _AWAY if room > 1e-9 * depth else ():
        step, reach = 0.25 * depth * max(1.0, 1.2 * away), away * depth
        y = np.linspace(y0 - reach, y1 + reach, max(int(np.ceil((y1 - y0 + 2 * reach) / step)) + 1, 3))
        z = np.linspace(z0 - reach, z1 + reach, max(int(np.ceil((z1 - z0 + 2 * reach) / step)) + 1, 3))
        out += [np.column_stack([np.full(z.size, end), z]) for end in (y[0], y[-1])]
        out += [np.column_stack([y[1:-1], np.full(y.size - 2, end)]) for end in (z[0], z[-1])]
        if reach > room:
            break
    return np.unique(np.clip(np.concatenate(out), outer[:, 0], outer[:, 1]), axis=0) if out else np.empty((0, 2))


def _divide(
    here: _Indices,
    at: FloatArray,
    beside: _Indices,
    basis: FloatArray,
    rows: list[list[float]],
    found: list[FloatArray],
) -> None:
    """Append the region of the positions `here`, and of all between these and those beside them; then its halves."""
    row, n = len(rows), basis.shape[2]
    directions, left = _directions(basis[np.unique(beside[here])], min(n - 2, _WIDEST))
    last = len(here) == 1 or 0 < len(directions) <= _FEW
    rows.append([0.0, float(last), np.sqrt(left), np.sqrt(1 - left)])
    found.append(directions)
    if not last:
        y_or_z = at[here, np.ptp(at[here], axis=0).argmax()]
        order = here[np.argsort(y_or_z, kind="stable")]
        for half in np.array_split(order, 2):
            _divide(half, at, beside, basis, rows, found)
    rows[row][0] = len(rows)


def _principal(rows: FloatArray) -> FloatArray:
    """Orthonormal directions of the rows, the one that they share most first."""
    few = len(rows) < rows.shape[1]
    square, vectors = np.linalg.eigh(rows @ rows.T if few else rows.T @ rows)
    kept = square > 1e-10 * square[-1]
    vectors = vectors[:, kept][:, ::-1].T
    return vectors @ rows / np.sqrt(square[kept][::-1, None]) if few else vectors


def _directions(spans: FloatArray, most: int) -> tuple[FloatArray, float]:
    """Directions that leave little of every reading in `spans` (positions, d, n), and how much; none if over `most`."""
    n = spans.shape[2]
    every = _principal(spans[:: max(len(spans) // _SAMPLE, 1)].reshape(-1, n))[:most]
    parts = spans @ every.T
    whole = spans @ spans.swapaxes(1, 2)
    taken = np.cumsum(parts[:, :, None, :] * parts[:, None, :, :], axis=-1)

    def left(count: int) -> float:
        """The most that so many directions leave of a unit reading, squared."""
        return float(np.linalg.eigvalsh(whole - taken[..., count - 1])[:, -1].max())

    low, high = 1, len(every)
    while low < high:  # the fewest that leave little
        middle = (low + high) // 2
        low, high = (low, middle) if left(middle) < _LEFT else (middle + 1, high)
    if left(low) >= _LEFT:
        return np.empty((0, n)), 1.0
    return every[:low], max(_MARGIN * left(low), 1e-7)
