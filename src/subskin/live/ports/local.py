"""Bytes on this machine: serial ports, files, pipes, and files played as fast as the device sent them."""

from __future__ import annotations

import copy
import os
import select
import stat
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from ... import _check
from ...errors import FileError, InvalidValueError
from ..drivers.base import Driver
from .base import HeldPort, Port, PortEnded, PortLost, needed

__all__ = ["FilePort", "Log", "PluggedIn", "SerialPort", "StandardInput", "listed"]


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


_MOST = 1 << 16


class _Descriptor(HeldPort):
    """What an open descriptor gives; a regular file as fast as it is read."""

    def read(self, timeout: float) -> bytes:
        number: int = self._own
        try:
            if self.real_time and not select.select([number], [], [], timeout)[0]:
                return b""
            data = os.read(number, _MOST)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise PortLost(self.name, f"it cannot be read ({error.strerror})", "check the cable") from None
        if not data:
            raise PortEnded(self.name, "it is at its end")
        return data

    @property
    def real_time(self) -> bool:
        """Whether bytes come in their own time: not of a regular file, and not known of a pipe on Windows."""
        return os.name == "posix" and not stat.S_ISREG(os.fstat(self._own).st_mode)

    def write(self, data: bytes) -> None:
        pass


class FilePort(_Descriptor, name="file"):
    """`file:PATH`: bytes that were recorded, or a named pipe.

    Parameters
    ----------
    path : str
        The file.

    Raises
    ------
    FileError
        There is no such file, or it cannot be read.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "log.bin").write_bytes(b"ab")
    ...     with FilePort(f"{folder}/log.bin") as port:
    ...         port.regular, port.read(0.0)
    (True, b'ab')
    """

    def __init__(self, path: str) -> None:
        self.name, self._path = path, path
        self.reopen()

    @property
    def regular(self) -> bool:
        """Whether it is a file that holds all its bytes already, and no pipe into which they come."""
        return self._held is not None and stat.S_ISREG(os.fstat(self._held).st_mode)

    def _begun(self) -> int:
        if not self._path:
            raise FileError("file:", "the name of a file is needed", "file:log.bin")
        try:
            number = os.open(self._path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
        except OSError as error:
            raise FileError(self._path, f"it cannot be read ({error.strerror})", "check the name") from None
        if stat.S_ISDIR(os.fstat(number).st_mode):
            os.close(number)
            raise FileError(self._path, "it is a folder", "name a file in it")
        return number

    def _ended(self, held: int) -> None:
        os.close(held)


class StandardInput(_Descriptor, name="-"):
    """`-`: what is piped in.

    Raises
    ------
    PortLost
        Standard input is closed.
    """

    def __init__(self) -> None:
        self.name = "standard input"
        self.reopen()

    def _begun(self) -> int:
        try:
            return sys.stdin.fileno()
        except (AttributeError, OSError, ValueError):
            raise PortLost(self.name, "it is closed", "pipe bytes into it") from None

    def _ended(self, held: int) -> None:
        pass  # it is not ours to close


_PIECE = 256
"""Bytes that come at once: a few frames."""
_LONGEST = 60.0
"""A step of the device's clock that is longer, or goes back, is no time that has passed [s]."""


class Log(Port):
    r"""A file of a device's bytes, read at the speed at which they came: by the device's times, or by a rate.

    Parameters
    ----------
    file : FilePort
        The file, open.
    driver : Driver
        What finds the frames in it; a copy of it is used.
    rate : float, optional
        Frames a second [1/s]; needed where the frames have no times.

    Raises
    ------
    InvalidValueError
        A rate that is not above 0; from `read`, frames without times, and no rate.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from subskin.live.drivers import named
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "log.csv")
    ...     _ = path.write_bytes(b"1,2\n3,4\n5,6\n")
    ...     log = Log(FilePort(str(path)), named("lines", sensors=2), rate=1000.0)
    ...     log.read(timeout=1.0), log.close()
    (b'1,2\n3,4\n5,6\n', None)
    """

    def __init__(self, file: FilePort, driver: Driver, rate: float | None = None) -> None:
        self.name, self._file = file.name, file
        self._rate = None if rate is None else _check.scalar("rate", rate, above=0.0, fix="rate=1000.0")
        self._driver = copy.deepcopy(driver)
        self._start()

    def _start(self) -> None:
        self._driver.reset()
        self._read, self._piece = b"", b""
        self._due = self._last = float("nan")

    @property
    def real_time(self) -> bool:  # noqa: D102
        return False

    def read(self, timeout: float) -> bytes:  # noqa: D102
        if not self._piece:
            self._read = self._read or self._file.read(0.0)
            self._piece, self._read = self._read[:_PIECE], self._read[_PIECE:]
            took = self._took(self._piece)
            self._due = took + (time.monotonic() if self._due != self._due else self._due)
        wait = self._due - time.monotonic()
        if wait > 0:
            time.sleep(min(wait, timeout))
        if wait > timeout:
            return b""
        piece, self._piece = self._piece, b""
        return piece

    def _took(self, piece: bytes) -> float:
        """How long the device took for some bytes [s]."""
        frames = self._driver.feed(piece)
        if not len(frames):
            return 0.0
        if self._rate is not None:
            return (len(frames) + frames.lost) / self._rate
        times = frames.device_time[np.isfinite(frames.device_time)]
        if not times.size and self._last != self._last:
            rule = "its frames have no times, and nothing says how fast they came"
            raise InvalidValueError(f"file:{self.name}", rule, "--rate 1000 (rate=1000.0), in frames a second")
        steps = np.diff(times, prepend=self._last)
        self._last = times[-1] if times.size else self._last
        return float(steps[(steps > 0) & (steps < _LONGEST)].sum())

    def write(self, data: bytes) -> None:  # noqa: D102
        self._file.write(data)

    def close(self) -> None:  # noqa: D102
        self._file.close()

    def reopen(self) -> None:  # noqa: D102
        self._file.reopen()
        self._start()
