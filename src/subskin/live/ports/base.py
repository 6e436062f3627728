"""What a port is: where bytes of a device come from; and ports by what a person writes."""

from __future__ import annotations

import inspect
import time
from abc import ABC, abstractmethod
from contextlib import suppress
from importlib import import_module
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from ..._frozen import Named
from ...errors import InvalidValueError, SubskinError
from ..drivers.base import Driver, made, named_among, written

if TYPE_CHECKING:
    from ...io import FingerFile

__all__ = ["HeldPort", "Port", "PortEnded", "PortLost", "needed", "opened", "schemes"]

_PACKAGES = {"serial": "pyserial"}


class PortLost(SubskinError):
    """A port that is not there, or no longer: unplugged, refused, closed by the other side. `reopen` may bring it."""


class PortEnded(SubskinError):
    """A file or a pipe that is at its end: no more bytes will come."""


class Port(Named, ABC):
    """Bytes of a device, as they come.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from subskin.live.ports import opened
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "log.txt")
    ...     _ = path.write_bytes(b"1,2")
    ...     with opened(f"file:{path}") as port:
    ...         port.read(timeout=0.1)
    b'1,2'
    """

    name: str = ""
    """What messages call it."""

    driver: Driver | None = None
    """The driver that reads it, where the port knows; a device does not say."""

    @property
    def real_time(self) -> bool:
        """Whether bytes come in their own time, read or not: not those of a file, nor in simulated time."""
        return True

    @abstractmethod
    def read(self, timeout: float) -> bytes:
        """All bytes that are there; b"" where none came within the time.

        Parameters
        ----------
        timeout : float
            How long to wait for the first byte [s].

        Raises
        ------
        PortLost
            The device is gone.
        PortEnded
            The file is at its end.
        """

    @abstractmethod
    def write(self, data: bytes) -> None:
        """Send `data` to the device.

        Parameters
        ----------
        data : bytes
            Commands of a driver; a file takes none, and lets them go.

        Raises
        ------
        PortLost
            The device is gone.
        """

    @abstractmethod
    def close(self) -> None:
        """Close it; more than once does no harm."""

    @abstractmethod
    def reopen(self) -> None:
        """Open it again, after it was lost.

        Raises
        ------
        PortLost
            It is still away.
        """

    def clock(self) -> float:
        """Host time of what was read last [s]: that of `time.monotonic`, of a simulation its own."""
        return time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


class HeldPort(Port):
    """A port that holds something open: a file, a socket, a stream of a library."""

    _held: Any = None

    @abstractmethod
    def _begun(self) -> Any:
        """What is held, open; raises as `reopen`."""

    def _ended(self, held: Any) -> None:
        held.close()

    @property
    def _own(self) -> Any:
        """What is held; raises a PortLost where it is closed."""
        if self._held is None:
            raise PortLost(self.name, "it is closed", "open it again")
        return self._held

    def _gone(self, seen: str, fix: str) -> PortLost:
        """The error of what is no longer there; it is closed."""
        self.close()
        return PortLost(self.name, seen, fix)

    def close(self) -> None:  # noqa: D102
        held, self._held = self._held, None
        if held is not None:
            with suppress(OSError):
                self._ended(held)

    def reopen(self) -> None:  # noqa: D102
        self.close()
        self._held = self._begun()


def needed(module: str, extra: str) -> Any:
    """The module, or an error that says how to install it.

    Raises
    ------
    SubskinError
        It is not installed.
    """
    try:
        return import_module(module)
    except (ImportError, RuntimeError):  # RuntimeError: of pylsl, without the library beneath it
        package = _PACKAGES.get(module.split(".")[0], module.split(".")[0])
        raise SubskinError(
            f"{package} is not installed", "this port needs it", f'pip install "subskin[{extra}]"'
        ) from None


_WHOLE = ("file", "ws")
"""Ports whose address may have a question mark of its own."""


def schemes() -> dict[str, type[Port]]:
    """The kinds of ports by what stands before the colon.

    Examples
    --------
    >>> schemes()["tcp"].__name__
    'TcpPort'
    """
    return dict(Port._by_name)


def opened(where: str, file: FingerFile | None = None) -> Port:
    """The port that `where` names, open.

    Parameters
    ----------
    where : str
        The kind, a colon, and where it is; options follow a question mark: "serial:/dev/ttyACM0?baud=115200",
        "tcp:192.168.1.5:5000", "udp::5000", "ws://localhost:5000", "file:log.bin", "-" for standard input, "demo".
        A path of a device alone is a serial port.
    file : FingerFile, optional
        The finger; "demo" simulates its sensors.

    Raises
    ------
    InvalidValueError, UnknownOptionError
        No such kind of port, or an option that it has not got.
    PortLost
        Nothing is there.
    FileError
        A file that cannot be read.

    Examples
    --------
    >>> opened("tcp:nowhere")
    Traceback (most recent call last):
    subskin.errors.InvalidValueError: tcp:nowhere: a host and a port are needed. Fix: tcp:127.0.0.1:5000.
    """
    text = f"serial:{where}" if where.startswith("/dev/") or where.upper().startswith("COM") else where
    kind, _, rest = text.partition(":")
    if kind not in schemes() and kind.partition("?")[0] in schemes():
        kind, rest = kind.partition("?")[0], text.removeprefix(kind.partition("?")[0])
    fix = "serial:/dev/ttyACM0, tcp:host:port, udp:, ws:, file:, -, demo"
    port = named_among(schemes(), kind, f'port "{where}"', "kind of port", fix, "{}:")
    position, options = (rest, {}) if kind in _WHOLE else written(rest)
    takes = inspect.signature(port).parameters
    first = next((name for name, one in takes.items() if one.default is one.empty and name != "file"), "")
    if position and not first:
        raise InvalidValueError(f'port "{where}"', f"{kind} has no address", kind)
    fixed: dict[str, Any] = {first: position} if first else {}
    return made(port, kind, options, fixed | ({"file": file} if "file" in takes else {}), texts=True)
