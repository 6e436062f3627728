"""Bytes of a serial port, by pyserial."""

from __future__ import annotations

from typing import Any

from ... import _check
from .base import HeldPort, PortLost, needed

__all__ = ["SerialPort"]


class SerialPort(HeldPort, name="serial"):
    """`serial:DEVICE?baud=115200`: a board on a USB cable or a serial line; nobody else may read it meanwhile.

    Parameters
    ----------
    device : str
        "/dev/ttyACM0", "COM3".
    baud : int
        Bits a second [1/s]; boards that are USB themselves take any.

    Raises
    ------
    InvalidValueError
        A baud rate that is not above 0.
    PortLost
        There is no such device, or another program holds it.
    """

    def __init__(self, device: str, baud: int = 115200) -> None:
        fix = "serial:/dev/ttyACM0?baud=9600"
        self._baud = _check.whole("baud", baud, at_least=1, at_most=100_000_000, fix=fix)
        self.name = device
        self.reopen()

    def _begun(self) -> Any:
        serial = needed("serial", "live")
        try:
            return serial.Serial(self.name, self._baud, timeout=0, exclusive=True)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise PortLost(self.name, f"it cannot be opened ({reason})", _advice(error)) from None

    def read(self, timeout: float) -> bytes:  # noqa: D102
        serial = self._own
        try:
            if serial.timeout != timeout:
                serial.timeout = timeout
            data: bytes = serial.read(max(serial.in_waiting, 1))
            more = serial.in_waiting
            return data + serial.read(more) if more else data
        except (OSError, TypeError, AttributeError) as error:  # what pyserial lets through when a device goes
            raise self._gone(f"the device is gone ({error})", "plug it in again") from None

    def write(self, data: bytes) -> None:  # noqa: D102
        try:
            self._own.write(data)
        except (OSError, TypeError, AttributeError) as error:
            raise self._gone(f"the device is gone ({error})", "plug it in again") from None


def _advice(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == 13:
        return "add yourself to the group that owns the device (often dialout), and log in again"
    if number in (11, 16):
        return "close the program that reads it"
    return "subskin ports lists what is plugged in"
