"""The compiled heart of `fit` on an area: a round contact of some half width, one frame at a time.

For each of some widths the scan and the climb of point loads (`project.py`), whose table is then that of the width;
from their tops a climb over the width as well (`round_contact.py`). At the best width the contact is judged as a point
load is; the interval of the width is where chi-square rises by 1.96^2, all else fitted anew (`round_judge.py`), and
what the other unknowns do there is what the width adds to their covariance. Where a moment is fitted, the scans do not
know of it: then a second search follows on what it leaves of the readings, and the contact is judged on these.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..layout import AREA, TWIST
from ..varpro import Ending
from .fall import look_round, widest_variance
from .judge import FINE, MOST, Search, Settings, is_broad, tops_of, unsure
from .point import Point, PointModel, covariance, in_room
from .point import climb as climb_point
from .project import FEW, MOST_CHI2, named_beyond, named_settings, room_of
from .round_contact import FIT, MOMENT, RoundAt, RoundModel, at_width, climb, keep, project
from .round_contact import in_room as contact_in_room
from .round_judge import (
    END,
    HIGH,
    LOW,
    MORE,
    MOVES,
    TURN,
    contact_outside,
    further_tops,
    ranked,
    uphill,
    width_profile,
)  # fmt: skip
from .scan import strongest, taken, whitened
from .tiles import Tiles

_TOPS = 8
"""Tops over position and width that are climbed to from the scan."""
_AGAIN = 3
_NEAR = 2.5
"""How near one start of a climb stands for another, over the width from which a profile counts as broad."""
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_UNKNOWNS = TWIST.unknowns
_Y, _Z, _N, _TY, _TZ, _HALF, _TWIST = range(_UNKNOWNS)
_LEAST, _MOST, _RESIDUAL = TWIST.interval, TWIST.interval + 1, TWIST.residual
_RIVAL, _RIVAL_CHI2, _STATUS = TWIST.rival, TWIST.rival_chi2, TWIST.status
_SQUARE, _OF_POINT = TWIST.square, AREA.square - AREA.covariance
"""Where a row has the covariance of two unknowns, and where that of a point load has it."""
_SURE = 2.0 * 1.959964


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
    shares: of the nodes of a tile; starts (2 widths, 4): S, y, z, q; levels (widths,): S of the best top of each width;
    tops, others: fits; flat: a table of point loads; box, only (6,): ends of y, z and q; sides (3, MOVES); spread:
    the covariance of a point load; tried, kept: as of `judge.best_beyond`.
    """

    full: FloatArray
    single: npt.NDArray[np.float32]
    bits: npt.NDArray[np.int32]
    bare: FloatArray
    shares: npt.NDArray[np.float32]
    starts: FloatArray
    levels: FloatArray
    tops: npt.NDArray[np.void]
    others: npt.NDArray[np.void]
    flat: FloatArray
    box: FloatArray
    only: FloatArray
    sides: FloatArray
    spread: FloatArray
    tried: npt.NDArray[np.float32]
    kept: npt.NDArray[np.int64]


@compiled(inline=True)
def _of_width(search, table):
    """The search for point loads that read as contacts of one width do."""
    return Search(PointModel(*search.points[:2], table, *search.points[3:]), search.tiles, search.settings)


@compiled(borrows=True)
def _starts(w, search, room, mine, rough):
    """Best and second-best top of each width into `mine.starts`: how many. Of readings that name a sensor its tile.

    Unless `rough`, of the finest tile.
    """
    single, starts, fits, widths, c, n = mine.single, mine.starts, room.fits, search.widths, mine.shares, w.size
    for i in range(n):
        single[i] = w[i]
    tile, most, share, count = n + 1, MOST, 0.05, 0
    if rough:
        hot, top = strongest(single, mine.bits, n)
        tile, most, share = hot if top >= search.settings.strong**2 else n, FEW, 0.25
    mine.kept[0, 0] = min(tile, n)
    for j in range(widths.size):
        t = tile + j * (n + 2)
        total = taken(single, single, search.tiles, t, c, c)[0]
        best, second = tops_of(w, _of_width(search, search.tables[j]), room, t, total, c, most, share)
        mine.levels[j] = fits[best].explained if best >= 0 else 0.0
        for p in (best, second):
            if p >= 0:
                starts[count, 0], starts[count, 1] = fits[p].explained, fits[p].y
                starts[count, 2], starts[count, 3] = fits[p].z, widths[j]
                count += 1
    return count


