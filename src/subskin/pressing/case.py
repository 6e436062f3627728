"""A contact: what is prescribed, the problem on a grid, and its solution, pressure and shear by turns.

The pressure makes the least of (p K p) / 2 + h p with p >= 0, where h is the gap of the undeformed bodies and of what
the shear lifts; the shear makes the least of (q K q) / 2 + w q within |q| <= mu p, where w is the slip that the
pressure, the indenter and the past would cause. Where the two do not disturb each other (nu = 1/2 on a half plane) one
turn is exact. Source: docs/pressing.md; Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), chapter 4.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import hypot
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..errors import InvalidValueError
from .influence import Influence

__all__ = ["Answered", "Asked", "Balance", "BoolArray", "Case", "Mixer", "along_axes", "asked", "hats", "settled"]

BoolArray: TypeAlias = npt.NDArray[np.bool_]

_ROUNDS = 100
_SETTLED = 0.5
"""Share of the tolerance to which the two agree."""
_MEMORY = 5
_WORSE = 3.0
"""A turn that leaves so many times the least change so far makes the past forgotten."""
_LEAST, _MOST = 1e-30, 1e30
"""Forces and depths between which no product of them overflows."""
_UNITS = {
    "force": ("N/m", "N"), "depth": ("m", "m"), "torsion": ("", "N m"), "twist": ("", "rad"), "moment": ("N", "N m"),
    "tilt": ("rad", "rad"), "tangential": ("N/m", "N"), "slide": ("m", "m"),
}  # fmt: skip
"""Units of a long body and of one on an area."""
_ALONG = ("moment", "tilt", "tangential", "slide")
"""What has a component along each axis of the surface."""
_EITHER = (("moment", "tilt"), ("tangential", "slide"), ("torsion", "twist"))


@dataclass(frozen=True, eq=False)
class Asked(Frozen):
    """What is prescribed, None for what is found; components along the axes of the surface have the shape (d,).

    Units as in `press`. Without friction, which is None then, nothing is dragged. A long body does not turn about x:
    its `twist` is 0.
    """

    force: float | None
    depth: float | None
    moment: FloatArray | None
    tilt: FloatArray
    tangential: FloatArray | None
    slide: FloatArray | None
    torsion: float | None
    twist: float | None
    friction: float | None


def asked(axes: int, *, friction: float | None, **given: Any) -> Asked:
    """`given` are the other fields, each None where it is left out, of a body on a surface of so many `axes`.

    Raises
    ------
    InvalidValueError
        Values that are not numbers or pairs of them, or that exclude each other.
    """
    if (given["force"] is None) == (given["depth"] is None):
        seen, fix = f"force = {given['force']}, depth = {given['depth']}", ("force=40.0", "force=1.5")[axes - 1]
        raise InvalidValueError(seen, "one of the two has to be given", f"{fix}, or depth=0.1e-3")
    values: dict[str, Any] = {}
    for name, value in given.items():
        read, unit = along_axes if name in _ALONG else _number, _UNITS[name][axes - 1]
        if axes == 1 and name in _EITHER[2] and value is not None:
            raise InvalidValueError(f"{name} = {value}", "a long body does not turn about x", f"leave out {name}")
        values[name] = None if value is None else read(name, value, unit, axes)
    values["tilt"] = np.zeros(axes) if values["tilt"] is None else values["tilt"]
    for one, other in _EITHER:
        if given[one] is not None and given[other] is not None and (other != "tilt" or values["tilt"].any()):
            seen = f"{one} = {given[one]}, {other} = {given[other]}"
            raise InvalidValueError(seen, "one of the two can be given", "leave out one of them")
    if friction is None:
        for name in (*_EITHER[1], *_EITHER[2]):
            if given[name] is not None and np.any(values[name]):
                seen, rule = f"{name} = {given[name]}", "nothing is dragged without friction"
                raise InvalidValueError(seen, rule, "give friction=, e.g. 0.5")
            values[name] = None
        return Asked(**values, friction=None)
    grip = _check.scalar("friction", friction, at_least=0.0, finite=axes == 2)
    for name in ("tangential", "torsion"):
        if grip == 0 and np.any(values[name]):
            seen = f"{name} = {given[name]} {_UNITS[name][axes - 1]} at friction = 0"
            raise InvalidValueError(seen, "nothing holds that drag", "friction > 0")
    if values["tangential"] is None and values["slide"] is None:
        values["tangential"] = np.zeros(axes)
    if values["torsion"] is None and values["twist"] is None:
        values["twist" if axes == 1 or values["slide"] is not None else "torsion"] = 0.0
    return Asked(**values, friction=grip)


def along_axes(name: str, value: Any, unit: str, axes: int, **limits: Any) -> FloatArray:
    """One number of a long body, or two along (y, z), as an array (d,)."""
    if axes == 1:
        return np.array([_check.scalar(name, value, unit=unit, **limits)])
    both = _check.real(name, value, unit=unit, **limits)
    if both.shape != (2,):
        seen = f"{name} of shape {both.shape}"
        raise InvalidValueError(seen, "on an area it has two components, along y and z", f"{name}=(1e-3, 0.0)")
    return both


def _number(name: str, value: Any, unit: str, axes: int) -> float:
    number = _check.scalar(name, value, unit=unit)
    if name not in ("force", "depth"):
        return number
    if not number > 0:
        seen = f"{name} = {number:.6g} {unit}"
        raise InvalidValueError(seen, "the indenter never touches the skin", f"give a {name} > 0")
    return _check.scalar(name, value, unit=unit, at_least=_LEAST, at_most=_MOST)


@dataclass(frozen=True, eq=False)
class Case(Frozen):
    """A problem on a grid of square cells: nodes along y, on an area along y and z, from the body's centre.

    `height` is the gap there, infinite where no body is, and `gap` gives it at any position. `shift` (d, ...) is the
    slip's starting point, the displacement along the surface less the body's, of the state before [m].
    """

    influence: Influence
    step: float
    axes: tuple[FloatArray, ...]
    height: FloatArray
    load: Asked
    shift: FloatArray
    tolerance: float
    gap: Callable[..., FloatArray]
    datum: float | None = None

    @property
    def y(self) -> FloatArray:
        """Nodes along y [m]."""
        return self.axes[0]

    @property
    def z(self) -> FloatArray:
        """Nodes along z [m], on an area."""
        return self.axes[1]

    @property
    def cell(self) -> float:
        """Area of a node [m^2]; on a row its length [m]."""
        return self.step ** len(self.axes)

    @cached_property
    def body(self) -> tuple[BoolArray, FloatArray]:
        """Where the body is, and the gap there, 0 elsewhere."""
        on = np.isfinite(self.height)
        return on, np.where(on, self.height, 0.0)

    @cached_property
    def rows(self) -> FloatArray:
        """On a row 1 and y at its nodes, whose products with a traction are its sums, (2, n)."""
        return np.array([np.ones(self.y.size), self.y])

    @property
    def mesh(self) -> tuple[FloatArray, ...]:
        """The nodes along each axis, of shapes that broadcast to the grid's."""
        return self.axes if len(self.axes) == 1 else (self.y[:, None], self.z)

    def leaning(self, tilt: FloatArray) -> FloatArray:
        """By how much a body that leans is lower [m]."""
        parts = [by * at for by, at in zip(tilt, self.mesh, strict=True)]
        return np.asarray(parts[0] if len(parts) == 1 else parts[0] + parts[1])

    def rigid(self, slide: FloatArray, twist: float) -> FloatArray:
        """Displacement of the body along the surface [m], (d, ...), of one length where it does not turn."""
        if not twist:
            return slide.reshape(-1, *[1] * len(self.axes))
        (y, z), out = self.mesh, np.empty((2, *self.height.shape))
        out[0] = slide[0] - twist * z
        out[1] = slide[1] + twist * y
        return out

    def arms(self, values: FloatArray) -> FloatArray:
        """Moments (d,) of a map, along each axis."""
        every = range(len(self.axes))
        sums = [values.sum(axis=tuple(other for other in every if other != axis)) @ self.axes[axis] for axis in every]
        return np.array(sums) * self.cell

    def turning(self, shear: FloatArray) -> float:
        """Moment of a drag about x; a row has none."""
        if len(shear) == 1:
            return 0.0
        return float(shear[1].sum(axis=1) @ self.y - shear[0].sum(axis=0) @ self.z) * self.cell


