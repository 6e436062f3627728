"""What the commands share that answer frame by frame, from the files to the answers and out again."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any, TextIO, cast

import numpy as np
import numpy.typing as npt

from ..errors import FileError, InvalidValueError, printable
from ..estimate.answer import Status
from ..estimate.estimate import Estimate
from ..estimate.layout import LINE, SIZED_LINE, WIDE
from ..estimate.on_area import moved
from ..estimate.resultants import Resultant
from ..estimate.several import TouchSet
from ..io.finger_file import FingerFile, load
from ..io.tables import Table, reading, writing
from ..stream.stage import Pipeline, Stage, join
from ..stream.tare import Tared
from .common import number, progress_bar, said_of, show, warn_of_raw
from .options import Rows

__all__ = [
    "Answers", "Kept", "against", "answers_of", "estimate_columns", "show_first", "show_statuses", "status_names",
]  # fmt: skip

Answer = Callable[..., Any]

_SHOWN = 20  # rows for the screen


@dataclass(frozen=True)
class Answers:
    """A stretch of the table: the rows in it that are chosen, counted from the table's first, and their answers."""

    file: FingerFile
    table: Table
    rows: npt.NDArray[np.intp]
    local: npt.NDArray[np.intp]
    found: Any

    @property
    def used(self) -> npt.NDArray[np.str_]:
        """The columns that each row's answer rests on, in one text."""
        patterns, group = np.unique(self.found.used, axis=0, return_inverse=True)
        names = [" ".join([n for n, on in zip(self.file.names, p, strict=True) if on]) for p in patterns]
        return np.array(names, dtype=str)[group.reshape(-1)]

    def column(self, name: str, why: str) -> npt.NDArray[np.float64]:
        """Another column of the table, in the rows that are chosen; each has to hold a number."""
        return self.table.numbers(name, finite=True, why=why)[self.local]


class _Chosen(Stage[int, Any]):
    """Which rows of a table are chosen, and the answer for these; the stages before it see them all."""

    def __init__(self, rows: Rows, answer: Answer) -> None:
        self.rows, self.answer = rows, answer
        self.takes_doubt = getattr(answer, "takes_doubt", False)

    def step(
        self, state: int | None, readings: npt.ArrayLike, time: object, doubt: npt.NDArray[np.float64] | None = None
    ) -> tuple[int, Any]:
        frames, first = np.asarray(readings), state or 0
        chosen = self.rows.of(first, len(frames))
        more = {} if doubt is None else {"doubt": doubt[chosen]}
        return first + len(frames), (np.flatnonzero(chosen), self.answer(frames[chosen], **more))


def answers_of(
    options: argparse.Namespace, prepare: Callable[[FingerFile], Answer], *, at_once: int = 20_000
) -> Iterator[Answers]:
    """What `prepare(file)` makes of the rows that are chosen, through the pipeline of the finger's file with --tare.

    The table is read, and answered, `at_once` rows at a time at most: memory holds no more of it. There is at least one
    stretch, which may have no rows.

    Raises
    ------
    FileError, InvalidValueError
        Whatever is wrong with the options, the finger or the table.
    """
    file = load(options.finger)
    with reading(options.readings) as table, progress_bar("frames", table.total) as advance:
        warn_of_raw(options, file, table)
        rows = Rows(options)
        drift = _drift(options.tare)
        with said_of(options.finger):
            answer = prepare(file)  # what is wrong with the finger shows before the first frame
            stages = {} if options.tare is None else file.pipeline(drift=drift).stages
        found_by = _Chosen(rows, answer)
        pipeline = Pipeline({**stages, "found": found_by})
        undone = stages.get("relaxation")
        if getattr(undone, "doubted", False) and not found_by.takes_doubt:
            what = "[relaxation] undoes what is held, but this answer does not weigh its doubt"
            print(f"subskin: warning: {what}. Fix: subskin locate does", file=sys.stderr)
        state, first, tared, last = None, 0, [], -np.inf
        for block in table:
            readings, time = (block.readings(file.names), None) if options.tare is None else file.frames(block)
            if time is not None:
                last = _forward(block, time, last)
            for begin in range(0, max(len(readings), 1), at_once):
                part = slice(begin, begin + at_once)
                with said_of(table.name):
                    state, out = pipeline.step(state, readings[part], None if time is None else time[part])
                if "tare" in out:
                    tared.append(_thinned(out["tare"]))
                advance(len(readings[part]), table.total)
                chosen, found = out["found"]
                yield Answers(file, block, first + begin + chosen, begin + chosen, found)
            first += len(readings)
        rows.check(first)
    if not first:
        print(f"subskin: warning: {printable(table.name)} has no rows", file=sys.stderr)
    for doubt in join(tared).doubts if tared else ():
        print(f"subskin: warning: {printable(doubt)}", file=sys.stderr)


def _forward(block: Table, time: npt.NDArray[np.float64], last: float) -> float:
    """The last of the times, none of which may be before the one ahead of it, or before `last`."""
    before = np.concatenate([[last], time[:-1]])
    back = np.flatnonzero(time < before)
    if back.size:
        row = int(back[0])
        seen = f"{block.position(row)}: time = {time[row]:.6g} s"
        rule = f"time must not go back (it was {before[row]:.6g} s)"
        raise FileError(seen, rule, "sort the frames by time")
    return float(time[-1]) if time.size else last


