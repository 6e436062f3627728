"""The angle of the force on a side whose centre and width are known, from the sensors beneath it.

The memo's quick way (section 5): beneath the centre the normal force alone makes the strain, and the drag alone its
slope along the surface; so both forces follow, and the angle from their ratio. Slope and strain are those of the
polynomial through the nearest sensors. Half a depth apart these are too far from each other for that, and the slope
comes out up to a third short. So it is compared with what the same polynomial makes of the contact's own readings, and
nothing is cut off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._frozen import Result
from ...contact import LineLoad
from ...contact.families import Family, family_of
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger, finger_needed
from ..answer import Status
from .row import LEAST, Changes, Frames, Mask, count_of, known_only, stencil

__all__ = ["MOST_STD", "SideAngle", "side_angle"]

MOST_STD = float(np.deg2rad(10.0))
"""Standard deviation of tan(angle) above which no angle is given, if nothing else is asked for: 10 degrees."""

BEYOND = 5.0
"""Standard deviations by which an angle has to lie outside the friction cone to be called unexplained."""

_LEVEL = 0.1
"""Depths in a row may differ by so much of their mean."""


@dataclass(frozen=True, eq=False)
class SideAngle(Result):
    """Angle of force found from a slope; every field has the batch's shape (...).

    Parameters
    ----------
    angle : ndarray
        Angle from the inward normal [rad], positive where it drags the skin towards +y; NaN unless `status` is OK.
    std : ndarray
        Its standard deviation [rad]; infinite at the blind depth.
    status : ndarray of int8
        `Status`. AMBIGUOUS: the readings leave the angle open, as near the blind depth (`most_std`). UNEXPLAINED: the
        load pulls or leans out of the friction cone, or the contact cannot make such readings. INCOMPLETE: too few
        sensors, or a position or width that is NaN.
    per_position : ndarray
        Change of the angle with the assumed centre of the contact [rad/m]. This is what usually limits it.
    per_half_width : ndarray
        Change of the angle with the assumed half width [rad/m].
    truncation : ndarray
        Largest systematic error [rad] that differences between sensors cause; 0 where they are allowed for.
    """

    angle: FloatArray
    std: FloatArray
    status: npt.NDArray[np.int8]
    per_position: FloatArray
    per_half_width: FloatArray
    truncation: FloatArray

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch."""
        return self.angle.shape

    @classmethod
    def _judged(
        cls,
        shape: tuple[int, ...],
        angle: FloatArray,
        variance: FloatArray,
        *others: FloatArray | float,
        bounds: tuple[float, float],
        silent: Mask,
        incomplete: Mask,
        wrong: Mask | bool = False,
    ) -> SideAngle:
        """Each frame's status; what cannot be stood by is taken back. `bounds`: steepest angle, largest std."""
        steepest, most_std = bounds
        with np.errstate(invalid="ignore"):
            std = np.where(np.isfinite(angle), np.sqrt(variance), np.inf)
            # of the tangent: that of the angle shrinks where chance has made it steep, and would let it pass
            steep = std / np.cos(angle) ** 2
        lean, std, steep, per_position, per_half_width, truncation = (
            np.array(np.broadcast_to(v, shape)) for v in (angle, std, steep, *others)
        )
        status = np.full(shape, Status.OK, dtype=np.int8)
        for kind, where in (
            (Status.UNEXPLAINED, np.abs(lean) > steepest + BEYOND * std),
            (Status.AMBIGUOUS, ~(np.maximum(steep, truncation) <= most_std)),
            (Status.UNEXPLAINED, wrong),
            (Status.NO_CONTACT, silent),
            (Status.INCOMPLETE, incomplete),
        ):
            status[np.broadcast_to(where, shape)] = kind
        lean[status != Status.OK] = np.nan
        for values in (std, per_position, per_half_width, truncation):
            values[status >= Status.NO_CONTACT] = np.nan
            values.flags.writeable = False
        lean.flags.writeable = status.flags.writeable = False
        return cls(lean, std, status, per_position, per_half_width, truncation)


def checked_bounds(friction: float, most_std: float) -> tuple[float, float]:
    """Steepest angle of the friction cone, and the largest standard deviation accepted [rad]; may be infinite."""
    most = _check.scalar("most_std", most_std, unit="rad", above=0.0, finite=False, fix="most_std=np.deg2rad(10)")
    return float(np.arctan(_check.friction(friction))), most


def checked_width(
    family: Family, half_width: npt.ArrayLike | None, std: npt.ArrayLike
) -> tuple[FloatArray | None, FloatArray, Mask]:
    """The half width of a contact that has one, its standard deviation, and where both are known."""
    if issubclass(family, LineLoad):
        if half_width is not None or np.any(np.asarray(std) != 0):
            raise InvalidValueError(f"half_width = {half_width!r} of a line load", "it has none", "leave it out")
        return None, np.zeros(()), np.array(True)
    if half_width is None:
        rule = "the slope gives the angle only where the half width is known"
        fix = "half_width=1e-3, side_angle_from_gradients on a half plane, or finger.fit, which finds it"
        raise InvalidValueError(f"half_width = None of a {family.__name__}", rule, fix)
    width, spread, known = known_only(half_width=half_width, half_width_std=std)
    _check.real("half_width", np.where(known, width, 1.0), unit="m", above=0.0)
    return np.where(known, width, 1.0), spread, known


