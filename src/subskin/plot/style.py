"""How every figure looks and how it is written: sizes, colours, type, and files that come out the same."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from os import PathLike
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from ..errors import InvalidValueError

__all__ = [
    "BLACK",
    "BLUE",
    "GREEN",
    "GREY",
    "ORANGE",
    "PINK",
    "SKY",
    "VERMILLION",
    "house_style",
    "new_figure",
    "save",
]

SINGLE, DOUBLE = 84.0, 174.0
"""Widths of a column and of a page [mm]."""

# Okabe and Ito's palette: told apart with any common colour vision.
BLACK, GREY = "#000000", "#6E6E6E"
BLUE, VERMILLION, GREEN, ORANGE = "#0072B2", "#D55E00", "#009E73", "#E69F00"
SKY, PINK = "#56B4E9", "#CC79A7"

NORMAL_95 = 1.959964
"""Half a 95 % interval in standard deviations."""

_MM = 1 / 25.4
_FORMATS = ("pdf", "png", "svg")
_STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # comes with matplotlib: the same letters on every machine
    "font.size": 8.0,
    "mathtext.fontset": "dejavusans",
    "axes.titlesize": 8.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8.0,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "legend.borderaxespad": 0.2,
    "lines.linewidth": 1.2,
    "lines.markersize": 4.0,
    "patch.linewidth": 0.6,
    "savefig.dpi": 300,
    "svg.hashsalt": "subskin",
    "svg.fonttype": "path",
}
# Settings that decide how a figure looks; those that choose a backend and its tools are left alone.
_FAMILIES = (
    "axes.", "contour.", "errorbar.", "figure.", "font.", "grid.", "hatch.", "image.", "legend.", "lines.",
    "markers.", "mathtext.", "patch.", "path.", "pdf.", "savefig.", "scatter.", "svg.", "text.",
    "xaxis.", "xtick.", "yaxis.", "ytick.",
)  # fmt: skip


def house_style() -> AbstractContextManager[None]:
    """The settings of this package's figures, for the length of a `with`; the user's own return after it."""
    settings: dict[Any, Any] = {k: v for k, v in mpl.rcParamsDefault.items() if k.startswith(_FAMILIES)}
    return mpl.rc_context(settings | _STYLE)


def new_figure(width: float, height: float, layout: Literal["constrained", "none"] = "constrained") -> Figure:
    """An empty figure of the given size [mm], drawn by Agg and known to no window."""
    figure = Figure(figsize=(width * _MM, height * _MM))
    if layout == "constrained":
        figure.set_layout_engine(
            ConstrainedLayoutEngine(w_pad=2 / 72, h_pad=2 / 72, wspace=0.03, hspace=0.03)
        )
    FigureCanvasAgg(figure)
    return figure


def zero_line(axes: Axes) -> None:
    """The line of no strain, so that compression and extension are told apart at sight."""
    axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=0.5)


def save(figure: Figure, path: str | PathLike[str], formats: Iterable[str] = ("svg", "png")) -> list[Path]:
    """Write a figure as `path` with each format's suffix, making the folder where it is missing.

    Each file is written beside its place and then renamed, so that none is ever left half written. The same
    figure gives the same bytes.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    path : path-like
        Where to, without a suffix, e.g. "out/truth".
    formats : iterable of {"svg", "png", "pdf"}, optional
        What to write; PNG has 300 dots an inch.

    Returns
    -------
    list of pathlib.Path
        The files, in the order of `formats`.

    Raises
    ------
    InvalidValueError
        A format that is not offered; nothing is written then.
    """
    target = Path(path)
    kinds = _formats(formats)
    target.parent.mkdir(parents=True, exist_ok=True)
    files = []
    for kind in kinds:
        file = target.with_name(f"{target.name}.{kind}")
        part = file.with_name(f".{file.name}.part")
        try:
            with house_style():
                figure.savefig(part, format=kind, metadata=_UNDATED[kind])
            part.replace(file)
        finally:
            part.unlink(missing_ok=True)
        files.append(file)
    return files


# What would make two files of one figure differ.
_UNDATED: dict[str, dict[str, Any]] = {
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
}


def _formats(formats: Iterable[str]) -> Sequence[str]:
    """The formats, checked before anything is drawn."""
    kinds = (formats,) if isinstance(formats, str) else tuple(formats)
    for kind in kinds:
        if kind not in _FORMATS:
            raise InvalidValueError(
                f"format {kind!r}", f"has to be one of {', '.join(_FORMATS)}", 'formats=("svg", "png")'
            )
    return kinds
