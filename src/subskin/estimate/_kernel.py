"""The compiled heart of `locate`: variable projection, one frame at a time.

For a load at y the whitened readings are w = A(y) theta + noise, theta = (N, T), A of shape (n, 2). With the forces
eliminated, the explained part of chi-square is S(y) = max over admissible theta of |w|^2 - |w - A theta|^2; theta is
admissible in the cone N >= 0, |T| <= mu N. S is scanned on a grid, its local maxima are refined by a safeguarded Newton
iteration with exact first and second derivatives (docs/locating.md; Golub and Pereyra 1973 without the cone).

Only arrays and numbers go in and out; `locate.py` prepares them.
"""

from __future__ import annotations

import math

import numba as nb
import numpy as np

from .estimate import COVARIANCE, FORCE, POSITION, RESIDUAL, RIVAL, STATUS

_CANDIDATES = 4
_OK, _AMBIGUOUS, _NO_CONTACT, _UNEXPLAINED, _PENDING = 0.0, 1.0, 2.0, 3.0, -1.0

_fast = {"nsz", "arcp", "contract", "reassoc"}  # not nnan, ninf: NaN and inf have a meaning here


@nb.njit(cache=True, nogil=True, fastmath=_fast, error_model="numpy", inline="always")
def _scan(w, basis, edges, c, s, peak):
    """S on the grid in s[1:-1], whose ends are -1, and a 1 in `peak` at each of its maxima; in single precision.

    w (n,); basis (n, 2, m): orthonormal columns; edges (4, m): unit edges of the cone in them; c (2, m): scratch.
    """
    n, _, m = basis.shape
    for k in range(m):
        c[0, k] = np.float32(0)
        c[1, k] = np.float32(0)
    i = 0
    while i + 4 <= n:  # four sensors a pass: the running sums go through memory less often
        w0, w1, w2, w3 = w[i], w[i + 1], w[i + 2], w[i + 3]
        for k in range(m):
            c[0, k] += (w0 * basis[i, 0, k] + w1 * basis[i + 1, 0, k]) + (
                w2 * basis[i + 2, 0, k] + w3 * basis[i + 3, 0, k]
            )
            c[1, k] += (w0 * basis[i, 1, k] + w1 * basis[i + 1, 1, k]) + (
                w2 * basis[i + 2, 1, k] + w3 * basis[i + 3, 1, k]
            )
        i += 4
    while i < n:
        for k in range(m):
            c[0, k] += w[i] * basis[i, 0, k]
            c[1, k] += w[i] * basis[i, 1, k]
        i += 1
    for k in range(m):
        c1, c2 = c[0, k], c[1, k]
        m1, m2, p1, p2 = edges[0, k], edges[1, k], edges[2, k], edges[3, k]
        low, high = c1 * m1 + c2 * m2, c1 * p1 + c2 * p2
        along = low if low > high else high
        along = along if along > 0 else np.float32(0)
        left, right = m1 * c2 - m2 * c1, c1 * p2 - c2 * p1
        inside = left if left < right else right
        s[k + 1] = c1 * c1 + c2 * c2 if inside > 0 else along * along
    for k in range(m):
        peak[k] = (s[k + 1] > s[k]) & (s[k + 1] >= s[k + 2])


