"""Where the scan looks: the grid of positions cut into a tile for each sensor that may be the strongest, and the edges.

A load whose strongest reading is that of one sensor stands near it; each tile holds the positions from which an
admissible load makes its sensor read at least 0.7 of the strongest, with a margin of one node, and the last tile the
whole grid. Beyond the search, or along its sides, stand nodes of four boxes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._lanes import EIGHT
from ...prepared import Prepared
from ...radial import RadialResponse

__all__ = [
    "BASIS", "COUNT", "NEAR", "NODES", "ORDER", "ROWS", "SHAPES", "STRIDE", "STRONG", "Response", "SomeSensors",
    "Tiles", "boxes_beyond", "nodes_beyond", "orthonormal", "strength", "tiles_of",
]  # fmt: skip

NEAR, COUNT, BASIS, NODES, SHAPES, ROWS, STRIDE, ORDER = range(8)
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

    table (tiles, 8): where the sensors of a tile begin, how many; where the basis, how many nodes; where the shapes;
    then rows, and nodes of a row, the last of which is none; how the basis of k sensors lies: 0 (3 nodes / 16, k, 16),
    1 (nodes, 3, k), 2 (nodes / 8, 3, k, 8); origin (tiles, 4): y and z of its first node and both steps, or instead of
    y the first of `nodes`; near: the sensors that count, k even; shapes (9, nodes): as of `scan.within`; sensors (4, k)
    and first (k + 1,): those of a `PointModel` that count, where they are asked for. All lie one tile after the other.
    A sensor that is one more than there are reads nothing.
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


class SomeSensors:
    """Readings of some of an array's sensors under unit forces, at nodes: columns of those of all, which are kept.

    Parameters
    ----------
    whole : callable
        Gives the response of all sensors; asked where nodes are new.
    pattern : ndarray of bool, shape (sensors of all,)
        Which sensors they are.
    kept : Prepared
        Where readings of all sensors are kept, by nodes.
    name : int
        Tells responses of one locator apart.
    """

    def __init__(
        self, whole: Callable[[], RadialResponse], pattern: npt.NDArray[np.bool_], kept: Prepared, name: int = 0
    ) -> None:
        self.sensors = int(pattern.sum())
        self._whole, self._pattern, self._kept, self._name = whole, pattern, kept, name

    def __call__(self, nodes: FloatArray) -> FloatArray:
        """Readings per unit of (N, Ty, Tz), shape (nodes, n, 3)."""
        key = (self._name, nodes.shape, nodes.tobytes())
        return np.compress(self._pattern, self._kept.get(key, lambda: self._whole()(nodes)), axis=-2)


Response: TypeAlias = RadialResponse | SomeSensors


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
        order: int = 0,
    ) -> None:
        """A tile of nodes that have `fields` (nodes, n, 3), of which the sensors `near` count."""
        basis, shapes = orthonormal(fields[:, near])
        (rows, columns), n = shape, fields.shape[1]
        stride = columns + (rows > 1)
        nodes, k = rows * stride + -(rows * stride) % 16, near.size + near.size % 2
        at = (np.arange(rows)[:, None] * stride + np.arange(columns)).reshape(-1)
        full, wide = np.zeros((k, 3, nodes)), np.zeros((9, nodes))
        full[: near.size, :, at], wide[:, at] = np.moveaxis(basis, 0, -1), shapes
        if order == 0:
            full = np.ascontiguousarray(full.reshape(k, -1, 2 * EIGHT).swapaxes(0, 1))
        elif order == 1:  # where single nodes are looked at
            full = np.ascontiguousarray(np.moveaxis(full, -1, 0).swapaxes(1, 2))
        elif order == 2:  # where those are that stand side by side
            full = np.ascontiguousarray(full.reshape(k, 3, -1, EIGHT).transpose(2, 1, 0, 3))
        self.rows.append((self.sizes[0], k, self.sizes[1], nodes, self.sizes[2], rows, stride, order))
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


def _grid(box: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    return tuple(np.linspace(low, high, max(math.ceil((high - low) / step - 1e-9) + 1, 3)) for low, high in box)  # type: ignore[return-value]


def _fields(response: Response, scale: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    nodes = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1).reshape(-1, 2)
    return response(nodes) * scale[:, None]


def tiles_of(
    responses: Sequence[Response],
    scale: FloatArray,
    box: FloatArray,
    step: float,
    finer: float,
    friction: float,
    inner: FloatArray | None = None,
) -> Tiles:
    """Of each response a tile for each sensor, one of the whole in steps of `step`, one in steps of `finer`.

    box ((y low, y high), (z low, z high)); scale (n,): 1 / noise. Where `inner` is a smaller box, tiles of
    it for each sensor come before all others.
    """
    build = _Builder()
    if inner is not None and (inner != box).any():
        _add_sensors(build, responses[0], scale, inner, step, friction)
    for response in responses:
        _add_tiles(build, response, scale, box, step, finer, friction)
    return build.done()


def _add_tiles(
    build: _Builder, response: Response, scale: FloatArray, box: FloatArray, step: float, finer: float, friction: float
) -> None:
    """The tiles of one response."""
    fields, y, z = _add_sensors(build, response, scale, box, step, friction)
    steps = (float(y[1] - y[0]), float(z[1] - z[0]))
    every = np.arange(response.sensors)
    build.add(fields, every, (y.size, z.size), (float(y[0]), float(z[0]), *steps))
    y, z = _grid(box, finer)
    steps = (float(y[1] - y[0]), float(z[1] - z[0]))
    build.add(_fields(response, scale, y, z), every, (y.size, z.size), (float(y[0]), float(z[0]), *steps), 2)


def _add_sensors(
    build: _Builder, response: Response, scale: FloatArray, box: FloatArray, step: float, friction: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A tile of one response for each sensor; the readings under unit forces at all nodes, and these."""
    y, z = _grid(box, step)
    steps = (float(y[1] - y[0]), float(z[1] - z[0]))
    fields = _fields(response, scale, y, z)
    hot, share = strength(fields, friction)
    columns = z.size
    for sensor in range(response.sensors):
        here = hot[:, sensor] >= STRONG
        here[np.argmax(hot[:, sensor])] = True
        j, k = np.divmod(np.flatnonzero(here), columns)
        j0, j1 = max(j.min() - 1, 0), min(j.max() + 2, y.size)
        k0, k1 = max(k.min() - 1, 0), min(k.max() + 2, columns)
        at = (np.arange(j0, j1)[:, None] * columns + np.arange(k0, k1)).reshape(-1)
        build.add(fields[at], _near(share[at]), (j1 - j0, k1 - k0), (float(y[j0]), float(z[k0]), *steps))
    return fields, y, z


