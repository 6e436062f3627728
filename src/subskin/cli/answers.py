"""What the commands share that answer frame by frame, from the files to the answers and out again."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TextIO

import numpy as np
import numpy.typing as npt

from ..errors import InvalidValueError
from ..estimate.estimate import Estimate, Status
from ..io.files import check_target
from ..io.finger_file import FingerFile, load
from ..io.tables import Table, read_table
from ..stream.pipeline import Pipeline
from ..stream.stage import Stage
from .common import check_figure, chosen_rows, number, progress_bar, said_of, show
from .frames import warn_of_raw

__all__ = ["Answers", "answers_of", "estimate_columns", "show_first", "show_statuses", "status_counts", "status_names"]

Answer = Callable[[npt.ArrayLike], Any]


@dataclass(frozen=True)
class Answers:
    """The finger, the table, the rows that are chosen, and what was found in each of these."""

    file: FingerFile
    table: Table
    rows: npt.NDArray[np.intp]
    found: Any

    @property
    def used(self) -> npt.NDArray[np.str_]:
        """The columns that each row's answer rests on, in one text."""
        patterns, group = np.unique(self.found.used, axis=0, return_inverse=True)
        names = [" ".join(n for n, on in zip(self.file.names, p, strict=True) if on) for p in patterns]
        return np.array(names, dtype=str)[group.reshape(-1)]


class _Chosen(Stage[int, Any]):
    """An answer for some rows of a table; the stages before it see them all."""

    def __init__(self, rows: npt.NDArray[np.bool_], answer: Answer) -> None:
        self.rows, self.answer = rows, answer

    def step(self, state: int | None, readings: npt.ArrayLike, time: object) -> tuple[int, Any]:
        frames, first = np.asarray(readings), state or 0
        stop = first + len(frames)
        return stop, self.answer(frames[self.rows[first:stop]])


def answers_of(options: argparse.Namespace, prepare: Callable[[FingerFile], Answer]) -> Answers:
    """What `prepare(file)` makes of the rows that are chosen, through the pipeline of the finger's file with --tare.

    Raises
    ------
    FileError, InvalidValueError
        Whatever is wrong with the options, the finger or the table; nothing has been written.
    """
    check_figure(options.figure)
    for target in (options.out, getattr(options, "totals", None)):
        if target not in (None, "-"):
            check_target(target)
    file, table = load(options.finger), read_table(options.readings)
    warn_of_raw(options, file, table)
    rows = chosen_rows(options, len(table)) ^ getattr(options, "skip_used", False)
    readings, time = (table.readings(file.names), None) if options.tare is None else file.frames(table)
    drift = _drift(options.tare)
    with said_of(options.finger):
        answer = prepare(file)
        answer(np.empty((0, len(file.names))))  # what is wrong with the finger shows before the first frame
        stages = {} if options.tare is None else file.pipeline(drift=drift).stages
    pipeline = Pipeline({**stages, "found": _Chosen(rows, answer)})
    with said_of(table.name), progress_bar("frames", len(table)) as advance:
        out = pipeline(readings, time, progress=advance)
    for doubt in out["tare"].doubts if "tare" in out else ():
        print(f"subskin: warning: {doubt}", file=sys.stderr)
    return Answers(file, table, np.flatnonzero(rows), out["found"])


def _drift(text: str | None) -> float | None:
    """The value of --tare, which may be left out."""
    try:
        return float(text) if text else None
    except ValueError:
        raise InvalidValueError(f'--tare "{text}"', "a reading per second is needed, in SI units", "--tare 2") from None


def estimate_columns(answers: Answers, *, width: bool = False) -> dict[str, Any]:
    """Columns of a table of estimates, with those of the half width."""
    found: Estimate = answers.found
    std, interval, second = found.std, found.half_width_interval, found.second
    columns: dict[str, Any] = {
        "row": answers.rows,
        "position": found.position + answers.file.origin,
        "force": found.force,
        "angle": found.angle,
        "half_width": found.half_width,
        "position_std": std[:, 0],
        "force_std": std[:, 1],
        "angle_std": std[:, 2],
        "half_width_low": interval[:, 0],
        "half_width_high": interval[:, 1],
        "status": status_names(found.status),
        "residual": found.residual,
        "spare": found.spare,
        "second_position": second.position + answers.file.origin,
        "second_half_width": second.half_width,
        "second_chi2": second.chi2,
        "used": answers.used,
    }
    if answers.file.length is not None:
        columns["newtons"] = found.force * answers.file.length
    return {k: v for k, v in columns.items() if width or not ("half_width" in k or k == "spare")}


def show_first(
    out: TextIO,
    columns: Mapping[str, Any],
    names: Sequence[str],
    title: str = "the first frames, in SI; -o writes them all",
    left: int = 1,
) -> None:
    """The first rows of some columns, for people."""
    count = min(len(columns["row"]), 20)
    show(out, title, names, [[_cell(columns[name][i]) for name in names] for i in range(count)], left)


def _cell(value: Any) -> str:
    return number(value) if isinstance(value, float) else str(value)


def status_names(status: npt.NDArray[np.int8]) -> npt.NDArray[np.object_]:
    """Each frame's status in lower case."""
    return np.array([s.name.lower() for s in Status], dtype=object)[status]


def status_counts(status: npt.NDArray[np.int8]) -> dict[str, int]:
    """How many frames have each status."""
    counts = np.bincount(status.astype(np.intp).reshape(-1), minlength=len(Status))
    return {s.name.lower(): int(counts[s]) for s in Status}


def show_statuses(out: TextIO, status: npt.NDArray[np.int8], meaning: Mapping[str, str]) -> None:
    """A table of the statuses for people."""
    rows = [[name, meaning[name], str(count)] for name, count in status_counts(status).items()]
    show(out, "frames", ["status", "", "count"], rows, left=2)
