"""Compiled: from a node of the scan to the top of S, in position alone or in position and width.

At each trial the forces are eliminated exactly, within compression and the friction cone (`eliminate`). In position the
climb is a safeguarded Newton iteration with exact first and second derivatives; in position y and q = a^2, the square
of the half width, in which readings are smooth down to no width at all, it is Newton's with the exact curvature where
that is a maximum's, and Levenberg and Marquardt's on the projected residual elsewhere (Golub and Pereyra 1973, Kaufman
1975, without the cone). docs/locating.md, docs/fitting.md.
"""

from __future__ import annotations

import math

from .._compiled import compiled

_STEPS = 40


@compiled(inline=True)
def eliminate(g11, g12, g22, b1, b2, mu):
    """Best admissible (N, T) for A^T A = g and A^T w = b, S there, and the inverse of what is left free of A^T A.

    All of it is free inside the cone N >= 0, |T| <= mu N, one direction on an edge, nothing at its tip.
    """
    det = g11 * g22 - g12 * g12
    inverse = 1.0 / det
    normal = (g22 * b1 - g12 * b2) * inverse
    tangential = (g11 * b2 - g12 * b1) * inverse
    i11, i12, i22 = g22 * inverse, -g12 * inverse, g11 * inverse
    height = b1 * normal + b2 * tangential
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
        height = b1 * normal + b2 * tangential
    return normal, tangential, height, i11, i12, i22


@compiled()
def eliminate_between(g11, g12, g22, b1, b2, mu, low, high):
    """The same with low <= N <= high: nothing is free in a corner of these and the cone. One end may be missing."""
    normal, tangential, height, i11, i12, i22 = eliminate(g11, g12, g22, b1, b2, mu)
    if low <= normal <= high:
        return normal, tangential, height, i11, i12, i22
    best = -math.inf
    normal = tangential = i11 = i12 = i22 = 0.0
    for side in range(2):
        sign = 2.0 * side - 1.0
        if mu < math.inf:  # an edge of the cone
            size = g11 + 2 * sign * mu * g12 + mu * mu * g22
            along = b1 + sign * mu * b2
            free = size > 0.0 and low * size < along < high * size
            n = along / size if free else (high if size > 0.0 and along > 0.0 and high < math.inf else low)
            height = n * (2 * along - n * size)
            if height > best:
                best, normal, tangential = height, n, sign * mu * n
                i11 = 1.0 / size if free else 0.0
                i12, i22 = sign * mu * i11, mu * mu * i11
        n = low if side == 0 else high
        if n < math.inf and g22 > 0.0:  # an end of the range
            t = (b2 - g12 * n) / g22
            if abs(t) <= mu * n or mu == math.inf:
                height = n * (2 * b1 - n * g11) + t * (b2 - g12 * n)
                if height > best:
                    best, normal, tangential = height, n, t
                    i11, i12, i22 = 0.0, 0.0, 1.0 / g22
    return normal, tangential, best, i11, i12, i22


@compiled(borrows=True)
def field_at(table, start, step, y, a):
    """A_N and A_T of a line load at y and their slopes in y, into a (4, n); table (cells, 5, 2, n) as in `project`."""
    cells, _, _, n = table.shape
    position = (y - start) / step
    cell = min(max(int(position), 0), cells - 1)
    t = position - cell - 0.5
    for side in range(2):
        for i in range(n):
            c1, c2 = table[cell, 1, side, i], table[cell, 2, side, i]
            c3, c4 = table[cell, 3, side, i], table[cell, 4, side, i]
            a[side, i] = table[cell, 0, side, i] + t * (c1 + t * (c2 + t * (c3 + t * c4)))
            a[2 + side, i] = (c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4)))) / step


@compiled(inline=True)
def project(w, table, start, step, mu, y, a, fit):
    """The best admissible forces for a load at y, with derivatives of S/2.

    table (cells, 5, 2, n); a: scratch (6, n). fit: N, T, S, g = dS/2dy, dg/dy, dN/dy, dT/dy, sums over the sensors for
    the covariance, and last whether nothing binds the forces.
    """
    g11, g12, g22, b1, b2 = _columns(w, table, start, step, y, a)
    normal, tangential, height, i11, i12, i22 = eliminate(g11, g12, g22, b1, b2, mu)
    _derive(w, a, g11, g12, g22, normal, tangential, height, i11, i12, i22, mu, fit)


@compiled()
def project_between(w, table, start, step, mu, low, high, y, a, fit):
    """The same with low <= N <= high."""
    g11, g12, g22, b1, b2 = _columns(w, table, start, step, y, a)
    normal, tangential, height, i11, i12, i22 = eliminate_between(g11, g12, g22, b1, b2, mu, low, high)
    _derive(w, a, g11, g12, g22, normal, tangential, height, i11, i12, i22, mu, fit)


