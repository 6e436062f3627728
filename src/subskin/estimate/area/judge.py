"""Compiled: how sure the best load of a frame is: covariance, other tops near it, the width of S, S far from it.

On an area S falls round its top like a parabola only where the noise is small beside the distance over which readings
bend. Else it is looked at (docs/locating_area.md).
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..._lanes import EIGHT, answers, one_of
from ..cone import eliminate_three
from ..layout import AREA
from ..varpro import Ending
from .fall import ROUND, beyond_near, falls
from .point import Point, climb, project
from .scan import shares_of_eight
from .tiles import BASIS, COUNT, NODES, ROWS, SHAPES, STRIDE

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
_YY, _YZ, _YN, _YTY, _YTZ, _ZZ, _ZN, _ZTY, _ZTZ, _NN, _NTY, _NTZ, _TYTY, _TYTZ, _TZTZ = range(
    AREA.covariance, AREA.covariance + 15
)
"""Columns of a row's covariance."""


@compiled(inline=True)
def widest_variance(row):
    """The largest variance of a direction in (y, z)."""
    yy, yz, zz = row[_YY], row[_YZ], row[_ZZ]
    half = 0.5 * (yy - zz)
    return 0.5 * (yy + zz) + math.sqrt(half * half + yz * yz)


@compiled(inline=True)
def unsure(fit, row, largest, box):
    """Whether the readings leave open the position, or the direction of the force by a radian."""
    if not largest < (box[1] - box[0]) ** 2 + (box[3] - box[2]) ** 2:
        return True
    n, ty, tz = fit.n, fit.ty, fit.tz
    c00, c01, c02, c11, c12, c22 = row[_NN], row[_NTY], row[_NTZ], row[_TYTY], row[_TYTZ], row[_TZTZ]
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
def at_node(shapes, at, nodes, c0, c1, c2, mu):
    """S at a node whose shapes begin at `at`: A^T A and A^T w follow from these and from what the basis takes."""
    r00, r01, r02 = float(shapes[at]), float(shapes[at + nodes]), float(shapes[at + 2 * nodes])
    r11, r12, r22 = float(shapes[at + 3 * nodes]), float(shapes[at + 4 * nodes]), float(shapes[at + 5 * nodes])
    _, _, _, explained, _, _, _, _, _, _, _ = eliminate_three(
        r00 * r00, r00 * r01, r00 * r02, r01 * r01 + r11 * r11, r01 * r02 + r11 * r12,
        r02 * r02 + r12 * r12 + r22 * r22, r00 * c0, r01 * c0 + r11 * c1, r02 * c0 + r12 * c1 + r22 * c2, mu,
    )  # fmt: skip
    return explained


@compiled(borrows=True)
def is_broad(w, tiles, t, at, explained, row, largest, settings):
    """Whether a load near the best, but further than six standard deviations, explains a frame about as well.

    At the nodes of tile t, the finest grid, S is exact, the cone included. at, explained: the best
    load's; largest: its variance.
    """
    index, origin, basis, shapes = tiles.table, tiles.origin, tiles.basis, tiles.shapes
    n, padded, nodes, rows, stride = w.size, index[t, COUNT], index[t, NODES], index[t, ROWS], index[t, STRIDE]
    columns = stride - 1
    y, z, hy, hz = at.y, at.z, origin[t, 2], origin[t, 3]
    yy, yz, zz = row[_YY], row[_YZ], row[_ZZ]
    least = settings.broad
    reach = max(6.0 * math.sqrt(largest), least)
    wide = max(1.8 * reach, reach + 1.5 * max(hy, hz))
    enough = explained - settings.ambiguity
    nearly, inverse = np.float32((1.0 - 1e-6) * enough), 1.0 / (yy * zz - yz * yz)
    j0, j1 = max(int((y - wide - origin[t, 0]) / hy), 0), min(int((y + wide - origin[t, 0]) / hy) + 2, rows)
    for j in range(j0, j1):
        dy = origin[t, 0] + j * hy - y
        away = math.sqrt(max(wide * wide - dy * dy, 0.0))
        k0, k1 = max(int((z - away - origin[t, 1]) / hz), 0), min(int((z + away - origin[t, 1]) / hz) + 2, columns)
        begin, end = j * stride + k0, j * stride + k1
        for p in range(begin - begin % EIGHT, end, EIGHT):
            c0, c1, c2 = shares_of_eight(w, n, basis, index[t, BASIS] + 3 * padded * p, padded)
            some = answers(c0 * c0 + c1 * c1 + c2 * c2 >= nearly)  # of the others not even a load that pulls is enough
            for lane in range(EIGHT if some > 0 else 0):
                e = p + lane - j * stride
                if (some >> lane) & 1 == 0 or not k0 <= e < k1:
                    continue
                dz = origin[t, 1] + e * hz - z
                far = (zz * dy * dy - 2.0 * yz * dy * dz + yy * dz * dz) * inverse
                if far > 36.0 and least * least < dy * dy + dz * dz < wide * wide:
                    s0, s1, s2 = one_of(c0, lane), one_of(c1, lane), one_of(c2, lane)
                    if (
                        at_node(shapes, index[t, SHAPES] + p + lane, nodes, s0, s1, s2, settings.limits.friction)
                        > enough
                    ):
                        return True
    return False


