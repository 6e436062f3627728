"""Which channels of a device are the sensors of a finger, and what their numbers are worth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..errors import InvalidValueError
from ..io.finger_file import FingerFile

__all__ = ["columns_of", "factor_of"]


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
