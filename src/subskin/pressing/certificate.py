"""Whether a contact's tractions are what they claim to be: every rule of contact, taken afresh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._check import FloatArray
from .._frozen import Frozen
from .case import Balance, Case

__all__ = ["Certificate", "Displaced", "certify", "displaced"]

_SAMPLES = (0.13, 0.5, 0.82)
"""Where on either side of the grid displacements are summed term by term."""
_AT_BOUND = 1e-9


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
        times the contact's width, of the tangential force in shares of the force, of a torsion as of a moment.
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
    """Gap and displacement u_x (...), slip and displacement along the surface (d, ...) at nodes [m]."""

    gap: FloatArray
    slip: FloatArray
    normal: FloatArray
    lateral: FloatArray


def displaced(case: Case, state: Balance) -> Displaced:
    """Displacements, gap and slip of the tractions of `state`, taken at their word."""
    op = case.influence
    normal, lateral = op.normal(state.pressure), op.dragged(state.pressure)
    if state.shear.any():
        normal, lateral = normal + op.lifted(state.shear), lateral + op.lateral(state.shear)
    gap = normal + case.height
    gap -= state.depth
    if state.tilt.any():
        gap -= case.leaning(state.tilt)
    slip = lateral - case.shift - case.rigid(state.slide, state.twist) if op.drags else lateral
    return Displaced(gap, slip, normal, lateral)


def certify(case: Case, state: Balance, moved: Displaced) -> Certificate:
    """The certificate of `state`, whose displacements are `moved`."""
    p, load = state.pressure, case.load
    force, top = float(p.sum() * case.cell), float(p.max(initial=0.0)) or 1.0
    at = np.nonzero(p)
    scale = max(float(moved.normal.max()), -float(moved.normal.min()), float(np.abs(moved.lateral).max()), 1e-300)
    beneath = np.abs(moved.gap[at])
    cone = creep = wrong = drag_error = 0.0
    width = (case.cell * max(int((p > 0).sum()), 1)) ** (1 / len(case.axes))
    if load.friction is not None:
        rubs = np.nonzero((p != 0) | state.shear.any(axis=0))
        held = _held(load.friction, p[rubs])
        q, slip = (np.array([part[rubs] for part in field]) for field in (state.shear, moved.slip))
        cone, creep, wrong = _friction(held, q, slip)
        drag_error = _drag_error(case, state, force, width, bool((_size(q) >= held * (1 - _AT_BOUND)).all()))
    missing = 0.0 if load.moment is None else float(np.abs(case.arms(p) - load.moment).max())
    return Certificate(
        scale=scale,
        penetration=max(0.0, -float(moved.gap.min())) / scale,
        gap=float(beneath.max(initial=0.0)) / scale,
        complementarity=float((p[at] * beneath).sum() * case.cell) / (force * scale) if force else 0.0,
        tension=max(0.0, -float(p.min())) / top,
        cone=cone / top,
        creep=creep / scale,
        wrong_way=wrong / scale,
        force_error=abs(force - load.force) / load.force if load.force else 0.0,
        moment_error=missing / (force * width) if missing else 0.0,
        tangential_error=drag_error,
        sums=_plain_sums(case, state, moved) / scale,
    )


def _size(q: FloatArray) -> FloatArray:
    return np.asarray(np.abs(q[0]) if len(q) == 1 else np.hypot(*q))


def _held(mu: float, p: FloatArray) -> FloatArray:
    """The drag that friction holds."""
    return mu * p if np.isfinite(mu) else np.where(p > 0, np.inf, 0.0)


def _friction(held: FloatArray, q: FloatArray, slip: FloatArray) -> tuple[float, float, float]:
    """Most by which a drag leaves the cone [Pa], greatest creep where it sticks, and the slip not against it [m]."""
    size = _size(q)
    within = size < held * (1 - _AT_BOUND)
    creep = float(_size(slip[:, within]).max(initial=0.0))
    rubbed = ~within & (held > 0)
    # friction drives the skin along with the body, so the skin lags: its slip is against the drag
    slid = slip[:, rubbed]
    along = q[:, rubbed] / np.maximum(size[rubbed], 1e-300)
    lag = (slid * along).sum(axis=0)
    if within.any():
        wrong = float(_size(slid - np.minimum(lag, 0.0) * along).max(initial=0.0))
    else:  # the slide is as long as one likes, and across it the skin slips by the less the longer
        wrong = float(np.maximum(lag, 0.0).max(initial=0.0))
    return float(np.maximum(size - held, 0.0).max(initial=0.0)), creep, wrong


def _drag_error(case: Case, state: Balance, force: float, width: float, slides: bool) -> float:
    """What is missing of the drag, in shares of the force; of one that friction does not hold, of what it holds."""
    load, error, most = case.load, 0.0, float(case.load.friction or 0.0) * force
    if slides and load.torsion is not None:
        return 0.0
    if load.tangential is not None:
        size = float(_size(load.tangential))
        wanted = load.tangential * (most / size if size > most else 1.0)
        total = state.shear.reshape(len(wanted), -1).sum(axis=1) * case.cell
        error = float(_size(total - wanted)) / force if force else 0.0
    if load.torsion is not None and force:
        error = max(error, abs(case.turning(state.shear) - load.torsion) / (force * width))
    return error


def _plain_sums(case: Case, state: Balance, moved: Displaced) -> float:
    """Displacements at a few nodes, term by term, less those by transforms [m]."""
    worst = 0.0
    for shares in zip(_SAMPLES, reversed(_SAMPLES), strict=True):
        at = tuple(int(share * count) for share, count in zip(shares, case.height.shape, strict=False))
        slow = case.influence.direct(state.pressure, state.shear, at)
        fast = np.array([moved.normal[at], *(part[at] for part in moved.lateral)])[: slow.size]
        worst = max(worst, float(np.abs(slow - fast).max()))
    return worst
