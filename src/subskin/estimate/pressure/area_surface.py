"""An area in elements: what each makes the sensors read, worked out once for all sensors that stand alike to them."""

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
from ..area.locator import search_of
from .hats import COARSE, Hats
from .prior import Membrane

__all__ = ["AreaSurface"]

_FINEST, _WIDEST = 3.0, 2.0
_MOST_NODES = 16_384
_POINTS = 4
_SAME = 1e-6


@dataclass(frozen=True, eq=False)
class AreaSurface(Frozen):
    """Bilinear hats on an area: a traction that is bilinear between nodes and 0 on the border.

    Parameters
    ----------
    y, z : ndarray, shape (ny + 2,), (nz + 2,)
        Nodes along y and along z, each of equal distance [m].
    hats : Hats
        Reading per Pa of pressure and of drag along y and along z at each inner node.
    """

    y: FloatArray
    z: FloatArray
    hats: Hats

    @cached_property
    def prior(self) -> Membrane:
        """The prior of a traction of these elements."""
        return Membrane((len(self.y) - 2, len(self.z) - 2), (_step(self.y), _step(self.z)))

    @classmethod
    def of(cls, finger: Finger, search: Any, step: float | None) -> AreaSurface:
        """Cut the search into elements of about a third of the least depth, or of at most `step` [m]."""
        array = finger.array
        depth = float(np.asarray(array.depth).min())
        if step is None:
            size = depth / _FINEST
        else:
            size = _check.scalar("step", step, unit="m", above=0.0)
            if size > depth / _WIDEST:
                rule = f"elements have to be finer than the depth, here at most {depth / _WIDEST:.6g} m"
                raise InvalidValueError(f"step = {step:.6g} m", rule, "leave out step")
        box, _ = search_of(array, search)
        axes = []
        for ends, at in zip(box, array.points.T, strict=True):
            if np.ptp(ends) > _MOST_NODES * size:
                rule, fix = f"at most {_MOST_NODES} elements can be solved for", "a narrower search or a larger step"
                raise GeometryError(f"elements of {size:.3g} m along {np.ptp(ends):.3g} m", rule, fix)
            nearest = size if search is not None else _fitting(at, size, step is not None)
            cells = COARSE * max(int(np.ceil(np.ptp(ends) / (COARSE * nearest) * (1 - 1e-9))), 3)
            length = np.ptp(ends) if search is not None else cells * nearest
            axes.append(0.5 * (ends.sum() + length * np.linspace(-1, 1, cells + 1)))
        count = (len(axes[0]) - 2) * (len(axes[1]) - 2)
        if count > _MOST_NODES:
            rule, fix = f"at most {_MOST_NODES} can be solved for", "a narrower search or a larger step"
            raise GeometryError(f"{count} elements of about {size:.3g} m", rule, fix)
        y, z = (_check.read_only(axis) for axis in axes)
        table = tabulate_radial(finger, float(np.hypot(*(np.ptp(axis) for axis in axes)))).separate()
        return cls(y, z, _hats(table, y, z))


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


def _hats(response: RadialResponse, y: FloatArray, z: FloatArray) -> Hats:
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
