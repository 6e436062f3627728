"""Where a finger locates well and where it cannot; what pitch, depth and number of sensors make of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from .. import _check
from .._check import FloatArray
from ..design.placement import PlacementQuality
from ..design.search import DesignedFinger, DesignStudy
from ..errors import GeometryError, InvalidValueError
from .style import DOUBLE, MM, Ink, finished, legend, new_figure, plain

__all__ = ["design_map_figure", "placement_figure", "placement_study_figure"]

_COLOURS = (Ink.VERMILLION, Ink.ORANGE, Ink.GREEN, Ink.BLUE, Ink.PINK, Ink.BLACK)
_LEAST, _MOST = 3.0, 300.0
"""Largest over smallest standard deviation that a map's colours tell apart: an even map looks even."""

_SHARE = 0.95
_UNITS = {"position": (MM, "mm"), "radius": (MM, "mm"), "angle": (180 / np.pi, "°"), "force": (100.0, "%")}
_FLOOR = 0.01
"""Share of touches [%] at the foot of the panel, where less is drawn as well."""


@finished
def placement_figure(quality: PlacementQuality) -> Figure:
    """Standard deviations over the touches, marked where they are not located for sure.

    Of a row those of position and angle, over position and angle. On an area those of position, and of the radius or
    the force, over the area: at each position that of the load which 95 % of the loads there do not exceed.

    Parameters
    ----------
    quality : PlacementQuality
        From `subskin.design.placement_quality`, of a row on a grid of two angles or more.

    Raises
    ------
    GeometryError
        A grid of one angle: its touches are a line, and no map.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=5e-5)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    >>> quality = ss.design.placement_quality(finger, ss.design.Touches(force=40.0), grid=(21, 9))
    >>> placement_figure(quality).axes[0].get_ylabel()
    'angle of the touch [°]'
    """
    row = quality.touches.dim == 1
    if row and len(quality.load) < 2:
        raise GeometryError("a grid of one angle", "two or more make a map", "friction > 0, grid=(101, 41)")
    figure = new_figure(DOUBLE, 72.0 if row else 74.0)
    if row:
        figure.get_layout_engine().set(wspace=0.08)  # type: ignore[union-attr,call-arg]
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    other = "angle" if row else "force" if quality.touches.half_width is None else "radius"
    for axes, name in zip(panels, ("position", other), strict=True):
        scale, unit = _UNITS[name]
        draw = _over_angles if row else _over_area
        draw(figure, axes, quality, scale * quality.std[name], f"std of the {name} [{unit}]")
    panels[0].set_ylabel("angle of the touch [°]" if row else "z of the touch [mm]")
    size = MM * quality["position_worst" if row else "position_95"]
    told, where = f"{size:.3g} mm" if np.isfinite(size) else "not determined", "at worst" if row else "for 95 %"
    panels[0].set_title(f"position: {told} {where}")
    unsure = 100 * (quality["ambiguous"] + np.nan_to_num(quality["unfelt"]))
    panels[1].set_title(f"unsure: {unsure:.2g} % of touches" if unsure >= 0.01 else "no touch is unsure")
    return figure


def _over_angles(figure: Figure, axes: Axes, quality: PlacementQuality, std: FloatArray, label: str) -> None:
    """A map of a row over positions and angles, hatched where touches are unsure, with the sensors below."""
    positions, angles = MM * quality.position, np.rad2deg(quality.angle)
    _map(figure, axes, positions, angles, std, label)
    unsure = (quality.ambiguous + quality.unfelt).T
    if (unsure >= 0.5).any():
        with mpl.rc_context({"hatch.linewidth": 0.5, "hatch.color": Ink.VERMILLION}):
            axes.contourf(positions, angles, unsure, levels=[0.5, 2.0], colors="none", hatches=["/////"])
        axes.contour(positions, angles, unsure, levels=[0.5], colors=Ink.VERMILLION, linewidths=0.6)
    array = quality.finger.array
    y = MM * np.asarray(array.y)[array.live]
    edge: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "clip_on": False}
    axes.plot(y, np.full(y.size, -0.02), marker=6, ls="none", color=Ink.BLACK, ms=5, **edge)
    margin = 0.02 * (positions[-1] - positions[0])
    axes.set_xlim(min(positions[0], y.min()) - margin, max(positions[-1], y.max()) + margin)
    axes.tick_params(axis="x", pad=6)
    axes.set_xlabel("position of the touch [mm], sensors marked")


