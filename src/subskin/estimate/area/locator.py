"""The estimators of local contacts: prepared once for a response on an area, then called on frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...array import SensorArray
from ...errors import GeometryError, InvalidValueError
from ...prepared import Prepared
from ...radial import RadialResponse
from ...radial_round import RoundResponse
from ..estimate import Estimate
from ..frames import Framewise, sensor_rows
from ..layout import AREA, ROUND, SIZED, TWIST, Layout
from ..settle.uncertain import Uncertain, fill_settled, in_doubt
from ..varpro import Limits
from .far import INNER, far_from, nodes_of
from .judge import Beyond, Settings, plain
from .observable import least_told_apart
from .point import PointModel, model_of, tabulated
from .round_contact import tables_of
from .round_project import RoundSearch
from .search import step_of
from .tiles import COUNT, NEAR, NODES, STRIDE, Seen, Tiles, boxes_beyond, nodes_beyond, nodes_of_sensors, tiles_of
from .uncertain import exactly, to_settle

__all__ = ["AreaLocator", "LocalLocator", "RoundLocator"]

_FINER = 5.0
_STRONG = 22.0
"""Noises from which the strongest reading is a sensor's that stands near the load (`tiles.py`)."""
_CURVED = 0.02
_ALIKE = 2e-3
"""Share of a load's squared readings below which another one, close by, may be taken for it."""
_MOST_FINE = 4_000_000
_RING_LEAVES, _BEYOND_LEAVES, _LEAVES = 6e-4, 2e-4, 0.03
"""What directions of a region leave of a unit reading, squared, a sensor: in the search and beyond; and the most."""
_SCANNED = 5
"""Half widths at which the scan looks."""
_WITHOUT = [
    *range(ROUND.unknowns), *TWIST.square[:-1, :-1][np.triu_indices(ROUND.unknowns)],
    *range(TWIST.interval, TWIST.rival + ROUND.unknowns), TWIST.rival_chi2, TWIST.status,
]  # fmt: skip
"""The columns of a row that says nothing of a moment."""


class LocalLocator(Framewise):
    """What the estimators of a contact on an area have in common: options, how one calls them, where they look.

    Parameters
    ----------
    response, array, search, friction, false_alarm, ambiguity, outliers
        As of `AreaLocator` and `InPlaceLocator`.
    known : int
        Unknowns that are known after all.
    """

    layout: Layout = AREA
    wide = False
    """Whether the contact has a half width that is not known."""

    def __init__(
        self, response: Any, array: SensorArray, search: Any, *, friction: float, false_alarm: float,
        ambiguity: float, outliers: int, known: int = 0,
    ) -> None:  # fmt: skip
        if response.sensors != len(array):
            seen = f"a response of {response.sensors} sensors, an array of {len(array)}"
            raise GeometryError(seen, "they have to match", "array.select(...)")
        self.response, self.search = response, search
        self.friction = _check.friction(friction)
        self.unknowns = 3 + 2 * (self.friction > 0) + self.wide + self.layout.twist - known
        self._ambiguity = _check.scalar("ambiguity", ambiguity, at_least=0.0)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        super().__init__(
            array, needed=self.unknowns, columns=self.layout.columns, status=self.layout.status, layout=self.layout,
            outliers=outliers, ambiguity=self._ambiguity,
        )  # fmt: skip

    def __call__(self, readings: npt.ArrayLike, doubt: npt.ArrayLike | None = None) -> Estimate:
        """The contact in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            Raw readings, offset included, in units of each gain. NaN marks a missing one; it, and a saturated one, are
            left out of its frame.
        doubt : array_like, shape (..., n), optional
            Of point loads: standard deviation of each reading beside the sensor's noise [reading]. A frame weighs its
            sensors by both.

        Returns
        -------
        Estimate
            Fields of shape (...); positions end in 2, components in 3, covariances in (5, 5).

        Raises
        ------
        GeometryError, InvalidValueError
            A last axis that is not the number of sensors; doubts of another shape, below 0, or of another contact.
        """
        table, used = self._frames(readings, doubt)
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

    @property
    def _detection(self) -> float:
        """The least chi-square explained by a contact."""
        return float(2 * np.log(1 / self._false_alarm))

    def _left(self, sensors: int, chance: float) -> float:
        """The chi-square that noise leaves of so many sensors' readings with a chance."""
        from scipy.special import chdtri

        return float(chdtri(max(sensors - self.unknowns, 1), chance))


