"""An array on an area as whitened tables, the bounds of Cramer and Rao for touches on it, and what it comes to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._frozen import Frozen
from ...array import SensorArray
from ...contact import RoundHertz
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...prepared import tabulated
from ...radial import RadialResponse, sampled, shared, tabulate_radial
from ...skin import Skin
from ...transducer import Transducer
from .._common import widest
from ..touches import Touches
from ._table import FALSE_ALARM, SHARES, checked_grid, checked_samples, jittered

AREA_GRID = (9, 6)
"""Positions along y, and along z, and azimuths at which bounds are found."""
_LEANS = np.array([0.0, 0.5, 1.0])
"""Angles at which they are, in shares of the largest, and the weights of the trapezoidal rule."""
_LEAN_WEIGHTS = np.array([0.25, 0.5, 0.25])
AREA_STDS = ("position", "angle", "force", "radius")
AREA_MEASURES = (*(f"{name}_{s}" for name in AREA_STDS for s in ("worst", "95", "mean")), *SHARES, "log_det", "rank")
"""Names of the numbers in which an array on an area is judged; `study_area` describes them."""
_BLIND = 1e-10
"""Share of the information of the best seen combination of unknowns below which another is not seen at all."""
WIDER = 0.02
"""Share by which the half width is changed for the slope of the readings in it."""
_NODES = 0.4
"""Distance of the positions at which loads are looked for, in least depths: as `AreaLocator` has it."""


class Channel(NamedTuple):
    """What one channel of an array measures.

    Parameters
    ----------
    transducer : Transducer
        One with a linear part.
    noise : float
        Standard deviation of a reading [unit of the transducer], > 0.
    width : float, optional
        Width along y over which it averages [m].
    """

    transducer: Transducer
    noise: float
    width: float = 0.0


class OneArea:
    """Tables of each kind of channel at one depth, from which those of every array there follow by shifting them.

    radius: the largest distance of a load from a sensor that will be asked for [m].
    """

    def __init__(self, skin: Skin, kinds: Sequence[Channel], depth: float, touches: Touches, radius: float) -> None:
        self.kinds, self.depth = tuple(kinds), depth
        zero, widths = np.zeros(len(kinds)), [kind.width for kind in kinds]
        transducers = [kind.transducer for kind in kinds]
        probe = Finger(skin, SensorArray(zero, depth, transducers, width=widths, z=zero))
        point = tabulate_radial(probe, radius)
        self.wider, self.tables = tables_of(probe, point, touches)
        middle = self.tables[len(self.tables) // 2]
        self._compiled = compiled_tables(middle)

    def field(self, points: FloatArray, which: npt.NDArray[np.intp]) -> AreaField:
        """Of channels at `points` (n, 2) [m], `which` (n,) of the kinds each is."""
        own = self.tables[0].kind
        noise = np.array([kind.noise for kind in self.kinds])[which]
        tables = tuple(
            replace(table, points=points, depth=np.full(len(which), self.depth), gain=1 / noise, kind=own[which])
            for table in self.tables
        )
        return AreaField(tables, self.wider, *self._compiled)


def tables_of(finger: Finger, point: RadialResponse, touches: Touches) -> tuple[float, tuple[RadialResponse, ...]]:
    """A finger's tables for the touches from those for points: three of them about a half width, and how far apart."""
    if touches.half_width is None:
        return 0.0, (point,)
    wider = WIDER * touches.half_width
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


def compiled_tables(response: RadialResponse) -> tuple[FloatArray, npt.NDArray[np.int64], int]:
    """Tables of a response as compiled loops want them, what their functions stand for, and the cells of one."""
    table, _ = response.cubics()
    if response.pair is not None:
        table = np.stack([sign * table[:, :, function] for function, sign in response.pair], axis=2)
    terms = response.terms if response.pair is None else response.terms[:0]
    rows = np.ascontiguousarray(table.reshape(table.shape[0] * table.shape[1], -1))
    return rows, np.ascontiguousarray(terms).astype(np.int64), table.shape[1]


