"""A row, or an array on an area, as whitened tables; the touches on it surveyed, and what it comes to in numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen
from ...array import SensorArray
from ...contact import RoundHertz
from ...finger import Finger
from ...prepared import tabulated
from ...radial import RadialResponse, sampled, shared, tabulate_radial
from ...response import Response, tabulate
from ...skin import Skin
from ...transducer import Transducer
from .._common import noise_of
from ..touches import Touches
from .asked import AREA_MEASURES, FALSE_ALARM, SHARES, AskedTouches, Judged, Told, summed_up, trapezoid
from .layout import Channel

MAPS = ("position", "force", "angle", "log_det", *SHARES)
"""Rows of a survey, in the order of the compiled code."""

_PEAKS, _UPHILL = 24, 30
"""Of a grid on an area, from which the largest standard deviation is looked for, and steps to it."""
_PIECE, _EXACT = 12.0, 1e-9
"""Depths from the middle of a table to where the next piece of it begins; error beside its largest value."""
_CELLS = 16
_SCAN = 32
"""Per depth: cells of a table, and positions at which loads are looked for; `locate` has the same."""


def _compiled() -> tuple[Any, Any]:
    """The compiled files, imported on first use."""
    from . import _bounds_kernel, _kernel

    return _bounds_kernel, _kernel


@dataclass(frozen=True, eq=False)
class RowField(Frozen):
    """A row's whitened receptive field, shape (cells, 5, 2, n), its start and step [m], and its shallowest depth [m].

    Its two ends are those of the search.
    """

    values: FloatArray
    start: float
    step: float
    shallowest: float

    @classmethod
    def of(cls, finger: Finger, search: tuple[float, float]) -> RowField:
        """That of a finger, its dead sensors left out; loads are looked for over `search` [m]."""
        live = finger.array.live
        array = finger.array.select(live)
        noise = noise_of(array)
        field = tabulate(finger, search).select(live)
        values = np.ascontiguousarray(np.swapaxes(field.coefficients / noise[:, None], 2, 3))
        return cls(values, field.start, field.step, float(np.asarray(array.depth).min()))

    def survey(
        self, touches: Touches, positions: FloatArray, angles: FloatArray, ambiguity: float, *, bounds: bool = True
    ) -> FloatArray:
        """`MAPS` of touches at positions (p,) [m] and angles (k,) or (p, k) [rad], shape (7, p, k).

        Without `bounds` the first four are not filled.
        """
        angles = np.broadcast_to(angles, (positions.size, angles.shape[-1]))
        out = np.empty((len(MAPS), *angles.shape))
        length = self.step * len(self.values)
        count = max(int(np.ceil(length * _SCAN / self.shallowest - 1e-9)) + 1, 3)
        limits = [2 * np.log(1 / FALSE_ALARM), ambiguity, 0.02 * self.shallowest, 0.1 * self.shallowest]
        scan = np.array([self.start, length / (count - 1), count])
        # copies of the positions, for another kind of array would be compiled for
        _compiled()[1].survey(
            self.values, self.start, self.step, scan, touches.friction, touches.cone, touches.force, np.array(limits),
            np.array(positions), np.stack([np.cos(angles), np.sin(angles)]), bounds, out,
        )  # fmt: skip
        return out

    def worst(self, touches: Touches, positions: FloatArray, angles: FloatArray, maps: FloatArray) -> FloatArray:
        """Largest standard deviations of position, force and angle, uphill from the highest points of a grid."""
        uphill = _compiled()[0].uphill
        ends = np.array([positions[[0, -1]], angles[[0, -1]]])
        size = np.ptp(ends, axis=1) / np.maximum([positions.size - 1, angles.size - 1], 1)
        out: FloatArray = maps[:3].max(axis=(1, 2))
        for which in np.flatnonzero(np.isfinite(out)):
            for p, k in _highest(maps[which]):
                top = uphill(
                    self.values, self.start, self.step, touches.friction, touches.force, which,
                    np.array([positions[p], angles[k]]), size, ends,
                )  # fmt: skip
                out[which] = max(out[which], top)
        return out

    def judged(self, asked: AskedTouches, box: FloatArray, *, maps: bool) -> Judged:
        """What is asked of touches over the span `box` (1, 2) [m]; with `maps` their shares are found on the grid."""
        touches, span, shape = asked.touches, box[0], asked.grid
        positions = np.linspace(span[0], span[1], shape[0])
        angles = np.linspace(-touches.cone, touches.cone, shape[1]) if touches.cone > 0 else np.zeros(1)
        weight = trapezoid(positions.size)[:, None] * trapezoid(angles.size)
        found = self.survey(touches, positions, angles, asked.ambiguity)
        worst = dict(zip(MAPS, self.worst(touches, positions, angles, found).tolist(), strict=False))
        named = dict(zip(MAPS, found, strict=True))
        most = {"position": float(np.ptp(span)) / 12**0.5, "angle": touches.cone / 3**0.5, "force": 1.0}
        std = {name: named[name] for name in most}
        values = summed_up(std, weight, most, worst)
        shares = {name: named[name] for name in SHARES} if maps else {}
        if maps:
            values |= {name: float((share * weight).sum()) for name, share in shares.items()}
        else:
            at = span[0] + np.ptp(span) * asked.shares
            drawn = self.survey(touches, at, touches.cone * asked.lean, asked.ambiguity, bounds=False)
            values |= {name: float(share.mean()) for name, share in zip(SHARES, drawn[-3:], strict=True)}
        values["log_det"] = float((named["log_det"] * weight).sum())
        load = touches.force * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        return Judged(positions, load, weight, std, shares, values)


def _highest(heights: FloatArray, most: int = 6) -> npt.NDArray[np.intp]:
    """Indices of the highest few points that no neighbour exceeds, shape (m, d)."""
    from scipy.ndimage import maximum_filter

    at = np.argwhere(heights >= maximum_filter(heights, size=3))
    return at[np.argsort(-heights[tuple(at.T)], kind="stable")[:most]]


class OneSensor:
    """The receptive field of one sensor, from which that of every row at its depth follows by shifting it.

    On a skin with ridges each row is tabulated by itself. `reach` is the largest distance of a load from a sensor that
    will be asked for [m].
    """

    def __init__(self, skin: Skin, kind: Channel, depth: float, reach: float) -> None:
        self._row: Callable[[FloatArray], Finger] | None = None
        self._depth = depth
        transducer, noise, width = kind
        if skin.ridges is not None:
            self._row = lambda y: Finger(skin, SensorArray(y, depth, transducer, noise=noise, width=width))
            return

        def stretch(low: float, high: float, step: float, tolerance: float) -> Response:
            return Response.from_function(
                lambda positions: _of_one(skin, transducer, depth, positions), low, high, step=step, tolerance=tolerance
            )

        piece, key = _PIECE * depth, ("row", skin, transducer, depth)
        field = tabulated((*key, 0), lambda: stretch(-piece, piece, depth / _CELLS, _EXACT))
        parts = [field.coefficients]
        for k in range(1, int(np.ceil((reach + width) / piece - 1e-9))):
            # farther off the field is smoother: cells of the middle do
            for side in (-1, 1):
                low, high = sorted((side * k * piece, side * (k + 1) * piece))
                more = tabulated((*key, side * k), partial(stretch, low, high, field.step, np.inf))
                parts.insert(0 if side < 0 else len(parts), more.coefficients)
        whole = Response(-piece * (len(parts) + 1) / 2, field.step, np.concatenate(parts))
        if width:
            whole = whole.averaged(width)
        self._step, self._start = whole.step, whole.start
        self._values = np.ascontiguousarray(whole.coefficients[:, :, 0, :] / noise)

    def moved(self, points: FloatArray, _: npt.NDArray[np.intp], box: FloatArray) -> RowField:
        """The table of sensors at `points` (n, 1) [m], with loads looked for in the `box` (1, 2) [m]."""
        positions, (low, high) = np.array(points[:, 0]), box[0].tolist()
        if self._row is not None:
            return RowField.of(self._row(positions), (low, high))
        cells = max(int(np.ceil((high - low) * _CELLS / self._depth - 1e-9)), 1)
        step = (high - low) / cells
        values = np.empty((cells, 5, 2, positions.size))
        _compiled()[0].row_table(self._values, self._start, self._step, positions, low, step, values)
        return RowField(values, low, step, self._depth)


def _of_one(skin: Skin, transducer: Transducer, depth: float, positions: FloatArray) -> FloatArray:
    """The field of a sensor at y = 0 under loads at positions (cells, m), those of each cell alike: (cells, m, 1, 2).

    It is that of as many sensors under m loads: what a skin sums over waves is then a product of matrices.
    """
    finger = Finger(skin, SensorArray(-positions[:, 0], depth, transducer))
    field = finger.receptive_field(positions[0] - positions[0, 0], "line")
    return np.swapaxes(field, 0, 1)[:, :, None]


_LEANS, _LEAN_WEIGHTS = (0.0, 0.5, 1.0), (0.25, 0.5, 0.25)
"""Angles at which bounds are found, in shares of the largest, and the weights of the trapezoidal rule."""
_WIDER = 0.02
"""Share by which the half width is changed for the slope of the readings in it."""
_NODES = 0.4
"""Distance of the positions at which loads are looked for, in least depths: as `AreaLocator` has it."""


@dataclass(frozen=True, eq=False)
class AreaField(Frozen):
    """Readings in units of noise under unit forces, at the touches' half width or at three about it, `wider` apart.

    cubics, terms, cells: the tables as compiled loops want them; box (2, 2): where loads are looked for [m].
    """

    tables: tuple[RadialResponse, ...]
    wider: float
    cubics: FloatArray
    terms: npt.NDArray[np.int64]
    cells: int
    box: FloatArray

    @classmethod
    def of(cls, finger: Finger, touches: Touches, box: FloatArray, reach: float) -> AreaField:
        """That of a finger whose sensors are live, out to the distance `reach` [m] from them."""
        noise = noise_of(finger.array)
        wider, tables = _tables_of(finger, tabulate_radial(finger, reach), touches)
        whitened = tuple(replace(table, gain=table.gain / noise) for table in tables)
        return cls(whitened, wider, *_compiled_tables(whitened[len(whitened) // 2]), box)

    @classmethod
    def of_each(cls, skin: Skin, kinds: Sequence[Channel], depth: float, touches: Touches, reach: float) -> AreaField:
        """That of a channel of each kind at (0, 0), from which those of every array at its depth follow: `moved`."""
        zero, (transducers, noise, width) = np.zeros(len(kinds)), zip(*kinds, strict=True)
        probe = Finger(skin, SensorArray(zero, depth, transducers, width=width, z=zero, noise=noise))
        return cls.of(probe, touches, np.zeros((2, 2)), reach)

    def moved(self, points: FloatArray, which: npt.NDArray[np.intp], box: FloatArray) -> AreaField:
        """Of channels at `points` (n, 2) [m], `which` (n,) of these each is."""
        tables = tuple(
            replace(t, points=points, depth=t.depth[which], gain=t.gain[which], kind=t.kind[which]) for t in self.tables
        )
        return replace(self, tables=tables, box=box)

    @property
    def response(self) -> RadialResponse:
        """That of the touches."""
        return self.tables[len(self.tables) // 2]

    def jacobian(self, position: FloatArray, load: FloatArray) -> FloatArray:
        """How readings change with y, z, (the half width) and N, Ty, Tz of loads (..., 3) at (..., 2), (..., n, u)."""
        unit, slopes = self.response(position), self.response.slopes(position)
        if self.wider:
            by_width = (self.tables[2](position) - self.tables[0](position)) / (2 * self.wider)
            slopes = np.concatenate([slopes, by_width[..., None]], axis=-1)
        moved = np.asarray(sum(slopes[..., c, :] * load[..., None, c, None] for c in range(3)))
        return np.concatenate([moved, np.broadcast_to(unit, (*moved.shape[:-1], 3))], axis=-1)

    def told(self, position: FloatArray, load: FloatArray, touches: Touches) -> Told:
        """Bounds of loads (..., 3) at positions (..., 2) that broadcast."""
        jacobian = self.jacobian(position, load)
        depth = float(self.response.depth.min())
        # a depth for each length and the force for each component: beside these the unknowns are scaled
        units = np.array([*[depth] * (jacobian.shape[-1] - 3), *[touches.force] * 3])
        return Told.of(np.swapaxes(jacobian, -1, -2) @ jacobian, units, 0 if touches.friction > 0 else 2)

    def judged(self, asked: AskedTouches, box: FloatArray, *, maps: bool) -> Judged:
        """What is asked of touches over the area `box` (2, 2) [m]; `maps` are found beside the shares."""
        touches, p = asked.touches, asked.grid[0]
        position, (angle, azimuth, leaning) = _grid_of(box, p), _leans_of(touches, asked.grid[1])
        load = touches.leaning(angle, azimuth)
        side = np.ones(p)
        side[[0, -1]] = 0.5
        weight = np.multiply.outer(np.multiply.outer(side, side), leaning)
        weight /= weight.sum()
        told = self.told(position[..., None, :], load, touches)
        std, unknowns = told.stds(load), told.covariance.shape[-1] - (0 if touches.friction > 0 else 2)
        most = {"position": np.ptp(box, axis=1).max() / 12**0.5, "angle": touches.cone / 3**0.5, "force": 1.0}
        parts = (position[..., :1], position[..., 1:], angle, azimuth)
        nodes = np.stack([np.broadcast_to(v, weight.shape) for v in parts], axis=-1)
        apart = np.maximum(np.ptp(box, axis=1) / (p - 1), 0.25 * float(self.response.depth.min()))
        steps = np.array([*apart, 0.5 * touches.cone, np.pi / asked.grid[1]])
        worst = {name: self.worst(touches, name, values, nodes, steps) for name, values in std.items()}
        values = summed_up(std, weight, most | {"radius": np.inf}, worst)
        values |= {"rank": float(told.rank.max()), "log_det": float((told.log_det * weight).sum())}
        found = {name: np.full(weight.shape, 1.0 if name == "ambiguous" else np.nan) for name in SHARES}
        values |= {name: float(share.flat[0]) for name, share in found.items()}
        if values["rank"] == unknowns:
            at = box[:, 0] + asked.shares * np.ptp(box, axis=1)
            drawn = touches.leaning(touches.cone * asked.lean, asked.azimuth)
            every = self.survey(touches, at, drawn, self.told(at, drawn, touches).covariance, asked.ambiguity)
            values |= dict(zip(SHARES, every.mean(axis=0).tolist(), strict=True))
            if maps:
                where, loads = (
                    np.broadcast_to(v, (*weight.shape, v.shape[-1])).reshape(-1, v.shape[-1])
                    for v in (position[..., None, :], load)
                )
                bounds = told.covariance.reshape(-1, *told.covariance.shape[3:])
                each = self.survey(touches, where, loads, bounds, asked.ambiguity)
                found = dict(zip(SHARES, each.T.reshape(-1, *weight.shape), strict=True))
        ordered = {name: values[name] for name in AREA_MEASURES}
        return Judged(position, load, weight, std, found, ordered, told.covariance, told.rank)

    def worst(self, touches: Touches, name: str, std: FloatArray, nodes: FloatArray, steps: FloatArray) -> float:
        """Largest of the standard deviations `std` (p, p, k), uphill from the highest of the `nodes` (p, p, k, 4).

        These are y, z [m], angle and azimuth [rad]. The `steps` (4,) are halved where none leads up.
        """
        at = tuple(_highest(std, _PEAKS).T)
        x, here = nodes[at], std[at]
        if not (np.isfinite(here).all() and here.any()):
            return float(here.max())
        ends = nodes.reshape(-1, 4)
        low, high = ends.min(axis=0), ends.max(axis=0)
        low[2:], high[2:] = (0.0, -np.inf), (touches.cone, np.inf)
        moves = np.concatenate([np.diag(steps), -np.diag(steps)])
        size, each = np.ones((len(x), 1, 1)), np.arange(len(x))
        for _ in range(_UPHILL):
            tried = np.clip(x[:, None] + size * moves, low, high)
            load = touches.leaning(tried[..., 2], tried[..., 3])
            found = self.told(tried[..., :2], load, touches).stds(load)[name]
            best = found.argmax(axis=1)
            up = found[each, best] > here
            x, here = np.where(up[:, None], tried[each, best], x), np.where(up, found[each, best], here)
            size = np.where(up[:, None, None], size, 0.5 * size)
        return float(here.max())

    def survey(
        self, touches: Touches, position: FloatArray, load: FloatArray, covariance: FloatArray, ambiguity: float
    ) -> FloatArray:
        """`SHARES` of touches at positions (t, 2) under loads (t, 3), whose bounds are known, shape (t, 3)."""
        from ...estimate.area.point import model_of
        from ._area_kernel import survey

        response, depth = self.response, float(self.response.depth.min())
        axes = []
        for low, high in self.box:
            count = max(int(np.ceil((high - low) / (_NODES * depth) - 1e-9)) + 1, 3)
            axes.append(np.linspace(low, high, count))
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        fields = np.ascontiguousarray(np.swapaxes(response(nodes), 1, 2))
        grams = fields @ np.swapaxes(fields, 1, 2)
        with np.errstate(all="ignore"):
            inverse = np.linalg.inv(grams + 1e-13 * np.trace(grams, axis1=1, axis2=2)[:, None, None] * np.eye(3))
        forms = np.stack([grams, inverse])
        model = model_of(response, np.ones(response.sensors), self.cells, self.cubics, self.terms)
        grid = np.array([(axis[0], axis[1] - axis[0], axis.size) for axis in axes])
        limits = np.array([2 * np.log(1 / FALSE_ALARM), ambiguity, 0.02 * depth, 0.1 * depth])
        readings = np.einsum("tnc,tc->tn", response(position), load)
        out = np.empty((len(readings), len(SHARES)))
        spread = np.stack([covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]], axis=-1)
        survey(
            readings, np.array(position), spread, model, fields, forms, grid,
            touches.friction, np.array(self.box.reshape(-1)), limits, out,
        )  # fmt: skip
        return out


def _tables_of(finger: Finger, point: RadialResponse, touches: Touches) -> tuple[float, tuple[RadialResponse, ...]]:
    """A finger's tables for the touches from those for points: three of them about a half width, and how far apart."""
    if touches.half_width is None:
        return 0.0, (point,)
    wider = _WIDER * touches.half_width
    sensors = [int(np.flatnonzero(point.kind == kind)[0]) for kind in range(len(point.coefficients))]
    cells, angles = point.coefficients.shape[1], 2 * int(point.terms[:, 1].max()) + 2
    every = []
    for k in (-1, 0, 1):
        a = touches.half_width + k * wider
        load = partial(RoundHertz, half_width=a)
        for i in sensors:
            array = finger.array
            sensor = array.transducers[i], float(np.asarray(array.depth)[i]), float(np.asarray(array.width)[i])
            key = ("round", finger.skin, *sensor, cells, angles, a)
            every.append(tabulated(key, partial(sampled, finger, i, cells, load, angles)))
    terms, tables, error = shared(every)
    each = tables.reshape(3, len(sensors), *tables.shape[1:])
    return wider, tuple(replace(point, terms=terms, coefficients=c, error=error) for c in each)


