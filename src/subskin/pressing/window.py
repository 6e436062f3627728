"""How wide a grid has to be: the contact's place and width, roughly, from a coarse grid that grows or shrinks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .._check import FloatArray
from ..errors import GeometryError
from ..skin import Skin
from .equilibrium import Case, Load, State, solve
from .indenter import Indenter
from .influence import influence

__all__ = ["chosen_window"]

_COARSE = 96
_TRIES = 60
_MARGIN = 1.3
_NARROW = 0.3
_LADDER = 1.25


def chosen_window(
    skin: Skin,
    indenter: Indenter,
    gap: Callable[[FloatArray], FloatArray],
    load: Load,
    position: float,
    datum: float | None,
) -> tuple[float, float]:
    """Ends of a window from the indenter's centre [m], wider than the contact, or as wide as the body.

    Widths come from a ladder, so that presses of about the same width share one grid, and what is known of the skin on
    it.
    """
    low, high = indenter.ends
    arm = load.moment / load.force if load.moment is not None and load.force is not None else 0.0
    if not low <= arm <= high:
        raise GeometryError(
            f"moment = {load.moment:.6g} N at force = {load.force:.6g} N/m",
            f"the resultant has to pass through the body, from {low:.6g} to {high:.6g} m",
        )
    most = 0.5 * skin.period
    width = high - low if np.isfinite(high - low) else _first_guess(skin, gap, load)
    middle = 0.5 * (low + high) if np.isfinite(high - low) else float(np.clip(arm, low, high))
    for _ in range(_TRIES):
        ends = _snapped(middle, min(_rung(width), most), low, high)
        case, state = _roughly(skin, gap, load, ends, datum)
        at = np.flatnonzero(state.pressure > 0)
        if not at.size:
            width *= 2
            continue
        left, right = case.y[at[0]] - case.step, case.y[at[-1]] + case.step
        cut = bool(left < ends[0] and ends[0] > low), bool(right > ends[1] and ends[1] < high)
        if any(cut):
            if width >= most:
                break
            middle += 0.25 * width * (cut[1] - cut[0])
            width *= 2
        elif right - left < _NARROW * (ends[1] - ends[0]) and case.y.size >= _COARSE:
            width, middle = max(2 * (right - left), 0.05 * (ends[1] - ends[0])), 0.5 * (left + right)
        else:
            return _snapped(0.5 * (left + right), min(_rung(_MARGIN * (right - left)), most), low, high)
    raise GeometryError(
        f"a window {ends[1] - ends[0]:.6g} m wide",
        "the contact reaches its ends, however wide",
        "press less, or give the body an end",
    )


def _roughly(
    skin: Skin,
    gap: Callable[[FloatArray], FloatArray],
    load: Load,
    ends: tuple[float, float],
    datum: float | None,
) -> tuple[Case, State]:
    step = (ends[1] - ends[0]) / _COARSE
    y: FloatArray = np.asarray(ends[0] + step * (np.arange(_COARSE) + 0.5), dtype=np.float64)
    plain = Load(load.force, load.depth, load.moment, load.tilt, None, None, None)
    op = influence(skin, step, _COARSE, periodic=False, datum=datum)
    case = Case(op, step, y, gap(y), plain, np.zeros(_COARSE), 1e-4, gap, datum)
    return case, solve(case)


def _rung(width: float) -> float:
    """The next width of the ladder."""
    return float(_LADDER ** np.ceil(np.log(width) / np.log(_LADDER) - 1e-9))


def _snapped(middle: float, width: float, low: float, high: float) -> tuple[float, float]:
    """A window about `middle` that ends where the body does, if it would reach there."""
    first, last = middle - width / 2, middle + width / 2
    if first < low:
        first, last = low, max(last, low + width) if last < high else last
    if last > high:
        first, last = max(low, min(first, high - width)), high
    return first, last


def _first_guess(skin: Skin, gap: Callable[[FloatArray], FloatArray], load: Load) -> float:
    """A width at which a half plane as soft as the surface would carry the load: P = E* h, h being the height there."""
    widths = 2.0 ** np.arange(-30, 4)
    widths = widths[widths < 0.5 * skin.period]
    heights = np.array([gap(np.array([-w / 2, w / 2])).min() for w in widths])
    if load.force is None:
        enough = heights > float(load.depth or 0.0)
    else:
        waves = np.pi / widths
        if np.isfinite(skin.period):  # a whole number of waves round a finger
            waves = np.maximum(np.round(waves * skin.period / (2 * np.pi)), 1) * 2 * np.pi / skin.period
        stiff = 2 / (skin.surface_compliance(waves)[:, 0, 0] * waves)
        enough = stiff * np.where(np.isfinite(heights), heights, np.inf) > load.force
    return float(widths[int(np.argmax(enough))]) if enough.any() else 1e-3
