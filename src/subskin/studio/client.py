"""One page that is connected, and what is said to it: its questions are answered, of several moves the latest.

The page sends JSON, and gets one binary frame for each answer: [length of the JSON, 32 bits, little-endian][JSON in
UTF-8][fields, one byte a point]. The JSON names the fields under "fields", each with its shape, in the order of their
bytes.
"""

from __future__ import annotations

import asyncio
import json
import logging
import math
import struct
import time
from collections import OrderedDict
from collections.abc import Callable, Coroutine, Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pydantic_core
from starlette.websockets import WebSocket, WebSocketDisconnect

from ..errors import SubskinError
from .studio import Studio
from .view import LARGEST, Answer

__all__ = ["Client", "Malformed", "Rate", "Request", "framed", "request_of"]

_DEEPEST = 12
_ITEMS = 4000


class Malformed(ValueError):
    """A message that no page of ours sends."""


class Request(NamedTuple):
    """What a page asks: its number, the view, what to do there, and with what."""

    number: int
    view: str
    do: str
    given: dict[str, Any]


def request_of(text: str) -> Request:
    """What a message asks.

    Parameters
    ----------
    text : str
        JSON: {"id": 7, "view": "finger", "do": "look", ...}.

    Raises
    ------
    Malformed
        Another thing.

    Examples
    --------
    >>> request_of('{"id": 7, "view": "memo", "do": "look", "figure": "6"}')
    Request(number=7, view='memo', do='look', given={'figure': '6'})
    """
    try:
        said = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise Malformed(f"no JSON: {error}") from None
    if not isinstance(said, dict):
        raise Malformed("no object")
    number, view, do = [said.pop(key, None) for key in ("id", "view", "do")]
    if type(number) is not int or not 0 <= number < 2**53:
        raise Malformed("id")
    for name in (view, do):
        if not (isinstance(name, str) and 0 < len(name) < 40):
            raise Malformed("view, do")
    _refuse_large(said)
    return Request(number, str(view), str(do), said)


def framed(said: Mapping[str, Any], fields: Sequence[npt.NDArray[np.uint8]] = ()) -> bytes:
    """The frame of an answer.

    Parameters
    ----------
    said : mapping
        Goes as JSON.
    fields : sequence of ndarray of uint8
        Go as they are.

    Examples
    --------
    >>> framed({"id": 7}, [np.zeros((1, 2), np.uint8)]).hex()
    '080000007b226964223a377d0000'
    """
    head = pydantic_core.to_json(said, inf_nan_mode="null", fallback=_listed)  # what is not a number is null
    return b"".join([struct.pack("<I", len(head)), head, *(np.ascontiguousarray(field).tobytes() for field in fields)])


class Rate:
    """Messages that a page may send: `burst` at once, and then `each` a second.

    Parameters
    ----------
    burst, each : float
        Messages, and messages a second.
    """

    def __init__(self, burst: float = 4000.0, each: float = 400.0) -> None:
        self._burst, self._each, self._left, self._at = burst, each, burst, time.monotonic()

    def allows(self) -> bool:
        """Whether one more may come; it is then counted."""
        now = time.monotonic()
        self._left = min(self._burst, self._left + self._each * (now - self._at)) - 1.0
        self._at = now
        return self._left >= 0.0


def _listed(value: Any) -> Any:
    """What JSON can say of a number or an array of NumPy."""
    return value.tolist()


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is no number of JSON")


def _refuse_large(said: dict[str, Any]) -> None:
    """Refuse what is not small, flat and finite."""
    level: list[Any] = [said]
    count = depth = 0
    while level:
        count += len(level)
        if depth > _DEEPEST or count > _ITEMS:
            raise Malformed("too deep" if depth > _DEEPEST else "too many values")
        inner: list[Any] = []
        for value in level:
            if isinstance(value, float) and not math.isfinite(value):
                raise Malformed("a number without end")
            if isinstance(value, int) and abs(value) >= 2**53:
                raise Malformed("a number too large")
            inner += value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
        level, depth = inner, depth + 1


_LOG = logging.getLogger(__name__)
_MOST_WAITING = 64
"""Things to do, one after the other, that may wait; a page sends few."""
_MALFORMED, _TOO_LARGE, _TOO_MANY = 1003, 1009, 1008


