"""A pressure of any shape, drawn by straight lines between nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from ..errors import GeometryError
from .base import Contact, Spectrum, Transforms
from .functions import FAR, far_shear_field, gap, inverse, joined, log_ratio, shear_field

__all__ = ["PressureProfile", "spherical_j1"]

_FAR_ELEMENT = 10.0
"""Beyond this many half lengths from a stretch its formulas cancel, and their series converges in seven terms."""

_TERMS = 7
_MOMENTS = 10
_BLOCK = 1 << 15


@dataclass(frozen=True, init=False)
class PressureProfile(Contact):
    """Pressure and, independently, shear that vary linearly between nodes and vanish beyond the first and the last.

    Each stretch between two nodes adds (p_b - p_a) + p(z) log((z - b)/(z - a)) to F(z), where p(z) is the straight line
    itself taken at z. Source: docs/theory.md; Johnson, Contact Mechanics (1985), section 2.6. A uniform strip and a
    ramp are the shortest ones: two nodes. Any smooth pressure is approached with the square of the nodes' distance.

    Parameters
    ----------
    y : array_like, shape (..., n)
        Nodes along the surface [m], ascending, n >= 2.
    pressure : array_like, shape (..., n)
        Pressure at each node [Pa], positive in compression.
    shear : array_like, shape (..., n), optional
        Shear at each node [Pa], positive where it drags the skin towards +y; none if left out.

    Attributes
    ----------
    nodes, node_pressure, node_shear : ndarray, shape (..., n)
        What was given, broadcast [m], [Pa], [Pa].

    Raises
    ------
    InvalidValueError, GeometryError
        A value that is not finite; fewer than two nodes, nodes that do not ascend, shapes that do not broadcast.

    Examples
    --------
    >>> ramp = PressureProfile(y=[0.0, 2e-3], pressure=[0.0, 20e3])
    >>> float(ramp.normal_force), float(ramp.pressure(0.5e-3))
    (20.0, 5000.0)
    """

    nodes: FloatArray
    node_pressure: FloatArray
    node_shear: FloatArray

    def __init__(self, y: npt.ArrayLike, pressure: npt.ArrayLike, shear: npt.ArrayLike | None = None) -> None:
        ys = _check.real("y", y, unit="m")
        ps = _check.real("pressure", pressure, unit="Pa")
        qs = _check.real("shear", np.zeros_like(ps) if shear is None else shear, unit="Pa")
        shape = _check.broadcast(y=ys, pressure=ps, shear=qs)
        if not ys.ndim or ys.shape[-1] < 2 or shape[-1] != ys.shape[-1]:
            raise GeometryError(
                f"y of shape {ys.shape}",
                "at least two nodes, one for each pressure, are needed",
                "y=[-1e-3, 0, 1e-3], pressure=[0, 1e3, 0]",
            )
        if not (np.diff(ys) > 0).all():
            fix = "np.sort, and a + b for a jump inside"
            raise GeometryError(f"y = {ys.tolist()}", "the nodes have to ascend", fix)
        nodes, pressures, shears = (np.broadcast_to(values, shape) for values in (ys, ps, qs))
        self.__dict__.update(nodes=nodes, node_pressure=pressures, node_shear=shears)

    @property
    def shape(self) -> tuple[int, ...]:  # noqa: D102
        return self.nodes.shape[:-1]

    @property
    def components(self) -> FloatArray:  # noqa: D102
        each = (np.trapezoid(v, self.nodes, axis=-1) for v in (self.node_pressure, self.node_shear))
        return _check.read_only(np.stack(tuple(each), axis=-1))

    @property
    def breaks(self) -> FloatArray:  # noqa: D102
        return self.nodes

    def transforms(self, z: ComplexArray) -> Transforms:  # noqa: D102
        shape = np.broadcast_shapes(self.shape, z.shape)
        p, dp, q, dq = (np.zeros(shape, dtype=np.complex128) for _ in range(4))
        step = max(1, _BLOCK // max(1, int(np.prod(shape))))
        for first in range(0, self.nodes.shape[-1] - 1, step):
            part = slice(first, first + step + 1)
            stretch = _Stretch.at(z[..., None], self.nodes[..., part])
            for values, f, df in ((self.node_pressure, p, dp), (self.node_shear, q, dq)):
                if values.any():
                    one, two = stretch.transform(values[..., part])
                    f += one.sum(axis=-1)
                    df += two.sum(axis=-1)
        h = self._shear_field(z, q, dq) if self.node_shear.any() else np.zeros(shape)
        return Transforms(p, dp, q, dq, h)

    def _shear_field(self, z: ComplexArray, q: ComplexArray, dq: ComplexArray) -> FloatArray:
        x = z.imag
        h = np.asarray(shear_field(np, x, (q.real, q.imag), (dq.real, dq.imag), not x.all()))
        middle = 0.5 * (self.nodes[..., 0] + self.nodes[..., -1])
        reach = self.nodes[..., -1] - middle
        away = np.broadcast_to(z - middle, h.shape)
        far = np.broadcast_to(np.abs(away) > FAR * reach, h.shape)
        if far.any():
            moments = [np.broadcast_to(m, h.shape)[far] for m in self._shear_moments(middle)]
            h[far] = far_shear_field(away[far].imag, away[far].real, moments)
        return h

    def _shear_moments(self, middle: FloatArray) -> list[FloatArray]:
        a, b = self.nodes[..., :-1, None], self.nodes[..., 1:, None]
        t, w = np.polynomial.legendre.leggauss((_MOMENTS + 2) // 2)  # exact for a straight line times t^(_MOMENTS - 1)
        share = 0.5 * (1 + t)
        q = self.node_shear[..., :-1, None] * (1 - share) + self.node_shear[..., 1:, None] * share
        arm, weight = a + (b - a) * share - middle[..., None, None], 0.5 * (b - a) * w * q
        return [np.asarray((weight * arm**k).sum(axis=(-2, -1))) for k in range(_MOMENTS)]

    def spectrum(self, k: FloatArray) -> Spectrum:  # noqa: D102
        shape = np.broadcast_shapes(self.shape, k.shape)
        p, q = (np.zeros(shape, dtype=np.complex128) for _ in range(2))
        step = max(1, _BLOCK // max(1, int(np.prod(shape))))
        wave = np.asarray(k)[..., None]
        for first in range(0, self.nodes.shape[-1] - 1, step):
            part = slice(first, first + step + 1)
            start, end = self.nodes[..., part][..., :-1], self.nodes[..., part][..., 1:]
            h = 0.5 * (end - start)
            even, odd = np.sinc(wave * h / np.pi), spherical_j1(wave * h)
            shift = h * np.exp(-0.5j * wave * (start + end))
            for values, total in ((self.node_pressure, p), (self.node_shear, q)):
                if values.any():
                    a, b = values[..., part][..., :-1], values[..., part][..., 1:]
                    total += (shift * ((a + b) * even - 1j * (b - a) * odd)).sum(axis=-1)
        return Spectrum(p, q)

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        return self.nodes[..., 0], self.nodes[..., -1]

    def pressure(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return self._between(self.node_pressure, y)

    def shear(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return self._between(self.node_shear, y)

    def _between(self, values: FloatArray, y: npt.ArrayLike) -> FloatArray:
        ys = _check.real("y", y, unit="m")
        shape = np.broadcast_shapes(self.shape, ys.shape)
        at = np.broadcast_to(ys, shape)
        nodes, values = (np.broadcast_to(v, (*shape, v.shape[-1])) for v in (self.nodes, values))
        left = np.clip((nodes <= at[..., None]).sum(axis=-1) - 1, 0, nodes.shape[-1] - 2)[..., None]
        a, b = (np.take_along_axis(nodes, left + k, axis=-1)[..., 0] for k in (0, 1))
        va, vb = (np.take_along_axis(values, left + k, axis=-1)[..., 0] for k in (0, 1))
        return _check.read_only(np.where((at < a) | (at > b), 0.0, (va * (b - at) + vb * (at - a)) / (b - a)))

    def singular_points(self) -> tuple[FloatArray, ...]:
        """The ends where pressure or shear jump from 0, NaN where they do not; at a kink all is finite."""
        ends = []
        for end in (0, -1):
            jumps = (self.node_pressure[..., end] != 0) | (self.node_shear[..., end] != 0)
            ends.append(np.where(jumps, self.nodes[..., end], np.nan))
        return tuple(ends)

    def expand(self, axes: int = 1) -> Self:  # noqa: D102
        shape = (*self.shape, *(1,) * axes, self.nodes.shape[-1])
        names = ("nodes", "node_pressure", "node_shear")
        return self.altered(**{name: getattr(self, name).reshape(shape) for name in names})


def spherical_j1(x: FloatArray) -> FloatArray:
    """(sin x - x cos x) / x^2, the spectrum of a straight line through 0."""
    small = np.abs(x) < 0.1
    far, square = np.where(small, 1.0, x), x * x
    series = x / 3 * (1 - square / 10 * (1 - square / 28 * (1 - square / 54 * (1 - square / 88))))
    return np.where(small, series, (np.sin(far) - far * np.cos(far)) / far**2)


class _Stretch(NamedTuple):
    """What the stretches between nodes (last axis) need of the points, whatever the tractions on them."""

    z: ComplexArray
    start: FloatArray
    end: FloatArray
    log: ComplexArray  # L = log((z - end) / (z - start))
    kernel: ComplexArray  # dL/dz = 2 h / ((z - start) (z - end))
    near: npt.NDArray[np.bool_]
    moment: ComplexArray  # 2 h + (z - centre) L, where far
    slope: ComplexArray  # L + (z - centre) dL/dz, where far

    @classmethod
    def at(cls, z: ComplexArray, nodes: FloatArray) -> _Stretch:
        start, end = nodes[..., :-1], nodes[..., 1:]
        h, centre = 0.5 * (end - start), 0.5 * (start + end)
        y, x = z.real, z.imag
        log = joined(log_ratio(np, x, y - start, y - end, y - centre, h))
        kernel = joined(inverse(gap(x, y - start, y - end, y - centre), 2 * h))
        near = (y - centre) ** 2 + x**2 < (_FAR_ELEMENT * h) ** 2
        w: ComplexArray = np.asarray(h / np.where(near, 1.0, z - centre), dtype=np.complex128)
        square = w * w
        moment, slope = np.zeros_like(w), np.zeros_like(w)
        for k in range(_TERMS, 0, -1):
            moment = (moment - 1 / (2 * k + 1)) * square
            slope = (slope + 2 * k / (2 * k + 1)) * square
        return cls(z, start, end, log, kernel, near, 2 * h * moment, 2 * w * slope)

    def transform(self, values: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """F and dF/dz of the straight lines through the nodes' `values`, stretch by stretch."""
        a, b = values[..., :-1], values[..., 1:]
        length = self.end - self.start
        m = (b - a) / length
        line = (a * (self.end - self.z) + b * (self.z - self.start)) / length
        mean = 0.5 * (a + b)
        f = np.where(self.near, (b - a) + line * self.log, mean * self.log + m * self.moment)
        df = np.where(self.near, m * self.log + line * self.kernel, mean * self.kernel + m * self.slope)
        return f, df
