"""The compiled heart of `fit`: place and width by variable projection, one frame at a time.

As in `_kernel.py` the forces are eliminated at each trial; what remains is S(y, q), q = a^2 being the square of the
half width, in which the readings are smooth down to no width at all. S is scanned on a grid of both; its best maxima
are refined by Levenberg and Marquardt's method on the projected residual (Golub and Pereyra 1973, Kaufman 1975).
"""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from .shape import COVARIANCE, FORCE, HALF_WIDTH, INTERVAL, POSITION, RESIDUAL, RIVAL, STATUS

_CANDIDATES = 8
_STEPS = 40
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0

_compiled = nb.njit(
    cache=True, nogil=True, fastmath={"nsz", "arcp", "contract", "reassoc"}, error_model="numpy"
)


@_compiled
def _rows(table, start, step, square, y, q, c, a):
    """The two columns of A and their slopes in y and q at (y, q): a (6, n) = A_N, A_T, their d/dy, their d/dq.

    table (cells, widths, 5, 2, n); c (2, 5, 2, n): scratch, the polynomial in t at this width, and its slope in q.
    """
    cells, widths, powers, _, n = table.shape
    position = (y - start) / step
    cell = min(max(int(position), 0), cells - 1)
    t = position - cell - 0.5
    x = 2.0 * q / square - 1.0
    c[:] = 0.0
    before, now, slope_before, slope = 1.0, x, 0.0, 1.0
    for w in range(widths):
        if w == 0:
            value, rise = 1.0, 0.0
        elif w == 1:
            value, rise = x, 1.0
        else:
            value, rise = 2 * x * now - before, 2 * now + 2 * x * slope - slope_before
            before, now, slope_before, slope = now, value, slope, rise
        rise *= 2.0 / square
        part = table[cell, w]
        for k in range(powers):
            for load in range(2):
                for i in range(n):
                    c[0, k, load, i] += value * part[k, load, i]
                    c[1, k, load, i] += rise * part[k, load, i]
    d = 1.0 / step
    for load in range(2):
        for i in range(n):
            v = g = s = 0.0
            for k in range(powers - 1, -1, -1):
                g = g * t + v
                v = v * t + c[0, k, load, i]
                s = s * t + c[1, k, load, i]
            a[load, i], a[2 + load, i], a[4 + load, i] = v, d * g, s


@_compiled
def _forces(w, a, mu, fit):
    """Best admissible forces and S into fit[0:3], and the inverse of what the cone leaves free into fit[3:6]."""
    n = w.size
    g11 = g12 = g22 = b1 = b2 = 0.0
    for i in range(n):
        g11 += a[0, i] * a[0, i]
        g12 += a[0, i] * a[1, i]
        g22 += a[1, i] * a[1, i]
        b1 += a[0, i] * w[i]
        b2 += a[1, i] * w[i]
    det = g11 * g22 - g12 * g12
    inverse = 1.0 / det
    normal, tangential = (g22 * b1 - g12 * b2) * inverse, (g11 * b2 - g12 * b1) * inverse
    i11, i12, i22 = g22 * inverse, -g12 * inverse, g11 * inverse
    if not (det > 1e-14 * g11 * g22 and normal >= 0.0 and abs(tangential) <= mu * normal):
        best = normal = tangential = i11 = i12 = i22 = 0.0
        for side in range(2):
            sign = 2.0 * side - 1.0
            e1, e2 = (1.0, sign * mu) if mu < math.inf else (0.0, sign)
            size = e1 * e1 * g11 + 2 * e1 * e2 * g12 + e2 * e2 * g22
            along = e1 * b1 + e2 * b2
            if along > 0.0 and size > 0.0 and along * along > best * size:
                best = along * along / size
                normal, tangential = along / size * e1, along / size * e2
                i11, i12, i22 = e1 * e1 / size, e1 * e2 / size, e2 * e2 / size
    fit[0], fit[1], fit[2] = normal, tangential, b1 * normal + b2 * tangential
    fit[3], fit[4], fit[5] = i11, i12, i22


