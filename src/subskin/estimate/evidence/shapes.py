"""What no named kind is: contacts of other shapes and widths; and rollers that stick: all as sums of line loads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..._check import FloatArray
from ...contact import FlatPunch, Hertz, SpreadContact, Strip, Wedge
from ...contact.families import family_of
from .kind import NONE, PAIR, Kind

__all__ = ["EDGE", "END", "OtherShape", "root_moment", "shapes", "sticking"]

EDGE, END = 0.2, 1.2
"""Where a vertex ends and the sides begin, and where these end: root of the pressure's second moment, in depths."""
_BEYOND = 1.7
"""Up to where rollers and flat bars are weighed that are wider than the sides."""
_LEAN = 0.6
"""Of a pressure that rises from one side to the other: its slope over its mean."""
_STICK = 0.7
"""Half width of the zone that sticks, over the contact's: a drag of half of what friction holds."""
_FAMILIES: tuple[tuple[type[SpreadContact], float], ...] = (
    (Strip, END),
    (Wedge, END),
    (Hertz, _BEYOND),
    (FlatPunch, _BEYOND),
)
_HOLLOW = 3.0
"""Of a pressure that is less in the middle: by how much its edges have more, over the middle."""
_PRESSURES = (
    ((1.0, 0.0, -1.0), 1.0), ((1.0, 0.0, _HOLLOW), 0.5), ((1.0, -_LEAN), 0.5), ((1.0, _LEAN), 0.5),
)  # fmt: skip
"""Powers of t, and shares: a parabola, a hollow pressure, and pressures that rise to either side."""
_NODES = 40


class OtherShape(NamedTuple):
    """Contacts of one shape: line loads and their weights as of `Response.of_lines`, half widths [m], and a share."""

    lines: FloatArray
    weights: FloatArray
    half_width: tuple[float, float]
    share: float


def root_moment(lines: FloatArray, weights: FloatArray) -> float:
    """Root of the second moment of the pressure about the position, in half widths."""
    pressure = weights if weights.ndim == 1 else weights[:, 0]
    return float(np.sqrt((pressure * lines**2).sum()))


def _polynomial(*coefficients: float) -> tuple[FloatArray, FloatArray]:
    """A pressure of these powers of t on |t| <= 1, about its centroid."""
    t, weight = np.polynomial.legendre.leggauss(_NODES)
    weights = weight * np.polynomial.polynomial.polyval(t, coefficients)
    weights /= weights.sum()
    return t - (weights * t).sum(), weights


def sticking() -> tuple[FloatArray, FloatArray]:
    """A roller that sticks in its middle: its drag is the roller's, less the same on the zone that sticks.

    Source: Johnson, Contact Mechanics (1985), section 7.2; `PartialSlip`.
    """
    t, weights = Hertz.as_line_loads()
    none, share = np.zeros_like(weights), _STICK**2
    drag = np.concatenate([weights, -share * weights]) / (1 - share)
    return np.concatenate([t, _STICK * t]), np.stack([np.concatenate([weights, none]), drag], axis=-1)


def shapes(kinds: Sequence[Kind], depth: float) -> tuple[OtherShape, ...]:
    """Contacts that none of the `kinds` is, with their shares, for sensors at `depth` [m] or deeper.

    An even pressure, one that rises evenly to either side, a parabola's, wedges, rollers and flat bars: each family
    alike probable, a hollow pressure half as much; each from the edge of the sides on, where it is none of the kinds.
    """
    named: dict[type, list[tuple[float, float]]] = {}
    for kind in kinds:
        if kind.family not in (PAIR, NONE):
            named.setdefault(family_of(kind.family), []).append(kind.half_width)  # type: ignore[arg-type]
    found = []
    for family, end in _FAMILIES:
        lines, weights = family.as_line_loads()
        unit = depth / root_moment(lines, weights)
        left = _without((EDGE * unit, end * unit), named.get(family, []))
        found += [OtherShape(lines, weights, ends, (ends[1] - ends[0]) / sum(b - a for a, b in left)) for ends in left]
    for coefficients, share in _PRESSURES:
        lines, weights = _polynomial(*coefficients)
        unit = depth / root_moment(lines, weights)
        found.append(OtherShape(lines, weights, (EDGE * unit, END * unit), share))
    total = sum(shape.share for shape in found)
    return tuple(shape._replace(share=shape.share / total) for shape in found)


def _without(whole: tuple[float, float], taken: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The stretches of `whole` that are in none of the `taken`."""
    start, left = whole[0], []
    for low, high in sorted(taken):
        if low > start:
            left.append((start, min(low, whole[1])))
        start = max(start, high)
        if start >= whole[1]:
            break
    if start < whole[1]:
        left.append((start, whole[1]))
    return [(a, b) for a, b in left if b - a > 1e-9 * whole[1]]
