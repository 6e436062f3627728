"""The compiled heart of `resultant`: which guesses explain a frame, and what they say together of its load.

Guesses that read most along the readings are looked at in full. Each gives a linear estimate, at the amplitude that its
own first direction tells, and its evidence. The answer is their mean, and its covariance counts how they differ.
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from ..project import whitened
from ..scan import MOST_CHI2

__all__ = ["resultant_frames"]

_LOOKED = 32
"""Guesses that are looked at in full."""
_TRUST = 0.75
"""Power of the evidence by which guesses weigh: pressures are no Gaussian scatter, and it is too sure."""
_LEAST = 1e-4
"""Of the largest weight, below which a guess does not count."""
_UNLIKE = 0.012
"""Share by which a load may be larger or less as its pressure is unlike all guesses: measured (docs/resultant.md)."""
_VAGUE = 0.3
"""Standard deviation over the normal force from which an answer is AMBIGUOUS."""
_LARGE = 1e150
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0


@compiled(frames="readings")
def resultant_frames(readings, sensors, first, basis, size, told, spread, chance, most, box, out, wrench):
    """Fill `out` (f, columns) as a `Layout` says, without a rival, and `wrench` (f, q + q^2).

    readings (f, n), raw; sensors (4, n) as of `whitened`; first to chance: a `Bank`; most: chi-square up to
    which there is no contact, and beyond which no pressure explains a frame; box (d, 2): where a centre is sure.
    wrench: what was asked, and its covariance.
    """
    n, k, q = readings.shape[1], basis.shape[1], told.shape[2]
    room = (
        np.empty(n),
        np.empty((_LOOKED, k)),
        np.empty((_LOOKED, k)),
        np.empty((_LOOKED, q)),
        np.empty(_LOOKED),
        np.empty(first.shape[1], np.float32),
    )
    order, high = np.empty(_LOOKED, np.int64), np.empty(_LOOKED)
    _each(readings, sensors, first, basis, size, told, spread, chance, (most, box, order, high), room, out, wrench)


@compiled(borrows=True)
def _each(readings, sensors, first, basis, size, told, spread, chance, more, room, out, wrench):
    """Frame by frame, with scratch."""
    most, box, order, high = more
    w, along, gain, mean, weight, quick = room
    status = out.shape[1] - 1
    q = told.shape[2]
    for f in range(readings.shape[0]):
        row, asked = out[f], wrench[f]
        for i in range(row.size):
            row[i] = math.nan
        for i in range(asked.size):
            asked[i] = math.nan
        total = whitened(readings[f], sensors, w)
        row[status - 1] = math.inf
        if not total < MOST_CHI2:
            row[status] = _PENDING
            continue
        left = _left(total, w, first, basis, size, chance, quick, order, high, along, gain, weight)
        row[_residual(box.shape[0])] = total if math.isinf(left) else left
        if total <= most:
            row[status] = _NO_CONTACT
            continue
        if left > most:
            row[status] = _UNEXPLAINED
            continue
        if _told(order, high, along, gain, weight, mean, size, told, spread, asked) == 0.0:
            row[status] = _UNEXPLAINED
            continue
        row[status] = _loaded(asked, q, box, row)


@compiled(inline=True)
def _residual(dim):
    """Column of chi-square: behind a position, components and their covariance."""
    k = 2 * dim + 1
    return k + k * (k + 1) // 2


@compiled()
def _left(total, w, first, basis, size, chance, quick, order, high, along, gain, weight):
    """Weigh the guesses that read most along w (n,); chi-square of the likeliest in its own scatter, or infinity.

    Fills `quick` with all their readings along the first direction, `order` with these guesses, `high` with the squares
    of their amplitudes, `along` and `gain` with readings along each direction and the share of them that is no noise,
    and `weight`.
    """
    n, looked = w.size, 0
    for g in range(quick.size):
        quick[g] = 0.0
    for i in range(n):
        value, row = np.float32(w[i]), first[i]
        for g in range(quick.size):
            quick[g] += row[g] * value
    for g in range(quick.size):
        here = quick[g]
        if here <= 0.0 or (looked == order.size and here <= high[looked - 1]):
            continue
        at = looked if looked < order.size else looked - 1
        while at > 0 and high[at - 1] < here:
            high[at], order[at] = high[at - 1], order[at - 1]
            at -= 1
        high[at], order[at] = here, g
        looked = min(looked + 1, order.size)
    best, top = math.inf, -math.inf
    for c in range(order.size):
        weight[c] = -math.inf
    for c in range(looked):
        g = order[c]
        most = 0.0
        for i in range(n):
            most += basis[g, 0, i] * w[i]
        amplitude2 = most * most / size[g, 0]
        explained, volume, logarithm = 0.0, 1.0, 0.0
        for j in range(size.shape[1]):
            part = 0.0
            for i in range(n):
                part += basis[g, j, i] * w[i]
            times = amplitude2 * size[g, j]
            along[c, j], gain[c, j] = part, times / (1.0 + times)
            explained += gain[c, j] * part * part
            volume *= 1.0 + times
            if volume > _LARGE:
                logarithm, volume = logarithm + math.log(volume), 1.0
        weight[c] = 0.5 * (explained - logarithm - math.log(volume)) + chance[g]
        high[c] = amplitude2
        if weight[c] > top:
            top, best = weight[c], max(total - explained, 0.0)
    for c in range(order.size):
        weight[c] = math.exp(_TRUST * (weight[c] - top)) if weight[c] > -math.inf else 0.0
    return best


@compiled()
def _told(order, amplitude2, along, gain, weight, mean, size, told, spread, asked):
    """Fill `asked` (q + q^2): what is asked, by all guesses together, and its covariance; the sum of their weights."""
    q, sum_of = mean.shape[1], 0.0
    for i in range(asked.size):
        asked[i] = 0.0
    for c in range(order.size):
        if weight[c] < _LEAST:
            continue
        for a in range(q):
            mean[c, a] = 0.0
        for j in range(size.shape[1]):
            for a in range(q):
                mean[c, a] += gain[c, j] * along[c, j] * told[order[c], j, a]
        if mean[c, 0] <= 0.0:  # it would pull
            weight[c] = 0.0
            continue
        sum_of += weight[c]
        for a in range(q):
            asked[a] += weight[c] * mean[c, a]
    if sum_of == 0.0:
        return 0.0
    for a in range(q):
        asked[a] /= sum_of
    for c in range(order.size):
        if weight[c] < _LEAST:
            continue
        g, share = order[c], weight[c] / sum_of
        for a in range(q):
            for b in range(a, q):
                known = 0.0
                for j in range(size.shape[1]):
                    known += gain[c, j] * size[g, j] * told[g, j, a] * told[g, j, b]
                apart = (mean[c, a] - asked[a]) * (mean[c, b] - asked[b])
                asked[q + a * q + b] += share * (amplitude2[c] * (spread[g, a, b] - known) + apart)
    for a in range(q):
        for b in range(a, q):
            asked[q + a * q + b] += _UNLIKE * _UNLIKE * asked[a] * asked[b]
    for a in range(q):
        for b in range(a):
            asked[q + a * q + b] = asked[q + b * q + a]
    return sum_of


@compiled()
def _loaded(asked, q, box, row):
    """Fill centre, components and their covariance in a row from the resultant; gives the status."""
    dim = box.shape[0]
    k, force = 2 * dim + 1, asked[0]
    status = _OK if asked[q] < (_VAGUE * force) ** 2 else _AMBIGUOUS
    for i in range(dim):
        row[i] = asked[dim + 1 + i] / force
        if not box[i, 0] < row[i] < box[i, 1]:
            status = _AMBIGUOUS
    for i in range(dim + 1):
        row[dim + i] = asked[i]
    at = k
    for i in range(k):
        for j in range(i, k):
            # a component stands for itself; a coordinate is its moment over the force
            one, per_one, less_one = (i - dim, 1.0, 0.0) if i >= dim else (dim + 1 + i, 1.0 / force, row[i] / force)
            two, per_two, less_two = (j - dim, 1.0, 0.0) if j >= dim else (dim + 1 + j, 1.0 / force, row[j] / force)
            value = per_one * per_two * asked[q + one * q + two] - less_one * per_two * asked[q + two]
            row[at] = value - per_one * less_two * asked[q + one * q] + less_one * less_two * asked[q]
            at += 1
    return status
