"""The compiled heart of `fit` on an area: a round contact of some half width, one frame at a time.

For each of some widths the scan and the climb of point loads (`project.py`), whose table is then that of the width;
from their tops a climb over the width as well (`round_contact.py`). At the best width the contact is judged as a point
load is; the interval of the width is where chi-square rises by 1.96^2, all else fitted anew, and what the other
unknowns do there is what the width adds to their covariance. Where a moment is fitted, the scans do not know of it:
then a second search follows on what it leaves of the readings, and the contact is judged on these.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..layout import AREA, ROUND, TWIST, Layout
from ..varpro import Ending
from .judge import FINE, MOST, is_broad, look_round, unsure, widest_variance
from .order import strongest, whitened
from .point import ROWS, Point, PointModel, covariance
from .point import climb as climb_point
from .project import FEW, MOST_CHI2, named_beyond, named_settings, room_of
from .round_contact import FIT, MOMENT, RoundAt, RoundModel, at_width, climb, in_room, keep, project
from .round_judge import MORE, contact_outside, further_tops, ranked, width_profile
from .scan import taken
from .settings import Search, Settings
from .tiles import Tiles
from .tops import tops_of

_TOPS = 8
"""Tops over position and width that are climbed to from the scan."""
_AGAIN = 3
_NEAR = 2.5
"""How near one start of a climb stands for another, over the width from which a profile counts as broad."""
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_POINT, _POINT_COLUMNS = AREA.covariance, AREA.columns


class _Columns(NamedTuple):
    """Where a row has what."""

    covariance: int
    interval: int
    residual: int
    rival: int
    rival_chi2: int
    status: int


def _where(layout: Layout) -> _Columns:
    return _Columns(*(getattr(layout, name) for name in _Columns._fields))


_PLAIN, _TWISTED = _where(ROUND), _where(TWIST)


class RoundSearch(NamedTuple):
    """Where round contacts are looked for, and what sensors read of them.

    contact: of any width; points: of point loads, whose table is another at each width; tables (k, rows, numbers):
    those of `widths` (k,), squares of half widths that are scanned in the search, as `far` are beyond it; ends (2,):
    the least and the largest q of the search.
    """

    contact: RoundModel
    points: PointModel
    tables: FloatArray
    widths: FloatArray
    far: FloatArray
    ends: FloatArray
    tiles: Tiles
    settings: Settings


class _RoundRoom(NamedTuple):
    """Scratch of a search for round contacts.

    full, single (n + 1,): readings, and bits: the same memory as integers; bare (n + 1,): what a moment leaves of them;
    shares, heights: of the nodes of a tile; starts (2 widths, 4): S, y, z, q; levels (widths,): S of the best top of
    each width; tops, others: fits; fit: of a point load; flat: a table of these; box, only (6,): ends of y, z and q;
    picked (4, 4), sides (3, 7); point: a row of `AREA`.
    """

    full: FloatArray
    single: npt.NDArray[np.float32]
    bits: npt.NDArray[np.int32]
    bare: FloatArray
    shares: npt.NDArray[np.float32]
    heights: npt.NDArray[np.float32]
    starts: FloatArray
    levels: FloatArray
    tops: npt.NDArray[np.void]
    others: npt.NDArray[np.void]
    flat: FloatArray
    box: FloatArray
    only: FloatArray
    picked: FloatArray
    sides: FloatArray
    point: FloatArray


@compiled(inline=True)
def _of_width(search, table):
    """The search for point loads that read as contacts of one width do."""
    points = search.points
    model = PointModel(points.sensors, points.first, table, points.terms, points.rows, points.bits)
    return Search(model, search.tiles, search.settings)


@compiled(borrows=True)
def _starts(w, search, room, mine, tile, most, share):
    """Best and second-best top of each width into `mine.starts`, the highest first; how many."""
    count, starts, fits, widths, c = 0, mine.starts, room.fits, search.widths, mine.shares
    for j in range(widths.size):
        t = tile + j * (w.size + 2)
        total = taken(mine.single, mine.single, search.tiles, t, c, c)[0]
        best, second = tops_of(w, _of_width(search, search.tables[j]), room, t, total, c, most, share)
        mine.levels[j] = fits[best].explained if best >= 0 else 0.0
        for other in range(2):
            p = second if other else best
            if p < 0:
                continue
            rank = count
            while rank > 0 and starts[rank - 1, 0] < fits[p].explained:
                for k in range(4):
                    starts[rank, k] = starts[rank - 1, k]
                rank -= 1
            starts[rank, 0], starts[rank, 1] = fits[p].explained, fits[p].y
            starts[rank, 2], starts[rank, 3] = fits[p].z, widths[j]
            count += 1
    return count


@compiled(borrows=True)
def _climbed(w, model, settings, mine, count, found):
    """Tops over position and width from the starts that are not near a higher one, behind those `found`: how many."""
    highest, starts, tops, near = 0.0, mine.starts, mine.tops, _NEAR * settings.broad
    for p in range(count):
        y, z, fresh = starts[p, 1], starts[p, 2], starts[p, 0] > 0.8 * highest
        for e in range(p):
            if starts[e, 0] >= 0.0 and abs(y - starts[e, 1]) + abs(z - starts[e, 2]) < near:
                fresh = False
        if not fresh or found == _TOPS:
            starts[p, 0] = -1.0
            continue
        at, ending = RoundAt(y, z, starts[p, 3]), Ending(FINE, 0.0, 0.0, -math.inf)
        climb(w, model, settings.limits, mine.box, at, ending, tops[found], mine.others[0])
        # a moment adds to the tops
        highest = max(highest, tops[found].explained if model.turned.shape[0] == 0 else starts[p, 0])
        found += 1
    return found


@compiled(borrows=True)
def _untwisted(w, model, limits, top, fit, v):
    """What the moment of a top leaves of the readings into v."""
    project(w, model, limits, RoundAt(top.y, top.z, top.q), fit)
    for i in range(w.size):
        v[i] = w[i] - fit.moment * model.rows[MOMENT, i]


@compiled(borrows=True)
def _spread_of_moment(top, g, point, moves, row, at):
    """The covariance of the moment with (y, z, N, Ty, Tz), with the width and with itself into row.

    point: the covariance of these five at one width; moves: how far all six move with a standard deviation of the
    width; g (5,): scratch; at: where the row's covariance begins.
    """
    g[0], g[1], g[2], g[3], g[4] = top.t_y, top.t_z, top.t_n, top.t_ty, top.t_tz
    over = 1.0 / top.square_moment if top.square_moment > 0.0 else math.inf
    own = over
    for j in range(5):
        total = 0.0
        for k in range(5):
            low, high = min(j, k), max(j, k)
            total += point[_POINT + low * (9 - low) // 2 + high] * g[k]
        own += over * over * total * g[j]
        row[at + j * (13 - j) // 2 + 6] = moves[5] * moves[j] - over * total
    row[at + 27] = own + moves[5] * moves[5]


@compiled(inline=True)
def _as_of(found, fit):
    """Of a contact's sums those that a point load there has too."""
    fit.g_n_n, fit.g_n_ty, fit.g_n_tz = found.g_n_n, found.g_n_ty, found.g_n_tz
    fit.g_ty_ty, fit.g_ty_tz, fit.g_tz_tz = found.g_ty_ty, found.g_ty_tz, found.g_tz_tz
    fit.a_y_n, fit.a_y_ty, fit.a_y_tz = found.a_y_n, found.a_y_ty, found.a_y_tz
    fit.a_z_n, fit.a_z_ty, fit.a_z_tz = found.a_z_n, found.a_z_ty, found.a_z_tz
    fit.u_y_y, fit.u_y_z, fit.u_z_z = found.u_y_y, found.u_y_z, found.u_z_z


