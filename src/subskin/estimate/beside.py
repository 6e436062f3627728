"""Point loads that sensors in a row feel: on the row, or beside it.

Where readings are N f(u) + (Ty dy + Tz dz) g(u), u = dy^2 + dz^2 and dz = -z of every sensor, a row sees |z| by how
widely a touch spreads over it, and no side. On a half space f = depth g: a drag across the row reads like a normal
force, and what is found is N - Tz z / depth (docs/locating_row.md).
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..array import SensorArray
from ..errors import InvalidValueError
from ..finger import Finger
from ..prepared import prepared
from ..radial import tabulate_radial
from ..response import Response
from ..skin import in_space
from .answer import Status
from .estimate import Estimate
from .frames import packed
from .layout import BESIDE, ON_ROW, SIZED_BESIDE, SIZED_ON_ROW
from .search import OTHERS, Locator
from .settle.uncertain import Uncertain, fill_settled

__all__ = [
    "LEFT_OPEN",
    "OnRowLocator",
    "PointLocator",
    "farthest_beside",
    "finger_in_space",
    "points_beside",
    "points_on",
]

_BESIDE = 3.0
"""Depths beside the row up to which a touch is thought of where no distance is stated."""
_MOST = 6.0
_TERMS = 1e-7
"""What the last of a table's sums over the distance may be, relative to the largest reading."""
_FEW, _MANY = 16, 48
_STEEPEST, _STEEP = 0.95, 1e3
_PACE = 0.1
"""Depths from one distance beside the row to the next along which the crest of chi-square is looked at."""
_OPEN = 0.1
"""Depths: a position whose standard error is larger is left open by the readings."""


def farthest_beside(finger: Finger, beside: float | None) -> float:
    """The largest distance beside the row [m]: `beside`, or three depths of the shallowest sensor.

    Raises
    ------
    InvalidValueError
        More than six depths: nothing is felt from there.
    """
    depth = float(np.min(finger.array.depth))
    if beside is None:
        return _BESIDE * depth
    if beside > _MOST * depth * (1 + 1e-12):
        rule = f"up to {_MOST:g} depths of the shallowest sensor, {_MOST * depth:.6g} m, can be thought of"
        raise InvalidValueError(f"beside = {beside:.6g} m", rule, f"beside={_MOST * depth:.3g}")
    return beside


def finger_in_space(finger: Finger) -> Finger:
    """The finger with its skin as touches on a point feel it.

    Raises
    ------
    GeometryError, InvalidValueError
        Sensors on an area; a skin that nobody knows in space.
    """
    finger.array.refuse_area()
    skin = in_space(finger.skin)
    if skin is None:
        rule = "a touch on a point needs a skin that is known in space"
        raise InvalidValueError(f"{finger.skin}", rule, 'HalfSpace(material), Layered(layers), or load="line"')
    return replace(finger, skin=skin)


def points_on(finger: Finger, search: tuple[float, float]) -> Response:
    """Readings of a row under point loads of unit N and Ty on it, as a table over y; errors as of `points_beside`.

    Tables are kept.
    """
    tip = finger_in_space(finger)

    def each(y: FloatArray) -> FloatArray:
        return tip.receptive_field(np.stack([y, np.zeros_like(y)], axis=-1), "point")[..., :2]

    def make() -> Response:
        return Response.from_function(each, *search, step=float(np.min(tip.array.depth)) / 16)

    return prepared(finger).get(("on the row", search), make)


def points_beside(finger: Finger, search: tuple[float, float], beside: float) -> Response:
    """Readings of a row under point loads of unit N and Ty at (y, z), as a table over y and z^2; even in z.

    Raises
    ------
    GeometryError, InvalidValueError
        Sensors on an area; a skin that nobody knows in space.
    """
    finger = finger_in_space(finger)
    low, high = search
    away = max(high - float(np.min(finger.array.y)), float(np.max(finger.array.y)) - low)
    radial = tabulate_radial(finger, float(np.hypot(away, beside)))
    for terms in (_FEW, 24, 32, _MANY):
        shares = 0.5 * (1 + np.cos(np.pi * (np.arange(terms) + 0.5) / terms))
        z = beside * np.sqrt(shares)

        def each(y: FloatArray, z: FloatArray = z) -> FloatArray:
            """Readings at every distance, those of one distance after those of the other: (..., terms n, 2)."""
            at = np.stack(np.broadcast_arrays(y[..., None], z), axis=-1)
            return radial(at)[..., :2].reshape(*y.shape, -1, 2)

        table = Response.from_function(each, low, high, step=float(np.min(finger.array.depth)) / 4, tolerance=1e-6)
        cells, powers, _, _ = table.coefficients.shape
        values = np.moveaxis(table.coefficients.reshape(cells, powers, terms, -1, 2), 2, 0)
        matrix = np.polynomial.chebyshev.chebvander(2 * shares - 1, terms - 1)
        sums = np.linalg.solve(matrix, values.reshape(terms, -1)).reshape(values.shape)
        made = replace(table, coefficients=np.ascontiguousarray(sums), widest=beside)
        if made.blur <= max(_TERMS, table.error) or terms == _MANY:
            return made
    raise AssertionError


