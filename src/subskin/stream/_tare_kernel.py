"""The compiled heart of `Tare`: one pass over the frames, which stops where a question has to be asked.

Only arrays and numbers go in and out; `tare.py` prepares them and keeps the state.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._compiled import compiled

# The state: numbers,
FREE, QUIET, ASKED, CLOCK = range(4)
"""1 where free; quiet since; touch began or last asked about; time of the last frame."""

NUMBERS = 4
# and rows with one value a sensor.
OFFSET, SPREAD, BASE, SUM, COUNT, BEFORE, LAST, CHANGED, REPEATS, HELD = range(10)
"""The offset and its standard deviation; the window's sum from BASE and its count; the last two readings, when the
last one changed, and how many equal ones have come since; the window's mean when it was last asked about."""

ROWS = 10
# Rows of what is known of the sensors.
NOISE, DRIFT, LOW, HIGH, ALIVE, LIVELY, OWN = range(7)
# Times that a question is asked by.
GUARD, SETTLE, PATIENCE = range(3)

_FEWEST = 20
"""Equal readings before a sensor is called frozen."""


class TaredFrames(NamedTuple):
    """What is filled for each frame: (m, n), and `free` (m,).

    `given` are the readings as if the offsets were the finger's own. To `doubt`, (0, n) where there is none, is added
    how surely an offset is known, as variances are.
    """

    given: FloatArray
    offset: FloatArray
    free: npt.NDArray[np.bool_]
    frozen: npt.NDArray[np.bool_]
    doubt: FloatArray


@compiled(exact=True)
def _median(a, b, c):
    """Of three, of those that are numbers."""
    if not math.isfinite(a):
        a = b if math.isfinite(b) else c
    if not math.isfinite(b):
        b = a
    return max(min(a, b), min(max(a, b), c))


@compiled(exact=True)
def follow(readings, smooth, time, begin, head, sensors, times, limits, rows, numbers, out):
    """Follow the offsets over the frames from `begin`; returns (next frame, oldest frame of the window, question).

    readings (m, n); smooth (w + m, n) and time (w + m,) begin with a window of w frames that were seen before. sensors
    (7, n); times (3,) [s]; limits (n + 1,): chi-square that noise exceeds so rarely, by number of sensors. rows (10, n)
    and numbers (4,) are the state and change in place; `out` is filled. It returns with question 1 after a frame at
    which a touch has lasted for `patience` since it began or was last asked about.
    """
    given, offset, free, frozen, doubt = out.given, out.offset, out.free, out.frozen, out.doubt
    frames, n = readings.shape
    window = time.size - frames
    guard, settle, patience = times[GUARD], times[SETTLE], times[PATIENCE]
    doubted = doubt.shape[0] > 0
    for k in range(begin, frames):
        t = time[window + k]
        if numbers[CLOCK] != numbers[CLOCK]:  # the first frame, perhaps of a touch that began before a break
            numbers[CLOCK] = numbers[ASKED] = t
        elapsed = t - numbers[CLOCK]
        numbers[CLOCK] = t
        chi2, count = 0.0, 0
        for i in range(n):
            raw = readings[k, i]
            rows[SPREAD, i] += sensors[DRIFT, i] * elapsed
            usable = sensors[ALIVE, i] > 0 and sensors[LOW, i] < raw < sensors[HIGH, i]
            if raw == rows[LAST, i]:
                rows[REPEATS, i] += 1
            else:
                rows[REPEATS, i], rows[CHANGED, i] = 0.0, t
            still = rows[REPEATS, i] >= _FEWEST and t - rows[CHANGED, i] >= patience
            frozen[k, i] = still and usable and sensors[LIVELY, i] > 0
            # one wild reading between two good ones is no touch, and is not learnt from
            v = _median(rows[BEFORE, i], rows[LAST, i], raw) if usable else math.nan
            rows[BEFORE, i], rows[LAST, i] = rows[LAST, i], raw
            smooth[window + k, i] = v
            if not usable:
                continue
            if rows[BASE, i] != rows[BASE, i]:
                rows[BASE, i] = v
            rows[SUM, i] += v - rows[BASE, i]
            rows[COUNT, i] += 1
            if rows[SPREAD, i] == math.inf:
                if numbers[FREE] == 0:
                    continue
                rows[OFFSET, i], rows[SPREAD, i] = v, sensors[NOISE, i]
            if not frozen[k, i]:
                away = v - rows[OFFSET, i]
                chi2 += away * away / (sensors[NOISE, i] ** 2 + rows[SPREAD, i] ** 2)
                count += 1
        # frames that leave the window have been free all the while, or they are forgotten
        while time[head] < t - guard:
            for i in range(n):
                v = smooth[head, i]
                if v != v:
                    continue
                rows[SUM, i] -= v - rows[BASE, i]
                rows[COUNT, i] -= 1
                if numbers[FREE] > 0 and not frozen[k, i]:
                    share = rows[SPREAD, i] ** 2 / (rows[SPREAD, i] ** 2 + sensors[NOISE, i] ** 2)
                    rows[OFFSET, i] += share * (v - rows[OFFSET, i])
                    rows[SPREAD, i] *= math.sqrt(1 - share)
            head += 1
        mean2 = left2 = 0.0
        for i in range(n):
            if rows[COUNT, i] > 0 and rows[SPREAD, i] < math.inf and not frozen[k, i]:
                mean = rows[BASE, i] + rows[SUM, i] / rows[COUNT, i]
                variance = sensors[NOISE, i] ** 2 / rows[COUNT, i]
                mean2 += (mean - rows[OFFSET, i]) ** 2 / (variance + rows[SPREAD, i] ** 2)
                left2 += (mean - rows[HELD, i]) ** 2 / (2 * variance)
        limit = limits[count]
        question = False
        if numbers[FREE] > 0:
            if chi2 > limit or mean2 > limit:
                numbers[FREE], numbers[QUIET], numbers[ASKED] = 0.0, math.inf, t
                rows[HELD] = math.nan
        # a touch that has stayed as it was is one still, however much drift there may have been meanwhile
        elif chi2 > limit or mean2 > 0.5 * limit or left2 <= limit:
            numbers[QUIET] = math.inf
            question = t - numbers[ASKED] >= patience
        else:
            numbers[QUIET] = min(numbers[QUIET], t)
            if t - numbers[QUIET] >= settle:
                numbers[FREE] = 1.0
        free[k] = numbers[FREE] > 0
        for i in range(n):
            known = rows[SPREAD, i] < math.inf
            if doubted and known:
                doubt[k, i] = math.sqrt(doubt[k, i] ** 2 + rows[SPREAD, i] ** 2)
            offset[k, i] = rows[OFFSET, i] if known else math.nan
            if sensors[ALIVE, i] <= 0:
                given[k, i] = readings[k, i]
            elif frozen[k, i] or not sensors[LOW, i] < readings[k, i] < sensors[HIGH, i]:
                given[k, i] = math.nan  # saturated, wherever its offset has gone
            else:
                given[k, i] = readings[k, i] - offset[k, i] + sensors[OWN, i]
        if question:
            numbers[ASKED] = t
            return k + 1, head, True
    return frames, head, False
