"""Stops the build where a page would load a script, style, font, image or frame from elsewhere."""

from __future__ import annotations

import re
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

REMOTE = r"""(?:https?:)?//[^"'\s)>]+"""
LOADS = [
    re.compile(rf"""<(?:script|img|iframe|source|video|audio|embed|object)\b[^>]*?(?:src|data)\s*=\s*["']?({REMOTE})"""),
    re.compile(rf"""<link\b(?=[^>]*rel\s*=\s*["']?(?:stylesheet|preload|preconnect|icon|prefetch|modulepreload))"""
               rf"""[^>]*?href\s*=\s*["']?({REMOTE})"""),
    re.compile(rf"""url\(\s*["']?({REMOTE})"""),
    re.compile(rf"""@import\s+["']({REMOTE})"""),
]  # fmt: skip


def remote_loads(text: str) -> list[str]:
    """Addresses that a browser would fetch on reading this page or style sheet."""
    return [match for pattern in LOADS for match in pattern.findall(text)]


def check(app: Sphinx, exception: Exception | None) -> None:
    if exception is not None or app.builder.format != "html":
        return
    out = Path(app.outdir)
    found = [
        f"{file.relative_to(out)}: {address}"
        for file in sorted([*out.rglob("*.html"), *out.rglob("*.css")])
        for address in remote_loads(file.read_text(encoding="utf-8"))
    ]
    if found:
        raise ExtensionError("the pages load from elsewhere:\n  " + "\n  ".join(found))


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("build-finished", check)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
