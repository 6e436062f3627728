"""Messages of a WebSocket, each on a line of its own."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

from .base import HeldPort, PortLost, needed

__all__ = ["WebSocketPort"]

_LARGEST = 1 << 18
"""Bytes of a message at most: of a larger one the connection ends."""
_WAITING = 256
"""Messages that wait to be read at most; then the sender has to wait."""
_MOST = 1 << 20
_PATIENCE = 5.0


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
