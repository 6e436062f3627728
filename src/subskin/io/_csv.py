"""CSV in blocks: bytes to columns and back.

A large block goes through Arrow's reader where that is installed, which is three times as fast as the next: pydantic's
reader of JSON. Both keep each double's bits. A block that holds more than plain cells goes through Python's own `csv`,
which says the row that is wrong.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import FileError

__all__ = ["MISSING", "CsvPart", "CsvReader", "csv_head", "csv_rows", "number_of"]

MISSING = ("", "nan", "NaN", "NAN", "-nan", "na", "NA", "N/A", "null", "None")
"""Cells without a value."""
BLOCK = 4_000_000
"""Bytes that are read at once."""
LARGE = 500_000
"""Bytes of a block from which on Arrow's reader earns the time in which it is imported."""
_LONGEST = 64_000_000  # bytes that a row, or a cell in quotes, may have
_HEAD = 4_000_000  # bytes of the line of names
_COMMA, _LINE = 44, 10
_NUMBER = re.compile(r"\s*[-+]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|inf|infinity)\s*", re.IGNORECASE)
_ARCHIVES = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")  # how .xlsx, .ods and .npz begin, and .xls
_MARKS = re.compile(r'[,"\r\n]')  # for which a cell of text stands in quotes
_FORMULA = ("=", "+", "-", "@", "\t", "\r")  # how a cell begins that a spreadsheet would run


@dataclass(frozen=True)
class CsvPart:
    """Some rows of a table: each column as numbers, or as cells where one of them is no number.

    Parameters
    ----------
    count : int
        How many rows.
    lines : sequence of int
        The line on which each row stands.
    values : sequence of ndarray or list of str
        The columns.
    """

    count: int
    lines: Sequence[int]
    values: Sequence[FloatArray | list[str]]

    def some(self, columns: Sequence[int]) -> list[FloatArray | list[str]]:
        """Some columns, by their indices."""
        return [self.values[index] for index in columns]


def number_of(cell: str) -> float | None:
    """The number that a cell holds; NaN of one without a value, None of text."""
    if cell.strip() in MISSING:
        return float("nan")
    return float(cell) if _NUMBER.fullmatch(cell) else None


