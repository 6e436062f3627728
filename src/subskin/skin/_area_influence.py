"""Displacement of the surface at a distance from a hat of traction: along a line, and on a square grid.

A half space's falls as 1/r from a hat that is bilinear about one node: its integrals over a hat depend on the number
of steps alone, so they are kept for every material and every step. What layers add is smooth over the depth of the
first one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from .._check import FloatArray
from ..errors import GeometryError
from ..material import Material

__all__ = ["added_by", "arranged", "hat_mean", "hat_spectrum", "of_half_space", "wave_sum"]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_BLOCK = 1 << 22


def hat_spectrum(k: FloatArray, step: float) -> FloatArray:
    """Fourier transform [m] of a hat that falls from 1 to 0 within one step on either side."""
    return np.asarray(step * np.sinc(0.5 * k * step / np.pi) ** 2)


def hat_mean(function: object, step: float, count: int) -> FloatArray:
    """Integral of the hat at 0 times a function of the distance, at distances j * step: smooth save perhaps at 0."""
    t = 0.5 * (1 + _NODES)
    total = np.zeros(count)
    for side in (-1, 1):
        for position, weight in zip(side * t, 0.5 * _WEIGHTS * (1 - t), strict=True):
            total += step * weight * function((np.arange(count) - position) * step)  # type: ignore[operator]
    return total


def wave_sum(
    k: FloatArray, even: FloatArray, odd: FloatArray, step: float, count: int
) -> tuple[FloatArray, FloatArray]:
    """Sums over k of even * cos(k y), shape (..., k) to (..., count), and of odd * sin(k y), at y = j * step."""
    cosines, sines = np.empty((*even.shape[:-1], count)), np.empty((*odd.shape[:-1], count))
    size = max(1, _BLOCK // k.size)
    for first in range(0, count, size):
        phase = k[:, None] * (step * np.arange(first, min(first + size, count)))
        cosines[..., first : first + size] = even @ np.cos(phase)
        sines[..., first : first + size] = odd @ np.sin(phase)
    return cosines, sines


def arranged(xx: FloatArray, yy: FloatArray, odd: FloatArray) -> FloatArray:
    """Influence (2, 2, count): u_x and u_y (first index) of a pressure and of a shear; `odd` is u_y of a pressure."""
    return np.array([[xx, -odd], [odd, yy]])


_NEAR = 24
"""Steps from a hat within which each of its cells is integrated by itself."""
_SQUARE_NODES, _ON = np.polynomial.legendre.leggauss(16)
_GAUSS, _SQUARE_WEIGHTS = 0.5 * (1 + _SQUARE_NODES), 0.5 * _ON
_WIDE = 4
"""Nodes on either side by which the mean of a smooth function over a hat is told, exactly to the ninth degree."""
_SMOOTH = 5.0
"""Steps in the depth of a first layer from which on what layers add is smooth."""
_MOST = 1 << 24

Kernel = Callable[[FloatArray, FloatArray], FloatArray]

_ANGULAR: dict[str, Kernel] = {
    "1": lambda y, z: np.ones_like(y + z),
    "cos": lambda y, z: y / np.hypot(y, z),
    "cos 2": lambda y, z: (y * y - z * z) / (y * y + z * z),
    "sin 2": lambda y, z: 2 * y * z / (y * y + z * z),
}


def of_half_space(material: Material, step: float, shape: tuple[int, int], drag: bool) -> FloatArray:
    """Displacement [m/Pa], shape (1 or 6, n, k), as `Skin.area_influence`."""
    nu, scale = material.poisson, step / (2 * material.shear)
    out = [2 * (1 - nu) * _unit("1", shape)]
    if drag:
        even, turned = (2 - nu) * _unit("1", shape), nu * _unit("cos 2", shape)
        across = _unit("cos", shape[::-1]).T
        odd = [(1 - 2 * nu) * one for one in (_unit("cos", shape), across)]
        out += [even + turned, even - turned, nu * _unit("sin 2", shape), *odd]
    return scale * np.stack(out)


def added_by(functions: Kernel, depth: float, step: float, shape: tuple[int, int]) -> FloatArray:
    """Means over a hat, times its area, of functions that are smooth over `depth` [m], shape (m, n, k).

    Parameters
    ----------
    functions : callable
        Of distances y >= 0 and z >= 0 [m] of shapes (n, 1) and (k,), each even or odd in either.
    depth, step : float
        Depth of the first layer and step of the grid [m].
    shape : tuple of int
        Numbers of distances along y and along z.

    Raises
    ------
    GeometryError
        A layer so thin that the grid would have to be cut too finely.
    """
    finer = 1
    while depth < _SMOOTH * step / finer:
        finer *= 2
    counts = [finer * count for count in shape]
    if counts[0] * counts[1] > _MOST:
        seen = f"a layer of {depth:.3g} m beneath a grid with a step of {step:.3g} m"
        raise GeometryError(seen, "the step is too wide for a skin that thin", "more nodes, or a smaller window")
    fine = step / finer
    hats = fine**2 * _folded(functions, [np.asarray(fine * np.arange(count + _WIDE)) for count in counts], _stencil())
    if finer == 1:
        return hats
    # a wide hat is a sum of narrow ones; beyond the end, where none are known, the last one stands
    weights = 1 - np.arange(finer) / finer
    out = _convolved(np.pad(hats, ((0, 0), (0, finer), (0, finer)), mode="edge"), weights)
    return out[:, : counts[0] : finer, : counts[1] : finer]


def _folded(functions: Kernel, axes: list[FloatArray], weights: FloatArray) -> FloatArray:
    """Symmetric sums of functions at even distances: the last ones are used up."""
    return _convolved(functions(axes[0][:, None], axes[1]), weights)


def _convolved(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Sums along both axes with the weights of 0, 1, 2 ... steps on either side; values mirror at 0, by their sign."""
    reach = weights.size - 1
    for axis in (-2, -1):
        values = np.moveaxis(values, axis, -1)
        sign = np.where(np.abs(values[..., :1]).max(axis=-2, keepdims=True) > 0, 1.0, -1.0)  # odd: 0 at the middle
        wide = np.concatenate([sign * values[..., reach:0:-1], values], axis=-1)
        count = values.shape[-1] - reach
        total = weights[0] * wide[..., reach : reach + count]
        for j in range(1, reach + 1):
            total += weights[j] * (wide[..., reach - j : reach - j + count] + wide[..., reach + j : reach + j + count])
        values = np.moveaxis(total, -1, axis)
    return values


