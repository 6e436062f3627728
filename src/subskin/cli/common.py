"""What the commands share that people see: numbers, tables, bars, JSON, and warnings of a finger and its tables."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain
from typing import TYPE_CHECKING, Any, TextIO

from .._lazy import np
from ..errors import FileError, InvalidValueError, SubskinError, each_printable, printable
from ..io.files import check_target, plain, to_standard_output
from .options import outputs_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from .. import io

__all__ = [
    "AREA_COLUMNS",
    "check_figure",
    "forces_said",
    "give",
    "note_orientation",
    "number",
    "progress_bar",
    "refuse_response",
    "said_of",
    "say",
    "show",
    "warn_of_depths",
    "warn_of_raw",
    "warn_of_spread",
]


def say(options: argparse.Namespace) -> TextIO:
    """Where text for people goes: not into a table or JSON that is written to standard output."""
    return sys.stderr if options.json or "-" in outputs_of(options).values() else sys.stdout


def number(value: float, digits: int = 4) -> str:
    """A number for people."""
    return "-" if not math.isfinite(value) else f"{value + 0.0:.{digits}g}"


def known_to(value: float, std: float) -> str:
    """A number for people, to the second digit of its standard error."""
    if not (math.isfinite(value) and 0 < std < math.inf):
        return number(value, 6)
    decimals = 1 - math.floor(math.log10(std))
    if 0 <= decimals < 9:
        return f"{round(value, decimals) + 0.0:.{decimals}f}"
    rounded = round(value, decimals)
    whole = math.floor(math.log10(abs(rounded))) + 1 if rounded else 1
    return number(rounded, max(whole + decimals, 1))


_QUIET = 60.0
"""Seconds for which a long command says nothing on a pipe."""


@contextmanager
def progress_bar(what: str, total: int | None, *, uneven: bool = False) -> Iterator[Callable[..., object]]:
    """A bar on standard error where that is a terminal.

    Yields what advances it, by one or by a number, and may then be told a better `total`; None for one not known yet.
    Where steps are `uneven`, the bar shows the time that has passed, for that left cannot be known; and on a pipe a
    line says every minute how far the work is.
    """
    if sys.stderr is None or not sys.stderr.isatty():
        yield _lines(what, total) if uneven and sys.stderr is not None else (lambda _count=1, _total=None: None)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn, TimeRemainingColumn

    time_column = TimeElapsedColumn() if uneven else TimeRemainingColumn()
    bar = Progress(what, BarColumn(), MofNCompleteColumn(), time_column, console=Console(stderr=True))
    with bar:
        task = bar.add_task("", total=total)
        yield lambda count=1, total=None: bar.update(task, advance=count, **({} if total is None else {"total": total}))


def _lines(what: str, total: int | None) -> Callable[..., object]:
    """Counts steps, and prints a line on standard error when a minute has passed since the last."""
    start = said = time.monotonic()
    done = 0

    def advance(count: int = 1) -> None:
        nonlocal said, done
        done += count
        now = time.monotonic()
        if now - said >= _QUIET:
            said = now
            print(f"subskin: {what}: {done} of {total}, {(now - start) / 60:.0f} min so far", file=sys.stderr)

    return advance


@contextmanager
def said_of(path: str) -> Iterator[None]:
    """What is wrong is said with the name of the file that it is wrong with."""
    try:
        yield
    except FileError:
        raise
    except SubskinError as error:
        raise FileError(f"{path}: {error.seen}", error.rule, error.fix) from None


def check_figure(path: str, option: str) -> None:
    """Raise where a figure could not be written to `path`: known before the work is done.

    Raises
    ------
    FileError
        An ending that is no figure's, a folder that is not there.
    """
    if not path.lower().endswith((".svg", ".png", ".pdf")):
        raise FileError(f"{option} {path}", "a figure is .svg, .png or .pdf", f"{option} figure.png")
    check_target(path)


def give(
    options: argparse.Namespace,
    data: Callable[[], Mapping[str, Any]],
    people: Callable[[TextIO], None],
    files: Mapping[str | None, Callable[[str], object]] | None = None,
    figure: Callable[[Any], Any] | None = None,
) -> int:
    """Draw with `figure(plot)`, write the files that are named, print JSON or for people; the exit code."""
    drawn = getattr(options, "figure", None)
    if drawn is not None and figure is not None:
        from .. import plot

        plot.save(figure(plot), drawn)
    for target, write in (files or {}).items():
        if target is not None:
            write(target)
    if options.json:
        to_standard_output(json.JSONEncoder(allow_nan=False).iterencode(plain(data())), end="\n")
        return 0
    out = say(options)
    people(out)
    for target in (*(files or {}), drawn):
        if target not in (None, "-"):
            print(f"-> {printable(target)}", file=out)
    return 0


_EDGES = 2
"""Blanks at both ends of a line."""
_WIDE, _TIGHT = 3, 1
"""Blanks between two columns."""
_TEXT = 24
"""A column of text is not made narrower than this."""


def show(out: TextIO, title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> None:
    """A table for people; the first `left` columns are text, the rest numbers.

    On a narrow terminal headings wrap, then text, then columns move together. Where that is not enough the terminal
    folds the lines.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    heading, *cells = each_printable([title, *columns, *chain.from_iterable(rows)])
    wide = len(columns)

    class Piped(Console):
        def on_broken_pipe(self) -> None:  # rich would end the process, with the code of no result
            raise BrokenPipeError

    console = Piped(file=out, highlight=False)
    room = console.width - _EDGES if out.isatty() else math.inf
    for blanks in (_WIDE, _TIGHT):
        widths = _widths([cells[i::wide] for i in range(wide)], left, room - blanks * (wide - 1))
        if (full := sum(widths) + blanks * (wide - 1)) <= room:
            break
    table = Table(title=Text(heading), title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    table.padding = (0, blanks // 2)
    for i, (name, width) in enumerate(zip(cells[:wide], widths, strict=True)):
        table.add_column(Text(name), justify="left" if i < left else "right", width=width, overflow="fold")
    for first in range(wide, len(cells), wide):
        table.add_row(*map(Text, cells[first : first + wide]))
    console.width = full + _EDGES + blanks  # which rich before 15 needs at the edge; a table takes what it needs
    console.print(table)


def _widths(columns: Sequence[Sequence[str]], left: int, room: float) -> list[int]:
    """The width of each column, a heading and its cells; together `room` where words can be wrapped so far."""
    from rich.cells import cell_len

    widths = [max(map(cell_len, cells)) for cells in columns]
    words = [[cell_len(word) for cell in cells for word in cell.split()] for cells in columns]
    least = [max(max(found, default=0), min(width, _TEXT)) for found, width in zip(words[:left], widths, strict=False)]
    for heading, *cells in columns[left:]:
        least.append(max(map(cell_len, [*heading.split(), *cells]), default=0))
    for group in (range(left, len(widths)), range(left)):
        while sum(widths) > room and (loose := [i for i in group if widths[i] > least[i]]):
            widths[max(loose, key=widths.__getitem__)] -= 1
    return widths


AREA_COLUMNS = ("position_y", "position_z")
"""Positions on an area, in tables."""

_ALIKE = 0.05  # presses whose depths differ by less are alike


def refuse_response(file: io.FingerFile, what: str) -> None:
    """Raise where the finger of the file has a response in place, which does not know `what`.

    Raises
    ------
    InvalidValueError
        It has one.
    """
    if file.finger.measured is not None:
        rule = f"a response in place knows the contact of its touches alone, and not {what}"
        fix = "remove the line response = ... of [calibration]: the skin's field then answers; or subskin locate"
        raise InvalidValueError("[calibration] response", rule, fix)


def forces_said(file: io.FingerFile, loads: Mapping[str, Any], column: str | None) -> str:
    """What forces found with a finger calibrated on touches with these `loads` are in; "" where a `column` said it."""
    from ..loads import force_unit

    if "force" not in loads:
        return "forces found with this finger are multiples of the touches' load (no --force-column)"
    force = file.one_force
    if column or force is None:
        return ""
    return f"every touch carries {number(force)} {force_unit(file.finger.array.on_area)} (normal_force under [locate])"


def warn_of_depths(table: io.Table, fix: str) -> None:
    """Warn where presses have several approaches, and no force says how hard each was."""
    if "depth" in table.columns and len(table):
        depth = table.numbers("depth")
        warn_of_spread(table.name, depth, fix)


def warn_of_spread(name: str, depth: npt.NDArray[np.float64], fix: str) -> None:
    """The same, of the presses' depths [m]."""
    low, high = 1e3 * float(depth.min()), 1e3 * float(depth.max())
    if high - low > _ALIKE * high:
        what = f"presses of {low:.3g} to {high:.3g} mm, and no force"
        rule = "presses without a force are all taken to be alike, and a deeper press is harder"
        print(f"subskin: warning: {name}: {what}: {rule}. Fix: {fix}", file=sys.stderr)


def note_orientation(file: io.FingerFile) -> None:
    """Say where nobody has confirmed which way round the sensors are, which no status can see."""
    if file.oriented is None:
        what = "nobody has confirmed which way round its sensors are"
        print(f"subskin: note: {printable(file.name)}: {what}. Fix: subskin orient", file=sys.stderr)


def warn_of_raw(options: argparse.Namespace, file: io.FingerFile, table: io.Table | io.TableReader) -> None:
    """Say where a raw recording is read without --tare, though its unit or its offsets are not the finger's."""
    how = file.recording
    if options.tare is not None or how is None or (how.scale == 1 and not file.differences):
        return
    if {column.name for column in (how.time, how.press) if column is not None} <= set(table.columns):
        what = "it has the columns of a raw recording, and the finger reads SI units without offsets"
        print(f"subskin: warning: {table.name}: {what}. Fix: --tare reads it by [recording]", file=sys.stderr)
