"""Bytes that come over a network: TCP, UDP."""

from __future__ import annotations

import select
import socket

from ...errors import InvalidValueError
from .base import HeldPort, PortLost

__all__ = ["TcpPort", "UdpPort"]

_MOST = 1 << 20
_PATIENCE = 5.0
"""How long a device may take to answer when it is called [s]."""


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
