"""A recorder: what comes out of a chain goes to a file as it happens, from a thread of its own."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from ..errors import FileError, InvalidValueError, SubskinError
from ..io.files import check_target, path_of
from ..io.finger_file import FingerFile
from .batch import Batch
from .convert import check_kind, convert
from .recording.files import ENDING, Growing
from .recording.layout import About
from .recording.rows import Counted

__all__ = ["Recorder"]

_FRAMES = 50_000
"""Frames that may wait for the disk; whoever brings more waits too."""
_STEPS = 50_000
_WRITE, _SYNC = 0.25, 1.0
"""Seconds between two writes, and between two times that the disk is waited for."""
_ROOM = 1 << 24
"""Numbers that may wait for the disk, where frames have many channels."""


class Channelled(Protocol):
    """What a recorder asks of a driver."""

    @property
    def channels(self) -> Sequence[str]:
        """Names of the raw values, in their order."""


class Recorder:
    r"""Records batches of a chain: nothing is left out, and whoever brings them waits while the disk is behind.

    While it records, the file ends in `.arrows`: an Arrow IPC stream that can be read after a crash (`recover`). Every
    quarter of a second is written, every second the disk has it. `close` makes it into the file that was named.

    A disk that is full ends the recording and not the stream: `failed` says so, `tell` is called once, and the file
    keeps what it has.

    Parameters
    ----------
    path : path-like
        The recording: .parquet, or what `convert` can write; .arrows stays as it is.
    file : FingerFile
        The finger; its text goes into the recording.
    driver : driver
        Whose `channels` are the names of the raw values, in their order.
    options : mapping, optional
        With which the chain was made.
    tell : callable, optional
        Called with one text when the recording had to end.
    epoch : float, optional
        Seconds since 1970 (UTC) at which the host's clock showed 0 [s]; by the clocks of this machine if left out.

    Raises
    ------
    FileError
        The file cannot be made, or there is one already.

    Examples
    --------
    >>> import tempfile
    >>> from subskin.io import parse_finger
    >>> file = parse_finger("skin = {young = 4e5}\nsensors = {y = [0.0], depth = 2e-3}")
    >>> class Board:
    ...     channels = ("p0",)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with Recorder(f"{folder}/touch.parquet", file, Board()) as recorder:
    ...         during = [path.name for path in Path(folder).iterdir()]
    ...     during, [path.name for path in Path(folder).iterdir()], recorder.failed
    (['touch.parquet.arrows'], ['touch.parquet'], '')
    """

    def __init__(
        self,
        path: str | Path,
        file: FingerFile,
        driver: Channelled,
        *,
        options: Mapping[str, Any] | None = None,
        tell: Callable[[str], object] | None = None,
        epoch: float | None = None,
    ) -> None:
        self.path = path_of(path)
        kept = self.path.name.endswith(ENDING)
        if not kept:
            check_kind(self.path)
            check_target(self.path)
        if self.path.exists():
            raise FileError(str(path), "there is such a file already", "name another one, or move it away")
        began = time.time() - time.monotonic() if epoch is None else epoch
        called = getattr(driver, "name", type(driver).__name__)
        self.about = About.for_finger(file, driver.channels, began, called, options)
        self._part = self.path if kept else self.path.with_name(self.path.name + ENDING)
        self._file = Growing(self._part, self.about)
        self._tell, self.failed = tell, ""
        self.frames = 0
        self._counted = Counted(self.about)
        self._most = max(min(_FRAMES, _ROOM // (len(self.about.channels) + len(self.about.names))), 1)
        self._waiting: list[Batch] = []
        self._count, self._closing, self._closed = 0, False, False
        self._change = threading.Condition()
        self._ended = threading.Event()
        self._threads = [
            threading.Thread(target=does, name=f"subskin {name}", daemon=True)
            for name, does in (("recorder", self._run), ("disk", self._keep))
        ]
        for thread in self._threads:
            thread.start()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def put(self, batch: Batch) -> None:
        """Take what came out of a step of the chain; waits while too much is still to be written.

        Parameters
        ----------
        batch : Batch
            It; of a recording that has `failed` it is let go.

        Raises
        ------
        InvalidValueError
            The recording is closed, or the frames have other channels.
        """
        if batch.raw.shape[1:] != (len(self.about.channels),):
            rule = f"the recording has {len(self.about.channels)} channels"
            raise InvalidValueError(f"raw values of shape {batch.raw.shape}", rule, "make a new recording")
        with self._change:
            if self._closing:
                raise InvalidValueError(f"{self.path}", "the recording is closed", "make a new one")
            while (
                not self.failed
                and self._waiting
                and (self._count + len(batch.raw) > self._most or len(self._waiting) >= _STEPS)
            ):
                self._change.notify_all()
                self._change.wait(_SYNC)
            if not self.failed:
                self._waiting.append(batch)
                self._count += len(batch.raw)

    def close(self) -> str:
        """Write the rest, and make the file that was named; the same again where it is closed.

        Returns
        -------
        str
            `failed`: "" where all went well, or what is left, and where.
        """
        with self._change:
            self._closing = True
            self._change.notify_all()
        for thread in self._threads:
            thread.join()
        if not self._closed:
            self._closed = True
            self._file.close()
            if self._part != self.path and not self.failed:
                try:
                    convert(self._part, self.path)
                    self._part.unlink()
                except (SubskinError, OSError) as error:
                    self._fail(error, f"{self._part} holds what was recorded")
        return self.failed

    def _run(self) -> None:
        """Write what waits, some times a second."""
        closing = False
        try:
            while not closing and not self.failed:
                with self._change:
                    if not self._closing and self._count < self._most // 2:
                        self._change.wait(_WRITE)
                    batches, self._waiting, self._count = self._waiting, [], 0
                    closing = self._closing
                    self._change.notify_all()
                if batches:
                    self._file.append(self._counted.rows(batches))
                    self.frames = self._counted.frames
            if not self.failed:
                self._file.end()
        except Exception as error:  # the stream goes on, whatever it is
            self._fail(error, self._kept)
        finally:
            self._ended.set()

    def _keep(self) -> None:
        """Wait for the disk each second; a slow one does not keep others from writing."""
        while not self._ended.wait(_SYNC):
            try:
                self._file.sync()
            except OSError as error:
                self._fail(error, self._kept)
                return

    @property
    def _kept(self) -> str:
        return f"{self._part} keeps the {self.frames} frames before it"

    def _fail(self, error: Exception, kept: str) -> None:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        with self._change:
            told = f"{self.path}: the recording has ended ({reason}): {kept}"
            first, self.failed = not self.failed, self.failed or told
            self._waiting, self._count = [], 0
            self._change.notify_all()
        if first and self._tell is not None:
            self._tell(told)
