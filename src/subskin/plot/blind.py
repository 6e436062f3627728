"""What unlabelled touches taught of a finger: each number as drawn and as found, and how more touches would help."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..calibration import BlindCalibration
from ..errors import GeometryError
from .style import BLACK, BLUE, DOUBLE, GREY, NORMAL_95, ORANGE, finished, new_figure

__all__ = ["blind_figure"]

_PALE = "#D9D9D9"
_ABOVE: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "columnspacing": 1.2}
_RATIOS = (1.0, 1.1, 1.3, 2.0, 5.0, 10.0, 30.0, 100.0, 1000.0)


@finished
def blind_figure(found: BlindCalibration, names: Sequence[str] | None = None) -> Figure:
    """Each fitted number before and after, and the standard deviations against the number of touches.

    On the left: the 95 % interval of the drawing (grey), what is found with its own (blue), and what endless touches
    would leave (black), all about the drawn value and in the drawing's standard deviations. On the right: by how much
    the uncertain finger raises the errors of positions and angles, by the number of touches (`error_ratio`).

    Parameters
    ----------
    found : BlindCalibration
        From `subskin.calibrate_blind`.
    names : sequence of str, optional
        Names of the sensors; their numbers by default.

    Raises
    ------
    GeometryError
        Names that are not one for each sensor.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=5e-5)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    >>> touch = ss.LineLoad(force=80.0, position=np.linspace(-3e-3, 3e-3, 30))
    >>> figure = blind_figure(ss.calibrate_blind(finger, finger.read(touch, np.random.default_rng(0)), friction=0))
    >>> figure.axes[1].get_xlabel()
    'touches like those used'
    """
    sensors = len(found.health)
    called = [str(i) for i in range(sensors)] if names is None else list(names)
    if len(called) != sensors:
        raise GeometryError(
            f"{len(called)} names", f"one for each of the {sensors} sensors is needed", "a name for each sensor"
        )
    figure = new_figure(DOUBLE, max(62.0, 20.0 + 4.6 * len(found.parameters)))
    left, right = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
    _intervals(left, found, called)
    _progress(right, found)
    return figure


def _intervals(axes: Axes, found: BlindCalibration, called: list[str]) -> None:
    prior = np.array([p.prior for p in found.parameters])
    moved = np.array([p.value - p.drawn for p in found.parameters]) / prior
    half = NORMAL_95 * np.array([p.std for p in found.parameters]) / prior
    least = NORMAL_95 * np.array([p.limit for p in found.parameters]) / prior
    row = np.arange(len(prior))
    axes.barh(row, 2 * NORMAL_95, left=-NORMAL_95, height=0.62, color=_PALE, label="as drawn")
    axes.hlines(row, moved - half, moved + half, color=BLUE, linewidth=3.2, label="as found")
    axes.hlines(row, moved - least, moved + least, color=BLACK, linewidth=1.0, label="at best")
    axes.plot(moved, row, "o", color=BLUE, markersize=4.0, markeredgecolor="white", markeredgewidth=0.5)
    axes.axvline(0.0, color=GREY, linewidth=0.5, zorder=0.5)
    texts = [p.name if p.sensor is None else f"{p.name} {called[p.sensor]}" for p in found.parameters]
    axes.set_yticks(row, texts)
    axes.set_ylim(len(prior) - 0.4, -0.6)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("off the drawn value, in its standard deviations")
    axes.set_title("a  each number, 95 % intervals", pad=16)
    handles, labels = axes.get_legend_handles_labels()
    order = [labels.index(name) for name in ("as drawn", "as found", "at best")]
    axes.legend([handles[i] for i in order], [labels[i] for i in order], ncols=3, **_ABOVE)


def _progress(axes: Axes, found: BlindCalibration) -> None:
    used = int(found.used.sum())
    touches = np.geomspace(max(used / 30, 2), 100 * used, 60)
    ratios = np.array([(r.position, r.angle) for r in map(found.error_ratio, touches)])
    for ratio, name, colour, dash in zip(ratios.T, ("position", "angle"), (BLUE, ORANGE), ("-", "--"), strict=True):
        if np.isfinite(ratio).all():
            axes.plot(touches, ratio, color=colour, linestyle=dash, label=f"rms error of {name}")
    axes.axvline(used, color=GREY, linewidth=0.5, zorder=0.5)
    axes.axhline(1.0, color=GREY, linewidth=0.5, zorder=0.5)
    note: dict[str, Any] = {"va": "top", "color": GREY, "fontsize": 7}
    axes.annotate(f"{used} used", (used, 1.0), (3, -2), ("data", "axes fraction"), "offset points", **note)
    axes.set(xscale="log", yscale="log", xlabel="touches like those used", ylabel="times a known finger's")
    top = float(np.nanmax(ratios))
    ticks = [t for t in _RATIOS if t < 1.2 * top]
    axes.set_yticks(ticks, [f"{t:g}" for t in ticks])
    axes.minorticks_off()
    axes.set(xlim=(touches[0], touches[-1]), ylim=(0.97, 1.1 * max(top, 1.1)))
    axes.set_title("b  what the finger costs in locating", pad=16)
    axes.legend(ncols=2, **_ABOVE)
