"""Readings -> how probable each kind of contact makes them: the evidence that `decide.contact_type` weighs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...contact.families import family_of
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...response import Response, tabulate
from ..frames import packed, scan_geometry, sensor_rows
from .base import LONG, Weighing
from .kind import RECTANGLES, Kind
from .shapes import root_moment, shapes, sticking

__all__ = ["Evidence"]

_SQUARE = 0.2
"""Step of the scan in the square of the half width, in squares of the least depth."""
_FAR, _WIDE = 1.2, 0.2
"""The half width beyond which its steps are even in the half width itself, and how far apart, in least depths."""
_FINE = 4
"""Steps of the survey's positions to one of the scan's."""
_FINE_WIDTH = 0.04
"""Largest step of the survey in the half width, in least depths."""
_OFF = 0.25
"""Share of model errors in what is none of the kinds; the rest are contacts of other shapes."""
_PAIRS = 0.125
"""Step of the grid of two touches, in least depths."""


class _Source(NamedTuple):
    """Responses to contacts of some half widths, and the second moment of their pressure at a half width of 1.

    whole: the kind that they are a part of, or -1; share, left: as of `KINDS`.
    """

    response: Response
    half_width: tuple[float, float]
    moment: float
    whole: int = -1
    share: float = 0.0
    left: float = 0.0


class Evidence(Weighing):
    """The log of the probability of frames of readings under each kind of contact; prepared once, called on many.

    Position, forces and width are integrated over: positions alike over the search, half widths alike over the kind's
    range, angles alike within the friction cone, magnitudes alike on a logarithmic scale (docs/deciding.md).

    Parameters
    ----------
    finger : Finger
        The forward model, with the sensors' noise.
    kinds : sequence of Kind
        At least one of a family; at most one "pair", at most one "none".
    search : (float, float), optional
        Where contacts may be, y [m]; the default reaches half a depth beyond the outermost sensors.
    friction : float, optional
        |tan(angle)| is at most this [-].
    false_alarm : float, optional
        As in `Locator`.

    Raises
    ------
    InvalidValueError, GeometryError
        Sensors without noise, kinds of one name, a search that is none.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=1e-5))
    >>> evidence = Evidence(finger, [Kind("edge", "line"), Kind("rod", "hertz", half_width=(0.5e-3, 2e-3))])
    >>> table, used = evidence(finger.read(ss.LineLoad(force=40.0)))
    >>> bool(table[1] > table[7])  # the logarithms of their probabilities
    True
    """

    _layout_of = LONG
    _example = 'Kind("edge", "wedge", ...), Kind("can", "hertz", ...)'
    _misplaced = (
        RECTANGLES,
        "an edge with its length is a kind on an area: sensors in a row do not see how long it is",
        'Kind("edge", "wedge", half_width=(0.2e-3, 1e-3))',
    )

    def __init__(
        self,
        finger: Finger,
        kinds: Sequence[Kind],
        *,
        search: tuple[float, float] | None = None,
        friction: float = 1.0,
        false_alarm: float = 1e-6,
    ) -> None:
        super().__init__(finger, kinds, friction=friction, false_alarm=false_alarm, needed=(3, 4))
        y, depth = np.asarray(finger.array.y), np.asarray(finger.array.depth)
        if search is None:
            search = (float(y.min() - 0.5 * depth.max()), float(y.max() + 0.5 * depth.max()))
        self._line = tabulate(finger, search)
        self._ends = first, last = (self._line.start, self._line.stop)
        self._sources = self._made(finger)
        count = max(int(np.ceil((last - first) / (self._shallowest / 16) - 1e-9)) + 1, 3)
        self._positions = np.linspace(first, last, count)

    def _made(self, finger: Finger) -> tuple[_Source, ...]:
        """What is weighed: each kind, then rollers that stick, then other shapes."""
        made, single = [], [self.kinds[i] for i in self._single]
        for kind in single:
            family: Any = family_of(kind.family)  # type: ignore[arg-type]
            response = Response.of(finger, family, self._ends, kind.half_width[1])
            moment = root_moment(*family.as_line_loads()) ** 2 if kind.half_width[1] else 1.0
            made.append(_Source(response, kind.half_width, moment))
        found: list[Any] = [
            (*sticking(), kind.half_width, (i, np.log(kind.stick), np.log1p(-kind.stick)))
            for i, kind in enumerate(single)
            if kind.stick > 0
        ]
        for shape in shapes(single, self._shallowest) if self._none >= 0 else ():
            found.append((*shape[:3], (-1, np.log((1 - _OFF) * shape.share), 0.0)))
        for lines, weights, half_width, (whole, share, left) in found:
            try:
                response = Response.of_lines(finger, lines, weights, self._ends, half_width[1])
            except (InvalidValueError, GeometryError):  # no room on this skin for shapes so wide: it has none
                if whole >= 0:
                    raise
                continue
            made.append(_Source(response, half_width, root_moment(lines, weights) ** 2, whole, share, left))
        return tuple(made)

    def _kernel(self) -> Any:
        from ._kernel import weigh_frames

        return weigh_frames

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        from scipy.special import chdtri

        from ._kernel import KINDS, KindsAsked, Tables

        array = self.array.select(pattern)
        n, scale, single, two = len(array), 1 / np.asarray(array.noise), len(self._single), self._two >= 0
        fine = np.linspace(*self._ends, _FINE * (self._positions.size - 1) + 1)
        kinds = np.zeros(len(self._sources), KINDS)
        parts: list[Any] = [[] for _ in range(7)]
        bases, edges, squares, tables, fines, nodes, rows = parts
        for told, source in zip(kinds, self._sources, strict=True):
            field = source.response.select(pattern)
            table = packed(field, scale)
            tables.append(table.reshape(len(table), -1, 10 * n))  # a line has one width
            told["start"], told["step"], told["widest"] = field.start, field.step, field.widest or 1.0
            told["ends"] = (*self._ends, *np.square(source.half_width))
            told["cells"], told["widths"] = tables[-1].shape[:2]
            told["moment"], told["whole"], told["share"], told["left"] = source[2:]
            if len(tables) > single:
                continue
            scanned = _squares(source.half_width, self._shallowest)
            grid = _on_grid(field, self._positions, np.sqrt(scanned)) * scale[:, None]
            basis, edge, _ = scan_geometry(grid.reshape(-1, *grid.shape[2:]), self.friction)
            widths, weights = _widths(source.half_width, _FINE_WIDTH * self._shallowest)
            grid = _on_grid(field, fine, widths) * scale[:, None]
            told["scanned"], told["surveyed"] = scanned.size, widths.size
            bases.append(basis)
            edges.append(edge)
            squares.append(scanned)
            fines.append(np.moveaxis(grid, (2, 3), (0, 1)))
            nodes.append(_inverse(grid, self.friction))
            rows.append(np.stack([widths, widths**2, weights]))
        for name, part in zip(Tables._fields, parts, strict=False):
            kinds[name][: len(part)] = np.cumsum([0, *(p.size for p in part[:-1])])
        alone, both = (n - touches * (2 + (self.friction > 0)) for touches in (1, 2))
        largest, most = (float(chdtri(max(k, 1), self._false_alarm)) for k in (alone, both))
        # what is near to none of the single ones is near to two touches
        kinds["share"][:single] = np.log(self._shares() * (0.5 if two else 1.0))
        kinds["spare"][:single] = np.maximum(self._spare(n), 0)
        kinds["column"][:single] = [self._slot(j) for j in range(single)]
        parts_of = single + int((kinds["whole"] >= 0).sum())
        two_at, none_at = (
            self._layout_of.first + self._layout_of.each * i if i >= 0 else -1 for i in (self._two, self._none)
        )
        asked = KindsAsked(
            self.friction, 2 * float(np.log(1 / self._false_alarm)), largest, most, single, parts_of, two_at, none_at,
            float(np.log(0.5)), max(float(both), 0.0), float(np.log(_OFF)),
        )  # fmt: skip
        flat: Any = [np.concatenate([np.ravel(p) for p in part]) for part in parts]
        tables_of: Any = Tables._make([*flat, self._positions, _FINE])
        return sensor_rows(array), kinds, tables_of, asked, self._pairs(pattern, scale)

    def _pairs(self, pattern: npt.NDArray[np.bool_], scale: FloatArray) -> Any:
        """What the sensors read of two touches; without pairs where no kind is one."""
        from ._pair import TouchPairs

        two, part = self._two, self._line.select(pattern)
        low, high = self.kinds[two].half_width if two >= 0 else (0.0, 0.0)
        step = 0.5 * _PAIRS * self._shallowest
        first, last = self._ends
        halves = np.linspace(low, high, 1 + int(np.ceil((high - low) / step)))
        centres = np.linspace(first, last, 1 + int(np.ceil((last - first) / (2 * step))))
        grid = np.stack(np.meshgrid(centres, halves, indexing="ij")).reshape(2, -1)
        inside = (grid[0] - grid[1] >= first) & (grid[0] + grid[1] <= last) & (two >= 0) & (grid[1] > 0)
        grid = np.ascontiguousarray(grid[:, inside])
        fields = np.concatenate([part(grid[0] - grid[1]), part(grid[0] + grid[1])], axis=-1) * scale[:, None]
        pad = np.zeros((len(fields), max(4 - fields.shape[1], 0), 4))  # three sensors, without friction
        basis, tri = np.linalg.qr(np.concatenate([fields, pad], axis=1))
        size = np.abs(tri).max(axis=(1, 2), keepdims=True, initial=1e-300)
        i = np.arange(4)
        tri[:, i, i] = np.where(tri[:, i, i] < 0, -1.0, 1.0) * np.maximum(np.abs(tri[:, i, i]), 1e-6 * size[:, :, 0])
        made = (basis[:, : fields.shape[1]], tri, np.linalg.inv(tri))
        columns, triangle, back = (np.ascontiguousarray(np.moveaxis(m, 0, -1), dtype=np.float32) for m in made)
        table, line, ends = packed(part, scale), self._line, np.array([first, last, low, high])
        return TouchPairs(grid, columns, triangle, back, table, line.start, line.step, self._shallowest, ends)


def _squares(width: tuple[float, float], depth: float) -> FloatArray:
    """Squares of the scan's half widths: in even steps, but farther apart where a half width is large."""
    low, high = width
    far = min(max(low, _FAR * depth), high)
    near = np.linspace(low**2, far**2, 1 + int(np.ceil((far**2 - low**2) / (_SQUARE * depth**2))))
    return np.append(near, np.linspace(far, high, 1 + int(np.ceil((high - far) / (_WIDE * depth))))[1:] ** 2)


