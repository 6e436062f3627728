"""Compiled: how far S falls round its top, at eight positions at once.

Near the top a sensor's functions of the distance are cubics in 1 / v (`field.py`), about the middle of the cell in
which v lies at the top: where readings fall off with a power of the distance, as they do, these hold far beyond the
cell; a series that holds at all distances is asked itself. Sums run over what the best load leaves of the readings, so
that no digits are lost.
"""

from __future__ import annotations

import numpy as np

from ..._compiled import compiled
from ..._lanes import EIGHT, alike, answers, eight, nought, put, where
from ..._lanes import root as square_root
from ..cone import cofactors, on_cone
from .point import CELLS, ONE, REST, Point, cell_of, coefficients, project, read, slopes

LANES = 48
"""Numbers of scratch: how far S falls, and the moves in y and in z, of eight positions; then the sums of
`beyond_near`."""
_OTHERS = 24
_TURNS = 2 * np.pi * np.arange(EIGHT) / EIGHT
ROUND = np.stack([np.cos(_TURNS), np.sin(_TURNS)], axis=-1)
_MIDDLE, _DIGITS = np.int64(1 << 45), np.int64((1 << 52) - 1)


@compiled(borrows=True)
def beyond_near(v, model, limits, fit, trial, lanes):
    """What sensors that are not in v add to the sums at the top, where nothing binds the forces, into lanes[24:45].

    These are chi-square left, A^T rho (3), A^T A (6), U^T rho (2), U^T U (3), A^T U (6); rho is what the load leaves.
    """
    project(v, model, limits, Point(fit.y, fit.z), trial)
    trial.n, trial.ty, trial.tz = fit.n, fit.ty, fit.tz
    slopes(v, model, trial)
    b0 = b1 = b2 = 0.0
    for i in range(v.size):
        a0, a1, a2, _, _, _, _, _, _ = read(model, i)
        rho = v[i] - a0 * fit.n - a1 * fit.ty - a2 * fit.tz
        b0 += a0 * rho
        b1 += a1 * rho
        b2 += a2 * rho
    o = lanes[_OTHERS:]
    o[0], o[1], o[2], o[3] = fit.left - trial.left, -b0, -b1, -b2
    o[4], o[5], o[6] = fit.g_n_n - trial.g_n_n, fit.g_n_ty - trial.g_n_ty, fit.g_n_tz - trial.g_n_tz
    o[7], o[8], o[9] = fit.g_ty_ty - trial.g_ty_ty, fit.g_ty_tz - trial.g_ty_tz, fit.g_tz_tz - trial.g_tz_tz
    o[10], o[11] = fit.by_y - trial.by_y, fit.by_z - trial.by_z
    o[12], o[13], o[14] = fit.u_y_y - trial.u_y_y, fit.u_y_z - trial.u_y_z, fit.u_z_z - trial.u_z_z
    o[15], o[16], o[17] = fit.a_y_n - trial.a_y_n, fit.a_y_ty - trial.a_y_ty, fit.a_y_tz - trial.a_y_tz
    o[18], o[19], o[20] = fit.a_z_n - trial.a_z_n, fit.a_z_ty - trial.a_z_ty, fit.a_z_tz - trial.a_z_tz


@compiled(inline=True)
def _added(r, dy, dz, a0, g, n, ty, tz, left, b0, b1, b2, g00, g01, g02, g11, g12, g22):
    """The sums of chi-square left, A^T rho and A^T A with one more sensor, that reads r."""
    a1, a2 = dy * g, dz * g
    rho = r - a0 * n - a1 * ty - a2 * tz
    return (
        left + rho * rho, b0 + a0 * rho, b1 + a1 * rho, b2 + a2 * rho,
        g00 + a0 * a0, g01 + a0 * a1, g02 + a0 * a2, g11 + a1 * a1, g12 + a1 * a2, g22 + a2 * a2,
    )  # fmt: skip


@compiled(borrows=True)
def falls(v, model, mu, box, fit, root, reach, best, lanes):
    """How much lower S is than at the top in fit, `reach` standard deviations round it: into lanes[:8]; and the least.

    root: as of `judge.root_of`; lanes: as of `LANES`. A position higher than that in `best` goes there. Outside the box
    S is taken to fall as at the top.
    """
    sensors, first, table, a, whole = model.sensors, model.first, model.table, model.rows, model.bits
    n, ty, tz = fit.n, fit.ty, fit.tz
    for k in range(EIGHT):
        c, s = reach * ROUND[k, 0], reach * ROUND[k, 1]
        lanes[8 + k], lanes[16 + k] = root[0] * c + root[1] * s, root[1] * c + root[2] * s
    dy, dz = eight(lanes, 8), eight(lanes, 16)
    ys, zs = dy + fit.y, dz + fit.z
    o = lanes[_OTHERS:]
    left = o[12] * dy * dy + 2.0 * o[13] * dy * dz + o[14] * dz * dz + o[0] - 2.0 * (o[10] * dy + o[11] * dz)
    b0, b1, b2 = o[1] - o[15] * dy - o[18] * dz, o[2] - o[16] * dy - o[19] * dz, o[3] - o[17] * dy - o[20] * dz
    g00, g01, g02, g11, g12, g22 = alike(o[4]), alike(o[5]), alike(o[6]), alike(o[7]), alike(o[8]), alike(o[9])
    if first[v.size] == 0:  # of a series, the same of all sensors
        f0, f1, f2, f3, h0, h1, h2, h3 = coefficients(table, 0)
        for i in range(v.size):
            dy, dz = sensors[0, i] - ys, sensors[1, i] - zs
            x = 1.0 / (1.0 + (dy * dy + dz * dz) * sensors[2, i])
            size = sensors[3, i] * x * square_root(x)
            a0, g = size * (f0 + x * (f1 + x * (f2 + x * f3))), size * (h0 + x * (h1 + x * (h2 + x * h3)))
            left, b0, b1, b2, g00, g01, g02, g11, g12, g22 = _added(
                v[i], dy, dz, a0, g, n, ty, tz, left, b0, b1, b2, g00, g01, g02, g11, g12, g22
            )
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
            left, b0, b1, b2, g00, g01, g02, g11, g12, g22 = _added(
                v[i], dy, dz, a0, g, n, ty, tz, left, b0, b1, b2, g00, g01, g02, g11, g12, g22
            )
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
            best.explained, best.y, best.z = fit.explained - lanes[k], fit.y + lanes[8 + k], fit.z + lanes[16 + k]
        least = min(least, lanes[k])
    return least
