"""Bytes that come over a network: TCP, UDP, WebSockets, and streams of the Lab Streaming Layer."""

from __future__ import annotations

import select
import socket
from contextlib import ExitStack
from typing import Any

import numpy as np

from ...errors import InvalidValueError
from ..drivers.fixed import Fixed
from ..drivers.framing import Field
from .base import HeldPort, PortLost, needed

__all__ = ["LslPort", "TcpPort", "UdpPort", "WebSocketPort"]

_MOST = 1 << 20
"""Bytes that one read gives at most."""
_PATIENCE = 5.0
"""How long a device may take to answer when it is called [s]."""
_LARGEST = 1 << 18
"""Bytes of a message of a WebSocket at most: of a larger one the connection ends."""
_WAITING = 256
"""Messages that wait to be read at most; then the sender has to wait."""
_SAMPLES = 4096
"""Samples of a stream of the Lab Streaming Layer that one read gives at most."""


def address(text: str, scheme: str) -> tuple[str, int]:
    """Host and port of "host:port"; an IPv6 address stands in brackets.

    Raises
    ------
    InvalidValueError
        No port, or one out of range.
    """
    host, colon, number = text.rpartition(":")
    if not colon or not number.isdecimal() or not 0 < int(number) < 65536:
        raise InvalidValueError(f"{scheme}:{text}", "a host and a port are needed", f"{scheme}:127.0.0.1:5000")
    return host.strip("[]") or "127.0.0.1", int(number)


class _Socket(HeldPort):
    def _ready(self, timeout: float) -> socket.socket | None:
        """The socket where bytes have come, or None."""
        its: socket.socket = self._own
        return its if select.select([its], [], [], timeout)[0] else None

    def _cut(self, error: object, fix: str = "check the network") -> PortLost:
        return self._gone(f"the connection is gone ({error})", fix)


class TcpPort(_Socket, name="tcp"):
    """`tcp:HOST:PORT`: a device, or a program, that waits for a reader.

    Parameters
    ----------
    where : str
        "host:port".

    Raises
    ------
    InvalidValueError
        No host and port.
    PortLost
        Nobody answers.
    """

    def __init__(self, where: str) -> None:
        self._where = address(where, "tcp")
        self.name = f"tcp:{where}"
        self.reopen()

    def _begun(self) -> socket.socket:
        try:
            its = socket.create_connection(self._where, timeout=_PATIENCE)
        except (OSError, UnicodeError) as error:
            rule = f"nobody answers ({getattr(error, 'strerror', None) or error})"
            raise PortLost(self.name, rule, "check the address, and that the device sends") from None
        its.setblocking(False)
        its.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return its

    def read(self, timeout: float) -> bytes:  # noqa: D102
        its = self._ready(timeout)
        if its is None:
            return b""
        try:
            data = its.recv(_MOST)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise self._cut(error.strerror) from None
        if not data:
            raise self._cut("closed by the other side", "start the device again")
        return data

    def write(self, data: bytes) -> None:  # noqa: D102
        its = self._own
        try:
            its.settimeout(_PATIENCE)
            its.sendall(data)
            its.setblocking(False)
        except OSError as error:
            raise self._cut(error.strerror or error) from None


class UdpPort(_Socket, name="udp"):
    """`udp:HOST:PORT`: packets sent to this machine; `udp::5000` takes those of this machine alone.

    Packets are taken from one sender: the first; of another address they are left out.

    Parameters
    ----------
    where : str
        The address of this machine that is listened at, 127.0.0.1 where it is left out, and the port.

    Raises
    ------
    InvalidValueError
        No port.
    PortLost
        The port is taken, or the address is not one of this machine.
    """

    def __init__(self, where: str) -> None:
        self._where = address(where, "udp")
        self.name = f"udp:{where}"
        self.reopen()

    def _begun(self) -> socket.socket:
        self._sender: tuple[str, int] | None = None
        its: socket.socket | None = None
        try:
            family = socket.AF_INET6 if ":" in self._where[0] else socket.AF_INET
            its = socket.socket(family, socket.SOCK_DGRAM)
            its.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _MOST)
            its.bind(self._where)
            its.setblocking(False)
            return its
        except OSError as error:
            if its is not None:
                its.close()
            raise PortLost(self.name, f"it cannot be listened at ({error.strerror})", "another port") from None

    def read(self, timeout: float) -> bytes:  # noqa: D102
        its = self._ready(timeout)
        packets: list[bytes] = []
        size = 0
        while its is not None and size < _MOST:
            try:
                data, sender = its.recvfrom(65536)
            except BlockingIOError:
                break
            except OSError as error:
                raise self._cut(error.strerror) from None
            if self._sender is None:
                self._sender = sender
            if sender[0] == self._sender[0]:
                packets.append(data)
                size += len(data)
        return b"".join(packets)

    def write(self, data: bytes) -> None:  # noqa: D102
        if self._held is not None and self._sender is not None and data:
            self._held.sendto(data, self._sender)


