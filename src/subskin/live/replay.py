"""A recording run again: the same steps through a chain, which gives the same bits, or another finger's answers."""

from __future__ import annotations

import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _check
from ..errors import FileError, InvalidValueError
from ..io.finger_file import FingerFile, parse_finger
from .batch import Batch
from .chain import Chain, ChainState
from .recording.layout import EVENT, About, columns_of, joined
from .recording.rows import Counted, rows_of
from .recording.source import OpenRecording, Step, opened

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["Replay", "replay"]

_AT_ONCE = 2000


class Replay:
    r"""The steps of an open recording, run through a chain once.

    Parameters
    ----------
    recording : OpenRecording
        An open recording.
    file : FingerFile, optional
        Another finger; that of the recording if left out.
    speed : float, optional
        How many times as fast as it happened; as fast as it can if left out.
    begin, end : float, optional
        Seconds since its first step between which it is shown [s]. What comes before runs unseen: the chain needs it.

    Raises
    ------
    InvalidValueError
        A speed that is not above 0, or an end before the beginning.
    FileError
        A recording without a finger, or a finger whose file is wrong.

    Examples
    --------
    >>> import tempfile
    >>> from subskin.live import DeviceFrames, Recorder
    >>> text = "skin = {young = 4e5}\nsensors = {count = 4, pitch = 2e-3, depth = 2e-3, noise = 1e-4}"
    >>> file = parse_finger(text)
    >>> class Board:
    ...     channels = file.names
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with Recorder(f"{folder}/touch.parquet", file, Board()) as recorder:
    ...         state, batch = Chain(file).step(None, DeviceFrames(np.zeros((3, 4)), [0.0, 0.1, 0.2]), 7.0)
    ...         recorder.put(batch)
    ...     with opened(f"{folder}/touch.parquet") as recording:
    ...         again = Replay(recording)
    ...         frames = sum(len(batch) for batch in again)
    >>> frames, again.same.rows, again.same.others
    (3, 3, 0)
    """

    def __init__(
        self,
        recording: OpenRecording,
        file: FingerFile | None = None,
        *,
        speed: float | None = None,
        begin: float = 0.0,
        end: float = np.inf,
    ) -> None:
        if speed is not None:
            _check.scalar("speed", speed, above=0.0, fix="speed=1 is as it happened")
        begin, end = (
            _check.scalar(name, time, unit="s", finite=False) for name, time in (("begin", begin), ("end", end))
        )
        if not begin <= end:
            raise InvalidValueError(f"from {begin} to {end} s", "it has to end after it begins", "swap them")
        _check.noun("recording", recording, OpenRecording, 'with open_recording("touch.parquet") as recording: ...')
        old = recording.about
        if file is None and not old.finger:
            raise FileError(recording.name, "it holds no finger file", "--finger finger.toml")
        if file is None and _in_place(old.finger):
            rule = "its finger goes by a response in a file of its own, which a recording does not hold"
            raise FileError(recording.name, rule, "--finger with the file of that finger, its response beside it")
        self.recording, self.name = recording, recording.name
        self.file = parse_finger(old.finger, f"the finger in {recording.name}") if file is None else file
        self.chain = Chain(self.file, channels=old.channels, **old.options)
        self.about = About.for_finger(self.file, old.channels, old.epoch, old.driver, self.chain.options)
        self.same: Compared | None = Compared(old) if file is None else None
        """Which rows came out as they were recorded; None with another finger."""
        self._speed, self._begin, self._end = speed, begin, end
        self._start = 0.0
        self._first: float | None = None
        self.frames = self.lost = self.bad = 0
        self.port, self.recorder = self, None
        """As a live stream has them: the clock is its own, and nothing records it."""

    def __iter__(self) -> Iterator[Batch]:
        """What comes out of the chain, step by step.

        Raises
        ------
        FileError
            The recording is damaged.
        """
        state: ChainState | None = None
        self._start = time.monotonic()
        for step in self.recording.steps():
            state, batch = self.chain.step(state, step.frames, step.host_time, step.command, step.values)
            if self.same is not None:
                self.same.add(step, batch)
            self._first = step.host_time if self._first is None else self._first
            at = step.host_time - self._first
            if at > self._end:
                break
            if at < self._begin:
                self._start = time.monotonic()
                continue
            if self._speed is not None:
                time.sleep(max(self._start + (at - max(self._begin, 0.0)) / self._speed - time.monotonic(), 0.0))
            self.frames += len(batch.raw)
            self.lost += batch.lost
            self.bad += batch.bad
            yield batch

    def clock(self) -> float:
        """What time it is in the recording while it is shown at a speed, by the host's clock of then [s]."""
        first = 0.0 if self._first is None else self._first
        return first + max(self._begin, 0.0) + (time.monotonic() - self._start) * (self._speed or 0.0)

    def batches(self, see: Callable[[Batch], object] | None = None) -> Iterator[pa.RecordBatch]:
        """The same as rows of a new recording.

        Parameters
        ----------
        see : callable, optional
            Called with what comes out of each step.

        Raises
        ------
        FileError
            The recording is damaged.
        """
        counted, held, frames = Counted(self.about), [], 0
        for batch in self:
            if see is not None:
                see(batch)
            held.append(batch)
            frames += len(batch.raw)
            if frames >= _AT_ONCE or len(held) >= _AT_ONCE:
                yield counted.rows(held)
                held, frames = [], 0
        yield counted.rows(held)


