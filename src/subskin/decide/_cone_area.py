"""How much of a load on an area lies beyond the friction cone: its drag has two components, and so have its errors.

A moment about the normal takes from what friction holds of the drag, by the limit surface of the contact.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..estimate import Estimate
from ._cone_area_kernel import fill_beyond
from .limit_surface import drag_held, effective_drag, friction_arm, moment_held

__all__ = ["AreaForces", "area_forces", "beyond_on_area", "margin_on_area"]

_NODES = 32
_T, _WEIGHTS = np.polynomial.hermite_e.hermegauss(_NODES)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()
_FEW, _FEW_WEIGHTS = np.polynomial.hermite_e.hermegauss(12)
_FEW_WEIGHTS = _FEW_WEIGHTS / _FEW_WEIGHTS.sum()
"""Where a moment is known as well."""
_CELL = 0.5 / np.sqrt(3.0)
"""Gauss and Legendre's two nodes in a cell of the density of mu, from its middle, in widths of the cell."""
_BLOCK = 1 << 21


class AreaForces(NamedTuple):
    """N, |T|, |M| / (arm a), and the errors of N, of T along the drag and across it, and of the moment (n, t, c, m).

    All in N and N^2, of the frames' shape; m is 0, and known, where there is no moment. law: the contact's pressure.
    """

    normal: FloatArray
    tangential: FloatArray
    nn: FloatArray
    nt: FloatArray
    tt: FloatArray
    nc: FloatArray
    tc: FloatArray
    cc: FloatArray
    turning: FloatArray
    nm: FloatArray
    tm: FloatArray
    cm: FloatArray
    mm: FloatArray
    law: str

    @property
    def numbers(self) -> tuple[FloatArray, ...]:
        """All fields but the law."""
        return self[:-1]

    def at(self, index: npt.NDArray[np.intp]) -> AreaForces:
        """The frames of a flat index."""
        fields: Any = (*(v.reshape(-1)[index] for v in self.numbers), self.law)
        return AreaForces(*fields)


def area_forces(estimate: Estimate, contact: str) -> AreaForces:
    """Components and their covariance in axes along the drag that was found and across it; a moment as a force.

    The moment is divided by the friction arm of a `contact` as wide as was found, whose error is carried along. Where
    the width may be 0 the moment's error is infinite.
    """
    load, at = estimate.load, estimate.layout
    parts = np.asarray(load.components)
    k = 7 if at.twist else 5
    square = estimate.table[..., at.square[2:k, 2:k]]  # N, Ty, Tz, and the half width and the moment
    drag = np.hypot(parts[..., 1], parts[..., 2])
    known = drag > 0
    y, z = (np.where(known, parts[..., k] / np.where(known, drag, 1.0), 2.0 - k) for k in (1, 2))
    turn = np.zeros((*drag.shape, 4, square.shape[-1]))
    turn[..., 0, 0] = 1.0
    turn[..., 1, 1], turn[..., 1, 2], turn[..., 2, 1], turn[..., 2, 2] = y, z, -z, y
    turning = np.zeros(drag.shape)
    if load.moment is not None:
        arm, width = friction_arm(contact), np.where(estimate.half_width > 0, estimate.half_width, np.inf)
        sign = np.where(load.moment < 0, -1.0, 1.0)
        turning = np.abs(load.moment) / (arm * width)
        turn[..., 3, 3], turn[..., 3, 4] = -turning / width, sign / (arm * width)
    c = turn @ square @ np.swapaxes(turn, -1, -2)
    if load.moment is not None:
        open_ = ~(estimate.half_width_interval[..., 0] > 0)
        c[..., 3, 3] = np.where(open_, np.inf, c[..., 3, 3])
    errors = (c[..., i, j] for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)))
    fields: Any = (parts[..., 0], drag, *errors, turning, *(c[..., i, 3] for i in range(4)), contact)
    return AreaForces(*fields)


