"""What servers and controllers of makers send: Xela's uSkin, Contactile's PapillArray."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ... import _check
from ...errors import InvalidValueError
from ..frames import DeviceFrames
from .base import Driver
from .parts import Counter, Splitter

__all__ = ["Contactile", "Xela"]

_LINE = 1 << 18


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
        self._splitter, self._count = Splitter(_LINE), Counter()

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


_START, _END = b"\x55\x66\x77\x88", b"\xaa\xbb\xcc\xdd"
_LONGEST = 8192
_STARTS = 16
"""Start marks before an end mark that are tried, the latest first: all but one are data."""
_HUB, _PILLARS, _GLOBAL, _PILLAR_SLIP, _SLIP = 1, 3, 4, 5, 6
_SIX, _STATE_FRICTION, _STATE_TWO = struct.Struct("<6f"), struct.Struct("<bf"), struct.Struct("<B2f")
_RATES = (100, 250, 500, 1000)
Read: TypeAlias = Callable[[bytes, int], tuple[list[float], int]]


class _Wrong(Exception):
    """The bytes are no packet of this layout."""


class Contactile(Driver, name="contactile"):
    r"""Contactile's controller: forces [N] and displacements [mm] of pillars, force and torque [N mm] of each sensor.

    A packet is handed on when its marks stand where its index says, and its sum of 16 bits is right. The sum of bytes
    does not see two bytes in the wrong order. Marks within the data do no harm. Format: PTSCOM_2.0_SPEC_SEP22, and
    langxin11/contactile_pts_lab, python_ws/pts_protocol.py.

    Parameters
    ----------
    sensors : int
        Arrays at the controller, 1 or 2.
    pillars : int
        Pillars of an array.
    slip : bool
        Also what the controller says of slip: state and friction of each pillar; state, friction and target force of
        each sensor. NaN where a packet does not have it.
    rate : int
        Packets a second that the controller is told to send: 100, 250, 500 or 1000 [1/s]; 0 leaves it as it is.

    Raises
    ------
    InvalidValueError
        Another number of arrays or pillars than there can be, an unknown rate.

    Examples
    --------
    >>> board = Contactile(rate=500)
    >>> board.channels[:6]
    ('s0_p0_Fx_N', 's0_p0_Fy_N', 's0_p0_Fz_N', 's0_p0_Dx_mm', 's0_p0_Dy_mm', 's0_p0_Dz_mm')
    >>> board.channels[-6:], board.start
    (('s0_Fx_N', 's0_Fy_N', 's0_Fz_N', 's0_Tx_Nmm', 's0_Ty_Nmm', 's0_Tz_Nmm'), b'f500\n')
    """

    def __init__(self, sensors: int = 1, pillars: int = 9, slip: bool = False, rate: int = 0) -> None:
        sensors = _check.whole("sensors", sensors, at_least=1, at_most=2, fix="sensors = 2")
        pillars = _check.whole("pillars", pillars, at_least=1, at_most=100, fix="pillars = 9")
        if rate and rate not in _RATES:
            rule = f"the controller has {', '.join(map(str, _RATES))} packets a second"
            raise InvalidValueError(f"rate = {rate!r}", rule, "rate = 500")
        self._sensors, self._pillars, self._slip = sensors, pillars, slip
        self.start = b"f%d\n" % rate if rate else b""
        axes = ("Fx_N", "Fy_N", "Fz_N", "Dx_mm", "Dy_mm", "Dz_mm")
        whole = ("Fx_N", "Fy_N", "Fz_N", "Tx_Nmm", "Ty_Nmm", "Tz_Nmm")
        names = [f"s{s}_p{p}_{axis}" for s in range(sensors) for p in range(pillars) for axis in axes]
        names += [f"s{s}_{axis}" for s in range(sensors) for axis in whole]
        if slip:
            names += [f"s{s}_p{p}_{of}" for s in range(sensors) for p in range(pillars) for of in ("slip", "friction")]
            names += [f"s{s}_{of}" for s in range(sensors) for of in ("slip", "friction", "target_N")]
        self.channels = tuple(names)
        self._count = Counter(1 << 32)
        self.reset()

    def reset(self) -> None:  # noqa: D102
        self._kept, self._looked = b"", 0
        self._count.reset()

    def feed(self, data: bytes) -> DeviceFrames:
        """As by `Driver`. Packets are judged in the order in which they end, each from the latest start on.

        Parameters
        ----------
        data : bytes
            As many as there are, at any cut.
        """
        data = self._kept + data
        first, at, bad, found = 0, self._looked, 0, []
        while (end := data.find(_END, at)) >= 0:
            at = end + 1
            start, tries = data.rfind(_START, first, end), _STARTS
            while start >= max(first, end - _LONGEST) and tries:
                tries -= 1
                try:
                    packet = self._packet(data[start + 4 : end])
                except (_Wrong, struct.error):
                    start = data.rfind(_START, first, start + 3)
                    continue
                found.append(packet)
                bad += data.count(_START, first, start)
                first = at = end + 4
                break
        keep = max(first, len(data) - _LONGEST - len(_END))
        bad += data.count(_START, first, min(keep + 3, len(data)))
        self._kept, self._looked = data[keep:], max(at, len(data) - 3, keep) - keep
        return self.counted(found, self._count, bad)

    def _packet(self, body: bytes) -> tuple[list[float], float, int]:
        """Values, time and number of what stands between the marks."""
        end = len(body) - 2
        if end < 1 or not 0 < body[0] <= 4:
            raise _Wrong
        wide = body[0]
        blocks: dict[int, int] = {}
        at, first = 1, end
        while at < first:
            kind, offset = _u16(body, at), int.from_bytes(body[at + 2 : at + 2 + wide], "little")
            at += 2 + wide
            if kind in blocks or not at <= offset < end:
                raise _Wrong
            blocks[kind], first = offset, min(first, offset)
        if at != first or not {_HUB, _PILLARS, _GLOBAL} <= set(blocks):
            raise _Wrong
        if sum(body[:end]) & 0xFFFF != _u16(body, end):
            raise _Wrong
        counter, ticks = struct.unpack_from("<IQ", body, blocks[_HUB])
        ends = {_HUB: blocks[_HUB] + 12}
        values, ends[_PILLARS] = self._each_pillar(body, blocks[_PILLARS], wide, _pillar)
        whole, ends[_GLOBAL] = self._each_sensor(body, blocks[_GLOBAL], wide, _pillar)
        values += whole
        for kind, each, read, count in (
            (_PILLAR_SLIP, self._each_pillar, _pillar_slip, 2 * self._pillars), (_SLIP, self._each_sensor, _slip, 3)
        ):  # fmt: skip
            if kind in blocks:
                more, ends[kind] = each(body, blocks[kind], wide, read)
            else:
                more = self._sensors * count * [math.nan]
            values += more if self._slip else []
        starts = sorted([*blocks.values(), end])
        for kind, stop in ends.items():  # each block fills the bytes up to the next
            if stop != starts[starts.index(blocks[kind]) + 1]:
                raise _Wrong
        return values, ticks * 1e-6, counter

    def _each_sensor(self, body: bytes, at: int, wide: int, read: Read) -> tuple[list[float], int]:
        """The numbers of each sensor in the block that begins `at`, and where it ends."""
        if _u16(body, at) != self._sensors:
            raise _Wrong
        at += 2 + self._sensors * wide
        values: list[float] = []
        for _ in range(self._sensors):
            more, at = read(body, at)
            values += more
        return values, at

    def _each_pillar(self, body: bytes, at: int, wide: int, read: Read) -> tuple[list[float], int]:
        """The same, of each pillar of each sensor."""

        def pillars(body: bytes, at: int) -> tuple[list[float], int]:
            if _u16(body, at) != self._pillars:
                raise _Wrong
            at += 2 + self._pillars * wide
            values: list[float] = []
            for _ in range(self._pillars):
                more, at = read(body, at)
                values += more
            return values, at

        return self._each_sensor(body, at, wide, pillars)

    def encode(  # noqa: D102
        self, values: npt.ArrayLike, device_time: npt.ArrayLike | None = None, sequence: npt.ArrayLike | None = None
    ) -> bytes:
        table = self.rows(values)
        numbers = np.zeros(len(table), np.int64) if sequence is None else np.asarray(sequence)
        times = np.zeros(len(table)) if device_time is None else np.asarray(device_time)
        sixes = 6 * self._sensors * self._pillars
        packets = []
        for row, number, time in zip(table, numbers.tolist(), times.tolist(), strict=True):
            pillars = [b"\x02\0" + _SIX.pack(*six) for six in row[:sixes].reshape(-1, 6)]
            sensors = [_listed(pillars[i * self._pillars : (i + 1) * self._pillars]) for i in range(self._sensors)]
            whole = [b"\x02\0" + _SIX.pack(*six) for six in row[sixes : sixes + 6 * self._sensors].reshape(-1, 6)]
            hub = struct.pack("<IQ", number % (1 << 32), round(time * 1e6))
            blocks = {_HUB: hub, _PILLARS: _listed(sensors), _GLOBAL: _listed(whole)}
            if self._slip:
                blocks |= self._slip_blocks(row[sixes + 6 * self._sensors :])
            at = 1 + 4 * len(blocks)
            body = b"\x02"
            for kind, block in blocks.items():
                body += struct.pack("<HH", kind, at)
                at += len(block)
            body += b"".join(blocks.values())
            packets.append(_START + body + struct.pack("<H", sum(body) & 0xFFFF) + _END)
        return b"".join(packets)

    def _slip_blocks(self, row: npt.NDArray[np.float64]) -> dict[int, bytes]:
        count = 2 * self._sensors * self._pillars
        pillars = [b"\x01\0" + struct.pack("<bf", int(of), friction) for of, friction in row[:count].reshape(-1, 2)]
        arrays = [_listed(pillars[i * self._pillars : (i + 1) * self._pillars]) for i in range(self._sensors)]
        sensors = [b"\x01\0" + struct.pack("<Bff", int(of), *more) for of, *more in row[count:].reshape(-1, 3)]
        return {_PILLAR_SLIP: _listed(arrays), _SLIP: _listed(sensors)}


def _u16(body: bytes, at: int) -> int:
    return int.from_bytes(body[at : at + 2], "little")


def _entry(body: bytes, at: int, kind: int, form: struct.Struct) -> tuple[list[float], int]:
    """The numbers of an entry of a kind, and where it ends."""
    if _u16(body, at) != kind:
        raise _Wrong
    return list(form.unpack_from(body, at + 2)), at + 2 + form.size


def _pillar(body: bytes, at: int) -> tuple[list[float], int]:
    return _entry(body, at, 2, _SIX)


def _pillar_slip(body: bytes, at: int) -> tuple[list[float], int]:
    return _entry(body, at, 1, _STATE_FRICTION)


def _slip(body: bytes, at: int) -> tuple[list[float], int]:
    return _entry(body, at, 1, _STATE_TWO)


def _listed(parts: list[bytes]) -> bytes:
    """A block of parts: how many, where each begins, the parts."""
    at, offsets = 2 + 2 * len(parts), []
    for part in parts:
        offsets.append(at)
        at += len(part)
    return struct.pack(f"<{1 + len(parts)}H", len(parts), *offsets) + b"".join(parts)
