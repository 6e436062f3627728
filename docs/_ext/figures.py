"""Figures of the gallery: those that an example holds in a variable, for subskin draws without pyplot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

PAGE = 174 / 25.4
"""Width of a page's figure [inch]; narrower ones are shown narrower."""


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save each new figure among the example's variables, and show it below the block that made it."""
    shown = []
    for value in block_vars["example_globals"].values():
        if isinstance(value, Figure) and not hasattr(value, "_in_gallery"):
            value._in_gallery = True
            path = Path(next(block_vars["image_path_iterator"]))
            value.savefig(path, dpi=200)
            position = path.relative_to(gallery_conf["src_dir"]).as_posix()
            width = min(100, round(100 * value.get_figwidth() / PAGE))
            shown.append(f".. image:: /{position}\n   :alt: figure\n   :width: {width}%\n   :align: center\n")
    return "\n".join(shown)
