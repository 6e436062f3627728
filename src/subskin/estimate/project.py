"""The compiled heart of `locate` and `fit`: one frame at a time, a load or a contact that explains it.

Scan S (`scan.py`), climb from its highest nodes (`kinds.py`), look at the ends of the search and beyond (`ends.py`),
judge, and fill a row. The table of responses says what is sought: with three axes a contact of some width, with four a
line load, for which the compiler leaves out all that belongs to a width. Only arrays and numbers go in and out;
`search.py` prepares them, `layout.py` names what a row holds.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._compiled import compiled
from .ends import at_end, outside
from .kinds import (
    LINE_FIT,
    LINE_ROWS,
    WIDE_FIT,
    Along,
    line_at,
    line_covariance,
    line_read,
    modelled,
    top_from,
    until,
    wide_covariance,
    width_of,
)
from .layout import LINE, WIDE
from .moments import line_moments, widened
from .scan import FEW, MOST_CHI2, Heights, highest, peaks, room_for, survey
from .varpro import Ending, Limits

_MANY = 8
"""Maxima over position and width that are climbed."""
_LARGE = 1e5
"""Sum of the squared readings, in noises, above which a climb's last step leaves too few digits of what is left."""
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_LINE_SQUARE, WIDE_SQUARE = LINE.square - LINE.covariance, WIDE.square - WIDE.covariance
"""Where the covariance of two unknowns stands among those of a row."""
_OF_FIT = WIDE_SQUARE[np.ix_([0, 2, 3, 1], [0, 2, 3, 1])]
"""The same, of y, N, T and half width, among those of a fit, whose order is y, q, N, T."""
_MORE, _NO_MORE = 1.0 + 1e-13, np.zeros(3)
_SPREAD = 1.959964
"""Standard deviations on either side of the middle of a 95 % interval."""


class FrameRoom(NamedTuple):
    """What a frame is worked out in: heights of the scan, the model, ends of the search and a copy, readings, fits."""

    heights: Heights
    model: Any
    ends: npt.NDArray[np.float64]
    held: npt.NDArray[np.float64]
    w: npt.NDArray[np.float64]
    score: npt.NDArray[np.float64]
    at: npt.NDArray[np.float64]
    fits: npt.NDArray[np.void]
    far_fits: npt.NDArray[np.void]
    covariance: npt.NDArray[np.float64]


@compiled(exact=True)
def whitened(frame, sensors, w):
    """Fill w (n,), the readings in units of noise, and give the sum of their squares; NaN if one cannot be used."""
    total, usable = 0.0, True
    for i in range(w.size):
        r = frame[i]
        usable &= sensors[2, i] < r < sensors[3, i]
        w[i] = (r - sensors[0, i]) * sensors[1, i]
        total += w[i] * w[i]
    return total if usable else math.nan


@compiled(frames="readings")
def project_frames(readings, sensors, basis, edges, shapes, squares, far, nodes, table, settings, out):
    """Fill `out` (f,), records of a `Layout`; status is -1 where reckoning ends or a sensor is lacking.

    readings (f, n), raw; sensors (4, n): offset, 1/noise, low and high end of the range; basis (n, 2, padded) and edges
    (4, padded): the scan, at m positions for each of `squares` (widths,) of the half width, then at the `nodes` (k,) of
    each stretch beyond the search, then zeros up to `padded` (`scan_geometry`); shapes (3, widths m): as in
    `between`, or (3, 0) where any normal force will do; far (stretches, cells, 5, 2, n): as in `outside`; table
    (cells, 5, 2, n) or (cells, widths, 10 n): whitened responses; settings (1,): `search.SETTINGS`.
    """
    told = settings[0]
    n, count = readings.shape[1], _MANY if table.ndim == 3 else FEW
    heights = room_for(basis, edges, shapes, squares.size * told.positions, far.shape[0] * nodes.size)
    ends = np.array([told.first, told.last, told.least_square, told.most_square])
    fits = np.zeros(count + 2, WIDE_FIT if table.ndim == 3 else LINE_FIT)
    room = FrameRoom(
        heights, modelled(table, told), ends, ends.copy(), np.empty(n), np.empty(count), np.zeros((count, 2)), fits,
        np.zeros(2, LINE_FIT), np.empty(10),
    )  # fmt: skip
    _each(readings, sensors, squares, far, nodes, table, told, room, out)


