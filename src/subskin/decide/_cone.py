"""How much of an estimate's load lies beyond the friction cone, friction being as uncertain as it is.

On an area the drag has two components, and so have its errors. There a moment about the normal takes from what friction
holds of the drag, by the limit surface of the contact.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError
from ..estimate import Either, Estimate, Layout, Status
from ._cone_kernel import CELL, EDGE, SURE, fill_cells
from ._drag_kernel import DOUBLINGS, FARTHEST, drag_frames, fill_beyond, fill_levels
from ._drag_lines import hermite
from .stick import drag_held, effective_drag, friction_arm, moment_held

__all__ = [
    "Forces", "beyond", "cells_beyond", "checked", "forces_of", "levels", "margin", "of_frames", "picked",
    "widths",
]  # fmt: skip

BoolArray = npt.NDArray[np.bool_]

_BLOCK, _SURFACE_BLOCK = 1 << 18, 1 << 21


_FEW = hermite(12)
"""The rule with a moment."""


class Forces(NamedTuple):
    """The load of each frame and its errors: N and T [N/m]; on an area N, |T| and 0, the drag across it [N].

    Where a moment was fitted too, |M| / (arm a) comes last, and `law` is the pressure of the contact that holds it.
    `mean` has the shape (..., k), `covariance` (..., k, k).
    """

    mean: FloatArray
    covariance: FloatArray
    law: str = ""

    @property
    def normal(self) -> FloatArray:
        """N."""
        return self.mean[..., 0]

    @property
    def tangential(self) -> FloatArray:
        """T, on an area |T|."""
        return self.mean[..., 1]

    @property
    def turning(self) -> FloatArray:
        """The moment as a force."""
        return self.mean[..., 3]

    @property
    def on_area(self) -> bool:
        """Whether the drag has two components."""
        return bool(self.mean.shape[-1] > 2)

    @property
    def turns(self) -> bool:
        """Whether a moment was fitted."""
        return bool(self.mean.shape[-1] > 3)

    def at(self, index: npt.NDArray[np.intp] | slice) -> Forces:
        """The frames of a flat index."""
        k = self.mean.shape[-1]
        return Forces(self.mean.reshape(-1, k)[index], self.covariance.reshape(-1, k, k)[index], self.law)

    def with_(self, normal: FloatArray | None = None, tangential: FloatArray | None = None) -> Forces:
        """Other loads with the same errors."""
        mean = np.array(self.mean)
        for column, values in enumerate((normal, tangential)):
            if values is not None:
                mean[..., column] = values
        return self._replace(mean=mean)


def forces_of(estimate: Estimate, contact: str = "hertz") -> tuple[Forces, BoolArray, BoolArray]:
    """The forces of each frame; whether their error is known; whether the estimator's own cone cut them off.

    Readings are linear in forces, so that errors are Gaussian there. contact: whose friction arm divides a moment.
    """
    checked(estimate)
    at, widest = estimate.layout, estimate.friction
    if at.dim == 2 and not at.twist:
        shape, table = estimate.shape, estimate.table.reshape(-1, estimate.table.shape[-1])
        mean, covariance = np.empty((len(table), 3)), np.empty((len(table), 3, 3))
        told, edge = np.empty(len(table), dtype=bool), np.empty(len(table), dtype=bool)
        drag_frames(table, _columns(at), widest, mean, covariance, told, edge)
        load = Forces(mean.reshape(*shape, 3), covariance.reshape(*shape, 3, 3))
        return load, told.reshape(shape), edge.reshape(shape)
    d, k = at.dim, 2 * at.dim + 1 + 2 * at.twist
    square = estimate.table[..., at.square[d:k, d:k]]  # of the components, and the half width and the moment
    load = Forces(np.asarray(estimate.load.components), np.asarray(square))
    if d == 2:
        load = _along_drag(estimate, load, contact)
    found = (estimate.status == Status.OK) | (estimate.status == Status.AMBIGUOUS)
    # where the estimator was told that there is no friction, the drag was not measured
    known = np.isfinite(load.mean).all(axis=-1) & np.isfinite(load.covariance).all(axis=(-2, -1))
    told = found & known & (load.covariance[..., 1, 1] > 0)
    edge = np.zeros_like(told)
    if np.isfinite(widest):
        edge = found & (np.abs(load.tangential) >= widest * load.normal * (1 - EDGE))
    return load, told, edge


@lru_cache(maxsize=16)
def _columns(layout: Layout) -> npt.NDArray[np.intp]:
    """Of `drag_frames`."""
    return np.array([layout.components, layout.status, *layout.square[2:5, 2:5].ravel()], dtype=np.intp)


def _along_drag(estimate: Estimate, load: Forces, contact: str) -> Forces:
    """The same in axes along the drag that was found and across it; a moment as a force.

    The moment is divided by the friction arm of a `contact` as wide as was found, whose error is carried along. Where
    the width may be 0 the moment's error is infinite.
    """
    moment, parts = np.asarray(estimate.load.moment), load.mean
    drag = np.hypot(parts[..., 1], parts[..., 2])
    known = drag > 0
    y, z = (np.where(known, parts[..., k] / np.where(known, drag, 1.0), 2.0 - k) for k in (1, 2))
    arm, width = friction_arm(contact), np.where(estimate.half_width > 0, estimate.half_width, np.inf)
    turning = np.abs(moment) / (arm * width)
    turn = np.zeros((*drag.shape, 4, load.covariance.shape[-1]))
    turn[..., 0, 0] = 1.0
    turn[..., 1, 1], turn[..., 1, 2], turn[..., 2, 1], turn[..., 2, 2] = y, z, -z, y
    turn[..., 3, 3], turn[..., 3, 4] = -turning / width, np.where(moment < 0, -1.0, 1.0) / (arm * width)
    covariance = turn @ load.covariance @ np.swapaxes(turn, -1, -2)
    covariance[..., 3, 3] = np.where(estimate.half_width_interval[..., 0] > 0, covariance[..., 3, 3], np.inf)
    return Forces(np.stack([parts[..., 0], drag, np.zeros_like(drag), turning], axis=-1), covariance, contact)


def checked(estimate: Estimate) -> Estimate:
    """What is an estimate; an error for what is not."""
    if isinstance(estimate, Either):
        rule = "of a line or a point, whichever it was, a row does not tell the drag across it"
        raise InvalidValueError("an answer for lines and points", rule, 'finger.locate(readings, load="line")')
    if not isinstance(estimate, Estimate):
        seen, rule = f"estimate = {_check.shown(estimate)}", "what Finger.locate or Finger.fit returned is needed"
        raise InvalidValueError(seen, rule, "decide.slip(finger.fit(readings), friction=0.5)")
    if estimate.layout.aside:
        rule = "a row does not tell the drag across it"
        raise InvalidValueError("an estimate of a point beside a row", rule, "SensorArray.grid(...)")
    return estimate


def widths(load: Forces, mu: FloatArray, side: FloatArray | float) -> FloatArray:
    """Standard deviation of side T - mu N, for `mu` of the frames' shape and one axis more."""
    c = load.covariance[..., None]
    square = c[..., 1, 1, :] - 2 * side * mu * c[..., 0, 1, :] + mu * mu * c[..., 0, 0, :]
    floor = 1e-12 * (np.abs(load.tangential)[..., None] + mu * np.abs(load.normal)[..., None]) + 1e-300
    return np.asarray(np.sqrt(np.maximum(square, floor * floor)))


