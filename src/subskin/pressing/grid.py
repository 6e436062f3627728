"""The grid of a contact: as wide as it has to be, found on a coarse grid that grows or shrinks, or as asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..errors import GeometryError, InvalidValueError
from ..skin import Skin
from . import area, row
from .beyond import touches_beyond
from .body import LocalIndenter
from .case import Asked, Balance, BoolArray, Case
from .indenter import Indenter
from .influence import influence

__all__ = ["Grid", "continued", "fresh"]

_PLACES = 2049
_TRIES = 60
_LEAST_LENGTH = 1e-15  # m, far within an atom
_LADDER = 1.25
_WIDEST = 1 << 12
"""Times the first guess of a width, beyond which a contact has no end."""
_RING = 24
_LEAST_TOLERANCE, _MOST_TOLERANCE = 1e-12, 1e-3
_LESS = 0.7
"""A press that displaces the skin by less than this share of what the one before did is solved once more."""


class _Way(NamedTuple):
    """How a grid is made: nodes if none are asked for, the least, the most, and what they are a multiple of."""

    nodes: int
    fewest: int
    most: int
    even: int
    tolerance: float
    coarse: int
    """Nodes of the grid on which the window is looked for."""
    narrow: float
    """Share of that grid beneath which a contact is looked at more closely."""
    least: float
    """Its least width then, in steps."""
    reach: float
    """Steps beyond the outermost node that touches to which a contact may go."""
    margin: float
    wider: int
    """Times that a grid is made wider because the bodies touch beyond it."""


_WAYS = {
    1: _Way(1024, 16, 1 << 22, 1, 1e-9, coarse=96, narrow=0.3, least=4.8, reach=1.0, margin=1.3, wider=5),
    2: _Way(256, 32, 4096, 32, 1e-8, coarse=32, narrow=0.35, least=4.0, reach=0.5, margin=1.2, wider=6),
}
_EQUILIBRIUM = {1: row.equilibrium, 2: area.equilibrium}

Ends: TypeAlias = tuple[FloatArray, FloatArray]
"""The lowest and the highest position along each axis [m]."""
Gap: TypeAlias = Callable[..., FloatArray]
Body: TypeAlias = Indenter | LocalIndenter


@dataclass(frozen=True, eq=False)
class Grid(Frozen):
    """What was asked of the grid; None where nothing was. Lengths [m], the window's sides along each axis."""

    nodes: int | None
    window: FloatArray | None
    period: float | None
    datum: float | None
    tolerance: float

    @classmethod
    def checked(cls, axes: int, nodes: Any, window: Any, period: Any, datum: Any, tolerance: Any) -> Grid:
        """The same, checked one by one."""
        way = _WAYS[axes]
        for name, value in (("period", period), ("datum", datum)):
            if axes == 2 and value is not None:
                raise InvalidValueError(f"{name} = {value}", f"a body on an area takes no {name}", f"leave out {name}")
        count = _check.scalar("nodes", way.nodes if nodes is None else nodes, at_least=way.fewest, at_most=way.most)
        if count != int(count):
            raise InvalidValueError(f"nodes = {count:.6g}", "a whole number is needed", f"nodes={way.nodes}")
        if count % way.even:
            fix = f"nodes={max(way.even, round(count / way.even) * way.even)}"
            raise InvalidValueError(
                f"nodes = {count:.6g}", f"a multiple of {way.even} is needed, for coarser grids", fix
            )
        repeat, rest = (
            None if value is None else _check.scalar(name, value, unit="m", above=0.0, at_least=_LEAST_LENGTH)
            for name, value in (("period", period), ("datum", datum))
        )
        wide = None
        if window is not None:
            wide = _check.real("window", window, unit="m", above=0.0, at_least=_LEAST_LENGTH)
            if wide.shape != () and wide.shape != (axes,) * (axes - 1):
                rule = f"a single number is needed{', or two along y and z' * (axes - 1)}"
                raise InvalidValueError(f"window of shape {wide.shape}", rule)
            wide = np.broadcast_to(wide, (axes,))
        if wide is not None and repeat is not None:
            seen = f"window = {window}, period = {period}"
            raise InvalidValueError(seen, "one of the two can be given", "leave out one of them")
        limit = way.tolerance if tolerance is None else tolerance
        limit = _check.scalar("tolerance", limit, at_least=_LEAST_TOLERANCE, at_most=_MOST_TOLERANCE)
        return cls(None if nodes is None else int(count), wide, repeat, rest, limit)


