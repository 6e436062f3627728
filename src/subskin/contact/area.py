"""Families of a local contact from its traction alone, for contacts that have no closed form in a half space."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from .._check import ComplexArray, FloatArray
from .kernels import point_family, point_radial

__all__ = ["area_families"]

# Close to a contact in polar coordinates about the point: along each ray, and over the directions between those in
# which the outline is not smooth, a stretch is mapped to the whole line as in `quadrature`; here to about 1e-11.
_STEP = 0.36
_ALONG, _AROUND = _STEP * np.arange(-84, 85), _STEP * np.arange(-72, 73)
_BLOCK = 1 << 16

# Beyond this many half widths from the outline by Gauss's rule, in variables that take a root at the edges.
_FAR = 0.5
_T, _W = np.polynomial.legendre.leggauss(36)
_TURNS = 80


class Traction(Protocol):
    """What is asked of a `LocalContact`."""

    @property
    def OUTLINE(self) -> str: ...
    @property
    def shape(self) -> tuple[int, ...]: ...
    @property
    def support(self) -> tuple[FloatArray, FloatArray]: ...
    def pressure(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray: ...
    def shear(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray: ...


def area_families(
    contact: Traction, orders: tuple[int, ...], x: FloatArray, y: FloatArray, z: FloatArray
) -> list[ComplexArray]:
    """W_m, or a derivative along x, of pressure, q_y and q_z: for each order (3, 4, ...), of order -1 (3, 3, ...).

    To about 1e-10 of the largest traction; 1e-6 where that grows like a root at the outline. It has to be smooth within
    the outline of the contact (`LocalContact.OUTLINE`); a kink costs digits.

    Parameters
    ----------
    contact : Traction
        Its traction, `support` and outline are asked for.
    orders : tuple of int
        As in `ShapedContact.unit_family`.
    x, y, z : ndarray
        Points [m], of shapes that broadcast against the batch.
    """
    shape = np.broadcast_shapes(contact.shape, x.shape, y.shape, z.shape)
    x, y, z = (np.broadcast_to(a, shape) for a in (x, y, z))
    low, high = (np.broadcast_to(end, (*shape, 2)) for end in contact.support)
    half, middle = 0.5 * (high - low), 0.5 * (high + low)
    round_ = contact.OUTLINE == "ellipse"
    beyond = (
        np.maximum(np.abs(y - middle[..., 0]) - half[..., 0], 0.0),
        np.maximum(np.abs(z - middle[..., 1]) - half[..., 1], 0.0),
    )
    far = np.sqrt(x * x + beyond[0] ** 2 + beyond[1] ** 2) > _FAR * half.max(axis=-1)
    if far.all():
        return _far_families(contact, orders, x, y, z, half, middle, round_)
    near = _near_families(contact, orders, x, y, z, low, high, round_)
    if not far.any():
        return near
    away = _far_families(contact, orders, x, y, z, half, middle, round_)
    return [np.where(far, a, b) for a, b in zip(away, near, strict=True)]


def _far_families(
    contact: Traction,
    orders: tuple[int, ...],
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    half: FloatArray,
    middle: FloatArray,
    round_: bool,
) -> list[ComplexArray]:
    """By Gauss's points of the outline."""
    if round_:
        s, turn = 0.5 * (1 + _T), 2 * np.pi * (np.arange(_TURNS) + 0.5) / _TURNS
        rho = np.sqrt((1 - s) * (1 + s))[:, None]
        u, v = rho * np.cos(turn), rho * np.sin(turn)
        weight = np.broadcast_to((0.5 * _W * s)[:, None] * (2 * np.pi / _TURNS), u.shape)
    else:
        s, w = np.sin(0.5 * np.pi * _T), 0.5 * np.pi * _W * np.cos(0.5 * np.pi * _T)
        u, v = np.meshgrid(s, s, indexing="ij")
        weight = np.outer(w, w)
    out = [np.zeros((3, 3 if order == -1 else 4, *x.shape), dtype=np.complex128) for order in orders]
    nodes = [a.reshape(-1, *(1,) * x.ndim) for a in (u, v, weight)]
    step = max(1, _BLOCK // max(1, x.size))
    for first in range(0, u.size, step):
        u, v, weight = (a[first : first + step] for a in nodes)
        at_y, at_z = middle[..., 0] + half[..., 0] * u, middle[..., 1] + half[..., 1] * v
        values = _traction(contact, at_y, at_z) * (weight * half[..., 0] * half[..., 1])
        zeta = (y - at_y) + 1j * (z - at_z)
        for total, order in zip(out, orders, strict=True):
            family = point_family(order, x, zeta)
            for one, value in zip(total, values, strict=True):
                if value.any():
                    one += (value * family).sum(axis=1)
    return out


def _near_families(
    contact: Traction,
    orders: tuple[int, ...],
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    low: FloatArray,
    high: FloatArray,
    round_: bool,
) -> list[ComplexArray]:
    """In polar coordinates about each point."""
    shape = _Ellipse(y, z, low, high) if round_ else _Rectangle(y, z, low, high)
    ends = np.sort(np.mod(shape.turns(), 2 * np.pi), axis=0)
    ends = np.concatenate([ends, ends[:1] + 2 * np.pi])
    out = [np.zeros((3, 3 if order == -1 else 4, *x.shape), dtype=np.complex128) for order in orders]
    surface, own = x == 0, np.zeros((3, *x.shape))
    if surface.any() and 0 in orders:  # the principal value; and W_0 is the traction itself there
        own = np.where(surface & shape.inside, _traction(contact, y, z), 0.0)
        own = np.where(np.isfinite(own), own, 0.0)
    along, back, ahead = (a.reshape(-1, *(1,) * (x.ndim + 1)) for a in _mapped(_ALONG))
    sides, rest, weight = (a.reshape(-1, *(1,) * x.ndim) for a in _mapped(_AROUND))
    step = max(1, _BLOCK // (along.size * max(1, x.size)))
    for start, length in zip(ends[:-1], np.diff(ends, axis=0), strict=True):
        if not (length > 1e-14).any():
            continue
        for first in range(0, len(sides), step):
            part = slice(first, first + step)
            phi = np.where(sides[part] < 0.5, start + length * sides[part], start + length - length * rest[part])
            nearest, farthest = shape.ray(phi)
            stretch = np.maximum(farthest - nearest, 0.0)
            rho = np.where(along < 0.5, nearest + stretch * along, farthest - stretch * back)
            c, s = np.cos(phi), np.sin(phi)
            values = _traction(contact, y + rho * c, z + rho * s)
            size = ahead * rho * stretch
            whole = np.where(np.isfinite(values) & (stretch > 0), values, 0.0) * size
            less = np.where(np.isfinite(values) & (stretch > 0), values - own[:, None, None], 0.0) * size
            turned = length * weight[part]
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                log = np.log(np.where(surface & (farthest > 0), farthest, 1.0)) / (2 * np.pi)
                for total, order in zip(out, orders, strict=True):
                    loads = less if order == 0 else whole
                    for m, kernel in enumerate(point_radial(order, x, rho)):
                        e = turned * (c + 1j * s) ** m
                        kernel = np.where(np.isfinite(kernel), kernel, 0.0)
                        for i, load in enumerate(loads):
                            ray = np.einsum("a...,a...->...", load, kernel)
                            rim = own[i] * m * log if order == 0 else 0.0
                            total[i, m] += (e * (ray + rim)).sum(axis=0)
    for total, order in zip(out, orders, strict=True):
        if order == 0:
            total[:, 0] = np.where(surface, own, total[:, 0])
    return out


def _mapped(v: npt.NDArray[np.floating[Any]]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Shares of a stretch from its start and from its end, and their weights."""
    share, rest = np.asarray(1 / (1 + np.exp(-v))), np.asarray(1 / (1 + np.exp(v)))
    return share, rest, np.asarray(_STEP * share * rest)


def _traction(contact: Traction, y: FloatArray, z: FloatArray) -> FloatArray:
    """Pressure, q_y and q_z, shape (3, ...)."""
    shear = contact.shear(y, z)
    return np.stack([contact.pressure(y, z), shear[..., 0], shear[..., 1]])


class _Rectangle:
    """A rectangle seen from points of the surface."""

    def __init__(self, y: FloatArray, z: FloatArray, low: FloatArray, high: FloatArray) -> None:
        self.gaps = [(low[..., i] - a, high[..., i] - a) for i, a in enumerate((y, z))]
        self.inside = np.all([(first <= 0) & (last >= 0) for first, last in self.gaps], axis=0)

    def turns(self) -> FloatArray:
        """Directions of the corners, shape (4, ...)."""
        (y0, y1), (z0, z1) = self.gaps
        return np.stack([np.arctan2(b, a) for a in (y0, y1) for b in (z0, z1)])

    def ray(self, phi: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Distances at which a ray enters and leaves it; the second is smaller where it misses."""
        nearest, farthest = np.zeros(phi.shape), np.full(phi.shape, np.inf)
        for (first, last), slope in zip(self.gaps, (np.cos(phi), np.sin(phi)), strict=True):
            with np.errstate(divide="ignore", invalid="ignore"):
                a, b = first / slope, last / slope
            a, b = np.where(slope == 0, -np.inf, a), np.where(slope == 0, np.inf, b)
            nearest, farthest = np.maximum(nearest, np.minimum(a, b)), np.minimum(farthest, np.maximum(a, b))
        return nearest, farthest


class _Ellipse:
    """The ellipse that fills a rectangle, seen from points of the surface."""

    def __init__(self, y: FloatArray, z: FloatArray, low: FloatArray, high: FloatArray) -> None:
        middle, self.half = 0.5 * (low + high), 0.5 * (high - low)
        self.u, self.v = (y - middle[..., 0]) / self.half[..., 0], (z - middle[..., 1]) / self.half[..., 1]
        r = np.hypot(self.u, self.v)
        self.beyond = (r - 1) * (r + 1)
        self.inside: npt.NDArray[np.bool_] = np.asarray(self.beyond <= 0)

    def turns(self) -> FloatArray:
        """Directions of the tangents, or of what is left of them inside, shape (4, ...)."""
        a, b = self.half[..., 0], self.half[..., 1]
        along, across = (self.u**2 - self.beyond) / a**2, (self.v**2 - self.beyond) / b**2
        mixed = 2 * self.u * self.v / (a * b)
        size = np.hypot(along - across, mixed)
        ratio = -(along + across) / np.where(size > 0, size, 1.0)
        middle = 0.5 * np.arctan2(mixed, along - across)
        half = 0.5 * np.arccos(np.clip(ratio, -1.0, 1.0))
        return np.stack([middle + half, middle - half, middle + half + np.pi, middle - half + np.pi])

    def ray(self, phi: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Distances at which a ray enters and leaves it; both are 0 where it misses."""
        c, s = np.cos(phi) / self.half[..., 0], np.sin(phi) / self.half[..., 1]
        square, slope = c * c + s * s, self.u * c + self.v * s
        under = slope * slope - square * self.beyond
        root = np.sqrt(np.maximum(under, 0.0))
        outer = np.where(slope <= 0, (root - slope) / square, -self.beyond / np.maximum(root + slope, 1e-300))
        inner = self.beyond / np.maximum(root - slope, 1e-300)
        ahead = (under > 0) & (self.inside | (slope < 0))
        return np.where(ahead & ~self.inside, inner, 0.0), np.where(ahead, outer, 0.0)