@compiled(borrows=True)
def _climbed(w, model, settings, mine, count, found):
    """Tops over position and width from the starts that are not near a higher one, behind those `found`: how many."""
    highest, starts, tops, near = 0.0, mine.starts, mine.tops, _NEAR * settings.broad
    for p in range(count):
        for e in range(p + 1, count):  # the highest first
            if starts[e, 0] > starts[p, 0]:
                for k in range(4):
                    starts[p, k], starts[e, k] = starts[e, k], starts[p, k]
        y, z, fresh = starts[p, 1], starts[p, 2], starts[p, 0] > 0.8 * highest
        for e in range(p):
            if starts[e, 0] >= 0.0 and abs(y - starts[e, 1]) + abs(z - starts[e, 2]) < near:
                fresh = False
        if not fresh or found == _TOPS:
            starts[p, 0] = -1.0
            continue
        at = RoundAt(y, z, starts[p, 3])
        climb(w, model, settings.limits, mine.box, at, uphill(FINE), tops[found], mine.others[0])
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
def _found(w, v, search, model, room, mine, row):
    """How many tops over position and width are in `mine.tops`; 0 where the row says that there is no contact."""
    settings, tops, twists, total = search.settings, mine.tops, model.turned.shape[0] > 0, 0.0
    for i in range(w.size):
        total += w[i] * w[i]
    best, count, left, bound = -1, 0, total, settings.largest
    for attempt in range(2):
        count = _climbed(w, model, settings, mine, _starts(w, search, room, mine, attempt == 0), 0)
        best, _ = ranked(tops, count, settings.apart)
        if twists and best >= 0:
            tile = mine.kept[0, 0]
            _untwisted(w, model, settings.limits, tops[best], mine.others[0], v)
            count = _climbed(w, model, settings, mine, _starts(v, search, room, mine, attempt == 0), count)
            mine.kept[0, 0] = tile
            best, _ = ranked(tops, count, settings.apart)
        left, bound = total, settings.largest
        if best >= 0:
            left = tops[best].left
            bound += settings.error * (tops[best].n ** 2 + tops[best].ty ** 2 + tops[best].tz ** 2)
        if left <= bound:
            break
    row[_RESIDUAL] = left
    if left > bound or best < 0 or tops[best].explained < settings.detection:
        row[_STATUS] = _UNEXPLAINED if left > bound else _NO_CONTACT
        return 0
    return further_tops(w, model, settings.limits, mine.box, 2.0 * settings.broad, best, count, tops, mine.others[0])


@compiled(borrows=True)
def _judged(w, v, search, model, room, mine, found):
    """How sure the position and the width of a top are, and their covariance at its width into `mine.spread`.

    Where another width, or another position near by, explains more, that becomes the top. Given are the shape of S
    round it, as of `look_round`, and whether the width's interval was found.
    """
    settings, spread, more, fit, others = search.settings, mine.spread, room.more, room.fits[0], mine.others
    limits, broad, free = settings.limits, settings.broad, mine.box[HIGH] > mine.box[LOW]
    flat, shape, told = _of_width(search, mine.flat), 0, True
    fine = Ending(FINE, settings.smallest, 0.0, -math.inf)
    for _ in range(_AGAIN):
        at_width(model, found.q, mine.flat)
        if model.turned.shape[0] > 0:
            _untwisted(w, model, limits, found, others[0], v)
        climb_point(v, flat.model, limits, settings.box, Point(found.y, found.z), fine, fit, room.fits[1])
        more[0] = more[1] = more[2] = 0.0
        shape = 0
        covariance(fit, limits, more, spread)
        if settings.curved * settings.curved < widest_variance(spread) < broad * broad * 100.0:
            shape = look_round(v, v, flat.model, flat, room, fit, spread)
        told, at = True, RoundAt(room.trials[1].y, room.trials[1].z, found.q)
        if shape >= 0 and free:
            told = width_profile(w, model, limits, mine.box, found, mine.only, others, mine.sides)
            at = RoundAt(others[0].y, others[0].z, others[0].q)
        if shape >= 0 and told:
            break
        climb(w, model, limits, mine.box, at, uphill(FINE), others[0], others[1])
        if others[0].explained > found.explained:
            keep(others[0], found)
    return shape, told


