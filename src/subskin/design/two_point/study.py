"""The least separation of two points over sensors and their noise; and metamers, single points that read like two."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Angle, Real, checked
from ...array import SensorArray
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...response import tabulate
from .._common import Found, listed, stretch
from ..touches import Touches
from .limen import Against, two_point_limen

__all__ = ["Metamers", "TwoPointStudy", "metamers", "two_point_study"]

_PITCHES = (0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0, 1.25, 1.5, 2.0)


@dataclass(frozen=True, eq=False)
class TwoPointStudy(Found):
    """What `two_point_study` found. Arrays of shape (c, k, s, m): count, depth, pitch, noise.

    Attributes
    ----------
    finger : Finger
        Whose skin and kind of sensor it is.
    touches : Touches
    against : {"point", "wide"}
    count : ndarray of int, shape (c,)
        Numbers of sensors.
    depth : ndarray, shape (k,)
        Their depths [m].
    pitch : ndarray, shape (s,)
        Their pitches, in depths [-].
    noise : ndarray, shape (m,)
        Noise, as a share of the largest reading under one point of the whole force, square to the skin [-].
    worst, median : ndarray, shape (c, k, s, m)
        Least separation that reads as two, the worst and the median over the touches [m]; infinite where none does.
    """

    finger: Finger
    touches: Touches
    against: Against
    count: npt.NDArray[np.int_]
    depth: FloatArray
    pitch: FloatArray
    noise: FloatArray
    worst: FloatArray
    median: FloatArray

    @checked
    def best(self, slack: Annotated[float, Real(at_least=0.0)] = 0.25) -> FloatArray:
        """The best pitch, and the range around it that is nearly as good, in depths, shape (c, k, m, 3).

        Best pitch, least and largest of those pitches, without a gap, whose worst separation is larger by a share
        of `slack` at most; NaN where no pitch serves.
        """
        worst = np.moveaxis(self.worst, 2, -1)
        out = np.full((*worst.shape[:-1], 3), np.nan)
        for index in np.ndindex(worst.shape[:-1]):
            row = worst[index]
            at = int(np.argmin(row))
            if np.isfinite(row[at]):
                out[index] = self.pitch[[at, *stretch(row <= (1 + slack) * row[at], at)]]
        return out


@checked
def two_point_study(
    finger: Finger,
    touches: Touches,
    *,
    count: npt.ArrayLike = (3, 4, 5, 6, 8),
    pitch: npt.ArrayLike = _PITCHES,
    depth: npt.ArrayLike | None = None,
    noise: npt.ArrayLike = (1e-4, 1e-3, 1e-2),
    against: Against = "point",
    progress: Callable[[], object] | None = None,
    **options: Any,
) -> TwoPointStudy:
    """`two_point_limen` of even rows in one skin, over their count, depth and pitch, and over the noise.

    On a half plane lengths scale with the depth, and the noise counts as a share of the largest reading: one depth says
    all. Layers and a round finger have lengths of their own.

    Parameters
    ----------
    finger : Finger
        The skin; transducer, gain and width of the first sensor, and the middle of the row, are those of each row.
    touches : Touches
        As in `two_point_limen`. Without a span each row is tried from its own first sensor to its last.
    count : array_like of int, shape (c,), optional
        Numbers of sensors, >= 2.
    pitch : array_like, shape (s,), optional
        Pitches, ascending [depths].
    depth : array_like, shape (k,), optional
        Depths [m]; the mean of the finger's own if left out.
    noise : array_like, shape (m,), optional
        Noise as a share of the largest reading under one point of the whole force, square to the skin.
    against : {"point", "wide"}, optional
        The rival of two points.
    progress : callable, optional
        Called after each row.
    **options
        Others of `two_point_limen`.

    Raises
    ------
    InvalidValueError, GeometryError, NotLinearError
        As in `two_point_limen`; a count < 2.

    Examples
    --------
    >>> import subskin as ss
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray(y=[0.0], depth=2e-3))
    >>> touches = ss.design.Touches(force=20.0, span=(-2e-3, 2e-3))
    >>> study = ss.design.two_point_study(
    ...     finger, touches, count=6, pitch=[0.25, 0.5, 1.0, 2.0], noise=1e-3, shares=[0.5]
    ... )
    >>> (study.worst[0, 0, :, 0] * 1e3).round(2).tolist(), study.best()[0, 0, 0].tolist()
    ([0.41, 0.21, 0.4, 0.91], [0.5, 0.5, 0.5])
    """
    counts = listed("count", count, at_least=2.0)
    if not (counts == np.round(counts)).all():
        raise InvalidValueError(f"count = {count!r}", "whole numbers are needed", "count=(3, 4, 6)")
    ratios = listed("pitch", pitch, above=0.0)
    if not (np.diff(ratios) > 0).all():
        raise InvalidValueError(f"pitch = {pitch!r}", "has to ascend", "pitch=(0.25, 0.5, 1.0)")
    own = float(np.asarray(finger.array.depth).mean())
    depths = listed("depth", own if depth is None else depth, "m", above=0.0)
    shares = listed("noise", noise, above=0.0)
    worst = np.empty((counts.size, depths.size, ratios.size, shares.size))
    median = np.empty_like(worst)
    for k, at in enumerate(depths):
        full = touches.force * _largest(finger, float(at))
        for c, s in np.ndindex(counts.size, ratios.size):
            row = _row(finger, int(counts[c]), float(ratios[s] * at), float(at), full * float(shares[0]))
            found = two_point_limen(row, touches, against=against, **options)
            for m, share in enumerate(shares):
                there = found if m == 0 else found.with_noise(float(share / shares[0]))
                worst[c, k, s, m], median[c, k, s, m] = there.worst, there.median
            if progress is not None:
                progress()
    return TwoPointStudy(finger, touches, against, counts.astype(int), depths, ratios, shares, worst, median)


def _row(finger: Finger, count: int, pitch: float, depth: float, noise: float) -> Finger:
    """An even row of sensors like the finger's first, in its skin."""
    a = finger.array
    array = SensorArray.line(
        count, pitch, depth, centre=float(np.asarray(a.y).mean()), transducer=a.transducers[0],
        gain=np.asarray(a.gain)[0], width=np.asarray(a.width)[0], noise=noise,
    )  # fmt: skip
    return Finger(finger.skin, array)


def _largest(finger: Finger, depth: float) -> float:
    """Largest reading of such a sensor under a unit normal line load."""
    one = _row(finger, 1, 1.0, depth, 0.0)
    table = tabulate(one)
    positions = np.linspace(table.start, table.stop, 4 * len(table.coefficients) + 1)
    return float(np.abs(table(positions)[..., 0]).max())


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
    >>> ((same.position * 1e3).round(6) + 0.0).tolist(), same.force.round(6).tolist()
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
