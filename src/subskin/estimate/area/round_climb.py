"""Compiled: whitened readings of a round contact of some half width, and the climb to the top of S in (y, z, width).

As `climb.py`, with one coordinate more: q, the square of the half width, in which readings are analytic. Tables are
those of `RoundResponse.cubics`, sums over Chebyshev's polynomials of q, whose values at one q are its shares.

A moment about the normal is one more linear unknown, which nothing binds. Its column is taken out of the others, of the
readings and of their slopes, wherever these are met: so the forces are eliminated as without it.
"""

from __future__ import annotations

import math

from ..._compiled import compiled
from .cone import eliminate, sums_of

COLUMNS = 24
"""Rows of scratch a sensor needs: 0-2 its readings under N, Ty, Tz; 3-5 their slopes in y, 6-8 in z, 9-11 in q; 12, 15,
18, 21 the same under a moment."""
SIZE = 47
"""Numbers of a fit: 0-10 as of `cone.eliminate`; 11-16 A^T A; 17 chi-square left; 18-20 the gradient of S/2 in y, z, q;
21-26 U^T U, U the readings' slopes, of yy yz yq zz zq qq; 27-35 A^T U, of y, then of z and q; 36-38 y, z, q; of a
moment's column t, of which A and U are free here: 39 the moment, 40 t^T t, 41-43 A^T t, 44-46 U^T t as they were."""
_CELLS = 64.0
_STEPS = 60


@compiled(borrows=True)
def shares_of(q, most, shares):
    """Chebyshev's polynomials of 2 q / most - 1, and their slopes in q; shares (2, widths)."""
    x, slope = 2.0 * q / most - 1.0, 2.0 / most
    shares[0, 0], shares[1, 0] = 1.0, 0.0
    shares[0, 1], shares[1, 1] = x, slope
    for j in range(2, shares.shape[1]):
        shares[0, j] = 2.0 * x * shares[0, j - 1] - shares[0, j - 2]
        shares[1, j] = 2.0 * (slope * shares[0, j - 1] + x * shares[1, j - 1]) - shares[1, j - 2]


@compiled(borrows=True)
def at_width(sums, shares, table):
    """The table of point loads that reads as contacts of one width do: sums (rows, numbers, widths) into table."""
    for k in range(sums.shape[0]):
        for e in range(sums.shape[1]):
            total = 0.0
            for j in range(sums.shape[2]):
                total += sums[k, e, j] * shares[0, j]
            table[k, e] = total


@compiled(borrows=True)
def round_field(sensors, first, sums, terms, shares, y, z, part, b):
    """Fill rows 0 to 11 of b; sensors, first, terms: as of `field.field_at`; part (functions, 3): scratch."""
    n = sensors.shape[1]
    last = first[n]
    for i in range(n):
        dy, dz = sensors[0, i] - y, sensors[1, i] - z
        share, octave = math.frexp(1.0 + (dy * dy + dz * dz) * sensors[2, i])
        at = (2.0 * share - 1.0) * _CELLS
        cell = int(at)
        k, t = first[i] + min(64 * (octave - 1) + cell, last), at - cell - 0.5
        steep = math.ldexp(2.0 * _CELLS, 1 - octave) * sensors[2, i]
        for e in range(part.shape[0]):
            value = slope = wider = 0.0
            for j in range(shares.shape[1]):
                c1, c2, c3 = sums[k, 4 * e + 1, j], sums[k, 4 * e + 2, j], sums[k, 4 * e + 3, j]
                here = sums[k, 4 * e, j] + t * (c1 + t * (c2 + t * c3))
                value += here * shares[0, j]
                wider += here * shares[1, j]
                slope += (c1 + t * (2.0 * c2 + 3.0 * t * c3)) * shares[0, j]
            part[e, 0], part[e, 1], part[e, 2] = value, steep * slope, wider
        for row in range(12):
            b[row, i] = 0.0
        for j in range(terms.shape[0]):
            row, order, imaginary, e = terms[j, 0], terms[j, 1], terms[j, 2], terms[j, 3]
            scale = sensors[3, i] * terms[j, 4]
            re, im, below_re, below_im = 1.0, 0.0, 0.0, 0.0  # zeta^order and zeta^(order - 1)
            for _ in range(order):
                below_re, below_im = re, im
                re, im = re * dy - im * dz, re * dz + im * dy
            shape = im if imaginary else re
            by_y = order * (below_im if imaginary else below_re)
            by_z = order * (below_re if imaginary else -below_im)
            f, df = scale * part[e, 0], scale * part[e, 1]
            b[row, i] += f * shape
            b[3 + row, i] -= df * dy * shape + f * by_y
            b[6 + row, i] -= df * dz * shape + f * by_z
            b[9 + row, i] += scale * part[e, 2] * shape


