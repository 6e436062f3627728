"""Readings -> a contact of some width: where, how hard, at what angle, how wide; of a named family."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ...array import SensorArray
from ...contact import LineLoad
from ...errors import GeometryError, InvalidValueError
from .._frames import Framewise, checked_friction, scan_geometry, sensor_rows
from .shape import RESIDUAL, RIVAL, STATUS, WIDTH, ShapeEstimate
from .shape_field import ShapeField

__all__ = ["Fitter"]

_SCAN_WIDTHS = 12


def _kernel() -> Any:
    """The compiled loop, imported on first use."""
    from . import _kernel as module

    return module.fit_frames


class Fitter(Framewise):
    """Finds a contact of one family in frames of readings; prepared once, then called on a frame or on many.

    Variable projection, as in `Locator`, over place and the square of the half width: the readings depend on that
    square smoothly, down to no width at all. Global on a grid of both, then refined (docs/fitting.md).

    Parameters
    ----------
    field : ShapeField
        The family's response; its ends bound the search.
    array : SensorArray
        Offset, noise and range of each sensor.
    width : (float, float)
        Least and largest half width [m]; both 0 for line loads.
    friction, false_alarm, ambiguity, outliers
        As of `Locator`; `outliers=1` needs two readings more than unknowns, so six.

    Raises
    ------
    InvalidValueError, GeometryError
        A sensor without noise, widths out of range, a table whose sensors do not match.
    """

    def __init__(
        self,
        field: ShapeField,
        array: SensorArray,
        *,
        width: tuple[float, float],
        friction: float = 1.0,
        false_alarm: float = 1e-6,
        ambiguity: float = 13.8,
        outliers: int = 0,
    ) -> None:
        if field.coefficients.shape[3] != len(array):
            raise GeometryError(
                f"a field of {field.coefficients.shape[3]} sensors, an array of {len(array)}",
                "they have to match",
            )
        ends = _check.real("width", width, unit="m", at_least=0.0)
        if ends.shape != (2,) or not ends[0] <= ends[1] <= field.widest:
            raise InvalidValueError(
                f"width = {width!r}",
                f"two half widths, ascending, up to the field's {field.widest:.6g} m are needed",
            )
        self.field = field
        self.width = (float(ends[0]), float(ends[1]))
        self.friction = checked_friction(friction)
        self.unknowns = 2 + (self.friction > 0) + (ends[1] > ends[0])
        self._ambiguity = _check.scalar("ambiguity", ambiguity, at_least=0.0)
        super().__init__(
            array,
            _kernel,
            needed=self.unknowns,
            columns=WIDTH,
            status=STATUS,
            unrivalled=RIVAL + 4,
            load=4,
            residual=RESIDUAL,
            outliers=outliers,
            ambiguity=self._ambiguity,
        )
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        self._shallowest = float(np.asarray(array.depth).min())
        count = max(int(np.ceil((field.stop - field.start) / (self._shallowest / 16) - 1e-9)) + 1, 3)
        self._positions = np.linspace(field.start, field.stop, count)
        steps = _SCAN_WIDTHS if ends[1] > ends[0] else 1
        self._squares = np.linspace(*self.width, steps) ** 2

    def __call__(self, readings: npt.ArrayLike) -> ShapeEstimate:
        """The contact in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            Raw readings, offset included; NaN marks a missing one.

        Returns
        -------
        ShapeEstimate
            Fields of shape (...).

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        return ShapeEstimate(*self._frames(readings), self.unknowns, self.friction)

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[npt.NDArray[Any], ...]:
        from scipy.special import chdtri

        array, field = self.array.select(pattern), self.field
        scale = 1 / np.asarray(array.noise)
        part = field.coefficients[:, :, :, pattern]
        # (widths, cells, powers, n, loads) -> (cells, widths, powers, loads, n)
        table = np.ascontiguousarray(np.moveaxis(part * scale[:, None], (0, 3), (1, 4)))
        grid = field(self._positions, np.sqrt(self._squares)[:, None])[..., pattern, :] * scale[:, None]
        basis, edges = scan_geometry(grid.reshape(-1, *grid.shape[2:]), self.friction)
        shape = (self._squares.size, self._positions.size)
        degrees = max(len(array) - self.unknowns, 1)
        spare = len(array) > self.unknowns
        options = np.array(
            [
                *(field.start, field.step, field.widest**2, self.friction),
                *(self._positions[0], self._positions[-1], self.width[0] ** 2, self.width[1] ** 2),
                2 * np.log(1 / self._false_alarm),
                # as many unknowns as readings explain anything: nothing is left to be unexplained
                float(chdtri(degrees, self._false_alarm)) if spare else np.inf,
                self._ambiguity,
                0.1 * self._shallowest,
            ]
        )
        return (
            sensor_rows(array),
            np.ascontiguousarray(basis.reshape(*basis.shape[:2], *shape)),
            np.ascontiguousarray(edges.reshape(4, *shape)),
            self._positions,
            self._squares,
            table,
            options,
        )


def widths_of(family: type, width: tuple[float, float] | None, depth: float) -> tuple[float, float]:
    """Bounds of the half width: none for lines, up to one and a half depths otherwise."""
    if issubclass(family, LineLoad):
        if width is not None:
            raise InvalidValueError(f"width = {width!r} of a line load", "it has none", "leave out width")
        return 0.0, 0.0
    return (0.0, 1.5 * depth) if width is None else width