LEFT_OPEN = 0.5
"""Status, in a table, of a point that explains a frame while its position, or whether it is one, is left open.

By itself it is AMBIGUOUS. Beside other contacts its probability and its standard error say the same.
"""


class PointLocator(Locator):
    """Finds point loads on a row or beside it: position along the row, |z|, and (N, Ty) of `Locator` in N.

    A drag across the row, which the readings do not tell from a normal force, is carried as uncertainty of N: every
    |Tz| <= friction N is as likely.

    Parameters
    ----------
    response : Response
        Of `points_beside`.
    array : SensorArray
        As in `Locator`.
    friction : float
        As in `Locator`. The search takes loads that lean more, by what a drag across takes off the normal force.
    **options
        As in `Locator`.

    Raises
    ------
    InvalidValueError, GeometryError
        As in `Locator`.
    """

    _without_spare = LEFT_OPEN

    def __init__(self, response: Response, array: SensorArray, *, friction: float = 1.0, **options: Any) -> None:
        self.depth = float(np.max(array.depth))
        self.open = _OPEN * float(np.min(array.depth))
        self._across = friction
        lost = friction * response.widest / float(np.min(array.depth)) if friction else 0.0
        steep = friction / (1 - lost) if lost < _STEEPEST else np.inf
        super().__init__(response, array, friction=steep, **options)
        self.layout = self._layout = BESIDE if self._uncertain is None else SIZED_BESIDE
        self._columns = self.layout.columns

    def _run(
        self, frames: FloatArray, pattern: npt.NDArray[np.bool_], out: FloatArray, doubt: FloatArray | None = None
    ) -> None:
        super()._run(frames, pattern, out, doubt)
        if doubt is None and self._uncertain is None:
            self._look_along(frames, pattern, 1, out)
        at = BESIDE
        out[:, at.square[1, 1]] += self.unseen(out)
        status = out[:, at.status]
        left_open = out[:, at.covariance] > self.open**2
        status[(status == Status.OK) & left_open] = LEFT_OPEN

    def _settle(
        self, frames: FloatArray, arrays: tuple[Any, ...], out: FloatArray, doubt: FloatArray | None = None
    ) -> None:
        from .settle.aside import SETTLED, from_settled, to_settled

        assert self._uncertain is not None
        away, rows = self.half_width[1], np.empty((len(out), SETTLED.itemsize // 8))

        def loop(*given: Any) -> None:
            part = BESIDE.named(np.empty((len(given[-1]), BESIDE.columns)))
            self._compiled(*given[:-1], part)
            to_settled(part, away, np.ndarray(len(part), SETTLED, given[-1]))

        fill_settled(loop, frames, arrays, bool(self._uncertain.sizes), rows, doubt)
        settled = np.ndarray(len(out), SETTLED, rows)
        from_settled(settled, away, BESIDE.named(out))
        out[:, SIZED_BESIDE.size] = settled["size"]

    def _to_settle(
        self, uncertain: Uncertain, array: SensorArray, pattern: npt.NDArray[np.bool_], thresholds: dict[str, float]
    ) -> tuple[Any, ...]:
        from .settle.aside import COLUMNS

        (low, high), most = self._search_ends, self.half_width[1]
        z = np.linspace(0.0, most, max(round(most / (2 * OTHERS * self._shallowest)), 1) + 1)
        every = np.meshgrid(np.arange(low, high, OTHERS * self._shallowest), z**2 / most, indexing="ij")
        box = np.array([low, high, 0.0, most])
        nodes = np.stack(every, axis=-1).reshape(-1, 2)
        return uncertain.to_settle(array, pattern, COLUMNS, nodes, box=box, beyond=box, **thresholds)

    def __call__(self, readings: npt.ArrayLike, doubt: npt.ArrayLike | None = None) -> Estimate:
        """As of `Locator`."""
        return self.alone(*self._frames(readings, doubt))

    def alone(self, table: FloatArray, used: npt.NDArray[np.bool_]) -> Estimate:
        """The answer of `_frames` where nothing but a point is thought of."""
        table = table.copy()
        status = table[..., BESIDE.status]
        status[status == LEFT_OPEN] = Status.AMBIGUOUS
        table.flags.writeable = False
        return Estimate(table, used, self.friction, self.unknowns, self.layout, self.relative)

    def _look_along(self, frames: FloatArray, pattern: npt.NDArray[np.bool_], stride: int, out: FloatArray) -> None:
        from .crest import look_along

        arrays = self._arrays if pattern is self._all else ()
        if not arrays:
            arrays = self._prepared.get(pattern.tobytes(), partial(self._prepare, pattern))
        nodes, pace = self._prepared.get(b"along" + pattern.tobytes(), partial(self._along, pattern))
        sensors, _, _, _, _, _, _, table, told, *_ = arrays
        look_along(frames, sensors, table, told, nodes, pace, stride, BESIDE.named(out))

    def _along(self, pattern: npt.NDArray[np.bool_]) -> tuple[FloatArray, float]:
        """Whitened tables at each distance beside the row along which the crest is looked at, and their pace [m]."""
        part, scale = self._searched.select(pattern), 1 / np.asarray(self.array.noise)[pattern]
        pace = part.widest / max(round(part.widest / (_PACE * self._shallowest)), 1)
        square = (np.arange(round(part.widest / pace) + 1) * pace / part.widest) ** 2
        sums = np.polynomial.chebyshev.chebvander(2 * square - 1, len(part.coefficients) - 1)
        every = np.tensordot(sums, part.coefficients, axes=1)
        return np.stack([packed(replace(part, coefficients=one, widest=0.0), scale) for one in every]), pace

    def count_beside(self, frames: FloatArray, pattern: npt.NDArray[np.bool_], table: FloatArray) -> None:
        """Widen the variance of positions on the row, rows (f, columns) of `ON_ROW`, by all distances beside it."""
        rows = np.zeros((len(table), BESIDE.columns))
        rows[:, 0], rows[:, BESIDE.residual] = table[:, 0], table[:, ON_ROW.residual]
        rows[:, BESIDE.covariance], rows[:, BESIDE.square[3, 3]] = table[:, ON_ROW.covariance], 1.0
        found = table[:, ON_ROW.status] <= Status.AMBIGUOUS
        rows[:, BESIDE.status] = np.where(found, Status.OK, Status.UNEXPLAINED)
        self._look_along(frames, pattern, 2, rows)
        table[found, ON_ROW.covariance] = rows[found, BESIDE.covariance]

    def unseen(self, table: FloatArray) -> FloatArray:
        """Variance of the normal force from the drag across the row, in rows (..., columns) of `BESIDE` [N^2]."""
        beside, upper = table[..., BESIDE.half_width], table[..., BESIDE.interval + 1]
        spread = np.fmax(upper, beside) / self.depth
        return np.asarray((min(self._across, _STEEP) * spread * table[..., BESIDE.components]) ** 2 / 3)


class OnRowLocator(Locator):
    """Finds point loads on a row: position and (N, Ty) of `Locator` in N, by the response of `points_on`.

    Parameters
    ----------
    response, array
        As in `Locator`.
    beside : PointLocator, optional
        With it the standard error of the position counts every distance beside the row that explains a frame as well.
    **options
        As in `Locator`.

    Raises
    ------
    InvalidValueError, GeometryError
        As in `Locator`.
    """

    def __init__(
        self, response: Response, array: SensorArray, *, beside: PointLocator | None = None, **options: Any
    ) -> None:
        super().__init__(response, array, **options)
        self.layout = self._layout = ON_ROW if self._uncertain is None else SIZED_ON_ROW
        self._beside = beside

    def _run(
        self, frames: FloatArray, pattern: npt.NDArray[np.bool_], out: FloatArray, doubt: FloatArray | None = None
    ) -> None:
        super()._run(frames, pattern, out, doubt)
        if doubt is None and self._uncertain is None and self._beside is not None:
            self._beside.count_beside(frames, pattern, out)
