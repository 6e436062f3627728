"""How wrong the half plane is, over the skin's thickness and the finger's radius."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from .._check import FloatArray
from ..errors import GeometryError
from .style import BLACK, DOUBLE, VERMILLION, house_style, new_figure, settled

__all__ = ["half_plane_map_figure"]

_PANELS = (
    ("beneath", 1.0, "strain beneath a touch\nover the half plane's", "%.2f"),
    ("reading", 100.0, "worst error of a reading\n[% of the largest]", "%.0f"),
    ("position", 1.0, "worst error of place\n[depths]", "%.2g"),
    ("angle", 180 / np.pi, "worst error of angle\n[degrees]", "%.0f"),
)


def half_plane_map_figure(
    thickness: npt.ArrayLike,
    radius: npt.ArrayLike,
    values: Mapping[str, FloatArray],
    here: tuple[float, float] | None = None,
) -> Figure:
    """Four maps of `subskin.design.half_plane_map`; flat skins (an infinite radius) are the top row.

    Parameters
    ----------
    thickness, radius : array_like
        As given to `half_plane_map`, ascending [depths].
    values : mapping
        What it returned.
    here : (float, float), optional
        Thickness and radius of a finger to mark [depths].

    Raises
    ------
    GeometryError
        Shapes that do not match.
    """
    heights, radii = np.asarray(thickness, dtype=float), np.asarray(radius, dtype=float)
    for name, *_ in _PANELS:
        if values[name].shape != (radii.size, heights.size):
            raise GeometryError(
                f"{name} of shape {values[name].shape}", f"({radii.size}, {heights.size}) is needed"
            )
    with house_style():
        figure = new_figure(DOUBLE, 58.0)
        panels = figure.subplots(1, 4, sharey=True)
        for axes, (name, factor, title, form) in zip(panels, _PANELS, strict=True):
            _panel(axes, heights, radii, factor * values[name], form, one=name == "beneath")
            axes.set_title(title, fontweight="normal")
            axes.set_xlabel("thickness / depth")
            if here is not None:
                at = np.interp(np.log(min(here[1], 1e9)), *_rows(radii))
                axes.plot(
                    np.interp(np.log(here[0]), *_columns(heights)),
                    at,
                    "o",
                    mfc="none",
                    mec=VERMILLION,
                    mew=1.4,
                )
        panels[0].set_ylabel("radius / depth")
        return settled(figure)


def _columns(heights: FloatArray) -> tuple[Any, Any]:
    return np.log(heights), np.arange(heights.size) + 0.5


def _rows(radii: FloatArray) -> tuple[Any, Any]:
    return np.log(np.where(np.isinf(radii), 1e9, radii)), np.arange(radii.size) + 0.5


def _panel(
    axes: Axes, heights: FloatArray, radii: FloatArray, values: FloatArray, form: str, one: bool
) -> None:
    """One map: each cell coloured, every other one with its number."""
    finite = values[np.isfinite(values)]
    if one:
        spread = max(float(np.abs(finite - 1).max()), 1e-6)
        norm: Normalize = TwoSlopeNorm(1.0, 1 - spread, 1 + spread)
        colours = "PuOr"
    else:
        low = max(float(finite[finite > 0].min()) if (finite > 0).any() else 1e-3, 1e-3 * float(finite.max()))
        norm, colours = LogNorm(low, max(float(finite.max()), 1.001 * low)), "cividis_r"
    image = axes.pcolormesh(values, norm=norm, cmap=colours, edgecolors="none", rasterized=True)
    for i, j in np.ndindex(values.shape):
        if np.isfinite(values[i, j]) and i % 2 == (values.shape[0] - 1) % 2 and j % 2 == 0:
            red, green, blue, _ = image.cmap(norm(values[i, j]))
            dark = 0.3 * red + 0.59 * green + 0.11 * blue < 0.5
            text = form % values[i, j]
            axes.text(
                j + 0.5, i + 0.5, text, ha="center", va="center", fontsize=5.5, color="w" if dark else BLACK
            )
    for axis, sizes in ((axes.xaxis, heights), (axes.yaxis, radii)):
        shown = np.arange(0, sizes.size, 2) if axis is axes.xaxis else np.arange(sizes.size - 1, -1, -2)
        axis.set_major_locator(FixedLocator((shown + 0.5).tolist()))
        axis.set_minor_locator(NullLocator())
        labels = ["flat" if np.isinf(sizes[k]) else f"{sizes[k]:.3g}" for k in shown]
        (axes.set_xticklabels if axis is axes.xaxis else axes.set_yticklabels)(labels)
    axes.set_facecolor("#EEEEEE")
