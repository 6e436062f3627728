"""The compiled heart of `locate` on an area: variable projection, one frame at a time.

Scan S over the tile of the strongest sensor (`scan.py`), climb from its highest nodes (`climb.py`); where what is left
is more than noise, over the whole grid, then over a finer one. Judge, look at the sides of the search and beyond, and
write a row. Only arrays and numbers go in and out: `locator.py` prepares them, `estimate/layout.py` names the columns.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..layout import AREA
from . import climb as _climb
from . import cone as _cone
from . import scan as _scan
from .climb import FIT, climb
from .cone import eliminate
from .scan import peaks, scan

_MOST, _FEW = 12, 4
_MOST_CHI2 = 1e30
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_FORCES, _COVARIANCE, _RESIDUAL = AREA.components, AREA.covariance, AREA.residual
_RIVAL, _RIVAL_CHI2, _STATUS = AREA.rival, AREA.rival_chi2, AREA.status


@compiled(built_on=(_climb, _scan))
def _search(
    w, single, sensors, first, flat, terms, tiles, t, most, share, options, scratch, whole, c, s, score, at, fits
):
    """Best and second-best top of S from the highest nodes of tile t, as rows of `fits`; -1 where there is none."""
    index, origin, near, basis, shapes = tiles
    mu, apart, smallest, box = options[0], options[4], options[8], options[9:13]
    k, nodes, rows, columns = index[t, 1], index[t, 3], index[t, 5], index[t, 6]
    scan(
        single,
        near[index[t, 0] : index[t, 0] + k],
        basis[index[t, 2] : index[t, 2] + 3 * k * nodes].reshape((k, 3, nodes)),
        shapes[index[t, 4] : index[t, 4] + 9 * nodes].reshape((9, nodes)),
        mu,
        c,
        s,
    )
    near_w, near_sensors, near_first = np.empty(k), np.empty((4, k)), np.empty(k + 2, dtype=np.int64)
    near_first[k], near_first[k + 1] = first[w.size], first[w.size + 1]
    for i in range(k):
        e = near[index[t, 0] + i]
        near_w[i], near_first[i] = w[e], first[e]
        for j in range(4):
            near_sensors[j, i] = sensors[j, e]
    best = second = -1
    spare = fits.shape[0] - 1
    count = peaks(s, rows, columns, share, score[:most], at)
    for q in range(count + 1):
        # a maximum clearly lower than both already found cannot become the best or the rival
        last = q == count or (second >= 0 and score[q] < 0.8 * fits[second, 3])
        if last and best <= 0:
            break
        p = best if last else q  # at last the best, if it was climbed roughly
        tolerance = 1e-2 if last or q == 0 else 1e-2 * max(fits[best, 3] - score[p], 0.1)
        y, z = origin[t, 0] + at[p, 0] * origin[t, 2], origin[t, 1] + at[p, 1] * origin[t, 3]
        for every in range(0 if 4 * k < 3 * w.size else 1, 2):  # of many sensors first those that count, then all
            v, layout, kinds = (w, sensors, first) if every else (near_w, near_sensors, near_first)
            climb(
                v, layout, kinds, flat, terms, mu, box, y, z, tolerance, smallest, scratch, whole, fits[p], fits[spare]
            )
            y, z = fits[p, 29], fits[p, 30]
        if last:
            break
        if best < 0:
            best = p
        elif abs(fits[p, 29] - fits[best, 29]) + abs(fits[p, 30] - fits[best, 30]) < apart:
            if fits[p, 3] > fits[best, 3]:
                best = p
        elif fits[p, 3] > fits[best, 3]:
            best, second = p, best
        elif second < 0 or fits[p, 3] > fits[second, 3]:
            second = p
    return best, second


@compiled(inline=True)
def covariance(fit, mu, row):
    """Inverse Fisher information of (y, z, N, Ty, Tz): 15 entries; and the largest variance of a direction in (y, z).

    Infinite, or NaN, where the readings do not say.
    """
    g00, g01, g02, g11, g12, g22 = fit[11], fit[12], fit[13], fit[14], fit[15], fit[16]
    if mu == 0.0:  # there is no drag, and that is known
        i00, i01, i02, i11, i12, i22 = 1.0 / g00, 0.0, 0.0, 0.0, 0.0, 0.0
    else:
        i00, i01, i02 = g11 * g22 - g12 * g12, g02 * g12 - g01 * g22, g01 * g12 - g02 * g11
        i11, i12, i22 = g00 * g22 - g02 * g02, g01 * g02 - g00 * g12, g00 * g11 - g01 * g01
        det = max(g00 * i00 + g01 * i01 + g02 * i02, 0.0)
        i00, i01, i02, i11, i12, i22 = i00 / det, i01 / det, i02 / det, i11 / det, i12 / det, i22 / det
    p0, p1, p2, r0, r1, r2 = fit[23], fit[24], fit[25], fit[26], fit[27], fit[28]
    k0, k1, k2 = i00 * p0 + i01 * p1 + i02 * p2, i01 * p0 + i11 * p1 + i12 * p2, i02 * p0 + i12 * p1 + i22 * p2
    l0, l1, l2 = i00 * r0 + i01 * r1 + i02 * r2, i01 * r0 + i11 * r1 + i12 * r2, i02 * r0 + i12 * r1 + i22 * r2
    hyy = fit[20] - (p0 * k0 + p1 * k1 + p2 * k2)
    hyz = fit[21] - (p0 * l0 + p1 * l1 + p2 * l2)
    hzz = fit[22] - (r0 * l0 + r1 * l1 + r2 * l2)
    det = max(hyy * hzz - hyz * hyz, 0.0)
    yy, yz, zz = hzz / det, -hyz / det, hyy / det
    c = _COVARIANCE
    row[c], row[c + 1], row[c + 5] = yy, yz, zz
    my0, my1, my2 = yy * k0 + yz * l0, yy * k1 + yz * l1, yy * k2 + yz * l2
    mz0, mz1, mz2 = yz * k0 + zz * l0, yz * k1 + zz * l1, yz * k2 + zz * l2
    row[c + 2], row[c + 3], row[c + 4] = -my0, -my1, -my2
    row[c + 6], row[c + 7], row[c + 8] = -mz0, -mz1, -mz2
    row[c + 9] = i00 + k0 * my0 + l0 * mz0
    row[c + 10] = i01 + k0 * my1 + l0 * mz1
    row[c + 11] = i02 + k0 * my2 + l0 * mz2
    row[c + 12] = i11 + k1 * my1 + l1 * mz1
    row[c + 13] = i12 + k1 * my2 + l1 * mz2
    row[c + 14] = i22 + k2 * my2 + l2 * mz2
    half = 0.5 * (yy - zz)
    return 0.5 * (yy + zz) + math.sqrt(half * half + yz * yz)


@compiled(inline=True)
def _unsure(fit, row, largest, options):
    """Whether the readings leave open the position, or the direction of the force by a radian."""
    if not largest < (options[10] - options[9]) ** 2 + (options[12] - options[11]) ** 2:
        return True
    n, ty, tz, c = fit[0], fit[1], fit[2], _COVARIANCE
    c00, c01, c02, c11, c12, c22 = row[c + 9], row[c + 10], row[c + 11], row[c + 12], row[c + 13], row[c + 14]
    force2 = n * n + ty * ty + tz * tz
    along = n * (n * c00 + 2 * (ty * c01 + tz * c02)) + ty * (ty * c11 + 2 * tz * c12) + tz * tz * c22
    return not (c00 + c11 + c22) * force2 - along < force2 * force2


@compiled(built_on=(_cone,))
def _broad(w, tiles, fit, largest, options, trial):
    """Whether a load near the best, but further than six standard deviations, explains a frame about as well.

    At the nodes of the finest grid S is exact, the cone included: there A^T A and A^T w follow from the basis.
    """
    index, origin, near, basis, shapes = tiles
    t = index.shape[0] - 1
    k, nodes, rows, columns = index[t, 1], index[t, 3], index[t, 5], index[t, 6]
    y, z, hy, hz = fit[29], fit[30], origin[t, 2], origin[t, 3]
    reach = max(6.0 * math.sqrt(largest), options[5])
    wide = max(1.8 * reach, reach + 1.5 * max(hy, hz))
    j0, j1 = max(int((y - wide - origin[t, 0]) / hy), 0), min(int((y + wide - origin[t, 0]) / hy) + 2, rows)
    k0, k1 = max(int((z - wide - origin[t, 1]) / hz), 0), min(int((z + wide - origin[t, 1]) / hz) + 2, columns)
    for j in range(j0, j1):
        for e in range(k0, k1):
            dy, dz = origin[t, 0] + j * hy - y, origin[t, 1] + e * hz - z
            if not reach * reach < dy * dy + dz * dz < wide * wide:
                continue
            p = j * columns + e
            c0 = c1 = c2 = 0.0
            for i in range(k):
                at = index[t, 2] + 3 * i * nodes + p
                r = w[near[index[t, 0] + i]]
                c0 += r * basis[at]
                c1 += r * basis[at + nodes]
                c2 += r * basis[at + 2 * nodes]
            if c0 * c0 + c1 * c1 + c2 * c2 < fit[3] - options[3]:
                continue  # not even a load that pulls
            at = index[t, 4] + p
            r00, r01, r02 = float(shapes[at]), float(shapes[at + nodes]), float(shapes[at + 2 * nodes])
            r11, r12, r22 = (
                float(shapes[at + 3 * nodes]),
                float(shapes[at + 4 * nodes]),
                float(shapes[at + 5 * nodes]),
            )
            eliminate(
                r00 * r00,
                r00 * r01,
                r00 * r02,
                r01 * r01 + r11 * r11,
                r01 * r02 + r11 * r12,
                r02 * r02 + r12 * r12 + r22 * r22,
                r00 * c0,
                r01 * c0 + r11 * c1,
                r02 * c0 + r12 * c1 + r22 * c2,
                options[0],
                trial,
            )
            if trial[3] > fit[3] - options[3]:
                return True
    return False


@compiled(built_on=(_climb, _scan))
def _outside(
    w, single, sensors, first, flat, terms, tiles, nodes, t, least, options, boxes, scratch, whole, c, s, fits
):
    """Whether S reaches `least` at a side of the search, or beyond."""
    index, origin, near, basis, shapes = tiles
    k, padded, count, start = index[t, 1], index[t, 3], index[t, 6], int(origin[t, 0])
    if count == 0:
        return False
    scan(
        single,
        near[index[t, 0] : index[t, 0] + k],
        basis[index[t, 2] : index[t, 2] + 3 * k * padded].reshape((k, 3, padded)),
        shapes[index[t, 4] : index[t, 4] + 9 * padded].reshape((9, padded)),
        options[0],
        c,
        s,
    )
    for b in range(4):
        best = -1
        for p in range(count):
            if nodes[start + p, 2] == b and (best < 0 or s[p] > s[best]):
                best = p
        if best < 0 or s[best] < options[7] * least:
            continue
        y, z = nodes[start + best, 0], nodes[start + best, 1]
        climb(
            w,
            sensors,
            first,
            flat,
            terms,
            options[0],
            boxes[b],
            y,
            z,
            0.05,
            options[8],
            scratch,
            whole,
            fits[0],
            fits[1],
        )
        if fits[0, 3] > least:
            return True
    return False


@compiled(built_on=(_climb, _scan))
def project_frames(readings, rows, sensors, first, flat, terms, tiles, outer, nodes, boxes, options, out):
    """Fill `out`, one row a frame; frames that are beyond reckoning or lack a sensor are left with status -1.

    readings (f, n), raw; rows (4, n): offset, 1 / noise, low and high end of the range; sensors, first, flat, terms: as
    of `field.field_at`; tiles, outer: `Tiles` of the search and of what is beyond, whose nodes (nodes, 3) lie in
    `boxes`; options: mu, the thresholds of detection and of chi-square, ambiguity, apart, broad, the reading from which
    the strongest names a tile, the share of `nearest_share`, the smallest step, the search, the table's error.
    """
    frames, n = readings.shape
    detection, largest, ambiguity, strong = options[1], options[2], options[3], options[6]
    widest = max(np.max(tiles[0][:, 3]), np.max(outer[0][:, 3]))
    c, s = np.empty((3, widest), dtype=np.float32), np.empty(widest, dtype=np.float32)
    w, single, scratch = np.empty(n), np.empty(n, dtype=np.float32), np.empty((18, n))
    whole = scratch.view(np.int64)
    score, at, fits, trials = np.empty(_MOST), np.empty((_MOST, 2)), np.empty((_MOST + 1, FIT)), np.empty((2, FIT))
    for f in range(frames):
        row = out[f]
        row[:] = math.nan
        row[_RIVAL_CHI2] = math.inf
        total, usable, hot, top = 0.0, True, 0, 0.0
        for i in range(n):
            r = readings[f, i]
            usable &= rows[2, i] < r < rows[3, i]
            w[i] = (r - rows[0, i]) * rows[1, i]
            single[i] = w[i]
            square = w[i] * w[i]
            total += square
            if square > top:
                hot, top = i, square
        if not (usable and total < _MOST_CHI2):
            row[_STATUS] = _PENDING
            continue
        tile = hot if top >= strong * strong else n
        best = second = -1
        for attempt in range(2):
            tile, most, share = (tile, _FEW, 0.25) if attempt == 0 else (n + 1, _MOST, 0.05)
            best, second = _search(
                w,
                single,
                sensors,
                first,
                flat,
                terms,
                tiles,
                tile,
                most,
                share,
                options,
                scratch,
                whole,
                c,
                s,
                score,
                at,
                fits,
            )
            left, bound = total, largest
            if best >= 0:
                left = fits[best, 17]
                bound += options[13] * (fits[best, 0] ** 2 + fits[best, 1] ** 2 + fits[best, 2] ** 2)
            if left <= bound:
                break
        tile = min(tile, n)
        row[_RESIDUAL] = left
        if left > bound:
            row[_STATUS] = _UNEXPLAINED
            continue
        explained = fits[best, 3] if best >= 0 else 0.0
        if explained < detection:
            row[_STATUS] = _NO_CONTACT
            continue
        fit, status = fits[best], _OK
        row[0], row[1] = fit[29], fit[30]
        row[_FORCES], row[_FORCES + 1], row[_FORCES + 2] = fit[0], fit[1], fit[2]
        spread = covariance(fit, options[0], row)
        if second >= 0:
            row[_RIVAL], row[_RIVAL + 1] = fits[second, 29], fits[second, 30]
            row[_RIVAL + 2], row[_RIVAL + 3], row[_RIVAL + 4] = fits[second, 0], fits[second, 1], fits[second, 2]
            worse = max(explained - fits[second, 3], 0.0)
            row[_RIVAL_CHI2] = worse
            if worse < ambiguity:
                status = _AMBIGUOUS
        margin = 2.0 * options[4]
        if not (
            options[9] + margin < row[0] < options[10] - margin and options[11] + margin < row[1] < options[12] - margin
        ):
            status = _AMBIGUOUS
        if _unsure(fit, row, spread, options) or (
            6.0 * math.sqrt(spread) > options[5] and _broad(w, tiles, fit, spread, options, trials[0])
        ):
            status = _AMBIGUOUS
        if status == _OK and _outside(
            w,
            single,
            sensors,
            first,
            flat,
            terms,
            outer,
            nodes,
            tile,
            explained - ambiguity,
            options,
            boxes,
            scratch,
            whole,
            c,
            s,
            trials,
        ):
            status = _AMBIGUOUS
        row[_STATUS] = status
