"""Round bodies on the skin: Hertz's sphere, the flat punch (Boussinesq), the cone (Love 1939, Sneddon 1948)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import numpy.typing as npt

from .._check import ComplexArray, FloatArray
from .._declared import Real
from ..errors import InvalidValueError
from .functions import hertz_spectrum
from .kernels import RealForm, cone_disc, disc_form, hertz_disc, punch_disc
from .local import LocalSpectrum, RadialTerm
from .round_contact import RoundContact
from .shifted import axial_family, punch_core, punches_core, punches_over, source_at

__all__ = ["Cone", "RoundHertz", "RoundPunch"]


@dataclass(frozen=True, eq=False, init=False)
class RoundHertz(RoundContact, name="round_hertz"):
    """A sphere on the skin: pressure 3 N / (2 pi a^2) sqrt(1 - r^2 / a^2) (Hertz 1881).

    Without `stick` the drag is proportional to the pressure: the contact slides. With it, it sticks for r < c and slips
    beyond, f = (f_a - (c/a)^3 f_c) / (1 - (c/a)^3), f_r being Hertz's shape of radius r: |T| = mu N (1 - (c/a)^3)
    (Cattaneo 1938, Mindlin 1949; exact at nu = 1/2). A moment is that of a disc that sticks and is turned (Reissner and
    Sagoci 1944). Source: docs/local_contacts.md; Johnson, Contact Mechanics (1985), sections 3.4, 3.9 and 7.2. Other
    parameters as in `RoundContact`.

    Parameters
    ----------
    stick : array_like, optional
        Radius c of the zone that sticks [m], from 0 (it slides) to `half_width` (nothing slips).

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range, a zone that is wider than the contact; shapes that do not broadcast.

    Examples
    --------
    >>> tip = RoundHertz(force=1.5, angle=0.3, azimuth=0.8, position=(1e-3, -2e-3), half_width=0.6e-3)
    >>> round(float(tip.pressure(1e-3, -2e-3)))
    1900582
    >>> held = RoundHertz(components=(1.0, 0.3, 0.0), half_width=1e-3, stick=0.5e-3)
    >>> held.shear(0.0, 0.0).round(-1).tolist()
    [81850.0, 0.0]
    """

    stick: Annotated[FloatArray, Real("m", at_least=0.0)] = field(default=0.0, kw_only=True)  # type: ignore[arg-type]

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.stick > self.half_width).any():
            seen = f"stick = {float(self.stick.max()):.6g} m, half_width = {float(self.half_width.min()):.6g} m"
            raise InvalidValueError(seen, "the zone that sticks lies within the contact", "stick <= half_width")

    @property
    def _share(self) -> FloatArray:
        """The ratio c / a."""
        return np.asarray(self.stick / self.half_width)

    FORM = staticmethod(disc_form(hertz_disc, power=2))

    def real_form(self) -> RealForm | None:  # noqa: D102
        return None if self.stick.any() else self.FORM(self.half_width)

    def disc_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray:  # noqa: D102
        return ring_family(order, x, zeta, np.zeros(()))

    def drag_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray | None:  # noqa: D102
        if not self.stick.any():
            return None
        a = self.half_width
        return np.asarray(ring_family(order, np.asarray(x / a), zeta / a, self._share) / a ** (2 + order))

    def unit_core(self, x: FloatArray, zeta: ComplexArray, w: ComplexArray, dw: ComplexArray) -> ComplexArray:  # noqa: D102
        core = super().unit_core(x, zeta, w, dw)
        a = self.half_width
        _, far, depth, r, low = _split(np.asarray(x / a), zeta / a, self._share)
        if far.any():
            size = np.broadcast_to(a, far.shape)[far]
            core[far] = punches_core(depth[far], np.abs(r[far]), low[far], 2) / size**2
        return core

    def disc_spectrum(self, k: FloatArray) -> FloatArray:  # noqa: D102
        return hertz_spectrum(k)

    def unit_drag_spectrum(self, k: FloatArray) -> FloatArray:
        """Hankel transform of the drag of unit resultant at `k` [1/m]; 1 at 0."""
        outer, c = k * self.half_width, self._share
        thin = np.asarray(c > 0.99)  # then as the mean of punches: nothing cancels
        cube = np.where(thin, 0.0, c**3)
        closed = (hertz_spectrum(outer) - cube * hertz_spectrum(c * outer)) / (1 - cube)
        if not thin.any():
            return np.asarray(closed)
        t, w = np.polynomial.legendre.leggauss(40)
        at = 0.5 * (1 + c[..., None]) + 0.5 * (1 - c[..., None]) * t
        share = w * at**2
        mean = (share * np.sinc(outer[..., None] * at / np.pi)).sum(axis=-1) / share.sum(axis=-1)
        return np.asarray(np.where(thin, mean, closed))

    def spectrum(self, ky: FloatArray, kz: FloatArray) -> LocalSpectrum:  # noqa: D102
        p, qy, qz = super().spectrum(ky, kz)
        if not self.stick.any():
            return LocalSpectrum(p, qy, qz)
        centre, load, k = self.position, self.components, np.hypot(ky, kz)
        shift = np.exp(-1j * (ky * centre[..., 0] + kz * centre[..., 1]))
        more = (self.unit_drag_spectrum(k) - self.unit_radial_spectrum(k)) * shift
        return LocalSpectrum(p, qy + load[..., 1] * more, qz + load[..., 2] * more)

    @property
    def radial_terms(self) -> tuple[RadialTerm, ...]:  # noqa: D102
        if not self.stick.any():
            return super().radial_terms
        press, drag = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 1.0])
        return (
            RadialTerm(self.components * press, self.moment, self.position, self.unit_radial_spectrum),
            RadialTerm(self.components * drag, 0 * self.moment, self.position, self.unit_drag_spectrum),
        )

    def disc_pressure(self, r: FloatArray) -> FloatArray:  # noqa: D102
        return np.asarray(1.5 / np.pi * np.sqrt(np.maximum((1 - r) * (1 + r), 0.0)))

    def disc_slope(self, r: FloatArray) -> FloatArray:  # noqa: D102
        with np.errstate(divide="ignore"):
            return np.where(r <= 1, -1.5 / np.pi * r / np.sqrt(np.maximum((1 - r) * (1 + r), 0.0)), 0.0)

    def unit_drag(self, y: FloatArray, z: FloatArray) -> FloatArray:  # noqa: D102
        r, c = np.hypot(y, z) / self.half_width, self._share
        outer = np.sqrt(np.maximum((1 - r) * (1 + r), 0.0))
        inner = np.sqrt(np.maximum((c - r) * (c + r), 0.0))
        # (outer - inner) / (1 - c^3), the factor 1 - c divided out where it sticks
        rest = 1 + c + c * c
        with np.errstate(divide="ignore", invalid="ignore"):
            slips = outer / ((1 - c) * rest)
            sticks = (1 + c) / (rest * (outer + inner))
        shape = np.where(r >= 1, np.where((c == 1) & (r == 1), np.inf, 0.0), np.where(r < c, sticks, slips))
        return np.asarray(1.5 / np.pi * shape / self.half_width**2)

    def singular(self, y: FloatArray, z: FloatArray) -> npt.NDArray[np.bool_]:
        """As `LocalContact.singular`: the rim, where a disc is turned or nothing slips: the drag is infinite there."""
        infinite = (self.moment != 0) | ((self.stick == self.half_width) & self.tangential_force.any(axis=-1))
        return np.asarray(infinite & (np.abs(self._zeta(y, z)) == self.half_width))


def _split(
    x: FloatArray, zeta: ComplexArray, low: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, ComplexArray, FloatArray]:
    """Points near a ring from `low` to 1 and points beyond, as masks; and all of them of one shape."""
    x, zeta, low = np.broadcast_arrays(x, zeta, low)
    r = np.abs(zeta)
    away = np.hypot(x, np.maximum(np.maximum(r - 1, low - r), 0.0))
    far = away > np.where(low > 0, 1 - low, 1.0)
    return ~far, far, x, zeta, low


def ring_family(order: int, x: FloatArray, zeta: ComplexArray, low: FloatArray) -> ComplexArray:
    """The family of (f_1 - c^3 f_c) / (1 - c^3), c = `low`, f_t being Hertz's shape of radius t.

    It is the sum of all punches from c to 1, weighed as t^2: so it is added up at points beyond, where the closed form
    cancels.
    """
    near, far, x, zeta, low = _split(x, zeta, low)
    out = np.empty((3 if order == -1 else 4, *near.shape), dtype=np.complex128)
    if near.any():
        at, away, c = x[near], zeta[near], low[near]
        whole = _hertz_family(order, at, away, np.ones_like(c))
        if low.any():
            c3 = c**3
            whole = (whole - c3 * _hertz_family(order, at, away, c)) / (1 - c3)
        out[:, near] = whole
    if far.any():
        out[:, far] = punches_over(order, x[far], zeta[far], low[far], 2)
    return out


def _hertz_family(order: int, x: FloatArray, zeta: ComplexArray, a: FloatArray) -> ComplexArray:
    """The closed form for the radius a."""
    a = np.where(a > 0, a, 1.0)  # of no radius: it is taken times 0
    x, zeta = x / a, zeta / a
    r = np.abs(zeta)
    source = source_at(x, r, 1.0)
    family = axial_family(
        order, zeta, r, lambda n, m: 3 * (source.member(n + 3, m).imag - source.member(n + 2, m).real)
    )
    return np.asarray(family / a ** (2 + order))


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

    FORM = staticmethod(disc_form(punch_disc))

    def real_form(self) -> RealForm | None:  # noqa: D102
        return self.FORM(self.half_width)

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

    FORM = staticmethod(disc_form(cone_disc, power=1))

    def real_form(self) -> RealForm | None:  # noqa: D102
        return self.FORM(self.half_width)

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
