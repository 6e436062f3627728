"""Streams of the Lab Streaming Layer, by pylsl."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..drivers.fields import Field
from ..drivers.fixed import Fixed
from .base import HeldPort, PortLost, needed

__all__ = ["LslPort"]

_MOST = 4096
_PATIENCE = 5.0


class LslPort(HeldPort, name="lsl"):
    """`lsl:NAME`: a stream of numbers on the network; its samples are frames, timed by the clock of the sender.

    Parameters
    ----------
    stream : str
        Name of the stream.

    Raises
    ------
    PortLost
        No such stream is there, or one of texts.
    """

    def __init__(self, stream: str) -> None:
        self.name, self._stream = f"lsl:{stream}", stream
        self.reopen()

    def _begun(self) -> Any:
        lsl, util = needed("pylsl", "lsl"), needed("pylsl.util", "lsl")
        found = lsl.resolve_byprop("name", self._stream, 1, _PATIENCE)
        if not found:
            raise PortLost(self.name, "no such stream is there", "check its name, and that it sends")
        if found[0].channel_format() == lsl.cf_string:
            raise PortLost(self.name, "it sends texts", "a stream of numbers")
        self._lost = util.LostError
        inlet = lsl.StreamInlet(found[0], recover=False)
        try:
            names = _names(inlet.info(_PATIENCE))
        except (util.LostError, util.TimeoutError):
            inlet.close_stream()
            raise PortLost(self.name, "it does not answer", "check the network") from None
        time = Field("time", "f64", "time")
        self.driver = Fixed([time, *(Field(name, "f64") for name in names)], start=b"LSL", check="crc32")
        return inlet

    def read(self, timeout: float) -> bytes:  # noqa: D102
        inlet = self._own
        assert self.driver is not None
        try:  # pull_chunk would wait for all that it may hold
            sample, time = inlet.pull_sample(timeout)
            if sample is None:
                return b""
            more, times = inlet.pull_chunk(0.0, _MOST)
        except self._lost:
            raise self._gone("the stream is gone", "start its sender again") from None
        return self.driver.encode(np.array([sample, *more], dtype=np.float64), [time, *times])

    def write(self, data: bytes) -> None:  # noqa: D102
        pass  # a stream takes no commands

    def _ended(self, held: Any) -> None:
        held.close_stream()


def _names(info: Any) -> list[str]:
    """Labels of the channels, with their units, where the stream has them."""
    names, channel = [], info.desc().child("channels").child("channel")
    for i in range(info.channel_count()):
        label, unit = channel.child_value("label") or f"c{i}", channel.child_value("unit")
        names.append(f"{label}_{unit}" if unit else label)
        channel = channel.next_sibling("channel")
    return names if len(set(names)) == len(names) else [f"c{i}" for i in range(len(names))]
