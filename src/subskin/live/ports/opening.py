"""Ports by what a person writes: serial:/dev/ttyACM0, tcp:host:port, file:log.bin, -, demo."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qsl

from ...errors import InvalidValueError, UnknownOptionError
from .base import Port

if TYPE_CHECKING:
    from ...io import FingerFile

__all__ = ["opened", "schemes"]


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
    known = schemes()
    text = f"serial:{where}" if where.startswith("/dev/") or where.upper().startswith("COM") else where
    kind, _, rest = text.partition(":")
    if kind not in known and kind.partition("?")[0] in known:
        kind, mark, options = kind.partition("?")
        rest = mark + options
    if kind not in known:
        close = difflib.get_close_matches(kind, list(known), n=1)
        fix = f"did you mean {close[0]}:" if close else "serial:/dev/ttyACM0, tcp:host:port, udp:, ws:, file:, -, demo"
        raise InvalidValueError(f'port "{where}"', "no such kind of port is known", fix)
    position, _, query = rest.rpartition("?") if "?" in rest and kind not in ("file", "ws") else (rest, "", "")
    options_given: dict[str, Any] = dict(parse_qsl(query, keep_blank_values=True))
    kind_of: Callable[..., Port] = known[kind]
    takes = inspect.signature(kind_of).parameters
    first = _first(takes)
    if position and not first:
        raise InvalidValueError(f'port "{where}"', f"{kind} has no address", kind)
    allowed = [name for name in takes if name not in ("file", first)]
    for option in options_given:
        if option not in allowed:
            rule = f"a port {kind}: has no such option"
            raise UnknownOptionError(f'option "{option}"', rule, f"known: {', '.join(allowed) or 'none'}")
    if "file" in takes:
        options_given["file"] = file
    return kind_of(position, **options_given) if first else kind_of(**options_given)


def _first(takes: Any) -> str:
    """The name of what says where the port is, or "" where there is but one."""
    return next((name for name, one in takes.items() if one.default is one.empty and name != "file"), "")
