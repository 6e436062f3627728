"""Sums that formats put behind their bytes."""

from __future__ import annotations

import binascii
import zlib
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["CHECKS", "Bytes", "Checksum"]

Bytes = npt.NDArray[np.uint8]


class Checksum(NamedTuple):
    """A check: its width in bytes, and what it makes of each row of bytes, shape (n, length)."""

    size: int
    of: Callable[[Bytes], npt.NDArray[np.int64]]


def _sum8(rows: Bytes) -> npt.NDArray[np.int64]:
    return np.asarray(rows.sum(axis=1, dtype=np.int64) & 0xFF)


def _sum16(rows: Bytes) -> npt.NDArray[np.int64]:
    return np.asarray(rows.sum(axis=1, dtype=np.int64) & 0xFFFF)


def _xor8(rows: Bytes) -> npt.NDArray[np.int64]:
    return np.asarray(np.bitwise_xor.reduce(rows, axis=1), dtype=np.int64)


def _row_by_row(of: Callable[[bytes], int]) -> Callable[[Bytes], npt.NDArray[np.int64]]:
    return lambda rows: np.array([of(row.tobytes()) for row in rows], dtype=np.int64)


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
    "sum8": Checksum(1, _sum8),
    "xor8": Checksum(1, _xor8),
    "sum16": Checksum(2, _sum16),
    "crc16_xmodem": Checksum(2, _row_by_row(lambda data: binascii.crc_hqx(data, 0))),
    "crc16_ccitt": Checksum(2, _row_by_row(lambda data: binascii.crc_hqx(data, 0xFFFF))),
    "crc16_modbus": Checksum(2, _row_by_row(_modbus)),
    "crc32": Checksum(4, _row_by_row(zlib.crc32)),
}
"""The checks by name. CRC-16/XMODEM, /CCITT-FALSE (IBM-3740) and /MODBUS, and CRC-32 as of Ethernet and zip."""
