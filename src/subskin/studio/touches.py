"""Sessions of a calibration: touches that are asked for at the bench, or were made before; and what is told of both."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .._check import FloatArray
from .._shown import with_error
from ..calibration import Calibration, calibrate
from ..errors import FileError
from ..io.changed import with_calibration
from ..io.finger_file import FingerFile
from ..io.tables import Table, read_table
from ..live.batch import BareChain
from ..live.bench import Bench
from ..live.connecting import connected
from ..live.run import Live
from ..live.session import BenchState, Said, calibrated
from .feed import Feed

__all__ = ["BenchFeed", "TouchesFeed", "fit_told"]

_WAIT = 0.05
_SAID = 40
"""Lines that are kept of what was said."""
_FIT = ("gain", "offset", "depth", "origin")


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
        return calibrated(self.file, self.bench.fit, self.bench.result(self.bench_state))

    def order(self, what: str) -> None:
        """Something that the person wants of the session; it is done between two batches.

        Parameters
        ----------
        what : {"again", "skip", "end"}
            A method of the bench.
        """
        self._orders.append(getattr(self.bench, what))

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

        self._orders.append(moved)

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

    def told(self) -> dict[str, Any]:  # noqa: D102
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


class TouchesFeed(Feed):
    """A table of touches, from its text to the finger that is fitted to it.

    The table has a column of positions, on an area two, and one for each sensor; force, angle and azimuth of each touch
    where it has columns of these names.

    Parameters
    ----------
    file : FingerFile
        The finger as drawn.
    name, text : str
        What the table is called, and what it says, as CSV.
    fit : sequence of str
        As in `calibrate`; gain, offset, depth and origin, on an area also turn, if empty.
    tell : callable
        As of `Feed`.
    """

    def __init__(self, file: FingerFile, name: str, text: str, fit: Sequence[str], tell: Callable[[], object]) -> None:
        super().__init__(name, tell)
        self.file, self._text = file, text
        self.fit = tuple(fit) or (*_FIT, "turn")[: 5 if file.finger.array.on_area else 4]
        self.found: Calibration | None = None
        self.positions = np.empty(0)
        self.relative = True

    def result(self) -> FingerFile:
        """The finger that is fitted.

        Raises
        ------
        FileError
            None is.
        """
        if self.found is None:
            raise FileError(self.name, "no finger was fitted to it", "touches that the finger can explain")
        facts = {"source": self.name, "fit": list(self.fit), "touches": self.found.score.touches}
        return with_calibration(self.file, self.found, facts | {"r2": float(self.found.r2)})

    def told(self) -> dict[str, Any]:  # noqa: D102
        return {
            **super().told(),
            "phase": "fit" if self.found is None else "done",
            "touches": self.positions,
            "said": [] if self.found is None else [self.found.misfit.verdict],
            **fit_told(self.file, self.found, relative=self.relative),
        }

    def _follow(self) -> None:
        self.state = "running"
        self._tell()
        table = _table(self.name, self._text)
        self.file = self.file.for_touches(table)
        self.fit = self.file.to_fit(self.fit)
        area = self.file.finger.array.on_area
        names = ("position_y", "position_z") if area else ("position",)
        each = [table.numbers(name, finite=True, why="each touch's position") for name in names]
        self.positions = np.stack(each, axis=-1) if area else each[0]
        loads: dict[str, Any] = {
            name: table.numbers(name, finite=True, why=f"the touches' {name}")
            for name in ("force", "angle", *("azimuth",) * area)
            if name in table.columns
        }
        self.relative = "force" not in loads
        self.found = calibrate(
            self.file.finger,
            table.readings(self.file.names),
            self.positions,
            fit=self.fit,
            origin=None if "origin" in self.fit else self.file.origin,
            turn=self.file.turn,
            load=self.file.load,
            **loads,
        )


def _table(name: str, text: str) -> Table:
    """The table of a text; errors name it as the page does."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "touches.csv"
        path.write_text(text, "utf-8")
        try:
            return replace(read_table(path), name=name)
        except FileError as error:
            raise FileError(error.seen.replace(str(path), name), error.rule, error.fix) from None


def fit_told(file: FingerFile, found: Calibration | None, *, relative: bool) -> dict[str, Any]:
    """What a page is told of a calibration, or that there is none yet.

    Parameters
    ----------
    file : FingerFile
        The finger as it was.
    found : Calibration or None
        What the touches made of it.
    relative : bool
        The force of the touches is not known, and nor is the gain of all sensors together.
    """
    if found is None:
        return {"health": ["ok"] * len(file.names), "r2": None, "doubts": [], "changes": []}
    return {
        "health": [one.name.lower() for one in found.health],
        "r2": float(found.r2),
        "doubts": list(found.doubts),
        "changes": _changes(file, found, relative),
    }


def _changes(file: FingerFile, found: Calibration, relative: bool) -> list[list[str]]:
    """What is another number than in the file: what, in the file, found, its standard error; empty where not fitted."""
    old, new = file.finger.array, found.finger.array
    n = len(new)
    gains = [np.broadcast_to(np.asarray(one.gain, float), (n,)) for one in (old, new)]
    depths = [1e3 * float(np.mean(np.asarray(one.depth))) for one in (old, new)]
    slope = np.eye(n)
    if relative:
        slope = (slope - gains[1][:, None] / gains[1].sum()) / gains[1].mean()
        gains = [gain / gain.mean() for gain in gains]
    rows = []
    for name, before, after, error in zip(file.names, *gains, _errors(found, "gain", slope), strict=True):
        rows.append([f"gain of {name}{', of the mean' if relative else ''}", f"{before:.4g}", *_shown(after, error)])
    depth_errors = (_errors(found, term, np.full((1, k), 1e3 / k))[0] for term, k in (("depth", 1), ("depths", n)))
    depth_error = next(filter(np.isfinite, depth_errors), np.nan)
    rows.append(["depth of the sensors, mean", f"{depths[0]:.3f} mm", *_shown(depths[1], depth_error, "mm")])
    origins = [1e3 * each for each in np.broadcast_arrays(*map(np.atleast_1d, (file.origin, found.origin)))]
    for axis, before, after in zip("yz", *origins, strict=False):
        term = f"origin_{axis}" if len(origins[0]) > 1 else "origin"
        error = _errors(found, term, np.full((1, 1), 1e3))[0]
        rows.append([f"origin {axis}", f"{before:.3f} mm", *_shown(after, error, "mm")])
    return rows


def _errors(found: Calibration, name: str, slope: FloatArray) -> FloatArray:
    """Standard errors of what is linear in the fitted numbers of a name; NaN where these were not fitted."""
    at = [i for i, p in enumerate(found.parameters) if p.name == name]
    if len(at) != slope.shape[1]:
        return np.full(len(slope), np.nan)
    return np.asarray(np.sqrt(np.einsum("ij,jk,ik->i", slope, found.covariance[np.ix_(at, at)], slope)))


def _shown(value: float, error: float, unit: str = "") -> tuple[str, str]:
    """A number and its standard error, to the digits that the error leaves."""
    if not (np.isfinite(error) and error > 0):
        return f"{value:.3f} {unit}" if unit else f"{value:.4g}", ""
    number, _, rest = with_error(value, error, "").partition(" +- ")
    return f"{number} {unit}".strip().replace("-", "\N{MINUS SIGN}"), f"{rest} {unit}".strip()
