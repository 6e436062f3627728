"""A recording read again, whichever of its two files it is: rows as they were written, and the steps that made them."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, Self

import numpy as np

from ..._frozen import Frozen
from ...errors import FileError
from ...io.files import opened as opened_file
from ...io.files import path_of
from ..frames import DeviceFrames
from .layout import COMMAND, EVENT, FRAME, STEP, About, checksum, columns_of, described, joined, need_pyarrow

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["OpenRecording", "RowSource", "Step", "batch_size", "opened"]

_KINDS = {FRAME, STEP, COMMAND, EVENT}
_LONGEST = 1_000_000


@dataclass(frozen=True, eq=False)
class Step(Frozen):
    """What went into a chain at once: frames, or a command.

    Parameters
    ----------
    number : int
        Which step of the recording, from 0.
    host_time : float
        The host's clock when it went in [s].
    frames : DeviceFrames
        The frames; none of a command.
    command : str
        What the command was; "" where frames went in.
    values : mapping
        What the command was given.
    rows : pyarrow.RecordBatch or None
        The rows of the recording that the step made.
    """

    number: int
    host_time: float
    frames: DeviceFrames
    command: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    rows: Any = None


class RowSource(Protocol):
    """Rows of a recording, wherever they come from: what can be made into a file.

    Attributes
    ----------
    about : About
        What is recorded.
    name : str
        What messages call it.
    """

    about: About
    name: str

    def batches(self) -> Iterator[pa.RecordBatch]:
        """The rows, some thousand at a time."""


class OpenRecording(ABC):
    """A recording that is open; made by `opened`: the stream that grows, or the Parquet file that it becomes.

    Parameters
    ----------
    path : Path
        The file.
    name : str
        What messages call it.
    whole : bool
        Refuse what was not closed, or is damaged, where its readable part ends.

    Raises
    ------
    FileError
        It cannot be read, is no recording, or is damaged.
    """

    def __init__(self, path: Path, name: str, whole: bool = False) -> None:
        need_pyarrow(name)
        self.name, self._whole = name, whole
        self.rows: int | None = None
        """How many rows there are; None of a stream, which does not know."""
        self.left, self.closed = "", True
        """What could not be read, "" where all could; whether it was closed. Known after `batches` has ended."""
        self._file: Any = None
        schema, told = self._head(path)
        listed = [f"{field.name}: {field.type}" for field in schema]
        self.about = About.of(told, listed, name)
        if listed != described(self.about) or str(self.rows) != told.get("subskin.rows", str(self.rows)):
            raise self._other()

    @abstractmethod
    def _head(self, path: Path) -> tuple[pa.Schema, dict[str, str]]:
        """The schema of the file, which is then open, and what its metadata say."""

    @abstractmethod
    def _other(self) -> FileError:
        """The error of a file with other columns or rows than its head says."""

    @abstractmethod
    def _batches(self) -> Iterator[pa.RecordBatch]:
        """The batches that are whole."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def batches(self) -> Iterator[pa.RecordBatch]:
        """The rows, some thousand at a time.

        Raises
        ------
        FileError
            A Parquet file that is damaged. A stream ends where it is damaged, and `left` says so; where it had to be
            `whole` it is refused there.
        """
        yield from self._batches()
        if self._whole and (self.left or not self.closed):
            rule = "it was not closed" + (f", and {self.left} cannot be read" if self.left else "")
            raise FileError(self.name, rule, f"subskin recover {self.name}")

    def steps(self) -> Iterator[Step]:
        """The steps that made the rows, in their order.

        Raises
        ------
        FileError
            As `batches`; rows that are not in the order of steps.
        """
        held: Any = None
        for batch in self.batches():
            whole = batch if held is None else joined([held, batch])
            number = whole.column("step").to_numpy()
            if (np.diff(number) < 0).any() or (number < 0).any():
                raise FileError(self.name, "its steps are not in their order", "record it again")
            cut = int(np.searchsorted(number, number[-1])) if number.size else 0  # the last step may go on
            held = whole.slice(cut)
            if held.num_rows > _LONGEST:
                raise FileError(self.name, f"a step has more than {_LONGEST} rows", "record it again")
            yield from self._steps(whole.slice(0, cut))
        if held is not None:
            yield from self._steps(held)

    def _steps(self, rows: pa.RecordBatch) -> Iterator[Step]:
        """The steps of rows that hold each of them whole."""
        if not rows.num_rows:
            return
        column = {name: rows.column(name).to_numpy() for name in ("step", "host_time", "device_time", "sequence",
                                                                  "lost", "bad")}  # fmt: skip
        values = np.column_stack([rows.column(f"raw.{name}").to_numpy() for name in self.about.channels])
        kinds = np.array(rows.column("kind").to_pylist(), dtype=object)
        unknown = set(kinds) - _KINDS
        if unknown:
            raise FileError(self.name, f'a row is of the kind "{unknown.pop()}"', "record it again")
        start = [0, *(np.flatnonzero(np.diff(column["step"])) + 1).tolist()]
        for begin, end in zip(start, [*start[1:], rows.num_rows], strict=True):
            kind, number = kinds[begin], int(column["step"][begin])
            framed = begin + int((kinds[begin:end] == FRAME).sum())
            if kind == EVENT or (kinds[begin:framed] != FRAME).any() or (framed == begin and kind == FRAME):
                raise FileError(self.name, f"the rows of step {number} are not in their order", "record it again")
            host, part = float(column["host_time"][begin]), slice(begin, framed)
            lost, bad = int(column["lost"][begin]), int(column["bad"][begin])
            frames = DeviceFrames(values[part], column["device_time"][part], column["sequence"][part], lost, bad)
            command, told = "", {}
            if kind == COMMAND:
                command = rows.column("name")[begin].as_py()
                told = dict(self._values(rows.column("values")[begin].as_py()))
            yield Step(number, host, frames, command, told, rows.slice(begin, end - begin))

    def _values(self, text: str) -> Mapping[str, Any]:
        try:
            told = json.loads(text) if text else {}
        except (ValueError, RecursionError):
            told = None
        if not isinstance(told, dict):
            raise FileError(self.name, f'a command was given "{text[:40]}"', "record it again")
        return told