@_compiled
def _slopes(w, a, fit):
    """Gradient of S/2 in (y, q) and the projected information matrix: g_y, g_q, m_yy, m_yq, m_qq."""
    n = w.size
    normal, tangential, i11, i12, i22 = fit[0], fit[1], fit[3], fit[4], fit[5]
    gy = gq = yy = yq = qq = 0.0
    p1 = p2 = r1 = r2 = 0.0
    for i in range(n):
        u = a[2, i] * normal + a[3, i] * tangential
        v = a[4, i] * normal + a[5, i] * tangential
        rho = w[i] - a[0, i] * normal - a[1, i] * tangential
        gy += rho * u
        gq += rho * v
        yy += u * u
        yq += u * v
        qq += v * v
        p1 += a[0, i] * u
        p2 += a[1, i] * u
        r1 += a[0, i] * v
        r2 += a[1, i] * v
    yy -= p1 * (i11 * p1 + i12 * p2) + p2 * (i12 * p1 + i22 * p2)
    yq -= r1 * (i11 * p1 + i12 * p2) + r2 * (i12 * p1 + i22 * p2)
    qq -= r1 * (i11 * r1 + i12 * r2) + r2 * (i12 * r1 + i22 * r2)
    return gy, gq, yy, yq, qq


@_compiled
def _refine(w, table, start, step, square, mu, y, q, ends, c, a, trial, fit):
    """Climb S from (y, q) within ends = (y low, y high, q low, q high); returns y and q, the rest in fit and a."""
    _rows(table, start, step, square, y, q, c, a)
    _forces(w, a, mu, fit)
    damping = 1e-4
    for _ in range(_STEPS):
        gy, gq, yy, yq, qq = _slopes(w, a, fit)
        # what stands at an end and would go on beyond stays
        fixed_y = (y <= ends[0] and gy < 0.0) or (y >= ends[1] and gy > 0.0)
        fixed_q = ends[2] == ends[3] or (q <= ends[2] and gq < 0.0) or (q >= ends[3] and gq > 0.0)
        done = True
        while damping < 1e12:
            hy, hq = yy * (1.0 + damping), qq * (1.0 + damping)
            if fixed_y and fixed_q:
                dy = dq = 0.0
            elif fixed_q:
                dy, dq = gy / hy, 0.0
            elif fixed_y:
                dy, dq = 0.0, gq / hq
            else:
                det = hy * hq - yq * yq
                dy, dq = (hq * gy - yq * gq) / det, (hy * gq - yq * gy) / det
            new_y = min(max(y + dy, ends[0]), ends[1])
            new_q = min(max(q + dq, ends[2]), ends[3])
            dy, dq = new_y - y, new_q - q
            if not abs(gy * dy) + abs(gq * dq) > 1e-7:
                break
            _rows(table, start, step, square, new_y, new_q, c, a)
            _forces(w, a, mu, trial)
            if trial[2] > fit[2]:
                y, q = new_y, new_q
                fit[:6] = trial[:6]
                damping = max(0.1 * damping, 1e-9)
                done = False
                break
            damping *= 10.0
        if done:
            break
    _rows(table, start, step, square, y, q, c, a)
    return y, q


