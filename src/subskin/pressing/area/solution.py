"""What a press on an area gives back: the contact, the body's position, and how good both are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._frozen import Frozen
from ...contact import PressureGrid
from ...skin import Skin
from ..body import LocalIndenter
from ..bounded import BoolArray
from ..certificate import Certificate
from ..solution import PressStatus
from .balance import AreaBalance, AreaCase

__all__ = ["LocalSolution"]


@dataclass(frozen=True, eq=False)
class LocalSolution(Frozen):
    """A skin pressed on an area by a body, as `press` found it: what `ContactSolution` is in a plane.

    `skin`, `indenter` and `position` (y, z) [m] are those of `press`; `status` and `reason` say what to make of the
    answer, and `certificate` how far it is from every rule of contact. `depth` [m] is how far the body has gone in,
    `slide` (y, z) [m] and `twist` [rad] how far it has gone along the surface and turned about x. At the nodes, shape
    (n, k): `gap`, the distance left between the bodies [m], infinite where there is no body; and, shape (n, k, 2),
    `slip`, how far the skin has slipped along the body since the start or the state before [m]. `case`, `state` and
    `lateral` are the solver's.
    """

    skin: Skin
    indenter: LocalIndenter
    position: FloatArray
    status: PressStatus
    reason: str
    certificate: Certificate
    case: AreaCase
    state: AreaBalance
    gap: FloatArray
    slip: FloatArray
    lateral: FloatArray

    def __repr__(self) -> str:
        low, high = (1e3 * 2 * self.half_width).tolist()
        where = f"contact {low:.4g} by {high:.4g} mm, depth={1e3 * self.depth:.4g} mm"
        return f"LocalSolution({self.status.name}, force={self.force:.4g} N, {where}: {self.reason})"

    @property
    def y(self) -> FloatArray:
        """Nodes along y [m], shape (n,)."""
        return _check.read_only(self.case.y + self.position[0])

    @property
    def z(self) -> FloatArray:
        """Nodes along z [m], shape (k,)."""
        return _check.read_only(self.case.z + self.position[1])

    @property
    def pressure(self) -> FloatArray:
        """Pressure at the nodes [Pa], shape (n, k)."""
        return self.state.pressure

    @property
    def shear(self) -> FloatArray:
        """Drag (q_y, q_z) at the nodes [Pa], shape (n, k, 2)."""
        return np.moveaxis(self.state.shear, 0, -1)

    @property
    def depth(self) -> float:
        """How far the body has gone in from first touching the undeformed skin [m]."""
        return self.state.depth

    @property
    def slide(self) -> FloatArray:
        """How far it has gone along the surface, (y, z) [m]."""
        return _check.read_only(self.state.slide)

    @property
    def twist(self) -> float:
        """Turn about x, from y towards z [rad]."""
        return self.state.twist

    @property
    def tilt(self) -> FloatArray:
        """Rotation (towards +y, towards +z) of the body [rad], positive where that side goes in."""
        return _check.read_only(self.state.tilt)

    @property
    def force(self) -> float:
        """Normal force [N]."""
        return float(self.pressure.sum() * self.case.cell)

    @property
    def tangential(self) -> FloatArray:
        """Tangential force (Ty, Tz) [N]."""
        return _check.read_only(self.state.shear.sum(axis=(1, 2)) * self.case.cell)

    @property
    def torsion(self) -> float:
        """Moment of the drag about x at `position` [N m]."""
        q = self.state.shear
        return float((q[1] * self.case.y[:, None] - q[0] * self.case.z).sum() * self.case.cell)

    @property
    def moment(self) -> FloatArray:
        """Moments of the pressure, of y p and of z p, about `position` [N m]."""
        p = self.pressure
        return _check.read_only(np.array([(p.T @ self.case.y).sum(), (p @ self.case.z).sum()]) * self.case.cell)

    @property
    def products(self) -> int:
        """Padded products on the finest grid, those of a drag counted twice; the certificate takes one more."""
        return self.state.products[0] + 2 * self.state.products[1]

    @property
    def friction(self) -> float | None:
        """Coefficient of friction; None where there is none."""
        return self.case.load.friction

    @cached_property
    def contact(self) -> PressureGrid:
        """The tractions as a contact like any other: bilinear between the nodes that touch."""
        boxed = []
        for axis, nodes in ((1, self.y), (0, self.z)):
            at = np.flatnonzero((self.pressure > 0).any(axis=axis))
            first, last = int(at[0]) - 1, int(at[-1]) + 1
            boxed.append((first, last, nodes[0] + self.case.step * np.arange(first, last + 1)))
        (i0, i1, y), (j0, j1, z) = boxed
        p, q = np.zeros((y.size, z.size)), np.zeros((y.size, z.size, 2))
        inside = np.s_[i0 + 1 : i1, j0 + 1 : j1]
        p[1:-1, 1:-1], q[1:-1, 1:-1] = self.pressure[inside], self.shear[inside]
        return PressureGrid(y, z, p, q if self.friction is not None else None)

    def thinned(self, nodes: int = 48) -> PressureGrid:
        """The contact on fewer nodes, of the same resultants: a layered finger reads it the quicker.

        Each node's traction goes to the four coarse nodes about it, by its distances. A field at a depth x errs by
        about a sixth of the square of the coarse step over x.

        Parameters
        ----------
        nodes : int, optional
            Nodes along the longer side of the contact.
        """
        full = self.contact
        count = _check.whole("nodes", nodes, at_least=4, at_most=4096)
        longest = max(full.nodes_y.size, full.nodes_z.size)
        wide = max(1.0, (longest - 1) / (count - 1)) * self.case.step
        if wide <= self.case.step * (1 + 1e-9):
            return full
        axes, shares = [], []
        for at in (full.nodes_y, full.nodes_z):
            size = int(np.ceil((at[-1] - at[0]) / wide - 1e-9)) + 3  # a border of zeros
            axes.append(0.5 * (at[0] + at[-1]) + wide * (np.arange(size) - 0.5 * (size - 1)))
            away = np.abs(axes[-1][:, None] - at) / wide
            shares.append(np.maximum(1 - away, 0.0) * (self.case.step / wide))
        maps = [full.node_pressure, full.node_shear[..., 0], full.node_shear[..., 1]]
        p, a, b = (shares[0] @ one @ shares[1].T for one in maps)
        return PressureGrid(axes[0], axes[1], p, np.stack([a, b], axis=-1) if self.friction is not None else None)

    @cached_property
    def edges(self) -> FloatArray:
        """Outermost positions that touch, [[low y, low z], [high y, high z]] [m], shape (2, 2)."""
        p, body = self.pressure, np.isfinite(self.gap)
        ends = [_ends(p, body, self.y), _ends(p.T, body.T, self.z)]
        return _check.read_only(np.array(ends).T)

    @property
    def half_width(self) -> FloatArray:
        """Half the distance between the outermost edges along y and along z [m], shape (2,)."""
        return _check.read_only(0.5 * (self.edges[1] - self.edges[0]))

    @property
    def area(self) -> float:
        """Area of the nodes that touch [m^2]."""
        return float((self.pressure > 0).sum() * self.case.cell)

    @cached_property
    def stick(self) -> BoolArray:
        """Nodes that touch and do not slip, shape (n, k); none without friction."""
        if self.friction is None:
            return np.zeros(self.pressure.shape, dtype=bool)
        held = self.friction * self.pressure
        sticks = (self.pressure > 0) & (np.hypot(*self.state.shear) < held * (1 - 1e-9))
        sticks.flags.writeable = False
        return np.asarray(sticks)


def _ends(pressure: FloatArray, body: BoolArray, nodes: FloatArray) -> tuple[float, float]:
    """Outermost positions along the first axis: the square of the pressure falls to 0 in a straight line.

    Where the body ends at the last node that touches, the contact does half a step beyond.
    """
    step, out = float(nodes[1] - nodes[0]), []
    for side in (1, -1):
        square, solid = pressure[::side] ** 2, body[::side]
        first = int(np.argmax((square > 0).any(axis=1)))
        best = 0.0
        for i in (first, first + 1):  # that of the next row may reach farther
            here, behind = square[i], square[min(i + 1, len(square) - 1)]
            outer = (here > 0) & ~(square[i - 1] > 0 if i else False)
            if not i or not solid[i - 1][outer].all():
                best = max(best, 0.5 - (i - first))
                continue
            falls = outer & (behind > here)
            share = (here[falls] / (behind - here)[falls]).max(initial=0.0)
            best = max(best, min(float(share), 1.0) - (i - first))
        out.append(float(nodes[::side][first] - side * best * step))
    return out[0], out[1]
