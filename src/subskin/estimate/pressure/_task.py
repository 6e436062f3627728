"""What the loop over frames is given: by what frames are weighed, and where the elements are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray

__all__ = ["Nodes", "Task"]


class Task(NamedTuple):
    """What frames are weighed by, of n sensors.

    Parameters
    ----------
    sensors : ndarray, shape (4, n)
        Offset, 1 / noise, ends of the range.
    largest : float
        Chi-square above which there is a contact, and a pressure does not explain a frame.
    friction : float
        Bound of the drag's tangent.
    near : float
        Where the search for the drag ends, in its standard deviations.
    rule : int
        Number of the rule of the weight.
    drags : ndarray, shape (T, 2)
        Tangents at which there is a weight.
    basis, squares : ndarray, shapes (T, n, n) and (T, n)
        U^T and S^2 (`_operator.Factors`) at each.
    spread : ndarray, shape (1 to 3, coarse N, n)
        C A^T of pressure and drags at the coarse elements.
    strips, gauges : ndarray, shapes (2, M, n) and (M, 3)
        Readings of even strips of pressure and of drag, and their products; none on an area.
    """

    sensors: FloatArray
    largest: float
    friction: float
    near: float
    rule: int
    drags: FloatArray
    basis: npt.NDArray[np.floating]
    squares: FloatArray
    spread: npt.NDArray[np.float32]
    strips: FloatArray
    gauges: FloatArray


class Nodes(NamedTuple):
    """The fine elements as totals want them.

    Parameters
    ----------
    y, z, own : ndarray, shape (N,)
        Positions [m], and the drag that belongs to 1 Pa of each.
    rim : ndarray of bool, shape (N,)
        Which lie at the edge of the search.
    area : float
        Of one [m, or m^2].
    wide_y, wide_z, few_z : int
        Elements in a coarse one along y and z, and coarse ones along z.
    row : bool
        Whether they stand along a row: an angle then has a sign.
    """

    y: FloatArray
    z: FloatArray
    own: FloatArray
    rim: npt.NDArray[np.bool_]
    area: float
    wide_y: int
    wide_z: int
    few_z: int
    row: bool
