"""All designs of a search: how near each comes to what was wanted."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator, ScalarFormatter

from ..design.search import DesignedFinger, DesignStudy
from .style import BLACK, BLUE, DOUBLE, GREEN, ORANGE, PINK, VERMILLION, house_style, new_figure, settled

__all__ = ["design_map_figure"]

_COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PINK, BLACK)
_DASHES = ("-", "--", ":", "-.")
_TOP = 30.0
"""Ratios above this are drawn as this."""


def design_map_figure(study: DesignStudy, finger: DesignedFinger | None = None) -> Figure:
    """Depth and pitch of one finger among all others, and what each count of sensors can do.

    Drawn is the largest ratio of what a design does to what was wanted: up to 1 all is met.

    Parameters
    ----------
    study : DesignStudy
        From `subskin.design.rank_fingers`.
    finger : DesignedFinger, optional
        Whose skin, kind and count the map is for; the first one's if left out.
    """
    chosen = study.fingers[0] if finger is None else finger
    grid, row = study.grid, chosen.row
    excess = np.where(np.isfinite(grid.excess), grid.excess, np.inf)
    n = int(np.searchsorted(grid.counts, row.count))
    with house_style():
        figure = new_figure(DOUBLE, 86.0)
        left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
        _map(figure, left, study, chosen, excess[row.skin, row.sensor, :, :, n])
        for k, choice in enumerate(study.goals.skins):
            for m, kind in enumerate(study.goals.sensors):
                best = np.minimum(excess[k, m].min(axis=(0, 1)), _TOP)
                if grid.counts.size > 1:
                    name = f"{kind.name}, {choice.name}"
                    colour, dash = _COLOURS[m % len(_COLOURS)], _DASHES[k % len(_DASHES)]
                    right.plot(grid.counts, best, dash, color=colour, label=name, marker=".")
                else:
                    right.plot(grid.counts, best, "o", color=_COLOURS[m % len(_COLOURS)])
        right.axhspan(1e-6, 1.0, color="#D9F0E6", zorder=0, linewidth=0)
        drawn = [*excess.min(axis=(2, 3)).ravel(), *(f.excess for f in study.fingers)]
        seen = [value for value in drawn if np.isfinite(value)]
        ends = 0.8 * min(*seen, 0.8), 1.25 * min(max(*seen, 1.25), _TOP)
        right.set(xlabel="sensors", ylabel="worst ratio", yscale="log", ylim=ends)
        right.set_title("best depth and pitch for each count")
        _plain(right, "y", ends)
        right.xaxis.set_major_locator(FixedLocator(grid.counts[:: max(1, grid.counts.size // 8)].tolist()))
        right.plot([row.count], [chosen.excess], "o", mfc="none", mec=BLACK, ms=9, zorder=4)
        if grid.counts.size > 1:
            handles, labels = right.get_legend_handles_labels()
            figure.legend(handles, labels, loc="outside lower center", ncols=min(2, len(labels)))
        return settled(figure)


def _map(figure: Figure, axes: Axes, study: DesignStudy, chosen: DesignedFinger, excess: np.ndarray) -> None:
    grid, row = study.grid, chosen.row
    pitches, depths = 1e3 * grid.pitches, 1e3 * grid.depths[row.skin]
    axes.set_title(f"{row.count} sensors, {study.goals.sensors[row.sensor].name}")
    axes.set(xlabel="pitch [mm]", ylabel="depth [mm]")
    shown = np.where(np.isfinite(excess), np.minimum(excess, _TOP), np.nan)
    axes.set_facecolor("#EEEEEE")
    if min(shown.shape) > 1:
        mesh = axes.pcolormesh(
            pitches, depths, shown, norm=LogNorm(0.2, _TOP), cmap="cividis_r", shading="nearest", rasterized=True
        )
        axes.set(xscale="log", yscale="log")
        filled = np.where(np.isfinite(excess), excess, 2 * _TOP)
        if (filled <= 1).any():
            axes.contour(pitches, depths, filled, levels=[1.0], colors=[BLACK], linewidths=1.2)
        bar = figure.colorbar(mesh, ax=axes, ticks=[0.2, 0.5, 1, 2, 5, 10, 30])
        bar.ax.yaxis.set_major_formatter(ScalarFormatter())
        bar.ax.yaxis.set_minor_locator(NullLocator())
        bar.set_label("worst ratio to what is wanted")
    for name, values in (("x", pitches), ("y", depths)):
        _plain(axes, name, (float(values[0]), float(values[-1])))
    axes.plot([1e3 * row.pitch], [1e3 * row.depth], "o", mfc="white", mec=VERMILLION, mew=1.6, ms=7)


def _plain(axes: Axes, which: str, ends: tuple[float, float]) -> None:
    """Plain numbers on a logarithmic axis, more of them where it is short."""
    axis = axes.xaxis if which == "x" else axes.yaxis
    steps = (1, 2, 5) if ends[1] > 6 * ends[0] else (1, 1.25, 1.6, 2, 2.5, 3, 4, 5, 6, 8)
    powers = 10.0 ** np.arange(-3, 4)
    ticks = np.round(np.outer(powers, steps).ravel(), 6)
    axis.set_major_locator(FixedLocator(ticks[(ticks >= ends[0] * 0.99) & (ticks <= ends[1] * 1.01)].tolist()))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())
