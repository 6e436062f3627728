"""The live view: one source at a time, which all pages see."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from ....errors import InvalidValueError
from ....io.finger_file import FingerFile
from ....loads import force_unit
from .feed import DeviceFeed, Feed, PlayedFeed

__all__ = ["LiveView"]

_SLIP = re.compile(r"\s*(\d*\.?\d+)\s*(?:\.\.\s*(\d*\.?\d+)\s*)?")
_RECORDINGS = (".parquet", ".arrows")


class Start(BaseModel):
    """What a page asks to be followed."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    port: str = Field(max_length=500)
    driver: str = Field(default="", max_length=200)
    slip: str = Field(default="", max_length=40)
    fit: str = Field(default="", max_length=40)
    begin: float = Field(default=0.0, ge=0.0, le=1e7)
    speed: Annotated[float, Field(gt=0.0, le=1000.0)] = 1.0


class LiveView:
    """What a device or a recording says; the same for all pages.

    Parameters
    ----------
    wake : callable
        Called from another thread when there is something new.
    first : str, optional
        What is offered at the beginning: the device or recording of the command.
    """

    DOES = frozenset({"live.start", "live.stop", "live.zero", "live.mark", "live.record", "live.seek"})

    def __init__(self, wake: Callable[[], object], first: str | None = None) -> None:
        self._wake, self.first = wake, first or "demo"
        self._source: Feed | None = None
        self.number = 0

    def answer(self, do: str, given: dict[str, Any], file: FingerFile) -> dict[str, Any]:
        """What a page is answered.

        Parameters
        ----------
        do : str
            What it asks.
        given : dict
            With what.
        file : FingerFile
            The finger.

        Raises
        ------
        SubskinError, ValidationError
            Something that cannot be.
        """
        if do == "begin":
            return {"first": self.first, "history": self._history(), **self._about(file)}
        if do == "start":
            self._start(Start.model_validate(given.get("start")), file)
        elif do == "stop":
            self.close()
        elif do == "seek" and isinstance(self._source, PlayedFeed):
            begin, speed = (float(given.get(key, usual)) for key, usual in (("begin", 0.0), ("speed", 1.0)))
            self._begin(
                PlayedFeed(self._source.name, self._tell, begin=max(begin, 0.0), speed=min(max(speed, 0.05), 100.0))
            )
        elif isinstance(self._source, DeviceFeed) and do in ("zero", "mark", "record"):
            if do == "zero":
                self._source.zero()
            elif do == "mark":
                self._source.mark(str(given.get("text", ""))[:200] or "mark")
            else:
                self._source.record(given.get("on") is True, Path.cwd())
        elif do != "history":
            raise InvalidValueError(f"live: {do}", "nothing runs for which that could be done", "start a device first")
        return {"history": self._history()} if do == "history" else {"done": True}

    def told(self) -> dict[str, Any]:
        """What a page that watches is told."""
        source = self._source
        return {"run": "idle"} if source is None else source.told()

    def close(self) -> None:
        """Stop what runs."""
        source = self._source
        if source is not None:
            source.close()
            self._tell()

    def _start(self, start: Start, file: FingerFile) -> None:
        if start.port.lower().endswith(_RECORDINGS):
            self._begin(PlayedFeed(start.port, self._tell, begin=start.begin, speed=start.speed))
            return
        options: dict[str, Any] = {name: value for name in ("driver", "fit") if (value := getattr(start, name))}
        if start.slip.strip():
            options["slip"] = _friction(start.slip)
        self._begin(DeviceFeed(file, start.port or None, options, self._tell))

    def _begin(self, source: Feed) -> None:
        self.close()
        self._source = source
        source.start()
        self._tell()

    def _about(self, file: FingerFile) -> dict[str, Any]:
        """The finger of what runs, or else the one that would."""
        track = None if self._source is None else self._source.track
        file = file if track is None else track.file
        array = file.finger.array
        units = {kind.unit for kind in array.transducers}
        force = force_unit(array.on_area, file.finger.relative)
        return {
            "sensors": {"y": array.points[:, 0], "z": array.points[:, 1], "names": list(file.names)},
            "area": array.on_area,
            "depth": float(np.max(array.depth)),
            "units": {"force": force, "reading": units.pop() if len(units) == 1 else ""},
        }

    def _history(self) -> list[list[float]]:
        track = None if self._source is None else self._source.track
        return [] if track is None else track.history()

    def _tell(self) -> None:
        self.number += 1
        self._wake()


def _friction(text: str) -> float | tuple[float, float]:
    match = _SLIP.fullmatch(text)
    if match is None:
        raise InvalidValueError(f'friction "{text}"', "a number or a range is needed", "0.5, or 0.4..0.8")
    low = float(match[1])
    return low if match[2] is None else (low, float(match[2]))
