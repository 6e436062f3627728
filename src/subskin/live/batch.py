"""What a chain makes of one read of a device."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen

if TYPE_CHECKING:
    from .events import Event

__all__ = ["Batch"]


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
