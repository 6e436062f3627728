"""What `subskin live` shows while loops are compiled: a second process finds what touches without them, and draws it.

The first process compiles. It keeps all that is read, so that nothing is lost, and hands the newest frames to the
second, in which Numba is off.
"""

from __future__ import annotations

import _thread
import copy
import logging
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any, NamedTuple, Self

import numpy as np

from .._check import FloatArray
from .._compiling import when_compiling
from ..io.finger_file import FingerFile
from ..live.chain import COMMANDS, Chain
from ..live.drivers import Driver
from ..live.events import Event
from ..live.frames import DeviceFrames
from ..live.run import Live
from .live_view import Bars, PlainLines

__all__ = ["Preview", "main"]

_EACH = 0.2
"""Seconds between two answers: what they cost is taken from the compiler."""
_FEW = 4
"""Frames of an answer."""
_PATIENCE = 2.0
"""Seconds within which the second process has to end."""


class _Setup(NamedTuple):
    """What the second process is told first."""

    file: FingerFile
    channels: tuple[str, ...]
    options: dict[str, Any]
    bars: bool
    began: float


class _Few(NamedTuple):
    """The newest frames of a read, or a command."""

    host: float
    values: FloatArray
    time: FloatArray
    command: str = ""


class Preview:
    """Shows a stream from when a loop has to be compiled to the end of the context; nothing where all were kept.

    Parameters
    ----------
    live : Live
        The stream, not yet begun; it begins with the preview.
    bars : bool
        Bars on standard output, or lines on standard error.
    zero : float or None
        So long after the first bytes nothing touches [s]; None once that is said.
    """

    def __init__(self, live: Live, bars: bool, zero: float | None) -> None:
        self._live, self._bars, self.zero = live, bars, zero
        self.shown = False
        self._zero_at = np.inf
        self._read: SimpleQueue[tuple[float, bytes | str]] = SimpleQueue()
        self._ended = threading.Event()
        self._context = ExitStack()

    def __enter__(self) -> Self:
        self._context.enter_context(when_compiling(self._start))
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._context.close()

    def _start(self) -> None:
        """Begin to compile; where there can be no second process the stream begins afterwards, as ever."""
        path = os.pathsep.join(str(Path(folder).resolve()) for folder in sys.path)
        with suppress(Exception):  # such as of a board's own driver that cannot be copied
            process = subprocess.Popen(
                [sys.executable, "-P", "-c", f"from {__name__} import main; main()"],
                env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": path},
                stdin=subprocess.PIPE, stdout=None if self._bars else sys.stderr, stderr=subprocess.DEVNULL,
            )  # fmt: skip
            self._context.callback(self._end, process)
            driver = copy.deepcopy(self._live.driver)
            threading.Thread(target=self._send, args=(process, driver), name="subskin preview", daemon=True).start()
            self._live.start(self._seen)
            self.shown = True
            log = logging.getLogger("subskin")
            self._context.callback(setattr, log, "disabled", log.disabled)
            log.disabled = True  # the preview itself says that loops are compiled

    def _end(self, process: subprocess.Popen[bytes]) -> None:
        self._ended.set()
        process.terminate()
        try:
            process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if self._bars:
            from rich.console import Console

            Console().show_cursor()  # which the picture hid, and did not show again where it was ended as it ended

    def _seen(self, host: float, what: bytes | str, values: Mapping[str, Any]) -> None:
        """Take what was read, in the reader's thread."""
        self._read.put((host, what))
        if self.zero is not None and isinstance(what, bytes):
            self._zero_at = min(self._zero_at, host + self.zero)
            if host >= self._zero_at:
                self.zero = None
                self._live.zero()

    def _send(self, process: subprocess.Popen[bytes], driver: Driver) -> None:
        """Hand on the newest frames, in a thread of its own; a second process that is gone is not missed."""
        chain, pipe = self._live.chain, process.stdin
        assert isinstance(chain, Chain)
        assert pipe is not None
        setup = _Setup(chain.file, tuple(chain.channels), dict(chain.options), self._bars, time.monotonic())
        try:
            with pipe:
                pickle.dump(setup, pipe)
                while not self._ended.wait(_EACH):
                    for few in _newest(_all(self._read), driver):
                        pickle.dump(few, pipe)
                    pipe.flush()
        except Exception:  # it may have ended, and a board's own driver may raise anything; compiling goes on
            process.terminate()


