"""Touches that were made before: a table of them, fitted as `subskin calibrate` does."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...calibration import Calibration, calibrate
from ...errors import FileError
from ...io.finger_file import FingerFile
from ...io.tables import Table, read_table
from .fit_told import fit_told
from .live.feed import Feed

__all__ = ["TouchesFeed"]

_FIT = ("gain", "offset", "depth", "origin")


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
        return self.file.with_finger(
            self.found.finger, self.found.origin, facts | {"r2": float(self.found.r2)}, turn=self.found.turn
        )

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
