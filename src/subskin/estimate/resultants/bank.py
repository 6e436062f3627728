"""Guesses of what presses, by position and size: what each makes the sensors read, and what readings tell of its load.

A guess is all pressures of about one size whose middles lie in one cell of the surface (`pressures.py`). Their readings
r and what is asked of them q - force, drag, first moments, torsion - scatter together. Guesses keep the second moments:
of r as C = U L U^T, of q with r as B, of q as V. With noise 1 and an amplitude s the best linear estimate of q is
s^2 B (s^2 C + 1)^-1 r, and its covariance is s^2 V - s^4 B (s^2 C + 1)^-1 B^T (docs/resultant.md).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...finger import Finger
from ...radial import tabulate_radial
from ...response import tabulate
from ..settle.uncertain import deeper_than, other_than
from .pressures import Tractions, tractions

__all__ = ["Bank", "bank_of"]

_SIZES = np.array([0.15, 0.4, 0.7, 1.0, 1.4, 1.9, 2.6, 3.5, 4.8])
"""Half sizes in depths of the shallowest sensor."""
_FINE, _COARSE = 0.2, 0.5
"""Steps of the lattice: in half sizes, at least this many depths, and at most so many depths.

Point loads half a depth apart read as an even pressure does, to exp(-4 pi)."""
_CELL, _BEYOND = 0.35, 1.0
"""Sides of a cell, in means of the depth and the half size, and depths beyond the sensors where the last one lies."""
_DRAWN = 120
_SHIFT = 1e-3
"""Of the steps, by which slopes are told."""
_KEPT = 1e-11
"""Share of the largest second moment of the readings below which one is left out: readings are no more precise."""
_MOST = 64
"""Directions in which the readings of a guess scatter."""
_MOST_NUMBERS = 2e7
"""Of a bank: 160 MB. Where there are more sensors cells are larger, up to so many times."""
_WIDEST = 100.0
_TORSION = 5
"""Which question of an area asks for it."""


class Bank(NamedTuple):
    """Guesses (g,), the sensors (n,) in units of noise, the quantities asked (q,).

    first (n, g): the unit vector along which a guess reads most, for a force that presses, in short numbers for a quick
    look; basis (g, k, n) and size (g, k): U and L, the largest first, 0 where there are fewer; told (g, k, q): B U / L;
    spread (g, q, q): V; chance (g,): logarithm of the cell's area.
    """

    first: npt.NDArray[np.float32]
    basis: FloatArray
    size: FloatArray
    told: FloatArray
    spread: FloatArray
    chance: FloatArray


def bank_of(finger: Finger, pattern: npt.NDArray[np.bool_], noise: FloatArray, extent: bool = False) -> Bank:
    """The guesses for the sensors of `pattern` (n,), each with such a `noise` [reading], shape (n,).

    What tolerances leave open of the finger scatters the readings of a guess too. With `extent`, of an area, the normal
    force's second moments, of y y, y z and z z, are asked as well.
    """
    dim = 2 if finger.array.on_area else 1
    depth, drawn = float(np.asarray(finger.array.depth).min()), _Fields(finger, pattern, noise, extent)
    parts: list[tuple[FloatArray, ...]] = []
    chances = []
    for step, cell, some, centres in _classes(finger, dim, depth, noise.size):
        # of each cell, nodes and components by sensors and questions; loads of all pressures, by nodes and components
        loads = some.values.reshape(-1, some.values.shape[2] * (dim + 1)) / np.sqrt(len(some.values))
        for one in drawn.of(some, centres, step):
            parts.append(_factored(drawn.moments(loads @ one), noise.size))
            chances.append(dim * np.log(cell * step))
    first, *rest = (np.ascontiguousarray(np.stack(each)) for each in zip(*parts, strict=True))
    return Bank._make((np.ascontiguousarray(first.T.astype(np.float32)), *rest, np.array(chances)))


def _classes(finger: Finger, dim: int, depth: float, n: int) -> Iterator[tuple[float, int, Tractions, FloatArray]]:
    """Of each size: step of its lattice [m], steps of a cell, its pressures, and the cells' middles (c, d)."""
    points = finger.array.points[:, :dim]
    low, high = points.min(axis=0) - _BEYOND * depth, points.max(axis=0) + _BEYOND * depth
    wider = 1.0
    while True:
        found = []
        for size in _SIZES:
            step = depth * min(_FINE * max(size, 1.0), _COARSE)
            cell = max(round(wider * _CELL * depth * np.sqrt(0.5 + 0.5 * size**2) / step), 1)
            axes = []
            for a, b in zip(low, high, strict=True):
                count = int(np.ceil((b - a) / (cell * step)))
                axes.append(0.5 * (a + b) + cell * step * (np.arange(count) - 0.5 * (count - 1)))
            centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, dim)
            found.append((float(size), step, cell, centres))
        if sum(len(centres) for *_, centres in found) * n * min(n, _MOST) <= _MOST_NUMBERS or wider > _WIDEST:
            break
        wider *= 1.25
    for size, step, cell, centres in found:
        yield step, cell, tractions(size * depth / step, cell, dim, _DRAWN), centres