class AreaLocator(LocalLocator):
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
    uncertain : Uncertain, optional
        What is not known of the finger, and of a touch's size.
    friction, scan_step, false_alarm, ambiguity, outliers
        As of `Locator`; the default step is 0.4 of the least depth.

    Raises
    ------
    InvalidValueError, GeometryError
        A sensor without noise, a response whose sensors do not match the array's, an option out of range.
    """

    def __init__(
        self,
        response: RadialResponse | RoundResponse,
        array: SensorArray,
        search: tuple[tuple[float, float], tuple[float, float]],
        *,
        beyond: float = 0.0,
        uncertain: Uncertain | None = None,
        friction: float = 1.0,
        scan_step: float | None = None,
        false_alarm: float = 1e-6,
        ambiguity: float = 13.8,
        outliers: int = 0,
    ) -> None:
        self._uncertain = uncertain
        if uncertain is not None:
            self.layout = SIZED
        super().__init__(
            response, array, search, friction=friction, false_alarm=false_alarm, ambiguity=ambiguity, outliers=outliers
        )
        self._beyond = _check.scalar("beyond", beyond, unit="m", at_least=0.0)
        self._fields = Prepared()
        self._depth = float(np.asarray(array.depth).min())
        self._step = step_of(array, search, scan_step)

    def _kernel(self) -> Any:
        from .project import project_frames

        return project_frames

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        """Arguments of the compiled loop between the frames and the output, for the sensors of `pattern`."""
        array, response = self.array.select(pattern), self.response.select(pattern)
        model, error = tabulated(response, array)
        seen = self._seen(lambda: self.response, pattern)
        points, box, away = self.array.points, np.array(self.search), INNER * self._depth
        inner = np.stack([points.min(axis=0) - away, points.max(axis=0) + away], axis=-1)
        inner = np.stack([np.maximum(inner[:, 0], box[:, 0]), np.minimum(inner[:, 1], box[:, 1])], axis=-1)
        if (inner[:, 0] >= inner[:, 1]).any():  # a search beside the sensors
            inner = box
        tiles, beyond, sizes = self._looked_at(model, [seen], [seen], inner)
        leaves, rest = (min(per * seen.sensors, _LEAVES) for per in (_RING_LEAVES, _BEYOND_LEAVES))
        ring, held = far_from(seen, inner, box, leaves)
        far = ring  # of a search that ends
        if self._beyond > 0:
            far, held = far_from(seen, box, box + self._beyond * np.array([-1.0, 1.0]), rest, 1.0)
        begin, members = nodes_of(held, beyond.nodes[:, :2])
        beyond, ring = beyond._replace(held=begin, members=members), ring._replace(once=1)
        settings = self._settings(array, response, error, least_told_apart(seen, _ALIKE))
        arrays = sensor_rows(array), *map(plain, (model, tiles, beyond, ring, far)), sizes, plain(settings)
        if self._uncertain is not None:
            arrays += (self._to_settle(self._uncertain, pattern, settings, beyond),)
        return arrays

    def _to_settle(self, uncertain: Uncertain, pattern: npt.NDArray[np.bool_], *given: Any) -> tuple[Any, ...]:
        """Arguments of the loop that settles, for the sensors of `pattern`; given: its `Settings` and `Beyond`."""
        return to_settle(uncertain, self.array.select(pattern), pattern, self._step, self._beyond, *given)

    def _fill(self, frames: FloatArray, arrays: tuple[Any, ...], out: FloatArray) -> None:
        if self._uncertain is None:
            self._compiled(frames, *arrays, out)
        else:
            fill_settled(self._compiled, frames, arrays, bool(self._uncertain.sizes), out)

    takes_doubt = True
    """Whether a call takes the doubts of readings, as a `Pipeline` asks."""

    def _doubted(
        self, frames: FloatArray, doubt: FloatArray, arrays: tuple[Any, ...], pattern: npt.NDArray[np.bool_],
        out: FloatArray,
    ) -> None:  # fmt: skip
        if self.layout.wide:  # a round contact
            super()._doubted(frames, doubt, arrays, pattern, out)
        if self._uncertain is not None:
            fill_settled(self._compiled, frames, arrays, bool(self._uncertain.sizes), out, doubt)
            return

        def made() -> tuple[Any, ...]:
            return self._to_settle(exactly(self.response), pattern, Settings(*arrays[-1]), Beyond(*arrays[3]))

        index = np.flatnonzero(in_doubt(doubt, np.asarray(self.array.noise)[pattern]))
        self._compiled(frames, *arrays, out)
        whole = np.empty((index.size, SIZED.columns))
        settling = self._prepared.get(b"doubt" + pattern.tobytes(), made)
        fill_settled(self._compiled, frames[index], (*arrays, settling), False, whole, doubt[index])
        out[index] = whole[:, : AREA.columns]

    def _settings(self, array: SensorArray, response: RadialResponse, error: float, told: float = np.inf) -> Settings:
        """The numbers that the compiled loop goes by; `error` is that of its table."""
        box, depth = np.array(self.search), self._depth
        strongest = np.abs(response(np.array([[p.mean() for p in box]])) / np.asarray(array.noise)[:, None]).max()
        return Settings(
            limits=Limits(self.friction), detection=self._detection,
            largest=self._left(len(array), self._false_alarm), ambiguity=self._ambiguity, apart=0.02 * depth,
            broad=0.1 * depth, strong=_STRONG, curved=_CURVED * depth, smallest=1e-9 * depth, box=box.reshape(-1),
            error=float(len(array) * (error * strongest) ** 2), told=told,
        )  # fmt: skip

    def _seen(self, whole: Callable[[], RadialResponse], pattern: npt.NDArray[np.bool_], name: int = 0) -> Seen:
        """What the sensors of `pattern` read, by the response of all.

        Where a sensor is missing, it is a part of what all of them read, which is kept by `name` and nodes: a stream
        waits for half as long.
        """
        array, read = self.array.select(pattern), None
        if pattern is self._all:
            read = whole().select(pattern)

        def some(nodes: FloatArray) -> FloatArray:
            every = self._fields.get((name, nodes.shape, nodes.tobytes()), lambda: whole()(nodes))
            return np.compress(pattern, every, axis=-2)

        return Seen(read or some, array, self._depth, self.friction)

    def _looked_at(
        self, model: PointModel, seen: Sequence[Seen], far: Sequence[Seen], inner: FloatArray | None = None
    ) -> tuple[Tiles, Beyond, npt.NDArray[np.int64]]:
        """Where the scans look, in the search and beyond it, and the most nodes and the longest row of a tile.

        `seen` are scanned, and `far` of them beyond the search; `inner` is the part that is looked at first.
        """
        box, boxes = np.array(self.search), boxes_beyond(np.array(self.search), self._beyond)
        finest = float(np.sqrt(3 * seen[0].sensors * np.ptp(box, axis=1).prod() / _MOST_FINE))
        tiles = tiles_of(seen, box, self._step, max(self._step / _FINER, finest), inner)
        outer, nodes = nodes_beyond(far, boxes)
        widest = max(int(t.table[:, NODES].max()) for t in (tiles, outer))
        sizes = np.array([widest, int(tiles.table[:, STRIDE].max()) + 2])
        # the sensors near each tile, and one that reads nothing
        every, kinds = np.column_stack([model.sensors, np.zeros(4)]), np.append(model.first[:-1], 0)
        parts = [tiles.near[i : i + k] for i, k in tiles.table[:, [NEAR, COUNT]]]
        tiles = tiles._replace(
            sensors=np.concatenate([every[:, near].reshape(-1) for near in parts]),
            first=np.concatenate([np.append(kinds[near], model.first[-1]) for near in parts]),
        )
        held, members = nodes_of_sensors(far, nodes[: len(nodes) // len(far)])
        return tiles, Beyond(outer, nodes, boxes, held, members), sizes


class RoundLocator(AreaLocator):
    """Finds the round contact of a family in frames of readings: position, forces and half width.

    The search is global in all three coordinates; readings know the square of the half width, so that its interval
    begins at 0 where they cannot tell the contact from a point (docs/fitting_area.md).

    Parameters
    ----------
    response : RoundResponse
        Readings under unit forces; it has to reach as that of an `AreaLocator`.
    array, search
        As of `AreaLocator`.
    half_width : (float, float)
        Least and largest half width [m]; twice the same where it is known.
    moment : RoundResponse, optional
        Readings under a unit moment about the normal, in place of N: then a moment is fitted as well.
    options
        `beyond`, `friction`, `scan_step`, `false_alarm`, `ambiguity`, `outliers`, as of `AreaLocator`.

    Raises
    ------
    InvalidValueError, GeometryError
        As of `AreaLocator`; half widths that the response does not reach.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid((2, 4), pitch=2e-3, depth=2e-3, noise=1e-4)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> locator = finger.locator("round_punch", search=((-3e-3, 3e-3), (-4e-3, 4e-3)))
    >>> locator.half_width, locator.unknowns
    ((0.0, 0.003), 6)
    """

    layout: Layout = ROUND
    response: RoundResponse

    takes_doubt = False

    def __init__(
        self,
        response: RoundResponse,
        array: SensorArray,
        search: tuple[tuple[float, float], tuple[float, float]],
        half_width: tuple[float, float],
        *,
        moment: RoundResponse | None = None,
        **options: Any,
    ) -> None:
        low, high = (_check.scalar("half_width", value, unit="m", at_least=0.0) for value in half_width)
        if not low <= high <= response.widest * (1 + 1e-12):
            rule = f"ascending half widths up to {response.widest:.6g} m are needed"
            raise InvalidValueError(f"half_width = {half_width!r}", rule, "half_width=(0.0, 2e-3)")
        self.moment = moment
        if moment is not None:
            self.layout = TWIST
        self.half_width, self.wide = (low, min(high, response.widest)), high > low
        super().__init__(response, array, search, **options)

    def _kernel(self) -> Any:
        from .round_project import project_round

        return project_round

    def _fill(self, frames: FloatArray, arrays: tuple[Any, ...], out: FloatArray) -> None:
        whole = out if self.layout.twist else np.empty((len(out), TWIST.columns))
        self._compiled(frames, *arrays, whole)
        if whole is not out:
            out[:] = whole[:, _WITHOUT]

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        array = self.array.select(pattern)
        response = self.response.select(pattern)
        contact, error, terms, cells = tables_of(response, array)
        low, high = np.square(self.half_width)
        widths = np.linspace(low, high, _SCANNED) if self.wide else np.array([low])
        shares = np.polynomial.chebyshev.chebvander(2 * widths / contact.most - 1, contact.sums.shape[-1] - 1)
        tables = np.ascontiguousarray(np.einsum("rnj,wj->wrn", contact.sums, shares))
        narrowest = response.separate().at(float(np.sqrt(low)))
        points = model_of(narrowest, np.asarray(array.noise), cells, tables[0], terms)
        every = [self._seen(partial(self.response.at, float(np.sqrt(q))), pattern, i) for i, q in enumerate(widths)]
        ends = [0, -1] if self.wide else [0]
        tiles, beyond, sizes = self._looked_at(points, every, [every[i] for i in ends])
        if self.moment is not None:
            part = self.moment.select(pattern)
            turns, wrong = part.cubics()
            turns = np.ascontiguousarray(turns.reshape(turns.shape[0] * cells, -1, turns.shape[-1]))
            turned = np.ascontiguousarray(part.table.terms).astype(np.int64)
            contact, error = contact._replace(turns=turns, turned=turned), max(error, wrong)
        settings = self._settings(array, narrowest, error)
        search = RoundSearch(contact, points, tables, widths, widths[ends], np.array([low, high]), tiles, settings)
        return sensor_rows(array), plain(search), plain(beyond), sizes