@compiled(inline=True)
def _columns(w, table, start, step, y, a):
    """Fill a (6, n) with the derivatives of A_N and A_T by y, first and second, and these; A^T A and A^T w."""
    cells, _, _, n = table.shape
    position = (y - start) / step
    cell = min(max(int(position), 0), cells - 1)
    t = position - cell - 0.5
    d1 = 1.0 / step
    d2 = d1 * d1
    g11 = g12 = g22 = b1 = b2 = 0.0
    for i in range(n):
        c1, c2, c3, c4 = (table[cell, 1, 0, i], table[cell, 2, 0, i], table[cell, 3, 0, i], table[cell, 4, 0, i])
        an = table[cell, 0, 0, i] + t * (c1 + t * (c2 + t * (c3 + t * c4)))
        a[0, i] = d1 * (c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4))))
        a[1, i] = d2 * (2 * c2 + t * (6 * c3 + t * (12 * c4)))
        c1, c2, c3, c4 = (table[cell, 1, 1, i], table[cell, 2, 1, i], table[cell, 3, 1, i], table[cell, 4, 1, i])
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
    return g11, g12, g22, b1, b2


@compiled(inline=True)
def _derive(w, a, g11, g12, g22, normal, tangential, height, i11, i12, i22, mu, fit):
    """Fill `fit` for forces that have been found."""
    n = w.size
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
    fit[0], fit[1], fit[2] = normal, tangential, height
    fit[3] = ru
    fit[4] = rv - uu + r1 * n1 + r2 * t1
    fit[5], fit[6] = n1, t1
    fit[7], fit[8], fit[9] = g11, g12, g22
    fit[10], fit[11], fit[12] = a1, a2, uu
    fit[13] = 1.0 if i11 > 0.0 and (abs(tangential) < mu * normal or mu == 0.0) else 0.0


@compiled(inline=True)
def climb(w, table, start, step, mu, y, low, high, tolerance, a, fit, rough=False):
    """Newton on dS/dy = 0 from y within [low, high], halving where Newton would leave; returns y.

    Ends with a step that raises S by less than `tolerance`, that is of less than its root in standard deviations; the
    error left is of the order of the square. S and the forces in `fit` are carried along the last step, but where the
    forces are bound before or after it: there the curvature jumps, so the end of the step is looked at, and has to be
    as flat, unless a `rough` answer will do.
    """
    return _newton(w, table, start, step, mu, False, 0.0, math.inf, y, low, high, tolerance, a, fit, rough)


@compiled()
def climb_between(w, table, start, step, mu, least, most, y, low, high, tolerance, a, fit):
    """The same with a normal force in least <= N <= most."""
    return _newton(w, table, start, step, mu, True, least, most, y, low, high, tolerance, a, fit, False)


@compiled(inline=True)
def _newton(w, table, start, step, mu, ranged, least, most, y, low, high, tolerance, a, fit, rough):
    """As `climb`; in place of each call, so that the compiler leaves out what a constant `ranged` does not need."""
    flat = False
    for k in range(_STEPS):
        if ranged:
            project_between(w, table, start, step, mu, least, most, y, a, fit)
        else:
            project(w, table, start, step, mu, y, a, fit)
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
        gain = slope * move
        before, flat = flat, gain < tolerance or abs(move) < 1e-10 * step
        if flat:
            normal, tangential = fit[0] + move * fit[5], fit[1] + move * fit[6]
            if rough or (fit[13] > 0.0 and least <= normal <= most and abs(tangential) <= mu * normal):
                fit[0], fit[1] = normal, tangential
                fit[2] += gain
                y = following
                break
            if before:
                break
        if k + 1 < _STEPS:
            y = following
    return y


