"""Tables of readings and results as CSV or Parquet; what is wrong with one is said with its line and column."""

from __future__ import annotations

import contextlib
import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import FileError, InvalidValueError
from ._csv import CsvPart, CsvReader, csv_head, csv_rows, number_of
from ._parquet import ParquetPart, ParquetReader, ParquetWriter, need_pyarrow
from .files import opened, replacing, size_of

__all__ = ["Table", "TableReader", "TableWriter", "read_table", "reading", "write_table", "writing"]

_PARQUET = (".parquet", ".pq")
_MOST_COLUMNS = 10_000
_LONGEST_NAME = 1000


_Part: TypeAlias = CsvPart | ParquetPart
"""Some rows, as CSV or Parquet gives them."""


@dataclass(frozen=True)
class Table:
    """Named columns, as read: a whole table, or a block of one.

    Parameters
    ----------
    name : str
        The file, for messages.
    columns : tuple of str
        Names of the columns.
    parts : tuple
        The rows, in stretches.
    by : str
        What a row is called: "line", or "row" where the file has no lines.
    head : int
        The line of the names.
    """

    name: str
    columns: tuple[str, ...]
    parts: tuple[_Part, ...]
    by: str = "line"
    head: int = 1

    def __len__(self) -> int:
        return sum(part.count for part in self.parts)

    def position(self, row: int) -> str:
        """Where row `row`, from 0, stands: "file.csv, line 7" or "file.parquet, row 5"."""
        for part in self.parts:
            if row < part.count:
                return f"{self.name}, {self.by} {part.lines[row]}"
            row -= part.count
        return self.name

    def numbers(self, column: str, *, finite: bool = False, why: str = "") -> FloatArray:
        """A column as floats; an empty cell is NaN.

        Parameters
        ----------
        column : str
            Its name.
        finite : bool, optional
            Refuse NaN, empty and infinite cells.
        why : str, optional
            What the column is for, for the message.

        Raises
        ------
        FileError
            No such column, text in a number, or (with `finite`) a cell without a number.
        """
        _check.noun("column", column, str, 'column="time"')
        if column not in self.columns:
            raise self._without(column, why)
        (values,) = self._numbers([column])
        if _check.flag("finite", finite) and not np.isfinite(values).all():
            row = int(np.flatnonzero(~np.isfinite(values))[0])
            seen = f'{self.position(row)}: column "{column}" = {values[row]:g}'
            rule = f"{why} has to be a number in every row" if why else "a number is needed in every row"
            raise FileError(seen, rule, "fill in the cell or delete the row")
        return values

    def _numbers(self, names: Sequence[str]) -> list[FloatArray]:
        """Columns as floats."""
        at = [self.columns.index(name) for name in names]
        each = []
        for name, parts in zip(names, zip(*(part.some(at) for part in self.parts), strict=True), strict=True):
            floats = []
            for part, values in zip(self.parts, parts, strict=True):
                if isinstance(values, list):
                    raise self._not_numbers(name, part, values)
                floats.append(values)
            each.append(np.concatenate(floats))
            each[-1].flags.writeable = False
        return each

    def texts(self, column: str) -> list[str]:
        """A column as text; numbers are written out, and what has no value is empty.

        Parameters
        ----------
        column : str
            Its name.

        Raises
        ------
        FileError
            No such column.
        """
        _check.noun("column", column, str, 'column="time"')
        if column not in self.columns:
            raise self._without(column, "")
        cells = (cell for part in self.parts for cell in part.some([self.columns.index(column)])[0])
        return [cell if isinstance(cell, str) else "" if np.isnan(cell) else f"{cell:.17g}" for cell in cells]

    def readings(self, names: Sequence[str]) -> FloatArray:
        """The columns `names` side by side, shape (rows, n); an empty cell is a missing reading, NaN.

        Raises
        ------
        FileError
            A column that is missing, or text in a number.
        """
        missing = [n for n in _check.several("names", names, str, 'names=["s0"]') if n not in self.columns]
        if missing:
            raise self._without(missing[0], f"the {len(names)} sensors' readings", names)
        out = np.empty((len(self), len(names)))
        for i, values in enumerate(self._numbers(names)):
            out[:, i] = values
        out.flags.writeable = False
        return out

    def _without(self, column: str, why: str, names: Sequence[str] = ()) -> FileError:
        where = f"{self.name}, line {self.head}" if self.by == "line" else self.name
        if self.columns and all(number_of(name) is not None for name in self.columns):
            seen = f"{where}: the first line holds numbers: {', '.join(self.columns)[:60]}"
            return FileError(seen, "the first line has to name the columns", "write a header line above the numbers")
        if len(self.columns) == 1 and re.search(r"[;\t|]", self.columns[0]):
            seen = f'{where}: a single column "{self.columns[0][:60]}"'
            return FileError(seen, "columns have to be separated by commas", "export the table with commas")
        close = difflib.get_close_matches(column, self.columns[:1000], n=1)
        lower = {name.lower(): name for name in self.columns}
        meant = lower.get(column.lower()) or (close[0] if close else None)
        seen = f'{where}: there is no column "{column}"' + (f", needed for {why}" if why else "")
        have = _some(self.columns)
        rule = f"the columns are {have}"
        if names:
            rule += f"; the finger needs {_some(names)}"
        return FileError(seen, rule, f'did you mean "{meant}"' if meant else "")

    def _not_numbers(self, column: str, part: _Part, cells: list[str]) -> FileError:
        """The first cell of a column that is no number."""
        row = next((i for i, cell in enumerate(cells) if number_of(cell) is None), None)
        if row is None:
            return FileError(
                f'{self.name}: column "{column}"', "numbers are needed, not text", "write the column again as numbers"
            )
        shown = cells[row] if len(cells[row]) <= 57 else f"{cells[row][:57]}..."
        seen = f'{self.name}, {self.by} {part.lines[row]}: column "{column}" holds "{shown}"'
        return FileError(seen, "a number is needed", "correct the cell, or leave it empty if there is none")


