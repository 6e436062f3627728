"""Bounds on what loads far from the sensors could explain, so that most frames need no scan there.

The default search goes well beyond the array, and loads are thought of further out still; most touches stand over the
sensors. What any load of some region makes the sensors read lies nearly in a few directions; so chi-square explained
by such a load is at most what those directions take up of the readings, and a little of the rest. Regions form a tree:
where the bound of one is too high, its halves are asked. A region whose loads would be read most by other sensors than
the frame's strongest is passed by. Before the tree is asked, the sensors round the strongest one are: no load far away
puts as much of what it makes there as a touch near them does. `reach.py` goes through both.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from .reach import AT_ONCE, FEW
from .tiles import STRONG, Response, orthonormal, strength

__all__ = ["INNER", "Far", "far_from", "nodes_of"]

INNER = 0.65
"""Depths beside the outermost sensors from which a load is far."""
_AWAY = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.4, 1.8, 2.4, 3.4, 4.7, 6.3, 8.0, 10.0)
"""Depths beyond these at which positions are looked at."""
_MARGIN = 1.2
"""How much more than is seen is left of a unit reading, squared."""
_FEWEST = 6
"""Directions of a region that is not halved."""
_CLUSTER = 9
"""Sensors round the strongest, itself among them."""
_SAMPLE, _WIDEST = 32, 24
"""Positions from which directions are made; most directions that are worth while."""
_BESIDE = 9
"""A position and those next to it."""
_Indices: TypeAlias = npt.NDArray[np.intp]


class Far(NamedTuple):
    """Regions, each before its halves; as `reach.regions_left` wants them.

    table (regions, 4): its first direction, how many (none: ask the halves), the region to go on with where the bound
    rules this one out, and whether it is a last one; left (regions,): what its directions leave of a unit reading,
    squared, single; directions (all of them, n), of length one, or zero so that a region has a multiple of
    `reach.AT_ONCE` where frames stand in lanes; seen (n + 1, regions): whether its loads may be read
    most by a sensor, and at last 1 for frames whose strongest sensor is not sure; cluster (n, 9): the sensors nearest
    to each; share (n + 1,): the most of a load's squares that these get, 1 at last; once: 1 where one region of each
    frame will do.
    """

    table: npt.NDArray[np.int64]
    left: npt.NDArray[np.float32]
    directions: npt.NDArray[np.float32]
    seen: npt.NDArray[np.uint8]
    cluster: npt.NDArray[np.int64]
    share: FloatArray
    once: int = 0


def far_from(
    response: Response, points: FloatArray, scale: FloatArray, inner: FloatArray, outer: FloatArray, depth: float,
    friction: float, leaves: float, coarse: float = 0.0,
) -> tuple[Far, list[FloatArray]]:  # fmt: skip
    """The tree of the positions between two boxes ((y low, y high), (z low, z high)); empty where there are none.

    points (n, 2): the sensors; scale (n,): 1 / noise; leaves: what the directions of a region may leave of a unit
    reading, squared; coarse: how many depths farther from the sensors the inner box is thought to be when positions are
    chosen. Beside the tree the positions of each region that is a last one; of the others none.
    """
    from scipy.spatial import KDTree

    at = _positions(inner, outer, depth, coarse)
    n = response.sensors
    if not len(at) or n <= _FEWEST:
        nothing = np.empty((0, n), dtype=np.float32), np.empty((n + 1, 0), dtype=np.uint8)
        index = np.empty((0, 4), dtype=np.int64)
        return Far(index, np.empty(0, dtype=np.float32), *nothing, np.empty((n, 0), dtype=np.int64), np.ones(n + 1)), []
    fields = response(at) * scale[:, None]
    hot = strength(fields, friction)[0] >= STRONG**2
    basis = orthonormal(fields)[0].swapaxes(1, 2)[:, : 3 if friction > 0 else 1]
    beside = np.asarray(KDTree(at).query(at, _BESIDE)[1])
    rows: list[list[float]] = []
    found: list[FloatArray] = []
    seen: list[npt.NDArray[np.bool_]] = []
    held: list[FloatArray] = []
    _divide(np.arange(len(at)), at, beside, basis, hot, leaves, rows, found, seen, held)
    table = np.array(rows)
    at_once = AT_ONCE if n < FEW else 1
    found = [np.append(part, np.zeros((-len(part) % at_once, n)), axis=0) for part in found]
    counts = np.array([len(part) for part in found])
    index = np.column_stack([np.cumsum(counts) - counts, counts, table[:, 0], table[:, 1]]).astype(np.int64)
    left = table[:, 2].astype(np.float32)  # as where the tree is empty: each kind of array is a compilation
    sees = np.append(np.stack(seen, axis=1), np.ones((1, len(rows))), axis=0).astype(np.uint8)
    return Far(index, left, np.concatenate(found).astype(np.float32), sees, *_clusters(points, basis, hot)), held


def nodes_of(held: list[FloatArray], nodes: FloatArray) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Where the nodes of each region begin (regions + 1,), and these: the nodes that have a position of it near them.

    held: positions of each region; nodes (m, 2). Of no region: all nodes, as of one.
    """
    from scipy.spatial import KDTree

    every = np.arange(len(nodes))
    if not held:
        return np.array([0, every.size]), every
    sizes = [len(part) for part in held]
    owner, at = np.repeat(np.arange(len(held)), sizes), np.concatenate(held)
    near = owner[KDTree(at).query(nodes, min(_BESIDE, len(at)))[1].reshape(len(nodes), -1)]
    pairs = np.unique(np.column_stack([near.reshape(-1), np.repeat(every, near.shape[1])]), axis=0)
    return np.searchsorted(pairs[:, 0], np.arange(len(held) + 1)), np.ascontiguousarray(pairs[:, 1])


