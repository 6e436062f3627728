"""Bytes of a serial port, by pyserial."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from ...errors import InvalidValueError
from .base import Port, PortLost
from .needs import needed

__all__ = ["SerialPort"]


class SerialPort(Port, name="serial"):
    """`serial:DEVICE?baud=115200`: a board on a USB cable or a serial line; nobody else may read it meanwhile.

    Parameters
    ----------
    device : str
        "/dev/ttyACM0", "COM3".
    baud : str
        Bits a second [1/s]; boards that are USB themselves take any.

    Raises
    ------
    InvalidValueError
        A baud rate that is no whole number above 0.
    PortLost
        There is no such device, or another program holds it.
    """

    def __init__(self, device: str, baud: str = "115200") -> None:
        if not baud.isdecimal() or not 0 < int(baud) <= 100_000_000:
            raise InvalidValueError(
                f"baud = {baud}", "a whole number above 0 is needed", "serial:/dev/ttyACM0?baud=9600"
            )
        self.name, self._baud = device, int(baud)
        self._serial: Any = None
        self.reopen()

    def reopen(self) -> None:  # noqa: D102
        serial = needed("serial", "live")
        self.close()
        try:
            self._serial = serial.Serial(self.name, self._baud, timeout=0, exclusive=True)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise PortLost(self.name, f"it cannot be opened ({reason})", _advice(error)) from None

    def read(self, timeout: float) -> bytes:  # noqa: D102
        serial = self._serial
        if serial is None:
            raise PortLost(self.name, "it is closed", "open it again")
        try:
            if serial.timeout != timeout:
                serial.timeout = timeout
            data: bytes = serial.read(max(serial.in_waiting, 1))
            more = serial.in_waiting
            return data + serial.read(more) if more else data
        except (OSError, TypeError, AttributeError) as error:  # what pyserial lets through when a device goes
            self.close()
            raise PortLost(self.name, f"the device is gone ({error})", "plug it in again") from None

    def write(self, data: bytes) -> None:  # noqa: D102
        if self._serial is None:
            raise PortLost(self.name, "it is closed", "open it again")
        try:
            self._serial.write(data)
        except (OSError, TypeError, AttributeError) as error:
            self.close()
            raise PortLost(self.name, f"the device is gone ({error})", "plug it in again") from None

    def close(self) -> None:  # noqa: D102
        serial, self._serial = self._serial, None
        if serial is not None:
            with suppress(OSError):
                serial.close()


def _advice(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == 13:
        return "add yourself to the group that owns the device (often dialout), and log in again"
    if number in (11, 16):
        return "close the program that reads it"
    return "subskin ports lists what is plugged in"
