"""A recording read again, whichever of its two files it is; and what is left of a damaged one, made whole again."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..._frozen import Frozen
from ...errors import FileError
from ...io.files import apart, check_target, path_of, replacing
from ...io.files import opened as opened_file
from ..frames import DeviceFrames
from .files import ENDING, ParquetRecording, StreamReader, write_parquet
from .layout import COMMAND, EVENT, FRAME, STEP, About, joined

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["OpenRecording", "Recovered", "RowSource", "Step", "opened", "recover"]

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


class OpenRecording:
    """A recording that is open; made by `opened`.

    Parameters
    ----------
    source : StreamReader or ParquetRecording
        What reads the file.
    whole : bool
        Refuse what was not closed, or is damaged, where its readable part ends.
    """

    def __init__(self, source: StreamReader | ParquetRecording, whole: bool = False) -> None:
        self._source, self._whole = source, whole
        self.about: About = source.about
        self.name: str = source.name

    @property
    def left(self) -> str:
        """What could not be read, known after `batches` has ended; "" where all could."""
        return self._source.left if isinstance(self._source, StreamReader) else ""

    @property
    def closed(self) -> bool:
        """Whether the recording was closed, known after `batches` has ended; a stream that was killed was not."""
        return self._source.closed if isinstance(self._source, StreamReader) else True

    @property
    def rows(self) -> int | None:
        """How many rows there are; None of a stream, which does not know."""
        return None if isinstance(self._source, StreamReader) else self._source.rows

    def batches(self) -> Iterator[pa.RecordBatch]:
        """The rows, some thousand at a time.

        Raises
        ------
        FileError
            A Parquet file that is damaged. A stream ends where it is damaged, and `left` says so; where it had to be
            `whole` it is refused there.
        """
        yield from self._source
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
    reader = ParquetRecording if start == b"PAR1" else StreamReader
    with reader(path_of(path), str(path)) as source:
        yield OpenRecording(source, whole)


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

            def rest() -> Iterator[pa.RecordBatch]:
                yield first
                yield from batches

            rows = write_parquet(part, recording.about, rest(), "recovered")
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
