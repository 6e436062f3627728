"""Frames of one length in a stream of bytes: boards of magnetometers, and what a table of fields describes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields as fields_of
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ... import _check
from ...errors import InvalidValueError, UnknownOptionError
from ..frames import DeviceFrames
from .base import Driver
from .framing import Bytes, Field, Flags, Framer, Shape, blocks_of, in_units
from .parts import CHECKS, Clock, Counter

__all__ = ["AnySkin", "Described", "Fixed"]

_LONGEST = 1 << 14


class Fixed(Driver):
    r"""Frames of one length: a start mark, fields, a check, an end mark, where the format has them.

    Parameters
    ----------
    fields : sequence of Field
        What lies between the marks, in its order, without gaps.
    start, end : bytes
        Marks; at least one is needed. A format without `end`, and without a check of 16 bits or more, is read one mark
        late: only the next frame's start tells that none of its bytes are missing.
    check : str
        "" or one of `subskin.live.drivers.CHECKS`; it lies behind the fields.
    covers : {"fields", "start"}
        Where the bytes begin that the check is made of: behind the start mark, or with it.
    big_endian : bool
        Numbers, and the check, have their high byte first.

    Raises
    ------
    InvalidValueError
        No mark, no channel, two fields for one use, an unknown check, a frame too long.

    Examples
    --------
    >>> fields = [Field("n", "u8", "counter"), Field("a_Pa", "u16"), Field("b_Pa", "u16")]
    >>> board = Fixed(fields, start=b"\xaa\x55", check="sum8", end=b"\n")
    >>> data = board.encode([[1000, 2000], [1001, 2002]], sequence=[7, 9])
    >>> data[:9].hex(" ")
    'aa 55 07 e8 03 d0 07 c9 0a'
    >>> frames = board.feed(data)
    >>> frames.values.tolist(), frames.sequence.tolist(), frames.lost
    ([[1000.0, 2000.0], [1001.0, 2002.0]], [7, 9], 1)
    """

    def __init__(
        self,
        fields: Sequence[Field],
        *,
        start: bytes = b"",
        end: bytes = b"",
        check: str = "",
        covers: str = "fields",
        big_endian: bool = False,
    ) -> None:
        fields = tuple(fields)
        if not (start or end):
            rule = "frames are found by a mark at their start or end"
            raise InvalidValueError("a frame without a mark", rule, 'end = "0d 0a"')
        _check.choice("check", check, ("", *CHECKS), 'check=""')
        _check.choice("covers", covers, ("fields", "start"))
        self._values = [field for field in fields if field.use == "value"]
        if not self._values:
            raise InvalidValueError("a frame without values", "one field at least is a channel", 'use = "value"')
        for use in ("counter", "time"):
            if sum(field.use == use for field in fields) > 1:
                raise InvalidValueError(f'two fields of use = "{use}"', "a frame has one at most", 'use = "skip"')
        kind = CHECKS[check] if check else None
        length = len(start) + sum(field.size for field in fields) + (kind.size if kind else 0) + len(end)
        if length > _LONGEST:
            raise InvalidValueError(f"a frame of {length} bytes", f"at most {_LONGEST} are handled", "fewer fields")
        bounded = any(np.isfinite([field.low, field.high]).any() for field in self._values)
        floats = any(field.type[0] == "f" for field in self._values)
        self._shape = Shape(
            length, start, end, kind, 0 if covers == "start" else len(start), big_endian,
            self._plausible if bounded or floats else None,
        )  # fmt: skip
        self.channels = tuple(field.name for field in self._values)
        self._blocks, self._counter, self._clock = (
            blocks_of(fields, len(start), big_endian, use) for use in ("value", "counter", "time")
        )
        self._framer, self._in_units = Framer(self._shape), in_units(self._values)
        self._count = Counter(256 ** self._counter[0].fields[0].size) if self._counter else None
        self._in_seconds = in_units(self._clock[0].fields) if self._clock else self._in_units
        whole = bool(self._clock) and self._clock[0].fields[0].type[0] != "f"
        self._ticks = Clock(self._clock[0].fields[0].scale, 256 ** self._clock[0].fields[0].size) if whole else None

    def feed(self, data: bytes) -> DeviceFrames:  # noqa: D102
        rows, bad = self._framer.feed(data)
        number, time, lost = np.full(len(rows), -1), np.full(len(rows), np.nan), 0
        if self._count is not None:
            number = self._counter[0].read(rows)[:, 0].astype(np.int64)
            lost = self._count.lost(number)
        if self._clock:
            ticks = self._clock[0].read(rows)
            time = self._ticks.time(ticks[:, 0]) if self._ticks else self._in_seconds([ticks])[:, 0]
        return DeviceFrames.made(self._read(rows), time, number, lost, bad)

    def reset(self) -> None:  # noqa: D102
        self._framer.reset()
        for part in (self._count, self._ticks):
            if part is not None:
                part.reset()

    def encode(  # noqa: D102
        self, values: npt.ArrayLike, device_time: npt.ArrayLike | None = None, sequence: npt.ArrayLike | None = None
    ) -> bytes:
        table, shape = self.rows(values), self._shape
        rows = np.zeros((len(table), shape.length), np.uint8)
        rows[:, : len(shape.start)] = np.frombuffer(shape.start, np.uint8)
        column = 0
        for block in self._blocks:
            here = table[:, column : column + len(block.fields)]
            worth = [(field.offset, field.scale) for field in block.fields]
            block.write(rows, (here - [w[0] for w in worth]) / [w[1] for w in worth])
            column += len(block.fields)
        for blocks, given in ((self._counter, sequence), (self._clock, device_time)):
            if blocks and given is not None:
                scale = blocks[0].fields[0].scale if blocks is self._clock else 1
                blocks[0].write(rows, np.asarray(given)[:, None] / scale if scale != 1 else np.asarray(given)[:, None])
        back = shape.length - len(shape.end)
        if shape.check is not None:
            first = back - shape.check.size
            order: Literal["big", "little"] = "big" if shape.big else "little"
            for row in rows:
                told = shape.check.of(row[shape.covers : first].tobytes())
                row[first:back] = list(told.to_bytes(shape.check.size, order))
        rows[:, back:] = np.frombuffer(shape.end, np.uint8)
        return rows.tobytes()

    def _read(self, rows: Bytes) -> npt.NDArray[np.float64]:
        return self._in_units([block.read(rows) for block in self._blocks])

    def _plausible(self, rows: Bytes) -> Flags:
        with np.errstate(invalid="ignore", over="ignore"):
            values = self._read(rows)
            inside = (values >= [f.low for f in self._values]) & (values <= [f.high for f in self._values])
        return np.asarray((inside & np.isfinite(values)).all(axis=1))


_RANGE: Mapping[str, tuple[float, float]] = {"C": (-60.0, 150.0), "uT": (-1e5, 1e5)}
"""What a magnetometer MLX90393 can send: its temperature, and twice its widest range."""


class AnySkin(Fixed, name="anyskin"):
    """Boards of AnySkin, ReSkin and eFlesh: of each chip temperature [C] and field x, y, z [uT], and nothing else.

    Frames have no number, no time and no check: raunaqbhirangi/anyskin, arduino/5X_binary_burst_stream.

    Parameters
    ----------
    sensors : int
        Chips on the board.

    Raises
    ------
    InvalidValueError
        No chip, or more than 255.

    Examples
    --------
    >>> board = AnySkin(sensors=5)
    >>> board.channels[:4], len(board.channels)
    (('t0_C', 'x0_uT', 'y0_uT', 'z0_uT'), 20)
    """

    def __init__(self, sensors: int = 5) -> None:
        super().__init__(chips(sensors), end=b"\r\n")


def chips(count: int) -> list[Field]:
    """Fields of a board of `count` magnetometers, in the order in which AnySkin's sketch sends them.

    Raises
    ------
    InvalidValueError
        No chip, or more than 255.
    """
    count = _check.whole("sensors", count, at_least=1, at_most=255, fix="sensors = 5")
    each = (("t", "C"), ("x", "uT"), ("y", "uT"), ("z", "uT"))
    return [
        Field(f"{axis}{i}_{unit}", "f32", low=_RANGE[unit][0], high=_RANGE[unit][1])
        for i in range(count)
        for axis, unit in each
    ]


_MOST = 4096
_KEYS = [field.name for field in fields_of(Field)]


class Described(Fixed, name="fixed"):
    """Frames of one length, described by a table of a file.

    Parameters
    ----------
    fields : sequence of mapping
        What lies between the marks, in its order: tables with `name` and `type`, and any of `use`, `scale`, `offset`,
        `low` and `high`, as of a `Field`. With `count`, so many of it follow each other, numbered from 0. A list of
        names is a group: with `count` it is the group that is repeated.
    start, end : str
        Marks, in hexadecimal digits: "0d 0a".
    check, covers
        As of `Fixed`.
    byte_order : {"little", "big"}
        Which byte of a number comes first.

    Raises
    ------
    InvalidValueError, UnknownOptionError
        As `Fixed`; a key that a field has not got, a mark that is not in hexadecimal digits.

    Examples
    --------
    >>> skin = Described([{"name": ["t_C", "x_uT", "y_uT", "z_uT"], "type": "f32", "count": 2}], end="0d 0a")
    >>> skin.channels
    ('t0_C', 'x0_uT', 'y0_uT', 'z0_uT', 't1_C', 'x1_uT', 'y1_uT', 'z1_uT')
    """

    def __init__(
        self,
        fields: Sequence[Mapping[str, Any]],
        start: str = "",
        end: str = "",
        check: str = "",
        covers: str = "fields",
        byte_order: str = "little",
    ) -> None:
        _check.choice("byte_order", byte_order, ("little", "big"))
        marks = [_mark(key, text) for key, text in (("start", start), ("end", end))]
        if not isinstance(fields, Sequence) or isinstance(fields, str):
            raise InvalidValueError("fields", "a table for each is needed", 'fields = [{name = "p0", type = "u16"}]')
        each = [field for table in fields for field in _fields(table)]
        if len(each) > _MOST:
            raise InvalidValueError(f"{len(each)} fields", f"at most {_MOST} are handled", "a smaller count")
        names = [field.name for field in each if field.use == "value"]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise InvalidValueError(f'two fields named "{twice}"', "each channel has a name of its own", "rename one")
        super().__init__(
            each, start=marks[0], end=marks[1], check=check, covers=covers, big_endian=byte_order == "big"
        )  # fmt: skip


def _mark(key: str, text: str) -> bytes:
    try:
        return bytes.fromhex(text)
    except ValueError:
        fix = f'{key} = "0d 0a"'
        raise InvalidValueError(f'{key} = "{text}"', "a mark is written in pairs of hexadecimal digits", fix) from None


def _fields(table: Any) -> list[Field]:
    """The fields of one table."""
    fix = '{name = "p0", type = "u16"}'
    if not isinstance(table, Mapping):
        raise InvalidValueError(f"fields: {table!r}", "a table for each is needed", fix)
    told = dict(table)
    count, names = told.pop("count", None), told.pop("name", None)
    group = names if isinstance(names, list) else [names]
    if not group or not all(isinstance(name, str) and name for name in group) or "type" not in told:
        raise InvalidValueError(f"field {names!r}", "a field has a name and a type", fix)
    if count is not None and (type(count) is not int or not 1 <= count <= _MOST):
        raise InvalidValueError(f"count = {count!r} of {group[0]}", f"a whole number from 1 to {_MOST} is needed", fix)
    for key in told:
        if key not in _KEYS:
            known = ", ".join([*_KEYS, "count"])
            raise UnknownOptionError(f'key "{key}" of field {group[0]}', "no such key is known", f"known: {known}")
    each = group if count is None else [_numbered(name, i) for i in range(count) for name in group]
    try:
        return [Field(name, **told) for name in each]
    except InvalidValueError as error:
        raise InvalidValueError(f"{error.seen} of field {group[0]}", error.rule, error.fix) from None


def _numbered(name: str, i: int) -> str:
    """x_uT becomes x0_uT."""
    head, mark, unit = name.partition("_")
    return f"{head}{i}{mark}{unit}"