@nb.njit(cache=True, nogil=True, fastmath=_fast, error_model="numpy", inline="always")
def _fit(w, table, start, step, mu, y, a, fit):
    """The best admissible forces for a load at y, with derivatives of S/2.

    a: scratch (6, n). fit: N, T, S, g = dS/2dy, dg/dy, dN/dy, dT/dy, then sums over the sensors for the covariance.
    """
    cells, _, _, n = table.shape
    position = (y - start) / step
    cell = min(max(int(position), 0), cells - 1)
    t = position - cell - 0.5
    d1 = 1.0 / step
    d2 = d1 * d1
    g11 = g12 = g22 = b1 = b2 = 0.0
    for i in range(n):
        c1, c2, c3, c4 = (
            table[cell, 1, 0, i],
            table[cell, 2, 0, i],
            table[cell, 3, 0, i],
            table[cell, 4, 0, i],
        )
        an = table[cell, 0, 0, i] + t * (c1 + t * (c2 + t * (c3 + t * c4)))
        a[0, i] = d1 * (c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4))))
        a[1, i] = d2 * (2 * c2 + t * (6 * c3 + t * (12 * c4)))
        c1, c2, c3, c4 = (
            table[cell, 1, 1, i],
            table[cell, 2, 1, i],
            table[cell, 3, 1, i],
            table[cell, 4, 1, i],
        )
        at = table[cell, 0, 1, i] + t * (c1 + t * (c2 + t * (c3 + t * c4)))
        a[2, i] = d1 * (c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4))))
        a[3, i] = d2 * (2 * c2 + t * (6 * c3 + t * (12 * c4)))
        a[4, i] = an
        a[5, i] = at
        g11 += an * an
        g12 += an * at
        g22 += at * at
        b1 += an * w[i]
        b2 += at * w[i]
    det = g11 * g22 - g12 * g12
    inverse = 1.0 / det
    normal = (g22 * b1 - g12 * b2) * inverse
    tangential = (g11 * b2 - g12 * b1) * inverse
    # inverse of the 2 x 2 normal matrix within what the cone leaves free: all, one edge, or nothing
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
    uu = rv = ru = q1 = q2 = a1 = a2 = 0.0
    for i in range(n):
        an, at, dn, dt = a[4, i], a[5, i], a[0, i], a[2, i]
        rho = w[i] - an * normal - at * tangential
        u = dn * normal + dt * tangential
        uu += u * u
        ru += rho * u
        rv += rho * (a[1, i] * normal + a[3, i] * tangential)
        q1 += dn * rho
        q2 += dt * rho
        a1 += an * u
        a2 += at * u
    r1, r2 = q1 - a1, q2 - a2
    n1, t1 = i11 * r1 + i12 * r2, i12 * r1 + i22 * r2
    fit[0], fit[1] = normal, tangential
    fit[2] = b1 * normal + b2 * tangential
    fit[3] = ru
    fit[4] = rv - uu + r1 * n1 + r2 * t1
    fit[5], fit[6] = n1, t1
    fit[7], fit[8], fit[9] = g11, g12, g22
    fit[10], fit[11], fit[12] = a1, a2, uu


@nb.njit(cache=True, nogil=True, fastmath=_fast, error_model="numpy", inline="always")
def _refine(w, table, start, step, mu, y, low, high, tolerance, a, fit):
    """Newton on dS/dy = 0 from y within [low, high], halving where Newton would leave; returns y.

    Ends with a step that raises S by less than `tolerance`, that is of less than its root in standard deviations; the
    error left is of the order of the square. S and the forces in `fit` are carried along the last step.
    """
    for _ in range(40):
        _fit(w, table, start, step, mu, y, a, fit)
        slope, curve = fit[3], fit[4]
        if slope > 0.0:
            low = y
        else:
            high = y
        move = -slope / curve if curve < 0.0 else (high - low if slope > 0.0 else low - high)
        following = y + move
        if not low <= following <= high:
            following = 0.5 * (low + high)
            move = following - y
        y = following
        gain = slope * move
        if gain < tolerance or abs(move) < 1e-10 * step:
            fit[0] += move * fit[5]
            fit[1] += move * fit[6]
            fit[2] += gain
            break
    return y


