"""What a press gives back: the contact, the indenter's position, and how good both are."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..contact import PressureGrid, PressureProfile
from ..skin import Skin
from .body import LocalIndenter
from .case import Balance, BoolArray, Case, hats
from .certificate import Certificate, certify, displaced
from .indenter import Indenter
from .influence import influence

__all__ = ["ContactSolution", "LocalSolution", "PressStatus", "Solution"]

_AT_BOUND = 1e-9
Of = TypeVar("Of", float, FloatArray)


class PressStatus(IntEnum):
    """What to make of a `ContactSolution`; its `reason` says it in words."""

    OK = 0
    """Every rule of contact holds to the tolerance."""
    SLIDES = 1
    """So they do, and friction holds no more than the drag: every node slips."""
    COARSE = 2
    """So they do on the grid, but the contact spans too few nodes to be drawn by them."""
    NOT_SETTLED = 3
    """A rule is broken by more than the tolerance; the certificate says which, and by how much."""


@dataclass(frozen=True, eq=False)
class Solution(Frozen, Generic[Of]):
    """A skin pressed by a body, as `press` found it.

    `skin`, `indenter` and `position` [m] are those of `press`; `status` and `reason` say what to make of the answer,
    and `certificate` how far it is from every rule of contact. At the nodes: `gap`, the distance left between the
    bodies [m], infinite where there is no body, and `slip`, how far the skin has slipped along the body since the start
    or the state before [m]. `case`, `state` and `lateral` are the solver's. What has a direction along the surface is
    one number of a long body, and two along (y, z) on an area.

    Examples
    --------
    >>> import subskin as ss
    >>> skin, body = ss.HalfPlane(ss.Material(young=0.4e6)), ss.pressing.Cylinder(radius=8e-3)
    >>> found = ss.press(skin, body, force=40.0, friction=0.3, tangential=4.0)
    >>> isinstance(found, ss.pressing.Solution), round(found.force, 6), round(found.tangential, 6)
    (True, 40.0, 4.0)
    >>> found.certificate.worst < 1e-5
    True
    """

    skin: Skin
    indenter: Any
    position: Of
    status: PressStatus
    reason: str
    certificate: Certificate
    case: Case
    state: Balance
    gap: FloatArray
    slip: FloatArray
    lateral: FloatArray

    def _along(self, values: FloatArray) -> Of:
        """Of a long body its number, of another all of them."""
        raise NotImplementedError

    @property
    def y(self) -> FloatArray:
        """Nodes along y [m], shape (n,)."""
        return _check.read_only(self.case.y + np.ravel(self.position)[0])

    @property
    def pressure(self) -> FloatArray:
        """Pressure at the nodes [Pa], shape (n,), on an area (n, k)."""
        return self.state.pressure

    @property
    def force(self) -> float:
        """Normal force [N/m], on an area [N]."""
        return float(self.pressure.sum() * self.case.cell)

    @property
    def tangential(self) -> Of:
        """Tangential force [N/m], on an area (Ty, Tz) [N]."""
        q = self.state.shear
        return self._along(q.reshape(len(q), -1).sum(axis=1) * self.case.cell)

    @property
    def moment(self) -> Of:
        """Moment of the pressure about `position` [N], on an area those of y p and of z p [N m]."""
        return self._along(self.case.arms(self.pressure))

    @property
    def tilt(self) -> Of:
        """Rotation of the body [rad], positive where the side of +y (and of +z) goes in."""
        return self._along(self.state.tilt)

    @property
    def friction(self) -> float | None:
        """Coefficient of friction; None where there is none."""
        return self.case.load.friction

    @property
    def known(self) -> bool:
        """Whether the surface moves by what is known, and not but for a constant: there is a ground, or a datum."""
        return self.skin.grounded or self.case.influence.periodic or self.case.datum is not None

    @property
    def depth(self) -> float:
        """How far the body has gone in [m]; NaN where the skin has no ground and no `datum` is given."""
        return self.state.depth if self.known else np.nan


@dataclass(frozen=True, eq=False)
class ContactSolution(Solution[float]):
    """A skin pressed by a long body, as `press` found it: a `Solution` at nodes along y, shape (n,)."""

    indenter: Indenter

    def _along(self, values: FloatArray) -> float:
        return float(values[0])

    def __repr__(self) -> str:
        where = f"half_width={1e3 * self.half_width:.4g} mm"
        if np.isfinite(self.depth):  # a half plane leaves it open
            where += f", depth={1e3 * self.depth:.4g} mm"
        return f"ContactSolution({self.status.name}, force={self.force:.4g} N/m, {where}: {self.reason})"

    @property
    def shear(self) -> FloatArray:
        """Shear at the nodes [Pa], shape (n,)."""
        return np.asarray(self.state.shear[0])

    @property
    def slide(self) -> float:
        """How far the body has gone along the surface [m]; NaN where that is not known, and without friction."""
        return float(self.state.slide[0]) if self.known and self.friction is not None else np.nan

    @property
    def iterations(self) -> int:
        """Steps of conjugate gradients, on all grids."""
        return sum(self.state.steps)

    @cached_property
    def contact(self) -> PressureProfile:
        """The tractions as a contact like any other: straight lines between the nodes that touch."""
        at = np.flatnonzero(self.pressure > 0)
        nodes = np.arange(at[0] - 1, at[-1] + 2)
        y = self.y[0] + self.case.step * nodes
        values = [np.zeros(nodes.size), np.zeros(nodes.size)]
        inside = slice(at[0], at[-1] + 1)
        values[0][1:-1], values[1][1:-1] = self.pressure[inside], self.shear[inside]
        return PressureProfile(y, values[0], values[1] if self.friction is not None else None)

    @cached_property
    def edges(self) -> FloatArray:
        """Where the bodies touch [m], shape (m, 2), from end to end; several where the profile has gaps to close."""
        step, p, y = self.case.step, self.pressure, self.y
        out = []
        for first, last in _runs(p > 0):
            ends = []
            for at, inwards in ((first, 1), (last, -1)):
                beyond = at - inwards
                if not 0 <= beyond < p.size or not np.isfinite(self.gap[beyond]):
                    share = 0.5  # the body ends there, half-way between the nodes
                elif first == last:
                    share = 0.0
                else:
                    # the square of the pressure falls to 0 in a straight line, where the bodies part smoothly
                    square, rise = p[at] ** 2, p[at + inwards] ** 2 - p[at] ** 2
                    share = float(square / rise) if rise > square else 1.0
                ends.append(y[at] - inwards * share * step)
            out.append(ends)
        return _check.read_only(np.array(out).reshape(-1, 2))

    @property
    def half_width(self) -> float:
        """Half the distance between the outermost edges [m]."""
        return float(self.edges[-1, 1] - self.edges[0, 0]) / 2

    @cached_property
    def stick(self) -> FloatArray:
        """Where they touch and do not slip [m], shape (k, 2); none without friction."""
        if self.friction is None:
            return _check.read_only(np.zeros((0, 2)))
        half, y = 0.5 * self.case.step, self.y  # an end is half-way between nodes, or the contact's own
        runs = [(y[a] - half, y[b] + half) for a, b in _runs(np.asarray(self.state.sticks) & (self.pressure > 0))]
        zones = np.array(runs, dtype=np.float64).reshape(-1, 2)
        return _check.read_only(np.clip(zones, self.edges[0, 0], self.edges[-1, 1]))

    def refined(self, by: int = 2) -> Certificate:
        """The certificate on a grid `by` times as fine, on which the same straight lines are given.

        On the grid of the solution the rules hold to the tolerance; between its nodes they hold to what the grid
        resolves. This says to how much.

        Examples
        --------
        >>> import subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
        >>> pressed = ss.press(skin, ss.pressing.Cylinder(radius=8e-3), force=40.0)
        >>> pressed.certificate.penetration < 1e-8 < pressed.refined().penetration < 1e-4
        True
        """
        by = _check.whole("by", by, at_least=1, at_most=64, fix="by=4")
        case, n = self.case, self.case.y.size
        periodic = case.influence.periodic
        count = n * by if periodic else (n - 1) * by + 1
        positions = np.arange(count) / by
        y = case.y[0] + positions * case.step

        def at(values: FloatArray) -> FloatArray:
            ends = np.append(values, values[0]) if periodic else values
            return np.interp(positions, np.arange(ends.size), ends)

        fine = dataclasses.replace(
            case,
            influence=influence(self.skin, case.step / by, (count,), periodic=periodic, datum=case.datum),
            step=case.step / by,
            axes=(y,),
            height=case.gap(y),
            shift=at(case.shift[0])[None],
        )
        state = dataclasses.replace(self.state, pressure=at(self.pressure), shear=at(self.shear)[None])
        return certify(fine, state, displaced(fine, state))


@dataclass(frozen=True, eq=False)
class LocalSolution(Solution[FloatArray]):
    """A skin pressed on an area by a body, as `press` found it: a `Solution` at nodes along y and z, shape (n, k).

    Displacements vanish far away, so that `depth` is always known. `slip` has the shape (n, k, 2).
    """

    indenter: LocalIndenter

    def _along(self, values: FloatArray) -> FloatArray:
        return _check.read_only(values)

    def __repr__(self) -> str:
        low, high = (1e3 * 2 * self.half_width).tolist()
        where = f"contact {low:.4g} by {high:.4g} mm, depth={1e3 * self.depth:.4g} mm"
        return f"LocalSolution({self.status.name}, force={self.force:.4g} N, {where}: {self.reason})"

    @property
    def z(self) -> FloatArray:
        """Nodes along z [m], shape (k,)."""
        return _check.read_only(self.case.z + self.position[1])

    @property
    def shear(self) -> FloatArray:
        """Drag (q_y, q_z) at the nodes [Pa], shape (n, k, 2)."""
        return np.moveaxis(self.state.shear, 0, -1)

    @property
    def known(self) -> bool:
        """Yes: displacements vanish far away."""
        return True

    @property
    def slide(self) -> FloatArray:
        """How far it has gone along the surface, (y, z) [m]."""
        return _check.read_only(self.state.slide)

    @property
    def twist(self) -> float:
        """Turn about x, from y towards z [rad]."""
        return self.state.twist

    @property
    def torsion(self) -> float:
        """Moment of the drag about x at `position` [N m]."""
        return self.case.turning(self.state.shear)

    @property
    def products(self) -> int:
        """Padded products on the finest grid, those of a drag counted twice; the certificate takes one more."""
        return self.state.steps[0] + 2 * self.state.steps[1]

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
            shares.append(hats(axes[-1], wide, at) * (self.case.step / wide))
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
        sticks = (self.pressure > 0) & (np.hypot(*self.state.shear) < held * (1 - _AT_BOUND))
        sticks.flags.writeable = False
        return np.asarray(sticks)


def _runs(member: BoolArray) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    padded = np.concatenate([[False], member, [False]]).astype(np.int8)
    starts, stops = np.flatnonzero(np.diff(padded) == 1), np.flatnonzero(np.diff(padded) == -1)
    return [(int(a), int(b) - 1) for a, b in zip(starts, stops, strict=True)]


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
