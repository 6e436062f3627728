"""The half plane: a skin thick and flat compared with the contact and the sensors' depth (memo section 2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray, each_read_only, read_only
from ..contact.base import Contact
from ..contact.functions import Pair
from ..contact.local import LocalContact
from ..material import Material
from ..tensor import State, Strain, Stress, SurfaceGradient, Wave
from ._points import blank_singular, complex_points, not_local, points, wave_points
from .base import Materials, Skin
from .surface import distances

__all__ = ["HalfPlane"]

# Points of one block: its temporaries (some fifteen arrays) then stay in the second-level cache.
_BLOCK = 4096


@dataclass(frozen=True)
class HalfPlane(Skin):
    """An infinite elastic half plane, x >= 0 being the depth.

    The field of any traction is built from the contact's Cauchy transforms (docs/theory.md, which is
    Muskhelishvili's representation; the memo's eqs. 4, 7 and 8 are its line load at nu = 1/2).

    Parameters
    ----------
    material : Material
        Young's modulus and Poisson's ratio.
    plane : {"strain", "stress"}, optional
        Long contacts (no strain along z, the memo's choice) or a thin slice (no stress along z).

    Raises
    ------
    InvalidValueError
        Where `plane` is neither.

    Examples
    --------
    A knife edge on rubber, 2 mm beneath: memo eq. (8).

    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.5))
    >>> strain = skin.strain(ss.LineLoad(force=40.0), x=2e-3, y=0.0)
    >>> round(float(strain.xx), 6)
    -0.023873
    """

    material: Material
    plane: Literal["strain", "stress"] = "strain"

    @property
    def materials(self) -> tuple[Material, ...]:  # noqa: D102
        return (self.material,)

    def with_(  # noqa: D102
        self, *, materials: Materials = None, thickness: float | None = None, radius: float | None = None
    ) -> Self:
        super().with_(thickness=thickness, radius=radius)
        return replace(self, material=self._one_each(materials)[0])

    def __str__(self) -> str:
        return f"a half plane ({self.material})" + (", plane stress" if self.plane == "stress" else "")

    def at(  # noqa: D102
        self, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None = None
    ) -> Callable[[Contact | LocalContact], State]:
        xs, ys = points(x, y, z=z)
        z, surface = complex_points(xs, ys), not (xs > 0).all()

        def state(contact: Contact | LocalContact) -> State:
            if isinstance(contact, LocalContact):
                raise not_local(contact, self)
            try:
                fields = _in_blocks(contact, z, surface)
            except ValueError:
                _check.broadcast(contact=np.empty(contact.shape), points=xs)  # says which shapes do not
                raise
            return _PlaneState(self, *fields)

        return state

    def wave(self, k: npt.ArrayLike, x: npt.ArrayLike) -> Wave:
        """Amplitudes under a wave of traction, shape (m, d, 2), as `Skin.wave`.

        The Cauchy transform of cos(k t) at z = y + i x is i pi exp(i k z): docs/theory.md, kappa and the surface
        gradient.
        """
        waves, depths = wave_points(k, x)
        kx = (waves[:, None] * depths)[..., None]
        fall = np.exp(-kx)
        mean, half = fall * np.array([-1.0, 1.0]), fall * np.concatenate([kx, 1 - kx], axis=-1)
        fields = mean, half, fall * np.concatenate([-kx, kx - 1], axis=-1)
        straight, across = self._softness
        deep = kx / (2 * self.material.shear)
        with np.errstate(divide="ignore", invalid="ignore"):  # no end to the displacement of waves without end
            share = fall / waves[:, None, None]
            ux = share * np.concatenate([straight + deep, -across - deep], axis=-1)
            uy = share * np.concatenate([deep - across, straight - deep], axis=-1)
        state = _PlaneState(self, *fields)
        return Wave(state.stress, state.strain, ux, uy)

    def surface_gradient(self, contact: Contact, y: npt.ArrayLike) -> SurfaceGradient:
        """Displacement gradient along the surface x = 0: du_x/dy and du_y/dy [-] at y [m].

        From 2 G d/dy(u_y + i u_x) = (kappa F - conj(F))/2 + conj(T), F = T + i N (docs/theory.md). Displacements
        themselves are known only up to a constant in a half plane; their gradient is not. Warns as `state` does.

        Examples
        --------
        Beneath a rigid flat punch the surface stays flat.

        >>> import subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
        >>> punch = ss.FlatPunch(force=40.0, half_width=1e-3)
        >>> bool(abs(skin.surface_gradient(punch, y=0.3e-3).ux) < 1e-15)
        True
        """
        _check.noun("contact", contact, Contact, "LineLoad(force=40.0)")
        ys = _check.real("y", y, unit="m")
        zeros = np.zeros_like(ys)
        with np.errstate(divide="ignore", invalid="ignore"):  # blanked, and warned of, below
            t = contact.transforms(complex_points(zeros, ys))
            big_t = t.q / np.pi
            big_f = big_t + 1j * t.p / np.pi
            nu = self.material.poisson
            kappa = 3 - 4 * nu if self.plane == "strain" else (3 - nu) / (1 + nu)
            gradient = (0.5 * (kappa * big_f - np.conj(big_f)) + np.conj(big_t)) / (2 * self.material.shear)
        uy, ux = (np.array(part, dtype=np.float64) for part in (gradient.real, gradient.imag))
        blank_singular(contact, zeros, ys, ux, uy)
        return SurfaceGradient(*each_read_only(ux, uy))

    def surface_influence(self, step: float, count: int) -> FloatArray:
        """Displacement of the surface [m/Pa] about a unit hat, shape (2, 2, count), as `Skin.surface_influence`.

        u_x of a pressure and u_y of a drag are those relative to a line load's at a distance of 1 m. A hat is the
        second difference of y |y| / 2 over the step, so u is that of the twice integrated kernel: y^2 log|y| / 2 -
        3 y^2 / 4 for log|y| (Johnson, Contact Mechanics (1985), section 2.6).
        """
        h, count = distances(step, count)
        straight, across = self._softness
        log = (-straight / np.pi * h) * (np.log(h) + _hat_logarithm(count))
        half = np.full(count, 0.5 * across * h)
        half[:1] = 0.0
        return read_only(np.array([[log, half], [-half, log]]))

    @property
    def _softness(self) -> tuple[float, float]:
        """K C[0, 0] = 2 / E* and -k C[0, 1] = (kappa - 1) / (4 G) [1/Pa]; the latter is 0 at nu = 1/2."""
        e, nu = self.material.young, self.material.poisson
        if self.plane == "strain":
            return 2 * (1 - nu**2) / e, (1 + nu) * (1 - 2 * nu) / e
        return 2 / e, (1 - nu) / e


class _PlaneState(State):
    """From the mean and half the difference of sigma_y and sigma_x, and tau_xy; what is not asked for is not made."""

    def __init__(self, skin: HalfPlane, mean: FloatArray, half: FloatArray, xy: FloatArray) -> None:
        self.__dict__.update(_skin=skin, _fields=(mean, half, xy))

    def __reduce__(self) -> tuple[Any, ...]:
        """It travels as what it has to say."""
        return State, (self.stress, self.strain)

    @cached_property
    def stress(self) -> Stress:
        skin, (mean, half, xy) = self.__dict__["_skin"], self.__dict__["_fields"]
        zz = 2 * skin.material.poisson * mean if skin.plane == "strain" else np.zeros(mean.shape)
        return Stress(mean - half, mean + half, zz, xy)

    @cached_property
    def strain(self) -> Strain:
        """Hooke's law (memo eq. 6).

        At nu = 1/2 the difference of the stresses alone strains the skin. Near the surface it is a small part of
        either, and would be lost in them.
        """
        skin, (mean, half, xy) = self.__dict__["_skin"], self.__dict__["_fields"]
        e, nu = skin.material.young, skin.material.poisson
        return Strain(*plane_strains(np, mean, half, xy, e, nu, skin.plane == "strain"))


def plane_stresses(
    xp: Any, x: Any, p: Pair, dp: Pair, q: Pair, dq: Pair, hq: Any, surface: bool = True
) -> tuple[Any, Any, Any]:
    """(sigma_y + sigma_x)/2, (sigma_y - sigma_x)/2 and tau_xy of a half plane from the transforms (docs/theory.md)."""
    if surface:  # there F' grows more slowly than 1/x
        dp, dq = ((xp.where(x == 0, 0.0, d[0]), xp.where(x == 0, 0.0, d[1])) for d in (dp, dq))
    return (q[0] - p[1]) / np.pi, (q[0] - x * dq[1] - x * dp[0]) / np.pi, (x * dp[1] - hq) / np.pi


def plane_strains(xp: Any, mean: Any, half: Any, xy: Any, e: Any, nu: Any, long: bool) -> tuple[Any, Any, Any, Any]:
    """eps_x, eps_y, eps_z and eps_xy of these by Hooke's law, of a `long` contact or a thin slice."""
    turned = (1 + nu) / e * half
    if long:
        widened, zz = (1 + nu) * (1 - 2 * nu) / e * mean, xp.zeros_like(mean)
    else:
        widened, zz = (1 - nu) / e * mean, -2 * nu / e * mean
    return widened - turned, widened + turned, zz, (1 + nu) / e * xy


