"""How much of an estimate's load lies beyond the friction cone, friction being as uncertain as it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError
from ..estimate import Estimate, Status
from ._cone_area import AreaForces, area_forces, beyond_on_area
from ._cone_kernel import EDGE, SURE, fill_cells

__all__ = ["Forces", "beyond", "cells_beyond", "checked", "falling_root", "forces_of", "of_frames", "picked", "widths"]

BoolArray = npt.NDArray[np.bool_]

_BLOCK = 1 << 18


class Forces(NamedTuple):
    """Normal and tangential force [N/m] and their covariance [(N/m)^2], each of the frames' shape."""

    normal: FloatArray
    tangential: FloatArray
    nn: FloatArray
    nt: FloatArray
    tt: FloatArray

    @property
    def numbers(self) -> tuple[FloatArray, ...]:
        """All fields."""
        return tuple(self)

    def at(self, index: npt.NDArray[np.intp]) -> Forces:
        """The frames of a flat index."""
        return Forces(*(v.reshape(-1)[index] for v in self))


def forces_of(estimate: Estimate, contact: str = "hertz") -> tuple[Forces | AreaForces, BoolArray, BoolArray]:
    """The forces of each frame; whether their error is known; whether the estimator's own cone cut them off.

    Readings are linear in (N, T), so that errors are Gaussian there. contact: whose friction arm divides a moment.
    """
    checked(estimate)
    load, widest = estimate.load, estimate.friction
    forces: Forces | AreaForces
    if estimate.layout.dim == 2:
        forces = area_forces(estimate, contact)
    else:
        square = np.asarray(load.covariance)
        forces = Forces(load.normal, load.tangential, square[..., 1, 1], square[..., 1, 2], square[..., 2, 2])
    found = (estimate.status == Status.OK) | (estimate.status == Status.AMBIGUOUS)
    # where the estimator was told that there is no friction, the drag was not measured
    known = np.isfinite(np.stack(forces.numbers)).all(axis=0)
    told = found & known & (forces.tt > 0)
    edge = np.zeros_like(told)
    if np.isfinite(widest):
        edge = found & (np.abs(forces.tangential) >= widest * forces.normal * (1 - EDGE))
    return forces, told, edge


def checked(estimate: Estimate) -> Estimate:
    """What is an estimate; an error for what is not."""
    if not isinstance(estimate, Estimate):
        raise InvalidValueError(
            f"estimate = {_check.shown(estimate)}",
            "what Finger.locate or Finger.fit returned is needed",
            "decide.slip(finger.fit(readings), friction=0.5)",
        )
    if estimate.layout.aside:
        rule = "a row does not tell the drag across it"
        raise InvalidValueError("an estimate of a point beside a row", rule, "SensorArray.grid(...)")
    return estimate


def widths(load: Forces, mu: FloatArray, side: float) -> FloatArray:
    """Standard deviation of side T - mu N, for `mu` of the frames' shape and one axis more."""
    nn, nt, tt = load.nn[..., None], load.nt[..., None], load.tt[..., None]
    square = tt - 2 * side * mu * nt + mu * mu * nn
    floor = 1e-12 * (np.abs(load.tangential)[..., None] + mu * np.abs(load.normal)[..., None]) + 1e-300
    return np.asarray(np.sqrt(np.maximum(square, floor * floor)))


def cells_beyond(load: Forces, edges: FloatArray, scale: FloatArray | None = None) -> FloatArray:
    """P(|T| > scale mu N), its mean over mu in each cell; edges (frames or 1, k + 1), result (frames, k)."""
    total = np.empty((load.normal.size, edges.shape[-1] - 1))
    factor = np.ones(load.normal.size) if scale is None else scale
    # copies are alike in memory, whatever they are of: the loop is compiled once
    fill_cells(*(np.array(v, order="C") for v in (*load, edges, factor)), total)
    unsure = np.flatnonzero(load.normal < SURE * np.sqrt(np.maximum(load.nn, 0.0)))
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
    shared = np.clip((mu * mu * load.nn[..., None] - load.tt[..., None]) / (one * two), -1 + 1e-15, 1 - 1e-15)
    rest = np.sqrt((1 - shared) * (1 + shared))
    with np.errstate(over="ignore"):
        turns = owens_t(h, (k - shared * h) / (h * rest)) + owens_t(k, (h - shared * k) / (k * rest))
    both = 0.5 * (ndtr(h) + ndtr(k)) - turns - np.where(h * k < 0, 0.5, 0.0)
    return np.asarray(np.clip(both, 0.0, np.minimum(ndtr(h), ndtr(k))))


def beyond(load: Forces | AreaForces, edges: FloatArray, masses: FloatArray, scale: npt.ArrayLike = 1.0) -> FloatArray:
    """P(|T| > scale mu N) over the errors of (N, T) and the density of mu, shape (frames,).

    load and scale (frames,); edges (frames or 1, k + 1), masses (frames or 1, k).
    """
    frames, cells = load.normal.size, masses.shape[-1]
    factor = np.broadcast_to(np.asarray(scale, dtype=np.float64), (frames,))
    if isinstance(load, AreaForces):
        return beyond_on_area(load, edges, masses, factor)
    out = np.empty(frames)
    step = max(1, _BLOCK // cells)
    for first in range(0, frames, step):
        part = slice(first, first + step)
        ends, weights = (v if v.shape[0] == 1 else v[part] for v in (edges, masses))
        out[part] = (cells_beyond(Forces(*(v[part] for v in load)), ends, factor[part]) * weights).sum(axis=-1)
    return out


def falling_root(
    f: Callable[..., FloatArray], low: FloatArray, high: FloatArray, index: npt.NDArray[np.intp]
) -> FloatArray:
    """Where f(x, index) falls through 0 between `low` and `high` (n,), to 1e-12 of x; f > 0 at low, <= 0 at high."""
    from scipy.optimize.elementwise import find_root

    found = find_root(
        f, (low, high), args=(index,), tolerances={"xatol": 0.0, "xrtol": 1e-12, "fatol": 0.0, "frtol": 0.0}
    )
    return np.asarray(found.x)


def of_frames(values: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """What each friction has, for each frame."""
    try:
        return np.broadcast_to(values, shape)
    except ValueError:
        raise GeometryError(
            f"frictions of shape {values.shape}, frames of shape {shape}",
            "one friction serves all frames, or each frame has its own",
            "friction=0.5",
        ) from None


def picked(rows: FloatArray, index: npt.NDArray[np.intp]) -> FloatArray:
    """Some of the rows; where there is only one it serves all."""
    return rows if rows.shape[0] == 1 else rows[index]
