"""What sensors in a row may feel besides lines: which locator a finger gets for points, and what is sought unasked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from .. import _check
from ..errors import InvalidValueError
from ..finger import Finger
from ..prepared import prepared
from ..radial import tabulate_radial
from ..response import tabulate
from .area.uncertain import on_area
from .beside import OnRowLocator, PointLocator, farthest_beside, finger_in_space, points_beside, points_on
from .either import EitherLocator
from .on_area import refuse
from .search import Locator
from .settle.row import on_row
from .settle.uncertain import Uncertain

__all__ = ["point_locator", "usual"]


def usual(finger: Finger, *of_lines: object) -> str:
    """What is sought where nothing is said: on a row whose skin is known in space a line or a point, else a line.

    Options `of_lines` are those of lines alone.
    """
    told = any(option is not None for option in of_lines)
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
        on, tip = points_on(finger, within), finger_in_space(finger)
        given = {**values, "uncertain": on_row(tip, within, sized=family == "either", local=True)}
        if most == 0.0:
            return OnRowLocator(on, finger.array, **given).allow_for(finger, mu)
        farthest = farthest_beside(finger, most)
        response = points_beside(finger, within, farthest)
        uncertain = _beside(tip, within, farthest, sized=family == "either")
        point = PointLocator(response, finger.array, uncertain=uncertain, **values)
        point.allow_for(finger, mu)
        if family == "point":
            return point
        return EitherLocator(
            line(ends), OnRowLocator(on, finger.array, beside=point, **given).allow_for(finger, mu), point
        )

    return prepared(finger).get((family, ends, most, *values.values()), make)


def _beside(tip: Finger, within: tuple[float, float], farthest: float, *, sized: bool) -> Uncertain | None:
    """What is not known of a finger in space, for point loads up to so far beside its row; None if it is exact."""
    y = np.asarray(tip.array.y)
    reach = float(np.hypot(max(within[1] - y.min(), y.max() - within[0]), farthest))
    found = on_area(tip, tabulate_radial(tip, reach), reach, sized=sized)
    return None if found is None else replace(found, aside=farthest)
