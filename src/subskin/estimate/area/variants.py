"""Compiled: readings of a point load, or of a round touch, by fingers that are not quite their drawing.

From a load to the best one by all errors (`estimate/settle.py`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..settle import Errors, stepped
from .point import Point, PointModel, point_field, read

_STEPS, _LEAST, _SHARE = 8, 0.05, 5e-3
"""The most steps, and the change of chi-square, and the share of it, below which the last was enough."""
Q = 5
"""Row of the slopes in q, behind those in y, z, N, Ty and Tz."""


class Variants(NamedTuple):
    """What sensors read by the finger as drawn, and by others, as of `PointModel`.

    sensors (V, 4, n), table (V, rows, numbers), first (n + 1,), terms (V, terms, 5); deeper, other, sizes: which is of
    deeper sensors, which what another Poisson's ratio changes, and the first of those by which readings change with q,
    q^2 and so on; -1 where there is none.
    """

    sensors: FloatArray
    table: FloatArray
    first: npt.NDArray[np.int64]
    terms: npt.NDArray[np.int64]
    deeper: int
    other: int
    sizes: int


class Settling(NamedTuple):
    """Thresholds, as of `judge.Settings`.

    widest: half width at q = 1 [m]; box, beyond (4,): ends of the search, and of where a load is thought of; longest:
    of a step [m]; level: mean square of the errors of a frame without a load; share: mean square of what a load adds,
    of its largest reading squared, and the same with all sizes.
    """

    friction: float
    largest: float
    ambiguity: float
    apart: float
    widest: float
    box: FloatArray
    beyond: FloatArray
    longest: float
    level: float
    share: float
    share_sized: float


class SettlingCase(NamedTuple):
    """What a frame is settled by; numbers, bits (V, ROWS, n + 1): one scratch, as either."""

    variants: Variants
    errors: Errors
    told: Settling
    numbers: FloatArray
    bits: npt.NDArray[np.int64]


@compiled(inline=True)
def _model(case, v):
    """The model of a variant."""
    made = case.variants
    return PointModel(made.sensors[v], made.first, made.table[v], made.terms[v], case.numbers[v], case.bits[v])


@compiled(borrows=True)
def lay_out(w, case, sized, room):
    """Rows, weights and rest of the readings at the state of `room`; sized: with slopes in q."""
    variants, errors = case.variants, case.errors
    at, load, q, rows, n = room.at, room.load, room.size[0], room.rows, w.size
    deeper, other, sizes = variants.deeper, variants.other, variants.sizes
    here, base = Point(at[0], at[1]), _model(case, 0)
    point_field(base, here)
    for i in range(n):
        a0, a1, a2, y0, y1, y2, z0, z1, z2 = read(base, 0, i)
        rows[0, i] = load[0] * y0 + load[1] * y1 + load[2] * y2
        rows[1, i] = load[0] * z0 + load[1] * z1 + load[2] * z2
        rows[2, i], rows[3, i], rows[4, i], rows[Q, i] = a0, a1, a2, 0.0
    power = 1.0
    for k in range(variants.table.shape[0] - sizes if sizes >= 0 and (sized or q > 0.0) else 0):
        wider, slope = _model(case, sizes + k), (k + 1) * power
        power *= q
        point_field(wider, here)
        for i in range(n):
            a0, a1, a2, y0, y1, y2, z0, z1, z2 = read(wider, 0, i)
            rows[Q, i] += slope * (load[0] * a0 + load[1] * a1 + load[2] * a2)
            rows[2, i] += power * a0
            rows[3, i] += power * a1
            rows[4, i] += power * a2
            rows[0, i] += power * (load[0] * y0 + load[1] * y1 + load[2] * y2)
            rows[1, i] += power * (load[0] * z0 + load[1] * z1 + load[2] * z2)
        if power == 0.0:
            break
    for i in range(n):
        predicted = load[0] * rows[2, i] + load[1] * rows[3, i] + load[2] * rows[4, i]
        room.rest[i] = w[i] - predicted
        moved, own = errors.position[i] ** 2 * (rows[0, i] ** 2 + rows[1, i] ** 2), errors.gain[i] * predicted
        room.weight[i] = errors.still[i] ** 2 + moved + (errors.own * own) ** 2
        for e in range(Q + 1, rows.shape[0]):
            rows[e, i] = errors.common * own if e == Q + 1 else 0.0
    if deeper >= 0:
        deep, together = _model(case, deeper), rows.shape[0] > Q + 2
        point_field(deep, here)
        for i in range(n):
            a0, a1, a2, _, _, _, _, _, _ = read(deep, 0, i)
            b0, b1, b2, _, _, _, _, _, _ = read(base, 0, i)
            changed = errors.depth[i] * (load[0] * (a0 - b0) + load[1] * (a1 - b1) + load[2] * (a2 - b2))
            if together:
                rows[Q + 2, i] = errors.common * changed
            room.weight[i] += (errors.own * changed) ** 2
    if other >= 0:
        ratio = _model(case, other)
        point_field(ratio, here)
        for i in range(n):
            a0, a1, a2, _, _, _, _, _, _ = read(ratio, 0, i)
            rows[Q + 3, i] = errors.poisson * (load[0] * a0 + load[1] * a1 + load[2] * a2)
    for i in range(n):
        room.weight[i] = 1.0 / room.weight[i]


@compiled(borrows=True)
def settle(w, case, box, sized, room):
    """From the state of `room` to the best one; chi-square left, infinite where no load presses."""
    left, q, told = math.inf, Q, case.told
    for _ in range(_STEPS):
        before = left
        lay_out(w, case, sized, room)
        left = stepped(room, told.friction, sized)
        if left < 0.0:
            return math.inf
        x = room.step
        shorter = min(1.0, told.longest / max(math.hypot(x[0], x[1]), 1e-300))
        for j in range(2):
            room.at[j] = min(max(room.at[j] + shorter * x[j], box[2 * j]), box[2 * j + 1])
        for c in range(3):
            room.load[c] += shorter * x[2 + c]
        if sized:
            room.size[0] = min(max(room.size[0] + shorter * x[q], 0.0), 1.0)
        if not room.load[0] > 0.0:
            return math.inf
        if shorter == 1.0 and abs(left - before) < _LEAST + _SHARE * left:
            break
    return left
