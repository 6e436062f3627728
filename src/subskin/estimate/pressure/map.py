"""What a map of the pressure along the surface gives back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray, read_only
from ..._shown import Drawing
from ...array import SensorArray
from ...loads import force_unit
from ..answer import FrameTable
from ..estimate import unit_column
from ..frames import patterns
from ..shown import Shown
from . import columns as column
from ._operator import Factors

__all__ = ["PressureMap", "SurfaceMap"]


class _Mapper(Protocol):
    """What a map asks of the mapper that made it."""

    y: FloatArray
    array: SensorArray
    shear: str
    friction: float
    relative: bool

    def factors(self, used: npt.NDArray[np.bool_]) -> Sequence[Factors]: ...


def _column(index: int, text: str) -> property:
    def get(self: SurfaceMap) -> FloatArray:
        return self.table[..., index]

    get.__doc__ = text
    return property(get)


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceMap(FrameTable):
    """What is found of the pressure on a surface: numbers of shape (...), and what lies at the elements (..., m)."""

    mapper: _Mapper

    normal_force = _column(column.FORCES, "Normal force [N/m; N on an area], the pressure's integral.")
    normal_std = _column(column.FORCE_STD, "Standard deviation of the normal force [N/m; N on an area].")
    angle = _column(column.ANGLE, "Angle of the resultant from the inward normal [rad]; 0 without shear.")
    angle_std = _column(column.ANGLE_STD, "Standard deviation of the angle [rad]; 0 without shear.")
    residual = _column(column.RESIDUAL, "Chi-square: sum of squared residuals in units of each sensor's noise.")
    weight = _column(
        column.WEIGHT,
        "Weight of the integral of (dp/dy)^2, or |grad p|^2, beside chi-square [m/Pa^2; 1/Pa^2 on an area].",
    )
    optimality = _column(
        column.OPTIMALITY, "Largest breach of the conditions of a minimum, of the slope at no pressure at all."
    )

    @property
    def status(self) -> npt.NDArray[np.int8]:
        """`Status` of each frame, as integers."""
        return self.table[..., column.STATUS].astype(np.int8)

    @property
    def y(self) -> FloatArray:
        """Nodes along the surface, or along y [m]; the traction is (bi)linear between them, 0 at the ends or border."""
        return self.mapper.y

    @property
    def _inner(self) -> tuple[int, ...]:
        """Nodes along each axis between the ends."""
        return (len(self.y) - 2,)

    @property
    def _heights(self) -> FloatArray:
        """Pressure, and where it is free the drag, at the inner nodes [Pa], shape (..., 1 to 3, m)."""
        values, m = self.table[..., column.WIDTH :], int(np.prod(self._inner))
        return values.reshape(*self.shape, values.shape[-1] // m, m)

    def _bordered(self, inner: FloatArray, mode: Any = "constant") -> FloatArray:
        """Values at the inner nodes, (..., m), with those of the ends, or of the border about them."""
        image = inner.reshape(*inner.shape[:-1], *self._inner)
        out = np.pad(image, [(0, 0)] * (inner.ndim - 1) + [(1, 1)] * len(self._inner), mode=mode)
        out[~np.isfinite(self.normal_force)] = np.nan
        return read_only(out)

    @property
    def pressure(self) -> FloatArray:
        """Pressure at each node [Pa], >= 0, shape (..., m), or (..., ny, nz) on an area."""
        return self._bordered(self._heights[..., 0, :])

    @property
    def pressure_std(self) -> FloatArray:
        """Standard deviation of the pressure [Pa], shaped as the pressure."""
        raise NotImplementedError

    @property
    def pressure_interval(self) -> FloatArray:
        """Ends of the 95 % band of the pressure [Pa], none below 0, shape (..., m, 2), or (..., ny, nz, 2)."""
        half, pressure = 1.959964 * self.pressure_std, self.pressure
        return read_only(np.stack([np.maximum(pressure - half, 0.0), pressure + half], axis=-1))

    @property
    def resolution(self) -> FloatArray:
        """Full width at half height of what a narrow pressure at each node looks like [m], shaped as the pressure.

        At the frame's weight and without regard to p >= 0, which can only sharpen it. Where such a pressure is seen
        elsewhere, the distance to there is in it. On an area the geometric mean of the widths along y and along z.
        """
        m = int(np.prod(self._inner))
        return self._bordered(self._at_elements(lambda factors, weight: factors.widths(weight, m), m), "edge")

    @property
    def seen(self) -> FloatArray:
        """What is left at each node of an even pressure over the whole search, shaped as it; 1 is all of it."""
        m = int(np.prod(self._inner))
        return self._bordered(self._at_elements(lambda factors, weight: factors.seen(weight, m), m), "edge")

    def _at_elements(self, what: Callable[[Factors, FloatArray], FloatArray], count: int) -> FloatArray:
        """What the factors tell at each of `count` elements, for each frame's sensors, angle and weight."""
        weight, lean = self.weight.reshape(-1), self.table[..., column.LEAN].reshape(-1)
        used = self.used.reshape(-1, self.used.shape[-1])
        out = np.full((len(weight), count), np.nan)
        for pattern, found in patterns(used, np.isfinite(self.normal_force.reshape(-1))):
            factors = self.mapper.factors(pattern)
            for k in np.unique(lean[found]):
                rows = found[lean[found] == k]
                out[rows] = what(factors[int(k)], weight[rows])
        return out.reshape(*self.shape, count)


