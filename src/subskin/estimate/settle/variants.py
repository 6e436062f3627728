"""Compiled: readings of loads, or of a touch of some size, by fingers that are not quite their drawing.

Line loads on a row, point loads on it or on an area: the table says which. Of point loads beside a row the second
coordinate is z^2 / aside, which readings are smooth in. As many press at once as the state has positions for.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..area.point import ROWS, Point, PointModel, point_field, read
from ..kinds import Along, Line, line_at, line_read
from .given import Errors, Settling, Variants
from .normal import COMMON, copied, stepped, volume_of

STEPS, _LEAST, _SHARE = 8, 0.05, 5e-3
"""The most steps as a rule, and the change of chi-square, and the share of it, below which the last was enough."""

_ON_ROW = 1e-8
"""Square of the least distance beside a row, in `aside`: slopes in z^2 are told at it."""


class SettlingCase(NamedTuple):
    """What a frame is settled by; scratch: numbers, bits (V, ROWS, n + 1), the same as either; here, there
    (F (1 + P), n): readings under unit forces, then their slopes in each coordinate; changed (n,).
    """

    variants: Variants
    errors: Errors
    told: Settling
    numbers: FloatArray
    bits: npt.NDArray[np.int64]
    here: FloatArray
    there: FloatArray
    changed: FloatArray


@compiled(inline=True)
def common_of(variants, errors):
    """How many errors sensors have in common."""
    return COMMON if variants.other >= 0 else 2 if errors.common > 0.0 else 0


@compiled()
def case_of(variants, errors, told, dim, n):
    """The case of frames of n readings, with its scratch; dim: coordinates of a position."""
    numbers, fill = np.empty((variants.table.shape[0], ROWS, n + 1)), (dim + 1) * told.forces
    return SettlingCase(
        variants, errors, told, numbers, numbers.view(np.int64), np.empty((fill, n)), np.empty((fill, n)), np.empty(n)
    )


@compiled(inline=True)
def distance_beside(square, aside):
    """How far beside the row [m] a load presses, whose second coordinate is z^2 / aside; never quite on it."""
    return math.sqrt(max(square * aside, _ON_ROW * aside * aside))


@compiled(borrows=True)
def _fill(table, case, v, at, out):
    """Readings of a variant under unit forces at `at`, then their slopes, into `out` (F (1 + P), n)."""
    made = case.variants
    if table.ndim == 5:
        line = Line(table[v], made.start, made.step, out)
        cell = line_at(line, Along(at[0]))
        for i in range(out.shape[1]):
            out[0, i], out[1, i], out[2, i], out[3, i], _, _ = line_read(line, cell, i)
    elif case.told.aside > 0.0:
        model = PointModel(made.sensors[v], made.first, table[v], made.terms[v], case.numbers[v], case.bits[v])
        z = distance_beside(at[1], case.told.aside)
        by, away = 0.5 * case.told.aside / z, out[2 * case.told.forces :]
        point_field(model, Point(at[0], z))
        for i in range(out.shape[1]):
            out[0, i], out[1, i], _, out[2, i], out[3, i], _, by_n, by_t, _ = read(model, 0, i)
            away[0, i], away[1, i] = by * by_n, by * by_t
    else:
        model = PointModel(made.sensors[v], made.first, table[v], made.terms[v], case.numbers[v], case.bits[v])
        point_field(model, Point(at[0], at[1]))
        for i in range(out.shape[1]):
            values = read(model, 0, i)
            for r in range(out.shape[0]):
                out[r, i] = values[r]


@compiled(borrows=True)
def _add(fields, begin, load, share, out):
    """Add a share of what a load reads by the fields (F,) from `begin` on to `out` (n,)."""
    for c in range(load.size):
        much = share * load[c]
        for i in range(out.size):
            out[i] += much * fields[begin + c, i]


@compiled(borrows=True)
def _combine(share, fields, other, others):
    """Of fields (F (1 + P), n) and others such shares, over the former."""
    for r in range(fields.shape[0]):
        for i in range(fields.shape[1]):
            fields[r, i] = share * fields[r, i] + other * others[r, i]


@compiled(borrows=True)
def lay_out(w, case, sized, room):
    """Rows, weights and rest of the readings at the state of `room`; sized: with slopes in q."""
    made, errors, rows, q, n = case.variants, case.errors, room.rows, room.size[0], w.size
    here, there, changed, dim = case.here, case.there, case.changed, case.told.box.size // 2
    forces, positions, components = case.told.forces, room.at.size, room.load.size
    by_q = positions + components
    common = by_q + 1
    rows[:] = 0.0
    changed[:] = 0.0
    copied(w, room.rest)
    for t in range(positions // dim):
        at, load = room.at[t * dim : (t + 1) * dim], room.load[t * forces : (t + 1) * forces]
        _fill(made.table, case, 0, at, here)
        if made.deeper >= 0:
            _fill(made.table, case, made.deeper, at, there)
            _add(there, 0, load, 1.0, changed)
            _add(here, 0, load, -1.0, changed)
            if common + 1 < rows.shape[0]:
                deep = errors.common * room.shared[1]
                _combine(1.0 - deep, here, deep, there)
        if made.other >= 0:
            _fill(made.table, case, made.other, at, there)
            _add(there, 0, load, 1.0, rows[common + 2])
            _combine(1.0, here, room.shared[2], there)
        power = 1.0
        for k in range(made.table.shape[0] - made.sizes if made.sizes >= 0 and (sized or q > 0.0) else 0):
            _fill(made.table, case, made.sizes + k, at, there)
            _add(there, 0, load, (k + 1) * power, rows[by_q])
            power *= q
            if power == 0.0:
                break
            _combine(1.0, here, power, there)
        for i in range(n if common < rows.shape[0] else 0):
            gain = 1.0 + errors.common * room.shared[0] * errors.gain[i]
            for r in range(here.shape[0]):
                here[r, i] *= gain
        for j in range(dim):
            _add(here, forces * (1 + j), load, 1.0, rows[t * dim + j])
        for c in range(forces):
            copied(here[c], rows[positions + t * forces + c])
        _add(here, 0, load, -1.0, room.rest)
    part = room.part
    part[:] = 0.0
    for j in range(dim):
        turn = 1.0
        if j == 1 and case.told.aside > 0.0:
            turn = 2.0 * distance_beside(room.at[1], case.told.aside) / case.told.aside
        for i in range(n):
            slope = rows[j, i]
            for k in range(j + dim, positions, dim):
                slope += rows[k, i]
            part[i] += (turn * slope) ** 2
    for i in range(n):
        own, moved = errors.gain[i] * (w[i] - room.rest[i]), part[i]
        room.weight[i] = 1.0 / (
            errors.still[i] ** 2 + errors.position[i] ** 2 * moved + errors.own**2 * (own**2 + changed[i] ** 2)
        )
        if common < rows.shape[0]:
            rows[common, i] = errors.common * own
        if common + 1 < rows.shape[0]:
            rows[common + 1, i] = errors.common * changed[i]


@compiled(borrows=True)
def _left(room):
    """Chi-square of the readings as they are laid out, with the determinant of the errors."""
    total = volume_of(room)
    for i in range(room.rest.size):
        total += room.rest[i] ** 2 * room.weight[i]
    for e in range(room.shared.size):
        total += room.shared[e] ** 2
    return total


@compiled(borrows=True)
def settle(w, case, box, sized, most, held, room):
    """From the state of `room` to the best one in `most` steps; chi-square left, infinite where a load pulls.

    held: as of `stepped`.
    """
    left, told, positions, components = math.inf, case.told, room.at.size, room.load.size
    dim, reach, now = told.box.size // 2, told.longest, math.inf
    for _ in range(most):
        before = left
        lay_out(w, case, sized, room)
        if positions > dim or told.aside > 0.0:
            # several loads, or force and distance, may chase each other: shorter steps where the last one made it worse
            last, now = now, _left(room)
            reach = 0.3 * reach if now > last else min(2.0 * reach, told.longest)
        left = stepped(room, told.friction, told.forces, sized, held)
        if left < 0.0:
            return math.inf
        x, longest = room.step, 0.0
        for t in range(positions // dim):
            length = 0.0
            for j in range(t * dim, (t + 1) * dim):
                length += x[j] ** 2
            longest = max(longest, length)
        shorter = min(1.0, reach / max(math.sqrt(longest), 1e-300))
        for j in range(positions):
            side = 2 * (j % dim)
            room.at[j] = min(max(room.at[j] + shorter * x[j], box[side]), box[side + 1])
        for c in range(components):
            room.load[c] += shorter * x[positions + c]
        if sized:
            room.size[0] = min(max(room.size[0] + shorter * x[positions + components], 0.0), 1.0)
        for e in range(room.shared.size):
            room.shared[e] += shorter * x[positions + components + 1 + e]
        for c in range(0, components, told.forces):
            if not room.load[c] > 0.0:
                return math.inf
        if shorter == 1.0 and abs(left - before) < _LEAST + _SHARE * left:
            break
    return left
