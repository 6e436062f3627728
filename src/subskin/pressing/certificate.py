"""Whether a contact's tractions are what they claim to be: every rule of contact, taken afresh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._check import FloatArray
from .._frozen import Frozen
from .equilibrium import Balance, Case
from .influence import Influence

__all__ = ["Certificate", "Displaced", "certify", "displaced"]

_SAMPLES = 5


@dataclass(frozen=True)
class Certificate:
    """How far a solution is from obeying each rule of contact; all would be 0 in exact arithmetic.

    Displacements are computed again from the tractions and the skin's own influence coefficients; nothing of the
    solver's is used. Lengths are in shares of `scale`, the greatest displacement; tractions in shares of
    the greatest pressure.

    Attributes
    ----------
    scale : float
        Greatest displacement [m]; from the ground, the datum, the mean, or else the end of the window.
    penetration, gap : float
        Deepest overlap of indenter and skin, and widest gap where there is pressure [-].
    complementarity : float
        Pressure times gap, summed, in shares of force times scale: a bound of the duality gap.
    tension, cone : float
        Greatest pull (negative pressure), and most by which a shear is beyond friction times pressure [-].
    creep, wrong_way : float
        Greatest slip where the skin should stick, and along the friction instead of against it [-].
    force_error, moment_error, tangential_error : float
        What is missing of each prescribed resultant: of the force in shares of it, of the moment in shares of force
        times the contact's width, of the tangential force in shares of the force.
    sums : float
        Greatest difference between displacements by Fourier transforms and by plain sums, at a few nodes [-].
    """

    scale: float
    penetration: float
    gap: float
    complementarity: float
    tension: float
    cone: float
    creep: float
    wrong_way: float
    force_error: float
    moment_error: float
    tangential_error: float
    sums: float

    @property
    def worst(self) -> float:
        """The greatest of all but `scale`."""
        return float(max(value for name, value in vars(self).items() if name != "scale"))


@dataclass(frozen=True, eq=False)
class Displaced(Frozen):
    """Gap and slip at nodes, of tractions taken at their word [m]."""

    gap: FloatArray
    slip: FloatArray
    normal: FloatArray
    lateral: FloatArray


def displaced(op: Influence, case: Case, state: Balance, height: FloatArray, shift: FloatArray) -> Displaced:
    """Displacements, gap and slip at the nodes of `op`, at which the tractions of `state` are given."""
    normal = op.apply(0, 0, state.pressure) + op.apply(0, 1, state.shear)
    lateral = op.apply(1, 0, state.pressure) + op.apply(1, 1, state.shear)
    gap = height + normal - state.depth - state.tilt * case.y
    return Displaced(gap, lateral - shift - state.slide, normal, lateral)


def certify(case: Case, state: Balance, moved: Displaced) -> Certificate:
    """The certificate of `state`, whose displacements are `moved`."""
    p, q, load = state.pressure, state.shear, case.load
    force = float(p.sum() * case.step)
    top = float(p.max(initial=0.0)) or 1.0
    pressed = p > 0
    scale = max(float(np.abs(moved.normal).max()), float(np.abs(moved.lateral).max()), 1e-300)
    body = np.isfinite(moved.gap)
    gap = np.where(body, moved.gap, 0.0)
    beneath = np.where(pressed, np.abs(gap), 0.0)
    cone = creep = wrong = drag_error = 0.0
    if load.friction is not None:
        held = load.friction * p if np.isfinite(load.friction) else np.where(pressed, np.inf, 0.0)
        cone = float(np.maximum(np.abs(q) - held, 0.0).max()) / top
        within = pressed & (np.abs(q) < held * (1 - 1e-9))
        creep = float(np.abs(moved.slip[within]).max(initial=0.0)) / scale
        # friction drives the skin along with the indenter, so the skin lags: slip and shear are of opposite sign
        rubbed = pressed & ~within
        wrong = float(np.maximum(moved.slip * np.sign(q), 0.0)[rubbed].max(initial=0.0)) / scale
        if load.tangential is not None and np.isfinite(load.friction):
            asked = float(np.clip(load.tangential, -load.friction * force, load.friction * force))
            drag_error = abs(float(q.sum() * case.step) - asked) / force
        elif load.tangential is not None:
            drag_error = abs(float(q.sum() * case.step) - load.tangential) / force
    width = case.step * max(int(pressed.sum()), 1)
    moment = float((p * case.y).sum() * case.step)
    return Certificate(
        scale=scale,
        penetration=float(np.maximum(-gap, 0.0).max()) / scale,
        gap=float(beneath.max()) / scale,
        complementarity=float((p * np.abs(gap)).sum() * case.step) / (force * scale) if force else 0.0,
        tension=float(np.maximum(-p, 0.0).max()) / top,
        cone=cone,
        creep=creep,
        wrong_way=wrong,
        force_error=abs(force - load.force) / load.force if load.force else 0.0,
        moment_error=abs(moment - load.moment) / (force * width) if load.moment is not None else 0.0,
        tangential_error=drag_error,
        sums=_plain_sums(case.influence, state, moved) / scale,
    )


def _plain_sums(op: Influence, state: Balance, moved: Displaced) -> float:
    """Displacements at a few nodes, term by term, less those by transforms [m]."""
    at = np.unique(np.linspace(0, op.count - 1, _SAMPLES).astype(np.intp))
    worst = 0.0
    for a, fast in ((0, moved.normal), (1, moved.lateral)):
        if a == 1 and not op.coupled and not state.shear.any():
            continue
        slow = op.direct(a, 0, state.pressure, at) + op.direct(a, 1, state.shear, at)
        worst = max(worst, float(np.abs(slow - fast[at]).max()))
    return worst
