"""The file that a closed recording is: Parquet, with a checksum for each page and one for its head."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import FileError
from .about import About
from .stream import need_pyarrow
from .table import columns_of, described, schema_of

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["ParquetRecording", "write_parquet"]

_ROWS = 20_000
"""Rows that are written, and read, at once: memory holds no more of them."""
_MOST_CELLS = 4_000_000


def write_parquet(path: Path, about: About, batches: Iterable[pa.RecordBatch], closed: str) -> int:
    """Write a recording; returns how many rows it has.

    Parameters
    ----------
    path : Path
        The file.
    about : About
        What is recorded.
    batches : iterable of pyarrow.RecordBatch
        Its rows.
    closed : str
        "yes", or what was lost.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema, rows = schema_of(about), 0
    texts = [name for name, kind in columns_of(about).items() if kind == "string"]
    options: Any = {"use_dictionary": texts, "compression": "zstd", "compression_level": 1, "write_page_checksum": True}
    with pq.ParquetWriter(str(path), schema, **options) as writer:
        held: list[Any] = []
        most = max(min(_ROWS, _MOST_CELLS // len(schema)), 1)
        for batch in batches:
            rows += batch.num_rows
            held.append(batch)
            if sum(part.num_rows for part in held) >= most:
                writer.write_table(pa.Table.from_batches(held, schema), row_group_size=most)
                held = []
        if held or not rows:
            writer.write_table(pa.Table.from_batches(held, schema))
        writer.add_key_value_metadata({"subskin.closed": closed, "subskin.rows": str(rows)})
    return rows


class ParquetRecording:
    """Reads such a file; what differs from its checksum is refused.

    Parameters
    ----------
    path : Path
        The file.
    name : str
        What messages call it.

    Raises
    ------
    FileError
        It cannot be read, is no recording, or is damaged.
    """

    def __init__(self, path: Path, name: str) -> None:
        need_pyarrow(name)
        import pyarrow as pa
        import pyarrow.parquet as pq

        self.name = name
        try:
            # no buffer_size: a buffered page takes as much memory as its head says, which may be damaged
            self._file: Any = pq.ParquetFile(
                path, page_checksum_verification=True, pre_buffer=False, memory_map=False,
                thrift_string_size_limit=1 << 26, thrift_container_size_limit=1 << 22,
            )  # fmt: skip
            schema = self._file.schema_arrow
            told = {
                k.decode(): v.decode() for k, v in (self._file.metadata.metadata or {}).items() if k[:8] == b"subskin."
            }
            listed = [f"{field.name}: {field.type}" for field in schema]
        except (OSError, ValueError, pa.ArrowException, MemoryError) as error:
            raise self._damaged(error) from None
        self.about = About.of(told, listed, name)
        self.rows = int(self._file.metadata.num_rows)
        if listed != described(self.about) or told.get("subskin.rows") != str(self.rows):
            raise FileError(name, "it is damaged: its columns or rows are not those that were written", "copy it again")

    def __enter__(self) -> ParquetRecording:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __iter__(self) -> Iterator[pa.RecordBatch]:
        import pyarrow as pa

        rows, most = 0, max(min(_ROWS, _MOST_CELLS // max(len(columns_of(self.about)), 1)), 1)
        batches = self._file.iter_batches(batch_size=most, use_threads=False)
        while True:
            try:
                batch = next(batches, None)
                if batch is not None:
                    batch.validate(full=True)
            except (OSError, ValueError, pa.ArrowException, MemoryError) as error:
                raise self._damaged(error) from None
            if batch is None:
                break
            if any(column.null_count for column in batch.columns):
                raise FileError(self.name, "it is damaged: it holds empty cells", "copy it again")
            rows += batch.num_rows
            yield batch
        if rows != self.rows:
            raise FileError(self.name, f"it is damaged: it has {rows} of {self.rows} rows", "copy it again")

    def _damaged(self, error: BaseException) -> FileError:
        said = (str(error).splitlines() or [type(error).__name__])[0][:80]
        return FileError(self.name, f"it is damaged, or no Parquet file ({said})", "copy it again")
