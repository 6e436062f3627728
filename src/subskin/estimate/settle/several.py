"""Compiled: one, two or more loads that press an area at once, each number of them settled by all errors.

A load more is looked for beside those that are known, whose forces readings may change freely; then all move together,
and one after the other is taken away and looked for again, until nothing is gained.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from .elsewhere import FEW, distance, rank_node, scanning, taken_at, whiten
from .normal import ALL, COMMON, NONE, copied, copy_state, room_of, spread_of, stepped, volume_of
from .variants import STEPS, case_of, common_of, lay_out, settle

_ROUNDS, _GAIN, _STARTS, _ANSWERS = 3, 0.05, 24, 128
"""Times that each load is looked for again, if that gained so much chi-square; positions from which the search begins
anew where nothing explains a frame; and the most answers that are kept."""
_FAINT, _MOVED = 0.02, 3.0
"""Share of the force that each load begins with at least; and the standard deviations by which positions are moved."""
_AROUND = ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0))
"""Directions in which a load is split."""


class SettledAnswers(NamedTuple):
    """What was settled of one number of loads: positions (answers, P), and `left` (answers,), chi-square with the
    determinant of the errors; filled (1,): how many.
    """

    at: FloatArray
    left: FloatArray
    filled: npt.NDArray[np.int64]


@compiled(borrows=True)
def _put_load(room, t, at, load):
    """Position and components, as load t of a room."""
    dim, forces = at.size, load.size
    for j in range(dim):
        room.at[t * dim + j] = at[j]
    for c in range(forces):
        room.load[t * forces + c] = load[c]


@compiled(borrows=True)
def _copy_loads(room, skip, out, dim):
    """The loads of a room but number `skip`, to the first ones of another."""
    to = 0
    for t in range(room.at.size // dim):
        if t != skip:
            _put_load(out, to, room.at[t * dim : (t + 1) * dim], room.load[t * (dim + 1) : (t + 1) * (dim + 1)])
            to += 1


@compiled(borrows=True)
def _try(w, case, trial, best, left, answers):
    """Settle what stands in `trial`; where it is better than `left`, it becomes `best`. The lesser of both."""
    trial.size[0], trial.shared[:] = 0.0, 0.0
    forces, first, total = case.told.box.size // 2 + 1, trial.at.size, 0.0
    lay_out(w, case, False, trial)  # the forces first
    if stepped(trial, case.told.friction, forces, False, ALL) < 0.0:
        return left
    for c in range(trial.load.size):
        trial.load[c] += trial.step[first + c]
        total += max(trial.load[c], 0.0) if c % forces == 0 else 0.0
    for c in range(0, trial.load.size, forces):
        if not trial.load[c] > _FAINT * total:
            trial.load[c] = _FAINT * total
            trial.load[c + 1 : c + forces] = 0.0
    found = settle(w, case, case.told.box, False, 2 * STEPS, NONE, trial)
    if not found < math.inf:
        return left
    found += volume_of(trial)
    k = answers.filled[0]
    if k < answers.left.size:
        copied(trial.at, answers.at[k])
        answers.left[k] = found
        answers.filled[0] = k + 1
    if found < left:
        copy_state(trial, best)
        copied(trial.weight, best.weight)
        left = found
    return left


@compiled(borrows=True)
def _look(w, case, nodes, fields, known, lines, total, trial, best, left, scan, answers):
    """Look for one load beside those of `known`, by the weights of its readings and so many lines of `scan`."""
    told, dim = case.told, nodes.shape[1]
    last = trial.at.size // dim - 1
    for e in range(FEW):
        scan.best[e, 0], scan.best[e, 1] = math.inf, -1.0
    for p in range(nodes.shape[0]):
        taken = taken_at(fields[p], known.weight, w, lines, told.friction, scan)
        if taken > 0.0:
            rank_node(nodes, p, total - taken, told.longest, nodes.shape[1], scan.best)
    for e in range(FEW):
        p = int(scan.best[e, 1])
        if p < 0:
            break
        taken_at(fields[p], known.weight, w, lines, told.friction, scan)
        if last > 0:
            _copy_loads(known, -1, trial, dim)
        _put_load(trial, last, nodes[p], scan.force)
        left = _try(w, case, trial, best, left, answers)
    return left


@compiled(borrows=True)
def _look_beside(w, case, nodes, fields, known, trial, best, left, scan, answers):
    """Look for one load beside those of `known`, whose forces are free."""
    known.shared[:] = 0.0
    lay_out(w, case, False, known)
    total, lines = whiten(w, known, True, scan.along)
    return _look(w, case, nodes, fields, known, lines, total, trial, best, left, scan, answers)


@compiled(borrows=True)
def _split(w, case, known, trial, best, left, answers):
    """Two loads for each one of those of `known`, near it to either side."""
    dim = case.told.box.size // 2
    last, step = trial.at.size // dim - 1, case.told.longest
    for t in range(last):
        for direction in _AROUND:
            _copy_loads(known, -1, trial, dim)
            for c in range(dim + 1):
                trial.load[t * (dim + 1) + c] *= 0.5
                trial.load[last * (dim + 1) + c] = trial.load[t * (dim + 1) + c]
            for j in range(dim):
                middle, move = trial.at[t * dim + j], step * direction[j]
                trial.at[t * dim + j], trial.at[last * dim + j] = middle - move, middle + move
            left = _try(w, case, trial, best, left, answers)
    return left


@compiled(borrows=True)
def _other(best, answers, spread, apart, dim):
    """What the best answer leaves that has a load where `best` has none within six standard deviations."""
    least, every = math.inf, best.at.size + best.load.size
    for k in range(answers.filled[0]):
        if not answers.left[k] < least:
            continue
        for t in range(best.at.size // dim):
            nearest, reach = math.inf, 0.0
            for s in range(best.at.size // dim):
                away = distance(answers.at[k, t * dim :], best.at[s * dim :], dim)
                if away < nearest:
                    nearest, variance = away, 0.0
                    for j in range(s * dim, (s + 1) * dim):
                        variance += spread[j * (2 * every + 1 - j) // 2]
                    reach = max(6.0 * math.sqrt(variance), apart)
            if nearest > reach:
                least = answers.left[k]
                break
    return least


@compiled(borrows=True)
def _stretch(w, case, best, trial, left, spread):
    """By how much the covariance is too small: how far positions move until chi-square has grown as it says.

    Each coordinate is moved by three standard deviations and held, while all else settles. Infinite where that is
    better.
    """
    worst, positions, every = 1.0, best.at.size, best.at.size + best.load.size
    for j in range(positions):
        deviation = math.sqrt(spread[j * (2 * every + 1 - j) // 2])
        for side in (-1.0, 1.0):
            copy_state(best, trial)
            trial.at[j] += side * _MOVED * deviation
            found = settle(w, case, case.told.beyond, False, 2 * STEPS, j, trial)
            rise = found + volume_of(trial) - left if found < math.inf else _MOVED**2
            worst = max(worst, _MOVED**2 / rise if rise > 0.0 else math.inf)
    return worst


@compiled(borrows=True)
def _say(w, case, best, trial, answers, block):
    """Fill a block of the answer (columns,) with what is known of one number of loads.

    The covariance is that without the cone: of two loads that lean as far as they may, neither need.
    """
    told, dim = case.told, case.told.box.size // 2
    positions, components = best.at.size, best.load.size
    every = positions + components
    spread = block[4 + every :]
    lay_out(w, case, False, best)
    if stepped(best, math.inf, dim + 1, False, NONE) < 0.0:
        block[0] = math.inf
        return
    spread_of(best, spread)
    block[0] = stepped(best, told.friction, dim + 1, False, NONE)
    block[1] = volume_of(best)
    block[3] = 1.0
    if block[0] < told.largest:
        block[3] = _stretch(w, case, best, trial, block[0] + block[1], spread)
    block[2] = _other(best, answers, spread, 5.0 * told.apart, dim) - block[0] - block[1]
    copied(best.at, block[4 : 4 + positions])
    copied(best.load, block[4 + positions : 4 + every])


@compiled(frames="readings")
def settle_several(readings, rows, given, out):
    """Settle one load, two, and so on, as many as `out` (f, most, columns) has blocks.

    A block has chi-square, the determinant of the errors, by how much another answer leaves more, by how much the
    covariance is too small, positions, components, and the upper triangle of their covariance. Its first column is -1
    where a reading is missing, infinite where no such loads press.
    """
    variants, errors, told, nodes, fields = given
    n, dim, components, most = readings.shape[1], nodes.shape[1], fields.shape[1], out.shape[1]
    common, case = common_of(variants, errors), case_of(variants, errors, told, dim, n)
    scan, w = scanning(components, n, COMMON + components * most), np.empty(n)
    for f in range(readings.shape[0]):
        inside, largest = True, 0.0
        for i in range(n):
            inside &= rows[2, i] < readings[f, i] < rows[3, i]
            w[i] = (readings[f, i] - rows[0, i]) * rows[1, i]
            largest = max(largest, w[i] * w[i])
        out[f] = math.nan
        out[f, :, 0] = math.inf
        if not inside:
            out[f, :, 0] = -1.0
            continue
        explained, known = False, room_of(dim, components, common, errors.ratios, n)
        for k in range(most):
            best = room_of((k + 1) * dim, (k + 1) * components, common, errors.ratios, n)
            trial = room_of((k + 1) * dim, (k + 1) * components, common, errors.ratios, n)
            answers = SettledAnswers(np.empty((_ANSWERS, best.at.size)), np.empty(_ANSWERS), np.zeros(1, np.int64))
            if k == 0:
                total = 0.0
                for i in range(n):
                    known.weight[i] = 1.0 / (errors.still[i] ** 2 + told.share * largest)
                    total += w[i] * w[i] * known.weight[i]
                left = _look(w, case, nodes, fields, known, 0, total, trial, best, math.inf, scan, answers)
            else:
                left = _look_beside(w, case, nodes, fields, known, trial, best, math.inf, scan, answers)
                left = _split(w, case, known, trial, best, left, answers)
            if not left < math.inf:
                break
            less = room_of(max(k, 1) * dim, max(k, 1) * components, common, errors.ratios, n)
            for _ in range(_ROUNDS if k > 0 else 0):
                before = left
                for t in range(k + 1):
                    _copy_loads(best, t, less, dim)
                    left = _look_beside(w, case, nodes, fields, less, trial, best, left, scan, answers)
                if not left < before - _GAIN:
                    break
            for _ in range(_ROUNDS):  # along a valley
                before = left
                copy_state(best, trial)
                left = _try(w, case, trial, best, left, answers)
                if not left < before - _GAIN:
                    break
            every = max(nodes.shape[0] // _STARTS, 1)
            for p in range(every // 2, nodes.shape[0] if k > 0 else 0, every):
                if explained or left - volume_of(best) < told.largest:
                    break
                _copy_loads(best, 0, less, dim)
                copied(nodes[p], less.at[:dim])
                left = _look_beside(w, case, nodes, fields, less, trial, best, left, scan, answers)
            _say(w, case, best, trial, answers, out[f, k])
            known, explained = best, explained or out[f, k, 0] < told.largest
