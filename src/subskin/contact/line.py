"""The line load: a knife edge across the skin (memo eqs. 1 to 4)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .._check import ComplexArray, FloatArray
from .base import Contact, ContactSum, Transforms
from .spread import ProportionalContact

__all__ = ["LineLoad"]

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

    def unit_transform(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:  # noqa: D102
        r = 1 / z
        return -r, r * r

    def unit_shear_field(self, z: ComplexArray, f: ComplexArray, df: ComplexArray) -> FloatArray:  # noqa: D102
        return np.asarray(2 * z.imag * (z.real * (f.real**2 + f.imag**2)) ** 2, dtype=np.float64)

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
