"""A contact on a row in equilibrium: the least of x K x / 2 + f x with every x between bounds and some sums given.

Both halves of a contact are of this kind: the pressure, which is not negative and carries the force, and the shear,
which friction bounds and which carries the drag. Which unknowns are at a bound is guessed, the others are found by
conjugate gradients, those that break a rule change sides, and so on: Newton's method for the complementarity
conditions (primal-dual active set; Hintermueller, Ito and Kunisch 2003). The gradients' preconditioner is the
circulant inverse of K on the free nodes alone, with the sums kept (Gould, Hribar and Nocedal 2001): two or three steps
a guess, whatever the number of nodes. A guess that is too wide halves its excess each time; so the guess on a grid
comes from one four times as coarse, with the nodes between free and fixed ones free.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from .._check import FloatArray
from .case import Balance, BoolArray, Case, settled

__all__ = ["equilibrium"]

_COARSEST = 128
_SAFE = 0.5
"""Share of the tolerance to which each part is solved, for a contact has two, and the scale is a guess."""


def equilibrium(case: Case, start: Balance | None = None) -> Balance:
    """Equilibrium on the grid of `case`; without a start, by way of coarser grids."""
    op = case.influence
    (count,), by = op.shape, op.by
    if start is None and count >= by * _COARSEST:
        rough = replace(
            case,
            influence=op.coarser,
            step=case.step * by,
            axes=(case.y[::by],),
            height=case.height[::by],
            shift=case.shift[:, ::by],
        )
        coarse = equilibrium(rough)
        moved = float(np.abs(rough.influence.normal(coarse.pressure)).max())
        maps = (coarse.pressure, coarse.shear[0], coarse.touches, np.asarray(coarse.sticks))
        p, q, touches, sticks = (_finer(values.astype(np.float64), count, by, op.periodic) for values in maps)
        start = replace(
            coarse,
            pressure=p,
            shear=q[None],
            touches=touches > 0,  # also the nodes between free and fixed ones
            sticks=sticks > 0,
            scale=max(moved, 1e-3 * coarse.scale),
        )
    return settled(case, _first(case) if start is None else start, _pressed, _dragged)


def _finer(values: FloatArray, count: int, by: int, periodic: bool) -> FloatArray:
    """The straight lines through every `by`-th node, at all `count` nodes; 0 beyond the last."""
    if not values.any():
        return np.zeros(count)
    step, out = np.empty(values.size), np.empty((values.size, by))
    step[:-1] = values[1:] - values[:-1]
    step[-1] = (values[0] if periodic else 0.0) - values[-1]
    np.multiply(step[:, None], np.arange(by) / by, out=out)
    out += values[:, None]
    return out.reshape(-1)[:count]


def _first(case: Case) -> Balance:
    """By force everything touches, by depth what the undeformed skin would; and nothing is known."""
    load, op = case.load, case.influence
    touches = np.isfinite(case.height)
    if load.depth is not None:
        beneath = case.height - case.leaning(load.tilt) < load.depth
        touches = beneath if beneath.any() else touches
        level = load.depth / op.longest
    else:
        level = float(load.force or 0.0) / (max(int(touches.sum()), 1) * case.step)
    p = level * touches
    # an even pressure, repeated, moves nothing but the mean; a node's own would
    scale = max(float(np.abs(op.normal(p)).max()), op.own * float(p.max()))
    return Balance(p, np.zeros((1, p.size)), touches, 0.0, load.tilt, np.zeros(1), 0.0, scale, touches)


def _pressed(case: Case, state: Balance, lifted: FloatArray) -> Balance:
    """The pressure beneath the indenter, the shear being what it is."""
    load, y, body = case.load, case.y, np.isfinite(case.height)
    f, rows, targets = np.where(body, case.height, 0.0) + lifted, [], []
    depth, tilt = 0.0 if load.depth is None else load.depth, load.tilt
    if load.force is None:
        f = f - depth
    else:
        rows.append(np.full(y.size, case.step))
        targets.append(load.force)
    if load.moment is None:
        f = f - case.leaning(tilt)
    else:
        rows.append(case.step * y)
        targets.append(float(load.moment[0]))
    bounds, start = (np.zeros(y.size), np.where(body, np.inf, 0.0)), (state.pressure, state.touches)
    limit = _SAFE * case.tolerance * state.scale
    p, multipliers, touches, steps = _least(case, 0, f, bounds, (rows, targets), start, limit)
    found = list(multipliers * case.step)
    if load.force is not None:
        depth = float(found.pop(0))
    if load.moment is not None:
        tilt = np.array(found)
    return replace(state, pressure=p, touches=touches, depth=depth, tilt=tilt, steps=state.after(pressure=steps))


def _dragged(case: Case, state: Balance) -> Balance:
    """The shear within what friction holds, the pressure being what it is."""
    load, op, p = case.load, case.influence, state.pressure
    mu = float(load.friction or 0.0)
    held = mu * p if np.isfinite(mu) else np.where(p > 0, np.inf, 0.0)
    w = op.dragged(p)[0] - case.shift[0]
    free = (state.sticks if np.isfinite(mu) and state.sticks is not None else True) & (p > 0)
    if load.slide is None:
        most, drag = float(held.sum() * case.step), 0.0 if load.tangential is None else float(load.tangential[0])
        if abs(drag) >= most * (1 - 1e-12):
            q = np.copysign(1.0, drag) * held[None]
            over = (w + op.lateral(q)[0])[held > 0]
            # the slide at which the last node lets go
            slide = float(over.max() if drag > 0 else over.min()) if over.size else 0.0
            return replace(state, shear=q, sticks=np.zeros(p.size, dtype=bool), slide=np.array([slide]))
        sums = [np.full(p.size, case.step)], [drag]
    else:
        w, sums = w - load.slide[0], ([], [])
    limit = min(mu, 1.0) * _SAFE * case.tolerance * state.scale
    q, multipliers, sticks, steps = _least(case, 1, w, (-held, held), sums, (state.shear[0], free), limit)
    motion = multipliers * case.step if load.slide is None else load.slide
    return replace(state, shear=q[None], sticks=sticks, slide=motion, steps=state.after(shear=steps))


def _least(
    case: Case,
    part: int,
    f: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    sums: tuple[list[FloatArray], list[float]],
    start: tuple[FloatArray, BoolArray],
    limit: float,
) -> tuple[FloatArray, FloatArray, BoolArray, int]:
    """Solve for the pressure (part 0) or the drag (1) from a start, with a first guess of who is free.

    The gradient of those comes to `limit`. Unknowns, the multipliers of the sums, who is free, and the steps it took.
    """
    from ._row_kernel import minimise

    op, (low, high), (rows, targets) = case.influence, bounds, sums
    own = op.own_lateral if part else op.own
    problem = f, low, high, np.array(rows).reshape(len(rows), f.size), np.array(targets, np.float64), own
    forward, nearly = ((spectrum, *_waves(2 * spectrum.size - 2)) for spectrum in op.circulants[part])
    x, gradient, free = np.array(start[0]), np.empty(f.size), start[1] & (high > low)
    multipliers, steps = minimise(forward, nearly, problem, x, free, gradient, limit)
    return x, multipliers, free, int(steps)


@lru_cache(maxsize=16)
def _waves(size: int) -> tuple[FloatArray, FloatArray]:
    """exp(-2 pi i j / size), real and imaginary part."""
    wave = np.exp(-2j * np.pi * np.arange(size) / size)
    return np.ascontiguousarray(wave.real), np.ascontiguousarray(wave.imag)
