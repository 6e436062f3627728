"""What a press gives back: the contact, the indenter's position, and how good both are."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..contact import PressureProfile
from ..skin import Skin
from .certificate import Certificate, certify, displaced
from .equilibrium import Balance, Case
from .indenter import Indenter
from .influence import influence

__all__ = ["ContactSolution", "PressStatus"]


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
class ContactSolution(Frozen):
    """A skin pressed by an indenter, as `press` found it.

    `skin`, `indenter` and `position` [m] are those of `press`; `status` and `reason` say what to make of the answer,
    and `certificate` how far it is from every rule of contact. `depth` and `slide` [m] are how far the indenter has
    gone in, and along the surface; NaN where the skin has no ground and no `datum` is given. At the nodes, shape (n,):
    `gap`, the distance left between the bodies [m], infinite where there is no body, and `slip`, how far the skin has
    slipped along the indenter since the start or the state before [m]. `case`, `state` and `lateral` are the solver's.
    """

    skin: Skin
    indenter: Indenter
    position: float
    status: PressStatus
    reason: str
    certificate: Certificate
    depth: float
    slide: float
    case: Case
    state: Balance
    gap: FloatArray
    slip: FloatArray
    lateral: FloatArray

    def __repr__(self) -> str:
        where = f"half_width={1e3 * self.half_width:.4g} mm"
        if np.isfinite(self.depth):  # a half plane leaves it open
            where += f", depth={1e3 * self.depth:.4g} mm"
        return f"ContactSolution({self.status.name}, force={self.force:.4g} N/m, {where}: {self.reason})"

    @property
    def y(self) -> FloatArray:
        """Nodes [m], shape (n,)."""
        return _check.read_only(self.case.y + self.position)

    @property
    def pressure(self) -> FloatArray:
        """Pressure at the nodes [Pa], shape (n,)."""
        return self.state.pressure

    @property
    def shear(self) -> FloatArray:
        """Shear at the nodes [Pa], shape (n,)."""
        return self.state.shear

    @property
    def force(self) -> float:
        """Normal force [N/m]."""
        return float(self.pressure.sum() * self.case.step)

    @property
    def tangential(self) -> float:
        """Tangential force [N/m]."""
        return float(self.shear.sum() * self.case.step)

    @property
    def moment(self) -> float:
        """Moment of the pressure about `position` [N]."""
        return float((self.pressure * self.case.y).sum() * self.case.step)

    @property
    def tilt(self) -> float:
        """Rotation of the indenter [rad], positive where the side of +y goes in."""
        return self.state.tilt

    @property
    def iterations(self) -> int:
        """Steps of conjugate gradients, on all grids."""
        return self.state.steps

    @property
    def friction(self) -> float | None:
        """Coefficient of friction; None where there is none."""
        return self.case.load.friction

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
        runs = [(y[a] - half, y[b] + half) for a, b in _runs(self.state.sticks & (self.pressure > 0))]
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
        op = influence(self.skin, case.step / by, count, periodic, case.datum)
        positions = np.arange(count) / by

        def at(values: FloatArray) -> FloatArray:
            ends = np.append(values, values[0]) if periodic else values
            return np.interp(positions, np.arange(ends.size), ends)

        fine = dataclasses.replace(
            case,
            influence=op,
            step=case.step / by,
            y=case.y[0] + positions * case.step,
            height=case.profile(case.y[0] + positions * case.step),
            shift=at(case.shift),
        )
        state = dataclasses.replace(self.state, pressure=at(self.pressure), shear=at(self.shear))
        return certify(fine, state, displaced(op, fine, state, fine.height, fine.shift))


def _runs(member: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    padded = np.concatenate([[False], member, [False]]).astype(np.int8)
    starts, stops = np.flatnonzero(np.diff(padded) == 1), np.flatnonzero(np.diff(padded) == -1)
    return [(int(a), int(b) - 1) for a, b in zip(starts, stops, strict=True)]
