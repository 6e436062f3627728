"""What a device has sent: frames as it counts, times and names them; and its clock beside the host's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..errors import GeometryError, InvalidValueError
from ..io.finger_file import FingerFile

__all__ = ["ClockMap", "ClockState", "DeviceFrames", "columns_of", "factor_of"]


@dataclass(frozen=True, eq=False)
class DeviceFrames(Frozen):
    """DeviceFrames that a driver found in the bytes of a device, in their order.

    Parameters
    ----------
    values : array_like, shape (n, c)
        A row for each frame, a column for each channel, in the units of the device; NaN is a missing value.
    device_time : array_like, shape (n,), optional
        Time of each frame by the clock of the device [s]; NaN where the device sends none (the default).
    sequence : array_like of int, shape (n,), optional
        Number that the device gave each frame; -1 where it counts none (the default).
    lost : int
        DeviceFrames that the device sent and that did not arrive, as far as its numbers tell.
    bad : int
        DeviceFrames that arrived broken, and were left out.

    Raises
    ------
    GeometryError
        `values` that are no table, or times and numbers of another length.

    Examples
    --------
    >>> frames = DeviceFrames([[1.0, 2.0], [1.5, 2.5]], sequence=[7, 9], lost=1)
    >>> len(frames), frames.lost, frames.device_time.tolist()
    (2, 1, [nan, nan])
    """

    values: FloatArray
    device_time: FloatArray = None  # type: ignore[assignment]
    sequence: npt.NDArray[np.int64] = None  # type: ignore[assignment]
    lost: int = 0
    bad: int = 0

    def __post_init__(self) -> None:
        values = _check.real("values", self.values, finite=False)
        if values.ndim != 2:
            rule = "a row for each frame, (n, c), is needed"
            raise GeometryError(f"values of shape {values.shape}", rule, "values[None] for one frame")
        n = len(values)
        time = np.full(n, np.nan) if self.device_time is None else np.asarray(self.device_time, dtype=np.float64)
        number = np.full(n, -1) if self.sequence is None else np.asarray(self.sequence)
        for name, column in (("device_time", time), ("sequence", number)):
            if column.shape != (n,):
                rule = f"one for each of the {n} frames is needed"
                raise GeometryError(f"{name} of shape {column.shape}", rule, f"{name} of shape ({n},)")
        for name, column in (("values", values), ("device_time", time), ("sequence", number.astype(np.int64))):
            closed = column.view()
            closed.flags.writeable = False
            object.__setattr__(self, name, closed)

    @classmethod
    def made(cls, values: FloatArray, time: FloatArray, number: npt.NDArray[np.int64], lost: int, bad: int) -> Self:
        """Frames of arrays that are right for certain, and the driver's own: they are closed, and nothing is checked.

        Parameters
        ----------
        values, time, number, lost, bad
            As `values`, `device_time`, `sequence`, `lost` and `bad`.
        """
        for column in (values, time, number):
            column.setflags(write=False)
        return cls.filled({"values": values, "device_time": time, "sequence": number, "lost": lost, "bad": bad})

    def __len__(self) -> int:
        return len(self.values)


def factor_of(file: FingerFile) -> FloatArray | None:
    """What makes of a channel what the pipeline takes, the unit of [recording]; None where it is that."""
    if file.live is None:
        return None
    factor = file.live.scale / (1.0 if file.recording is None else file.recording.scale)
    return None if (factor == 1).all() else factor


def columns_of(file: FingerFile, channels: Sequence[str]) -> npt.NDArray[np.intp] | None:
    """Where the sensors are among the channels; None where they are these."""
    names: Sequence[str] = file.names
    if file.live is not None and file.live.channels:
        names = file.live.channels
        missing = [name for name in names if name not in channels]
        if missing:
            seen = f"channels of [live]: {', '.join(missing)}"
            raise InvalidValueError(seen, f"the device has the channels {', '.join(channels)}", "one of these for each")
    if tuple(names) == tuple(channels):
        return None
    if len(set(channels)) == len(channels) and set(names) <= set(channels):
        return np.array([list(channels).index(name) for name in names])
    if len(channels) == len(names) and not set(names) & set(channels):
        return None
    missing = [name for name in names if name not in channels]
    seen = f"the device has the channels {', '.join(channels)}"
    rule = f"the finger's sensors are {', '.join(names)}; not found: {', '.join(missing)}"
    raise InvalidValueError(seen, rule, "channels = [...] under [live] names one for each sensor")


_WINDOW = 1.0
"""Seconds of which the frame that was least late is kept."""
_WINDOWS, _FEWEST = 60, 5
"""How many are kept, and from how many a slope is told."""
_SKEW = 1e-3
"""Faster or slower than this no device's clock runs; what seems so is delay."""
_STOPPED, _AWAY = 3, 0.05
"""A clock that has stood still: so many windows one after the other are all later by so much [s]."""
_COUNTERS = (2**32 * 1e-6, 2**32 * 1e-3, 2**16 * 1e-3, 2**24 * 1e-6)
"""Seconds after which counters of us and ms begin again."""
_NEAR, _AHEAD, _LATE = 0.25, 5.0, 0.05
"""Seconds by which device time may run ahead of the host's where a counter began again, and where it did not; and by
which a frame may be older than the one before it, for a network that changed their order."""


