"""Docstrings as pages: `Name` between backticks links to what is public; what says nothing is dropped."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from docutils.parsers.rst import roles
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.ext import autosummary

PUBLIC = re.compile(r"(?:subskin\.)?(?:[A-Z]\w*[a-z]\w*|[a-z_]+\.[\w.]+)(?:\.\w+)*")


def name_role(
    role: str, rawtext: str, text: str, line: int, inliner: Any, options: Any = None, content: Any = ()
) -> tuple[list[nodes.Node], list[nodes.system_message]]:
    code = nodes.literal(rawtext, text, classes=["xref", "py"] if PUBLIC.fullmatch(text) else [])
    if not PUBLIC.fullmatch(text):
        return [code], []
    target = text.removeprefix("subskin.")
    link = addnodes.pending_xref(
        rawtext, code, refdomain="py", reftype="obj", reftarget=target, refspecific=True, refwarn=False
    )
    return [link], []


def drop_object_base(app: Sphinx, tree: nodes.document) -> None:
    """Take out the line "Bases: object"."""
    for paragraph in list(tree.findall(nodes.paragraph)):
        if paragraph.astext() == "Bases: object":
            paragraph.parent.remove(paragraph)


def drop_links_of_words(app: Sphinx, tree: nodes.document) -> None:
    """In "ndarray, shape (n,)" the word shape is no name, though several classes have one of that name."""
    for link in list(tree.findall(addnodes.pending_xref)):
        if link.get("reftarget") == "shape":
            link.replace_self(link.children)


def keep_bars(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Let |x| mean an absolute value, not a substitution; doctests stay as they are."""
    if what == "data" and lines[:1] == (type(obj).__doc__ or "").splitlines()[:1]:
        lines.clear()  # a constant says nothing of its own, and what its type says is not about it
    example = False
    for i, line in enumerate(lines):
        example = line.strip().startswith(">>>") or (example and bool(line.strip()))
        if not example:
            lines[i] = line.replace("|", r"\|")


def skip_fields(app: Sphinx, what: str, name: str, obj: object, skip: bool, options: object) -> bool | None:
    """Leave out a named tuple's "Alias for field number 0", and a field's default that is a built-in type."""
    alias = (getattr(obj, "__doc__", None) or "").startswith("Alias for field number")
    return True if alias or (isinstance(obj, type) and obj.__module__ == "builtins") else None


def setup(app: Sphinx) -> dict[str, bool]:
    roles.register_local_role("name", name_role)
    app.connect("autodoc-process-docstring", keep_bars)
    app.connect("autodoc-skip-member", skip_fields)
    app.connect("doctree-read", drop_object_base)
    app.connect("doctree-read", drop_links_of_words)
    # where the first sentence of a docstring does not end
    autosummary.WELL_KNOWN_ABBREVIATIONS = (*autosummary.WELL_KNOWN_ABBREVIATIONS, "eq.", "eqs.", "Fig.", "Figs.")
    return {"parallel_read_safe": True, "parallel_write_safe": True}
