"""A contact on an area in equilibrium on a grid: from coarse grids to fine ones, the pressure and then the shear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .._check import FloatArray
from .case import Balance, BoolArray, Case, settled
from .influence import Influence
from .lateral import Dragged, dragged, finer_drag
from .normal import Pressed, finer, pressed
from .quarter import corner, quarter, unfolded, with_parity

__all__ = ["equilibrium"]

_COARSEST = 32
_SAFE = 0.7
"""Share of the tolerance to which the pressure is solved: the scale is a guess."""
_ROUGH = 100.0
"""Times the tolerance to which a coarse grid is solved: it is only a start."""
_MARGIN = 4
_SAME = 1e-3
"""Share of what counts by which both sides may differ and are still called the same."""
_PARITIES = ((False, False), (True, True), (False, True))
"""Whether q_y is odd along y and along z beneath a drag along y, a drag along z, a torsion."""
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
    limit = _SAFE * case.tolerance * state.scale
    part = _part(touch)
    shape, box = (part[0].stop - part[0].start, part[1].stop - part[1].start), (slice(None), *part)
    found = _dragged(
        op.cropped(shape), (w - rigid)[box], held[part], (case.y[part[0]], case.z[part[1]]), targets, start[box],
        sticks[part], limit,
    )  # fmt: skip
    shear = np.zeros(w.shape)
    shear[box] = found.shear
    motion = given + found.motion
    sticks = np.zeros(p.shape, dtype=bool)
    sticks[part] = found.sticks
    steps = state.after(shear=found.products)
    return replace(state, shear=shear, slide=motion[:2], twist=float(motion[2]), steps=steps, sticks=sticks)


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
    limit = _SAFE * case.tolerance * state.scale
    found, part = _on_part(case, f, body, targets, state, limit)
    pressure, touches = np.zeros(f.shape), np.zeros(f.shape, dtype=bool)
    pressure[part], touches[part] = found.pressure, found.touches
    motion = given + found.motion
    depth, tilt = float(motion[0]), motion[1:]
    top = float(pressure.max(initial=0.0))
    scale = max(abs(depth), case.influence.own * top) if top else state.scale
    steps = state.after(pressure=found.products)
    return replace(state, pressure=pressure, touches=touches, depth=depth, tilt=tilt, scale=scale, steps=steps)


def _on_part(
    case: Case, f: FloatArray, body: BoolArray, targets: FloatArray, state: Balance, limit: float
) -> tuple[Pressed, tuple[slice, slice]]:
    """Solve on the part of the grid that a start touches, and a margin; on all of it where that is not enough."""
    part = _part(state.touches)
    while True:
        nodes = case.y[part[0]], case.z[part[1]]
        shape = (part[0].stop - part[0].start, part[1].stop - part[1].start)
        found = _pressed(
            case.influence.cropped(shape), np.ascontiguousarray(f[part]), body[part], nodes, targets,
            state.pressure[part], state.touches[part], limit,
        )  # fmt: skip
        if shape == f.shape:
            return found, part
        rim = found.touches.copy()
        rim[1:-1, 1:-1] = False
        whole = np.zeros(f.shape, dtype=bool)
        whole[part] = rim
        inner = np.zeros(f.shape, dtype=bool)
        inner[1:-1, 1:-1] = True
        if not (whole & inner).any():
            return found, part
        part = (slice(0, f.shape[0]), slice(0, f.shape[1]))


def _pressed(
    op: Influence,
    f: FloatArray,
    body: BoolArray,
    nodes: tuple[FloatArray, FloatArray],
    targets: FloatArray,
    start: FloatArray,
    touches: BoolArray,
    limit: float,
) -> Pressed:
    """As `pressed`, on a quarter where that says all."""
    even = not np.nan_to_num(targets[1:]).any() and _centred(nodes)
    even = even and not (body != body[::-1]).any() and not (body != body[:, ::-1]).any()
    if not even or not with_parity(f, (False, False), _SAME * limit):
        return pressed(op, f, body, nodes, targets, start, touches, limit)
    n, k = (count // 2 for count in f.shape)
    found = pressed(
        quarter(op), corner(f), corner(body), (nodes[0][n:], nodes[1][k:]),
        np.array([0.25 * targets[0], np.nan, np.nan]), corner(start), corner(touches), limit,
    )  # fmt: skip
    return replace(found, pressure=unfolded(found.pressure), touches=unfolded(found.touches))


def _dragged(
    op: Influence,
    w: FloatArray,
    held: FloatArray,
    nodes: tuple[FloatArray, FloatArray],
    targets: FloatArray,
    start: FloatArray,
    sticks: BoolArray,
    limit: float,
) -> Dragged:
    """As `dragged`, on a quarter where that says all: what is asked for and what moves have one parity."""
    if _centred(nodes) and with_parity(held, (False, False), 0.0):
        for at, odd in enumerate(_PARITIES):
            asked = np.nan_to_num(np.delete(targets, at)).any()
            other = (not odd[0], not odd[1])
            if asked or not (with_parity(w[0], odd, _SAME * limit) and with_parity(w[1], other, _SAME * limit)):
                continue
            n, k = (count // 2 for count in held.shape)
            kept = np.full(3, np.nan)
            kept[at] = 0.25 * targets[at]
            found = dragged(
                quarter(op, odd), corner(w), corner(held), (nodes[0][n:], nodes[1][k:]), kept, corner(start),
                corner(sticks), limit,
            )  # fmt: skip
            shear = np.stack([unfolded(found.shear[0], odd), unfolded(found.shear[1], other)])
            return replace(found, shear=shear, sticks=unfolded(found.sticks))
    return dragged(op, w, held, nodes, targets, start, sticks, limit)


def _centred(nodes: tuple[FloatArray, FloatArray]) -> bool:
    """Whether nodes stand in pairs on either side of both axes."""
    return all(at.size % 2 == 0 and np.abs(at + at[::-1]).max() <= _SAME * (at[1] - at[0]) for at in nodes)


def _part(touches: BoolArray) -> tuple[slice, slice]:
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
