"""The elliptical Hertz contact: bodies of two curvatures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt

from .._check import ComplexArray, FloatArray
from .._declared import Real
from .from_projections import at_the_surface, mean_over_directions
from .functions import hertz_spectrum
from .kernels import point_core, point_family
from .patch import HALF_WIDTHS
from .shaped import ShapedContact

__all__ = ["EllipticHertz"]

_FAR = 4.0
_S, _W = np.polynomial.legendre.leggauss(10)
_AROUND = 24


@dataclass(frozen=True, eq=False, init=False)
class EllipticHertz(ShapedContact, name="elliptic_hertz"):
    """An ellipsoid on the skin: pressure 3 N / (2 pi a b) sqrt(1 - (y/a)^2 - (z/b)^2) (Hertz 1881).

    A moment drags as the derivative of the shape does. Source: docs/local_contacts.md; Johnson, Contact Mechanics
    (1985), section 4.2. Parameters force, angle, azimuth, position, components and moment as in `ShapedContact`.

    Parameters
    ----------
    half_widths : array_like, shape (..., 2)
        Half the axes of the ellipse, (a, b) along y and z before it is turned [m], > 0; required.
    turn : array_like, optional
        Angle by which the ellipse is turned, from +y towards +z [rad].

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; shapes that do not broadcast.

    Examples
    --------
    >>> bar = EllipticHertz(force=1.0, half_widths=(2e-3, 0.5e-3), turn=0.5)
    >>> round(float(bar.pressure(0.0, 0.0)))
    477465
    """

    RANKS: ClassVar[dict[str, int]] = {"components": 1, "position": 1, "half_widths": 1}

    half_widths: Annotated[FloatArray, HALF_WIDTHS] = (np.nan, np.nan)  # type: ignore[assignment]
    turn: Annotated[FloatArray, Real("rad")] = 0.0  # type: ignore[assignment]

    def unit_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray:  # noqa: D102
        along, size = np.exp(1j * self.turn), self.half_widths.max(axis=-1)
        arrays = (x / size, zeta * np.conj(along) / size, *np.moveaxis(self.half_widths / size[..., None], -1, 0))
        x, zeta, a, b = np.broadcast_arrays(*arrays)
        far = x * x + np.abs(zeta) ** 2 > _FAR**2
        out = np.empty((3 if order == -1 else 4, *x.shape), dtype=np.complex128)
        for chosen, family in ((far, _far_family), (~far, _near_family)):
            if chosen.any():
                out[:, chosen] = family(order, *(v[chosen] for v in (x, zeta, a, b)))
        m = np.arange(len(out)).reshape(-1, *(1,) * x.ndim)
        return np.asarray(out * along**m / size ** (2 + order))

    def unit_core(self, x: FloatArray, zeta: ComplexArray, w: ComplexArray, dw: ComplexArray) -> ComplexArray:  # noqa: D102
        core = super().unit_core(x, zeta, w, dw)
        size = self.half_widths.max(axis=-1)
        arrays = (x / size, zeta * np.exp(-1j * self.turn) / size, *np.moveaxis(self.half_widths, -1, 0) / size, size)
        x, zeta, a, b, size = (np.broadcast_to(v, core.shape) for v in arrays)
        far = x * x + np.abs(zeta) ** 2 > _FAR**2
        if far.any():
            x, zeta, a, b, size = (v[far] for v in (x, zeta, a, b, size))
            core[far] = sum(share * point_core(x, zeta - at) for at, share in _nodes(a, b)) / size**2
        return core

    def unit_spectrum(self, ky: FloatArray, kz: FloatArray) -> FloatArray:  # noqa: D102
        c, s = np.cos(self.turn), np.sin(self.turn)
        along, across = self.half_widths[..., 0] * (c * ky + s * kz), self.half_widths[..., 1] * (c * kz - s * ky)
        return hertz_spectrum(np.hypot(along, across))

    def _turned(self, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Along both axes in units of the half widths, and what is under the root."""
        c, s = np.cos(self.turn), np.sin(self.turn)
        along, across = (c * y + s * z) / self.half_widths[..., 0], (c * z - s * y) / self.half_widths[..., 1]
        r = np.hypot(along, across)
        return along, across, (1 - r) * (1 + r)

    def unit_pressure(self, y: FloatArray, z: FloatArray) -> FloatArray:  # noqa: D102
        under = self._turned(y, z)[2]
        return np.asarray(1.5 / np.pi * np.sqrt(np.maximum(under, 0.0)) / self.half_widths.prod(axis=-1))

    def unit_slope(self, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        along, across, under = self._turned(y, z)
        a, b = self.half_widths[..., 0], self.half_widths[..., 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(under >= 0, -1.5 / np.pi / (a * b * np.sqrt(np.maximum(under, 0.0))), 0.0)
        c, s = np.cos(self.turn), np.sin(self.turn)
        by_along, by_across = share * along / a, share * across / b
        return c * by_along - s * by_across, s * by_along + c * by_across

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        a, b = self.half_widths[..., 0], self.half_widths[..., 1]
        c, s = np.cos(self.turn), np.sin(self.turn)
        reach = np.stack([np.hypot(a * c, b * s), np.hypot(a * s, b * c)], axis=-1)
        return self.position - reach, self.position + reach

    def singular(self, y: FloatArray, z: FloatArray) -> npt.NDArray[np.bool_]:
        """As `LocalContact.singular`: the rim, where it is turned: the drag is infinite there."""
        away = self._zeta(y, z)
        return np.asarray((self.moment != 0) & (self._turned(away.real, away.imag)[2] == 0))


def _near_family(order: int, x: FloatArray, zeta: ComplexArray, a: FloatArray, b: FloatArray) -> ComplexArray:
    """The mean of the plane fields of the ellipse's projections: parabolas of half width c(phi)."""

    def cauchy(phi: FloatArray, depth: ComplexArray, chosen: npt.NDArray[np.intp]) -> ComplexArray:
        """F, F' or F'' of the projection, times 1 / (4 pi^2)."""
        long, wide = a[chosen, None], b[chosen, None]
        c = np.hypot(long * np.cos(phi), wide * np.sin(phi))
        size = 0.75 / c  # (pi/2) p0 a b / c, p0 = 3 / (2 pi a b)
        ratio = c / depth
        near = np.abs(ratio) > 0.35
        with np.errstate(divide="ignore", invalid="ignore"):
            log = np.log(depth - c) - np.log(depth + c)
            square = np.where(near, 0.0, ratio) ** 2
            series = np.zeros_like(square)
            for k in range(18, -1, -1):  # of log + 2 c/Z = -2 (c/Z)^3 (1/3 + (c/Z)^2/5 + ...)
                series = series * square + 1 / (2 * k + 3)
            rest = -2 * np.where(near, 0.0, ratio) ** 3 * series
            if order == -1:
                closed = (1 - (depth / c) ** 2) * log - 2 * depth / c
                away = -2 * ratio - (depth / c) ** 2 * rest + rest
                return np.asarray(size * np.where(near, closed, away))
            if order == 0:
                closed = 2 * depth * log / c**2 + 4 / c
                return np.asarray(-size * np.where(near, closed, 2 * depth / c**2 * rest))
            closed = log + 2 * depth * c / (depth * depth - c * c)
            # 2 Z c / (Z^2 - c^2) - 2 c/Z = 2 (c/Z)^3 / (1 - (c/Z)^2)
            away = rest + 2 * np.where(near, 0.0, ratio) ** 3 / (1 - square)
            return np.asarray(-2 * size / c**2 * np.where(near, closed, away))

    out = mean_over_directions(order, x, zeta, cauchy, _tangents(x, zeta, a, b))
    outside = np.hypot(zeta.real / a, zeta.imag / b) - 1
    on = (x == 0) & (outside > 0)
    if order == 1 and on.any():
        at, long, wide = zeta[on], a[on], b[on]
        room = np.minimum(long, wide) * np.minimum(outside[on], 1.0)
        out[:, on] = at_the_surface(lambda depth: _near_family(order, depth, at, long, wide), room)
    return out


def _tangents(x: FloatArray, zeta: ComplexArray, a: FloatArray, b: FloatArray) -> ComplexArray:
    """Directions, complex, in which the field of the projections is singular, one each half turn, shape (n, 3).

    The point lies on the end of the projection there, Z^2 = c^2: with w = e^{i phi} of the fourth degree, its roots
    are pairs w, -1/w*, a half turn apart. Or the projection has no width, c = 0.
    """
    back, gap = np.conj(zeta), (a - b) * (a + b)
    lead, last = back**2 - gap, zeta**2 - gap
    tiny = 1e-12 * (a * a + b * b)
    lead = np.where(np.abs(lead) > tiny, lead, tiny)
    terms = [4j * x * back, 2 * np.abs(zeta) ** 2 - 4 * x * x - 2 * (a * a + b * b), 4j * x * zeta, last]
    companion = np.zeros((*x.shape, 4, 4), dtype=np.complex128)
    companion[..., 0, :] = -np.stack(terms, axis=-1) / lead[..., None]
    companion[..., [1, 2, 3], [0, 1, 2]] = 1.0
    roots = np.linalg.eigvals(companion)
    turns = -1j * np.log(np.where(roots == 0, 1e-300, roots))
    turns = np.take_along_axis(turns, np.argsort(np.mod(turns.real, np.pi), axis=1), axis=1)
    ahead = np.mod(turns.real, np.pi)
    twins = ahead[:, 1] - ahead[:, 0] + ahead[:, 3] - ahead[:, 2] < 0.5 * np.pi
    ends = np.where(twins[:, None], turns[:, [0, 2]], turns[:, [1, 3]])
    thin = np.minimum(a, b) / np.maximum(a, b)
    none = np.where(a > b, 0.5 * np.pi, 0.0) + 1j * np.arctanh(np.minimum(thin, 1 - 1e-15))
    return np.concatenate([ends, none[:, None]], axis=1)


def _far_family(order: int, x: FloatArray, zeta: ComplexArray, a: FloatArray, b: FloatArray) -> ComplexArray:
    """The sum over point loads."""
    total = np.zeros((), dtype=np.complex128)
    for at, share in _nodes(a, b):
        total = total + share * point_family(order, x, zeta - at)
    return np.asarray(total)


def _nodes(a: FloatArray, b: FloatArray) -> list[tuple[Any, float]]:
    """Points of the ellipse, and the share of the load on each."""
    rows: list[tuple[Any, float]] = []
    for node, weight in zip(_S, _W, strict=True):
        s = 0.5 * (1 + node)
        rho = np.sqrt((1 - s) * (1 + s))
        for turn in 2 * np.pi * (np.arange(_AROUND) + 0.5) / _AROUND:
            rows.append((np.asarray(rho * (a * np.cos(turn) + 1j * b * np.sin(turn))), 1.5 * s * s * weight / _AROUND))
    return rows
