"""What a chain makes of one read of a device, the last minutes of it, and a chain that finds nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..io.finger_file import FingerFile
from .frames import ClockMap, ClockState, DeviceFrames, columns_of

if TYPE_CHECKING:
    from .events import Event

__all__ = ["BareChain", "Batch", "RingBuffer"]


@dataclass(frozen=True, eq=False)
class Batch(Frozen):
    """All frames of one read, n of them, through the chain; of a command, none.

    Parameters
    ----------
    time : ndarray, shape (n,)
        When each was taken, by the host's clock [s].
    device_time : ndarray, shape (n,)
        The same by the device's [s]; NaN where it sends none.
    sequence : ndarray of int, shape (n,)
        Number that the device gave each; -1 where it counts none.
    raw : ndarray, shape (n, c)
        Values of the channels as they came [reading].
    readings : ndarray, shape (n, s)
        Readings of the sensors in SI with the drift taken off, as `Finger.locate` takes them [reading]; NaN where one
        is out.
    free : ndarray of bool, shape (n,)
        Which frames are free of contact for certain: offsets are learnt from these.
    lost, bad : int
        Frames that did not arrive, and that arrived broken.
    found : Estimate or Either or None
        What touches, of shape (n,); None where there is no frame.
    decision : Slip or None
        How close to slipping it is, of shape (n,); None where that is not asked.
    events : tuple of Event
        What happened.
    host_time : float
        When the last byte arrived, by the host's clock [s].
    first : int
        Number of the first frame in the stream, from 0.
    command : str
        What was asked: "zero", "mark", "port_lost", "port_back", or "" for frames.
    values : mapping
        With the command.
    """

    time: FloatArray
    device_time: FloatArray
    sequence: npt.NDArray[np.int64]
    raw: FloatArray
    readings: FloatArray
    free: npt.NDArray[np.bool_]
    lost: int = 0
    bad: int = 0
    found: Any = None
    decision: Any = None
    events: tuple[Event, ...] = ()
    host_time: float = np.nan
    first: int = 0
    command: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.time)


_MOST = 64 << 20
"""Bytes that it takes at most: where frames are many and wide, it reaches less far back."""
_FIRST = 1024
"""Frames for which there is room at the beginning; the room doubles as it is needed."""


class RingBuffer:
    """Keeps times, readings, estimates and whether the skin was free, of the last frames.

    Parameters
    ----------
    seconds : float, optional
        How far back it reaches [s]; less where that takes more than 64 MB.

    Examples
    --------
    >>> ring = RingBuffer(seconds=2.0)
    >>> for k in range(5):
    ...     ring.put(time=np.array([float(k)]), readings=np.full((1, 3), k))
    >>> ring.last()["time"].tolist(), ring.last(1.0)["readings"].shape
    ([2.0, 3.0, 4.0], (2, 3))
    """

    def __init__(self, seconds: float = 120.0) -> None:
        self.seconds = _check.scalar("seconds", seconds, unit="s", above=0.0)
        self._columns: dict[str, npt.NDArray[Any]] = {}
        self._at = self._count = 0

    def __len__(self) -> int:
        return self._count

    def take(self, batch: Batch) -> None:
        """Keep the frames of a batch.

        Parameters
        ----------
        batch : Batch
            What came out of a chain.
        """
        if len(batch) and batch.found is not None:
            table = {} if not hasattr(batch.found, "table") else {"found": batch.found.table}
            self.put(time=batch.time, readings=batch.readings, free=batch.free, status=batch.found.status, **table)

    def put(self, **columns: npt.NDArray[Any]) -> None:
        """Keep frames.

        Parameters
        ----------
        **columns : ndarray, shape (n, ...)
            By their names, the same each time; `time` [s] is one of them.
        """
        frames = len(columns["time"])
        if not self._columns:
            self._columns = {n: np.empty((_FIRST, *v.shape[1:]), v.dtype) for n, v in columns.items()}
        while self._count + frames > self._room and self._grow(float(columns["time"][-1])):
            pass
        room = self._room
        kept = min(frames, room)
        at = self._at % room
        index = slice(at, at + kept) if at + kept <= room else (at + np.arange(kept)) % room
        for name, values in columns.items():
            self._columns[name][index] = values[frames - kept :]
        self._at = (self._at + kept) % room
        self._count = min(self._count + kept, room)

    def last(self, seconds: float | None = None) -> dict[str, npt.NDArray[Any]]:
        """The last frames, oldest first, by the names of the columns; copies.

        Parameters
        ----------
        seconds : float, optional
            Of how long [s]; all of them if left out.
        """
        if not self._columns:
            return {}
        order = (self._at - self._count + np.arange(self._count)) % self._room
        time = self._columns["time"][order]
        reach = self.seconds if seconds is None else seconds
        order = order[np.searchsorted(time, time[-1] - reach) if time.size else 0 :]
        return {name: values[order] for name, values in self._columns.items()}

    @property
    def _room(self) -> int:
        return len(self._columns["time"])

    def _grow(self, now: float) -> bool:
        """Twice the room, unless the oldest frame is old enough to leave, or memory would take too much."""
        oldest = self._columns["time"][(self._at - self._count) % self._room] if self._count else now
        size = sum(values.nbytes for values in self._columns.values())
        if now - oldest > self.seconds or 2 * size > _MOST:
            return False
        order = (self._at - self._count + np.arange(self._count)) % self._room
        for name, values in self._columns.items():
            wide = np.empty((2 * len(values), *values.shape[1:]), values.dtype)
            wide[: order.size] = values[order]
            self._columns[name] = wide
        self._at = self._count
        return True


class BareChain:
    r"""What a `Live` runs where the finger is not known yet: no tare, no search, no events.

    Parameters
    ----------
    file : FingerFile
        Names of the sensors, and the units of their channels.
    channels : sequence of str
        What the device calls its values, in their order.

    Raises
    ------
    InvalidValueError
        Channels among which the sensors are not.

    Examples
    --------
    >>> import subskin as ss
    >>> text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 2\npitch = 3e-3\ndepth = 3e-3\n[live]\nunit = 'hPa'\n"
    >>> chain = BareChain(ss.io.parse_finger(text + "driver = {name = 'lines', sensors = 2}"), ("s1", "s0"))
    >>> chain.step(None, DeviceFrames([[2.0, 1.0]]), host_time=0.1)[1].readings.tolist()
    [[100.0, 200.0]]
    """

    def __init__(self, file: FingerFile, channels: Sequence[str]) -> None:
        self.file, self.channels, self._clock = file, tuple(channels), ClockMap()
        self._index = columns_of(file, channels)
        recorded = 1.0 if file.recording is None else file.recording.scale
        self._scale = recorded if file.live is None else file.live.scale

    def step(
        self,
        state: tuple[ClockState | None, int] | None,
        frames: DeviceFrames,
        host_time: float,
        command: str = "",
        values: Mapping[str, Any] | None = None,
    ) -> tuple[tuple[ClockState | None, int], Batch]:
        """Take what one read of a device gave; as `Chain.step`, and `found` of the batch is None.

        Parameters
        ----------
        state, frames, host_time, command, values
            As of `Chain.step`.
        """
        clock, first = (None, 0) if state is None else state
        device, times = frames.device_time, []
        edges = [0, *(at for at, _ in self._clock.breaks(clock, device, host_time)), len(frames)]
        for number in range(len(edges) - 1):
            clock = clock.again() if number and clock is not None else clock
            clock, time = self._clock.step(clock, device[edges[number] : edges[number + 1]], host_time)
            times.append(time)
        raw = frames.values if len(frames) else np.empty((0, len(self.channels)))
        readings = (raw if self._index is None else raw[:, self._index]) * self._scale
        batch = Batch(
            np.concatenate(times), device, frames.sequence, raw, readings, np.zeros(len(raw), dtype=bool), frames.lost,
            frames.bad, host_time=host_time, first=first, command=command, values=values or {},
        )  # fmt: skip
        return (clock, first + len(frames)), batch
