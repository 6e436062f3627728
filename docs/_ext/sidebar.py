"""The sidebar lists pages, not the hundreds of names that have a page each: the reference lists those.

Each page carries the sidebar. With the names in it a page was three times as long, and nearly all of the time in which
the pages are written went into it. Pages that it does not list share the one of their folder: to work it out for each
took a fifth of the time that was left.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from posixpath import dirname
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.ext.autosummary import autosummary_toc


def drop_names(app: Sphinx, tree: nodes.document) -> None:
    """Take out what `autosummary` adds to the tree of pages; its table of links stays."""
    for toc in list(tree.findall(autosummary_toc)):
        toc.parent.remove(toc)


def share(app: Sphinx, page: str, template: str, context: dict[str, Any], tree: nodes.document | None) -> None:
    """Give a page that is not listed what another in its folder was given: no entry is its own, and links are alike."""
    if page not in _listed(app):
        context["toctree"] = _first_of(dirname(page), context["toctree"])


@cache
def _listed(app: Sphinx) -> set[str]:
    return set(app.env.collect_relations())


_made: dict[tuple[str, ...], str] = {}


def _first_of(folder: str, make: Callable[..., str]) -> Callable[..., str]:
    def toctree(**options: Any) -> str:
        key = (folder, *map(str, sorted(options.items())))
        if key not in _made:
            _made[key] = make(**options)
        return _made[key]

    return toctree


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("doctree-read", drop_names, priority=100)  # before Sphinx collects the tree of pages
    app.connect("html-page-context", share, priority=100)  # before the theme asks for it
    return {"parallel_read_safe": True, "parallel_write_safe": True}