def fresh(skin: Skin, body: Body, gap: Gap, load: Asked, grid: Grid) -> tuple[Case, Balance]:
    """A problem on a grid of its own, and its solution."""
    if grid.period is not None:
        if np.isfinite(skin.period):
            seen = f"period = {grid.period:.6g} m on a {type(skin).__name__}"
            raise GeometryError(seen, "only a flat skin goes on and on", "leave out period")
        _upright(load, grid.period)
        if isinstance(body, Indenter):
            body.check_period(grid.period)
        half = np.array([0.5 * grid.period])
        return _solved(_case(skin, gap, load, (-half, half), grid))
    if grid.window is not None:
        case, state = _solved(_case(skin, gap, load, (-0.5 * grid.window, 0.5 * grid.window), grid))
        _whole(case, state, body, "give a wider window, or less force")
        for where in touches_beyond(skin, body, case, state)[:1]:
            at = ", ".join(f"{name} = {part:.6g}" for name, part in zip("yz", where, strict=False))
            rule = f"beyond it, at {at} m from the indenter's centre, the bodies overlap"
            raise GeometryError(f"a window of {_size(case)}", rule, "a wider window, or none")
        return case, state
    limits = _limits(body)
    low, high = _searched(skin, body, gap, load, grid)
    for _ in range(_WAYS[len(low)].wider):
        case, state = _solved(_case(skin, gap, load, (low, high), grid))
        cut = _cut_off(case, state, limits)
        if cut.any():
            grow = 0.25 * (high - low)
            low, high = low - grow * cut[0], high + grow * cut[1]
        else:
            mesh = touches_beyond(skin, body, case, state)
            if not mesh:
                return case, state
            grow = 0.25 * (high - low).max()
            low, high = (np.min([low, *(at - grow for at in mesh)], 0), np.max([high, *(at + grow for at in mesh)], 0))
        low, high = np.maximum(low, limits[0]), np.minimum(high, limits[1])
        if (high - low).max() > 0.5 * skin.period:
            break
    seen, rule = f"a grid of {_size(case)}", "the bodies touch beyond it as well, however wide it is made"
    raise GeometryError(seen, rule, f"a body that ends, {'period=, ' * (len(low) == 1)}window=, or less force")


def continued(
    before: Case, state: Balance, lateral: FloatArray, grid: Grid, load: Asked, body: Body
) -> tuple[Case, Balance]:
    """The next problem on the grid of the last, and its solution; slip counts from there."""
    sides = before.step * np.array(before.height.shape)
    periodic = before.influence.periodic
    had = {
        "nodes": max(before.height.shape),
        "window": None if periodic else sides,
        "period": sides if periodic else None,
        "datum": before.datum,
    }
    for name, value in had.items():
        asked = getattr(grid, name)
        if asked is not None and (value is None or not np.allclose(asked, value, rtol=1e-9, atol=0.0)):
            seen = f"{name} = {_sizes(asked)} after a press with {'none' if value is None else _sizes(value)}"
            rule = "a press goes on with the grid of the one before"
            raise GeometryError(seen, rule, f"leave out {name}, or give it to the first press")
    if periodic:
        _upright(load, float(sides[0]))
    shift = lateral - before.rigid(state.slide, state.twist)
    case = replace(before, load=load, shift=shift, tolerance=grid.tolerance)
    _touchable(case)
    pressed = state.pressure > 0
    case, found = _solved(case, replace(state, steps=(0, 0), touches=pressed, sticks=_sticks(case, pressed)))
    if len(sides) == 2 and found.scale < _LESS * state.scale:
        # it was solved to a share of what the skin was displaced before
        case, found = _solved(case, found)
    if not periodic:
        _whole(case, found, body, "give a wider window to the first press, or less force")
    return case, found


def _sticks(case: Case, pressed: BoolArray) -> BoolArray | None:
    """The first guess of who sticks: on a row who touches, on an area by the drag before."""
    return pressed if len(case.axes) == 1 else None


def _solved(case: Case, start: Balance | None = None) -> tuple[Case, Balance]:
    return case, _EQUILIBRIUM[len(case.axes)](case, start)


