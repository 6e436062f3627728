"""Readings -> how probable each kind of contact makes them: the evidence that `decide.contact_type` weighs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...contact.families import family_of
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...response import Response, tabulate
from ..frames import Framewise, packed, scan_geometry, sensor_rows
from .columns import EACH, KIND, STATUS
from .kind import NONE, PAIR, STRETCH, Kind
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


class Evidence(Framewise):
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

    def __init__(
        self,
        finger: Finger,
        kinds: Sequence[Kind],
        *,
        search: tuple[float, float] | None = None,
        friction: float = 1.0,
        false_alarm: float = 1e-6,
    ) -> None:
        self.kinds = tuple(kinds)
        names = [kind.name for kind in self.kinds]
        if not names or len(set(names)) < len(names):
            raise InvalidValueError(
                f"kinds = {names}",
                "at least one, each of its own name, is needed",
                'Kind("edge", "wedge", ...), Kind("can", "hertz", ...)',
            )
        if STRETCH in [kind.family for kind in self.kinds]:
            rule = "an edge with its length is a kind on an area: sensors in a row do not see how long it is"
            raise InvalidValueError('family = "edge"', rule, 'Kind("edge", "wedge", half_width=(0.2e-3, 1e-3))')
        self._single = [i for i, kind in enumerate(self.kinds) if kind.family not in (PAIR, NONE)]
        pair, none = ([i for i, k in enumerate(self.kinds) if k.family == f] for f in (PAIR, NONE))
        if not self._single or len(pair) > 1 or len(none) > 1:
            rule = 'at least one kind of a family, and at most one "pair" and one "none", can be weighed'
            raise InvalidValueError(f"families = {[k.family for k in self.kinds]}", rule, "leave the others out")
        self._two, self._none = (pair or [-1])[0], (none or [-1])[0]
        array = finger.array
        y, depth = np.asarray(array.y), np.asarray(array.depth)
        if search is None:
            search = (float(y.min() - 0.5 * depth.max()), float(y.max() + 0.5 * depth.max()))
        self.friction = _check.friction(friction)
        needed = 4 if self.friction > 0 else 3
        super().__init__(array, needed=needed, columns=KIND + EACH * len(names), status=STATUS)
        self.allow_for(finger, self.friction)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        self._shallowest = float(depth.min())
        table = tabulate(finger, search)
        self._ends = (table.start, table.stop)
        single = [self.kinds[i] for i in self._single]
        families: list[Any] = [k.family for k in single]
        self.fields = tuple(
            Response.of(finger, family_of(family), self._ends, k.half_width[1])
            for family, k in zip(families, single, strict=True)
        )
        self._more, self._parts, self._moments = self._others(finger, single, none)
        self._line = table
        count = max(int(np.ceil((table.stop - table.start) / (self._shallowest / 16) - 1e-9)) + 1, 3)
        self._positions = np.linspace(*self._ends, count)
        self._squares = tuple(_squares(k, self._shallowest) for k in single)

    def _others(
        self, finger: Finger, single: list[Kind], none: list[int]
    ) -> tuple[tuple[tuple[Response, tuple[float, float]], ...], FloatArray, FloatArray]:
        """What is weighed beside the single kinds: responses and half widths, whose part they are, second moments."""
        parts, found = [], []
        moments = [root_moment(*family_of(k.family).as_line_loads()) ** 2 if k.half_width[1] else 1.0 for k in single]  # type: ignore[arg-type,union-attr]
        for i, kind in enumerate(single):
            if kind.stick > 0:
                found.append((*sticking(), kind.half_width))
                parts.append([i, np.log(kind.stick), np.log1p(-kind.stick)])
        for shape in shapes(single, self._shallowest) if none else ():
            found.append(shape[:3])
            parts.append([-1.0, np.log((1 - _OFF) * shape.share), 0.0])
        made, kept = [], []
        for part, (lines, weights, ends) in zip(parts, found, strict=True):
            try:
                made.append((Response.of_lines(finger, lines, weights, self._ends, ends[1]), ends))
            except (InvalidValueError, GeometryError):  # no room on this skin for shapes so wide: it has none
                if part[0] >= 0:
                    raise
                continue
            kept.append(part)
            moments.append(root_moment(lines, weights) ** 2)
        return tuple(made), np.array(kept).reshape(-1, 3), np.array(moments)

    def __call__(self, readings: npt.ArrayLike) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Packed results, shape (..., 1 + 6 kinds), and the sensors used, shape (..., n).

        Parameters
        ----------
        readings : array_like, shape (..., n)
            As in `Locator`.
        """
        return self._frames(readings)

    def _kernel(self) -> Any:
        from ._kernel import weigh_frames

        return weigh_frames

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        from scipy.special import chdtri

        from ._kernel import Odds, Thresholds
        from ._tables import Sizes, Starts, Tables

        array = self.array.select(pattern)
        scale = 1 / np.asarray(array.noise)
        tables, bases, edges, geometry, fines, nodes, rows = [], [], [], [], [], [], []
        fine_positions = np.linspace(*self._ends, _FINE * (self._positions.size - 1) + 1)
        single = [self.kinds[i] for i in self._single]
        for field, squares, kind in zip(self.fields, self._squares, single, strict=True):
            part = field.select(pattern)
            table = packed(part, scale)
            tables.append(table.reshape(len(table), -1, 10 * len(array)))  # a line has one width
            grid = _on_grid(part, self._positions, np.sqrt(squares)) * scale[:, None]
            basis, edge, _ = scan_geometry(grid.reshape(-1, *grid.shape[2:]), self.friction)
            bases.append(basis)
            edges.append(edge)
            widths, weights = _widths(kind.half_width, _FINE_WIDTH * self._shallowest)
            grid = _on_grid(part, fine_positions, widths) * scale[:, None]
            fines.append(np.ascontiguousarray(np.moveaxis(grid, (2, 3), (0, 1))))
            nodes.append(_inverse(grid, self.friction))
            rows.append(np.stack([widths, widths**2, weights]))
            ends = (*self._ends, *np.square(kind.half_width))
            geometry.append([field.start, field.step, field.widest**2 or 1.0, *ends])
        for field, half_width in self._more:
            tables.append(packed(field.select(pattern), scale))
            geometry.append([field.start, field.step, field.widest**2, *self._ends, *np.square(half_width)])
        spare = [float(len(array) - k.unknowns(self.friction)) for k in single]
        alone = len(array) - (3 if self.friction > 0 else 2)
        both = len(array) - (6 if self.friction > 0 else 4)
        largest, most = (float(chdtri(max(k, 1), self._false_alarm)) for k in (alone, both))
        priors = np.array([k.prior for k in single])
        # what is near to none of the single ones is near to two touches
        shares = np.log(np.append(priors / priors.sum() * (0.5 if self._two >= 0 else 1.0), 0.5))
        flat: list[Any] = [bases, edges, self._squares, tables, fines, nodes, rows]
        starts = np.zeros((len(flat), len(tables)), dtype=np.int64)
        for begin, part in zip(starts, flat, strict=True):
            begin[1 : len(part)] = np.cumsum([p.size for p in part[:-1]])
        none = len(self._more) * [0]
        sizes = (
            [*(q.size for q in self._squares), *none], *np.transpose([t.shape[:2] for t in tables]),
            [*(r.shape[1] for r in rows), *none],
        )  # fmt: skip
        joined = (np.concatenate([np.ravel(p) for p in part]) for part in flat)
        scans, edged, squared, tabled, fine, noded, rowed = joined
        whole, share, left = self._parts.T
        return (
            sensor_rows(array),
            Tables(
                scans, edged, self._positions, squared, tabled, fine, noded, rowed, np.array(geometry), Starts(*starts),
                Sizes(*(np.array(s, dtype=np.int64) for s in sizes)), _FINE,
            ),
            Odds(
                np.array(self._single), self._two, self._none, shares, np.maximum([*spare, both], 0.0),
                whole.astype(np.intp), np.array(share), np.array(left), self._moments, float(np.log(_OFF)),
            ),
            Thresholds(self.friction, 2 * float(np.log(1 / self._false_alarm)), largest, most),
            self._pairs(pattern, scale),
        )  # fmt: skip

    def _pairs(self, pattern: npt.NDArray[np.bool_], scale: FloatArray) -> Any:
        """What the sensors read of two touches; without pairs where no kind is one."""
        from ._pair import LineTable, TouchPairs

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
        single = (np.ascontiguousarray(np.moveaxis(m, 0, -1), dtype=np.float32) for m in made)
        ends = np.array([first, last, low, high])
        line = LineTable(packed(part, scale), self._line.start, self._line.step)
        columns, triangle, inverse = single
        return TouchPairs(grid, columns, triangle, inverse, line, self._shallowest, ends)


def _squares(kind: Kind, depth: float) -> FloatArray:
    """Squares of the scan's half widths: in even steps, but farther apart where a half width is large."""
    low, high = kind.half_width
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
