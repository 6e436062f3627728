"""A live stream: a port is read, and what it gives goes through the chain, batch by batch."""

from __future__ import annotations

import asyncio
import threading
import time
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ..errors import InvalidValueError
from ..finger import Finger
from ..io.finger_file import FingerFile, load
from .batch import BareChain, Batch, RingBuffer
from .chain import Chain, file_of
from .connecting import connected
from .drivers import Driver
from .frames import DeviceFrames
from .ports import Port, PortEnded, PortLost

if TYPE_CHECKING:
    from .record import Recorder

__all__ = ["Live", "live"]

_POLL = 0.1
"""Seconds that a read may wait for the first byte."""
_AGAIN = 0.5
"""Seconds between two tries to open a port that is lost."""
_AT_ONCE = 1 << 20
"""Bytes that go through the chain as one batch at most, where whoever takes the batches was away."""
_WAITING = 1 << 26
"""Bytes that wait at most; the reader then waits too, and the device's frames are lost where it says so."""


class Live:
    """A device, read by a thread of its own; its batches are iterated over, by `for` or by `async for`.

    The thread does nothing but read, so that no byte waits in a buffer of the system that is small. All bytes that
    have come since the last batch make the next one: whoever is slow gets larger batches, never older ones. Each batch
    is recorded before it is handed on.

    Parameters
    ----------
    chain : Chain or BareChain
        What is made of the frames.
    port : Port
        Where the bytes come from; it is closed at the end.
    driver : Driver
        What finds the frames in them.
    recorder : Recorder, optional
        Takes each batch before it is handed on; it is closed at the end.
    seconds : float, optional
        How far back `ring` reaches [s].
    """

    def __init__(
        self,
        chain: Chain | BareChain,
        port: Port,
        driver: Driver,
        recorder: Recorder | None = None,
        seconds: float = 120.0,
    ) -> None:
        self.chain, self.port, self.driver, self.ring = chain, port, driver, RingBuffer(seconds)
        self.state: Any = None
        self.frames = self.lost = self.bad = 0
        self.ended = False
        self.recorder = recorder
        self._waiting: deque[tuple[float, bytes | str, Mapping[str, Any]]] = deque()
        self._bytes = 0
        self._change = threading.Condition()
        self._closing = threading.Event()
        self._failed: BaseException | None = None
        self._wake: Callable[[], object] | None = None
        self._seen: Callable[[float, bytes | str, Mapping[str, Any]], object] | None = None
        self._cut = -np.inf
        self._nothing = DeviceFrames(np.empty((0, len(driver.channels))))
        self._thread = threading.Thread(target=self._read, name="subskin reader", daemon=True)
        self._started = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def start(self, seen: Callable[[float, bytes | str, Mapping[str, Any]], object] | None = None) -> None:
        """Begin to read; the first batch that is asked for does so too.

        Parameters
        ----------
        seen : callable, optional
            Until the first batch is asked for it is given what is read, in the reader's thread: when it came [s], the
            bytes or the command, and the command's values. Tenths of a second become batches of their own meanwhile.
        """
        if not self._started:
            self._started, self._seen = True, seen
            self._thread.start()

    def record(self, path: str | Path, *, late: bool = False) -> None:
        """Record all of it, before the first batch is asked for.

        Parameters
        ----------
        path : path-like
            The recording, as of `Recorder`.
        late : bool, optional
            Record from here on, when batches have been taken: a replay begins with the skin as it is then.

        Raises
        ------
        FileError
            The file cannot be made, or there is one already.
        InvalidValueError
            Batches have been taken already, or they are of a chain that finds nothing.
        """
        from .record import Recorder

        if (self.state is not None and not late) or not isinstance(self.chain, Chain):
            rule = "a recording has all batches of a chain, from the first on"
            raise InvalidValueError(f'record("{path}")', rule, "live(file, port, record=...)")
        epoch = time.time() - self.port.clock()
        self.recorder = Recorder(path, self.chain.file, self.driver, options=self.chain.options, epoch=epoch)

    def close(self) -> None:
        """Stop reading, tell the device to stop, and close the port; more than once does no harm."""
        if self._closing.is_set():
            return
        self._closing.set()
        with self._change:
            self._change.notify_all()
        if self._started:
            self._thread.join(10.0)
        with suppress(PortLost):
            if self.driver.stop:
                self.port.write(self.driver.stop)
        self.port.close()
        if self.recorder is not None:
            self.recorder.close()

    def zero(self) -> None:
        """Nothing touches now: what is read are the offsets."""
        self._put(self.port.clock(), "zero", {})

    def mark(self, text: str) -> None:
        """Put an event with a text into the stream, and into the recording.

        Parameters
        ----------
        text : str
            What it says.
        """
        self._put(self.port.clock(), "mark", {"text": text})

    def take(self, timeout: float = _POLL) -> list[Batch]:
        """All that has come since the last call, as one batch, with a batch for each command in between.

        Parameters
        ----------
        timeout : float, optional
            How long to wait where nothing has come [s]; then there is no batch.

        Raises
        ------
        SubskinError, OSError
            Whatever stopped the reader.
        """
        self.start()
        with self._change:
            if not self._waiting and not self.ended and self._failed is None:
                self._change.wait(timeout)
        return self._batches()

    def __iter__(self) -> Iterator[Batch]:
        while not (self.ended or self._closing.is_set()):
            yield from self.take()

    async def __aiter__(self) -> AsyncIterator[Batch]:
        """The batches, without a thread that waits in the loop."""
        loop, come = asyncio.get_running_loop(), asyncio.Event()
        self._wake = lambda: loop.call_soon_threadsafe(come.set)
        self.start()
        try:
            while not (self.ended or self._closing.is_set()):
                with suppress(TimeoutError):
                    await asyncio.wait_for(come.wait(), _AGAIN)
                come.clear()
                for batch in self._batches():
                    yield batch
        finally:
            self._wake = None

    def _batches(self) -> list[Batch]:
        self._seen = None
        with self._change:
            items: list[tuple[float, bytes | str, Mapping[str, Any]]] = []
            size = 0
            while self._waiting and size < _AT_ONCE:
                items.append(self._waiting.popleft())
                size += len(items[-1][1]) if isinstance(items[-1][1], bytes) else 0
            self._bytes -= size
            failed, rest = self._failed, bool(self._waiting)
            self._change.notify_all()
        if rest and self._wake is not None:
            self._wake()
        made, chunks, at = [], [], 0.0
        for host, what, values in items:
            if isinstance(what, bytes):
                chunks.append(what)
                at = host
                continue
            if chunks:
                made += self._fed(b"".join(chunks), at)
                chunks = []
            if what == "cut":
                continue
            if what == "ended":
                self.ended = True
                continue
            if what == "port_back":
                self.driver.reset()
            made.append(self._step(self._nothing, host, what, values))
        if chunks:
            made += self._fed(b"".join(chunks), at)
        if failed is not None and not made and not rest:  # what came before it is handed on first
            self.ended = True
            raise failed
        return made

    def _fed(self, data: bytes, host: float) -> list[Batch]:
        frames = self.driver.feed(data)
        return [self._step(frames, host)] if len(frames) or frames.lost or frames.bad else []

    def _step(
        self, frames: DeviceFrames, host: float, command: str = "", values: Mapping[str, Any] | None = None
    ) -> Batch:
        self.state, batch = self.chain.step(self.state, frames, host, command, values)
        self.frames += len(batch)
        self.lost += batch.lost
        self.bad += batch.bad
        if self.recorder is not None:
            self.recorder.put(batch)
        self.ring.take(batch)
        return batch

    def _put(self, host: float, what: bytes | str, values: Mapping[str, Any]) -> None:
        seen = self._seen
        if seen is not None:
            seen(host, what, values)
        with self._change:
            while self._bytes > _WAITING and not self._closing.is_set():
                self._change.wait(_POLL)
            if seen is not None and host - self._cut > _POLL:
                self._waiting.append((host, "cut", {}))
                self._cut = host
            self._waiting.append((host, what, values))
            self._bytes += len(what) if isinstance(what, bytes) else 0
            self._change.notify_all()
        wake = self._wake
        if wake is not None:
            with suppress(RuntimeError):  # the loop is closed
                wake()

    def _read(self) -> None:
        """The reader's thread."""
        try:
            if self.driver.start:
                self.port.write(self.driver.start)
            while not self._closing.is_set():
                try:
                    data = self.port.read(_POLL)
                except PortLost as lost:
                    self._put(self.port.clock(), "port_lost", {"text": str(lost)})
                    if self._reopened():
                        self._put(self.port.clock(), "port_back", {})
                    continue
                if data:
                    self._put(self.port.clock(), data, {})
        except PortEnded:
            self._put(self.port.clock(), "ended", {})
        except Exception as error:
            self._failed = error
            with self._change:
                self._change.notify_all()
            if self._wake is not None:
                self._wake()

    def _reopened(self) -> bool:
        """Try until the port is there again, or reading is to stop."""
        while not self._closing.wait(_AGAIN):
            with suppress(PortLost):
                self.port.reopen()
                if self.driver.start:
                    self.port.write(self.driver.start)
                return True
        return False


