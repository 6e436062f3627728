"""An array on an area as whitened tables, the bounds of Cramer and Rao for touches on it, and what it comes to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen
from ...array import SensorArray
from ...contact import RoundHertz
from ...errors import InvalidValueError
from ...finger import Finger
from ...prepared import tabulated
from ...radial import RadialResponse, sampled, shared, tabulate_radial
from ...skin import Skin
from .._common import widest
from ..touches import Touches
from .asked import AREA_MEASURES, FALSE_ALARM, SHARES, Asked, Judged, summed_up
from .layout import Channel

_LEANS, _LEAN_WEIGHTS = (0.0, 0.5, 1.0), (0.25, 0.5, 0.25)
"""Angles at which bounds are found, in shares of the largest, and the weights of the trapezoidal rule."""
_BLIND = 1e-10
"""Share of the information of the best seen combination of unknowns below which another is not seen at all."""
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
        noise = np.asarray(finger.array.noise)
        if not (noise > 0).all():
            raise InvalidValueError("noise = 0", "the answer depends on the noise of the sensors", "noise=1e-4")
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
        unit = self.response(position)
        parts = [np.einsum("...ncd,...c->...nd", self.response.slopes(position), load)]
        if self.wider:
            by_width = (self.tables[2](position) - self.tables[0](position)) / (2 * self.wider)
            parts.append(np.einsum("...nc,...c->...n", by_width, load)[..., None])
        return np.concatenate([*parts, np.broadcast_to(unit, (*parts[0].shape[:-1], 3))], axis=-1)

    def told(self, position: FloatArray, load: FloatArray, touches: Touches) -> Told:
        """Bounds of loads (..., 3) at positions (..., 2) that broadcast."""
        jacobian = self.jacobian(position, load)
        depth = float(self.response.depth.min())
        # a depth for each length and the force for each component: beside these the unknowns are scaled
        units = np.array([*[depth] * (jacobian.shape[-1] - 3), *[touches.force] * 3])
        return Told.of(np.swapaxes(jacobian, -1, -2) @ jacobian, units, 0 if touches.friction > 0 else 2)

    def judged(self, asked: Asked, box: FloatArray, *, maps: bool) -> Judged:
        """What is asked of touches over the area `box` (2, 2) [m]; `maps` are found beside the shares."""
        touches, p = asked.touches, asked.grid[0]
        position, (load, leaning) = _grid_of(box, p), _loads_of(touches, asked.grid[1])
        side = np.ones(p)
        side[[0, -1]] = 0.5
        weight = np.multiply.outer(np.multiply.outer(side, side), leaning)
        weight /= weight.sum()
        told = self.told(position[..., None, :], load, touches)
        std, unknowns = told.stds(load), told.covariance.shape[-1] - (0 if touches.friction > 0 else 2)
        most = {"position": np.ptp(box, axis=1).max() / 12**0.5, "angle": touches.cone / 3**0.5, "force": 1.0}
        values = summed_up(std, weight, most | {"radius": np.inf})
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

    def survey(
        self, touches: Touches, position: FloatArray, load: FloatArray, covariance: FloatArray, ambiguity: float
    ) -> FloatArray:
        """`SHARES` of touches at positions (t, 2) under loads (t, 3), whose bounds are known, shape (t, 3)."""
        from ._area_kernel import survey

        response, depth = self.response, float(self.response.depth.min())
        axes = []
        for low, high in self.box:
            count = max(int(np.ceil((high - low) / (_NODES * depth) - 1e-9)) + 1, 3)
            axes.append(np.linspace(low, high, count))
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        fields = np.ascontiguousarray(np.swapaxes(response(nodes), 1, 2))
        grams = fields @ np.swapaxes(fields, 1, 2)
        upper = np.triu_indices(3)
        with np.errstate(all="ignore"):
            inverse = np.linalg.inv(grams + 1e-13 * np.trace(grams, axis1=1, axis2=2)[:, None, None] * np.eye(3))
        forms = np.ascontiguousarray(np.stack([grams[:, *upper], inverse[:, *upper]]))
        sensors = np.ascontiguousarray(np.stack([*response.points.T, response.depth**-2.0, response.gain]))
        first = np.append(response.kind * self.cells, self.cells - 1).astype(np.int64)
        grid = np.array([v for axis in axes for v in (axis[0], axis[1] - axis[0], axis.size)])
        limits = np.array([2 * np.log(1 / FALSE_ALARM), ambiguity, 0.02 * depth, 0.1 * depth])
        readings = np.einsum("tnc,tc->tn", response(position), load)
        out = np.empty((len(readings), len(SHARES)))
        spread = np.stack([covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]], axis=-1)
        survey(
            readings, np.array(position), spread, sensors, first, self.cubics, self.terms, fields, forms, grid,
            touches.friction, np.array(self.box.reshape(-1)), limits, out,
        )  # fmt: skip
        return out


class Told(NamedTuple):
    """Bounds at touches of shape (...): covariance of (y, z, (a), N, Ty, Tz), infinite where one is open; rank."""

    covariance: FloatArray
    rank: npt.NDArray[np.intp]
    log_det: FloatArray

    @classmethod
    def of(cls, information: FloatArray, units: FloatArray, known: int) -> Told:
        """From Fisher's information (..., u, u); units (u,) are those beside which errors are small.

        The last `known` unknowns are known to be 0: the drag where there is no friction.
        """
        u = information.shape[-1] - known
        scale = units[:u]
        whole = information[..., :u, :u] * (scale[:, None] * scale)
        covariance = np.full(information.shape, 0.0)
        with np.errstate(all="ignore"):
            sizes = np.trace(whole, axis1=-2, axis2=-1)
            lifted = whole + 1e-15 * sizes[..., None, None] * np.eye(u)
            inverse = np.linalg.inv(lifted)
            blind = ~(np.trace(inverse, axis1=-2, axis2=-1) * sizes * _BLIND < 1.0) | ~(sizes > 0)
        rank = np.full(blind.shape, u)
        if blind.any():
            values = np.linalg.eigvalsh(whole[blind])
            rank[blind] = (values > _BLIND * values[:, -1:]).sum(axis=-1)
        covariance[..., :u, :u] = np.where(blind[..., None, None], np.inf, inverse * (scale[:, None] * scale))
        sign, log_det = np.linalg.slogdet(lifted)
        return cls(covariance, rank, np.where(sign > 0, log_det, -np.inf) - 4 * np.log(scale[0]))

    def stds(self, load: FloatArray) -> dict[str, FloatArray]:
        """Standard deviations by `AREA_STDS`, of touches under loads (..., 3).

        Of the position in the direction in which it is worst, of the angle of the load to that side to which it is
        worst [rad], of the force relative to it, of the half width [m] (0 where it is known).
        """
        c = self.covariance
        bad = ~np.isfinite(c[..., 0, 0])
        at, forces = np.where(bad[..., None, None], 0.0, c), np.broadcast_to(load, (*c.shape[:-2], 3))
        size = np.linalg.norm(forces, axis=-1)
        along = forces / size[..., None]
        turn = np.eye(3) - along[..., :, None] * along[..., None, :]
        f = at[..., -3:, -3:]
        across = turn @ f @ turn
        out = {
            "position": widest(at[..., :2, :2]),
            "angle": np.sqrt(np.maximum(np.linalg.eigvalsh(across)[..., -1], 0.0)) / size,
            "force": np.sqrt(np.maximum(np.einsum("...i,...ij,...j->...", along, f, along), 0.0)) / size,
            "radius": np.sqrt(np.maximum(at[..., 2, 2], 0.0)) if c.shape[-1] == 6 else np.zeros(bad.shape),
        }
        known = "radius" if c.shape[-1] == 5 else ""
        return {name: value if name == known else np.where(bad, np.inf, value) for name, value in out.items()}


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


def _loads_of(touches: Touches, azimuths: int) -> tuple[FloatArray, FloatArray]:
    """Loads straight down and to all sides (k, 3), and their weights (k,)."""
    leans = [(0.0, 0.0, 1.0)]
    if touches.cone > 0:
        turns = 2 * np.pi * (np.arange(azimuths) + 0.25) / azimuths  # none along an axis of the array
        leans = [(0.0, 0.0, _LEAN_WEIGHTS[0])]
        for lean, share in zip(_LEANS[1:], _LEAN_WEIGHTS[1:], strict=True):
            leans += [(lean * touches.cone, turn, share / azimuths) for turn in turns]
    angle, azimuth, share = np.array(leans).T
    return touches.leaning(angle, azimuth), share
