"""What sensors read of hats on a lattice, kept once for all sensors that stand alike to the lattice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen

__all__ = ["AT_ONCE", "LANES", "REGISTERS", "Hats"]

AT_ONCE, LANES, REGISTERS = 2, 8, 5
"""Sensors that a compiled loop goes through at once, numbers in a register, and registers it fills for each sensor."""


@dataclass(frozen=True, eq=False)
class Hats(Frozen):
    """Readings of sensors per Pa of the hats of a lattice, which along a row of sensors is one line.

    Sensors that stand alike to the lattice read one table, each from a corner of its own. A grid of sensors so needs
    one table of twice the lattice's sides, and not a number for each hat and sensor.

    Parameters
    ----------
    shape : (int, int)
        Hats along y and along z.
    tables : tuple of ndarray, shape (2 or 3, rows, columns) each
        Readings per Pa of pressure and of drag along y and, on an area, along z.
    kind : ndarray of int, shape (n,)
        Which table a sensor reads.
    corner : ndarray of int, shape (n, 2)
        Row and column of its table at which the first hat is.
    gain : ndarray, shape (n,)
        What the table is multiplied by.
    """

    shape: tuple[int, int]
    tables: tuple[FloatArray, ...]
    kind: npt.NDArray[np.int64]
    corner: npt.NDArray[np.int64]
    gain: FloatArray

    def select(self, sensors: npt.NDArray[np.bool_], scale: FloatArray) -> Hats:
        """Those of some sensors (n,), each of their readings times its `scale`."""
        return Hats(
            self.shape, self.tables, self.kind[sensors], self.corner[sensors], self.gain[sensors] * scale
        )  # fmt: skip

    def columns(self, component: int) -> FloatArray:
        """All readings of a component, 0 the pressure, 1 and 2 the drags, shape (ny nz, n)."""
        ny, nz = self.shape
        out = np.empty((ny, nz, self.kind.size))
        for i, (kind, (y, z)) in enumerate(zip(self.kind.tolist(), self.corner.tolist(), strict=True)):
            out[..., i] = self.gain[i] * self.tables[kind][component, y : y + ny, z : z + nz]
        return out.reshape(ny * nz, -1)

    def among(self, chosen: npt.NDArray[np.intp], components: int) -> FloatArray:
        """Readings of the first components of the `chosen` hats (k,), shape (components, k, n)."""
        y, z = np.divmod(chosen, self.shape[1])
        out = np.empty((components, chosen.size, self.kind.size))
        for kind, table in enumerate(self.tables):
            sensors = np.flatnonzero(self.kind == kind)
            rows, columns = (at[:, None] + self.corner[sensors, i] for i, at in enumerate((y, z)))
            out[:, :, sensors] = table[:components, rows, columns]
        return out * self.gain

    def coarse(self, times: tuple[int, int]) -> Hats:
        """Those of hats so many times as wide along y and along z: a wide hat is a sum of narrow ones."""
        wide = [_widened(_widened(table, 1, times[0]), 2, times[1]) for table in self.tables]
        steps, rest = np.divmod(self.corner, times)
        which, kind = np.unique(np.column_stack([self.kind, rest]), axis=0, return_inverse=True)
        tables = tuple(
            np.ascontiguousarray(wide[k][:, y :: times[0], z :: times[1]]) for k, y, z in which.tolist()
        )  # fmt: skip
        shape = (self.shape[0] // times[0], self.shape[1] // times[1])
        return Hats(shape, tables, kind.reshape(-1), steps, self.gain)

    def to_either_side(self, friction: float) -> Hats:
        """Of a row, with all the drag that friction holds towards +y, and on a line of their own towards -y."""
        tables = tuple(
            np.stack([table[0, 0] + friction * table[1, 0], table[0, 0] - friction * table[1, 0]])[None]
            for table in self.tables
        )
        return Hats((2, self.shape[1]), tables, self.kind, self.corner, self.gain)

    def flat(self, components: int) -> tuple[FloatArray, npt.NDArray[np.int64], int]:
        """The first components of all tables in a line (components, L), where each sensor's begins, and rows' length.

        Sensor i reads gain_i line[start_i + y length + z] of the hat (y, z).
        """
        length = max(table.shape[2] for table in self.tables)
        rows = [np.pad(table[:components], ((0, 0), (0, 0), (0, length - table.shape[2]))) for table in self.tables]
        begin = length * np.cumsum([0, *(table.shape[1] for table in rows)])
        # rows are read in whole registers
        line = np.concatenate(
            [*(table.reshape(components, -1) for table in rows), np.zeros((components, LANES))], axis=1
        )
        return line, begin[self.kind] + self.corner[:, 0] * length + self.corner[:, 1], length


def _widened(table: FloatArray, axis: int, times: int) -> FloatArray:
    """Readings of hats so many times as wide along an axis, from the first position with a whole one on it."""
    count = table.shape[axis] - 2 * (times - 1)
    shares = (1 - abs(k - times + 1) / times for k in range(2 * times - 1))
    parts = (s * np.take(table, np.arange(k, k + count), axis) for k, s in enumerate(shares))
    return np.asarray(sum(parts))