@dataclass(frozen=True, eq=False)
class Balance(Frozen):
    """Pressure (...) and shear (d, ...) at the nodes [Pa], and the body's position; a start, or a solution.

    `touches` and `sticks` are the nodes whose pressure or shear is between its bounds, `sticks` None where that is
    not known. depth and slide count from an unknown zero where the skin has no ground. `steps` are those of the
    pressure's and of the shear's solves: on a row of conjugate gradients, on an area products on the finest grid.
    `rough` is the coarser grid's solution from which a start on an area comes.
    """

    pressure: FloatArray
    shear: FloatArray
    touches: BoolArray
    depth: float
    tilt: FloatArray
    slide: FloatArray
    twist: float
    scale: float
    sticks: BoolArray | None = None
    steps: tuple[int, int] = (0, 0)
    rough: Balance | None = None


def hats(nodes: FloatArray, step: float, at: FloatArray) -> FloatArray:
    """By how much each of `nodes`, `step` apart, stands for what is given at other positions (nodes, at)."""
    return np.maximum(1 - np.abs(nodes[:, None] - at) / step, 0.0)


@dataclass(frozen=True, eq=False)
class Answered(Frozen):
    """Tractions, by how much the body moves for the sums that are given, who is not at a bound, and the steps."""

    x: FloatArray
    motion: FloatArray
    free: BoolArray
    steps: int


Solve: TypeAlias = Callable[[Case, Balance, FloatArray, npt.NDArray[Any], FloatArray], Answered]
"""The least of x K x / 2 + w x, from w, what bounds x, and its sums over the nodes, NaN where none is given.

Of a pressure w is a gap (...), bounded by where the body is, and the sums are those of p and of p along each axis. Of a
drag w is a slip (d, ...), bounded by what is held, and the sums are its own and, on an area, its moment about x.
"""


