"""Tables for people: as wide as they need to be, for no number is cut."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TextIO

from ..errors import each_printable

__all__ = ["show"]

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

    heading, *cells = each_printable([title, *columns, *(cell for row in rows for cell in row)])
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
