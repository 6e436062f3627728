"""A contact in equilibrium on a grid: pressure and shear by turns, from coarse grids to fine ones.

The pressure makes the least of (p K p) / 2 + h p with p >= 0, where h is the gap of the undeformed bodies and of what
the shear lifts; the shear makes the least of (q K q) / 2 + w q within -mu p <= q <= mu p, where w is the slip that the
pressure, the indenter and the past would cause. Where the two do not disturb each other (nu = 1/2 on a half plane) one
turn is exact. Source: docs/pressing.md; Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), chapter 4.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .._check import FloatArray
from .._frozen import Frozen
from .bounded import BoolArray, Problem, finer
from .influence import Influence

__all__ = ["Balance", "Case", "Mixer", "Prescribed", "solve"]

_COARSEST = 128
_BY = 4
_SAFE = 0.5
"""Share of the tolerance to which each part is solved, for a contact has two, and the scale is a guess."""
_ROUNDS = 100
_MEMORY = 5
_WORSE = 3.0
"""A turn that leaves so many times the least change so far makes the past forgotten."""


@dataclass(frozen=True)
class Prescribed:
    """What is prescribed: force or depth, moment or tilt, tangential force or slide; None for what is found.

    Units as in `press`; `friction` is None where there is none.
    """

    force: float | None
    depth: float | None
    moment: float | None
    tilt: float
    tangential: float | None
    slide: float | None
    friction: float | None


@dataclass(frozen=True)
class Case(Frozen):
    """A problem on a grid: nodes `y` from the indenter's centre, the gap `height` there, infinite where no body is.

    `shift` is the slip's starting point, u_y - slide of the state before [m]; `profile` gives `height` at any position.
    """

    influence: Influence
    step: float
    y: FloatArray
    height: FloatArray
    load: Prescribed
    shift: FloatArray
    tolerance: float
    profile: Callable[[FloatArray], FloatArray]
    datum: float | None = None

    def coarser(self, by: int) -> Case:
        """The same on every `by`-th node."""
        return replace(
            self,
            influence=self.influence.coarser(by),
            step=self.step * by,
            y=self.y[::by],
            height=self.height[::by],
            shift=self.shift[::by],
        )


@dataclass(frozen=True)
class Balance(Frozen):
    """Pressure and shear at the nodes [Pa], and the indenter's position; what a grid's solution starts from, or is.

    `touches` and `sticks` are the nodes whose pressure or shear is between its bounds. depth and slide count from an
    unknown zero where the skin has no ground.
    """

    pressure: FloatArray
    shear: FloatArray
    touches: BoolArray
    sticks: BoolArray
    depth: float
    tilt: float
    slide: float
    scale: float
    steps: int

    def finer(self, count: int, by: int, periodic: bool) -> Balance:
        """A start on the finer grid: also the nodes between free and fixed ones are free."""
        p, q = (finer(v, count, by, periodic) for v in (self.pressure, self.shear))
        touches, sticks = (finer(v.astype(np.float64), count, by, periodic) > 0 for v in (self.touches, self.sticks))
        return replace(self, pressure=p, shear=q, touches=touches, sticks=sticks)


def solve(case: Case, start: Balance | None = None) -> Balance:
    """Equilibrium on the grid of `case`; without a start, by way of coarser grids."""
    count, periodic = case.influence.count, case.influence.periodic
    if start is None and count >= _BY * _COARSEST:
        rough = case.coarser(_BY)
        coarse = solve(rough)
        moved = float(np.abs(rough.influence.apply(0, 0, coarse.pressure)).max())
        start = replace(coarse.finer(count, _BY, periodic), scale=max(moved, 1e-3 * coarse.scale))
    found = _settle(case, _first(case) if start is None else start)
    for values in (found.pressure, found.shear):
        values.flags.writeable = False
    return found


def _first(case: Case) -> Balance:
    """By force everything touches, by depth what the undeformed skin would; and nothing is known."""
    count, load = case.y.size, case.load
    touches = np.isfinite(case.height)
    if load.depth is not None:
        beneath = case.height - load.tilt * case.y < load.depth
        touches = beneath if beneath.any() else touches
        level = load.depth / case.influence.longest
    else:
        level = float(load.force or 0.0) / (max(int(touches.sum()), 1) * case.step)
    own = float(case.influence.rows[0, 0, 0] - case.influence.rows[0, 0, 1])
    p = level * touches
    # an even pressure, repeated, moves nothing but the mean; a node's own would
    scale = max(float(np.abs(case.influence.apply(0, 0, p)).max()), own * float(p.max()))
    return Balance(p, np.zeros(count), touches, touches, 0.0, load.tilt, 0.0, scale, 0)


def _settle(case: Case, start: Balance) -> Balance:
    """Pressure and shear in turn until neither disturbs the other.

    Turn by turn the disturbance falls by a factor that is poor where the two are strongly coupled (a stiff skin on a
    soft one bends, and drags itself along); so the next one is extrapolated from the last few.
    """
    load, op = case.load, case.influence
    body = np.isfinite(case.height)
    height = np.where(body, case.height, 0.0)
    state, limit = start, _SAFE * case.tolerance * start.scale
    rubs = load.friction is not None
    lifted = op.apply(0, 1, state.shear) if rubs else np.zeros(case.y.size)
    mixer = Mixer()
    for _ in range(_ROUNDS):
        state = _normal(case, state, height + lifted, body, limit)
        if not rubs:
            break
        state = _tangential(case, state, limit)
        if not op.coupled:
            break
        change = op.apply(0, 1, state.shear) - lifted
        if load.force is not None and state.touches.any():
            even = float(change[state.touches].mean())
            change -= even
            state = replace(state, depth=state.depth + even)
        if np.abs(change[state.touches]).max(initial=0.0) <= limit:
            break
        lifted = mixer.next(lifted, change)
    return state


class Mixer:
    """Anderson's extrapolation of a fixed-point iteration (Walker and Ni 2011)."""

    def __init__(self) -> None:
        self.positions: list[FloatArray] = []
        self.changes: list[FloatArray] = []
        self.least = np.inf

    def next(self, position: FloatArray, change: FloatArray) -> FloatArray:
        """Where to go from `position`, whose own step is `change`."""
        size = float(np.abs(change).max())
        if size > _WORSE * self.least:
            self.positions, self.changes = [], []
            self.least = size
            return position + 0.5 * change
        self.least = min(self.least, size)
        self.positions, self.changes = ([*self.positions[-_MEMORY:], position], [*self.changes[-_MEMORY:], change])
        if len(self.positions) == 1:
            return position + change
        moves, turns = np.diff(self.positions, axis=0), np.diff(self.changes, axis=0)
        weights = np.linalg.lstsq(turns.T, change, rcond=1e-10)[0]
        return np.asarray(position + change - weights @ (moves + turns))


