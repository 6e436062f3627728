"""What sensors in a row may feel besides lines: which locator a finger gets for points, and what is sought unasked."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .. import _check
from ..errors import InvalidValueError
from ..finger import Finger
from ..prepared import prepared
from ..response import tabulate
from .beside import OnRowLocator, PointLocator, farthest_beside, points_beside, points_on
from .either import EitherLocator
from .on_area import refuse
from .search import Locator

__all__ = ["point_locator", "usual"]


def usual(finger: Finger, *of_lines: object) -> str:
    """What is sought where nothing is said: on a row whose skin is known in space a line or a point, else a line.

    Tolerances, and options `of_lines`, are those of lines alone.
    """
    told = finger.tolerances is not None or any(option is not None for option in of_lines)
    return "line" if told or finger.array.on_area or not finger.skin.takes_local else "either"


def point_locator(
    finger: Finger,
    family: str,
    search: Any,
    beside: Any,
    others: dict[str, Any],
    values: dict[str, Any],
    line: Callable[[tuple[float, float] | None], Locator],
) -> Locator | EitherLocator:
    """The locator of point loads on a row or beside it ("point"), or of these and of `line` loads ("either").

    Raises
    ------
    InvalidValueError, GeometryError
        `others` than the options that both know; an option out of range; a skin that nobody knows in space.
    """
    refuse(others, "loads on a point know no such option")
    ends = _check.ends("search", search, "search=(-5e-3, 5e-3)")
    most = None if beside is None else _check.scalar("beside", beside, unit="m", at_least=0.0)
    if most == 0.0 and family == "either":
        rule, fix = "a point may press beside the row, or it need not be sought", 'load="point" for points on the row'
        raise InvalidValueError("beside = 0 m", rule, fix)

    def make() -> Locator | EitherLocator:
        table, mu = tabulate(finger, ends), float(values["friction"])
        within = (table.start, table.stop)
        on = points_on(finger, within)
        if most == 0.0:
            return OnRowLocator(on, finger.array, **values).allow_for(finger, mu)
        response = points_beside(finger, within, farthest_beside(finger, most))
        point = PointLocator(response, finger.array, **values).allow_for(finger, mu)
        if family == "point":
            return point
        on_row = OnRowLocator(on, finger.array, beside=point, **values).allow_for(finger, mu)
        return EitherLocator(line(ends), on_row, point)

    return prepared(finger).get((family, ends, most, *values.values()), make)
