"""A finger's response to contacts of one shape, as a table over place and width."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...contact import FlatPunch, Hertz, LineLoad, Strip, Wedge
from ...contact.spread import SpreadContact
from ...errors import InvalidValueError
from ...finger import Finger
from ...receptive_field import CELL_NODES, DEGREE, TO_POWERS, ReceptiveField

__all__ = ["FAMILIES", "Family", "ShapeField", "family_of"]

Family = type[SpreadContact] | type[LineLoad]

FAMILIES: dict[str, Family] = {
    "line": LineLoad, "wedge": Wedge, "hertz": Hertz, "strip": Strip, "punch": FlatPunch,
}  # fmt: skip
"""Contact families by name, from the narrowest."""

_WIDTHS = 14
"""Chebyshev nodes in the square of the width: 1e-7 of the largest reading where the widest is 1.5 depths."""
_POINTS = 40
_MOST_WIDE = 4.0
"""Depths up to which the nodes, and the scans that start from them, are close enough."""


def family_of(family: str | Family) -> Family:
    """The class of a named family, or one's own.

    Raises
    ------
    InvalidValueError
        An unknown name, something that is no contact of one width.
    """
    if isinstance(family, str):
        if family not in FAMILIES:
            raise InvalidValueError(f'family = "{family}"', f"has to be one of {', '.join(FAMILIES)}")
        return FAMILIES[family]
    if isinstance(family, type) and issubclass(family, SpreadContact | LineLoad):
        return family
    raise InvalidValueError(
        f"family = {family!r}",
        "a name or a subclass of SpreadContact is needed",
        f"one of {', '.join(FAMILIES)}",
    )


@dataclass(frozen=True, eq=False)
class ShapeField:
    """Readings under a unit normal and a unit tangential force, by the contact's place y and half width a.

    They are even in a, so in each cell of y the coefficients of the powers of t = (y - centre) / step are Chebyshev
    sums in 2 (a / widest)^2 - 1.

    Parameters
    ----------
    start, step, widest : float
        Left end and width of the cells, largest half width [m].
    coefficients : ndarray, shape (widths, cells, 5, n, 2)
        One width, that of a line, for `LineLoad`.
    """

    start: float
    step: float
    widest: float
    coefficients: FloatArray

    @property
    def stop(self) -> float:
        """Right end of the last cell [m]."""
        return float(self.start + self.step * self.coefficients.shape[1])

    @classmethod
    def of(cls, finger: Finger, family: Family, search: tuple[float, float], widest: float) -> ShapeField:
        """Tabulate a family from the finger's table for line loads: a contact is a sum of them, on any skin."""
        low, high = search
        depth = float(np.asarray(finger.array.depth).min())
        if widest > _MOST_WIDE * depth * (1 + 1e-12):
            raise InvalidValueError(
                f"half widths up to {widest:.6g} m",
                f"up to {_MOST_WIDE:g} depths of the shallowest sensor, {_MOST_WIDE * depth:.6g} m, can be fitted",
                f"width=(0.0, {_MOST_WIDE * depth:.3g})",
            )
        step = depth / 16
        cells = max(int(np.ceil((high - low) / step * (1 - 1e-12))), 1)
        step = (high - low) / cells
        positions = (low + step * (np.arange(cells) + 0.5))[:, None] + step * CELL_NODES
        if issubclass(family, LineLoad):
            values = finger.tabulate(search)(positions)[None]
            return cls(low, step, widest, _check.read_only(np.einsum("kj,wcjnl->wcknl", TO_POWERS, values)))
        line = finger.tabulate((low - widest, high + widest))
        shares = 0.5 * (1 + np.cos(np.pi * (np.arange(_WIDTHS) + 0.5) / _WIDTHS))
        t, weights = _points(family)
        values = np.stack([_spread(line, positions, widest * np.sqrt(q) * t, weights) for q in shares])
        matrix = np.polynomial.chebyshev.chebvander(2 * shares - 1, _WIDTHS - 1)
        sums = np.linalg.solve(matrix, values.reshape(_WIDTHS, -1)).reshape(values.shape)
        return cls(low, step, widest, _check.read_only(np.einsum("kj,wcjnl->wcknl", TO_POWERS, sums)))

    def __call__(self, position: npt.ArrayLike, half_width: npt.ArrayLike) -> FloatArray:
        """Values at `position` and `half_width` [m], broadcast to (...); the result is (..., n, 2)."""
        y, a = np.broadcast_arrays(
            np.asarray(position, dtype=np.float64), np.asarray(half_width, dtype=np.float64)
        )
        widths, cells = self.coefficients.shape[:2]
        cell = np.clip(np.floor((y - self.start) / self.step).astype(np.intp), 0, cells - 1)
        t = (y - self.start) / self.step - cell - 0.5
        wide = np.polynomial.chebyshev.chebvander(2 * (a / self.widest) ** 2 - 1, widths - 1)
        powers = np.vander(t.reshape(-1), DEGREE + 1, increasing=True).reshape(*t.shape, DEGREE + 1)
        return np.asarray(np.einsum("w...knl,...w,...k->...nl", self.coefficients[:, cell], wide, powers))


def _points(family: type[SpreadContact]) -> tuple[FloatArray, FloatArray]:
    """Places in half widths and weights of line loads that make the contact of unit force.

    t = sin(psi), whose slope takes up a root at the ends, and psi crowded towards 0, where a wedge has its tip.
    """
    v, weight = np.polynomial.legendre.leggauss(_POINTS)
    v, weight = 0.5 * (1 + v), 0.5 * weight
    psi = 0.5 * np.pi * v**3
    t = np.sin(psi)
    inside = np.minimum(t, np.nextafter(1.0, 0.0))
    pressure = family(force=1.0, half_width=1.0).pressure(inside)
    weights = pressure * np.cos(psi) * 1.5 * np.pi * v**2 * weight
    both = np.concatenate([-t[::-1], t]), np.concatenate([weights[::-1], weights])
    return both[0], both[1] / both[1].sum()


def _spread(
    line: ReceptiveField, positions: FloatArray, shifts: FloatArray, weights: FloatArray
) -> FloatArray:
    return np.asarray(sum(w * line(positions + s) for s, w in zip(shifts, weights, strict=True)))