@compiled(borrows=True)
def _found(w, v, total, search, model, room, mine, row, at):
    """How many tops over position and width there are, in `mine.tops`; 0 where the row says that there is no contact.

    Beside it the tile that was looked at.
    """
    settings, single, tops = search.settings, mine.single, mine.tops
    n, limits, twists = w.size, settings.limits, model.turned.shape[0] > 0
    hot, top = strongest(single, mine.bits, n)
    first = hot if top >= settings.strong * settings.strong else n
    best, count, left, bound = -1, 0, total, settings.largest
    for attempt in range(2):
        tile, few, share = (first, FEW, 0.25) if attempt == 0 else (n + 1, MOST, 0.05)
        begun = _starts(w, search, room, mine, tile, few, share)
        count = _climbed(w, model, settings, mine, begun, 0)
        best, _ = ranked(tops, count, settings.apart)
        if twists and best >= 0:
            _untwisted(w, model, limits, tops[best], mine.others[0], v)
            for i in range(n):
                single[i] = v[i]
            again = n + 1
            if attempt == 0:
                hot, top = strongest(single, mine.bits, n)
                again = hot if top >= settings.strong * settings.strong else n
            begun = _starts(v, search, room, mine, again, few, share)
            count = _climbed(w, model, settings, mine, begun, count)
            best, _ = ranked(tops, count, settings.apart)
            for i in range(n):
                single[i] = w[i]
        left, bound = total, settings.largest
        if best >= 0:
            left = tops[best].left
            bound += settings.error * (tops[best].n ** 2 + tops[best].ty ** 2 + tops[best].tz ** 2)
        if left <= bound:
            break
    row[at.residual] = left
    if left > bound:
        row[at.status] = _UNEXPLAINED
        return 0, first
    if best < 0 or tops[best].explained < settings.detection:
        row[at.status] = _NO_CONTACT
        return 0, first
    count = further_tops(w, model, limits, mine.box, 2.0 * settings.broad, best, count, tops, mine.others[0])
    return count, tile


