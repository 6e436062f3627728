"""All designs of a search: how near each comes to what was wanted."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from ..design.search import DesignedFinger, DesignStudy
from .parts import legend, plain
from .style import BLACK, BLUE, DOUBLE, GREEN, ORANGE, PINK, VERMILLION, finished, new_figure

__all__ = ["design_map_figure"]

_COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PINK, BLACK)
_DASHES = ("-", "--", ":", "-.")
_TOP = 30.0
"""Ratios above this are drawn as this."""


@finished
def design_map_figure(study: DesignStudy, finger: DesignedFinger | None = None) -> Figure:
    """Depth and pitch of one finger among all others, and what each count of sensors can do.

    Drawn is the largest ratio of what a design does to what was wanted: up to 1 all is met.

    Parameters
    ----------
    study : DesignStudy
        From `subskin.design.rank_fingers`.
    finger : DesignedFinger, optional
        Whose skin, kind and count the map is for; the first one's if left out.

    Examples
    --------
    >>> file = load_goals("goals.toml")  # doctest: +SKIP
    >>> study = rank_fingers(search_grid(file.goals))  # doctest: +SKIP
    >>> save(design_map_figure(study), "map.png")  # doctest: +SKIP
    """
    chosen = study.fingers[0] if finger is None else finger
    grid, row = study.grid, chosen.row
    excess = np.where(np.isfinite(grid.excess), grid.excess, np.inf)
    n = row.which(study.goals)[2]
    figure = new_figure(DOUBLE, 86.0)
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    counts = np.unique(grid.counts)
    _map(figure, left, study, chosen, excess[row.skin, row.sensor, :, :, n])
    for k, choice in enumerate(study.goals.skins):
        for m, kind in enumerate(study.goals.choices):
            best = np.minimum(_of_counts(grid.counts, excess[k, m].min(axis=(0, 1))), _TOP)
            dash = "o" if counts.size == 1 else f".{_DASHES[k % len(_DASHES)]}"
            colour = _COLOURS[m % len(_COLOURS)]
            right.plot(counts, best, dash, color=colour, label=f"{kind.name}, {choice.name}")
    right.axhspan(1e-6, 1.0, color="#D9F0E6", zorder=0, linewidth=0)
    drawn = [*excess.min(axis=(2, 3)).ravel(), *(f.excess for f in study.fingers)]
    seen = [value for value in drawn if np.isfinite(value)]
    ends = 0.8 * min(*seen, 0.8), 1.25 * min(max(*seen, 1.25), _TOP)
    right.set(xlabel="positions" if study.goals.on_area else "sensors", ylabel="worst ratio", yscale="log", ylim=ends)
    right.set_title("best of each count" if study.goals.on_area else "best depth and pitch for each count")
    plain(right.yaxis, _ticks(*ends))
    right.xaxis.set_major_locator(FixedLocator(counts[:: max(1, counts.size // 8)].tolist()))
    right.plot([row.count], [chosen.excess], "o", mfc="none", mec=BLACK, ms=9, zorder=4)
    if counts.size > 1:
        legend(figure, right, ncols=min(2, len(study.goals.skins) * len(study.goals.choices)))
    return figure


def _map(figure: Figure, axes: Axes, study: DesignStudy, chosen: DesignedFinger, excess: np.ndarray) -> None:
    grid, row = study.grid, chosen.row
    pitches, depths = 1e3 * grid.pitches, 1e3 * grid.depths[row.skin]
    layout = study.goals.layouts[row.which(study.goals)[2]]
    many = layout.text if study.goals.on_area else f"{row.count} sensors"
    axes.set_title(f"{many}, {study.goals.choices[row.sensor].name}")
    axes.set(xlabel="pitch [mm]", ylabel="depth [mm]")
    shown = np.where(np.isfinite(excess), np.minimum(excess, _TOP), np.nan)
    axes.set_facecolor("#EEEEEE")
    if min(shown.shape) > 1:
        look: dict[str, Any] = {"cmap": "cividis_r", "shading": "nearest", "rasterized": True}
        seen = shown[np.isfinite(shown)]
        good = bool((seen <= 1).any())  # else colours are for how far off the designs are, not for what none reaches
        low, high = (0.2, _TOP) if good or not seen.size else (float(seen.min()), float(seen.max()))
        mesh = axes.pcolormesh(pitches, depths, shown, norm=LogNorm(low, max(high, 1.5 * low)), **look)
        axes.set(xscale="log", yscale="log")
        filled = np.where(np.isfinite(excess), excess, 2 * _TOP)
        if (filled <= 1).any():
            axes.contour(pitches, depths, filled, levels=[1.0], colors=[BLACK], linewidths=1.2)
        bar = figure.colorbar(mesh, ax=axes, label="worst ratio to what is wanted")
        plain(bar.ax.yaxis, [0.2, 0.5, 1, 2, 5, 10, 30] if good else _ticks(low, max(high, 1.5 * low)))
    plain(axes.xaxis, _ticks(pitches[0], pitches[-1]))
    plain(axes.yaxis, _ticks(depths[0], depths[-1]))
    if not row.free:
        axes.plot([1e3 * row.pitch], [1e3 * row.depth], "o", mfc="white", mec=VERMILLION, mew=1.6, ms=7)


def _of_counts(counts: np.ndarray, excess: np.ndarray) -> np.ndarray:
    """The least of each count, of which there may be several layouts."""
    return np.array([excess[counts == count].min() for count in np.unique(counts)])


def _ticks(low: float, high: float) -> list[float]:
    """Round numbers on a logarithmic axis, more of them where it is short."""
    steps = (1, 2, 5) if high > 6 * low else (1, 1.25, 1.6, 2, 2.5, 3, 4, 5, 6, 8)
    ticks = np.round(np.outer(10.0 ** np.arange(-3, 4), steps).ravel(), 6)
    return [float(tick) for tick in ticks if 0.99 * low <= tick <= 1.01 * high]
