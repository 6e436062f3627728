"""Bounds of numbers: those that a name has, and those of all numbers, within which their powers stay finite."""

from __future__ import annotations

from typing import TypedDict

import numpy as np
import numpy.typing as npt

from .errors import InvalidValueError

__all__ = ["LARGEST", "SMALLEST", "NumberBounds", "NumberLimits", "keep"]

LARGEST, SMALLEST = 1e75, 1e-75
"""Magnitudes between which a number lies, or above 0: its fourth power, and one over that, are floats still."""


class NumberBounds(TypedDict, total=False):
    """What bounds a number, whether it has to be finite (it has), and what an error proposes."""

    above: float | None
    at_least: float | None
    at_most: float | None
    finite: bool
    fix: str


class NumberLimits(NumberBounds, total=False):
    """The same, and its SI unit."""

    unit: str


def keep(name: str, array: npt.NDArray[np.float64], limits: NumberLimits) -> None:
    """Refuse the first number that is out of bounds; one that is not finite passes where it need not be."""
    above, at_least, at_most = limits.get("above"), limits.get("at_least"), limits.get("at_most")
    unit, fix = limits.get("unit", ""), limits.get("fix", "")
    if not array.size:
        return
    least, most = np.minimum.reduce(array, axis=None), np.maximum.reduce(array, axis=None)  # NaN where one is NaN

    def refuse(good: npt.NDArray[np.bool_], bound: str) -> None:
        if not np.all(good):
            rule = f"has to be {bound}" + (f" [{unit}]" if unit else "")
            raise InvalidValueError(_seen(name, array, ~np.asarray(good)), rule, fix)

    if not -LARGEST <= least <= most <= LARGEST:
        known = np.isfinite(array)
        if limits.get("finite", True):
            refuse(known, "finite")
        refuse(~known | (np.abs(array) <= LARGEST), f"at most {LARGEST:g} in magnitude")
    if above is not None and not least > above:
        refuse(array > above, f"> {above:g}")
    if above == 0.0 and at_most is None and not least >= SMALLEST:  # a share, or a chance, may be as small as it likes
        refuse(array >= SMALLEST, f"at least {SMALLEST:g}")
    if at_least is not None and not least >= at_least:
        refuse(array >= at_least, f">= {at_least:g}")
    if at_most is not None and not most <= at_most:
        refuse(array <= at_most, f"<= {at_most:g}")


def _seen(name: str, array: npt.NDArray[np.float64], bad: npt.NDArray[np.bool_]) -> str:
    """`name = value`, with the index of the first offender where the value is an array."""
    if array.ndim == 0:
        return f"{name} = {float(array):.6g}"
    where = tuple(int(i) for i in np.argwhere(bad)[0])
    position = ", ".join(map(str, where))
    return f"{name}[{position}] = {array[where]:.6g}"