class _Stream(OpenRecording):
    """An Arrow IPC stream, be it cut off or damaged: what is whole is given, the rest is said in `left`."""

    def _head(self, path: Path) -> tuple[pa.Schema, dict[str, str]]:
        import pyarrow as pa

        self.closed = False
        try:
            self._file = pa.OSFile(str(path), "rb")  # a map would count the whole file as memory
            self._size: int = self._file.size()
        except (OSError, pa.ArrowException) as error:
            reason = getattr(error, "strerror", None) or error
            raise FileError(self.name, f"it cannot be read ({reason})", "check the name and the permissions") from None
        try:
            self._reader: Any = pa.ipc.open_stream(self._file)
            schema = self._reader.schema
            return schema, {key.decode(): value.decode() for key, value in (schema.metadata or {}).items()}
        except (OSError, ValueError, pa.ArrowException, MemoryError):
            rule = "it is no recording, or it was cut off in its head"
            raise FileError(self.name, rule, "name a file that subskin recorded") from None

    def _other(self) -> FileError:
        rule = "its columns are not those of a recording"
        return FileError(self.name, rule, "name a file that subskin recorded")

    def _batches(self) -> Iterator[pa.RecordBatch]:
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


class _Parquet(OpenRecording):
    """A Parquet file: what differs from its checksum is refused."""

    def _head(self, path: Path) -> tuple[pa.Schema, dict[str, str]]:
        import pyarrow as pa
        import pyarrow.parquet as pq

        try:
            # no buffer_size: a buffered page takes as much memory as its head says, which may be damaged
            self._file = pq.ParquetFile(
                path, page_checksum_verification=True, pre_buffer=False, memory_map=False,
                thrift_string_size_limit=1 << 26, thrift_container_size_limit=1 << 22,
            )  # fmt: skip
            self.rows = int(self._file.metadata.num_rows)
            found = (self._file.metadata.metadata or {}).items()
            told = {key.decode(): value.decode() for key, value in found if key[:8] == b"subskin."}
            return self._file.schema_arrow, {"subskin.rows": "", **told}
        except (OSError, ValueError, pa.ArrowException, MemoryError) as error:
            raise self._damaged(error) from None

    def _other(self) -> FileError:
        rule = "it is damaged: its columns or rows are not those that were written"
        return FileError(self.name, rule, "copy it again")

    def _batches(self) -> Iterator[pa.RecordBatch]:
        import pyarrow as pa

        rows = 0
        batches = self._file.iter_batches(batch_size=batch_size(self.about), use_threads=False)
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
        return FileError(self.name, f"it is damaged, or no Parquet file ({_first(error)})", "copy it again")


_ROWS = 20_000
"""Rows that are written, and read, at once: memory holds no more of them."""
_MOST_CELLS = 4_000_000


def batch_size(about: About) -> int:
    """How many rows of a recording are written, and read, at once."""
    return max(min(_ROWS, _MOST_CELLS // max(len(columns_of(about)), 1)), 1)


@contextmanager
def opened(path: str | Path, *, whole: bool = False) -> Iterator[OpenRecording]:
    """Open a recording: a closed one (Parquet), or a stream that still grows or was cut off (.arrows).

    Parameters
    ----------
    path : path-like
        The file.
    whole : bool, optional
        As of `OpenRecording`.

    Raises
    ------
    FileError
        It cannot be read, is no recording, or is damaged.

    Examples
    --------
    >>> with opened("touch.parquet") as recording:
    ...     recording.about.channels
    Traceback (most recent call last):
    subskin.errors.FileError: touch.parquet: there is no such file. Fix: check the name and the folder.
    """
    if str(path) == "-":
        raise FileError("standard input", "a recording is read from a file", "name a file")
    with opened_file(path) as file:
        start = file.peek(4)[:4]
    if start == b"kind" and str(path).lower().endswith(".csv"):
        rule = "a CSV of a recording has no finger in it, and cannot be replayed or converted"
        raise FileError(str(path), rule, "record .parquet; subskin convert touch.parquet touch.csv makes the CSV of it")
    with (_Parquet if start == b"PAR1" else _Stream)(path_of(path), str(path), whole) as recording:
        yield recording