class Client:
    """A connection, from when it is accepted to when it ends.

    What a page only looks at is answered for the latest request alone; what it does (`Studio.does`) is done one after
    the other, each once. What a view tells of itself, such as a live stream, is sent again when the page has said that
    it has drawn the last.

    Parameters
    ----------
    socket : WebSocket
        The connection.
    studio : Studio
        What answers.
    """

    def __init__(self, socket: WebSocket, studio: Studio) -> None:
        self._socket, self._studio = socket, studio
        self._asked: OrderedDict[str, Request] = OrderedDict()
        self._come = asyncio.Event()
        self._count = 0
        self.watching = ""
        """The view that tells of itself, or none."""
        self._drawn = True
        self._told = -1
        self._loop: asyncio.AbstractEventLoop | None = None
        self._busy: set[str] = set()
        self._tasks: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        """Until the page goes."""
        self._loop = asyncio.get_running_loop()
        await self._socket.accept()
        self._studio.clients.add(self)
        reader = asyncio.create_task(self._read())
        worker = asyncio.create_task(self._work())
        try:
            done, _ = await asyncio.wait({reader, worker}, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                if (error := task.exception()) is not None and not isinstance(error, WebSocketDisconnect):
                    raise error
        finally:
            self._studio.clients.discard(self)
            for task in (reader, worker, *self._tasks):
                task.cancel()
                with suppress(asyncio.CancelledError, Exception):
                    await task

    def wake(self) -> None:
        """There may be something to tell; called from any thread."""
        if self._loop is not None:
            with suppress(RuntimeError):  # the loop is closed
                self._loop.call_soon_threadsafe(self._come.set)

    async def _read(self) -> None:
        """Take what the page sends; end where it sends what no page of ours does."""
        rate = Rate()
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            text = message.get("text")
            if text is None or len(text) > LARGEST:
                return await self._end(_MALFORMED if text is None else _TOO_LARGE)
            if not rate.allows():
                return await self._end(_TOO_MANY)
            try:
                self._take(request_of(text))
            except Malformed:
                return await self._end(_MALFORMED)
            except OverflowError:
                return await self._end(_TOO_MANY)

    def _take(self, request: Request) -> None:
        if request.view == "page":
            self._page(request)
            return
        name = f"{request.view}.{request.do}"
        if self._studio.does(request.view, request.do):
            self._count += 1
            if len(self._asked) > _MOST_WAITING:
                raise OverflowError
            name = f"{name} {self._count}"
        self._asked.pop(name, None)
        self._asked[name] = request
        self._come.set()

    def _page(self, request: Request) -> None:
        """What the page says of itself: which view it watches, and that it has drawn what it was told."""
        if request.do == "watch":
            view = request.given.get("of")
            self.watching = view if isinstance(view, str) else ""
            self._told = -1
        elif request.do != "drawn":
            raise Malformed(request.do)
        self._drawn = True
        self._come.set()

    async def _work(self) -> None:
        """Answer: of each view one thing after the other, the views beside each other."""
        while True:
            self._come.clear()
            for name, request in list(self._asked.items()):
                if request.view not in self._busy:
                    del self._asked[name]
                    self._begin(request.view, self._answer(request))
            if self._news() and "" not in self._busy:
                self._begin("", self._tell())
            await self._come.wait()
            for task in [task for task in self._tasks if task.done()]:
                self._tasks.discard(task)
                task.result()  # raises what went wrong

    def _begin(self, name: str, work: Coroutine[Any, Any, None]) -> None:
        self._busy.add(name)
        task = asyncio.create_task(work)
        self._tasks.add(task)

        def done(_: asyncio.Task[None]) -> None:
            self._busy.discard(name)
            self._come.set()

        task.add_done_callback(done)

    async def _answer(self, request: Request) -> None:
        said, fields = await self._in_thread(request.view, answered, self._studio.answer, request)
        await self._socket.send_bytes(framed({**said, "id": request.number, "view": request.view}, fields))

    async def _tell(self) -> None:
        view, self._told, self._drawn = self.watching, self._studio.number_of(self.watching), False
        said, fields = await self._in_thread(view, self._studio.news, view)
        await self._socket.send_bytes(framed({**said, "view": view, "news": True}, fields))

    async def _in_thread(self, view: str, work: Callable[..., Answer], *given: Any) -> Answer:
        return await asyncio.get_running_loop().run_in_executor(self._studio.hand(view), work, *given)

    def _news(self) -> bool:
        """Whether the view that is watched has something new, and the page has drawn what it was told."""
        return bool(self.watching) and self._drawn and self._studio.number_of(self.watching) != self._told

    async def _end(self, code: int) -> None:
        with suppress(RuntimeError):
            await self._socket.close(code)


def answered(answer: Callable[[str, str, dict[str, Any]], Answer], request: Request) -> Answer:
    """The answer to a request, or what is wrong with it in words.

    Parameters
    ----------
    answer : callable
        Takes view, do and what is given.
    request : Request
        What is asked.
    """
    try:
        return answer(request.view, request.do, request.given)
    except SubskinError as error:
        return {"error": str(error)}, []
    except Exception as error:
        _LOG.exception("%s.%s", request.view, request.do)
        return {"error": f"the studio failed, and this is its fault: {type(error).__name__}: {error}"}, []
