"""The estimator of local contacts: prepared once for a response on an area, then called on frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...array import SensorArray
from ...errors import GeometryError, InvalidValueError
from ...prepared import Prepared
from ...radial import RadialResponse
from ..estimate import Estimate
from ..frames import Framewise, sensor_rows
from ..layout import AREA, Layout
from ..varpro import Limits
from .alike import least_told_apart
from .far import INNER, far_from, nodes_of
from .point import PointModel, model_of
from .settings import Beyond, Settings, plain
from .tiles import Response, SomeSensors, Tiles, boxes_beyond, nodes_beyond, tiles_of

__all__ = ["BEYOND", "AreaLocator"]

BEYOND = 8.0
"""Depths beside the default search up to which a load is thought of."""
_STEP, _FINER = 0.4, 5.0
_REACH = 1.5
_STRONG = 22.0
"""Noises from which the strongest reading is a sensor's that stands near the load (`tiles.py`)."""
_CURVED = 0.02
_ALIKE = 2e-3
"""Share of a load's squared readings below which another one, close by, may be taken for it."""
_MOST_FINE = 4_000_000
_MOST_NODES = 2_000_000
_RING_LEAVES, _BEYOND_LEAVES, _LEAVES = 6e-4, 2e-4, 0.03
"""What directions of a region leave of a unit reading, squared, a sensor: in the search and beyond; and the most."""


