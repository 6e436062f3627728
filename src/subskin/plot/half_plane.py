"""How wrong the half plane is, over the skin's thickness and the finger's radius."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from .._check import FloatArray
from ..errors import GeometryError
from .style import DOUBLE, Ink, finished, new_figure

__all__ = ["half_plane_map_figure", "tip_map_figure"]

_PANELS = (
    ("beneath", 1.0, "strain beneath a touch over the half plane's", "%.2f"),
    ("reading", 100.0, "worst error of a reading [% of the largest]", "%.0f"),
    ("position", 1.0, "worst error of position [depths]", "%.2f"),
    ("angle", 180 / np.pi, "worst error of angle [degrees]", "%.0f"),
)
_HEIGHT = 140.0
_NUMBER = 6.0
"""Size of a cell's number [pt]."""

_FLAT = 1e9
"""Stands for the radius of a flat skin, in depths, where a logarithm is taken."""


_TIP_PANELS = (
    ("reading", 100.0, "worst error of a reading [% of the largest]", "%.1f"),
    ("position", 1.0, "worst error of position [depths]", "%.2f"),
    ("force", 100.0, "worst error of force [%]", "%.0f"),
    ("angle", 180 / np.pi, "worst error of angle [degrees]", "%.0f"),
)


@finished
def half_plane_map_figure(values: Mapping[str, FloatArray], here: tuple[float, float] | None = None) -> Figure:
    """Four maps of `subskin.design.half_plane_map`, with the number in each cell; flat skins are the top row.

    Parameters
    ----------
    values : mapping
        What `half_plane_map` returned.
    here : (float, float), optional
        Thickness and radius of a finger to ring, as multiples of its sensors' depth; an infinite radius for a flat one.

    Raises
    ------
    GeometryError
        Shapes that do not match, a thickness or a radius that does not ascend.

    Examples
    --------
    >>> import subskin as ss
    >>> values = ss.design.half_plane_map(thickness=[3.0, 8.0], radius=[5.0, float("inf")])
    >>> figure = half_plane_map_figure(values, here=(4.0, 8.0))
    >>> [label.get_text() for label in figure.axes[0].get_yticklabels()]
    ['5', 'flat']
    """
    heights, radii = (np.atleast_1d(np.asarray(values[name], dtype=float)) for name in ("thickness", "radius"))
    for name, sizes in (("thickness", heights), ("radius", radii)):
        if sizes.ndim != 1 or not (np.diff(sizes) > 0).all():
            raise GeometryError(f"{name} = {sizes.tolist()}", "ascending values are needed", "np.sort")
    for name, *_ in _PANELS:
        if values[name].shape != (radii.size, heights.size):
            raise GeometryError(
                f"{name} of shape {values[name].shape}",
                f"({radii.size}, {heights.size}) is needed",
                "a value for each radius and thickness",
            )
    ring = None if here is None else (_cell(here[0], heights), _cell(here[1], radii))
    return _maps(values, _PANELS, (heights, radii), ("thickness / depth", "radius / depth"), ring)


@finished
def tip_map_figure(values: Mapping[str, FloatArray], here: tuple[float, float] | None = None) -> Figure:
    """Four maps of `subskin.design.tip.tip_map`, with the number in each cell.

    Parameters
    ----------
    values : mapping
        What `tip_map` returned.
    here : (float, float), optional
        Radius and depth of sensors to ring [thicknesses of the skin].

    Examples
    --------
    >>> import subskin as ss
    >>> figure = tip_map_figure(ss.design.tip.tip_map("sphere", "mean_pressure"), here=(4.0, 0.5))
    >>> [label.get_text() for label in figure.axes[0].get_yticklabels()]
    ['2', '3', '5', '10', '20', '50']
    """
    depths, radii = values["depth"], values["radius"]
    ring = None
    if here is not None:
        across = float(np.interp(here[1], depths, np.arange(depths.size) + 0.5))
        ring = across, _cell(here[0], radii)
    return _maps(values, _TIP_PANELS, (depths, radii), ("depth / thickness", "radius / thickness"), ring)


def _maps(
    values: Mapping[str, FloatArray],
    contents: tuple[tuple[str, float, str, str], ...],
    sizes: tuple[FloatArray, FloatArray],
    names: tuple[str, str],
    ring: tuple[float, float] | None,
) -> Figure:
    """Four panels, with a ring at a cell."""
    figure = new_figure(DOUBLE, _HEIGHT)
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, (name, factor, title, form) in zip(panels.flat, contents, strict=True):
        _panel(axes, factor * values[name], form, about_one=name == "beneath")
        axes.set_title(title, fontweight="normal")
        if ring is not None:
            axes.plot(*ring, "o", ms=16, mfc="none", mec=Ink.VERMILLION, mew=1.2, clip_on=False)
        _label(axes, *sizes)
        axes.set(xlabel=names[0], ylabel=names[1])
        axes.label_outer()
    return figure


def _cell(value: float, sizes: FloatArray) -> float:
    """Where a thickness or a radius lies among the cells; beyond them, in the outermost."""
    finite = np.minimum(sizes, _FLAT)
    return float(np.interp(np.log(min(value, _FLAT)), np.log(finite), np.arange(sizes.size) + 0.5))


def _label(axes: Axes, heights: FloatArray, radii: FloatArray) -> None:
    for axis, sizes in ((axes.xaxis, heights), (axes.yaxis, radii)):
        axis.set_major_locator(FixedLocator((np.arange(sizes.size) + 0.5).tolist()))
        axis.set_minor_locator(NullLocator())
    axes.set_xticklabels([f"{h:.3g}" for h in heights])
    axes.set_yticklabels(["flat" if np.isinf(r) else f"{r:.3g}" for r in radii])
    axes.tick_params(length=0)


def _panel(axes: Axes, values: FloatArray, form: str, *, about_one: bool) -> None:
    """One map: each cell coloured and with its number; grey where there is no such finger."""
    finite = values[np.isfinite(values)]
    if about_one:
        spread = max(float(np.abs(finite - 1).max(initial=0.0)), 1e-6)
        norm: Normalize = TwoSlopeNorm(1.0, 1 - spread, 1 + spread)
        colours = "PuOr"
    else:
        high = max(float(finite.max(initial=0.0)), 1e-9)
        low = max(float(finite[finite > 0].min(initial=high)), 1e-3 * high)
        norm, colours = LogNorm(low, max(high, 1.001 * low)), "cividis_r"
    image = axes.pcolormesh(values, norm=norm, cmap=colours, edgecolors="w", linewidth=0.3)
    for i, j in np.argwhere(np.isfinite(values)):
        red, green, blue, _ = image.cmap(norm(values[i, j]))
        ink = "w" if 0.3 * red + 0.59 * green + 0.11 * blue < 0.5 else Ink.BLACK
        axes.text(j + 0.5, i + 0.5, form % values[i, j], ha="center", va="center", fontsize=_NUMBER, color=ink)
    axes.set_facecolor("#EEEEEE")