def _all(queue: SimpleQueue[Any]) -> list[Any]:
    """What waits."""
    taken = []
    with suppress(Empty):
        while True:
            taken.append(queue.get_nowait())
    return taken


def _newest(items: list[tuple[float, bytes | str]], driver: Driver) -> list[_Few]:
    """The commands among what was read, and before each the first and the newest frames."""
    told: list[_Few] = []
    data, at = b"", 0.0
    for host, what in [*items, (0.0, "")]:
        if isinstance(what, bytes):
            data, at = data + what, host
            continue
        frames = driver.feed(data)
        data = b""
        if len(frames):
            # the first of all is that of the free skin
            kept = np.unique(np.r_[0, max(len(frames) - _FEW + 1, 0) : len(frames)])
            told.append(_Few(at, frames.values[kept], frames.device_time[kept]))
        if what == "port_back":
            driver.reset()
        if what in COMMANDS:
            told.append(_Few(host, np.empty((0, len(driver.channels))), np.empty(0), str(what)))
    return told


class _Early:
    """What a picture of the second process says of itself."""

    live: Any

    def state(self) -> str:
        """In place of rate, losses and latency."""
        seconds = time.monotonic() - self.live.began
        return f"PREVIEW of some frames: compiling, once, {seconds:.0f} s so far; no frame is lost"

    def tell(self, event: Event) -> None:
        """Nothing: between some frames there are gaps."""


class _EarlyBars(_Early, Bars):
    stays = False


class _EarlyLines(_Early, PlainLines):
    pass


class _Shown:
    """What a view asks of a stream: nothing is counted yet."""

    frames = lost = bad = 0
    recorder = None

    def __init__(self, began: float) -> None:
        self.port, self.began = self, began

    def clock(self) -> float:
        """As of a port."""
        return time.monotonic()


def main() -> None:
    """Be the second process, until it is ended or the pipe from the first is."""
    signal.signal(signal.SIGTERM, _leave)
    try:
        setup: _Setup = pickle.load(sys.stdin.buffer)
        inbox: SimpleQueue[_Few] = SimpleQueue()
        threading.Thread(target=_listen, args=(inbox,), daemon=True).start()
        _show(setup, inbox)
    finally:
        os._exit(0)  # the thread that listens holds standard input


def _leave(*_: object) -> None:
    """Leave once: the end of the pipe and the first process both say so, and the picture has to end in between."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    sys.exit()


def _listen(inbox: SimpleQueue[_Few]) -> None:
    with suppress(Exception):  # the end of the pipe, wherever it is cut
        while True:
            inbox.put(pickle.load(sys.stdin.buffer))
    _thread.interrupt_main(signal.SIGTERM)


def _show(setup: _Setup, inbox: SimpleQueue[_Few]) -> None:
    chain, state = Chain(setup.file, channels=setup.channels, **setup.options), None
    drawn = -np.inf
    with (_EarlyBars if setup.bars else _EarlyLines)(setup.file, _Shown(setup.began)) as shown:
        while True:
            waiting = []
            with suppress(Empty):
                waiting = [inbox.get(timeout=_EACH), *_all(inbox)]
            for k, few in enumerate(waiting):
                if few.command or state is None or k + 1 == len(waiting) or waiting[k + 1].command:
                    state, batch = chain.step(state, DeviceFrames(few.values, few.time), few.host, few.command)
                    shown.see(batch)
            if time.monotonic() - drawn >= shown.each:
                shown.draw()
                drawn = time.monotonic()
