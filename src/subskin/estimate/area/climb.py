"""Compiled: from a node of the scan to the top of S in (y, z), the forces eliminated exactly at each trial.

Gauss-Newton steps on the projected residual (Golub and Pereyra 1973; Kaufman 1975), damped after Levenberg and
Marquardt, within a box.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from .cone import eliminate, sums_of
from .field import field_at

FIT = 32
"""Numbers of a fit: 0-10 as of `cone.eliminate`; 11-16 A^T A; 17 chi-square left; 18, 19 gradient of S/2 in y, z;
20-22 U^T U, U the readings' slopes; 23-28 A^T U, of y then of z; 29, 30 the position."""
_STEPS = 40
_ROUGH = 1.0
"""Gain below which a rough climb does not end: where one of its steps fails, the next is half as long at once."""
_TURNS = 2 * np.pi * np.arange(8) / 8
ROUND = np.stack([np.cos(_TURNS), np.sin(_TURNS)], axis=-1)


@compiled(inline=True)
def project(w, sensors, first, table, terms, mu, y, z, a, whole, fit):
    """The best admissible forces at (y, z)."""
    field_at(sensors, first, table, terms, y, z, a, whole)
    g00 = g01 = g02 = g11 = g12 = g22 = b0 = b1 = b2 = 0.0
    if terms.shape[0] == 0:
        for i in range(w.size):
            a0, g, r = a[5, i], a[7, i], w[i]
            a1, a2 = a[0, i] * g, a[1, i] * g
            g00 += a0 * a0
            g01 += a0 * a1
            g02 += a0 * a2
            g11 += a1 * a1
            g12 += a1 * a2
            g22 += a2 * a2
            b0 += a0 * r
            b1 += a1 * r
            b2 += a2 * r
    else:
        g00, g01, g02, g11, g12, g22, b0, b1, b2 = sums_of(a, w, 5)
    eliminate(g00, g01, g02, g11, g12, g22, b0, b1, b2, mu, fit)
    fit[11], fit[12], fit[13], fit[14], fit[15], fit[16] = g00, g01, g02, g11, g12, g22
    fit[29], fit[30] = y, z


@compiled(inline=True)
def slopes(w, terms, a, fit):
    """Chi-square left, the gradient of S/2, and the sums for its curvature and for the covariance."""
    n, ty, tz = fit[0], fit[1], fit[2]
    left = gy = gz = uyy = uyz = uzz = p0 = p1 = p2 = r0 = r1 = r2 = 0.0
    if terms.shape[0] == 0:
        for i in range(w.size):
            dy, dz, a0, g = a[0, i], a[1, i], a[5, i], a[7, i]
            turned = dy * ty + dz * tz
            rho = w[i] - a0 * n - g * turned
            along = a[6, i] * n + a[8, i] * turned
            uy, uz = dy * along - g * ty, dz * along - g * tz
            a1, a2 = dy * g, dz * g
            left += rho * rho
            gy += rho * uy
            gz += rho * uz
            uyy += uy * uy
            uyz += uy * uz
            uzz += uz * uz
            p0 += a0 * uy
            p1 += a1 * uy
            p2 += a2 * uy
            r0 += a0 * uz
            r1 += a1 * uz
            r2 += a2 * uz
    else:
        for i in range(w.size):
            a0, a1, a2 = a[5, i], a[6, i], a[7, i]
            rho = w[i] - a0 * n - a1 * ty - a2 * tz
            uy = a[8, i] * n + a[9, i] * ty + a[10, i] * tz
            uz = a[11, i] * n + a[12, i] * ty + a[13, i] * tz
            left += rho * rho
            gy += rho * uy
            gz += rho * uz
            uyy += uy * uy
            uyz += uy * uz
            uzz += uz * uz
            p0 += a0 * uy
            p1 += a1 * uy
            p2 += a2 * uy
            r0 += a0 * uz
            r1 += a1 * uz
            r2 += a2 * uz
    fit[17], fit[18], fit[19], fit[20], fit[21], fit[22] = left, gy, gz, uyy, uyz, uzz
    fit[23], fit[24], fit[25], fit[26], fit[27], fit[28] = p0, p1, p2, r0, r1, r2


@compiled(inline=True)
def _free(fit, k):
    """I x, x the three numbers of A^T U from k on, I the inverse of what is left free of A^T A."""
    x0, x1, x2 = fit[k], fit[k + 1], fit[k + 2]
    return (
        fit[4] * x0 + fit[5] * x1 + fit[6] * x2,
        fit[5] * x0 + fit[7] * x1 + fit[8] * x2,
        fit[6] * x0 + fit[8] * x1 + fit[9] * x2,
    )


@compiled(inline=True)
def _curvature(fit):
    """The projected information (yy, yz, zz), and how N, Ty, Tz fall with y and with z."""
    i0, i1, i2 = _free(fit, 23)
    j0, j1, j2 = _free(fit, 26)
    yy = fit[20] - (fit[23] * i0 + fit[24] * i1 + fit[25] * i2)
    yz = fit[21] - (fit[26] * i0 + fit[27] * i1 + fit[28] * i2)
    zz = fit[22] - (fit[26] * j0 + fit[27] * j1 + fit[28] * j2)
    return yy, yz, zz, i0, i1, i2, j0, j1, j2


