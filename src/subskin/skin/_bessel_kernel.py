"""Bessel functions of the first kind of many orders at once, compiled; imported only where they are needed."""

from __future__ import annotations

from .._compiled import compiled


@compiled(entry=True)
def bessel(x, first, second, out):
    """J_l(x), l = 0 ... n - 1, to rounding of the largest.

    x (m,), and J_0 and J_1 there; fills out (n, m). Upwards where x is larger than the order, which is stable there;
    else downwards from zero (Miller's algorithm; Abramowitz and Stegun, 9.12), so that J_0 + 2 J_2 + 2 J_4 + ... = 1.
    """
    n = out.shape[0]
    start = 2 * ((n + 14 + int(7 * n**0.5)) // 2)
    for j in range(x.size):
        at = x[j]
        if at >= n:
            below, here = first[j], second[j]
            out[0, j] = below
            if n > 1:
                out[1, j] = here
            for order in range(2, n):
                below, here = here, 2 * (order - 1) / at * here - below
                out[order, j] = here
            continue
        slope = 2 / max(at, 1e-20)
        above, here, total = 0.0, 1e-280, 0.0
        for order in range(start, 0, -1):
            above, here = here, order * slope * here - above
            if order <= n:
                out[order - 1, j] = here
            if order % 2 == 1:
                total += here if order == 1 else 2 * here
            if abs(here) > 1e250:
                above *= 1e-250
                here *= 1e-250
                total *= 1e-250
                for higher in range(order - 1, n):
                    out[higher, j] *= 1e-250
        for order in range(n):
            out[order, j] /= total
