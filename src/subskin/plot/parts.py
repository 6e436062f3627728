"""What many figures have: panels to scale, a line of no strain, headings, legends, plain numbers on an axis."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter, NullLocator

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError
from ..finger import Finger
from .style import GREY, new_figure

__all__ = ["frame_of", "heading", "legend", "plain", "single", "stacked", "unit_of", "zero_line"]


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
    axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=0.5)


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