class AreaLocator(Framewise):
    """Finds the local contact in frames of readings; prepared once, then called on a frame or on millions.

    Variable projection: readings are linear in (N, Ty, Tz), which are eliminated exactly at each trial position, within
    compression and the cone of friction; what remains is a search over (y, z) (docs/locating_area.md). It is global: a
    grid, then the best maxima are refined; the second of them is the rival.

    Parameters
    ----------
    response : RadialResponse
        Readings under unit forces; it has to reach from any sensor to any position of the search and beyond.
    array : SensorArray
        Offset, noise and range of each sensor (its gain is in the response; gain 0 marks a dead sensor).
    search : ((float, float), (float, float))
        Ends of the positions y, and of z [m].
    beyond : float, optional
        Distance beyond the search [m] at which a load may press as well. Where one there, or at a side of the search,
        comes within `ambiguity` of the best chi-square, the frame is AMBIGUOUS.
    friction, scan_step, false_alarm, ambiguity, outliers
        As of `Locator`; the default step is 0.4 of the least depth.

    Raises
    ------
    InvalidValueError, GeometryError
        A sensor without noise, a response whose sensors do not match the array's, an option out of range.
    """

    layout: Layout = AREA
    wide = False
    """Whether the contact has a half width that is not known."""

    def __init__(
        self,
        response: RadialResponse,
        array: SensorArray,
        search: tuple[tuple[float, float], tuple[float, float]],
        *,
        beyond: float = 0.0,
        friction: float = 1.0,
        scan_step: float | None = None,
        false_alarm: float = 1e-6,
        ambiguity: float = 13.8,
        outliers: int = 0,
    ) -> None:
        if response.sensors != len(array):
            seen = f"a response of {response.sensors} sensors, an array of {len(array)}"
            raise GeometryError(seen, "they have to match", "array.select(...)")
        self.response, self.search = response, search
        self.friction = _check.friction(friction)
        self.unknowns = 3 + 2 * (self.friction > 0) + self.wide + self.layout.twist
        self._ambiguity = _check.scalar("ambiguity", ambiguity, at_least=0.0)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        self._beyond = _check.scalar("beyond", beyond, unit="m", at_least=0.0)
        self._fields = Prepared()
        self._depth = float(np.asarray(array.depth).min())
        self._step = step_of(array, search, scan_step)
        super().__init__(
            array, needed=self.unknowns, columns=self.layout.columns, status=self.layout.status, layout=self.layout,
            outliers=outliers, ambiguity=self._ambiguity,
        )  # fmt: skip

    def __call__(self, readings: npt.ArrayLike) -> Estimate:
        """The contact in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            Raw readings, offset included, in units of each gain. NaN marks a missing one; it, and a saturated one, are
            left out of its frame.

        Returns
        -------
        Estimate
            Fields of shape (...); positions end in 2, components in 3, covariances in (5, 5).

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        table, used = self._frames(readings)
        return Estimate(table, used, self.friction, self.unknowns, self.layout, self.relative)

    def covers(self, position: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Which positions lie where loads are looked for.

        Parameters
        ----------
        position : array_like, shape (..., 2)
            Positions (y, z) [m].
        """
        at, box = np.asarray(position, dtype=np.float64), np.asarray(self.search)
        return np.asarray(((box[:, 0] <= at) & (at <= box[:, 1])).all(axis=-1))

    def _kernel(self) -> Any:
        from .project import project_frames

        return project_frames

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        """Arguments of the compiled loop between the frames and the output, for the sensors of `pattern`."""
        array, response = self.array.select(pattern), self.response.select(pattern).separate()
        table, error = response.cubics()
        series = response.series() if response.pair is not None else None
        if series is not None:  # one cell holds all distances
            table, error = series[0][None, None], series[1]
        cells = table.shape[1]
        if response.pair is not None:
            table = np.stack([sign * table[:, :, function] for function, sign in response.pair], axis=2)
        terms = response.terms if response.pair is None else response.terms[:0]
        inner, outer = self._over_the_sensors()
        table = np.ascontiguousarray(table.reshape(table.shape[0] * cells, -1))
        model = model_of(response, np.asarray(array.noise), cells, table, terms)
        tiles, beyond, sizes = self._looked_at(model, [lambda: self.response], [0], pattern, inner)
        seen = self._read_by(lambda: self.response, pattern)
        ring, far, (held, members) = self._far(seen, array, inner, outer, beyond.nodes)
        least = least_told_apart(seen, array.points, 1 / np.asarray(array.noise), self._depth, self.friction)
        settings = self._settings(array, response, error, least if least < _ALIKE else np.inf)
        beyond = beyond._replace(held=held, members=members)
        return sensor_rows(array), *map(plain, (model, tiles, beyond, ring, far)), sizes, plain(settings)

    def _far(
        self, response: Response, array: SensorArray, inner: FloatArray, outer: FloatArray, nodes: FloatArray
    ) -> tuple[Any, ...]:
        """Bounds for the search round its inner part, and for what is beyond, of which each region has `nodes`.

        Of a search that ends, both are the same.
        """
        seen, boxes = (response, array.points, 1 / np.asarray(array.noise)), (inner, np.array(self.search), outer)
        kind = self._depth, self.friction
        ring_leaves, beyond_leaves = (min(per * response.sensors, _LEAVES) for per in (_RING_LEAVES, _BEYOND_LEAVES))
        ring, held = far_from(*seen, *boxes[:2], *kind, ring_leaves)
        beyond = ring
        if self._beyond > 0:
            beyond, held = far_from(*seen, *boxes[1:], *kind, beyond_leaves, 1.0)
        return ring._replace(once=1), beyond, nodes_of(held, nodes[:, :2])

    def _over_the_sensors(self) -> tuple[FloatArray, FloatArray]:
        """The part of the search where most touches stand, and how far loads are thought of."""
        points, box = self.array.points, np.array(self.search)
        away = INNER * self._depth
        inner = np.stack([points.min(axis=0) - away, points.max(axis=0) + away], axis=-1)
        inner = np.stack([np.maximum(inner[:, 0], box[:, 0]), np.minimum(inner[:, 1], box[:, 1])], axis=-1)
        if (inner[:, 0] >= inner[:, 1]).any():  # a search beside the sensors
            inner = box
        return inner, box + self._beyond * np.array([-1.0, 1.0])

    def _settings(self, array: SensorArray, response: RadialResponse, error: float, told: float = np.inf) -> Settings:
        """The numbers that the compiled loop goes by; `error` is that of its table."""
        from scipy.special import chdtri

        box = np.array(self.search)
        strongest = np.abs(response(np.array([[p.mean() for p in box]])) / np.asarray(array.noise)[:, None]).max()
        return Settings(
            limits=Limits(self.friction),
            detection=float(2 * np.log(1 / self._false_alarm)),
            largest=float(chdtri(max(len(array) - self.unknowns, 1), self._false_alarm)),
            ambiguity=self._ambiguity,
            apart=0.02 * self._depth,
            broad=0.1 * self._depth,
            strong=_STRONG,
            curved=_CURVED * self._depth,
            smallest=1e-9 * self._depth,
            box=box.reshape(-1),
            error=float(len(array) * (error * strongest) ** 2),
            told=told,
        )

    def _read_by(self, whole: Callable[[], RadialResponse], pattern: npt.NDArray[np.bool_], name: int = 0) -> Response:
        """What the sensors of `pattern` read, of what all read."""
        return whole().select(pattern) if pattern is self._all else SomeSensors(whole, pattern, self._fields, name)

    def _looked_at(
        self,
        model: PointModel,
        wholes: Sequence[Callable[[], RadialResponse]],
        far: Sequence[int],
        pattern: npt.NDArray[np.bool_],
        inner: FloatArray | None = None,
    ) -> tuple[Tiles, Beyond, npt.NDArray[np.int64]]:
        """Where the scans look, in the search and beyond it, and the most nodes and the longest row of a tile.

        `model` is that of the sensors of `pattern`; `wholes` give the responses of all sensors that are scanned, and
        `far` which of them beyond the search; `inner` is the part that is looked at first, where bounds say which nodes
        beyond are looked at. Where a sensor is missing, what is read at the nodes is a part of what all of them read,
        which is kept: a stream waits for half as long.
        """
        array, box = self.array.select(pattern), np.array(self.search)
        scale = 1 / np.asarray(array.noise)
        responses = [self._read_by(whole, pattern, name) for name, whole in enumerate(wholes)]
        finest = float(np.sqrt(3 * len(array) * np.ptp(box, axis=1).prod() / _MOST_FINE))
        tiles = tiles_of(responses, scale, box, self._step, max(self._step / _FINER, finest), self.friction, inner)
        boxes = boxes_beyond(box, self._beyond)
        seen = [responses[i] for i in far]
        outer, nodes = nodes_beyond(seen, scale, boxes, self._depth, self.friction, inner is None)
        widest = max(int(t.table[:, 3].max()) for t in (tiles, outer))
        sizes = np.array([widest, int(tiles.table[:, 6].max()) + 2])
        # the sensors near each tile, and one that reads nothing
        every, kinds, last = (
            np.column_stack([model.sensors, np.zeros(4)]),
            np.append(model.first[:-1], 0),
            model.first[-1],
        )
        parts = [tiles.near[i : i + k] for i, k in tiles.table[:, :2]]
        tiles = tiles._replace(
            sensors=np.concatenate([every[:, near].reshape(-1) for near in parts]),
            first=np.concatenate([np.append(kinds[near], last) for near in parts]),
        )
        return tiles, Beyond(outer, nodes, boxes, np.array([0, len(nodes)]), np.arange(len(nodes))), sizes


