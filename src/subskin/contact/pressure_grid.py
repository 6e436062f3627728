"""Any map of pressure and drag, bilinear between the nodes of a grid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from ..errors import GeometryError
from .corners import Corner
from .kernels import point_core, point_family
from .local import LocalContact, LocalSpectrum, LocalTransforms, Potentials
from .profile import spherical_j1

__all__ = ["PressureGrid"]

_FAR = ((8.0, 6), (30.0, 4))
"""Beyond so many half widths of a cell from the map its corners cancel: so many points each way stand for a cell."""

_BLOCK = 1 << 14

Kernel: TypeAlias = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], ComplexArray]
"""What nodes at the distances (y, z) add to points, (n, 1) and (n, k), under their loads, summed over the nodes."""


@dataclass(frozen=True, eq=False, init=False)
class PressureGrid(LocalContact):
    """Pressure and, independently, drag that vary bilinearly between the nodes of a grid and vanish outside.

    Each node adds the field of a corner (docs/local_contacts.md). Any smooth map is approached with the square of the
    nodes' distance. A map that is not zero at its border jumps there.

    Parameters
    ----------
    y, z : array_like, shape (n,), (k,)
        Nodes along y and along z [m], ascending, two at least.
    pressure : array_like, shape (..., n, k)
        Pressure at the nodes [Pa], positive in compression.
    shear : array_like, shape (..., n, k, 2), optional
        Drag (q_y, q_z) at the nodes [Pa]; none if left out.

    Attributes
    ----------
    nodes_y, nodes_z, node_pressure, node_shear : ndarray
        What was given, broadcast [m], [m], [Pa], [Pa], of the shapes above.

    Raises
    ------
    InvalidValueError, GeometryError
        A value that is not finite; nodes that do not ascend, shapes that do not belong together.

    Examples
    --------
    >>> import numpy as np
    >>> y, z = np.linspace(-2e-3, 2e-3, 5), np.linspace(-1e-3, 1e-3, 3)
    >>> bump = PressureGrid(y, z, 1e5 * np.outer([0, 1, 2, 1, 0], [0, 1, 0]))
    >>> bump.components.round(6).tolist(), float(bump.pressure(0.5e-3, 0.5e-3))
    ([0.4, 0.0, 0.0], 75000.0)
    """

    nodes_y: FloatArray
    nodes_z: FloatArray
    node_pressure: FloatArray
    node_shear: FloatArray

    def __init__(
        self, y: npt.ArrayLike, z: npt.ArrayLike, pressure: npt.ArrayLike, shear: npt.ArrayLike | None = None
    ) -> None:
        ys, zs = _check.real("y", y, unit="m"), _check.real("z", z, unit="m")
        for name, nodes in (("y", ys), ("z", zs)):
            if nodes.ndim != 1 or nodes.size < 2 or not (np.diff(nodes) > 0).all():
                seen = f"{name} of shape {nodes.shape}" if nodes.ndim != 1 else f"{name} = {nodes.tolist()}"
                raise GeometryError(seen, "a row of two nodes at least, which ascend, is needed", "np.unique")
        ps = _check.real("pressure", pressure, unit="Pa")
        qs = _check.real("shear", np.zeros((*ps.shape, 2)) if shear is None else shear, unit="Pa")
        if ps.shape[-2:] != (ys.size, zs.size) or qs.shape[-3:] != (ys.size, zs.size, 2):
            seen = f"pressure of shape {ps.shape}, shear of shape {qs.shape}"
            raise GeometryError(seen, f"(..., {ys.size}, {zs.size}) and (..., {ys.size}, {zs.size}, 2) are needed")
        shape = _check.broadcast(pressure=ps, shear=qs[..., 0])
        node_pressure, node_shear = np.broadcast_to(ps, shape), np.broadcast_to(qs, (*shape, 2))
        self.__dict__.update(nodes_y=ys, nodes_z=zs, node_pressure=node_pressure, node_shear=node_shear)

    @property
    def shape(self) -> tuple[int, ...]:  # noqa: D102
        return self.node_pressure.shape[:-2]

    def _integrated(self, power_y: int, power_z: int) -> FloatArray:
        """Integrals of pressure, q_y and q_z times powers, 0 or 1, of the distances from `position`, shape (..., 3)."""
        weights = [
            _moments(nodes - middle)[power]
            for nodes, middle, power in zip((self.nodes_y, self.nodes_z), self._middle, (power_y, power_z), strict=True)
        ]
        values = np.concatenate([self.node_pressure[..., None], self.node_shear], axis=-1)
        return np.asarray(np.einsum("i,j,...ijc->...c", *weights, values))

    @property
    def _middle(self) -> tuple[float, float]:
        return 0.5 * float(self.nodes_y[0] + self.nodes_y[-1]), 0.5 * float(self.nodes_z[0] + self.nodes_z[-1])

    @cached_property
    def components(self) -> FloatArray:
        """Resultant (N, Ty, Tz) [N], shape (..., 3)."""
        return _check.read_only(self._integrated(0, 0))

    @property
    def position(self) -> FloatArray:
        """The middle of the grid [m], shape (..., 2)."""
        return np.broadcast_to(np.array(self._middle), (*self.shape, 2))

    @property
    def moment(self) -> FloatArray:  # noqa: D102
        return _check.read_only(self._integrated(1, 0)[..., 2] - self._integrated(0, 1)[..., 1])

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        low, high = (np.array([self.nodes_y[end], self.nodes_z[end]]) for end in (0, -1))
        return np.broadcast_to(low, (*self.shape, 2)), np.broadcast_to(high, (*self.shape, 2))

    def pressure(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return _check.read_only(self._between(self.node_pressure, y, z))

    def shear(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        parts = [self._between(self.node_shear[..., i], y, z) for i in (0, 1)]
        return _check.read_only(np.stack(parts, axis=-1))

    def _between(self, values: FloatArray, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:
        ys, zs = _check.real("y", y, unit="m"), _check.real("z", z, unit="m")
        shape = np.broadcast_shapes(self.shape, ys.shape, zs.shape)
        weights = [
            np.broadcast_to(_hats(nodes, at), (*shape, nodes.size))
            for nodes, at in ((self.nodes_y, ys), (self.nodes_z, zs))
        ]
        return np.asarray(np.einsum("...i,...j,...ij->...", *weights, values))

    def spectrum(self, ky: FloatArray, kz: FloatArray) -> LocalSpectrum:  # noqa: D102
        along, across = _hat_spectra(self.nodes_y, np.asarray(ky)), _hat_spectra(self.nodes_z, np.asarray(kz))
        maps = (self.node_pressure, self.node_shear[..., 0], self.node_shear[..., 1])
        rows = (np.einsum("...i,...ij->...j", along, values) for values in maps)
        return LocalSpectrum(*(np.asarray(np.einsum("...j,...j->...", across, row)) for row in rows))

    @property
    def _values(self) -> FloatArray:
        """p, q_y and q_z at the nodes, shape (3, ..., n, k)."""
        return np.stack([self.node_pressure, self.node_shear[..., 0], self.node_shear[..., 1]])

    @property
    def _axes(self) -> tuple[FloatArray, FloatArray]:
        return self.nodes_y, self.nodes_z

    @cached_property
    def _corners(self) -> FloatArray:
        """Of p, q_y and q_z and of each node: what of 1, y', z', y' z' starts there, shape (3, 4, ..., n k)."""
        values = self._values
        hy, hz = np.diff(self.nodes_y)[:, None], np.diff(self.nodes_z)
        low, high = np.s_[..., :-1, :], np.s_[..., 1:, :]
        left, right = np.s_[..., :-1], np.s_[..., 1:]
        by_y, by_z = (values[high] - values[low]) / hy, (values[right] - values[left]) / hz
        by_yz = (by_y[right] - by_y[left]) / hz
        out = np.zeros((4, *values.shape))
        for at_y, side_y in ((low, 1), (high, -1)):
            for at_z, side_z in ((left, 1), (right, -1)):
                parts = (values[at_y][at_z], by_y[at_z], by_z[at_y], by_yz)
                for total, part in zip(out, parts, strict=True):
                    total[at_y][at_z] += side_y * side_z * part
        out[np.abs(out) < 1e-14 * np.abs(out).max(axis=(-2, -1), initial=1e-300, keepdims=True)] = 0.0
        return np.moveaxis(out, 0, 1).reshape(3, 4, *values.shape[1:-2], -1)

    def _nodes(self, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Where Gauss's points of all cells are, and p, q_y and q_z times their weights, shape (3, ..., n)."""
        kept: dict[int, tuple[FloatArray, FloatArray, FloatArray]] = self.__dict__.setdefault("_gauss", {})
        if count not in kept:
            (ys, wy), (zs, wz) = (_gauss(nodes, count) for nodes in (self.nodes_y, self.nodes_z))
            hats = _hats(self.nodes_y, ys) * wy[:, None], _hats(self.nodes_z, zs) * wz[:, None]
            loads = np.matmul(hats[0], np.matmul(self._values, hats[1].T))
            at_y, at_z = np.meshgrid(ys, zs, indexing="ij")
            kept[count] = at_y.reshape(-1), at_z.reshape(-1), loads.reshape(*loads.shape[:-2], -1)
        return kept[count]

    def _sum(self, x: FloatArray, y: FloatArray, z: FloatArray, near: Kernel, far: Kernel) -> ComplexArray:
        """The sum over corners where that is exact and over point loads elsewhere, of p, q_y and q_z: (3, m, ...)."""
        shape = np.broadcast_shapes(self.shape, x.shape)
        at = [np.broadcast_to(a, shape).reshape(-1, 1) for a in (x, y, z)]
        cell = 0.5 * max(float(np.diff(self.nodes_y).max()), float(np.diff(self.nodes_z).max()))
        beyond = [np.maximum(np.maximum(n[0] - a, a - n[-1]), 0.0) for n, a in zip(self._axes, at[1:], strict=True)]
        away = np.sqrt(at[0] ** 2 + beyond[0] ** 2 + beyond[1] ** 2)[:, 0] / cell
        level = sum((away > far_off).astype(int) for far_off, _ in _FAR)
        out: ComplexArray | None = None
        for k, count in enumerate((0, *(count for _, count in _FAR))):
            chosen = np.flatnonzero(level == k)
            if not chosen.size:
                continue
            if k == 0:
                nodes = [a.reshape(-1) for a in np.meshgrid(*self._axes, indexing="ij")]
                kernel, loads = near, self._corners
            else:
                *nodes, loads = self._nodes(count)
                kernel = far
            found = _summed(kernel, [a[chosen] for a in at], nodes, self._chosen(loads, shape, chosen))
            if out is None:
                out = np.zeros((*found.shape[:-1], away.size), dtype=np.complex128)
            out[..., chosen] = found
        whole = np.zeros((3, 4, away.size), dtype=np.complex128) if out is None else out
        return whole.reshape(*whole.shape[:-1], *shape)

    def _chosen(self, loads: FloatArray, shape: tuple[int, ...], chosen: npt.NDArray[np.intp]) -> FloatArray:
        """Loads of the chosen points: one row for all where there is one map."""
        lead = loads.shape[: loads.ndim - 1 - len(self.shape)]
        if not self.shape:
            return loads[..., None, :]
        wide = np.broadcast_to(loads, (*lead, *shape, loads.shape[-1]))
        return wide.reshape(*lead, -1, loads.shape[-1])[..., chosen, :]

    def _families(self, order: int, x: FloatArray, y: FloatArray, z: FloatArray) -> ComplexArray:
        """The families of p, q_y and q_z, shape (3, 4, ...)."""
        count = 3 if order == -1 else 4

        def near(x: FloatArray, y: FloatArray, z: FloatArray, loads: FloatArray) -> ComplexArray:
            corner = Corner(x, y, z)
            each = [corner.bilinear(order, *slopes).sum(axis=-1) if slopes.any() else None for slopes in loads]
            zero = np.zeros((count, len(x)), dtype=np.complex128)
            return np.stack([zero if one is None else one / (2 * np.pi) for one in each])

        def far(x: FloatArray, y: FloatArray, z: FloatArray, loads: FloatArray) -> ComplexArray:
            family = point_family(order, x, y + 1j * z)
            return np.stack([(one * family).sum(axis=-1) for one in loads])

        return self._sum(x, y, z, near, far)[:, :count]

    def transforms(self, x: FloatArray, y: FloatArray, z: FloatArray) -> LocalTransforms:
        """As `local_transforms_of`."""
        (p, a, b), (dp, da, db) = self._families(0, x, y, z), self._families(1, x, y, z)
        q, dq = a + 1j * b, da + 1j * db
        sq = np.asarray(q[0] + 0.5 * x * dq[0])
        if self.node_shear.any():

            def near(x: FloatArray, y: FloatArray, z: FloatArray, loads: FloatArray) -> ComplexArray:
                return np.full((3, 1, len(x)), np.nan, dtype=np.complex128)

            def far(x: FloatArray, y: FloatArray, z: FloatArray, loads: FloatArray) -> ComplexArray:
                return np.stack([(one * point_core(x, y + 1j * z)).sum(axis=-1) for one in loads])[:, None]

            core = self._sum(x, y, z, near, far)[:, 0]
            sq = np.where(np.isnan(core[0]), sq, core[1] + 1j * core[2])
        return LocalTransforms(p, dp, q, dq, a - 1j * b, da - 1j * db, sq, np.zeros((2, *sq.shape), dtype=complex))

    def potentials(self, x: FloatArray, y: FloatArray, z: FloatArray) -> Potentials:
        """As `local_potentials_of`, at `x`, `y`, `z`."""
        p, a, b = -self._families(-1, x, y, z)
        return Potentials(p, a + 1j * b, a - 1j * b, np.zeros_like(p[0]))

    def singular(self, y: FloatArray, z: FloatArray) -> npt.NDArray[np.bool_]:
        """As `LocalContact.singular`: the border, where it does not vanish."""
        low, high = self.support
        on_y = ((y == low[..., 0]) | (y == high[..., 0])) & (low[..., 1] <= z) & (z <= high[..., 1])
        on_z = ((z == low[..., 1]) | (z == high[..., 1])) & (low[..., 0] <= y) & (y <= high[..., 0])
        border = on_y | on_z
        if not border.any():
            return np.asarray(border)
        jumps = (self.pressure(y, z) != 0) | (self.shear(y, z) != 0).any(axis=-1)
        return np.asarray(border & jumps)

    def expand(self, axes: int = 1) -> Self:  # noqa: D102
        shape = (*self.shape, *(1,) * axes)
        pressure = self.node_pressure.reshape(*shape, *self.node_pressure.shape[-2:])
        return self.altered(node_pressure=pressure, node_shear=self.node_shear.reshape(*pressure.shape, 2))


