"""What is not known of a row's finger, and of the size of a touch, made ready for the loop that settles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..._check import FloatArray
from ...contact import Hertz, RoundHertz
from ...errors import InvalidValueError
from ...finger import Finger
from ...radial_round import tabulate_round
from ...response import Response
from ..frames import packed
from .given import Variants
from .uncertain import POWERS, SQUARES, WITHOUT, Uncertain, deeper_than, other_than

__all__ = ["on_row"]

_EXACT = 1e-6
"""What tables leave, of the largest reading."""


def on_row(finger: Finger, ends: tuple[float, float], *, sized: bool, local: bool = False) -> Uncertain | None:
    """What is not known of a finger with a row of sensors, for loads between `ends` [m]; None if it is exact.

    sized: whether a load may be a roller's contact; local: of point loads on the row, by a finger in space, and a
    ball's contacts.
    """
    told, depth = finger.tolerances, np.asarray(finger.array.depth)
    if told is None:
        return None
    if finger.skin.ridges is not None:
        rule = "readings of a ridged skin are not smooth in what is not known"
        raise InvalidValueError("tolerances of a finger with ridges", rule, WITHOUT)
    deeper, (other, ratios), widest = deeper_than(finger), other_than(finger), float(depth.min())
    wider = _wider(finger, ends, widest, local) if sized else None

    def read(one: Finger, y: FloatArray) -> FloatArray:
        return one.receptive_field(_on_it(y), "point")[..., :2] if local else one.receptive_field(y)

    def parts(y: FloatArray) -> list[FloatArray]:
        base = read(finger, y)
        made = [base] if deeper is None else [base, read(deeper, y)]
        made += [] if other is None else [read(other, y) - base]
        if wider is None:
            return made
        added = [wider(y, float(np.sqrt(q)) * widest) - base for q in SQUARES]
        return made + [sum(share * one for share, one in zip(row, added, strict=True)) for row in POWERS]

    both = Response.from_function(
        lambda y: np.concatenate(parts(y), axis=-2), *ends, step=0.25 * widest, tolerance=_EXACT
    )
    n = len(finger.array)
    every = [both.select(np.arange(both.sensors) // n == v) for v in range(both.sensors // n)]
    first = every.pop(1) if deeper is not None else None
    second = every.pop(1) if other is not None else None
    return Uncertain(told, _rows, every[0], ratios, first, second, tuple(every[1:]), widest)


def _on_it(y: FloatArray) -> FloatArray:
    """Points (y, 0) on the row, shape (..., 2)."""
    return np.stack([y, np.zeros_like(y)], axis=-1)


def _wider(
    finger: Finger, ends: tuple[float, float], widest: float, local: bool
) -> Callable[[FloatArray, float], FloatArray]:
    """Readings under unit forces of a roller's, or a ball's, contact, by position and half width."""
    if not local:
        wide = Response.of(finger, Hertz, ends, widest)
        return lambda y, a: wide(y, np.full_like(y, a))
    y = np.asarray(finger.array.y)
    round_ = tabulate_round(finger, RoundHertz, max(ends[1] - float(y.min()), float(y.max()) - ends[0]), 1.5 * widest)
    return lambda y, a: round_.at(a)(_on_it(y))[..., :2]


def _rows(every: list[Response], noise: FloatArray, at: dict[str, int]) -> Variants:
    """Tables of responses of a row, as loops want them."""
    table = np.stack([packed(one, 1 / noise) for one in every])
    none = np.zeros((len(every), 0, 5), dtype=np.int64)
    n = noise.size
    return Variants(
        np.zeros((len(every), 4, n)), table, np.zeros(n + 1, dtype=np.int64), none, every[0].start, every[0].step, **at
    )