def reach_of(array: SensorArray, box: FloatArray, beyond: float = 0.0) -> float:
    """How far a response has to reach for loads in the box (2, 2), and `beyond` it [m]."""
    return float(np.sqrt(2.0) * (max(float(np.abs(array.points - corner).max()) for corner in box.T) + beyond))


def step_of(array: SensorArray, search: Any, scan_step: float | None) -> float:
    """The steps of a search [m], which are not to be too many."""
    usual = _STEP * float(np.asarray(array.depth).min())
    step = _check.scalar("scan_step", usual if scan_step is None else scan_step, unit="m", above=0.0)
    sides = np.ptp(np.asarray(search), axis=1)
    if not sides[0] / step <= _MOST_NODES / max(sides[1] / step, 1.0):
        seen = f"a search of {sides[0]:.4g} by {sides[1]:.4g} m in steps of {step:.4g} m"
        rule = f"at most {_MOST_NODES} positions are looked at"
        raise InvalidValueError(seen, rule, "a narrower search; all lengths are in m: 6e-3")
    return step


def search_of(array: SensorArray, search: Any) -> tuple[FloatArray, float]:
    """The ends of a search ((y low, y high), (z low, z high)) and how far loads are thought of beyond it [m].

    The default goes 1.5 depths beyond the outermost sensors.
    """
    deepest, points = float(np.asarray(array.depth).max()), array.points
    if search is None:
        low, high = points.min(axis=0) - _REACH * deepest, points.max(axis=0) + _REACH * deepest
        return np.stack([low, high], axis=-1), BEYOND * deepest
    box = _check.real("search", search, unit="m")
    if box.shape != (2, 2) or not (box[:, 0] < box[:, 1]).all():
        rule = "the ends of y and those of z are needed, ascending"
        raise InvalidValueError(f"search = {_check.shown(search)}", rule, "search=((-5e-3, 5e-3), (-5e-3, 5e-3))")
    return box, 0.0
