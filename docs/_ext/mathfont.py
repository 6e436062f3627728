"""A mathematics font beside the pages, cut down to the characters in use: brackets grow on every machine."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

from fontTools import subset
from sphinx.application import Sphinx

FONT = files("ziamath").joinpath("fonts/STIXTwoMath-Regular.ttf")  # STIX Two Math, SIL Open Font License
FORMULA = re.compile(r"<math\b.*?</math>", re.DOTALL)
ITALICS = (*range(0x1D434, 0x1D468), 0x210E, *range(0x1D6E2, 0x1D71C))
"""What a browser sets for a letter that stands alone."""
ROOT = 0x221A
"""Drawn by `msqrt`, in no text."""


def write(app: Sphinx, exception: Exception | None) -> None:
    if exception is not None or app.builder.format != "html":
        return
    out = Path(app.outdir)
    used = {c for page in out.rglob("*.html") for text in FORMULA.findall(page.read_text("utf-8")) for c in text}
    options = subset.Options(flavor="woff", layout_features=["*"], notdef_outline=True)
    font = subset.load_font(str(FONT), options)
    cut = subset.Subsetter(options)
    cut.populate(unicodes=[*map(ord, used), *range(0x20, 0x7F), *ITALICS, ROOT])
    cut.subset(font)
    subset.save_font(font, str(out / "_static" / "mathematics.woff"), options)


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
