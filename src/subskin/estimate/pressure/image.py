"""What an image of the pressure on an area gives back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray, read_only
from ..._shown import Drawing
from ...contact import PressureGrid
from ...errors import GeometryError
from ...loads import force_unit
from ..estimate import unit_column
from ..shown import Shown
from . import columns as column
from .map import SurfaceMap, _column, _Mapper

__all__ = ["PressureImage"]


class _AreaMapper(_Mapper, Protocol):
    """What an image asks of the `ImageMapper` that made it."""

    @property
    def z(self) -> FloatArray: ...

    def std(self, used: npt.NDArray[np.bool_], drag: FloatArray, weight: float, heights: FloatArray) -> FloatArray: ...


def _pair(first: int, second: int, text: str) -> property:
    def get(self: PressureImage) -> FloatArray:
        return read_only(self.table[..., [first, second]])

    get.__doc__ = text
    return property(get)


@dataclass(frozen=True, eq=False, repr=False)
class PressureImage(SurfaceMap):
    """The pressure found on an area in each frame: numbers of shape (...), images of shape (..., ny, nz).

    Frames that are not `OK` or `AMBIGUOUS` carry NaN.

    Parameters
    ----------
    table, used
        As in `Estimate`.
    mapper : ImageMapper
        What made it.
    """

    mapper: _AreaMapper

    tangential_force = _pair(column.FORCES + 1, column.ACROSS, "Tangential force (Ty, Tz) [N], shape (..., 2).")
    tangential_std = _pair(column.FORCE_STD + 1, column.ACROSS_STD, "Its standard deviations [N], shape (..., 2).")
    centre = _pair(column.CENTRE, column.CENTRE_Z, "Centre of pressure (y, z) [m], shape (..., 2).")
    centre_std = _pair(column.CENTRE_STD, column.CENTRE_Z_STD, "Its standard deviations [m], shape (..., 2).")

    moment = _column(column.MOMENT, "Moment of the drag about the normal at the centre [N m], from +y towards +z.")
    moment_std = _column(column.MOMENT_STD, "Its standard deviation [N m]; both 0 where the drag is not free.")

    plot = Drawing("pressure_image_figure")

    @property
    def azimuth(self) -> FloatArray:
        """Direction of the tangential force, from +y towards +z [rad]; 0 without shear."""
        return np.asarray(np.arctan2(self.table[..., column.ACROSS], self.table[..., column.FORCES + 1]))

    @property
    def azimuth_std(self) -> FloatArray:
        """Standard deviation of the azimuth [rad]; infinite without shear."""
        return self.table[..., column.AZIMUTH_STD]

    def _shown(self) -> list[Shown]:
        (y, z), (y_std, z_std) = np.moveaxis(self.centre, -1, 0), np.moveaxis(self.centre_std, -1, 0)
        unit = force_unit(local=True, relative=self.mapper.relative)
        moment = Shown("moment", 1e3 * self.moment, 1e3 * self.moment_std, f"{unit} mm")
        return [
            Shown("normal force", self.normal_force, self.normal_std, unit),
            Shown("centre y", 1e3 * y, 1e3 * y_std, "mm"),
            Shown("z", 1e3 * z, 1e3 * z_std, "mm"),
            Shown("angle", 180 / np.pi * self.angle, 180 / np.pi * self.angle_std, "deg"),
            *([moment] if self.mapper.shear == "free" else []),
        ]

    def _columns(self) -> dict[str, Any]:
        out = {}
        for name, error in (("tangential_force", "tangential_std"), ("centre", "centre_std")):
            for i, axis in enumerate("yz"):
                out[f"{name}_{axis}"] = getattr(self, name)[..., i]
                out[f"{error}_{axis}"] = getattr(self, error)[..., i]
        names = ["normal_force", "normal_std", "angle", "angle_std", "azimuth", "azimuth_std"]
        names += ["moment", "moment_std", "residual"]
        unit = unit_column(self.shape, self.mapper.relative)
        return {name: getattr(self, name) for name in names} | out | super()._columns() | unit

    @property
    def z(self) -> FloatArray:
        """Nodes along z [m], shape (nz,)."""
        return self.mapper.z

    @property
    def _inner(self) -> tuple[int, int]:
        return len(self.y) - 2, len(self.z) - 2

    @cached_property
    def _deviations(self) -> FloatArray:
        """Standard deviations of the heights with the border [Pa], shape (..., 1 or 3, ny, nz)."""
        heights = self._heights.reshape(-1, *self._heights.shape[-2:])
        used, tangents = self.used.reshape(len(heights), -1), self.tangential_force / self.normal_force[..., None]
        weight, out = self.weight.reshape(-1), np.full(heights.shape, np.nan)
        for f in np.flatnonzero(np.isfinite(self.normal_force.reshape(-1))):
            out[f] = self.mapper.std(used[f], tangents.reshape(-1, 2)[f], weight[f], heights[f])
        return self._bordered(out.reshape(self._heights.shape))

    @property
    def pressure_std(self) -> FloatArray:
        """Standard deviation of the pressure [Pa], shape (..., ny, nz): noise, and what smoothing and drag leave open.

        It is 0 more than an element away from all that press. Each frame is worked out by itself (`band.py`).
        """
        return self._deviations[..., 0, :, :]

    @property
    def shear(self) -> FloatArray:
        """Drag (q_y, q_z) at each node [Pa], shape (..., ny, nz, 2)."""
        if self.mapper.shear == "free":
            return np.moveaxis(self._bordered(self._heights[..., 1:, :]), -3, -1)
        tangents = self.tangential_force / self.normal_force[..., None]
        return read_only(tangents[..., None, None, :] * self.pressure[..., None])

    @property
    def shear_std(self) -> FloatArray:
        """Standard deviations of the drag [Pa], shape (..., ny, nz, 2); 0 where none was allowed."""
        if self.mapper.shear == "free":
            return np.moveaxis(self._deviations[..., 1:, :, :], -3, -1)
        tangents = (self.tangential_force / self.normal_force[..., None])[..., None, None, :]
        doubt = (self.tangential_std / self.normal_force[..., None])[..., None, None, :]
        pressure = self.pressure[..., None]
        with np.errstate(invalid="ignore"):  # a drag of which nothing is known, where nothing presses: none
            of_drag = np.where(pressure == 0, 0.0, doubt * pressure)
            return read_only(np.hypot(tangents * self.pressure_std[..., None], of_drag))

    @property
    def contact(self) -> PressureGrid:
        """The traction as a contact, to read it into any finger or to see its field in any skin.

        Raises
        ------
        GeometryError
            A frame in which no pressure was found.
        """
        if not np.isfinite(self.normal_force).all():
            raise GeometryError("frames without a pressure", "a contact has one in each", "found[found.status == 0]")
        return PressureGrid(self.y, self.z, self.pressure, self.shear)
