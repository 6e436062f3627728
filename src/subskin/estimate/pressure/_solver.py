"""The pressure >= 0 at a weight, and the angle at which it fits best, compiled: exact, for one frame.

For whitened readings b and columns A, in the unknown heights x >= 0 of the elements,

    J = 1/2 |A x - b|^2 + 1/2 w x^T K x + cost x        with K the integral of (dp/dy)^2, or of |grad p|^2

is strictly convex, and its minimum is found exactly by block principal pivoting (Portugal, Judice and Vicente 1994; Kim
and Park 2011): guess which heights are > 0, solve for these, exchange all that came out with the wrong sign; and by
Lawson and Hanson's way (1974), which always arrives, where that goes in circles. Where the traction leans, A = A_p +
t A_q, and t = tan(angle) follows by Newton's method on the minimum J(t).
"""

from __future__ import annotations

import math

import numpy as np

from ..._compiled import compiled
from . import _on_area as on_area
from ._on_area import by_four

_ROUNDS = 300
_CLOSE = 1e-9  # of two tangents
TOLERANCE = 1e-11  # of a slope, of the largest that there is at x = 0


@compiled()
def _factor(level, t, w, count, work):
    """Cholesky factor of the Hessian's rows and columns `index`, into `lower`; False where it has none."""
    lower, index = work[4], work[5]
    if len(level) > 5:
        return on_area.hessian(level, w, True, work, count) and factored(lower, count)
    for i in range(count):
        _along(level, t, w, index, i, lower[i])
    return factored(lower, count)


@compiled(borrows=True)
def _divided(row, j, p, q, r, s, a, b, c, d):
    """Four numbers of a row of the factor, from j on, by four rows above; a to d: what the numbers before take away."""
    row[j] = (row[j] - a) * p[j]
    row[j + 1] = (row[j + 1] - b - row[j] * q[j]) * q[j + 1]
    row[j + 2] = (row[j + 2] - c - row[j] * r[j] - row[j + 1] * r[j + 1]) * r[j + 2]
    row[j + 3] = (row[j + 3] - d - row[j] * s[j] - row[j + 1] * s[j + 1] - row[j + 2] * s[j + 2]) * s[j + 3]


@compiled(borrows=True)
def factored(lower, count):
    """Put its Cholesky factor in the place of a matrix; False where it has none. The diagonal is kept inverted."""
    for i in range(0, count, 4):  # four rows and four columns at once: each number is fetched a quarter as often
        end = min(i + 4, count)
        one, two = lower[i], lower[min(i + 1, count - 1)]
        three, four = lower[min(i + 2, count - 1)], lower[min(i + 3, count - 1)]
        for j in range(0, i, 4):
            p, q, r, s = lower[j], lower[j + 1], lower[j + 2], lower[j + 3]
            ap, aq, ar, at, bp, bq, br, bt, cp, cq, cr, ct, dp, dq, dr, dt = by_four(
                one, two, three, four, p, q, r, s, j
            )
            _divided(one, j, p, q, r, s, ap, aq, ar, at)
            if end > i + 1:
                _divided(two, j, p, q, r, s, bp, bq, br, bt)
            if end > i + 2:
                _divided(three, j, p, q, r, s, cp, cq, cr, ct)
            if end > i + 3:
                _divided(four, j, p, q, r, s, dp, dq, dr, dt)
        for h in range(i, end):
            row = lower[h]
            for j in range(i, h):
                a = 0.0
                for k in range(j):
                    a += row[k] * lower[j, k]
                row[j] = (row[j] - a) * lower[j, j]
            a = 0.0
            for k in range(h):
                a += row[k] * row[k]
            pivot = row[h] - a
            if not pivot > 1e-15 * row[h]:
                return False
            row[h] = 1.0 / math.sqrt(pivot)
    return True


