"""How much of a Gaussian load lies beyond the friction cone, of a drag with one component: compiled loops.

Cell by cell of the density of mu.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from .._check import FloatArray
from .._compiled import compiled
from ..estimate import Status

__all__ = [
    "AMBIGUOUS",
    "CANNOT_TELL",
    "CELL",
    "CUT_OFF",
    "EDGE",
    "JUDGED",
    "MARGIN",
    "MARGIN_STD",
    "NORMAL",
    "OK",
    "PROBABILITY",
    "RATIO",
    "SURE",
    "TANGENTIAL",
    "UNSURE",
    "VERDICT",
    "SlipVerdict",
    "fill_cells",
    "fill_row",
    "judge_frames",
    "put_judged",
]  # fmt: skip


class SlipVerdict(IntEnum):
    """What to make of a frame; the thresholds are those of `slip`."""

    HOLDS = 0
    """The probability of slip is below the first threshold."""
    AT_RISK = 1
    """It is between the two."""
    SLIPS = 2
    """It is at the second or above. A contact that slides lies on the cone: its frames scatter about 1/2."""
    CANNOT_TELL = 3
    """No load, or one of two, or one that the estimator's own cone cut off where friction may hold more."""


EDGE = 1e-6
"""Share of the cone within which a load lies on its edge."""
SURE = 8.0
"""Standard deviations from 0 at which a normal force is taken to press for certain: the rest is 6e-16."""

NORMAL, TANGENTIAL, MARGIN, MARGIN_STD, PROBABILITY, RATIO, VERDICT, CUT_OFF, UNSURE = range(9)
"""Columns that are filled, by name. The load lies on the edge of the estimator's own cone: cut off. It may pull, and so
be counted twice: unsure."""
JUDGED = 9

OK, AMBIGUOUS, CANNOT_TELL = int(Status.OK), int(Status.AMBIGUOUS), int(SlipVerdict.CANNOT_TELL)

_HALF = math.sqrt(0.5)
_BELL = 1 / math.sqrt(2 * math.pi)
_SURELY = 39.0
"""Beyond this Phi is 0, and the density too, to the last bit that a float has."""
_FAR = 10.0
"""Squares of z that differ by the square of this: Phi of one is less than the last bit of the other's."""
CELL = 0.5 / math.sqrt(3.0)
"""Gauss and Legendre's two nodes in a cell of the density of mu, from its middle, in widths of the cell."""
_CLOSE = 0.02
"""Ends of a cell so close together that a series serves where differences would lose digits."""


@compiled(inline=True, exact=True)
def _tail(z: float) -> float:
    """Phi(z)."""
    return 0.5 * math.erfc(-_HALF * z)


@compiled(inline=True, exact=True)
def _bell(z: float) -> float:
    return _BELL * math.exp(-0.5 * min(abs(z), 40.0) ** 2)


@compiled(inline=True, exact=True)
def _mean(low: float, middle: float, high: float, low_tail: float, low_bell: float, tail: float, bell: float) -> float:
    """Mean of Phi(z) over a cell at whose ends and middle z is given; z is a straight line there, and a little bent.

    Phi and its density at both ends are given too. With G the integral of Phi and H that of G: the line gives
    (G2 - G1) / D, the bend 4 b times the mean of t (1 - t) phi, which is (G1 + G2) / D^2 - 2 (H2 - H1) / D^3.
    """
    apart, centre = high - low, 0.5 * (low + high)
    if abs(apart) < _CLOSE:
        here, square = _bell(centre), apart * apart
        line = _tail(centre) - centre * here * square / 24 * (1 + (centre * centre - 3) * square / 80)
        bent = here * (1 / 6 + (centre * centre - 1) * square / 240)
    else:
        g_low, g_high = low * low_tail + low_bell, high * tail + bell
        h_low = 0.5 * ((low * low + 1) * low_tail + low * low_bell)
        h_high = 0.5 * ((high * high + 1) * tail + high * bell)
        line = (g_high - g_low) / apart
        bent = ((g_low + g_high) - 2 * (h_high - h_low) / apart) / (apart * apart)
    return float(max(line + 4 * (middle - centre) * bent, 0.0))


@compiled(inline=True, exact=True)
def _width(t: float, n: float, nn: float, nt: float, tt: float, mu: float) -> float:
    """Standard deviation of t - mu n."""
    floor = 1e-12 * (abs(t) + mu * abs(n)) + 1e-300
    return math.sqrt(max(tt - 2 * mu * nt + mu * mu * nn, floor * floor))


