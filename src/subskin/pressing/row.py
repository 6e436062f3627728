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
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .case import Answered, Balance, Case, settled

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
    return settled(case, _first(case) if start is None else start, _solved)


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


def _solved(case: Case, state: Balance, w: FloatArray, bound: npt.NDArray[Any], targets: FloatArray) -> Answered:
    """As `Solve`, of a row."""
    from ._row_kernel import minimise

    op, drag, mu = case.influence, w.ndim == 2, float(case.load.friction or 0.0)
    limit = _SAFE * case.tolerance * state.scale
    if drag:
        low, high, own, limit, x = -bound, bound, op.own_lateral, min(mu, 1.0) * limit, state.shear[0]
        free = bound > 0 if state.sticks is None or not np.isfinite(mu) else state.sticks
    else:
        low, high, own, x, free = np.zeros(w.size), np.where(bound, np.inf, 0.0), op.own, state.pressure, state.touches
    given = np.isfinite(targets)
    sums = case.rows[: given.size][given]
    forward, nearly = ((spectrum, *_waves(2 * spectrum.size - 2)) for spectrum in op.circulants[int(drag)])
    x, free, motion = np.array(x), free & (high > low), np.zeros(targets.size)
    problem = w.reshape(-1), low, high, sums, targets[given], own
    motion[given], steps = minimise(forward, nearly, problem, x, free, np.empty(x.size), limit)
    return Answered(x[None] if drag else x, motion, free, int(steps))


@lru_cache(maxsize=16)
def _waves(size: int) -> tuple[FloatArray, FloatArray]:
    """exp(-2 pi i j / size), real and imaginary part."""
    wave = np.exp(-2j * np.pi * np.arange(size) / size)
    return np.ascontiguousarray(wave.real), np.ascontiguousarray(wave.imag)
