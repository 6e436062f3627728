"""The uniform strip: the same pressure all over the contact, as under an inflated membrane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._check import ComplexArray, FloatArray
from .functions import gap, log_ratio
from .spread import SpreadContact

__all__ = ["Strip"]


@dataclass(frozen=True, eq=False)
class Strip(SpreadContact, name="strip"):
    """Uniform pressure and shear over |y - position| <= half_width, F(z) = log((z - a) / (z + a)) / (2 a).

    Source: docs/theory.md; Johnson, Contact Mechanics (1985), section 2.5. For a pressure
    that varies along the contact see `PressureProfile`. Parameters as in `SpreadContact`.

    Examples
    --------
    >>> strip = Strip(force=40.0, half_width=1e-3)
    >>> strip.pressure([0.0, 0.5e-3, 2e-3]).round(6).tolist()
    [20000.0, 20000.0, 0.0]
    """

    SERIES = (1.0, 1 / 3, 1 / 5, 1 / 7, 1 / 9)

    def unit_transform(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:  # noqa: D102
        a = self._a
        x, y = z.imag, z.real
        return log_ratio(x, y + a, y - a, y, a) / (2 * a), 1 / gap(x, y + a, y - a, y)

    def unit_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        return np.asarray(np.sinc(k * self._a / np.pi))

    def unit_pressure(self, y: FloatArray) -> FloatArray:  # noqa: D102
        return np.where(np.abs(y) <= self._a, 1 / (2 * self._a), 0.0)

    def singular_points(self) -> tuple[FloatArray, ...]:
        """Both ends: the pressure jumps there, and under drag sigma_y grows like a logarithm."""
        return self.support
