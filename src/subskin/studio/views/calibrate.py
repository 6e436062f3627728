"""The view of a session at the bench: where to touch next, what the touches say so far, and the finger to keep."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from ...errors import FileError, InvalidValueError
from ...io.finger_file import FingerFile, save_finger
from ...io.units import quantity
from ...live.bare import BareChain
from ...live.bench import Bench
from ...live.bench_file import calibrated, candidates_of
from ...live.connecting import connected
from ...live.run import Live
from ...live.session import BenchState, Said
from ..protocol import LARGEST
from .fit_told import fit_told
from .live.feed import Feed
from .touches_feed import TouchesFeed

__all__ = ["CalibrateView"]

_WAIT = 0.05
_SAID = 40
"""Lines that are kept of what was said."""


class Begin(BaseModel):
    """What a session is begun with, as a person types it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    force: str = Field(default="", max_length=40)
    accuracy: str = Field(default="0.2 mm", max_length=40)
    positions: str = Field(default="", max_length=500)
    rest: str = Field(default="2 s", max_length=40)
    hold: str = Field(default="0.5 s", max_length=40)
    fit: str = Field(default="", max_length=100)
    driver: str = Field(default="", max_length=200)


class Given(BaseModel):
    """Touches that were made before."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(max_length=200)
    text: str = Field(max_length=LARGEST)
    fit: str = Field(default="", max_length=100)


class BenchFeed(Feed):
    """A session, from the device's first frame to the last touch.

    Parameters
    ----------
    bench : Bench
        What asks for the touches.
    port : str
        Where the device is.
    tell : callable
        As of `Feed`.
    driver : str, optional
        What the device sends; that of the port or the file if left out.
    """

    def __init__(self, bench: Bench, port: str, tell: Callable[[], object], driver: str = "") -> None:
        super().__init__(port, tell)
        self.bench, self.file, self._driver = bench, bench.file, driver
        self._source: Any = None
        self._orders: list[Callable[[BenchState], tuple[BenchState, tuple[Said, ...]]]] = []
        self.bench_state, first = bench.start()
        self.said: list[Said] = list(first)
        self.level = np.zeros(len(bench.file.names))

    def result(self) -> FingerFile:
        """The finger that the touches make.

        Raises
        ------
        ConvergenceError
            As `Bench.result`.
        """
        return calibrated(self.bench, self.bench.result(self.bench_state))

    def order(self, what: Callable[[BenchState], tuple[BenchState, tuple[Said, ...]]]) -> None:
        """Something that the person wants of the session; it is done between two batches.

        Parameters
        ----------
        what : callable
            From a state to the next, and what is said.
        """
        self._orders.append(what)

    def elsewhere(self, position: Any) -> None:
        """The touch that is asked for is made at another position.

        Parameters
        ----------
        position : float or ndarray of shape (2,)
            On the axis of the touches [m].
        """

        def moved(state: BenchState) -> tuple[BenchState, tuple[Said, ...]]:
            if state.phase != "touch":
                return state, (Said("late", "a position can be changed only before the touch"),)
            number, at = len(state.positions) + 1, ", ".join(f"{1e3 * v:.2f} mm" for v in np.atleast_1d(position))
            values = {"position": np.asarray(position).tolist()}
            return replace(state, asked=position), (Said("touch", f"touch {number}: at {at}, as you say", values),)

        self.order(moved)

    def _follow(self) -> None:
        port, driver = connected(self.file, self.name, self._driver or None)
        with Live(BareChain(self.file, driver.channels), port, driver) as source:
            self._source = source
            self.state = "running"
            self._tell()
            while not self._stop.is_set() and self.bench_state.phase != "done" and not source.ended:
                for batch in source.take(_WAIT):
                    if len(batch):
                        self._after(*self.bench.step(self.bench_state, batch.readings, batch.time))
                        self._feel(batch.readings[-1])
                while self._orders:
                    self._after(*self._orders.pop(0)(self.bench_state))
                self._tell()
            if self.bench_state.phase != "done":
                self._after(*self.bench.end(self.bench_state))

    def _feel(self, reading: np.ndarray[Any, np.dtype[np.float64]]) -> None:
        state = self.bench_state
        if state.zero is not None and state.noise is not None:
            self.level = (reading - state.zero) / state.noise

    def _after(self, state: BenchState, said: tuple[Said, ...]) -> None:
        """Take what a step gave; a stage that can be told is told."""
        self.bench_state = state
        press, lift = (getattr(self._source.port, name, None) for name in ("press", "lift"))
        for one in said:
            self.said = [*self.said, one][-_SAID:]
            if one.kind == "touch" and press is not None:
                press(state.asked, self.bench.force)
            if state.phase == "lift" and one.kind in ("taken", "again", "skip") and lift is not None:
                lift()

    def told(self) -> dict[str, Any]:
        state = self.bench_state
        return {
            **super().told(),
            "phase": state.phase,
            "asked": state.asked,
            "touches": state.positions,
            "said": [one.text.replace("R^2", "R\N{SUPERSCRIPT TWO}") for one in self.said],
            "level": self.level,
            "error": state.error,
            "wanted": self.bench.accuracy,
            **fit_told(self.file, state.found, relative=self.bench.force is None),
        }


class CalibrateView:
    """A calibration, the same for all pages: at the bench where a device was given, or of touches made before.

    Parameters
    ----------
    wake : callable
        Called from another thread when there is something new.
    port : str, optional
        The device of the command.
    """

    DOES = frozenset(f"calibrate.{do}" for do in ("start", "file", "again", "skip", "end", "at", "accept", "back"))

    def __init__(self, wake: Callable[[], object], port: str | None = None) -> None:
        played = (port or "").lower().endswith((".parquet", ".arrows"))
        self._wake = wake
        self.port = "" if port is None or played or port.partition("?")[0] == "demo" else port
        self._feed: BenchFeed | TouchesFeed | None = None
        self.number = 0

    @property
    def running(self) -> bool:
        """Whether a session has the device."""
        return self._feed is not None and self._feed.state in ("starting", "running")

    def answer(self, do: str, given: dict[str, Any], file: FingerFile) -> dict[str, Any]:
        """What a page is answered.

        Parameters
        ----------
        do : str
            What it asks.
        given : dict
            With what.
        file : FingerFile
            The finger as drawn.

        Raises
        ------
        SubskinError, ValidationError
            Something that cannot be.
        """
        feed = self._feed
        if do == "begin":
            return {"port": self.port, **_about(file if feed is None else feed.file)}
        if do == "start" and self.port:
            self._start(Begin.model_validate(given.get("start", {})), file)
        elif do == "file":
            self._follow_file(Given.model_validate(given.get("file")), file)
        elif feed is not None and do == "accept":
            return self._accept(feed, str(given.get("name", "")))
        elif feed is not None and do == "back":
            self.close()
            self._feed = None
            self._tell()
        elif isinstance(feed, BenchFeed) and self.running and do in ("again", "skip", "end"):
            feed.order(getattr(feed.bench, do))
        elif isinstance(feed, BenchFeed) and self.running and do == "at":
            feed.elsewhere(_position(str(given.get("position", "")), feed.bench.candidates.ndim))
        else:
            raise InvalidValueError(f"calibrate: {do}", "no session runs for which that could be done", "begin one")
        return {"done": True}

    def told(self) -> dict[str, Any]:
        """What a page that watches is told."""
        return {"run": "idle"} if self._feed is None else self._feed.told()

    def close(self) -> None:
        """End the session; its touches are kept until another one begins."""
        if self._feed is not None:
            self._feed.close()

    def _start(self, begin: Begin, file: FingerFile) -> None:
        self.close()
        unit = "N" if file.finger.array.on_area else "N/m"
        bench = Bench(
            file,
            candidates_of(file, begin.positions.strip() or None),
            force=quantity(begin.force, unit, "force") if begin.force.strip() else None,
            accuracy=quantity(begin.accuracy, "m", "accuracy"),
            rest=quantity(begin.rest, "s", "rest"),
            hold=quantity(begin.hold, "s", "hold"),
            fit=_listed(begin.fit) or None,
        )
        self._begin(BenchFeed(bench, self.port, self._tell, begin.driver.strip()))

    def _follow_file(self, given: Given, file: FingerFile) -> None:
        self.close()
        self._begin(TouchesFeed(file, given.name, given.text, _listed(given.fit), self._tell))

    def _begin(self, feed: BenchFeed | TouchesFeed) -> None:
        self._feed = feed
        feed.start()
        self._tell()

    def _accept(self, feed: BenchFeed | TouchesFeed, name: str) -> dict[str, Any]:
        """Write the finger, as the option `-o` of the commands does, into the folder where the studio was started."""
        if Path(name).name != name or Path(name).suffix != ".toml":
            raise InvalidValueError(
                f'name "{name}"', "a name that ends with .toml, without a folder", "calibrated.toml"
            )
        path = Path.cwd() / name
        if path.exists():
            raise FileError(name, "there is such a file already", "another name")
        save_finger(feed.result(), path)
        return {"text": path.read_text("utf-8"), "path": str(path)}

    def _tell(self) -> None:
        self.number += 1
        self._wake()


def _about(file: FingerFile) -> dict[str, Any]:
    """What the drawing needs of a finger."""
    array = file.finger.array
    return {
        "sensors": {"y": array.points[:, 0], "z": array.points[:, 1], "names": list(file.names)},
        "area": array.on_area,
        "depths": np.broadcast_to(np.asarray(array.depth), (len(array),)),
        "unit": "N" if array.on_area else "N/m",
    }


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