def _over_area(figure: Figure, axes: Axes, quality: PlacementQuality, std: FloatArray, label: str) -> None:
    """A map over an area of what 95 % of the loads at each position keep, outlined where touches are ambiguous."""
    order = np.argsort(std, axis=-1)
    passed = np.cumsum(np.take_along_axis(quality.weight, order, axis=-1), axis=-1)
    at = (passed < _SHARE * passed[..., -1:]).sum(axis=-1)[..., None]
    kept = np.take_along_axis(np.take_along_axis(std, order, axis=-1), at, axis=-1)[..., 0]
    y, z = MM * quality.position[:, 0, 0], MM * quality.position[0, :, 1]
    axes.set_facecolor("#EEEEEE")
    _map(figure, axes, y, z, kept, label)
    unsure = np.average(quality.ambiguous, axis=-1, weights=quality.weight).T
    if (unsure >= 0.5).any() and not (unsure >= 0.5).all():
        axes.contour(y, z, unsure, levels=[0.5], colors=[Ink.VERMILLION], linewidths=1.2)
    points = MM * np.unique(quality.finger.array.points[quality.finger.array.live], axis=0)
    axes.plot(*points.T, "o", mfc="white", mec=Ink.BLACK, mew=0.9, ms=4.5, zorder=3)
    seen = np.concatenate([points, np.stack([y[[0, -1]], z[[0, -1]]], axis=-1)])
    low, high = seen.min(axis=0), seen.max(axis=0)
    margin = 0.04 * float((high - low).max())
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    axes.set_box_aspect(float((high[1] - low[1] + 2 * margin) / (high[0] - low[0] + 2 * margin)))
    axes.set_xlabel("y of the touch [mm]")


def _map(figure: Figure, axes: Axes, x: FloatArray, y: FloatArray, std: FloatArray, label: str) -> None:
    """Standard deviations (x, y) in colours, and their bar."""
    known = std[np.isfinite(std) & (std > 0)]
    low = float(known.min()) if known.size else 1.0
    high = float(np.clip(known.max(initial=low), _LEAST * low, _MOST * low))
    look: dict[str, Any] = {"cmap": "cividis_r", "shading": "nearest", "rasterized": True}
    shown = axes.pcolormesh(x, y, std.T, norm=LogNorm(low, high), **look)
    bar = figure.colorbar(shown, ax=axes, label=label, extend="max" if (std > high).any() else "neither")
    plain(bar.ax.yaxis, subs=(1.0, 2.0, 5.0) if high < 50 * low else (1.0, 3.0))


@finished
def placement_study_figure(
    study: Mapping[str, FloatArray],
    depth: float,
    pitches: npt.ArrayLike,
    counts: Sequence[int],
    *,
    measure: str = "position_worst",
    most: float = 0.01,
    within: float = 0.1,
) -> Figure:
    """Error of the position, and share of touches not located for sure, over pitch and number of sensors.

    Thick where a row is nearly as good as the best of its number among rows that locate enough touches. Left out where
    the error of the position exceeds the length of the row.

    Parameters
    ----------
    study : mapping of str to ndarray, shape (s, c)
        From `subskin.design.placement.study_at_depth`, of rows.
    depth : float
        Depth of the sensors [m].
    pitches : array_like, shape (s,)
        Distances of neighbours, two or more [m].
    counts : sequence of int
        Numbers of sensors, six at most.
    measure : {"position_worst", "position_95", "position_mean"}, optional
        What is drawn on the left.
    most : float, optional
        Largest share of touches that may be ambiguous or unfelt.
    within : float, optional
        Share by which the measure of a row that is nearly as good may be larger.

    Raises
    ------
    GeometryError, InvalidValueError
        Fewer than two pitches; other pitches and numbers of sensors than those of the study; another measure.

    Examples
    --------
    >>> import subskin as ss
    >>> from subskin.design.placement import Channel, study_at_depth
    >>> skin, touches, pitches = ss.HalfPlane(ss.Material(young=0.4e6)), ss.design.Touches(force=40.0), [0.5e-3, 1e-3]
    >>> rows = study_at_depth(skin, Channel(ss.NormalStrain(), 5e-5), 1e-3, pitches, [4, 6], touches, samples=500)
    >>> placement_study_figure(rows, 1e-3, pitches, [4, 6]).axes[0].get_xlabel()
    'pitch / depth'
    """
    _check.choice("measure", measure, _MEASURES, 'measure="wrong"')
    deep, steps = _check.scalar("depth", depth, unit="m", above=0.0), _check.real("pitches", pitches, unit="m", above=0)
    shape = study["wrong"].shape
    if shape != (steps.size, len(counts)) or not 0 < len(counts) <= len(_COLOURS):
        seen = f"pitches of shape {steps.shape}, {len(counts)} counts, a study of shape {shape}"
        raise InvalidValueError(
            seen, f"those of the study are needed, and {len(_COLOURS)} counts at most", "counts=[4]"
        )
    if steps.size < 2:
        raise GeometryError("one pitch", "two or more are needed to draw a line", "pitches=np.linspace(1e-3, 3e-3, 9)")
    figure = new_figure(DOUBLE, 78.0)
    left, right = figure.subplots(1, 2, sharex=True)
    order = np.argsort(steps)
    ratio = steps[order] / deep
    for column, (colour, count) in enumerate(zip(_COLOURS, counts, strict=False)):
        std, ambiguous, unfelt = (study[name][order, column] for name in (measure, "ambiguous", "unfelt"))
        std, unsure = std / deep, ambiguous + unfelt
        std = np.where(std < ratio * count, std, np.nan)
        left.plot(ratio, std, color=colour, label=f"{count} sensors")
        right.plot(ratio, np.maximum(100 * unsure, _FLOOR), color=colour)
        allowed = np.where(unsure <= most, std, np.nan)
        if np.isfinite(allowed).any():
            near = allowed <= (1 + within) * np.nanmin(allowed)
            left.plot(ratio, np.where(near, std, np.nan), color=colour, lw=4, alpha=0.5, solid_capstyle="round")
    for axes in (left, right):
        axes.set(yscale="log", xlabel="pitch / depth")
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    left.set_ylabel(f"std of the position / depth, {_MEASURES[measure]}")
    right.set(ylabel="unsure touches [%]", ylim=(0.8 * _FLOOR, 130))
    right.axhline(100 * most, color=Ink.GREY, lw=0.6, ls=(0, (4, 3)))
    legend(figure, left, ncols=6)
    return figure


