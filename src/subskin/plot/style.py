"""How every figure looks, what many have, and how it is written: sizes, colours, panels, legends, equal files."""

from __future__ import annotations

import io
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import AbstractContextManager
from functools import wraps
from os import PathLike, getpid
from pathlib import Path
from typing import Any, Literal, ParamSpec

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import AutoLocator, FixedLocator, LogLocator, NullFormatter, NullLocator

from .. import _check
from .._check import FloatArray
from ..errors import FileError, GeometryError, InvalidValueError
from ..finger import Finger
from ..io.files import path_of

__all__ = [
    "LETTERS",
    "Figure",
    "Ink",
    "encoded",
    "frame_of",
    "heading",
    "house_style",
    "legend",
    "new_figure",
    "plain",
    "save",
    "single",
    "stacked",
    "unit_of",
    "zero_line",
]

SINGLE, DOUBLE = 84.0, 174.0
"""Widths of a column and of a page [mm]."""


class Ink:
    """Okabe and Ito's palette: told apart with any common colour vision."""

    BLACK, GREY = "#000000", "#6E6E6E"
    BLUE, VERMILLION, GREEN, ORANGE = "#0072B2", "#D55E00", "#009E73", "#E69F00"
    SKY, PINK = "#56B4E9", "#CC79A7"


DASHED = (0, (4, 2))
MM = 1e3
"""Millimetres in a metre."""

NORMAL_95 = 1.959964
"""Half a 95 % interval in standard deviations."""

LETTERS = Path(mpl.get_data_path()) / "fonts" / "ttf"
"""Where the files of the letters are that the figures are written with."""

_MM = 1 / 25.4
_DPI = 300
_STILL = 0.1
"""Dots by which a panel may move when all is laid out once more."""
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
    "savefig.dpi": _DPI,
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


_P = ParamSpec("_P")


def finished(draw: Callable[_P, Figure]) -> Callable[_P, Figure]:
    """The function, which then draws in `house_style` and returns a figure that is `settled`."""

    @wraps(draw)
    def drawn(*given: _P.args, **named: _P.kwargs) -> Figure:
        with house_style():
            return settled(draw(*given, **named))

    return drawn


def new_figure(width: float, height: float, layout: Literal["constrained", "none"] = "constrained") -> Figure:
    """An empty figure of the given size [mm], drawn by Agg and known to no window."""
    figure = Figure(figsize=(width * _MM, height * _MM), dpi=_DPI)
    if layout == "constrained":
        figure.set_layout_engine(ConstrainedLayoutEngine(w_pad=2 / 72, h_pad=2 / 72, wspace=0.03, hspace=0.03))
    FigureCanvasAgg(figure)
    return figure


def settled(figure: Figure) -> Figure:
    """The figure with its layout and its ticks worked out once and kept.

    Else each further draw would move the panels by a hair, and other settings of the user's change the ticks.
    """
    engine = figure.get_layout_engine()
    if engine is not None:
        before: Any = np.inf
        for _ in range(3):  # the ticks depend on the panels' sizes, and these on the ticks' labels
            engine.execute(figure)
            now = np.array([axes.get_window_extent().bounds for axes in figure.axes])
            if np.abs(now - before).max(initial=0.0) < _STILL:
                break
            before = now
    figure.set_layout_engine("none")
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        if isinstance(axis.get_major_locator(), AutoLocator):
            axis.set_major_locator(FixedLocator(axis.get_majorticklocs().tolist()))
    return figure


# What would make two files of one figure differ.
_UNDATED: dict[str, dict[str, Any]] = {
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
}


def save(figure: Figure, path: str | PathLike[str], formats: Iterable[str] | None = None) -> list[Path]:
    """Write a figure, making the folder where it is missing.

    Each file is written beside its place and then renamed, so that none is ever left half written. The same
    figure gives the same bytes.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    path : path-like
        Where to, e.g. "out/truth.png", or "out/truth" for every one of `formats`.
    formats : iterable of {"svg", "png", "pdf"}, optional
        What to write, each with its own suffix; PNG has 300 dots an inch. The default is the suffix of
        `path`, or SVG and PNG where it has none of these.

    Returns
    -------
    list of pathlib.Path
        The files, in the order of `formats`.

    Raises
    ------
    InvalidValueError
        A format that is not offered; nothing is written then.
    FileError
        A folder or file that cannot be written.

    Examples
    --------
    >>> save(new_figure(84.0, 60.0), getfixture("tmp_path") / "empty.svg")[0].name
    'empty.svg'
    """
    target = path_of(path)
    suffix = target.suffix[1:].lower()
    if suffix in _UNDATED:
        target = target.with_suffix("")
    kinds = _formats(formats if formats is not None else (suffix,) if suffix in _UNDATED else ("svg", "png"))
    return [_write(figure, target.with_name(f"{target.name}.{kind}"), kind) for kind in kinds]