class _Fields:
    """What sensors read under unit forces, of a finger and of such as it may be instead, in units of the noise."""

    def __init__(self, finger: Finger, pattern: npt.NDArray[np.bool_], noise: FloatArray, extent: bool) -> None:
        self._extent = extent
        self._finger, self._pattern, self._noise, self._told = finger, pattern, noise, finger.tolerances
        self._others = [] if self._told is None else [deeper_than(finger), other_than(finger)[0]]
        if self._told is not None:
            sensors = len(finger.array)
            self._gain = self._told.of("gain", sensors)[pattern]
            self._moved = (self._told.of("position", sensors) * np.asarray(finger.array.depth))[pattern]

    def of(self, some: Tractions, centres: FloatArray, step: float) -> Iterator[FloatArray]:
        """At the nodes of each cell, (w (d + 1), n + q); with tolerances n more for each that may be off."""
        dim = centres.shape[1]
        whole = np.round((centres - centres[0]) / step).astype(np.intp)
        nodes = some.nodes.astype(np.intp)
        least, shape = nodes.min(axis=0), np.ptp(nodes, axis=0) + np.ptp(whole, axis=0) + 1
        lattice = np.stack(np.meshgrid(*(np.arange(k) for k in shape), indexing="ij"), axis=-1).reshape(-1, dim)
        at = centres.min(axis=0) + step * (lattice + least)
        base = self._read(self._finger, at)
        every = [base, _asked(at, self._extent)]
        if self._told is not None:
            every += [self._read(other, at) - base if other is not None else 0.0 * base for other in self._others]
            shift = _SHIFT * step
            for move in shift * np.eye(dim):
                slope = (self._read(self._finger, at + move) - self._read(self._finger, at - move)) / (2 * shift)
                every.append(slope * self._moved)
        where = np.ravel_multi_index(tuple((whole[:, None] + nodes - least).T), tuple(shape)).T
        table = np.concatenate(every, axis=2)
        for one in where:
            yield table[one].reshape(len(nodes) * (dim + 1), -1)

    def _read(self, finger: Finger, at: FloatArray) -> FloatArray:
        """At positions (m, d), (m, d + 1, n)."""
        if at.shape[1] > 1:
            away = float(np.abs(at[:, None] - finger.array.points).max())
            every = tabulate_radial(finger, 1.5 * away)(at)
        else:
            more, y = float(np.asarray(finger.array.depth).min()), at[:, 0]
            low, high, about = float(y.min()) - more, float(y.max()) + more, finger.skin.period
            if high - low > about:  # once about a round finger
                middle = float(np.mean(np.asarray(finger.array.y)))
                low, high = middle - 0.5 * about, middle + 0.5 * about
                y = low + np.mod(y - low, about)
            every = tabulate(finger, (low, high))(y)
        return np.asarray(np.swapaxes(every[:, self._pattern] / self._noise[:, None], 1, 2))

    def moments(self, loads: FloatArray) -> FloatArray:
        """Second moments of readings and questions, of loads each a deviation large, (n + q, n + q)."""
        n, told = self._noise.size, self._told
        dim = 2 if self._finger.array.on_area else 1
        first = n + 2 * dim + 1 + (dim > 1) + 3 * self._extent
        out: FloatArray = np.asarray(loads[:, :first].T @ loads[:, :first])
        if told is None:
            return out
        deeper, other, *slopes = np.split(loads[:, first:], 2 + dim, axis=1)
        shared, own = told.common, 1 - told.common
        added = other.T @ other
        for part in (loads[:, :n] * self._gain, deeper):
            added += shared * part.T @ part + own * np.diag((part**2).sum(axis=0))
        out[:n, :n] += added + np.diag(sum((part**2).sum(axis=0) for part in slopes))
        return out


def _asked(at: FloatArray, extent: bool) -> FloatArray:
    """Of unit forces at positions (m, d): force and drag, the normal force's first moments, torsion, (m, d + 1, q).

    With `extent` its second moments too.
    """
    dim = at.shape[1]
    out = np.zeros((len(at), dim + 1, 2 * dim + 1 + (dim > 1) + 3 * extent))
    out[:, range(dim + 1), range(dim + 1)] = 1.0
    out[:, 0, dim + 1 : 2 * dim + 1] = at
    if dim > 1:
        out[:, 1, _TORSION], out[:, 2, _TORSION] = -at[:, 1], at[:, 0]
    if extent:
        y, z = at.T
        out[:, 0, _TORSION + 1 :] = np.stack([y * y, y * z, z * z], axis=-1)
    return out


def _factored(moments: FloatArray, n: int) -> tuple[FloatArray, ...]:
    """Of second moments (n + q, n + q) the first direction (n,), and basis, size, told and spread of a `Bank`."""
    if n <= _MOST:
        size, basis = np.linalg.eigh(moments[:n, :n])
    else:
        from scipy.linalg import eigh

        size, basis = eigh(moments[:n, :n], subset_by_index=[n - _MOST, n - 1])
    size, basis = size[::-1], basis.T[::-1]
    keep = size > _KEPT * size[0]
    told = np.where(keep[:, None], basis @ moments[:n, n:], 0.0) / np.where(keep, size, 1.0)[:, None]
    return basis[0] * np.sign(told[0, 0]), basis, np.where(keep, size, 0.0), told, moments[n:, n:]
