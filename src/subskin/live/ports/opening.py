"""Ports by what a person writes: serial:/dev/ttyACM0, tcp:host:port, file:log.bin, -, demo."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

from ...errors import InvalidValueError
from ..options import made, named_among, written
from .base import Port

if TYPE_CHECKING:
    from ...io import FingerFile

__all__ = ["opened", "schemes"]

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