def _some(names: Sequence[str]) -> str:
    return ", ".join(name if len(name) <= 60 else f"{name[:57]}..." for name in names[:20]) + ", ..." * (
        len(names) > 20
    )


class TableReader:
    """A table that is read in blocks, so that memory holds one of them; made by `reading`.

    Iterating gives each block as a `Table`, whose rows go on where those of the block before it ended. There is at
    least one, which may have no rows.

    Parameters
    ----------
    source : CsvReader or ParquetReader
        Where the rows come from.
    size : int or None
        Bytes of the file; None where that is not known.
    """

    def __init__(self, source: CsvReader | ParquetReader, size: int | None = None) -> None:
        self._source, self._size = source, size
        self.name, self.columns = source.name, tuple(source.columns)
        self.by = "line" if isinstance(source, CsvReader) else "row"
        self._head = source.head_line if isinstance(source, CsvReader) else 1
        self.rows = 0
        where = f"{self.name}, line {self._head}" if self.by == "line" else self.name
        if len(self.columns) > _MOST_COLUMNS:
            raise FileError(
                f"{where}: {len(self.columns)} columns", f"at most {_MOST_COLUMNS} are handled", "leave out columns"
            )
        long = next((i for i, name in enumerate(self.columns) if len(name) > _LONGEST_NAME), None)
        if long is not None:
            seen = f"{where}: the name of column {long + 1} has {len(self.columns[long])} letters"
            raise FileError(seen, f"at most {_LONGEST_NAME} are handled", "shorten it")
        if len(set(self.columns)) < len(self.columns):
            twice = next(name for i, name in enumerate(self.columns) if name in self.columns[:i])
            raise FileError(
                f'{where}: two columns are called "{twice}"',
                "each column needs a name of its own",
                "rename one of them",
            )

    @property
    def total(self) -> int | None:
        """How many rows the table has: from its footer, or estimated from the rows read; None where unknown."""
        if isinstance(self._source, ParquetReader):
            return self._source.rows
        if not self._size or not self._source.taken:
            return None
        return round(self.rows * max(self._size / self._source.taken, 1.0))

    def __iter__(self) -> Iterator[Table]:
        """The blocks."""
        for part in self._source:
            self.rows += part.count
            yield Table(self.name, self.columns, (part,), self.by, self._head)


@contextlib.contextmanager
def reading(path: str | Path) -> Iterator[TableReader]:
    """Open the table at `path`, as `read_table`, to be read block by block.

    Raises
    ------
    FileError
        As `read_table`; of what is wrong with a row, when its block is reached.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_table(f"{folder}/touches.csv", {"y": [1e-3, 2e-3]})
    ...     with reading(f"{folder}/touches.csv") as table:
    ...         [block.numbers("y").tolist() for block in table]
    [[0.001, 0.002]]
    """
    name = "standard input" if str(path) == "-" else str(path)
    with opened(path) as file:
        size, start = size_of(file), file.peek(4)[:4]
        if not start:
            raise FileError(
                f"{name} is empty", "a table with a header is needed", "write a header line above the numbers"
            )
        if Path(path).suffix.lower() in _PARQUET or start == b"PAR1":
            yield TableReader(ParquetReader(file, name), size)
        else:
            yield TableReader(CsvReader(file, name), size)


