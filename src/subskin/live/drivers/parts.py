"""What formats are made of: sums behind bytes, lines, and the counters and clocks of devices."""

from __future__ import annotations

import binascii
import zlib
from collections.abc import Callable
from functools import reduce
from operator import xor
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["CHECKS", "Checksum", "Clock", "Counter", "Splitter"]


class Checksum(NamedTuple):
    """A check: its width in bytes, and what it makes of the bytes."""

    size: int
    of: Callable[[bytes], int]


def _modbus_table() -> list[int]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0xA001 if byte & 1 else 0)
        table.append(byte)
    return table


_MODBUS = _modbus_table()


def _modbus(data: bytes) -> int:
    value = 0xFFFF
    for byte in data:
        value = value >> 8 ^ _MODBUS[(value ^ byte) & 0xFF]
    return value


CHECKS = {
    "sum8": Checksum(1, lambda data: sum(data) & 0xFF),
    "xor8": Checksum(1, lambda data: reduce(xor, data, 0)),
    "sum16": Checksum(2, lambda data: sum(data) & 0xFFFF),
    "crc16_xmodem": Checksum(2, lambda data: binascii.crc_hqx(data, 0)),
    "crc16_ccitt": Checksum(2, lambda data: binascii.crc_hqx(data, 0xFFFF)),
    "crc16_modbus": Checksum(2, _modbus),
    "crc32": Checksum(4, zlib.crc32),
}
"""The checks by name. CRC-16/XMODEM, /CCITT-FALSE (IBM-3740) and /MODBUS, and CRC-32 as of Ethernet and zip."""


class Splitter:
    r"""Cuts bytes at the ends of lines.

    Parameters
    ----------
    longest : int
        Bytes of a line at most; of a longer one nothing is kept.

    Examples
    --------
    >>> splitter = Splitter(longest=4)
    >>> splitter.feed(b"ab\ncdefg\nh"), splitter.feed(b"i\n")
    ([b'ab', None], [b'hi'])
    """

    def __init__(self, longest: int) -> None:
        self._longest = longest
        self.reset()

    def reset(self) -> None:
        """Forget the line that is unfinished."""
        self._kept, self._long = b"", False

    def feed(self, data: bytes) -> list[bytes | None]:
        """The lines that end in `data`; None for one that is too long."""
        *whole, rest = (self._kept + data).split(b"\n")
        lines = [None if len(line) > self._longest else line for line in whole]
        if lines and self._long:
            lines[0] = None
        self._long = (self._long and not lines) or len(rest) > self._longest
        self._kept = b"" if self._long else rest
        return lines


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