def boxes_beyond(box: FloatArray, beyond: float) -> FloatArray:
    """Four boxes (y low, y high, z low, z high) to the distance `beyond` [m] round the search; 0: its sides."""
    (y0, y1), (z0, z1) = box
    a, b, c, d = y0 - beyond, y1 + beyond, z0 - beyond, z1 + beyond
    return np.array([[a, y0, c, d], [y1, b, c, d], [y0, y1, c, z0], [y0, y1, z1, d]])


def nodes_beyond(
    responses: Sequence[Response], scale: FloatArray, boxes: FloatArray, depth: float, friction: float,
    each: bool = True,
) -> tuple[Tiles, FloatArray]:  # fmt: skip
    """Of each response a tile of `boxes` for each sensor, then one of all; and its nodes (nodes, 4).

    These are y, z, which box, and a share. Unless `each`, there is but the tile of all, which lies node by node.

    Rings of nodes stand closer near the search, `_RINGS` depths from it. A load of a box explains at most what one of
    its nodes does over that node's share.
    """
    y0, y1, z0, z1 = boxes[0, 1], boxes[1, 0], boxes[2, 3], boxes[3, 2]
    rings, ring = [], []
    for away in _RINGS if boxes[0, 0] < y0 else _RINGS[:1]:
        step, out = 0.25 * depth * max(1.0, 1.2 * away), away * depth
        y = np.linspace(y0 - out, y1 + out, max(math.ceil((y1 - y0 + 2 * out) / step) + 1, 3))
        z = np.linspace(z0 - out, z1 + out, max(math.ceil((z1 - z0 + 2 * out) / step) + 1, 3))
        rings += [np.column_stack([np.full(z.size, end), z]) for end in (y[0], y[-1])]
        rings += [np.column_stack([y[1:-1], np.full(y.size - 2, end)]) for end in (z[0], z[-1])]
        ring += [away] * (2 * z.size + 2 * (y.size - 2))
    at, build = np.concatenate(rings), _Builder()
    nodes: list[FloatArray] = []
    which = np.where(at[:, 0] <= y0, 0, np.where(at[:, 0] >= y1, 1, np.where(at[:, 1] <= z0, 2, 3)))
    for response in responses:
        fields = response(at) * scale[:, None]
        share = _shares(response, scale, boxes, fields, at, which, np.array(ring), depth, friction)
        every = np.column_stack([at, which, share])
        hot, near_share = strength(fields, friction) if each else (fields[..., 0], fields[..., 0])
        for sensor in range(0 if each else response.sensors, response.sensors + 1):
            whole = sensor == response.sensors
            some = np.arange(len(every)) if whole else np.flatnonzero(hot[:, sensor] >= STRONG**2)
            near = np.arange(response.sensors) if whole else _near(near_share[some]) if some.size else np.arange(2)
            start = float(sum(len(part) for part in nodes))
            build.add(fields[some], near, (1, some.size), (start, 0.0, 0.0, 0.0), int(not each))
            nodes.append(every[some])
    return build.done(), np.concatenate(nodes)