class CsvReader:
    """The blocks of a CSV file, one after the other, each checked.

    Parameters
    ----------
    file : binary file
        Where the bytes come from.
    name : str
        What messages call it.
    """

    def __init__(self, file: BinaryIO, name: str) -> None:
        self.name = name
        self.taken = 0
        self._file, self._held = file, b""
        self._line = 1
        head = self._header()
        self.head_line = self._line
        self._line += head.count(b"\n") + 1
        self.columns = [cell.strip() for cell in self._cells(head)]
        self._width = len(self.columns)

    def _cells(self, head: bytes) -> list[str]:
        text = self._text(head, self.head_line)
        if '"' not in text:
            return text.split(",")
        try:
            return next(csv.reader(io.StringIO(text, newline="")), [])
        except csv.Error as error:
            raise FileError(
                f"{self.name}, line {self.head_line}", f"it cannot be read as CSV ({error})", "save it again as CSV"
            ) from None

    def _header(self) -> bytes:
        """The first line that is not blank; the line it stands on is `_line`."""
        data, at_end = self._more(), False
        if data.startswith(b"\xef\xbb\xbf"):
            data = data[3:]
        while True:
            body = data.lstrip(b"\n")
            end = self._end(body)
            if end >= 0 or at_end:
                break
            if len(body) > _HEAD:
                seen = f"{self.name}, line {self._line}: a line of more than {_HEAD // 1_000_000} MB"
                raise FileError(seen, "the first line has to name the columns", "write a header line above the numbers")
            more = self._more()
            at_end, data = not more, data + more
        self._line += len(data) - len(body)
        head, self._held = (body, b"") if end < 0 else (body[:end], body[end + 1 :])
        if not head:
            raise FileError(
                f"{self.name} is empty", "a table with a header is needed", "write a header line above the numbers"
            )
        return head

    @staticmethod
    def _end(body: bytes) -> int:
        """Where the first line ends, outside of quotes; -1 if it does not."""
        end = body.find(b"\n")
        while end >= 0 and body.count(b'"', 0, end) % 2:
            end = body.find(b"\n", end + 1)
        return end

    def _more(self) -> bytes:
        """The next bytes, with ends of lines as one character; empty at the end."""
        data = self._file.read(BLOCK)
        if data.endswith(b"\r"):  # it may be half an end of line
            data += self._file.read(1)
        self.taken += len(data)
        return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data

    def __iter__(self) -> Iterator[CsvPart]:
        """The blocks; at least one, be it without rows."""
        first = True
        while True:
            more = self._more()
            data = self._held + more
            at_end = not more
            end = len(data) if at_end else self._cut(data)
            if end < 0:
                if len(data) > _LONGEST:
                    seen = f"{self.name}, line {self._line}"
                    rule = f"a row, or a cell in quotes, does not end within {_LONGEST // 1_000_000} MB"
                    raise FileError(seen, rule, "close the quotes")
                self._held = data
                continue
            block, self._held = data[:end], data[end:]
            if block or first:
                part = self._part(block, at_end)
                if at_end and block and not block.endswith(b"\n"):
                    said = "its last line does not end: where the file was cut off, its last number may be too short"
                    text = f"{self.name}: {said}. Fix: copy it again, or end the line"
                    _check.warn(text)
                yield part
                first = False
            if at_end:
                return
            self._line += block.count(b"\n")

    @staticmethod
    def _cut(data: bytes) -> int:
        """Behind the last line that is whole; -1 if none is."""
        end = data.rfind(b"\n")
        if data.count(b'"', 0, end + 1) % 2 == 0:
            return end + 1 or -1
        while end >= 0 and data.count(b'"', 0, end) % 2:
            end = data.rfind(b"\n", 0, data.rfind(b'"', 0, end))
        return end + 1 or -1

    def _part(self, block: bytes, at_end: bool) -> CsvPart:
        if b'"' not in block and b"\0" not in block and b"\n\n" not in block and not block.startswith(b"\n"):
            if len(block) >= LARGE and (columns := _by_arrow(block, self._width)) is not None:
                return CsvPart(len(columns[0]), range(self._line, self._line + len(columns[0])), columns)
            plain = block if block.endswith(b"\n") or not block else block + b"\n"
            rows = self._rows(plain)
            if rows is not None:
                return CsvPart(rows, range(self._line, self._line + rows), self._columns(plain, rows))
        return self._careful(block, at_end)

    def _rows(self, block: bytes) -> int | None:
        """How many rows a plain block has; None where some row has too many or too few cells."""
        codes = np.frombuffer(block, np.uint8)
        marks = codes[(codes == _COMMA) | (codes == _LINE)]
        if marks.size % self._width:
            return None
        rows = marks.reshape(-1, self._width) == _LINE
        return len(rows) if rows[:, -1].all() and not rows[:, :-1].any() else None

    def _columns(self, block: bytes, rows: int) -> list[FloatArray | list[str]]:
        """The columns of a plain block."""
        if not rows:
            return [np.empty(0) for _ in range(self._width)]
        joined = block[:-1].replace(b"\n", b",")
        values = _numbers(joined, rows * self._width)
        if values is not None:
            return list(np.ascontiguousarray(values.reshape(rows, self._width).T))
        self._text(block, self._line)
        cells = joined.split(b",")
        return [_column(cells[i :: self._width]) for i in range(self._width)]

    def _careful(self, block: bytes, at_end: bool) -> CsvPart:
        """A block with quotes, blank lines or faults."""
        text = self._text(block, self._line)
        reader = csv.reader(io.StringIO(text, newline=""), strict=True)
        lines: list[int] = []
        cells: list[list[str]] = []
        try:
            for row in reader:
                line = self._line + reader.line_num - 1
                if not row and self._width > 1:
                    continue
                row = row or [""]  # of a single column an empty line is a missing value
                if len(row) != self._width:
                    raise self._ragged(line, len(row), at_end and not any(filter(None, reader)))
                lines.append(line)
                cells.append(row)
        except csv.Error as error:
            line = self._line + reader.line_num - 1
            raise FileError(
                f"{self.name}, line {line}", f"it cannot be read as CSV ({error})", "close the quotes"
            ) from None
        across = zip(*cells) if cells else ((),) * self._width
        return CsvPart(len(lines), lines, [_column([c.encode() for c in column], list(column)) for column in across])

    def _ragged(self, line: int, count: int, last: bool) -> FileError:
        if self._width == 1 and re.search(r"[;\t|]", self.columns[0]):  # and commas in the numbers
            seen = f'{self.name}: a single column "{self.columns[0][:60]}"'
            rule = "columns have to be separated by commas, and decimals by points"
            return FileError(seen, rule, "export the table with commas and points")
        seen = f"{self.name}, line {line}: {count} cell{'s'[: count != 1]} where the header has {self._width}"
        if last and count < self._width:
            return FileError(seen, "the file ends in the middle of a line", "copy it again, or delete that line")
        return FileError(seen, "every line needs as many cells as the header", "complete that line, or delete it")

    def _text(self, block: bytes, line: int) -> str:
        if line == 1 and block.startswith(_ARCHIVES):
            raise FileError(
                f"{self.name} is a spreadsheet or an archive", "a table is CSV or Parquet", "export it as CSV"
            )
        if b"\0" in block:
            seen = f"{self.name}, line {line + block.count(10, 0, block.index(0))}: a byte that is 0"
            raise FileError(seen, "the file has to be text in UTF-8", "save it as UTF-8")
        try:
            return block.decode("utf-8")
        except UnicodeDecodeError as error:
            where = f"{self.name}, line {line + block.count(10, 0, error.start)}"
            raise FileError(where, "the file has to be text in UTF-8", "save it as UTF-8") from None


