"""The cone (Love 1939, Sneddon 1948)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._check import ComplexArray, FloatArray
from .discs import cone_disc, disc_form
from .kernels import RealForm
from .round_contact import RoundContact
from .shifted import axial_family, punches_core, punches_over, source_at

__all__ = ["Cone"]

_FORM = disc_form(cone_disc, power=1)

_FAR = 2.0


@dataclass(frozen=True, eq=False, init=False)
class Cone(RoundContact, name="cone"):
    """A blunt rigid cone on the skin: pressure N / (pi a^2) arccosh(a / r).

    Source: docs/local_contacts.md; Johnson, Contact Mechanics (1985), section 5.2. Parameters as in `RoundContact`; the
    tip is at `position`.

    Examples
    --------
    >>> tip = Cone(force=1.0, half_width=1e-3)
    >>> tip.pressure([0.5e-3, 1e-3], 0.0).round(1).tolist()
    [419200.7, 0.0]
    """

    def real_form(self) -> RealForm | None:  # noqa: D102
        return _FORM(self.half_width)

    def disc_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray:  # noqa: D102
        x, zeta = np.broadcast_arrays(x, zeta)
        r = np.abs(zeta)
        far = np.hypot(x, r) > _FAR
        out = np.empty((3 if order == -1 else 4, *x.shape), dtype=np.complex128)
        if not far.all():
            near = ~far
            tip, rim = (source_at(x[near], r[near], t) for t in (0.0, 1.0))
            out[:, near] = axial_family(
                order, zeta[near], r[near], lambda n, m: 2 * (tip.member(n + 2, m) - rim.member(n + 2, m)).real
            )
        if far.any():
            out[:, far] = punches_over(order, x[far], zeta[far], np.zeros(()), 1)
        return out

    def unit_core(self, x: FloatArray, zeta: ComplexArray, w: ComplexArray, dw: ComplexArray) -> ComplexArray:  # noqa: D102
        core = super().unit_core(x, zeta, w, dw)
        a = self.half_width
        depth, r = np.broadcast_arrays(x / a, np.abs(zeta) / a)
        far = np.hypot(depth, r) > _FAR
        if far.any():
            core[far] = punches_core(depth[far], r[far], np.zeros(()), 1) / np.broadcast_to(a, far.shape)[far] ** 2
        return core

    def disc_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        return np.sinc(0.5 * k / np.pi) ** 2

    def disc_pressure(self, r: FloatArray) -> FloatArray:  # noqa: D102
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.arcsinh(np.sqrt(np.maximum((1 - r) * (1 + r), 0.0)) / r) / np.pi)

    def disc_slope(self, r: FloatArray) -> FloatArray:  # noqa: D102
        with np.errstate(divide="ignore"):
            return np.where(r <= 1, -1 / (np.pi * r * np.sqrt(np.maximum((1 - r) * (1 + r), 0.0))), 0.0)

    def singular(self, y: FloatArray, z: FloatArray) -> npt.NDArray[np.bool_]:
        """As `LocalContact.singular`: the tip, for the pressure has no end there; and where it is turned, the rim."""
        r = np.abs(self._zeta(y, z))
        return np.asarray((r == 0) | ((self.moment != 0) & (r == self.half_width)))