@compiled(borrows=True)
def _each(readings, sensors, squares, far, nodes, table, told, room, out):
    """Frame by frame; arguments as of `project_frames`."""
    heights, model, ends, held, w, score, at, fits, far_fits, c = room
    cone = Limits(told.friction, told.least, told.most)
    s = heights.nodes[1 : heights.size + 1].reshape(squares.size, told.positions)
    spare, trial = fits[-2], fits[-1]
    for f in range(readings.shape[0]):
        row = out[f]
        _emptied(table, row)
        total = whitened(readings[f], sensors, w)
        if not total < MOST_CHI2:
            row.status = _PENDING
            continue
        far_top = survey(w, heights, told)
        if table.ndim == 3:
            tops = highest(s, told.first, told.pace, squares, score, at)
        else:
            tops = peaks(heights.nodes, told.first, told.pace, heights.words, heights.peak, score, at)
        best, second = _climbed(w, table, model, cone, ends, told.apart, 1e-14 * total, score[:tops], at, fits)
        if best < 0:
            best, fits[0].n, fits[0].t, fits[0].explained, fits[0].left = 0, 0.0, 0.0, 0.0, total
        elif table.ndim == 3 and fits[best].left > told.largest:
            _widths_tried(w, table, model, cone, ends, told, s, squares, fits, best)
        fit = fits[best]
        if table.ndim == 4 and total > _LARGE:
            fit.left = _left(w, model, fit)
        row.residual = max(fit.left, 0.0)
        force2 = fit.n * fit.n + fit.t * fit.t
        if row.residual > told.largest + told.fine * force2:
            # too little for the least force may still be nothing
            row.status = _NO_CONTACT if told.least > 0.0 and total <= told.nothing else _UNEXPLAINED
            continue
        if fit.explained < told.detection:
            row.status = _NO_CONTACT
            continue
        row.y, row.n, row.t = fit.y, fit.n, fit.t
        if table.ndim == 3:
            sure, square = wide_uncertainty(fit, cone, ends, c, row), WIDE_SQUARE
        else:
            sure, square = _line_uncertainty(fit, cone, s[0], told, row), _LINE_SQUARE
        margin = 0.02 * told.pace
        sure &= told.first + margin < fit.y < told.last - margin
        # a lesser or a larger force would do better
        sure &= (told.least == 0.0 or fit.n > told.least) and fit.n < told.most
        enough = fit.explained - told.ambiguity
        sure = sure and not at_end(w, table, model, cone, held, told, s, squares, enough, spare, trial)
        if sure and far_top >= told.near * enough:
            sure = not outside(
                w, far, nodes, told, cone, held, heights.beyond, enough, model.rows[:LINE_ROWS], far_fits
            )
        sure = sure and angle_told(row, square)
        if table.ndim == 4:
            line_moments(w, model, fit, cone, told, trial, row.covariance)
        if second >= 0:
            other = fits[second]
            row.rival_y, row.rival_n, row.rival_t = other.y, other.n, other.t
            if table.ndim == 3:
                row.rival_half_width = math.sqrt(other.q)
            row.rival_chi2 = max(fit.explained - other.explained, 0.0)
            sure &= row.rival_chi2 >= told.ambiguity
        row.status = _OK if sure else _AMBIGUOUS


@compiled()
def _left(w, model, fit):
    """Chi-square of a line load: squares of what it leaves, exact however much it explains."""
    here, left = line_at(model, Along(fit.y)), 0.0
    for i in range(w.size):
        normal, tangential, _, _, _, _ = line_read(model, here, i)
        rest = w[i] - normal * fit.n - tangential * fit.t
        left += rest * rest
    return left


@compiled()
def angle_told(row, square):
    """Whether the angle is known to a radian: else a load at any other would do; square: where a covariance stands."""
    c, n, t = row.covariance, row.n, row.t
    turned = n * n * c[square[2, 2]] - 2 * n * t * c[square[1, 2]] + t * t * c[square[1, 1]]
    return turned < (n * n + t * t) ** 2


@compiled()
def _emptied(table, row):
    row.y = row.n = row.t = row.residual = row.rival_y = row.rival_n = row.rival_t = math.nan
    row.rival_chi2, c = math.inf, row.covariance
    for k in range(c.size):
        c[k] = math.nan
    if table.ndim == 3:
        row.half_width = row.low = row.high = row.rival_half_width = math.nan