@compiled(borrows=True)
def round_project(w, model, mu, y, z, q, room, fit):
    """The best admissible forces, and moment, at (y, z) and the width of q, and how S changes there; all of fit."""
    sensors, first, sums, terms, most, turns, turned = model
    shares, part, twisted, b = room[2], room[3], room[4], room[5]
    shares_of(q, most, shares)
    round_field(sensors, first, sums, terms, shares, y, z, part, b)
    g00, g01, g02, g11, g12, g22, b0, b1, b2 = sums_of(b, w, 0)
    for k in range(39, SIZE):
        fit[k] = 0.0
    over = alone = 0.0
    if turned.shape[0]:
        round_field(sensors, first, turns, turned, shares, y, z, twisted, b[12:])
        tt = c0 = c1 = c2 = 0.0
        for i in range(w.size):
            t = b[12, i]
            tt += t * t
            c0 += t * b[0, i]
            c1 += t * b[1, i]
            c2 += t * b[2, i]
            alone += t * w[i]
        fit[40], fit[41], fit[42], fit[43] = tt, c0, c1, c2
        over = 1.0 / tt if tt > 0.0 else 0.0
        g00 -= over * c0 * c0
        g01 -= over * c0 * c1
        g02 -= over * c0 * c2
        g11 -= over * c1 * c1
        g12 -= over * c1 * c2
        g22 -= over * c2 * c2
        b0 -= over * alone * c0
        b1 -= over * alone * c1
        b2 -= over * alone * c2
    eliminate(g00, g01, g02, g11, g12, g22, b0, b1, b2, mu, fit)
    fit[3] += over * alone * alone
    fit[11], fit[12], fit[13], fit[14], fit[15], fit[16] = g00, g01, g02, g11, g12, g22
    fit[36], fit[37], fit[38] = y, z, q
    n, ty, tz = fit[0], fit[1], fit[2]
    moment = over * (alone - fit[41] * n - fit[42] * ty - fit[43] * tz)
    fit[39] = moment
    for k in range(17, 36):
        fit[k] = 0.0
    for i in range(w.size):
        rest = w[i] - b[0, i] * n - b[1, i] * ty - b[2, i] * tz
        for k in range(3):
            b[3 + 3 * k, i] = b[3 + 3 * k, i] * n + b[4 + 3 * k, i] * ty + b[5 + 3 * k, i] * tz
        if over > 0.0:
            t = b[12, i]
            rest -= moment * t
            for k in range(3):
                b[3 + 3 * k, i] += moment * b[15 + 3 * k, i]
                fit[44 + k] += t * b[3 + 3 * k, i]
        fit[17] += rest * rest
        uy, uz, uq = b[3, i], b[6, i], b[9, i]
        fit[18] += rest * uy
        fit[19] += rest * uz
        fit[20] += rest * uq
        fit[21] += uy * uy
        fit[22] += uy * uz
        fit[23] += uy * uq
        fit[24] += uz * uz
        fit[25] += uz * uq
        fit[26] += uq * uq
        for j in range(3):
            fit[27 + j] += b[j, i] * uy
            fit[30 + j] += b[j, i] * uz
            fit[33 + j] += b[j, i] * uq
    if over > 0.0:
        at = 21
        for j in range(3):
            for k in range(j, 3):
                fit[at] -= over * fit[44 + j] * fit[44 + k]
                at += 1
            for k in range(3):
                fit[27 + 3 * j + k] -= over * fit[44 + j] * fit[41 + k]


