"""Where the scan looks: the grid of positions cut into a tile for each sensor that may be the strongest, and the edges.

A load whose strongest reading is that of one sensor stands near it; each tile holds the positions from which an
admissible load makes its sensor read at least 0.7 of the strongest, with a margin of one node, and the last tile the
whole grid. Beyond the search, or along its sides, stand nodes of four boxes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._lanes import EIGHT
from ...array import SensorArray

__all__ = [
    "BASIS", "COUNT", "NEAR", "NODES", "ROWS", "SHAPES", "STRIDE", "STRONG", "Seen", "Tiles", "boxes_beyond",
    "nodes_beyond", "nodes_of_sensors", "orthonormal", "rings_round", "strength", "tiles_of",
]  # fmt: skip

NEAR, COUNT, BASIS, NODES, SHAPES, ROWS, STRIDE = range(7)
"""Columns of a table of tiles."""
STRONG = 0.7
"""Share of the strongest reading from which a sensor may be the strongest one with noise."""
_ENERGY, _MOST_NEAR = 0.98, 64
_RINGS = (0.0, 0.5, 1.0, 1.6, 2.4, 3.4, 4.7, 6.3, 8.0)
"""Depths beyond the search at which nodes stand; the boxes end at the last."""
_SAMPLES = 96
_MARGIN = 0.95
_AT_ONCE = 32  # nodes whose readings fit a processor's cache


class Tiles(NamedTuple):
    """Tiles as compiled loops want them.

    table (tiles, 7): where the sensors of a tile begin, how many; where the basis, how many nodes; where the shapes;
    then rows, and nodes of a row, the last of which is none; origin (tiles, 4): y and z of its first node and both
    steps, or instead of y the first of `nodes`; near: the sensors that count, k even; basis (nodes / 8, k, 3, 8);
    shapes (9, nodes): as of `scan.within`; sensors (4, k) and first (k + 1,): those of a
    `PointModel` that count, where they are asked for. All lie one tile after the other. A sensor that is one more than
    there are reads nothing.
    """

    table: npt.NDArray[np.int64]
    origin: FloatArray
    near: npt.NDArray[np.int64]
    basis: npt.NDArray[np.float32]
    shapes: npt.NDArray[np.float32]
    sensors: FloatArray
    first: npt.NDArray[np.int64]


def directions(friction: float) -> FloatArray:
    """Unit forces (N, Ty, Tz) all over the cone of `friction`, shape (k, 3)."""
    turns = 2 * np.pi * np.arange(8) / 8
    leans = (0.5, 1.0, 2.0, np.inf) if np.isinf(friction) else (friction / 2, friction)
    out = [np.array([[1.0, 0.0, 0.0]])]
    for lean in leans if friction > 0 else ():
        angle = math.atan(lean)
        drag = math.sin(angle) * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
        out.append(np.column_stack([np.full(turns.size, math.cos(angle)), drag]))
    return np.concatenate(out)


def strength(fields: FloatArray, friction: float) -> tuple[FloatArray, FloatArray]:
    """Of each node and sensor: its largest reading over the strongest one's, and its mean share of the squares."""
    every = directions(friction)
    hot, share = np.empty(fields.shape[:2]), np.empty(fields.shape[:2])
    for begin in range(0, len(fields), _AT_ONCE):
        part = slice(begin, begin + _AT_ONCE)
        square = (every @ fields[part].swapaxes(1, 2)) ** 2  # of nodes, forces and sensors
        hot[part] = (square / np.maximum(square.max(axis=2, keepdims=True), 1e-300)).max(axis=1)
        share[part] = (square / np.maximum(square.sum(axis=2, keepdims=True), 1e-300)).mean(axis=1)
    return np.sqrt(hot), share


