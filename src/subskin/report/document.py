"""What a report is made of: headings, paragraphs, lists, tables, pictures and files, whatever it is written as."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..plot.style import Figure

__all__ = ["Block", "Bullets", "Document", "Heading", "Listing", "Paragraph", "Picture", "Table"]


@dataclass(frozen=True)
class Heading:
    """A heading; `level` 1 begins a section, 2 a part of one."""

    text: str
    level: int = 1


@dataclass(frozen=True)
class Paragraph:
    """A paragraph; `lead` sets it larger, as the first thing to read."""

    text: str
    lead: bool = False


@dataclass(frozen=True)
class Bullets:
    """A list."""

    items: Sequence[str]


@dataclass(frozen=True)
class Table:
    """A table; the first `left` columns are text and the rest numbers, rows in `strong` stand out."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    left: int = 1
    strong: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Picture:
    """A figure with what it shows."""

    figure: Figure
    caption: str


@dataclass(frozen=True)
class Listing:
    """A file, as it stands."""

    text: str


Block = Heading | Paragraph | Bullets | Table | Picture | Listing


@dataclass(frozen=True)
class Document:
    """A report: its title, what stands beneath the title, and its blocks."""

    title: str
    subtitle: str
    blocks: Sequence[Block]
