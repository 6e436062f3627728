"""What a report is made of: headings, paragraphs, lists, tables, pictures and files, whatever it is written as."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..plot.style import Figure

__all__ = ["Block", "Bullets", "Document", "Heading", "Listing", "Paragraph", "Picture", "TextTable"]


@dataclass(frozen=True)
class Heading:
    """A heading, its `text`; `level` 1 begins a section, 2 a part of one."""

    text: str
    level: int = 1


@dataclass(frozen=True)
class Paragraph:
    """A paragraph, its `text`; `lead` sets it larger, as the first thing to read."""

    text: str
    lead: bool = False


@dataclass(frozen=True)
class Bullets:
    """A list of `items`."""

    items: Sequence[str]


@dataclass(frozen=True)
class TextTable:
    """A table of `columns` and `rows`, and its `caption`.

    The first `left` columns are text and the rest numbers; rows in `strong` stand out.
    """

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    left: int = 1
    strong: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Picture:
    """A `figure` and a `caption`, what it shows."""

    figure: Figure
    caption: str


@dataclass(frozen=True)
class Listing:
    """The `text` of a file, as it stands."""

    text: str


Block = Heading | Paragraph | Bullets | TextTable | Picture | Listing


@dataclass(frozen=True)
class Document:
    """A report: its `title`, the `subtitle` beneath it, and its `blocks`.

    Examples
    --------
    >>> from subskin.plot.style import new_figure
    >>> blocks = [Heading("Why"), Paragraph("It is soft."), Bullets(["one", "two"]), Listing("young = 0.4e6")]
    >>> blocks += [TextTable(["name", "value"], [["pitch", "2 mm"]]), Picture(new_figure(84.0, 60.0), "nothing yet")]
    >>> Document("A finger", "seed 3", blocks).title
    'A finger'
    """

    title: str
    subtitle: str
    blocks: Sequence[Block]
