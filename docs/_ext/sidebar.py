"""The sidebar lists pages, not the hundreds of names that have a page each: the reference lists those.

Each page carries the sidebar. With the names in it a page was three times as long, and nearly all of the time in which
the pages are written went into it.
"""

from __future__ import annotations

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.ext.autosummary import autosummary_toc


def drop_names(app: Sphinx, tree: nodes.document) -> None:
    """Take out what `autosummary` adds to the tree of pages; its table of links stays."""
    for toc in list(tree.findall(autosummary_toc)):
        toc.parent.remove(toc)


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("doctree-read", drop_names, priority=100)  # before Sphinx collects the tree of pages
    return {"parallel_read_safe": True, "parallel_write_safe": True}
