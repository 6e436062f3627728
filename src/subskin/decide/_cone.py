"""How much of an estimate's load lies beyond the friction cone, friction being as uncertain as it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError
from ..estimate import Estimate, Status

__all__ = ["Forces", "beyond", "cells_beyond", "falling_root", "forces_of", "of_frames", "picked", "widths"]

BoolArray = npt.NDArray[np.bool_]

_BLOCK = 1 << 18
_EDGE = 1e-6
_SURE = 8.0
"""Standard deviations from 0 at which a normal force is taken to press for certain: the rest is 6e-16."""


class Forces(NamedTuple):
    """Normal and tangential force [N/m] and their covariance [(N/m)^2], each of the frames' shape."""

    normal: FloatArray
    tangential: FloatArray
    nn: FloatArray
    nt: FloatArray
    tt: FloatArray

    def at(self, index: npt.NDArray[np.intp]) -> Forces:
        """The frames of a flat index."""
        return Forces(*(v.reshape(-1)[index] for v in self))


def forces_of(estimate: Estimate) -> tuple[Forces, BoolArray, BoolArray]:
    """The forces of each frame; whether their error is known; whether the estimator's own cone cut them off.

    Readings are linear in (N, T), so that errors are Gaussian there.
    """
    if not isinstance(estimate, Estimate):
        raise InvalidValueError(
            f"estimate = {repr(estimate)[:60]}",
            "what Finger.locate or Finger.fit returned is needed",
            "decide.slip(finger.fit(readings), friction=0.5)",
        )
    load, widest = estimate.load, estimate.friction
    square = np.asarray(load.covariance)
    forces = Forces(load.normal, load.tangential, square[..., 1, 1], square[..., 1, 2], square[..., 2, 2])
    found = (estimate.status == Status.OK) | (estimate.status == Status.AMBIGUOUS)
    # where the estimator was told that there is no friction, the drag was not measured
    told = found & np.isfinite(np.stack(forces)).all(axis=0) & (forces.tt > 0)
    edge = np.zeros_like(told)
    if np.isfinite(widest):
        edge = found & (np.abs(forces.tangential) >= widest * forces.normal * (1 - _EDGE))
    return forces, told, edge


def widths(load: Forces, mu: FloatArray, side: float) -> FloatArray:
    """Standard deviation of side T - mu N, for `mu` of the frames' shape and one axis more."""
    nn, nt, tt = load.nn[..., None], load.nt[..., None], load.tt[..., None]
    square = tt - 2 * side * mu * nt + mu * mu * nn
    floor = 1e-12 * (np.abs(load.tangential)[..., None] + mu * np.abs(load.normal)[..., None]) + 1e-300
    return np.asarray(np.sqrt(np.maximum(square, floor * floor)))


def cell_mean(low: FloatArray, middle: FloatArray, high: FloatArray) -> FloatArray:
    """Mean of Phi(z) over a cell at whose ends and middle z is given; z is a straight line there, and a little bent.

    With G the integral of Phi and H that of G: the line gives (G2 - G1) / D, the bend 4 b times the mean of
    t (1 - t) phi, which is (G1 + G2) / D^2 - 2 (H2 - H1) / D^3.
    """
    from scipy.special import ndtr

    # from the lower tail: near 1, Phi would be a difference of large numbers
    flip = np.where(low + high > 0, -1.0, 1.0)
    low, middle, high = flip * low, flip * middle, flip * high
    apart = high - low
    centre = 0.5 * (low + high)
    bend = middle - centre
    close = np.abs(apart) < 0.02
    width = np.where(close, 1.0, apart)
    below, above, bell = ndtr(low), ndtr(high), _bell(centre)
    bell_low, bell_high = _bell(low), _bell(high)
    g_low, g_high = low * below + bell_low, high * above + bell_high
    h_low = 0.5 * ((low * low + 1) * below + low * bell_low)
    h_high = 0.5 * ((high * high + 1) * above + high * bell_high)
    square = apart * apart
    line = np.where(
        close,
        ndtr(centre) - centre * bell * square / 24 * (1 + (centre * centre - 3) * square / 80),
        (g_high - g_low) / width,
    )
    bent = np.where(
        close,
        bell * (1 / 6 + (centre * centre - 1) * square / 240),
        ((g_low + g_high) - 2 * (h_high - h_low) / width) / (width * width),
    )
    mean = np.maximum(line + 4 * bend * bent, 0.0)
    return np.asarray(np.where(flip < 0, 1 - mean, mean))


def _bell(z: FloatArray) -> FloatArray:
    return np.asarray(np.exp(-0.5 * np.minimum(np.abs(z), 40.0) ** 2) / np.sqrt(2 * np.pi))