@compiled(exact=True)
def fill_row(
    n: float, t: float, nn: float, nt: float, tt: float, edges: FloatArray, scale: float, out: FloatArray
) -> None:  # fmt: skip
    """P(T > mu N) + P(-T > mu N) in each cell of the density of mu.

    The end of a cell is the beginning of the next, and so is Phi there. The side to which the load does not lean is
    passed over where it adds less than a bit: z lies deeper in the tail there, at the largest numerator and the largest
    width of the cell's two ends (its square is convex in mu).
    """
    side = -1.0 if t < 0 else 1.0
    t, nt = side * t, side * nt
    mu = scale * edges[0]
    width, other = _width(t, n, nn, nt, tt, mu), _width(t, n, nn, -nt, tt, mu)
    low, low_tail, low_bell, flipped = (t - mu * n) / width, math.nan, math.nan, False
    for k in range(out.size):
        end = scale * edges[k + 1]
        half = 0.5 * (mu + end)
        middle = (t - half * n) / _width(t, n, nn, nt, tt, half)
        high = (t - end * n) / _width(t, n, nn, nt, tt, end)
        end_other = _width(t, n, nn, -nt, tt, end)
        most, least = max(low, middle, high), min(low, middle, high)
        if most < -_SURELY:
            mean, low_tail = 0.0, math.nan
        elif least > _SURELY:
            mean, low_tail = 1.0, math.nan
        else:
            flip = low + high > 0  # from the lower tail: near 1, Phi would be a difference of large numbers
            one = -1.0 if flip else 1.0
            if flip != flipped or low_tail != low_tail:
                low_tail, low_bell = _tail(one * low), _bell(low)
            tail, bell = _tail(one * high), _bell(high)
            mean = _mean(one * low, one * middle, one * high, low_tail, low_bell, tail, bell)
            mean = 1 - mean if flip else mean
            low_tail, low_bell, flipped = tail, bell, flip
        away = (-t - mu * n) / max(other, end_other)
        if n < 0 or away > -_FAR or away * away - min(least, 0.0) ** 2 < _FAR * _FAR:
            begins, ends = (-t - mu * n) / other, (-t - end * n) / end_other
            turns = (-t - half * n) / _width(t, n, nn, -nt, tt, half)
            if max(begins, turns, ends) > -_SURELY:
                one = -1.0 if begins + ends > 0 else 1.0
                more = _mean(
                    one * begins, one * turns, one * ends,
                    _tail(one * begins), _bell(begins), _tail(one * ends), _bell(ends),
                )  # fmt: skip
                mean += 1 - more if one < 0 else more
        out[k] = mean
        mu, low, other = end, high, end_other


@compiled(exact=True, frames="mean")
def fill_cells(mean: FloatArray, covariance: FloatArray, edges: FloatArray, scale: FloatArray, out: FloatArray) -> None:
    """P(T > mu N) + P(-T > mu N), its mean over mu in each cell; edges (frames or 1, k + 1), out (frames, k).

    mean (frames, 2), covariance (frames, 2, 2): of N and T.
    """
    for i in range(out.shape[0]):
        row, c = edges[min(i, edges.shape[0] - 1)], covariance[i]
        fill_row(mean[i, 0], mean[i, 1], c[0, 0], c[0, 1], c[1, 1], row, scale[i], out[i])


@compiled(inline=True, exact=True)
def put_judged(
    out: FloatArray, n: float, t: float, nn: float, nt: float, tt: float, facts: FloatArray, total: float,
    limits: FloatArray, ok: bool,
) -> None:  # fmt: skip
    """Fill a frame's row (JUDGED,) with what follows from N and T, their covariance, facts (3,) and the probability."""
    mean, std = facts[0], facts[1]
    across = tt - 2 * mean * math.copysign(1.0, t) * nt + mean * mean * nn
    out[NORMAL], out[TANGENTIAL], out[MARGIN], out[PROBABILITY] = n, t, mean * n - abs(t), total
    out[MARGIN_STD] = math.sqrt(max(across + std * std * (n * n + nn), 0.0))
    out[RATIO] = abs(t) / (mean * n) if t != 0 else 0.0
    if ok:
        out[VERDICT] = (total >= limits[0]) + (total >= limits[1])


@compiled(exact=True, frames="table")
def judge_frames(
    table: FloatArray, columns: tuple[int, int, int, int, int], widest: float,
    edges: FloatArray, masses: FloatArray, facts: FloatArray, limits: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Each frame of an estimate's table beside the cone of friction; NaN where nothing can be told.

    columns are those of N, of its variance, of the covariance, of T's variance, and of the status; facts (frames or 1,
    3) mean, standard deviation and upper end of mu; limits the two thresholds; out (frames, JUDGED).
    """
    cells = np.empty(masses.shape[1])
    c_n, c_nn, c_nt, c_tt, c_status = columns
    for i in range(out.shape[0]):
        n, t, nn, nt, tt = table[i, c_n], table[i, c_n + 1], table[i, c_nn], table[i, c_nt], table[i, c_tt]
        row = min(i, edges.shape[0] - 1)
        most = facts[row, 2]
        found = table[i, c_status] == OK or table[i, c_status] == AMBIGUOUS
        out[i] = np.nan
        out[i, CUT_OFF] = found and math.isfinite(widest) and abs(t) >= widest * n * (1 - EDGE)
        out[i, VERDICT], out[i, UNSURE] = CANNOT_TELL, 0.0
        # where the estimator was told that there is no friction, the drag was not measured
        if not (found and abs(n + t + nn + nt + tt) < math.inf and tt > 0 and n > 0):
            continue
        if out[i, CUT_OFF] and widest < most:
            continue
        fill_row(n, t, nn, nt, tt, edges[row], 1.0, cells)
        total = 0.0
        for k in range(cells.size):
            total += min(cells[k], 1.0) * masses[row, k]
        put_judged(out[i], n, t, nn, nt, tt, facts[row], total, limits, table[i, c_status] == OK)
        out[i, UNSURE] = n < SURE * math.sqrt(nn)
