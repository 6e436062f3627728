"""Readings -> where, how hard, at what angle (and how wide): any number of sensors, any response, any family."""

from __future__ import annotations

from typing import Any, Never

import numpy as np
import numpy.typing as npt

from .. import _check
from ..contact import Hertz, LineLoad
from ..contact.families import Family, family_of
from ..errors import InvalidValueError
from ..finger import Finger
from ..prepared import prepared
from ..response import Response, tabulate
from .beyond import beyond
from .estimate import Estimate
from .search import Locator
from .stick_locator import StickLocator, checked_stick

__all__ = ["fit", "locate", "locator"]

_OPTIONS = "search, half_width, normal_force, friction, scan_step, false_alarm, ambiguity, outliers, stick"


def locator(
    finger: Finger,
    family: str | Family = "line",
    *,
    search: tuple[float, float] | None = None,
    half_width: tuple[float, float] | None = None,
    normal_force: tuple[float, float] | None = None,
    friction: float = 1.0,
    scan_step: float | None = None,
    false_alarm: float = 1e-6,
    ambiguity: float = 13.8,
    outliers: int = 0,
    stick: float | tuple[float, float] | None = None,
    **_unknown: Never,
) -> Locator:
    """A `Locator` of a finger, prepared once for many calls; as `finger.locator(...)` too.

    Parameters
    ----------
    finger : Finger
        The forward model, with the sensors' noise.
    family : {"line", "wedge", "hertz", "strip", "punch"} or class of contacts, optional
        What presses, the drag being in proportion to the pressure.
    search : (float, float), optional
        Range of positions y [m]; contacts outside are taken to be impossible. The default reaches 1.5 depths beyond the
        outermost sensors, and a load further out that explains a frame as well makes it AMBIGUOUS.
    half_width : (float, float), optional
        Least and largest half width [m]; 0 to 1.5 depths of the shallowest sensor if left out. A line has none.
    normal_force, friction, scan_step, false_alarm, ambiguity, outliers
        As in `Locator`.
    stick : float or (float, float), optional
        Of "hertz" alone: the contact sticks in its middle by this coefficient of friction mu [-], known or a range, as
        in `StickLocator`. `friction` bounds the search; this one shapes the drag.

    Raises
    ------
    InvalidValueError, GeometryError
        An unknown family, ends out of order, sensors without noise, an option that does not exist.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-5))
    >>> ss.locator(finger, friction=0.5).friction
    0.5
    """
    if _unknown:
        _check.no_options(_unknown, _OPTIONS)
    kind = family_of(family)
    ends = _check.ends("search", search, "search=(-5e-3, 5e-3)")
    widths = _check.ends("half_width", half_width, "half_width=(0.0, 3e-3)")
    forces = _check.ends("normal_force", normal_force, "normal_force=(1.0, 100.0)")
    held = None if stick is None else checked_stick(stick)
    if held is not None and kind is not Hertz:
        fix = "leave it out: a flat sticks all over until it slides, and a line has no width"
        raise InvalidValueError(f"stick = {stick!r} of a {kind.__name__}", 'only "hertz" knows its zone of stick', fix)
    values: dict[str, Any] = _check.values(
        friction=friction, scan_step=scan_step, false_alarm=false_alarm, ambiguity=ambiguity, outliers=outliers
    )

    def make() -> Locator:
        table = tabulate(finger, ends)
        more: dict[str, Any] = {**values, "normal_force": forces}
        if ends is None:
            more["beyond"] = beyond(finger, table)
        if issubclass(kind, LineLoad):
            if widths is not None:
                raise InvalidValueError(f"half_width = {half_width!r} of a line load", "it has none", "leave it out")
            return Locator(table, finger.array, **more).allow_for(finger, friction)
        low, high = widths or (0.0, 1.5 * float(np.asarray(finger.array.depth).min()))
        response = Response.of(finger, kind, (table.start, table.stop), max(high, 1e-3 * table.step))
        more["half_width"] = (low, high)
        if held is not None:
            return StickLocator(response, finger.array, held, **more).allow_for(finger, friction)
        return Locator(response, finger.array, **more).allow_for(finger, friction)

    return prepared(finger).get(("locator", kind, ends, widths, forces, held, *values.values()), make)


