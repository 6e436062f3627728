"""Compiled: the load that explains a frame by a response measured in place, whose doubt is weighed with the noise."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..cone import eliminate_one, eliminate_three
from ..layout import AREA
from ..varpro import Limits
from .fall import widest_variance
from .point import FIT, covariance, information

_MOST, _STEPS, _SWEEPS = 8, 25, 3
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_FORCES, _COVARIANCE, _RESIDUAL, _RIVAL = AREA.components, AREA.covariance, AREA.residual, AREA.rival
_RIVAL_CHI2, _STATUS = AREA.rival_chi2, AREA.status


_CUBIC = np.linalg.inv(np.vander([-1.0, 0.0, 1.0, 2.0], increasing=True)).T.copy()
"""Of each of four nodes the powers of its weight (Lagrange)."""


class InPlaceModel(NamedTuple):
    """What sensors read in place.

    common (n,): standard deviations of the error that mixed readings have in common; values, variance (k, l, n, c), of
    mixed readings at the nodes; y, z: first node and step of these.
    """

    common: FloatArray
    values: FloatArray
    variance: FloatArray
    y: FloatArray
    z: FloatArray


class InPlaceSettings(NamedTuple):
    """Thresholds: `stride`: nodes from one to the next of a scan; `doubtful`: chi-square from which all are scanned;
    `vague`: variance of a position from which a frame is AMBIGUOUS.
    """

    limits: Limits
    stride: int
    detection: float
    largest: float
    ambiguity: float
    doubtful: float
    vague: float


class _Room(NamedTuple):
    """Scratch: sums (3, 3), along, shared, load (3,), slopes (2, 3); here, doubt (3, n, c): values and slopes; cost
    (k, l) of the nodes; score (most,), at (most, 2): the lowest of them; fits: of these and one more; ends (most,).
    """

    sums: FloatArray
    along: FloatArray
    shared: FloatArray
    load: FloatArray
    slopes: FloatArray
    here: FloatArray
    doubt: FloatArray
    cost: FloatArray
    score: FloatArray
    at: npt.NDArray[np.int64]
    fits: npt.NDArray[np.void]
    ends: FloatArray


@compiled()
def _doubt(variance, i, load):
    """Variance of the mixed reading i: 1 of the noise and, of a `load` (3,), the doubt of the response (n, c)."""
    v = 1.0
    for j in range(variance.shape[1]):
        v += load[j] * load[j] * variance[i, j]
    return v


@compiled()
def _cost(r, common, values, variance, limits, room, fit):
    """Chi-square left of a frame r (n,) at a node, and the likeliest error in common; the components into fit.

    The errors' covariance is that of the independent ones and `common` (n,) times its transpose, by whose part
    everything is less (Sherman and Morrison).
    """
    g, b, s, components = room.sums, room.along, room.shared, values.shape[1]
    g[:], b[:], s[:] = 0.0, 0.0, 0.0
    out, size, along = 0.0, 1.0, 0.0
    for i in range(r.size):
        w = 1.0 / _doubt(variance, i, room.load)
        wc = w * common[i]
        size += wc * common[i]
        along += wc * r[i]
        out += w * r[i] * r[i]
        for j in range(components):
            a = values[i, j]
            b[j] += w * a * r[i]
            s[j] += wc * a
            for k in range(j, components):
                g[j, k] += w * a * values[i, k]
    for j in range(components):
        b[j] -= along * s[j] / size
        for k in range(j, components):
            g[j, k] -= s[j] * s[k] / size
    fit.g_n_n, fit.g_n_ty, fit.g_n_tz = g[0, 0], g[0, 1], g[0, 2]
    fit.g_ty_ty, fit.g_ty_tz, fit.g_tz_tz = g[1, 1], g[1, 2], g[2, 2]
    if components == 1:
        fit.ty = fit.tz = fit.i_n_ty = fit.i_n_tz = fit.i_ty_ty = fit.i_ty_tz = fit.i_tz_tz = 0.0
        fit.n, fit.explained, fit.i_n_n, fit.inside = eliminate_one(g[0, 0], b[0], limits.least, limits.most)
    else:
        (
            fit.n, fit.ty, fit.tz, fit.explained, fit.i_n_n, fit.i_n_ty, fit.i_n_tz, fit.i_ty_ty, fit.i_ty_tz,
            fit.i_tz_tz, fit.inside,
        ) = eliminate_three(
            g[0, 0], g[0, 1], g[0, 2], g[1, 1], g[1, 2], g[2, 2], b[0], b[1], b[2], limits.friction
        )  # fmt: skip
    level = (along - s[0] * fit.n - s[1] * fit.ty - s[2] * fit.tz) / size
    return out - along * along / size - fit.explained, level, size


@compiled(inline=True)
def _weight(e, t):
    """How much the e-th of four nodes at -1, 0, 1, 2 has in a cubic at t, and the slope of that."""
    c0, c1, c2, c3 = _CUBIC[e, 0], _CUBIC[e, 1], _CUBIC[e, 2], _CUBIC[e, 3]
    return c0 + t * (c1 + t * (c2 + t * c3)), c1 + t * (2.0 * c2 + 3.0 * t * c3)


@compiled()
def _between(table, p, q, out):
    """Values of a table (k, l, n, c) between its nodes, and their slopes a node: out (3, n, c), by cubics."""
    j, k = min(max(int(p), 1), table.shape[0] - 3), min(max(int(q), 1), table.shape[1] - 3)
    out[:] = 0.0
    for e in range(4):
        a, da = _weight(e, p - j)
        for f in range(4):
            b, db = _weight(f, q - k)
            for i in range(table.shape[2]):
                for c in range(table.shape[3]):
                    x = table[j + e - 1, k + f - 1, i, c]
                    out[0, i, c] += a * b * x
                    out[1, i, c] += da * b * x
                    out[2, i, c] += a * db * x


@compiled()
def _settle(r, model, limits, p, q, room, fit):
    """From node (p, q) to the best position, where it ends in fit.y and fit.z, in nodes; fit is that of a point load.

    Gauss-Newton steps; the doubt changes with the position too. A step that worsens it is halved. The likelihood would
    have the logarithm of the variances as well: it draws loads to where touches have been, and is left out. Returns the
    chi-square left.
    """
    last, common, here, doubt, shared, slopes, load = (
        math.inf, model.common, room.here, room.doubt, room.shared, room.slopes, room.load
    )  # fmt: skip
    step_p = step_q = 0.0
    top_p, top_q, components = model.values.shape[0] - 1.0, model.values.shape[1] - 1.0, model.values.shape[3]
    for _ in range(_STEPS):
        _between(model.values, p, q, here)
        _between(model.variance, p, q, doubt)
        for i in range(r.size):
            for c in range(components):
                doubt[0, i, c] = max(doubt[0, i, c], 0.0)
        cost, level, size = _cost(r, common, here[0], doubt[0], limits, room, fit)
        if cost > last + 1e-9 and abs(step_p) + abs(step_q) > 1e-6:
            p, q, step_p, step_q = p - 0.5 * step_p, q - 0.5 * step_q, 0.5 * step_p, 0.5 * step_q
            continue
        done = last - cost < 1e-4
        last = cost
        force = (fit.n, fit.ty, fit.tz)
        gp = gq = upp = upq = uqq = cp = cq = 0.0
        left = level * level
        slopes[:] = 0.0
        for i in range(r.size):
            v, rest = _doubt(doubt[0], i, load), r[i] - level * common[i]
            up = uq = dv = dw = 0.0
            for c in range(components):
                rest -= force[c] * here[0, i, c]
                up += force[c] * here[1, i, c]
                uq += force[c] * here[2, i, c]
                dv += load[c] * load[c] * doubt[1, i, c]
                dw += load[c] * load[c] * doubt[2, i, c]
            more = -0.5 * rest * rest / (v * v)
            gp += rest * up / v - more * dv
            gq += rest * uq / v - more * dw
            left += rest * rest / v
            upp += up * up / v
            upq += up * uq / v
            uqq += uq * uq / v
            cp += common[i] * up / v
            cq += common[i] * uq / v
            for c in range(components):
                slopes[0, c] += here[0, i, c] * up / v
                slopes[1, c] += here[0, i, c] * uq / v
        for c in range(components):
            slopes[0, c] -= shared[c] * cp / size
            slopes[1, c] -= shared[c] * cq / size
        fit.left, fit.y, fit.z, fit.by_y, fit.by_z = left, p, q, gp, gq
        fit.u_y_y, fit.u_y_z, fit.u_z_z = upp - cp * cp / size, upq - cp * cq / size, uqq - cq * cq / size
        fit.a_y_n, fit.a_y_ty, fit.a_y_tz = slopes[0, 0], slopes[0, 1], slopes[0, 2]
        fit.a_z_n, fit.a_z_ty, fit.a_z_tz = slopes[1, 0], slopes[1, 1], slopes[1, 2]
        if done:
            break
        told = information(fit)
        det = told.y_y * told.z_z - told.y_z * told.y_z
        det = det if det > 1e-9 * told.y_y * told.z_z else told.y_y * told.z_z + 1e-300
        step_p, step_q = (told.z_z * gp - told.y_z * gq) / det, (told.y_y * gq - told.y_z * gp) / det
        shorter = 1.5 / max(math.hypot(step_p, step_q), 1.5)
        before_p, before_q = p, q
        p = min(max(p + shorter * step_p, 0.0), top_p)
        q = min(max(q + shorter * step_q, 0.0), top_q)
        step_p, step_q = p - before_p, q - before_q
    return last


@compiled()
def _scan(r, model, limits, typical, apart, room):
    """Chi-square left at every `apart`-th node, into room.cost; the doubt is that of the best node's load."""
    values, load, cost, fit = model.values, room.load, room.cost, room.fits[_MOST]
    load[:] = typical
    for _ in range(_SWEEPS):
        best, force = math.inf, (0.0, 0.0, 0.0)
        for p in range(0, values.shape[0], apart):
            for q in range(0, values.shape[1], apart):
                here = _cost(r, model.common, values[p, q], model.variance[p, q], limits, room, fit)[0]
                cost[p // apart, q // apart] = here
                if here < best:
                    best, force = here, (fit.n, fit.ty, fit.tz)
        size, moved = 0.0, 0.0
        for j in range(3):
            moved += (abs(force[j]) - abs(load[j])) ** 2
            size += force[j] ** 2
        if not moved > 0.01 * size:
            break
        for j in range(3):
            load[j] = force[j]


@compiled()
def _lowest(cost, apart, score, at):
    """The lowest nodes of a scan, each lower than its neighbours, the best first: how many."""
    count = 0
    for j in range(cost.shape[0]):
        for k in range(cost.shape[1]):
            here, lower = cost[j, k], True
            for e in range(max(j - 1, 0), min(j + 2, cost.shape[0])):
                for d in range(max(k - 1, 0), min(k + 2, cost.shape[1])):
                    lower &= not cost[e, d] < here
            rank = count
            while rank > 0 and score[rank - 1] > here:
                rank -= 1
            if lower and rank < _MOST:
                for e in range(min(count, _MOST - 1), rank, -1):
                    score[e] = score[e - 1]
                    at[e, 0], at[e, 1] = at[e - 1, 0], at[e - 1, 1]
                score[rank], at[rank, 0], at[rank, 1] = here, j * apart, k * apart
                count = min(count + 1, _MOST)
    return count


@compiled()
def _tops(r, model, limits, cost, apart, room):
    """The best load and its rival, at least a node away, as rows of room.fits; -1 where there is none."""
    fits, ends, at, top, rival = room.fits, room.ends, room.at, -1, -1
    count = _lowest(cost, apart, room.score, at)
    for e in range(count):
        ends[e] = _settle(r, model, limits, float(at[e, 0]), float(at[e, 1]), room, fits[e])
        if top < 0 or ends[e] < ends[top]:
            top = e
    for e in range(count):
        away = math.hypot(fits[e].y - fits[top].y, fits[e].z - fits[top].z)
        if away > 1.0 and (rival < 0 or ends[e] < ends[rival]):
            rival = e
    return top, rival


@compiled(inline=True)
def _put(fit, y, z, at):
    """Position [m] and components of a fit, into at; y, z: first node and step."""
    at[0], at[1] = y[0] + y[1] * fit.y, z[0] + z[1] * fit.z
    at[_FORCES], at[_FORCES + 1], at[_FORCES + 2] = fit.n, fit.ty, fit.tz


@compiled()
def _frame(r, total, model, typical, settings, room, row):
    """Fill the row of a frame of mixed readings r (n,), whose chi-square is `total`."""
    limits, y, z, fits, ends = settings.limits, model.y, model.z, room.fits, room.ends
    apart = settings.stride
    while True:
        cost = room.cost[: (model.values.shape[0] - 1) // apart + 1, : (model.values.shape[1] - 1) // apart + 1]
        _scan(r, model, limits, typical, apart, room)
        top, rival = _tops(r, model, limits, cost, apart, room)
        if apart == 1 or not fits[top].left > settings.doubtful:
            break
        apart = 1  # what the scan hardly explains may lie in a narrow valley between its nodes
    one = fits[top]
    row[_RESIDUAL] = one.left
    if one.left > settings.largest or total - ends[top] < settings.detection:
        row[_STATUS] = _UNEXPLAINED if one.left > settings.largest else _NO_CONTACT
        return
    if limits.friction == 0.0 and one.i_n_n == 0.0:
        one.g_n_n = math.inf  # the force is not free
    p, q, status = one.y, one.z, _OK
    _put(one, y, z, row)
    one.u_y_y, one.u_y_z, one.u_z_z = (
        one.u_y_y / (y[1] * y[1]), one.u_y_z / (y[1] * z[1]), one.u_z_z / (z[1] * z[1])
    )  # fmt: skip
    one.a_y_n, one.a_y_ty, one.a_y_tz = one.a_y_n / y[1], one.a_y_ty / y[1], one.a_y_tz / y[1]
    one.a_z_n, one.a_z_ty, one.a_z_tz = one.a_z_n / z[1], one.a_z_ty / z[1], one.a_z_tz / z[1]
    spread = row[_COVARIANCE:_RESIDUAL]
    covariance(one, limits, np.zeros(3), spread)
    if rival >= 0:
        _put(fits[rival], y, z, row[_RIVAL:])
        row[_RIVAL_CHI2] = max(ends[rival] - ends[top], 0.0)
        if ends[rival] - ends[top] < settings.ambiguity:
            status = _AMBIGUOUS
    if not (0.5 < p < model.values.shape[0] - 1.5 and 0.5 < q < model.values.shape[1] - 1.5):
        status = _AMBIGUOUS
    variance = widest_variance(spread)
    reach = 6.0 * math.sqrt(variance) + 0.75 * apart * max(y[1], z[1])
    if not variance < settings.vague:
        status = _AMBIGUOUS
    for j in range(cost.shape[0] if status == _OK else 0):
        for k in range(cost.shape[1]):
            away = math.hypot((j * apart - p) * y[1], (k * apart - q) * z[1])
            if away > reach and cost[j, k] < ends[top] + settings.ambiguity:
                status = _AMBIGUOUS
    row[_STATUS] = status


@compiled(frames="readings")
def in_place_frames(readings, rows, mix, model, typical, settings, out):
    """Fill `out`, one row a frame; those that lack a sensor are left with status -1.

    readings (f, n), raw; rows (4, n): offset, 1 / noise, low and high end of the range; mix (n, n): what makes readings
    of errors that are independent, of variance 1 by noise; typical (3,): a load like the calibration's.
    """
    (frames, n), (k, m, _, c), common = readings.shape, model.values.shape, model.common
    room = _Room(
        np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3), np.empty((2, 3)), np.empty((3, n, c)),
        np.empty((3, n, c)), np.empty((k, m)), np.empty(_MOST), np.empty((_MOST, 2), dtype=np.int64),
        np.zeros(_MOST + 1, FIT), np.empty(_MOST),
    )  # fmt: skip
    r = np.empty(n)
    for f in range(frames):
        row = out[f]
        row[:] = math.nan
        row[_RIVAL_CHI2] = math.inf
        total, size, along, usable = 0.0, 1.0, 0.0, True
        for i in range(n):
            usable &= rows[2, i] < readings[f, i] < rows[3, i]
            r[i] = 0.0
            for j in range(n):
                r[i] += mix[i, j] * (readings[f, j] - rows[0, j])
            total += r[i] * r[i]
            size += common[i] * common[i]
            along += common[i] * r[i]
        total -= along * along / size
        if usable and total < 1e30:
            _frame(r, total, model, typical, settings, room, row)
        else:
            row[_STATUS] = _PENDING
