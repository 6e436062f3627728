"""Bounds of numbers: those that a name has, and those of all numbers, within which their powers stay finite."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .errors import InvalidValueError

__all__ = ["LARGEST", "SMALLEST", "keep"]

LARGEST, SMALLEST = 1e75, 1e-75
"""Magnitudes between which a number lies, or above 0: its fourth power, and one over that, are floats still."""


def keep(
    name: str,
    array: npt.NDArray[np.float64],
    *,
    unit: str,
    above: float | None,
    at_least: float | None,
    at_most: float | None,
    finite: bool,
    fix: str,
) -> None:
    """Refuse the first number that is out of bounds; one that is not finite passes where `finite` is False."""

    def hold(good: npt.NDArray[np.bool_], bound: str) -> None:
        if not np.logical_and.reduce(good, axis=None):  # `good.all()` takes twice the time
            rule = f"has to be {bound}" + (f" [{unit}]" if unit else "")
            raise InvalidValueError(_seen(name, array, ~np.asarray(good)), rule, fix)

    size = np.abs(array)
    if not np.logical_and.reduce(size <= LARGEST, axis=None):  # rare, so that it may take its time
        if finite:
            hold(np.isfinite(array), "finite")
        hold((size <= LARGEST) | ~np.isfinite(array), f"at most {LARGEST:g} in magnitude")
    if above is not None:
        hold(array > above, f"> {above:g}")
        if above == 0.0 and at_most is None:  # a share, or a chance, may be as small as it likes
            hold(array >= SMALLEST, f"at least {SMALLEST:g}")
    if at_least is not None:
        hold(array >= at_least, f">= {at_least:g}")
    if at_most is not None:
        hold(array <= at_most, f"<= {at_most:g}")


def _seen(name: str, array: npt.NDArray[np.float64], bad: npt.NDArray[np.bool_]) -> str:
    """`name = value`, with the index of the first offender where the value is an array."""
    if array.ndim == 0:
        return f"{name} = {float(array):.6g}"
    where = tuple(int(i) for i in np.argwhere(bad)[0])
    position = ", ".join(map(str, where))
    return f"{name}[{position}] = {array[where]:.6g}"