def _compiled_tables(response: RadialResponse) -> tuple[FloatArray, npt.NDArray[np.int64], int]:
    """Tables of a response as compiled loops want them, what their functions stand for, and the cells of one."""
    table, _ = response.cubics()
    if response.pair is not None:
        table = np.stack([sign * table[:, :, function] for function, sign in response.pair], axis=2)
    terms = response.terms if response.pair is None else response.terms[:0]
    rows = np.ascontiguousarray(table.reshape(table.shape[0] * table.shape[1], -1))
    return rows, np.ascontiguousarray(terms).astype(np.int64), table.shape[1]


def _grid_of(box: FloatArray, count: int) -> FloatArray:
    """Positions along both sides, from end to end, (p, p, 2) [m]."""
    return np.stack(np.meshgrid(*(np.linspace(low, high, count) for low, high in box), indexing="ij"), axis=-1)


def _leans_of(touches: Touches, azimuths: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Angles and azimuths of loads straight down and to all sides (k,) [rad], and their weights (k,)."""
    leans = [(0.0, 0.0, 1.0)]
    if touches.cone > 0:
        turns = 2 * np.pi * (np.arange(azimuths) + 0.25) / azimuths  # none along an axis of the array
        leans = [(0.0, 0.0, _LEAN_WEIGHTS[0])]
        for lean, share in zip(_LEANS[1:], _LEAN_WEIGHTS[1:], strict=True):
            leans += [(lean * touches.cone, turn, share / azimuths) for turn in turns]
    angle, azimuth, share = np.array(leans).T
    return angle, azimuth, share