@compiled(borrows=True)
def _judged(w, v, search, model, room, mine, found):
    """How sure the position and the width of a top are, and their covariance at its width into `mine.point`.

    Where another width, or another position near by, explains more, that becomes the top. Given are the shape of S
    round it, as of `look_round`, and whether the width's interval was found.
    """
    settings, point, more, fit, others = search.settings, mine.point, room.more, room.fits[0], mine.others
    limits, broad, twists, free = settings.limits, settings.broad, model.turned.shape[0] > 0, mine.box[5] > mine.box[4]
    flat, fine = _of_width(search, mine.flat), Ending(FINE, settings.smallest, 0.0, -math.inf)
    shape, told, spread_of = 0, True, point[_POINT:]
    for _ in range(_AGAIN):
        at_width(model, found.q, mine.flat)
        if twists:
            _untwisted(w, model, limits, found, others[0], v)
        climb_point(v, flat.model, limits, settings.box, Point(found.y, found.z), fine, fit, room.fits[1])
        more[0] = more[1] = more[2] = 0.0
        shape = 0
        covariance(fit, limits, more, spread_of)
        spread = widest_variance(point)
        if settings.curved * settings.curved < spread < broad * broad * 100.0:
            shape = look_round(v, v, flat.model, flat, room, fit, point)
        told, at = True, RoundAt(room.trials[1].y, room.trials[1].z, found.q)
        if shape >= 0 and free:
            told = width_profile(w, model, limits, mine.box, found, mine.only, others, mine.sides)
            at = RoundAt(others[0].y, others[0].z, others[0].q)
        if shape >= 0 and told:
            break
        climb(w, model, limits, mine.box, at, Ending(FINE, 0.0, 0.0, -math.inf), others[0], others[1])
        if others[0].explained > found.explained:
            keep(others[0], found)
    return shape, told


@compiled(borrows=True)
def _rival(tops, best, count, settings, row, at, twists):
    """Fill the row's rival, and say whether it explains about as well."""
    found, (_, second) = tops[best], ranked(tops, count, settings.apart)
    if second < 0:
        return False
    other, rival = tops[second], row[at.rival :]
    rival[0], rival[1], rival[5] = other.y, other.z, math.sqrt(other.q)
    rival[2], rival[3], rival[4] = other.n, other.ty, other.tz
    if twists:
        rival[6] = other.moment
    row[at.rival_chi2] = max(found.explained - other.explained, 0.0)
    return row[at.rival_chi2] < settings.ambiguity


