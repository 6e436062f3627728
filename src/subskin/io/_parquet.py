"""Parquet in blocks, through PyArrow: an extra that only this file imports."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..errors import FileError
from .files import needed

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["ParquetPart", "ParquetReader", "ParquetWriter", "need_pyarrow"]

ROWS = 20_000
"""Rows that are read at once."""


def need_pyarrow(name: str) -> None:
    """Refuse Parquet, called `name`, where PyArrow is not installed: raises a FileError."""
    rule, fix = "Parquet needs PyArrow, which is not installed", 'pip install "subskin[parquet]", or use CSV'
    needed(name, rule, fix, "pyarrow.parquet")


@dataclass(frozen=True)
class ParquetPart:
    """Some rows of a table.

    Parameters
    ----------
    batch : pyarrow.RecordBatch
        The rows.
    lines : sequence of int
        The number of each row, from 1.
    """

    batch: pa.RecordBatch
    lines: Sequence[int]

    @property
    def count(self) -> int:
        """How many rows."""
        return int(self.batch.num_rows)

    def some(self, columns: Sequence[int]) -> list[FloatArray | list[str]]:
        """Some columns, by their indices: numbers, or texts."""
        return [self._column(index) for index in columns]

    def _column(self, index: int) -> FloatArray | list[str]:
        import pyarrow as pa

        data = self.batch.column(index)
        kind = data.type
        if pa.types.is_null(kind):
            return np.full(self.count, np.nan)
        if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind):
            cast: Any = data.cast(pa.float64(), safe=False)
            return np.array(cast.fill_null(float("nan")).to_numpy(zero_copy_only=False), dtype=np.float64)
        return ["" if value is None else str(value) for value in data.to_pylist()]


class ParquetReader:
    """The blocks of a Parquet file; a page whose checksum is wrong is refused.

    Parameters
    ----------
    file : binary file
        One that can be searched.
    name : str
        What messages call it.
    """

    def __init__(self, file: BinaryIO, name: str) -> None:
        need_pyarrow(name)
        import pyarrow.parquet as pq

        self.name = name
        if file.read(4) != b"PAR1":
            raise FileError(name, "it is no Parquet file", "name a CSV file .csv")
        file.seek(-4, 2)
        whole = file.read(4) == b"PAR1" and file.tell() > 8
        file.seek(0)
        if not whole:
            raise FileError(name, "it ends in the middle: a Parquet file has a footer", "copy it again")
        with self._damage():
            # pages are read as they are wanted, so that memory does not hold a row group
            self._file = pq.ParquetFile(file, page_checksum_verification=True, pre_buffer=False, buffer_size=1 << 20)
            self.columns = [str(column) for column in self._file.schema_arrow.names]
            self.rows = int(self._file.metadata.num_rows)

    def _damage(self) -> Any:
        return _Damage(self.name)

    def __iter__(self) -> Iterator[ParquetPart]:
        """The blocks; at least one, be it without rows."""
        import pyarrow as pa

        first = 1
        with self._damage():
            batches = self._file.iter_batches(batch_size=ROWS, use_threads=False)
            for batch in batches:
                yield ParquetPart(batch, range(first, first + batch.num_rows))
                first += batch.num_rows
            if first == 1:
                yield ParquetPart(pa.RecordBatch.from_pylist([], self._file.schema_arrow), range(0))


class _Damage:
    """Says what PyArrow found wrong with a file."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        import pyarrow as pa

        if isinstance(error, pa.ArrowException | OSError | ValueError | MemoryError) and not isinstance(
            error, FileError
        ):
            said = (str(error).splitlines() or [""])[0][:80]
            if "crc" in said.lower() or "checksum" in said.lower():
                raise FileError(self.name, "it is damaged: a page differs from its checksum", "copy it again") from None
            raise FileError(self.name, f"it cannot be read as Parquet ({said})", "write it again, or use CSV") from None


class ParquetWriter:
    """Rows appended to a Parquet file, with a checksum for each page.

    Few rows at a time are gathered: the footer, which is kept in memory, grows with each group of rows.

    Parameters
    ----------
    path : Path
        The file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._writer: Any = None
        self._held: list[Any] = []

    def write(self, columns: Mapping[str, npt.NDArray[Any]]) -> None:
        """Append rows; the first ones say what kind each column is of."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        table = pa.table({name: _arrow(values) for name, values in columns.items()})
        if self._writer is None:
            self._writer = pq.ParquetWriter(str(self._path), table.schema, write_page_checksum=True)
        self._held.append(table)
        if sum(map(len, self._held)) >= ROWS:
            self._flush()

    def close(self) -> None:
        """Write the rows that are left, and the footer."""
        if self._writer is not None:
            self._flush()
            self._writer.close()

    def _flush(self) -> None:
        import pyarrow as pa

        if self._held:
            self._writer.write_table(pa.concat_tables(self._held))
            self._held = []


def _arrow(array: npt.NDArray[Any]) -> Any:
    import pyarrow as pa

    if array.dtype.kind == "f":
        return pa.array(array + 0.0, mask=np.isnan(array))  # no -0
    return pa.array(array, pa.string()) if array.dtype.kind in "UO" else pa.array(array)