@compiled(borrows=True)
def round_curvature(fit, h):
    """The projected information of (y, z, q) into h (3, 3): U^T U less what the forces explain of it."""
    for j in range(3):
        for k in range(j, 3):
            value = fit[21 + j * (5 - j) // 2 + k]
            x0, x1, x2 = fit[27 + 3 * j], fit[28 + 3 * j], fit[29 + 3 * j]
            y0, y1, y2 = fit[27 + 3 * k], fit[28 + 3 * k], fit[29 + 3 * k]
            value -= x0 * (fit[4] * y0 + fit[5] * y1 + fit[6] * y2)
            value -= x1 * (fit[5] * y0 + fit[7] * y1 + fit[8] * y2)
            value -= x2 * (fit[6] * y0 + fit[8] * y1 + fit[9] * y2)
            h[j, k] = h[k, j] = value


@compiled(borrows=True)
def _bounded_step(fit, h, more, box, m):
    """A damped step from the position of fit into row 6 of m, within the box; what would leave it ends at its side."""
    for k in range(3):
        at, pull = fit[36 + k], fit[18 + k]
        fixed = (at <= box[2 * k] and pull <= 0.0) or (at >= box[2 * k + 1] and pull >= 0.0)
        m[6, k], m[7, k] = 0.0, (1.0 if fixed else 0.0)
    for _ in range(3):
        for j in range(3):
            if m[7, j] == 1.0:
                m[3 + j, 0] = m[3 + j, 1] = m[3 + j, 2] = 0.0
                m[3 + j, j], m[3 + j, 3] = 1.0, m[6, j]
            else:
                for k in range(3):
                    m[3 + j, k] = h[j, k]
                m[3 + j, j], m[3 + j, 3] = h[j, j] * more + 1e-12 * fit[21 + j * (7 - j) // 2] + 1e-300, fit[18 + j]
        for j in range(3):  # fixed rows are those of the identity, the rest is positive: no rows change their order
            for k in range(3):
                if k != j and m[3 + k, j] != 0.0:
                    ratio = m[3 + k, j] / m[3 + j, j]
                    for e in range(4):
                        m[3 + k, e] -= ratio * m[3 + j, e]
        inside = True
        for k in range(3):
            if m[7, k] == 0.0:
                step, at = m[3 + k, 3] / m[3 + k, k], fit[36 + k]
                m[6, k] = step
                if not box[2 * k] <= at + step <= box[2 * k + 1]:
                    m[6, k] = min(max(at + step, box[2 * k]), box[2 * k + 1]) - at
                    m[7, k], inside = 1.0, False
        if inside:
            return


@compiled(borrows=True)
def round_climb(w, model, mu, box, y, z, q, tolerance, room, fit, trial):
    """Climb from (y, z, q) within box (6,), low and high of each; the top is in fit, its information in room.

    Ends with a step that would raise S by less than `tolerance`, which is still made where it helps. model: sensors,
    first, sums and terms, the square of the largest half width, and the sums and terms of a moment, none if it is none;
    room: scratch, which is the information h (3, 3), equations (8, 4), shares (2, widths), the functions of a sensor
    (functions, 3), those under a moment, and (COLUMNS, n).
    """
    h, m = room[0], room[1]
    y, z, q = min(max(y, box[0]), box[1]), min(max(z, box[2]), box[3]), min(max(q, box[4]), box[5])
    damping, fit[3], last = 1e-5, -1.0, False
    for _ in range(_STEPS):
        round_project(w, model, mu, y, z, q, room, trial)
        if trial[3] > fit[3]:
            for k in range(SIZE):
                fit[k] = trial[k]
            round_curvature(fit, h)
            damping = 0.1 * damping
        else:
            damping = max(10.0 * damping, 1e-3)
        if last:
            return
        _bounded_step(fit, h, 1.0 + damping, box, m)
        y, z, q = fit[36] + m[6, 0], fit[37] + m[6, 1], fit[38] + m[6, 2]
        last = not fit[18] * m[6, 0] + fit[19] * m[6, 1] + fit[20] * m[6, 2] >= tolerance
