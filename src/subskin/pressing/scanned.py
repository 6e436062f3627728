"""What presses, as it was measured or computed: profiles of points, and heights on a grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Real
from ..errors import GeometryError, InvalidValueError
from .body import Ends, LocalIndenter, points
from .indenter import Indenter

__all__ = ["HeightMap", "Profile"]

_MOST_POINTS = 10**7
_FILLED = Real("m", fix="fill the gaps, e.g. np.interp over the points that there are")
_NONE = "fill the gaps, or np.inf where there is no body"


def _ascending(name: str, nodes: FloatArray) -> None:
    if not (np.diff(nodes) > 0).all():
        at = int(np.argmin(np.diff(nodes)))
        seen = f"{name}[{at}] = {nodes[at]:.6g}, {name}[{at + 1}] = {nodes[at + 1]:.6g}"
        raise GeometryError(seen, "the positions have to ascend", "sort the points, and keep one of each")


@dataclass(frozen=True)
class _Lowered:
    """A function whose lowest value is taken off; it pickles where the function does."""

    function: Callable[[FloatArray], npt.ArrayLike]
    lowest: float

    def __call__(self, y: FloatArray) -> FloatArray:
        return np.asarray(self.function(y), dtype=np.float64) - self.lowest


@dataclass(frozen=True, eq=False)
class Profile(Indenter):
    """A measured profile: points joined by straight lines; there is nothing beyond the first and the last.

    Parameters
    ----------
    y : array_like, shape (n,)
        Positions [m], ascending, n >= 2.
    height_at : array_like, shape (n,)
        Heights [m], larger is farther from the skin; the lowest is taken off, as depth counts from it.

    Raises
    ------
    InvalidValueError, GeometryError
        A gap (a value that is not finite), fewer than two points, positions that do not ascend.

    Examples
    --------
    >>> Profile([-1e-3, 0.0, 1e-3], [2e-4, 1e-4, 3e-4]).height([0.0, 0.5e-3, 2e-3]).round(9).tolist()
    [0.0, 0.0001, inf]
    """

    y: Annotated[npt.ArrayLike, _FILLED]
    height_at: Annotated[npt.ArrayLike, _FILLED]
    _function: Callable[[FloatArray], FloatArray] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        y, height = np.asarray(self.y), np.asarray(self.height_at)
        if y.ndim != 1 or y.shape != height.shape or y.size < 2:
            seen = f"y of shape {y.shape}, height_at of shape {height.shape}"
            raise GeometryError(
                seen,
                "a profile needs two points or more, a height for each position",
                "Profile([-1e-3, 0, 1e-3], [1e-4, 0, 1e-4])",
            )
        _ascending("y", y)
        object.__setattr__(self, "height_at", _check.read_only(height - height.min()))

    @classmethod
    def from_function(
        cls, function: Callable[[FloatArray], npt.ArrayLike], low: float, high: float, points: int = 4097
    ) -> Profile:
        """A profile given by a `function` of the position y [m], from `low` to `high` [m].

        The function itself is evaluated at the solver's nodes; `points` are for finding its lowest point.

        Examples
        --------
        >>> bump = Profile.from_function(lambda y: 5e-5 * (1 - np.exp(-(y / 1e-3) ** 2)), -3e-3, 3e-3)
        >>> float(bump.height(0.0))
        0.0
        """
        if not callable(function):
            seen, fix = f"function = {_check.shown(function)}", "lambda y: y**2 / 16e-3"
            raise InvalidValueError(seen, "a function of the positions y is needed", fix)
        count = _check.whole("points", points, at_least=2, at_most=_MOST_POINTS, fix="points=4001")
        y = np.linspace(_check.scalar("low", low, unit="m"), _check.scalar("high", high, unit="m"), int(count))
        raw = _check.real("height", function(y), unit="m", fix="end the profile where the function does")
        if raw.shape != y.shape:
            raise GeometryError(
                f"height of shape {raw.shape}", f"the function has to return shape {y.shape}", "np.vectorize(function)"
            )
        lowest = float(raw.min())
        return cls(y, raw, _Lowered(function, lowest))

    def height(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys = _check.real("y", y, unit="m")
        low, high = self.ends
        inside = (ys >= low) & (ys <= high)
        at = np.clip(ys, low, high)
        points = np.asarray(self.y, dtype=np.float64)
        values = np.interp(at, points, np.asarray(self.height_at)) if self._function is None else self._function(at)
        return np.asarray(np.where(inside, values, np.inf))

    @property
    def ends(self) -> tuple[float, float]:  # noqa: D102
        points = np.asarray(self.y, dtype=np.float64)
        return float(points[0]), float(points[-1])


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

    y: Annotated[npt.ArrayLike, Real("m")]
    z: Annotated[npt.ArrayLike, Real("m")]
    height_at: Annotated[npt.ArrayLike, Real("m", finite=False, fix=_NONE)]

    def __post_init__(self) -> None:
        super().__post_init__()
        ys, zs, height = np.asarray(self.y), np.asarray(self.z), np.asarray(self.height_at)
        for name, nodes in (("y", ys), ("z", zs)):
            if nodes.ndim != 1 or nodes.size < 2:
                raise GeometryError(f"{name} of shape {nodes.shape}", "two positions or more are needed, which ascend")
            _ascending(name, nodes)
        if np.isnan(height).any() or (height == -np.inf).any() or not np.isfinite(height).any():
            raise InvalidValueError("height_at with NaN or without any height", "each point needs a height", _NONE)
        if height.shape != (ys.size, zs.size):
            seen = f"height_at of shape {height.shape}, y of {ys.size}, z of {zs.size}"
            raise GeometryError(seen, f"a height for each position, shape ({ys.size}, {zs.size}), is needed")
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
