"""A report as one HTML file: styles and pictures are in it, and nothing is fetched when it is read."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from functools import singledispatch
from html import escape as escaped
from importlib.resources import files

from ..design.words import held
from ..plot.style import encoded
from .document import Block, Bullets, Document, Heading, Listing, Paragraph, Picture, TextTable

__all__ = ["as_html"]


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
    links = "".join(f'<a href="#{_anchor(h.text)}">{escape(h.text)}</a>' for h in sections)
    body = "\n".join(_html(block) for block in document.blocks)
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


def escape(text: str) -> str:
    """The text as it stands in a page, numbers held to their units."""
    return escaped(held(text))


def _anchor(text: str) -> str:
    return "".join(c if c.isalnum() else "-" for c in text.lower())


def _class(name: str, given: bool) -> str:
    return f' class="{name}"' if given else ""


@singledispatch
def _html(block: Block) -> str:
    raise TypeError(f"{type(block).__name__}: no block of a report")


@_html.register
def _(block: Heading) -> str:
    return f'<h{block.level + 1} id="{_anchor(block.text)}">{escape(block.text)}</h{block.level + 1}>'


@_html.register
def _(block: Paragraph) -> str:
    return f"<p{_class('lead', block.lead)}>{escape(block.text)}</p>"


@_html.register
def _(block: Bullets) -> str:
    return "<ul>" + "".join(f"<li>{escape(item)}</li>" for item in block.items) + "</ul>"


@_html.register
def _(block: TextTable) -> str:
    def cells(row: Sequence[str], tag: str) -> str:
        return "".join(f"<{tag}{_class('text', i < block.left)}>{escape(cell)}</{tag}>" for i, cell in enumerate(row))

    rows = "".join(
        f"<tr{_class('strong', i in block.strong)}>{cells(row, 'td')}</tr>" for i, row in enumerate(block.rows)
    )
    caption = f'<p class="caption">{escape(block.caption)}</p>' if block.caption else ""
    return (
        f'{caption}<div class="table"><table><thead><tr>{cells(block.columns, "th")}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


@_html.register
def _(block: Picture) -> str:
    data = base64.b64encode(encoded(block.figure, "svg")).decode("ascii")
    caption = escape(block.caption)
    width = block.figure.get_figwidth() * 25.4
    return (
        f'<figure><div class="scroll"><img alt="{caption}" style="width:{width:.0f}mm" '
        f'src="data:image/svg+xml;base64,{data}"></div>'
        f"<figcaption>{caption}</figcaption></figure>"
    )


@_html.register
def _(block: Listing) -> str:
    return f"<pre>{escaped(block.text)}</pre>"
