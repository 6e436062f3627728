"""The two files that a recording is, with checksums: an Arrow IPC stream while it grows, Parquet when it is closed."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ...errors import FileError
from ...io.files import check_target
from .layout import About, checksum, columns_of, described, schema_of

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["ENDING", "Growing", "ParquetRecording", "StreamReader", "need_pyarrow", "write_parquet"]

ENDING = ".arrows"
"""What the name of such a file ends with."""


def need_pyarrow(name: str) -> None:
    """Refuse a recording where PyArrow is not installed.

    Raises
    ------
    FileError
        It is not.
    """
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        rule = "a recording needs PyArrow, which is not installed"
        raise FileError(name, rule, 'pip install "subskin[log]"') from None


class _Written:
    """Takes what PyArrow writes, and gives it away: a file is written by the system's own call, which may fail."""

    closed = False

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._at = 0

    def write(self, data: Any) -> int:
        taken = bytes(data)
        self._parts.append(taken)
        self._at += len(taken)
        return len(taken)

    def tell(self) -> int:
        return self._at

    def flush(self) -> None: ...

    def taken(self) -> bytes:
        parts, self._parts = self._parts, []
        return b"".join(parts)


class Growing:
    """A new recording, to which whole batches are appended; what fails in the middle of one is cut off again.

    Parameters
    ----------
    path : Path
        The file; one that is there already is never touched.
    about : About
        What is recorded.

    Raises
    ------
    FileError
        There is such a file, or it cannot be made.
    """

    def __init__(self, path: Path, about: About) -> None:
        need_pyarrow(str(path))
        import pyarrow as pa

        self.path, self._number = path, 0
        check_target(path)
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            rule = "a recording lies there that was not closed"
            raise FileError(str(path), rule, f"subskin recover {path}, or name another file") from None
        except OSError as error:
            raise FileError(str(path), f"it cannot be written ({error.strerror})", "name another file") from None
        self._whole = 0
        self._sink = _Written()
        schema = schema_of(about)
        self._writer: Any = pa.ipc.new_stream(cast("Any", self._sink), schema)
        try:
            self.append(pa.RecordBatch.from_pylist([], schema))  # the head is written with the first batch
            self.sync()
            with suppress(OSError):  # a folder cannot be synced everywhere
                folder = os.open(path.parent, os.O_RDONLY)
                os.fsync(folder)
                os.close(folder)
        except OSError as error:
            self.close()
            path.unlink(missing_ok=True)
            raise FileError(str(path), f"it cannot be written ({error.strerror})", "name another file") from None

    def append(self, batch: pa.RecordBatch) -> None:
        """Write a batch, whole or not at all; raises OSError."""
        told = {"number": str(self._number), "crc32": checksum(batch, self._number)}
        self._writer.write_batch(batch, custom_metadata=told)
        self._put()
        self._number += 1

    def end(self) -> None:
        """Write that nothing follows; raises OSError."""
        self._writer.close()
        self._put()
        self.sync()

    def sync(self) -> None:
        """Wait until the disk has it; raises OSError."""
        os.fsync(self._file)

    def close(self) -> None:
        """Close the file as it is."""
        os.close(self._file)

    def _put(self) -> None:
        rest = memoryview(self._sink.taken())
        size = len(rest)
        try:
            while rest:
                rest = rest[os.write(self._file, rest) :]
        except OSError:
            with suppress(OSError):
                os.ftruncate(self._file, self._whole)
                os.lseek(self._file, self._whole, os.SEEK_SET)
            raise
        self._whole += size


class StreamReader:
    """Reads such a file, be it cut off or damaged: what is whole is given, the rest is said in `left`.

    Parameters
    ----------
    path : Path
        The file.
    name : str
        What messages call it.

    Raises
    ------
    FileError
        It cannot be read, or its head is damaged.
    """

    def __init__(self, path: Path, name: str) -> None:
        need_pyarrow(name)
        import pyarrow as pa

        self.name, self.left, self.skipped = name, "", 0
        try:
            self._file = pa.OSFile(str(path), "rb")  # a map would count the whole file as memory
            self._size: int = self._file.size()
        except (OSError, pa.ArrowException) as error:
            reason = getattr(error, "strerror", None) or error
            raise FileError(name, f"it cannot be read ({reason})", "check the name and the permissions") from None
        try:
            self._reader: Any = pa.ipc.open_stream(self._file)
            schema = self._reader.schema
            told = {key.decode(): value.decode() for key, value in (schema.metadata or {}).items()}
            listed = [f"{field.name}: {field.type}" for field in schema]
        except (OSError, ValueError, pa.ArrowException, MemoryError):
            rule = "it is no recording, or it was cut off in its head"
            raise FileError(name, rule, "name a file that subskin recorded") from None
        self.about = About.of(told, listed, name)
        if listed != described(self.about):
            raise FileError(name, "its columns are not those of a recording", "name a file that subskin recorded")
        self.closed = False

    def __enter__(self) -> StreamReader:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __iter__(self) -> Iterator[pa.RecordBatch]:
        """The batches whose checksum is right; one that is damaged is left out where the next one can be found."""
        import pyarrow as pa

        expected = 0
        while True:
            start = self._file.tell()
            try:
                batch, told = self._reader.read_next_batch_with_custom_metadata()
            except StopIteration:
                self._ended(start)
                return
            except (OSError, ValueError, pa.ArrowException, MemoryError) as error:
                self.left = f"{self._size - start} bytes from byte {start} on ({_first(error)})"
                return
            number = _number(told)
            if number is None or number < expected or not _whole(batch, number, told):
                self.skipped += 1
                self.left = f"a damaged part at byte {start}"
                continue
            expected = number + 1
            yield batch

    def _ended(self, start: int) -> None:
        after = self._size - self._file.tell()
        # PyArrow takes the end of the file, and zeros, for the end of the stream as well
        self._file.seek(start)
        mark = self._file.read(8)
        self.closed = mark == b"\xff\xff\xff\xff\0\0\0\0"
        if mark and not self.closed:
            self.left = f"{self._size - start} bytes from byte {start} on (no batch begins there)"
        elif after:
            self.left = f"{after} bytes after the end"


def _first(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:80]


def _number(told: Any) -> int | None:
    try:
        text = dict(told or {})[b"number"]
        return int(text) if text.isdigit() and len(text) < 19 else None
    except (KeyError, ValueError):
        return None


def _whole(batch: pa.RecordBatch, number: int, told: Any) -> bool:
    """Whether the batch is what was written; one that is not may be anything, and is not touched before it is valid."""
    import pyarrow as pa

    try:
        batch.validate(full=True)
        if any(column.null_count for column in batch.columns):
            return False
        return bytes(dict(told)[b"crc32"]).decode("ascii", "replace") == checksum(batch, number)
    except (pa.ArrowException, ValueError, KeyError, OSError):
        return False


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