@lru_cache(maxsize=1)
def _stencil() -> FloatArray:
    """Weights of 0 ... 4 steps that give a polynomial's integral over a hat."""
    p = np.arange(_WIDE + 1)
    powers = np.arange(_WIDE + 1)[None, :].astype(float) ** (2 * p[:, None])
    powers[:, 1:] *= 2
    return np.asarray(np.linalg.solve(powers, 2 / ((2 * p + 1) * (2 * p + 2))))


@lru_cache(maxsize=16)
def _unit(kind: str, shape: tuple[int, int]) -> FloatArray:
    """Integrals over unit hats of cos(m t) / (2 pi r) and the like, at whole numbers of steps."""
    angular = _ANGULAR[kind]

    def kernel(y: FloatArray, z: FloatArray) -> FloatArray:
        return np.asarray(angular(y, z) / (2 * np.pi * np.hypot(y, z)))

    wide = [max(count, _NEAR) for count in shape]
    y, z = (np.arange(count + _WIDE, dtype=np.float64) for count in wide)
    z[0] = 1e-30  # not 0 over 0; what is near is replaced
    values = kernel(y[:, None], z)[None]
    if kind in ("cos", "sin 2"):
        values[:, 0] = 0.0
    if kind == "sin 2":
        values[:, :, 0] = 0.0
    out = _convolved(values, _stencil())[0]
    out[:_NEAR, :_NEAR] = _near(kernel)
    out = np.ascontiguousarray(out[: shape[0], : shape[1]])
    out.flags.writeable = False
    return out


def _near(kernel: Kernel) -> FloatArray:
    """The same by Gauss's rule in each of the four cells of a hat; in polar fashion where a cell has the point."""
    at = np.arange(_NEAR, dtype=np.float64)
    s, ws = _GAUSS, _SQUARE_WEIGHTS * (1 - _GAUSS)
    out = np.zeros((_NEAR, _NEAR))
    for side in (-1, 1):
        for other in (-1, 1):
            y, z = at[:, None] - side * s, at[:, None] - other * s
            cells = kernel(y[:, None, :, None], z[None, :, None, :]) @ ws @ ws
            for i in (0, 1):
                for j in (0, 1):
                    # the singular point is a corner: s = i on this side, t = j on that one
                    mine, yours = i == 0 or side == 1, j == 0 or other == 1
                    if mine and yours:
                        cells[i, j] = _cornered(kernel, i, j, side, other)
            out += cells
    return out


def _cornered(kernel: Kernel, i: int, j: int, side: int, other: int) -> float:
    """Over a cell with the singular point in a corner, by Duffy's substitution: two triangles, u du dv each."""
    u, v = _GAUSS[:, None], _GAUSS[None, :]
    weight = _SQUARE_WEIGHTS[:, None] * _SQUARE_WEIGHTS * u
    total = 0.0
    for a, b in ((u + 0 * v, u * v), (u * v, u + 0 * v)):  # distances from the corner
        s, t = (1 - a if i else a), (1 - b if j else b)
        total += float((weight * (1 - s) * (1 - t) * kernel(i - side * s, j - other * t)).sum())
    return total
