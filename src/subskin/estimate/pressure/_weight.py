"""The weight of smoothness by a rule, compiled: evidence, discrepancy, or generalised cross-validation.

In the generalised singular system of sensors and smoothness (`_operator.Factors`) a weight w leaves the share
a_i = w / (S_i^2 + w) of each component of the readings b. With c_i = (U^T b)_i the rules are

    evidence        least of       sum a_i c_i^2 - sum ln a_i        the readings' probability, p being Gaussian
    discrepancy     root of        sum a_i^2 c_i^2 - n               as much is left as noise makes
    gcv             least of       sum a_i^2 c_i^2 / (sum a_i)^2     (Golub, Heath and Wahba 1979)

each written as a root in ln w, and found from the smooth side.
"""

from __future__ import annotations

import math

from ..._compiled import compiled

EVIDENCE, DISCREPANCY, GCV = 0, 1, 2
LOWEST, HIGHEST = -28.0, 6.0
"""Of ln(w / largest S^2)."""

_STEP = 0.5
_LEAST_FREE = 0.25  # of the readings: with less left over, cross-validation rests on a few accidents of noise


@compiled()
def _rule(u, power, squares, kind):
    """What is 0 at the rule's weight w = e^u, rising through it: power is (U^T b)^2."""
    w = math.exp(u)
    n = squares.size
    one = two = three = four = 0.0
    for i in range(n):
        a = w / (squares[i] + w)  # the share of this component that is left unexplained
        one += a * (1.0 - a) * power[i]
        two += 1.0 - a
        three += a * a * power[i]
        four += a * a * (1.0 - a) * power[i]
    if kind == EVIDENCE:
        return one - two
    if kind == DISCREPANCY:
        return three - n
    free = n - two
    taken = 0.0
    for i in range(n):
        a = w / (squares[i] + w)
        taken += a * (1.0 - a)
    return four * free - three * taken


@compiled()
def _free(u, squares):
    """Degrees of freedom that the readings keep at the weight e^u."""
    w = math.exp(u)
    s = 0.0
    for i in range(squares.size):
        s += w / (squares[i] + w)
    return s


@compiled()
def weigh(power, squares, kind):
    """Ln w of the rule: its first root from the smooth side."""
    top = 0.0
    for i in range(squares.size):
        top = max(top, squares[i])
    base = math.log(top)
    high = base + HIGHEST
    above = _rule(high, power, squares, kind)
    if above <= 0.0:
        return high
    while True:
        low = high - _STEP
        if low < base + LOWEST or (kind == GCV and _free(high, squares) < _LEAST_FREE * squares.size):
            return high
        below = _rule(low, power, squares, kind)
        if below <= 0.0:
            break
        high, above = low, below
    for _ in range(60):  # false position, Illinois; halving when that is slow
        u = (low * above - high * below) / (above - below)
        value = _rule(u, power, squares, kind)
        if value == 0.0 or high - low < 1e-12:
            return u
        if value > 0.0:
            if abs(u - high) < 1e-12:
                return u
            high, above, below = u, value, 0.5 * below
        else:
            if abs(u - low) < 1e-12:
                return u
            low, below, above = u, value, 0.5 * above
    return 0.5 * (low + high)