def _normal(case: Case, state: Balance, gap: FloatArray, body: BoolArray, limit: float) -> Balance:
    """The pressure beneath the indenter, the shear being what it is."""
    load, y = case.load, case.y
    f, rows, targets = gap, [], []
    if load.force is None:
        f = f - float(load.depth or 0.0)
    else:
        rows.append(np.full(y.size, case.step))
        targets.append(load.force)
    if load.moment is None:
        f = f - load.tilt * y
    else:
        rows.append(case.step * y)
        targets.append(load.moment)
    sums = np.array(rows).reshape(len(rows), y.size)
    high = np.where(body, np.inf, 0.0)
    problem = Problem(case.influence, 0, f, np.zeros(y.size), high, sums, np.array(targets))
    found = problem.minimise(state.pressure, state.touches, limit)
    positions = list(found.multipliers * case.step)
    depth = float(load.depth or 0.0) if load.force is None else float(positions.pop(0))
    tilt = load.tilt if load.moment is None else float(positions.pop(0))
    steps = state.steps + found.steps
    return replace(state, pressure=found.x, touches=found.free, depth=depth, tilt=tilt, steps=steps)


def _tangential(case: Case, state: Balance, limit: float) -> Balance:
    """The shear within what friction holds, the pressure being what it is."""
    load, op, p = case.load, case.influence, state.pressure
    mu = float(load.friction or 0.0)
    held = mu * p if np.isfinite(mu) else np.where(p > 0, np.inf, 0.0)
    slip = op.apply(1, 0, p) - case.shift
    count = p.size
    free = state.sticks & (p > 0) if np.isfinite(mu) else p > 0
    if load.slide is None:
        most, drag = float(held.sum() * case.step), float(load.tangential or 0.0)
        if abs(drag) >= most * (1 - 1e-12):
            q = np.copysign(1.0, drag) * held
            moved = slip + op.apply(1, 1, q)
            sticks = np.zeros(count, dtype=bool)
            # the slide at which the last node lets go
            over = moved[held > 0]
            slide = float(over.max() if drag > 0 else over.min()) if over.size else 0.0
            return replace(state, shear=q, sticks=sticks, slide=slide)
        sums, targets = np.full((1, count), case.step), np.array([drag])
    else:
        slip = slip - load.slide
        sums, targets = np.zeros((0, count)), np.zeros(0)
    problem = Problem(op, 1, slip, -held, held, sums, targets)
    found = problem.minimise(state.shear, free, min(mu, 1.0) * limit)
    slide = load.slide if load.slide is not None else float(found.multipliers[0] * case.step)
    return replace(state, shear=found.x, sticks=found.free, slide=slide, steps=state.steps + found.steps)
