"""The server: who is answered, pages and their parts, pictures to keep, and the socket on which all else is said."""

from __future__ import annotations

import asyncio
import hmac
import os
import re
import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from ..errors import SubskinError
from .client import Client
from .finger import picture_of
from .state import FingerState
from .studio import Studio
from .view import LARGEST

__all__ = ["Guard", "Keys", "app_of", "kept_secret"]

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]

_REFUSED = b"subskin studio answers only the browser in which its own address was opened: the one in the terminal.\n"
_LONGEST_QUERY = 2000
_LETTERS = 32
"""Of a secret."""


class Keys:
    """What lets a browser in: the token of the address, and the cookie that it is changed for.

    Parameters
    ----------
    port : int
        The server's; the cookie bears it, so that two studios do not take each other's.
    secret : str
        From which both are made; the same secret lets a page in again after the server was started again.
    """

    def __init__(self, port: int, secret: str | None = None) -> None:
        self.port, secret = port, secret or secrets.token_urlsafe(_LETTERS)
        self.token, self.cookie = (_derived(secret, f"{what} {port}") for what in ("token", "cookie"))
        self.name = f"subskin_studio_{port}"
        self.hosts = frozenset(f"{host}:{port}" for host in ("127.0.0.1", "localhost", "[::1]"))
        self.origins = frozenset(f"http://{host}" for host in self.hosts)

    @property
    def address(self) -> str:
        """The address to open."""
        return f"http://127.0.0.1:{self.port}/?token={self.token}"


class Guard:
    """ASGI middleware: Host, Origin, token and cookie are looked at before anything else is.

    Parameters
    ----------
    app : callable
        What answers whoever is let in.
    keys : Keys
        What lets in.
    """

    def __init__(self, app: Callable[[Scope, Receive, Send], Awaitable[None]], keys: Keys) -> None:
        self._app, self._keys = app, keys
        sockets = " ".join(sorted(f"ws://{host}" for host in keys.hosts if "[" not in host))  # a policy knows no [::1]
        policy = (
            f"default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
            f"connect-src 'self' {sockets}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        )
        self._headers = [
            (b"content-security-policy", policy.encode()),
            (b"x-content-type-options", b"nosniff"),
            (b"referrer-policy", b"no-referrer"),
            (b"cross-origin-opener-policy", b"same-origin"),
            (b"cross-origin-resource-policy", b"same-origin"),
            (b"cache-control", b"no-store"),
        ]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or turn it away."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return

        async def guarded(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", []), *self._headers]
            await send(message)

        headers: dict[str, list[str]] = {}
        for name, value in scope["headers"]:
            headers.setdefault(name.decode("latin-1"), []).append(value.decode("latin-1"))
        if scope["type"] == "http" and self._known(headers) and self._brings_token(scope):
            await self._let_in(scope, guarded)
        elif self._known(headers, scope) and self._has_cookie(headers):
            await self._app(scope, receive, guarded)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008})
        else:
            await _answer(guarded, 403, _REFUSED)

    def _known(self, headers: dict[str, list[str]], scope: Scope | None = None) -> bool:
        """Whether host and origin are ours; what changes something, and a socket, has to name its origin."""
        origin = headers.get("origin")
        named = scope is None or (scope["type"] == "http" and scope["method"] in ("GET", "HEAD"))
        right = named if origin is None else len(origin) == 1 and origin[0] in self._keys.origins
        host = headers.get("host", [])
        return right and len(host) == 1 and host[0] in self._keys.hosts

    def _brings_token(self, scope: Scope) -> bool:
        query = scope.get("query_string", b"")
        if scope["method"] != "GET" or scope["path"] != "/" or not query or len(query) > _LONGEST_QUERY:
            return False
        given = parse_qs(query.decode("latin-1")).get("token", [])
        return len(given) == 1 and hmac.compare_digest(given[0].encode(), self._keys.token.encode())

    def _has_cookie(self, headers: dict[str, list[str]]) -> bool:
        try:
            given = SimpleCookie("; ".join(headers.get("cookie", []))).get(self._keys.name)
        except CookieError:
            return False
        return given is not None and hmac.compare_digest(given.value.encode(), self._keys.cookie.encode())

    async def _let_in(self, scope: Scope, send: Send) -> None:
        """The cookie for the token, and an address that does not show it."""
        cookie = f"{self._keys.name}={self._keys.cookie}; Path=/; HttpOnly; SameSite=Strict"
        await _answer(send, 303, b"", (b"location", b"/"), (b"set-cookie", cookie.encode()))


