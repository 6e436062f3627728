"""What every answer carries: value, covariance, residual, status, and the rival."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from .._check import FloatArray

__all__ = ["Estimate", "Packed", "Rival", "Status"]


class Status(IntEnum):
    """How far an answer can be trusted, frame by frame."""

    OK = 0
    """One load explains the readings, and no other comes near."""
    AMBIGUOUS = 1
    """Another load explains them nearly as well (`Estimate.second`), or the best one lies at the search's edge."""
    NO_CONTACT = 2
    """Nothing beyond noise."""
    UNEXPLAINED = 3
    """No admissible load (pressing, within the friction cone) explains the readings."""
    INCOMPLETE = 4
    """Too few sensors could be used."""


# Columns of the packed table that the compiled locator fills, one row a frame.
POSITION, FORCE, ANGLE, COVARIANCE, RESIDUAL, RIVAL, STATUS, WIDTH = 0, 1, 2, 3, 9, 10, 14, 15


def _column(index: int, text: str) -> property:
    def get(self: Estimate) -> FloatArray:
        return self.table[..., index]

    return property(get, doc=text)


@dataclass(frozen=True, eq=False)
class Rival:
    """The second-best load: a minimum of chi-square of its own. NaN, and `chi2` infinite, where there is none."""

    table: FloatArray

    @property
    def position(self) -> FloatArray:
        """Place y [m], shape (...)."""
        return self.table[..., RIVAL]

    @property
    def force(self) -> FloatArray:
        """Magnitude [N/m], shape (...)."""
        return self.table[..., RIVAL + 1]

    @property
    def angle(self) -> FloatArray:
        """Angle from the inward normal [rad], shape (...)."""
        return self.table[..., RIVAL + 2]

    @property
    def chi2(self) -> FloatArray:
        """How much larger its chi-square is than the best one's, shape (...)."""
        return self.table[..., RIVAL + 3]


class Packed:
    """What all estimates are: a table of packed results, a row a frame, read by name."""

    table: FloatArray
    _status: ClassVar[int]
    _square: ClassVar[npt.NDArray[np.intp]]
    """Columns of the covariance, as the square that they make."""

    def __repr__(self) -> str:
        counts = np.bincount(np.atleast_1d(self.status).reshape(-1), minlength=len(Status))
        said = ", ".join(f"{counts[s]} {s.name}" for s in Status if counts[s])
        return f"{type(self).__name__}(shape {self.shape}: {said or 'no frames'})"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch."""
        return self.table.shape[:-1]

    @property
    def status(self) -> npt.NDArray[np.int8]:
        """`Status` of each frame, as integers."""
        return self.table[..., self._status].astype(np.int8)

    @property
    def covariance(self) -> FloatArray:
        """Of (position [m], force [N/m], angle [rad], ...), shape (..., k, k): the inverse Fisher information."""
        return self.table[..., self._square]

    @property
    def std(self) -> FloatArray:
        """Standard deviations of the same, shape (..., k)."""
        return np.sqrt(self.table[..., self._square.diagonal()])


@dataclass(frozen=True, eq=False, repr=False)
class Estimate(Packed):
    """The load found in each frame; every field has the batch's shape (...).

    `covariance` and `std` are of position [m], force [N/m] and angle [rad], shapes (..., 3, 3) and (..., 3).
    Frames that are not `OK` or `AMBIGUOUS` carry NaN for the load: no number is given for nonsense.

    Parameters
    ----------
    table : ndarray, shape (..., 15)
        The packed results; read them by name.
    used : ndarray of bool, shape (..., n)
        Which sensors each frame's answer rests on; the others were missing, saturated or dead.
    friction : float
        The cone that was searched, |tan(angle)| <= friction [-]. A load on its edge may be steeper than was found.
    """

    table: FloatArray
    used: npt.NDArray[np.bool_]
    friction: float

    _status: ClassVar[int] = STATUS
    _square: ClassVar[npt.NDArray[np.intp]] = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]]) + COVARIANCE

    position = _column(POSITION, "Place of the load y [m].")
    force = _column(FORCE, "Magnitude of the load [N/m].")
    angle = _column(ANGLE, "Angle from the inward normal [rad], positive where it drags the skin towards +y.")
    residual = _column(
        RESIDUAL, "Chi-square of the fit: sum of squared residuals in units of each sensor's noise."
    )

    @property
    def second(self) -> Rival:
        """The rival: the second-best load and how much worse it fits."""
        return Rival(self.table)
