"""Compiled: the best components of a force that presses within the cone of friction, exactly.

Maximises S = 2 b.theta - theta.G theta, G = A^T A and b = A^T w, over N >= 0 and |T| <= mu N, of theta = N, (N, T) or
(N, Ty, Tz). Inside the cone that is a solve of as many equations. On that of three, theta = N (1, mu cos phi,
mu sin phi) and S = (b.e)^2 / (e.G e) in phi alone. The set is convex, so the best of the two is the best there is.
"""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled
from .._lanes import answers, nought, root, where

_STEPS, _SHORT = 12, 1e-3
"""Turns on the cone at most; and the last one [rad], after which about a tenth of its square is left."""
_TURNS = 2 * np.pi * np.arange(12) / 12
_DIRECTIONS = np.stack([np.cos(_TURNS), np.sin(_TURNS)], axis=-1)


@compiled(inline=True)
def eliminate_one(g, b, least, most):
    """The best N in least <= N <= most, S there, the inverse of G where N is free, else 0, and 1 where it is."""
    n = b / g if g > 0.0 else 0.0
    if least <= n <= most:
        return n, b * n, (1.0 / g if n > 0.0 else 0.0), (1.0 if n > 0.0 else 0.0)
    n = min(max(n, least), most)
    return n, n * (2.0 * b - n * g), 0.0, 0.0


@compiled(borrows=True)
def _at_an_edge(g00, g01, g11, b0, b1, mu, least, most):
    """The first six numbers of `eliminate_two` where something binds."""
    best = n = t = i00 = i01 = i11 = 0.0
    if least > 0.0:
        best = -math.inf
    for side in range(2):
        sign = 2.0 * side - 1.0
        if mu < math.inf:  # an edge of the cone
            size, along = g00 + 2.0 * sign * mu * g01 + mu * mu * g11, b0 + sign * mu * b1
            free = size > 0.0 and least * size < along < most * size
            pressed = min(max(along / size, least), most) if size > 0.0 else least
            height = pressed * (2.0 * along - pressed * size)
            if height > best:
                best, n, t = height, pressed, sign * mu * pressed
                i00 = 1.0 / size if free else 0.0
                i01, i11 = sign * mu * i00, mu * mu * i00
        pressed = least if side == 0 else most
        if pressed < math.inf and g11 > 0.0:  # an end of N
            drag = (b1 - g01 * pressed) / g11
            if abs(drag) <= mu * pressed or mu == math.inf:
                height = pressed * (2.0 * b0 - pressed * g00) + drag * (b1 - g01 * pressed)
                if height > best:
                    best, n, t = height, pressed, drag
                    i00, i01, i11 = 0.0, 0.0, 1.0 / g11
    return n, t, best, i00, i01, i11


@compiled(inline=True)
def eliminate_two(g00, g01, g11, b0, b1, mu, least, most):
    """The best N and T, with least <= N <= most; S; the inverse of G in what is left free (00, 01, 11); and 1 inside.

    All is free inside the cone, one direction on an edge of it or at an end of N, nothing in a corner. One end of N may
    be missing: 0 and infinity.
    """
    det = g00 * g11 - g01 * g01
    inverse = 1.0 / det
    n, t = (g11 * b0 - g01 * b1) * inverse, (g00 * b1 - g01 * b0) * inverse
    i00, i01, i11, explained, inside = g11 * inverse, -g01 * inverse, g00 * inverse, b0 * n + b1 * t, 1.0
    if not (det > 1e-14 * g00 * g11 and n >= 0.0 and abs(t) <= mu * n and least <= n <= most):
        n, t, explained, i00, i01, i11 = _at_an_edge(g00, g01, g11, b0, b1, mu, least, most)
        inside = 1.0 if mu == 0.0 and i00 > 0.0 else 0.0  # a drag of 0 is no edge
    return n, t, explained, i00, i01, i11, inside


@compiled(inline=True)
def cofactors(g00, g01, g02, g11, g12, g22):
    """The six cofactors of G (00, 01, 02, 11, 12, 22), and its determinant."""
    c00, c01, c02 = g11 * g22 - g12 * g12, g02 * g12 - g01 * g22, g01 * g12 - g02 * g11
    c11, c12, c22 = g00 * g22 - g02 * g02, g01 * g02 - g00 * g12, g00 * g11 - g01 * g01
    return c00, c01, c02, c11, c12, c22, g00 * c00 + g01 * c01 + g02 * c02


