"""What is plugged in, and which driver may read it."""

from __future__ import annotations

from dataclasses import dataclass

from .base import needed

__all__ = ["PluggedIn", "listed"]

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