def _deviations(load: Forces, mu: FloatArray, side: float) -> FloatArray:
    """How far side T lies beyond mu N, in standard deviations."""
    return np.asarray((side * load.tangential[..., None] - mu * load.normal[..., None]) / widths(load, mu, side))


def cells_beyond(load: Forces, edges: FloatArray) -> FloatArray:
    """P(|T| > mu N), its mean over mu in each cell between the `edges` (..., k + 1); shape (..., k)."""
    ends, centres = np.asarray(edges), 0.5 * (edges[..., :-1] + edges[..., 1:])
    total: FloatArray = np.zeros(())
    for side in (1.0, -1.0):
        z, middle = (_deviations(load, mu, side) for mu in (ends, centres))
        total = total + cell_mean(z[..., :-1], middle, z[..., 1:])
    unsure = load.normal < _SURE * np.sqrt(np.maximum(load.nn, 0.0))
    if unsure.any():
        both = _both(load.at(np.flatnonzero(unsure)), _rows(edges, unsure))
        total[unsure] = np.maximum(total[unsure] - both, 0.0)
    return np.asarray(np.minimum(total, 1.0))


def _rows(values: FloatArray, which: BoolArray) -> FloatArray:
    return np.asarray(np.broadcast_to(values, (*which.shape, values.shape[-1]))[which])


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


def beyond(load: Forces, edges: FloatArray, masses: FloatArray, scale: npt.ArrayLike = 1.0) -> FloatArray:
    """P(|T| > scale mu N) over the errors of (N, T) and the density of mu, shape (frames,).

    load and scale (frames,); edges (frames or 1, k + 1), masses (frames or 1, k).
    """
    frames, cells = load.normal.size, masses.shape[-1]
    factor = np.broadcast_to(np.asarray(scale, dtype=np.float64), (frames,))
    out = np.empty(frames)
    step = max(1, _BLOCK // cells)
    for first in range(0, frames, step):
        part = slice(first, first + step)
        ends, weights = (v if v.shape[0] == 1 else v[part] for v in (edges, masses))
        values = cells_beyond(Forces(*(v[part] for v in load)), factor[part, None] * ends)
        out[part] = (values * weights).sum(axis=-1)
    return out


def falling_root(
    f: Callable[[FloatArray, npt.NDArray[np.intp]], FloatArray], low: FloatArray, high: FloatArray
) -> FloatArray:
    """Where f(x, index) falls through 0 between `low` and `high` (n,), to 1e-12 of x; f > 0 at low, <= 0 at high.

    Chandrupatla (1997): inverse quadratic interpolation where it is safe, halving elsewhere.
    """
    every = np.arange(low.size)
    b, a = np.array(low, dtype=np.float64), np.array(high, dtype=np.float64)
    fb, fa = f(b, every), f(a, every)
    c, fc, t = b.copy(), fb.copy(), np.full(low.size, 0.5)
    out = np.where(fa == 0, a, 0.5 * (a + b))
    left = np.flatnonzero((fa != 0) & (a != b))
    for _ in range(200):
        if not left.size:
            break
        x = a[left] + t[left] * (b[left] - a[left])
        fx = f(x, left)
        same = np.sign(fx) == np.sign(fa[left])
        c[left], fc[left] = np.where(same, a[left], b[left]), np.where(same, fa[left], fb[left])
        b[left], fb[left] = np.where(same, b[left], a[left]), np.where(same, fb[left], fa[left])
        a[left], fa[left] = x, fx
        best = np.where(np.abs(fx) < np.abs(fb[left]), x, b[left])
        out[left] = best
        with np.errstate(divide="ignore"):
            limit = 1e-12 * np.abs(best) / np.abs(b[left] - a[left])
        t[left] = _next(a[left], b[left], c[left], fx, fb[left], fc[left], limit)
        left = left[(limit < 0.5) & (fx != 0)]
    return out


def _next(
    a: FloatArray, b: FloatArray, c: FloatArray, fa: FloatArray, fb: FloatArray, fc: FloatArray, limit: FloatArray
) -> FloatArray:
    """How far from a towards b the next trial is."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        position, value = (a - b) / (c - b), (fa - fb) / (fc - fb)
        safe = (value**2 < position) & ((1 - value) ** 2 < 1 - position)
        t = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
    t = np.where(safe & np.isfinite(t), t, 0.5)
    return np.clip(t, np.minimum(limit, 0.5), np.maximum(1 - limit, 0.5))


def of_frames(values: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """What each friction has, for each frame."""
    try:
        return np.broadcast_to(values, shape)
    except ValueError:
        raise GeometryError(
            f"frictions of shape {values.shape}, frames of shape {shape}",
            "one friction serves all frames, or each frame has its own",
        ) from None


def picked(rows: FloatArray, index: npt.NDArray[np.intp]) -> FloatArray:
    """Some of the rows; where there is only one it serves all."""
    return rows if rows.shape[0] == 1 else rows[index]
