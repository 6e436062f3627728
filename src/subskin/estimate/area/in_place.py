"""Compiled: the load that explains a frame by a response measured in place, whose doubt is weighed with the noise."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._check import FloatArray
from ..._compiled import compiled
from ..cone import eliminate_one, eliminate_three
from ..layout import AREA
from ..varpro import Limits
from .judge import widest_variance
from .point import FIT, covariance, information

_MOST, _STEPS, _SWEEPS = 8, 25, 3
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_FORCES, _COVARIANCE, _RESIDUAL, _RIVAL = AREA.components, AREA.covariance, AREA.residual, AREA.rival
_RIVAL_CHI2, _STATUS = AREA.rival_chi2, AREA.status


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
    """Thresholds: `stride`: nodes from one to the next of a scan; `doubtful`: chi-square from which all are scanned."""

    limits: Limits
    stride: int
    detection: float
    largest: float
    ambiguity: float
    doubtful: float


class _Room(NamedTuple):
    """Scratch: sums (3, 3), along (3,), shared (3,), slopes (2, 3); here, doubt (3, n, c): values and slopes."""

    sums: FloatArray
    along: FloatArray
    shared: FloatArray
    slopes: FloatArray
    here: FloatArray
    doubt: FloatArray


@compiled()
def _doubt(variance, i, load):
    """Variance of the mixed reading i: 1 of the noise and, of a `load` (3,), the doubt of the response (n, c)."""
    v = 1.0
    for j in range(variance.shape[1]):
        v += load[j] * load[j] * variance[i, j]
    return v


@compiled()
def _cost(r, common, values, variance, load, limits, room, fit):
    """Chi-square left of a frame r (n,) at a node; the components into fit.

    The errors' covariance is that of the independent ones and `common` (n,) times its transpose, by whose part
    everything is less (Sherman and Morrison).
    """
    g, b, s, components = room.sums, room.along, room.shared, values.shape[1]
    for j in range(3):
        b[j] = s[j] = 0.0
        for k in range(3):
            g[j, k] = 0.0
    out, size, along = 0.0, 1.0, 0.0
    for i in range(r.size):
        w = 1.0 / _doubt(variance, i, load)
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
    return out - along * along / size - fit.explained


@compiled(inline=True)
def _at(p, size):
    """The second of four nodes about p, and how far from it."""
    second = min(max(int(p), 1), size - 3)
    return second, p - second


@compiled(inline=True)
def _cubic(t):
    """Weights of four nodes at -1, 0, 1, 2 (Lagrange), and their slopes."""
    return (
        (
            -t * (t - 1.0) * (t - 2.0) / 6.0,
            0.5 * (t * t - 1.0) * (t - 2.0),
            -0.5 * t * (t + 1.0) * (t - 2.0),
            t * (t * t - 1.0) / 6.0,
        ),
        (
            -(3.0 * t * t - 6.0 * t + 2.0) / 6.0,
            0.5 * (3.0 * t * t - 4.0 * t - 1.0),
            -0.5 * (3.0 * t * t - 2.0 * t - 2.0),
            (3.0 * t * t - 1.0) / 6.0,
        ),
    )


@compiled()
def _between(table, p, q, out):
    """Values of a table (k, l, n, c) between its nodes, and their slopes a node: out (3, n, c), by cubics."""
    j, s = _at(p, table.shape[0])
    k, t = _at(q, table.shape[1])
    a, da = _cubic(s)
    b, db = _cubic(t)
    out[:] = 0.0
    for e in range(4):
        for f in range(4):
            u, v, w = a[e] * b[f], da[e] * b[f], a[e] * db[f]
            for i in range(table.shape[2]):
                for c in range(table.shape[3]):
                    x = table[j + e - 1, k + f - 1, i, c]
                    out[0, i, c] += u * x
                    out[1, i, c] += v * x
                    out[2, i, c] += w * x


@compiled()
def _settle(r, model, limits, p, q, load, room, fit):
    """From node (p, q) to the best position, where it ends in fit.y and fit.z, in nodes; fit is that of a point load.

    Gauss-Newton steps; the doubt changes with the position too. A step that worsens it is halved. The likelihood would
    have the logarithm of the variances as well: it draws loads to where touches have been, and is left out. Returns the
    chi-square left.
    """
    last, common, here, doubt, shared, slopes = math.inf, model.common, room.here, room.doubt, room.shared, room.slopes
    step_p = step_q = 0.0
    top_p, top_q, components = model.values.shape[0] - 1.0, model.values.shape[1] - 1.0, model.values.shape[3]
    for _ in range(_STEPS):
        _between(model.values, p, q, here)
        _between(model.variance, p, q, doubt)
        for i in range(r.size):
            for c in range(components):
                doubt[0, i, c] = max(doubt[0, i, c], 0.0)
        cost = _cost(r, common, here[0], doubt[0], load, limits, room, fit)
        if cost > last + 1e-9 and abs(step_p) + abs(step_q) > 1e-6:
            p, q, step_p, step_q = p - 0.5 * step_p, q - 0.5 * step_q, 0.5 * step_p, 0.5 * step_q
            continue
        done = last - cost < 1e-4
        last = cost
        force = (fit.n, fit.ty, fit.tz)
        gp = gq = upp = upq = uqq = cp = cq = 0.0
        size, level = 1.0, 0.0
        for i in range(r.size):
            rest = r[i]
            for c in range(components):
                rest -= force[c] * here[0, i, c]
            wc = common[i] / _doubt(doubt[0], i, load)
            size += wc * common[i]
            level += wc * rest
        level /= size  # the likeliest error in common
        left = level * level
        for c in range(3):
            shared[c] = slopes[0, c] = slopes[1, c] = 0.0
        for i in range(r.size):
            v = _doubt(doubt[0], i, load)
            rest, dv, dw = r[i] - level * common[i], 0.0, 0.0
            up = uq = 0.0
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
                shared[c] += common[i] * here[0, i, c] / v
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
        long = math.hypot(step_p, step_q)
        if long > 1.5:
            step_p, step_q = 1.5 * step_p / long, 1.5 * step_q / long
        before_p, before_q = p, q
        p, q = min(max(p + step_p, 0.0), top_p), min(max(q + step_q, 0.0), top_q)
        step_p, step_q = p - before_p, q - before_q
    return last


@compiled(inline=True)
def _put(fit, y, z, at):
    """Where a fit is [m], into at (2,)."""
    at[0], at[1] = y[0] + fit.y * y[1], z[0] + fit.z * z[1]


@compiled(frames="readings")
def in_place_frames(readings, rows, mix, model, typical, settings, out):
    """Fill `out`, one row a frame; those that lack a sensor are left with status -1.

    readings (f, n), raw; rows (4, n): offset, 1 / noise, low and high end of the range; mix (n, n): what makes readings
    of errors that are independent, of variance 1 by noise; typical (3,): a load like the calibration's.
    """
    frames, n = readings.shape
    values, variance, common, y, z, limits = (
        model.values,
        model.variance,
        model.common,
        model.y,
        model.z,
        settings.limits,
    )
    r, load, best_force, more = np.empty(n), np.empty(3), np.empty(3), np.zeros(3)
    cost, score, at = np.empty(values.shape[:2]), np.empty(_MOST), np.empty((_MOST, 2), dtype=np.int64)
    fits, ends = np.zeros(_MOST + 1, FIT), np.empty(_MOST)
    room = _Room(
        np.empty((3, 3)), np.empty(3), np.empty(3), np.empty((2, 3)), np.empty((3, n, values.shape[3])),
        np.empty((3, n, values.shape[3])),
    )  # fmt: skip
    fit = fits[_MOST]
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
        if not (usable and total < 1e30):
            row[_STATUS] = _PENDING
            continue
        apart, top, rival = settings.stride, 0, -1
        while True:
            first, second = (values.shape[0] - 1) // apart + 1, (values.shape[1] - 1) // apart + 1
            load[:] = typical
            count = 0
            for _ in range(_SWEEPS):
                best = math.inf
                for j in range(first):
                    for k in range(second):
                        p, q = j * apart, k * apart
                        cost[j, k] = _cost(r, common, values[p, q], variance[p, q], load, limits, room, fit)
                        if cost[j, k] < best:
                            best = cost[j, k]
                            best_force[0], best_force[1], best_force[2] = fit.n, fit.ty, fit.tz
                size, moved = 0.0, 0.0
                for j in range(3):
                    moved += (abs(best_force[j]) - abs(load[j])) ** 2
                    size += best_force[j] ** 2
                if not moved > 0.01 * size:
                    break
                for j in range(3):
                    load[j] = best_force[j]
            for j in range(first):  # the lowest nodes of the scan, each lower than its neighbours
                for k in range(second):
                    here_is = cost[j, k]
                    lower = True
                    for e in range(max(j - 1, 0), min(j + 2, first)):
                        for d in range(max(k - 1, 0), min(k + 2, second)):
                            lower &= not cost[e, d] < here_is
                    if not lower:
                        continue
                    rank = count
                    while rank > 0 and score[rank - 1] > here_is:
                        rank -= 1
                    if rank < _MOST:
                        for e in range(min(count, _MOST - 1), rank, -1):
                            score[e] = score[e - 1]
                            at[e, 0], at[e, 1] = at[e - 1, 0], at[e - 1, 1]
                        score[rank], at[rank, 0], at[rank, 1] = here_is, j * apart, k * apart
                        count = min(count + 1, _MOST)
            top = rival = -1
            for e in range(count):
                p, q = float(at[e, 0]), float(at[e, 1])
                ends[e] = _settle(r, model, limits, p, q, load, room, fits[e])
                if top < 0 or ends[e] < ends[top]:
                    top = e
            for e in range(count):
                away = math.hypot(fits[e].y - fits[top].y, fits[e].z - fits[top].z)
                if away > 1.0 and (rival < 0 or ends[e] < ends[rival]):
                    rival = e
            if apart == 1 or not fits[top].left > settings.doubtful:
                break
            apart = 1  # what the scan hardly explains may lie in a narrow valley between its nodes
        one = fits[top]
        row[_RESIDUAL] = one.left
        if one.left > settings.largest:
            row[_STATUS] = _UNEXPLAINED
            continue
        if total - ends[top] < settings.detection:
            row[_STATUS] = _NO_CONTACT
            continue
        if limits.friction == 0.0 and one.i_n_n == 0.0:
            one.g_n_n = math.inf  # the force is not free
        p, q = one.y, one.z
        _put(one, y, z, row)
        row[_FORCES], row[_FORCES + 1], row[_FORCES + 2] = one.n, one.ty, one.tz
        one.u_y_y, one.u_y_z, one.u_z_z = (
            one.u_y_y / (y[1] * y[1]), one.u_y_z / (y[1] * z[1]), one.u_z_z / (z[1] * z[1])
        )  # fmt: skip
        one.a_y_n, one.a_y_ty, one.a_y_tz = one.a_y_n / y[1], one.a_y_ty / y[1], one.a_y_tz / y[1]
        one.a_z_n, one.a_z_ty, one.a_z_tz = one.a_z_n / z[1], one.a_z_ty / z[1], one.a_z_tz / z[1]
        covariance(one, limits, more, row[_COVARIANCE:])
        wide = widest_variance(row)
        status = _OK
        if rival >= 0:
            other = fits[rival]
            _put(other, y, z, row[_RIVAL:])
            row[_RIVAL + 2], row[_RIVAL + 3], row[_RIVAL + 4] = other.n, other.ty, other.tz
            row[_RIVAL_CHI2] = max(ends[rival] - ends[top], 0.0)
            if ends[rival] - ends[top] < settings.ambiguity:
                status = _AMBIGUOUS
        if not (0.5 < p < values.shape[0] - 1.5 and 0.5 < q < values.shape[1] - 1.5):
            status = _AMBIGUOUS
        reach = 6.0 * math.sqrt(wide) + 0.75 * apart * max(y[1], z[1])
        if not reach < math.inf:
            status = _AMBIGUOUS
        elif status == _OK:
            for j in range(first):
                for k in range(second):
                    away = math.hypot((j * apart - p) * y[1], (k * apart - q) * z[1])
                    if away > reach and cost[j, k] < ends[top] + settings.ambiguity:
                        status = _AMBIGUOUS
        row[_STATUS] = status
