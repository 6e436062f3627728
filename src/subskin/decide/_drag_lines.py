"""How much of a Gaussian load with a drag of two components lies beyond a cone of friction: compiled loops.

A load holds where mu N > |T|. Along any line in space that is one interval, for the cone is convex. So lines are laid
across the cone's side, the normal distribution's tails count along each, and the rules of Gauss and Hermite count from
line to line. There the integrand hardly changes, as the lines lie side by side along the cone.
"""

from __future__ import annotations

import math

import numpy as np

from .._check import FloatArray
from .._compiled import compiled

__all__ = ["FEW_LINES", "GUESS_LINES", "LEAST", "above", "certain", "deviate", "hermite", "lines_of", "shares"]


def hermite(count: int) -> FloatArray:
    """Nodes and weights of Gauss and Hermite's rule for a standard normal variable, (2, count)."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(count)
    return np.stack([nodes, weights / weights.sum()])


_FEW_ACROSS, _ACROSS = hermite(4), hermite(8)
_FEW_ALONG, _ALONG, _MANY_ALONG = hermite(2), hermite(8), hermite(32)
_ROUND = np.stack(np.polynomial.legendre.leggauss(48)) * (math.pi / 2)
"""Nodes and weights over the angle about the cone's axis."""
_STRAIGHT, _BENT = 0.05, 0.25
"""Standard deviations by which the cone's side bends within one of the drag across: up to the first few lines serve,
beyond the second those about the axis."""
_STEADY = 0.2
"""Errors of the drag over the drag up to which few lines serve along the side."""
FEW_LINES, GUESS_LINES = (2, _FEW_ALONG, False), (3, _FEW_ALONG, False)
_PRESSES = 6.0
"""Standard deviations from 0 at which lines along the side of the cone do for its tip: what pulls is 1e-9."""
_LIGHT = 1e-14
"""Weights below which a line is passed over: all of them together are 1e-11."""
_LOWER, _UPPER, _WIDEST = 7.5, 9.5, 9.0
"""Standard deviations below which a load holds for no ratio |T| / N, above which for any, and of the drag across."""
_HALF, _BELL = math.sqrt(0.5), 1 / math.sqrt(2 * math.pi)
LEAST = 1e-300
_SURELY = 37.0
"""Beyond this 1 - Phi is 0, to the last bit that a float has."""


@compiled(inline=True, exact=True)
def above(z):
    """1 - Phi(z)."""
    return 0.5 * math.erfc(_HALF * z) if abs(z) < _SURELY else 0.0 if z > 0.0 else 1.0


@compiled(exact=True)
def lines_of(mean, c):
    """How straight the cone's side looks across, the rule along it, and whether its tip is near."""
    t, cc = abs(mean[1]) + LEAST, c[2, 2]
    # the least for any coefficient
    least = c[1, 1] - c[0, 1] * c[0, 1] / c[0, 0] if c[0, 0] > 0.0 else c[1, 1]
    spread = math.sqrt(max(least, 0.0)) + 1e-12 * t
    bend = cc / (spread * t)
    straight = 2 if bend < _STRAIGHT else 1 if bend < _BENT else 0
    if mean[0] < _PRESSES * math.sqrt(c[0, 0]):
        return straight, _MANY_ALONG, True
    return straight, _FEW_ALONG if math.sqrt(c[1, 1] + cc) < _STEADY * t else _ALONG, False


