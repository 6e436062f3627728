"""A report as a page and as a PDF: every block arrives, nothing is fetched, nothing runs off the page."""

from html.parser import HTMLParser

import pytest

from subskin.plot.style import house_style, new_figure
from subskin.report import Bullets, Document, Heading, Listing, Paragraph, Picture, Table, as_html, as_pdf


def figure():
    with house_style():
        drawn = new_figure(80.0, 40.0)
        drawn.subplots().plot([0, 1], [0, 1])
    return drawn


BLOCKS = (
    Heading("One & <two>"),
    Paragraph("A lead <script>alert(1)</script>", lead=True),
    Heading("Part", 2),
    Bullets(["first µm", "second 5°"]),
    Table(["name", "value"], [["a", "1 %"], ["b < c", "2"]], "A caption", strong=frozenset({1})),
    Picture(figure(), 'Says "this"'),
    Listing('key = "value"  # <so>'),
)
DOCUMENT = Document("A title", "seed 3", BLOCKS)


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.words = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes += attributes

    def handle_data(self, data):
        self.words.append(data.strip())


def test_the_page_holds_every_block_and_fetches_nothing():
    page = Page(as_html(DOCUMENT))
    for words in ("A title", "seed 3", "One & <two>", "A lead <script>alert(1)</script>", "Part", "first µm"):
        assert words in page.words
    for words in ("A caption", "b < c", 'Says "this"', 'key = "value"  # <so>'):
        assert words in page.words
    assert "script" not in page.tags
    assert "link" not in page.tags
    links = [value for name, value in page.attributes if name in ("src", "href")]
    assert all(value.startswith(("data:image/svg+xml;base64,", "#")) for value in links)
    anchors = {value[1:] for value in links if value.startswith("#")}
    assert anchors <= {value for name, value in page.attributes if name == "id"}
    assert page.tags.count("tr") == 3
    assert ("class", "strong") in page.attributes
    assert ("class", "lead") in page.attributes


def test_the_same_report_gives_the_same_bytes():
    assert as_html(DOCUMENT) == as_html(DOCUMENT)
    assert as_pdf(DOCUMENT) == as_pdf(DOCUMENT)


def pages(data):
    return data.count(b"/Type /Page") - data.count(b"/Type /Pages")


def test_a_long_report_takes_several_pages():
    assert pages(as_pdf(DOCUMENT)) == 1
    long = Document("A title", "", [Table(["n"], [[str(i)] for i in range(200)]), *BLOCKS])
    assert 4 <= pages(as_pdf(long)) <= 8


def test_a_wide_table_is_made_to_fit(monkeypatch):
    from reportlab import platypus

    widths = []
    made = platypus.Table
    monkeypatch.setattr(
        platypus, "Table", lambda rows, colWidths, **k: widths.append(colWidths) or made(rows, colWidths, **k)
    )
    wide = Table([f"column {i}" for i in range(14)], [["a rather long cell"] * 14])
    narrow = Table(["a", "b"], [["1", "2"]])
    as_pdf(Document("A title", "", [wide, narrow]))
    page = (210 - 2 * 18) / 25.4 * 72
    assert sum(widths[0]) == pytest.approx(page, abs=0.1)
    assert sum(widths[1]) < 0.2 * page
