"""Reports of a design: one content, written as a page for a browser and as a document for print."""

from .design_report import design_report
from .document import Bullets, Document, Heading, Listing, Paragraph, Picture, Table
from .html import as_html
from .pdf import as_pdf

__all__ = [
    "Bullets",
    "Document",
    "Heading",
    "Listing",
    "Paragraph",
    "Picture",
    "Table",
    "as_html",
    "as_pdf",
    "design_report",
]
