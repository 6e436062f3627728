"""What the compiled loop of a free drag on an area wants: columns of pressure and drags, and its work."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from .hats import COARSE, LANES, REGISTERS, Hats
from .levels import Level, level_of
from .prior import Membrane

__all__ = ["FreeArea"]

_ROOM = 128
"""Elements not out for which there is room at first."""

_Work = tuple[Any, ...]


class FreeArea(NamedTuple):
    """All that is worked out once for the sensors that can be used."""

    sensors: FloatArray
    limits: FloatArray
    basis: npt.NDArray[np.float32]  # U^T, (n, n)
    squares: FloatArray  # S^2, (n,)
    spread: npt.NDArray[np.float32]  # C A^T of each height at the coarse nodes, (3, coarse m, n)
    few: npt.NDArray[np.int64]  # coarse elements along y and z
    level: Level
    idle: list[_Work]  # kept from call to call; each thread takes its own

    @classmethod
    def of(cls, sensors: FloatArray, limits: FloatArray, hats: Hats, prior: Membrane, least_force: float) -> FreeArea:
        """Of the readings of the used sensors, whitened; the drags' are those of the friction's share of a Pa."""
        (ny, nz), friction = prior.shape, float(limits[1])
        scales = (1.0, friction, friction)
        at = (np.arange(ny // COARSE)[:, None] * COARSE + 1) * nz + np.arange(nz // COARSE) * COARSE + 1
        gram, spread = np.zeros(2 * (hats.kind.size,)), []
        for i, scale in enumerate(scales):
            columns = scale * hats.columns(i)
            wide = prior.applied(columns)
            gram += columns.T @ wide
            spread.append(wide[at.reshape(-1)].astype(np.float32))
        squares, vectors = np.linalg.eigh(0.5 * (gram + gram.T))
        pull = least_force * float(np.linalg.norm(hats.columns(0), axis=1).max())
        level = level_of(hats, 3, prior, pull, COARSE, friction)
        scaled = np.ascontiguousarray(level.parts * np.array(scales)[:, None])
        return cls(
            sensors, limits, vectors.T.astype(np.float32), np.maximum(squares, 0.0), np.stack(spread),
            np.array([ny // COARSE, nz // COARSE]), level._replace(parts=scaled), [],
        )  # fmt: skip

    def fill(self, readings: FloatArray, y: FloatArray, z: FloatArray, out: FloatArray) -> None:
        """Fill `out`, a row for each frame; y, z: the inner nodes."""
        from ._free_kernel import map_free_frames

        *numbers, level, idle = self
        try:
            work = idle.pop()
        except IndexError:
            work = self._work(_ROOM)
        done = 0
        while (
            done := map_free_frames(done, readings, *numbers, tuple(level), y, z, work, out)
        ) < len(readings):  # fmt: skip
            work = self._work(2 * len(work[7]) // 3)
        idle.append(work)

    def _work(self, room: int) -> _Work:
        """Arrays that the compiled loop fills (`_free_parts.py`), with room for so many elements."""
        level, total, sensors = self.level, self.level.cost.size, self.squares.size
        room = min(room, total)
        rows = np.full(total + 1, -1)
        rows[-1] = 0
        return (
            np.empty((3, total)), np.empty((3, total)), np.zeros(total, dtype=np.int8), np.zeros((2, total)),
            np.zeros(total), np.empty(sensors), rows, np.empty((3 * room, sensors)), np.empty(2 * (3 * room,)),
            np.empty(2 * (3 * room,)), np.empty(total, dtype=np.int64), np.empty(total + 1, dtype=np.int64),
            np.empty(3 * total), np.empty((3, total)), np.empty((3, total)), level.parts.astype(np.float32),
            np.empty(level.gain.size, dtype=np.float32), np.empty(LANES * REGISTERS, dtype=np.float32),
            np.empty(total), np.empty((3, total)), np.empty((3, total)),
        )  # fmt: skip