def _clusters(
    points: FloatArray, basis: FloatArray, hot: npt.NDArray[np.bool_]
) -> tuple[npt.NDArray[np.int64], FloatArray]:
    """Sensors round each one (n, 9), and the most that these get of the squares of a load it may read most (n + 1,)."""
    from scipy.spatial import KDTree

    n = len(points)
    cluster = np.asarray(KDTree(points).query(points, min(_CLUSTER, n))[1]).reshape(n, -1)
    member = np.zeros((n, n))
    np.put_along_axis(member, cluster, 1.0, axis=1)
    shares = np.where(hot, (basis**2).sum(axis=1) @ member.T, 0.0).max(axis=0)
    return cluster.astype(np.int64), np.append(np.minimum(_MARGIN * shares, 1.0), 1.0)


def _positions(inner: FloatArray, outer: FloatArray, depth: float, coarse: float) -> FloatArray:
    """Positions (m, 2) round the inner box, closer near it."""
    (y0, y1), (z0, z1) = inner
    room = np.abs(outer - inner).max()
    out = []
    for away in _AWAY if room > 1e-9 * depth else ():
        step, reach = 0.25 * depth * max(1.0, 1.2 * (away + coarse)), away * depth
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
    hot: npt.NDArray[np.bool_],
    leaves: float,
    rows: list[list[float]],
    found: list[FloatArray],
    seen: list[npt.NDArray[np.bool_]],
    held: list[FloatArray],
) -> None:
    """Append the region of the positions `here`, and of all between these and those beside them; then its halves."""
    row, n = len(rows), basis.shape[2]
    these = np.unique(beside[here])
    directions, left = _directions(basis[these], leaves, min(n - 2, _WIDEST))
    last = len(here) == 1 or 0 < len(directions) <= _FEWEST
    rows.append([0.0, float(last), left])
    found.append(directions)
    seen.append(np.asarray(hot[these].any(axis=0)))
    held.append(at[here] if last else at[:0])
    if not last:
        y_or_z = at[here, np.ptp(at[here], axis=0).argmax()]
        order = here[np.argsort(y_or_z, kind="stable")]
        for half in np.array_split(order, 2):
            _divide(half, at, beside, basis, hot, leaves, rows, found, seen, held)
    rows[row][0] = len(rows)


def _principal(rows: FloatArray) -> FloatArray:
    """Orthonormal directions of the rows, the one that they share most first."""
    few = len(rows) < rows.shape[1]
    square, vectors = np.linalg.eigh(rows @ rows.T if few else rows.T @ rows)
    kept = square > 1e-10 * square[-1]
    vectors = vectors[:, kept][:, ::-1].T
    return vectors @ rows / np.sqrt(square[kept][::-1, None]) if few else vectors


def _directions(spans: FloatArray, leaves: float, most: int) -> tuple[FloatArray, float]:
    """Directions that leave little of every reading in `spans` (positions, d, n), and how much; none if over `most`."""
    n = spans.shape[2]
    every = _principal(spans[:: max(len(spans) // _SAMPLE, 1)].reshape(-1, n))[:most]
    parts = spans @ every.T
    whole = spans @ spans.swapaxes(1, 2)
    taken = np.cumsum(parts[:, :, None, :] * parts[:, None, :, :], axis=-1)

    def left(count: int) -> float:
        """No less than the most that so many directions leave of a unit reading, squared: the largest sum of a row."""
        return float(np.abs(whole - taken[..., count - 1]).sum(axis=-1).max())

    low, high = 1, len(every)
    if left(high) >= leaves:
        return np.empty((0, n)), 1.0
    while low < high:  # the fewest that leave little
        middle = (low + high) // 2
        low, high = (low, middle) if left(middle) < leaves else (middle + 1, high)
    return every[:low], max(_MARGIN * float(np.linalg.eigvalsh(whole - taken[..., low - 1])[:, -1].max()), 1e-7)