def live(
    file: FingerFile | Finger | str | Path,
    port: Port | str | None = None,
    driver: Driver | str | Mapping[str, Any] | None = None,
    *,
    rate: float | None = None,
    record: str | Path | None = None,
    prepare: bool = True,
    seconds: float = 120.0,
    **options: Any,
) -> Live:
    """A device, read live: iterate over it, and each batch says what touches; as `subskin.live(...)` too.

    Parameters
    ----------
    file : FingerFile or Finger or path-like
        The finger.
    port : Port or str, optional
        Where its bytes come from, as `subskin.live.ports.opened` takes it: "serial:/dev/ttyACM0?baud=115200",
        "tcp:host:port", "ws://host:port", "file:log.bin", "-", "demo". [live] of the file if left out.
    driver : Driver or str or mapping, optional
        What finds the frames in the bytes: "anyskin", "lines?sensors=4", ..., or a table as under [live]. What the
        port knows, or [live] of the file, if left out.
    rate : float, optional
        Of a file of bytes whose frames have no times: how many came a second [1/s]. It is played as fast as they came.
    record : path-like, optional
        Where to record all of it.
    prepare : bool, optional
        Tabulate and compile before the first byte is read. Without it the first batches wait for that.
    seconds : float, optional
        How far back `Live.ring` reaches [s].
    **options
        Of the `Chain`: fit, slip, overload, drift, friction, ...

    Returns
    -------
    Live
        Close it, or use it in a `with`.

    Raises
    ------
    FileError, InvalidValueError, GeometryError, PortLost
        A finger, a driver or an option that does not fit; nothing is at the port.

    Examples
    --------
    >>> import subskin as ss
    >>> ss.live("finger.toml", port="demo")
    Traceback (most recent call last):
    subskin.errors.FileError: finger.toml: there is no such file. Fix: check the name and the folder.
    """
    file = load(file) if isinstance(file, str | Path) else file_of(file)
    where, reads = connected(file, port, driver, rate)
    try:
        chain = Chain(file, channels=reads.channels, **options)
        if prepare:
            chain.prepare()
        made = Live(chain, where, reads, seconds=seconds)
        if record is not None:
            made.record(record)
        return made
    except BaseException:
        where.close()
        raise
