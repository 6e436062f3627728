"""A contact on an area in equilibrium on a grid: from coarse grids to fine ones, the pressure and then the shear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..._check import FloatArray
from ..._frozen import Frozen
from ..bounded import BoolArray
from .influence import AreaInfluence
from .load import Asked
from .normal import Pressed, finer, pressed

__all__ = ["AreaBalance", "AreaCase", "equilibrium"]

_COARSEST = 32
_SAFE = 0.7
"""Share of the tolerance to which the pressure is solved: the scale is a guess."""
_ROUGH = 100.0
"""Times the tolerance to which a coarse grid is solved: it is only a start."""
_MARGIN = 4
_EVEN = 16

Gap = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class AreaCase(Frozen):
    """A problem on a grid: nodes `y`, `z` from the body's centre, the gap `height` there, infinite where no body is.

    `shift` is the slip's starting point, the displacement along the surface less the body's, of the state before [m].
    """

    influence: AreaInfluence
    step: float
    y: FloatArray
    z: FloatArray
    height: FloatArray
    load: Asked
    shift: FloatArray
    tolerance: float
    gap: Gap

    @property
    def cell(self) -> float:
        """Area of a node [m^2]."""
        return self.step**2

    def coarser(self) -> AreaCase:
        """The same on every other node."""
        return replace(
            self,
            influence=self.influence.coarser,
            step=2 * self.step,
            y=self.y[::2],
            z=self.z[::2],
            height=self.height[::2, ::2],
            shift=self.shift[:, ::2, ::2],
            tolerance=self.tolerance,
        )

    def rigid(self, slide: FloatArray, twist: float) -> FloatArray:
        """Displacement of the body along the surface [m], (2, n, k)."""
        out = np.empty((2, *self.height.shape))
        out[0] = slide[0] - twist * self.z
        out[1] = slide[1] + twist * self.y[:, None]
        return out


@dataclass(frozen=True, eq=False)
class AreaBalance(Frozen):
    """Pressure (n, k) and shear (2, n, k) at the nodes [Pa], and the body's position; a start, or a solution.

    `products` is the number of products by the influence on the finest grid, of the pressure's and the shear's solve.
    """

    pressure: FloatArray
    shear: FloatArray
    touches: BoolArray
    depth: float
    tilt: FloatArray
    slide: FloatArray
    twist: float
    scale: float
    products: tuple[int, int] = (0, 0)


def equilibrium(case: AreaCase, start: AreaBalance | None = None) -> AreaBalance:
    """Equilibrium on the grid of `case`; without a start by way of coarser grids."""
    n, k = case.height.shape
    if start is None and min(n, k) >= 2 * _COARSEST and not n % 2 and not k % 2:
        rough = replace(case.coarser(), tolerance=min(_ROUGH * case.tolerance, 1e-3))
        coarse = equilibrium(rough)
        pressure, touches = finer(coarse.pressure)
        start = replace(coarse, pressure=pressure, touches=touches, shear=np.zeros((2, n, k)))
    return _normal(case, _first(case) if start is None else start)


def _first(case: AreaCase) -> AreaBalance:
    """By force everything touches, by depth what the undeformed skin would; and nothing is known."""
    load, shape = case.load, case.height.shape
    touches = np.isfinite(case.height)
    if load.depth is not None:
        beneath = case.height - _leaning(case, load.tilt) < load.depth
        touches = beneath if beneath.any() else touches
        level = load.depth / (case.influence.own * max(min(shape), 2))
    else:
        level = float(load.force or 0.0) / (max(int(touches.sum()), 1) * case.cell)
    p = level * touches
    scale = float(case.influence.normal(p).max())
    return AreaBalance(p, np.zeros((2, *shape)), touches, 0.0, load.tilt, np.zeros(2), 0.0, scale)


def _leaning(case: AreaCase, tilt: FloatArray) -> FloatArray:
    return np.asarray(tilt[0] * case.y[:, None] + tilt[1] * case.z)


def _normal(case: AreaCase, state: AreaBalance, lifted: FloatArray | float = 0.0) -> AreaBalance:
    """The pressure beneath the body, the shear being what it is."""
    load, body = case.load, np.isfinite(case.height)
    f = np.where(body, case.height, 0.0) + lifted
    rows: list[FloatArray] = []
    targets: list[float] = []
    if load.force is None:
        f -= float(load.depth or 0.0)
    else:
        rows.append(np.full((1, 1), case.cell))
        targets.append(load.force)
    if load.moment is None:
        if load.tilt.any():
            f -= _leaning(case, load.tilt)
    else:
        rows += [case.cell * case.y[:, None], case.cell * case.z[None, :]]
        targets += list(load.moment)
    limit = _SAFE * case.tolerance * state.scale
    found, part = _on_part(case, f, body, rows, np.array(targets), state, limit)
    pressure, touches = np.zeros(f.shape), np.zeros(f.shape, dtype=bool)
    pressure[part], touches[part] = found.pressure, found.touches
    at = list(found.multipliers * case.cell)
    depth = float(load.depth or 0.0) if load.force is None else float(at.pop(0))
    tilt = load.tilt if load.moment is None else np.array(at)
    top = float(pressure.max(initial=0.0))
    scale = max(abs(depth), case.influence.own * top) if top else state.scale
    return replace(
        state, pressure=pressure, touches=touches, depth=depth, tilt=tilt, scale=scale,
        products=(found.products, state.products[1]),
    )  # fmt: skip


def _on_part(
    case: AreaCase,
    f: FloatArray,
    body: BoolArray,
    rows: list[FloatArray],
    targets: FloatArray,
    state: AreaBalance,
    limit: float,
) -> tuple[Pressed, tuple[slice, slice]]:
    """Solve on the part of the grid that a start touches, and a margin; on all of it where that is not enough."""
    part = _part(state.touches)
    while True:
        shape = (part[0].stop - part[0].start, part[1].stop - part[1].start)
        sums = [row[part[0] if row.shape[0] > 1 else slice(None), part[1] if row.shape[1] > 1 else slice(None)] for row in rows]
        found = pressed(
            case.influence.cropped(shape), np.ascontiguousarray(f[part]), body[part], sums, targets,
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


def _part(touches: BoolArray) -> tuple[slice, slice]:
    """The box about what touches, with a margin, of sizes that are shared by many contacts."""
    out = []
    for axis in (0, 1):
        count = touches.shape[axis]
        at = np.flatnonzero(touches.any(axis=1 - axis))
        low, high = (int(at[0]), int(at[-1])) if at.size else (0, count - 1)
        size = min(count, -(-(high - low + 1 + 2 * _MARGIN) // _EVEN) * _EVEN)
        first = int(np.clip((low + high + 1 - size) // 2, 0, count - size))
        out.append(slice(first, first + size))
    return out[0], out[1]