def kept_secret() -> str:
    """The secret of the studio on this machine: a page is let in again when the server was started again.

    It is made where there is none; a new one each time where it cannot be kept.

    It lies in a folder of the user's, readable by the user alone.
    """
    file = _folder() / "studio.key"
    fresh = secrets.token_urlsafe(_LETTERS)
    try:
        file.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if file.exists() and not (os.name == "posix" and file.stat().st_mode & 0o077):
            kept = file.read_text("ascii").strip()
            if len(kept) >= _LETTERS:
                return kept
        file.unlink(missing_ok=True)
        with os.fdopen(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as out:
            out.write(fresh)
    except (OSError, UnicodeDecodeError):
        pass
    return fresh


def _folder() -> Path:
    kept = os.environ.get("LOCALAPPDATA") if os.name == "nt" else os.environ.get("XDG_STATE_HOME")
    return (Path(kept) if kept else Path.home() / ".local" / "state") / "subskin"


def _derived(secret: str, what: str) -> str:
    return hmac.new(secret.encode(), f"subskin studio: {what}".encode(), "sha256").hexdigest()


async def _answer(send: Send, status: int, body: bytes, *headers: tuple[bytes, bytes]) -> None:
    told = [(b"content-type", b"text/plain; charset=utf-8"), (b"content-length", str(len(body)).encode()), *headers]
    await send({"type": "http.response.start", "status": status, "headers": told})
    await send({"type": "http.response.body", "body": body})


_TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
}
_PICTURES = {"svg": "image/svg+xml", "png": "image/png"}


def app_of(studio: Studio, keys: Keys) -> Guard:
    """The application that a server runs.

    Parameters
    ----------
    studio : Studio
        What answers.
    keys : Keys
        Who is answered.
    """
    parts = _parts()

    async def part(request: Request) -> Response:
        name = request.path_params.get("name", "index.html")
        if name not in parts:
            return PlainTextResponse("there is no such page", 404)
        return Response(parts[name], media_type=_TYPES[name.rpartition(".")[2]])

    async def socket(connection: WebSocket) -> None:
        await Client(connection, studio).run()

    async def picture(request: Request) -> Response:
        return await _made(request, studio)

    return Guard(
        Starlette(
            routes=[
                Route("/", part),
                Route("/static/{name:path}", part),
                Route("/picture.{kind}", picture, methods=["POST"]),
                WebSocketRoute("/socket", socket),
            ]
        ),
        keys,
    )


def _parts() -> dict[str, bytes]:
    """The page and its parts, as they lie in the package; all that is served."""
    folder = files("subskin.studio") / "static"
    found = {}
    for part in folder.iterdir():
        if part.is_file() and re.fullmatch(r"[a-z0-9_]+\.(html|css|js|svg)", part.name):
            found[part.name] = part.read_bytes()
    return found


async def _made(request: Request, studio: Studio) -> Response:
    """A picture of what a page shows."""
    kind = request.path_params["kind"]
    if kind not in _PICTURES or int(request.headers.get("content-length") or LARGEST + 1) > LARGEST:
        return PlainTextResponse("SVG or PNG, of a finger", 400)
    try:
        state = FingerState.model_validate_json(await request.body())
        made = await asyncio.get_running_loop().run_in_executor(studio.hand("finger"), picture_of, state, kind)
    except (SubskinError, ValueError) as error:
        return PlainTextResponse(str(error), 400)
    return Response(made, media_type=_PICTURES[kind])
