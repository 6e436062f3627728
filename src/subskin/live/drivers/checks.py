"""Sums that formats put behind their bytes."""

from __future__ import annotations

import binascii
import zlib
from collections.abc import Callable
from functools import reduce
from operator import xor
from typing import NamedTuple

__all__ = ["CHECKS", "Checksum"]


class Checksum(NamedTuple):
    """A check: its width in bytes, and what it makes of the bytes."""

    size: int
    of: Callable[[bytes], int]


def _modbus_table() -> list[int]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0xA001 if byte & 1 else 0)
        table.append(byte)
    return table


_MODBUS = _modbus_table()


def _modbus(data: bytes) -> int:
    value = 0xFFFF
    for byte in data:
        value = value >> 8 ^ _MODBUS[(value ^ byte) & 0xFF]
    return value


CHECKS = {
    "sum8": Checksum(1, lambda data: sum(data) & 0xFF),
    "xor8": Checksum(1, lambda data: reduce(xor, data, 0)),
    "sum16": Checksum(2, lambda data: sum(data) & 0xFFFF),
    "crc16_xmodem": Checksum(2, lambda data: binascii.crc_hqx(data, 0)),
    "crc16_ccitt": Checksum(2, lambda data: binascii.crc_hqx(data, 0xFFFF)),
    "crc16_modbus": Checksum(2, _modbus),
    "crc32": Checksum(4, zlib.crc32),
}
"""The checks by name. CRC-16/XMODEM, /CCITT-FALSE (IBM-3740) and /MODBUS, and CRC-32 as of Ethernet and zip."""
