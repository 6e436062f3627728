"""What was found on an area, on the axes of the touches: moved and turned."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .._axes import on_touches, turned
from .estimate import Estimate

__all__ = ["moved"]


def moved(found: Estimate, origin: npt.ArrayLike, turn: float = 0.0) -> Estimate:
    """The same contacts on the axes of the touches: positions, drags, their covariance, and the rivals.

    Parameters
    ----------
    found : Estimate
        Of sensors on an area, on their own axes.
    origin : array_like, shape (2,)
        Where the finger's (0, 0) lies on the other axes [m].
    turn : float, optional
        By how much the finger's y lies turned from theirs, towards z [rad].

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=20.0)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> touch = ss.PointLoad(force=1.5, angle=0.3, azimuth=0.8, position=(1e-3, -2e-3))
    >>> found = moved(finger.locate(finger.read(touch)), origin=(10e-3, 20e-3), turn=np.pi / 2)
    >>> (found.position * 1e3).round(3).tolist(), round(float(found.load.azimuth - np.pi / 2), 3)
    ([12.0, 21.0], 0.8)
    """
    layout, table = found.layout, np.array(found.table)
    k, first = layout.unknowns, layout.components
    for at in (0, layout.rival):
        table[..., at : at + 2] = on_touches(table[..., at : at + 2], np.asarray(origin), turn)
        drag = slice(at + first + 1, at + first + 3)
        table[..., drag] = on_touches(table[..., drag], np.zeros(2), turn)
    if turn:
        whole = np.eye(k)
        whole[:2, :2] = whole[first + 1 : first + 3, first + 1 : first + 3] = turned(turn)
        square = table[..., layout.square]
        known = np.isfinite(square)  # an infinite variance stays where it is
        all_known = np.asarray(known.all(axis=(-2, -1)))[..., None, None]
        out = np.where(all_known, whole @ np.where(known, square, 0.0) @ whole.T, square)
        upper = np.triu_indices(k)
        table[..., layout.covariance : layout.covariance + k * (k + 1) // 2] = out[(..., *upper)]
    return Estimate(table, found.used, found.friction, found.unknowns, layout, found.relative)
