"""What a report is made of, and how it is written as a page: styles and pictures are in it, and it fetches nothing."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape as escaped
from importlib.resources import files

from ..design.words import held
from ..plot.style import Figure, encoded

__all__ = ["Block", "Bullets", "Document", "Heading", "Listing", "Paragraph", "Picture", "TextTable", "as_html"]


def escape(text: str) -> str:
    """The text as it stands in a page, numbers held to their units."""
    return escaped(held(text))


def _class(name: str, given: bool) -> str:
    return f' class="{name}"' if given else ""


@dataclass(frozen=True)
class Heading:
    """A heading, its `text`; `level` 1 begins a section, 2 a part of one."""

    text: str
    level: int = 1

    @property
    def anchor(self) -> str:
        """Its name in the page."""
        return "".join(c if c.isalnum() else "-" for c in self.text.lower())

    @property
    def html(self) -> str:
        """As it stands in a page."""
        return f'<h{self.level + 1} id="{self.anchor}">{escape(self.text)}</h{self.level + 1}>'


@dataclass(frozen=True)
class Paragraph:
    """A paragraph, its `text`; `lead` sets it larger, as the first thing to read."""

    text: str
    lead: bool = False

    @property
    def html(self) -> str:
        """As it stands in a page."""
        return f"<p{_class('lead', self.lead)}>{escape(self.text)}</p>"


@dataclass(frozen=True)
class Bullets:
    """A list of `items`."""

    items: Sequence[str]

    @property
    def html(self) -> str:
        """As it stands in a page."""
        return "<ul>" + "".join(f"<li>{escape(item)}</li>" for item in self.items) + "</ul>"


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

    @property
    def html(self) -> str:
        """As it stands in a page."""
        rows = "".join(
            f"<tr{_class('strong', i in self.strong)}>{self._cells(row, 'td')}</tr>" for i, row in enumerate(self.rows)
        )
        caption = f'<p class="caption">{escape(self.caption)}</p>' if self.caption else ""
        return (
            f'{caption}<div class="table"><table><thead><tr>{self._cells(self.columns, "th")}</tr></thead>'
            f"<tbody>{rows}</tbody></table></div>"
        )

    def _cells(self, row: Sequence[str], tag: str) -> str:
        return "".join(f"<{tag}{_class('text', i < self.left)}>{escape(cell)}</{tag}>" for i, cell in enumerate(row))


@dataclass(frozen=True)
class Picture:
    """A `figure` and a `caption`, what it shows."""

    figure: Figure
    caption: str

    @property
    def html(self) -> str:
        """As it stands in a page."""
        data = base64.b64encode(encoded(self.figure, "svg")).decode("ascii")
        caption, width = escape(self.caption), self.figure.get_figwidth() * 25.4
        return (
            f'<figure><div class="scroll"><img alt="{caption}" style="width:{width:.0f}mm" '
            f'src="data:image/svg+xml;base64,{data}"></div>'
            f"<figcaption>{caption}</figcaption></figure>"
        )


@dataclass(frozen=True)
class Listing:
    """The `text` of a file, as it stands."""

    text: str

    @property
    def html(self) -> str:
        """As it stands in a page."""
        return f"<pre>{escaped(self.text)}</pre>"


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


def as_html(document: Document) -> str:
    """The report as a page.

    Parameters
    ----------
    document : Document
        The report.

    Examples
    --------
    >>> from subskin.report import Document, Paragraph
    >>> "<p>It is soft.</p>" in as_html(Document("A finger", "seed 3", [Paragraph("It is soft.")]))
    True
    """
    style = files(__package__).joinpath("report.css").read_text(encoding="utf-8")
    sections = [b for b in document.blocks if isinstance(b, Heading) and b.level == 1]
    links = "".join(f'<a href="#{h.anchor}">{escape(h.text)}</a>' for h in sections)
    body = "\n".join(block.html for block in document.blocks)
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(document.title)}</title>
<style>
{style}</style>
</head>
<body>
<header>
<h1>{escape(document.title)}</h1>
<p>{escape(document.subtitle)}</p>
<nav>{links}</nav>
</header>
<main>
{body}
</main>
</body>
</html>
"""