def side_angle(
    finger: Finger,
    readings: npt.ArrayLike,
    family: str | Family = "hertz",
    *,
    position: npt.ArrayLike,
    half_width: npt.ArrayLike | None = None,
    position_std: npt.ArrayLike = 0.0,
    half_width_std: npt.ArrayLike = 0.0,
    sensors: int = 5,
    friction: float = 1.0,
    most_std: float = MOST_STD,
    false_alarm: float = 1e-6,
) -> SideAngle:
    """Angle of force on a contact whose position and width are known, from value and slope of the strain beneath it.

    The memo's quick way (section 5) on a row of sensors, any skin and any transducer. It needs the centre: an error of
    a hundredth of a depth turns the angle by some 3 degrees (`per_position`). The position of the largest strain will
    not do, because the slope is always 0 there. Find the centre with `finger.fit`, or by symmetry while nothing drags.
    Where centre and half width are unknown use `finger.fit`. A contact that sticks, its drag not in proportion to the
    pressure, misleads both (docs/limits.md).

    Parameters
    ----------
    finger : Finger
        One row of sensors of one kind.
    readings : array_like, shape (..., n)
        Raw readings, each in units of its gain; NaN marks a missing one.
    family : {"line", "wedge", "hertz", "strip", "punch"} or subclass of SpreadContact, optional
        What presses, the drag being in proportion to the pressure.
    position : array_like, shape (...)
        Centre of the contact y [m]; NaN where it is unknown.
    half_width : array_like, shape (...)
        Half width of the contact [m], NaN where it is unknown; left out for a line load.
    position_std, half_width_std : array_like, optional
        How well these are known [m], apart from this frame's noise; they go into the angle's standard deviation.
    sensors : int, optional
        Number of sensors nearest the centre whose polynomial gives value and slope, >= 3.
    friction : float, optional
        Coefficient of friction: an angle well beyond its cone is UNEXPLAINED.
    most_std : float, optional
        Standard deviation of tan(angle) above which no angle is given (AMBIGUOUS), as near the blind depth. It is that
        of the angle [rad] where the force leans little, and does not shrink where chance has made it steep.
    false_alarm : float, optional
        Chance with which noise is called a contact, or readings of that contact UNEXPLAINED. For the latter all sensors
        are asked; where `position_std` or `half_width_std` is not 0, errors of these are let pass.

    Returns
    -------
    SideAngle
        Fields of shape (...).

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range, shapes that do not broadcast, sensors of several kinds, depths, or without noise.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=7, pitch=1e-3, depth=2e-3, noise=2e-5))
    >>> readings = finger.read(ss.Hertz(force=40.0, angle=0.3, half_width=1e-3))
    >>> told = side_angle(finger, readings, position=0.0, half_width=1e-3)
    >>> round(float(told.angle), 6), round(float(told.std), 4)
    (0.3, 0.0033)
    """
    finger_needed(finger)
    kind = family_of(family)
    width, width_std, known = checked_width(kind, half_width, half_width_std)
    bounds = checked_bounds(friction, most_std)
    alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
    array, depth = finger.array, np.asarray(finger.array.depth)
    if np.unique(np.asarray(array.y)).size < len(array) or np.ptp(depth) > _LEVEL * depth.mean():
        rule = "a slope takes sensors in one row"
        fix = "ss.Finger(finger.skin, finger.array.select(...)), or side_angle_from_gradients for two rows"
        raise GeometryError(f"{len(array)} sensors at depths from {depth.min():.6g} to {depth.max():.6g} m", rule, fix)
    frames = Frames.of(finger, readings, position, position_std)
    _check.broadcast(frames=np.empty(frames.shape), half_width=known.astype(float), half_width_std=width_std)
    shape = np.broadcast_shapes(frames.shape, known.shape, width_std.shape)

    count = count_of(sensors, int(array.live.sum()))
    local = stencil(array, frames.usable, frames.position, count)[..., :2, :]
    made = Changes.of(finger, kind, frames.position, width)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        to_forces = _inverse(local @ made.unit) @ local  # (..., 2, n)
        forces = np.einsum("...ln,...n->...l", to_forces, frames.measured)
        normal, drag = forces[..., 0], forces[..., 1]
        turn = np.stack([-drag, normal], axis=-1) / (normal**2 + drag**2)[..., None]
        per_reading = np.einsum("...l,...ln->...n", turn, to_forces)
        per_position, per_width = (
            -np.einsum("...n,...nl,...l->...", per_reading, change, forces) for change in made[1:]
        )
        variance = ((per_reading * frames.used_noise) ** 2).sum(axis=-1)
        variance = variance + (per_position * frames.position_std) ** 2 + (per_width * width_std) ** 2
        angle = np.arctan2(drag, normal)
        # a normal force that is not beyond its own noise is no measure for the drag
        lost = np.abs(normal) < BEYOND * np.sqrt(((to_forces[..., 0, :] * frames.used_noise) ** 2).sum(axis=-1))
    columns = [made.unit]
    columns += [made.by_position] if (frames.position_std > 0).any() else []
    columns += [made.by_width] if (width_std > 0).any() else []
    return SideAngle._judged(
        *(shape, angle, np.where(lost, np.inf, variance), per_position, per_width, 0.0),
        bounds=bounds,
        silent=~frames.beyond(made.unit[..., :0], alarm),
        incomplete=(frames.usable.sum(axis=-1) < LEAST) | ~known,
        wrong=frames.beyond(np.concatenate(columns, axis=-1), alarm),
    )


def _inverse(m: FloatArray) -> FloatArray:
    """Of matrices (..., 2, 2), infinite or NaN where there is none."""
    determinant = m[..., 0, 0] * m[..., 1, 1] - m[..., 0, 1] * m[..., 1, 0]
    turned = np.stack([m[..., 1, 1], -m[..., 0, 1], -m[..., 1, 0], m[..., 0, 0]], axis=-1)
    return np.asarray((turned / determinant[..., None]).reshape(m.shape))
