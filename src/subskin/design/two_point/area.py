"""Two touches or one on an area, and the direction of an edge: what an array resolves beside a single touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Length, checked
from ...errors import InvalidValueError
from ...finger import Finger
from ...radial import tabulate_radial
from .._common import Count, Found, Seed, Several, noise_of
from ..placement.asked import Told
from ..touches import Touches
from .limen import distance_needed, from_which_on

__all__ = ["AreaLimen", "edge_direction", "two_point_area"]

_STEPS, _NEAREST, _FARTHEST = 12, 0.1, 4.0
"""Distances of two touches that are tried, and the nearest and farthest of them [least depths]."""
_NODES = 16
"""Points of which an edge is made."""


@dataclass(frozen=True, eq=False)
class AreaLimen(Found):
    """What `two_point_area` found, of k pairs.

    Attributes
    ----------
    finger : Finger
    touches : Touches
    position : ndarray, shape (k, 2)
        Middle of each pair (y, z) [m], moved in where one touch would else leave the area.
    azimuth : ndarray, shape (k,)
        Direction from one touch to the other, from +y towards +z [rad].
    separation : ndarray, shape (k,)
        Distance from which on a pair reads as two [m]; infinite where it does not up to the largest that was tried.
    largest : float
        That distance [m].
    needed : float
        Distance from the readings of the best single touch that is noticed, in units of noise.
    """

    finger: Finger
    touches: Touches
    position: FloatArray
    azimuth: FloatArray
    separation: FloatArray
    largest: float
    needed: float


@checked
def two_point_area(
    finger: Finger,
    touches: Touches,
    *,
    pairs: Count = 60,
    power: float = 0.9,
    false_alarm: float = 0.01,
    largest: Length | None = None,
    search: Any = None,
    rng: Seed = 0,
) -> AreaLimen:
    """From which distance on two touches on an area read as two, and not as one.

    The two share the force and press straight down. They read as two where the best single touch of the kind, located
    as `fit` does, leaves so large a chi-square that a test of it with so many `false_alarm` has the `power`: as
    `two_point_limen` has it for rows.

    Parameters
    ----------
    finger : Finger
        With the noise of its sensors.
    touches : Touches
        On an area; its half width is that of each touch.
    pairs : int, optional
        Pairs drawn at random, of any direction; both touches lie on the area, where that is wide enough.
    power, false_alarm : float, optional
        Share of frames of two that read as two, and of frames of one that do.
    largest : float, optional
        Largest distance that is tried [m]; four least depths, or the shorter side of the area if that is less.
    search : optional
        Where a single touch is looked for [m], as in `Finger.locate`.
    rng : Generator or int, optional
        Random generator of the pairs, or its seed.

    Raises
    ------
    InvalidValueError, GeometryError
        Touches without an area; a share out of range; sensors that do not tell a single touch.

    Examples
    --------
    >>> import subskin as ss
    >>> from subskin.design.two_point import two_point_area
    >>> array = ss.SensorArray.grid((4, 4), pitch=2e-3, depth=2e-3, noise=1e-4)
    >>> touches = ss.design.Touches(force=1.0, friction=0.5, area=((-2e-3, 2e-3), (-2e-3, 2e-3)))
    >>> found = two_point_area(ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array), touches, pairs=20)
    >>> bool(0.2e-3 < np.quantile(found.separation, 0.95) < 0.4e-3)
    True
    """
    box = _area(touches)
    depth = float(np.asarray(finger.array.depth).min())
    usual = min(_FARTHEST * depth, float(np.ptp(box, axis=1).min()))
    far = usual if largest is None else largest
    drawn = _check.random(rng)
    middle = drawn.uniform(box[:, 0], box[:, 1], (pairs, 2))
    azimuth = drawn.uniform(0.0, np.pi, pairs)
    along = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    step = np.geomspace(min(_NEAREST * depth, 0.5 * far), far, _STEPS)
    down = np.array([0.5 * touches.force, 0.0, 0.0])
    family = "line" if touches.half_width is None else "round_hertz"
    options: dict[str, Any] = {} if search is None else {"search": search}

    def distances(separation: FloatArray, which: npt.NDArray[np.intp]) -> FloatArray:
        """From the readings of some pairs (k,) so far apart (s, k) to those of the best single one, in noises."""
        half = 0.5 * separation[..., None] * along[which]
        inside = np.minimum(np.abs(half), 0.5 * np.ptp(box, axis=1))
        centre = np.clip(middle[which], box[:, 0] + inside, box[:, 1] - inside)
        pressed = [finger.measure(touches.contact(down, centre + side * half), linear=True) for side in (-1, 1)]
        readings = np.asarray(finger.array.gain) * (pressed[0] + pressed[1]) + np.asarray(finger.array.offset)
        found = finger.fit(readings, family, friction=touches.friction, **options)
        return np.sqrt(np.nan_to_num(np.asarray(found.residual), nan=0.0))

    spare = int(finger.array.live.sum()) - (5 if touches.half_width is None else 6)
    needed = distance_needed(spare, power, false_alarm, "fit")
    distance = distances(np.broadcast_to(step[:, None], (step.size, pairs)), np.arange(pairs))
    separation = from_which_on(step, distance, needed, distances)
    return AreaLimen(finger, touches, middle, azimuth, separation, far, needed)


@checked
def edge_direction(
    finger: Finger, touches: Touches, length: Length, *, positions: Several = 7, directions: Count = 6
) -> FloatArray:
    """How well the direction of a straight edge is found: its Cramer-Rao bounds [rad], shape (p, p, directions).

    The edge is a line of so much `length` on which the force of the touches, straight down, is spread evenly; its
    position, direction and all components of its force are unknown.

    Parameters
    ----------
    finger : Finger
        With the noise of its sensors.
    touches : Touches
        On an area, over which the edge's middle lies.
    length : float
        Length of the edge [m], > 0.
    positions, directions : int, optional
        How many along each side, and how many over half a turn.

    Returns
    -------
    ndarray, shape (p, p, directions)
        Standard deviations [rad]; infinite where the readings leave it open.

    Raises
    ------
    InvalidValueError, GeometryError
        Touches without an area, a length that is not > 0, sensors without noise.

    Examples
    --------
    The direction of a longer edge is found better.

    >>> import subskin as ss
    >>> from subskin.design.two_point import edge_direction
    >>> array = ss.SensorArray.grid((4, 4), pitch=2e-3, depth=2e-3, noise=1e-4)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> touches = ss.design.Touches(force=1.0, area=((-2e-3, 2e-3), (-2e-3, 2e-3)))
    >>> short, long = (np.median(edge_direction(finger, touches, length)) for length in (2e-3, 6e-3))
    >>> bool(long < 0.3 * short)
    True
    """
    box = _area(touches)
    array = finger.array.select(finger.array.live)
    noise = noise_of(array)
    ends = np.stack([box[:, 0] - 0.5 * length, box[:, 1] + 0.5 * length], axis=-1)
    reach = float(np.hypot(*np.abs(ends[None] - array.points[:, :, None]).max(axis=(0, 2))))
    table = tabulate_radial(Finger(finger.skin, array), reach)
    y, z = (np.linspace(low, high, positions) for low, high in box)
    at = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1)[:, :, None, None]
    turn = np.pi * (np.arange(directions) + 0.25) / directions
    t, weight = np.polynomial.legendre.leggauss(_NODES)
    offset = 0.5 * length * t[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)[:, None]  # (d, nodes, 2)
    across = 0.5 * length * t[:, None] * np.stack([-np.sin(turn), np.cos(turn)], axis=-1)[:, None]
    where = at + offset
    share = 0.5 * weight[:, None, None]
    unit = (share * table(where)).sum(axis=3)  # (p, p, d, n, 3)
    slopes = touches.force * table.slopes(where)[..., 0, :]  # of a load straight down
    moved = (share * slopes).sum(axis=3)
    turned = (share[..., 0] * (slopes * across[:, :, None]).sum(axis=-1)).sum(axis=3)
    depth = float(np.asarray(array.depth).min())
    units = np.array([depth, depth, 1.0, *[touches.force] * 3])
    jacobian = np.concatenate([moved, turned[..., None], unit], axis=-1) / noise[:, None]
    told = Told.of(np.swapaxes(jacobian, -1, -2) @ jacobian, units)
    return _check.read_only(np.sqrt(np.maximum(told.covariance[..., 2, 2], 0.0)))


def _area(touches: Touches) -> FloatArray:
    _check.noun("touches", touches, Touches, "design.Touches(force=1.0, area=((-5e-3, 5e-3), (-5e-3, 5e-3)))")
    if touches.area is None:
        fix = "Touches(1.0, area=((-5e-3, 5e-3), (-5e-3, 5e-3)))"
        raise InvalidValueError("touches without an area", "local touches are needed", fix)
    return np.asarray(touches.area)