@dataclass(frozen=True, eq=False)
class AreaField(Frozen):
    """Readings in units of noise under unit forces, at the touches' half width or at three about it, `wider` apart.

    cubics, terms, cells: the tables as compiled loops want them.
    """

    tables: tuple[RadialResponse, ...]
    wider: float
    cubics: FloatArray
    terms: npt.NDArray[np.int64]
    cells: int

    @property
    def response(self) -> RadialResponse:
        """That of the touches."""
        return self.tables[len(self.tables) // 2]

    def columns(self, position: FloatArray) -> FloatArray:
        """How readings change with y, z, (the half width) and the components, (p, n, 2 or 3 or 1, 3).

        The first two, or three, are per unit force and metre: they are to be multiplied by the load.
        """
        moved = np.moveaxis(self.response.slopes(position), -1, -2)
        parts = [moved]
        if self.wider:
            parts.append(((self.tables[2](position) - self.tables[0](position)) / (2 * self.wider))[..., None, :])
        return np.concatenate([*parts, self.response(position)[..., None, :]], axis=-2)

    def information(self, position: FloatArray, load: FloatArray) -> FloatArray:
        """Fisher's of (y, z, (a), N, Ty, Tz) at positions (p, 2) under loads (d, 3), shape (p, d, u, u)."""
        columns = self.columns(position)
        p, n, m, _ = columns.shape
        flat = columns.reshape(p, n, 3 * m)
        grams = (np.swapaxes(flat, 1, 2) @ flat).reshape(p, m, 3, m, 3)
        select = np.zeros((len(load), m + 2, m, 3))
        for k in range(m - 1):
            select[:, k, k] = load
        select[:, m - 1 :, m - 1] = np.eye(3)
        shape = len(load), m + 2, 3 * m
        flat_select, flat_grams = select.reshape(shape), grams.reshape(p, 3 * m, 3 * m)
        return np.asarray(flat_select @ flat_grams[:, None] @ np.swapaxes(flat_select, 1, 2))

    def survey(
        self, touches: Touches, position: FloatArray, load: FloatArray, spread: FloatArray, box: FloatArray,
        ambiguity: float,
    ) -> FloatArray:  # fmt: skip
        """`SHARES` of touches at positions (t, 2) under loads (t, 3), shape (t, 3); spread (t, 3): as of the kernel."""
        from ._area_kernel import survey

        response, depth = self.response, float(self.response.depth.min())
        axes = []
        for low, high in box:
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
        survey(
            readings, np.array(position), spread, sensors, first, self.cubics, self.terms, fields, forms, grid,
            touches.friction, np.array(box.reshape(-1)), limits, out,
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


class AskedTouches(NamedTuple):
    """Touches of a study: a closed grid of positions (p, 2) and loads (d, 3), their weights; and so many at random."""

    position: FloatArray
    load: FloatArray
    weight: FloatArray
    random_position: FloatArray
    random_load: FloatArray

    @classmethod
    def of(cls, touches: Touches, grid: tuple[int, int], samples: int, rng: np.random.Generator) -> AskedTouches:
        """Touches over the area and the cone of `touches`."""
        grid, amount = checked_grid(grid), checked_samples(samples)
        box = np.asarray(touches.area)
        side = np.ones(grid[0])
        side[[0, -1]] = 0.5
        y, z = (np.linspace(low, high, grid[0]) for low, high in box)
        position = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1).reshape(-1, 2)
        leans = [(0.0, 0.0, 1.0)]
        if touches.cone > 0:
            turns = 2 * np.pi * (np.arange(grid[1]) + 0.25) / grid[1]  # none along an axis of the array
            leans = [(0.0, 0.0, _LEAN_WEIGHTS[0])]
            for lean, share in zip(_LEANS[1:], _LEAN_WEIGHTS[1:], strict=True):
                leans += [(lean * touches.cone, turn, share / grid[1]) for turn in turns]
        angle, azimuth, share = np.array(leans).T
        weight = np.multiply.outer(np.multiply.outer(side, side).reshape(-1), share)
        along, across = jittered(amount, rng)
        count = across.size
        at = np.stack([np.repeat(along, across.shape[1]), rng.random(count)], axis=-1)
        more = _loads(touches, across.reshape(-1) * touches.cone, rng.uniform(-np.pi, np.pi, count))
        random_position = box[:, 0] + at * np.ptp(box, axis=1)
        return cls(position, _loads(touches, angle, azimuth), weight / weight.sum(), random_position, more)


def _loads(touches: Touches, angle: FloatArray, azimuth: FloatArray) -> FloatArray:
    side = np.sin(angle)
    return touches.force * np.stack([np.cos(angle), side * np.cos(azimuth), side * np.sin(azimuth)], axis=-1)


def units_of(touches: Touches, depth: float) -> FloatArray:
    """A depth for each length and the force for each component: beside these the unknowns are scaled."""
    lengths = [depth] * (2 + (touches.half_width is not None))
    return np.array([*lengths, *[touches.force] * 3])


def judged_area(
    field: AreaField, touches: Touches, asked: AskedTouches, box: FloatArray, ambiguity: float
) -> tuple[Told, dict[str, float]]:
    """Bounds on the grid of `asked`, and `AREA_MEASURES`."""
    depth = float(field.response.depth.min())
    units, known = units_of(touches, depth), 0 if touches.friction > 0 else 2
    told = Told.of(field.information(asked.position, asked.load), units, known)
    stds = told.stds(asked.load)
    area = np.ptp(np.asarray(touches.area), axis=1)
    most = {"position": area.max() / 12**0.5, "angle": touches.cone / 3**0.5, "force": 1.0, "radius": np.inf}
    out: dict[str, float] = {}
    for name in AREA_STDS:
        std, ceiling = stds[name], most[name]
        out[f"{name}_worst"] = float(std.max())
        out[f"{name}_95"] = quantile(std, asked.weight, 0.95)
        out[f"{name}_mean"] = float((np.minimum(std, ceiling) * asked.weight).sum())
    out["rank"] = float(told.rank.max())
    out["log_det"] = float((told.log_det * asked.weight).sum())
    if out["rank"] < units.size - known:
        shares = np.array([1.0, np.nan, np.nan])
    else:
        shares = _shares(field, touches, asked, units, known, box, ambiguity)
    out |= dict(zip(SHARES, shares.tolist(), strict=True))
    return told, {name: out[name] for name in AREA_MEASURES}


def _shares(
    field: AreaField,
    touches: Touches,
    asked: AskedTouches,
    units: FloatArray,
    known: int,
    box: FloatArray,
    ambiguity: float,
) -> FloatArray:
    """Means of `SHARES` over the touches drawn at random."""
    position, load = asked.random_position, asked.random_load
    m = field.columns(position)
    by = np.einsum("tnmc,tc->tnm", m[..., :-1, :], load)
    jacobian = np.concatenate([by, m[..., -1, :]], axis=-1)
    c = Told.of(np.swapaxes(jacobian, 1, 2) @ jacobian, units, known).covariance
    spread = np.stack([c[:, 0, 0], c[:, 0, 1], c[:, 1, 1]], axis=-1)
    return np.asarray(field.survey(touches, position, load, spread, box, ambiguity).mean(axis=0))


def quantile(values: FloatArray, weight: FloatArray, share: float) -> float:
    """The least of `values` that so large a share of the weight does not exceed."""
    order = np.argsort(values, axis=None)
    passed = np.cumsum(weight.ravel()[order])
    return float(values.ravel()[order[min(np.searchsorted(passed, share * passed[-1]), order.size - 1)]])


def searched_area(points: FloatArray, depth: float, touches: Touches, margin: float) -> FloatArray:
    """Ends of y and of z where loads are looked for: `margin` depths beyond the sensors, and all that is touched."""
    box = np.asarray(touches.area)
    low = np.minimum(points.min(axis=0) - margin * depth, box[:, 0])
    return np.stack([low, np.maximum(points.max(axis=0) + margin * depth, box[:, 1])], axis=-1)


def check_area(skin: Skin, touches: Touches) -> None:
    """Refuses touches that are not on an area, and a skin that takes none there."""
    _check.noun("skin", skin, Skin, "HalfSpace(Material(young=0.4e6))")
    _check.noun("touches", touches, Touches, "design.Touches(force=20.0)")
    if touches.area is None:
        raise GeometryError(
            "touches without an area", "local touches are needed", "area=((-5e-3, 5e-3), (-5e-3, 5e-3))"
        )
    if not skin.takes_local:
        rule = "it is solved in a plane and takes no touch on an area"
        raise InvalidValueError(f"the skin {skin}", rule, "HalfSpace(material), or Layered")
