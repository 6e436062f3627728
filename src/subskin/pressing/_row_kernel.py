"""The inner loops on a row, compiled: products with circulants by FFT, and conjugate gradients between bounds.

Python's own cost of a call would be most of the time at the sizes of a contact; so is the plain FFT here, which with
nothing around it is as quick as a library's. row.py says what is solved, and how.
"""

from __future__ import annotations

import numpy as np

from .._compiled import compiled

__all__ = ["circulant", "minimise"]

_STEPS = 60
"""Conjugate gradients before a guess is given up; seven or so are enough."""
_CHANGES = 300
_LOOSE = 0.03
"""A guess is solved to this share of what breaks its bounds: it is about to change."""
_PATIENCE = 10
"""Guesses changed as a whole without fewer rules broken, before they are changed node by node."""


@compiled()
def _fft(xr, xi, yr, yi, wr, wi):
    """Fourier transform of xr + i xi, of a length that is a power of two: radix 4, sorting itself (Stockham).

    wr + i wi are exp(-i pi k / n), k < 2 n. All four arrays are overwritten; returns the two that
    hold the answer, and the two others.
    """
    length, stride = xr.size, 1
    while length > 1:
        if length % 4 == 0:
            m = length // 4
            for p in range(m):
                k = 2 * p * stride
                w1r, w1i, w2r, w2i, w3r, w3i = wr[k], wi[k], wr[2 * k], wi[2 * k], wr[3 * k], wi[3 * k]
                i0 = stride * p
                i1, i2, i3, o = i0 + stride * m, i0 + 2 * stride * m, i0 + 3 * stride * m, 4 * i0
                for q in range(stride):
                    ar, ai = xr[i0 + q] + xr[i2 + q], xi[i0 + q] + xi[i2 + q]
                    br, bi = xr[i0 + q] - xr[i2 + q], xi[i0 + q] - xi[i2 + q]
                    cr, ci = xr[i1 + q] + xr[i3 + q], xi[i1 + q] + xi[i3 + q]
                    dr, di = xr[i1 + q] - xr[i3 + q], xi[i1 + q] - xi[i3 + q]
                    yr[o + q], yi[o + q] = ar + cr, ai + ci
                    tr, ti = br + di, bi - dr
                    yr[o + stride + q], yi[o + stride + q] = tr * w1r - ti * w1i, tr * w1i + ti * w1r
                    tr, ti = ar - cr, ai - ci
                    yr[o + 2 * stride + q], yi[o + 2 * stride + q] = tr * w2r - ti * w2i, tr * w2i + ti * w2r
                    tr, ti = br - di, bi + dr
                    yr[o + 3 * stride + q], yi[o + 3 * stride + q] = tr * w3r - ti * w3i, tr * w3i + ti * w3r
            length, stride = m, 4 * stride
        else:
            m = length // 2
            for p in range(m):
                k = 2 * p * stride
                w1r, w1i = wr[k], wi[k]
                i0 = stride * p
                i1, o = i0 + stride * m, 2 * i0
                for q in range(stride):
                    tr, ti = xr[i0 + q] - xr[i1 + q], xi[i0 + q] - xi[i1 + q]
                    yr[o + q], yi[o + q] = xr[i0 + q] + xr[i1 + q], xi[i0 + q] + xi[i1 + q]
                    yr[o + stride + q], yi[o + stride + q] = tr * w1r - ti * w1i, tr * w1i + ti * w1r
            length, stride = m, 2 * stride
        xr, yr = yr, xr
        xi, yi = yi, xi
    return xr, xi, yr, yi


