"""Tables of readings and results as CSV or Parquet; what is wrong with one is said with its line and column."""

from __future__ import annotations

import csv
import difflib
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import FileError, InvalidValueError
from .files import read_bytes, replacing, write_bytes

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["Table", "read_table", "write_table"]

_MISSING = ("", "nan", "NaN", "NAN", "-nan", "na", "NA", "N/A", "null", "None")
_PARQUET = (".parquet", ".pq")


@dataclass(frozen=True)
class Table:
    """Named columns, as read.

    Parameters
    ----------
    name : str
        The file, for messages.
    arrow : pyarrow.Table
        The columns.
    text : bytes
        A CSV file's bytes, for finding a line again; empty for Parquet.
    """

    name: str
    arrow: pa.Table
    text: bytes = field(default=b"", repr=False)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(self.arrow.column_names)

    def __len__(self) -> int:
        return int(self.arrow.num_rows)

    def position(self, row: int) -> str:
        """Where row `row`, from 0, stands: "file.csv, line 7" or "file.parquet, row 5"."""
        if not self.text:
            return f"{self.name}, row {row + 1}"
        for number, (line, _) in enumerate(_lines(self.text)):
            if number == row + 1:
                return f"{self.name}, line {line}"
        return f"{self.name}, row {row + 1}"

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
        import pyarrow as pa

        if column not in self.columns:
            raise self._without(column, why)
        data = self.arrow.column(column)
        kind = data.type
        if pa.types.is_null(kind):
            values = np.full(len(self), np.nan)
        elif pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind):
            cast: Any = data.cast(pa.float64(), safe=False)
            values = cast.fill_null(float("nan")).to_numpy(zero_copy_only=False)
        else:
            raise self._not_numbers(column)
        values = np.array(values, dtype=np.float64)
        if finite and not np.isfinite(values).all():
            row = int(np.flatnonzero(~np.isfinite(values))[0])
            seen = f'{self.position(row)}: column "{column}" = {values[row]:g}'
            rule = f"{why} has to be a number in every row" if why else "a number is needed in every row"
            raise FileError(seen, rule, "fill in the cell or delete the row")
        return _check.read_only(values)

    def readings(self, names: Sequence[str]) -> FloatArray:
        """The columns `names` side by side, shape (rows, n); an empty cell is a missing reading, NaN.

        Raises
        ------
        FileError
            A column that is missing, or text in a number.
        """
        missing = [name for name in names if name not in self.columns]
        if missing:
            raise self._without(missing[0], f"the {len(names)} sensors' readings", names)
        out = np.empty((len(self), len(names)))
        for i, name in enumerate(names):
            out[:, i] = self.numbers(name)
        return _check.read_only(out)

    def _without(self, column: str, why: str, names: Sequence[str] = ()) -> FileError:
        where = f"{self.name}, line 1" if self.text else self.name
        if self.columns and all(_is_number(name) for name in self.columns):
            seen = f"{where}: the first line holds numbers: {', '.join(self.columns)[:60]}"
            return FileError(seen, "the first line has to name the columns", "write a header line above the numbers")
        if len(self.columns) == 1 and re.search(r"[;\t|]", self.columns[0]):
            seen = f'{where}: a single column "{self.columns[0][:60]}"'
            return FileError(seen, "columns have to be separated by commas", "export the table with commas")
        close = difflib.get_close_matches(column, self.columns, n=1)
        lower = {name.lower(): name for name in self.columns}
        meant = lower.get(column.lower()) or (close[0] if close else None)
        seen = f'{where}: there is no column "{column}"' + (f", needed for {why}" if why else "")
        have = ", ".join(self.columns[:20]) + (", ..." if len(self.columns) > 20 else "")
        rule = f"the columns are {have}"
        if names:
            rule += f"; the finger needs {', '.join(names[:20])}"
        return FileError(seen, rule, f'did you mean "{meant}"' if meant else "")

    def _not_numbers(self, column: str) -> FileError:
        """The first cell of a column that is no number."""
        for row, cell in enumerate(self.arrow.column(column)):
            value = cell.as_py()
            if value is not None and not (isinstance(value, str) and _is_number(value)):
                shown = f'"{value}"' if isinstance(value, str) else str(value)
                seen = f'{self.position(row)}: column "{column}" holds {shown[:60]}'
                return FileError(seen, "a number is needed", "correct the cell, or leave it empty if there is none")
        return FileError(f'{self.name}: column "{column}"', f"numbers are needed, not {self.arrow.column(column).type}")


