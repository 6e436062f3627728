"""Frames of one length, found by marks and a check in bytes that may be damaged, and the values in them.

What is handed on, and why it is no false frame (docs/devices.md has it in words):

- With a check of 16 bits or more: the marks are in their positions and the check is right.
- Otherwise the frame lies between two marks, a frame's length apart, with no other mark in it. It is whole then, unless
  the line changed a byte that is no mark, or lost as many bytes in the frame as it added: no format without a check can
  tell. A mark may also occur in the data; such a frame is handed on only when the next frame's marks are right too.
- When the position of frames is not known (at the start, after damage) two frames have to have right marks, and no
  other position may explain the bytes as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import Annotated, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Noun, Real, Ruled
from ..._frozen import Frozen
from ...errors import InvalidValueError
from .parts import Checksum

__all__ = ["TYPES", "Block", "Bytes", "Field", "Flags", "Framer", "Shape", "blocks_of", "in_units"]

_WINDOW = 8
"""Frames over which a mark in the data is compared with the true one, before the first of them is given up."""

Bytes = npt.NDArray[np.uint8]
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
        self.shape, self._strong, self._seen, self._tail = shape, shape.strong, shape.seen, shape.tail
        joint, back = shape.end + shape.start, len(shape.end)
        self._joint = joint  # what stands between two frames, in a frame perhaps cut off at its end
        self._parts = tuple(joint[:size] for size in range(back + 1, len(joint)))
        self._first, self._within = 0 if shape.end else 1, shape.length if shape.start else shape.length - 1
        self._need = shape.seen + (0 if self._strong else shape.length)
        self.reset()

    def reset(self) -> None:
        """Forget what is unfinished."""
        self._kept, self._lead = b"", 0
        self._locked, self._fresh, self._joining = False, True, True
        self._skipped = self._told = 0

    def feed(self, data: bytes) -> tuple[Bytes, int]:
        """The frames that are complete with `data`, shape (n, length), and how many were found broken."""
        data = self._kept + data
        length, bad, at, found = self.shape.length, 0, self._lead, []
        while True:
            if self._locked:
                end, waits = self._run(data, at)
                found.append(data[at:end])
                at = end
                if waits:
                    break
                self._locked = False
            sure, begin = self._search(data, at)
            self._skipped += begin - at
            self._fresh = self._fresh and begin == at and not sure
            at = begin
            # a frame that was joined in its middle is not broken
            broken = -(-self._skipped // length) if sure and not self._joining else self._skipped // length
            bad, self._told = bad + max(broken - self._told, 0), max(broken, self._told)
            if not sure:
                break
            self._locked, self._joining, self._skipped, self._told = True, False, 0, 0
        self._lead = min(at, len(self.shape.end))
        self._kept = data[at - self._lead :]
        return np.frombuffer(b"".join(found), np.uint8).reshape(-1, length), bad

    def _fits(self, data: bytes, at: int) -> bool:
        """Whether the bytes from `at` on have the marks of a frame, and its check."""
        shape = self.shape
        if not data.startswith(self._tail, at + self._seen - len(self._tail)) or not data.startswith(shape.start, at):
            return False
        if shape.check is None:
            return True
        end = at + shape.length - len(shape.end) - shape.check.size
        told = int.from_bytes(data[end : end + shape.check.size], "big" if shape.big else "little")
        return shape.check.of(data[at + shape.covers : end]) == told

    def _run(self, data: bytes, at: int) -> tuple[int, bool]:
        """Where the frames from `at` on that follow each other end, and whether the next needs more bytes."""
        length, last = self.shape.length, len(data) - self._seen
        while at <= last:
            if not self._fits(data, at):
                return at, False
            mixed = not self._strong and (
                data.find(self._joint, at + self._first, at + self._within) >= 0
                or data.endswith(self._parts, at, at + length)
            )
            if mixed and at + length > last:
                return at, True
            if mixed and not self._fits(data, at + length):
                return at, False
            at += length
        return at, True

    def _search(self, data: bytes, at: int) -> tuple[bool, int]:
        """Whether frames start at a position from `at` on, and the position; else the first that may still be it."""
        length, last = self.shape.length, len(data) - self._need
        while (at := self._next(data, at)) <= last:
            step: int | None = 1
            if self._fits(data, at):
                step = 0 if self._strong else self._alone(data, at) if self._fits(data, at + length) else 1
            if not step:
                return step == 0, at
            at += step
        return False, at

    def _next(self, data: bytes, at: int) -> int:
        """The first position from `at` on that a frame may start at: with its mark, or behind one."""
        start, end = self.shape.start, self.shape.end
        if start:
            found = data.find(start, at)
            return found if found >= 0 else max(at, len(data) - len(start) + 1)
        if self._fresh and at == 0:
            return at
        if self._strong:
            found = data.find(end, at + self.shape.length - len(end))
            return found - self.shape.length + len(end) if found >= 0 else max(at, len(data) - self._need + 1)
        found = data.find(end, max(at - len(end), 0))
        return found + len(end) if found >= 0 else len(data)

    def _alone(self, data: bytes, at: int) -> int | None:
        """0 where frames start `at` and nowhere else, None where more bytes have to come, or how far to go on."""
        length, plausible = self.shape.length, self.shape.plausible
        rivals = [other for other in range(at + 1, at + length) if self._fits(data, other)]
        if rivals and plausible is not None:
            rows = [np.frombuffer(data, np.uint8, length, first) for first in (at, *rivals)]
            likely = dict(zip((at, *rivals), plausible(np.array(rows)).tolist(), strict=True))
            if any(likely.values()):
                rivals = [other for other in rivals if likely[other]]
                if not likely[at]:
                    return rivals[0] - at
        for count in range(2, _WINDOW + 1):
            last = at + (count - 1) * length
            if last + self._seen > len(data):
                return None
            if not self._fits(data, last):
                return 1
            rivals = [other for other in rivals if self._fits(data, other + (count - 2) * length)]
            if not rivals:
                return 0
        return length * (_WINDOW // 2)


TYPES = {
    **{f"u{8 * size}": (size, "u") for size in (1, 2, 3, 4, 8)},
    **{f"i{8 * size}": (size, "i") for size in (1, 2, 3, 4, 8)},
    **{f"f{8 * size}": (size, "f") for size in (2, 4, 8)},
}
"""Types by name: size in bytes and kind. u24 and i24 are what many converters send."""

_Type: TypeAlias = Annotated[str, Ruled(lambda name, value: _check.choice(name, value, TYPES, 'type="u16"'))]
_End: TypeAlias = Annotated[float, Real(finite=False)]


@dataclass(frozen=True)
class Field(Noun):
    """One number of a frame.

    Parameters
    ----------
    name : str
        What it is; its unit belongs to the name of a value.
    type : str
        One of `TYPES`.
    use : {"value", "counter", "time", "skip"}
        What it is for: a channel, the number of the frame, its time by the device's clock, or nothing.
    scale : float
        What one count is worth [units of the channel; s for the time].
    offset : float
        What is added then, in the same units.
    low, high : float
        Range of what the device can send, in the same units; it decides only where marks leave two positions open.

    Raises
    ------
    InvalidValueError
        An unknown type or use, a scale of 0, a time that runs back.

    Examples
    --------
    >>> Field("pressure_Pa", "i24", scale=0.5).size
    3
    """

    name: str
    type: _Type
    use: Literal["value", "counter", "time", "skip"] = "value"
    scale: float = 1.0
    offset: float = 0.0
    low: _End = -np.inf
    high: _End = np.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.scale or (self.use == "time" and self.scale < 0):
            rule = "a time runs on, and no count is worth 0"
            raise InvalidValueError(f"scale = {self.scale} of {self.name}", rule, "scale = 1.0")
        if self.use == "counter" and TYPES[self.type][1] != "u":
            raise InvalidValueError(f'type "{self.type}" of a counter', "a counter counts up from 0", 'type = "u16"')

    @property
    def size(self) -> int:
        """Its bytes."""
        return TYPES[self.type][0]


@dataclass(frozen=True)
class Block(Frozen):
    """Fields of one type that lie side by side: they are read at once."""

    first: int
    fields: tuple[Field, ...]
    big: bool

    @cached_property
    def _dtype(self) -> np.dtype[np.generic]:
        size, kind = self.fields[0].size, TYPES[self.fields[0].type][1]
        return np.dtype(f"{'>' if self.big else '<'}{kind}{4 if size == 3 else size}")

    def read(self, rows: Bytes) -> npt.NDArray[np.generic]:
        """The numbers as they were sent, shape (n, fields), of rows of bytes."""
        size, count = self.fields[0].size, len(self.fields)
        data = np.ascontiguousarray(rows[:, self.first : self.first + size * count])
        if size != 3:
            return data.view(self._dtype)
        wide = np.zeros((len(data), count, 4), np.uint8)  # three bytes are the high ones of four
        wide[:, :, slice(0, 3) if self.big else slice(1, 4)] = data.reshape(-1, count, 3)
        return wide.view(self._dtype)[:, :, 0] >> 8

    def write(self, rows: Bytes, numbers: npt.ArrayLike) -> None:
        """Put `numbers`, shape (n, fields), into rows of bytes; whole numbers beyond their range wrap."""
        size, count = self.fields[0].size, len(self.fields)
        given = np.asarray(numbers)
        if self._dtype.kind != "f":
            given = np.rint(given).astype(np.int64)
        data = (
            np.ascontiguousarray(given.astype(self._dtype))
            .view(np.uint8)
            .reshape(len(rows), count, self._dtype.itemsize)
        )
        if size == 3:
            data = data[:, :, slice(1, 4) if self.big else slice(0, 3)]
        rows[:, self.first : self.first + size * count] = data.reshape(len(rows), size * count)


def blocks_of(fields: Sequence[Field], first: int, big: bool, use: str) -> list[Block]:
    """Blocks of the fields of one `use`, where the fields begin at byte `first`.

    Parameters
    ----------
    fields : sequence of Field
        All fields, in their order.
    first : int
        Where the first begins [byte].
    big : bool
        Numbers have their high byte first.
    use : str
        As of a `Field`.
    """
    blocks = []
    for (kind, of), group in groupby(fields, key=lambda field: (field.type, field.use)):
        together = tuple(group)
        if of == use:
            blocks.append(Block(first, together, big))
        first += TYPES[kind][0] * len(together)
    return blocks


def in_units(fields: Sequence[Field]) -> Callable[[Sequence[npt.NDArray[np.generic]]], FloatArray]:
    """What turns numbers as they were sent, blocks of shape (n, k), into the units of `fields`, shape (n, fields)."""
    scale, offset = np.array([f.scale for f in fields]), np.array([f.offset for f in fields])
    plain, centred = bool((scale == 1).all()), not offset.any()

    def turned(numbers: Sequence[npt.NDArray[np.generic]]) -> FloatArray:
        values = (numbers[0] if len(numbers) == 1 else np.concatenate(numbers, axis=1)).astype(np.float64)
        if not plain:
            values *= scale
        if not centred:
            values += offset
        return values

    return turned
