"""What the commands share: options, values with units, rows, numbers for people, JSON."""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain
from typing import TYPE_CHECKING, Any, TextIO

from .._lazy import np
from ..errors import FileError, InvalidValueError, SubskinError, each_printable, printable
from ..io.files import check_target, to_standard_output
from ..io.units import line_load, quantity

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = [
    "Rows",
    "add_figure",
    "add_json",
    "add_rows",
    "add_shared",
    "check_figure",
    "chosen_rows",
    "describe",
    "give",
    "inputs_of",
    "listed",
    "number",
    "outputs_of",
    "plain",
    "positive",
    "progress_bar",
    "quantity_range",
    "said_of",
    "say",
    "show",
]


def describe(parser: argparse.ArgumentParser, run: Any, examples: str, notes: str = "") -> None:
    """What the help says after the first line, and what runs."""
    parser.description = f"{parser.description}\n\n{notes}" if notes else parser.description
    parser.epilog = f"examples:\n{examples}"
    parser.set_defaults(run=run)


def add_shared(parser: argparse.ArgumentParser, what: str) -> None:
    """-o and --json."""
    parser.add_argument(
        "-o", "--out", metavar="FILE", help=f"{what}; CSV, or Parquet for .parquet; - for standard output"
    )
    add_json(parser)


def add_json(parser: argparse.ArgumentParser) -> None:
    """--json."""
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def add_figure(parser: Any, what: str) -> None:
    """--figure, of a parser or a group of options."""
    parser.add_argument("--figure", metavar="FILE", help=f"{what} (.svg, .png or .pdf)")


def add_rows(parser: argparse.ArgumentParser, verb: str) -> None:
    """--every and --rows."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--every", type=int, metavar="N", help=f"{verb} rows 0, N, 2N, ...")
    group.add_argument("--rows", metavar="LIST", help=f"{verb} these rows, counted from 0: 10,30,50 or 0-9,20")


class Rows:
    """The rows that --every or --rows names, all without them; or, with --skip-used, the others.

    Parameters
    ----------
    options : Namespace
        `every`, `rows` and, of some commands, `skip_used`.

    Raises
    ------
    InvalidValueError
        Options that say no rows.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self._every, self._others = options.every, getattr(options, "skip_used", False)
        self._ranges: list[tuple[str, int, int]] | None = None
        if self._every is not None and self._every < 1:
            raise InvalidValueError(f"--every {self._every}", "has to be >= 1", "--every 2 takes every second row")
        if options.rows is not None:
            self._ranges = [self._range(part) for part in options.rows.split(",")]

    @staticmethod
    def _range(part: str) -> tuple[str, int, int]:
        match = re.fullmatch(r"\s*([0-9]{1,12})(?:\s*-\s*([0-9]{1,12}))?\s*", part)
        if match is None:
            raise InvalidValueError(f'--rows "{part}"', "rows are whole numbers", "--rows 10,30,50 or 0-9,20")
        first, last = int(match[1]), int(match[2] or match[1])
        if first > last:
            raise InvalidValueError(f"--rows {part.strip()}", "the first has to be <= the last", f"{last}-{first}")
        return part.strip(), first, last

    def of(self, first: int, count: int) -> npt.NDArray[np.bool_]:
        """Which of `count` rows are chosen, the first of which is row `first` of the table."""
        chosen = np.zeros(count, dtype=bool)
        if self._every is not None:
            chosen[-first % self._every :: self._every] = True
        elif self._ranges is not None:
            for _, begin, end in self._ranges:
                chosen[max(begin - first, 0) : max(end + 1 - first, 0)] = True
        else:
            chosen[:] = True
        return chosen ^ self._others

    def check(self, count: int) -> None:
        """Raise where a row is named that a table of `count` rows has not got.

        Raises
        ------
        InvalidValueError
            There is such a row.
        """
        for part, _, last in self._ranges or ():
            if last >= count:
                rule = f"the table has rows 0 to {count - 1}" if count else "the table has no rows"
                raise InvalidValueError(f"--rows {part}", rule, "rows are counted from 0")


def chosen_rows(options: argparse.Namespace, count: int) -> npt.NDArray[np.bool_]:
    """Which of a table's `count` rows are chosen, as by `Rows`."""
    rows = Rows(options)
    rows.check(count)
    return rows.of(0, count)


def quantity_range(text: str, unit: str, name: str, length: float | None = None) -> tuple[float, float]:
    """A range, as "-5 mm .. 5 mm" or "-5..5 mm", or one value, in SI; forces in N are divided by the `length` [m]."""
    parts = [part.strip() for part in text.split("..")]
    if len(parts) == 1:
        value = _value(parts[0], unit, name, length)
        return value, value
    if len(parts) != 2:
        raise InvalidValueError(f'{name} "{text}"', "a value or a range is needed", f'{name} "-5 mm .. 5 mm"')
    if re.fullmatch(r"[-+.\deE]+", parts[0]):  # -5..5 mm: the unit belongs to both
        parts[0] += " " + re.sub(r"^\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*", "", parts[1])
    low, high = (_value(part.strip(), unit, name, length) for part in parts)
    if low > high:
        raise InvalidValueError(f'{name} "{text}"', "the first has to be <= the second", "swap them")
    return low, high


def _value(text: str, unit: str, name: str, length: float | None) -> float:
    return line_load(text, length, name) if unit == "N/m" else quantity(text, unit, name)


def positive(text: str, unit: str, name: str, fix: str = "", length: float | None = None) -> tuple[float, float]:
    """A range, or one value, above 0; `length` as in `quantity_range`."""
    low, high = quantity_range(text, unit, name, length)
    if not low > 0:
        raise InvalidValueError(f'{name} "{text}"', f"has to be > 0 [{unit}]", fix)
    return low, high


def listed(text: str) -> tuple[str, ...]:
    """What stands between commas."""
    return tuple(part.strip() for part in text.split(",") if part.strip())


def say(options: argparse.Namespace) -> TextIO:
    """Where text for people goes: not into a table or JSON that is written to standard output."""
    return sys.stderr if options.json or "-" in outputs_of(options).values() else sys.stdout


_INPUTS = {"finger": "the finger", "goals": "the goals", "readings": "the readings", "recording": "the recording",
           "touches": "the touches"}  # fmt: skip
_OUTPUTS = {"out": "-o", "relaxed": "--relaxation", "totals": "--totals", "figure": "--figure", "map": "--map",
            "tip_map": "--tip-map", "movie": "--movie", "record": "--record"}  # fmt: skip


def inputs_of(options: argparse.Namespace) -> dict[str, str]:
    """The files that a command reads, by what they are called."""
    return {said: path for key, said in _INPUTS.items() if isinstance(path := getattr(options, key, None), str)}


def outputs_of(options: argparse.Namespace) -> dict[str, str]:
    """The files that a command writes, by their options."""
    return {said: path for key, said in _OUTPUTS.items() if isinstance(path := getattr(options, key, None), str)}


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


def check_figure(path: str | None, option: str = "--figure") -> None:
    """Raise where a figure could not be written to `path`, if any: known before the work is done.

    Raises
    ------
    FileError
        An ending that is no figure's, a folder that is not there.
    """
    if path is None:
        return
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


def plain(value: Any) -> Any:
    """What JSON can say; what is not a number is null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):  # a NumPy array or number
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