def read_table(path: str | Path) -> Table:
    """Read the table at `path`: CSV (with a header line), Parquet (.parquet, .pq), or CSV from standard input ("-").

    Parquet needs PyArrow, `pip install "subskin[parquet]"`.

    Raises
    ------
    FileError
        A file that cannot be read, is empty, is cut off, or has lines of different lengths. The message names the
        file and the line.

    Examples
    --------
    >>> read_table("touches.csv")
    Traceback (most recent call last):
    subskin.errors.FileError: touches.csv: there is no such file. Fix: check the name and the folder.
    """
    with reading(path) as blocks:
        tables = list(blocks)
    return Table(tables[0].name, tables[0].columns, tuple(t.parts[0] for t in tables), tables[0].by, tables[0].head)


class TableWriter:
    """A table that is written block by block; made by `writing`.

    Parameters
    ----------
    part : Path
        The file.
    parquet : bool
        Parquet, or CSV.
    """

    def __init__(self, part: Path, parquet: bool) -> None:
        self._parquet = ParquetWriter(part) if parquet else None
        self._csv = None if parquet else part.open("wb")
        self._names: list[str] | None = None

    def write(self, columns: Mapping[str, npt.ArrayLike | Sequence[str]]) -> None:
        """Append rows: `columns` of equal length, the same ones each time.

        Raises
        ------
        InvalidValueError
            Columns of different lengths, or others than before.
        """
        arrays = {name: np.asarray(values) for name, values in columns.items()}
        if len({len(a) for a in arrays.values()}) > 1:
            lengths = ", ".join(f"{name} {len(a)}" for name, a in arrays.items())
            raise InvalidValueError(
                f"columns of lengths {lengths}", "they have to be equal", "one value for each row in every column"
            )
        if self._names not in (None, list(arrays)):
            raise InvalidValueError(
                f"columns {_some(list(arrays))}",
                f"the table has {_some(self._names or [])}",
                "the same columns in every block",
            )
        if self._parquet is not None:
            self._parquet.write(arrays)
        elif self._csv is not None:
            if self._names is None:
                self._csv.write(csv_head(list(arrays)))
            for first in range(0, len(next(iter(arrays.values()), ())), 20_000):
                self._csv.write(csv_rows({name: a[first : first + 20_000] for name, a in arrays.items()}))
        self._names = list(arrays)

    def close(self) -> None:
        """Write what is still held."""
        for file in (self._parquet, self._csv):
            if file is not None:
                file.close()


@contextlib.contextmanager
def writing(path: str | Path) -> Iterator[TableWriter]:
    """Open a table to be written block by block, as `write_table`: it appears whole when the block ends, or not at all.

    Raises
    ------
    FileError
        The file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with writing(f"{folder}/touches.csv") as table:
    ...         table.write({"y": [1e-3]})
    ...         table.write({"y": [2e-3]})
    ...     read_table(f"{folder}/touches.csv").numbers("y").tolist()
    [0.001, 0.002]
    """
    if parquet := str(path).lower().endswith(_PARQUET):
        need_pyarrow(str(path))
    with replacing(path) as part:
        table = TableWriter(part, parquet)
        try:
            yield table
        finally:
            table.close()


def write_table(path: str | Path, columns: Mapping[str, npt.ArrayLike | Sequence[str]]) -> None:
    """Write `columns` of equal length to `path`: Parquet (.parquet, .pq) or CSV (any other; "-" is standard output).

    The file appears whole or not at all. NaN becomes an empty cell. In CSV, text that a spreadsheet would run as a
    formula (it begins with =, +, - or @) is put behind an apostrophe.

    Raises
    ------
    InvalidValueError
        Columns of different lengths.
    FileError
        The file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_table(f"{folder}/touches.csv", {"y": [1e-3, np.nan], "z": [0, 1]})
    ...     read_table(f"{folder}/touches.csv").numbers("y").tolist()
    [0.001, nan]
    """
    with writing(path) as table:
        table.write(columns)
