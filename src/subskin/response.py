"""A finger's response: readings under unit loads, as a table over position (and half width). All an estimator knows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _check
from ._cell import DEGREE, NODES, TO_POWERS, cells_of, ends_of, from_crest_to_crest, polynomial, within
from ._cell import mean as mean_of
from ._check import FloatArray
from ._declared import Extent, Length, Noun, Real, Ruled, checked
from .contact import LineLoad, SpreadContact
from .contact.families import Family
from .errors import ConvergenceError, GeometryError, InvalidValueError
from .finger import Finger, finger_needed
from .prepared import prepared

__all__ = ["Response", "tabulate"]

_CHECKS = np.array([-0.43, -0.19, 0.06, 0.31, 0.46])
_MOST_CELLS = 1 << 12
_MOST_HALVINGS = 5
_WIDTHS = 14
"""Chebyshev nodes in the square of the width: 1e-7 of the largest reading where the widest is 1.5 depths."""
_MOST_WIDE = 4.0
"""Depths up to which the nodes, and the scans that start from them, are close enough."""
_MOST_SHARES = 1 << 20
"""Of coefficients in sums, held at a time: 8 MB."""
_Ends: TypeAlias = Annotated[tuple[float, float], Real("m", fix="search=(-5e-3, 5e-3)")]


def _of_one_width(name: str, family: Any) -> Any:
    if not isinstance(family, type) or not issubclass(family, LineLoad | SpreadContact):
        seen = f"{name} = {_check.shown(family)}"
        raise InvalidValueError(seen, "a class of contacts of one half width is needed", "family=ss.Hertz")
    return family


@dataclass(frozen=True, eq=False)
class Response(Noun):
    """Readings under a unit normal and a unit tangential force, as functions of the contact's position.

    In each of `cells` equal cells a polynomial of degree 4 in t, the distance from the cell's centre over `step`. For
    contacts of some half width a, in which readings are even, each coefficient is a Chebyshev sum over the square of a.

    Parameters
    ----------
    start, step : float
        Left end of the first cell and width of each [m].
    coefficients : ndarray, shape (cells, 5, n, 2) or (widths, cells, 5, n, 2)
        Coefficient of t^k for each sensor and for the normal [..., 0] and tangential [..., 1] force, per N/m.
    error : float
        Largest error seen between the nodes, relative to the largest value.
    widest : float
        Largest half width [m]; 0 of line loads.

    Raises
    ------
    GeometryError
        Coefficients of another shape.
    """

    start: Annotated[float, Real("m")]
    step: Length
    coefficients: FloatArray
    error: Annotated[float, Real(at_least=0.0, finite=False)] = 0.0
    widest: Extent = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        values = self.coefficients
        wide = self.widest > 0
        if values.ndim != 4 + wide or values.shape[1 + wide] != DEGREE + 1 or values.shape[-1] != 2:
            raise GeometryError(
                f"coefficients of shape {values.shape}",
                f"({'widths, ' * wide}cells, {DEGREE + 1}, n, 2) is needed",
                "Response.from_table",
            )

    def __repr__(self) -> str:
        wide = f", half widths to {self.widest:.4g} m" if self.widest else ""
        return f"Response({self.sensors} sensors, y = {self.start:.4g} to {self.stop:.4g} m{wide})"

    @cached_property
    def sensors(self) -> int:
        """Number of sensors."""
        return int(self.coefficients.shape[-2])

    @cached_property
    def blur(self) -> float:
        """Error of the table anywhere, relative to its largest value: between its positions, and between its widths."""
        if not self.widest:
            return self.error
        rest = np.abs(self.coefficients[-1]).max() / np.abs(self.coefficients[:, :, 0]).sum(axis=0).max()
        return max(self.error, float(rest))

    @cached_property
    def stop(self) -> float:
        """Right end of the last cell [m]."""
        return float(self.start + self.step * self.coefficients.shape[-4])

    @classmethod
    @checked
    def from_function(
        cls,
        function: Callable[[FloatArray], FloatArray],
        start: Annotated[float, Real("m")],
        stop: Annotated[float, Real("m")],
        *,
        step: Length,
        tolerance: Annotated[float, Real(above=0.0, finite=False)] = 1e-9,
    ) -> Response:
        """Tabulate `function`, which maps positions (...) to (..., n, 2), between `start` and `stop` [m].

        The cells, at most `step` [m] wide, are halved until the error between their nodes falls below `tolerance` times
        the largest value.

        Raises
        ------
        GeometryError
            stop <= start, a step so short that a million cells would not do, or a function of another shape.
        ConvergenceError
            The tolerance is not met with 4096 cells, or 32 times as many as to start with: the function is not smooth.
        """
        if not stop > start:
            raise GeometryError(f"start = {start:.6g}, stop = {stop:.6g}", "start has to be < stop", "swap them")
        cells = cells_of(stop - start, step)
        most = max(_MOST_CELLS, cells << _MOST_HALVINGS)
        while cells <= most:
            width = (stop - start) / cells
            centres = start + width * (np.arange(cells) + 0.5)
            positions = centres[:, None] + width * np.concatenate([NODES, _CHECKS])
            values = _check.real("function(position)", function(positions))
            if values.shape[:2] != positions.shape or values.ndim != 4 or values.shape[3] != 2:
                rule = f"positions of shape {positions.shape} have to give {(*positions.shape, 'n', 2)}"
                raise GeometryError(f"function(position) of shape {values.shape}", rule.replace("'", ""))
            at_nodes, at_checks = np.split(values, [NODES.size], axis=1)
            coefficients = np.einsum("kj,cjnl->cknl", TO_POWERS, at_nodes)
            cell, t = within((positions[:, NODES.size :] - start) / width, cells)
            worst = float(np.abs(polynomial(coefficients[cell], t) - at_checks).max())
            peak = float(np.abs(at_nodes).max())
            if worst <= tolerance * peak:
                return cls(start, width, coefficients, worst / peak if peak else 0.0)
            cells *= 2
        rule = "a smooth receptive field is needed"
        fix = "sensors that read something: not strain along the depth at a rigid base; and not at the surface itself"
        raise ConvergenceError(f"an error of {worst / peak if peak else 0.0:.2g} with {cells // 2} cells", rule, fix)

    @classmethod
    def from_table(
        cls, positions: npt.ArrayLike, normal: npt.ArrayLike, tangential: npt.ArrayLike, *, tolerance: float = 1e-6
    ) -> Response:
        """A response measured, or computed elsewhere, at the given load positions; a quintic spline between them.

        Parameters
        ----------
        positions : array_like, shape (m,)
            Positions of the load [m], ascending, m >= 6.
        normal, tangential : array_like, shape (m, n)
            Reading of each sensor per unit of normal and of tangential line load [1/(N/m)].
        tolerance : float, optional
            Accuracy to which the spline is followed, relative to the largest value.

        Raises
        ------
        GeometryError
            Shapes that do not match, too few positions, or positions that do not ascend.
        """
        from scipy.interpolate import make_interp_spline

        y = _check.real("positions", positions, unit="m")
        fields = [_check.real("normal", normal), _check.real("tangential", tangential)]
        if y.ndim != 1 or y.size < 6 or not (np.diff(y) > 0).all():
            raise GeometryError(
                f"positions of shape {y.shape}",
                "at least 6 ascending positions are needed",
                "np.linspace(-7e-3, 7e-3, 141)",
            )
        if any(f.ndim != 2 or f.shape[0] != y.size or f.shape != fields[0].shape for f in fields):
            raise GeometryError(
                f"normal {fields[0].shape}, tangential {fields[1].shape}",
                f"both need the shape ({y.size}, sensors)",
                "a row for each position, a column for each sensor",
            )
        spline = make_interp_spline(y, np.stack(fields, axis=-1), k=5)
        return cls.from_function(spline, float(y[0]), float(y[-1]), step=float(np.diff(y).min()), tolerance=tolerance)

    @classmethod
    @checked
    def of(
        cls, finger: Finger, family: Annotated[Family, Ruled(_of_one_width)], search: _Ends, widest: float
    ) -> Response:
        """The response to a family of contacts, from that to line loads: a contact is a sum of them, on any skin.

        Parameters
        ----------
        finger : Finger
            The forward model.
        family : class of contacts
            Of one half width.
        search : (float, float)
            Ends of the positions [m].
        widest : float
            Largest half width [m].

        Raises
        ------
        InvalidValueError
            Half widths that are too large for the sensors' depths.
        """
        if issubclass(family, LineLoad):
            return tabulate(finger, search)
        return cls.of_lines(finger, *family.as_line_loads(), search, widest)

    @classmethod
    @checked
    def of_lines(
        cls, finger: Finger, lines: FloatArray, weights: FloatArray, search: _Ends, widest: Length
    ) -> Response:
        """The response to contacts that are sums of line loads.

        Parameters
        ----------
        finger : Finger
            The forward model.
        lines : ndarray, shape (m,)
            Positions of the line loads from the contact's [half widths].
        weights : ndarray, shape (m,) or (m, 2)
            Their shares of the contact's force; of the normal and of the tangential one, where these differ.
        search, widest
            As in `of`.

        Raises
        ------
        InvalidValueError
            Half widths that are too large for the sensors' depths.
        """
        (low, high), depth = search, float(np.asarray(finger.array.depth).min())
        if widest > (most := _MOST_WIDE * depth) * (1 + 1e-12):
            rule = f"up to {_MOST_WIDE:g} depths of the shallowest sensor, {most:.6g} m, can be fitted"
            raise InvalidValueError(f"half widths up to {widest:.6g} m", rule, f"half_width=(0.0, {most:.3g})")
        step = (high - low) / (cells := cells_of(high - low, depth / 16))
        positions = (low + step * (np.arange(cells) + 0.5))[:, None] + step * NODES
        line = tabulate(finger, (low - widest, high + widest))
        shares = 0.5 * (1 + np.cos(np.pi * (np.arange(_WIDTHS) + 0.5) / _WIDTHS))
        values = np.stack([line._summed(positions, widest * np.sqrt(q) * lines, weights) for q in shares])
        matrix = np.polynomial.chebyshev.chebvander(2 * shares - 1, _WIDTHS - 1)
        sums = np.linalg.solve(matrix, values.reshape(_WIDTHS, -1)).reshape(values.shape)
        return cls(low, step, np.einsum("kj,wcjnl->wcknl", TO_POWERS, sums), line.error, widest)

    def _summed(self, positions: FloatArray, shifts: FloatArray, weights: FloatArray) -> FloatArray:
        """Sum of the values at `positions` + `shifts` (m,), of line loads, times `weights`; positions + (n, 2)."""
        if weights.ndim == 2:
            return np.stack([self._summed(positions, shifts, weights[:, i])[..., i] for i in range(2)], axis=-1)
        cells = len(self.coefficients)
        table = self.coefficients.reshape(cells, DEGREE + 1, -1)
        total = np.zeros((positions.size, table.shape[2]))
        for part in np.array_split(np.arange(positions.size), -(-positions.size * cells // _MOST_SHARES)):
            steps = (positions.reshape(-1)[part, None] + shifts - self.start) / self.step
            cell = np.clip(np.floor(steps).astype(np.intp), 0, cells - 1)
            t, term = (steps - cell - 0.5).reshape(-1), np.tile(weights, part.size)
            share = (cell + cells * np.arange(part.size)[:, None]).reshape(-1)
            for k in range(DEGREE + 1):  # how much of each coefficient is in each sum: one product takes them all
                total[part] += np.bincount(share, term, part.size * cells).reshape(-1, cells) @ table[:, k]
                term *= t
        return total.reshape(*positions.shape, -1, 2)

    @checked
    def averaged(self, width: Length) -> Response:
        """The mean over so wide a sensor about each position, of a table of line loads; shorter by that width.

        Parameters
        ----------
        width : float
            Width of the sensors [m], > 0 and less than the table is long.

        Raises
        ------
        InvalidValueError, GeometryError
            Another width; a table of contacts of some half width.
        """
        if self.widest:
            raise GeometryError(f"a table of half widths up to {self.widest:.6g} m", "one of line loads is needed")
        c = self.coefficients
        powers = np.arange(1, DEGREE + 2)
        before = np.concatenate([np.zeros((1, *c.shape[2:])), self.step * np.cumsum(mean_of(c), axis=0)])

        def sums(position: FloatArray) -> FloatArray:
            cell, t = within((position - self.start) / self.step, len(c))
            parts = (t[..., None] ** powers - (-0.5) ** powers) / powers  # (..., 1, 1, k)
            return np.asarray(before[cell] + self.step * np.einsum("...knl,...abk->...nl", c[cell], parts))

        def mean(position: FloatArray) -> FloatArray:
            return (sums(position + 0.5 * width) - sums(position - 0.5 * width)) / width

        less = self.step * np.ceil(0.5 * width / self.step - 1e-9)
        ends = self.start + less, self.stop - less
        return Response.from_function(mean, *ends, step=self.step, tolerance=np.inf)

    def select(self, sensors: npt.ArrayLike) -> Response:
        """The response of some of the `sensors`, given by a mask or by indices."""
        index = np.arange(self.sensors)[_check.of_sensors(sensors, self.sensors)]
        if np.array_equal(index, np.arange(self.sensors)):
            return self
        return self.altered(coefficients=self.coefficients[..., index, :])

    def __call__(self, position: npt.ArrayLike, half_width: npt.ArrayLike = 0.0, *, derivative: int = 0) -> FloatArray:
        """Value, or first or second derivative in y, shape (..., n, 2).

        Parameters
        ----------
        position : array_like, shape (...)
            Where the contact presses [m]; beyond the ends the outermost polynomial goes on.
        half_width : array_like, shape (...)
            Its half width [m]; of no effect in a table of line loads.
        derivative : {0, 1, 2}, optional
            Which derivative in y.

        Raises
        ------
        InvalidValueError, GeometryError
            What is no number; another derivative; positions and half widths that do not broadcast.
        """
        derivative = _check.whole("derivative", derivative, at_least=0, at_most=2, fix="derivative=1")
        y = _check.real("position", position, unit="m", finite=False)
        c = self.coefficients
        if self.widest:
            a = _check.real("half_width", half_width, unit="m", finite=False)
            y, a = np.broadcast_to(y, shape := _check.broadcast(position=y, half_width=a)), np.broadcast_to(a, shape)
        cell, t = within((y - self.start) / self.step, c.shape[-4])
        if self.widest:
            shares = np.polynomial.chebyshev.chebvander(2 * (a / self.widest) ** 2 - 1, len(c) - 1)
            c = np.einsum("w...knl,...w->...knl", c[:, cell], shares)
        else:
            c = c[cell]
        return polynomial(c, t, derivative) / self.step**derivative


def tabulate(finger: Finger, search: tuple[float, float] | None = None) -> Response:
    """A finger's response to line loads over the positions `search`; tables are kept, and asking again costs nothing.

    Parameters
    ----------
    finger : Finger
        The forward model.
    search : (float, float), optional
        Ends of the positions [m]; the default reaches 1.5 depths beyond the outermost sensors.

    Raises
    ------
    InvalidValueError
        Where `search` is not two ascending positions, or goes more than once round a finger.
    GeometryError
        Sensors on an area: what lies in a plane is known of sensors in a row.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3))
    >>> (table := tabulate(finger))
    Response(4 sensors, y = -0.006 to 0.006 m)
    >>> bool(np.allclose(table(1.234e-3), finger.receptive_field(1.234e-3), rtol=1e-8))
    True
    """
    finger_needed(finger)
    finger.array.refuse_area()
    ends = _check.ends("search", search, "search=(-5e-3, 5e-3)")

    def make() -> Response:
        low, high = ends_of(finger, ends)
        cells = 2 * cells_of(high - low, float(np.asarray(finger.array.depth).min()) / 16)  # half as many never do
        step = (high - low) / cells
        if finger.skin.ridges is not None:
            low, high, step = from_crest_to_crest(low, high, step, *finger.skin.ridges, finger.skin.period)
        return Response.from_function(finger.receptive_field, low, high, step=step)

    return prepared(finger).get(("table", ends), make)
