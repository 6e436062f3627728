"""What a fit of a contact of some width gives back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..estimate import Packed

__all__ = ["ShapeEstimate", "ShapeRival"]

# Columns of the packed table that the compiled fit fills, one row a frame.
POSITION, FORCE, ANGLE, HALF_WIDTH, COVARIANCE, INTERVAL = 0, 1, 2, 3, 4, 14
RESIDUAL, RIVAL, STATUS, WIDTH = 16, 17, 22, 23


def _column(index: int, text: str) -> property:
    def get(self: ShapeEstimate) -> FloatArray:
        return self.table[..., index]

    return property(get, doc=text)


@dataclass(frozen=True, eq=False)
class ShapeRival:
    """The second-best contact of the same family, elsewhere. NaN, and `chi2` infinite, where there is none."""

    table: FloatArray

    position = _column(RIVAL, "Place y [m], shape (...).")
    force = _column(RIVAL + 1, "Magnitude [N/m], shape (...).")
    angle = _column(RIVAL + 2, "Angle from the inward normal [rad], shape (...).")
    half_width = _column(RIVAL + 3, "Half width [m], shape (...).")
    chi2 = _column(RIVAL + 4, "How much larger its chi-square is than the best one's, shape (...).")


@dataclass(frozen=True, eq=False, repr=False)
class ShapeEstimate(Packed):
    """The contact of one family found in each frame; every field has the batch's shape (...).

    `covariance` and `std` are of position [m], force [N/m], angle [rad] and half width [m], shapes (..., 4, 4) and
    (..., 4). Frames that are not `OK` or `AMBIGUOUS` carry NaN.

    Parameters
    ----------
    table : ndarray, shape (..., 23)
        The packed results; read them by name.
    used : ndarray of bool, shape (..., n)
        Which sensors each frame's answer rests on.
    unknowns : int
        Number of unknowns; as many readings are always explained, whatever presses.
    friction : float
        The cone that was searched, |tan(angle)| <= friction [-]. A load on its edge may be steeper than was found.
    """

    table: FloatArray
    used: npt.NDArray[np.bool_]
    unknowns: int
    friction: float

    _status: ClassVar[int] = STATUS
    _square: ClassVar[npt.NDArray[np.intp]] = (
        np.array([[0, 1, 2, 3], [1, 4, 5, 6], [2, 5, 7, 8], [3, 6, 8, 9]]) + COVARIANCE
    )

    position = _column(POSITION, "Centre of the contact y [m].")
    force = _column(FORCE, "Magnitude of the resultant [N/m].")
    angle = _column(ANGLE, "Angle from the inward normal [rad], positive where it drags the skin towards +y.")
    half_width = _column(HALF_WIDTH, "Half width a [m].")
    residual = _column(
        RESIDUAL, "Chi-square of the fit: sum of squared residuals in units of each sensor's noise."
    )

    @property
    def half_width_interval(self) -> FloatArray:
        """95 % interval of the half width [m], shape (..., 2); lopsided near 0, for readings know its square."""
        return self.table[..., INTERVAL : INTERVAL + 2]

    @property
    def spare(self) -> npt.NDArray[np.intp]:
        """Readings beyond the unknowns, shape (...); where 0 the residual says nothing, for all is explained."""
        return np.asarray(np.maximum(self.used.sum(axis=-1) - self.unknowns, 0))

    @property
    def second(self) -> ShapeRival:
        """The rival: the second-best contact at another place, and how much worse it fits."""
        return ShapeRival(self.table)
