"""The angle of the force on a side from a slope and a strain beneath it, or from gradients at two depths (memo)."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...contact import Hertz, LineLoad
from ...contact.families import Family, family_of
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger, finger_needed
from ...skin import Skin
from ...transducer import MeanPressure, NormalStrain, NormalStress, VolumeResistance
from .angle import BEYOND, MOST_STD, SideAngle, checked_bounds, checked_width
from .row import LEAST, Frames, Mask, count_of, stencil, unit_loads, unit_readings

__all__ = ["blind_depth", "side_angle_from_gradients", "side_angle_from_slope"]

_BLIND = 1e-9
"""A slope times the depth, beside the strain, that counts as none: rounding, and the skins' own errors."""
_SHALLOWEST, _DEEPEST, _SCAN = (1e-3, 20.0, 240)  # in half widths; the zero lies at 2 nu half widths as nu falls to 0
_STEP = 1e-4
_REACH, _COUNT = 0.5, 24
_THETA = np.pi * (np.arange(_COUNT) + 0.5) / _COUNT
_NODES = _REACH * np.cos(_THETA)


def _derivatives() -> FloatArray:
    """Weights (3, nodes) that make value, first and second derivative at 0 from values at the nodes.

    A strain at depth x is analytic in y up to a distance of x from the real axis, whatever presses. So a Chebyshev
    series over half a depth on either side converges as (2 + sqrt 5)^-nodes.
    """
    powers = np.arange(_COUNT)
    rows = []
    for order in range(3):
        series = [np.polynomial.Chebyshev.basis(j) for j in powers]
        at_0 = np.array([(s.deriv(order) if order else s)(0.0) for s in series])
        share = np.where(powers == 0, 1.0, 2.0) / _COUNT
        rows.append((share * at_0) @ np.cos(powers[:, None] * _THETA) / _REACH**order)
    return np.array(rows)


_DERIVATIVES = _derivatives()


class _Beneath(NamedTuple):
    """Beneath the centre: strain per N, slope per T times the depth, second derivative per N times its square."""

    strain: FloatArray
    slope: FloatArray
    bend: FloatArray

    @classmethod
    def of(cls, skin: Skin, family: Family, depth: FloatArray, half_width: FloatArray | None) -> _Beneath:
        x, a = np.broadcast_arrays(depth, 0.0 if half_width is None else half_width)
        width = None if half_width is None else a[..., None, None]
        strain = skin.strain(unit_loads(family, 0.0, width), x[..., None, None], (x[..., None] * _NODES)[..., None])
        press, drag = np.moveaxis(strain.xx, -1, 0)
        return cls(press @ _DERIVATIVES[0], drag @ _DERIVATIVES[1], press @ _DERIVATIVES[2])

    @property
    def blind(self) -> Mask:
        """Where there is no slope, whatever the drag."""
        return np.asarray(~(np.abs(self.slope) > _BLIND * np.abs(self.strain)))


def blind_depth(skin: Skin, half_width: npt.ArrayLike, family: str | Family = "hertz") -> FloatArray:
    """Depth at which the slope beneath the centre is zero at every angle: never put the sensors there.

    On a half plane it is also the depth of the largest strain beneath the centre, so that the gradient rule is blind
    there too (docs/limits.md).

    Parameters
    ----------
    skin : Skin
        Any.
    half_width : array_like, shape (...)
        Half width of the contact [m].
    family : {"hertz", "strip", "punch", "wedge"} or subclass of SpreadContact, optional
        What presses.

    Returns
    -------
    ndarray, shape (...)
        The shallowest such depth between 0.001 and 20 half widths [m]; NaN where there is none.

    Raises
    ------
    InvalidValueError
        A line load, which has no width; half_width <= 0.

    Examples
    --------
    >>> import subskin as ss
    >>> rubber = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.5))
    >>> blind_depth(rubber, half_width=1.0).round(6).item(), blind_depth(rubber, 1.0, "punch").round(6).item()
    (0.786151, 1.414214)
    """
    _check.noun("skin", skin, Skin, "finger.skin")
    kind = family_of(family)
    if issubclass(kind, LineLoad):
        rule = "it has no width, and on a half plane no blind depth"
        raise InvalidValueError("family = LineLoad", rule, "a family of some width, such as hertz")
    widths = _check.real("half_width", half_width, unit="m", above=0.0)
    out = [_shallowest_zero(skin, kind, float(a)) for a in widths.reshape(-1)]
    return _check.read_only(np.array(out, dtype=np.float64).reshape(widths.shape))


def _shallowest_zero(skin: Skin, family: Family, a: float) -> float:
    from scipy.optimize import brentq

    def slope(depth: npt.ArrayLike) -> FloatArray:
        return _Beneath.of(skin, family, np.asarray(depth, dtype=np.float64), np.asarray(a)).slope

    # a gauge at a rigid base reads nothing of a press, and the scan ends short of it
    stop = min(_DEEPEST * a, 0.99 * skin.thickness)
    depths = np.geomspace(min(_SHALLOWEST * a, 0.01 * stop), stop, _SCAN)
    signs = np.sign(slope(depths))
    change = np.flatnonzero(signs[1:] * signs[:-1] < 0)
    if not change.size:
        return np.nan
    return float(
        brentq(lambda x: float(slope(x)), depths[change[0]], depths[change[0] + 1], xtol=1e-13 * a, rtol=1e-12)
    )


