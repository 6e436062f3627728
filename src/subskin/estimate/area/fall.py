"""Compiled: how far S falls round its top, one position at a time or eight at once, and whether that is a parabola.

Near the top a sensor's functions of the distance are cubics in 1 / v (`point.py`), about the middle of the cell in
which v lies at the top: where readings fall off with a power of the distance, as they do, these hold far beyond the
cell; a series that holds at all distances is asked itself. Sums run over what the best load leaves of the readings, so
that no digits are lost.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._compiled import compiled
from ..._lanes import EIGHT, alike, answers, eight, nought, put, where
from ..._lanes import root as square_root
from ..cone import cofactors, on_cone
from .point import CELLS, ONE, REST, Point, cell_of, coefficients, project, read, slopes

LANES = 3 * EIGHT
"""Numbers of scratch: how far S falls, and the moves in y and in z, of eight positions."""
_TO_Y, _TO_Z = EIGHT, 2 * EIGHT
_TURNS = 2 * np.pi * np.arange(EIGHT) / EIGHT
ROUND = np.stack([np.cos(_TURNS), np.sin(_TURNS)], axis=-1)
_MIDDLE, _DIGITS = np.int64(1 << 45), np.int64((1 << 52) - 1)
_NEAR, _FAR = 2.5, 4.0
"""Standard deviations at which S is looked at round the top; the farther only where it is no parabola at the nearer."""
_ODD, _LEVEL, _HIGHER = 1.25, 4.0, 0.1
"""Ratio of variances from which it is none; least fall to the farther distance; what counts as higher than the top."""
_CLOSE = 0.25
"""Depths off the top up to which `falls` is asked."""
_YY, _YZ, _ZZ = 0, 1, 5
"""Where a covariance of (y, z, N, Ty, Tz) has what."""


class _Sums(NamedTuple):
    """Of eight positions: chi-square left, A^T rho and A^T A; rho is what the load at the top leaves."""

    left: Any
    n: Any
    ty: Any
    tz: Any
    n_n: Any
    n_ty: Any
    n_tz: Any
    ty_ty: Any
    ty_tz: Any
    tz_tz: Any


@compiled(borrows=True)
def beyond_near(v, model, limits, fit, rest):
    """What sensors that are not in v add to the sums at the top, where nothing binds the forces, into `rest`.

    A fit: its sums by their names; its components are A^T rho.
    """
    project(v, model, limits, Point(fit.y, fit.z), rest)
    rest.n, rest.ty, rest.tz = fit.n, fit.ty, fit.tz
    slopes(v, model, rest)
    b0 = b1 = b2 = 0.0
    for i in range(v.size):
        a0, a1, a2, _, _, _, _, _, _ = read(model, 0, i)
        rho = v[i] - a0 * fit.n - a1 * fit.ty - a2 * fit.tz
        b0 += a0 * rho
        b1 += a1 * rho
        b2 += a2 * rho
    rest.n, rest.ty, rest.tz, rest.left = -b0, -b1, -b2, fit.left - rest.left
    rest.g_n_n, rest.g_n_ty, rest.g_n_tz = fit.g_n_n - rest.g_n_n, fit.g_n_ty - rest.g_n_ty, fit.g_n_tz - rest.g_n_tz
    rest.g_ty_ty, rest.g_ty_tz = fit.g_ty_ty - rest.g_ty_ty, fit.g_ty_tz - rest.g_ty_tz
    rest.g_tz_tz, rest.by_y, rest.by_z = fit.g_tz_tz - rest.g_tz_tz, fit.by_y - rest.by_y, fit.by_z - rest.by_z
    rest.u_y_y, rest.u_y_z, rest.u_z_z = fit.u_y_y - rest.u_y_y, fit.u_y_z - rest.u_y_z, fit.u_z_z - rest.u_z_z
    rest.a_y_n, rest.a_y_ty, rest.a_y_tz = fit.a_y_n - rest.a_y_n, fit.a_y_ty - rest.a_y_ty, fit.a_y_tz - rest.a_y_tz
    rest.a_z_n, rest.a_z_ty, rest.a_z_tz = fit.a_z_n - rest.a_z_n, fit.a_z_ty - rest.a_z_ty, fit.a_z_tz - rest.a_z_tz


@compiled(inline=True)
def _added(s, r, dy, dz, a0, g, n, ty, tz):
    """The sums with one more sensor, that reads r."""
    a1, a2 = dy * g, dz * g
    rho = r - a0 * n - a1 * ty - a2 * tz
    return _Sums(
        s.left + rho * rho, s.n + a0 * rho, s.ty + a1 * rho, s.tz + a2 * rho, s.n_n + a0 * a0, s.n_ty + a0 * a1,
        s.n_tz + a0 * a2, s.ty_ty + a1 * a1, s.ty_tz + a1 * a2, s.tz_tz + a2 * a2,
    )  # fmt: skip


@compiled(borrows=True)
def falls(v, model, mu, box, fit, rest, root, reach, best, lanes):
    """How much lower S is than at the top in fit, `reach` standard deviations round it: into lanes[:8]; and the least.

    rest: as of `beyond_near`, or nothing; root: as of `root_of`; lanes: as of `LANES`. A position higher than that in
    `best` goes there. Outside the box S is taken to fall as at the top.
    """
    sensors, first, table, a, whole = model.sensors, model.first, model.table, model.rows, model.bits
    n, ty, tz = fit.n, fit.ty, fit.tz
    for k in range(EIGHT):
        c, s = reach * ROUND[k, 0], reach * ROUND[k, 1]
        lanes[_TO_Y + k], lanes[_TO_Z + k] = root[0] * c + root[1] * s, root[1] * c + root[2] * s
    dy, dz = eight(lanes, _TO_Y), eight(lanes, _TO_Z)
    ys, zs = dy + fit.y, dz + fit.z
    sums = _Sums(
        rest.u_y_y * dy * dy + 2.0 * rest.u_y_z * dy * dz + rest.u_z_z * dz * dz + rest.left
        - 2.0 * (rest.by_y * dy + rest.by_z * dz),
        rest.n - rest.a_y_n * dy - rest.a_z_n * dz, rest.ty - rest.a_y_ty * dy - rest.a_z_ty * dz,
        rest.tz - rest.a_y_tz * dy - rest.a_z_tz * dz, alike(rest.g_n_n), alike(rest.g_n_ty), alike(rest.g_n_tz),
        alike(rest.g_ty_ty), alike(rest.g_ty_tz), alike(rest.g_tz_tz),
    )  # fmt: skip
    if first[v.size] == 0:  # of a series, the same of all sensors
        f0, f1, f2, f3, h0, h1, h2, h3 = coefficients(table, 0)
        for i in range(v.size):
            dy, dz = sensors[0, i] - ys, sensors[1, i] - zs
            x = 1.0 / (1.0 + (dy * dy + dz * dz) * sensors[2, i])
            size = sensors[3, i] * x * square_root(x)
            a0, g = size * (f0 + x * (f1 + x * (f2 + x * f3))), size * (h0 + x * (h1 + x * (h2 + x * h3)))
            sums = _added(sums, v[i], dy, dz, a0, g, n, ty, tz)
    else:
        for i in range(v.size):
            away, aside = sensors[0, i] - fit.y, sensors[1, i] - fit.z
            a[0, i] = 1.0 + (away * away + aside * aside) * sensors[2, i]
        for i in range(v.size):
            bits = whole[0, i]
            whole[1, i] = first[i] + cell_of(bits, first[v.size])
            middle = (bits & ~REST) | _MIDDLE
            whole[0, i], whole[2, i] = middle, (middle & _DIGITS) | ONE
        for i in range(v.size):
            f0, f1, f2, f3, h0, h1, h2, h3 = coefficients(table, whole[1, i])
            middle, share, scale = a[0, i], CELLS * a[2, i], sensors[3, i]
            cube = share * share * share
            f1, f2, h1, h2 = share * f1, share * share * f2, share * h1, share * share * h2
            f1, f2, f3 = -f1, f1 + f2, -(f1 + 2.0 * f2 + cube * f3)
            h1, h2, h3 = -h1, h1 + h2, -(h1 + 2.0 * h2 + cube * h3)
            dy, dz = sensors[0, i] - ys, sensors[1, i] - zs
            x = middle / (1.0 + (dy * dy + dz * dz) * sensors[2, i]) - 1.0
            a0, g = scale * (f0 + x * (f1 + x * (f2 + x * f3))), scale * (h0 + x * (h1 + x * (h2 + x * h3)))
            sums = _added(sums, v[i], dy, dz, a0, g, n, ty, tz)
    left, b0, b1, b2, g00, g01, g02, g11, g12, g22 = sums
    c00, c01, c02, c11, c12, c22, det = cofactors(g00, g01, g02, g11, g12, g22)
    inverse = 1.0 / det
    m = (c00 * b0 + c01 * b1 + c02 * b2) * inverse
    my = (c01 * b0 + c11 * b1 + c12 * b2) * inverse
    mz = (c02 * b0 + c12 * b1 + c22 * b2) * inverse
    fall = left - (b0 * m + b1 * my + b2 * mz) - fit.left
    sy, sz, most = my + ty, mz + tz, mu * (m + n)
    within = (box[0] <= ys) & (ys <= box[1]) & (box[2] <= zs) & (zs <= box[3])
    free = (det > 1e-13 * g00 * g11 * g22) & (m + n >= 0.0) & (sy * sy + sz * sz <= most * most)
    bound = within & (where(free, nought(m) + 1.0, nought(m)) < 0.5)
    if answers(bound) > 0:
        w0 = b0 + g00 * n + g01 * ty + g02 * tz
        w1 = b1 + g01 * n + g11 * ty + g12 * tz
        w2 = b2 + g02 * n + g12 * ty + g22 * tz
        taken = on_cone((g00, g01, g02, g11, g12, g22), (w0, w1, w2), mu, sy, sz, bound)[3]
        gain = taken - n * (b0 + w0) - ty * (b1 + w1) - tz * (b2 + w2)
        fall = where(free, fall, left - gain - fit.left)
    fall = where(within, fall, reach * reach)
    put(lanes, 0, fall)
    least = reach * reach
    for k in range(EIGHT):
        if fit.explained - lanes[k] > best.explained:
            best.explained, best.y, best.z = (
                fit.explained - lanes[k],
                fit.y + lanes[_TO_Y + k],
                fit.z + lanes[_TO_Z + k],
            )
        least = min(least, lanes[k])
    return least


@compiled(inline=True)
def widest_variance(spread):
    """The largest variance of a direction in (y, z)."""
    yy, yz, zz = spread[_YY], spread[_YZ], spread[_ZZ]
    half = 0.5 * (yy - zz)
    return 0.5 * (yy + zz) + math.sqrt(half * half + yz * yz)


@compiled(inline=True)
def root_of(yy, yz, zz, root):
    """Fill root with 00, 01, 11 of the symmetric root of the covariance of (y, z)."""
    det = math.sqrt(max(yy * zz - yz * yz, 0.0))
    over = 1.0 / math.sqrt(yy + zz + 2.0 * det)
    root[0], root[1], root[2] = (yy + det) * over, yz * over, (zz + det) * over


@compiled(borrows=True)
def drops(w, model, limits, box, fit, root, reach, trial, best, out):
    """How much lower S is round the top in fit, at `reach` standard deviations; into out.

    root: as of `root_of`. A position higher than that in `best` goes there. Outside the box S is taken to fall as at
    the top.
    """
    for k in range(out.size):
        c, s = reach * ROUND[k, 0], reach * ROUND[k, 1]
        at = Point(fit.y + root[0] * c + root[1] * s, fit.z + root[1] * c + root[2] * s)
        out[k] = reach * reach
        if box[0] <= at.y <= box[1] and box[2] <= at.z <= box[3]:
            project(w, model, limits, at, trial)
            out[k] = fit.explained - trial.explained
            if trial.explained > best.explained:
                best.explained, best.y, best.z = trial.explained, at.y, at.z


@compiled(borrows=True)
def look_round(w, near_w, near, search, room, fit, spread):
    """How S falls round the top: 0 about as a parabola, 1 less so, 2 so little that there is no one answer.

    `room.more` is what the variance of (y, z) gains: the second moment of exp(S / 2) about the top, whose width is
    looked at in eight directions. -1: S is larger a few deviations off; room.trials[1] says where. near_w, near: the
    readings and the model of the sensors that count.
    """
    model, settings, lanes, ratio, more = search.model, search.settings, room.lanes, room.ratio, room.more
    limits, box, root, fall = settings.limits, settings.box, room.root, lanes[:EIGHT]
    trial, best, rest = room.trials[0], room.trials[1], room.trials[2]
    root_of(spread[_YY], spread[_YZ], spread[_ZZ], root)
    more[0] = more[1] = more[2] = 0.0
    base, shape, widest = fit.explained, 0, 0.0
    close = 0.0
    if model.terms.shape[0] == 0:
        close = 10.0 * _CLOSE * settings.broad / math.sqrt(widest_variance(spread))
    v, its = (near_w, near) if fit.inside > 0.0 else (w, model)
    if close >= _NEAR and v.size < w.size:
        rest = room.trials[3]
        beyond_near(v, its, limits, fit, rest)
    best.explained = base + _HIGHER
    for far in range(2):
        reach = _FAR if far else _NEAR
        if reach <= close:
            least = falls(v, its, limits.friction, box, fit, rest, root, reach, best, lanes)
            if v.size < w.size and _ODD * least < reach * reach:  # then all sensors are asked
                v, its, rest = w, model, room.trials[2]
                best.explained = base + _HIGHER
                falls(v, its, limits.friction, box, fit, rest, root, reach, best, lanes)
        else:
            drops(w, model, limits, box, fit, root, reach, trial, best, fall)
        if best.explained > base + _HIGHER:
            return -1
        for k in range(ratio.size):
            wide = min(max(reach * reach / max(fall[k], 1e-9), 0.1), 9.0)
            ratio[k] = max(ratio[k], wide) if far else wide
            widest = max(widest, ratio[k])
            if far and fall[k] < _LEVEL:
                shape = 2
        if widest < _ODD:
            break
        shape = max(shape, 1)
    m00 = m01 = m11 = weight = 0.0
    for k in range(ratio.size):
        square, x, y = ratio[k] * ratio[k], ROUND[k, 0], ROUND[k, 1]
        weight += square
        m00 += 2.0 * square * ratio[k] * x * x
        m01 += 2.0 * square * ratio[k] * x * y
        m11 += 2.0 * square * ratio[k] * y * y
    m00, m01, m11 = m00 / weight - 1.0, m01 / weight, m11 / weight - 1.0
    # the root times this, times the root
    y0, y1 = root[0] * m00 + root[1] * m01, root[0] * m01 + root[1] * m11
    z0, z1 = root[1] * m00 + root[2] * m01, root[1] * m01 + root[2] * m11
    more[0], more[1], more[2] = y0 * root[0] + y1 * root[1], y0 * root[1] + y1 * root[2], z0 * root[1] + z1 * root[2]
    return shape
