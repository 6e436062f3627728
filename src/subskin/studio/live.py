"""The live view: a device, or a recording that is played; one at a time, which all pages see."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from ..errors import FileError, InvalidValueError, SubskinError
from ..io.finger_file import FingerFile
from ..live.recording.source import opened
from ..live.replay import Replay
from ..live.run import live
from .feed import Fed, Feed, Track
from .view import FromPage, asked, done, drawn

__all__ = ["LiveView"]

_WAIT = 0.05
_SLIP = re.compile(r"\s*(\d*\.?\d+)\s*(?:\.\.\s*(\d*\.?\d+)\s*)?")
_RECORDINGS = (".parquet", ".arrows")


class Start(FromPage):
    """What a page asks to be followed."""

    port: str = Field(max_length=500)
    driver: str = Field(default="", max_length=200)
    slip: str = Field(default="", max_length=40)
    fit: str = Field(default="", max_length=40)
    begin: float = Field(default=0.0, ge=0.0, le=1e7)
    speed: Annotated[float, Field(gt=0.0, le=1000.0)] = 1.0


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

    def told(self) -> dict[str, Any]:
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
        try:
            self._live.record(path, late=True)
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

    def told(self) -> dict[str, Any]:
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


class LiveView(Fed[Feed]):
    """What a device or a recording says; the same for all pages.

    Parameters
    ----------
    wake, file
        As of `Fed`.
    first : str, optional
        What is offered at the beginning: the device or recording of the command.
    """

    def __init__(
        self, wake: Callable[[], object], file: Callable[[str | None], FingerFile], first: str | None = None
    ) -> None:
        super().__init__(wake, file)
        self.first = first or "demo"

    @asked
    def begin(self, finger: str | None = None) -> dict[str, Any]:
        """The finger of what runs, or else the one that would."""
        track = self._track
        file = self._file(finger) if track is None else track.file
        return {"first": self.first, **self.history(), **drawn(file, file.finger.relative)}

    @asked
    def history(self) -> dict[str, Any]:
        """All steps that are kept of what runs."""
        return {"history": [] if self._track is None else self._track.history()}

    @done
    def start(self, start: Start, finger: str | None = None) -> None:
        """Follow a device, or play a recording."""
        if start.port.lower().endswith(_RECORDINGS):
            self._follow(PlayedFeed(start.port, self._tell, begin=start.begin, speed=start.speed))
            return
        options: dict[str, Any] = {name: value for name in ("driver", "fit") if (value := getattr(start, name))}
        if start.slip.strip():
            options["slip"] = _friction(start.slip)
        self._follow(DeviceFeed(self._file(finger), start.port or None, options, self._tell))

    @done
    def stop(self) -> None:
        """Stop what runs."""
        self.close()

    @done
    def seek(self, begin: float = 0.0, speed: float = 1.0) -> None:
        """Play the recording from another time on."""
        if not isinstance(self.feed, PlayedFeed):
            raise _nothing("seek")
        speed = min(max(speed, 0.05), 100.0)
        self._follow(PlayedFeed(self.feed.name, self._tell, begin=max(begin, 0.0), speed=speed))

    @done
    def zero(self) -> None:
        """Nothing touches now."""
        self._device("zero").zero()

    @done
    def mark(self, text: str = "") -> None:
        """An event with a text."""
        self._device("mark").mark(text[:200] or "mark")

    @done
    def record(self, on: bool = False) -> None:
        """Begin to record, or stop."""
        self._device("record").record(on, Path.cwd())

    @property
    def _track(self) -> Track | None:
        return None if self.feed is None else self.feed.track

    def _device(self, do: str) -> DeviceFeed:
        if not isinstance(self.feed, DeviceFeed):
            raise _nothing(do)
        return self.feed


def _nothing(do: str) -> InvalidValueError:
    return InvalidValueError(f"live: {do}", "nothing runs for which that could be done", "start a device first")


def _friction(text: str) -> float | tuple[float, float]:
    match = _SLIP.fullmatch(text)
    if match is None:
        raise InvalidValueError(f'friction "{text}"', "a number or a range is needed", "0.5, or 0.4..0.8")
    low = float(match[1])
    return low if match[2] is None else (low, float(match[2]))
