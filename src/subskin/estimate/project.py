"""The compiled heart of `locate` and `fit`: variable projection, one frame at a time.

Scan S (`scan.py`), climb from its highest nodes (`climb.py`), look at the ends of the search and beyond (`ends.py`),
judge, and write a row. The table of responses says what
is sought: with three axes a contact of some width, with four a line load, for which the compiler leaves out all that
belongs to a width. Only arrays and numbers go in and out; `locate.py` prepares them, `layout.py` names the columns.
"""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled
from .climb import climb, climb_between, climb_wide, project_wide
from .ends import SINGLE, at_end, at_end_wide, outside
from .layout import LINE, WIDE
from .scan import FEW, MOST_CHI2, between, highest, peaks, scan

_MOST = 8
_LARGE = 1e5
"""Sum of the squared readings, in noises, above which too few digits are left in what a load leaves of it."""
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
_COVARIANCE, _INTERVAL = (LINE.covariance, WIDE.covariance), WIDE.interval
_RESIDUAL, _STATUS = (LINE.residual, WIDE.residual), (LINE.status, WIDE.status)
_RIVAL, _RIVAL_CHI2 = (LINE.rival, WIDE.rival), (LINE.rival_chi2, WIDE.rival_chi2)
_RIVAL_WIDTH, _HALF_WIDTH = WIDE.rival + WIDE.half_width, WIDE.half_width


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


@compiled(inline=True)
def _left(w, table, start, step, y, normal, tangential):
    """Chi-square of a line load: squares of what it leaves, exact however much it explains."""
    cells, _, _, n = table.shape
    position = (y - start) / step
    cell = min(max(int(position), 0), cells - 1)
    t = position - cell - 0.5
    chi2 = 0.0
    for i in range(n):
        an = table[cell, 3, 0, i] + t * table[cell, 4, 0, i]
        at = table[cell, 3, 1, i] + t * table[cell, 4, 1, i]
        an = table[cell, 0, 0, i] + t * (table[cell, 1, 0, i] + t * (table[cell, 2, 0, i] + t * an))
        at = table[cell, 0, 1, i] + t * (table[cell, 1, 1, i] + t * (table[cell, 2, 1, i] + t * at))
        rho = w[i] - an * normal - at * tangential
        chi2 += rho * rho
    return chi2