@compiled(inline=True)
def _climbed(w, table, model, cone, ends, apart, digits, score, at, fits):
    """Climb from nodes `at` of heights `score` into `fits`: which is the best, and the best other one; -1: none is.

    digits: what S is known to.
    """
    fine, trial = max(1e-7 if table.ndim == 3 else 1e-6, digits), fits[-1]
    best = second = -1
    for p in range(score.size):
        # a maximum clearly lower than both already found cannot become the best or the rival
        if second >= 0 and score[p] < 0.8 * fits[second].explained:
            break
        fit = fits[p]
        # of a line load a rival will do that is near its top, as readings have no ridge along which it may stop
        rough = fine if p == 0 or table.ndim == 3 else 1e-2 * max(fits[best].explained - score[p], 1e-3)
        needed = fits[second].explained if second >= 0 and table.ndim == 4 else -math.inf
        ending = Ending(max(rough, digits), 0.0, 0.0, needed)
        top_from(w, table, model, cone, ends, at[p, 0], at[p, 1], ending, fit, trial)
        differs = best < 0 or _differ(table, fit, fits[best], apart)
        if best < 0 or fit.explained > fits[best].explained:
            best, second = p, best if differs else second
        elif differs and (second < 0 or fit.explained > fits[second].explained):
            second = p
    if best > 0 and table.ndim == 4:
        fit = fits[best]
        top_from(w, table, model, cone, ends, fit.y, 0.0, until(fine), fit, trial)
    return best, second


@compiled(inline=True)
def _differ(table, one, other, apart):
    """Whether two maxima are two contacts, and not one reached twice."""
    return abs(one.y - other.y) > apart or abs(width_of(table, one) - width_of(table, other)) > apart


@compiled()
def _widths_tried(w, table, model, cone, ends, told, s, squares, fits, best):
    """Before a frame is called unexplained, climb from the best position of each width as well; s (widths, m)."""
    spare, trial = fits[-2], fits[-1]
    for j in range(squares.size):
        k = 0
        for p in range(1, s.shape[1]):
            k = p if s[j, p] > s[j, k] else k
        top_from(w, table, model, cone, ends, told.first + k * told.pace, squares[j], until(1e-7), spare, trial)
        if spare.explained > fits[best].explained:
            fits[best] = spare


@compiled()
def _line_uncertainty(fit, cone, s, told, row):
    """Fill in the covariance of (y, N, T); whether S is about as narrow as its curvature at the top says; s (m,)."""
    c, pace = row.covariance, told.pace
    line_covariance(fit, cone, _NO_MORE, c)
    variance, m = c[0], s.size
    if not variance < (told.last - told.first) ** 2:  # the readings do not determine the position
        return False
    at = (fit.y - told.first) / pace
    if variance >= 0.25 * pace * pace:  # narrower than the scan resolves: a parabola there
        width = 0.0
        for side in (-1, 1):
            k = math.floor(at) + (1 if side > 0 else 0)
            before, last, crossing = 0.0, at, math.nan
            while 0 <= k < m:
                here = math.sqrt(max(fit.explained - s[k], 0.0))
                if here >= _SPREAD:
                    crossing = last + (k - last) * (_SPREAD - before) / (here - before)
                    break
                before, last = here, k
                k += side
            if crossing != crossing:
                crossing = at + side * _SPREAD * math.sqrt(variance) / pace
            width += abs(crossing - at) * pace
        # to where chi-square has risen by as much as at the ends of the interval: the covariance is widened to match
        widened(c, (0.5 * width / _SPREAD) ** 2)
    reach = max(6.0 * math.sqrt(c[0]), told.broad) / pace
    before, after = math.floor(at - reach), math.ceil(at + reach)
    enough = fit.explained - told.ambiguity
    return (before < 0 or s[before] <= enough) and (after >= m or s[after] <= enough)


