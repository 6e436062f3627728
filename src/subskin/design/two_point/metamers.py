"""Metamers of two sensors: the single point that reads as two points do (memo section 7, Fig. 18)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Angle, Real, checked
from ...errors import GeometryError
from ...finger import Finger
from ...response import tabulate
from .._common import Found

__all__ = ["Metamers", "metamers"]

_NODES = 4
"""Positions looked at in each cell of the table: its polynomials of degree 4 do not turn unseen between them."""
_HALVINGS = 50


@dataclass(frozen=True, eq=False)
class Metamers(Found):
    """Single points that read like several on two sensors.

    Attributes
    ----------
    reading : ndarray, shape (..., 2)
        What the two sensors read under all the points, without offset [their unit].
    position, force : ndarray, shape (..., k)
        Position [m] and magnitude [N/m] of each single point that reads the same, from -y to +y; NaN where a touch has
        fewer than k. k is that of the touch with most, and at least 1.
    direction : ndarray, shape (...)
        atan2 of the second reading and the first [rad]: the ratio of the readings, with their signs.
    reach : (float, float)
        Directions between which the curve of a single point runs over the search [rad]; a turn of 2 pi or more has
        them all. A touch has a metamer exactly where its direction, or that and a whole turn, lies between them.
    """

    reading: FloatArray
    position: FloatArray
    force: FloatArray
    direction: FloatArray
    reach: tuple[float, float]

    @property
    def exist(self) -> npt.NDArray[np.bool_]:
        """Whether a touch has a metamer, shape (...)."""
        return np.asarray(np.isfinite(self.position).any(axis=-1))

    @property
    def in_reach(self) -> npt.NDArray[np.bool_]:
        """Whether the direction of a touch lies within `reach`, shape (...): the condition for a metamer."""
        low, high = self.reach
        turn = 2 * np.pi
        return np.asarray((self.direction - low) % turn <= high - low)


@checked
def metamers(
    finger: Finger,
    position: Annotated[npt.ArrayLike, Real("m")],
    force: Annotated[npt.ArrayLike, Real("N/m", at_least=0.0)] = 1.0,
    *,
    angle: Angle = 0.0,
    search: tuple[float, float] | None = None,
) -> Metamers:
    """Each single point that two sensors read as they read two points, or several; all at one known angle.

    A point at y of force P has the readings P v(y), v being the two receptive fields. As y goes along the skin v draws
    a curve in the plane of the readings; the sum of points is a chord's point, or beyond it. Every ray from the origin
    that meets the curve is a point's: a metamer exists where the ratio of the two readings, signs included, occurs on
    the curve, and it is found there, P from the length. Source: memo section 7, Fig. 18.

    Parameters
    ----------
    finger : Finger
        With two live sensors.
    position : array_like, shape (..., m)
        Positions of the points of each touch [m].
    force : array_like, shape (..., m), optional
        Their magnitudes [N/m], >= 0, one or more > 0.
    angle : float, optional
        Angle of all of them, and of the single point [rad]. Were it unknown, a whole curve of single points would do.
    search : (float, float), optional
        Where the single point is looked for [m]; 1.5 depths beyond the sensors if left out.

    Raises
    ------
    GeometryError
        A finger with other than two live sensors; shapes that do not match.
    InvalidValueError
        A force < 0, an angle that does not press.

    Examples
    --------
    Two points half a depth to either side of the middle, and the one that reads the same:

    >>> import subskin as ss
    >>> pair = ss.SensorArray(y=[-0.5e-3, 0.5e-3], depth=1e-3)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), pair)
    >>> same = ss.design.metamers(finger, position=[-0.5e-3, 0.5e-3], force=[10.0, 10.0])
    >>> (same.position * 1e3).round(6).tolist(), same.force.round(6).tolist()
    ([0.0], [20.833333])
    """
    live = finger.array.live
    if live.sum() != 2:
        seen = f"a finger with {int(live.sum())} live sensors"
        raise GeometryError(seen, "metamers are those of two", "Finger(skin, array.select([0, 1]))")
    positions, forces = np.atleast_1d(position), np.asarray(force)
    _check.broadcast(position=positions, force=forces)
    positions, forces = np.broadcast_arrays(positions, forces)
    if not (forces > 0).any(axis=-1).all():
        raise GeometryError("a touch without force", "one point or more has to press", "force=[10.0, 10.0]")
    if not abs(angle) < np.pi / 2:
        raise GeometryError(f"angle = {angle:.6g}", "has to press, between -pi/2 and pi/2", "angle=0.3")
    along = np.array([np.cos(angle), np.sin(angle)])
    table = tabulate(finger, search)

    def curve(y: FloatArray) -> FloatArray:
        return np.asarray(table(y)[..., live, :] @ along)

    single = finger.receptive_field(positions)[..., live, :] @ along
    reading = np.sum(forces[..., None] * single, axis=-2)
    grid = np.linspace(table.start, table.stop, _NODES * len(table.coefficients) + 1)
    found = _crossings(reading.reshape(-1, 2), curve, grid)
    v = curve(np.nan_to_num(found))
    flat = reading.reshape(-1, 1, 2)
    with np.errstate(invalid="ignore", divide="ignore"):
        size = np.sum(flat * v, axis=-1) / np.sum(v * v, axis=-1)
    pushes = np.isfinite(found) & (size > 0)
    order = np.argsort(~pushes, axis=1, kind="stable")
    most = max(int(pushes.sum(axis=1).max(initial=0)), 1)
    single_position, single_force = (
        np.take_along_axis(np.where(pushes, values, np.nan), order, axis=1)[:, :most].reshape(*reading.shape[:-1], most)
        for values in (found, size)
    )
    turned = np.unwrap(np.arctan2(*curve(grid).T[::-1]))
    direction = np.arctan2(reading[..., 1], reading[..., 0])
    reach = float(turned.min()), float(turned.max())
    return Metamers(reading, single_position, single_force, direction, reach)


def _crossings(reading: FloatArray, curve: Callable[[FloatArray], FloatArray], grid: FloatArray) -> FloatArray:
    """Positions (f, k) at which the curve is in line with each reading (f, 2), before or behind; the rest NaN."""
    across = _cross(reading[:, None, :], curve(grid))
    before, after = across[:, :-1], across[:, 1:]
    frame, cell = np.nonzero((before == 0) | (before * after < 0))
    low, high = grid[cell], grid[cell + 1]
    sign = np.sign(before[frame, cell])
    high = np.where(sign == 0, low, high)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        same = np.sign(_cross(reading[frame], curve(middle))) == sign
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    count = np.bincount(frame, minlength=len(reading))
    found = np.full((len(reading), max(int(count.max(initial=0)), 1)), np.nan)
    found[frame, np.arange(frame.size) - np.repeat(np.cumsum(count) - count, count)] = 0.5 * (low + high)
    return found


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
