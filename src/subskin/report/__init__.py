"""Reports of a design: one content, written as a page that a browser shows and prints."""

from .design_report import design_report
from .document import Bullets, Document, Heading, Listing, Paragraph, Picture, TextTable, as_html

__all__ = ["Bullets", "Document", "Heading", "Listing", "Paragraph", "Picture", "TextTable", "as_html", "design_report"]
