"""Readings -> how probable each kind of contact makes them: the evidence that `decide.contact_type` weighs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...contact import LineLoad
from ...contact.families import Family, family_of
from ...errors import InvalidValueError
from ...finger import Finger
from ...response import Response, tabulate
from ..estimate import Status
from ..frames import Framewise, checked_friction, packed, scan_geometry, sensor_rows
from .columns import EACH, KIND, STATUS

__all__ = ["Evidence", "Kind"]

_SAID = ("cannot tell", *(status.name.lower().replace("_", " ") for status in Status))
_SQUARE = 0.2
"""Step of the scan in the square of the half width, in squares of the least depth."""
_FINE = 4
"""Steps of the survey's positions to one of the scan's."""
_FINE_WIDTH = 0.04
"""Largest step of the survey in the half width, in least depths."""


@dataclass(frozen=True)
class Kind:
    """A kind of contact that may have pressed, and what is known of it before a reading is seen.

    Parameters
    ----------
    name : str
        What the answer calls it.
    family : {"line", "wedge", "hertz", "strip", "punch"} or subclass of SpreadContact
        Its pressure's shape.
    half_width : (float, float)
        Least and largest half width [m], all between being as probable; both 0 for a line.
    prior : float
        How probable it is, relative to the other kinds.

    Raises
    ------
    InvalidValueError
        An unknown family, widths out of order or of a line, a prior that is not > 0.

    Examples
    --------
    >>> import subskin as ss
    >>> ss.decide.Kind("edge", "wedge", half_width=(0.2e-3, 0.7e-3)).prior
    1.0
    """

    name: str
    family: str | Family
    half_width: tuple[float, float] = (0.0, 0.0)
    prior: float = 1.0

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InvalidValueError(f"name = {self.name!r}", "a kind needs a name", 'Kind("vertex", "wedge", ...)')
        if self.name in _SAID:
            raise InvalidValueError(f'name = "{self.name}"', "answers without a kind are called so", "another name")
        line = issubclass(family_of(self.family), LineLoad)
        ends = _check.real("half_width", self.half_width, unit="m", at_least=0.0)
        if ends.shape != (2,) or not ends[0] <= ends[1]:
            raise InvalidValueError(f"half_width = {self.half_width!r}", "two half widths, ascending, are needed")
        seen = f"half_width = {self.half_width!r} of a {'line load' if line else self.family}"
        if line and ends[1] > 0:
            raise InvalidValueError(seen, "it has none", "leave out half_width")
        if not line and not ends[1] > 0:
            raise InvalidValueError(seen, "its largest half width has to be > 0", "half_width=(0.1e-3, 1e-3)")
        _check.scalar("prior", self.prior, above=0.0)


class Evidence(Framewise):
    """The log of the probability of frames of readings under each kind of contact; prepared once, called on many.

    Position, forces and width are integrated over: positions alike over the search, half widths alike over the kind's
    range, angles alike within the friction cone, magnitudes alike on a logarithmic scale (docs/deciding.md).

    Parameters
    ----------
    finger : Finger
        The forward model, with the sensors' noise.
    kinds : sequence of Kind
        At least one.
    search : (float, float), optional
        Where contacts may be, y [m]; the default reaches half a depth beyond the outermost sensors.
    friction : float, optional
        |tan(angle)| is at most this [-].
    false_alarm : float, optional
        As of `Locator`.

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
            raise InvalidValueError(f"kinds = {names}", "at least one, each of its own name, is needed")
        array = finger.array
        y, depth = np.asarray(array.y), np.asarray(array.depth)
        if search is None:
            search = (float(y.min() - 0.5 * depth.max()), float(y.max() + 0.5 * depth.max()))
        self.friction = checked_friction(friction)
        needed = 4 if self.friction > 0 else 3
        super().__init__(array, needed=needed, columns=KIND + EACH * len(names), status=STATUS)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        self._shallowest = float(depth.min())
        table = tabulate(finger, search)
        self._ends = (table.start, table.stop)
        self.fields = tuple(Response.of(finger, family_of(k.family), self._ends, k.half_width[1]) for k in self.kinds)
        count = max(int(np.ceil((table.stop - table.start) / (self._shallowest / 16) - 1e-9)) + 1, 3)
        self._positions = np.linspace(*self._ends, count)
        step = _SQUARE * self._shallowest**2
        ends = [np.square(k.half_width) for k in self.kinds]
        self._squares = tuple(np.linspace(low, high, 1 + int(np.ceil((high - low) / step))) for low, high in ends)

    def __call__(self, readings: npt.ArrayLike) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Packed results, shape (..., 1 + 6 kinds), and the sensors used, shape (..., n).

        Parameters
        ----------
        readings : array_like, shape (..., n)
            As of `Locator`.
        """
        return self._frames(readings)

    def _kernel(self) -> Any:
        from ._kernel import weigh_frames

        return weigh_frames

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        from scipy.special import chdtri

        array = self.array.select(pattern)
        scale = 1 / np.asarray(array.noise)
        tables, bases, edges, geometry, fines, nodes, rows = [], [], [], [], [], [], []
        fine_positions = np.linspace(*self._ends, _FINE * (self._positions.size - 1) + 1)
        for field, squares, kind in zip(self.fields, self._squares, self.kinds, strict=True):
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
        largest = float(chdtri(max(len(array) - (3 if self.friction > 0 else 2), 1), self._false_alarm))
        options = np.array([self.friction, 2 * np.log(1 / self._false_alarm), largest])
        scans = (tuple(bases), tuple(edges), self._positions, self._squares)
        surveys = (tuple(fines), tuple(nodes), tuple(rows))
        return sensor_rows(array), *scans, tuple(tables), *surveys, np.array(geometry), options


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
