"""Where a finger on an area locates well and where it cannot, seen from above."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from .._check import FloatArray
from ..design.placement import AreaQuality
from .parts import plain
from .style import BLACK, DOUBLE, MM, VERMILLION, finished, new_figure

__all__ = ["area_placement_figure"]

_SHARE = 0.95
_LEAST, _MOST = 3.0, 300.0
"""Largest over smallest standard deviation that a map's colours tell apart."""


@finished
def area_placement_figure(quality: AreaQuality) -> Figure:
    """Standard errors of position and force over the area that is touched, outlined where touches are ambiguous.

    At each position that of the load which 95 % of the loads there do not exceed.

    Parameters
    ----------
    quality : AreaQuality
        From `subskin.design.placement.area_quality`.

    Examples
    --------
    >>> import subskin as ss
    >>> from subskin.design.placement import area_quality
    >>> array = ss.SensorArray.grid((3, 3), pitch=2e-3, depth=2e-3, noise=1e-3)
    >>> touches = ss.design.Touches(force=1.0, friction=0.5, area=((-2e-3, 2e-3), (-2e-3, 2e-3)))
    >>> found = area_quality(ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array), touches, grid=(9, 6), samples=50)
    >>> area_placement_figure(found).axes[0].get_ylabel()
    'z of the touch [mm]'
    """
    wide = quality.touches.half_width is not None
    figure = new_figure(DOUBLE, 74.0)
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    _map(figure, panels[0], quality, MM * _kept(quality, "position"), "std of the position [mm]")
    if wide:
        _map(figure, panels[1], quality, MM * _kept(quality, "radius"), "std of the radius [mm]")
    else:
        _map(figure, panels[1], quality, 100 * _kept(quality, "force"), "std of the force [%]")
    panels[0].set_ylabel("z of the touch [mm]")
    unsure = 100 * (quality["ambiguous"] + np.nan_to_num(quality["unfelt"]))
    panels[0].set_title(f"position: {_told(MM * quality['position_95'], 'mm')} for 95 %")
    panels[1].set_title(f"unsure: {unsure:.2g} % of touches" if unsure >= 0.01 else "no touch is unsure")
    return figure


def _told(value: float, unit: str) -> str:
    return f"{value:.3g} {unit}" if np.isfinite(value) else "not determined"


def _kept(quality: AreaQuality, name: str) -> FloatArray:
    """Standard deviation that 95 % of the loads at each position keep, (p, p)."""
    values, weight = quality.std[name], quality.weight
    order = np.argsort(values, axis=-1)
    passed = np.cumsum(np.take_along_axis(weight, order, axis=-1), axis=-1)
    at = (passed < _SHARE * passed[..., -1:]).sum(axis=-1)
    return np.asarray(np.take_along_axis(np.take_along_axis(values, order, axis=-1), at[..., None], axis=-1)[..., 0])


def _map(figure: Figure, axes: Axes, quality: AreaQuality, std: FloatArray, label: str) -> None:
    y, z = MM * quality.y, MM * quality.z
    known = std[np.isfinite(std) & (std > 0)]
    low = float(known.min()) if known.size else 1.0
    high = float(np.clip(known.max(initial=low), _LEAST * low, _MOST * low))
    axes.set_facecolor("#EEEEEE")
    shown = axes.pcolormesh(y, z, std.T, norm=LogNorm(low, high), cmap="cividis_r", shading="nearest", rasterized=True)
    unsure = quality.ambiguous.T
    if (unsure >= 0.5).any() and not (unsure >= 0.5).all():
        axes.contour(y, z, unsure, levels=[0.5], colors=[VERMILLION], linewidths=1.2)
    points = MM * np.unique(quality.finger.array.points[quality.finger.array.live], axis=0)
    axes.plot(*points.T, "o", mfc="white", mec=BLACK, mew=0.9, ms=4.5, zorder=3)
    seen = np.concatenate([points, np.stack([y[[0, -1]], z[[0, -1]]], axis=-1)])
    margin = 0.04 * float(np.ptp(seen, axis=0).max())
    axes.set_xlim(seen[:, 0].min() - margin, seen[:, 0].max() + margin)
    axes.set_ylim(seen[:, 1].min() - margin, seen[:, 1].max() + margin)
    axes.set_box_aspect(float((np.ptp(seen[:, 1]) + 2 * margin) / (np.ptp(seen[:, 0]) + 2 * margin)))
    axes.set_xlabel("y of the touch [mm]")
    bar = figure.colorbar(shown, ax=axes, label=label, extend="max" if (std > high).any() else "neither")
    plain(bar.ax.yaxis, subs=(1.0, 2.0, 5.0) if high < 50 * low else (1.0, 3.0))
