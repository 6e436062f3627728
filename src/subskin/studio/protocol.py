"""What page and server say to each other: JSON from the page, one binary frame for each answer.

A frame is [length of the JSON, 32 bits, little-endian][JSON in UTF-8][fields, one byte a point]. The JSON names the
fields under "fields", each with its shape, in the order of their bytes.
"""

from __future__ import annotations

import json
import math
import struct
import time
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pydantic_core

__all__ = ["LARGEST", "Malformed", "Rate", "Request", "framed", "request_of"]

LARGEST = 256 * 1024
"""Bytes of a message from the page; a larger one ends the connection."""
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
    number, view, do = (said.pop(key, None) for key in ("id", "view", "do"))
    if type(number) is not int or not 0 <= number < 2**53:
        raise Malformed("id")
    if not all(isinstance(name, str) and 0 < len(name) < 40 for name in (view, do)):
        raise Malformed("view, do")
    _count(said, 0)
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


def _count(value: Any, depth: int) -> int:
    """How many values there are in `value`, which has to be small, flat and finite."""
    if depth > _DEEPEST:
        raise Malformed("too deep")
    if isinstance(value, float) and not math.isfinite(value):
        raise Malformed("a number without end")
    if isinstance(value, int) and abs(value) >= 2**53:
        raise Malformed("a number too large")
    inner = list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else []
    count = 1 + sum(_count(item, depth + 1) for item in inner)
    if count > _ITEMS:
        raise Malformed("too many values")
    return count
