"""Frames of one length, found by marks and a check in bytes that may be damaged.

What is handed on, and why it is no false frame (docs/devices.md has it in words):

- With a check of 16 bits or more: the marks are in their positions and the check is right.
- Otherwise the frame lies between two marks, a frame's length apart, with no other mark in it. It is whole then, unless
  the line changed a byte that is no mark, or lost as many bytes in the frame as it added: no format without a check can
  tell. A mark may also occur in the data; such a frame is handed on only when the next frame's marks are right too.
- When the position of frames is not known (at the start, after damage) two frames have to have right marks, and no
  other position may explain the bytes as well.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .checks import Bytes, Checksum

__all__ = ["Framer", "Shape"]

_WINDOW = 8
"""Frames over which a mark in the data is compared with the true one, before the first of them is given up."""

_SLAB = 1 << 15
"""Bytes that are looked through at a time."""

Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Shape:
    """How a frame is marked: its length, the marks at its start and end, its check.

    Parameters
    ----------
    length : int
        Bytes of a frame, all told.
    start, end : bytes
        Marks; one of the two may be b"".
    check : Checksum or None
        The check that lies before the end mark.
    covers : int
        First byte of those that the check is made of; the last is before the check.
    big : bool
        The check has its high byte first.
    plausible : callable, optional
        Which rows of bytes hold values that the device can send; asked only where marks leave two positions open.
    """

    length: int
    start: bytes = b""
    end: bytes = b""
    check: Checksum | None = None
    covers: int = 0
    big: bool = False
    plausible: Callable[[Bytes], Flags] | None = None

    @property
    def strong(self) -> bool:
        """Whether the check alone makes a frame."""
        return self.check is not None and self.check.size >= 2

    @property
    def tail(self) -> bytes:
        """The mark behind the data of a frame: without an end mark the start of the next, where no check is strong."""
        return self.end or (b"" if self.strong else self.start)

    @property
    def seen(self) -> int:
        """Bytes from a frame's start that have to be there to judge it."""
        return self.length + (0 if self.end or self.strong else len(self.start))


