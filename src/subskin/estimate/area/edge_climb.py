"""Compiled: whitened readings of an edge, and the climb to the top of S in its position, direction, length and width.

An edge is a force spread evenly along a straight stretch, of half length l, and across it as narrow spheres of half
width a are: Gauss and Legendre's rule along the stretch, over round contacts of that width (`round_climb.py`). Unknowns
are, in this order, y, z, the direction, l and q = a^2. After half a turn an edge is the same.
"""

from __future__ import annotations

import math

from ..._compiled import compiled
from .cone import eliminate, sums_of
from .round_climb import round_field, shares_of

UNKNOWNS = 5
COLUMNS = 30
"""Rows of scratch a sensor needs: 0-2 its readings under N, Ty, Tz; 3-5 their slopes in y, 6-8 in z, 9-11 in q, 12-14
in the direction, 15-17 in l; 18-29 those of one round contact."""
SIZE = 53
"""Numbers of a fit: 0-10 as of `cone.eliminate`; 11-16 A^T A; 17 chi-square left; 18-22 the gradient of S/2 in the
unknowns; 23-27 these; 28-52 their information, the forces eliminated, in rows."""
_SLOPES = (3, 6, 12, 15, 9)
"""Where the slopes in each unknown begin."""
FEWEST = 4
"""Least number of nodes along an edge."""
_STEPS = 40
_TURN = 0.5
"""Most that a step turns the edge [rad]."""


@compiled(borrows=True)
def edge_project(w, model, mu, at, room, fit):
    """The best admissible forces on the edge `at` (5,), and how S changes there; all of fit.

    model: sensors, first, sums, terms and the largest q, as of `round_climb`; then rules on (-1, 1), nodes and weights
    of so many nodes, shape (rules, 2, nodes), the least depth, and how many nodes a rule needs, over 1 / arsinh of that
    depth in half lengths; room: scratch, which is shares (2, widths), the functions of a sensor (functions, 3), and
    (COLUMNS, n).
    """
    sensors, first, sums, terms, most, rules, depth, digits = model
    shares, part, b = room[0], room[1], room[2]
    one, n = b[18:], w.size
    c, s = math.cos(at[2]), math.sin(at[2])
    shares_of(at[4], most, shares)
    count = min(max(int(digits / math.asinh(depth / at[3])) + 1, FEWEST), rules.shape[0] - 1)
    rule = rules[count]
    for row in range(18):
        for i in range(n):
            b[row, i] = 0.0
    for node in range(count):
        along, share = rule[0, node], 0.5 * rule[1, node]
        away = along * at[3]
        round_field(sensors, first, sums, terms, shares, at[0] + away * c, at[1] + away * s, part, one)
        for row in range(12):
            for i in range(n):
                b[row, i] += share * one[row, i]
        by_y, by_z = -share * away * s, share * away * c
        to_y, to_z = share * along * c, share * along * s
        for row in range(3):
            for i in range(n):
                b[12 + row, i] += by_y * one[3 + row, i] + by_z * one[6 + row, i]
                b[15 + row, i] += to_y * one[3 + row, i] + to_z * one[6 + row, i]
    g00, g01, g02, g11, g12, g22, b0, b1, b2 = sums_of(b, w, 0)
    eliminate(g00, g01, g02, g11, g12, g22, b0, b1, b2, mu, fit)
    fit[11], fit[12], fit[13], fit[14], fit[15], fit[16] = g00, g01, g02, g11, g12, g22
    force, ty, tz, left = fit[0], fit[1], fit[2], 0.0
    for i in range(n):
        rest = w[i] - b[0, i] * force - b[1, i] * ty - b[2, i] * tz
        left += rest * rest
        one[0, i] = rest
    fit[17] = left
    for k in range(UNKNOWNS):
        row, pull, x0, x1, x2 = _SLOPES[k], 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            u = b[row, i] * force + b[row + 1, i] * ty + b[row + 2, i] * tz
            one[1 + k, i] = u
            pull += one[0, i] * u
            x0 += b[0, i] * u
            x1 += b[1, i] * u
            x2 += b[2, i] * u
        fit[18 + k], fit[23 + k] = pull, at[k]
        t0, t1, t2 = (
            fit[4] * x0 + fit[5] * x1 + fit[6] * x2,
            fit[5] * x0 + fit[7] * x1 + fit[8] * x2,
            fit[6] * x0 + fit[8] * x1 + fit[9] * x2,
        )
        for j in range(k + 1):  # what is left of U^T U once the forces have explained theirs
            total = y0 = y1 = y2 = 0.0
            for i in range(n):
                total += one[1 + j, i] * one[1 + k, i]
                y0 += b[0, i] * one[1 + j, i]
                y1 += b[1, i] * one[1 + j, i]
                y2 += b[2, i] * one[1 + j, i]
            total -= t0 * y0 + t1 * y1 + t2 * y2
            fit[28 + UNKNOWNS * j + k] = fit[28 + UNKNOWNS * k + j] = total