def cells_beyond(load: Forces, edges: FloatArray, scale: FloatArray | None = None) -> FloatArray:
    """P(|T| > scale mu N) of a row, its mean over mu in each cell; edges (frames or 1, k + 1), result (frames, k)."""
    total = np.empty((load.normal.size, edges.shape[-1] - 1))
    factor = np.ones(load.normal.size) if scale is None else scale
    # copies are alike in memory, whatever they are of: the loop is compiled once
    fill_cells(*(np.array(v, order="C") for v in (*load[:2], edges, factor)), total)
    unsure = np.flatnonzero(load.normal < SURE * np.sqrt(np.maximum(load.covariance[:, 0, 0], 0.0)))
    if unsure.size:
        both = _both(load.at(unsure), factor[unsure, None] * picked(edges, unsure))
        total[unsure] = np.maximum(total[unsure] - both, 0.0)
    return np.minimum(total, 1.0, out=total)


def _both(load: Forces, edges: FloatArray) -> FloatArray:
    """P(|T| < -mu N): a load that pulls is counted on both sides of the cone. Owen (1956)."""
    from scipy.special import ndtr, owens_t

    mu = 0.5 * (edges[..., :-1] + edges[..., 1:])
    one, two = widths(load, mu, 1.0), widths(load, mu, -1.0)
    normal, tangential = load.normal[..., None], load.tangential[..., None]
    h, k = (tangential - mu * normal) / one, (-tangential - mu * normal) / two
    h, k = np.where(h == 0, 1e-300, h), np.where(k == 0, 1e-300, k)
    shared = mu * mu * load.covariance[..., 0, 0, None] - load.covariance[..., 1, 1, None]
    shared = np.clip(shared / (one * two), -1 + 1e-15, 1 - 1e-15)
    rest = np.sqrt((1 - shared) * (1 + shared))
    with np.errstate(over="ignore"):
        turns = owens_t(h, (k - shared * h) / (h * rest)) + owens_t(k, (h - shared * k) / (k * rest))
    both = 0.5 * (ndtr(h) + ndtr(k)) - turns - np.where(h * k < 0, 0.5, 0.0)
    return np.asarray(np.clip(both, 0.0, np.minimum(ndtr(h), ndtr(k))))


