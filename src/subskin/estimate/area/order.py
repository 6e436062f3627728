"""Compiled: readings in units of noise, and the sensor that reads most, by which frames are put in order."""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled

_SIZE, _WORD, _INDEX = np.int64(0x7FFFFFFF), np.int64(32), np.int64(0xFFFFFFFF)


@compiled(inline=True)
def whitened(frame, rows, w, single):
    """Fill w and single (n + 1,), readings in units of noise, and give the sum of their squares; NaN if one is out."""
    total, usable = 0.0, True
    n = frame.size
    for i in range(n):
        r = frame[i]
        usable &= rows[2, i] < r < rows[3, i]
        w[i] = (r - rows[0, i]) * rows[1, i]
        single[i] = w[i]
        total += w[i] * w[i]
    return total if usable else math.nan


@compiled(inline=True)
def strongest(single, bits, n):
    """The sensor with the largest reading, and its square; bits: the readings as integers, which are as quick to rank.

    Numbers without their sign rank as their bits do.
    """
    largest = np.int64(0)
    for i in range(n):  # the first of equals
        largest = max(largest, (np.int64(bits[i] & _SIZE) << _WORD) + (n - 1 - i))
    hot = n - 1 - (largest & _INDEX)
    return hot, single[hot] * single[hot]


@compiled(borrows=True)
def by_strongest(readings, rows, strong, hot, start, order):
    """Each frame's strongest sensor into hot, and the frames into order: first those of sensor 0, then those of 1.

    A frame that reads less than `strong` noises comes last, its sensor is n. start (n + 2,): scratch.
    """
    frames, n = readings.shape
    for i in range(n + 2):
        start[i] = 0
    for f in range(frames):
        frame, largest, here = readings[f], -1.0, 0
        for i in range(n):
            size = abs((frame[i] - rows[0, i]) * rows[1, i])
            here = i if size > largest else here
            largest = size if size > largest else largest
        here = here if largest >= strong else n
        hot[f] = here
        start[here + 1] += 1
    for i in range(n + 1):
        start[i + 1] += start[i]
    for f in range(frames):
        order[start[hot[f]]] = f
        start[hot[f]] += 1
