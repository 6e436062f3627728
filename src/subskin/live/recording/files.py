"""The two files that a recording is: an Arrow IPC stream while it grows, Parquet when it is closed or recovered."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ..._frozen import Frozen
from ...errors import FileError
from ...io.files import apart, check_target, path_of, replacing
from .layout import About, checksum, columns_of, need_pyarrow, schema_of
from .source import batch_size, opened

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["ENDING", "Growing", "Recovered", "recover", "write_parquet"]

ENDING = ".arrows"
"""What the name of a recording that grows ends with."""


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
        most = batch_size(about)
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


@dataclass(frozen=True)
class Recovered(Frozen):
    """What was found.

    Parameters
    ----------
    path : Path
        The recording that was written.
    rows, frames : int
        Its rows, and the frames among them.
    seconds : float
        From its first frame to its last [s].
    left : str
        What could not be read; "" where all could.
    closed : bool
        The recording had been closed, and nothing was wrong with it.
    """

    path: Path
    rows: int
    frames: int
    seconds: float
    left: str
    closed: bool


def recover(path: str | Path, target: str | Path | None = None) -> Recovered:
    """Write all that can be read of a recording to a new file, Parquet; the old one stays as it is.

    A stream that was cut off anywhere gives all batches up to the cut. A batch whose checksum is wrong is left out.

    Parameters
    ----------
    path : path-like
        What is left: a file that ends in .arrows.
    target : path-like, optional
        The new file; the name of the old one without .arrows if left out.

    Raises
    ------
    FileError
        Nothing can be read, or the new file cannot be written.

    Examples
    --------
    >>> recover("touch.parquet.arrows")
    Traceback (most recent call last):
    subskin.errors.FileError: touch.parquet.arrows: there is no such file. Fix: check the name and the folder.
    """
    new = path_of(_named(path) if target is None else target)
    with opened(path) as recording:
        apart({"the recording": str(path)}, {"-o": str(new)})
        if target is None and new.exists():
            raise FileError(str(new), "there is such a file already", "name another one with -o")
        check_target(new)
        counts = _Counts()
        with replacing(new) as part:
            batches = counts.passed(recording.batches())
            first = next(batches, None)
            if first is None:
                raise FileError(str(path), f"no frame can be read{_because(recording.left)}", "record again")
            rows = write_parquet(part, recording.about, chain([first], batches), "recovered")
        whole = recording.closed and not recording.left
        return Recovered(new, rows, counts.frames, counts.seconds, recording.left, whole)


def _because(left: str) -> str:
    return f" ({left})" if left else ""


def _named(path: str | Path) -> str:
    name = str(path)
    if not name.endswith(ENDING):
        return f"{name}.recovered.parquet"
    name = name.removesuffix(ENDING)
    return name if name.endswith(".parquet") else f"{name}.parquet"


class _Counts:
    """Counts what passes."""

    def __init__(self) -> None:
        self.frames, self._first, self._last = 0, float("nan"), float("nan")

    def passed(self, batches: Iterator[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
        for batch in batches:
            kinds = batch.column("kind").to_pylist()
            time = batch.column("time").to_numpy()[[i for i, kind in enumerate(kinds) if kind == "frame"]]
            self.frames += len(time)
            if time.size:
                self._first = time[0] if self._first != self._first else self._first
                self._last = time[-1]
            yield batch

    @property
    def seconds(self) -> float:
        return float(self._last - self._first) if self.frames else 0.0