def _shares(
    response: Response,
    scale: FloatArray,
    boxes: FloatArray,
    fields: FloatArray,
    nodes: FloatArray,
    which: npt.NDArray[np.intp],
    ring: FloatArray,
    depth: float,
    friction: float,
) -> FloatArray:
    """Of each node: the least share of a load in its box that a node of its ring explains where it is the best one."""
    rng = np.random.default_rng(0)
    out = np.ones(len(nodes))
    least = np.ones(len(nodes))
    for b, (y0, y1, z0, z1) in enumerate(boxes):
        own = np.flatnonzero(which == b)
        basis, _ = orthonormal(fields[own])
        at = np.stack([rng.uniform(y0, y1, 2 * _SAMPLES), rng.uniform(z0, z1, 2 * _SAMPLES)], axis=-1)
        # as many again near the search, where the nodes are close and the share is large
        span, far = 2.0 * depth, y1 - y0 if b < 2 else z1 - z0
        across = int(b >= 2)
        edge = boxes[b, 1] if b == 0 else boxes[b, 0] if b == 1 else boxes[b, 3] if b == 2 else boxes[b, 2]
        side = -1.0 if b % 2 == 0 else 1.0
        at[_SAMPLES:, across] = edge + side * rng.uniform(0.0, min(span, far), _SAMPLES)
        made = np.einsum("pnj,dj->pdn", response(at) * scale[:, None], directions(friction)).reshape(-1, scale.size)
        made /= np.maximum(np.linalg.norm(made, axis=-1, keepdims=True), 1e-300)
        parts = (made @ basis[..., 0].T) ** 2
        parts += (made @ basis[..., 1].T) ** 2
        parts += (made @ basis[..., 2].T) ** 2
        best = parts.argmax(axis=-1)
        np.minimum.at(least, own[best], parts[np.arange(best.size), best])
    for away in np.unique(ring):
        out[ring == away] = _MARGIN * least[ring == away].min()
    return out
