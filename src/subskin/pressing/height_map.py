"""A body of any shape that presses on an area: its heights at the points of a grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError
from .body import Ends, LocalIndenter, points

__all__ = ["HeightMap"]


@dataclass(frozen=True, eq=False)
class HeightMap(LocalIndenter):
    """A measured or computed surface: heights on a grid, bilinear between its points; there is nothing beyond it.

    Parameters
    ----------
    y, z : array_like, shape (n,), (k,)
        Positions [m], ascending, two at least.
    height_at : array_like, shape (n, k)
        Heights [m], larger is farther from the skin; the lowest is taken off, as depth counts from it. inf where no
        body is.

    Raises
    ------
    InvalidValueError, GeometryError
        A NaN, positions that do not ascend, or shapes that do not belong together.

    Examples
    --------
    >>> body = HeightMap([-1e-3, 1e-3], [0.0, 1e-3], [[2e-4, 3e-4], [1e-4, 2e-4]])
    >>> body.height([0.0, 0.0], [0.5e-3, 2e-3]).round(9).tolist()
    [0.0001, inf]
    """

    y: npt.ArrayLike
    z: npt.ArrayLike
    height_at: npt.ArrayLike

    def __post_init__(self) -> None:
        ys, zs = _check.real("y", self.y, unit="m"), _check.real("z", self.z, unit="m")
        for name, nodes in (("y", ys), ("z", zs)):
            if nodes.ndim != 1 or nodes.size < 2 or not (np.diff(nodes) > 0).all():
                raise GeometryError(f"{name} of shape {nodes.shape}", "two positions or more are needed, which ascend")
        fix = "fill the gaps, or np.inf where there is no body"
        height = _check.real("height_at", self.height_at, unit="m", finite=False, fix=fix)
        if np.isnan(height).any() or (height == -np.inf).any() or not np.isfinite(height).any():
            raise InvalidValueError("height_at with NaN or without any height", "each point needs a height", fix)
        if height.shape != (ys.size, zs.size):
            seen = f"height_at of shape {height.shape}, y of {ys.size}, z of {zs.size}"
            raise GeometryError(seen, f"a height for each position, shape ({ys.size}, {zs.size}), is needed")
        object.__setattr__(self, "y", ys)
        object.__setattr__(self, "z", zs)
        object.__setattr__(self, "height_at", _check.read_only(height - height[np.isfinite(height)].min()))

    @classmethod
    def from_function(
        cls, function: Callable[[FloatArray, FloatArray], npt.ArrayLike], y: npt.ArrayLike, z: npt.ArrayLike
    ) -> HeightMap:
        """The heights that a `function` of y (n, 1) and z (k,) [m] has at the points.

        Examples
        --------
        >>> at = np.linspace(-3e-3, 3e-3, 61)
        >>> dome = HeightMap.from_function(lambda y, z: 5e-5 * (1 - np.exp(-(y**2 + z**2) / 1e-6)), at, at)
        >>> float(dome.height(0.0, 0.0))
        0.0
        """
        if not callable(function):
            seen = f"function = {_check.shown(function)}"
            raise InvalidValueError(seen, "a function of y and z is needed", "lambda y, z: ...")
        ys, zs = points(y, z)
        if ys.ndim != 1 or zs.ndim != 1:
            seen = f"y of shape {ys.shape}, z of shape {zs.shape}"
            raise GeometryError(seen, "a row of positions each is needed", "np.linspace(-3e-3, 3e-3, 61)")
        found = _check.returned("function(y, z)", function(ys[:, None], zs), (ys.size, zs.size), exactly=True)
        return cls(ys, zs, found)

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys, zs = np.broadcast_arrays(*points(y, z))
        heights = np.asarray(self.height_at, dtype=np.float64)
        i, s, inside = _cell(np.asarray(self.y, dtype=np.float64), ys)
        j, t, also = _cell(np.asarray(self.z, dtype=np.float64), zs)
        out = np.zeros(ys.shape)
        for di, wi in ((0, 1 - s), (1, s)):
            for dj, wj in ((0, 1 - t), (1, t)):
                weight = wi * wj
                out += np.where(weight > 0, weight, 0.0) * np.where(weight > 0, heights[i + di, j + dj], 0.0)
        return np.asarray(np.where(inside & also, out, np.inf))

    @property
    def ends(self) -> Ends:  # noqa: D102
        ys, zs = np.asarray(self.y, dtype=np.float64), np.asarray(self.z, dtype=np.float64)
        return (float(ys[0]), float(ys[-1])), (float(zs[0]), float(zs[-1]))


def _cell(nodes: FloatArray, at: FloatArray) -> tuple[npt.NDArray[np.intp], FloatArray, npt.NDArray[np.bool_]]:
    """The stretch in which each position lies, its share of it, and whether it lies in any."""
    i = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, nodes.size - 2)
    share = (at - nodes[i]) / (nodes[i + 1] - nodes[i])
    return i, np.clip(share, 0.0, 1.0), (at >= nodes[0]) & (at <= nodes[-1])