@compiled(exact=True)
def shares(mean, c, q, lines):
    """P(|T| > q N), or that it pulls; and the rest, P(|T| < q N): neither by a difference, for both may be small."""
    straight, along, tip = lines
    across = _FEW_ACROSS if straight >= 2 else _ACROSS if straight else _ROUND
    n, t, nn, nt, tt, cc = mean[0], mean[1], c[0, 0], c[0, 1], c[1, 1], c[2, 2]
    # of N, T and the drag across: eta goes along (dn, dt, dc), across the cone's side, xi along (1, lean, 0) rest
    lean = 0.0 if tip else -q if t < 0 else q
    share, turn = (c[0, 2] / cc, c[1, 2] / cc) if cc > 0.0 and not straight else (0.0, 0.0)
    nn, nt, tt = nn - share * c[0, 2], nt - share * c[1, 2], tt - turn * c[1, 2]
    spread = math.sqrt(max(tt - 2 * lean * nt + lean * lean * nn, 1e-24 * (n * n + t * t) + LEAST))
    dn, dt, dc = (nt - lean * nn) / spread, (tt - lean * nt) / spread, 0.0
    if abs(dt - lean * dn) < 0.5 * spread:  # no errors to speak of
        dn, dt = 0.0, spread
    elif straight:
        dc = (c[1, 2] - lean * c[0, 2]) / spread
        cc = max(cc - dc * dc, 0.0)
        share = (c[0, 2] - dn * dc) / cc if cc > 1e-12 * c[2, 2] else 0.0
        turn = lean * share
    rest, root = math.sqrt(max(nn - dn * dn - (share * share * cc if straight else 0.0), 0.0)), math.sqrt(cc)
    a, slips, holds = dt * dt + dc * dc - q * q * dn * dn, 0.0, 0.0
    reach = q * (n + _WIDEST * math.sqrt(c[0, 0]))
    if not straight and reach < _WIDEST * root:  # what lies farther across slips
        slips = 2.0 * above(reach / root) if reach > 0.0 else 1.0
    reach = min(reach, _WIDEST * root)
    for i in range(across.shape[1]):
        side, share_of = root * across[0, i], across[1, i]
        if not straight:
            side = reach * math.sin(across[0, i])
            share_of *= reach / root * math.cos(across[0, i]) * _BELL * math.exp(-0.5 * (side / root) ** 2)
        for j in range(along.shape[1]):
            weight = share_of * along[1, j]
            if weight < _LIGHT:
                continue
            xi = rest * along[0, j]
            drag, press = t + turn * side + lean * xi, n + share * side + xi
            b, d = drag * dt + side * dc - q * q * press * dn, drag * drag + side * side - q * q * press * press
            square, low, high = b * b - a * d, math.inf, math.inf  # a eta^2 + 2 b eta + d > 0 slips
            if square > 0.0:
                k = -(b + math.copysign(math.sqrt(square), b))
                one, two = k / a if a != 0.0 else math.copysign(math.inf, k), d / k
                low, high = min(one, two), max(one, two)
                if a >= 0.0:
                    if press + dn * (0.5 * (low + high) if a > 0.0 else two) <= 0.0:  # of the cone of loads that pull
                        low = high = math.inf
                elif dn > 0.0:
                    low, high = high, math.inf
                else:
                    low, high = -math.inf, low
            elif d < 0.0 < press:
                low = -math.inf
            if low == high:
                slips += weight
                continue
            slip = above(-low) + above(high)
            slips += weight * slip
            if slip < 0.5:
                holds += weight * (1.0 - slip)
            else:
                holds += weight * (above(low) - above(high) if low > 0.0 else above(-high) - above(-low))
    return slips, holds


@compiled(exact=True)
def deviate(one, other):
    """The z with Phi(-z) = one / (one + other), by Halley's steps from Abramowitz and Stegun (26.2.23)."""
    total = one + other
    p = max(min(one, other) / total, LEAST)
    w = math.sqrt(-2.0 * math.log(p))
    z = w - (2.515517 + w * (0.802853 + 0.010328 * w)) / (1.0 + w * (1.432788 + w * (0.189269 + 0.001308 * w)))
    for _ in range(2):
        over = (above(z) - p) / (_BELL * math.exp(-0.5 * z * z))
        z += over / (1.0 - 0.5 * z * over)
    return z if one < other else -z


@compiled(exact=True)
def certain(mean, c):
    """Ratios |T| / N below which a load slips for certain, and above which it holds; infinite where it may pull.

    There |T| - q N is so many of its standard deviations off 0; a drag across only adds to |T|.
    """
    n, t, side = mean[0], abs(mean[1]), -1.0 if mean[1] < 0 else 1.0
    nn, nt, tt = c[0, 0] + 1e-24 * n * n, side * c[0, 1], c[1, 1] + 1e-24 * t * t + LEAST
    size = t + math.sqrt(tt + c[2, 2])
    if n + _LOWER * math.sqrt(nn) <= 0.0:
        return math.inf, math.inf
    least = 1e-8 * size / (n + _LOWER * math.sqrt(nn))
    a, b, d = n * n - _LOWER**2 * nn, n * t - _LOWER**2 * nt, t * t - _LOWER**2 * tt
    square = b * b - a * d
    low = d / (b + math.sqrt(square)) if d > 0.0 and b > 0.0 and square > 0.0 else 0.0
    far = math.sqrt(t * t + _UPPER**2 * c[2, 2])
    a, b, d = n * n - _UPPER**2 * nn, n * far - _UPPER**2 * nt, far * far - _UPPER**2 * tt
    high = (b + math.sqrt(max(b * b - a * d, 0.0))) / a if n > 0.0 and a > 0.0 else math.inf
    return max(low, least), high
