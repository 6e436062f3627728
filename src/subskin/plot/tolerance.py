"""What errors cost and what is learnt of them: the costs of tolerances, and a calibration without known touches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import _check
from .._check import FloatArray
from ..calibration import BlindCalibration
from ..design.tolerance import SOURCES, Cost, ToleranceBudget
from ..errors import GeometryError
from .style import DASHED, DOUBLE, NORMAL_95, Ink, finished, legend, new_figure, plain

__all__ = ["blind_figure", "tolerance_figure"]

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
    axes.hlines(row, moved - half, moved + half, color=Ink.BLUE, linewidth=3.2, label="as found")
    axes.hlines(row, moved - least, moved + least, color=Ink.BLACK, linewidth=1.0, label="at best")
    axes.plot(moved, row, "o", color=Ink.BLUE, markersize=4.0, markeredgecolor="white", markeredgewidth=0.5)
    axes.axvline(0.0, color=Ink.GREY, linewidth=0.5, zorder=0.5)
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
    for ratio, name, colour, dash in zip(
        ratios.T, ("position", "angle"), (Ink.BLUE, Ink.ORANGE), ("-", "--"), strict=True
    ):
        if np.isfinite(ratio).all():
            axes.plot(touches, ratio, color=colour, linestyle=dash, label=f"rms error of {name}")
    axes.axvline(used, color=Ink.GREY, linewidth=0.5, zorder=0.5)
    axes.axhline(1.0, color=Ink.GREY, linewidth=0.5, zorder=0.5)
    note: dict[str, Any] = {"va": "top", "color": Ink.GREY, "fontsize": 7}
    axes.annotate(f"{used} used", (used, 1.0), (3, -2), ("data", "axes fraction"), "offset points", **note)
    axes.set(xscale="log", yscale="log", xlabel="touches like those used", ylabel="times a known finger's")
    top = float(np.nanmax(ratios))
    ticks = [t for t in _RATIOS if t < 1.2 * top]
    axes.set_yticks(ticks, [f"{t:g}" for t in ticks])
    axes.minorticks_off()
    axes.set(xlim=(touches[0], touches[-1]), ylim=(0.97, 1.1 * max(top, 1.1)))
    axes.set_title("b  what the finger costs in locating", pad=16)
    axes.legend(ncols=2, **_ABOVE)


_DECADES = 3.5
"""Of the axis, below the largest error: what costs less is as good as nothing."""

_TOTAL = {"total": "root of the sum of squares", "together": "all at once"}
_ROW = 4.9


class _Panel(NamedTuple):
    """Which column of the costs, and how it is labelled."""

    name: str
    scale: float
    label: str


_PANELS = (_Panel("position", 1e3, "error of position [mm]"), _Panel("angle", 180 / np.pi, "error of angle [deg]"))


@finished
def tolerance_figure(budget: ToleranceBudget, position: float | None = None, angle: float | None = None) -> Figure:
    """A bar for each source of error, its rms, and a mark for the worst touch, on logarithmic axes.

    On the left errors of position, on the right those of the angle. With self-calibration, marks show what it leaves of
    each: of the few fingers that were calibrated, which is why an unchanged error need not end with its bar. What costs
    less than about a three-thousandth of the largest has no bar.

    Parameters
    ----------
    budget : ToleranceBudget
        From `subskin.design.tolerance_budget`.
    position, angle : float, optional
        Wanted accuracies [m, rad], drawn as lines.

    Raises
    ------
    InvalidValueError
        A wanted accuracy that is not > 0.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.line(count=8, pitch=2e-3, depth=2e-3, noise=1e-5)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    >>> budget = ss.design.tolerance_budget(finger, ss.design.Touches(force=20.0), {"poisson": 0.05}, draws=20)
    >>> [axes.get_xlabel() for axes in tolerance_figure(budget, position=0.1e-3).axes]
    ['error of position [mm]', 'error of angle [deg]']
    """
    wanted = [
        None if value is None else _check.scalar(name, value, above=0.0, unit=unit)
        for name, value, unit in (("position", position, "m"), ("angle", angle, "rad"))
    ]
    rows = [*budget.rows, budget.total, budget.together]
    figure = new_figure(DOUBLE, 30.0 + _ROW * len(rows))
    panels = figure.subplots(1, 2, sharey=True)
    for axes, panel, goal in zip(panels, _PANELS, wanted, strict=True):
        _bars(axes, panel, rows)
        _recovered(axes, panel, budget)
        _limits(axes, panel, budget, goal)
    panels[0].set_yticks(range(len(rows)), [_text(row) for row in rows])
    panels[0].set_ylim(len(rows) - 0.4, -0.6)
    for axes in panels:
        axes.tick_params(axis="y", length=0)
        axes.axhline(len(budget.rows) - 0.5, color=Ink.GREY, linewidth=0.5)
    count = len(panels[0].get_legend_handles_labels()[1])
    legend(figure, panels[0], first=["rms"], loc="outside upper center", ncols=count, columnspacing=1.4)
    return figure


def _text(row: Cost) -> str:
    """A source and its amount."""
    if row.source in _TOTAL:
        return _TOTAL[row.source]
    text = SOURCES[row.source].text
    if row.unit == "m":
        return f"{text}, {1e3 * row.amount:.2g} mm"
    if row.unit or row.source == "poisson":
        return f"{text}, {row.amount:.2g}"
    return f"{text}, {100 * row.amount:.2g} %"


def _values(panel: _Panel, rows: list[Cost], kind: str) -> FloatArray:
    return panel.scale * np.array([getattr(row, f"{panel.name}_{kind}") for row in rows])


def _bars(axes: Axes, panel: _Panel, rows: list[Cost]) -> None:
    at = np.arange(len(rows))
    summed = np.array([row.source in _TOTAL for row in rows])
    rms, worst = (_values(panel, rows, kind) for kind in ("rms", "worst"))
    axes.set_xscale("log")
    axes.barh(at, rms, height=0.62, color=np.where(summed, Ink.GREY, Ink.BLUE), alpha=0.85, label="rms")
    axes.plot(worst, at, "|", color=Ink.BLACK, markersize=8.0, markeredgewidth=1.2, label="worst touch")
    axes.set_xlabel(panel.label)


def _recovered(axes: Axes, panel: _Panel, budget: ToleranceBudget) -> None:
    """What is left after each kind of self-calibration, beside the source's bar; the last is of all at once."""
    at = {row.source: i for i, row in enumerate(budget.rows)} | {"together": len(budget.rows) + 1}
    looks = (("known", Ink.GREEN, "o", "calibrated at known positions"), ("blind", Ink.ORANGE, "D", "calibrated blind"))
    for name, colour, marker, label in looks:
        found = [(getattr(r, name), at[r.source]) for r in budget.recovered if getattr(r, name) is not None]
        if found:
            left = _values(panel, [cost for cost, _ in found], "rms")
            look: dict[str, Any] = {"color": colour, "ms": 4.5, "mec": "white", "mew": 0.6, "label": label}
            axes.plot(left, [row for _, row in found], marker, **look)


def _limits(axes: Axes, panel: _Panel, budget: ToleranceBudget, goal: float | None) -> None:
    """The wanted accuracy, and an axis of whole numbers in plain figures that leaves out what costs nothing."""
    rows = [*budget.rows, budget.total, budget.together]
    after = [cost for r in budget.recovered for cost in (r.known, r.blind) if cost is not None]
    every = np.concatenate([_values(panel, rows, "rms"), _values(panel, rows, "worst"), _values(panel, after, "rms")])
    every = every[np.isfinite(every) & (every > 0)]
    top = float(every.max()) if every.size else 1.0
    if goal is not None:
        axes.axvline(panel.scale * goal, color=Ink.VERMILLION, linewidth=1.0, linestyle=DASHED, label="wanted")
        top = max(top, panel.scale * goal)
    low = max(top / 10**_DECADES, 0.5 * float(every[every > top / 10**_DECADES].min()) if every.size else 0.0)
    axes.set_xlim(low, 1.6 * top)
    plain(axes.xaxis, subs=(1.0,), small=True)