def margin_on_area(load: AreaForces, mean: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """What is left of mu N by the drag that counts, its standard deviation, and that drag over mu N; all (frames,).

    mean, std: of mu.
    """
    whole, along, turned = _steepness(load)
    across = along**2 * load.tt - 2 * mean * along * load.nt + mean**2 * load.nn
    if turned.any():
        across = across + turned * (turned * load.mm + 2 * along * load.tm - 2 * mean * load.nm)
    n = load.normal
    with np.errstate(divide="ignore", invalid="ignore"):  # without friction, or without a force
        ratio = whole / (mean * n)
    return mean * n - whole, np.sqrt(np.maximum(across + std**2 * (n * n + load.nn), 0.0)), ratio


def _steepness(load: AreaForces) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The drag alone that is as near to slipping, and how it grows with the drag and with the moment."""
    t, m = load.tangential, load.turning
    if not m.any():
        return t, np.ones_like(t), np.zeros_like(t)
    whole = effective_drag(t, m, load.law)
    h = 1e-3 * whole + 1e-300

    def slope(dt: FloatArray, dm: FloatArray) -> FloatArray:
        ends = (effective_drag(np.abs(t + sign * dt), np.abs(m + sign * dm), load.law) for sign in (1, -1))
        up, down = ends
        return np.asarray((up - down) / (2 * h))

    return whole, slope(h, 0 * h), slope(0 * h, h)


def beyond_on_area(load: AreaForces, edges: FloatArray, masses: FloatArray, scale: FloatArray) -> FloatArray:
    """P(|T| > scale mu N), shape (frames,); edges (frames or 1, k + 1), masses (frames or 1, k).

    Gauss and Hermite's rule over the drag across and over N, the normal distribution's tails for the drag along, Gauss
    and Legendre's rule over mu in each cell. With a moment the limit surface takes the place of mu N.
    """
    if load.mm.any() or load.turning.any():
        return _beyond_surface(load, edges, masses, scale)
    out = np.empty(load.normal.size)
    given = (np.stack(load[:8], axis=-1), edges, masses, scale, _T, _WEIGHTS)
    fill_beyond(*(np.array(v, dtype=np.float64, order="C") for v in given), out)  # compiled for what can be written
    return out


def _beyond_surface(load: AreaForces, edges: FloatArray, masses: FloatArray, scale: FloatArray) -> FloatArray:
    """As `beyond_on_area`, of a drag and a moment: tails along that of the two whose error counts more.

    Gauss and Hermite's rule over the other, over the drag across, and over N.
    """
    _, along, turned = _steepness(load)
    by_moment = turned**2 * load.mm > along**2 * load.tt
    out = np.empty(load.normal.size)
    for tails, frames in ((True, np.flatnonzero(by_moment)), (False, np.flatnonzero(~by_moment))):
        step = max(1, _BLOCK // (2 * masses.shape[-1] * _FEW.size**3))
        for first in range(0, frames.size, step):
            at = frames[first : first + step]
            ends, weights = (v if v.shape[0] == 1 else v[at] for v in (edges, masses))
            out[at] = _tails(load.at(at), ends, weights, scale[at], tails)
    return np.clip(out, 0.0, 1.0)


def _tails(load: AreaForces, edges: FloatArray, masses: FloatArray, scale: FloatArray, by_moment: bool) -> FloatArray:
    """The part of `_beyond_surface` whose tails are along the moment, or along the drag."""
    from scipy.special import ndtr

    order = "tcnm" if by_moment else "mcnt"
    means = {"n": load.normal, "t": load.tangential, "c": np.zeros_like(load.normal), "m": load.turning}
    size = 1e-12 * sum(np.abs(v) for v in means.values())
    square = np.empty((load.normal.size, 4, 4))
    for i, a in enumerate(order):
        for j, b in enumerate(order):
            square[:, i, j] = getattr(load, "".join(sorted(a + b, key="ntcm".index)))
        square[:, i, i] = square[:, i, i] * (1 + 1e-12) + size**2 + 1e-300
    root = np.linalg.cholesky(square)
    grid = np.stack(np.meshgrid(_FEW, _FEW, _FEW, indexing="ij")).reshape(3, -1)
    share = (_FEW_WEIGHTS[:, None, None] * _FEW_WEIGHTS[:, None] * _FEW_WEIGHTS).reshape(-1)
    moved = root[:, :, :3] @ grid
    first, across, normal, own = (means[name][:, None] + moved[:, i] for i, name in enumerate(order))
    half, width = 0.5 * (edges[:, :-1] + edges[:, 1:]), np.diff(edges, axis=-1)
    total, spread = np.zeros(load.normal.size), root[:, None, 3, 3, None]
    for node in (-_CELL, _CELL):
        hold = (scale[:, None] * (half + node * width))[..., None] * np.maximum(normal, 0.0)[:, None]
        if by_moment:
            cut = moment_held(hold, np.hypot(first, across)[:, None], load.law)
        else:
            held = drag_held(hold, np.abs(first)[:, None], load.law)
            cut = np.sqrt(np.maximum(held**2 - across[:, None] ** 2, 0.0))
        p = ndtr((own[:, None] - cut) / spread) + ndtr((-own[:, None] - cut) / spread)
        total += 0.5 * np.einsum("fkg,fk,g->f", p, np.broadcast_to(masses, p.shape[:2]), share)
    return total