@compiled()
def circulant(x, op, room, out):
    """The product of a symmetric circulant with x, zeros after its end.

    `op` is its real spectrum, of h + 1 waves, and the table exp(-i pi k / h) = wr + i wi, k < 2 h.
    Even and odd positions are the two halves of a complex transform of half the length h; `room` is (4, h).
    """
    spectrum, wr, wi = op
    half = spectrum.size - 1
    n = x.size
    xr, xi, yr, yi = room[0], room[1], room[2], room[3]
    for j in range(n // 2):
        xr[j], xi[j] = x[2 * j], x[2 * j + 1]
    for j in range(n // 2, half):
        xr[j] = xi[j] = 0.0
    if n % 2:
        xr[n // 2] = x[n - 1]
    zr, zi, yr, yi = _fft(xr, xi, yr, yi, wr, wi)
    a, b = (zr[0] + zi[0]) * spectrum[0], (zr[0] - zi[0]) * spectrum[half]
    scale = 1.0 / half
    zr[0], zi[0] = 0.5 * scale * (a + b), 0.5 * scale * (a - b)
    for k in range(1, half // 2 + 1):
        j = half - k
        # even and odd parts of the transform at k; at j they are the conjugates
        er, ei = 0.5 * (zr[k] + zr[j]), 0.5 * (zi[k] - zi[j])
        gr, gi = 0.5 * (zi[k] + zi[j]), 0.5 * (zr[j] - zr[k])
        hr, hi = gr * wr[k] - gi * wi[k], gr * wi[k] + gi * wr[k]
        s, d = 0.5 * scale * (spectrum[k] + spectrum[j]), 0.5 * scale * (spectrum[k] - spectrum[j])
        ar, ai = s * er + d * hr, s * ei + d * hi
        br, bi = d * er + s * hr, d * ei + s * hi
        cr, ci = br * wr[k] + bi * wi[k], bi * wr[k] - br * wi[k]
        zr[k], zi[k] = ar - ci, ai + cr
        zr[j], zi[j] = ar + ci, cr - ai
    # the way back is the way there with the two parts exchanged
    odd, even, yr, yi = _fft(zi, zr, yi, yr, wr, wi)
    for j in range(n // 2):
        out[2 * j], out[2 * j + 1] = even[j], odd[j]
    if n % 2:
        out[n - 1] = even[n // 2]


@compiled()
def _project(sums, spread, gram, z):
    """The multipliers that make the sums of z vanish; z is changed."""
    count, n = sums.shape
    totals, multipliers = np.zeros(count), np.zeros(count)
    for c in range(count):
        for i in range(n):
            totals[c] += sums[c, i] * z[i]
    for c in range(count):
        for d in range(count):
            multipliers[c] += gram[c, d] * totals[d]
        for i in range(n):
            z[i] -= multipliers[c] * spread[c, i]
    return multipliers


@compiled()
def _gram(sums, spread):
    """Inverse of the matrix sums @ spread.T, of at most two rows."""
    count, n = sums.shape
    g = np.zeros((count, count))
    for c in range(count):
        for d in range(count):
            for i in range(n):
                g[c, d] += sums[c, i] * spread[d, i]
    if count == 1:
        g[0, 0] = 1.0 / g[0, 0]
    elif count == 2:
        det = g[0, 0] * g[1, 1] - g[0, 1] * g[1, 0]
        g[0, 0], g[1, 1] = g[1, 1] / det, g[0, 0] / det
        g[0, 1], g[1, 0] = -g[0, 1] / det, -g[1, 0] / det
    return g


@compiled()
def _release(x, gradient, low, high, free, short):
    """Free one node where none is left to carry a sum: the first that would move as what is missing grows."""
    best = -1
    for i in range(x.size):
        if high[i] > low[i] and x[i] == (low[i] if short > 0 else high[i]):
            before = best < 0 or (gradient[i] < gradient[best] if short > 0 else gradient[i] > gradient[best])
            best = i if before else best
    if best >= 0:
        free[best] = True


@compiled()
def minimise(k, m, problem, x, free, gradient, limit):
    """Least of x K x / 2 + f x, low <= x <= high, sums @ x = targets, from x; x, free and gradient are overwritten.

    k is K and m its preconditioner, as in `circulant`. In the problem f, low, high have the shape (n,), sums (c, n),
    targets (c,), c being 0, 1 or 2; `own` is what a node's own x adds to its gradient. Nodes with low = high stay
    there. Returns the multipliers and the steps taken; what they are worth, the certificate says.
    """
    f, low, high, sums, targets, own = problem
    n, count = x.size, sums.shape[0]
    kroom, mroom = np.empty((4, k[0].size - 1)), np.empty((4, m[0].size - 1))
    spread, masked, z = np.zeros((count, n)), np.zeros(n), np.zeros(n)
    direction, moved = np.zeros(n), np.zeros(n)
    multipliers, taken, missing = np.zeros(count), 0, np.zeros(count)
    fewest, patience, slow = n + 1, _PATIENCE, False
    for _ in range(_CHANGES):
        some = False
        for i in range(n):
            if not free[i]:
                x[i] = low[i] if x[i] - low[i] <= high[i] - x[i] else high[i]
            some = some or free[i]
        if count > 0 and not some:
            circulant(x, k, kroom, gradient)
            short = targets[0]
            for i in range(n):
                gradient[i] += f[i]
                short -= sums[0, i] * x[i]
            _release(x, gradient, low, high, free, short)
        for c in range(count):
            for i in range(n):
                masked[i] = sums[c, i] if free[i] else 0.0
            circulant(masked, m, mroom, spread[c])
            missing[c] = targets[c]
            for i in range(n):
                missing[c] -= sums[c, i] * x[i]
                if not free[i]:
                    spread[c, i] = 0.0
        gram = _gram(sums, spread)
        for c in range(count):
            for d in range(count):
                for i in range(n):
                    x[i] += gram[c, d] * missing[d] * spread[c, i]
        circulant(x, k, kroom, gradient)
        for i in range(n):
            gradient[i] += f[i]
            direction[i] = 0.0
        before, settled = 1.0, False
        for step in range(_STEPS + 1):
            for i in range(n):
                masked[i] = gradient[i] if free[i] else 0.0
            circulant(masked, m, mroom, z)
            for i in range(n):
                if not free[i]:
                    z[i] = 0.0
            multipliers = _project(sums, spread, gram, z)
            error = breaks = now = 0.0
            for i in range(n):
                if free[i]:
                    residual = gradient[i]
                    for c in range(count):
                        residual -= multipliers[c] * sums[c, i]
                    now += residual * z[i]
                    error = max(error, abs(residual))
                    breaks = max(breaks, low[i] - x[i], x[i] - high[i])
            settled = error <= limit
            if settled or (not slow and error <= _LOOSE * own * breaks) or step == _STEPS or not now > 0.0:
                break
            ratio, before = now / before, now
            for i in range(n):
                direction[i] = ratio * direction[i] - z[i]
            circulant(direction, k, kroom, moved)
            curve = 0.0
            for i in range(n):
                curve += direction[i] * moved[i]
            if not curve > 0.0:  # a singular K, and nothing that holds its null space
                break
            length = now / curve
            for i in range(n):
                x[i] += length * direction[i]
                gradient[i] += length * moved[i]
            taken += 1
        broken, far, last = 0, 0.0, -1
        for i in range(n):
            for c in range(count):
                gradient[i] -= multipliers[c] * sums[c, i]
            out = max(low[i] - x[i], x[i] - high[i]) if free[i] else 0.0
            back = (
                not free[i] and high[i] > low[i] and (gradient[i] < -limit if x[i] == low[i] else gradient[i] > limit)
            )
            if out > 0.0 or back:
                far = np.inf if back else max(far, out)
                broken, last = broken + 1, i
        done = settled and own * far <= limit
        if broken < fewest:
            fewest, patience, slow = broken, _PATIENCE, False
        elif patience > 0:
            patience -= 1
        else:
            slow = True
        for i in range(n):
            if slow and not done and i != last:
                continue
            if free[i]:
                if x[i] < low[i] or x[i] > high[i]:
                    x[i], free[i] = low[i] if x[i] < low[i] else high[i], False
            elif high[i] > low[i] and (gradient[i] < -limit if x[i] == low[i] else gradient[i] > limit):
                free[i] = True
        if done:
            return multipliers, taken
    for i in range(n):
        x[i] = min(max(x[i], low[i]), high[i])
    return multipliers, taken
