"""The grid of a contact: as wide as it has to be, found on a coarse grid that grows or shrinks, or as asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError
from ..skin import Skin
from .equilibrium import Balance, Case, Prescribed, solve
from .indenter import Indenter
from .influence import influence

__all__ = ["Grid", "continued", "fresh"]

_NODES = 1024
_COARSE = 96
_PLACES = 2049
_TRIES = 60
_WIDER = 5
_LEAST_LENGTH = 1e-15  # m, far within an atom
_MARGIN = 1.3
_NARROW = 0.3
_LADDER = 1.25
_WIDEST = 1 << 12
"""Times the first guess of a width, beyond which a contact has no end."""
_LEAST_TOLERANCE, _MOST_TOLERANCE = 1e-12, 1e-3
_MOST_NODES = 1 << 22
_FAR = 24
"""Windows on either side within which the bodies are looked at for a touch that the window leaves out."""
_PARTS = 16
_OVERLAP = 1e-3
"""Overlap beyond the window that counts, in shares of the greatest displacement: its pressure is a coarser one."""

Gap = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class Grid:
    """What was asked of the grid; None where nothing was. Lengths [m]."""

    nodes: int | None
    window: float | None
    period: float | None
    datum: float | None
    tolerance: float

    @classmethod
    def checked(
        cls, nodes: int | None, window: float | None, period: float | None, datum: float | None, tolerance: float
    ) -> Grid:
        """The same, checked one by one."""
        count = None if nodes is None else _check.scalar("nodes", nodes, at_least=16, at_most=_MOST_NODES)
        if count is not None and count != int(count):
            raise InvalidValueError(f"nodes = {count:.6g}", "a whole number is needed", "nodes=1024")
        wide, repeat, rest = (
            None if value is None else _check.scalar(name, value, unit="m", above=0.0, at_least=_LEAST_LENGTH)
            for name, value in (("window", window), ("period", period), ("datum", datum))
        )
        if wide is not None and repeat is not None:
            raise InvalidValueError(
                f"window = {window}, period = {period}", "one of the two can be given", "leave out one of them"
            )
        limit = _check.scalar("tolerance", tolerance, at_least=_LEAST_TOLERANCE, at_most=_MOST_TOLERANCE)
        return cls(None if count is None else int(count), wide, repeat, rest, limit)


def fresh(skin: Skin, indenter: Indenter, gap: Gap, load: Prescribed, grid: Grid) -> tuple[Case, Balance]:
    """A problem on a grid of its own, and its solution."""
    count = grid.nodes or _NODES
    if grid.period is not None:
        if np.isfinite(skin.period):
            seen = f"period = {grid.period:.6g} m on a {type(skin).__name__}"
            raise GeometryError(seen, "only a flat skin goes on and on", "leave out period")
        _upright(load, grid.period)
        indenter.check_period(grid.period)
        ends = (-grid.period / 2, grid.period / 2)
        case = _case(skin, gap, load, ends, 1 << (count - 1).bit_length(), grid)
        return case, solve(case)
    if grid.window is not None:
        case = _case(skin, gap, load, (-grid.window / 2, grid.window / 2), count, grid)
        case, state = _whole(case, solve(case), indenter, "give a wider window, or less force")
        where = _touches_beyond(skin, indenter, case, state)
        if where:
            seen = f"a window of {grid.window:.6g} m"
            rule = f"beyond it, at y = {where[0]:.6g} m from the indenter's centre, the bodies overlap"
            raise GeometryError(seen, rule, "a wider window, or none")
        return case, state
    low, high = _window(skin, indenter, gap, load, grid.datum)
    for _ in range(_WIDER):
        case = _case(skin, gap, load, (low, high), count, grid)
        state = solve(case)
        cut = _cut_off(case, state, indenter)
        grow = 0.25 * (high - low)
        if any(cut):
            low, high = low - grow * cut[0], high + grow * cut[1]
            continue
        where = _touches_beyond(skin, indenter, case, state)
        if not where:
            return case, state
        low, high = min(low, *(y - grow for y in where)), max(high, *(y + grow for y in where))
        low, high = max(low, indenter.ends[0]), min(high, indenter.ends[1])
        if high - low > 0.5 * skin.period:
            break
    seen, rule = f"a grid {high - low:.6g} m wide", "the bodies touch beyond it as well, however wide it is made"
    raise GeometryError(seen, rule, "a body that ends, period=, window=, or less force")


def continued(
    before: Case, state: Balance, lateral: FloatArray, grid: Grid, load: Prescribed, indenter: Indenter
) -> tuple[Case, Balance]:
    """The next problem on the grid of the last, and its solution; slip counts from there."""
    width = before.step * before.y.size
    had = {
        "nodes": before.y.size,
        "window": None if before.influence.periodic else width,
        "period": width if before.influence.periodic else None,
        "datum": before.datum,
    }
    for name, value in had.items():
        asked = getattr(grid, name)
        if asked is not None and (value is None or not np.isclose(asked, value, rtol=1e-9, atol=0.0)):
            seen = f"{name} = {asked:.6g} after a press with {'none' if value is None else f'{value:.6g}'}"
            rule = "a press goes on with the grid of the one before"
            raise GeometryError(seen, rule, f"leave out {name}, or give it to the first press")
    if before.influence.periodic:
        _upright(load, width)
    _touchable(before.y, before.height, load)
    case = replace(before, load=load, shift=lateral - state.slide, tolerance=grid.tolerance)
    pressed = state.pressure > 0
    found = solve(case, replace(state, steps=0, touches=pressed, sticks=pressed))
    if case.influence.periodic:
        return case, found
    return _whole(case, found, indenter, "give a wider window to the first press, or less force")


def _case(skin: Skin, gap: Gap, load: Prescribed, ends: tuple[float, float], count: int, grid: Grid) -> Case:
    """The problem on `count` nodes, in the middle of as many equal parts of the window."""
    wide = ends[1] - ends[0]
    if grid.datum is not None and grid.datum < wide:
        raise GeometryError(
            f"datum = {grid.datum:.6g} m",
            f"the surface rests beyond the window, {wide:.6g} m wide",
            "a larger datum, or a narrower window",
        )
    step, y = _nodes(ends, count)
    height = gap(y)
    _touchable(y, height, load)
    _within(y[np.isfinite(height)], load)
    periodic = grid.period is not None
    if periodic and not skin.grounded and load.depth is not None and not load.depth < height.mean():
        seen = f"depth = {load.depth:.6g} m"
        rule = "pressed in to the profile's mean, the bodies touch all along, and no force brings them deeper"
        raise InvalidValueError(seen, rule, f"less than {height.mean():.6g} m, or a force")
    op = influence(skin, step, count, periodic, grid.datum)
    return Case(op, step, y, height, load, np.zeros(count), grid.tolerance, gap, grid.datum)


def _nodes(ends: tuple[float, float], count: int) -> tuple[float, FloatArray]:
    """The step between nodes in the middle of equal parts of a window, and these nodes."""
    step = float((ends[1] - ends[0]) / count)
    return step, np.asarray(ends[0] + step * (np.arange(count) + 0.5), dtype=np.float64)


def _touchable(y: FloatArray, height: FloatArray, load: Prescribed) -> None:
    half = 0.5 * float(y[1] - y[0])
    if not np.isfinite(height).any():
        seen = f"no part of the indenter between y = {y[0] - half:.6g} and {y[-1] + half:.6g} m from its centre"
        raise InvalidValueError(seen, "the indenter never touches the skin", "a wider window, or another position")
    if load.depth is not None and not load.tilt and load.moment is None and not (height < load.depth).any():
        seen, rule = f"depth = {load.depth:.6g} m", "the indenter never touches the skin"
        raise InvalidValueError(seen, rule, f"its lowest point is {height.min():.6g} m above it")


def _within(body: FloatArray, load: Prescribed) -> None:
    """Raise where no pressure beneath the body has the force and the moment."""
    if load.moment is None or load.force is None:
        return
    arm = load.moment / load.force
    if not body[0] < arm < body[-1]:
        seen = f"moment = {load.moment:.6g} N at force = {load.force:.6g} N/m"
        rule = f"the resultant has to pass through the body, from {body[0]:.6g} to {body[-1]:.6g} m"
        raise GeometryError(seen, rule, f"it would at {arm:.6g} m; less moment")


def _upright(load: Prescribed, period: float) -> None:
    if load.moment is not None or load.tilt:
        raise GeometryError(
            f"period = {period:.6g} m with a moment or a tilt",
            "a body that repeats does not turn",
            "leave out moment and tilt",
        )


def _touches_beyond(skin: Skin, indenter: Indenter, case: Case, state: Balance) -> list[float]:
    """Where the bodies overlap most beyond either end of the window, from the indenter's centre.

    Each end counts by itself: were the window to grow to one side alone, what touches there would lift the other off.
    """
    wide, low = case.step * case.y.size, case.y[0] - 0.5 * case.step
    h = wide / _PARTS
    share = (case.y - low) / h
    at = np.clip(np.floor(share).astype(np.intp), 0, _PARTS - 1)
    part = share - at
    lower, upper = (np.bincount(at + i, state.pressure * s, _PARTS + 1) for i, s in ((0, 1 - part), (1, part)))
    hats = (lower + upper) * (case.step / h)
    most = min(_FAR, int(0.5 * skin.period / wide) - 1 if np.isfinite(skin.period) else _FAR) * _PARTS
    if most < _PARTS:
        return []
    rows = influence(skin, h, most + _PARTS + 1, periodic=False).rows[0, 0]
    within = case.influence.apply(0, 0, state.pressure)
    limit, found = _OVERLAP * float(np.abs(within).max()), []
    for side in (-1, 1):
        edge = 0 if side < 0 else _PARTS
        nodes = edge + side * np.arange(most + 1)  # from the window's end outwards, in steps of h
        moved = rows[np.abs(nodes[:, None] - np.arange(_PARTS + 1))] @ hats
        moved += within[0 if side < 0 else -1] - moved[0]  # the same zero as within the window
        y = low + h * (edge + side * np.linspace(0, most, 16 * most + 1)[1:])
        inside = (y > indenter.ends[0]) & (y < indenter.ends[1])
        if not inside.any():
            continue
        y = y[inside]
        sunk = np.interp(side * ((y - low) / h - edge), np.arange(most + 1), moved)
        left = case.profile(y) + sunk - state.depth - state.tilt * y
        worst = int(np.argmin(left))
        if left[worst] < -limit:
            found.append(float(y[worst]))
    return found


def _cut_off(case: Case, state: Balance, indenter: Indenter) -> tuple[bool, bool]:
    """Whether the contact runs into either end of the window where the body goes on."""
    low, high = indenter.ends
    return (
        bool(state.pressure[0] > 0 and case.y[0] - 0.75 * case.step > low),
        bool(state.pressure[-1] > 0 and case.y[-1] + 0.75 * case.step < high),
    )


def _whole(case: Case, state: Balance, indenter: Indenter, fix: str) -> tuple[Case, Balance]:
    if any(_cut_off(case, state, indenter)):
        seen = f"a window of {case.step * case.y.size:.6g} m"
        raise GeometryError(seen, "the contact reaches its end, and would go on beyond", fix)
    return case, state


def _window(skin: Skin, indenter: Indenter, gap: Gap, load: Prescribed, datum: float | None) -> tuple[float, float]:
    """Ends of a window from the indenter's centre [m], wider than the contact, or as wide as the body.

    Widths come from a ladder, so that presses of about the same width share one grid, and what is known of the skin on
    it.
    """
    low, high = indenter.ends
    arm = load.moment / load.force if load.moment is not None and load.force is not None else 0.0
    _within(np.array([low, high]), load)
    most = 0.5 * skin.period
    if np.isfinite(high - low):
        width, middle = high - low, 0.5 * (low + high)
    else:
        middle = float(np.clip(arm, low, high))
        if np.isfinite(most) and load.moment is None:
            middle = _lowest(gap, max(low, -0.5 * most), min(high, 0.5 * most))
        width = _first_guess(skin, gap, load, middle)
    plain = replace(load, tangential=None, slide=None, friction=None)
    touched, widest = False, min(_WIDEST * width, most)
    for _ in range(_TRIES):
        ends = _snapped(middle, min(_rung(width), most), low, high)
        step, y = _nodes(ends, _COARSE)
        op = influence(skin, step, _COARSE, periodic=False, datum=datum)
        case = Case(op, step, y, gap(y), plain, np.zeros(_COARSE), 1e-4, gap, datum)
        state = solve(case)
        touched = True if state.pressure.any() else touched
        at = np.flatnonzero(state.pressure > 0)
        if not at.size:
            width *= 2
            continue
        left, right = case.y[at[0]] - case.step, case.y[at[-1]] + case.step
        cut = bool(left < ends[0] and ends[0] > low), bool(right > ends[1] and ends[1] < high)
        if any(cut):
            if width >= widest:
                break
            middle += 0.25 * width * (cut[1] - cut[0])
            width *= 2
        elif right - left < _NARROW * (ends[1] - ends[0]):
            width, middle = max(2 * (right - left), 0.05 * (ends[1] - ends[0])), 0.5 * (left + right)
        else:
            return _snapped(0.5 * (left + right), min(_rung(_MARGIN * (right - left)), most), low, high)
    if not touched:
        _touchable(case.y, case.height, load)
    seen, rule = f"a grid {ends[1] - ends[0]:.6g} m wide", "the contact reaches its ends, however wide it is made"
    raise GeometryError(seen, rule, "press less, give the body an end, or window=")


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


def _first_guess(skin: Skin, gap: Gap, load: Prescribed, middle: float) -> float:
    """A width at which a half plane as soft as the surface would carry the load: P = E* h, h being the height there."""
    widths = 2.0 ** np.arange(-30, 4)
    widths = widths[widths < 0.5 * skin.period]
    lowest = float(gap(np.array([middle]))[0])
    heights = np.array([gap(middle + np.array([-w / 2, w / 2])).min() for w in widths]) - lowest
    if load.force is None:
        enough = heights > float(load.depth or 0.0) - lowest
    else:
        waves = np.pi / widths
        if np.isfinite(skin.period):  # a whole number of waves round a finger
            waves = np.maximum(np.round(waves * skin.period / (2 * np.pi)), 1) * 2 * np.pi / skin.period
        stiff = 2 / (skin.surface_compliance(waves)[:, 0, 0] * waves)
        enough = stiff * np.where(np.isfinite(heights), heights, np.inf) > load.force
    if enough.any():
        return float(widths[int(np.argmax(enough))])
    if np.isinf(skin.period):
        seen = f"a body that rises by {heights[-1]:.3g} m over {widths[-1]:.3g} m, on a flat skin"
        raise GeometryError(seen, "they would touch all along", "a body that ends, period=, window=, or a Round skin")
    return float(widths[-1])


def _lowest(gap: Gap, low: float, high: float) -> float:
    """Where the bodies are nearest: their first touch, on a round finger beside the body's own lowest point."""
    for _ in range(3):
        y = np.linspace(low, high, _PLACES)
        at = int(np.argmin(gap(y)))
        low, high = y[max(at - 1, 0)], y[min(at + 1, _PLACES - 1)]
    return float(0.5 * (low + high))
