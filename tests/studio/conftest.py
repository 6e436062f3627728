"""A studio that answers on a port of this machine, for the tests of a session."""

from __future__ import annotations

import json
import struct
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import httpx
import pytest
import uvicorn
from websockets.sync.client import ClientConnection, connect

from subskin.studio.opening import bound, served
from subskin.studio.server import Keys
from subskin.studio.studio import Studio

DEVICE = "robot?seed=3"
"""A stage that touches a finger; the views Live and Calibrate offer it."""


@dataclass
class Running:
    """A server in a thread."""

    studio: Studio
    keys: Keys
    server: uvicorn.Server
    thread: threading.Thread

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.keys.port}"

    def connect(self, **changes: Any) -> ClientConnection:
        headers = {"cookie": f"{self.keys.name}={self.keys.cookie}", "origin": self.url, **changes}
        origin = headers.pop("origin")
        return connect(
            f"ws://127.0.0.1:{self.keys.port}/socket", origin=origin, additional_headers=headers, max_size=None
        )

    def get(self, path: str = "/", **headers: str) -> httpx.Response:
        return httpx.get(self.url + path, headers=headers, timeout=20, verify=False)

    def stop(self) -> None:
        self.server.should_exit = True
        self.thread.join(10)
        self.studio.close()

    def again(self) -> None:
        """As after the command is given once more: nothing is left of the studio that was."""
        new = started(self.keys.port)
        self.studio, self.server, self.thread = new.studio, new.server, new.thread


def started(port: int = 0) -> Running:
    place = bound(port)
    studio, keys = Studio(device=DEVICE), Keys(place.getsockname()[1], "the secret of the tests")
    server = served(studio, keys)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [place]}, daemon=True)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    return Running(studio, keys, server, thread)


@pytest.fixture(scope="session")
def running() -> Iterator[Running]:
    one = started()
    yield one
    one.stop()


def heard(socket: ClientConnection, timeout: float = 30.0) -> tuple[dict[str, Any], bytes]:
    data = socket.recv(timeout)
    assert isinstance(data, bytes)
    (length,) = struct.unpack("<I", data[:4])
    return json.loads(data[4 : 4 + length]), data[4 + length :]


@pytest.fixture
def asked() -> Any:
    """Ask on a socket, and hear the answer."""

    def ask(
        socket: ClientConnection, view: str, do: str, number: int = 1, **given: Any
    ) -> tuple[dict[str, Any], bytes]:
        socket.send(json.dumps({"id": number, "view": view, "do": do, **given}))
        return heard(socket)

    ask.heard = heard  # type: ignore[attr-defined]
    return ask
