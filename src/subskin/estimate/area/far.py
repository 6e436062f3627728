"""Bounds on what loads far from the sensors could explain, so that most frames need no scan there.

The default search goes well beyond the array, and loads are thought of further out still; most touches stand over the
sensors. What any load of some region makes the sensors read lies nearly in a few directions; so chi-square explained
by such a load is at most what those directions take up of the readings, and a little of the rest. Regions form a tree:
where the bound of one is too high, its halves are asked. A region whose loads would be read most by other sensors than
the frame's strongest is passed by. Before the tree is asked, the sensors round the strongest one are: no load far away
puts as much of what it makes there as a touch near them does.

Eight frames go through the tree side by side, each in its lane: which region is next is then asked once for all of
them, and a lane that is done with a part of the tree waits for the others.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..._lanes import alike, answers, eight, first_of, where
from .tiles import STRONG, Seen, orthonormal, rings_round, strength

__all__ = ["FEW", "INNER", "Far", "crowded", "far_from", "nodes_of", "regions_left"]

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
AT_ONCE = 4
"""Directions whose sums are added up side by side."""
FEW = 48
"""Sensors below which frames stand in lanes; of more, a frame by itself keeps the lanes full."""
_ROUNDING = np.float32(1.0 - 2e-5)
"""Sums in single precision are sure to fewer digits."""
_NOUGHT, _ONE, _FOUR, _NEVER = np.float32(0), np.float32(1), np.float32(4), np.float32(math.inf)
_Indices: TypeAlias = npt.NDArray[np.intp]


class Far(NamedTuple):
    """Regions, each before its halves; as `regions_left` wants them.

    table (regions, 4): its first direction, how many (none: ask the halves), the region to go on with where the bound
    rules this one out, and whether it is a last one; left (regions,): what its directions leave of a unit reading,
    squared, single; directions (all of them, n), of length one, or zero so that a region has a multiple of
    `AT_ONCE` where frames stand in lanes; seen (n + 1, regions): whether its loads may be read
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
    of: Seen, inner: FloatArray, outer: FloatArray, leaves: float, coarse: float = 0.0
) -> tuple[Far, list[FloatArray]]:
    """The tree of the positions between two boxes ((y low, y high), (z low, z high)); empty where there are none.

    leaves: what the directions of a region may leave of a unit reading, squared; coarse: how many depths farther from
    the sensors the inner box is thought to be when positions are chosen. Beside the tree the positions of each region
    that is a last one; of the others none.
    """
    from scipy.spatial import KDTree

    n, room = of.sensors, np.abs(outer - inner).max()
    if not room > 1e-9 * of.depth or n <= _FEWEST:
        nothing = np.empty((0, n), dtype=np.float32), np.empty((n + 1, 0), dtype=np.uint8)
        index = np.empty((0, 4), dtype=np.int64)
        return Far(index, np.empty(0, dtype=np.float32), *nothing, np.empty((n, 0), dtype=np.int64), np.ones(n + 1)), []
    beyond = sum(away * of.depth <= room for away in _AWAY) + 1
    rings = np.concatenate(rings_round(inner, _AWAY[:beyond], of.depth, coarse))
    at = np.unique(np.clip(rings, outer[:, 0], outer[:, 1]), axis=0)
    fields = of(at)
    hot = strength(fields, of.friction)[0] >= STRONG**2
    basis = orthonormal(fields)[0].swapaxes(1, 2)[:, : 3 if of.friction > 0 else 1]
    beside = np.asarray(KDTree(at).query(at, _BESIDE)[1])
    regions: list[_Region] = []
    _divide(np.arange(len(at)), at, beside, basis, hot, leaves, regions)
    at_once = AT_ONCE if n < FEW else 1
    found = [np.append(part.directions, np.zeros((-len(part.directions) % at_once, n)), axis=0) for part in regions]
    counts = np.array([len(part) for part in found])
    index = np.column_stack([np.cumsum(counts) - counts, counts, [(part.after, part.last) for part in regions]])
    left = np.array([part.left for part in regions], dtype=np.float32)
    sees = np.ones((n + 1, len(regions)), dtype=np.uint8)
    sees[:-1] = np.stack([part.seen for part in regions], axis=1)
    directions, clusters = np.concatenate(found).astype(np.float32), _clusters(of.points, basis, hot)
    held = [at[part.here] if part.last else at[:0] for part in regions]
    return Far(index.astype(np.int64), left, directions, sees, *clusters), held


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


class _Region(NamedTuple):
    """A region as it is made: its positions, as indices, and what `Far` says of it."""

    here: _Indices
    directions: FloatArray
    left: float
    seen: npt.NDArray[np.bool_]
    last: bool
    after: int