def orthonormal(fields: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Columns of A (nodes, n, 3) in an orthonormal basis: the basis, and the shapes (9, nodes) of `scan.scan`."""
    basis, parts = np.zeros_like(fields), np.zeros((3, 3, len(fields)))
    for j in range(3):
        rest = fields[..., j].copy()
        for _ in range(2):  # twice is enough
            for i in range(j):
                along = np.einsum("pn,pn->p", basis[..., i], rest)
                parts[i, j] += along
                rest -= along[:, None] * basis[..., i]
        size = np.linalg.norm(rest, axis=1)
        kept = size > 1e-6 * np.linalg.norm(fields[..., j], axis=1)
        parts[j, j] = np.where(kept, size, 0.0)
        basis[..., j] = np.where(kept[:, None], rest / np.where(kept, size, 1.0)[:, None], 0.0)
    inverse = [np.divide(1.0, d, out=np.zeros_like(d), where=d > 0) for d in (parts[0, 0], parts[1, 1], parts[2, 2])]
    rows = [parts[0, 0], parts[0, 1], parts[0, 2], parts[1, 1], parts[1, 2], parts[2, 2], *inverse]
    return basis, np.stack(rows)


class Seen:
    """What sensors read at positions, in units of noise.

    Parameters
    ----------
    read : callable
        Readings per unit of (N, Ty, Tz) at positions (m, 2), shape (m, n, 3): a response.
    array : SensorArray
        Where they stand, and their noise.
    depth, friction : float
        What lengths are measured by [m]; the cone of the loads that are thought of.
    """

    def __init__(self, read: Callable[[FloatArray], FloatArray], array: SensorArray, depth: float, friction: float):
        self.points, self.sensors, self.depth, self.friction = array.points, len(array), depth, friction
        self._read, self._scale = read, 1 / np.asarray(array.noise)[:, None]

    def __call__(self, nodes: FloatArray) -> FloatArray:
        """Readings per unit of (N, Ty, Tz), shape (nodes, n, 3)."""
        return np.asarray(self._read(nodes) * self._scale)

    def made(self, nodes: FloatArray) -> FloatArray:
        """Unit readings of loads all over the cone, shape (nodes, directions, n)."""
        out = np.einsum("pnj,dj->pdn", self(nodes), directions(self.friction))
        return np.asarray(out / np.maximum(np.linalg.norm(out, axis=-1, keepdims=True), 1e-300))


class _Builder:
    """Tiles one after the other."""

    def __init__(self) -> None:
        self.rows: list[tuple[int, ...]] = []
        self.origins: list[tuple[float, ...]] = []
        self.parts: tuple[list[npt.NDArray[Any]], ...] = ([], [], [])
        self.sizes = [0, 0, 0]

    def add(
        self,
        fields: FloatArray,
        near: npt.NDArray[np.intp],
        shape: tuple[int, int],
        origin: tuple[float, float, float, float],
    ) -> None:
        """A tile of nodes that have `fields` (nodes, n, 3), of which the sensors `near` count."""
        basis, shapes = orthonormal(fields[:, near])
        (rows, columns), n = shape, fields.shape[1]
        stride = columns + (rows > 1)
        nodes, k = rows * stride + -(rows * stride) % EIGHT, near.size + near.size % 2
        at = (np.arange(rows)[:, None] * stride + np.arange(columns)).reshape(-1)
        full, wide = np.zeros((nodes, k, 3)), np.zeros((9, nodes))
        full[at, : near.size], wide[:, at] = basis, shapes
        full = np.ascontiguousarray(full.reshape(-1, EIGHT, k, 3).transpose(0, 2, 3, 1))
        self.rows.append((self.sizes[0], k, self.sizes[1], nodes, self.sizes[2], rows, stride))
        self.origins.append(origin)
        for i, part in enumerate((np.append(near, [n] * (k - near.size)), full.reshape(-1), wide.reshape(-1))):
            self.parts[i].append(part)
            self.sizes[i] += part.size

    def done(self) -> Tiles:
        """All of them."""
        near, basis, shapes = (np.concatenate(part) for part in self.parts)
        single = np.float32
        index = np.array(self.rows, dtype=np.int64)
        none = np.empty(0), np.empty(0, dtype=np.int64)
        origins, near = np.array(self.origins), near.astype(np.int64)
        return Tiles(index, origins, near, basis.astype(single), shapes.astype(single), *none)


def _near(share: FloatArray) -> npt.NDArray[np.intp]:
    """The sensors that have nearly all of what loads on some nodes make; share (nodes, n)."""
    mean, worst = share.mean(axis=0), share.max(axis=0)
    order = np.argsort(-np.maximum(mean, 0.5 * worst))
    enough = int(np.searchsorted(np.cumsum(mean[order]), _ENERGY * mean.sum())) + 1
    count = min(max(enough, 8), _MOST_NEAR)
    return np.arange(mean.size) if count > 0.75 * mean.size else np.sort(order[:count])


def _grid(box: FloatArray, step: float) -> tuple[FloatArray, tuple[int, int], tuple[float, float, float, float]]:
    """Nodes (nodes, 2) of a box, how many along y and z, and the first one and both steps."""
    y, z = (np.linspace(low, high, max(math.ceil((high - low) / step - 1e-9) + 1, 3)) for low, high in box)
    nodes = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1).reshape(-1, 2)
    return nodes, (y.size, z.size), (float(y[0]), float(z[0]), float(y[1] - y[0]), float(z[1] - z[0]))


def tiles_of(
    seen: Sequence[Seen], box: FloatArray, step: float, finer: float, inner: FloatArray | None = None
) -> Tiles:
    """Of what is seen a tile for each sensor, one of the whole in steps of `step`, one in steps of `finer`; for each.

    box ((y low, y high), (z low, z high)). Where `inner` is a smaller box, tiles of it for each sensor come before all
    others.
    """
    build = _Builder()
    if inner is not None and (inner != box).any():
        _add_sensors(build, seen[0], inner, step)
    for each in seen:
        every = np.arange(each.sensors)
        fields, shape, origin = _add_sensors(build, each, box, step)
        build.add(fields, every, shape, origin)
        nodes, shape, origin = _grid(box, finer)
        build.add(each(nodes), every, shape, origin)
    return build.done()


def _add_sensors(build: _Builder, seen: Seen, box: FloatArray, step: float) -> tuple[FloatArray, Any, Any]:
    """A tile for each sensor; the readings at all nodes, and how these lie."""
    nodes, (rows, columns), origin = _grid(box, step)
    fields = seen(nodes)
    hot, share = strength(fields, seen.friction)
    for sensor in range(seen.sensors):
        here = hot[:, sensor] >= STRONG
        here[np.argmax(hot[:, sensor])] = True
        j, k = np.divmod(np.flatnonzero(here), columns)
        j0, j1 = max(j.min() - 1, 0), min(j.max() + 2, rows)
        k0, k1 = max(k.min() - 1, 0), min(k.max() + 2, columns)
        at = (np.arange(j0, j1)[:, None] * columns + np.arange(k0, k1)).reshape(-1)
        first = (float(nodes[at[0], 0]), float(nodes[at[0], 1]), *origin[2:])
        build.add(fields[at], _near(share[at]), (j1 - j0, k1 - k0), first)
    return fields, (rows, columns), origin


def boxes_beyond(box: FloatArray, beyond: float) -> FloatArray:
    """Four boxes (y low, y high, z low, z high) to the distance `beyond` [m] round the search; 0: its sides."""
    (y0, y1), (z0, z1) = box
    a, b, c, d = y0 - beyond, y1 + beyond, z0 - beyond, z1 + beyond
    return np.array([[a, y0, c, d], [y1, b, c, d], [y0, y1, c, z0], [y0, y1, z1, d]])


def rings_round(box: FloatArray, away: Sequence[float], depth: float, coarse: float = 0.0) -> list[FloatArray]:
    """Positions (m, 2) along each of some rings round a box, so many depths away; of farther ones they lie wider apart.

    coarse: how many depths farther away the rings are thought to be for that.
    """
    rings = []
    for ring in away:
        step, reach = 0.25 * depth * max(1.0, 1.2 * (ring + coarse)), ring * depth
        wider = box + reach * np.array([-1.0, 1.0])
        y, z = (np.linspace(low, high, max(math.ceil((high - low) / step) + 1, 3)) for low, high in wider)
        ends = [np.column_stack([np.full(z.size, end), z]) for end in (y[0], y[-1])]
        ends += [np.column_stack([y[1:-1], np.full(y.size - 2, end)]) for end in (z[0], z[-1])]
        rings.append(np.concatenate(ends))
    return rings


def nodes_beyond(seen: Sequence[Seen], boxes: FloatArray) -> tuple[Tiles, FloatArray]:
    """Of what is seen a tile of `boxes`, and the nodes of all (nodes, 4): y, z, which box, and a share.

    Rings of nodes stand closer near the search, `_RINGS` depths from it. A load of a box explains at most what one of
    its nodes does over that node's share.
    """
    box = np.array([[boxes[0, 1], boxes[1, 0]], [boxes[2, 3], boxes[3, 2]]])
    rings = rings_round(box, _RINGS if boxes[0, 0] < box[0, 0] else _RINGS[:1], seen[0].depth)
    at, ring = np.concatenate(rings), np.repeat(np.arange(len(rings)), [len(part) for part in rings])
    beside = (at[:, 0] <= box[0, 0], at[:, 0] >= box[0, 1], at[:, 1] <= box[1, 0])
    which, build = np.select(beside, (0, 1, 2), 3), _Builder()
    nodes: list[FloatArray] = []
    for each in seen:
        fields = each(at)
        build.add(fields, np.arange(each.sensors), (1, len(at)), (len(nodes) * len(at), 0.0, 0.0, 0.0))
        nodes.append(np.column_stack([at, which, _shares(each, boxes, fields, which, ring)]))
    return build.done(), np.concatenate(nodes)


def nodes_of_sensors(seen: Sequence[Seen], nodes: FloatArray) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Where the nodes of each sensor begin (n + 2,), and these: where it may read a load most; at last all nodes."""
    hot = np.any([strength(each(nodes[:, :2]), each.friction)[0] >= STRONG**2 for each in seen], axis=0)
    parts = [*(np.flatnonzero(column) for column in hot.T), np.arange(len(nodes))]
    return np.cumsum([0, *(len(part) for part in parts)]), np.concatenate(parts)


def _shares(
    seen: Seen, boxes: FloatArray, fields: FloatArray, which: npt.NDArray[np.intp], ring: npt.NDArray[np.intp]
) -> FloatArray:
    """Of each node: the least share of a load in its box that a node of its ring explains where it is the best one."""
    rng, least = np.random.default_rng(0), np.ones(len(which))
    for b, ends in enumerate(boxes):
        own = np.flatnonzero(which == b)
        basis, _ = orthonormal(fields[own])
        at = np.stack([rng.uniform(low, high, 2 * _SAMPLES) for low, high in (ends[:2], ends[2:])], axis=-1)
        # as many again near the search, where the nodes are close and the share is large
        across, side = b // 2, b % 2
        low, high = ends[2 * across : 2 * across + 2]
        near = rng.uniform(0.0, min(2.0 * seen.depth, high - low), _SAMPLES)
        at[_SAMPLES:, across] = low + near if side else high - near
        made = seen.made(at).reshape(-1, seen.sensors)
        parts = ((made @ basis.swapaxes(0, 2)) ** 2).sum(axis=0)
        best = parts.argmax(axis=-1)
        np.minimum.at(least, own[best], parts[np.arange(best.size), best])
    every = np.full(ring.max() + 1, 1.0)
    np.minimum.at(every, ring, least)
    return np.asarray(_MARGIN * every[ring])
