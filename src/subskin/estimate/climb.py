"""Compiled: from a node of the scan to the top of S, in position alone or in position and width.

At each trial the forces are eliminated exactly, within compression and the friction cone (`eliminate`). In position the
climb is a safeguarded Newton iteration with exact first and second derivatives; in position y and q = a^2, the square
of the half width, in which readings are smooth down to no width at all, it is Levenberg and Marquardt's method on the
projected residual (Golub and Pereyra 1973, Kaufman 1975, without the cone). docs/locating.md, docs/fitting.md.
"""

from __future__ import annotations

import math

from .._compiled import compiled

_STEPS = 40


@compiled(inline=True)
def eliminate(g11, g12, g22, b1, b2, mu):
    """Best admissible (N, T) for A^T A = g and A^T w = b, and the inverse of what the cone leaves free of A^T A.

    All of it is free inside the cone N >= 0, |T| <= mu N, one direction on an edge, nothing at its tip.
    """
    det = g11 * g22 - g12 * g12
    inverse = 1.0 / det
    normal = (g22 * b1 - g12 * b2) * inverse
    tangential = (g11 * b2 - g12 * b1) * inverse
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
    return normal, tangential, i11, i12, i22


@compiled(inline=True)
def project(w, table, start, step, mu, y, a, fit):
    """The best admissible forces for a load at y, with derivatives of S/2.

    table (cells, 5, 2, n); a: scratch (6, n). fit: N, T, S, g = dS/2dy, dg/dy, dN/dy, dT/dy, then sums over the sensors
    for the covariance.
    """
    cells, _, _, n = table.shape
    place = (y - start) / step
    cell = min(max(int(place), 0), cells - 1)
    t = place - cell - 0.5
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
    normal, tangential, i11, i12, i22 = eliminate(g11, g12, g22, b1, b2, mu)
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


@compiled(inline=True)
def climb(w, table, start, step, mu, y, low, high, tolerance, a, fit):
    """Newton on dS/dy = 0 from y within [low, high], halving where Newton would leave; returns y.

    Ends with a step that raises S by less than `tolerance`, that is of less than its root in standard deviations; the
    error left is of the order of the square. S and the forces in `fit` are carried along the last step.
    """
    for _ in range(_STEPS):
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
        y = following
        gain = slope * move
        if gain < tolerance or abs(move) < 1e-10 * step:
            fit[0] += move * fit[5]
            fit[1] += move * fit[6]
            fit[2] += gain
            break
    return y


@compiled()
def project_wide(w, table, start, step, square, mu, y, q, c, a, fit):
    """The best admissible forces at (y, q): fit = N, T, S and the inverse of what the cone leaves free (3).

    table (cells, widths, 10 n): in each cell the powers of t, for N and T each, as Chebyshev sums in 2 q / square - 1.
    a (3, 2 n): A_N and A_T, their slopes in y, and in q; c (2, 10 n): scratch.
    """
    cells, widths, size = table.shape
    two_n = size // 5
    place = (y - start) / step
    cell = min(max(int(place), 0), cells - 1)
    t = place - cell - 0.5
    x = 2.0 * q / square - 1.0
    rise_of = 2.0 / square
    for j in range(size):
        c[0, j] = table[cell, 0, j]
        c[1, j] = 0.0
    before, now, slope_before, slope = 1.0, x, 0.0, 1.0
    for k in range(1, widths):
        if k > 1:
            value, rise = 2 * x * now - before, 2 * now + 2 * x * slope - slope_before
            before, now, slope_before, slope = now, value, slope, rise
        rise = rise_of * slope
        for j in range(size):
            c[0, j] += now * table[cell, k, j]
            c[1, j] += rise * table[cell, k, j]
    d = 1.0 / step
    for i in range(two_n):
        c1, c2, c3, c4 = c[0, two_n + i], c[0, 2 * two_n + i], c[0, 3 * two_n + i], c[0, 4 * two_n + i]
        a[0, i] = c[0, i] + t * (c1 + t * (c2 + t * (c3 + t * c4)))
        a[1, i] = d * (c1 + t * (2 * c2 + t * (3 * c3 + t * (4 * c4))))
        c1, c2, c3, c4 = c[1, two_n + i], c[1, 2 * two_n + i], c[1, 3 * two_n + i], c[1, 4 * two_n + i]
        a[2, i] = c[1, i] + t * (c1 + t * (c2 + t * (c3 + t * c4)))
    n = w.size
    g11 = g12 = g22 = b1 = b2 = 0.0
    for i in range(n):
        an, at = a[0, i], a[0, n + i]
        g11 += an * an
        g12 += an * at
        g22 += at * at
        b1 += an * w[i]
        b2 += at * w[i]
    normal, tangential, fit[3], fit[4], fit[5] = eliminate(g11, g12, g22, b1, b2, mu)
    fit[0], fit[1], fit[2] = normal, tangential, b1 * normal + b2 * tangential


@compiled()
def slopes(w, a, fit):
    """Gradient of S/2 in (y, q) and the projected information matrix: g_y, g_q, m_yy, m_yq, m_qq."""
    n = w.size
    normal, tangential, i11, i12, i22 = fit[0], fit[1], fit[3], fit[4], fit[5]
    gy = gq = yy = yq = qq = 0.0
    p1 = p2 = r1 = r2 = 0.0
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
        p1 += an * u
        p2 += at * u
        r1 += an * v
        r2 += at * v
    yy -= p1 * (i11 * p1 + i12 * p2) + p2 * (i12 * p1 + i22 * p2)
    yq -= r1 * (i11 * p1 + i12 * p2) + r2 * (i12 * p1 + i22 * p2)
    qq -= r1 * (i11 * r1 + i12 * r2) + r2 * (i12 * r1 + i22 * r2)
    return gy, gq, yy, yq, qq


@compiled()
def climb_wide(w, table, start, step, square, mu, y, q, ends, c, a, fit):
    """Climb S from (y, q) within ends = (y low, y high, q low, q high); returns y and q, the rest in fit.

    Ends with a step that raises S by less than 1e-7, which is still made where it does.
    """
    project_wide(w, table, start, step, square, mu, y, q, c, a[0], fit)
    here, damping = 0, 1e-4
    normal, tangential, top, i11, i12, i22 = fit[0], fit[1], fit[2], fit[3], fit[4], fit[5]
    for _ in range(_STEPS):
        gy, gq, yy, yq, qq = slopes(w, a[here], fit)
        # what stands at an end and would go on beyond stays
        fixed_y = (y <= ends[0] and gy < 0.0) or (y >= ends[1] and gy > 0.0)
        fixed_q = ends[2] == ends[3] or (q <= ends[2] and gq < 0.0) or (q >= ends[3] and gq > 0.0)
        done = True
        while damping < 1e12:
            hy, hq = yy * (1.0 + damping), qq * (1.0 + damping)
            if fixed_y and fixed_q:
                break
            if fixed_q:
                dy, dq = gy / hy, 0.0
            elif fixed_y:
                dy, dq = 0.0, gq / hq
            else:
                det = hy * hq - yq * yq
                dy, dq = (hq * gy - yq * gq) / det, (hy * gq - yq * gy) / det
            new_y = min(max(y + dy, ends[0]), ends[1])
            new_q = min(max(q + dq, ends[2]), ends[3])
            dy, dq = new_y - y, new_q - q
            small = not abs(gy * dy) + abs(gq * dq) > 1e-7
            project_wide(w, table, start, step, square, mu, new_y, new_q, c, a[1 - here], fit)
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