def _thinned(tared: Tared) -> Tared:
    """At most 1000 frames of a stretch, for what is said of the stream as a whole."""
    step = slice(None, None, 1 + len(tared.free) // 1000)
    frames = ("readings", "offset", "free", "frozen")
    return replace(tared, doubt=None, **{name: getattr(tared, name)[step] for name in frames})


class Kept(ExitStack):
    """What is kept of the stretches: how many frames have each status, the first rows, whole columns, and the table -o.

    Parameters
    ----------
    options : Namespace
        `out`, and `json`, with which all columns are kept to the last row.
    columns : sequence of str
        Those to keep without it.
    """

    def __init__(self, options: argparse.Namespace, columns: Sequence[str] = ()) -> None:
        super().__init__()
        self._table = None if options.out is None else self.enter_context(writing(options.out))
        self.files: dict[str | None, Callable[[str], object]] = {options.out: lambda _: self.close()}
        """What `give` finishes."""
        self.frames = 0
        self.status = {s.name.lower(): 0 for s in Status}
        self.first: dict[str, Any] = {}
        self._names, self._parts = None if options.json else columns, cast("list[dict[str, Any]]", [])

    def add(
        self, columns: Mapping[str, Any], status: npt.NDArray[np.int8], written: Mapping[str, Any] | None = None
    ) -> None:
        """Take a stretch; what is `written` of it, if not its columns."""
        if self._table is not None:
            self._table.write(columns if written is None else written)
        if len(self.first.get("row", ())) < _SHOWN:
            old = self.first or {name: np.asarray(values)[:0] for name, values in columns.items()}
            self.first = {n: np.concatenate([old[n], v[: _SHOWN - len(old[n])]]) for n, v in columns.items()}
        self.frames += len(status)
        for name, count in status_counts(status).items():
            self.status[name] += count
        names = columns if self._names is None else self._names
        self._parts.append({name: columns[name] for name in names})

    @property
    def columns(self) -> dict[str, Any]:
        """The columns that were kept."""
        return {name: np.concatenate([part[name] for part in self._parts]) for name in self._parts[0]}


def _drift(text: str | None) -> float | None:
    """The value of --tare, which may be left out."""
    try:
        return float(text) if text else None
    except ValueError:
        raise InvalidValueError(f'--tare "{text}"', "a reading per second is needed, in SI units", "--tare 2") from None


def estimate_columns(answers: Answers, *, width: bool = False) -> dict[str, Any]:
    """Columns of a table of answers: those of `to_dict`, positions and drags on the axes of the tables.

    With `width` a table of line loads has half widths, which are 0.
    """
    found, file = answers.found, answers.file
    layout = found.layout if isinstance(found, Estimate) else None
    long, area = layout in (LINE, SIZED_LINE, WIDE), True
    if isinstance(found, TouchSet):
        found = found.moved(file.origin, file.turn)
    elif area := layout is not None and layout.dim == 2:
        found = moved(found, file.origin, file.turn)
    columns = {"row": answers.rows, **found.to_dict()}
    if isinstance(answers.found, Resultant):
        columns = {name: values for name, values in columns.items() if not name.startswith("second_")}
        if area:
            columns |= {"torsion": answers.found.torsion, "torsion_std": answers.found.torsion_std}
    columns.pop("half_width_std", None)  # the interval says more: readings know the square of a half width
    if width and layout == LINE:
        columns |= dict.fromkeys(("half_width", "half_width_low", "half_width_high"), found.half_width)
        columns["second_half_width"] = found.second.half_width
    columns["used"] = answers.used
    for name in () if area else columns.keys() & {"position", "second_position"}:
        columns[name] = columns[name] + file.origin
    if long and file.length is not None and not found.relative:
        columns["newtons"] = columns["force"] * file.length
    return columns


def against(columns: Mapping[str, Any], answers: Answers, names: str) -> dict[str, Any]:
    """Columns of the true positions, of the errors, and of whether a truth lies beyond the search.

    On an area, where two columns are named, the error is the distance.

    Raises
    ------
    InvalidValueError
        One column for an area, two for a row.
    """
    given, on_area = names.split(","), "position_y" in columns
    if len(given) != 1 + on_area:
        rule = "sensors on an area need two columns, y and z" if on_area else "a row needs one column"
        raise InvalidValueError(f'--truth "{names}"', rule, "--truth y,z" if on_area else "--truth position")
    truth = [answers.column(name.strip(), "the true position") for name in given]
    locator = answers.file.locator()
    if not on_area:
        outside = ~locator.covers(truth[0] - answers.file.origin)
        return {"truth": truth[0], "error": columns["position"] - truth[0], "beyond": outside}
    y, z = truth
    error = np.hypot(columns["position_y"] - y, columns["position_z"] - z)
    outside = ~locator.covers(answers.file.on_finger(np.stack(truth, axis=-1)))
    return {"truth_y": y, "truth_z": z, "error": error, "beyond": outside}


def show_first(
    out: TextIO,
    columns: Mapping[str, Any],
    names: Sequence[str],
    title: str = "the first frames, in SI; -o writes them all",
    left: int = 1,
) -> None:
    """Rows of some columns, for people."""
    rows = [[_cell(columns[name][i]) for name in names] for i in range(len(columns["row"]))]
    show(out, title, names, rows, left)


def _cell(value: Any) -> str:
    return number(value) if isinstance(value, float) else str(value)


def status_names(status: npt.NDArray[np.int8]) -> npt.NDArray[np.object_]:
    """Each frame's status in lower case."""
    return np.array([s.name.lower() for s in Status], dtype=object)[status]


def status_counts(status: npt.NDArray[np.int8]) -> dict[str, int]:
    """How many frames have each status."""
    counts = np.bincount(status.astype(np.intp).reshape(-1), minlength=len(Status))
    return {s.name.lower(): int(counts[s]) for s in Status}


def show_statuses(out: TextIO, status: Mapping[str, int], meaning: Mapping[str, str]) -> None:
    """A table of how many frames have each status, for people."""
    show(out, "frames", ["status", "", "count"], [[name, meaning[name], str(n)] for name, n in status.items()], left=2)
