"""The flat round punch (Boussinesq 1885)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._check import ComplexArray, FloatArray
from .discs import disc_form, punch_disc
from .kernels import RealForm
from .round_contact import RoundContact
from .shifted import axial_family, punch_core, source_at

__all__ = ["RoundPunch"]

_FORM = disc_form(punch_disc)


@dataclass(frozen=True, eq=False, init=False)
class RoundPunch(RoundContact, name="round_punch"):
    """A rigid flat disc on the skin: pressure N / (2 pi a sqrt(a^2 - r^2)).

    Source: docs/local_contacts.md; Johnson, Contact Mechanics (1985), section 3.4. Parameters as in `RoundContact`. A
    moment drags as the derivative of the shape does, as with all contacts; a disc that sticks and is turned is a
    `RoundHertz` with `moment=`.

    Examples
    --------
    >>> stylus = RoundPunch(force=1.0, half_width=1e-3)
    >>> float(stylus.pressure(0.0, 0.0).round(3)), float(stylus.pressure(1e-3, 0.0))
    (159154.943, inf)
    """

    def real_form(self) -> RealForm | None:  # noqa: D102
        return _FORM(self.half_width)

    def disc_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray:  # noqa: D102
        r = np.abs(zeta)
        source = source_at(x, r, 1.0)
        return axial_family(order, zeta, r, lambda n, m: source.member(n + 1, m).imag)

    def unit_core(self, x: FloatArray, zeta: ComplexArray, w: ComplexArray, dw: ComplexArray) -> ComplexArray:  # noqa: D102
        a = self.half_width
        return np.asarray(punch_core(np.asarray(x / a), np.abs(zeta) / a, 1.0) / a**2, dtype=np.complex128)

    def disc_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        return np.sinc(k / np.pi)

    def disc_pressure(self, r: FloatArray) -> FloatArray:  # noqa: D102
        with np.errstate(divide="ignore"):
            return np.where(r <= 1, 1 / (2 * np.pi * np.sqrt(np.maximum((1 - r) * (1 + r), 0.0))), 0.0)

    def disc_slope(self, r: FloatArray) -> FloatArray:  # noqa: D102
        with np.errstate(divide="ignore"):
            return np.where(r <= 1, r / (2 * np.pi * np.maximum((1 - r) * (1 + r), 0.0) ** 1.5), 0.0)

    def singular(self, y: FloatArray, z: FloatArray) -> npt.NDArray[np.bool_]:
        """As `LocalContact.singular`: the rim: the stress grows like 1/sqrt(distance)."""
        return np.asarray(np.abs(self._zeta(y, z)) == self.half_width)
