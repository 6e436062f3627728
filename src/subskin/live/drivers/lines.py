"""Lines of text with numbers: what a sketch prints over a serial port."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ... import _check
from ...errors import InvalidValueError
from ..frames import DeviceFrames
from .base import Driver
from .parts import CHECKS, Checksum, Clock, Counter, Splitter

__all__ = ["Lines", "TakkTile"]

_LONGEST = 1 << 16
_TICKS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
_ALLOWED = b"0123456789+-.eE"
_PARTED = bytes(
    byte if byte in _ALLOWED or byte in b"naNA" else 32 if byte in b"[],;\t\r " else ord("?") for byte in range(256)
)
"""What separates numbers becomes a space; what no number has, a letter that makes none."""


class Lines(Driver, name="lines"):
    r"""A line of numbers for each frame, between commas, semicolons, tabs, spaces or brackets.

    A line with a word, or with another count of numbers, is no frame: a header, what a board says when it starts, a
    line that lost bytes. The first line after opening is left out, for its beginning may be missing. A digit that
    was changed or lost leaves a number: only `check` sees that.

    Parameters
    ----------
    columns : sequence of str, optional
        Names of the numbers of a line, in their order; those of `time` and `counter` among them.
    sensors : int, optional
        Instead of `columns`: how many numbers a line has, named c0, c1, ...
    time : str
        The column that holds the time of the device; "" for none.
    tick : {"s", "ms", "us"}
        Unit of that time.
    counter : str
        The column that holds the number of the frame; "" for none.
    begin, end : str
        What each line begins and ends with; a line that lacks it is no frame. The first line counts where `begin` is
        given.
    check : str
        "" or one of `subskin.live.drivers.CHECKS`: a line ends with * and the check of all bytes before it, in
        hexadecimal digits. "xor8" is that of NMEA 0183; it does not see a digit that is doubled, "crc16_ccitt" does.

    Raises
    ------
    InvalidValueError
        No columns, a column named twice or not there, an unknown tick or check.

    Examples
    --------
    >>> board = Lines(columns=["t_us", "p0", "p1"], time="t_us", tick="us")
    >>> frames = board.feed(b"Barometers ready\r\n1000,101325,101330\r\n2000,101326,1013")
    >>> frames.values.tolist(), frames.device_time.tolist()
    ([[101325.0, 101330.0]], [0.001])
    >>> board.feed(b"29\r\n").values.tolist()
    [[101326.0, 101329.0]]
    """

    def __init__(
        self,
        columns: Sequence[str] | None = None,
        *,
        sensors: int | None = None,
        time: str = "",
        tick: str = "s",
        counter: str = "",
        begin: str = "",
        end: str = "",
        check: str = "",
    ) -> None:
        if (columns is None) == (sensors is None):
            rule = "the numbers of a line are named by one of the two"
            raise InvalidValueError("lines with both or none of columns and sensors", rule, "sensors = 5")
        if not (columns is None or isinstance(columns, list | tuple)):
            raise InvalidValueError(f"columns = {columns!r}", "a list of names is needed", 'columns = ["t", "p0"]')
        names = _numbered(sensors) if columns is None else tuple(columns)
        if not all(isinstance(name, str) and name for name in names) or len(set(names)) != len(names):
            raise InvalidValueError(f"columns = {names}", "each column has a name of its own", 'columns = ["t", "p0"]')
        for key, name in (("time", time), ("counter", counter)):
            if name and name not in names:
                raise InvalidValueError(f'{key} = "{name}"', "it is none of the columns", f"one of {', '.join(names)}")
        _check.choice("tick", tick, _TICKS)
        _check.choice("check", check, ("", *CHECKS), 'check=""')
        self._at = {name: i for i, name in enumerate(names)}
        self._time, self._counter = self._at.get(time), self._at.get(counter)
        self._values = [i for i in range(len(names)) if i not in (self._time, self._counter)]
        if not self._values:
            raise InvalidValueError(f"columns = {names}", "one of them at least is a channel", 'columns = ["t", "p0"]')
        self.channels = tuple(names[i] for i in self._values)
        self._tick, self._size = _TICKS[tick], len(names)
        self._begin, self._end, self._check = begin.encode(), end.encode(), CHECKS.get(check)
        self._splitter, self._count, self._clock = Splitter(_LONGEST), Counter(), Clock(self._tick, 1 << 32)
        self.reset()

    def reset(self) -> None:  # noqa: D102
        self._splitter.reset()
        self._skips = not self._begin
        self._count.reset()
        self._clock.reset()

    def feed(self, data: bytes) -> DeviceFrames:  # noqa: D102
        rows, bad = [], 0
        for line in self._splitter.feed(data):
            skipped, self._skips = self._skips, False
            row = None if line is None or skipped else self._row(line)
            if row is not None:
                rows.append(row)
            elif not skipped and (line is None or line.strip()):
                bad += 1
        table = np.array(rows, dtype=np.float64).reshape(len(rows), self._size)
        time = np.full(len(rows), np.nan) if self._time is None else self._times(table[:, self._time])
        number, lost = np.full(len(rows), -1), 0
        if self._counter is not None:
            number = table[:, self._counter].astype(np.int64)
            lost = self._count.lost(number)
        return DeviceFrames.made(table[:, self._values], time, number, lost, bad)

    def _times(self, counts: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Whole counts of ms or us run on where those of 32 bits, as micros() of a sketch has them, begin again."""
        whole = self._tick < 1 and (counts == np.floor(counts)).all() and (counts >= 0).all()
        return self._clock.time(counts) if whole and (counts < 2**32).all() else counts * self._tick

    def _row(self, line: bytes) -> list[float] | None:
        """The numbers of a line, or None where it is no frame."""
        line = line.strip(b"\r \t")
        if self._check is not None:
            line, _, told = line.rpartition(b"*")
            if told.upper() != _sum(self._check, line):
                return None
        if not (line.startswith(self._begin) and line.endswith(self._end)):
            return None
        words = line.translate(_PARTED).split()
        if len(words) != self._size:
            return None
        try:
            row = [float(word) for word in words]
        except ValueError:
            return None
        if any(math.isinf(value) for value in row):
            return None
        keys = [row[i] for i in (self._time, self._counter) if i is not None]
        if any(not 0 <= value < 2**62 for value in keys) or (
            self._counter is not None and row[self._counter] != int(row[self._counter])
        ):
            return None
        return row

    def encode(  # noqa: D102
        self, values: npt.ArrayLike, device_time: npt.ArrayLike | None = None, sequence: npt.ArrayLike | None = None
    ) -> bytes:
        table = self.rows(values)
        full = np.zeros((len(table), self._size))
        full[:, self._values] = table
        if self._time is not None and device_time is not None:
            full[:, self._time] = np.asarray(device_time) / self._tick
            if self._tick < 1:
                full[:, self._time] = np.rint(full[:, self._time])
        if self._counter is not None and sequence is not None:
            full[:, self._counter] = sequence
        lines = []
        for row in full.tolist():
            line = self._begin + ",".join(_written(value) for value in row).encode() + self._end
            lines.append(line + (b"" if self._check is None else b"*" + _sum(self._check, line)) + b"\r\n")
        return b"".join(lines)


class TakkTile(Lines, name="takktile"):
    r"""The Arduino of TakkTile: `[[327],[335]]` and the end of a line (robomechanics/takktile_arduino), in counts.

    Parameters
    ----------
    sensors : int
        Cells of the strip.

    Examples
    --------
    >>> TakkTile(sensors=3).feed(b"[[327],[335],[331]]\r\n").values.tolist()
    [[327.0, 335.0, 331.0]]
    """

    def __init__(self, sensors: int = 5) -> None:
        super().__init__(sensors=sensors, begin="[[", end="]]")


def _numbered(sensors: int | None) -> tuple[str, ...]:
    count = _check.whole("sensors", sensors, at_least=1, at_most=10_000, fix="sensors = 5")
    return tuple(f"c{i}" for i in range(count))


def _written(value: float) -> str:
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def _sum(check: Checksum, line: bytes) -> bytes:
    """The check of a line, in hexadecimal digits."""
    return b"%0*X" % (2 * check.size, check.of(line))