def read_table(path: str | Path) -> Table:
    """Read the table at `path`: CSV (with a header line), Parquet (.parquet, .pq), or CSV from standard input ("-").

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
    name = "standard input" if str(path) == "-" else str(path)
    data = read_bytes(path)
    if not data:
        raise FileError(f"{name} is empty", "a table with a header is needed")
    if Path(path).suffix.lower() in _PARQUET or data[:4] == b"PAR1":
        return Table(name, _parquet(data, name))
    return Table(name, _csv(data, name), data)


def _parquet(data: bytes, name: str) -> pa.Table:
    import pyarrow as pa
    import pyarrow.parquet as pq

    if data[:4] != b"PAR1":
        raise FileError(name, "it is no Parquet file", "name a CSV file .csv")
    try:
        table = pq.read_table(pa.BufferReader(data))
    except (pa.ArrowException, OSError, ValueError, MemoryError) as error:
        if data[-4:] != b"PAR1":
            raise FileError(name, "it ends in the middle: a Parquet file has a footer", "copy it again") from None
        raise FileError(name, f"it cannot be read as Parquet ({str(error).splitlines()[0][:80]})") from None
    _named(list(table.column_names), name)
    return table


def _csv(data: bytes, name: str) -> pa.Table:
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    header = next(_lines(data), None)
    if header is None:
        raise FileError(f"{name} is empty", "a table with a header is needed")
    try:
        table = arrow_csv.read_csv(
            io.BytesIO(data),
            # of a single column an empty line is a missing value
            parse_options=arrow_csv.ParseOptions(ignore_empty_lines=len(header[1]) > 1),
            convert_options=arrow_csv.ConvertOptions(
                null_values=list(_MISSING), strings_can_be_null=True, true_values=[], false_values=[]
            ),
        )
        names = [column.strip() for column in table.column_names]
    except (pa.ArrowException, ValueError) as error:  # ValueError: names that are not UTF-8
        raise _broken(data, name, len(header[1]), str(error)) from None
    if any(pa.types.is_binary(kind) for kind in table.schema.types):
        raise _broken(data, name, len(header[1]), "bytes that are no text")
    _named(names, f"{name}, line {header[0]}")
    return table.rename_columns(names)


def _named(columns: list[str], where: str) -> None:
    twice = next((c for c in columns if columns.count(c) > 1), None) if len(columns) < 10_000 else None
    if twice is not None:
        raise FileError(f'{where}: two columns are called "{twice}"', "each column needs a name of its own")


def _lines(data: bytes) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of each line that is not blank."""
    text = io.StringIO(data.decode("utf-8-sig", errors="replace"), newline="")
    reader = csv.reader(text)
    try:
        for cells in reader:
            if cells:
                yield reader.line_num, cells
    except csv.Error:
        return


def _broken(data: bytes, name: str, width: int, reason: str) -> FileError:
    """What is wrong with a CSV file that could not be read."""
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        return FileError(f"{name}, line {line}", "the file has to be text in UTF-8", "save it as UTF-8")
    rows = [(line, len(cells)) for line, cells in _lines(data)]
    last = rows[-1][0] if rows else 0
    for line, count in rows:
        if count != width:
            seen = f"{name}, line {line}: {count} cell{'s'[: count != 1]} where the header has {width}"
            if line == last and count < width:
                return FileError(seen, "the file ends in the middle of a line", "copy it again, or delete that line")
            return FileError(seen, "every line needs as many cells as the header")
    return FileError(name, f"it cannot be read as CSV ({reason.splitlines()[0][:80]})")


def write_table(path: str | Path, columns: Mapping[str, npt.ArrayLike | Sequence[str]]) -> None:
    """Write `columns` of equal length to `path`: Parquet (.parquet, .pq) or CSV (any other; "-" is standard output).

    The file appears whole or not at all. NaN becomes an empty cell.

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
    import pyarrow as pa
    import pyarrow.parquet as pq
    from pyarrow import csv as arrow_csv

    arrays = {name: _arrow(values) for name, values in columns.items()}
    if len({len(a) for a in arrays.values()}) > 1:
        lengths = ", ".join(f"{name} {len(a)}" for name, a in arrays.items())
        raise InvalidValueError(f"columns of lengths {lengths}", "they have to be equal")
    table = pa.table(arrays)
    if Path(path).suffix.lower() in _PARQUET:
        with replacing(path) as part:
            pq.write_table(table, str(part))
        return
    head = io.StringIO()  # pyarrow puts every name of a header in quotes
    csv.writer(head, lineterminator="\n").writerow(arrays)
    body = io.BytesIO(head.getvalue().encode())
    body.seek(0, io.SEEK_END)
    # "needed" puts every text in quotes
    style: Literal["none", "needed"] = "needed" if any(map(_needs_quotes, table.columns)) else "none"
    arrow_csv.write_csv(table, body, arrow_csv.WriteOptions(include_header=False, quoting_style=style))
    write_bytes(path, body.getvalue())


def _arrow(values: npt.ArrayLike | Sequence[str]) -> Any:
    import pyarrow as pa

    array = np.asarray(values)
    if array.dtype.kind == "f":
        return pa.array(array + 0.0, mask=np.isnan(array))  # no -0
    return pa.array(array, pa.string()) if array.dtype.kind in "UO" else pa.array(array)


def _needs_quotes(column: Any) -> bool:
    import pyarrow as pa
    import pyarrow.compute as pc

    if not pa.types.is_string(column.type):
        return False
    return bool(pc.any(pc.match_substring_regex(column, '[",\\r\\n]')).as_py())


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
