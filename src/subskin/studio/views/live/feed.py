"""Where a live view's batches come from: a device, or a recording that is played; each in a thread of its own."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ....errors import FileError, SubskinError
from ....io.finger_file import FingerFile
from ....live.record import Recorder
from ....live.recording.source import opened
from ....live.replay import Replay
from ....live.run import live
from .track import Track

__all__ = ["DeviceFeed", "Feed", "PlayedFeed"]

_WAIT = 0.05


class Feed(ABC):
    """What runs in the thread; `tell` is called when there is something new.

    Parameters
    ----------
    name : str
        Of the device or the recording.
    tell : callable
        Called from the thread.
    """

    def __init__(self, name: str, tell: Callable[[], object]) -> None:
        self.name, self._tell = name, tell
        self.track: Track | None = None
        self.state, self.fault = "starting", ""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="subskin studio live", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def close(self) -> None:
        """End, and wait for it."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(10.0)

    def told(self) -> dict[str, Any]:
        """What a page is told."""
        track = self.track
        return {"name": self.name, "run": self.state, "fault": self.fault, **({} if track is None else track.told())}

    def _run(self) -> None:
        try:
            self._follow()
            self.state = "ended"
        except (SubskinError, OSError) as error:
            self.state, self.fault = "failed", str(error)
        self._tell()

    @abstractmethod
    def _follow(self) -> None:
        """Take batches until their source ends or `_stop` is set."""


class DeviceFeed(Feed):
    """A device, through `subskin.live`.

    Parameters
    ----------
    file : FingerFile
        The finger.
    port : str or None
        Where it is; None for what [live] of the file names.
    options : mapping
        Of `subskin.live`: driver, fit, slip.
    tell : callable
        As of `Feed`.
    """

    def __init__(self, file: FingerFile, port: str | None, options: dict[str, Any], tell: Callable[[], object]) -> None:
        super().__init__(port or "the device of the file", tell)
        self._file, self._port, self._options = file, port, options
        self._live: Any = None
        self._orders: list[Callable[[], object]] = []
        self.recording = self.recorded = ""

    def zero(self) -> None:
        """Nothing touches now."""
        if self._live is not None:
            self._live.zero()

    def mark(self, text: str) -> None:
        """An event with a text.

        Parameters
        ----------
        text : str
            What it says.
        """
        if self._live is not None:
            self._live.mark(text)

    def record(self, on: bool, folder: Path) -> None:
        """Begin to record into the folder, or stop.

        Parameters
        ----------
        on : bool
            Which of the two.
        folder : Path
            Where the file goes.
        """
        self._orders.append(lambda: self._begin_recording(folder) if on else self._end_recording())

    def told(self) -> dict[str, Any]:  # noqa: D102
        live = self._live
        more = {} if live is None else {"frames": live.frames, "lost": live.lost, "bad": live.bad}
        return {**super().told(), **more, "kind": "device", "recording": self.recording, "recorded": self.recorded}

    def _follow(self) -> None:
        # the chain is prepared before the first byte is read
        self._live = live(self._file, self._port, **self._options)
        self.track = Track(self._live.chain.file)
        self.state = "running"
        self._tell()
        try:
            while not (self._stop.is_set() or self._live.ended):
                while self._orders:
                    self._orders.pop(0)()
                batches = self._live.take(_WAIT)
                now = self._live.port.clock()
                for batch in batches:
                    self.track.see(batch, max(now - batch.host_time, 0.0))
                if batches:
                    self._tell()
                if self._live.recorder is not None and self._live.recorder.failed:
                    self.fault = self._live.recorder.failed
                    self._end_recording()
        finally:
            self._live.close()
            if self.recording:
                self.recording, self.recorded = "", self.recording

    def _begin_recording(self, folder: Path) -> None:
        if self._live.recorder is not None:
            return
        path = folder / time.strftime("touch-%Y%m%d-%H%M%S.parquet")
        chain, port = self._live.chain, self._live.port
        try:
            self._live.recorder = Recorder(
                path, chain.file, self._live.driver, options=chain.options, epoch=time.time() - port.clock()
            )
            self.recording, self.fault = str(path), ""
        except (SubskinError, ModuleNotFoundError) as error:
            self.fault = str(error)
        self._tell()

    def _end_recording(self) -> None:
        recorder, self._live.recorder = self._live.recorder, None
        if recorder is not None:
            recorder.close()
            self.recording, self.recorded = "", recorder.failed or self.recording
        self._tell()


class PlayedFeed(Feed):
    """A recording, played at a speed from a time on; it is paused by being stopped.

    Parameters
    ----------
    path : str
        The recording.
    tell : callable
        As of `Feed`.
    begin : float, optional
        Seconds since its first frame from which on it is shown [s].
    speed : float, optional
        How many times as fast as it happened.
    """

    def __init__(self, path: str, tell: Callable[[], object], *, begin: float = 0.0, speed: float = 1.0) -> None:
        super().__init__(path, tell)
        self.begin, self.speed = begin, speed
        self.at, self.whole = begin, 0.0

    def told(self) -> dict[str, Any]:  # noqa: D102
        return {**super().told(), "kind": "recording", "at": self.at, "whole": self.whole, "speed": self.speed}

    def _follow(self) -> None:
        self.whole = _length(self.name)
        with opened(self.name) as recording:
            played = Replay(recording, speed=self.speed, begin=self.begin)
            self.track = Track(played.file)
            self.state = "running"
            first: float | None = None
            shown = -1.0
            for batch in played:
                if self._stop.is_set():
                    return
                first = batch.host_time - self.begin if first is None else first
                self.at = batch.host_time - first
                self.track.see(batch, 0.0)
                if time.monotonic() - shown > 0.012:
                    shown = time.monotonic()
                    self._tell()


def _length(path: str) -> float:
    """How long a recording is [s]."""
    first = last = None
    with opened(path) as recording:
        for step in recording.steps():
            first = step.host_time if first is None else first
            last = step.host_time
    if first is None or last is None:
        raise FileError(path, "there is nothing in it", "record again")
    return last - first
