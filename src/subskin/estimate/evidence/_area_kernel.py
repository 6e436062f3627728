"""Compiled: the evidence of one kind of round contact, in frames whose contact was found by another.

From the position found a climb within the kind's widths, then Gauss and Legendre's rule over the width about its top:
at each width forces and position are fitted anew, and integrated over by Laplace's method.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..area.round_climb import COLUMNS, SIZE, round_climb, round_curvature

_FINE = 0.003
"""What the last step of a climb may gain."""
_DEEP = 24.0
"""Fall of S at which the integral over the width ends."""
_LOG_2PI = math.log(2 * math.pi)


@compiled(borrows=True)
def log_integral(fit, h, mu):
    """Log of the integral of exp(S / 2) over position and forces at one width; forces alike on a logarithmic scale."""
    yy, yz, zz = h[0, 0], h[0, 1], h[1, 1]
    det = yy * zz - yz * yz
    g00, g01, g02, g11, g12, g22 = fit[11], fit[12], fit[13], fit[14], fit[15], fit[16]
    force2 = fit[0] * fit[0] + fit[1] * fit[1] + fit[2] * fit[2]
    free = 5.0
    if mu == 0.0:
        det, force2, free = det * g00, force2 ** (1.0 / 3.0), 3.0
    else:
        det *= g00 * (g11 * g22 - g12 * g12) - g01 * (g01 * g22 - g12 * g02) + g02 * (g01 * g12 - g11 * g02)
    if not (det > 0.0 and force2 > 0.0):
        return -math.inf
    return 0.5 * (fit[3] + free * _LOG_2PI - math.log(det) - 3.0 * math.log(force2))


@compiled()
def weigh_kind(frames, found, model, mu, box, ratio, nodes, weights, out):
    """Fill out: log of the evidence but for chi-square at no load, chi-square, y, z, N, Ty, Tz, half width, then NaN.

    frames (f, n), in units of noise; found (f, 3): y, z, half width of a contact near by, NaN where there is none;
    model, box: as of `round_climb`; ratio: of the kind's half width to that one, where their readings are most alike;
    nodes, weights: Gauss and Legendre's on (0, 1).
    """
    n, sums = frames.shape[1], model[2]
    room = (
        np.empty((3, 3)), np.empty((8, 4)), np.empty((2, sums.shape[2])), np.empty((sums.shape[1] // 4, 3)),
        np.empty((0, 3)), np.empty((COLUMNS, n)),
    )  # fmt: skip
    fits, only = np.empty((3, SIZE)), np.empty(6)
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
        best[3] = -1.0
        for start in range(3 if high > low else 1):
            q = (ratio * a) ** 2 if start == 0 else low if start == 1 else high
            round_climb(w, model, mu, box, y, z, q, _FINE, room, fit, trial)
            if fit[3] > best[3]:
                for k in range(SIZE):
                    best[k] = fit[k]
        q = best[38]
        for k in range(4):
            only[k] = box[k]
        total, largest = 0.0, -math.inf
        round_curvature(best, room[0])
        if not high > low:
            largest, total = log_integral(best, room[0], mu), 1.0
        else:
            h = room[0]
            minor = h[0, 0] * h[1, 1] - h[0, 1] * h[0, 1]
            first, second = h[1, 1] * h[0, 2] - h[0, 1] * h[1, 2], h[0, 0] * h[1, 2] - h[0, 1] * h[0, 2]
            told = max(h[2, 2] - (h[0, 2] * first + h[1, 2] * second) / minor, 1e-300)
            for side in range(2):
                end = high if side else low
                pull = abs(best[20]) if end != q else 0.0
                reach = (math.sqrt(pull * pull + _DEEP * told) - pull) / told
                to = min(q + reach, end) if side else max(q - reach, end)
                begin, stop = math.sqrt(q), math.sqrt(to)
                if begin == stop:
                    continue
                at_y, at_z = best[36], best[37]
                for k in range(nodes.size):
                    here = begin + (stop - begin) * nodes[k]
                    only[4] = only[5] = here * here
                    round_climb(w, model, mu, only, at_y, at_z, here * here, _FINE, room, fit, trial)
                    round_curvature(fit, room[0])
                    share = weights[k] * abs(stop - begin) / (math.sqrt(high) - math.sqrt(low))
                    part = log_integral(fit, room[0], mu)
                    at_y, at_z = fit[36], fit[37]
                    if part > largest:
                        total = total * math.exp(largest - part) if total > 0.0 else 0.0
                        largest = part
                    if part > -math.inf:
                        total += share * math.exp(part - largest)
        row[0] = largest + math.log(total) if total > 0.0 else -math.inf
        row[1], row[2], row[3], row[7] = best[17], best[36], best[37], math.sqrt(q)
        row[4], row[5], row[6] = best[0], best[1], best[2]
