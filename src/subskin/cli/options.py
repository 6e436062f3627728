"""What commands take: options, said as a person writes them; rows, values with units, and files as they are given."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from .._lazy import np
from ..errors import InvalidValueError
from ..io.units import line_load, quantity

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = [
    "DRAWN", "JSON", "MEANING", "Command", "Rows", "chosen_rows", "command", "figure", "frames", "group", "inputs_of",
    "listed", "option", "outputs_of", "positive", "quantity_range", "rows", "shared",
]  # fmt: skip


class Option(NamedTuple):
    """One argument of a parser, and the title and text of its group; of a group without a title one may be given."""

    names: tuple[str, ...]
    settings: dict[str, Any]
    group: tuple[str, str] | None = None


Options: TypeAlias = tuple[Option, ...]


class Command(NamedTuple):
    """A command: what runs, and what its parser is told."""

    run: Callable[[argparse.Namespace], int]
    examples: str
    notes: str
    options: Options

    def fill(self, parser: argparse.ArgumentParser) -> None:
        """Tell the parser what the command takes."""
        parser.description = f"{parser.description}\n\n{self.notes}" if self.notes else parser.description
        parser.epilog = f"examples:\n{self.examples}"
        parser.set_defaults(run=self.run, json=False)
        groups: dict[Any, Any] = {None: parser}
        for names, settings, of in self.options:
            if of not in groups:
                title, text = of or ("", "")
                made = (
                    parser.add_argument_group(title, text or None) if title else parser.add_mutually_exclusive_group()
                )
                groups[of] = made
            now = dict(settings)
            for asked in ("help", "choices"):
                if callable(now.get(asked)):
                    now[asked] = now[asked]()
            groups[of].add_argument(*names, **now)


def command(
    examples: str, *options: Options, notes: str = ""
) -> Callable[[Callable[[argparse.Namespace], int]], Command]:
    """What makes a command of the function that runs it."""
    return lambda run: Command(run, examples, notes, sum(options, ()))


def option(spec: str, text: str | Callable[[], str], usual: Any = None, **more: Any) -> Options:
    """An option as a person writes it: "--count N", "-o --out FILE", "--grid", "recording FILE", "finger?".

    "--load {line,point}" takes one of these; what ends in a question mark may be left out. Where the `usual` value is a
    number, it takes such numbers. A text, and choices, may be functions that are asked when the command is.
    """
    words = spec.split()
    names = tuple(word for word in words if word.startswith("-")) or (words[0].removesuffix("?"),)
    given: dict[str, Any] = {"help": text} | ({"metavar": words[-1]} if len(words) > len(names) else {})
    if words[-1].startswith("{"):
        given = {"help": text, "choices": words[-1][1:-1].split(",")}
    elif names[0].startswith("-") and "metavar" not in given and "choices" not in more:
        given["action"] = "store_true"
    elif words[0].endswith("?"):
        given["nargs"] = "?"
    if usual is not None:
        given |= {"default": usual} | ({} if isinstance(usual, str) else {"type": type(usual)})
    return (Option(names, given | more),)


def group(title: str, text: str, *options: Options) -> Options:
    """Options under a title of their own; without a title at most one of them is given."""
    return tuple(one._replace(group=(title, text)) for one in sum(options, ()))


JSON = option("--json", "print the result as JSON")


def shared(what: str) -> Options:
    """-o and --json."""
    return (*option("-o --out FILE", f"{what}; CSV, or Parquet for .parquet; - for standard output"), *JSON)


def figure(what: str) -> Options:
    """--figure."""
    return option("--figure FILE", f"{what} (.svg, .png or .pdf)")


def rows(verb: str) -> Options:
    """--every or --rows."""
    every = option("--every N", f"{verb} rows 0, N, 2N, ...", type=int)
    return group("", "", every, option("--rows LIST", f"{verb} these rows, counted from 0: 10,30,50 or 0-9,20"))


def frames(verb: str, what: str, drawn: str) -> Options:
    """What the commands take that answer frame by frame: the finger, the readings, --tare, and all of the above."""
    tare = (
        "the rows are a raw stream, with a column of times: convert the units of [recording], undo [relaxation], and "
        "subtract drift; DRIFT is the fastest believed, reading/s ([tare], or 0.3 noise a second)"
    )
    return (
        *option("finger", "finger.toml, best as calibrated"),
        *option("readings", "table of readings, CSV or Parquet; - for standard input"),
        *option("--tare DRIFT", tare, nargs="?", const=""),
        *figure(drawn),
        *rows(f"{verb} only"),
        *shared(what),
    )


MEANING = {
    "ok": "one load explains the readings",
    "ambiguous": "another load explains them nearly as well, or the position is at the edge of the search",
    "no_contact": "nothing beyond noise",
    "unexplained": "no pressing load within the friction cone explains the readings",
    "incomplete": "too few sensors could be used",
}
"""What each status says, in words."""


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


_INPUTS = {"finger": "the finger", "goals": "the goals", "readings": "the readings", "recording": "the recording",
           "touches": "the touches"}  # fmt: skip
DRAWN = {"figure": "--figure", "map": "--map", "tip_map": "--tip-map"}
"""Options that name a figure, known to be one before the work is done."""
_OUTPUTS = DRAWN | {"out": "-o", "relaxed": "--relaxation", "totals": "--totals", "movie": "--movie",
                    "record": "--record"}  # fmt: skip


def inputs_of(options: argparse.Namespace) -> dict[str, str]:
    """The files that a command reads, by what they are called."""
    return {said: path for key, said in _INPUTS.items() if isinstance(path := getattr(options, key, None), str)}


def outputs_of(options: argparse.Namespace) -> dict[str, str]:
    """The files that a command writes, by their options."""
    return {said: path for key, said in _OUTPUTS.items() if isinstance(path := getattr(options, key, None), str)}
