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
        lost, last, size = 0, self._last, self._size
        for number in np.asarray(numbers, dtype=np.int64).tolist():
            gone = (number - last) % size - 1 if last >= 0 else 0
            lost += gone if 0 < gone < size // 2 else 0
            last = number
        self._last = last
        return lost


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
        self._last: float = -1
        self._turns = 0

    def time(self, counts: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Time of each count [s]; the counts follow those given before."""
        size, tick, times = self._size, self._tick, []
        for count in np.asarray(counts).tolist():
            back = self._last - count
            if back > 0:  # begun again at its end, or switched on again: then it has made no turns
                self._turns = self._turns + 1 if (size - back) * tick <= _TURN else 0
            self._last = count
            times.append((count + self._turns * size) * tick)
        return np.array(times, dtype=np.float64)
