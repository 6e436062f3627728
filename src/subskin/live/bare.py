"""A chain that finds nothing: frames of a device as readings of the sensors, with their times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..io.finger_file import FingerFile
from .batch import Batch
from .clock import ClockMap, ClockState
from .frames import DeviceFrames, columns_of

__all__ = ["BareChain"]


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