def _case(skin: Skin, gap: Gap, load: Asked, ends: Ends, grid: Grid, *, sure: bool = True) -> Case:
    """The problem on square cells in whose middles the nodes stand, of a load that is `sure` to be one for them."""
    way, sides = _WAYS[len(ends[0])], ends[1] - ends[0]
    count, periodic = grid.nodes or way.nodes, grid.period is not None
    if periodic:
        count = 1 << (count - 1).bit_length()
    if sure and grid.datum is not None and grid.datum < sides.max():
        seen, rule = f"datum = {grid.datum:.6g} m", f"the surface rests beyond the window, {sides.max():.6g} m wide"
        raise GeometryError(seen, rule, "a larger datum, or a narrower window")
    step = float(sides.max() / count)
    counts = tuple(max(way.even, -(-round(float(side / step)) // way.even) * way.even) for side in sides)
    first = 0.5 * (ends[0] + ends[1]) - 0.5 * step * np.array(counts)
    axes = tuple(low + step * (np.arange(count) + 0.5) for low, count in zip(first, counts, strict=True))
    height = np.asarray(gap(*(axes if len(axes) == 1 else (axes[0][:, None], axes[1]))))
    op = influence(skin, step, counts, load.friction is not None or len(axes) == 1, periodic, grid.datum)
    case = Case(op, step, axes, height, load, np.zeros((len(axes), *counts)), grid.tolerance, gap, grid.datum)
    if not sure:
        return case
    _touchable(case)
    if load.moment is not None:
        body = np.isfinite(height)
        on = [nodes[body.any(axis=1 - i) if len(axes) == 2 else body] for i, nodes in enumerate(axes)]
        _carried(load, np.array([nodes[0] for nodes in on]), np.array([nodes[-1] for nodes in on]))
    if periodic and not skin.grounded and load.depth is not None and not load.depth < height.mean():
        rule = "pressed in to the profile's mean, the bodies touch all along, and no force brings them deeper"
        raise InvalidValueError(f"depth = {load.depth:.6g} m", rule, f"less than {height.mean():.6g} m, or a force")
    return case


def _touchable(case: Case) -> None:
    load, half = case.load, 0.5 * case.step
    if not np.isfinite(case.height).any():
        parts = zip("yz", case.axes, strict=False)
        where = ", ".join(f"{name} = {at[0] - half:.6g} and {at[-1] + half:.6g} m" for name, at in parts)
        seen = f"no part of the indenter between {where} from its centre"
        raise InvalidValueError(seen, "the indenter never touches the skin", "a wider window, or another position")
    if load.depth is not None and load.moment is None:
        lowest = float((case.height - case.leaning(load.tilt)).min())
        if not lowest < load.depth:
            seen, rule = f"depth = {load.depth:.6g} m", "the indenter never touches the skin"
            raise InvalidValueError(seen, rule, f"its lowest point is {lowest:.6g} m above it")


def _carried(load: Asked, low: FloatArray, high: FloatArray) -> None:
    """Raise where no pressure beneath the body has the force and the moment."""
    if load.moment is None or load.force is None:
        return
    for moment, first, last in zip(load.moment, low, high, strict=True):
        arm = moment / load.force
        if not first < arm < last:
            units = ("N", "N/m") if len(low) == 1 else ("N m", "N")
            seen = f"moment = {moment:.6g} {units[0]} at force = {load.force:.6g} {units[1]}"
            rule = f"the resultant has to pass through the body, from {first:.6g} to {last:.6g} m"
            raise GeometryError(seen, rule, f"it would at {arm:.6g} m; less moment")


def _upright(load: Asked, period: float) -> None:
    if load.moment is not None or load.tilt.any():
        seen = f"period = {period:.6g} m with a moment or a tilt"
        raise GeometryError(seen, "a body that repeats does not turn", "leave out moment and tilt")


def _limits(body: Body) -> Ends:
    """Beyond what there is no body, along each axis."""
    low, high = np.reshape(np.asarray(body.ends, dtype=np.float64), (-1, 2)).T
    return low, high


def _cut_off(case: Case, state: Balance, limits: Ends) -> BoolArray:
    """Whether the contact runs into the border at the low and the high end of each axis, where the body goes on."""
    near, out = 0.75 * case.step, np.zeros((2, len(case.axes)), dtype=bool)
    for axis, nodes in enumerate(case.axes):
        rim = np.moveaxis(state.pressure, axis, 0) > 0
        out[0, axis] = rim[0].any() and nodes[0] - near > limits[0][axis]
        out[1, axis] = rim[-1].any() and nodes[-1] + near < limits[1][axis]
    return out


def _whole(case: Case, state: Balance, body: Body, fix: str) -> None:
    if _cut_off(case, state, _limits(body)).any():
        seen = f"a window of {_size(case)}"
        raise GeometryError(seen, "the contact reaches its end, and would go on beyond", fix)


def _size(case: Case) -> str:
    return f"{_sizes(case.step * np.array(case.height.shape))} m"


def _sizes(sides: npt.ArrayLike) -> str:
    return " by ".join(f"{side:.6g}" for side in np.ravel(sides))


def _searched(skin: Skin, body: Body, gap: Gap, load: Asked, grid: Grid) -> Ends:
    """Ends of a window from the indenter's centre [m], wider than the contact, or as wide as the body.

    Widths come from a ladder, so that presses of about the same width share one grid, and what is known of the skin on
    it.
    """
    limits, most = _limits(body), 0.5 * skin.period
    way, (low, high), bounded = _WAYS[len(limits[0])], limits, np.isfinite(limits[1] - limits[0])
    _carried(load, low, high)
    arm = np.zeros(low.shape) if load.moment is None or load.force is None else load.moment / load.force
    middle = np.clip(arm + (body.centre if isinstance(body, LocalIndenter) else 0.0), low, high)
    middle[bounded] = 0.5 * (low[bounded] + high[bounded])
    if np.isfinite(most) and load.moment is None and not bounded.any():
        middle = np.array([_lowest(gap, max(low[0], -0.5 * most), min(high[0], 0.5 * most))])
    sides = high - low
    if not bounded.all():
        sides = np.where(bounded, sides, _first_guess(skin, gap, load, middle))
    plain = replace(load, tangential=None, slide=None, torsion=None, twist=None, friction=None)
    rough = replace(grid, nodes=way.coarse, tolerance=1e-4)
    touched, widest = False, min(_WIDEST * float(sides.max()), most)
    for _ in range(_TRIES):
        wide = _on_ladder(sides, most) if len(low) == 1 else sides
        ends = _snapped(middle, wide, limits)
        case = _case(skin, gap, plain, ends, rough, sure=False)
        if not np.isfinite(case.height).any():
            sides = 2 * sides
            continue
        _, state = _solved(case)
        if not state.pressure.any():
            sides = 2 * sides
            continue
        touched, cut = True, _cut_off(case, state, limits)
        first, last = _touched(case, state, way.reach)
        if cut.any():
            if sides.max() >= widest:
                break
            middle = middle + 0.25 * sides * (cut[1].astype(float) - cut[0])
            sides = np.where(cut.any(axis=0), 2 * sides, sides)
        elif (last - first).max() < way.narrow * (ends[1] - ends[0]).max():
            sides, middle = np.maximum(2 * (last - first), way.least * case.step), 0.5 * (first + last)
        else:
            return _snapped(0.5 * (first + last), _on_ladder(way.margin * (last - first), most), limits)
    if not touched:
        _touchable(case)
        raise InvalidValueError("this body", "the indenter never touches the skin", "another position, or a window")
    seen, rule = f"a grid of {_size(case)}", "the contact reaches its ends, however wide it is made"
    raise GeometryError(seen, rule, "press less, give the body an end, or window=")


def _touched(case: Case, state: Balance, reach: float) -> Ends:
    """The ends of what presses, with so many steps beyond."""
    ends = []
    for axis, nodes in enumerate(case.axes):
        rows = np.moveaxis(state.pressure, axis, 0).reshape(nodes.size, -1)
        at = nodes[(rows > 0).any(axis=1)]
        ends.append((at[0] - reach * case.step, at[-1] + reach * case.step))
    low, high = np.array(ends).T
    return low, high


def _on_ladder(sides: FloatArray, most: float) -> FloatArray:
    """The longest side brought to the next width of the ladder."""
    longest = sides.max()
    rung = _LADDER ** np.ceil(np.log(longest) / np.log(_LADDER) - 1e-9)
    return np.asarray(sides * (min(float(rung), most) / longest))


def _snapped(middle: FloatArray, sides: FloatArray, limits: Ends) -> Ends:
    """A window about `middle` that ends where the body does, if it would reach there."""
    first, last = middle - sides / 2, middle + sides / 2
    for i, (low, high) in enumerate(zip(*limits, strict=True)):
        if first[i] < low:
            first[i], last[i] = low, max(last[i], low + sides[i]) if last[i] < high else last[i]
        if last[i] > high:
            first[i], last[i] = max(low, min(first[i], high - sides[i])), high
    return first, last


def _first_guess(skin: Skin, gap: Gap, load: Asked, middle: FloatArray) -> float:
    """A width at which a half space as soft as the surface would carry the load: P = E* h, F = E* w h, h the height."""
    widths = 2.0 ** np.arange(-30, 5)
    widths = widths[widths < 0.5 * skin.period]
    turn = np.arange(_RING) * (2 * np.pi / _RING)
    ways = np.array([[-1.0, 1.0]]) if len(middle) == 1 else np.array([np.cos(turn), np.sin(turn)])
    around = [(at + 0.5 * widths[:, None] * way).ravel() for at, way in zip(middle, ways, strict=True)]
    lowest = float(gap(*middle[:, None])[0])
    lowest = lowest if np.isfinite(lowest) else 0.0
    every = gap(*around).reshape(widths.size, -1)
    heights = (every.min(axis=1) if len(middle) == 1 else np.median(every, axis=1)) - lowest
    if load.force is None:
        enough = heights > float(load.depth or 0.0) - lowest
    else:
        waves = np.pi / widths
        if np.isfinite(skin.period):  # a whole number of waves round a finger
            waves = np.maximum(np.round(waves * skin.period / (2 * np.pi)), 1) * 2 * np.pi / skin.period
        stiff = 2 / (skin.surface_compliance(waves)[:, 0, 0] * waves) * widths ** (len(middle) - 1)
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