@compiled(borrows=True)
def beside(w, search, room, best, second, row):
    """Best and second-best top, where another may stand too near the best one for the scan to tell them apart.

    Few sensors, or strains along the depth where nu < 1/2, leave pairs of tops a fifth of a depth apart and more: climb
    once more from four sides, and from where a load with the drag reversed would read about the same.
    """
    settings, fits = search.settings, room.fits
    fit, box, ending = fits[best], settings.box, Ending(FINE, settings.smallest, 0.0, -math.inf)
    turn = 0.5 * math.atan2(2.0 * row[_YZ], row[_YY] - row[_ZZ])
    away, y0, z0 = max(_ASIDE * settings.broad, 3.0 * math.sqrt(widest_variance(row))), fit.y, fit.z
    along, across = row[_TYTY], row[_TZTZ]
    to_y = -2.0 * fit.ty * row[_YTY] / along if along > 0.0 else 0.0
    to_z = -2.0 * fit.tz * row[_ZTZ] / across if across > 0.0 else 0.0
    for side in range(5 if abs(to_y) + abs(to_z) < box[1] - box[0] else 4):
        p, to = MOST + 1 + side, turn + 0.5 * math.pi * side
        at = Point(y0 + away * math.cos(to), z0 + away * math.sin(to))
        if side == 4:
            at = Point(y0 + to_y, z0 + to_z)
        climb(w, search.model, settings.limits, box, at, ending, fits[p], fits[MOST])
        if abs(fits[p].y - fits[best].y) + abs(fits[p].z - fits[best].z) < settings.apart:
            continue
        if fits[p].explained > fits[best].explained:
            best, second = p, best
        elif second < 0 or fits[p].explained > fits[second].explained:
            second = p
    return best, second


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
def look_round(w, near_w, near, search, room, fit, row):
    """How S falls round the top: 0 about as a parabola, 1 less so, 2 so little that there is no one answer.

    `room.more` is what the variance of (y, z) gains: the second moment of exp(S / 2) about the top, whose width is
    looked at in eight directions. -1: S is larger a few deviations off; room.trials[1] says where. near_w, near: the
    readings and the model of the sensors that count.
    """
    model, settings, lanes, ratio, more = search.model, search.settings, room.lanes, room.ratio, room.more
    limits, box, root, fall = settings.limits, settings.box, room.root, lanes[:EIGHT]
    trial, best = room.trials[0], room.trials[1]
    root_of(row[_YY], row[_YZ], row[_ZZ], root)
    more[0] = more[1] = more[2] = 0.0
    base, shape, widest = fit.explained, 0, 0.0
    close = 0.0
    if model.terms.shape[0] == 0:
        close = 10.0 * _CLOSE * settings.broad / math.sqrt(widest_variance(row))
    v, its = (near_w, near) if fit.inside > 0.0 else (w, model)
    if close >= _NEAR:
        for k in range(lanes.size):
            lanes[k] = 0.0
        if v.size < w.size:
            beyond_near(v, its, limits, fit, trial, lanes)
    best.explained = base + _HIGHER
    for far in range(2):
        reach = _FAR if far else _NEAR
        if reach <= close:
            least = falls(v, its, limits.friction, box, fit, root, reach, best, lanes)
            if v.size < w.size and _ODD * least < reach * reach:  # then all sensors are asked
                v, its = w, model
                best.explained = base + _HIGHER
                for k in range(lanes.size):
                    lanes[k] = 0.0
                falls(v, its, limits.friction, box, fit, root, reach, best, lanes)
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


@compiled(borrows=True)
def outside(w, single, search, beyond, kept, lane, least, tried, room):
    """Whether S reaches `least` at a side of the search, or beyond.

    Climbs begin at the best node of each box, of the regions that may reach it: those kept of the frame in `lane`, as
    of `reach.regions_left`. tried (nodes,): scratch.
    """
    index, basis, shapes = beyond.tiles.table, beyond.tiles.basis, beyond.tiles.shapes
    nodes, held, settings = beyond.nodes, beyond.held, search.settings
    padded, m, count, n = index[0, COUNT], index[0, NODES], index[0, STRIDE], w.size
    top, best, fit = room.ratio[:4], room.ratio[4:], room.trials[0]
    for b in range(4):
        top[b], best[b] = least, -1.0
    for p in range(count):
        tried[p] = np.float32(0)
    for r in range(kept.shape[0]):
        i = kept[r, 0]
        for e in range(held[i], held[i + 1] if (kept[r, 1] >> lane) & 1 else held[i]):
            p = beyond.members[e]
            if tried[p] > 0:
                continue
            tried[p] = np.float32(1)
            b, needed = int(nodes[p, 2]), nodes[p, 3]
            c0, c1, c2 = node_shares(single, basis, index[0, BASIS] + 3 * padded * p, padded, n)
            if c0 * c0 + c1 * c1 + c2 * c2 < needed * top[b]:
                continue  # not even a load that pulls, at most nodes of most frames
            explained = at_node(shapes, index[0, SHAPES] + p, m, c0, c1, c2, settings.limits.friction)
            if explained >= needed * top[b]:
                top[b], best[b] = explained / needed, float(p)
    for b in range(4):
        if best[b] >= 0.0:
            p = int(best[b])
            at, ending = Point(nodes[p, 0], nodes[p, 1]), Ending(0.05, settings.smallest, 0.0, least)
            climb(w, search.model, settings.limits, beyond.boxes[b], at, ending, fit, room.trials[1])
            if fit.explained > least:
                return True
    return False
