"""The line load: a knife edge across the skin (memo eqs. 1 to 4); and any contact as a sum of line loads."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .._check import ComplexArray, FloatArray
from ..errors import ConvergenceError
from .base import Contact, ContactSum, Transforms
from .functions import line, line_shear
from .profile import PressureProfile
from .spread import ProportionalContact

__all__ = ["LineLoad", "LineLoads", "line_loads"]

# From here on a compiled sum is worth the time that it takes to load it.
_MANY_LOADS, _MANY_POINTS = 8, 4096


@dataclass(frozen=True, eq=False)
class LineLoad(ProportionalContact, name="line"):
    """A load on a line of no width, F(z) = -1/z (Flamant 1892; memo eqs. 1 to 4).

    Parameters as in `ProportionalContact`.

    Examples
    --------
    >>> knife = LineLoad(force=40.0, angle=0.3, position=0.8e-3)
    >>> round(float(knife.normal_force), 3), round(float(knife.tangential_force), 3)
    (38.213, 11.821)
    """

    GROWTH = np.nan  # it has no width
    FORM = staticmethod(line)

    def unit_shear_field(self, z: ComplexArray, f: ComplexArray, df: ComplexArray) -> FloatArray:  # noqa: D102
        return np.asarray(line_shear(z.imag, f.real))

    def unit_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        return np.ones_like(k)

    def unit_pressure(self, y: FloatArray) -> FloatArray:  # noqa: D102
        return np.where(y == 0, np.inf, 0.0)

    def singular_points(self) -> tuple[FloatArray, ...]:  # noqa: D102
        return (np.broadcast_to(np.asarray(self.position, dtype=np.float64), self.shape),)

    @classmethod
    def joined(cls, parts: list[Contact]) -> list[Contact]:  # noqa: D102
        single = all(part.shape == () for part in parts)
        return [_Lines(tuple(parts))] if single and len(parts) >= _MANY_LOADS else parts


@dataclass(frozen=True, eq=False)
class _Lines(ContactSum):
    """Many single line loads, added up point by point in compiled code where there are many points."""

    @cached_property
    def _terms(self) -> tuple[Contact, ...]:
        return self.parts

    @cached_property
    def _loads(self) -> FloatArray:
        """Position, normal and tangential force of each, shape (3, n)."""
        rows = [[part.position for part in self.parts]]  # type: ignore[attr-defined]
        rows += [[part.normal_force for part in self.parts], [part.tangential_force for part in self.parts]]
        return np.array(rows, dtype=np.float64)

    def transforms(self, z: ComplexArray) -> Transforms:
        if z.size < _MANY_POINTS:
            return super().transforms(z)
        from ._compiled import add_lines

        out = np.empty((4, z.size), dtype=np.complex128)
        field = np.empty(z.size)
        add_lines(np.ascontiguousarray(z).reshape(-1), self._loads, out, field)
        p, dp, q, dq = out.reshape(4, *z.shape)
        return Transforms(p, dp, q, dq, field.reshape(z.shape))


_U, _W = np.polynomial.legendre.leggauss(12)
_PLAIN = 0.5 * (1 + _U), 0.5 * _W
# 3 u^2 - 2 u^3 makes a root at either end of a panel, above or below the line, a polynomial
_GRADED = 0.25 * (1 + _U) ** 2 * (2 - _U), 0.75 * (1 - _U**2) * _W
_T, _V = np.polynomial.legendre.leggauss(4)
_FEW = 0.5 * (1 + _T), 0.5 * _V
_SHORT = 0.125
"""Longest panel of a pressure of straight lines, in depths, on which four nodes are enough."""

_NEAR = 8.0 ** -np.arange(1, 6)
"""Distances from a root or a logarithm, in depths, at which panels end; the last of them are graded."""

_FORCE_ERROR = 1e-6


class LineLoads(NamedTuple):
    """Positions [m] and forces [N/m], normal and tangential, of the lines; all of shape (..., m)."""

    y: FloatArray
    normal: FloatArray
    tangential: FloatArray


def line_loads(contact: Contact, breaks: FloatArray, depth: float) -> LineLoads:
    """Line loads that act at `depth` and deeper as `contact` does, also where it is smooth only between `breaks`.

    Gauss's rule between the positions where the traction, or what it is to be multiplied with, is not smooth, on panels
    no wider than the depth: the skin's answer is smooth over that. The contact's shape broadcasts to the batch shape of
    `breaks` (..., k).
    """
    shape = breaks.shape[:-1]
    parts = contact.parts if isinstance(contact, ContactSum) else (contact,)
    found = [_of_one(part, breaks, depth) for part in parts]
    whole = LineLoads(*(np.concatenate(arrays, axis=-1) for arrays in zip(*found, strict=True)))
    size = np.abs(whole.normal).sum(axis=-1) + np.abs(whole.tangential).sum(axis=-1)
    for sums, force in ((whole.normal, contact.normal_force), (whole.tangential, contact.tangential_force)):
        miss = np.abs(sums.sum(axis=-1) - np.broadcast_to(force, shape))
        if not (miss <= _FORCE_ERROR * size).all():
            raise ConvergenceError(
                f"a {type(contact).__name__} whose force comes out wrong by {float(miss.max()):.2g} N/m",
                "its traction has to be smooth between its edges and its singular points",
                "a sum of contacts that are",
            )
    return whole


def _of_one(contact: Contact, breaks: FloatArray, depth: float) -> LineLoads:
    shape = breaks.shape[:-1]
    if isinstance(contact, LineLoad):
        forces = (contact.position, contact.normal_force, contact.tangential_force)
        return LineLoads(*(np.broadcast_to(np.asarray(v), shape)[..., None] for v in forces))
    low, high = (np.broadcast_to(end, shape)[..., None] for end in contact.support)
    wide = high - low
    count = max(int(np.ceil(wide.max(initial=0.0) / depth)), 2)
    ends = [breaks, low + depth * np.arange(1, count), *_corners(contact, shape, depth)]
    edges = np.sort(np.clip(np.concatenate(ends, axis=-1), low, high), axis=-1)
    length = np.diff(edges)[..., None]
    if isinstance(contact, PressureProfile):  # straight lines
        share, part = _FEW if (length <= _SHORT * depth).all() else _PLAIN
    else:
        last = length <= _NEAR[-1] * depth * (1 + 1e-9)
        share, part = (np.where(last, graded, plain) for graded, plain in zip(_GRADED, _PLAIN, strict=True))
    y = (edges[..., :-1, None] + length * share).reshape(*shape, -1)
    weight = (length * part).reshape(*shape, -1)
    wider = contact.expand(1)
    tractions = (wider.pressure(y), wider.shear(y))
    return LineLoads(y, *(np.where(weight > 0, weight, 0.0) * np.where(weight > 0, t, 0.0) for t in tractions))


def _corners(contact: Contact, shape: tuple[int, ...], depth: float) -> list[FloatArray]:
    """Positions within the contact where its traction is not smooth, and others close to them, each (..., k)."""
    if isinstance(contact, PressureProfile):
        return [np.broadcast_to(contact.breaks, (*shape, contact.breaks.shape[-1]))]
    around = depth * np.concatenate([-_NEAR, [0.0], _NEAR])
    return [np.broadcast_to(at, shape)[..., None] + around for at in np.moveaxis(contact.breaks, -1, 0)]