@compiled(inline=True)
def _step(y, z, gy, gz, yy, yz, zz, box):
    """Where a step ends within the box: what stands at a side and would go on beyond stays."""
    fixed_y = (y <= box[0] and gy <= 0.0) or (y >= box[1] and gy >= 0.0)
    fixed_z = (z <= box[2] and gz <= 0.0) or (z >= box[3] and gz >= 0.0)
    det = yy * zz - yz * yz
    det = det if det > 1e-12 * yy * zz else yy * zz
    my = 0.0 if fixed_y else gy / yy if fixed_z else (zz * gy - yz * gz) / det
    mz = 0.0 if fixed_z else gz / zz if fixed_y else (yy * gz - yz * gy) / det
    to_y, to_z = min(max(y + my, box[0]), box[1]), min(max(z + mz, box[2]), box[3])
    if to_y != y + my and not fixed_z:  # cut short: the best z for what is left of it
        to_z = min(max(z + (gz - yz * (to_y - y)) / zz, box[2]), box[3])
    elif to_z != z + mz and not fixed_y:
        to_y = min(max(y + (gy - yz * (to_z - z)) / yy, box[0]), box[1])
    return to_y, to_z


@compiled(borrows=True)
def climb(w, sensors, first, table, terms, mu, box, y, z, tolerance, smallest, straight, needed, a, whole, fit, trial):
    """Climb from (y, z) within box = (y low, y high, z low, z high); the top is in fit.

    Ends with a step that raises S by less than `tolerance`, or is shorter than `smallest`, or so short beside a
    hundredfold of `straight`, over which readings bend, that it leaves a hundredth of a standard deviation; it is still
    made, and the forces carried along, where nothing binds them. It also ends where not even four times what the next
    step gains leads to S = `needed`.
    """
    to_y, to_z = min(max(y, box[0]), box[1]), min(max(z, box[2]), box[3])
    damping, fit[3] = 1e-5, -1.0
    again = 1.0 if tolerance > _ROUGH else 1e-3
    yy = yz = zz = i0 = i1 = i2 = j0 = j1 = j2 = 0.0
    for _ in range(_STEPS):
        project(w, sensors, first, table, terms, mu, to_y, to_z, a, whole, trial)
        if trial[3] > fit[3]:
            slopes(w, terms, a, trial)
            for k in range(FIT):
                fit[k] = trial[k]
            yy, yz, zz, i0, i1, i2, j0, j1, j2 = _curvature(fit)
            damping = 0.1 * damping
        else:
            damping = max(10.0 * damping, again)
        floor = 1e-12 * (fit[20] + fit[22]) + 1e-300
        more = 1.0 + damping
        y, z, gy, gz = fit[29], fit[30], fit[18], fit[19]
        to_y, to_z = _step(y, z, gy, gz, yy * more + floor, yz, zz * more + floor, box)
        my, mz = to_y - y, to_z - z
        gain = gy * my + gz * mz
        if not gain >= max(tolerance, straight * math.sqrt(yy + zz)) or abs(my) + abs(mz) < smallest:
            n, ty, tz = fit[0] - i0 * my - j0 * mz, fit[1] - i1 * my - j1 * mz, fit[2] - i2 * my - j2 * mz
            if gain > 0.0 and fit[10] > 0.0 and n >= 0.0 and ty * ty + tz * tz <= mu * mu * n * n:
                fit[0], fit[1], fit[2], fit[29], fit[30] = n, ty, tz, to_y, to_z
                fit[18], fit[19] = gy - yy * my - yz * mz, gz - yz * my - zz * mz
                fit[3] += gain
                fit[17] -= gain
            return
        if fit[3] + 4.0 * gain < needed:
            return


@compiled(inline=True)
def root_of(yy, yz, zz, root):
    """Fill root with 00, 01, 11 of the symmetric root of the covariance of (y, z)."""
    det = math.sqrt(max(yy * zz - yz * yz, 0.0))
    over = 1.0 / math.sqrt(yy + zz + 2.0 * det)
    root[0], root[1], root[2] = (yy + det) * over, yz * over, (zz + det) * over


@compiled(borrows=True)
def drops(w, sensors, first, table, terms, mu, box, fit, base, root, reach, a, whole, trial, best, out):
    """How much lower S is than `base` round the top in fit, at `reach` standard deviations; into out.

    root: as of `root_of`. A position higher than that in `best` goes there.
    Outside the box S is taken to fall as at the top.
    """
    for k in range(out.size):
        c, s = reach * ROUND[k, 0], reach * ROUND[k, 1]
        y, z = fit[29] + root[0] * c + root[1] * s, fit[30] + root[1] * c + root[2] * s
        out[k] = reach * reach
        if box[0] <= y <= box[1] and box[2] <= z <= box[3]:
            project(w, sensors, first, table, terms, mu, y, z, a, whole, trial)
            out[k] = base - trial[3]
            if trial[3] > best[3]:
                best[3], best[29], best[30] = trial[3], y, z
