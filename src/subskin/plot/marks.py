"""Loads and readings from above: where one stands, its drag, the ellipse of what was found; a disc for each sensor."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, FancyArrowPatch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from .._check import FloatArray
from ..contact import LocalContact
from ..finger import Finger
from ..loads import Load
from ..transducer import Transducer
from .parts import heading
from .style import BLACK, DOUBLE, GREY, MM, SINGLE, VERMILLION, new_figure

__all__ = ["heat_maps", "mark_drag", "mark_found", "told"]

_HALO = [withStroke(linewidth=2.6, foreground="white")]
"""Marks stand out from a dark field."""
_ELLIPSE_95 = 2.447747
"""Half axes of a 95 % ellipse in standard deviations: sqrt(-2 ln 0.05)."""


def told(load: Load) -> str:
    """A load in words: 1.5 N, 28.6° towards 46°, at (1.00, -2.00) mm."""
    (y, z), force, angle = MM * load.position, float(load.force), float(np.degrees(load.angle))
    towards = f" towards {float(np.degrees(load.azimuth)):z.0f}°" if angle > 1e-9 else ""
    return f"{force:.3g} N, {angle:.1f}°{towards}, at ({y:z.2f}, {z:z.2f}) mm".replace("-", "−")


def mark_drag(axes: Axes, position: FloatArray, components: FloatArray, length: float, colour: str) -> None:
    """A dot where a load stands, and its drag as an arrow: `length` [mm] where it is as large as the force."""
    y, z = MM * np.asarray(position)
    axes.plot([y], [z], "o", color=colour, markersize=3.2, zorder=4, path_effects=_HALO)
    shift = length * np.asarray(components)[1:] / (np.linalg.norm(components) or 1.0)
    if np.hypot(*shift) > 0.02 * length:
        arrow = FancyArrowPatch((y, z), (y + shift[0], z + shift[1]), arrowstyle="-|>", shrinkA=0, shrinkB=0)
        arrow.set(color=colour, linewidth=1.6, mutation_scale=9, zorder=4, path_effects=_HALO)
        axes.add_patch(arrow)


def mark_found(axes: Axes, load: Load, length: float) -> None:
    """The load that was found, and the 95 % ellipse of its position."""
    mark_drag(axes, load.position, load.components, length, VERMILLION)
    if load.covariance is not None and np.isfinite(load.covariance[:2, :2]).all():
        values, vectors = np.linalg.eigh(load.covariance[:2, :2])
        wide, high = 2 * _ELLIPSE_95 * MM * np.sqrt(np.maximum(values, 0.0))
        turn = float(np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0])))
        ellipse = Ellipse(tuple(MM * np.asarray(load.position)), wide, high, angle=turn, zorder=3.5)
        ellipse.set(facecolor="none", edgecolor=VERMILLION, linewidth=1.2, path_effects=_HALO)
        axes.add_patch(ellipse)


_TALLEST = 88.0
"""Height of a map [mm], at most."""
_BESIDE = 30.0
"""Room beside a map, for its labels and its bar [mm]."""
_UNITS = {"": (100.0, "%"), "Pa": (1e-3, "kPa"), "m": (1e6, "µm"), "T": (1e3, "mT")}


def heat_maps(finger: Finger, contact: LocalContact | None, load: Load | None, frame: FloatArray, title: str) -> Figure:
    """What each kind of sensor measures, freed of offset and gain, as discs from above: a panel for each kind."""
    array = finger.array
    kinds = list(dict.fromkeys(array.transducers))
    columns = 2 if len(kinds) == 4 else min(len(kinds), 3)
    rows = -(-len(kinds) // columns)
    points = MM * array.points
    near = _nearest(points)
    low, high = points.min(axis=0) - 0.75 * near, points.max(axis=0) + 0.75 * near
    aspect = float((high - low)[1] / (high - low)[0])
    wide = (SINGLE if columns == 1 else DOUBLE) / columns
    inner = min(wide - _BESIDE, _TALLEST / aspect)
    tall, head = aspect * inner + 14.5, 5.5 if title else 0.0
    figure = new_figure(wide * columns, tall * rows + head, layout="none")
    measured = (frame - np.asarray(array.offset)) / np.where(array.live, array.gain, np.nan)
    for k, kind in enumerate(kinds):
        x, y = wide * (k % columns) + 11.0, tall * (rows - 1 - k // columns) + 9.0
        size = np.array([wide * columns, tall * rows + head] * 2)
        axes = figure.add_axes(tuple(np.array([x, y, inner, aspect * inner]) / size))
        bar = figure.add_axes(tuple(np.array([x + inner + 2.5, y, 2.2, aspect * inner]) / size))
        own = np.array([other == kind for other in array.transducers])
        _discs(axes, bar, points[own], measured[own], 0.84 * near, kind)
        if contact is not None:
            mark_drag(axes, contact.position, contact.components, 0.2 * float((high - low)[0]), BLACK)
        if load is not None:
            mark_found(axes, load, 0.2 * float((high - low)[0]))
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="y [mm]", ylabel="z [mm]")
        axes.set_title(repr(kind).removesuffix("()"), fontweight="normal", pad=3)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    if title:
        heading(figure, title)
    return figure


def _nearest(points: FloatArray) -> float:
    """Distance of the closest two of some points that are not the same; 1 where there is one alone."""
    unique = np.unique(points, axis=0)
    gaps = np.hypot(*(unique[:, None] - unique).T) + np.diag(np.full(len(unique), np.inf))
    return float(gaps.min()) if len(unique) > 1 else 1.0


def _discs(axes: Axes, bar: Axes, points: FloatArray, measured: FloatArray, size: float, kind: Transducer) -> None:
    """What sensors of one kind measure, each as a disc of `size` [mm], with their bar; a cross where there is none."""
    scale, unit = _UNITS.get(kind.unit, (1.0, kind.unit))
    known = np.isfinite(measured)
    most = scale * float(np.abs(measured[known]).max(initial=0.0)) or 1.0
    each = np.full(int(known.sum()), size)
    look: dict[str, Any] = {"cmap": "RdBu_r", "edgecolor": GREY, "linewidth": 0.4}
    discs = EllipseCollection(each, each, 0 * each, units="xy", offsets=points[known], **look)
    discs.set_offset_transform(axes.transData)
    discs.set_array(scale * measured[known])
    discs.set_clim(-most, most)
    axes.add_collection(discs)
    axes.plot(*points[~known].T, "x", color=GREY)
    Colorbar(bar, discs, label=f"measured [{unit}]" if unit else "measured")
    bar.tick_params(labelsize=6)
