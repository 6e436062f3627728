"""The surface in elements, along a row or on an area: what each makes the sensors read."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._frozen import Frozen
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...radial import RadialResponse, tabulate_radial
from ...response import Response, tabulate
from ..area.search import search_of
from .hats import Hats
from .prior import Bridge, Membrane, Prior

__all__ = ["Surface"]

_FINEST, _WIDEST, _MOST = (12.0, 3.0), (4.0, 2.0), (4096, 16_384)
"""Elements to the least depth if nothing is asked for, at least, and in all; along a row and on an area."""

_COARSE = (3, 2)
"""Elements along one side of a coarse one, from which each search starts."""

_POINTS = 4
_SAME = 1e-6


@dataclass(frozen=True, eq=False)
class Surface(Frozen):
    """Hats along a line or on an area: a traction that is (bi)linear between nodes and 0 at the ends, or the border.

    Parameters
    ----------
    y, z : ndarray, shapes (ny + 2,) and (nz + 2,)
        Nodes along y and along z, each of equal distance [m]; along a row z is the single line of its sensors.
    hats : Hats
        Reading per Pa of pressure and of drag along y and, on an area, along z at each inner node.
    """

    y: FloatArray
    z: FloatArray
    hats: Hats

    @property
    def drags(self) -> int:
        """Directions of a drag: 1 along a row, 2 on an area."""
        return 1 if len(self.z) == 1 else 2

    @property
    def coarse(self) -> tuple[int, int]:
        """Elements along y and z in a coarse one, by lines and along them."""
        return (1, _COARSE[0]) if self.drags == 1 else (_COARSE[1], _COARSE[1])

    @cached_property
    def prior(self) -> Prior:
        """The prior of a traction of these elements."""
        if self.drags == 1:
            return Bridge(len(self.y) - 2, _step(self.y))
        return Membrane((len(self.y) - 2, len(self.z) - 2), (_step(self.y), _step(self.z)))

    @classmethod
    def of(cls, finger: Finger, search: Any, step: float | None) -> Surface:
        """Cut the search into elements of a share of the least depth, or of at most `step` [m]."""
        return (cls._area if finger.array.on_area else cls._row)(finger, search, step)

    @classmethod
    def _row(cls, finger: Finger, search: tuple[float, float] | None, step: float | None) -> Surface:
        table = tabulate(finger, search)
        size = _size(finger, step, 0)
        length, times = table.stop - table.start, _COARSE[0]
        cells = times * max(int(np.ceil(length / (times * size) * (1 - 1e-12))), 2)
        if cells > _MOST[0]:
            rule, fix = f"at most {_MOST[0]} can be solved for", "a narrower search or a larger step"
            raise GeometryError(f"{cells} elements of {length / cells:.3g} m", rule, fix)
        y = np.linspace(table.start, table.stop, cells + 1)
        reading = np.moveaxis(_line_hats(table, y), (1, 2), (0, 1))[:, :, None]
        n = len(reading)
        tables = tuple(_check.read_only(np.ascontiguousarray(one)) for one in reading)
        hats = Hats((1, len(y) - 2), tables, np.arange(n), np.zeros((n, 2), dtype=np.int64), np.ones(n))
        return cls(_check.read_only(y), _check.read_only(np.zeros(1)), hats)

    @classmethod
    def _area(cls, finger: Finger, search: Any, step: float | None) -> Surface:
        if finger.measured is not None:
            seen = "a finger with a response measured in place"
            rule = "an image of the pressure goes by the skin's field"
            raise InvalidValueError(seen, rule, "dataclasses.replace(finger, measured=None), if that field will do")
        array, size, times = finger.array, _size(finger, step, 1), _COARSE[1]
        box, _ = search_of(array, search)
        axes = []
        for ends, at in zip(box, array.points.T, strict=True):
            if np.ptp(ends) > _MOST[1] * size:
                rule, fix = f"at most {_MOST[1]} elements can be solved for", "a narrower search or a larger step"
                raise GeometryError(f"elements of {size:.3g} m along {np.ptp(ends):.3g} m", rule, fix)
            nearest = size if search is not None else _fitting(at, size, step is not None)
            cells = times * max(int(np.ceil(np.ptp(ends) / (times * nearest) * (1 - 1e-9))), 3)
            length = np.ptp(ends) if search is not None else cells * nearest
            axes.append(0.5 * (ends.sum() + length * np.linspace(-1, 1, cells + 1)))
        count = (len(axes[0]) - 2) * (len(axes[1]) - 2)
        if count > _MOST[1]:
            rule, fix = f"at most {_MOST[1]} can be solved for", "a narrower search or a larger step"
            raise GeometryError(f"{count} elements of about {size:.3g} m", rule, fix)
        y, z = (_check.read_only(axis) for axis in axes)
        table = tabulate_radial(finger, float(np.hypot(*(np.ptp(axis) for axis in axes)))).separate()
        return cls(y, z, _area_hats(table, y, z))


def _size(finger: Finger, step: float | None, kind: int) -> float:
    """The size of an element [m]; kind: 0 along a row, 1 on an area."""
    depth = float(np.asarray(finger.array.depth).min())
    if step is None:
        return depth / _FINEST[kind]
    size = _check.scalar("step", step, unit="m", above=0.0)
    if size > depth / _WIDEST[kind]:
        rule = f"elements have to be {'finer' if kind else 'much finer'} than the depth, here at most "
        rule += f"{depth / _WIDEST[kind]:.6g} m"
        raise InvalidValueError(f"step = {step:.6g} m", rule, "leave out step")
    return size


def _step(nodes: FloatArray) -> float:
    return float(nodes[-1] - nodes[0]) / (len(nodes) - 1)


def _fitting(at: FloatArray, size: float, at_most: bool) -> float:
    """The step near `size`, or not above it, of which all distances of sensors along an axis are multiples.

    Where there is none, `size` itself.
    """
    found = np.unique(np.round(at / (_SAME * size))) * (_SAME * size)
    gaps = np.diff(found)
    gaps = gaps[gaps > 10 * _SAME * size]
    if not gaps.size or (np.abs(gaps / gaps.min() - np.round(gaps / gaps.min())) > 1e-3).any():
        return size
    pieces = gaps.min() / size
    if pieces < 0.5:
        return size
    return float(gaps.min() / max(np.ceil(pieces - 1e-9) if at_most else np.round(pieces), 1))


def _line_hats(table: Response, y: FloatArray) -> FloatArray:
    """Readings per Pa of the hats at the inner nodes, by quadrature of the line loads' table, shape (m, n, 2)."""
    # the fields are analytic within a depth: four points in an element of a quarter of it leave 1e-9
    t, weight = np.polynomial.legendre.leggauss(_POINTS)
    share, weight = 0.5 * (1 + t), 0.5 * weight * (y[1] - y[0])
    left, right = y[:-1], y[1:]
    rising = falling = np.zeros((len(left), *table.coefficients.shape[2:]))
    for s, w in zip(share, weight, strict=True):
        values = table(left + s * (right - left))
        rising, falling = rising + w * s * values, falling + w * (1 - s) * values
    return np.asarray(rising[:-1] + falling[1:])


