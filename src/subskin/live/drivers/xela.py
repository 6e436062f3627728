"""Xela's uSkin: messages in JSON, one a line."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..frames import DeviceFrames
from .base import Driver
from .parts import Counter, Splitter

__all__ = ["Xela"]

_LONGEST = 1 << 18


class Xela(Driver, name="xela"):
    r"""Xela's server: of each taxel x, y and z, in counts, or in N where it is calibrated.

    The port "ws:" puts each message on a line of its own. Numbers that are missing between messages are lost frames.
    Other messages, such as the welcome, are left out; those that are damaged, or of another sensor, are bad. Format:
    mcsix/xela_server_ros2, scripts/xela_service.

    Parameters
    ----------
    sensors : int
        Sensors at the server, named "1", "2", ...
    taxels : int
        Taxels of each.
    calibrated : bool
        The forces [N] of calibrated sensors, not the counts.

    Raises
    ------
    InvalidValueError
        No sensor, no taxel.

    Examples
    --------
    >>> skin = Xela(taxels=1)
    >>> frames = skin.feed(b'{"message": 786, "time": 2.5, "sensors": 1, "1": {"data": "7F39,7F29,7D39"}}\n')
    >>> skin.channels, frames.values.tolist(), frames.device_time.tolist(), frames.sequence.tolist()
    (('s1_t0_x', 's1_t0_y', 's1_t0_z'), [[32569.0, 32553.0, 32057.0]], [2.5], [786])
    """

    def __init__(self, sensors: int = 1, taxels: int = 16, calibrated: bool = False) -> None:
        sensors = _check.whole("sensors", sensors, at_least=1, at_most=16, fix="sensors = 1")
        taxels = _check.whole("taxels", taxels, at_least=1, at_most=1000, fix="taxels = 1")
        self._sensors, self._taxels, self._calibrated = sensors, taxels, calibrated
        unit = "_N" if calibrated else ""
        self.channels = tuple(
            f"s{s}_t{t}_{axis}{unit}" for s in range(1, sensors + 1) for t in range(taxels) for axis in "xyz"
        )
        self._splitter, self._count = Splitter(_LONGEST), Counter()

    def reset(self) -> None:  # noqa: D102
        self._splitter.reset()
        self._count.reset()

    def feed(self, data: bytes) -> DeviceFrames:  # noqa: D102
        found, bad = [], 0
        for line in self._splitter.feed(data):
            if line is not None and not line.strip():
                continue
            try:
                message = json.loads(line or b"")
                if isinstance(message, dict) and isinstance(message.get("message"), str):
                    continue
                found.append(self._read(message))
            except (ValueError, RecursionError, TypeError, KeyError, AttributeError):
                bad += 1
        return self.counted(found, self._count, bad)

    def _read(self, message: dict[str, Any]) -> tuple[list[float], float, int]:
        number, time = message["message"], message["time"]
        if type(number) is not int or not 0 <= number < 1 << 62 or type(time) not in (int, float):
            raise ValueError
        row: list[float] = []
        for sensor in range(1, self._sensors + 1):
            told = message[str(sensor)]
            if self._calibrated:
                row += [float(value) for value in _flat(told["calibrated"])]
            else:
                row += [_count(word) for word in told["data"].split(",")]
        if len(row) != len(self.channels) or not all(map(math.isfinite, [*row, time])):
            raise ValueError
        return row, float(time), number

    def encode(  # noqa: D102
        self, values: npt.ArrayLike, device_time: npt.ArrayLike | None = None, sequence: npt.ArrayLike | None = None
    ) -> bytes:
        table = self.rows(values)
        times = np.zeros(len(table)) if device_time is None else np.asarray(device_time)
        numbers = np.arange(len(table)) if sequence is None else np.asarray(sequence)
        lines = []
        for row, time, number in zip(table, times.tolist(), numbers.tolist(), strict=True):
            message: dict[str, Any] = {"message": number, "time": time, "sensors": self._sensors}
            for sensor, own in enumerate(row.reshape(self._sensors, -1), 1):
                counts = "" if self._calibrated else ",".join(f"{round(value):04X}" for value in own)
                told = {"data": counts, "sensor": str(sensor), "taxels": self._taxels}
                message[str(sensor)] = {**told, "calibrated": own.tolist() if self._calibrated else None}
            lines.append(json.dumps(message).encode() + b"\n")
        return b"".join(lines)


def _count(word: str) -> float:
    """Four hexadecimal digits."""
    digits = word.strip()
    if len(digits) != 4 or not all(digit in "0123456789abcdefABCDEF" for digit in digits):
        raise ValueError
    return float(int(digits, 16))


def _flat(values: Any) -> list[float]:
    """Forces, whether they come taxel by taxel or all in a row; a text or a truth value is none."""
    flat = [one for value in values for one in (value if isinstance(value, list) else [value])]
    if not all(type(one) in (int, float) for one in flat):
        raise ValueError
    return flat
