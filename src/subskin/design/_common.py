"""What several tools for designers ask: counts, seeds, one sensor of a row, the stretch in which something is good."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Ruled, Whole
from .._frozen import Result, close
from ..array import SensorArray
from ..contact.families import Family, LocalFamily
from ..errors import GeometryError, InvalidValueError
from ..estimate.locate import locator, row_locator
from ..finger import Finger
from ..skin import Skin
from .touches import Touches

Count: TypeAlias = Annotated[int, Whole(1, 10**8)]
Several: TypeAlias = Annotated[int, Whole(2, 10**8)]
Seed: TypeAlias = Annotated[np.random.Generator | int, Ruled(lambda _, value: _check.random(value) and value)]
"""A random generator, or the seed of one."""


class Found(Result):
    """What a tool found: a dataclass of many numbers, of which a person sees the shapes and which none can change."""

    def __post_init__(self) -> None:
        close(self.__dict__.values())


def listed(name: str, value: npt.ArrayLike, unit: str = "", **bounds: Any) -> FloatArray:
    """One number or a list of them, (n,) with n > 0, within `bounds` as of `_check.real`."""
    values = np.atleast_1d(_check.real(name, value, unit=unit, **bounds))
    if values.ndim != 1 or not values.size:
        raise GeometryError(f"{name} of shape {values.shape}", "one is needed, or a list of them", "shape (3,)")
    return values


def noise_of(array: SensorArray) -> FloatArray:
    """The noise of the sensors, which have to have some."""
    noise = np.asarray(array.noise)
    if not (noise > 0).all():
        raise InvalidValueError("noise = 0", "the answer depends on the noise of the sensors", "noise=1e-4")
    return noise


def index_of(array: SensorArray, sensor: object) -> int:
    """`sensor` as the index of one."""
    whole_number = isinstance(sensor, int | np.integer) and not isinstance(sensor, bool)
    if not whole_number or not 0 <= int(sensor) < len(array):  # type: ignore[call-overload]
        rule = f"there are 0 to {len(array) - 1}"
        raise InvalidValueError(f"sensor = {_check.shown(sensor)}", rule, "sensor=0")
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


def locator_for(finger: Finger, touches: Touches, family: str | Family | LocalFamily = "", **options: Any) -> Any:
    """What finds the touches by the field of the finger's skin; they are of the `family` if another is not given.

    Of a round touch its radius is found as well, and no moment.
    """
    if touches.area is None:
        long: Any = family or "line"
        return row_locator(finger, long, **options)
    if not finger.array.on_area:
        rule = "sensors in a row take touches for lines across it"
        raise GeometryError("touches on an area", rule, "a span, or SensorArray.grid(...)")
    wide, bare = touches.half_width, replace(finger, measured=None)
    if family or wide is None:
        return locator(bare, family or "point", **options)
    depth = float(np.asarray(finger.array.depth).min())
    widths = (0.0, max(1.5 * depth, 1.25 * wide))
    return locator(bare, "round_hertz", **{"half_width": widths, "moment": False, **options})


def widest(square: FloatArray) -> FloatArray:
    """Standard deviation in the direction in which it is largest, of covariances (..., 1, 1) or (..., 2, 2).

    Infinite where one of them is.
    """
    if square.shape[-1] == 1:
        return np.sqrt(square[..., 0, 0])
    with np.errstate(invalid="ignore"):
        half = 0.5 * (square[..., 0, 0] - square[..., 1, 1])
        mean = 0.5 * (square[..., 0, 0] + square[..., 1, 1])
        out = np.sqrt(np.maximum(mean + np.hypot(half, square[..., 0, 1]), 0.0))
    return np.asarray(np.where(np.isinf(square).any(axis=(-2, -1)), np.inf, out))
