"""Serial ports, by pyserial: their bytes, what is plugged in, and which driver may read it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ... import _check
from .base import HeldPort, PortLost, needed

__all__ = ["PluggedIn", "SerialPort", "listed"]


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


_GUESSES = {
    0x239A: ("anyskin", "Adafruit: ReSkin's sketches run on its QT Py and Trinket M0"),
    0x2341: ("lines", "Arduino: a sketch most often prints lines"),
}
"""Guesses by the USB number of who made the board.

Adafruit's number: adafruit/ArduinoCore-samd, boards.txt; ReSkin's boards: raunaqbhirangi/reskin_sensor,
arduino/README.md. Arduino's: avrdude's list of USB devices. The numbers of Contactile's controller are not known to us;
those of converters (FTDI, CH340, CP210x) tell nothing of what is behind them.
"""


@dataclass(frozen=True)
class PluggedIn:
    """A serial port of this machine.

    Parameters
    ----------
    port : str
        As `opened` takes it.
    says : str
        What the device says that it is.
    usb : str
        USB numbers of vendor and product, in hexadecimal digits, "239a:80cc"; "" where it is no USB device.
    serial_number : str
        Of the device; "" where it has none.
    driver : str
        The driver that may read it; "unknown" where nothing tells.
    why : str
        What the guess rests on.
    """

    port: str
    says: str
    usb: str = ""
    serial_number: str = ""
    driver: str = "unknown"
    why: str = ""


def listed() -> list[PluggedIn]:
    """The serial ports of this machine, those of USB first.

    Raises
    ------
    SubskinError
        pyserial is not installed.

    Examples
    --------
    >>> all(one.port.startswith("serial:") for one in listed())
    True
    """
    found = []
    for one in needed("serial.tools.list_ports", "live").comports():
        driver, why = _GUESSES.get(one.vid, ("unknown", ""))
        says = " ".join(part for part in (one.manufacturer, one.product) if part) or one.description
        says = "" if says in (None, "n/a") else says  # what pyserial has for a port that says nothing
        usb = "" if one.vid is None else f"{one.vid:04x}:{one.pid or 0:04x}"
        found.append(PluggedIn(f"serial:{one.device}", says, usb, one.serial_number or "", driver, why))
    return sorted(found, key=lambda one: (not one.usb, one.port))