@compiled(borrows=True)
def _along(level, t, w, index, i, row):
    """Row i of the Hessian, up to its diagonal, of elements along a row."""
    gram, diagonal, beside = level[1], level[2], level[3]
    a = index[i]
    part = gram[0, a]
    if gram.shape[0] > 1:
        once, twice = gram[1, a], gram[2, a]
        for j in range(i + 1):
            c = index[j]
            row[j] = part[c] + t * (once[c] + t * twice[c])
    else:
        for j in range(i + 1):
            row[j] = part[index[j]]
    row[i] += w * diagonal[a]
    if i > 0 and index[i - 1] == a - 1:
        row[i - 1] += w * beside[a - 1]


@compiled()
def forward(lower, count, z):
    """Solve L z = z in place."""
    for i in range(count):
        s = 0.0
        for k in range(i):
            s += lower[i, k] * z[k]
        z[i] = (z[i] - s) * lower[i, i]


@compiled()
def variance_of(lower, count, index, weights, z):
    """The variance of a sum of unknowns with these weights; leaves L^-1 of the weights in z."""
    for k in range(count):
        z[k] = weights[index[k]]
    forward(lower, count, z)
    s = 0.0
    for k in range(count):
        s += z[k] * z[k]
    return s


@compiled()
def backward(lower, count, z):
    """Solve L^T z = z in place."""
    for i in range(count - 1, -1, -1):
        z[i] *= lower[i, i]
        for k in range(i):
            z[k] -= lower[i, k] * z[i]


@compiled()
def _solve(level, t, w, on, downhill, work):
    """The heights that are `on`, whatever their signs, into z: how many, or -1 where they are not determined."""
    lower, index, z = work[4], work[5], work[6]
    count = 0
    for j in range(on.size):
        if on[j]:
            index[count] = j
            z[count] = downhill[j]
            count += 1
    if not _factor(level, t, w, count, work):
        return -1
    forward(lower, count, z)
    backward(lower, count, z)
    return count


@compiled()
def _slope(level, w, b, work):
    """Residual A x - b into r and the gradient of J into `slope`."""
    if len(level) == 5:
        _slope_along(level, w, b, work)
    else:
        on_area.residual(b, work)
        on_area.slopes(level, w, work)


@compiled()
def _slope_along(level, w, b, work):
    """The same of elements along a row."""
    _, _, diagonal, beside, cost = level
    columns, x, slope, r, _, _, _, _ = work
    total, n = columns.shape
    for i in range(n):
        r[i] = -b[i]
    for j in range(total):
        if x[j] != 0.0:
            for i in range(n):
                r[i] += columns[j, i] * x[j]
    for j in range(total):
        s = cost[j] + w * diagonal[j] * x[j]
        if j > 0:
            s += w * beside[j - 1] * x[j - 1]
        if j + 1 < total:
            s += w * beside[j] * x[j + 1]
        for i in range(n):
            s += columns[j, i] * r[i]
        slope[j] = s


@compiled()
def minimise(level, t, w, b, downhill, on, work):
    """The x >= 0 of least J, from the guess `on` of what is > 0; how many are, or -1 where none was found.

    downhill (N,) is minus the gradient at 0. Leaves the factor of the Hessian on what is > 0 in `lower`, the numbers of
    these in `index`, and the gradient in `slope`.
    """
    x, slope, index, z = work[1], work[2], work[5], work[6]
    total = x.size
    tolerance = TOLERANCE * np.abs(downhill).max()
    patience = most = 3 if len(level) == 5 else 20  # on an area elements come one in a neighbourhood, over more rounds
    fewest = total + 1
    for _ in range(_ROUNDS):
        count = _solve(level, t, w, on, downhill, work)
        if count < 0:
            return -1
        x[:] = 0.0
        wrong = 0
        for k in range(count):
            x[index[k]] = z[k]
            wrong += z[k] < 0.0
        _slope(level, w, b, work)
        for j in range(total):
            wrong += not on[j] and slope[j] < -tolerance
        if wrong == 0:
            return count
        if wrong < fewest:
            fewest, patience = wrong, most
        elif patience > 0:
            patience -= 1
        else:
            return _descend(level, t, w, b, on, work, downhill, tolerance)
        for j in range(total):
            if on[j]:
                on[j] = x[j] >= 0.0
            else:
                on[j] = slope[j] < -tolerance
                if len(level) > 5:
                    on[j] &= on_area.steepest(level, slope, j)
    return -1


