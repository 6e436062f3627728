"""The last minutes of a stream, in memory that does not grow."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .batch import Batch

__all__ = ["RingBuffer"]

_MOST = 64 << 20
"""Bytes that it takes at most: where frames are many and wide, it reaches less far back."""
_FIRST = 1024
"""Frames for which there is room at the beginning; the room doubles as it is needed."""


class RingBuffer:
    """Keeps times, readings, estimates and whether the skin was free, of the last frames.

    Parameters
    ----------
    seconds : float, optional
        How far back it reaches [s]; less where that takes more than 64 MB.

    Examples
    --------
    >>> ring = RingBuffer(seconds=2.0)
    >>> for k in range(5):
    ...     ring.put(time=np.array([float(k)]), readings=np.full((1, 3), k))
    >>> ring.last()["time"].tolist(), ring.last(1.0)["readings"].shape
    ([2.0, 3.0, 4.0], (2, 3))
    """

    def __init__(self, seconds: float = 120.0) -> None:
        self.seconds = _check.scalar("seconds", seconds, unit="s", above=0.0)
        self._columns: dict[str, npt.NDArray[Any]] = {}
        self._at = self._count = 0

    def __len__(self) -> int:
        return self._count

    def take(self, batch: Batch) -> None:
        """Keep the frames of a batch.

        Parameters
        ----------
        batch : Batch
            What came out of a chain.
        """
        if len(batch) and batch.found is not None:
            table = {} if not hasattr(batch.found, "table") else {"found": batch.found.table}
            self.put(time=batch.time, readings=batch.readings, free=batch.free, status=batch.found.status, **table)

    def put(self, **columns: npt.NDArray[Any]) -> None:
        """Keep frames.

        Parameters
        ----------
        **columns : ndarray, shape (n, ...)
            By their names, the same each time; `time` [s] is one of them.
        """
        frames = len(columns["time"])
        if not self._columns:
            self._columns = {n: np.empty((_FIRST, *v.shape[1:]), v.dtype) for n, v in columns.items()}
        while self._count + frames > self._room and self._grow(float(columns["time"][-1])):
            pass
        room = self._room
        kept = min(frames, room)
        at = self._at % room
        index = slice(at, at + kept) if at + kept <= room else (at + np.arange(kept)) % room
        for name, values in columns.items():
            self._columns[name][index] = values[frames - kept :]
        self._at = (self._at + kept) % room
        self._count = min(self._count + kept, room)

    def last(self, seconds: float | None = None) -> dict[str, npt.NDArray[Any]]:
        """The last frames, oldest first, by the names of the columns; copies.

        Parameters
        ----------
        seconds : float, optional
            Of how long [s]; all of them if left out.
        """
        if not self._columns:
            return {}
        order = (self._at - self._count + np.arange(self._count)) % self._room
        time = self._columns["time"][order]
        reach = self.seconds if seconds is None else seconds
        order = order[np.searchsorted(time, time[-1] - reach) if time.size else 0 :]
        return {name: values[order] for name, values in self._columns.items()}

    @property
    def _room(self) -> int:
        return len(self._columns["time"])

    def _grow(self, now: float) -> bool:
        """Twice the room, unless the oldest frame is old enough to leave, or memory would take too much."""
        oldest = self._columns["time"][(self._at - self._count) % self._room] if self._count else now
        size = sum(values.nbytes for values in self._columns.values())
        if now - oldest > self.seconds or 2 * size > _MOST:
            return False
        order = (self._at - self._count + np.arange(self._count)) % self._room
        for name, values in self._columns.items():
            wide = np.empty((2 * len(values), *values.shape[1:]), values.dtype)
            wide[: order.size] = values[order]
            self._columns[name] = wide
        self._at = self._count
        return True
