"""A contact on an area in equilibrium on a grid: from coarse grids to fine ones, the pressure and then the shear."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..errors import GeometryError
from .bounded import solved
from .case import Answered, Balance, BoolArray, Case, settled
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
    return settled(case, _first(case) if start is None else start, _solved)


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


def _solved(case: Case, state: Balance, w: FloatArray, bound: npt.NDArray[Any], targets: FloatArray) -> Answered:
    """As `Solve`, on the part of the grid that a start touches, and a margin; on all of it where that is not enough."""
    start, free, part = state.pressure, state.touches, _part(state.touches)
    if w.ndim == 3:
        (start, free), part = _rubbing(state, bound, float(case.load.friction or 0.0)), _part(bound > 0)
    limit = _SAFE * case.tolerance * state.scale
    whole = Problem(case.influence, w, bound, case.axes, targets, start, free, limit)
    found = solved(whole.on(part))
    if w.ndim == 2 and not _within(found.free, part, bound.shape):
        part = (slice(0, bound.shape[0]), slice(0, bound.shape[1]))
        found = solved(whole.on(part))
    x, free = np.zeros(w.shape), np.zeros(bound.shape, dtype=bool)
    x[..., *part], free[part] = found.x, found.free
    return replace(found, x=x, free=free)


def _rubbing(state: Balance, held: FloatArray, mu: float) -> tuple[FloatArray, BoolArray]:
    """A drag to start from, and who may stick."""
    if state.rough is not None:
        return finer_drag(state.rough.shear, mu * state.rough.pressure, held)
    if state.sticks is not None:
        return state.shear, state.sticks
    return state.shear, (held > 0) & ((np.hypot(*state.shear) < held * (1 - _AT_BOUND)) | (not state.shear.any()))


def _first(case: Case) -> Balance:
    """What lies lower than half the approach touches, as beneath a sphere, under a pressure as round as there."""
    load, op = case.load, case.influence
    low = case.height - case.leaning(load.tilt)
    rises = np.sort(low[np.isfinite(low)])
    if not rises.size:
        rule = "some nodes of a grid have to lie beneath the body"
        raise GeometryError(f"a grid of steps of {1e3 * case.cell**0.5:.3g} mm", rule, "nodes=512, or a wider body")
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