class Framer:
    r"""Cuts bytes into frames of one length.

    Parameters
    ----------
    shape : Shape
        How a frame is marked.

    Examples
    --------
    >>> framer = Framer(Shape(4, end=b"\r\n"))
    >>> rows, bad = framer.feed(b"x\r\nab\r\ncd\r\ne")
    >>> [row.tobytes() for row in rows], bad
    ([b'ab\r\n', b'cd\r\n'], 0)
    """

    def __init__(self, shape: Shape) -> None:
        self.shape = shape
        self._marks = [(at, byte) for at, byte in enumerate(shape.start)]
        self._marks += [(shape.seen - len(shape.tail) + at, byte) for at, byte in enumerate(shape.tail)]
        self.reset()

    def reset(self) -> None:
        """Forget what is unfinished."""
        self._kept, self._lead = b"", 0
        self._locked, self._fresh, self._joining = False, True, True
        self._skipped = self._told = 0

    def feed(self, data: bytes) -> tuple[Bytes, int]:
        """The frames that are complete with `data`, shape (n, length), and how many were found broken."""
        found, bad = [np.empty((0, self.shape.length), np.uint8)], 0
        for first in range(0, len(data), _SLAB):
            bad += self._feed(data[first : first + _SLAB], found)
        return np.concatenate(found), bad

    def _feed(self, data: bytes, found: list[Bytes]) -> int:
        length, bad = self.shape.length, 0
        buffer = np.frombuffer(self._kept + data, np.uint8)
        at = self._lead
        while True:
            if self._locked:
                count, waits = self._run(buffer, at)
                found.append(buffer[at : at + count * length].reshape(count, length))
                at += count * length
                if waits:
                    break
                self._locked = False
            sure, start = self._search(buffer, at)
            self._skipped += start - at
            self._fresh = self._fresh and start == at and not sure
            at = start
            # a frame that was joined in its middle is not broken
            broken = -(-self._skipped // length) if sure and not self._joining else self._skipped // length
            bad, self._told = bad + max(broken - self._told, 0), max(broken, self._told)
            if not sure:
                break
            self._locked, self._joining, self._skipped, self._told = True, False, 0, 0
        lead = min(at, len(self.shape.end))
        self._kept, self._lead = buffer[at - lead :].tobytes(), lead
        return bad

    def _holds(self, rows: Bytes) -> Flags:
        """Which rows, each of the bytes `seen`, have the marks of a frame, and its check."""
        good = np.ones(len(rows), dtype=bool)
        for at, byte in self._marks:
            good &= rows[:, at] == byte
        shape = self.shape
        if shape.check is not None and good.any():
            end = shape.length - len(shape.end) - shape.check.size
            told = rows[:, end : end + shape.check.size][good].astype(np.int64)
            weights = 256 ** np.arange(shape.check.size)
            right = shape.check.of(rows[good, shape.covers : end]) == told @ (weights[::-1] if shape.big else weights)
            good[good] = right
        return good

    def _marked(self, rows: Bytes) -> Flags:
        """Which rows have the marks between two frames in them, also in part at their end."""
        shape = self.shape
        joint, back = shape.end + shape.start, len(shape.end)
        wide = shape.length
        inside = np.ones((len(rows), wide - 1), dtype=bool)
        first = 1 - back  # the joint may begin at -back, the true one; the others are tried
        for k, byte in enumerate(joint):
            low = first + k
            here = slice(max(low, 0), min(low + wide - 1, wide))
            inside[:, here.start - low : here.stop - low] &= rows[:, here] == byte
            inside[:, : here.start - low] = False
        return np.asarray(inside.any(axis=1))

    def _run(self, buffer: Bytes, at: int) -> tuple[int, bool]:
        """Frames from `at` on that follow each other, and whether the next needs more bytes."""
        length, seen = self.shape.length, self.shape.seen
        if len(buffer) - at < seen:
            return 0, True
        count = (len(buffer) - at - seen) // length + 1
        rows = np.lib.stride_tricks.as_strided(buffer[at:], (count, seen), (length, 1), writeable=False)
        good = self._holds(rows)
        if self.shape.strong:
            right, unknown = good, False
        else:
            mixed = self._marked(rows[:, :length])
            follows = np.append(good[1:], False)
            right, unknown = good & (~mixed | follows), bool(good[-1] and mixed[-1])
        if right.all():
            return count, True
        first = int(np.argmin(right))
        return first, unknown and first == count - 1

    def _search(self, buffer: Bytes, at: int) -> tuple[bool, int]:
        """Whether frames start at a position from `at` on, and the position; else the first that may still be it."""
        shape, length, seen = self.shape, self.shape.length, self.shape.seen
        if len(buffer) - at < (seen if shape.strong else seen + length):
            return False, at
        fits = self._holds(np.lib.stride_tricks.sliding_window_view(buffer[at:], seen))
        begins = fits if shape.strong else fits[:-length] & fits[length:]
        if shape.end and not shape.start and not shape.strong:
            begins &= self._behind(buffer, at, len(begins))
        here = 0
        while (more := np.flatnonzero(begins[here:])).size:
            here += int(more[0])
            step = 0 if shape.strong else self._alone(buffer[at:], fits, here)
            if step is None or step == 0:
                return step == 0, at + here
            here += step
        return False, at + max(here, len(begins))

    def _behind(self, buffer: Bytes, at: int, count: int) -> Flags:
        """Which of the `count` positions from `at` on lie behind an end mark, or where the bytes begin."""
        behind = np.ones(count, dtype=bool)
        for k, byte in enumerate(reversed(self.shape.end), start=1):
            early = min(max(k - at, 0), count)
            behind[:early] = False
            behind[early:] &= buffer[at + early - k : at + count - k] == byte
        behind[0] |= self._fresh
        return behind

    def _alone(self, buffer: Bytes, fits: Flags, here: int) -> int | None:
        """0 where frames start `here` and nowhere else, None where more bytes have to come, or how far to go on."""
        length, plausible = self.shape.length, self.shape.plausible
        for count in range(2, _WINDOW + 1):
            last = here + (count - 1) * length
            if last >= len(fits):
                return None
            stands = np.asarray(fits[here:last].reshape(count - 1, length).all(axis=0))
            stands[0] &= fits[last]
            if not stands[0]:
                return 1
            positions = np.flatnonzero(stands)
            if len(positions) > 1 and plausible is not None:
                likely = plausible(np.lib.stride_tricks.sliding_window_view(buffer[here:], length)[positions])
                positions = positions[likely] if likely.any() else positions
            if len(positions) == 1:
                return int(positions[0])
        return length