@compiled(inline=True)
def _as_of(found, fit):
    """Of a contact's sums those that a point load there has too."""
    fit.g_n_n, fit.g_n_ty, fit.g_n_tz = found.g_n_n, found.g_n_ty, found.g_n_tz
    fit.g_ty_ty, fit.g_ty_tz, fit.g_tz_tz = found.g_ty_ty, found.g_ty_tz, found.g_tz_tz
    fit.a_y_n, fit.a_y_ty, fit.a_y_tz = found.a_y_n, found.a_y_ty, found.a_y_tz
    fit.a_z_n, fit.a_z_ty, fit.a_z_tz = found.a_z_n, found.a_z_ty, found.a_z_tz
    fit.u_y_y, fit.u_y_z, fit.u_z_z = found.u_y_y, found.u_y_z, found.u_z_z


@compiled(borrows=True)
def _covariance(found, spread, moves, width_std, g, row):
    """The covariance of all unknowns into the row, and what the width adds to that of a point load into `spread`.

    The moment's goes with (y, z, N, Ty, Tz) at one width, whose covariance `spread` is at first. moves: how far the
    others move with a standard deviation of the width; g: scratch.
    """
    g[0], g[1], g[2], g[3], g[4] = found.t_y, found.t_z, found.t_n, found.t_ty, found.t_tz
    own = over = 1.0 / found.square_moment if found.square_moment > 0.0 else math.inf
    for j in range(5):
        total = 0.0
        for k in range(5):
            total += spread[_OF_POINT[j, k]] * g[k]
        own += over * over * total * g[j]
        row[_SQUARE[j, _TWIST]] = moves[TURN] * moves[j] - over * total
    row[_SQUARE[_TWIST, _TWIST]] = own + moves[TURN] * moves[TURN]
    for j in range(5):
        for k in range(j, 5):
            spread[_OF_POINT[j, k]] += moves[j] * moves[k]
            row[_SQUARE[j, k]] = spread[_OF_POINT[j, k]]
        row[_SQUARE[j, _HALF]] = moves[j] * width_std
    row[_SQUARE[_HALF, _TWIST]], row[_SQUARE[_HALF, _HALF]] = moves[TURN] * width_std, width_std * width_std


@compiled(borrows=True)
def _rival(tops, best, count, settings, row):
    """Fill the row's rival, and say whether it explains about as well."""
    found, (_, second) = tops[best], ranked(tops, count, settings.apart)
    if second < 0:
        return False
    other, rival = tops[second], row[_RIVAL:]
    rival[_Y], rival[_Z], rival[_HALF], rival[_TWIST] = other.y, other.z, math.sqrt(other.q), other.moment
    rival[_N], rival[_TY], rival[_TZ] = other.n, other.ty, other.tz
    row[_RIVAL_CHI2] = max(found.explained - other.explained, 0.0)
    return row[_RIVAL_CHI2] < settings.ambiguity