@compiled()
def wide_uncertainty(fit, cone, ends, c, row):
    """Fill in half width, its interval and the covariance; whether the contact lies within: in width and in angle.

    c (10,): scratch.
    """
    q, least, most, turn = fit.q, ends[2], ends[3], 1.0
    half, known = math.sqrt(fit.q), least == most
    # what the readings say nothing of is infinite within rounding, not an error
    fit.u_y_y, fit.u_q_q = _MORE * fit.u_y_y, math.inf if known else _MORE * fit.u_q_q
    fit.g_n_n, fit.g_t_t = _MORE * fit.g_n_n, _MORE * fit.g_t_t
    wide_covariance(fit, cone, _NO_MORE, c)
    row.half_width = row.low = row.high = half
    sure = True
    if not known:
        spread = _SPREAD * math.sqrt(c[_OF_FIT[3, 3]])
        row.low, row.high = math.sqrt(max(q - spread, least)), math.sqrt(min(q + spread, most))
        # near no width the readings know its square alone: the interval says how much that is
        straight = 0.5 / half if half > 0.0 else math.inf
        about = 0.5 * (math.sqrt(q + spread) - math.sqrt(max(q - spread, 0.0))) / spread
        turn = min(straight, about) if spread < math.inf else straight
        sure = q < most and not 0.0 < q <= least
    k = 0
    for i in range(4):
        for j in range(i, 4):
            row.covariance[k] = c[_OF_FIT[i, j]] * (turn if i == 3 else 1.0) * (turn if j == 3 else 1.0)
            k += 1
    if 0.0 < cone.friction < math.inf:
        sure &= abs(fit.t) < cone.friction * fit.n * (1.0 - 1e-9)
    return sure


_OPEN = 0.5
"""Of the share `near` of `Stretches`, which was measured in the units of the sensors' noise: nodes are climbed from
that explain so much less."""


@compiled(frames="readings")
def doubted_frames(readings, doubt, arrays, fields, out):
    """Fill `out` as `project_frames` does, with noise sqrt(noise^2 + doubt^2) of each reading.

    doubt (f, n) [reading]; arrays: those of `project_frames` between the readings and `out`; fields (k, n, 2): the
    columns at the nodes of the scan, and of what lies beyond, in units of the noise.
    """
    sensors, basis, edges, shapes, squares, far, nodes, table, settings = arrays
    frames, n = readings.shape
    ranged, mu = shapes.shape[1], settings[0].friction
    size = squares.size * settings[0].positions
    mine, white, edge, shape = sensors.copy(), basis.copy(), edges.copy(), shapes.copy()
    beyond, tabled, told = far.copy(), table.copy(), settings.copy()
    told[0].near *= _OPEN
    largest = np.abs(fields[:size]).max()
    ratio = np.empty(n)
    cells, own_cells = table.reshape(-1, n), tabled.reshape(-1, n)
    far_cells, own_far = far.reshape(-1, n), beyond.reshape(-1, n)
    for f in range(frames):
        for i in range(n):
            more = doubt[f, i] * sensors[1, i]
            ratio[i] = 1.0 / math.sqrt(1.0 + more * more)
            mine[1, i] = sensors[1, i] * ratio[i]
        for k in range(cells.shape[0]):
            for i in range(n):
                own_cells[k, i] = cells[k, i] * ratio[i]
        for k in range(far_cells.shape[0]):
            for i in range(n):
                own_far[k, i] = far_cells[k, i] * ratio[i]
        top = 0.0
        for k in range(fields.shape[0]):
            # as `scan_geometry`
            normal2 = both = 0.0
            for i in range(n):
                a, b = fields[k, i, 0] * ratio[i], fields[k, i, 1] * ratio[i]
                normal2 += a * a
                both += a * b
                if k < size:
                    top = max(top, abs(a), abs(b))
            length = math.sqrt(normal2)
            scale = 1.0 / length if length > 0.0 else 1.0
            along = both * scale
            rest2 = 0.0
            for i in range(n):
                rest = (fields[k, i, 1] - along * scale * fields[k, i, 0]) * ratio[i]
                rest2 += rest * rest
            across = math.sqrt(rest2)
            turn = 1.0 / across if across > 0.0 else 1.0
            for i in range(n):
                a = fields[k, i, 0] * ratio[i] * scale
                white[i, 0, k] = a
                white[i, 1, k] = (fields[k, i, 1] * ratio[i] - along * a) * turn
            for side in range(2):
                sign = 2.0 * side - 1.0
                one, other = (1.0, sign * mu) if mu < math.inf else (0.0, sign)
                x, y = one * length + other * along, other * across
                far_off = math.sqrt(x * x + y * y)
                unit = 1.0 / far_off if far_off > 0.0 else 1.0
                edge[2 * side, k], edge[2 * side + 1, k] = x * unit, y * unit
            if k < ranged:
                shape[0, k], shape[1, k], shape[2, k] = length, along, across
        if largest > 0.0:
            told[0].fine = settings[0].fine * (top / largest) ** 2
        project_frames(
            readings[f : f + 1], mine, white, edge, shape, squares, beyond, nodes, tabled, told, out[f : f + 1]
        )
