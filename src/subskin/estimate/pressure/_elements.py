"""Elements of the surface, compiled: columns, Hessian and gradient, of thousands of which a touch needs some dozens.

Elements stand on lines, on a row of sensors on one. Each has one height, its pressure, or three, its pressure and its
drags. The row of sensors and the area differ in what `Level` holds, and in nothing else.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ._algebra import multiply
from ._windows import windows
from .hats import AT_ONCE, LANES, REGISTERS, Hats

_SINGLE = 2e-5  # error of a slope in single precision, of the largest column times the residual

DRAGS, COLUMNS, PRODUCTS, AWAY, SHORT, SINGLE = 0, 1, 2, 3, 4, 5
"""What `Work.taken` counts: rows of drags, columns, columns that are multiplied, and directions in which x stays.

And it says whether there was no room for a column, and whether products are made in single precision.
"""


class Level(NamedTuple):
    """Elements of one size: N on `ny` lines of `nz`.

    Parameters
    ----------
    parts : ndarray, shape (1 to 3, L)
        Tables of what sensors read per Pa of pressure, and of drags along y and z, in a line (`hats.Hats.flat`).
    start, gain : ndarray, shape (n,)
        Where a sensor's table begins in it, and by what it is multiplied; up to a multiple of `AT_ONCE` sensors.
    length : int
        Of a row of the tables.
    stencil : ndarray, shape (2, 2)
        Smoothness K between elements so many apart, in lines and along them.
    ny, nz : int
        Lines, and elements on each.
    cost : ndarray, shape (N,)
        Slope of J by the least force.
    largest : float
        The largest column.
    """

    parts: FloatArray
    start: npt.NDArray[np.int64]
    gain: FloatArray
    length: int
    stencil: FloatArray
    ny: int
    nz: int
    cost: FloatArray
    largest: float

    @classmethod
    def of(cls, hats: Hats, scales: tuple[float, ...], stencil: FloatArray, pull: float, friction: float) -> Level:
        """Elements with as many tractions as there are `scales`, of which each is one; pull: the cost of an element."""
        parts, start, length = hats.flat(len(scales))
        more = -start.size % AT_ONCE
        start, gain = np.pad(start, (0, more)), np.pad(hats.gain, (0, more))
        ny, nz = hats.shape
        largest = max(1.0, friction) * float(
            np.max(sum(np.linalg.norm(hats.columns(i), axis=1) for i in range(len(scales))))
        )
        scaled = np.ascontiguousarray(parts * np.array(scales)[:, None])
        return cls(scaled, start, gain, length, stencil, ny, nz, np.full(ny * nz, pull), largest)


class Work(NamedTuple):
    """What the loops fill, of n sensors, with room for C columns of elements with h heights, up to N.

    Parameters
    ----------
    lines, single : ndarray, shape (h, L)
        Tables at the drag, and the same in single precision.
    x, slope, spread : ndarray, shape (h, N)
        Heights, gradient of J, and what of it is cost and smoothness.
    residual : ndarray, shape (n,)
        A x - b.
    lower : ndarray, shape (h C, h C)
        Factor of the Hessian.
    listed, z, half : ndarray, shapes (N,), (h N,) and (h N,)
        Numbers of the elements in the factor, values of theirs, and the same times L^T.
    rows, drags : ndarray, shapes (N,) and (0 to 2, C, n)
        In which row of the drags' columns an element is, -1 for none; these columns, in single precision.
    order, columns, short, products : ndarray, shapes (N,), (h C, n), (h C, n) and (h C, h C)
        In which column at the drag an element is, -1 for none; these, also in single precision, and their products.
    taken : ndarray, shape (6,)
        How many there are of each: `DRAGS`, `COLUMNS`, `PRODUCTS`, `AWAY`; and `SHORT`, `SINGLE`.
    slot : ndarray, shape (N,)
        Scratch.
    away : ndarray, shape (C, C)
        Directions in which x stays.
    pull, field : ndarray, shapes (n,) and (LANES REGISTERS,)
        Scratch in single precision.
    """

    lines: FloatArray
    single: npt.NDArray[np.float32]
    x: FloatArray
    slope: FloatArray
    spread: FloatArray
    residual: FloatArray
    lower: FloatArray
    listed: npt.NDArray[np.int64]
    z: FloatArray
    half: FloatArray
    rows: npt.NDArray[np.int64]
    drags: npt.NDArray[np.float32]
    order: npt.NDArray[np.int64]
    columns: FloatArray
    short: npt.NDArray[np.float32]
    products: FloatArray
    taken: npt.NDArray[np.int64]
    slot: npt.NDArray[np.int64]
    away: FloatArray
    pull: npt.NDArray[np.float32]
    field: npt.NDArray[np.float32]

    @classmethod
    def of(cls, level: Level, sensors: int, room: int, heights: int) -> Work:
        """With room for the columns of so many elements; with three heights the tables stay, and with one they lean."""
        total = level.cost.size
        room = min(room, total)
        rows, single, whole = heights * room, np.float32, np.int64
        lines = level.parts if heights > 1 else level.parts[:1].copy()
        leans = 0 if heights > 1 else len(level.parts) - 1
        return cls(
            lines, lines.astype(single), np.empty((heights, total)), np.empty((heights, total)),
            np.empty((heights, total)), np.empty(sensors), np.empty((rows, rows)),
            np.empty(total, whole), np.empty(heights * total), np.empty(heights * total),
            np.full(total, -1, whole), np.empty((leans, room, sensors), single),
            np.full(total, -1, whole), np.empty((rows, sensors)), np.empty((rows, sensors), single),
            np.empty((rows, rows)), np.zeros(6, whole), np.empty(total, whole), np.empty((room, room)),
            np.empty(level.gain.size, single), np.empty(LANES * REGISTERS, single),
        )  # fmt: skip


@compiled(borrows=True)
def lean(level, t, work):
    """Go to the drag t, where there is one: columns at another one, and their products, no longer hold."""
    parts, line, single, order = level.parts, work.lines[0], work.single[0], work.order
    if parts.shape[0] == 1:
        return
    if parts.shape[0] == 2:
        for i in range(line.size):
            line[i] = parts[0, i] + t[0] * parts[1, i]
    else:
        for i in range(line.size):
            line[i] = parts[0, i] + t[0] * parts[1, i] + t[1] * parts[2, i]
    for i in range(line.size):
        single[i] = line[i]
    for j in range(order.size):
        order[j] = -1
    work.taken[COLUMNS] = work.taken[PRODUCTS] = 0


@compiled(borrows=True)
def forget(work):
    """Take no columns as known; where none lean, only when half the room is taken: they hold for all frames."""
    room = work.columns.shape[0] // work.x.shape[0]
    if work.drags.shape[0] == 0 and (room == work.order.size or 2 * work.taken[COLUMNS] < room):
        return
    for j in range(work.rows.size):
        work.rows[j] = work.order[j] = -1
    for k in range(work.taken.size):
        work.taken[k] = 0


@compiled(borrows=True)
def make_exact(work):
    """Take no products as known, and make them in double precision."""
    work.taken[PRODUCTS] = work.taken[SINGLE] = 0


@compiled(borrows=True)
def crowded(work):
    """Whether there was no room for all columns that were asked for."""
    return work.taken[SHORT] > 0


@compiled(borrows=True)
def gather(level, work, count):
    """The columns at the drag of the listed elements; False without room."""
    start, gain, taken, columns, drags = level.start, level.gain, work.taken, work.columns, work.drags
    heights, n = work.x.shape[0], work.columns.shape[1]
    room = columns.shape[0] // heights
    for k in range(count):
        j = work.listed[k]
        if work.order[j] >= 0:
            continue
        first = j // level.nz * level.length + j % level.nz
        if work.rows[j] < 0:
            row = taken[DRAGS]
            if row == room:
                taken[SHORT] = 1
                return False
            work.rows[j], taken[DRAGS] = row, row + 1
            for part in range(drags.shape[0]):
                for i in range(n):
                    drags[part, row, i] = gain[i] * level.parts[part + 1, start[i] + first]
        at = taken[COLUMNS]
        work.order[j], taken[COLUMNS] = at, at + 1
        for part in range(heights):
            line, column = work.lines[part], columns[heights * at + part]
            for i in range(n):
                column[i] = gain[i] * line[start[i] + first]
    return True


@compiled(borrows=True)
def multiplied(work):
    """Make the products of the columns that have none."""
    heights = work.x.shape[0]
    first, last = heights * work.taken[PRODUCTS], heights * work.taken[COLUMNS]
    if work.taken[SINGLE] == 0:
        multiply(work.columns, work.products, first, last)
    elif first < last:
        for at in range(first, last):
            for i in range(work.columns.shape[1]):
                work.short[at, i] = work.columns[at, i]
        multiply(work.short, work.products, first, last)
    work.taken[PRODUCTS] = work.taken[COLUMNS]


@compiled(borrows=True)
def hessian(level, w, work, count):
    """The Hessian of the listed pressures into the factor, up to its diagonal; False where there is no room."""
    stencil, nz, index, slot = level.stencil, level.nz, work.listed, work.slot
    if count > len(work.lower):
        work.taken[SHORT] = 1
        return False
    if not gather(level, work, count):
        return False
    multiplied(work)
    for i in range(count):
        slot[i] = work.order[index[i]]
    before = 0
    for i in range(count):
        a, row, part = index[i], work.lower[i], work.products[slot[i]]
        for k in range(i + 1):
            row[k] = part[slot[k]]
        # index ascends: neighbours before a are a itself, the one on its left, and three in the line before
        row[i] += w * stencil[0, 0]
        z = a % nz
        if z > 0 and i > 0 and index[i - 1] == a - 1:
            row[i - 1] += w * stencil[0, 1]
        while index[before] < a - nz - 1:
            before += 1
        for k in range(before, min(before + 3, i)):
            apart = index[k] - (a - nz)
            if apart <= 1 and 0 <= z + apart < nz:
                row[k] += w * stencil[1, abs(apart)]
    return True


@compiled(borrows=True)
def steepest(level, slope, j):
    """Whether no neighbour of the element j has a lesser slope.

    Elements are taken one in a neighbourhood: what lies about one that is taken mostly comes right with it, and would
    else have to be let go again.
    """
    nz = level.nz
    y, z = j // nz, j % nz
    for dy in range(-1, 2):
        for dz in range(-1, 2):
            if 0 <= y + dy < level.ny and 0 <= z + dz < nz and slope[j + dy * nz + dz] < slope[j]:
                return False
    return True


@compiled(borrows=True)
def _seen(level, line, r, j):
    """The column of the element j, from a line of the tables, times r (n,)."""
    start, gain = level.start, level.gain
    at, s = j // level.nz * level.length + j % level.nz, 0.0
    for i in range(r.size):
        s += gain[i] * r[i] * line[start[i] + at]
    return s


@compiled(borrows=True)
def roughly(level, work, part, r, out):
    """Add to `out` (N,) every column of a part, in single precision, times r (n,); how far that may be off."""
    start, nz, line, pull, field = level.start, level.nz, work.single[part], work.pull, work.field
    size = 0.0
    for i in range(r.size):
        size += r[i] * r[i]
    size = math.sqrt(size)
    if size == 0.0:
        return 0.0
    for i in range(pull.size):
        pull[i] = level.gain[i] * r[i] / size if i < r.size else 0.0
    for y in range(level.ny):
        for z in range(0, nz, LANES * REGISTERS):
            many = min(nz - z, LANES * REGISTERS)
            windows(line, start, pull, y * level.length + z, (many + LANES - 1) // LANES, field)
            for k in range(many):
                out[y * nz + z + k] += size * np.float64(field[k])
    return _SINGLE * size * level.largest


@compiled(borrows=True)
def residual(b, work):
    """A x - b; the columns of all that is not 0 are gathered."""
    x, r, columns, slot, heights = work.x, work.residual, work.columns, work.slot, work.x.shape[0]
    for i in range(r.size):
        r[i] = -b[i]
    many = 0
    for j in range(x.shape[1]):
        slot[many] = j
        many += x[0, j] != 0.0
    for part in range(heights):
        for k in range(0, many, 4):  # four columns at once: r is fetched a quarter as often
            last = many - 1
            a, c, d, e = slot[k], slot[min(k + 1, last)], slot[min(k + 2, last)], slot[min(k + 3, last)]
            one, two = columns[heights * work.order[a] + part], columns[heights * work.order[c] + part]
            three, four = columns[heights * work.order[d] + part], columns[heights * work.order[e] + part]
            p, q = x[part, a], x[part, c] if k + 1 < many else 0.0
            u, v = x[part, d] if k + 2 < many else 0.0, x[part, e] if k + 3 < many else 0.0
            for i in range(r.size):
                r[i] += p * one[i] + q * two[i] + (u * three[i] + v * four[i])


@compiled(inline=True)
def falls(slope, j):
    """How steeply J falls where an element that is 0 is taken in, in the best direction within its cone."""
    return -slope[0, j] if slope.shape[0] == 1 else math.hypot(slope[1, j], slope[2, j]) - slope[0, j]


@compiled(borrows=True)
def slopes(level, w, work):
    """The gradient of J at the residual; the columns of all that is not 0 are gathered.

    Where an element is not > 0, and it is plain whether J falls there, single precision is enough.
    """
    stencil, ny, nz = level.stencil, level.ny, level.nz
    x, slope, r, spread = work.x, work.slope, work.residual, work.spread
    heights, total = x.shape
    for part in range(heights):
        for j in range(total):
            spread[part, j] = level.cost[j] if part == 0 else 0.0
    for j in range(total):
        if x[0, j] == 0.0:
            continue
        y, z = j // nz, j % nz
        for dy in range(-1, 2):
            for dz in range(-1, 2):
                if 0 <= y + dy < ny and 0 <= z + dz < nz:
                    for part in range(heights):
                        spread[part, j + dy * nz + dz] += w * stencil[abs(dy), abs(dz)] * x[part, j]
    doubt = 0.0
    for part in range(heights):
        for j in range(total):
            slope[part, j] = spread[part, j]
        doubt += roughly(level, work, part, r, slope[part])
    for j in range(total):
        if x[0, j] != 0.0:
            for part in range(heights):
                column, s = work.columns[heights * work.order[j] + part], spread[part, j]
                for i in range(r.size):
                    s += column[i] * r[i]
                slope[part, j] = s
        elif abs(falls(slope, j)) <= doubt:
            for part in range(heights):
                slope[part, j] = spread[part, j] + _seen(level, work.lines[part], r, j)


@compiled(borrows=True)
def least(level, work):
    """J, after `residual` and `slopes`."""
    x, spread = work.x, work.spread
    value = 0.0
    for i in range(work.residual.size):
        value += work.residual[i] * work.residual[i]
    for part in range(x.shape[0]):
        for j in range(x.shape[1]):
            value += x[part, j] * spread[part, j]
    for j in range(x.shape[1]):
        value += level.cost[j] * x[0, j]
    return 0.5 * value
