"""A finger's receptive fields as a table: all that an estimator needs to know of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from .errors import ConvergenceError, GeometryError

__all__ = ["ReceptiveField"]

DEGREE = 4
"""Degree of the polynomial in a cell."""

# Chebyshev-Lobatto points of a cell [-1/2, 1/2]: with the ends among them, neighbouring cells agree where they meet.
CELL_NODES = -0.5 * np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)
TO_POWERS = np.linalg.inv(np.vander(CELL_NODES, increasing=True))
_CHECKS = np.array([-0.43, -0.19, 0.06, 0.31, 0.46])
_MOST_CELLS = 1 << 12
_MOST_HALVINGS = 5


@dataclass(frozen=True, eq=False)
class ReceptiveField:
    """Readings under a unit normal and a unit tangential line load, as functions of the load's position.

    In each of `cells` equal cells a polynomial of degree 4 in t = (y - centre of the cell) / step.

    Parameters
    ----------
    start, step : float
        Left end of the first cell and width of each [m].
    coefficients : ndarray, shape (cells, 5, n, 2)
        Coefficient of t^k for each sensor and for the normal [..., 0] and tangential [..., 1] load.
    error : float
        Largest error seen between the nodes, relative to the largest value.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3))
    >>> table = ReceptiveField.from_function(finger.receptive_field, -5e-3, 5e-3, step=2e-3 / 16)
    >>> difference = np.abs(table(1.234e-3) - finger.receptive_field(1.234e-3))
    >>> bool(difference.max() < 1e-9 * np.abs(table(1.234e-3)).max())
    True
    """

    start: float
    step: float
    coefficients: FloatArray
    error: float = 0.0

    def __post_init__(self) -> None:
        values = _check.real("coefficients", self.coefficients)
        if values.ndim != 4 or values.shape[1] != DEGREE + 1 or values.shape[3] != 2:
            raise GeometryError(
                f"coefficients of shape {values.shape}", f"(cells, {DEGREE + 1}, n, 2) is needed"
            )
        object.__setattr__(self, "coefficients", values)

    @property
    def stop(self) -> float:
        """Right end of the last cell [m]."""
        return self.start + self.step * len(self.coefficients)

    @classmethod
    def from_function(
        cls,
        function: Callable[[FloatArray], FloatArray],
        start: float,
        stop: float,
        *,
        step: float,
        tolerance: float = 1e-9,
    ) -> ReceptiveField:
        """Tabulate `function`, which maps positions (...) to (..., n, 2), between `start` and `stop` [m].

        The cells, at most `step` [m] wide, are halved until the error between their nodes falls below `tolerance` times
        the largest value.

        Raises
        ------
        GeometryError
            stop <= start.
        ConvergenceError
            The tolerance is not met with 4096 cells, or 32 times as many as to start with: the function is not smooth.
        """
        if not stop > start:
            raise GeometryError(f"start = {start:.6g}, stop = {stop:.6g}", "start has to be < stop")
        cells = max(int(np.ceil((stop - start) / step * (1 - 1e-12))), 1)
        most = max(_MOST_CELLS, cells << _MOST_HALVINGS)
        while cells <= most:
            width = (stop - start) / cells
            centres = start + width * (np.arange(cells) + 0.5)
            at_nodes = function(centres[:, None] + width * CELL_NODES)
            coefficients = np.einsum("kj,cjnl->cknl", TO_POWERS, at_nodes)
            table = cls(start, width, coefficients)
            checks = (centres[:, None] + width * _CHECKS).reshape(-1)
            worst = float(np.abs(table(checks) - function(checks)).max())
            peak = float(np.abs(at_nodes).max())
            if worst <= tolerance * peak:
                return cls(start, width, coefficients, worst / peak if peak else 0.0)
            cells *= 2
        raise ConvergenceError(
            f"an error of {worst / peak if peak else 0.0:.2g} with {cells // 2} cells",
            "a smooth receptive field is needed",
            "sensors that read something: not strain along the depth at a rigid base; and not at the surface itself",
        )

    @classmethod
    def from_table(
        cls,
        positions: npt.ArrayLike,
        normal: npt.ArrayLike,
        tangential: npt.ArrayLike,
        *,
        tolerance: float = 1e-6,
    ) -> ReceptiveField:
        """Receptive fields measured, or computed elsewhere, at the given load positions; a quintic spline between them.

        Parameters
        ----------
        positions : array_like, shape (m,)
            Places of the load [m], ascending, m >= 6.
        normal, tangential : array_like, shape (m, n)
            Reading of each sensor per N/m of normal and of tangential line load.
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
            raise GeometryError(f"positions of shape {y.shape}", "at least 6 ascending places are needed")
        if any(f.ndim != 2 or f.shape[0] != y.size or f.shape != fields[0].shape for f in fields):
            raise GeometryError(
                f"normal {fields[0].shape}, tangential {fields[1].shape}",
                f"both need the shape ({y.size}, sensors)",
            )
        spline = make_interp_spline(y, np.stack(fields, axis=-1), k=5)
        return cls.from_function(
            spline, float(y[0]), float(y[-1]), step=float(np.diff(y).min()), tolerance=tolerance
        )

    def select(self, sensors: npt.ArrayLike) -> ReceptiveField:
        """The table of some of the sensors, given by a mask or by indices."""
        return ReceptiveField(self.start, self.step, self.coefficients[:, :, np.asarray(sensors)], self.error)

    def __call__(self, position: npt.ArrayLike, derivative: int = 0) -> FloatArray:
        """Value, or first or second derivative in y, at `position` [m] of shape (...); the result is (..., n, 2).

        Beyond the ends the outermost polynomial goes on.
        """
        y = np.asarray(position, dtype=np.float64)
        cell = np.clip(np.floor((y - self.start) / self.step).astype(np.intp), 0, len(self.coefficients) - 1)
        t = ((y - self.start) / self.step - cell - 0.5)[..., None, None]
        c = self.coefficients[cell]
        total = np.zeros(c.shape[:-3] + c.shape[-2:])
        for k in range(DEGREE, derivative - 1, -1):
            factor = float(np.prod(np.arange(k, k - derivative, -1)))
            total = total * t + factor * c[..., k, :, :]
        return total / self.step**derivative