@compiled(borrows=True)
def _frame(w, v, search, beyond, model, room, mine, row, at):
    """Fill the row of a frame."""
    settings, single, tops, point, fit, sides = (
        search.settings, mine.single, mine.tops, mine.point, room.fits[0], mine.sides
    )  # fmt: skip
    n, limits, box, broad = w.size, settings.limits, mine.box, settings.broad
    free, twists = box[5] > box[4], model.turned.shape[0] > 0
    total = 0.0
    for i in range(n):
        total += w[i] * w[i]
    count, tile = _found(w, v, total, search, model, room, mine, row, at)
    if count == 0:
        return
    best, _ = ranked(tops, count, settings.apart)
    found = tops[best]
    shape, told = _judged(w, v, search, model, room, mine, found)
    status = _OK if told and (shape == 0 or shape == 1) and n > 5 + free + twists else _AMBIGUOUS
    top = fit.explained
    if twists:  # what the readings say of position and forces where the moment is not known
        _as_of(found, fit)
    covariance(fit, limits, room.more, point[_POINT:])
    half, width_std, interval = math.sqrt(found.q), 0.0, row[at.interval :]
    interval[0] = interval[1] = half
    if free:
        low, high = math.sqrt(min(sides[0, 6], found.q)), math.sqrt(max(sides[1, 6], found.q))
        interval[0], interval[1], width_std = low, high, (high - low) / (2.0 * 1.959964)
        if found.q >= box[5] or (box[4] > 0.0 and found.q <= box[4]):
            status = _AMBIGUOUS
    if twists:
        _spread_of_moment(found, mine.only, point, sides[2], row, at.covariance)
        row[6], row[at.covariance + 26] = found.moment, sides[2, 5] * width_std
    at_point, at_round = _POINT, at.covariance
    for j in range(5):
        for k in range(j, 5):
            if free:
                point[at_point] += sides[2, j] * sides[2, k]
            row[at_round] = point[at_point]
            at_point, at_round = at_point + 1, at_round + 1
        row[at_round] = sides[2, j] * width_std if free else 0.0
        at_round += 1 + twists
    row[at_round] = width_std * width_std
    row[at.residual] = found.left
    row[0], row[1], row[5] = found.y, found.z, half
    row[2], row[3], row[4] = found.n, found.ty, found.tz
    if _rival(tops, best, count, settings, row, at, twists):
        status = _AMBIGUOUS
    margin, ends = 2.0 * settings.apart, settings.box
    if not (ends[0] + margin < found.y < ends[1] - margin and ends[2] + margin < found.z < ends[3] - margin):
        status = _AMBIGUOUS
    spread = widest_variance(point)
    if unsure(fit, point, spread, ends):
        status = _AMBIGUOUS
    for j in range(7 if twists else 0):  # where the moment leaves a combination open, rounding may be less than 0
        own = at.covariance + j * (15 - j) // 2
        if j != 5 and not row[own] > 0.0 and not (limits.friction == 0.0 and 2 < j < 5):
            row[own], status = math.inf, _AMBIGUOUS
    if status == _OK and 6.0 * math.sqrt(spread) > broad:
        nearest, widths = 0, search.widths
        for j in range(widths.size):
            if abs(widths[j] - found.q) < abs(widths[nearest] - found.q):
                nearest = j
        explained, here = min(mine.levels[nearest], found.explained), Point(found.y, found.z)
        if twists:
            near = _of_width(search, search.tables[nearest]).model
            fine = Ending(FINE, settings.smallest, 0.0, -math.inf)
            climb_point(v, near, limits, ends, here, fine, fit, room.fits[1])
            explained = min(fit.explained, top)
        finest = (nearest + 1) * (n + 2) - 1
        if is_broad(v, search.tiles, finest, here, explained, point, spread, settings):
            status = _AMBIGUOUS
    if status == _OK:
        least = found.explained - settings.ambiguity
        seen = 0.0 if twists else least
        if contact_outside(w, single, model, limits, beyond, min(tile, n), search.far, seen, least, mine, mine.others):
            status = _AMBIGUOUS
    row[at.status] = status


@compiled(borrows=True)
def _each(readings, rows, search, beyond, model, room, mine, at, out):
    """As `project_round`, with its scratch."""
    n = readings.shape[1]
    w = mine.full[:n]
    v = mine.bare[:n] if model.turned.shape[0] > 0 else w
    for f in range(readings.shape[0]):
        row = out[f]
        total = whitened(readings[f], rows, mine.full, mine.single)
        for i in range(row.size):
            row[i] = math.nan
        row[at.rival_chi2] = math.inf
        if total < MOST_CHI2:
            _frame(w, v, search, beyond, model, room, mine, row, at)
        else:
            row[at.status] = _PENDING


@compiled(frames="readings")
def project_round(readings, rows, search, beyond, sizes, out):
    """Fill `out`, one row a frame, as `project.project_frames` does, in the columns of `ROUND`, or of `TWIST`.

    search: a `RoundSearch` without the scratch of its models; sizes: as of `project_frames`; without their names.
    """
    n, (widest, lead) = readings.shape[1], (sizes[0], sizes[1])
    its_contact, its_points, tables, squares, far, both, tiles, settings = search
    known = named_settings(settings)
    points, contact, ends = PointModel(*its_points), in_room(RoundModel(*its_contact)), known.box
    scratch, single, widths = np.empty((ROWS, n + 1)), np.zeros(n + 1, dtype=np.float32), squares.size
    mine = PointModel(points.sensors, points.first, points.table, points.terms, scratch, scratch.view(np.int64))
    whole = RoundSearch(contact, mine, tables, squares, far, both, Tiles(*tiles), known)
    box = np.array([ends[0], ends[1], ends[2], ends[3], both[0], both[1]])
    own = _RoundRoom(
        np.zeros(n + 1), single, single.view(np.int32), np.empty(n + 1),
        np.empty(3 * widest + 2 * n + 4, dtype=np.float32), np.empty(widest, dtype=np.float32),
        np.empty((2 * widths, 4)), np.empty(widths), np.empty(_TOPS + MORE, FIT), np.empty(2, FIT),
        np.empty((contact.sums.shape[0], contact.sums.shape[1])), box, np.empty(6), np.empty((4, 4)),
        np.zeros((3, 7)), np.empty(_POINT_COLUMNS),
    )  # fmt: skip
    at = _TWISTED if contact.turned.shape[0] > 0 else _PLAIN
    _each(readings, rows, whole, named_beyond(beyond), contact, room_of(widest, lead, n), own, at, out)