@nb.njit(cache=True, nogil=True, fastmath=_fast, error_model="numpy")
def locate_frames(readings, sensors, basis, edges, table, options, out):
    """Fill `out`, one row a frame; the columns are named in `estimate.py`.

    readings (f, n), raw; sensors (4, n): offset, 1/noise, low and high end of the range; basis (n, 2, m) and
    edges (4, m): the scan; table (cells, 5, 2, n): whitened receptive field; options: start and step of the table,
    start and step of the scan, mu, then the thresholds of `locate._prepare`. Frames in which a sensor cannot be used
    are left with status -1.
    """
    frames, n = readings.shape
    m = edges.shape[1]
    start, step, scan_start, scan_step, mu = options[0], options[1], options[2], options[3], options[4]
    detection, largest, ambiguity, apart, wide = options[5], options[6], options[7], options[8], options[9]
    scan_stop = scan_start + (m - 1) * scan_step
    score = np.empty((2, m), dtype=np.float32)
    w = np.empty(n)
    w_single = np.empty(n, dtype=np.float32)
    s = np.full(m + 2, -1, dtype=np.float32)
    words = np.zeros((m + 7) // 8, dtype=np.uint64)
    peak = words.view(np.uint8)
    peak_score = np.empty(_CANDIDATES)
    peak_y = np.empty(_CANDIDATES)
    positions = np.empty(_CANDIDATES)
    fits = np.empty((_CANDIDATES, 13))
    scratch = np.empty((6, n))
    for f in range(frames):
        row = out[f]
        total = 0.0
        usable = True
        for i in range(n):
            r = readings[f, i]
            usable &= sensors[2, i] < r < sensors[3, i]
            w[i] = (r - sensors[0, i]) * sensors[1, i]
            total += w[i] * w[i]
        row[:] = math.nan
        row[RIVAL + 3] = math.inf
        if not (usable and total < math.inf):
            row[STATUS] = _PENDING
            continue
        for i in range(n):
            w_single[i] = w[i]
        _scan(w_single, basis, edges, score, s, peak)
        # the best few maxima of the scan, by the height of the parabola through their three points
        count = 0
        for word in range(words.size):
            if words[word] == 0:
                continue
            for k in range(8 * word, min(8 * word + 8, m)):
                if peak[k] == 0 or not s[k + 1] > 0:
                    continue
                left, here, right = s[k], s[k + 1], s[k + 2]
                shift, height = 0.0, float(here)
                if left >= 0 and right >= 0:
                    shift = 0.5 * (left - right) / (left - 2 * here + right)
                    height = here - 0.25 * (left - right) * shift
                position = count
                while position > 0 and peak_score[position - 1] < height:
                    position -= 1
                if position < _CANDIDATES:
                    for q in range(min(count, _CANDIDATES - 1), position, -1):
                        peak_score[q], peak_y[q] = peak_score[q - 1], peak_y[q - 1]
                    peak_score[position] = height
                    peak_y[position] = scan_start + (k + shift) * scan_step
                    count = min(count + 1, _CANDIDATES)
        best = second = -1
        for q in range(count):
            # a maximum clearly lower than both already found cannot become the best or the rival
            if second >= 0 and peak_score[q] < 0.8 * fits[second, 2]:
                break
            y = peak_y[q]
            lo, hi = max(y - 1.5 * scan_step, scan_start), min(y + 1.5 * scan_step, scan_stop)
            tolerance = 1e-5 if q == 0 else 1e-2 * max(fits[best, 2] - peak_score[q], 1e-3)
            positions[q] = _refine(w, table, start, step, mu, y, lo, hi, tolerance, scratch, fits[q])
            if best < 0 or fits[q, 2] > fits[best, 2]:
                best, second = q, best
            elif second < 0 or fits[q, 2] > fits[second, 2]:
                second = q
        explained = fits[best, 2] if best >= 0 else 0.0
        residual = max(total - explained, 0.0)
        row[RESIDUAL] = residual
        if residual > largest:
            row[STATUS] = _UNEXPLAINED
            continue
        if explained < detection:
            row[STATUS] = _NO_CONTACT
            continue
        y = positions[best]
        normal, tangential = fits[best, 0], fits[best, 1]
        force = math.hypot(normal, tangential)
        row[POSITION], row[FORCE], row[FORCE + 1] = y, force, math.atan2(tangential, normal)
        _covariance(fits[best], force, mu, row)
        status = _OK
        margin = 0.02 * scan_step
        if y <= scan_start + margin or y >= scan_stop - margin:
            status = _AMBIGUOUS
        if row[COVARIANCE] < (scan_stop - scan_start) ** 2:
            _widen(s, scan_start, scan_step, y, explained, row)
            # the profile has to be about as narrow as its curvature at the top says
            reach = max(6.0 * math.sqrt(row[COVARIANCE]), wide)
            before = math.floor((y - reach - scan_start) / scan_step)
            after = math.ceil((y + reach - scan_start) / scan_step)
            if before >= 0 and explained - s[before + 1] < ambiguity:
                status = _AMBIGUOUS
            if after < m and explained - s[after + 1] < ambiguity:
                status = _AMBIGUOUS
        else:  # the readings do not determine the place
            status = _AMBIGUOUS
        if not row[COVARIANCE + 5] < 1.0:  # nor the angle: a load at any other would do
            status = _AMBIGUOUS
        if second >= 0 and abs(positions[second] - y) > apart:
            row[RIVAL] = positions[second]
            row[RIVAL + 1] = math.hypot(fits[second, 0], fits[second, 1])
            row[RIVAL + 2] = math.atan2(fits[second, 1], fits[second, 0])
            row[RIVAL + 3] = max(explained - fits[second, 2], 0.0)
            if row[RIVAL + 3] < ambiguity:
                status = _AMBIGUOUS
        row[STATUS] = status


@nb.njit(cache=True, nogil=True, fastmath=_fast, error_model="numpy", inline="always")
def _covariance(fit, force, mu, row):
    """Inverse Fisher information, carried from (y, N, T) to (position, force, angle); six entries."""
    normal, tangential = fit[0], fit[1]
    g11, g12, g22, a1, a2, uu = fit[7], fit[8], fit[9], fit[10], fit[11], fit[12]
    cos, sin = normal / force, tangential / force
    if mu == 0.0:  # the angle is known: two unknowns
        det = max(uu * g11 - a1 * a1, 0.0)
        row[COVARIANCE], row[COVARIANCE + 1], row[COVARIANCE + 2] = g11 / det, -a1 / det, 0.0
        row[COVARIANCE + 3], row[COVARIANCE + 4], row[COVARIANCE + 5] = uu / det, 0.0, 0.0
        return
    yy = g11 * g22 - g12 * g12
    yn = g12 * a2 - a1 * g22
    yt = a1 * g12 - g11 * a2
    det = max(
        uu * yy + a1 * yn + a2 * yt, 0.0
    )  # 0, and so an infinite variance, where rounding has made it less
    nn = (uu * g22 - a2 * a2) / det
    nt = (a1 * a2 - uu * g12) / det
    tt = (uu * g11 - a1 * a1) / det
    yn, yt = yn / det, yt / det
    row[COVARIANCE] = yy / det
    row[COVARIANCE + 1] = cos * yn + sin * yt
    row[COVARIANCE + 2] = (cos * yt - sin * yn) / force
    row[COVARIANCE + 3] = cos * cos * nn + 2 * cos * sin * nt + sin * sin * tt
    row[COVARIANCE + 4] = (cos * cos * nt + cos * sin * (tt - nn) - sin * sin * nt) / force
    row[COVARIANCE + 5] = (cos * cos * tt - 2 * cos * sin * nt + sin * sin * nn) / (force * force)


@nb.njit(cache=True, nogil=True, fastmath=_fast, error_model="numpy")
def _widen(s, scan_start, scan_step, y, explained, row):
    """Where the profile of chi-square is wider than its curvature at the best y says, widen the covariance to match.

    The distance to where chi-square has risen by 1.96^2 is read off the scan on either side.
    """
    variance = row[COVARIANCE]
    if (
        variance < 0.25 * scan_step * scan_step
    ):  # narrower than the scan resolves: the profile is a parabola there
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
        c1, c2 = row[COVARIANCE + 1], row[COVARIANCE + 2]
        extra = (ratio - 1.0) / variance
        row[COVARIANCE] *= ratio
        row[COVARIANCE + 1] *= ratio
        row[COVARIANCE + 2] *= ratio
        row[COVARIANCE + 3] += extra * c1 * c1
        row[COVARIANCE + 4] += extra * c1 * c2
        row[COVARIANCE + 5] += extra * c2 * c2