@compiled(borrows=True)
def _frame(w, v, search, beyond, model, room, mine, row):
    """Fill the row of a frame."""
    settings, tops, spread, fit, sides = search.settings, mine.tops, mine.spread, room.fits[0], mine.sides
    n, limits, box, broad = w.size, settings.limits, mine.box, settings.broad
    free, twists = box[HIGH] > box[LOW], model.turned.shape[0] > 0
    count = _found(w, v, search, model, room, mine, row)
    if count == 0:
        return
    best, _ = ranked(tops, count, settings.apart)
    found = tops[best]
    shape, told = _judged(w, v, search, model, room, mine, found)
    status = _OK if told and (shape == 0 or shape == 1) and n > 5 + free + twists else _AMBIGUOUS
    top = fit.explained
    if twists:  # what the readings say of position and forces where the moment is not known
        _as_of(found, fit)
    covariance(fit, limits, room.more, spread)
    half, width_std = math.sqrt(found.q), 0.0
    row[_LEAST] = row[_MOST] = half
    if free:
        row[_LEAST], row[_MOST] = math.sqrt(min(sides[0, END], found.q)), math.sqrt(max(sides[1, END], found.q))
        width_std = (row[_MOST] - row[_LEAST]) / _SURE
        if found.q >= box[HIGH] or (box[LOW] > 0.0 and found.q <= box[LOW]):
            status = _AMBIGUOUS
    _covariance(found, spread, sides[2], width_std, mine.only, row)
    row[_RESIDUAL], row[_Y], row[_Z], row[_HALF], row[_TWIST] = found.left, found.y, found.z, half, found.moment
    row[_N], row[_TY], row[_TZ] = found.n, found.ty, found.tz
    if _rival(tops, best, count, settings, row):
        status = _AMBIGUOUS
    margin, ends = 2.0 * settings.apart, settings.box
    if not (ends[0] + margin < found.y < ends[1] - margin and ends[2] + margin < found.z < ends[3] - margin):
        status = _AMBIGUOUS
    widest = widest_variance(spread)
    if unsure(fit, spread, widest, ends):
        status = _AMBIGUOUS
    for j in range(_UNKNOWNS if twists else 0):
        # where the moment leaves a combination open, rounding may be less than 0
        if j != _HALF and not row[_SQUARE[j, j]] > 0.0 and not (limits.friction == 0.0 and _TY <= j <= _TZ):
            row[_SQUARE[j, j]], status = math.inf, _AMBIGUOUS
    if status == _OK and 6.0 * math.sqrt(widest) > broad:
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
        if is_broad(v, search.tiles, finest, here, explained, spread, widest, settings):
            status = _AMBIGUOUS
    if status == _OK:
        least = found.explained - settings.ambiguity
        seen = 0.0 if twists else least
        if contact_outside(w, model, limits, beyond, search.far, seen, least, mine, room):
            status = _AMBIGUOUS
    row[_STATUS] = status


@compiled(borrows=True)
def _each(readings, rows, search, beyond, model, room, mine, out):
    """As `project_round`, with its scratch."""
    n = readings.shape[1]
    w = mine.full[:n]
    v = mine.bare[:n] if model.turned.shape[0] > 0 else w
    for f in range(readings.shape[0]):
        row = out[f]
        total = whitened(readings[f], rows, mine.full, mine.single)
        for i in range(row.size):
            row[i] = math.nan
        row[_RIVAL_CHI2] = math.inf
        if total < MOST_CHI2:
            _frame(w, v, search, beyond, model, room, mine, row)
        else:
            row[_STATUS] = _PENDING


@compiled(frames="readings")
def project_round(readings, rows, search, beyond, sizes, out):
    """Fill `out`, one row a frame, as `project.project_frames` does, in the columns of `TWIST`.

    search: a `RoundSearch` without the scratch of its models; sizes: as of `project_frames`; without their names.
    """
    n, (widest, lead) = readings.shape[1], (sizes[0], sizes[1])
    single, kept = np.zeros(n + 1, dtype=np.float32), np.zeros((1, 2), dtype=np.int64)
    kept[0, 1] = 1  # the nodes of one sensor, for the one frame
    its_contact, points, tables, squares, far, both, tiles, settings = search
    contact, known = contact_in_room(RoundModel(*its_contact)), named_settings(settings)
    whole = RoundSearch(contact, in_room(points, n), tables, squares, far, both, Tiles(*tiles), known)
    ends = known.box
    box = np.array([ends[0], ends[1], ends[2], ends[3], both[0], both[1]])
    own = _RoundRoom(
        np.zeros(n + 1), single, single.view(np.int32), np.empty(n + 1),
        np.empty(3 * widest + 2 * n + 4, dtype=np.float32), np.empty((2 * squares.size, 4)), np.empty(squares.size),
        np.zeros(_TOPS + MORE, FIT), np.zeros(2, FIT), np.empty((contact.sums.shape[0], contact.sums.shape[1])), box,
        np.empty(6), np.zeros((3, MOVES)), np.empty(15), np.empty(widest, dtype=np.float32), kept,
    )  # fmt: skip
    _each(readings, rows, whole, named_beyond(beyond), contact, room_of(widest, lead, n), own, out)