@dataclass(frozen=True, eq=False)
class ClockState(Frozen):
    """What is known of the clocks, from one batch to the next.

    Parameters
    ----------
    seen : ndarray, shape (w, 2)
        Of each window the device's time of the frame that was least late, and how far the host's clock was ahead [s].
    window : float
        Device time at which the last of them began [s].
    raw, wrapped : float
        Device time of the last frame as it came [s], and what counters that began again have left out [s].
    host, time : float
        Host time of the last batch, and host time given to the last frame [s].
    period : float
        Time between frames of a device without a clock [s].
    delay, skew : float
        Host time minus device time at device time 0 [s], and how much it grows a second [-].
    """

    seen: FloatArray
    window: float = -np.inf
    raw: float = np.nan
    wrapped: float = 0.0
    host: float = np.nan
    time: float = -np.inf
    period: float = np.nan
    delay: float = np.nan
    skew: float = 0.0

    def again(self) -> ClockState:
        """The state for a device whose clock has begun again: the host's time goes on."""
        return ClockState(np.empty((0, 2)), host=self.host, time=self.time, period=self.period)


@dataclass(frozen=True)
class ClockMap:
    """Device time to host time, batch by batch; it never goes back.

    A frame arrives late by what the bus and the scheduler make of it, never early. So the frame that was least late in
    each second is kept; a median of the slopes between these tells how much faster one clock runs (Theil 1950, Sen
    1968); the line of this slope beneath all of them maps device time. What is left is the least delay of the bus,
    which no clock at one end can tell. Frames of a device without a clock are spread evenly over the time since the
    batch before.

    Examples
    --------
    >>> clock, state = ClockMap(), None
    >>> for device, host in ((5.0, 100.001), (5.5, 100.503), (6.0, 101.002)):  # bytes that took 1, 3 and 2 ms
    ...     state, time = clock.step(state, np.array([device]), host)
    ...     print(time.round(4).tolist())
    [100.001]
    [100.501]
    [101.001]
    """

    def breaks(self, state: ClockState | None, device: FloatArray, host: float) -> list[tuple[int, float]]:
        """Where the device's clock began again, or was set: numbers of frames, and by how much it jumped [s].

        Parameters
        ----------
        state, device, host
            As of `step`. A counter of 16 to 32 bits that begins again at its end is no break.
        """
        if state is None or not device.size:
            return []
        room = max(host - state.host, 0.0)
        if _rises(device, state.raw) and device.item(-1) - state.raw <= room + _AHEAD:  # nearly always
            return []
        steps = _steps(device, state.raw)
        if steps.min() >= 0 and steps.max() <= room + _AHEAD:
            return []
        odd = np.flatnonzero((steps < 0) | (steps > room + _AHEAD))
        steps = steps[odd]
        wraps = ((steps[:, None] + _COUNTERS >= 0) & (steps[:, None] + _COUNTERS <= room + _NEAR)).any(axis=1)
        fine = wraps | ((steps < 0) & (steps > -_LATE) & (device[odd] > _LATE))
        return [(int(frame), float(step)) for frame, step in zip(odd[~fine], steps[~fine], strict=True)]

    def step(self, state: ClockState | None, device: FloatArray, host: float) -> tuple[ClockState, FloatArray]:
        """Host times of the frames of a batch, in which there is no break.

        Parameters
        ----------
        state : ClockState or None
            What the batches before left; None at the beginning.
        device : ndarray, shape (n,)
            Device time of each frame [s]; NaN where there is none.
        host : float
            Host time at which the last of them arrived [s].

        Returns
        -------
        state : ClockState
            For the next batch.
        time : ndarray, shape (n,)
            Host time of each frame [s], not decreasing, none later than `host` nor before the last.
        """
        before = ClockState(np.empty((0, 2))) if state is None else state
        if not device.size:
            return before, np.empty(0)
        raw, wrapped = device.item(-1), before.wrapped
        if _rises(device, before.raw):  # nearly always
            device = device + wrapped
        else:
            known = np.isfinite(device)
            if not known.any():
                return self._without(before, device.size, host)
            if not known.all():  # the time of the frame before it, or of the first that has one
                first = before.raw if np.isfinite(before.raw) else device[known][0]
                source = np.maximum.accumulate(np.where(known, np.arange(device.size), -1))
                device = np.where(source < 0, first, device[source])
                raw = device.item(-1)
            device, wrapped = _unwrapped(device, before, max(host - before.host, 0.0))
        last = device.item(-1)
        seen, window, delay, skew = self._learnt(before, last, host)
        if device.size == 1:
            time = np.array([max(min(last + (delay + skew * last), host), before.time)])
        else:
            time = device + (delay + skew * device)
            time = np.maximum.accumulate(np.maximum(np.minimum(time, host), before.time))
        now = ClockState.filled({
            "seen": seen, "window": window, "raw": raw, "wrapped": wrapped, "host": host, "time": time.item(-1),
            "period": before.period, "delay": delay, "skew": skew,
        })  # fmt: skip
        return now, time

    def _learnt(self, before: ClockState, device: float, host: float) -> tuple[FloatArray, float, float, float]:
        """`seen`, `window`, `delay`, `skew` with the newest frame of a batch, which waited least of all its frames."""
        ahead, seen = host - device, before.seen
        if device - before.window < _WINDOW and len(seen):
            if ahead >= seen[-1, 1]:
                return seen, before.window, before.delay, before.skew
            seen = np.concatenate([seen[:-1], [[device, ahead]]])
            # the line comes down; its slope waits for the window's end
            delay = min(before.delay, ahead - before.skew * device) if len(seen) > 1 else ahead
            return seen, before.window, delay, before.skew
        above = seen[-_STOPPED:, 1] - (before.delay + before.skew * seen[-_STOPPED:, 0])
        if len(seen) > _STOPPED and (above > _AWAY).all():
            seen = seen[-_STOPPED:]
        skew = 0.0
        if len(seen) >= _FEWEST:
            i, j = np.triu_indices(len(seen), 1)
            apart = seen[j] - seen[i]
            skew = float(np.clip(np.median(apart[:, 1] / apart[:, 0]), -_SKEW, _SKEW))
        seen = np.concatenate([seen[-_WINDOWS + 1 :], [[device, ahead]]])
        return seen, device, float((seen[:, 1] - skew * seen[:, 0]).min()), skew

    def _without(self, before: ClockState, frames: int, host: float) -> tuple[ClockState, FloatArray]:
        """Frames of a device that sends no time."""
        each = max(host - before.host, 0.0) / frames if np.isfinite(before.host) else 0.0
        period = before.period
        if each > 0:
            share = min(0.5, frames / 500)
            period = period + share * (min(each, 4 * period) - period) if period > 0 else each
        apart = min(each, period) if period > 0 else each
        time = host - apart * np.arange(frames - 1, -1, -1.0)
        time = np.maximum.accumulate(np.maximum(time, before.time))
        return replace(before, host=host, time=float(time[-1]), period=period), time


def _rises(device: FloatArray, last: float) -> bool:
    """Whether device time goes on from the `last`, frame by frame, each having one."""
    begins, ends = device.item(0) >= last, device.item(-1) < np.inf
    return begins and ends and (device.size == 1 or bool((device[1:] >= device[:-1]).all()))


def _steps(device: FloatArray, last: float) -> FloatArray:
    """From each frame's device time to the next; 0 before the first frame of all, and where there is no time."""
    steps = np.empty(device.size)
    steps[0] = device[0] - last
    np.subtract(device[1:], device[:-1], out=steps[1:])
    if steps[0] != steps[0] or not np.isfinite(steps).all():
        steps[~np.isfinite(steps)] = 0.0
    return steps


def _unwrapped(device: FloatArray, before: ClockState, room: float) -> tuple[FloatArray, float]:
    """Device times with what counters left out that began again, and the sum of it."""
    out, wrapped = device + before.wrapped, before.wrapped
    steps = _steps(device, before.raw)
    if steps.min() >= 0:
        return out, wrapped
    for k in np.flatnonzero(steps < 0):
        for length in _COUNTERS:
            if 0 <= steps[k] + length <= room + _NEAR:
                out[k:] += length
                wrapped += length
                break
    return out, wrapped