class WebSocketPort(HeldPort, name="ws"):
    """`ws://HOST:PORT`: a server that sends messages, such as Xela's at ws://localhost:5000.

    Parameters
    ----------
    where : str
        What follows "ws:".

    Raises
    ------
    PortLost
        Nobody answers, or not as a WebSocket.
    """

    def __init__(self, where: str) -> None:
        self.name = f"ws:{where}"
        self._stack = ExitStack()
        self.reopen()

    def _begun(self) -> Any:
        client = needed("websockets.sync.client", "live")
        exceptions = needed("websockets.exceptions", "live")
        limits = {"max_size": _LARGEST, "max_queue": _WAITING, "open_timeout": _PATIENCE, "close_timeout": 1.0}
        try:
            return self._stack.enter_context(client.connect(self.name, compression=None, proxy=None, **limits))
        except (OSError, ValueError, EOFError, exceptions.WebSocketException) as error:
            rule = f"no WebSocket answers ({str(error)[:100]})"
            raise PortLost(self.name, rule, "check the address, ws://localhost:5000") from None

    def read(self, timeout: float) -> bytes:  # noqa: D102
        socket = self._own
        closed = needed("websockets.exceptions", "live").ConnectionClosed
        parts: list[bytes] = []
        size = 0
        while size < _MOST:
            try:
                message = socket.recv(timeout=0.0 if parts else timeout)
            except TimeoutError:
                break
            except closed as error:
                if parts:  # said at the next call
                    break
                seen = f"the connection is gone ({str(error)[:100]})"
                raise self._gone(seen, "start the server again") from None
            parts.append(_line(message))
            size += len(parts[-1])
        return b"".join(parts)

    def write(self, data: bytes) -> None:  # noqa: D102
        if self._held is not None and data:
            try:
                self._held.send(data)
            except needed("websockets.exceptions", "live").ConnectionClosed:
                raise self._gone("the connection is gone", "start the server again") from None

    def _ended(self, held: Any) -> None:
        self._stack.close()


def _line(message: str | bytes) -> bytes:
    """A text on one line: within JSON the end of a line is but space. Bytes are as they came."""
    return message if isinstance(message, bytes) else message.replace("\n", " ").encode(errors="replace") + b"\n"


class LslPort(HeldPort, name="lsl"):
    """`lsl:NAME`: a stream of numbers on the network; its samples are frames, timed by the clock of the sender.

    Parameters
    ----------
    stream : str
        Name of the stream.

    Raises
    ------
    PortLost
        No such stream is there, or one of texts.
    """

    def __init__(self, stream: str) -> None:
        self.name, self._stream = f"lsl:{stream}", stream
        self.reopen()

    def _begun(self) -> Any:
        lsl, util = needed("pylsl", "lsl"), needed("pylsl.util", "lsl")
        found = lsl.resolve_byprop("name", self._stream, 1, _PATIENCE)
        if not found:
            raise PortLost(self.name, "no such stream is there", "check its name, and that it sends")
        if found[0].channel_format() == lsl.cf_string:
            raise PortLost(self.name, "it sends texts", "a stream of numbers")
        self._lost = util.LostError
        inlet = lsl.StreamInlet(found[0], recover=False)
        try:
            names = _names(inlet.info(_PATIENCE))
        except (util.LostError, util.TimeoutError):
            inlet.close_stream()
            raise PortLost(self.name, "it does not answer", "check the network") from None
        time = Field("time", "f64", "time")
        self.driver = Fixed([time, *(Field(name, "f64") for name in names)], start=b"LSL", check="crc32")
        return inlet

    def read(self, timeout: float) -> bytes:  # noqa: D102
        inlet = self._own
        assert self.driver is not None
        try:  # pull_chunk would wait for all that it may hold
            sample, time = inlet.pull_sample(timeout)
            if sample is None:
                return b""
            more, times = inlet.pull_chunk(0.0, _SAMPLES)
        except self._lost:
            raise self._gone("the stream is gone", "start its sender again") from None
        return self.driver.encode(np.array([sample, *more], dtype=np.float64), [time, *times])

    def write(self, data: bytes) -> None:  # noqa: D102
        pass  # a stream takes no commands

    def _ended(self, held: Any) -> None:
        held.close_stream()


def _names(info: Any) -> list[str]:
    """Labels of the channels, with their units, where the stream has them."""
    names, channel = [], info.desc().child("channels").child("channel")
    for i in range(info.channel_count()):
        label, unit = channel.child_value("label") or f"c{i}", channel.child_value("unit")
        names.append(f"{label}_{unit}" if unit else label)
        channel = channel.next_sibling("channel")
    return names if len(set(names)) == len(names) else [f"c{i}" for i in range(len(names))]