def side_angle_from_slope(
    slope: npt.ArrayLike,
    strain: npt.ArrayLike,
    skin: Skin,
    family: str | Family = "hertz",
    *,
    depth: npt.ArrayLike,
    slope_std: npt.ArrayLike,
    strain_std: npt.ArrayLike,
    half_width: npt.ArrayLike | None = None,
    position_std: npt.ArrayLike = 0.0,
    half_width_std: npt.ArrayLike = 0.0,
    friction: float = 1.0,
    most_std: float = MOST_STD,
) -> SideAngle:
    """Angle of force from the strain eps_x beneath the centre of the contact and its slope along the surface.

    On an incompressible half plane under a Hertz contact of half width a, with s^2 = x^2 + a^2,

        tan(angle) = -(slope/strain) x (1 - x/s) / [1 - x (x^2 + 2 a^2)/s^3],

    in place of the memo's (20) to (22), whose alpha is -angle. Any other skin and contact answers in the same way. The
    centre is that of the contact; the largest strain lies elsewhere, and the slope is always 0 there.

    Parameters
    ----------
    slope, strain : array_like, shape (...)
        d eps_x/dy [1/m] and eps_x [-] beneath the centre; NaN where there is none.
    skin : Skin
        Any; only ratios of its moduli matter.
    family : {"line", "wedge", "hertz", "strip", "punch"} or subclass of SpreadContact, optional
        What presses, the drag being in proportion to the pressure.
    depth : array_like
        Where they were measured, x [m].
    slope_std, strain_std : array_like
        Their standard deviations [1/m], [-], taken to be independent.
    half_width : array_like
        Half width of the contact [m]; left out for a line load.
    position_std, half_width_std : array_like, optional
        How well the centre and the half width are known [m]; both go into the angle's standard deviation.
    friction, most_std
        As in `side_angle`.

    Returns
    -------
    SideAngle
        Fields of shape (...).

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; shapes that do not broadcast; a depth that the skin does not have.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.5))
    >>> more = {"depth": 2e-3, "half_width": 1e-3, "slope_std": 0.05, "strain_std": 1e-4}
    >>> told = side_angle_from_slope(slope=-2.0, strain=-0.01, skin=skin, **more)
    >>> round(float(told.angle), 3), round(float(told.std), 3), ss.Status(told.status).name
    (0.523, 0.012, 'OK')
    """
    _check.noun("skin", skin, Skin, "finger.skin")
    kind = family_of(family)
    x = _check.real("depth", depth, unit="m", above=0.0)
    a, width_std, known = checked_width(kind, half_width, half_width_std)
    rise = _check.real("slope", slope, unit="1/m", finite=False)
    value = _check.real("strain", strain, finite=False)
    rise_std = _check.real("slope_std", slope_std, unit="1/m", at_least=0.0)
    value_std = _check.real("strain_std", strain_std, at_least=0.0)
    position_std = _check.real("position_std", position_std, unit="m", at_least=0.0)
    bounds = checked_bounds(friction, most_std)
    stds = {"slope_std": rise_std, "strain_std": value_std, "position_std": position_std, "half_width_std": width_std}
    shape = _check.broadcast(slope=rise, strain=value, depth=x, half_width=known.astype(float), **stds)
    unit = _Beneath.of(skin, kind, x, a)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        to_drag = np.where(unit.blind, np.nan, x / unit.slope)
        normal, drag = value / unit.strain, rise * to_drag
        square = normal**2 + drag**2
        per_slope, per_strain = normal * to_drag / square, -drag / unit.strain / square
        per_position = per_slope * normal * unit.bend / x**2 + per_strain * rise
        per_width = np.zeros(shape)
        if a is not None:
            more, less = (_Beneath.of(skin, kind, x, a * (1 + side * _STEP)) for side in (1, -1))
            of_strain, of_slope = (np.log(m / n) / (2 * _STEP * a) for m, n in ((more[0], less[0]), (more[1], less[1])))
            per_width = normal * drag / square * (of_strain - of_slope)
        variance = (per_slope * rise_std) ** 2 + (per_strain * value_std) ** 2
        variance = variance + (per_position * position_std) ** 2 + (per_width * width_std) ** 2
        angle = np.arctan2(drag, normal)
        # a strain that is not beyond its own noise is no measure for the slope
        lost = np.abs(value) < BEYOND * value_std
        silent = (np.abs(value) <= BEYOND * value_std) & (np.abs(rise) <= BEYOND * rise_std)
    return SideAngle._judged(
        *(shape, angle, np.where(lost, np.inf, variance), per_position, per_width, 0.0),
        bounds=bounds,
        silent=silent,
        incomplete=~(np.isfinite(rise) & np.isfinite(value) & known),
    )


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
