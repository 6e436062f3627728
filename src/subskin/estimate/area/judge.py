"""Compiled: the tops of S from the highest nodes of a tile, and how sure the best one is.

Other tops near it, the width of S, S far from it and beyond the search (docs/locating_area.md). What the compiled loops
go by is named here: settings, where is looked, and scratch.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..._lanes import EIGHT, alike, answers, one_of
from ..cone import eliminate_three
from ..varpro import Ending, Limits
from .fall import widest_variance
from .point import Point, PointModel, climb
from .scan import peaks, shares_of_eight, within
from .tiles import BASIS, COUNT, NEAR, NODES, ROWS, SHAPES, STRIDE, Tiles

MOST = 12
"""Maxima of a scan that are climbed at most: rows of fits; behind these stand one to try in, and five more."""
FINE = 0.03
"""What the last step of a climb may gain."""
_ASIDE = 2.0
"""How far beside a top another is looked for, in widths of a broad one."""
_SMALL = 24
"""Sensors of which all are fitted at once; of more, first those near the strongest."""
_YY, _YZ, _YN, _YTY, _YTZ, _ZZ, _ZN, _ZTY, _ZTZ, _NN, _NTY, _NTZ, _TYTY, _TYTZ, _TZTZ = range(15)
"""Where a covariance of (y, z, N, Ty, Tz) has what: `spread` in the functions below."""


def plain(value: Any) -> Any:
    """A named tuple as one without names, and so its parts: Numba takes these in a third of the time.

    A loop gives them their names again, part by part.
    """
    return tuple(plain(part) for part in value) if isinstance(value, tuple) else value


class Settings(NamedTuple):
    """Thresholds of a search.

    detection: least chi-square explained by a contact; largest: most that may be left; ambiguity: chi-square by which
    the second-best has to be worse; apart: two tops nearer than this are one [m]; broad: a profile wider than this may
    be ambiguous [m]; strong: noises from which the strongest reading names a tile; curved: standard deviation from
    which S need be no parabola [m]; smallest: least step of a climb [m]; box (4,): ends of y, then of z; error: chi-
    square of a unit force, squared, by the table's error; told: least share of a load by which others near it differ,
    infinite where that is large.
    """

    limits: Limits
    detection: float
    largest: float
    ambiguity: float
    apart: float
    broad: float
    strong: float
    curved: float
    smallest: float
    box: FloatArray
    error: float
    told: float


class Beyond(NamedTuple):
    """What lies at the sides of the search and beyond: four boxes, their nodes (nodes, 4), and the tiles of these.

    held, members: the nodes of each region, as of `far.nodes_of`, or of each sensor.
    """

    tiles: Tiles
    nodes: FloatArray
    boxes: FloatArray
    held: npt.NDArray[np.int64]
    members: npt.NDArray[np.int64]


class Search(NamedTuple):
    """Where point loads are looked for, and what sensors read of them."""

    model: PointModel
    tiles: Tiles
    settings: Settings


class Scratch(NamedTuple):
    """Scratch of a search.

    lead: numbers before the nodes of `heights`; part (n + 1,): readings of the sensors that count; score (most,), at
    (most, 2): the highest nodes; fits: of these, one to try in and five more; trials: one to try in, one of where S is
    higher, and of `fall.look_round` nothing, and what is not near; lanes: as of `fall.LANES`; ratio (8,), root (3,),
    more (3,).
    """

    lead: int
    heights: npt.NDArray[np.float32]
    part: FloatArray
    score: FloatArray
    at: FloatArray
    fits: npt.NDArray[np.void]
    trials: npt.NDArray[np.void]
    lanes: FloatArray
    ratio: FloatArray
    root: FloatArray
    more: FloatArray


@compiled(inline=True)
def nearby(w, model, tiles, t, part):
    """Readings and model of the sensors that count in tile t, where these are few; else of all."""
    i0, k = tiles.table[t, NEAR], tiles.table[t, COUNT]
    near_w, near = w, model
    if 4 * k < 3 * w.size and w.size > _SMALL:
        near_w, first = part[:k], tiles.first[i0 + t : i0 + t + k + 1]
        sensors = tiles.sensors[4 * i0 : 4 * (i0 + k)].reshape((4, k))
        near = PointModel(sensors, first, *model[2:])
    return near_w, near


@compiled(borrows=True)
def tops_of(w, search, room, t, total, c, most, share):
    """Best and second-best top of S from the highest nodes of tile t, as rows of `room.fits`; -1 where there is none.

    Of many sensors first those that count are fitted, then all; `room.part` keeps the readings of these. total, c: as
    of `scan.taken`; most, share: as of `scan.peaks`.
    """
    tiles, settings, model, fits, heights, lead = (
        search.tiles, search.settings, search.model, room.fits, room.heights, room.lead
    )  # fmt: skip
    index, origin, at, score = tiles.table, tiles.origin, room.at, room.score
    i0, k, m, stride = index[t, NEAR], index[t, COUNT], index[t, NODES], index[t, STRIDE]
    shapes = tiles.shapes[index[t, SHAPES] : index[t, SHAPES] + 9 * m].reshape((9, m))
    within(shapes, settings.limits.friction, c, heights[lead : lead + m])
    for p in range(lead + m, lead + m + stride + 2):
        heights[p] = np.float32(-1)
    near_w, near = nearby(w, model, tiles, t, room.part)
    few = near_w.size < w.size
    straight = 0.02 * settings.broad if few else 0.0
    if few:
        for i in range(k):
            e = tiles.near[i0 + i]
            near_w[i] = w[e] if e < w.size else 0.0
    best = second = -1
    count = peaks(heights, lead, m, stride, total, share, score[:most], at)
    for q in range(count + 1):
        # a maximum clearly lower than both already found cannot become the best or the rival
        last = q == count or (second >= 0 and score[q] < 0.8 * fits[second].explained)
        if last and best <= 0:
            break
        p = best if last else q  # at last the best, if it was climbed roughly
        tolerance, needed = FINE, -math.inf
        if not last and q > 0:
            tolerance = 1e-2 * max(fits[best].explained - score[p], 0.1)
            needed = fits[second].explained if second >= 0 else needed
        start = Point(origin[t, 0] + at[p, 0] * origin[t, 2], origin[t, 1] + at[p, 1] * origin[t, 3])
        if few:
            ending = Ending(tolerance, settings.smallest, straight, -math.inf)
            climb(near_w, near, settings.limits, settings.box, start, ending, fits[p], fits[MOST])
            start = Point(fits[p].y, fits[p].z)
        ending = Ending(tolerance, settings.smallest, straight, needed)
        climb(w, model, settings.limits, settings.box, start, ending, fits[p], fits[MOST])
        if last:
            break
        if best < 0:
            best = p
        elif abs(fits[p].y - fits[best].y) + abs(fits[p].z - fits[best].z) < settings.apart:
            if fits[p].explained > fits[best].explained:
                best = p
        elif fits[p].explained > fits[best].explained:
            best, second = p, best
        elif second < 0 or fits[p].explained > fits[second].explained:
            second = p
    return best, second


@compiled(inline=True)
def unsure(fit, spread, largest, box):
    """Whether the readings leave open the position, or the direction of the force by a radian."""
    if not largest < (box[1] - box[0]) ** 2 + (box[3] - box[2]) ** 2:
        return True
    n, ty, tz = fit.n, fit.ty, fit.tz
    c00, c01, c02 = spread[_NN], spread[_NTY], spread[_NTZ]
    c11, c12, c22 = spread[_TYTY], spread[_TYTZ], spread[_TZTZ]
    force2 = n * n + ty * ty + tz * tz
    along = n * (n * c00 + 2 * (ty * c01 + tz * c02)) + ty * (ty * c11 + 2 * tz * c12) + tz * tz * c22
    return not (c00 + c11 + c22) * force2 - along < force2 * force2


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
def is_broad(w, tiles, t, at, explained, spread, largest, settings):
    """Whether a load near the best, but further than six standard deviations, explains a frame about as well.

    At the nodes of tile t, the finest grid, S is exact, the cone included. at, explained: the best
    load's; largest: its variance.
    """
    index, origin, basis, shapes = tiles.table, tiles.origin, tiles.basis, tiles.shapes
    n, padded, nodes, rows, stride = w.size, index[t, COUNT], index[t, NODES], index[t, ROWS], index[t, STRIDE]
    columns = stride - 1
    y, z, hy, hz = at.y, at.z, origin[t, 2], origin[t, 3]
    yy, yz, zz = spread[_YY], spread[_YZ], spread[_ZZ]
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
            c0, c1, c2 = shares_of_eight(w, n, basis, index[t, BASIS] + 3 * padded * p)
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
def beside(w, search, room, best, second, spread):
    """Best and second-best top, where another may stand too near the best one for the scan to tell them apart.

    Few sensors, or strains along the depth where nu < 1/2, leave pairs of tops a fifth of a depth apart and more: climb
    once more from four sides, and from where a load with the drag reversed would read about the same.
    """
    settings, fits = search.settings, room.fits
    fit, box, ending = fits[best], settings.box, Ending(FINE, settings.smallest, 0.0, -math.inf)
    turn = 0.5 * math.atan2(2.0 * spread[_YZ], spread[_YY] - spread[_ZZ])
    away, y0, z0 = max(_ASIDE * settings.broad, 3.0 * math.sqrt(widest_variance(spread))), fit.y, fit.z
    along, across = spread[_TYTY], spread[_TZTZ]
    to_y = -2.0 * fit.ty * spread[_YTY] / along if along > 0.0 else 0.0
    to_z = -2.0 * fit.tz * spread[_ZTZ] / across if across > 0.0 else 0.0
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


@compiled(borrows=True)
def best_beyond(single, n, beyond, t, kept, lane, mu, tried, top, best):
    """The best node of each box beyond the search, where S may be larger than `top`, which is raised to what it is.

    Nodes of tile t are looked at, of the regions that are kept of the frame in `lane` (`far.regions_left`). top, best
    (4,): what S is at most near a box's best node, and which node that is; tried (nodes,): scratch.
    """
    tiles, nodes, held = beyond.tiles, beyond.nodes, beyond.held
    index, basis, shapes = tiles.table, tiles.basis, tiles.shapes
    padded, m, first, begin = index[t, COUNT], index[t, NODES], int(tiles.origin[t, 0]), -EIGHT
    c0, c1, c2 = alike(np.float32(0)), alike(np.float32(0)), alike(np.float32(0))
    for p in range(m):
        tried[p] = np.float32(0)
    for r in range(kept.shape[0]):
        i = kept[r, 0]
        for e in range(held[i], held[i + 1] if (kept[r, 1] >> lane) & 1 else held[i]):
            p = beyond.members[e]
            if tried[p] > 0:
                continue
            tried[p] = np.float32(1)
            if not begin <= p < begin + EIGHT:  # nodes of a region stand side by side
                begin = p - p % EIGHT
                c0, c1, c2 = shares_of_eight(single, n, basis, index[t, BASIS] + 3 * padded * begin)
            b, share = int(nodes[first + p, 2]), nodes[first + p, 3]
            s0, s1, s2 = one_of(c0, p - begin), one_of(c1, p - begin), one_of(c2, p - begin)
            if s0 * s0 + s1 * s1 + s2 * s2 < share * top[b]:
                continue  # not even a load that pulls, at most nodes of most frames
            explained = at_node(shapes, index[t, SHAPES] + p, m, s0, s1, s2, mu)
            if explained >= share * top[b]:
                top[b], best[b] = explained / share, float(first + p)


@compiled(borrows=True)
def outside(w, single, search, beyond, kept, lane, least, tried, room):
    """Whether S reaches `least` at a side of the search, or beyond: climbs begin at the best node of each box."""
    settings, top, best, fit = search.settings, room.ratio[:4], room.ratio[4:], room.trials[0]
    for b in range(4):
        top[b], best[b] = least, -1.0
    best_beyond(single, w.size, beyond, 0, kept, lane, settings.limits.friction, tried, top, best)
    for b in range(4):
        if best[b] >= 0.0:
            p, ending = int(best[b]), Ending(0.05, settings.smallest, 0.0, least)
            at = Point(beyond.nodes[p, 0], beyond.nodes[p, 1])
            climb(w, search.model, settings.limits, beyond.boxes[b], at, ending, fit, room.trials[1])
            if fit.explained > least:
                return True
    return False
