"""The whitened receptive field of a row as a table, the survey of touches on it, and what it comes to in numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._frozen import Frozen
from ...array import SensorArray
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...prepared import tabulated
from ...response import Response, tabulate
from ...skin import Skin
from ...transducer import Transducer
from ..touches import Touches

AMBIGUITY = 13.8
FALSE_ALARM = 1e-6
MARGIN = 1.5
"""As `finger.locate` has them if nothing else is stated."""
_FARTHEST = 100.0
"""Depths beyond the sensors from which nothing is felt."""

MAPS = ("position", "force", "angle", "log_det", "ambiguous", "wrong", "unfelt")
"""Rows of a survey, in the order of the compiled code."""

_MOST_SAMPLES, _MOST_SENSORS = 10**7, 10**4
GRID = (101, 41)
"""Positions and angles of the grid on which bounds are found."""

SHARES = ("ambiguous", "wrong", "unfelt")
_STDS = ("position", "angle", "force")
PLACEMENT_MEASURES = (*(f"{name}_{s}" for name in _STDS for s in ("worst", "95", "mean")), *SHARES, "log_det")
"""Names of the numbers in which a placement is judged; `study_row` describes them."""

_PEAKS = 6
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
        """That of a finger, its dead sensors left out."""
        live = finger.array.live
        array = finger.array.select(live)
        noise = np.asarray(array.noise)
        if not (noise > 0).all():
            raise InvalidValueError("noise = 0", "the answer depends on the noise of the sensors", "noise=1e-4")
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
        climb = _compiled()[0].climb
        ends = np.array([positions[[0, -1]], angles[[0, -1]]])
        size = np.ptp(ends, axis=1) / np.maximum([positions.size - 1, angles.size - 1], 1)
        out: FloatArray = maps[:3].max(axis=(1, 2))
        for which in np.flatnonzero(np.isfinite(out)):
            for p, k in _highest(maps[which]):
                top = climb(
                    self.values, self.start, self.step, touches.friction, touches.force, which,
                    np.array([positions[p], angles[k]]), size, ends,
                )  # fmt: skip
                out[which] = max(out[which], top)
        return out


def _highest(heights: FloatArray) -> npt.NDArray[np.intp]:
    """Indices of the highest few points that no neighbour exceeds, shape (m, 2)."""
    from scipy.ndimage import maximum_filter

    at = np.argwhere(heights >= maximum_filter(heights, size=3))
    return at[np.argsort(-heights[tuple(at.T)], kind="stable")[:_PEAKS]]


class OneSensor:
    """The receptive field of one sensor, from which that of every row at its depth follows by shifting it.

    On a skin with ridges each row is tabulated by itself. `reach` is the largest distance of a load from a sensor that
    will be asked for [m].
    """

    def __init__(
        self, skin: Skin, transducer: Transducer, depth: float, noise: float, width: float, reach: float
    ) -> None:
        self._row: Callable[[FloatArray], Finger] | None = None
        self._depth = depth
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

    def row(self, positions: FloatArray, search: tuple[float, float]) -> RowField:
        """The table of sensors at `positions` [m]."""
        if self._row is not None:
            return RowField.of(self._row(positions), search)
        cells = max(int(np.ceil((search[1] - search[0]) * _CELLS / self._depth - 1e-9)), 1)
        step = (search[1] - search[0]) / cells
        values = np.empty((cells, 5, 2, positions.size))
        _compiled()[0].row_table(self._values, self._start, self._step, np.array(positions), search[0], step, values)
        return RowField(values, search[0], step, self._depth)


def _of_one(skin: Skin, transducer: Transducer, depth: float, positions: FloatArray) -> FloatArray:
    """The field of a sensor at y = 0 under loads at positions (cells, m), those of each cell alike: (cells, m, 1, 2).

    It is that of as many sensors under m loads: what a skin sums over waves is then a product of matrices.
    """
    finger = Finger(skin, SensorArray(-positions[:, 0], depth, transducer))
    field = finger.receptive_field(positions[0] - positions[0, 0], "line")
    return np.swapaxes(field, 0, 1)[:, :, None]


def searched(
    positions: FloatArray, depth: float, skin: Skin, span: tuple[float, float] | None, margin: float
) -> tuple[float, float]:
    """Where loads are looked for [m]: `margin` depths beyond the sensors at `positions`, and all that is touched."""
    low, high = float(positions.min()) - margin * depth, float(positions.max()) + margin * depth
    if span is not None:
        low, high = min(low, span[0]), max(high, span[1])
    middle, half = 0.5 * (low + high), min(0.5 * (high - low), 0.5 * skin.period)
    return middle - half, middle + half


def jittered(count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """At least `count` touches, one at random in each of equal cells of the unit square: positions (p,), angles (p, k).

    The angles of a position share it. There are more positions than angles, for what is ambiguous is so along narrow
    strips that run with the angle.
    """
    across = max(round(np.sqrt(count / 10)), 1)
    along = -(-count // across)
    positions = (np.arange(along) + rng.random(along)) / along
    return positions, (np.arange(across) + rng.random((along, across))) / across


def judged(
    field: RowField, touches: Touches, span: tuple[float, float], grid: tuple[int, int], ambiguity: float
) -> tuple[FloatArray, FloatArray, FloatArray, dict[str, float]]:
    """Positions (p,) and angles (k,) from end to end, `MAPS` of these touches, and their `PLACEMENT_MEASURES`."""
    shape = checked_grid(grid)
    positions = np.linspace(*span, shape[0])
    angles = np.linspace(-touches.cone, touches.cone, shape[1]) if touches.cone > 0 else np.zeros(1)
    weight = _trapezoid(positions.size)[:, None] * _trapezoid(angles.size)
    maps = field.survey(touches, positions, angles, ambiguity)
    worst = field.worst(touches, positions, angles, maps)
    # a touch that is known less well than by its being one of `touches` counts as one known so well
    most = {"position": (span[1] - span[0]) / 12**0.5, "angle": touches.cone / 3**0.5, "force": 1.0}
    out = {}
    for name in _STDS:
        std = maps[MAPS.index(name)]
        out[f"{name}_worst"] = float(worst[MAPS.index(name)])
        out[f"{name}_95"] = _quantile_95(std, weight)
        out[f"{name}_mean"] = float((np.minimum(std, most[name]) * weight).sum())
    out |= {name: float((maps[MAPS.index(name)] * weight).sum()) for name in (*SHARES, "log_det")}
    return positions, angles, maps, out


def _trapezoid(count: int) -> FloatArray:
    """Weights of the trapezoidal rule, of sum 1."""
    weight = np.ones(count)
    if count > 1:
        weight[[0, -1]] = 0.5
    return weight / float(weight.sum())


def _quantile_95(values: FloatArray, weight: FloatArray) -> float:
    order = np.argsort(values, axis=None)
    passed = np.cumsum(weight.ravel()[order])
    return float(values.ravel()[order[np.searchsorted(passed, 0.95 * passed[-1])]])


def checked_grid(grid: tuple[int, int]) -> tuple[int, int]:
    """Two whole numbers, >= 2 positions and >= 1 angle."""
    values = _check.real("grid", grid)
    if values.shape != (2,) or not (values == np.round(values)).all() or values[0] < 2 or values[1] < 1:
        raise InvalidValueError(f"grid = {grid!r}", "numbers of positions and of angles are needed", f"grid={GRID}")
    return int(values[0]), int(values[1])


def checked_samples(samples: int) -> int:
    """A number of touches that are drawn at random."""
    return _check.whole("samples", samples, at_least=1, at_most=_MOST_SAMPLES, fix="samples=2000")


def checked_margin(margin: npt.ArrayLike) -> float:
    """How far beyond the sensors loads are looked for, in depths."""
    fix = f"margin={MARGIN}: farther out a load is hardly felt"
    return _check.scalar("margin", margin, at_least=0.0, at_most=_FARTHEST, fix=fix)


def checked_counts(counts: npt.ArrayLike, touches: Touches) -> npt.NDArray[np.int_]:
    """Numbers of sensors: whole ones, and no fewer than a touch has unknowns."""
    _check.noun("touches", touches, Touches, "design.Touches(force=20.0)")
    numbers = np.atleast_1d(_check.real("counts", counts))
    if (
        numbers.ndim != 1
        or not numbers.size
        or not (numbers == np.round(numbers)).all()
        or numbers.max() > _MOST_SENSORS
    ):
        rule = f"a list of whole numbers up to {_MOST_SENSORS} is needed"
        raise InvalidValueError(f"counts = {_check.shown(counts)}", rule, "counts=[4, 6, 8]")
    needed = 2 if touches.friction == 0 else 3
    if numbers.min() < needed:
        raise InvalidValueError(
            f"{int(numbers.min())} sensors",
            f"a touch has {needed} unknowns, and takes as many sensors that respond",
            "more sensors",
        )
    return numbers.astype(np.int_)


def check_span(skin: Skin, touches: Touches) -> None:
    """Refuses touches that go round the skin and on."""
    _check.noun("skin", skin, Skin, "HalfPlane(Material(young=0.4e6))")
    if touches.span is not None and touches.span[1] - touches.span[0] > skin.period * (1 + 1e-12):
        raise GeometryError(f"span = {touches.span} m", f"the finger is {skin.period:.6g} m about", "a shorter span")
