"""What every answer carries: value, covariance, residual, status, and the rival."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from .._shown import Drawing, span
from ..loads import Load, force_unit, polar_covariance
from .answer import OfReadings
from .layout import LINE, Layout
from .shown import Shown

__all__ = ["Estimate", "Rival", "unit_column"]


_DEGREE, _MM = 180 / np.pi, 1e3  # in a rad, in a metre


class _Found(Frozen):
    """A contact as some columns of a table give it: those from `_first` on."""

    table: FloatArray
    layout: Layout
    _first: int

    @property
    def position(self) -> FloatArray:
        """Where it presses: y [m], shape (...); of a local contact (y, z), shape (..., 2)."""
        at, d = self._first, self.layout.dim
        return self.table[..., at] if d == 1 else self.table[..., at : at + d]

    @property
    def components(self) -> FloatArray:
        """Normal force and drag, (N, T) [N/m], or (N, Ty, Tz) [N], shape (..., d + 1)."""
        at = self._first + self.layout.components
        return self.table[..., at : at + self.layout.dim + 1]

    @property
    def force(self) -> FloatArray:
        """Magnitude of the load [N/m or N], shape (...)."""
        return Load(self.position, self.components).force

    @property
    def angle(self) -> FloatArray:
        """Angle from the inward normal [rad], shape (...), positive where it drags the skin towards +y."""
        return Load(self.position, self.components).angle

    @property
    def half_width(self) -> FloatArray:
        """Half width a [m], shape (...); 0 of a line and of a point, NaN of a patch, which has `half_widths`."""
        if self.layout.sized and self._first == 0:
            return self.table[..., self.layout.size]
        return self._width(self.layout.wide and not self.layout.aside)

    @property
    def moment(self) -> FloatArray | None:
        """Moment about the inward normal [N m], shape (...), positive from +y to +z; None where it was not fitted."""
        return self.table[..., self._first + self.layout.unknowns - 1] if self.layout.twist else None

    @property
    def half_widths(self) -> FloatArray | None:
        """Of a patch half its sides [m], that turned from y and that turned from z, shape (..., 2); else None."""
        return self._sides(0, 2) if self.layout.sides else None

    @property
    def turn(self) -> FloatArray | None:
        """By how much a patch is turned, from +y towards +z, within an eighth of a full turn [rad], shape (...)."""
        return self._sides(2, 1)[..., 0] if self.layout.sides else None

    @property
    def corners(self) -> FloatArray | None:
        """Of a patch its corners (y, z), one after the other about it [m], shape (..., 4, 2); else None."""
        if self.half_widths is None or self.turn is None:
            return None
        signs = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
        along, across = np.moveaxis(signs * self.half_widths[..., None, :], -1, 0)
        c, s = np.cos(self.turn)[..., None], np.sin(self.turn)[..., None]
        away = np.stack([c * along - s * across, s * along + c * across], axis=-1)
        return np.asarray(self.position[..., None, :] + away)

    @property
    def slopes(self) -> FloatArray | None:
        """Of a patch with a linear pressure, its slopes as of `Patch` [1/m, 1/m, 1/m^2], shape (..., 3); else None."""
        if not self.layout.leaning:
            return None
        return np.concatenate([self._sides(3, 2), np.zeros((*self.table.shape[:-1], 1))], axis=-1)

    @property
    def hollow(self) -> FloatArray | None:
        """Of a patch as of a punch by how much less it presses in its middle than at the edges' middles, over the mean.

        The pressure is 1 + hollow (u^2 + v^2 - 2/3) at (u, v) half widths, over its mean. None of other contacts.
        """
        return self._sides(3, 1)[..., 0] if self.layout.hollow else None

    def _sides(self, first: int, count: int) -> FloatArray:
        """What stands behind the components of a patch."""
        at = self._first + self.layout.components + 3 + first
        return self.table[..., at : at + count]

    @property
    def beside(self) -> FloatArray:
        """How far a point load presses beside a row of sensors, |z| [m], shape (...); 0 of other contacts."""
        return self._width(self.layout.wide and self.layout.aside)

    def _width(self, known: bool) -> FloatArray:
        if known:
            return self.table[..., self._first + self.layout.half_width]
        return np.where(np.isnan(self.table[..., self._first]) | self.layout.sides, np.nan, 0.0)


@dataclass(frozen=True, eq=False)
class Rival(_Found):
    """The second-best contact: a minimum of chi-square of its own. NaN, and `chi2` infinite, where there is none.

    Parameters
    ----------
    table, layout, relative
        As in `Estimate`, whose `second` it is.
    """

    table: FloatArray
    layout: Layout
    relative: bool = False

    @property
    def _first(self) -> int:  # type: ignore[override]
        return self.layout.rival

    def __repr__(self) -> str:
        known = int(np.isfinite(self.chi2).sum())
        more = span(self.chi2[np.isfinite(self.chi2)])
        load = Load(self.position, self.components, relative=self.relative)
        return f"Rival(in {known} of {self.chi2.size} frames, chi-square larger by {more}; {load!r})"

    @property
    def chi2(self) -> FloatArray:
        """How much larger its chi-square is than the best one's, shape (...)."""
        return self.table[..., self.layout.rival_chi2]


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Estimate(_Found, OfReadings):
    """The contact found in each frame; every field has the batch's shape (...).

    Frames that are not `OK` or `AMBIGUOUS` have NaN for the contact.

    Parameters
    ----------
    table : ndarray, shape (..., layout.columns)
        The packed results, in the columns and units of `layout`; read them by name.
    used : ndarray of bool, shape (..., n)
        Which sensors each frame's answer rests on; the others were missing, saturated or dead.
    friction : float
        The cone that was searched, |tan(angle)| <= friction [-]. A load on its edge may be steeper than was found.
    unknowns : int
        Number of unknowns that were fitted.
    layout : Layout
        What stands in which column.
    relative : bool
        Whether forces are multiples of the load of the touches of a calibration, as of the finger: `force_unit`.
    """

    friction: float
    unknowns: int = 3
    layout: Layout = LINE
    relative: bool = False

    _first = 0
    plot = Drawing("estimate_figure")

    def __init__(
        self, table: FloatArray, used: npt.NDArray[np.bool_], friction: float, unknowns: int = 3, layout: Layout = LINE,
        relative: bool = False,
    ) -> None:  # fmt: skip
        kept = self.__dict__  # as a frozen dataclass would, in half the time: each frame of a live loop waits for it
        kept["table"], kept["used"], kept["friction"] = table, used, friction
        kept["unknowns"], kept["layout"], kept["relative"] = unknowns, layout, relative

    @property
    def status(self) -> npt.NDArray[np.int8]:
        """`Status` of each frame, as integers."""
        return self.table[..., self.layout.status].astype(np.int8)

    @property
    def residual(self) -> FloatArray:
        """Chi-square of the fit: sum of squared residuals in units of each sensor's noise."""
        return self.table[..., self.layout.residual]

    @cached_property
    def load(self) -> Load:
        """Position and components, and a moment where it was fitted, with the covariance of these."""
        at, k = self.layout, 2 * self.layout.dim + 1
        which = [*range(k), *[at.unknowns - 1] * at.twist]
        square = self.table[..., at.square[np.ix_(which, which)]]
        square.flags.writeable = False
        return Load(self.position, self.components, square, self.moment, self.relative)

    @property
    def covariance(self) -> FloatArray:
        """Inverse Fisher information of position, force, angle, half width and moment, (..., k, k).

        On an area position (y, z) and azimuth count two and one more; what is not an unknown is not there. Of a patch
        both half widths, the turn, and the first two slopes or `hollow`, come behind.
        """
        return polar_covariance(self.components, self.table[..., self.layout.square])

    @property
    def std(self) -> FloatArray:
        """Standard deviations of the same, shape (..., k)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1))

    @property
    def half_width_interval(self) -> FloatArray:
        """95 % interval of the half width [m], shape (..., 2); lopsided near 0, where readings depend on its square.

        NaN where `locate` took a size, or none, for a finger with tolerances: it counts sizes in the covariance alone.
        """
        if self.layout.sized:
            return np.full((*self.shape, 2), np.nan)
        return self._interval(self.layout.wide and not self.layout.aside, self.half_width)

    @property
    def beside_interval(self) -> FloatArray:
        """95 % interval of `beside` [m], shape (..., 2); lopsided near 0, where readings depend on its square."""
        return self._interval(self.layout.wide and self.layout.aside, self.beside)

    def _interval(self, known: bool, value: FloatArray) -> FloatArray:
        if known:
            return self.table[..., self.layout.interval : self.layout.interval + 2]
        return np.repeat(value[..., None], 2, axis=-1)

    @property
    def spare(self) -> npt.NDArray[np.intp]:
        """Readings beyond the unknowns, shape (...); with 0 they cannot speak against the load, and it is AMBIGUOUS."""
        return np.asarray(np.maximum(self.used.sum(axis=-1) - self.unknowns, 0))

    @property
    def second(self) -> Rival:
        """The rival: the second-best contact elsewhere, and how much worse it fits."""
        return Rival(self.table, self.layout, self.relative)

    @property
    def force_unit(self) -> str:
        """What forces are in: "N/m", "N" of point loads; "touch loads" where they are `relative`."""
        return force_unit(self.layout.dim == 2 or self.layout.aside, self.relative)

    def _polar(self) -> list[tuple[str, FloatArray, float, str]]:
        """Position, force, angle (and half width) in the order of `std`: name, values, scale and unit for people."""
        d, load, aside = self.layout.dim, self.load, self.layout.aside
        where = [self.position] if d == 1 else [self.position[..., 0], self.position[..., 1]]
        names = ("position",) if d == 1 else ("position_y", "position_z")
        found = [(name, values, _MM, "mm") for name, values in zip(names, where, strict=True)]
        found += [("force", load.force, 1.0, self.force_unit), ("angle", load.angle, _DEGREE, "deg")]
        found += [("azimuth", load.azimuth, _DEGREE, "deg")] if d == 2 else []
        if self.layout.wide:
            found.append(("beside", self.beside, _MM, "mm") if aside else ("half_width", self.half_width, _MM, "mm"))
        if self.half_widths is not None and self.turn is not None:
            found += [(f"half_width_{'yz'[k]}", self.half_widths[..., k], _MM, "mm") for k in range(2)]
            found.append(("turn", self.turn, _DEGREE, "deg"))
        if self.slopes is not None:
            found += [(f"slope_{'yz'[k]}", self.slopes[..., k], 1 / _MM, "/mm") for k in range(2)]
        if self.hollow is not None:
            found.append(("hollow", self.hollow, 1.0, ""))
        if self.moment is not None:
            found.append(("moment", self.moment, _MM, f"{self.force_unit} mm"))
        return found

    def _shown(self) -> list[Shown]:
        std = self.std
        return [
            Shown(name.replace("_", " "), scale * values, scale * std[..., i], unit)
            for i, (name, values, scale, unit) in enumerate(self._polar())
        ]

    def _more(self) -> str:
        if self.shape or not np.isfinite(self.residual):
            return ""
        size = (
            f"half width {_MM * float(self.half_width):.3g} mm, " if self.layout.sized and self.half_width > 0 else ""
        )
        return f"{size}chi-square {float(self.residual):.3g} with {int(self.spare)} to spare"

    def _columns(self) -> dict[str, Any]:
        std, found, second = self.std, self._polar(), self.second
        columns: dict[str, Any] = {name: values for name, values, *_ in found}
        columns |= {f"{name}_std": std[..., i] for i, (name, *_) in enumerate(found)}
        if self.layout.wide:
            interval, name = self._interval(True, self.beside), "beside" if self.layout.aside else "half_width"
            columns |= {f"{name}_low": interval[..., 0], f"{name}_high": interval[..., 1]}
        if self.layout.sized:
            columns["half_width"] = self.half_width
        columns |= {**super()._columns(), "residual": self.residual, "spare": self.spare}
        if self.layout.dim == 1:
            columns["second_position"] = second.position
        if self.layout.wide:
            columns["second_half_width"] = second.half_width
        return {**columns, "second_chi2": second.chi2, **unit_column(self.shape, self.relative)}


def unit_column(shape: tuple[int, ...], relative: bool) -> dict[str, Any]:
    """A column that says what forces are in where that is no newtons, which all other tables have."""
    return {"force_unit": np.full(shape, force_unit(local=True, relative=True), dtype=object)} if relative else {}