def _by_arrow(block: bytes, width: int) -> list[FloatArray | list[str]] | None:
    """The columns of a block; None without Arrow, where a row is wrong, or where Arrow takes a column for dates."""
    try:
        from pyarrow import ArrowInvalid, csv, float64, types
    except ImportError:
        return None
    named = csv.ReadOptions(column_names=[str(i) for i in range(width)], use_threads=False)
    try:
        columns = csv.read_csv(
            io.BytesIO(block), named, convert_options=csv.ConvertOptions(null_values=list(MISSING))
        ).itercolumns()
    except ArrowInvalid:
        return None
    out: list[FloatArray | list[str]] = []
    for column in columns:
        if types.is_string(column.type):
            texts: Any = column.to_pylist()
            out.append(_column([text.encode() for text in texts], texts))
        elif types.is_null(column.type) or types.is_integer(column.type) or types.is_floating(column.type):
            out.append(column.cast(float64(), safe=False).to_numpy())
        else:
            return None
    return out


def _numbers(joined: bytes, count: int) -> FloatArray | None:
    """Cells between commas, read as numbers all at once; None where it takes more than that."""
    from pydantic_core import from_json

    if b"u" in joined or b"s" in joined:  # true, false and null are JSON, and no numbers
        return None
    if joined.startswith(b",") or joined.endswith(b",") or b",," in joined or not joined:
        joined = b"," + joined + b","
        joined = joined.replace(b",,", b",null,").replace(b",,", b",null,")[1:-1]
    try:
        values = np.array(from_json(b"[%b]" % joined), dtype=np.float64)
    except (ValueError, TypeError, OverflowError):
        return None
    return values if values.shape == (count,) else None


def _column(cells: Sequence[bytes], texts: list[str] | None = None) -> FloatArray | list[str]:
    """One column: numbers, or its cells as text."""
    values = _numbers(b",".join(cells), len(cells)) if cells else np.empty(0)
    if values is not None:
        return values
    texts = [cell.decode() for cell in cells] if texts is None else texts
    out = np.empty(len(texts))
    for i, cell in enumerate(texts):
        number = number_of(cell)
        if number is None:
            return texts
        out[i] = number
    return out


def csv_head(names: Sequence[str]) -> bytes:
    """The line of names."""
    line = ",".join(names)
    plain = line.count(",") < len(names) and not _MARKS.search(line.replace(",", ""))
    return (line.encode(errors="replace") if plain else b",".join(map(_quoted, names))) + b"\n"


def csv_rows(columns: Mapping[str, npt.NDArray[Any]]) -> bytes:
    """Rows of CSV; NaN is an empty cell, and text that a spreadsheet would run is put behind an apostrophe."""
    if not columns or not len(next(iter(columns.values()))):
        return b""
    return b"\n".join(map(b",".join, zip(*map(_written, columns.values())))) + b"\n"


def _written(column: npt.NDArray[Any]) -> list[bytes]:
    from pydantic_core import to_json

    if column.dtype.kind in "biu":
        return to_json(column.tolist())[1:-1].split(b",")
    if column.dtype.kind == "f":
        numbers = to_json((column + 0.0).tolist(), inf_nan_mode="constants")[1:-1]  # no -0
        if b"N" in numbers or b"I" in numbers:
            numbers = numbers.replace(b"NaN", b"").replace(b"Infinity", b"inf")
        return numbers.split(b",")
    texts = column.tolist()
    kept = {text: _quoted(f"'{text}" if str(text).startswith(_FORMULA) else text) for text in set(texts)}
    return [kept[text] for text in texts]


def _quoted(value: object) -> bytes:
    """A cell of text, in quotes where it needs them."""
    text = "" if value is None else str(value)
    if _MARKS.search(text):
        text = '"' + text.replace('"', '""') + '"'
    return text.encode("utf-8", errors="replace")
