"""What a person sees of a result: numbers with their errors and units, tables, and how to be drawn."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Drawing", "Presets", "Tabled", "html_table", "lines", "many_of", "parameter_rows", "span", "with_error"]


class Presets(dict[str, dict[str, Any]]):
    """Rows by their names, each a value by the name of its column; shown as a table in the units of people."""

    def __init__(self, rows: Mapping[str, dict[str, Any]], units: Mapping[str, tuple[float, str]]) -> None:
        super().__init__(rows)
        self._units = dict(units)

    def _table(self) -> tuple[list[str], list[list[str]]]:
        columns = list(next(iter(self.values())))
        heads = ["name", *(f"{c} [{self._units[c][1]}]" if c in self._units else c for c in columns)]
        return heads, [[name, *(self._cell(c, row[c]) for c in columns)] for name, row in self.items()]

    def _cell(self, column: str, value: Any) -> str:
        if not isinstance(value, float):
            return str(value)
        shown = f"{value * self._units.get(column, (1.0, ''))[0]:.3g}"
        return f"{float(shown):.0f}" if "e+" in shown else shown

    def __repr__(self) -> str:
        heads, rows = self._table()
        return lines("", [heads, *rows]).lstrip("\n")

    def _repr_html_(self) -> str:
        heads, rows = self._table()
        return html_table("", rows, heads)


class Drawing:
    """A figure of `subskin.plot` whose first argument is the thing itself, as a method: found when it is asked for.

    So `finger.plot(...)` is `subskin.plot.finger_figure(finger, ...)`, and a finger knows no figure.
    """

    def __init__(self, figure: str) -> None:
        self._figure = figure

    def __get__(self, thing: object, owner: type) -> Any:
        function = getattr(import_module(f"{__package__}.plot"), self._figure)
        return function if thing is None else function.__get__(thing, owner)


class Tabled(ABC):
    """A thing that people see as a title and a table; as a dataclass it is made with `repr=False`."""

    _HEADS: tuple[str, ...] = ()  # of the columns, in a notebook

    def _title(self) -> str:
        return type(self).__name__

    @abstractmethod
    def _shown(self) -> Sequence[Sequence[str]]:
        """Rows of the table."""

    def __repr__(self) -> str:
        return lines(self._title(), self._shown())

    def _repr_html_(self) -> str:
        return html_table(self._title(), self._shown(), self._HEADS)


def with_error(value: float, std: float, unit: str) -> str:
    """A number to the digits that its standard deviation leaves it: 0.79 +- 0.03 mm.

    Two digits of the standard deviation where it begins with 1 or 2, one otherwise; without one, four of the value.
    """
    if not math.isfinite(value):
        return "-"
    if not (math.isfinite(std) and std > 0):
        return f"{value + 0.0:.4g} {unit}".strip()
    power = math.floor(math.log10(std))
    digits = power - (std / 10**power < 3)
    shown = [f"{round(v, -digits) + 0.0:.{max(-digits, 0)}f}" for v in (value, std)]
    return f"{' +- '.join(shown)} {unit}".strip()


def parameter_rows(parameters: Iterable[Any]) -> list[tuple[str, str, str]]:
    """Name, sensor and value with its error of each number that a calibration fitted; metres as millimetres."""
    rows = []
    for p in parameters:
        scale, unit = (1e3, "mm") if p.unit == "m" else (1.0, p.unit)
        value = with_error(scale * p.value, scale * p.std, unit)
        rows.append((p.name, "" if p.sensor is None else str(p.sensor), value))
    return rows


def span(values: npt.ArrayLike, unit: str = "", digits: int = 3) -> str:
    """The least and the largest of some numbers, NaN left out: -5.2 to 6.1 mm; one where they are alike."""
    known = np.asarray(values, dtype=np.float64)
    known = known[~np.isnan(known)]
    if not known.size:
        return "-"
    ends = dict.fromkeys(f"{v + 0.0:.{digits}g}" for v in (known.min(), known.max()))
    return f"{' to '.join(ends)} {unit}".strip()


def many_of(counts: Iterable[tuple[str, int]]) -> str:
    """Names with how often each is there, those that are not left out: 2 OK, 1 AMBIGUOUS."""
    return ", ".join(f"{count} {name}" for name, count in counts if count)


def lines(title: str, rows: Sequence[Sequence[str]]) -> str:
    """A title and rows below it, their columns in line."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    body = ("  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows)
    return "\n".join([title, *(f"  {line}" for line in body)])


def html_table(title: str, rows: Sequence[Sequence[str]], heads: Sequence[str] = ()) -> str:
    """The same as a table for a notebook."""
    top = f"<tr>{''.join(f'<th>{escape(head)}</th>' for head in heads)}</tr>" if heads else ""
    cells = ("".join(f"<td>{escape(cell).replace('+-', '&plusmn;')}</td>" for cell in row) for row in rows)
    body = "".join(f"<tr>{row}</tr>" for row in cells)
    return f"<table><caption>{escape(title)}</caption>{top}{body}</table>"
