"""The view of a search: goals as a form, the search as it runs, the map of designs, and the fingers that it found."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from importlib.resources import files
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from .._check import FloatArray
from ..design import rank_fingers, search_grid
from ..design.finger_table import finger_table, legend_of
from ..design.search import DesignedFinger, DesignGrid, DesignStudy
from ..design.words import reasons_of, remedies_of, verdict_of
from ..errors import InvalidValueError, SubskinError
from ..io.goals_file import GoalsFile, finger_text, parse_goals
from .view import StudioView, asked, done

__all__ = ["DesignView"]

_FIELDS = (
    ("touch", "force", "forces, weakest and strongest"),
    ("touch", "friction", "friction"),
    ("touch", "span", "length that is touched"),
    ("touch", "area", "sides of the area that is touched"),
    ("touch", "edge", "length of an edge"),
    ("touch", "feature", "two edges that read as two"),
    ("touch", "largest_strain", "largest strain"),
    ("accuracy", "position", "error of the position"),
    ("accuracy", "angle", "error of the angle"),
    ("accuracy", "force", "error of the force, as a share"),
    ("accuracy", "edge", "error of an edge's direction"),
    ("accuracy", "unsure", "share that may be unsure"),
    ("room", "count", "count, least and most"),
    ("room", "depth", "depth, least and most"),
    ("room", "least_pitch", "least pitch"),
    ("room", "longest_row", "longest row"),
    ("search", "depths", "depths tried"),
    ("search", "pitches", "pitches tried"),
)
Goals = Annotated[str, Field(max_length=100_000)]
Index = Annotated[int, Field(strict=True)]
_MOST = 30.0
"""Ratios above are drawn as this."""


Rows = dict[str, Mapping[str, FloatArray]]


class _Sent(Rows):
    """Finished rows in the process that searches: each is sent, so that a search that was stopped goes on."""

    def __init__(self, rows: Rows, pipe: Connection) -> None:
        super().__init__(rows)
        self._pipe, self._lock = pipe, threading.Lock()

    def put(self, key: str, row: Mapping[str, FloatArray]) -> None:
        """Keep a row."""
        self[key] = row
        self.say("row", (key, row))

    def say(self, what: str, value: Any = None) -> None:
        """Tell the studio; several threads may."""
        with self._lock:
            try:
                self._pipe.send((what, value))
            except BrokenPipeError:
                raise SystemExit from None  # the studio is gone


def _searched(pipe: Connection, text: str, rows: Rows) -> None:
    """The search, in a process of its own: it can be ended at any moment, and what is live does not wait for it."""
    sent = _Sent(rows, pipe)
    try:
        grid = search_grid(parse_goals(text).goals, store=sent, progress=lambda: sent.say("step"))
        sent.say("grid", grid)
        sent.say("study", rank_fingers(grid, progress=lambda: sent.say("step")))
    except SubskinError as error:
        sent.say("fault", str(error))


class DesignView(StudioView):
    """One search at a time, which all pages see.

    Parameters
    ----------
    wake : callable
        Called from another thread when there is something new.
    """

    number = 0

    def __init__(self, wake: Callable[[], object]) -> None:
        super().__init__(wake)
        self.text = files("subskin.io").joinpath("goals_example.toml").read_text("utf-8")
        self._rows: Rows = {}
        self._process: SpawnProcess | None = None
        self._thread: threading.Thread | None = None
        self._run, self._fault, self._done, self._total = "idle", "", 0, 1
        self._file: GoalsFile | None = None
        self._grid: DesignGrid | None = None
        self._study: DesignStudy | None = None

    @asked
    def begin(self) -> dict[str, Any]:
        """The goals of the last search, or an example, and their form."""
        return _form(self.text)

    @asked
    def check(self, text: Goals) -> dict[str, Any]:
        """Goals as they were typed, and their form."""
        return _form(text)

    @asked
    def edit(self, text: Goals, key: str, value: Annotated[str, Field(max_length=200)]) -> dict[str, Any]:
        """Goals with another value of a field."""
        return _form(_edited(text, key, value))

    def told(self) -> dict[str, Any]:
        """How the search stands."""
        out: dict[str, Any] = {"run": self._run, "fault": self._fault, "done": self._done, "total": self._total}
        grid, study = self._grid, self._study
        if grid is not None:
            goals = grid.goals
            out["map"] = {
                "skins": [skin.name for skin in goals.skins],
                "sensors": [kind.name for kind in goals.choices],
                "layouts": [
                    f"{layout.count} sensors, {layout.text}" if goals.on_area else f"{layout.count} sensors"
                    for layout in goals.layouts
                ],
                "rows": int(np.isfinite(grid.excess).sum()),
            }
        if study is not None:
            columns, rows, left = finger_table(study)
            out["study"] = {
                "verdict": verdict_of(study),
                "remedies": remedies_of(study),
                "legend": legend_of(study),
                "columns": columns,
                "rows": rows,
                "left": left,
                "fingers": [
                    {**_where(study, one), "meets": one.meets, "reasons": reasons_of(study, one.row)}
                    for one in study.fingers
                ],
            }
        return out

    def close(self) -> None:
        """Stop what runs; finished rows are kept."""
        if self._process is not None:
            self._process.terminate()
        if self._thread is not None:
            self._thread.join(10.0)

    @done
    def start(self, text: Goals) -> None:
        """Begin a search."""
        file = parse_goals(text)
        self.close()
        self.text, self._file, self._grid, self._study, self._fault = text, file, None, None, ""
        looks = len(file.goals.skins) * len(file.goals.choices)
        self._run, self._done, self._total = "searching", 0, looks * file.goals.effort.depths
        spawn = get_context("spawn")
        here, there = spawn.Pipe(duplex=False)
        self._process = spawn.Process(target=_searched, args=(there, text, self._rows), daemon=True)
        self._process.start()
        there.close()
        self._thread = threading.Thread(target=self._follow, args=(here, looks), daemon=True)
        self._thread.start()
        self._tell()

    @done
    def stop(self) -> None:
        """End the search; finished rows are kept."""
        self.close()

    def _follow(self, pipe: Connection, looks: int) -> None:
        """Hear what the search says until it ends, or is ended."""
        with pipe, suppress(EOFError, OSError):
            while self._run != "done":
                what, value = pipe.recv()
                if what == "row":
                    self._rows[value[0]] = value[1]
                    continue
                if what == "step":
                    self._done += 1
                elif what == "grid":
                    self._grid, self._run, self._done, self._total = value, "ranking", 0, looks
                elif what == "study":
                    self._study, self._run = value, "done"
                else:
                    self._run, self._fault = "failed", value
                self._tell()
        if self._run in ("searching", "ranking"):
            self._run = "stopped"
        self._tell()

    @asked
    def map(self, skin: Index = 0, sensor: Index = 0, layout: Index = 0) -> dict[str, Any]:
        """The designs of one skin, kind and count, or layout on an area."""
        grid = self._known()
        excess = grid.excess[_of(grid, skin, sensor)][:, :, _chosen("layout", layout, len(grid.goals.layouts))]
        return {
            "skin": skin,
            "sensor": sensor,
            "layout": layout,
            "depths": grid.depths[skin],
            "pitches": grid.pitches,
            "excess": np.where(np.isfinite(excess), np.minimum(excess, _MOST), np.nan),
        }

    @asked
    def hold(
        self,
        finger: Index | None = None,
        skin: Index = 0,
        sensor: Index = 0,
        layout: Index = 0,
        depth: Index = 0,
        pitch: Index = 0,
    ) -> dict[str, Any]:
        """A finger that was found, or a design of the map, as a finger.toml."""
        grid, file = self._known(), self._file
        assert file is not None
        search: Any
        if finger is not None:
            found = () if self._study is None else self._study.fingers
            if not found:
                raise InvalidValueError("no fingers", "no search has ended yet", "start the search")
            one = found[_chosen("finger", finger, len(found))]
            row, search = one.row, one.quality.search
        else:
            k, m = _of(grid, skin, sensor)
            d, s = _chosen("depth", depth, grid.depths.shape[1]), _chosen("pitch", pitch, len(grid.pitches))
            row, touches = grid.row(k, m, d, s, _chosen("layout", layout, len(grid.goals.layouts))), file.goals.touches
            search = touches.area or touches.span or (-0.5 * row.length, 0.5 * row.length)
        return {"text": finger_text(file, row, search, [f"{file.goals.title}: held in the studio"])}

    @asked
    def report(self) -> dict[str, Any]:
        """The report of a search that has ended, as a page."""
        from ..report import as_html, design_report

        if self._study is None or self._file is None:
            raise InvalidValueError("no report", "no search has ended yet", "start the search")
        return {"report": as_html(design_report(self._study, self._file.text))}

    def _known(self) -> DesignGrid:
        if self._grid is None:
            raise InvalidValueError("no design", "nothing has been searched yet", "start the search")
        return self._grid


def _of(grid: DesignGrid, skin: int, sensor: int) -> tuple[int, int]:
    """A skin and a kind of the grid."""
    return _chosen("skin", skin, len(grid.goals.skins)), _chosen("sensor", sensor, len(grid.goals.choices))


def _chosen(name: str, which: int, count: int) -> int:
    """Which of `count` things a page means."""
    if not 0 <= which < count:
        raise InvalidValueError(f"{name} {which}", f"there are {count}, counted from 0", "choose on the page")
    return which


def _form(text: str) -> dict[str, Any]:
    import tomlkit

    parse_goals(text)
    document: Any = tomlkit.parse(text)
    fields = [
        {"key": f"{table}.{key}", "label": label, "group": table, "value": _plain(document[table][key])}
        for table, key, label in _FIELDS
        if table in document and key in document[table]
    ]
    return {"text": text, "form": fields}


def _where(study: DesignStudy, one: DesignedFinger) -> dict[str, int]:
    """The map on which a finger lies."""
    return dict(zip(("skin", "sensor", "layout"), one.row.which(study.goals), strict=True))


def _plain(value: Any) -> str:
    """A value of a TOML file as a person types it; of a list its parts between dots."""
    return " .. ".join(str(one) for one in value) if isinstance(value, list) else str(value)


def _edited(text: str, key: str, value: str) -> str:
    """The goals with another value of a field."""
    import tomlkit

    if key not in {f"{table}.{name}" for table, name, _ in _FIELDS}:
        raise InvalidValueError(key, "the goals have no such field", "a field of the form")
    parse_goals(text)
    document: Any = tomlkit.parse(text)
    table, name = key.split(".")
    parts = [_typed(part.strip()) for part in value.split("..")] if ".." in value else [_typed(value.strip())]
    document[table][name] = parts if len(parts) > 1 else parts[0]
    return tomlkit.dumps(document)


def _typed(text: str) -> int | float | str:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
