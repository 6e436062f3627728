"""Counters and clocks of devices: what is lost, and time that runs on where a counter begins again."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["Clock", "Counter"]

_TURN = 10.0
"""A clock that goes back has begun again where it then lies at most so much [s] behind its end; else it was reset."""


class Counter:
    """Finds lost frames by the numbers that a device gives them.

    A number that goes back, or on by half its range, is that of a device that was switched on again: nothing is lost.

    Parameters
    ----------
    size : int, optional
        Numbers before it begins at 0 again.

    Examples
    --------
    >>> counter = Counter(256)
    >>> counter.lost([253, 254, 1]), counter.lost([2, 0])
    (2, 0)
    """

    def __init__(self, size: int = 1 << 63) -> None:
        self._size, self._last = size, -1

    def reset(self) -> None:
        """Forget the last number."""
        self._last = -1

    def lost(self, numbers: npt.ArrayLike) -> int:
        """How many are missing between the last number and these, and among these."""
        now = np.asarray(numbers, dtype=np.int64)
        if not now.size:
            return 0
        gone = np.diff(now, prepend=self._last if self._last >= 0 else now[0] - 1) - 1
        if self._size < 1 << 63:
            gone = (gone + 1) % self._size - 1
        self._last = int(now[-1])
        return int(gone[(gone > 0) & (gone < self._size // 2)].sum())


class Clock:
    """Time of a device whose counter has a range: it runs on where the counter begins at 0 again.

    Parameters
    ----------
    tick : float
        What one count is worth [s].
    size : int
        Counts before it begins at 0 again.

    Examples
    --------
    >>> clock = Clock(1e-6, 2**32)
    >>> clock.time([4294967000, 704]).tolist(), clock.time([1704]).tolist()
    ([4294.967, 4294.968], [4294.969])
    """

    def __init__(self, tick: float, size: int) -> None:
        self._tick, self._size = tick, size
        self.reset()

    def reset(self) -> None:
        """Forget the last count."""
        self._last, self._turns = -1, 0

    def time(self, counts: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Time of each count [s]; the counts follow those given before."""
        now = np.asarray(counts).astype(np.int64) if self._size <= 1 << 62 else np.asarray(counts)
        if not now.size or self._size > 1 << 62:
            return np.asarray(now * self._tick, dtype=np.float64)
        before = np.concatenate([[self._last if self._last >= 0 else now[0]], now[:-1]])
        turned = (now < before) & ((now - before + self._size) * self._tick <= _TURN)
        restarted = (now < before) & ~turned
        turns = self._turns + np.cumsum(turned)
        if restarted.any():  # the clock of a device that was switched on again begins with no turn
            at = np.maximum.accumulate(np.where(restarted, np.arange(len(now)), -1))
            turns = np.where(at >= 0, turns - turns[np.maximum(at, 0)], turns)
        self._last, self._turns = int(now[-1]), int(turns[-1])
        return np.asarray((now + turns * self._size) * self._tick, dtype=np.float64)