@compiled()
def _descend(level, t, w, b, on, work, downhill, tolerance):
    """The same from x, by Lawson and Hanson's way: downhill all along, one height more > 0 at a time."""
    x, slope, index, z = work[1], work[2], work[5], work[6]
    total = x.size
    for j in range(total):
        on[j] = x[j] > 0.0
        x[j] = max(x[j], 0.0)
    for _ in range(_ROUNDS):
        count = _solve(level, t, w, on, downhill, work)
        if count < 0:
            return -1
        share, first = 1.0, -1
        for k in range(count):
            if z[k] < 0.0 and x[index[k]] < share * (x[index[k]] - z[k]):
                share, first = x[index[k]] / (x[index[k]] - z[k]), k
        for k in range(count):
            j = index[k]
            x[j] += share * (z[k] - x[j])
            if k == first or x[j] < 0.0:
                x[j], on[j] = 0.0, False
        if first >= 0:
            continue
        for k in range(count):
            x[index[k]] = z[k]
        _slope(level, w, b, work)
        steepest = -1
        for j in range(total):
            if not on[j] and slope[j] < -tolerance and (steepest < 0 or slope[j] < slope[steepest]):
                steepest = j
        if steepest < 0:
            return count
        on[steepest] = True
    return -1


@compiled()
def turn(parts, work, count, along):
    """dJ/dt and d2J/dt2 at the minimum over x; leaves L^-1 d2J/dx dt in c."""
    columns, x, _, r, lower, index, _, c = work
    n = r.size
    along[:] = 0.0
    for k in range(count):
        j = index[k]
        for i in range(n):
            along[i] += parts[1, j, i] * x[j]
    first = second = 0.0
    for i in range(n):
        first += along[i] * r[i]
        second += along[i] * along[i]
    for k in range(count):
        j = index[k]
        s = 0.0
        for i in range(n):
            s += columns[j, i] * along[i] + parts[1, j, i] * r[i]
        c[k] = s
    forward(lower, count, c)
    for k in range(count):
        second -= c[k] * c[k]
    return first, second


@compiled()
def settle(level, t, low, high, w, b, on, work, near):
    """Least J over x >= 0 and over t in [low, high], from the guesses `on` and t: t and the count.

    Newton's method, with the bracket halved where it would leave it. With no second part t stays. level: columns by
    part (1 or 2, N, n), Hessians by power of t (1 or 3, N, N), K's diagonal and the line beside it, cost. work, all of
    it changed: columns at t (N, n), x, gradient, residual (n,), factor (N, N), the numbers of what is > 0, and scratch.
    """
    parts, columns = level[0], work[0]
    leans = parts.shape[0] > 1
    along, downhill = np.empty(b.size), np.empty(columns.shape[0])
    count, second = -1, math.inf
    a, d = low, high
    for _ in range(40):
        if leans:
            for j in range(columns.shape[0]):
                for i in range(columns.shape[1]):
                    columns[j, i] = parts[0, j, i] + t * parts[1, j, i]
        for j in range(downhill.size):
            s = -level[4][j]
            for i in range(b.size):
                s += columns[j, i] * b[i]
            downhill[j] = s
        count = minimise(level, t, w, b, downhill, on, work)
        if not leans or count < 0:
            return t, count
        first, second = turn(parts, work, count, along)
        if first > 0.0:
            d = t
        else:
            a = t
        # where J curves the wrong way there is no step: halve the bracket, whose ends slope towards each other
        new = t - first / second if second > 0.0 else math.inf
        if (t <= low and first >= 0.0) or (t >= high and first <= 0.0):
            return t, count  # at the edge of the cone
        new = min(max(new, low), high) if second > 0.0 else new
        if not a <= new <= d:
            new = 0.5 * (a + d)
        if abs(new - t) * math.sqrt(max(second, 0.0)) < near and (second > 0.0 or d - a < _CLOSE):
            return t, count
        t = new
    return t, count
