"""The certificate of a contact on an area: every rule taken afresh, on the whole grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..._check import FloatArray
from ..._frozen import Frozen
from ..certificate import Certificate
from .balance import AreaBalance, AreaCase

__all__ = ["AreaDisplaced", "certified", "moved_by"]

_SAMPLES = (0.13, 0.5, 0.82)
"""Where on either side of the grid displacements are summed term by term."""
_AT_BOUND = 1e-9


@dataclass(frozen=True, eq=False)
class AreaDisplaced(Frozen):
    """Gap (n, k), slip (2, n, k), and displacements u_x (n, k) and u_y, u_z (2, n, k), of tractions at nodes [m]."""

    gap: FloatArray
    slip: FloatArray
    normal: FloatArray
    lateral: FloatArray


def moved_by(case: AreaCase, state: AreaBalance) -> AreaDisplaced:
    """Displacements, gap and slip of the tractions of `state`, taken at their word."""
    op, rubs = case.influence, case.load.friction is not None
    normal = op.normal(state.pressure)
    lateral = np.zeros((2, *case.height.shape))
    if rubs:
        normal += op.lifted(state.shear)
        lateral = op.lateral(state.shear) + op.dragged(state.pressure)
    gap = normal + case.height
    gap -= state.depth
    if state.tilt.any():
        gap -= state.tilt[0] * case.y[:, None] + state.tilt[1] * case.z
    slip = lateral - case.shift - case.rigid(state.slide, state.twist) if rubs else lateral
    return AreaDisplaced(gap, slip, normal, lateral)


def certified(case: AreaCase, state: AreaBalance, moved: AreaDisplaced) -> Certificate:
    """The certificate of `state`, whose displacements are `moved`."""
    p, load = state.pressure, case.load
    force, top = float(p.sum() * case.cell), float(p.max(initial=0.0)) or 1.0
    at = np.nonzero(p)
    scale = max(float(moved.normal.max()), -float(moved.normal.min()), float(np.abs(moved.lateral).max()), 1e-300)
    beneath = np.abs(moved.gap[at])
    cone = creep = wrong = drag_error = 0.0
    if load.friction is not None:
        cone, creep, wrong = _friction(load.friction, p[at], state.shear[:, at[0], at[1]], moved.slip[:, at[0], at[1]])
        cone, creep, wrong = cone / top, creep / scale, wrong / scale
        drag_error = _drag_error(case, state, force)
    width = case.step * np.sqrt(max(at[0].size, 1))
    arms = np.array([(p.sum(axis=1) * case.y).sum(), (p.sum(axis=0) * case.z).sum()]) * case.cell
    return Certificate(
        scale=scale,
        penetration=max(0.0, -float(moved.gap.min())) / scale,
        gap=float(beneath.max(initial=0.0)) / scale,
        complementarity=float((p[at] * beneath).sum() * case.cell) / (force * scale) if force else 0.0,
        tension=max(0.0, -float(p.min())) / top,
        cone=cone,
        creep=creep,
        wrong_way=wrong,
        force_error=abs(force - load.force) / load.force if load.force else 0.0,
        moment_error=float(np.abs(arms - load.moment).max()) / (force * width) if load.moment is not None else 0.0,
        tangential_error=drag_error,
        sums=_plain_sums(case, state, moved) / scale,
    )


def _friction(mu: float, p: FloatArray, q: FloatArray, slip: FloatArray) -> tuple[float, float, float]:
    """Most by which a drag leaves the cone [Pa], greatest creep where it sticks, and the slip not against it [m]."""
    size, held = np.hypot(*q), mu * p
    within = size < held * (1 - _AT_BOUND)
    creep = float(np.hypot(*slip[:, within]).max(initial=0.0))
    rubbed = ~within & (held > 0)
    # friction drives the skin along with the body, so the skin lags: its slip is against the drag
    slid = slip[:, rubbed]
    along = q[:, rubbed] / np.maximum(size[rubbed], 1e-300)
    lag = (slid * along).sum(axis=0)
    if within.any():
        wrong = float(np.hypot(*(slid - np.minimum(lag, 0.0) * along)).max(initial=0.0))
    else:  # the slide is as long as one likes, and across it the skin slips by the less the longer
        wrong = float(np.maximum(lag, 0.0).max(initial=0.0))
    return float(np.maximum(size - held, 0.0).max(initial=0.0)), creep, wrong


def _drag_error(case: AreaCase, state: AreaBalance, force: float) -> float:
    """What is missing of the drag, in shares of what friction can hold; none where all slips."""
    load, p = case.load, state.pressure
    most = float(load.friction or 0.0) * force
    if not most:
        return 0.0
    held = float(load.friction or 0.0) * p
    if (np.hypot(*state.shear) >= held * (1 - _AT_BOUND)).all():
        return 0.0
    error = 0.0
    if load.tangential is not None:
        total = state.shear.sum(axis=(1, 2)) * case.cell
        error = float(np.hypot(*(total - load.tangential))) / most
    if load.torsion is not None:
        turned = (state.shear[1] * case.y[:, None] - state.shear[0] * case.z).sum() * case.cell
        arm = case.step * np.sqrt(max(int((p > 0).sum()), 1))
        error = max(error, abs(float(turned) - load.torsion) / (most * arm))
    return error


def _plain_sums(case: AreaCase, state: AreaBalance, moved: AreaDisplaced) -> float:
    """Displacements at a few nodes, term by term, less those by transforms [m]."""
    n, k = case.height.shape
    at = [(int(a * n), int(b * k)) for a, b in zip(_SAMPLES, reversed(_SAMPLES), strict=True)]
    if case.load.friction is None:
        slow = case.influence.direct([state.pressure], at)
        fast = np.array([[moved.normal[i, j]] for i, j in at])
    else:
        slow = case.influence.direct([state.pressure, *state.shear], at)
        fast = np.array([[moved.normal[i, j], *moved.lateral[:, i, j]] for i, j in at])
    return float(np.abs(slow - fast[:, : slow.shape[1]]).max())
