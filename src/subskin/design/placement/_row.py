"""The whitened receptive field of a row as a table, the survey of touches on it, and what it comes to in numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen
from ...array import SensorArray
from ...errors import InvalidValueError
from ...finger import Finger
from ...prepared import tabulated
from ...response import Response, tabulate
from ...skin import Skin
from ...transducer import Transducer
from ..touches import Touches
from .asked import FALSE_ALARM, SHARES, Asked, Judged, summed_up, trapezoid
from .layout import Channel

MAPS = ("position", "force", "angle", "log_det", *SHARES)
"""Rows of a survey, in the order of the compiled code."""

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
        """That of a finger, its dead sensors left out; loads are looked for over `search` [m]."""
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

    def judged(self, asked: Asked, box: FloatArray, *, maps: bool) -> Judged:
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
