"""From a command to a page: a port of this machine, the server, and the browser."""

from __future__ import annotations

import socket
import sys
import threading
import time
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import FileError, InvalidValueError

if TYPE_CHECKING:
    import uvicorn

    from .server import Keys
    from .studio import Studio

__all__ = ["bound", "serve", "served"]

_PORT, _TRIED = 8771, 20
_HOST = "127.0.0.1"


def serve(
    file: str | Path | None = None,
    *,
    device: str | None = None,
    port: int | None = None,
    browser: bool = True,
    quiet: bool = False,
) -> None:
    """Serve the studio until Ctrl-C.

    Parameters
    ----------
    file : path-like, optional
        The finger.toml that is shown at the beginning.
    device : str, optional
        A device, "demo" or a recording, which the live view begins with.
    port : int, optional
        Port of this machine; 8771, or the next that is free, if left out.
    browser : bool, optional
        Open the page.
    quiet : bool, optional
        Say nothing on standard error.

    Raises
    ------
    FileError
        A finger that cannot be read; packages that are missing.
    InvalidValueError
        A port that is taken.
    """
    try:
        import starlette  # noqa: F401
        import uvicorn  # noqa: F401
        import websockets  # noqa: F401
    except ModuleNotFoundError as error:
        raise FileError(f"{error.name}", "the studio needs it", 'pip install "subskin[studio]"') from None
    from .server import Keys, kept_secret
    from .studio import Studio

    studio = Studio(file, device)
    here = bound(port)
    keys = Keys(here.getsockname()[1], kept_secret())
    server = served(studio, keys)
    if not quiet:
        print(f"subskin: the studio is at {keys.address}", file=sys.stderr, flush=True)
        print("subskin: it answers this machine alone; Ctrl-C stops", file=sys.stderr, flush=True)
    if browser:
        threading.Thread(target=_open, args=(server, keys.address), daemon=True).start()
    try:
        server.run(sockets=[here])
    finally:
        studio.close()


def served(studio: Studio, keys: Keys) -> uvicorn.Server:
    """The server, which is to be run with a socket of `bound`.

    Parameters
    ----------
    studio : Studio
        What answers.
    keys : Keys
        Who is answered.
    """
    import uvicorn

    from .server import app_of
    from .view import LARGEST

    settings = uvicorn.Config(
        app_of(studio, keys),
        ws="websockets-sansio",
        ws_max_size=LARGEST,
        log_level="error",
        lifespan="off",
        timeout_graceful_shutdown=1,
        server_header=False,
        date_header=False,
        ws_per_message_deflate=False,
    )
    return uvicorn.Server(settings)


def _open(server: uvicorn.Server, address: str) -> None:
    """Open the page when the server answers."""
    while not server.started:
        time.sleep(0.02)
    webbrowser.open(address)


def bound(port: int | None) -> socket.socket:
    """A socket of this machine alone, on the port or the first that is free.

    Parameters
    ----------
    port : int or None
        Which port; None for 8771, or the next that is free.

    Raises
    ------
    InvalidValueError
        A port that another program has, or that is none.
    """
    if port is not None and not 0 <= port < 65536:
        raise InvalidValueError(f"--host-port {port}", "it has to lie between 0 and 65535", "leave it out")
    for number in [port] if port is not None else [*range(_PORT, _PORT + _TRIED), 0]:
        made = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            made.bind((_HOST, number))
        except OSError:
            made.close()
            continue
        return made
    raise InvalidValueError(f"--host-port {port}", "another program has it", "leave it out, or another number")