@_compiled
def _uncertainty(w, a, fit, mu, q, ends, row):
    """Covariance of (position, force, angle, half width), and the 95 % interval of the half width."""
    n = w.size
    normal, tangential = fit[0], fit[1]
    wide = ends[3] > ends[2]
    size = 4 if wide else 3
    information = np.zeros((size, size))
    columns = np.empty((size, n))
    for i in range(n):
        columns[0, i] = a[2, i] * normal + a[3, i] * tangential
        columns[1, i], columns[2, i] = a[0, i], (a[1, i] if mu > 0.0 else 0.0)
        if wide:
            columns[3, i] = a[4, i] * normal + a[5, i] * tangential
    scale = np.empty(size)
    for j in range(size):
        total = 0.0
        for i in range(n):
            total += columns[j, i] * columns[j, i]
        scale[j] = math.sqrt(total) if total > 0.0 else 1.0
    for j in range(size):
        for k in range(size):
            for i in range(n):
                information[j, k] += columns[j, i] * columns[k, i] / (scale[j] * scale[k])
    for j in range(size):
        information[j, j] += (
            1e-14  # what the readings say nothing of is infinite within rounding, not an error
        )
    covariance = np.linalg.inv(information)
    force = math.hypot(normal, tangential)
    cos, sin = normal / force, tangential / force
    turn = np.zeros((4, size))
    turn[0, 0] = 1.0 / scale[0]
    turn[1, 1], turn[2, 1] = cos / scale[1], -sin / force / scale[1]
    if mu > 0.0:  # else there is no drag, and that is known
        turn[1, 2], turn[2, 2] = sin / scale[2], cos / force / scale[2]
    half = math.sqrt(q)
    row[INTERVAL] = row[INTERVAL + 1] = half
    if wide:
        spread = 1.959964 * math.sqrt(covariance[3, 3]) / scale[3]
        low, high = math.sqrt(max(q - spread, ends[2])), math.sqrt(min(q + spread, ends[3]))
        row[INTERVAL], row[INTERVAL + 1] = low, high
        # near no width the readings know its square alone: the interval says how much that is
        straight = 0.5 / half if half > 0.0 else math.inf
        turn[3, 3] = (
            min(straight, 0.5 * (math.sqrt(q + spread) - math.sqrt(max(q - spread, 0.0))) / spread) / scale[3]
        )
    full = turn @ covariance @ turn.T
    k = 0
    for i in range(4):
        for j in range(i, 4):
            row[COVARIANCE + k] = full[i, j]
            k += 1


@_compiled
def fit_frames(readings, sensors, basis, edges, positions, squares, table, options, out):
    """Fill `out`, one row a frame; the columns are named in `shape.py`.

    basis (n, 2, widths, m) and edges (4, widths, m): the scan at `positions` (m,) and `squares` (widths,); table
    (cells, widths, 5, 2, n): whitened; options: start and step of the table, the square of its widest, mu, the ends
    of y and of q, then the thresholds of `fit._prepare`.
    """
    frames, n = readings.shape
    rows, m = squares.size, positions.size
    start, step, square, mu = options[0], options[1], options[2], options[3]
    ends = options[4:8]
    detection, largest, ambiguity, apart = options[8], options[9], options[10], options[11]
    w = np.empty(n)
    s = np.empty((rows, m), dtype=np.float32)
    a, c = np.empty((6, n)), np.empty((2, 5, 2, n))
    fits, trial = np.empty((_CANDIDATES + 1, 6)), np.empty(6)
    score, at = np.empty(_CANDIDATES), np.empty((_CANDIDATES + 1, 2))
    for f in range(frames):
        row = out[f]
        row[:] = math.nan
        row[RIVAL + 4] = math.inf
        total, usable = 0.0, True
        for i in range(n):
            r = readings[f, i]
            usable &= sensors[2, i] < r < sensors[3, i]
            w[i] = (r - sensors[0, i]) * sensors[1, i]
            total += w[i] * w[i]
        if not (usable and total < math.inf):
            row[STATUS] = _PENDING
            continue
        _scan(w, basis, edges, s)
        count = _starts(s, positions, squares, score, at)
        best = second = -1
        for p in range(count):
            at[p, 0], at[p, 1] = _refine(
                w, table, start, step, square, mu, at[p, 0], at[p, 1], ends, c, a, trial, fits[p]
            )
            if best < 0 or fits[p, 2] > fits[best, 2]:
                if best >= 0 and _differ(at, best, p, apart):
                    second = best
                best = p
            elif _differ(at, best, p, apart) and (second < 0 or fits[p, 2] > fits[second, 2]):
                second = p
        if best >= 0 and total - fits[best, 2] > largest:
            # before a frame is called unexplained, the best place of each width is tried as well
            spare = _CANDIDATES
            for j in range(rows):
                k = 0
                for p in range(1, m):
                    k = p if s[j, p] > s[j, k] else k
                at[spare, 0], at[spare, 1] = _refine(
                    w,
                    table,
                    start,
                    step,
                    square,
                    mu,
                    positions[k],
                    squares[j],
                    ends,
                    c,
                    a,
                    trial,
                    fits[spare],
                )
                if fits[spare, 2] > fits[best, 2]:
                    at[best], fits[best] = at[spare], fits[spare]
        explained = fits[best, 2] if best >= 0 else 0.0
        row[RESIDUAL] = max(total - explained, 0.0)
        if row[RESIDUAL] > largest:
            row[STATUS] = _UNEXPLAINED
            continue
        if explained < detection:
            row[STATUS] = _NO_CONTACT
            continue
        y, q = at[best, 0], at[best, 1]
        normal, tangential = fits[best, 0], fits[best, 1]
        row[POSITION], row[FORCE] = y, math.hypot(normal, tangential)
        row[FORCE + 1], row[HALF_WIDTH] = math.atan2(tangential, normal), math.sqrt(q)
        _rows(table, start, step, square, y, q, c, a)
        _uncertainty(w, a, fits[best], mu, q, ends, row)
        status = _OK
        beyond = y <= ends[0] or y >= ends[1]
        if ends[3] > ends[2]:
            beyond |= q >= ends[3] or 0.0 < q <= ends[2]
        if 0.0 < mu < math.inf:
            beyond |= abs(tangential) >= mu * normal * (1.0 - 1e-9)
        if beyond or not row[COVARIANCE + 7] < 1.0:
            status = _AMBIGUOUS  # at the edge of the search, in place, width or angle; or at any angle
        if second >= 0:
            row[RIVAL] = at[second, 0]
            row[RIVAL + 1] = math.hypot(fits[second, 0], fits[second, 1])
            row[RIVAL + 2] = math.atan2(fits[second, 1], fits[second, 0])
            row[RIVAL + 3] = math.sqrt(at[second, 1])
            row[RIVAL + 4] = max(explained - fits[second, 2], 0.0)
            if row[RIVAL + 4] < ambiguity:
                status = _AMBIGUOUS
        row[STATUS] = status