@compiled()
def project_frames(readings, sensors, basis, edges, shapes, squares, far, table, options, out):
    """Fill `out`, one row a frame; frames that are beyond reckoning or lack a sensor are left with status -1.

    readings (f, n), raw; sensors (4, n): offset, 1/noise, low and high end of the range; basis (n, 2, padded) and edges
    (4, padded): the scan, at m positions for each of `squares` (widths,) of the half width, then at k beyond the
    search, nodes of each stretch in `far` (stretches, cells, 5, 2, n), as in `outside`, then zeros up to `padded`
    (`scan_geometry`); shapes (3, widths m): as in `between`, or (3, 0) where any normal force will do; table
    (cells, 5, 2, n) or (cells, widths, 10 n): whitened responses; options: start and step of the table, start and step
    of the scan, mu, then the thresholds and ends of `Locator._prepare`, the last m, the share `near` and
    the nodes of `Stretches`.
    """
    wide = 1 if table.ndim == 3 else 0
    frames, n = readings.shape
    beyond, rows, padded, m = far.shape[0] * (options.size - 23), squares.size, edges.shape[1], int(options[21])
    size, ranged = rows * m, shapes.shape[1] > 0
    start, step, scan_start, scan_step, mu = options[0], options[1], options[2], options[3], options[4]
    detection, largest, ambiguity, apart, broad = options[5], options[6], options[7], options[8], options[9]
    least, most, fine, nothing = options[15], options[16], options[17], options[18]
    scan_stop = scan_start + (m - 1) * scan_step
    sums = np.empty((2, padded), dtype=np.float32)
    w = np.empty(n)
    w_single = np.empty(n, dtype=np.float32)
    heights = np.full(padded + 2, -1, dtype=np.float32)
    s, inner = heights[: size + 2], heights[1 : size + 1]
    nodewise = heights[1:-1]
    single = np.empty(beyond, dtype=np.float32)
    words = np.zeros(padded // 8, dtype=np.uint64)
    peak = words.view(np.uint8)
    count = _MOST if table.ndim == 3 else FEW
    score = np.empty(count)
    ys = np.empty(FEW)
    at = np.empty((count + 1, 2))
    fits = np.empty((count + 1, 14))
    fit = np.empty(14)
    scratch = np.empty((6, n))
    if table.ndim == 3:
        a, c = np.empty((2, 6, 2 * n)), np.empty((3, 10 * n + table.shape[1] + 3))
    for f in range(frames):
        row = out[f]
        total = whitened(readings[f], sensors, w)
        row[:] = math.nan
        row[_RIVAL_CHI2[wide]] = math.inf
        if not total < MOST_CHI2:
            row[_STATUS[wide]] = _PENDING
            continue
        for i in range(n):
            w_single[i] = w[i]
        scan(w_single, basis, edges, sums, nodewise)
        far_top = np.float32(0.0)
        for k in range(beyond):
            single[k] = heights[size + 1 + k]
            far_top = max(far_top, single[k])
        for k in range(size + 1, padded + 1):
            heights[k] = np.float32(-1)
        if ranged:
            between(sums, shapes, mu, least, most, inner)
        best = second = -1
        if table.ndim == 3:
            best, second = _climbed(w, inner.reshape(rows, m), squares, table, options, total, score, at, fits, c, a)
        else:
            for p in range(peaks(heights, scan_start, scan_step, words, peak, score, ys)):
                # a maximum clearly lower than both already found cannot become the best or the rival
                if second >= 0 and score[p] < 0.8 * fits[second, 2]:
                    break
                y = ys[p]
                lo, hi = max(y - 1.5 * scan_step, scan_start), min(y + 1.5 * scan_step, scan_stop)
                tolerance = 1e-5 if p == 0 else 1e-2 * max(fits[best, 2] - score[p], 1e-3)
                if ranged:
                    y = climb_between(w, table, start, step, mu, least, most, y, lo, hi, tolerance, scratch, fits[p])
                else:
                    y = climb(w, table, start, step, mu, y, lo, hi, tolerance, scratch, fits[p], p > 0)
                at[p, 0] = y
                if best < 0 or fits[p, 2] > fits[best, 2]:
                    best, second = p, best
                elif second < 0 or fits[p, 2] > fits[second, 2]:
                    second = p
            if best >= 0:
                centre, careful = ys[best], best == 0
                for _ in range(m):
                    y = at[best, 0]
                    inside = abs(y - centre) < 1.49 * scan_step or not scan_start < y < scan_stop
                    if careful and inside:
                        break
                    # of readings of 1e4 noises the scan's single precision leaves the top open by a step or more
                    lo, hi = max(y - 1.5 * scan_step, scan_start), min(y + 1.5 * scan_step, scan_stop)
                    centre, careful = y, True
                    at[best, 0] = climb_between(
                        w, table, start, step, mu, least, most, y, lo, hi, 1e-5, scratch, fits[best]
                    )
        explained, residual = 0.0, total
        if best >= 0:
            y, normal, tangential, explained = at[best, 0], fits[best, 0], fits[best, 1], fits[best, 2]
            if table.ndim == 3:
                project_wide(
                    w, table, start, step, options[10], mu, y, at[best, 1], c, a[0], fits[best], least, most
                )  # fmt: skip
                residual = 0.0
                for i in range(n):
                    residual += (w[i] - a[0, 0, i] * normal - a[0, 0, n + i] * tangential) ** 2
            elif total > _LARGE:
                residual = _left(w, table, start, step, y, normal, tangential)
            else:
                residual = max(total - explained, 0.0)
        row[_RESIDUAL[wide]] = residual
        force2 = normal * normal + tangential * tangential if best >= 0 else 0.0
        if residual > largest + fine * force2:
            # too little for the least force may still be nothing
            row[_STATUS[wide]] = _NO_CONTACT if least > 0.0 and total <= nothing else _UNEXPLAINED
            continue
        if explained < detection:
            row[_STATUS[wide]] = _NO_CONTACT
            continue
        row[0], row[1], row[2] = y, normal, tangential
        if table.ndim == 3:
            row[_HALF_WIDTH] = math.sqrt(at[best, 1])
            _uncertainty(a[0], options, at[best], fits[best], row)
            status = _OK if _within(options, at[best], fits[best]) else _AMBIGUOUS
            if at_end_wide(w, table, options, inner.reshape(rows, m), squares, explained - ambiguity, c, a, fit):
                status = _AMBIGUOUS
        else:
            _covariance(fits[best], mu, row)
            status = _OK
            margin = 0.02 * scan_step
            if y <= scan_start + margin or y >= scan_stop - margin:
                status = _AMBIGUOUS
            ends = max(inner[0], inner[m - 1]) * (1.0 + SINGLE)
            if ends >= explained - ambiguity and at_end(w, table, options, inner, explained - ambiguity, scratch, fit):
                status = _AMBIGUOUS
            if row[_COVARIANCE[0]] < (scan_stop - scan_start) ** 2:
                _widen(s, scan_start, scan_step, y, explained, row)
                # the profile has to be about as narrow as its curvature at the top says
                reach = max(6.0 * math.sqrt(row[_COVARIANCE[0]]), broad)
                before = math.floor((y - reach - scan_start) / scan_step)
                after = math.ceil((y + reach - scan_start) / scan_step)
                if before >= 0 and explained - s[before + 1] < ambiguity:
                    status = _AMBIGUOUS
                if after < m and explained - s[after + 1] < ambiguity:
                    status = _AMBIGUOUS
            else:  # the readings do not determine the position
                status = _AMBIGUOUS
        if (least > 0.0 and normal <= least) or normal >= most:  # a lesser or a larger force would do better
            status = _AMBIGUOUS
        if far_top >= options[22] * (explained - ambiguity) and outside(
            w, far, options, single, explained - ambiguity, scratch, fit
        ):
            status = _AMBIGUOUS
        k = _COVARIANCE[wide]
        nn, nt, tt = (row[k + 4], row[k + 5], row[k + 7]) if wide else (row[k + 3], row[k + 4], row[k + 5])
        turned = normal * normal * tt - 2 * normal * tangential * nt + tangential * tangential * nn
        if not turned < force2 * force2:  # nor the angle, to a radian: a load at any other would do
            status = _AMBIGUOUS
        if second >= 0 and (wide or abs(at[second, 0] - y) > apart):
            rival = _RIVAL[wide]
            row[rival], row[rival + 1], row[rival + 2] = at[second, 0], fits[second, 0], fits[second, 1]
            if table.ndim == 3:
                row[_RIVAL_WIDTH] = math.sqrt(at[second, 1])
            worse = max(explained - fits[second, 2], 0.0)
            row[_RIVAL_CHI2[wide]] = worse
            if worse < ambiguity:
                status = _AMBIGUOUS
        row[_STATUS[wide]] = status


@compiled()
def _climbed(w, s, squares, table, options, total, score, at, fits, c, a):
    """Best and second-best contact over position and width, as rows of `at` and `fits`; -1 where there is none."""
    start, step, scan_start, scan_step, mu = options[0], options[1], options[2], options[3], options[4]
    largest, apart, square, ends = options[6], options[8], options[10], options[11:15]
    least, most = options[15], options[16]
    rows, m = s.shape
    best = second = -1
    for p in range(highest(s, scan_start, scan_step, squares, score, at)):
        if second >= 0 and score[p] < 0.8 * fits[second, 2]:
            break
        at[p, 0], at[p, 1] = climb_wide(
            w, table, start, step, square, mu, at[p, 0], at[p, 1], ends, c, a, fits[p], least, most
        )
        if best < 0 or fits[p, 2] > fits[best, 2]:
            if best >= 0 and _differ(at, best, p, apart):
                second = best
            best = p
        elif _differ(at, best, p, apart) and (second < 0 or fits[p, 2] > fits[second, 2]):
            second = p
    if best >= 0 and total - fits[best, 2] > largest:
        # before a frame is called unexplained, the best position of each width is tried as well
        spare = score.size
        for j in range(rows):
            k = 0
            for p in range(1, m):
                k = p if s[j, p] > s[j, k] else k
            y = scan_start + k * scan_step
            at[spare, 0], at[spare, 1] = climb_wide(
                w, table, start, step, square, mu, y, squares[j], ends, c, a, fits[spare], least, most
            )
            if fits[spare, 2] > fits[best, 2]:
                at[best], fits[best] = at[spare], fits[spare]
    return best, second


@compiled()
def _differ(at, i, j, apart):
    """Whether two maxima are two contacts, and not one reached twice."""
    return abs(at[i, 0] - at[j, 0]) > apart or abs(math.sqrt(at[i, 1]) - math.sqrt(at[j, 1])) > apart


@compiled()
def _within(options, at, fit):
    """Whether a contact lies within the search: in position, width and angle."""
    low, high, least, most, mu = options[11], options[12], options[13], options[14], options[4]
    inside = low < at[0] < high
    if most > least:
        inside &= at[1] < most and not 0.0 < at[1] <= least
    if 0.0 < mu < math.inf:
        inside &= abs(fit[1]) < mu * fit[0] * (1.0 - 1e-9)
    return inside


@compiled(inline=True)
def _covariance(fit, mu, row):
    """Inverse Fisher information of (y, N, T); six entries."""
    c = _COVARIANCE[0]
    g11, g12, g22, a1, a2, uu = fit[7], fit[8], fit[9], fit[10], fit[11], fit[12]
    if mu == 0.0:  # there is no drag, and that is known: two unknowns
        det = max(uu * g11 - a1 * a1, 0.0)
        row[c], row[c + 1], row[c + 2] = g11 / det, -a1 / det, 0.0
        row[c + 3], row[c + 4], row[c + 5] = uu / det, 0.0, 0.0
        return
    yy = g11 * g22 - g12 * g12
    yn = g12 * a2 - a1 * g22
    yt = a1 * g12 - g11 * a2
    # 0, and so an infinite variance, where rounding has made it less
    det = max(uu * yy + a1 * yn + a2 * yt, 0.0)
    row[c], row[c + 1], row[c + 2] = yy / det, yn / det, yt / det
    row[c + 3] = (uu * g22 - a2 * a2) / det
    row[c + 4] = (a1 * a2 - uu * g12) / det
    row[c + 5] = (uu * g11 - a1 * a1) / det


@compiled()
def _widen(s, scan_start, scan_step, y, explained, row):
    """Where the profile of chi-square is wider than its curvature at the best y says, widen the covariance to match.

    The distance to where chi-square has risen by 1.96^2 is read off the scan on either side.
    """
    c = _COVARIANCE[0]
    variance = row[c]
    if variance < 0.25 * scan_step * scan_step:  # narrower than the scan resolves: the profile is a parabola there
        return
    m = s.size - 2
    width = 0.0
    for side in (-1, 1):
        k = math.floor((y - scan_start) / scan_step) + (1 if side > 0 else 0)
        before, at = 0.0, y
        crossing = math.nan
        while 0 <= k < m:
            here = math.sqrt(max(explained - s[k + 1], 0.0))
            position = scan_start + k * scan_step
            if here >= 1.96:
                crossing = at + (position - at) * (1.96 - before) / (here - before)
                break
            before, at = here, position
            k += side
        if crossing != crossing:
            crossing = y + side * 1.96 * math.sqrt(variance)
        width += abs(crossing - y)
    ratio = (0.5 * width / 1.96) ** 2 / variance
    if ratio > 1.0:
        c1, c2 = row[c + 1], row[c + 2]
        extra = (ratio - 1.0) / variance
        row[c] *= ratio
        row[c + 1] *= ratio
        row[c + 2] *= ratio
        row[c + 3] += extra * c1 * c1
        row[c + 4] += extra * c1 * c2
        row[c + 5] += extra * c2 * c2


@compiled()
def _uncertainty(a, options, at, fit, row):
    """Covariance of (position, N, T, half width), and the 95 % interval of the half width; a as in `project_wide`."""
    n = a.shape[1] // 2
    mu, q, least, most = options[4], at[1], options[13], options[14]
    normal, tangential = fit[0], fit[1]
    wide = most > least
    size = 4 if wide else 3
    columns = np.empty((size, n))
    for i in range(n):
        columns[0, i] = a[1, i] * normal + a[1, n + i] * tangential
        columns[1, i], columns[2, i] = a[0, i], (a[0, n + i] if mu > 0.0 else 0.0)
        if wide:
            columns[3, i] = a[2, i] * normal + a[2, n + i] * tangential
    scale = np.empty(size)
    for j in range(size):
        total = 0.0
        for i in range(n):
            total += columns[j, i] * columns[j, i]
        scale[j] = math.sqrt(total) if total > 0.0 else 1.0
    information = np.zeros((size, size))
    for j in range(size):
        for k in range(size):
            for i in range(n):
                information[j, k] += columns[j, i] * columns[k, i] / (scale[j] * scale[k])
        information[j, j] += 1e-14  # what the readings say nothing of is infinite within rounding, not an error
    covariance = np.linalg.inv(information)
    # how far (position, N, T, half width) move with the unknowns in their scales; drag that is not there does not
    moves = np.zeros(4)
    moves[0], moves[1], moves[2] = 1.0 / scale[0], 1.0 / scale[1], (1.0 / scale[2] if mu > 0.0 else 0.0)
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
    k = _COVARIANCE[1]
    for i in range(4):
        for j in range(i, 4):
            known = i >= size or j >= size
            row[k] = 0.0 if known else moves[i] * covariance[i, j] * moves[j]
            k += 1
