"""The grid of a contact on an area: as large as it has to be, found on coarse grids, or as asked for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._frozen import Frozen
from ...errors import GeometryError, InvalidValueError
from ...skin import Skin
from ..body import LocalIndenter
from .balance import AreaBalance, AreaCase, Gap, equilibrium
from .influence import area_influence
from .load import Asked

__all__ = ["AreaGrid", "area_case", "continued", "fresh"]

_NODES = 256
_COARSE = 32
_EVEN = 32
_TRIES = 40
_WIDER = 6
_MARGIN = 1.2
_NARROW = 0.35
_LADDER = 1.25
_RING = 24
_WIDEST = 16.0  # m
_LESS = 0.7
_FAR = 27.0
"""Times its own size that is looked over about a box for touches that it leaves out."""
_OVERLAP = 1e-3
"""Overlap beyond the box that counts, in shares of the greatest displacement: its pressure is a coarser one."""

Ends = tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class AreaGrid(Frozen):
    """What was asked of the grid: nodes along the longer side, sides along y and z [m]; None where nothing was."""

    nodes: int
    window: FloatArray | None
    tolerance: float

    @classmethod
    def checked(cls, nodes: int | None, window: Any, tolerance: float) -> AreaGrid:
        """The same, checked."""
        count = _check.scalar("nodes", _NODES if nodes is None else nodes, at_least=32, at_most=4096)
        if count % _EVEN:
            fix = f"nodes={max(_EVEN, round(count / _EVEN) * _EVEN)}"
            raise InvalidValueError(f"nodes = {count:.6g}", f"a multiple of {_EVEN} is needed, for coarser grids", fix)
        sides = None
        if window is not None:
            sides = np.broadcast_to(_check.real("window", window, unit="m", above=0.0), (2,))
        return cls(int(count), sides, _check.scalar("tolerance", tolerance, at_least=1e-12, at_most=1e-3))


def fresh(skin: Skin, body: LocalIndenter, gap: Gap, load: Asked, box: AreaGrid) -> tuple[AreaCase, AreaBalance]:
    """A problem on a grid of its own, and its solution."""
    if box.window is not None:
        ends = -0.5 * box.window, 0.5 * box.window
        case = area_case(skin, gap, load, ends, box.nodes, box.tolerance)
        state = equilibrium(case)
        if any(_cut_off(case, state, body)):
            raise GeometryError(_size(ends), "the contact reaches its border, and goes on", "a wider window, or none")
        where = _touches_beyond(skin, body, case, state)
        if where is not None:
            rule = f"beyond it, at y = {where[0]:.6g}, z = {where[1]:.6g} m from the body's centre, the bodies overlap"
            raise GeometryError(_size(ends), rule, "a wider window, or none")
        return case, state
    ends = _found(skin, body, gap, load)
    for _ in range(_WIDER):
        case = area_case(skin, gap, load, ends, box.nodes, box.tolerance)
        state = equilibrium(case)
        cut = _cut_off(case, state, body)
        low, high = ends
        where = None
        if any(cut):
            grow = 0.25 * (high - low)
            low, high = low - grow * np.array(cut[:2]), high + grow * np.array(cut[2:])
        else:
            where = _touches_beyond(skin, body, case, state)
            if where is None:
                return case, state
            reach = 0.25 * float((high - low).max())
            low, high = np.minimum(low, where - reach), np.maximum(high, where + reach)
        ends = _within(body, low, high)
    raise GeometryError(
        _size(ends), "the bodies touch beyond it as well, however large it is made", "window=, or less force"
    )


def continued(case: AreaCase, state: AreaBalance, body: LocalIndenter) -> AreaBalance:
    """The solution of the next problem on the grid of the last."""
    found = equilibrium(case, replace(state, products=(0, 0), touches=state.pressure > 0, sticks=None))
    if found.scale < _LESS * state.scale:  # it was solved to a share of what the skin was displaced before
        found = equilibrium(case, found)
    if any(_cut_off(case, found, body)):
        seen = f"a grid of {case.step * case.y.size:.6g} by {case.step * case.z.size:.6g} m"
        raise GeometryError(seen, "the contact reaches its border, and goes on", "a wider window for the first press")
    return found


def area_case(skin: Skin, gap: Gap, load: Asked, ends: Ends, nodes: int, tolerance: float) -> AreaCase:
    """The problem on square cells, `nodes` along the longer side, in whose middles the nodes stand."""
    sides = ends[1] - ends[0]
    step = float(sides.max()) / nodes
    counts = [max(_EVEN, -(-round(float(side) / step) // _EVEN) * _EVEN) for side in sides]
    middle = 0.5 * (ends[0] + ends[1])
    y, z = (m + step * (np.arange(c) - 0.5 * (c - 1)) for m, c in zip(middle, counts, strict=True))
    height = np.asarray(gap(y[:, None], z))
    if not np.isfinite(height).any():
        raise InvalidValueError(
            _size(ends), "the indenter never touches the skin: no part of it is there", "a wider window"
        )
    leaning = load.tilt[0] * y[:, None] + load.tilt[1] * z
    if load.depth is not None and load.moment is None and not (height - leaning < load.depth).any():
        seen, fix = (
            f"depth = {load.depth:.6g} m",
            f"its lowest point is {float((height - leaning).min()):.6g} m above it",
        )
        raise InvalidValueError(seen, "the indenter never touches the skin", fix)
    op = area_influence(skin, step, (counts[0], counts[1]), load.friction is not None)
    return AreaCase(op, step, y, z, height, load, np.zeros((2, *height.shape)), tolerance, gap)


def _size(ends: Ends) -> str:
    sides = ends[1] - ends[0]
    return f"a grid of {sides[0]:.6g} by {sides[1]:.6g} m"


def _found(skin: Skin, body: LocalIndenter, gap: Gap, load: Asked) -> Ends:
    """Ends of a box about the contact, a little larger than it."""
    limits = np.array(body.ends)
    finite = np.isfinite(limits).all(axis=1)
    width = _first_guess(skin, body, gap, load)
    side = np.where(finite, limits[:, 1] - limits[:, 0], width)
    middle = np.where(finite, 0.5 * np.where(np.isfinite(limits), limits, 0.0).sum(axis=1), body.centre)
    plain = _plain(load)
    touched = False
    for _ in range(_TRIES):
        ends = _within(body, middle - 0.5 * side, middle + 0.5 * side)
        case = area_case(skin, gap, plain, ends, _COARSE, 1e-4)
        state = equilibrium(case)
        if not state.pressure.any():
            side = 2 * side
            continue
        touched = True
        cut = np.array(_cut_off(case, state, body)).reshape(2, 2)
        if cut.any():
            middle = middle + 0.25 * side * (cut[1].astype(float) - cut[0])
            side = np.where(cut.any(axis=0), 2 * side, side)
            if side.max() > _WIDEST:
                break
            continue
        low, high = _touched(case, state)
        extent = high - low
        if extent.max() < _NARROW * (ends[1] - ends[0]).max():
            side, middle = np.maximum(2 * extent, 4 * case.step), 0.5 * (low + high)
            continue
        side, middle = _MARGIN * extent, 0.5 * (low + high)
        side = side * (_rung(float(side.max())) / side.max())
        return _within(body, middle - 0.5 * side, middle + 0.5 * side)
    if not touched:
        raise InvalidValueError("this body", "the indenter never touches the skin", "another position, or a window")
    raise GeometryError(
        _size(ends), "the contact reaches its border, however large it is made", "press less, or window="
    )


def _plain(load: Asked) -> Asked:
    return replace(load, tangential=None, slide=None, torsion=None, twist=None, friction=None)


def _rung(width: float) -> float:
    """The next width of the ladder, so that presses of about one size share a grid."""
    return float(_LADDER ** np.ceil(np.log(width) / np.log(_LADDER) - 1e-9))


def _within(body: LocalIndenter, low: FloatArray, high: FloatArray) -> Ends:
    limits = np.array(body.ends)
    return np.maximum(low, limits[:, 0]), np.minimum(high, limits[:, 1])


def _first_guess(skin: Skin, body: LocalIndenter, gap: Gap, load: Asked) -> float:
    """A width at which a half space as soft as the surface would carry the load: F = E* w h, h the height there."""
    widths = 2.0 ** np.arange(-24, 5)
    turn = 2 * np.pi * np.arange(_RING) / _RING
    y, z = (c + 0.5 * widths[:, None] * part(turn) for c, part in zip(body.centre, (np.cos, np.sin), strict=True))
    lowest = float(gap(np.array(body.centre[0]), np.array(body.centre[1])))
    lowest = lowest if np.isfinite(lowest) else 0.0
    height = np.median(gap(np.asarray(y), np.asarray(z)), axis=1) - lowest
    if load.force is None:
        enough = height > float(load.depth or 0.0) - lowest
    else:
        waves = np.pi / widths
        stiff = 2 / (skin.surface_compliance(waves)[:, 0, 0] * waves)
        enough = stiff * widths * np.where(np.isfinite(height), height, np.inf) > load.force
    return float(widths[int(np.argmax(enough))]) if enough.any() else float(widths[-1])


def _touched(case: AreaCase, state: AreaBalance) -> Ends:
    """The box of the nodes that press, to half a step."""
    low, high = [], []
    for axis, nodes in ((1, case.y), (0, case.z)):
        at = np.flatnonzero((state.pressure > 0).any(axis=axis))
        low.append(nodes[at[0]] - 0.5 * case.step)
        high.append(nodes[at[-1]] + 0.5 * case.step)
    return np.array(low), np.array(high)


def _cut_off(case: AreaCase, state: AreaBalance, body: LocalIndenter) -> tuple[bool, bool, bool, bool]:
    """Whether the contact runs into the border at low y, low z, high y, high z, where the body goes on."""
    p, limits, near = state.pressure > 0, np.array(body.ends), 0.75 * case.step
    return (
        bool(p[0].any() and case.y[0] - near > limits[0, 0]),
        bool(p[:, 0].any() and case.z[0] - near > limits[1, 0]),
        bool(p[-1].any() and case.y[-1] + near < limits[0, 1]),
        bool(p[:, -1].any() and case.z[-1] + near < limits[1, 1]),
    )


def _touches_beyond(skin: Skin, body: LocalIndenter, case: AreaCase, state: AreaBalance) -> FloatArray | None:
    """Where the bodies overlap most beyond the box, from the body's centre; None where they do not."""
    middle = np.array([0.5 * (case.y[0] + case.y[-1]), 0.5 * (case.z[0] + case.z[-1])])
    half = 0.5 * case.step * np.array(case.height.shape)
    size, limits = float(half.max()), np.array(body.ends)
    if (middle - half <= limits[:, 0] + case.step).all() and (middle + half >= limits[:, 1] - case.step).all():
        return None
    scale, wide = state.scale, 3.0
    while wide <= _FAR:
        step = 2 * wide * size / 96
        y, z = (m + step * (np.arange(96) - 47.5) for m in middle)
        fine = [m + 0.5 * step * (np.arange(191) - 95.0) for m in middle]
        away = np.abs(fine[0] - middle[0])[:, None] > half[0]
        away = away | (np.abs(fine[1] - middle[1]) > half[1])
        height = np.asarray(case.gap(fine[0][:, None], fine[1]))
        left = height - state.depth - state.tilt[0] * fine[0][:, None] - state.tilt[1] * fine[1]
        if (left[away] < 0).any():  # else the skin, which sinks, cannot touch there
            op = area_influence(skin, step, (96, 96), False)
            rough = np.zeros((96, 96))
            share_y, share_z = (case.y - y[0]) / step, (case.z - z[0]) / step
            weights = [np.maximum(1 - np.abs(np.arange(96)[:, None] - share), 0.0) for share in (share_y, share_z)]
            rough = weights[0] @ state.pressure @ weights[1].T * (case.cell / step**2)
            sunk = op.normal(rough)
            between = np.empty((191, 191))
            between[::2, ::2] = sunk
            between[1::2, ::2] = 0.5 * (sunk[1:] + sunk[:-1])
            between[:, 1::2] = 0.5 * (between[:, 2::2] + between[:, :-1:2])
            left = np.where(away, left + between, np.inf)
            at = np.unravel_index(int(np.argmin(left)), left.shape)
            if left[at] < -_OVERLAP * scale:
                return np.array([fine[0][at[0]], fine[1][at[1]]])
        wide *= 3
    return None
