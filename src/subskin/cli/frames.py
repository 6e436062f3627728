"""What the commands share that answer frame by frame: the table in, chunks with a progress bar, statuses, names."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from .common import add_rows, add_shared, check_figure, chosen_rows, say, show

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ..io.finger_file import FingerFile
    from ..io.tables import Table

    FloatArray = npt.NDArray[np.float64]

__all__ = [
    "MEANING",
    "add_frames",
    "check_targets",
    "in_chunks",
    "read_frames",
    "sensor_names",
    "show_statuses",
    "status_counts",
    "status_names",
    "told",
]

_CHUNK = 100_000

MEANING = {
    "ok": "one load explains the readings",
    "ambiguous": "another load explains them nearly as well, or the place is at the edge of the search",
    "no_contact": "nothing beyond noise",
    "unexplained": "no pressing load within the friction cone explains the readings",
    "incomplete": "too few sensors could be used",
}
"""What each status says, in words."""


def add_frames(parser: argparse.ArgumentParser, verb: str, what: str, figure: str) -> None:
    """The finger, the readings, --figure, --every and --rows, -o and --json."""
    parser.add_argument("finger", help="finger.toml, best as calibrated")
    parser.add_argument("readings", help="table of readings, CSV or Parquet; - for standard input")
    parser.add_argument("--figure", metavar="FILE", help=f"{figure} (.svg, .png or .pdf)")
    add_rows(parser, f"{verb} only")
    add_shared(parser, what)


def check_targets(options: argparse.Namespace) -> None:
    """Raise where -o or --figure could not be written: known before the work is done."""
    from ..io.files import check_target

    if options.figure is not None:
        check_figure(options.figure, "--figure")
    if options.out not in (None, "-"):
        check_target(options.out)


def read_frames(options: argparse.Namespace) -> tuple[FingerFile, Table, npt.NDArray[np.intp], FloatArray]:
    """The finger, the table, the rows that are chosen and their readings."""
    import numpy as np

    from ..io.finger_file import load_finger
    from ..io.tables import read_table

    file = load_finger(options.finger)
    table = read_table(options.readings)
    readings = table.readings(file.names)
    rows = np.flatnonzero(chosen_rows(options, len(table)) ^ getattr(options, "skip_used", False))
    return file, table, rows, readings[rows]


@contextmanager
def told(path: str) -> Iterator[None]:
    """What is wrong with a finger is said with the name of its file."""
    from ..errors import FileError, SubskinError

    try:
        yield
    except FileError:
        raise
    except SubskinError as error:
        raise FileError(f"{path}: {error.seen}", error.rule, error.fix) from None


def in_chunks(answer: Callable[[FloatArray], Any], readings: FloatArray) -> list[Any]:
    """`answer` of all frames, in chunks: memory stays small and the progress bar moves."""
    if len(readings) <= _CHUNK:
        return [answer(readings)]
    parts = []
    with _progress(len(readings)) as advance:
        for first in range(0, len(readings), _CHUNK):
            chunk = readings[first : first + _CHUNK]
            parts.append(answer(chunk))
            advance(len(chunk))
    return parts


@contextmanager
def _progress(total: int) -> Iterator[Callable[[int], None]]:
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    bar = Progress(
        "frames", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), console=Console(stderr=True)
    )
    with bar:
        task = bar.add_task("", total=total)
        yield lambda count: bar.advance(task, count)


def status_names(status: npt.NDArray[np.int8]) -> npt.NDArray[np.object_]:
    """Each frame's status in lower case."""
    import numpy as np

    from ..estimate.estimate import Status

    return np.array([s.name.lower() for s in Status], dtype=object)[status]


def status_counts(status: npt.NDArray[np.int8]) -> dict[str, int]:
    """How many frames have each status."""
    import numpy as np

    from ..estimate.estimate import Status

    counts = np.bincount(status.astype(np.intp).reshape(-1), minlength=len(Status))
    return {s.name.lower(): int(counts[s]) for s in Status}


def sensor_names(file: FingerFile, used: npt.NDArray[np.bool_]) -> npt.NDArray[np.str_]:
    """The columns that each frame's answer rests on, in one text."""
    import numpy as np

    patterns, group = np.unique(used, axis=0, return_inverse=True)
    names = [" ".join(n for n, on in zip(file.names, p, strict=True) if on) for p in patterns]
    return np.array(names, dtype=str)[group.reshape(-1)]


def show_statuses(options: argparse.Namespace, status: npt.NDArray[np.int8], meaning: dict[str, str]) -> None:
    """A table of the statuses for people."""
    rows = [[name, meaning[name], str(count)] for name, count in status_counts(status).items()]
    show(say(options), "frames", ["status", "", "count"], rows, left=2)
