"""A contact on an area in equilibrium on a grid: from coarse grids to fine ones, the pressure and then the shear."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .._check import FloatArray
from .bounded import solved
from .case import Balance, BoolArray, Case, settled
from .descent import Part, Problem
from .influence import Influence

__all__ = ["between", "equilibrium"]

_COARSEST = 32
_SAFE = 0.7
"""Share of the tolerance to which the pressure is solved: the scale is a guess."""
_ROUGH = 100.0
"""Times the tolerance to which a coarse grid is solved: it is only a start."""
_MARGIN = 4
_AT_BOUND = 1e-9
_ROUND = 1.18
"""Approach of a sphere over the displacement in the middle of its contact, were the pressure even."""


def equilibrium(case: Case, start: Balance | None = None) -> Balance:
    """Equilibrium on the grid of `case`; without a start by way of coarser grids."""
    n, k = case.height.shape
    if start is None and max(n, k) >= 2 * _COARSEST and min(n, k) >= _COARSEST and not n % 2 and not k % 2:
        rough = _coarser(case)
        coarse = equilibrium(replace(rough, tolerance=min(_ROUGH * case.tolerance, 1e-3)))
        pressure, touches = finer(coarse.pressure)
        start = replace(
            coarse,
            pressure=pressure,
            shear=np.zeros((2, n, k)),
            touches=touches,
            sticks=None,
            steps=(0, 0),
            rough=coarse,
        )
    return settled(case, _first(case) if start is None else start, _normal, _tangential)


def _coarser(case: Case) -> Case:
    """The same on nodes between, each in the middle of four."""
    y, z = (0.5 * (nodes[::2] + nodes[1::2]) for nodes in case.axes)
    rows = 0.5 * (case.shift[:, ::2] + case.shift[:, 1::2])
    return replace(
        case,
        influence=case.influence.coarser,
        step=2 * case.step,
        axes=(y, z),
        height=np.asarray(case.gap(y[:, None], z)),
        shift=0.5 * (rows[..., ::2] + rows[..., 1::2]),
    )


def _tangential(case: Case, state: Balance) -> Balance:
    """The shear within what friction holds, the pressure being what it is."""
    load, op, p = case.load, case.influence, state.pressure
    mu = float(load.friction or 0.0)
    held, touch = mu * p, p > 0
    if not mu:
        return replace(state, shear=np.zeros((2, *p.shape)))
    w = op.dragged(p) - case.shift
    targets, given = np.full(3, np.nan), np.zeros(3)
    if load.slide is None:
        targets[:2] = np.asarray(load.tangential) / case.cell
    else:
        given[:2] = load.slide
    if load.twist is None:
        targets[2] = float(load.torsion or 0.0) / case.cell
    else:
        given[2] = load.twist
    rigid = case.rigid(given[:2], given[2])
    slid = _sliding(case, state, held, w - rigid)
    if slid is not None:
        return slid
    start, sticks = state.shear, state.sticks
    if state.rough is not None:
        start, sticks = finer_drag(state.rough.shear, mu * state.rough.pressure, held)
    elif sticks is None:
        sticks = touch & ((np.hypot(*state.shear) < held * (1 - 1e-9)) | (not state.shear.any()))
    part = _part(touch)
    found = solved(_problem(case, state, (w - rigid, held), targets, start, sticks).on(part))
    shear, sticks = np.zeros(w.shape), np.zeros(p.shape, dtype=bool)
    shear[..., *part], sticks[part] = found.x, found.free
    motion, steps = given + found.motion, state.after(shear=found.products)
    return replace(state, shear=shear, slide=motion[:2], twist=float(motion[2]), steps=steps, sticks=sticks)


def _problem(
    case: Case, state: Balance, rules: tuple[FloatArray, Any], targets: FloatArray, start: FloatArray, free: Any
) -> Problem:
    """As `Problem`, of w and of what bounds."""
    limit = _SAFE * case.tolerance * state.scale
    return Problem(case.influence, *rules, (case.y, case.z), targets, start, free, limit)


def _sliding(case: Case, state: Balance, held: FloatArray, w: FloatArray) -> Balance | None:
    """All of it slides along a drag, or turns beneath a moment, that friction does not hold; None where it may."""
    load = case.load
    most = float(held.sum() * case.cell)
    if load.slide is None and not load.torsion and load.tangential is not None:
        size = float(np.hypot(*load.tangential))
        if size >= most * (1 - 1e-12) and size > 0:
            along = load.tangential / size
            q = along[:, None, None] * held
            moved = w + case.influence.lateral(q)
            far = (moved * along[:, None, None]).sum(axis=0)[held > 0]
            return replace(state, shear=q, slide=along * float(far.max()), twist=0.0)
    if load.twist is None and load.tangential is not None and not load.tangential.any() and load.torsion:
        turning = case.rigid(np.zeros(2), float(np.sign(load.torsion)))
        arm = np.hypot(*turning)
        if abs(load.torsion) >= float((held * arm).sum()) * case.cell * (1 - 1e-12):
            q = turning / np.maximum(arm, 1e-300) * held
            moved = w + case.influence.lateral(q)
            far = (moved * turning).sum(axis=0) / np.maximum(arm, 1e-300) ** 2
            return replace(state, shear=q, slide=np.zeros(2), twist=float(np.sign(load.torsion) * far[held > 0].max()))
    return None


def _first(case: Case) -> Balance:
    """What lies lower than half the approach touches, as beneath a sphere, under a pressure as round as there."""
    load, op = case.load, case.influence
    low = case.height - case.leaning(load.tilt)
    rises = np.sort(low[np.isfinite(low)])
    lowest = float(rises[0])
    rises -= lowest
    under = _ROUND * _beneath_discs(op)[: rises.size]
    count = 1 + np.arange(under.size)
    if load.force is not None:
        level = load.force / case.cell / count  # the mean pressure, were so many nodes to touch
        touching = max(1, int(np.searchsorted(2 * rises[: under.size] - level * under, 0.0)))
        mean = level[touching - 1]
    else:
        sunk = max(float(load.depth or 0.0) - lowest, 1e-3 * float(rises[-1]))  # coarse nodes may miss the contact
        touching = int(np.clip(np.searchsorted(2 * rises, sunk), 1, under.size))
        mean = sunk / under[touching - 1]
    edge = float(rises[touching - 1]) + case.influence.own * mean * 1e-9
    share = np.clip(1 - (low - lowest) / edge, 0.0, 1.0)
    touches = low - lowest <= edge
    shape = np.sqrt(share + 1e-3) * touches
    p = shape * (mean * touching / shape.sum())
    scale = float(op.normal(p).max())
    return Balance(p, np.zeros((2, *p.shape)), touches, 0.0, load.tilt, np.zeros(2), 0.0, scale)


def _beneath_discs(op: Influence) -> FloatArray:
    """Displacement in the middle of discs of 1, 2, ... nodes under a pressure of 1 [m/Pa]."""
    away = np.add.outer(np.arange(op.shape[0]) ** 2, np.arange(op.shape[1]) ** 2)
    times = np.full(op.shape, 4.0)
    times[0], times[:, 0], times[0, 0] = 2.0, 2.0, 1.0
    order = np.argsort(away, axis=None, kind="stable")
    nodes = np.cumsum(times.flat[order])
    moved = np.cumsum((times * op.rows[0]).flat[order])
    return np.asarray(np.interp(1.0 + np.arange(op.shape[0] * op.shape[1]), nodes, moved))


def _normal(case: Case, state: Balance, lifted: FloatArray) -> Balance:
    """The pressure beneath the body, the shear being what it is."""
    load, body = case.load, np.isfinite(case.height)
    f = np.where(body, case.height, 0.0) + lifted
    targets, given = np.full(3, np.nan), np.zeros(3)
    if load.force is None:
        given[0] = float(load.depth or 0.0)
        f -= given[0]
    else:
        targets[0] = load.force / case.cell
    if load.moment is None:
        given[1:] = load.tilt
        if load.tilt.any():
            f -= case.leaning(load.tilt)
    else:
        targets[1:] = load.moment / case.cell
    whole, part = _problem(case, state, (f, body), targets, state.pressure, state.touches), _part(state.touches)
    found = solved(whole.on(part))
    if not _within(found.free, part, f.shape):  # more than the part and its margin
        part = (slice(0, f.shape[0]), slice(0, f.shape[1]))
        found = solved(whole.on(part))
    pressure, touches = np.zeros(f.shape), np.zeros(f.shape, dtype=bool)
    pressure[part], touches[part] = found.x, found.free
    motion = given + found.motion
    depth, tilt = float(motion[0]), motion[1:]
    top = float(pressure.max(initial=0.0))
    scale = max(abs(depth), case.influence.own * top) if top else state.scale
    steps = state.after(pressure=found.products)
    return replace(state, pressure=pressure, touches=touches, depth=depth, tilt=tilt, scale=scale, steps=steps)


def _within(touches: BoolArray, part: Part, shape: tuple[int, ...]) -> bool:
    """Whether what touches on a part keeps from its rim, but where that is the grid's."""
    for axis, side in enumerate(part):
        rim = np.moveaxis(touches, axis, 0)
        if (side.start > 0 and rim[0].any()) or (side.stop < shape[axis] and rim[-1].any()):
            return False
    return True