def _widths(width: tuple[float, float], step: float) -> tuple[FloatArray, FloatArray]:
    """Half widths, and the weights of their mean over the range: the trapezoid's, with Gregory's ends."""
    low, high = width
    if not high > low:
        return np.array([low]), np.ones(1)
    count = max(int(np.ceil((high - low) / step)) + 1, 7)
    weights = np.ones(count)
    weights[:3] = weights[:-4:-1] = 3 / 8, 7 / 6, 23 / 24
    return np.linspace(low, high, count), weights / (count - 1)


def _on_grid(field: Response, positions: FloatArray, widths: FloatArray) -> FloatArray:
    """Values for each half width and position, shape (widths, positions, n, 2)."""
    y, a = np.broadcast_arrays(positions, widths[:, None])
    return field(y, a)


def _inverse(fields: FloatArray, friction: float) -> FloatArray:
    """Inverse of A^T A (three entries) and log(2 pi) - log(det) / 2, for fields (..., n, 2); shape (4, ...).

    Without friction that of its first column alone.
    """
    g = np.einsum("...nk,...nl->kl...", fields, fields)
    if friction == 0:
        none = np.zeros_like(g[0, 0])
        return np.stack([1 / g[0, 0], none, none, 0.5 * np.log(2 * np.pi) - 0.5 * np.log(g[0, 0])])
    det = np.maximum(g[0, 0] * g[1, 1] - g[0, 1] ** 2, 1e-14 * g[0, 0] * g[1, 1])
    return np.stack([g[1, 1] / det, -g[0, 1] / det, g[0, 0] / det, np.log(2 * np.pi) - 0.5 * np.log(det)])
