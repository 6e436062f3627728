"""Readings -> where, how hard, at what angle (and how wide): any number of sensors, any response, any family."""

from __future__ import annotations

from typing import Any, Literal, Never, TypeAlias, cast, overload

import numpy as np
import numpy.typing as npt

from .. import _check
from ..contact import Hertz, LineLoad
from ..contact.families import Family, LocalFamily, checked_family, family_of
from ..errors import InvalidValueError
from ..finger import Finger, finger_needed
from ..prepared import prepared
from ..response import Response, tabulate
from .area import AreaLocator, InPlaceLocator
from .either import Either, EitherLocator
from .estimate import Estimate
from .on_area import area_locator, refuse, refuse_tolerances, several_locator
from .on_row import point_locator, usual
from .patches import PatchLocator
from .search import Locator
from .settle.row import on_row
from .several import SeveralLocator, TouchSet, checked_touches
from .stick_locator import StickLocator, checked_stick
from .stretches import beyond, reached

__all__ = ["fit", "locate", "locator"]

Search: TypeAlias = tuple[float, float] | tuple[tuple[float, float], tuple[float, float]] | None
Load: TypeAlias = Literal["line", "point", "either", "patch"]
Sides: TypeAlias = tuple[float, float] | tuple[tuple[float, float], tuple[float, float]]
Pressure: TypeAlias = Literal["even", "linear", "punch"]
AnyLocator: TypeAlias = Locator | AreaLocator | InPlaceLocator | EitherLocator | SeveralLocator | PatchLocator

_KNOW_NONE = "several touches know no such option"
_OF_FIT = ("half_width", "stick", "moment", "turn", "pressure")
_OPTIONS = (
    "search, half_width, normal_force, friction, scan_step, false_alarm, ambiguity, outliers, stick, beside, moment, "
    "turn, pressure"
)


