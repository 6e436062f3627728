"""Where contacts are looked for: the ends of a search along a row, as given or as they follow from the finger."""

from __future__ import annotations

import numpy as np

from . import _check
from .errors import InvalidValueError
from .finger import Finger

__all__ = ["ends_of", "from_crest_to_crest"]

_FARTHEST = 100.0
"""Depths by which a search may be wider than the row."""


def ends_of(finger: Finger, search: tuple[float, float] | None) -> tuple[float, float]:
    """The ends of a search, checked."""
    y, deepest, period = np.asarray(finger.array.y), float(np.max(finger.array.depth)), finger.skin.period
    if search is None:
        whole = (y.min() - 1.5 * deepest, y.max() + 1.5 * deepest)
        middle = 0.5 * (whole[0] + whole[1])
        half = min(0.5 * (whole[1] - whole[0]), 0.5 * period)
        return float(middle - half), float(middle + half)
    low, high = _check.pair("search", search, "search=(-5e-3, 5e-3)", "m")
    if not low < high:
        raise InvalidValueError(f"search = {search!r}", "two ascending positions are needed", "search=(-5e-3, 5e-3)")
    if high - low > period * (1 + 1e-12):
        rule = f"the finger is {period:.6g} m about, and positions repeat after that"
        raise InvalidValueError(f"search = {search!r}", rule, "a narrower search")
    if high - low > np.ptp(y) + _FARTHEST * deepest:
        rule = f"it is wider than the row by more than {_FARTHEST:g} depths, beyond which sensors read nothing"
        raise InvalidValueError(f"search = {search!r} m", rule, "search in metres, such as (-5e-3, 5e-3)")
    return low, high


def from_crest_to_crest(
    low: float, high: float, step: float, crest: float, pitch: float, period: float
) -> tuple[float, float, float]:
    """Ends on crests, and a step of which a pitch is a whole number: what ridges bear is smooth from crest to crest."""
    first, last = np.floor((low - crest) / pitch + 1e-9), np.ceil((high - crest) / pitch - 1e-9)
    last = min(last, first + np.round(period / pitch)) if np.isfinite(period) else last
    return float(crest + pitch * first), float(crest + pitch * last), pitch / np.ceil(pitch / step)
