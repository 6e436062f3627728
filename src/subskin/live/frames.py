"""What a device has sent: frames as it counts, times and names them, and which channels are the sensors of a finger."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..errors import GeometryError, InvalidValueError
from ..io.finger_file import FingerFile

__all__ = ["DeviceFrames", "columns_of", "factor_of"]


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