def settled(case: Case, start: Balance, solve: Solve) -> Balance:
    """Pressure (with the gap that the shear lifts) and shear in turn until neither disturbs the other.

    Turn by turn the disturbance falls by a factor that is poor where the two are strongly coupled (a stiff skin on a
    soft one bends, and drags itself along); so the next one is extrapolated from the last few.
    """
    op, load, limit = case.influence, case.load, _SETTLED * case.tolerance * start.scale
    if load.friction is None:
        found = _pressed(case, start, np.zeros(case.height.shape), solve)
        return _closed(replace(found, shear=np.zeros(case.shift.shape), rough=None))
    state, lifted, mixer = start, op.lifted(start.shear), Mixer()
    for _ in range(_ROUNDS):
        state = _dragged(case, _pressed(case, state, lifted, solve), solve)
        if not op.coupled:
            break
        change = op.lifted(state.shear) - lifted
        if load.force is not None and state.touches.any():
            even = float(change[state.touches].mean())
            change -= even
            state = replace(state, depth=state.depth + even)
        if np.abs(change[state.touches]).max(initial=0.0) <= limit:
            break
        lifted = mixer.next(lifted.reshape(-1), change.reshape(-1)).reshape(lifted.shape)
    return _closed(state)


def _pressed(case: Case, state: Balance, lifted: FloatArray, solve: Solve) -> Balance:
    """The pressure beneath the body, the shear being what it is."""
    load, axes = case.load, len(case.axes)
    body, height = case.body
    f = height + lifted
    targets, given = np.full(1 + axes, np.nan), np.zeros(1 + axes)
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
    found = solve(case, state, f, body, targets)
    motion, scale = given + found.motion, state.scale
    if axes == 2 and (top := float(found.x.max(initial=0.0))):
        scale = max(abs(float(motion[0])), case.influence.own * top)
    depth, tilt = float(motion[0]), motion[1:]
    steps = state.steps[0] + found.steps, state.steps[1]
    return replace(state, pressure=found.x, touches=found.free, depth=depth, tilt=tilt, scale=scale, steps=steps)


def _dragged(case: Case, state: Balance, solve: Solve) -> Balance:
    """The shear within what friction holds, the pressure being what it is."""
    load, p, axes = case.load, state.pressure, len(case.axes)
    mu = float(load.friction or 0.0)
    held = mu * p if np.isfinite(mu) else np.where(p > 0, np.inf, 0.0)
    if not held.any():
        return replace(state, shear=np.zeros(case.shift.shape), sticks=np.zeros(p.shape, dtype=bool), rough=None)
    targets, given = np.full(2 * axes - 1, np.nan), np.zeros(2 * axes - 1)
    if load.slide is None:
        targets[:axes] = np.asarray(load.tangential) / case.cell
    else:
        given[:axes] = load.slide
    if load.twist is None:
        targets[axes:] = float(load.torsion or 0.0) / case.cell
    else:
        given[axes:] = load.twist
    w = case.influence.dragged(p) - case.shift
    if given.any():
        w -= case.rigid(given[:axes], float(given[axes:].sum()))
    slid = _sliding(case, state, held, w)
    if slid is not None:
        return slid
    found = solve(case, state, w, held, targets)
    motion, steps = given + found.motion, (state.steps[0], state.steps[1] + found.steps)
    slide, twist = motion[:axes], float(motion[axes:].sum())
    return replace(state, shear=found.x, sticks=found.free, slide=slide, twist=twist, steps=steps, rough=None)


def _sliding(case: Case, state: Balance, held: FloatArray, w: FloatArray) -> Balance | None:
    """All of it slides along a drag, or turns beneath a moment, that friction does not hold; None where it may."""
    load, sticks = case.load, np.zeros(held.shape, dtype=bool)
    if load.slide is None and not load.torsion and load.tangential is not None:
        size, most = hypot(*load.tangential), float(held.sum() * case.cell)
        if size >= most * (1 - 1e-12) and size > 0:
            along = (load.tangential / size).reshape(-1, *[1] * held.ndim)
            q = along * held
            # the slide at which the last node lets go
            far = float(((w + case.influence.lateral(q)) * along).sum(axis=0)[held > 0].max())
            return replace(state, shear=q, sticks=sticks, slide=far * along.ravel(), twist=0.0, rough=None)
    if load.twist is None and load.tangential is not None and not load.tangential.any() and load.torsion:
        turning = case.rigid(np.zeros(2), float(np.sign(load.torsion)))
        arm = np.hypot(*turning)
        if abs(load.torsion) >= float((held * arm).sum()) * case.cell * (1 - 1e-12):
            q = turning / np.maximum(arm, 1e-300) * held
            moved = w + case.influence.lateral(q)
            far = ((moved * turning).sum(axis=0) / np.maximum(arm, 1e-300) ** 2)[held > 0].max()
            twist = float(np.sign(load.torsion) * far)
            return replace(state, shear=q, sticks=sticks, slide=np.zeros(2), twist=twist, rough=None)
    return None


def _closed(state: Balance) -> Balance:
    for values in (state.pressure, state.shear):
        values.flags.writeable = False
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
