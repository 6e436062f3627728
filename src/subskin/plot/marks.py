"""Loads as they are marked from above: where one stands, its drag, the ellipse of the position that was found."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse, FancyArrowPatch
from matplotlib.patheffects import withStroke

from .._check import FloatArray
from ..loads import Load
from .style import MM, VERMILLION

__all__ = ["mark_drag", "mark_found", "told"]

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