@compiled(borrows=True)
def project_wide(w, table, start, step, square, mu, y, q, c, a, fit, low, high):
    """The best admissible forces at (y, q): fit = N, T, S and the inverse of what the cone leaves free (3).

    table (cells, widths, 10 n): in each cell the powers of t, for N and T each, as Chebyshev sums in 2 q / square - 1.
    a (6, 2 n): A_N and A_T, then their derivatives in y, q, yy, yq, qq; c (3, 10 n + widths + 3): scratch.
    """
    cells, widths, size = table.shape
    two_n = size // 5
    position = (y - start) / step
    cell = min(max(int(position), 0), cells - 1)
    t = position - cell - 0.5
    x, slope = 2.0 * q / square - 1.0, 2.0 / square
    v0, v1, v2 = c[0], c[1], c[2]  # the sums, and their first and second derivatives in x
    for j in range(size):
        v0[j] = v1[j] = v2[j] = 0.0
    h0, h1, h2 = v0[size:], v1[size:], v2[size:]  # Chebyshev polynomials, and their derivatives
    h0[0], h1[0], h2[0], h0[1], h1[1], h2[1] = 1.0, 0.0, 0.0, x, 1.0, 0.0
    for k in range(2, widths):
        h0[k] = 2 * x * h0[k - 1] - h0[k - 2]
        h1[k] = 2 * h0[k - 1] + 2 * x * h1[k - 1] - h1[k - 2]
        h2[k] = 4 * h1[k - 1] + 2 * x * h2[k - 1] - h2[k - 2]
    for k in range(widths, widths + 3):
        h0[k] = h1[k] = h2[k] = 0.0
    for k in range(0, widths, 4):  # four at once: the sums go through memory less often
        r0, r1 = table[cell, k], table[cell, min(k + 1, widths - 1)]
        r2, r3 = table[cell, min(k + 2, widths - 1)], table[cell, min(k + 3, widths - 1)]
        p0, p1, p2, p3 = h0[k], h0[k + 1], h0[k + 2], h0[k + 3]
        q0, q1, q2, q3 = h1[k], h1[k + 1], h1[k + 2], h1[k + 3]
        s0, s1, s2, s3 = h2[k], h2[k + 1], h2[k + 2], h2[k + 3]
        for j in range(size):
            t0, t1, t2, t3 = r0[j], r1[j], r2[j], r3[j]
            v0[j] += (p0 * t0 + p1 * t1) + (p2 * t2 + p3 * t3)
            v1[j] += (q0 * t0 + q1 * t1) + (q2 * t2 + q3 * t3)
            v2[j] += (s0 * t0 + s1 * t1) + (s2 * t2 + s3 * t3)
    d1, d2 = 1.0 / step, 1.0 / (step * step)
    for i in range(two_n):
        c1, c2, c3, c4 = c[0, two_n + i], c[0, 2 * two_n + i], c[0, 3 * two_n + i], c[0, 4 * two_n + i]
        a[0, i] = c[0, i] + t * (c1 + t * (c2 + t * (c3 + t * c4)))
        a[1, i] = d1 * (c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4))))
        a[3, i] = d2 * (2 * c2 + t * (6 * c3 + t * (12 * c4)))
        c1, c2, c3, c4 = c[1, two_n + i], c[1, 2 * two_n + i], c[1, 3 * two_n + i], c[1, 4 * two_n + i]
        a[2, i] = slope * (c[1, i] + t * (c1 + t * (c2 + t * (c3 + t * c4))))
        a[4, i] = slope * d1 * (c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4))))
        c1, c2, c3, c4 = c[2, two_n + i], c[2, 2 * two_n + i], c[2, 3 * two_n + i], c[2, 4 * two_n + i]
        a[5, i] = slope * slope * (c[2, i] + t * (c1 + t * (c2 + t * (c3 + t * c4))))
    n = w.size
    g11 = g12 = g22 = b1 = b2 = 0.0
    for i in range(n):
        an, at = a[0, i], a[0, n + i]
        g11 += an * an
        g12 += an * at
        g22 += at * at
        b1 += an * w[i]
        b2 += at * w[i]
    if low > 0.0 or high < math.inf:
        fit[0], fit[1], fit[2], fit[3], fit[4], fit[5] = eliminate_between(g11, g12, g22, b1, b2, mu, low, high)
    else:
        fit[0], fit[1], fit[2], fit[3], fit[4], fit[5] = eliminate(g11, g12, g22, b1, b2, mu)