def _area_hats(response: RadialResponse, y: FloatArray, z: FloatArray) -> Hats:
    """Readings per Pa of the hats at the inner nodes, by quadrature of the point loads' table."""
    hy, hz = _step(y), _step(z)
    ny, nz = len(y) - 2, len(z) - 2
    # sensors that stand alike to the nodes share their readings, moved by whole steps
    where = (response.points - (y[1], z[1])) / (hy, hz)
    whole = np.floor(where + 1e-6).astype(np.int64)
    rest = np.round((where - whole) / _SAME).astype(np.int64)
    _, first, kind = np.unique(
        np.column_stack([response.kind, rest]), axis=0, return_index=True, return_inverse=True
    )  # fmt: skip
    kind = kind.reshape(-1)
    tables, corner = [], np.empty_like(whole)
    for k, sensor in enumerate(first.tolist()):
        steps = whole[kind == k]
        least, most = -steps.max(axis=0), -steps.min(axis=0)
        corner[kind == k] = -least - steps
        # nodes so many steps from the sensors' own
        along, across = (np.arange(a - 1, b + n) for a, b, n in zip(least, most, (ny, nz), strict=True))
        one = replace(response.select([sensor]), gain=np.ones(1))
        corners = _cells(one, one.points[0] - (where - whole)[sensor] * (hy, hz), along * hy, across * hz, hy, hz)
        hat = corners[0, 0][1:, 1:] + corners[1, 0][:-1, 1:] + corners[0, 1][1:, :-1] + corners[1, 1][:-1, :-1]
        tables.append(_check.read_only(np.moveaxis(hat, -1, 0)))
    return Hats((ny, nz), tuple(tables), kind, corner, np.asarray(response.gain))


def _cells(
    table: RadialResponse, origin: FloatArray, along: FloatArray, across: FloatArray, hy: float, hz: float
) -> npt.NDArray[np.float64]:
    """Readings of the parts of hats in each cell, by the corner of the cell, low or high, where the hat's top is.

    Shape (2, 2, cells along y, cells along z, 3).
    """
    t, weight = np.polynomial.legendre.leggauss(_POINTS)
    share, weight = 0.5 * (1 + t), 0.5 * weight
    out = np.zeros((2, 2, along.size, across.size, 3))
    for s, u in zip(share, weight, strict=True):
        for p, v in zip(share, weight, strict=True):
            at = np.stack(np.meshgrid(along + s * hy, across + p * hz, indexing="ij"), axis=-1)
            values = u * v * hy * hz * table(origin + at)[..., 0, :]
            for i, by_y in enumerate((1 - s, s)):
                for k, by_z in enumerate((1 - p, p)):
                    out[i, k] += by_y * by_z * values
    return out
