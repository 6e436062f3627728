"""What runs in a thread of its own behind a view, a device or a recording, and what is told of its stream."""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np

from ..decide import SlipVerdict
from ..errors import SubskinError
from ..estimate import Status
from ..io.finger_file import FingerFile
from ..live.batch import Batch
from .answer import STATUS, rows_of
from .view import StudioView

__all__ = ["Fed", "Feed", "Track"]

_STEP = 0.05
"""Seconds of a step of the history: of its frames the mean, and of the force the largest too."""
_KEPT = 12_000
"""Steps that are kept: ten minutes."""
_RECENT = 60
"""Steps that go with each picture; a page asks for the others once."""
_TRAIL = 80
_EVENTS = 60
_SLIPS = {
    SlipVerdict.HOLDS: "It holds.",
    SlipVerdict.AT_RISK: "It may slip.",
    SlipVerdict.SLIPS: "It slips.",
    SlipVerdict.CANNOT_TELL: "Whether it slips cannot be told.",
}


class Track:
    """Follows batches; may be asked from another thread.

    Parameters
    ----------
    file : FingerFile
        The finger.
    """

    def __init__(self, file: FingerFile) -> None:
        self.file = file
        self._lock = threading.Lock()
        self._latest: Batch | None = None
        self._steps: deque[list[float]] = deque(maxlen=_KEPT)
        self._open: tuple[int, list[list[float]]] = (-1, [])
        self._trail: deque[list[float]] = deque(maxlen=_TRAIL)
        self._events: deque[dict[str, Any]] = deque(maxlen=_EVENTS)
        self._seen: deque[tuple[float, int, float]] = deque()
        self._first: float | None = None
        self._told_events = 0
        self._area = file.finger.array.on_area

    def see(self, batch: Batch, late: float) -> None:
        """Take what came out of the chain.

        Parameters
        ----------
        batch : Batch
            What came.
        late : float
            Seconds since its last byte arrived.
        """
        with self._lock:
            start = self._first
            for event in batch.events:
                at = event.time - (event.time if start is None else start)
                self._told_events += 1
                self._events.append({"number": self._told_events, "time": at, "kind": event.kind, "text": event.text})
            if not len(batch):
                return
            self._first = float(batch.time[0]) if self._first is None else self._first
            now = time.monotonic()
            self._seen.append((now, len(batch), late))
            while self._seen[0][0] < now - 1.0:
                self._seen.popleft()
            self._latest = batch
            self._keep(batch)

    def _keep(self, batch: Batch) -> None:
        """The history, and the trail."""
        found = batch.found
        columns = found.to_dict()
        at = batch.time - (self._first or 0.0)
        area = self._area
        where = columns["position_y"] if area else columns["position"]
        force = columns.get("force", np.full(len(batch), np.nan))
        lean = np.degrees(columns.get("angle", np.full(len(batch), np.nan)))
        touched = found.status != int(Status.NO_CONTACT)
        ratio = np.full(len(batch), np.nan) if batch.decision is None else batch.decision.ratio
        across = columns["position_z"] if area else np.full(len(batch), np.nan)
        rows = np.stack([at, np.where(touched, force, 0.0), where, lean, ratio, across], axis=-1)
        for number in np.unique((at // _STEP).astype(int)).tolist():
            part = rows[(at // _STEP).astype(int) == number].tolist()
            if number != self._open[0]:
                self._close()
                self._open = (number, [])
            self._open[1].extend(part)
        last = rows[-1]
        self._trail.append([float(last[2]), float(last[5]), float(last[1])])

    def _close(self) -> None:
        number, rows = self._open
        if not rows:
            return
        values = np.array(rows)
        known = [_mean(values[:, k]) for k in (2, 3, 4)]
        force = values[:, 1][np.isfinite(values[:, 1])]
        self._steps.append([number, float(force.max()) if force.size else math.nan, *known])

    def told(self) -> dict[str, Any]:
        """How it stands now."""
        with self._lock:
            late = sorted(late for *_, late in self._seen)
            frames = sum(count for _, count, _ in self._seen)
            return {
                **self._now(),
                "steps": list(self._steps)[-_RECENT:],
                "trail": list(self._trail),
                "events": list(self._events),
                "rate": float(frames),
                "late": late[len(late) // 2] if late else math.nan,
                "lasted": self._steps[-1][0] * _STEP if self._steps else 0.0,
            }

    def history(self) -> list[list[float]]:
        """All steps that are kept: number, largest force, and means of position, angle and share of the friction."""
        with self._lock:
            return list(self._steps)

    def _now(self) -> dict[str, Any]:
        """The last frame."""
        batch = self._latest
        if batch is None:
            return {"readings": None, "found": None}
        array = self.file.finger.array
        own = np.asarray(array.offset)
        noise = np.asarray(array.noise)
        found = batch.found[-1]
        status = Status(int(found.status))
        load = getattr(found, "load", None)
        slip = None
        if batch.decision is not None:
            verdict = SlipVerdict(int(batch.decision.verdict[-1]))
            slip = {"verdict": verdict.name, "words": _SLIPS[verdict], "ratio": float(batch.decision.ratio[-1])}
        return {
            "readings": batch.readings[-1] - own,
            "strength": (batch.readings[-1] - own) / np.where(noise > 0, noise, np.inf),
            "found": {"status": status.name, "words": STATUS[status], "rows": rows_of(found.to_dict(), self._area)},
            "load": _load(load),
            "slip": slip,
        }


def _load(load: Any) -> dict[str, Any] | None:
    """Where and how the load presses, if one was found."""
    if load is None or not np.isfinite(load.components).all():
        return None
    return {"position": np.atleast_1d(load.position), "components": load.components}


def _mean(values: Any) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else math.nan


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


_Feed = TypeVar("_Feed", bound=Feed)


class Fed(StudioView, Generic[_Feed]):
    """A view that tells of one feed at a time.

    Parameters
    ----------
    wake : callable
        As of `StudioView`.
    file : callable
        The finger of a text, or of the command where there is none.
    """

    number = 0

    def __init__(self, wake: Callable[[], object], file: Callable[[str | None], FingerFile]) -> None:
        super().__init__(wake)
        self._file = file
        self.feed: _Feed | None = None

    def told(self) -> dict[str, Any]:
        """What a page that watches is told."""
        return {"run": "idle"} if self.feed is None else self.feed.told()

    def close(self) -> None:
        """Stop what runs."""
        if self.feed is not None:
            self.feed.close()
            self._tell()

    def _follow(self, feed: _Feed) -> None:
        self.close()
        self.feed = feed
        feed.start()
        self._tell()