def _hat_logarithm(count: int) -> FloatArray:
    """The integral of (1 - |t|) log|j - t| over |t| < 1, for j = 0 ... count - 1.

    It is half the second difference of j^2 log j, less 3/2: a difference that loses ever more digits. So the logarithms
    of (j + 1) / j and (j - 1) / j are taken apart, and from j = 8 on the Taylor series of the second difference.
    """
    j = np.arange(count, dtype=np.float64)
    out = np.log(np.maximum(j, 1.0))
    n = j[2:8]
    out[2:8] += 0.5 * ((n + 1) ** 2 * np.log1p(1 / n) + (n - 1) ** 2 * np.log1p(-1 / n)) - 1.5
    out[:2] = np.array([-1.5, 2 * np.log(2) - 1.5])[:count]
    inverse = 1 / j[8:] ** 2
    tail = np.zeros_like(inverse)
    for m in range(20, 2, -2):
        tail = (tail + 2 / (m * (m - 1) * (m - 2))) * inverse
    out[8:] -= tail
    return out


def _in_blocks(contact: Contact, z: ComplexArray, surface: bool) -> tuple[FloatArray, ...]:
    """`_fields` over all points; a single contact's over blocks of them."""
    if z.size <= _BLOCK or contact.shape:
        return _fields(contact, z, surface)
    flat = z.reshape(-1)
    out = tuple(np.empty(z.size) for _ in range(3))
    for start in range(0, z.size, _BLOCK):
        block = slice(start, start + _BLOCK)
        for target, values in zip(out, _fields(contact, flat[block], surface), strict=True):
            target[block] = values
    return tuple(a.reshape(z.shape) for a in out)


def _fields(contact: Contact, z: ComplexArray, surface: bool) -> tuple[FloatArray, ...]:
    """`plane_stresses` of a contact; infinite ones are left out."""
    x = z.imag
    with np.errstate(divide="ignore", invalid="ignore"):  # singular points are blanked, and warned of, below
        p, dp, q, dq, hq = contact.transforms(z)
        pairs = [(part.real, part.imag) for part in (p, dp, q, dq)]
        fields = plane_stresses(np, x, pairs[0], pairs[1], pairs[2], pairs[3], hq, surface)
        mean, half, xy = (np.asarray(part) for part in fields)
    if surface:
        blank_singular(contact, x, z.real, mean, half, xy)
    return mean, half, xy
