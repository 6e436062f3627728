"""The flat punch: a rigid bar with sharp edges, pressed straight or tilted (memo eq. 14, Fig. 7c)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from .._declared import Real
from .base import Spectrum, Transforms
from .functions import jinc, root
from .proportional import scaled
from .spread import SpreadContact

__all__ = ["FlatPunch"]


@dataclass(frozen=True, eq=False)
class FlatPunch(SpreadContact, name="punch"):
    """A rigid flat punch: pressure (N + 2 M y / a^2) / (pi sqrt(a^2 - y^2)), y from its centre.

    F(z) = -1/s for a unit force, -2/(s (z + s)) for a unit moment, s = sqrt(z^2 - a^2). Source: memo eq.
    (14); docs/theory.md; Johnson, Contact Mechanics (1985), section
    2.8. The shear has the shape of the force's part alone: a moment tilts, it does not drag. Other
    parameters and errors as in `SpreadContact`.

    Parameters
    ----------
    moment : array_like, optional
        Moment M of the pressure about the centre [N m/m], positive where it presses harder towards +y. By keyword.

    Warns
    -----
    ValidityWarning
        |moment| > |N| half_width / 2: one edge would have to pull on the skin, where a real punch lifts.

    Examples
    --------
    >>> punch = FlatPunch(force=40.0, half_width=1e-3, moment=0.01)
    >>> punch.pressure([-0.5e-3, 0.0, 0.5e-3]).round(1).tolist()
    [11026.6, 12732.4, 18377.6]
    """

    moment: Annotated[npt.ArrayLike, Real("N m/m")] = 0.0

    GROWTH = 0.0
    SERIES = (1.0, 1 / 2, 3 / 8, 5 / 16, 35 / 128)

    def __post_init__(self) -> None:
        super().__post_init__()
        most = np.abs(self.normal_force) * self._a / 2
        if (np.abs(self._m) > most * (1 + 1e-12)).any():
            message = (
                "|moment| > normal force * half_width / 2: one edge of the punch pulls on the skin; a punch "
                "that does not stick lifts there, and its contact is narrower than given"
            )
            _check.warn(message)

    @property
    def _m(self) -> FloatArray:
        return np.asarray(self.moment, dtype=np.float64)

    def unit_transform(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:  # noqa: D102
        s = root(z, self._a)
        return -1 / s, z / (s * s * s)

    def transforms(self, z: ComplexArray) -> Transforms:  # noqa: D102
        t = super().transforms(z)
        if not self._m.any():
            return t
        z = self._centred(z)
        s = root(z, self._a)
        return t._replace(p=t.p - 2 * self._m / (s * (z + s)), dp=t.dp + 2 * self._m / (s * s * s))

    def unit_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        from scipy.special import j0

        return np.asarray(j0(k * self._a))

    def spectrum(self, k: FloatArray) -> Spectrum:  # noqa: D102
        s = super().spectrum(k)
        if not self._m.any():
            return s
        return s._replace(p=s.p - 1j * k * self._m * jinc(k * self._a) * self._shifted(k))

    def unit_pressure(self, y: FloatArray) -> FloatArray:  # noqa: D102
        a = self._a
        under = np.sqrt(np.maximum((a - y) * (a + y), 0.0))
        with np.errstate(divide="ignore"):
            return np.where(np.abs(y) <= a, 1 / (np.pi * under), 0.0)

    def pressure(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        centred = self._from_centre(y)
        return scaled(self.normal_force + 2 * self._m * centred / self._a**2, self.unit_pressure(centred))

    def singular_points(self) -> tuple[FloatArray, ...]:
        """Both edges: the stress grows like 1/sqrt(distance)."""
        return self.support