@compiled(borrows=True)
def _step(fit, more, box, m, step):
    """A damped step within the box (10,), low and high of each unknown, into `step`; what would leave it ends there."""
    for k in range(UNKNOWNS):
        at, pull = fit[23 + k], fit[18 + k]
        fixed = (at <= box[2 * k] and pull <= 0.0) or (at >= box[2 * k + 1] and pull >= 0.0)
        step[k], step[UNKNOWNS + k] = 0.0, (1.0 if fixed else 0.0)
    for _ in range(UNKNOWNS):
        for j in range(UNKNOWNS):
            for k in range(UNKNOWNS):
                m[j, k] = 0.0 if step[UNKNOWNS + j] == 1.0 else fit[28 + UNKNOWNS * j + k]
            if step[UNKNOWNS + j] == 1.0:
                m[j, j], m[j, UNKNOWNS] = 1.0, step[j]
            else:
                m[j, j], m[j, UNKNOWNS] = m[j, j] * (1.0 + more) + 1e-300, fit[18 + j]
        for j in range(UNKNOWNS):  # as in `round_climb`: no rows change their order
            for k in range(UNKNOWNS):
                if k != j and m[k, j] != 0.0:
                    ratio = m[k, j] / m[j, j]
                    for e in range(UNKNOWNS + 1):
                        m[k, e] -= ratio * m[j, e]
        inside = True
        for k in range(UNKNOWNS):
            if step[UNKNOWNS + k] == 0.0:
                by, at = m[k, UNKNOWNS] / m[k, k], fit[23 + k]
                step[k] = by
                if not box[2 * k] <= at + by <= box[2 * k + 1]:
                    step[k] = min(max(at + by, box[2 * k]), box[2 * k + 1]) - at
                    step[UNKNOWNS + k], inside = 1.0, False
        if inside:
            return


@compiled(borrows=True)
def edge_climb(w, model, mu, box, start, tolerance, room, fit, trial):
    """Climb from `start` (5,) within box (10,), low and high of each unknown; the top is in fit.

    Ends with a step that would raise S by less than `tolerance`, which is still made where it helps. room: as of
    `edge_project`, then m (5, 6), step (10,) and the next point (5,).
    """
    m, step, at = room[3], room[4], room[5]
    for k in range(UNKNOWNS):
        at[k] = min(max(start[k], box[2 * k]), box[2 * k + 1])
    damping, fit[3], last = 1e-4, -1.0, False
    for _ in range(_STEPS):
        edge_project(w, model, mu, at, room, trial)
        if trial[3] > fit[3]:
            for k in range(SIZE):
                fit[k] = trial[k]
            damping = 0.1 * damping
        else:
            damping = max(10.0 * damping, 1e-3)
        if last:
            return
        _step(fit, damping, box, m, step)
        step[2], gain = min(max(step[2], -_TURN), _TURN), 0.0
        for k in range(UNKNOWNS):
            at[k] = fit[23 + k] + step[k]
            gain += fit[18 + k] * step[k]
        last = not gain >= tolerance