@compiled(inline=True)
def _turn(g, b, mu, c, s, asked):
    """Newton's steps in phi from the direction (c, s) of the drag: the direction they end at, and the last, squared.

    A lane that has come to rest moves no more.
    """
    last = nought(c) + 1.0
    (g00, g01, g02, g11, g12, g22), (b0, b1, b2) = g, b
    h01, h02 = 2.0 * mu * g01, 2.0 * mu * g02
    half, across, twice = 0.5 * mu * mu * (g11 + g22), 0.5 * mu * mu * (g11 - g22), mu * mu * g12
    for _ in range(_STEPS):
        moves = asked & (last >= _SHORT * _SHORT)
        c2, s2 = c * c - s * s, 2.0 * c * s
        along, size = b0 + mu * (b1 * c + b2 * s), g00 + half + h01 * c + h02 * s + across * c2 + twice * s2
        d_along, d_size = mu * (b2 * c - b1 * s), h02 * c - h01 * s + 2.0 * (twice * c2 - across * s2)
        dd_along, dd_size = b0 - along, -h01 * c - h02 * s - 4.0 * (across * c2 + twice * s2)
        slope = 2.0 * d_along * size - along * d_size
        curve = 2.0 * dd_along * size + d_along * d_size - along * dd_size
        step = where(curve < 0.0, -slope / curve, where(slope < 0.0, nought(c) - 0.1, nought(c) + 0.1))
        step = where(step > 0.3, 0.3, where(step < -0.3, -0.3, step))
        quarter = 0.25 * step * step  # a turn by twice atan(step / 2), which ends where one by step does
        one, along_it = 1.0 / (1.0 + quarter), 1.0 - quarter
        x, y = one * (c * along_it - s * step), one * (s * along_it + c * step)
        c, s, last = where(moves, x, c), where(moves, y, s), where(moves, step * step, last)
        if answers(asked & (last >= _SHORT * _SHORT)) == 0:
            break
    return c, s, last


@compiled(inline=True)
def _best_direction(g, b, mu):
    """The drag's direction of twelve whose load on the cone explains most, and how much; 0 where none presses."""
    (g00, g01, g02, g11, g12, g22), (b0, b1, b2) = g, b
    h01, h02 = 2.0 * mu * g01, 2.0 * mu * g02
    half, across, twice = 0.5 * mu * mu * (g11 + g22), 0.5 * mu * mu * (g11 - g22), mu * mu * g12
    best, c, s = nought(g00), nought(g00) + 1.0, nought(g00)
    for k in range(_DIRECTIONS.shape[0]):
        x, y = _DIRECTIONS[k, 0], _DIRECTIONS[k, 1]
        along = b0 + mu * (b1 * x + b2 * y)
        size = g00 + half + h01 * x + h02 * y + across * (x * x - y * y) + 2.0 * twice * x * y
        better = (along > 0.0) & (along * along > best * size)
        best, c, s = where(better, along * along / size, best), where(better, x, c), where(better, y, s)
    return best, c, s


@compiled(inline=True)
def _pressed(g, b, mu, c, s):
    """Of e = (1, mu c, mu s): b.e, e.G e, the last two of G e, and how S rises out of the cone."""
    (g00, g01, g02, g11, g12, g22), (b0, b1, b2) = g, b
    along = b0 + mu * (b1 * c + b2 * s)
    g_e1, g_e2 = g01 + mu * (g11 * c + g12 * s), g02 + mu * (g12 * c + g22 * s)
    size = g00 + mu * (g01 * c + g02 * s) + mu * (c * g_e1 + s * g_e2)
    return along, size, g_e1, g_e2, (b1 * c + b2 * s) * size - along * (g_e1 * c + g_e2 * s)