_MEASURES = {"position_worst": "at worst", "position_95": "95 % below", "position_mean": "mean"}


_KIND_COLOURS = (Ink.BLUE, Ink.VERMILLION, Ink.GREEN, Ink.ORANGE, Ink.PINK, Ink.BLACK)
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
    _design_map(figure, left, study, chosen, excess[row.skin, row.sensor, :, :, n])
    for k, choice in enumerate(study.goals.skins):
        for m, kind in enumerate(study.goals.choices):
            best = np.minimum(_of_counts(grid.counts, excess[k, m].min(axis=(0, 1))), _TOP)
            dash = "o" if counts.size == 1 else f".{_DASHES[k % len(_DASHES)]}"
            colour = _KIND_COLOURS[m % len(_KIND_COLOURS)]
            right.plot(counts, best, dash, color=colour, label=f"{kind.name}, {choice.name}")
    right.axhspan(1e-6, 1.0, color="#D9F0E6", zorder=0, linewidth=0)
    drawn = [*excess.min(axis=(2, 3)).ravel(), *(f.excess for f in study.fingers)]
    seen = [value for value in drawn if np.isfinite(value)]
    ends = 0.8 * min(*seen, 0.8), 1.25 * min(max(*seen, 1.25), _TOP)
    right.set(xlabel="positions" if study.goals.on_area else "sensors", ylabel="worst ratio", yscale="log", ylim=ends)
    right.set_title("best of each count" if study.goals.on_area else "best depth and pitch for each count")
    plain(right.yaxis, _ticks(*ends))
    right.xaxis.set_major_locator(FixedLocator(counts[:: max(1, counts.size // 8)].tolist()))
    right.plot([row.count], [chosen.excess], "o", mfc="none", mec=Ink.BLACK, ms=9, zorder=4)
    if counts.size > 1:
        legend(figure, right, ncols=min(2, len(study.goals.skins) * len(study.goals.choices)))
    return figure


def _design_map(figure: Figure, axes: Axes, study: DesignStudy, chosen: DesignedFinger, excess: np.ndarray) -> None:
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
            axes.contour(pitches, depths, filled, levels=[1.0], colors=[Ink.BLACK], linewidths=1.2)
        bar = figure.colorbar(mesh, ax=axes, label="worst ratio to what is wanted")
        plain(bar.ax.yaxis, [0.2, 0.5, 1, 2, 5, 10, 30] if good else _ticks(low, max(high, 1.5 * low)))
    plain(axes.xaxis, _ticks(pitches[0], pitches[-1]))
    plain(axes.yaxis, _ticks(depths[0], depths[-1]))
    if not row.free:
        axes.plot([1e3 * row.pitch], [1e3 * row.depth], "o", mfc="white", mec=Ink.VERMILLION, mew=1.6, ms=7)


def _of_counts(counts: np.ndarray, excess: np.ndarray) -> np.ndarray:
    """The least of each count, of which there may be several layouts."""
    return np.array([excess[counts == count].min() for count in np.unique(counts)])


def _ticks(low: float, high: float) -> list[float]:
    """Round numbers on a logarithmic axis, more of them where it is short."""
    steps = (1, 2, 5) if high > 6 * low else (1, 1.25, 1.6, 2, 2.5, 3, 4, 5, 6, 8)
    ticks = np.round(np.outer(10.0 ** np.arange(-3, 4), steps).ravel(), 6)
    return [float(tick) for tick in ticks if 0.99 * low <= tick <= 1.01 * high]