def _divide(
    here: _Indices, at: FloatArray, beside: _Indices, basis: FloatArray, hot: npt.NDArray[np.bool_], leaves: float,
    regions: list[_Region],
) -> None:  # fmt: skip
    """Append the region of the positions `here`, and of all between these and those beside them; then its halves."""
    row, n = len(regions), basis.shape[2]
    these = np.unique(beside[here])
    directions, left = _directions(basis[these], leaves, min(n - 2, _WIDEST))
    last = len(here) == 1 or 0 < len(directions) <= _FEWEST
    regions.append(_Region(here, directions, left, np.asarray(hot[these].any(axis=0)), last, row + 1))
    if not last:
        y_or_z = at[here, np.ptp(at[here], axis=0).argmax()]
        order = here[np.argsort(y_or_z, kind="stable")]
        for half in np.array_split(order, 2):
            _divide(half, at, beside, basis, hot, leaves, regions)
        regions[row] = regions[row]._replace(after=len(regions))


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


@compiled(inline=True)
def crowded(single, total, least, tile, far):
    """Whether a frame's strongest sensors have more of it than any load far away gives them, beside all of `least`."""
    cluster, share, out = far.cluster, far.share, False
    if share[tile] < 1.0:
        here = np.float32(0)
        for k in range(cluster.shape[1]):
            w = single[cluster[tile, k]]
            here += w * w
        if here > share[tile] * total:
            bound = math.sqrt(here * share[tile]) + math.sqrt(max(total - here, 0.0) * (1.0 - share[tile]))
            out = bound * bound < _ROUNDING * least
    return out


@compiled(borrows=True)
def _taken_by_one(directions, begin, count, single):
    """The squares of what `count` directions from `begin` on take of one frame."""
    n, taken = directions.shape[1], np.float32(0)
    for j in range(begin, begin + count):
        along = np.float32(0)
        for i in range(n):
            along += directions[j, i] * single[i]
        taken += along * along
    return taken


@compiled(inline=True)
def _taken(directions, begin, count, wide):
    """The squares of what `count` directions from `begin` on take of eight frames."""
    n, taken = directions.shape[1], alike(_NOUGHT)
    for j in range(begin, begin + count, AT_ONCE):
        c0, c1, c2, c3 = alike(_NOUGHT), alike(_NOUGHT), alike(_NOUGHT), alike(_NOUGHT)
        for i in range(n):
            w = eight(wide, 8 * i)
            c0 += w * directions[j, i]
            c1 += w * directions[j + 1, i]
            c2 += w * directions[j + 2, i]
            c3 += w * directions[j + 3, i]
        taken += (c0 * c0 + c1 * c1) + (c2 * c2 + c3 * c3)
    return taken


@compiled(exact=True, borrows=True)
def regions_left(singles, wide, asked, tile, far, kept):
    """The last regions of which a load may explain enough, into kept (regions, 2), and of which frames: how many.

    singles (8, n + 1): readings of eight frames in units of noise, and wide (n, 8) as well where there are less than
    `FEW` sensors; asked (3, 8): their squares added up, what is enough, infinite for a frame that is not asked, and
    scratch; tile: their strongest sensor, n where it is not sure; far: a `Far`; frames: as bits.
    """
    table, left, directions, seen = far.table, far.left, far.directions, far.seen
    total, least, until = eight(asked, 0), eight(asked, 8), alike(_NOUGHT)
    until = where(least < _NEVER, until, _NEVER)
    least = least * _ROUNDING
    i = found = 0
    regions = table.shape[0]
    while i < regions:
        here, after = np.float32(i), table[i, 2]
        asks = until <= here
        if seen[tile, i] == 0 or answers(asks) == 0:
            i = after
            continue
        square = left[i]
        if directions.shape[1] < FEW:
            taken = _taken(directions, table[i, 0], table[i, 1], wide)
        else:
            others = answers(asks)
            while others > 0:
                lane = first_of(others)
                others &= others - 1
                asked[2, lane] = _taken_by_one(directions, table[i, 0], table[i, 1], singles[lane])
            taken = eight(asked, 16)
        rest = total - taken
        # the bound is (sqrt(taken (1 - square)) + sqrt(rest square))^2; compared without its roots
        a, b = taken * (_ONE - square), rest * square
        over = least - a - b
        lower = asks & (rest > total * square) & (over > _NOUGHT) & (over * over > a * b * _FOUR)
        until = where(lower, np.float32(after), until)
        may = answers(until <= here)
        if may == 0:
            i = after
            continue
        if table[i, 3] == 1:
            kept[found, 0], kept[found, 1] = i, may
            found += 1
            if far.once == 1:
                until = where(until <= here, _NEVER, until)
                if answers(until < _NEVER) == 0:
                    break
        i += 1
    return found