@dataclass(frozen=True, eq=False, repr=False)
class PressureMap(SurfaceMap):
    """The pressure found along the surface in each frame: numbers of shape (...), curves of shape (..., m).

    Frames that are not `OK` or `AMBIGUOUS` carry NaN.

    Parameters
    ----------
    table, used
        As in `Estimate`.
    mapper : PressureMapper
        What made it.
    """

    tangential_force = _column(column.FORCES + 1, "Tangential force [N/m], the shear's integral.")
    tangential_std = _column(column.FORCE_STD + 1, "Standard deviation of the tangential force [N/m].")
    centre = _column(column.CENTRE, "Centre of pressure y [m].")
    centre_std = _column(column.CENTRE_STD, "Standard deviation of the centre [m].")

    plot = Drawing("pressure_figure")

    def _shown(self) -> list[Shown]:
        unit = force_unit(local=False, relative=self.mapper.relative)
        scaled = (("normal_force", "normal_std", 1.0, unit), ("centre", "centre_std", 1e3, "mm"))
        found = [*scaled, ("angle", "angle_std", 180 / np.pi, "deg")]
        return [Shown(n.replace("_", " "), k * getattr(self, n), k * getattr(self, e), u) for n, e, k, u in found]

    def _columns(self) -> dict[str, Any]:
        names = ("normal_force", "tangential_force", "angle", "centre")
        errors = ("normal_std", "tangential_std", "angle_std", "centre_std", "residual")
        found = {name: getattr(self, name) for name in (*names, *errors)}
        return found | super()._columns() | unit_column(self.shape, self.mapper.relative)

    @property
    def _heights(self) -> FloatArray:
        parts = super()._heights
        if self.mapper.shear != "free":
            return parts
        # of all the drag that friction holds, to either side
        one, other = np.moveaxis(parts, -2, 0)
        return np.stack([one + other, self.mapper.friction * (one - other)], axis=-2)

    @cached_property
    def _deviations(self) -> FloatArray:
        """Standard deviations of the heights with the ends [Pa], shape (..., 1 or 2, m)."""
        inner = self._heights.shape[-2:]
        found = self._at_elements(Factors.std, inner[0] * inner[1]).reshape(*self.shape, *inner)
        return self._bordered(found * np.array([1.0, self.mapper.friction])[: inner[0], None])

    @property
    def pressure_std(self) -> FloatArray:
        """Standard deviation of the pressure [Pa], noise and what smoothness leaves open, shape (..., m)."""
        return self._deviations[..., 0, :]

    @property
    def shear(self) -> FloatArray:
        """Shear at each node [Pa], positive where it drags the skin towards +y, shape (..., m)."""
        if self.mapper.shear == "free":
            return self._bordered(self._heights[..., 1, :])
        return read_only(np.tan(self.angle)[..., None] * self.pressure)

    @property
    def shear_std(self) -> FloatArray:
        """Standard deviation of the shear [Pa], shape (..., m); 0 where none was allowed."""
        if self.mapper.shear == "free":
            return self._deviations[..., 1, :]
        tangent = np.tan(self.angle)
        slope = (1 + tangent**2) * self.angle_std
        return read_only(np.hypot(tangent[..., None] * self.pressure_std, slope[..., None] * self.pressure))
