"""Compiled: the evidence of one kind of round contact, in frames whose contact was found by another.

From the position found a climb within the kind's widths, then Gauss and Legendre's rule over the width about its top:
at each width forces and position are fitted anew, and integrated over by Laplace's method.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..area.round_contact import FIT, RoundAt, climb, in_room, information, keep
from ..varpro import Ending, Limits

_FINE = 0.003
"""What the last step of a climb may gain."""
_DEEP = 24.0
"""Fall of S at which the integral over the width ends."""
_LOG_2PI = math.log(2 * math.pi)


@compiled(borrows=True)
def log_integral(fit, yy, yz, zz, mu):
    """Log of the integral of exp(S / 2) over position and forces at one width; forces alike on a logarithmic scale.

    yy, yz, zz: the information of the position.
    """
    det = yy * zz - yz * yz
    force2 = fit.n * fit.n + fit.ty * fit.ty + fit.tz * fit.tz
    free = 5.0
    if mu == 0.0:
        det, force2, free = det * fit.g_n_n, force2 ** (1.0 / 3.0), 3.0
    else:
        det *= (
            fit.g_n_n * (fit.g_ty_ty * fit.g_tz_tz - fit.g_ty_tz * fit.g_ty_tz)
            - fit.g_n_ty * (fit.g_n_ty * fit.g_tz_tz - fit.g_ty_tz * fit.g_n_tz)
            + fit.g_n_tz * (fit.g_n_ty * fit.g_ty_tz - fit.g_ty_ty * fit.g_n_tz)
        )
    if not (det > 0.0 and force2 > 0.0):
        return -math.inf
    return 0.5 * (fit.explained + free * _LOG_2PI - math.log(det) - 3.0 * math.log(force2))


@compiled(frames="frames")
def weigh_kind(frames, found, model, mu, box, ratio, nodes, weights, out):
    """Fill out: log of the evidence but for chi-square at no load, chi-square, y, z, N, Ty, Tz, half width, then NaN.

    frames (f, n), in units of noise; found (f, 3): y, z, half width of a contact near by, NaN where there is none;
    model: as of `round_contact`, without its scratch; box: ends of y, z and q; ratio: of the kind's half width to
    that one, where their readings are most alike; nodes, weights: Gauss and Legendre's on (0, 1).
    """
    model, limits, fine = in_room(model), Limits(mu, 0.0, math.inf), Ending(_FINE, 0.0, 0.0, -math.inf)
    fits, only = np.empty(3, FIT), np.empty(6)
    best, fit, trial = fits[0], fits[1], fits[2]
    low, high = box[4], box[5]
    for f in range(frames.shape[0]):
        w, row = frames[f], out[f]
        for k in range(row.size):
            row[k] = math.nan
        row[0] = -math.inf
        y, z, a = found[f, 0], found[f, 1], found[f, 2]
        if not math.isfinite(y):
            continue
        best.explained = -1.0
        for start in range(3 if high > low else 1):
            q = (ratio * a) ** 2 if start == 0 else low if start == 1 else high
            climb(w, model, limits, box, RoundAt(y, z, q), fine, fit, trial)
            if fit.explained > best.explained:
                keep(fit, best)
        q, told = best.q, information(best)
        for k in range(4):
            only[k] = box[k]
        total, largest = 0.0, -math.inf
        if not high > low:
            largest, total = log_integral(best, told.y_y, told.y_z, told.z_z, mu), 1.0
        else:
            minor = told.y_y * told.z_z - told.y_z * told.y_z
            first, second = told.z_z * told.y_q - told.y_z * told.z_q, told.y_y * told.z_q - told.y_z * told.y_q
            alone = max(told.q_q - (told.y_q * first + told.z_q * second) / minor, 1e-300)
            for side in range(2):
                end = high if side else low
                pull = abs(best.by_q) if end != q else 0.0
                reach = (math.sqrt(pull * pull + _DEEP * alone) - pull) / alone
                to = min(q + reach, end) if side else max(q - reach, end)
                begin, stop = math.sqrt(q), math.sqrt(to)
                if begin == stop:
                    continue
                at_y, at_z = best.y, best.z
                for k in range(nodes.size):
                    here = begin + (stop - begin) * nodes[k]
                    only[4] = only[5] = here * here
                    climb(w, model, limits, only, RoundAt(at_y, at_z, here * here), fine, fit, trial)
                    told = information(fit)
                    share = weights[k] * abs(stop - begin) / (math.sqrt(high) - math.sqrt(low))
                    part = log_integral(fit, told.y_y, told.y_z, told.z_z, mu)
                    at_y, at_z = fit.y, fit.z
                    if part > largest:
                        total = total * math.exp(largest - part) if total > 0.0 else 0.0
                        largest = part
                    if part > -math.inf:
                        total += share * math.exp(part - largest)
        row[0] = largest + math.log(total) if total > 0.0 else -math.inf
        row[1], row[2], row[3], row[7] = best.left, best.y, best.z, math.sqrt(q)
        row[4], row[5], row[6] = best.n, best.ty, best.tz
