"""The angle of the force on a side from two rows of sensors at two depths, without knowing the side (half plane)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...contact import Hertz, LineLoad
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger, finger_needed
from ...skin import Skin
from ...transducer import MeanPressure, NormalStrain, NormalStress, VolumeResistance
from .angle import BEYOND, MOST_STD, SideAngle, checked_bounds
from .row import LEAST, Frames, count_of, stencil, unit_readings
from .slope import blind_depth

__all__ = ["side_angle_from_gradients"]

_KINDS = (NormalStrain, NormalStress, MeanPressure, VolumeResistance)
"""Transducers that read one sign beneath every press, and nothing of a drag beneath its centre."""
_WIDTHS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0)
"""Half widths, in depths, over which the truncation is looked for."""
_NEAR_BLIND = 0.25


def side_angle_from_gradients(
    finger: Finger,
    readings: npt.ArrayLike,
    *,
    position: npt.ArrayLike,
    position_std: npt.ArrayLike = 0.0,
    sensors: int = 5,
    friction: float = 1.0,
    most_std: float = MOST_STD,
    false_alarm: float = 1e-6,
) -> SideAngle:
    """Angle of force from two rows of sensors at two depths, by tan(angle) = -(d eps_x/dy)/(d eps_x/dx).

    Beneath the centre of a symmetric contact whose drag is in proportion to its pressure this holds exactly on a half
    plane, for any Poisson's ratio, in plane strain and plane stress; width, shape, force and stiffness are not needed
    (docs/limits.md; the memo's alpha is -angle). It does not hold on layers. Both gradients vanish at the
    `blind_depth`. The centre has to be known as well as for `side_angle`; a contact that sticks misleads it more.

    Parameters
    ----------
    finger : Finger
        On a half plane, its sensors at two depths, of one kind: `NormalStrain`, `NormalStress`, `MeanPressure` or
        `VolumeResistance`.
    readings, position, position_std, sensors, friction, most_std, false_alarm
        As in `side_angle`; `sensors` of each row.

    Returns
    -------
    SideAngle
        `truncation` is the largest error that differences between sensors cause under Hertz contacts of half widths up
        to two depths, save within a quarter of the one that is blind; where it exceeds `most_std` too, no angle is
        given (AMBIGUOUS). `per_half_width` is 0.

    Raises
    ------
    InvalidValueError, GeometryError
        Another skin, another transducer, other than two depths, and as in `side_angle`.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> y = np.tile(0.5e-3 * np.arange(-3, 4), 2)
    >>> finger = ss.Finger(skin, ss.SensorArray(y=y, depth=np.repeat([1.6e-3, 2e-3], 7), noise=2e-5))
    >>> told = side_angle_from_gradients(finger, finger.read(ss.Hertz(40.0, 0.3, half_width=1e-3)), position=0.0)
    >>> round(float(told.angle), 3), round(float(told.std), 3), round(float(told.truncation), 3)
    (0.29, 0.004, 0.024)
    """
    finger_needed(finger)
    skin, array = finger.skin, finger.array
    fix = "side_angle of one row, with the half width, or finger.fit"
    if not skin.endless:
        raise InvalidValueError(f"a {type(skin).__name__} skin", "the gradient rule holds on a half plane alone", fix)
    kind = array.transducers[0]
    if not isinstance(kind, _KINDS):
        rule = f"the gradient rule takes one of {', '.join(k.__name__ for k in _KINDS)}"
        raise InvalidValueError(f"transducer {type(kind).__name__}", rule, fix)
    depth = np.asarray(array.depth)
    depths = np.unique(depth)
    if depths.size != 2:
        raise GeometryError(
            f"sensors at {depths.size} depths", "two rows are needed, each at one depth", "SensorArray(depth=[...])"
        )
    if any(np.unique(np.asarray(array.y)[depth == d]).size < (depth == d).sum() for d in depths):
        raise GeometryError(
            "two sensors at one position",
            "each has to have its own in its row",
            "finger.array.select(...) without one of them",
        )
    bounds = checked_bounds(friction, most_std)
    alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
    frames = Frames.of(finger, readings, position, position_std)
    rows = [frames.usable & (depth == d) for d in depths]
    upper, lower = (
        stencil(array, row, frames.position, count_of(sensors, int((array.live & (depth == d)).sum())))
        for row, d in zip(rows, depths, strict=True)
    )
    # The rule holds depth by depth, so between the rows for the slope's mean over depth. Weights in proportion to the
    # depth make it exactly from the two rows both where the slope is constant, far above the blind depth, and where it
    # falls as 1/depth^2, far beneath.
    shares = depths / depths.sum()
    along = shares[0] * upper[..., 1:, :] + shares[1] * lower[..., 1:, :]  # slope, bend
    across = (lower[..., :2, :] - upper[..., :2, :]) / np.diff(depths)  # of value, of slope
    weights = np.stack([-along[..., 0, :], across[..., 0, :]], axis=-2)
    moved = np.stack([-along[..., 1, :], across[..., 1, :]], axis=-2)
    middle = 0.5 * (upper[..., 0, :] + lower[..., 0, :])

    drag, press = np.moveaxis(np.einsum("...ln,...n->...l", weights, frames.measured), -1, 0)
    drag_moved, press_moved = np.moveaxis(np.einsum("...ln,...n->...l", moved, frames.measured), -1, 0)
    noise = frames.used_noise
    with np.errstate(divide="ignore", invalid="ignore"):
        square = drag**2 + press**2
        turned = press[..., None] * weights[..., 0, :] - drag[..., None] * weights[..., 1, :]
        per_position = (press * drag_moved - drag * press_moved) / square
        variance = ((turned * noise) ** 2).sum(axis=-1) / square**2 + (per_position * frames.position_std) ** 2
        angle = np.arctan(drag / press)
    # a gradient that is not beyond its own noise is steep or shallow by chance, and says so of neither
    lost = np.abs(press) < BEYOND * np.sqrt(((weights[..., 1, :] * noise) ** 2).sum(axis=-1))
    pressed = np.einsum("...n,...n->...", middle, frames.measured) * (1 if isinstance(kind, MeanPressure) else -1)
    truncation = _truncation(finger, skin, frames.position, weights, angle)
    return SideAngle._judged(
        *(frames.shape, angle, np.where(lost, np.inf, variance), per_position, 0.0, truncation),
        bounds=bounds,
        silent=~frames.beyond(np.empty((len(array), 0)), alarm),
        incomplete=np.minimum(*(row.sum(axis=-1) for row in rows)) < LEAST,
        wrong=pressed < -BEYOND * np.sqrt(((middle * noise) ** 2).sum(axis=-1)),
    )


@lru_cache(maxsize=16)
def _blind_depth(skin: Skin) -> float:
    """Of a Hertz contact of half width 1."""
    return float(blind_depth(skin, 1.0))


def _truncation(finger: Finger, skin: Skin, position: FloatArray, rule: FloatArray, angle: FloatArray) -> FloatArray:
    """Largest error of `rule` over the contacts of which it says this angle, the blind widths left out."""
    depth = float(np.asarray(finger.array.depth).mean())
    blind = depth / _blind_depth(skin)
    said = np.tan(angle)
    worst = np.zeros(angle.shape)
    for width in depth * np.array(_WIDTHS):
        if abs(width - blind) < _NEAR_BLIND * blind:
            continue
        family, half = (Hertz, np.asarray(width)) if width else (LineLoad, None)
        drag, press = np.moveaxis(rule @ unit_readings(finger, family, position, half), -2, 0)  # (..., 2 forces)
        with np.errstate(divide="ignore", invalid="ignore"):
            true = (said * press[..., 0] - drag[..., 0]) / (drag[..., 1] - said * press[..., 1])
        worst = np.fmax(worst, np.abs(np.arctan(true) - angle))
    return worst