def beyond(load: Forces, edges: FloatArray, masses: FloatArray, scale: npt.ArrayLike = 1.0) -> FloatArray:
    """P(|T| > scale mu N) over the errors of the load and the density of mu, shape (frames,).

    load and scale (frames,); edges (frames or 1, k + 1), masses (frames or 1, k). With a moment it is the part
    beyond the limit surface.
    """
    frames = load.normal.size
    factor = np.broadcast_to(np.asarray(scale, dtype=np.float64), (frames,))
    out = np.empty(frames)
    if load.turns:
        return _beyond_surface(load, edges, masses, factor)
    if load.on_area:
        fill_beyond(*_written(*load[:2], edges, masses, factor), out)
        return out
    every = np.arange(frames)
    for index in np.split(every, every[:: max(1, _BLOCK // masses.shape[-1])][1:]):
        cells = cells_beyond(load.at(index), picked(edges, index), factor[index])
        out[index] = (cells * picked(masses, index)).sum(axis=-1)
    return out


def _written(*given: FloatArray) -> list[FloatArray]:
    """Copies: loops are compiled for arrays that can be written and are alike in memory."""
    return [np.array(v, dtype=np.float64, order="C") for v in given]


def levels(load: Forces, edges: FloatArray, masses: FloatArray, probability: float, *, by_ratio: bool) -> FloatArray:
    """Where |T| > r mu N with a `probability`: the r (frames,) by ratio, else the normal force, r being 1.

    0 where the load slips less often for any of these, infinite where for all it slips more often; edges and masses as
    of `beyond`.
    """
    if load.turns:
        return _levels(load, edges, masses, probability, by_ratio)
    out = np.empty(load.normal.size)
    fill_levels(*_written(*load[:2], edges, masses), probability, by_ratio, out)
    if not load.on_area:
        pressed = load.normal if by_ratio else out
        index = np.flatnonzero(~(pressed >= SURE * np.sqrt(load.covariance[:, 0, 0])))
        if index.size:
            out[index] = _levels(load.at(index), picked(edges, index), picked(masses, index), probability, by_ratio)
    return out


def _levels(load: Forces, edges: FloatArray, masses: FloatArray, probability: float, by_ratio: bool) -> FloatArray:
    """As `levels`, by `beyond`: of loads that turn, and of those of a row that may pull."""
    from scipy.optimize.elementwise import bracket_root, find_root

    def excess(x: FloatArray, at: npt.NDArray[np.intp]) -> FloatArray:
        part, scale = (load.at(at), np.exp(x)) if by_ratio else (load.at(at).with_(x), 1.0)
        slips = beyond(part, picked(edges, at), picked(masses, at), scale)
        # tails are nearly straight in the logarithm
        return np.asarray(np.log(np.maximum(slips, 1e-300)) - np.log(probability))

    frames = load.normal.size
    f: Callable[..., FloatArray] = excess
    least, every = -FARTHEST if by_ratio else 0.0, np.arange(frames)
    out = np.where(excess(np.full(frames, least), every) <= 0, least, np.inf)
    index = np.flatnonzero(out > least)
    size = np.abs(load.tangential) + np.sqrt(load.covariance[:, 1, 1]) + np.sqrt(load.covariance[:, 0, 0])
    guess = np.zeros(index.size) if by_ratio else size[index]
    ends = bracket_root(f, np.full(index.size, least), guess, xmin=least, args=(index,), maxiter=DOUBLINGS)
    low, high = (np.asarray(end)[ends.success] for end in ends.bracket)
    index = index[ends.success]
    out[index] = find_root(
        f, (low, high), args=(index,), tolerances={"xatol": 0.0, "xrtol": 1e-12, "fatol": 0.0, "frtol": 0.0}
    ).x
    return np.exp(out) * (out > least) if by_ratio else out


def margin(load: Forces, mean: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """What is left of mu N by the drag that counts, its standard deviation, and that drag over mu N; all (frames,).

    mean, std: of mu. Of loads that turn.
    """
    whole, slope = _steepness(load)
    slope[:, 0] = -mean
    square = np.einsum("fi,fij,fj->f", slope, load.covariance, slope)
    n = load.normal
    with np.errstate(divide="ignore", invalid="ignore"):  # without friction, or without a force
        ratio = whole / (mean * n)
    square = square + std**2 * (n * n + load.covariance[:, 0, 0])
    return mean * n - whole, np.sqrt(np.maximum(square, 0.0)), ratio


def _steepness(load: Forces) -> tuple[FloatArray, FloatArray]:
    """The drag alone that is as near to slipping (frames,), and how it grows with the load (frames, k)."""
    slope = np.zeros_like(load.mean)
    t, m = load.tangential, load.turning
    whole = effective_drag(t, m, load.law)
    h = 1e-3 * whole + 1e-300
    for column, dt, dm in ((1, h, 0 * h), (3, 0 * h, h)):
        up, down = (effective_drag(np.abs(t + sign * dt), np.abs(m + sign * dm), load.law) for sign in (1, -1))
        slope[:, column] = (up - down) / (2 * h)
    return whole, slope


def _beyond_surface(load: Forces, edges: FloatArray, masses: FloatArray, scale: FloatArray) -> FloatArray:
    """As `beyond`, of a drag and a moment: tails along that of the two whose error counts more.

    Gauss and Hermite's rule over the other, over the drag across, and over N.
    """
    slope = _steepness(load)[1]
    error = slope**2 * np.diagonal(load.covariance, axis1=1, axis2=2)
    by_moment = error[:, 3] > error[:, 1]
    out = np.empty(load.normal.size)
    for tails, frames in ((True, np.flatnonzero(by_moment)), (False, np.flatnonzero(~by_moment))):
        step = max(1, _SURFACE_BLOCK // (2 * masses.shape[-1] * _FEW[0].size ** 3))
        for first in range(0, frames.size, step):
            at = frames[first : first + step]
            out[at] = _tails(load.at(at), picked(edges, at), picked(masses, at), scale[at], tails)
    return np.clip(out, 0.0, 1.0)


def _tails(load: Forces, edges: FloatArray, masses: FloatArray, scale: FloatArray, by_moment: bool) -> FloatArray:
    """The part of `_beyond_surface` whose tails are along the moment, or along the drag."""
    from scipy.special import ndtr

    order, each = [1, 2, 0, 3] if by_moment else [3, 2, 0, 1], np.arange(4)
    size = 1e-12 * np.abs(load.mean).sum(axis=-1, keepdims=True)
    square = load.covariance[:, order][:, :, order]
    square[:, each, each] = square[:, each, each] * (1 + 1e-12) + size**2 + 1e-300
    root = np.linalg.cholesky(square)
    grid = np.stack(np.meshgrid(*3 * [_FEW[0]], indexing="ij")).reshape(3, -1)
    share = np.einsum("i,j,k->ijk", *3 * [_FEW[1]]).reshape(-1)
    moved = root[:, :, :3] @ grid
    first, across, normal, own = np.moveaxis(load.mean[:, order, None] + moved, 1, 0)
    half, width = 0.5 * (edges[:, :-1] + edges[:, 1:]), np.diff(edges, axis=-1)
    total, spread = np.zeros(load.normal.size), root[:, None, 3, 3, None]
    for node in (-CELL, CELL):
        hold = (scale[:, None] * (half + node * width))[..., None] * np.maximum(normal, 0.0)[:, None]
        if by_moment:
            cut = moment_held(hold, np.hypot(first, across)[:, None], load.law)
        else:
            held = drag_held(hold, np.abs(first)[:, None], load.law)
            cut = np.sqrt(np.maximum(held**2 - across[:, None] ** 2, 0.0))
        p = ndtr((own[:, None] - cut) / spread) + ndtr((-own[:, None] - cut) / spread)
        total += 0.5 * np.einsum("fkg,fk,g->f", p, np.broadcast_to(masses, p.shape[:2]), share)
    return total


def of_frames(values: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """What each friction has, for each frame."""
    try:
        return np.broadcast_to(values, shape)
    except ValueError:
        seen = f"frictions of shape {values.shape}, frames of shape {shape}"
        raise GeometryError(seen, "one friction serves all frames, or each frame has its own", "friction=0.5") from None


def picked(rows: FloatArray, index: npt.NDArray[np.intp]) -> FloatArray:
    """Some of the rows; where there is only one it serves all."""
    return rows if rows.shape[0] == 1 else rows[index]
