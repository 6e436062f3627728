"""A report as a PDF for A4, set by ReportLab in the letters of the figures."""

from __future__ import annotations

import io
from functools import cache
from typing import Any
from xml.sax.saxutils import escape

from ..design.words import held
from ..plot.style import LETTERS, Figure, encoded
from .document import Block, Bullets, Document, Heading, Listing, Paragraph, Picture, Table

__all__ = ["as_pdf"]

_MARGIN = 18.0
"""Margins [mm]."""
_SHORT = 24
"""Tables of up to this many rows are not broken over pages."""


def as_pdf(document: Document) -> bytes:
    """The report as a PDF; the same report gives the same bytes.

    Parameters
    ----------
    document : Document
        The report.

    Examples
    --------
    >>> as_pdf(Document("A finger", "seed 3", [Paragraph("It is soft.")]))[:5]
    b'%PDF-'
    """
    from reportlab import platypus
    from reportlab.lib.pagesizes import A4
    from reportlab.lib.units import mm

    look = _look()
    file = io.BytesIO()
    pages = platypus.SimpleDocTemplate(
        file, pagesize=A4, title=document.title, subject=document.subtitle, author="", invariant=1,
        leftMargin=_MARGIN * mm, rightMargin=_MARGIN * mm, topMargin=_MARGIN * mm, bottomMargin=_MARGIN * mm,
    )  # fmt: skip
    story = [_text(document.title, look["title"]), _text(document.subtitle, look["grey"]), platypus.Spacer(1, 4 * mm)]
    for block in document.blocks:
        story += _flowables(block, look, pages.width)

    def foot(canvas: Any, _: Any) -> None:
        canvas.setFont("DejaVuSans", 7)
        canvas.setFillGray(0.43)
        canvas.drawString(_MARGIN * mm, 10 * mm, document.title)
        canvas.drawRightString(A4[0] - _MARGIN * mm, 10 * mm, f"{canvas.getPageNumber()}")

    pages.build(story, onFirstPage=foot, onLaterPages=foot)
    return file.getvalue()


def _text(words: str, style: Any, **options: Any) -> Any:
    """Words set in a style, numbers held to their units."""
    from reportlab import platypus

    return platypus.Paragraph(escape(held(words)), style, **options)


@cache
def _look() -> dict[str, Any]:
    """Styles of the paragraphs; registers the letters that matplotlib brings, so Greek and µ are there."""
    from reportlab.lib.styles import ParagraphStyle
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont

    for name in ("DejaVuSans", "DejaVuSans-Bold", "DejaVuSansMono"):
        pdfmetrics.registerFont(TTFont(name, str(LETTERS / f"{name}.ttf")))
    text = ParagraphStyle("text", fontName="DejaVuSans", fontSize=8.5, leading=12.5, spaceAfter=5)
    bold: dict[str, Any] = {"fontName": "DejaVuSans-Bold", "keepWithNext": 1}
    small: dict[str, Any] = {"fontSize": 7, "leading": 9, "spaceAfter": 0}

    def style(name: str, **changes: Any) -> ParagraphStyle:
        return ParagraphStyle(name, parent=text, **changes)

    return {
        "text": text,
        "lead": style("lead", fontSize=10, leading=14.5),
        "title": style("title", fontSize=17, leading=22, spaceAfter=2, **bold),
        "1": style("1", fontSize=12.5, leading=16, spaceBefore=12, spaceAfter=5, **bold),
        "2": style("2", fontSize=9.5, leading=13, spaceBefore=8, spaceAfter=3, **bold),
        "grey": style("grey", textColor="#6E6E6E", fontSize=7.5, leading=10.5),
        "bullet": style("bullet", leftIndent=9, bulletIndent=0, spaceAfter=2.5),
        "code": style("code", fontName="DejaVuSansMono", fontSize=6.5, leading=9),
        "cell": style("cell", **small),
        "number": style("number", **small, alignment=2),
        "head": style("head", **small, fontName="DejaVuSans-Bold"),
        "numberhead": style("numberhead", **small, fontName="DejaVuSans-Bold", alignment=2),
    }


def _flowables(block: Block, look: dict[str, Any], width: float) -> list[Any]:
    from reportlab import platypus

    match block:
        case Heading(text, level):
            return [_text(text, look[str(level)])]
        case Paragraph(text, lead):
            return [_text(text, look["lead" if lead else "text"])]
        case Bullets(items):
            return [_text(item, look["bullet"], bulletText="•") for item in items]
        case Table():
            caption = [_text(block.caption, look["grey"])] if block.caption else []
            whole = [*caption, _table(block, look, width), platypus.Spacer(1, 8)]
            return [platypus.KeepTogether(whole)] if len(block.rows) <= _SHORT else whole
        case Listing(text):
            return [platypus.Preformatted(text, look["code"], maxLineLength=110)]
        case Picture(figure, caption):
            shown = [_image(figure, width), platypus.Spacer(1, 3), _text(caption, look["grey"])]
            return [platypus.KeepTogether(shown), platypus.Spacer(1, 6)]


def _table(block: Table, look: dict[str, Any], width: float) -> Any:
    """The table, its columns as wide as what is in them, within the page."""
    from reportlab import platypus
    from reportlab.pdfbase.pdfmetrics import stringWidth

    styles = ["cell"] * block.left + ["number"] * (len(block.columns) - block.left)
    heads = [style.replace("cell", "") + "head" for style in styles]
    rows = [[_text(cell, look[style]) for cell, style in zip(block.columns, heads, strict=True)]]
    rows += [[_text(cell, look[style]) for cell, style in zip(row, styles, strict=True)] for row in block.rows]
    wide = []
    for head, *cells in zip(block.columns, *block.rows, strict=True):
        words = (*cells, *head.split(), "")  # cells stay on one line where there is room, heads may break
        wide.append(9 + max(stringWidth(word, "DejaVuSans-Bold", 7) for word in words))
    scale = min(1.0, width / sum(wide))
    rules: Any = [
        ("LINEBELOW", (0, 0), (-1, 0), 0.9, "black"),
        ("LINEBELOW", (0, 1), (-1, -1), 0.3, "#D9D9D9"),
        ("LEFTPADDING", (0, 0), (-1, -1), 3),
        ("RIGHTPADDING", (0, 0), (-1, -1), 3),
        ("TOPPADDING", (0, 0), (-1, -1), 2),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 2),
        ("VALIGN", (0, 0), (-1, 0), "BOTTOM"),
        *(("BACKGROUND", (0, i + 1), (-1, i + 1), "#EAF3F9") for i in sorted(block.strong)),
    ]
    return platypus.Table(rows, colWidths=[w * scale for w in wide], repeatRows=1, hAlign="LEFT", style=rules)


def _image(figure: Figure, width: float) -> Any:
    from reportlab import platypus

    wide, high = (72 * size for size in figure.get_size_inches())
    scale = min(1.0, width / wide)
    return platypus.Image(io.BytesIO(encoded(figure, "png")), wide * scale, high * scale, hAlign="LEFT")