def locator(
    finger: Finger,
    family: str | Family | LocalFamily | None = None,
    *,
    search: Search = None,
    half_width: Sides | None = None,
    normal_force: tuple[float, float] | None = None,
    friction: float = 1.0,
    scan_step: float | None = None,
    false_alarm: float = 1e-6,
    ambiguity: float = 13.8,
    outliers: int = 0,
    stick: float | tuple[float, float] | None = None,
    beside: float | None = None,
    moment: bool | None = None,
    turn: float | tuple[float, float] | None = None,
    pressure: Pressure | None = None,
    touches: int = 1,
    **_unknown: Never,
) -> Locator | AreaLocator | InPlaceLocator | EitherLocator | SeveralLocator | PatchLocator:
    """A `Locator` of a finger, prepared once for many calls; as `finger.locator(...)` too.

    Where the sensors are on an area it is an `AreaLocator`, of point loads, a `RoundLocator`, of round contacts, or a
    `PatchLocator`; an `InPlaceLocator` where the finger has a response `measured` in place.

    Parameters
    ----------
    finger : Finger
        The forward model, with the sensors' noise.
    family : {"line", "wedge", "hertz", "strip", "punch", "point", "either"} or class of contacts, optional
        What presses, the drag being in proportion to the pressure. "point" and "either" as `load` of `locate`, as is
        what is taken if it is left out. On an area "point", a round contact: "round_hertz", "round_punch", "cone",
        one's own, or "patch", a rectangle.
    search : (float, float) or ((float, float), (float, float)), optional
        Range of positions y [m], or of y and of z; contacts outside are taken to be impossible. The default
        reaches 1.5 depths beyond the outermost sensors, and a load further out that explains a frame as well makes it
        AMBIGUOUS.
    half_width : (float, float), optional
        Least and largest half width [m]; 0 to 1.5 depths of the shallowest sensor if left out. A line has none, nor has
        a point. Of a patch as in `PatchLocator`.
    normal_force, friction, scan_step, false_alarm, ambiguity, outliers
        As in `Locator`.
    stick : float or (float, float), optional
        Of "hertz" alone: the contact sticks in its middle by this coefficient of friction mu [-], known or a range, as
        in `StickLocator`. `friction` bounds the search; this one shapes the drag.
    beside : float, optional
        Of "point" and "either" on a row: the largest distance beside the row at which a point may press [m]; three
        depths of the shallowest sensor if left out, six at most. 0: a point presses on the row.
    moment : bool, optional
        Of round contacts on an area: whether a moment about the normal is fitted. If left out it is where the sensors
        tell it and more than seven are live; normal strain, pressure and normal stress never do.
    turn, pressure : optional
        Of a patch, as in `PatchLocator`: by how much it is turned, and how it presses.
    touches : int, optional
        As in `locate`; from 2 on it is a `SeveralLocator`.

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
    finger_needed(finger)
    if family is None:
        family = usual(finger, half_width, normal_force, stick, moment) if touches == 1 else "line"
    elif not isinstance(family, str):
        checked_family(family)
    _check.no_options(_unknown, f"{_OPTIONS}, touches")
    values: dict[str, Any] = _check.values(
        friction=friction, scan_step=scan_step, false_alarm=false_alarm, ambiguity=ambiguity, outliers=outliers
    )
    of_area: dict[str, Any] = {"moment": moment, "turn": turn, "pressure": pressure}
    others = {"half_width": half_width, "normal_force": normal_force, "stick": stick, "beside": beside}
    if (most := checked_touches(touches)) > 1:
        unsaid = family in ("line", "point")
        refuse({"family": None if unsaid else family, **others, **of_area}, _KNOW_NONE)
        return several_locator(finger, most, search, values)
    if finger.measured is not None:
        refuse_tolerances(finger, "a response measured in place, which has no drawing")
    if finger.array.on_area:
        return area_locator(finger, family, search, {**others, **of_area}, values)
    if family == "patch" or turn is not None or pressure is not None:
        seen = 'family = "patch"' if family == "patch" else f"turn = {turn}, pressure = {pressure}"
        raise InvalidValueError(seen, "a patch needs sensors on an area", "SensorArray.grid(...)")
    if moment is not None:
        seen, rule = f"moment = {_check.shown(moment)}", "only a round contact on an area has one"
        raise InvalidValueError(seen, rule, 'SensorArray.grid(...), and fit(readings, "round_hertz", moment=True)')
    if family not in ("line", LineLoad, "point", "either") or normal_force is not None:
        refuse_tolerances(finger, "a search of other contacts, or of a stated force")
    if family == "point" or family == "either":
        del others["beside"]
        return point_locator(
            finger, family, search, beside, others, values, lambda ends: row_locator(finger, search=ends, **values)
        )
    if beside is not None:
        rule = "a long contact has no distance beside the row"
        raise InvalidValueError(f"beside = {_check.shown(beside)}", rule, 'load="point" or load="either"')
    kind = family_of(family)  # type: ignore[arg-type]
    sized = finger.tolerances is not None and family == "line"  # nothing was said of the touch
    ends = _check.ends("search", search, "search=(-5e-3, 5e-3)")
    widths = _check.ends("half_width", half_width, "half_width=(0.0, 3e-3)")
    forces = _check.ends("normal_force", normal_force, "normal_force=(1.0, 100.0)")
    held = None if stick is None else checked_stick(stick)
    if held is not None and kind is not Hertz:
        fix = "leave it out: a flat sticks all over until it slides, and a line has no width"
        raise InvalidValueError(f"stick = {stick!r} of a {kind.__name__}", 'only "hertz" knows its zone of stick', fix)

    def make() -> Locator:
        table = tabulate(finger, ends)
        more: dict[str, Any] = {**values, "normal_force": forces}
        if ends is None:
            more["beyond"] = prepared(finger).get(("beyond",), lambda: beyond(finger, table))
        if issubclass(kind, LineLoad):
            if widths is not None:
                raise InvalidValueError(f"half_width = {half_width!r} of a line load", "it has none", "leave it out")
            if finger.tolerances is not None:
                whole = reached(finger, table) if ends is None else (table.start, table.stop)
                more["uncertain"] = on_row(finger, whole, sized=sized)
            return Locator(table, finger.array, **more).allow_for(finger, friction)
        low, high = widths or (0.0, 1.5 * float(np.asarray(finger.array.depth).min()))
        response = Response.of(finger, kind, (table.start, table.stop), max(high, 1e-3 * table.step))
        more["half_width"] = (low, high)
        if held is not None:
            return StickLocator(response, finger.array, held, **more).allow_for(finger, friction)
        return Locator(response, finger.array, **more).allow_for(finger, friction)

    return prepared(finger).get(("locator", kind, sized, ends, widths, forces, held, *values.values()), make)


def row_locator(finger: Finger, family: str | Family = "line", **options: Any) -> Locator:
    """As `locator`, for what is solved in a plane: sensors on an area are refused."""
    finger.array.refuse_area()
    made = locator(finger, family, **options)
    if not isinstance(made, Locator):
        raise InvalidValueError('family = "either"', "one family is needed", 'family="line"')
    return made


@overload
def locate(finger: Finger, readings: npt.ArrayLike, *, load: Literal["either"], **options: Any) -> Either: ...
@overload
def locate(
    finger: Finger,
    readings: npt.ArrayLike,
    *,
    touches: Literal[2, 3],
    load: Literal["point"] | None = None,
    **options: Any,
) -> TouchSet: ...
@overload
def locate(
    finger: Finger, readings: npt.ArrayLike, *, load: Literal["line", "point", "patch"] | None = None, **options: Any
) -> Estimate: ...


def locate(
    finger: Finger,
    readings: npt.ArrayLike,
    *,
    load: Load | None = None,
    beside: float | None = None,
    search: Search = None,
    normal_force: tuple[float, float] | None = None,
    friction: float = 1.0,
    scan_step: float | None = None,
    false_alarm: float = 1e-6,
    ambiguity: float = 13.8,
    outliers: int = 0,
    doubt: npt.ArrayLike | None = None,
    touches: int = 1,
    **_unknown: Never,
) -> Estimate | Either | TouchSet:
    """Where, how hard and at what angle a load presses; as `finger.locate(readings)` too.

    Where the sensors are on an area it is a point load, at (y, z) [m], with components (N, Ty, Tz) [N]. The locator is
    prepared on the first call and kept, so later calls with the same options cost little more than the search.

    Parameters
    ----------
    finger : Finger
        The forward model, with the sensors' noise.
    readings : array_like, shape (..., n)
        Raw readings, each in units of its gain; NaN marks a missing one.
    load : {"line", "point", "either", "patch"}, optional
        What presses; on an area a point, or a "patch", as in `fit`. "line": a long contact across the row. "point"
        presses on the row or up to `beside` of it, on a skin that takes local contacts, and |z| is found as `beside` of
        the answer. "either" is
        both, an `Either` with the probability of the point (docs/locating_row.md). If it is left out it is "either" on
        a row whose skin is known in space, else "line", and with a `normal_force` too. With tolerances a
        touch of which nothing is said may have a size, `half_width` of the answer (docs/real_fingers.md).
    beside : float, optional
        As in `locator`.
    search, normal_force, friction, scan_step, false_alarm, ambiguity, outliers
        As in `locator`.
    doubt : array_like, shape (..., n), optional
        Standard deviation of each reading beside the sensor's noise [reading], as in `Locator`: that of `Tared`, where
        a touch was held. Not of an area's response measured in place, nor with several touches.
    touches : int, optional
        The most touches at once, up to 3, on an area; from 2 on the answer is a `TouchSet`, with the number of
        touches by evidence, and each of them as a point load.

    Returns
    -------
    Estimate or Either or TouchSet
        Position [m], force [N/m], angle [rad], covariance, rival, residual and status, each of shape (...). On an area
        position (..., 2), force [N], `load.components` (..., 3), `load.covariance` (..., 5, 5).

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
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=20.0)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> touch = ss.PointLoad(force=1.5, angle=0.3, azimuth=0.8, position=(1e-3, -2e-3))
    >>> found = ss.locate(finger, finger.read(touch))
    >>> (found.position * 1e3).round(3).tolist(), found.load.components.round(3).tolist()
    ([1.0, -2.0], [1.433, 0.309, 0.318])
    """
    finger_needed(finger)
    if _unknown:
        _check.no_options(
            _unknown, ", ".join(["load", *(n for n in _OPTIONS.split(", ") if n not in _OF_FIT), "doubt", "touches"])
        )
    if load is not None:
        _check.choice("load", load, ("line", "point", "either", "patch"))
    if load == "line":
        finger.array.refuse_area()
    if checked_touches(touches) > 1:
        refuse({"load": None if load == "point" else load, "doubt": doubt}, _KNOW_NONE)
        several = locator(
            finger, search=search, normal_force=normal_force, friction=friction, scan_step=scan_step,
            false_alarm=false_alarm, ambiguity=ambiguity, outliers=outliers, beside=beside, touches=touches,
        )  # fmt: skip
        return cast("SeveralLocator", several)(readings)
    family = LineLoad if load == "line" else load
    search_with = _quick(
        finger, family, search, None, normal_force, friction, scan_step, false_alarm, ambiguity, outliers,
        None, beside, None, None, None,
    )  # fmt: skip
    found: Estimate | Either = search_with(readings) if doubt is None else search_with(readings, doubt)
    return found.of(finger, readings)


def fit(
    finger: Finger,
    readings: npt.ArrayLike,
    family: str | Family | LocalFamily | None = None,
    *,
    search: Search = None,
    half_width: Sides | None = None,
    normal_force: tuple[float, float] | None = None,
    friction: float = 1.0,
    scan_step: float | None = None,
    false_alarm: float = 1e-6,
    ambiguity: float = 13.8,
    outliers: int = 0,
    stick: float | tuple[float, float] | None = None,
    beside: float | None = None,
    moment: bool | None = None,
    turn: float | tuple[float, float] | None = None,
    pressure: Pressure | None = None,
    **_unknown: Never,
) -> Estimate:
    """A contact of one family: where, how hard, at what angle, how wide; as `finger.fit(readings, family)` too.

    The search is global in position and half width. There are four unknowns, on an area six: with as many readings a
    pull and nonsense are UNEXPLAINED, but only more sensors can object to the family. A fit of line loads is `locate`.

    Parameters
    ----------
    finger, readings
        As in `locate`.
    family : str or class of contacts, optional
        "hertz" if left out, on an area "round_hertz".
    search, half_width, normal_force, friction, scan_step, false_alarm, ambiguity, outliers, stick, beside, moment
        As in `locator`.
    turn, pressure
        As in `locator`.

    Returns
    -------
    Estimate
        Position [m], force [N/m], angle [rad], half width [m], their covariance, an interval of the half width, rival,
        residual, status, each of shape (...). On an area as of `locate`, and the half width; covariances (..., 6, 6).
        With a moment that is `load.moment` [N m], and covariances are (..., 7, 7). Of a patch `half_widths`, `turn` and
        `slopes` (docs/patches.md).

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
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=20.0)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> tip = ss.RoundHertz(force=1.5, angle=0.3, position=(1e-3, -2e-3), half_width=2e-3)
    >>> found = ss.fit(finger, finger.read(tip), "round_hertz")
    >>> ss.Status(found.status).name, round(float(found.half_width) * 1e3, 3), found.covariance.shape
    ('OK', 2.0, (6, 6))
    """
    finger_needed(finger)
    _check.no_options(_unknown, _OPTIONS)
    if family is None:
        family = "round_hertz" if finger.array.on_area else "hertz"
    checked_family(family)
    if family == "either":
        raise InvalidValueError('family = "either"', "a fit is of one family", 'finger.locate(readings, load="either")')
    found: Estimate = _quick(
        finger, family, search, half_width, normal_force, friction, scan_step, false_alarm, ambiguity, outliers,
        stick, beside, moment, turn, pressure,
    )(readings)  # fmt: skip
    return found.of(finger, readings)


def _quick(finger: Finger, family: str | Family | LocalFamily | None, *options: Any) -> Any:
    """The locator of the options as they were given, in the order of `_OPTIONS`: the shortest way for one frame."""

    def make() -> AnyLocator:
        return locator(finger, family, **dict(zip(_OPTIONS.split(", "), options, strict=True)))

    try:
        return prepared(finger).get((family, options), make)
    except TypeError:  # an array or a list among them, which is no key
        return make()
