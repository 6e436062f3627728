"""The view of a session at the bench: where to touch next, what the touches say so far, and the finger to keep."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from ..errors import FileError, InvalidValueError
from ..io.finger_file import FingerFile, save_finger
from ..io.units import quantity
from ..live.bench import Bench
from ..live.session import candidates_of
from .feed import Fed
from .touches import BenchFeed, TouchesFeed
from .view import LARGEST, FromPage, asked, done, drawn

__all__ = ["CalibrateView"]


class Begin(FromPage):
    """What a session is begun with, as a person types it."""

    force: str = Field(default="", max_length=40)
    accuracy: str = Field(default="0.2 mm", max_length=40)
    positions: str = Field(default="", max_length=500)
    rest: str = Field(default="2 s", max_length=40)
    hold: str = Field(default="0.5 s", max_length=40)
    fit: str = Field(default="", max_length=100)
    driver: str = Field(default="", max_length=200)


class TouchesMade(FromPage):
    """Touches that were made before."""

    name: str = Field(max_length=200)
    text: str = Field(max_length=LARGEST)
    fit: str = Field(default="", max_length=100)


_USUAL = Begin()


class CalibrateView(Fed[BenchFeed | TouchesFeed]):
    """A calibration, the same for all pages: at the bench where a device was given, or of touches made before.

    Parameters
    ----------
    wake, file
        As of `Fed`.
    port : str, optional
        The device of the command.
    """

    def __init__(
        self, wake: Callable[[], object], file: Callable[[str | None], FingerFile], port: str | None = None
    ) -> None:
        super().__init__(wake, file)
        played = (port or "").lower().endswith((".parquet", ".arrows"))
        self.port = "" if port is None or played or port.partition("?")[0] == "demo" else port

    @asked
    def begin(self, finger: str | None = None) -> dict[str, Any]:
        """Where the device is, and the finger."""
        return {"port": self.port, **drawn(self._file(finger) if self.feed is None else self.feed.file)}

    @done
    def start(self, start: Begin = _USUAL, finger: str | None = None) -> None:
        """Begin a session at the bench."""
        if not self.port:
            raise _nothing("start")
        file = self._file(finger)
        unit = drawn(file)["units"]["force"]
        bench = Bench(
            file,
            candidates_of(file, start.positions.strip() or None),
            force=quantity(start.force, unit, "force") if start.force.strip() else None,
            accuracy=quantity(start.accuracy, "m", "accuracy"),
            rest=quantity(start.rest, "s", "rest"),
            hold=quantity(start.hold, "s", "hold"),
            fit=_listed(start.fit) or None,
        )
        self._follow(BenchFeed(bench, self.port, self._tell, start.driver.strip()))

    @done
    def file(self, file: TouchesMade, finger: str | None = None) -> None:
        """Fit the finger to touches that were made before."""
        self._follow(TouchesFeed(self._file(finger), file.name, file.text, _listed(file.fit), self._tell))

    @done
    def again(self) -> None:
        """Take back the last touch."""
        self._session("again").order("again")

    @done
    def skip(self) -> None:
        """Ask for another position."""
        self._session("skip").order("skip")

    @done
    def end(self) -> None:
        """End with the touches that there are."""
        self._session("end").order("end")

    @done
    def at(self, position: str = "") -> None:
        """The touch is made at another position."""
        session = self._session("at")
        session.elsewhere(_position(position, session.bench.candidates.ndim))

    @done
    def accept(self, name: str = "") -> dict[str, Any]:
        """Write the finger, as the option `-o` of the commands does, into the folder where the studio was started."""
        if self.feed is None:
            raise _nothing("accept")
        if Path(name).name != name or Path(name).suffix != ".toml":
            raise InvalidValueError(
                f'name "{name}"', "a name that ends with .toml, without a folder", "calibrated.toml"
            )
        path = Path.cwd() / name
        if path.exists():
            raise FileError(name, "there is such a file already", "another name")
        save_finger(self.feed.result(), path)
        return {"text": path.read_text("utf-8"), "path": str(path)}

    @done
    def back(self) -> None:
        """Leave the session, and its touches."""
        if self.feed is None:
            raise _nothing("back")
        self.close()
        self.feed = None
        self._tell()

    def _session(self, do: str) -> BenchFeed:
        """The session at the bench that runs."""
        feed = self.feed
        if not isinstance(feed, BenchFeed) or feed.state not in ("starting", "running"):
            raise _nothing(do)
        return feed


def _nothing(do: str) -> InvalidValueError:
    return InvalidValueError(f"calibrate: {do}", "no session runs for which that could be done", "begin one")


def _listed(text: str) -> tuple[str, ...]:
    """The words of a list."""
    return tuple(word for word in text.replace(",", " ").split() if word)


def _position(text: str, dim: int) -> Any:
    """Where a touch is made: a length, on an area two."""
    parts = [quantity(part.strip(), "m", "position") for part in text.split(",")]
    if len(parts) != dim:
        raise InvalidValueError(
            f'position "{text}"', f"{dim} lengths are needed", "1.5 mm" if dim == 1 else "1 mm, 2 mm"
        )
    return parts[0] if dim == 1 else np.array(parts)