def locate(
    finger: Finger,
    readings: npt.ArrayLike,
    *,
    search: tuple[float, float] | None = None,
    normal_force: tuple[float, float] | None = None,
    friction: float = 1.0,
    scan_step: float | None = None,
    false_alarm: float = 1e-6,
    ambiguity: float = 13.8,
    outliers: int = 0,
    **_unknown: Never,
) -> Estimate:
    """Where, how hard and at what angle a line load presses; as `finger.locate(readings)` too.

    The locator is prepared on the first call and kept, so later calls with the same options cost little more than the
    search.

    Parameters
    ----------
    finger : Finger
        The forward model, with the sensors' noise.
    readings : array_like, shape (..., n)
        Raw readings, each in units of its gain; NaN marks a missing one.
    search, normal_force, friction, scan_step, false_alarm, ambiguity, outliers
        As in `locator`.

    Returns
    -------
    Estimate
        Position [m], force [N/m], angle [rad], covariance, rival, residual and status, each of shape (...).

    Raises
    ------
    InvalidValueError, GeometryError
        As in `locator`; a last axis that is not the number of sensors.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-5))
    >>> found = ss.locate(finger, finger.read(ss.LineLoad(force=40.0, angle=0.3, position=0.8e-3)))
    >>> ss.Status(found.status).name, round(float(found.position) * 1e3, 4)
    ('OK', 0.8)
    """
    if _unknown:
        _check.no_options(_unknown, _OPTIONS.replace("half_width, ", "").replace(", stick", ""))
    return _quick(
        finger, "line", search, None, normal_force, friction, scan_step, false_alarm, ambiguity, outliers, None
    )(readings)


def fit(
    finger: Finger,
    readings: npt.ArrayLike,
    family: str | Family = "hertz",
    *,
    search: tuple[float, float] | None = None,
    half_width: tuple[float, float] | None = None,
    normal_force: tuple[float, float] | None = None,
    friction: float = 1.0,
    scan_step: float | None = None,
    false_alarm: float = 1e-6,
    ambiguity: float = 13.8,
    outliers: int = 0,
    stick: float | tuple[float, float] | None = None,
    **_unknown: Never,
) -> Estimate:
    """A contact of one family: where, how hard, at what angle, how wide; as `finger.fit(readings, family)` too.

    The search is global in position and half width. There are four unknowns: with four readings a pull and nonsense are
    UNEXPLAINED, but only more sensors can object to the family. A fit of line loads is `locate`.

    Parameters
    ----------
    finger, readings
        As in `locate`.
    family, search, half_width, normal_force, friction, scan_step, false_alarm, ambiguity, outliers, stick
        As in `locator`.

    Returns
    -------
    Estimate
        Position [m], force [N/m], angle [rad], half width [m], their covariance, an interval of the half width, rival,
        residual, status, each of shape (...).

    Raises
    ------
    InvalidValueError, GeometryError
        As in `locate`.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=1e-5))
    >>> roller = ss.Hertz(force=40.0, angle=0.3, position=0.4e-3, half_width=1.2e-3)
    >>> found = ss.fit(finger, finger.read(roller), "hertz")
    >>> ss.Status(found.status).name, round(float(found.half_width) * 1e3, 3)
    ('OK', 1.2)
    """
    _check.no_options(_unknown, _OPTIONS)
    return _quick(
        finger, family, search, half_width, normal_force, friction, scan_step, false_alarm, ambiguity, outliers, stick
    )(readings)


def _quick(finger: Finger, family: str | Family, *options: Any) -> Locator:
    """The locator of the options as they were given, in the order of `_OPTIONS`: the shortest way for one frame."""

    def make() -> Locator:
        return locator(finger, family, **dict(zip(_OPTIONS.split(", "), options, strict=True)))

    try:
        return prepared(finger).get((family, options), make)
    except TypeError:  # an array or a list among them, which is no key
        return make()