def _summed(kernel: Kernel, at: list[FloatArray], nodes: Sequence[FloatArray], loads: FloatArray) -> ComplexArray:
    """The kernel over all nodes (last axis), block by block; nodes without a load are left out."""
    used = np.flatnonzero(loads.reshape(-1, loads.shape[-1]).any(axis=0))
    step, total = max(1, _BLOCK // len(at[0])), None
    for first in range(0, max(used.size, 1), step):
        some = used[first : first + step]
        part = kernel(at[0], at[1] - nodes[0][some], at[2] - nodes[1][some], loads[..., some])
        total = part if total is None else total + part
    return np.asarray(total)


def _gauss(nodes: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Gauss's points and weights on all stretches between nodes."""
    t, w = np.polynomial.legendre.leggauss(count)
    half, middle = 0.5 * np.diff(nodes)[:, None], 0.5 * (nodes[1:] + nodes[:-1])[:, None]
    return (middle + half * t).reshape(-1), (half * w).reshape(-1)


def _moments(nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Integrals over each node's hat of 1 and of t."""
    t, w = _gauss(nodes, 2)
    hats = _hats(nodes, t)
    return w @ hats, (w * t) @ hats


def _hats(nodes: FloatArray, at: FloatArray) -> FloatArray:
    """Weights of the nodes in the interpolation `at` positions, shape (..., n); 0 outside."""
    gaps, t = np.diff(nodes), np.asarray(at)[..., None]
    rising, falling = (t - nodes[:-1]) / gaps, (nodes[1:] - t) / gaps
    inside = (nodes[:-1] <= t) & ((t < nodes[1:]) | ((t == nodes[-1]) & (nodes[1:] == nodes[-1])))
    out = np.zeros((*np.shape(at), nodes.size))
    out[..., :-1] += np.where(inside, falling, 0.0)
    out[..., 1:] += np.where(inside, rising, 0.0)
    return out


def _hat_spectra(nodes: FloatArray, k: FloatArray) -> ComplexArray:
    """Fourier transforms of the nodes' hats at `k`, shape (..., n)."""
    h, middle, wave = 0.5 * np.diff(nodes), 0.5 * (nodes[1:] + nodes[:-1]), k[..., None]
    even, odd = np.sinc(wave * h / np.pi), spherical_j1(np.asarray(wave * h))
    shift = h * np.exp(-1j * wave * middle)
    out = np.zeros((*k.shape, nodes.size), dtype=np.complex128)
    out[..., :-1] += shift * (even + 1j * odd)
    out[..., 1:] += shift * (even - 1j * odd)
    return out
