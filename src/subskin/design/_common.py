"""What several tools for designers ask: whole numbers, one sensor of a row, the stretch in which something is good."""

from __future__ import annotations

from numbers import Real

import numpy as np
import numpy.typing as npt

from ..array import SensorArray
from ..errors import InvalidValueError
from ..skin import Skin


def whole(name: str, value: object, least: int = 1) -> int:
    """`value` as a whole number, or a message that says which are allowed."""
    if isinstance(value, bool) or not isinstance(value, Real) or value % 1 or value < least:
        raise InvalidValueError(f"{name} = {value!r}", f"a whole number >= {least} is needed", f"{name}={least}")
    return int(value)  # type: ignore[call-overload, no-any-return]


def index_of(array: SensorArray, sensor: object) -> int:
    """`sensor` as the index of one."""
    if isinstance(sensor, bool) or sensor not in range(len(array)):
        raise InvalidValueError(f"sensor = {sensor!r}", f"there are 0 to {len(array) - 1}", "sensor=0")
    return int(sensor)  # type: ignore[call-overload, no-any-return]


def refuse_ridges(skin: Skin, what: str) -> None:
    """Refuses a skin with ridges where a tool takes the skin for the same everywhere."""
    if skin.ridges is not None:
        fix = "the smooth skin, or finger.read, locate and placement_quality, which know its ridges"
        raise InvalidValueError(f"{what} of {skin}", "it is for a skin that is the same at every position", fix)


def stretch(good: npt.NDArray[np.bool_], at: int) -> tuple[int, int]:
    """First and last index about `at` between which all are good."""
    bad = np.flatnonzero(~good)
    return int(bad[bad < at].max(initial=-1)) + 1, int(bad[bad > at].min(initial=good.size)) - 1