def _formats(formats: Iterable[str]) -> tuple[str, ...]:
    """The formats, checked before anything is drawn."""
    kinds = (formats,) if isinstance(formats, str) else tuple(formats)
    for kind in kinds:
        if kind not in _UNDATED:
            rule = f"has to be one of {', '.join(sorted(_UNDATED))}"
            raise InvalidValueError(f"format {kind!r}", rule, 'formats=("svg", "png")')
    return kinds


def encoded(figure: Figure, kind: str) -> bytes:
    """The file of a figure, "svg", "png" or "pdf": the same figure gives the same bytes."""
    file = io.BytesIO()
    with house_style():
        figure.savefig(file, format=kind, metadata=_UNDATED[kind])
    return file.getvalue()


def _write(figure: Figure, file: Path, kind: str) -> Path:
    part = file.with_name(f".{file.name}.{getpid()}.part")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            part.write_bytes(encoded(figure, kind))
            part.replace(file)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        reason = error.strerror or str(error)
        raise FileError(str(file), f"cannot be written ({reason})", "name another folder") from error
    return file


def stacked(
    width: float, heights: Sequence[float], *, left: float, right: float, top: float, foot: float, gap: float = 3.0
) -> tuple[Figure, list[Axes]]:
    """A figure with panels one below the other, of one width and to the millimetre: a panel can be to scale.

    `heights` are those of the panels, the rest are the margins around and the gap between them, all in mm.
    The panels share the horizontal axis, and only the lowest labels it.
    """
    high = sum(heights) + gap * (len(heights) - 1) + top + foot
    figure = new_figure(width, high, layout="none")
    panels: list[Axes] = []
    y = high - top
    for height in heights:
        box = (left / width, (y - height) / high, (width - left - right) / width, height / high)
        panels.append(figure.add_axes(box, sharex=panels[0] if panels else None))
        y -= height + gap
    for panel in panels[:-1]:
        panel.tick_params(labelbottom=False)
    return figure, panels


def zero_line(axes: Axes) -> None:
    """The line of no strain, so that compression and extension are told apart at sight."""
    axes.axhline(0.0, color=Ink.GREY, linewidth=0.5, zorder=0.5)


def unit_of(finger: Finger, otherwise: str) -> str:
    """The unit of all its readings; `otherwise` where they have several."""
    units = {kind.unit for kind in finger.array.transducers}
    return units.pop() if len(units) == 1 else otherwise


def single(what: str, shape: tuple[int, ...], rule: str = "a single contact is needed", fix: str = "") -> None:
    """Refuses a batch where one is drawn."""
    if shape != ():
        raise GeometryError(f"{what} of shape {shape}", rule, fix or "draw them one by one")


def frame_of(finger: Finger, readings: npt.ArrayLike | None) -> FloatArray | None:
    """The readings of one frame, one for each sensor, if there are any."""
    if readings is None:
        return None
    frame = _check.real("readings", _check.readings(readings), finite=False)
    if frame.shape != (len(finger.array),):
        rule = f"one for each of the {len(finger.array)} sensors"
        raise GeometryError(f"readings of shape {frame.shape}", rule, "readings[0]")
    return frame


def heading(figure: Figure, text: str) -> None:
    """A heading over all panels."""
    figure.suptitle(text, fontsize=8, fontweight="bold", x=0.01, ha="left")


def legend(figure: Figure, *panels: Axes, first: Collection[str] = (), **look: Any) -> None:
    """One legend below all panels, where it covers nothing; each label once, those of `first` before the others."""
    pairs = [pair for axes in panels for pair in zip(*axes.get_legend_handles_labels(), strict=True)]
    entries = {str(label): handle for handle, label in pairs}
    names = sorted(entries, key=lambda name: name not in first)
    figure.legend([entries[name] for name in names], names, **{"loc": "outside lower center"} | look)


def plain(
    axis: Axis, ticks: Sequence[float] | None = None, subs: Sequence[float] = (1.0, 2.0, 5.0), *, small: bool = False
) -> None:
    """Numbers without exponents: at `ticks`, or at `subs` times powers of ten; `small` keeps the ticks between them."""
    axis.set_major_locator(LogLocator(subs=tuple(subs)) if ticks is None else FixedLocator(list(ticks)))
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    if small:
        axis.set_minor_formatter(NullFormatter())
    else:
        axis.set_minor_locator(NullLocator())