@compiled(borrows=True)
def slopes(w, a, fit):
    """Gradient of S/2 in (y, q) and its curvature there, with the sign of a maximum's taken as positive.

    g_y, g_q; the projected information m_yy, m_yq, m_qq; and what the misfit adds to these for the curvature.
    """
    n = w.size
    normal, tangential, i11, i12, i22 = fit[0], fit[1], fit[3], fit[4], fit[5]
    gy = gq = yy = yq = qq = byy = byq = bqq = 0.0
    p1 = p2 = r1 = r2 = e1 = e2 = f1 = f2 = 0.0
    for i in range(n):
        an, at = a[0, i], a[0, n + i]
        u = a[1, i] * normal + a[1, n + i] * tangential
        v = a[2, i] * normal + a[2, n + i] * tangential
        rho = w[i] - an * normal - at * tangential
        gy += rho * u
        gq += rho * v
        yy += u * u
        yq += u * v
        qq += v * v
        byy += rho * (a[3, i] * normal + a[3, n + i] * tangential)
        byq += rho * (a[4, i] * normal + a[4, n + i] * tangential)
        bqq += rho * (a[5, i] * normal + a[5, n + i] * tangential)
        p1 += an * u
        p2 += at * u
        r1 += an * v
        r2 += at * v
        e1 += a[1, i] * rho
        e2 += a[1, n + i] * rho
        f1 += a[2, i] * rho
        f2 += a[2, n + i] * rho
    yy -= p1 * (i11 * p1 + i12 * p2) + p2 * (i12 * p1 + i22 * p2)
    yq -= r1 * (i11 * p1 + i12 * p2) + r2 * (i12 * p1 + i22 * p2)
    qq -= r1 * (i11 * r1 + i12 * r2) + r2 * (i12 * r1 + i22 * r2)
    # (e - p)^T I (e - p) less p^T I p, which the projected information has already
    byy += e1 * (i11 * (e1 - 2 * p1) + i12 * (e2 - 2 * p2)) + e2 * (i12 * (e1 - 2 * p1) + i22 * (e2 - 2 * p2))
    bqq += f1 * (i11 * (f1 - 2 * r1) + i12 * (f2 - 2 * r2)) + f2 * (i12 * (f1 - 2 * r1) + i22 * (f2 - 2 * r2))
    byq += e1 * (i11 * (f1 - r1) + i12 * (f2 - r2)) + e2 * (i12 * (f1 - r1) + i22 * (f2 - r2))
    byq -= p1 * (i11 * f1 + i12 * f2) + p2 * (i12 * f1 + i22 * f2)
    return gy, gq, yy, yq, qq, -byy, -byq, -bqq


@compiled(borrows=True)
def climb_wide(w, table, start, step, square, mu, y, q, ends, c, a, fit, low, high):
    """Climb S from (y, q) within ends = (y low, y high, q low, q high); returns y and q, the rest in fit.

    Steps are Newton's where S is curved downwards, and those of the projected information elsewhere, shortened until S
    rises. Ends with a step that raises S by less than 1e-7, which is still made where it does. a (2, 6, 2 n).
    """
    project_wide(w, table, start, step, square, mu, y, q, c, a[0], fit, low, high)
    here, damping = 0, 1e-4
    normal, tangential, top, i11, i12, i22 = fit[0], fit[1], fit[2], fit[3], fit[4], fit[5]
    for _ in range(_STEPS):
        gy, gq, yy, yq, qq, byy, byq, bqq = slopes(w, a[here], fit)
        # what stands at an end and would go on beyond stays
        fixed_y = (y <= ends[0] and gy < 0.0) or (y >= ends[1] and gy > 0.0)
        fixed_q = ends[2] == ends[3] or (q <= ends[2] and gq < 0.0) or (q >= ends[3] and gq > 0.0)
        if fixed_y and fixed_q:
            break
        cyy, cyq, cqq = yy + byy, yq + byq, qq + bqq
        curved = (fixed_y or cyy > 1e-3 * yy) and (fixed_q or cqq > 1e-3 * qq)
        if curved and (fixed_y or fixed_q or cyy * cqq - cyq * cyq > 1e-3 * cyy * cqq):
            yy, yq, qq = cyy, cyq, cqq
        done = True
        while damping < 1e12:
            hy, hq = yy * (1.0 + damping), qq * (1.0 + damping)
            if fixed_q:
                dy, dq = gy / hy, 0.0
            elif fixed_y:
                dy, dq = 0.0, gq / hq
            else:
                det = hy * hq - yq * yq
                dy, dq = (hq * gy - yq * gq) / det, (hy * gq - yq * gy) / det
            new_y = min(max(y + dy, ends[0]), ends[1])
            if new_y != y + dy and not fixed_q:  # cut short: the best q for what is left of it
                dq = (gq - yq * (new_y - y)) / hq
            new_q = min(max(q + dq, ends[2]), ends[3])
            if new_q != q + dq and not fixed_y:
                new_y = min(max(y + (gy - yq * (new_q - q)) / hy, ends[0]), ends[1])
            dy, dq = new_y - y, new_q - q
            small = not abs(gy * dy) + abs(gq * dq) > 1e-7
            project_wide(w, table, start, step, square, mu, new_y, new_q, c, a[1 - here], fit, low, high)
            if fit[2] > top:
                y, q, here = new_y, new_q, 1 - here
                normal, tangential, top, i11, i12, i22 = fit[0], fit[1], fit[2], fit[3], fit[4], fit[5]
                damping = max(0.1 * damping, 1e-9)
                done = small
                break
            if small:
                break
            damping *= 10.0
        fit[0], fit[1], fit[2], fit[3], fit[4], fit[5] = normal, tangential, top, i11, i12, i22
        if done:
            break
    return y, q