class Compared:
    """Counts rows that came out as they were recorded, to the last bit.

    Parameters
    ----------
    about : About
        What is recorded.
    """

    def __init__(self, about: About) -> None:
        self._about = about
        self._steps: list[Step] = []
        self._made: list[Batch] = []
        self._rows = self._other = 0
        self.different: set[str] = set()
        """The columns in which some row differs."""

    def add(self, step: Step, batch: Batch) -> None:
        """Take what was recorded of a step, and what came out now."""
        self._steps.append(step)
        self._made.append(batch)
        if len(self._steps) >= _AT_ONCE:
            self._look()

    @property
    def rows(self) -> int:
        """How many rows were looked at."""
        self._look()
        return self._rows

    @property
    def others(self) -> int:
        """How many of these differ."""
        self._look()
        return self._other

    def _look(self) -> None:
        if not self._steps:
            return
        before = joined([step.rows for step in self._steps])
        now = rows_of(self._about, self._made)
        self._steps, self._made = [], []
        for events in (False, True):  # of events there may be others; all else is row by row what went in
            self._row_by_row(_some(before, events), _some(now, events), events)

    def _row_by_row(self, before: pa.RecordBatch, now: pa.RecordBatch, events: bool) -> None:
        count = min(before.num_rows, now.num_rows)
        most = max(before.num_rows, now.num_rows)
        self._rows += most
        self._other += most - count
        if most > count:
            self.different.add("events")
        wrong = np.zeros(count, dtype=bool)
        for name, kind in columns_of(self._about).items():
            if name not in ("step", "frame"):  # numbers of the rows themselves
                differs = _differs(before.column(name)[:count], now.column(name)[:count], kind)
                if differs.any():
                    self.different.add("events" if events else name)
                wrong |= differs
        self._other += int(wrong.sum())


def _some(rows: pa.RecordBatch, events: bool) -> pa.RecordBatch:
    import pyarrow as pa

    kinds = np.array(rows.column("kind").to_pylist(), dtype=object)
    return rows.filter(pa.array((kinds == EVENT) == events))


def _differs(before: Any, now: Any, kind: str) -> Any:
    a, b = (column.to_numpy(zero_copy_only=kind != "string") for column in (before, now))
    if kind != "double":
        return a != b
    return (a.view(np.int64) != b.view(np.int64)) & ~(np.isnan(a) & np.isnan(b))


def _in_place(finger: str) -> bool:
    """Whether a finger file goes by a response in place; what is no TOML is said where it is read."""
    try:
        table = tomllib.loads(finger).get("calibration")
    except tomllib.TOMLDecodeError:
        return False
    return isinstance(table, dict) and "response" in table


def replay(
    path: str | Path,
    file: FingerFile | None = None,
    *,
    speed: float | None = None,
    begin: float = 0.0,
    end: float = np.inf,
) -> Iterator[Batch]:
    """What a chain makes of a recording, step by step: what it made when it was recorded, to the last bit.

    Parameters
    ----------
    path : path-like
        The recording.
    file, speed, begin, end
        As of `Replay`.

    Raises
    ------
    FileError, InvalidValueError
        As `Replay`, and a recording that cannot be read.

    Examples
    --------
    >>> next(replay("touch.parquet"))
    Traceback (most recent call last):
    subskin.errors.FileError: touch.parquet: there is no such file. Fix: check the name and the folder.
    """
    with opened(path) as recording:
        yield from Replay(recording, file, speed=speed, begin=begin, end=end)