@compiled(borrows=True)
def on_cone(g, b, mu, ty, tz, asked):
    """The first ten numbers of a fit on the cone, or of eight in lanes, of which those that are asked are sure to hold.

    g: 00, 01, 02, 11, 12, 22 of G; b (3); (ty, tz) may be any drag; best is one that points as the best does.
    Where S has no slope along the cone, and rises out of it, the load is the best there is: S has one top and the cone
    is convex. Where the drag given does not lead there, twelve directions are tried.
    """
    (g00, _, _, g11, g12, g22), (b0, b1, b2) = g, b
    none = nought(g00)
    if mu == 0.0:
        over = where((b0 > 0.0) & (g00 > 0.0), 1.0 / g00, none)
        return b0 * over, none, none, b0 * b0 * over, over, none, none, none, none, none
    if mu == math.inf:  # nothing but N >= 0 binds
        det = g11 * g22 - g12 * g12
        over = where(det > 1e-13 * g11 * g22, 1.0 / det, none)
        ty, tz = (g22 * b1 - g12 * b2) * over, (g11 * b2 - g12 * b1) * over
        return none, ty, tz, b1 * ty + b2 * tz, none, none, none, g22 * over, -g12 * over, g11 * over
    square = ty * ty + tz * tz
    known = (square > 0.0) & (square < math.inf)
    over = 1.0 / root(square)
    c, s = where(known, over * ty, none + 1.0), where(known, over * tz, none)
    c, s, last = _turn(g, b, mu, c, s, asked & known)
    along, size, g_e1, g_e2, out = _pressed(g, b, mu, c, s)
    found = known & (last < _SHORT * _SHORT) & (along > 0.0) & (out >= 0.0)
    presses = where(found, none + 1.0, none)
    lost = asked & (presses < 0.5)
    if answers(lost) > 0:
        best, x, y = _best_direction(g, b, mu)
        x, y, last = _turn(g, b, mu, x, y, lost & (best > 0.0))
        c, s, presses = where(found, c, x), where(found, s, y), where(found, presses, best)
        along, size, g_e1, g_e2, out = _pressed(g, b, mu, c, s)
    n = where(presses > 0.0, along / size, none)
    # free are N along e, and phi along f = (0, -mu s, mu c), in which the cone is curved
    cross = mu * (c * g_e2 - s * g_e1)
    pull = out / (mu * along)
    other = mu * mu * (s * s * g11 - 2.0 * s * c * g12 + c * c * g22 + pull)
    det = size * other - cross * cross
    over = where((presses > 0.0) & (det > 0.0), 1.0 / det, none)
    i00, i01, i11 = other * over, -cross * over, size * over
    i00, i01, i11 = where(over > 0.0, i00, none), where(over > 0.0, i01, none), where(over > 0.0, i11, none)
    e1, e2, f1, f2 = mu * c, mu * s, -mu * s, mu * c
    return (
        n, n * e1, n * e2, where(presses > 0.0, along * n, none), i00, i00 * e1 + i01 * f1, i00 * e2 + i01 * f2,
        i00 * e1 * e1 + 2.0 * i01 * e1 * f1 + i11 * f1 * f1,
        i00 * e1 * e2 + i01 * (e1 * f2 + e2 * f1) + i11 * f1 * f2,
        i00 * e2 * e2 + 2.0 * i01 * e2 * f2 + i11 * f2 * f2,
    )  # fmt: skip


@compiled(inline=True)
def eliminate_three(g00, g01, g02, g11, g12, g22, b0, b1, b2, mu):
    """The best N, Ty, Tz; S; the inverse of G in what is left free (00, 01, 02, 11, 12, 22); and 1 inside.

    Inside the cone all of theta is free, on it what keeps to it, at its tip nothing.
    """
    i00, i01, i02, i11, i12, i22, det = cofactors(g00, g01, g02, g11, g12, g22)
    over = 1.0 / det
    i00, i01, i02, i11, i12, i22 = over * i00, over * i01, over * i02, over * i11, over * i12, over * i22
    n, ty, tz = i00 * b0 + i01 * b1 + i02 * b2, i01 * b0 + i11 * b1 + i12 * b2, i02 * b0 + i12 * b1 + i22 * b2
    explained, inside = b0 * n + b1 * ty + b2 * tz, 1.0
    if not (det > 1e-13 * g00 * g11 * g22 and n >= 0.0 and ty * ty + tz * tz <= mu * mu * n * n):
        n, ty, tz, explained, i00, i01, i02, i11, i12, i22 = on_cone(
            (g00, g01, g02, g11, g12, g22), (b0, b1, b2), mu, ty, tz, True
        )
        inside = 0.0
    return n, ty, tz, explained, i00, i01, i02, i11, i12, i22, inside


@compiled(inline=True)
def admissible_one(n, least, most):
    """Whether N keeps to its ends."""
    return least <= n <= most


@compiled(inline=True)
def admissible_two(n, t, mu, least, most):
    """Whether a force keeps to the cone, and N to its ends."""
    return least <= n <= most and abs(t) <= mu * n


@compiled(inline=True)
def admissible_three(n, ty, tz, mu):
    """Whether a force keeps to the cone."""
    return n >= 0.0 and ty * ty + tz * tz <= mu * mu * n * n
