"""The server: pages and their parts, pictures to keep, and the socket on which all else is said."""

from __future__ import annotations

import re
from importlib.resources import files

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from ..errors import SubskinError
from .client import Client
from .guard import Guard, Keys
from .protocol import LARGEST
from .studio import Studio
from .views.finger import picture_of
from .views.state import FingerState

__all__ = ["app_of"]

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
    import asyncio

    kind = request.path_params["kind"]
    if kind not in _PICTURES or int(request.headers.get("content-length") or LARGEST + 1) > LARGEST:
        return PlainTextResponse("SVG or PNG, of a finger", 400)
    try:
        state = FingerState.model_validate_json(await request.body())
        made = await asyncio.get_running_loop().run_in_executor(studio.hand("finger"), picture_of, state, kind)
    except (SubskinError, ValueError) as error:
        return PlainTextResponse(str(error), 400)
    return Response(made, media_type=_PICTURES[kind])