@_compiled
def _differ(at, i, j, apart):
    """Whether two maxima are two contacts, and not one reached twice."""
    return abs(at[i, 0] - at[j, 0]) > apart or abs(math.sqrt(at[i, 1]) - math.sqrt(at[j, 1])) > apart


@_compiled
def _starts(s, positions, squares, score, at):
    """The highest points of the scan s, the best first, as many as `score` holds: their number."""
    rows, m, most = squares.size, positions.size, score.size
    count = 0
    for j in range(rows):
        for k in range(m):
            here = s[j, k]
            if not here > 0.0 or not _highest(s, j, k):
                continue
            position = count
            while position > 0 and score[position - 1] < here:
                position -= 1
            if position < most:
                for p in range(min(count, most - 1), position, -1):
                    score[p] = score[p - 1]
                    at[p] = at[p - 1]
                score[position] = here
                at[position, 0], at[position, 1] = positions[k], squares[j]
                count = min(count + 1, most)
    return count


@_compiled
def _highest(s, j, k):
    """Whether s[j, k] is the highest of its neighbours."""
    rows, m = s.shape
    here = s[j, k]
    for dj in range(-1, 2):
        for dk in range(-1, 2):
            a, b = j + dj, k + dk
            if (dj != 0 or dk != 0) and 0 <= a < rows and 0 <= b < m:
                before = dj < 0 or (dj == 0 and dk < 0)
                if s[a, b] > here or (before and s[a, b] == here):
                    return False
    return True


@_compiled
def _scan(w, basis, edges, s):
    """S on the grid of widths and places, as in `_kernel._scan`."""
    n, _, rows, m = basis.shape
    for j in range(rows):
        for k in range(m):
            c1 = c2 = 0.0
            for i in range(n):
                c1 += w[i] * basis[i, 0, j, k]
                c2 += w[i] * basis[i, 1, j, k]
            m1, m2, p1, p2 = edges[0, j, k], edges[1, j, k], edges[2, j, k], edges[3, j, k]
            low, high = c1 * m1 + c2 * m2, c1 * p1 + c2 * p2
            along = max(low, high, 0.0)
            inside = min(m1 * c2 - m2 * c1, c1 * p2 - c2 * p1)
            s[j, k] = c1 * c1 + c2 * c2 if inside > 0.0 else along * along