def _part(touches: BoolArray) -> Part:
    """The box about what touches, with a margin, of sizes that are shared by many contacts and quick to transform."""
    from scipy.fft import next_fast_len

    out = []
    for axis in (0, 1):
        count = touches.shape[axis]
        at = np.flatnonzero(touches.any(axis=1 - axis))
        low, high = (int(at[0]), int(at[-1])) if at.size else (0, count - 1)
        size = min(count, 2 * next_fast_len((high - low + 2) // 2 + _MARGIN, real=True))
        first = int(np.clip((low + high + 1 - size) // 2, 0, count - size))
        out.append(slice(first, first + size))
    return out[0], out[1]


def finer(pressure: FloatArray) -> tuple[FloatArray, BoolArray]:
    """A start on a grid twice as fine, and who may touch there.

    At the rim the square of the pressure falls in a straight line, so the square is interpolated; beyond the rim it is
    continued by that line, below 0, and tells where between two nodes the contact ends.
    """
    square = pressure**2
    n, k = square.shape
    wide = np.pad(square, 2)
    rim = np.zeros((n, k), dtype=bool)
    touch = wide > 0
    outside = ~touch[2:-2, 2:-2]
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            if i or j:
                rim |= touch[2 + i : 2 + i + n, 2 + j : 2 + j + k]
    rim &= outside
    at = np.flatnonzero(rim)
    row, column = np.unravel_index(at, (n, k))
    total, lines = np.zeros(at.size), np.zeros(at.size)
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            if i or j:
                one = wide[row + 2 + i, column + 2 + j]
                two = wide[row + 2 + 2 * i, column + 2 + 2 * j]
                both = (one > 0) & (two > 0)
                total += np.where(both, 2 * one - two, 0.0)
                lines += both
    square.flat[at] = np.minimum(total / np.maximum(lines, 1.0), 0.0)
    out = between(square)
    return np.sqrt(np.maximum(out, 0.0)), out > 0


def between(values: FloatArray) -> FloatArray:
    """Bilinear values (..., 2 n, 2 k) at nodes of half the step, of which two stand about each node."""
    for axis in (-2, -1):
        values = np.moveaxis(values, axis, 0)
        out = np.empty((2 * len(values), *values.shape[1:]))
        shares = 0.25 * np.concatenate([values[:1], values, values[-1:]])
        np.add(shares[:-2], 3 * shares[1:-1], out=out[::2])
        np.add(shares[2:], 3 * shares[1:-1], out=out[1::2])
        values = np.moveaxis(out, 0, axis)
    return np.ascontiguousarray(values)


def finer_drag(shear: FloatArray, held: FloatArray, finer_held: FloatArray) -> tuple[FloatArray, BoolArray]:
    """A start on a grid twice as fine, and who may stick there, for the drag friction holds there.

    What friction still holds falls to 0 at the end of the stick zone as the pressure does at the rim (`finer`). The
    direction is that of the coarse drag, also one node beyond it.
    """
    size = np.sqrt((shear**2).sum(axis=0))
    left = held - size
    left, sticks = finer(np.where(left > _AT_BOUND * held, left, 0.0))
    unit = shear / np.where(size > 0, size, np.inf)
    wide = np.pad(unit, ((0, 0), (1, 1), (1, 1)))
    rows = wide[:, :-2] + wide[:, 1:-1] + wide[:, 2:]
    unit = np.where(size > 0, unit, rows[..., :-2] + rows[..., 1:-1] + rows[..., 2:])
    unit /= np.maximum(np.sqrt((unit**2).sum(axis=0)), 1e-300)
    q = between(unit)
    size = np.sqrt((q**2).sum(axis=0))
    length = np.maximum(finer_held - np.where(sticks, left, 0.0), 0.0)
    return q * (length / np.where(size > 0, size, np.inf)), sticks & (finer_held > 0)
