"""The values in frames of one length: where each lies, of which type, and what it is worth."""

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
from .framing import Bytes

__all__ = ["TYPES", "Block", "Field", "blocks_of", "in_units"]

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
