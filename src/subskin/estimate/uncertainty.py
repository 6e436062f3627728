"""Compiled: the covariance of a contact of some width, and the interval of its half width."""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled
from .layout import WIDE

_COVARIANCE, _INTERVAL = WIDE.covariance, WIDE.interval


@compiled()
def uncertainty(columns, prior, wide, drags, q, least, most, row):
    """Fill the covariance of (position, N, T, half width) and the 95 % interval of the half width in `row`.

    columns (k, n): derivatives of the whitened readings in position, N, T, the square q of the half width if `wide`,
    and, where k says so, one more unknown, which is integrated out; prior: what is known of that, as 1 over its
    standard deviation. Drag that is not there (`drags` false) does not move.
    """
    size, n = columns.shape
    scale = np.empty(size)
    for j in range(size):
        total = prior * prior if j == 3 + wide else 0.0
        for i in range(n):
            total += columns[j, i] * columns[j, i]
        scale[j] = math.sqrt(total) if total > 0.0 else 1.0
    information = np.zeros((size, size))
    for j in range(size):
        for k in range(size):
            for i in range(n):
                information[j, k] += columns[j, i] * columns[k, i] / (scale[j] * scale[k])
        information[j, j] += 1e-14  # what the readings say nothing of is infinite within rounding, not an error
    if size > 3 + wide:
        information[3 + wide, 3 + wide] += (prior / scale[3 + wide]) ** 2
    covariance = np.linalg.inv(information)
    # how far (position, N, T, half width) move with the unknowns in their scales
    moves = np.zeros(4)
    moves[0], moves[1], moves[2] = 1.0 / scale[0], 1.0 / scale[1], (1.0 / scale[2] if drags else 0.0)
    half = math.sqrt(q)
    row[_INTERVAL] = row[_INTERVAL + 1] = half
    if wide:
        spread = 1.959964 * math.sqrt(covariance[3, 3]) / scale[3]
        row[_INTERVAL] = math.sqrt(max(q - spread, least))
        row[_INTERVAL + 1] = math.sqrt(min(q + spread, most))
        # near no width the readings know its square alone: the interval says how much that is
        straight = 0.5 / half if half > 0.0 else math.inf
        about = 0.5 * (math.sqrt(q + spread) - math.sqrt(max(q - spread, 0.0))) / spread
        moves[3] = min(straight, about) / scale[3]
    k = _COVARIANCE
    for i in range(4):
        for j in range(i, 4):
            known = i >= 3 + wide or j >= 3 + wide
            row[k] = 0.0 if known else moves[i] * covariance[i, j] * moves[j]
            k += 1
