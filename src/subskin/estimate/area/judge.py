"""Compiled: how sure the best load of a frame is: covariance, other tops near it, the width of S, S far from it.

On an area S falls round its top like a parabola only where the noise is small beside the distance over which readings
bend. Else it is looked at (docs/locating_area.md).
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..._lanes import EIGHT, answers, one_of
from ..layout import AREA
from .climb import ROUND, climb, drops, root_of
from .cone import eliminate
from .fall import beyond_near, falls
from .scan import shares_of_eight

MOST = 12
"""Maxima of a scan that are climbed at most: rows of fits; behind these stand one to try in, and five more."""
FINE = 0.03
"""What the last step of a climb may gain."""
_ASIDE = 2.0
"""How far beside a top another is looked for, in widths of a broad one."""
_NEAR, _FAR = 2.5, 4.0
"""Standard deviations at which S is looked at round the top; the farther only where it is no parabola at the nearer."""
_ODD, _LEVEL, _HIGHER = 1.25, 4.0, 0.1
"""Ratio of variances from which it is none; least fall to the farther distance; what counts as higher than the top."""
_CLOSE = 0.25
"""Depths off the top up to which `fall.falls` is asked."""
_COVARIANCE = AREA.covariance


@compiled(borrows=True)
def covariance(fit, mu, more, row):
    """Inverse Fisher information of (y, z, N, Ty, Tz), 15 entries, that of (y, z) plus `more` (yy, yz, zz).

    Infinite, or NaN, where the readings do not say.
    """
    g00, g01, g02, g11, g12, g22 = fit[11], fit[12], fit[13], fit[14], fit[15], fit[16]
    if mu == 0.0:  # there is no drag, and that is known
        i00, i01, i02, i11, i12, i22 = 1.0 / g00, 0.0, 0.0, 0.0, 0.0, 0.0
    else:
        i00, i01, i02 = g11 * g22 - g12 * g12, g02 * g12 - g01 * g22, g01 * g12 - g02 * g11
        i11, i12, i22 = g00 * g22 - g02 * g02, g01 * g02 - g00 * g12, g00 * g11 - g01 * g01
        det = max(g00 * i00 + g01 * i01 + g02 * i02, 0.0)
        over = 1.0 / det
        i00, i01, i02, i11, i12, i22 = i00 * over, i01 * over, i02 * over, i11 * over, i12 * over, i22 * over
    p0, p1, p2, r0, r1, r2 = fit[23], fit[24], fit[25], fit[26], fit[27], fit[28]
    k0, k1, k2 = i00 * p0 + i01 * p1 + i02 * p2, i01 * p0 + i11 * p1 + i12 * p2, i02 * p0 + i12 * p1 + i22 * p2
    l0, l1, l2 = i00 * r0 + i01 * r1 + i02 * r2, i01 * r0 + i11 * r1 + i12 * r2, i02 * r0 + i12 * r1 + i22 * r2
    hyy = fit[20] - (p0 * k0 + p1 * k1 + p2 * k2)
    hyz = fit[21] - (p0 * l0 + p1 * l1 + p2 * l2)
    hzz = fit[22] - (r0 * l0 + r1 * l1 + r2 * l2)
    det = max(hyy * hzz - hyz * hyz, 0.0)
    yy, yz, zz = hzz / det + more[0], -hyz / det + more[1], hyy / det + more[2]
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


@compiled(inline=True)
def widest_variance(row):
    """The largest variance of a direction in (y, z)."""
    yy, yz, zz = row[_COVARIANCE], row[_COVARIANCE + 1], row[_COVARIANCE + 5]
    half = 0.5 * (yy - zz)
    return 0.5 * (yy + zz) + math.sqrt(half * half + yz * yz)


@compiled(inline=True)
def unsure(fit, row, largest, options):
    """Whether the readings leave open the position, or the direction of the force by a radian."""
    if not largest < (options[10] - options[9]) ** 2 + (options[12] - options[11]) ** 2:
        return True
    n, ty, tz, c = fit[0], fit[1], fit[2], _COVARIANCE
    c00, c01, c02, c11, c12, c22 = row[c + 9], row[c + 10], row[c + 11], row[c + 12], row[c + 13], row[c + 14]
    force2 = n * n + ty * ty + tz * tz
    along = n * (n * c00 + 2 * (ty * c01 + tz * c02)) + ty * (ty * c11 + 2 * tz * c12) + tz * tz * c22
    return not (c00 + c11 + c22) * force2 - along < force2 * force2


@compiled(inline=True)
def node_shares(w, basis, at, padded, n):
    """What the basis of a node takes of n readings; it begins at `at`, of a tile that lies node by node."""
    b0, b1, b2 = basis[at : at + n], basis[at + padded : at + padded + n], basis[at + 2 * padded :]
    c0 = c1 = c2 = np.float32(0)
    for i in range(n):
        c0 += w[i] * b0[i]
        c1 += w[i] * b1[i]
        c2 += w[i] * b2[i]
    return c0, c1, c2


@compiled(borrows=True)
def at_node(shapes, at, nodes, c0, c1, c2, mu, trial):
    """Fill trial as `cone.eliminate` does, of a node whose shapes begin at `at`; A^T A and A^T w follow from these."""
    r00, r01, r02 = float(shapes[at]), float(shapes[at + nodes]), float(shapes[at + 2 * nodes])
    r11, r12, r22 = float(shapes[at + 3 * nodes]), float(shapes[at + 4 * nodes]), float(shapes[at + 5 * nodes])
    eliminate(
        r00 * r00, r00 * r01, r00 * r02, r01 * r01 + r11 * r11, r01 * r02 + r11 * r12,
        r02 * r02 + r12 * r12 + r22 * r22, r00 * c0, r01 * c0 + r11 * c1, r02 * c0 + r12 * c1 + r22 * c2, mu, trial,
    )  # fmt: skip


@compiled(borrows=True)
def is_broad(w, tiles, fit, row, largest, options, trial):
    """Whether a load near the best, but further than six standard deviations, explains a frame about as well.

    At the nodes of the finest grid S is exact, the cone included.
    """
    index, origin, _, basis, shapes = tiles
    t = index.shape[0] - 1
    n, padded, nodes, rows, stride = w.size, index[t, 1], index[t, 3], index[t, 5], index[t, 6]
    columns = stride - 1
    y, z, hy, hz = fit[29], fit[30], origin[t, 2], origin[t, 3]
    yy, yz, zz = row[_COVARIANCE], row[_COVARIANCE + 1], row[_COVARIANCE + 5]
    least = options[5]
    reach = max(6.0 * math.sqrt(largest), least)
    wide = max(1.8 * reach, reach + 1.5 * max(hy, hz))
    enough = fit[3] - options[3]
    nearly, inverse = np.float32((1.0 - 1e-6) * enough), 1.0 / (yy * zz - yz * yz)
    j0, j1 = max(int((y - wide - origin[t, 0]) / hy), 0), min(int((y + wide - origin[t, 0]) / hy) + 2, rows)
    for j in range(j0, j1):
        dy = origin[t, 0] + j * hy - y
        away = math.sqrt(max(wide * wide - dy * dy, 0.0))
        k0, k1 = max(int((z - away - origin[t, 1]) / hz), 0), min(int((z + away - origin[t, 1]) / hz) + 2, columns)
        begin, end = j * stride + k0, j * stride + k1
        for p in range(begin - begin % EIGHT, end, EIGHT):
            c0, c1, c2 = shares_of_eight(w, n, basis, index[t, 2] + 3 * padded * p, padded)
            some = answers(c0 * c0 + c1 * c1 + c2 * c2 >= nearly)  # of the others not even a load that pulls is enough
            for lane in range(EIGHT if some > 0 else 0):
                e = p + lane - j * stride
                if (some >> lane) & 1 == 0 or not k0 <= e < k1:
                    continue
                dz = origin[t, 1] + e * hz - z
                far = (zz * dy * dy - 2.0 * yz * dy * dz + yy * dz * dz) * inverse
                if far > 36.0 and least * least < dy * dy + dz * dz < wide * wide:
                    s0, s1, s2 = one_of(c0, lane), one_of(c1, lane), one_of(c2, lane)
                    at_node(shapes, index[t, 4] + p + lane, nodes, s0, s1, s2, options[0], trial)
                    if trial[3] > enough:
                        return True
    return False


@compiled(borrows=True)
def beside(w, sensors, first, table, terms, options, best, second, row, scratch, whole, fits):
    """Best and second-best top, where another may stand too near the best one for the scan to tell them apart.

    Few sensors, or strains along the depth where nu < 1/2, leave pairs of tops a fifth of a depth apart and more: climb
    once more from four sides, and from where a load with the drag reversed would read about the same.
    """
    fit, c = fits[best], _COVARIANCE
    yy, yz, zz = row[c], row[c + 1], row[c + 5]
    turn = 0.5 * math.atan2(2.0 * yz, yy - zz)
    away, spare, y0, z0 = max(_ASIDE * options[5], 3.0 * math.sqrt(widest_variance(row))), MOST, fit[29], fit[30]
    along, across = row[c + 12], row[c + 14]
    to_y = -2.0 * fit[1] * row[c + 3] / along if along > 0.0 else 0.0
    to_z = -2.0 * fit[2] * row[c + 8] / across if across > 0.0 else 0.0
    for side in range(5 if abs(to_y) + abs(to_z) < options[10] - options[9] else 4):
        p, to = MOST + 1 + side, turn + 0.5 * math.pi * side
        y, z = y0 + away * math.cos(to), z0 + away * math.sin(to)
        if side == 4:
            y, z = y0 + to_y, z0 + to_z
        climb(
            w, sensors, first, table, terms, options[0], options[9:13], y, z, FINE, options[8], 0.0, -math.inf,
            scratch, whole, fits[p], fits[spare],
        )  # fmt: skip
        if abs(fits[p, 29] - fits[best, 29]) + abs(fits[p, 30] - fits[best, 30]) < options[4]:
            continue
        if fits[p, 3] > fits[best, 3]:
            best, second = p, best
        elif second < 0 or fits[p, 3] > fits[second, 3]:
            second = p
    return best, second


@compiled(borrows=True)
def look_round(w, near, sensors, first, table, terms, options, fit, row, scratch, whole, trials, lanes, ratio, more):
    """How S falls round the top: 0 about as a parabola, 1 less so, 2 so little that there is no one answer.

    `more` is what the variance of (y, z) gains: the second moment of exp(S / 2) about the top, whose width is looked
    at in eight directions. -1: S is larger a few deviations off; trials[2, 29] and [2, 30] say where. near: w, sensors
    and first of the sensors that count.
    """
    trial, best, root, fall = trials[0], trials[2], trials[1, :3], lanes[:8]
    c = _COVARIANCE
    root_of(row[c], row[c + 1], row[c + 5], root)
    more[0] = more[1] = more[2] = 0.0
    mu, box = options[0], options[9:13]
    base, shape, widest = fit[3], 0, 0.0
    close = 10.0 * _CLOSE * options[5] / math.sqrt(widest_variance(row)) if terms.shape[0] == 0 else 0.0
    v, its_sensors, its_first = near if fit[10] > 0.0 else (w, sensors, first)
    if close >= _NEAR:
        for k in range(lanes.size):
            lanes[k] = 0.0
        if v.size < w.size:
            beyond_near(v, its_sensors, its_first, table, terms, mu, fit, scratch, whole, trial, lanes)
    best[3] = base + _HIGHER
    for far in range(2):
        reach = _FAR if far else _NEAR
        if reach <= close:
            least = falls(
                v, its_sensors, its_first, table, mu, box, fit, root, reach, scratch, whole, trial, best, lanes
            )  # fmt: skip
            if v.size < w.size and _ODD * least < reach * reach:  # then all sensors are asked
                v, its_sensors, its_first = w, sensors, first
                best[3] = base + _HIGHER
                for k in range(lanes.size):
                    lanes[k] = 0.0
                falls(v, sensors, first, table, mu, box, fit, root, reach, scratch, whole, trial, best, lanes)
        else:
            drops(
                w, sensors, first, table, terms, mu, box, fit, base, root, reach, scratch, whole, trial, best, fall
            )  # fmt: skip
        if best[3] > base + _HIGHER:
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


@compiled(borrows=True)
def outside(
    w, single, sensors, first, table, terms, tiles, nodes, held, members, kept, lane, least, options, boxes, scratch,
    whole, tried, fits,
):  # fmt: skip
    """Whether S reaches `least` at a side of the search, or beyond.

    Climbs begin at the best node of each box, of the regions that may reach it: those kept of the frame in `lane`, as
    of `reach.regions_left`. held, members: as of `far.nodes_of`; tried (nodes,): scratch.
    """
    index, _, _, basis, shapes = tiles
    padded, m, count, n = index[0, 1], index[0, 3], index[0, 6], w.size
    trial, top, best = fits[0], fits[2, :4], fits[2, 4:8]
    for b in range(4):
        top[b], best[b] = least, -1.0
    for p in range(count):
        tried[p] = np.float32(0)
    for r in range(kept.shape[0]):
        i = kept[r, 0]
        for e in range(held[i], held[i + 1] if (kept[r, 1] >> lane) & 1 else held[i]):
            p = members[e]
            if tried[p] > 0:
                continue
            tried[p] = np.float32(1)
            b, needed = int(nodes[p, 2]), nodes[p, 3]
            c0, c1, c2 = node_shares(single, basis, index[0, 2] + 3 * padded * p, padded, n)
            if c0 * c0 + c1 * c1 + c2 * c2 < needed * top[b]:
                continue  # not even a load that pulls, at most nodes of most frames
            at_node(shapes, index[0, 4] + p, m, c0, c1, c2, options[0], trial)
            if trial[3] >= needed * top[b]:
                top[b], best[b] = trial[3] / needed, float(p)
    for b in range(4):
        if best[b] >= 0.0:
            p = int(best[b])
            climb(
                w, sensors, first, table, terms, options[0], boxes[b], nodes[p, 0], nodes[p, 1], 0.05, options[8], 0.0,
                least, scratch, whole, fits[0], fits[1],
            )  # fmt: skip
            if fits[0, 3] > least:
                return True
    return False
