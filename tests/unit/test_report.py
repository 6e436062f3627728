"""A report as a page: every block arrives, and nothing is fetched."""

from html.parser import HTMLParser

from subskin.plot.style import house_style, new_figure
from subskin.report import Bullets, Document, Heading, Listing, Paragraph, Picture, TextTable, as_html


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
    TextTable(["name", "value"], [["a", "1 %"], ["b < c", "2"]], "A caption", strong=frozenset({1})),
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
