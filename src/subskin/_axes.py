"""Where a finger lies on the axes of the touches, and positions taken from one to the other."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray

__all__ = ["on_finger", "on_touches", "turned", "turned_square"]


def turned(turn: float) -> FloatArray:
    """The matrix that takes vectors (y, z) of the finger, as columns, to the axes of the touches.

    Parameters
    ----------
    turn : float
        By how much the finger's y lies turned from the touches' y, towards z [rad].
    """
    cos, sin = np.cos(turn), np.sin(turn)
    return np.array([[cos, -sin], [sin, cos]])


def on_finger(positions: npt.ArrayLike, origin: Any, turn: float = 0.0) -> FloatArray:
    """Positions on the axes of the touches, as they lie on the finger [m].

    Parameters
    ----------
    positions : array_like, shape (...) or (..., 2)
        On the axis of the touches, or on their axes (y, z) [m].
    origin : float, or array_like of shape (2,)
        Where the finger's y = 0, or its (0, 0), lies on these [m].
    turn : float, optional
        As in `turned` [rad].

    Examples
    --------
    >>> on_finger([[12e-3, 5e-3]], origin=(10e-3, 5e-3), turn=0.0).tolist()
    [[0.002, 0.0]]
    """
    away = np.asarray(_check.real("positions", positions, unit="m") - np.asarray(origin))
    return away if np.ndim(origin) == 0 or turn == 0 else away @ turned(turn)


def on_touches(positions: npt.ArrayLike, origin: Any, turn: float = 0.0) -> FloatArray:
    """Positions on the finger, as they lie on the axes of the touches [m]; parameters as in `on_finger`.

    Examples
    --------
    >>> import numpy as np
    >>> on_touches([[2e-3, 0.0]], origin=(10e-3, 5e-3), turn=np.pi / 2).round(6).tolist()
    [[0.01, 0.007]]
    """
    at = _check.real("positions", positions, unit="m", finite=False)
    return np.asarray((at if np.ndim(origin) == 0 or turn == 0 else at @ turned(turn).T) + np.asarray(origin))


def turned_square(square: FloatArray, pairs: Iterable[int], turn: float) -> FloatArray:
    """A covariance on axes that lie turned; NaN stays, and so does all of one with an infinite variance.

    Parameters
    ----------
    square : ndarray, shape (..., k, k)
        Of k unknowns.
    pairs : iterable of int
        The first of two unknowns each, along y and along z, that turn together.
    turn : float
        As in `turned` [rad].

    Examples
    --------
    >>> import numpy as np
    >>> turned_square(np.diag([4.0, 1.0, 9.0]), [0], np.pi / 2).round(6).tolist()
    [[1.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 9.0]]
    """
    whole = np.eye(square.shape[-1])
    for k in pairs:
        whole[k : k + 2, k : k + 2] = turned(turn)
    known = np.isfinite(square)
    left = np.isinf(square).any(axis=(-2, -1), keepdims=True)
    return np.where(known & ~left, whole @ np.where(known, square, 0.0) @ whole.T, square)
