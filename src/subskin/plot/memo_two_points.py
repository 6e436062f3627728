"""The memo's figures on two points: what two sensors confuse (Fig. 18), what a third sensor adds (Fig. 19)."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import RectBivariateSpline

from .._check import FloatArray
from ..array import SensorArray
from ..design import Touches, metamers, two_point_limen
from ..finger import Finger
from .memo_lines import UNIT_SKIN
from .parts import heading, legend, plain, zero_line
from .style import BLACK, BLUE, DASHED, DOUBLE, GREEN, GREY, ORANGE, VERMILLION, new_figure

__all__ = ["figure_18", "figure_19"]

# One full scale: the strain right beneath a unit point at unit depth; readings are compression in shares of it.
_GAIN = -2 * np.pi / 3
_APART = 0.5
_COLOURS = (BLUE, VERMILLION, GREEN)
_POINTS, _FORCES = np.array([-0.75, 0.6]), np.array([0.8, 0.5])
_REACH = 3.0
_NOISE = 1e-3
_ARROW: dict[str, Any] = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0}
_BESIDE = ((0.0, -0.07), (0.04, 0.13), (0.09, 0.09), (0.14, 0.02), (0.1, 0.0))
"""Where the number of each marked position stands beside the curve."""


def _finger(sensors: FloatArray) -> Finger:
    return Finger(UNIT_SKIN, SensorArray(y=sensors, depth=1.0, gain=_GAIN, noise=_NOISE))


def figure_18() -> Figure:
    """Two sensors: two points and the one that reads the same; where they are, and for which points there is one."""
    finger = _finger(np.array([-1.0, 1.0]) * _APART)
    one, force = _metamer(finger)
    figure = new_figure(DOUBLE, 70.0)
    channels, plane, positions = figure.subplots(1, 3, width_ratios=[1.25, 1.0, 1.0])
    _channels(channels, finger, one, force)
    _plane(plane, finger, one, force)
    _positions(positions, figure, finger)
    for axes, title in zip((channels, plane, positions), ("Channels", "Readings", "Equal points"), strict=True):
        axes.set_title(title, fontweight="normal")
    heading(figure, "Two sensors: two points (black) and the one that reads the same (orange)")
    return figure


def _metamer(pair: Finger) -> tuple[float, float]:
    """Position and force of the single point that two sensors take for the two: of several the one nearest them."""
    same = metamers(pair, _POINTS, _FORCES, search=(-_REACH, _REACH))
    nearest = int(np.nanargmin(np.abs(same.position)))
    return float(same.position[nearest]), float(same.force[nearest])


def _channels(axes: Axes, finger: Finger, one: float, force: float) -> None:
    """Each sensor's reading against the position of a unit point; the points as arrows from above."""
    y = np.linspace(-_REACH, _REACH, 601)
    field = finger.receptive_field(y)[..., 0]
    zero_line(axes)
    for i, colour in zip(range(field.shape[1]), _COLOURS, strict=False):
        axes.plot(y, field[:, i], color=colour, label=f"sensor {i + 1}")
        axes.plot(np.asarray(finger.array.y)[i], -0.28, "o", ms=4, mfc="white", mec=colour, mew=1.0)
    for position, size in zip(_POINTS, _FORCES, strict=True):
        _arrow(axes, float(position), float(size), BLACK)
    _arrow(axes, one, force, ORANGE)
    axes.set(xlim=(-_REACH, _REACH), ylim=(-0.36, 2.5), yticks=[0.0, 0.5, 1.0])
    axes.set(xlabel="position of a point [depths]", ylabel="reading [full scale]")
    axes.spines["left"].set_bounds(-0.36, 1.1)
    axes.legend(loc="upper right")


def _arrow(axes: Axes, position: float, force: float, colour: str) -> None:
    """A force on the skin, as long as it is large."""
    look = {**_ARROW, "color": colour, "linewidth": 1.4, "mutation_scale": 8}
    axes.annotate("", (position, 1.12), (position, 1.12 + force), arrowprops=look)


def _plane(axes: Axes, finger: Finger, one: float, force: float) -> None:
    """The curve of a unit point in the plane of the two readings; the sum of two, and its ray."""
    y = np.linspace(-_REACH, _REACH, 601)
    curve = finger.receptive_field(y)[..., 0]
    axes.plot(*curve.T, color=GREY)
    marks = np.arange(-1.0, 1.01, 0.5)
    at = finger.receptive_field(marks)[..., 0]
    axes.plot(*at.T, "o", ms=2.5, color=GREY)
    for mark, (a, b), (da, db) in zip(marks, at, _BESIDE, strict=True):
        axes.text(a + da, b + db, f"{mark:g}", fontsize=6.5, color=GREY, ha="center", va="center")
    tips = _FORCES[:, None] * finger.receptive_field(_POINTS)[..., 0]
    whole = tips.sum(axis=0)
    for tip, tail in ((tips[0], (0.0, 0.0)), (whole, tips[0])):
        axes.annotate("", tip, tail, arrowprops={**_ARROW, "color": BLACK, "mutation_scale": 7})
    axes.plot([0.0, 1.15 * whole[0]], [0.0, 1.15 * whole[1]], color=ORANGE, linestyle=DASHED, zorder=1)
    axes.plot(*(finger.receptive_field(one)[..., 0]), "o", color=ORANGE, ms=5, zorder=3)
    zero_line(axes)
    axes.axvline(0.0, color=GREY, linewidth=0.5, zorder=0.5)
    axes.set_aspect("equal")
    axes.set(xlim=(-0.25, 1.1), ylim=(-0.25, 1.1), xticks=[0, 0.5, 1], yticks=[0, 0.5, 1])
    axes.set(xlabel="sensor 1 [full scale]", ylabel="sensor 2 [full scale]")


def _positions(axes: Axes, figure: Figure, finger: Finger) -> None:
    """The position of the one that reads as two equal points do, over the positions of these."""
    y = np.linspace(-2.0, 2.0, 81)
    left, right = np.meshgrid(y, y)
    both = np.stack([left, right], axis=-1)
    same = metamers(finger, both, search=(-_REACH, _REACH))
    # where there are several, the one nearest the points' middle
    far = np.abs(same.position - both.mean(axis=-1, keepdims=True))
    at = np.argmin(np.where(np.isfinite(far), far, np.inf), axis=-1)[..., None]
    position = np.take_along_axis(same.position, at, axis=-1)[..., 0]
    image = axes.pcolormesh(y, y, position, cmap="RdBu_r", vmin=-2, vmax=2, shading="nearest", rasterized=True)
    axes.set_aspect("equal")
    ticks = [-2, -1, 0, 1, 2]
    axes.set(xlabel="one point [depths]", ylabel="other point [depths]", xticks=ticks, yticks=ticks)
    figure.colorbar(image, ax=axes, ticks=ticks, aspect=25, shrink=0.9, label="reads as one at [depths]")


def figure_19() -> Figure:
    """Three sensors: what the third says of the pair's metamer, and which separations read as two along the skin."""
    pair, three = _finger(np.array([-1.0, 1.0]) * _APART), _finger(np.array([-1.0, 1.0, 0.0]) * _APART)
    one, force = _metamer(pair)
    figure = new_figure(DOUBLE, 122.0)
    grid = figure.add_gridspec(2, 1, height_ratios=[1.0, 0.95])
    upper = grid[0].subgridspec(1, 2, width_ratios=[1.9, 1.0])
    channels, readings = figure.add_subplot(upper[0]), figure.add_subplot(upper[1])
    _channels(channels, three, one, force)
    _readings(readings, three, one, force)
    channels.set_title("Channels", fontweight="normal")
    readings.set_title("Readings", fontweight="normal")
    lower = grid[1].subgridspec(1, 3)
    first = figure.add_subplot(lower[0])
    maps = [first, *(figure.add_subplot(lower[i], sharex=first, sharey=first) for i in (1, 2))]
    for axes, pitch in zip(maps, (_APART, 1.0, 2.0), strict=True):
        _hidden(axes, pitch)
        axes.tick_params(labelleft=axes is first)
    first.set_ylabel("separation [depths]")
    heading(figure, "Three sensors: two points (black) and the one that sensors 1 and 2 take for them (orange)")
    legend(figure, first, ncols=3)
    return figure


def _readings(axes: Axes, finger: Finger, one: float, force: float) -> None:
    two = _FORCES @ finger.receptive_field(_POINTS)[..., 0]
    single = force * finger.receptive_field(one)[..., 0]
    x = np.arange(two.size)
    for shift, values, colour in ((-0.18, two, BLACK), (0.18, single, ORANGE)):
        axes.bar(x + shift, values, width=0.34, color=colour)
    axes.set_xticks(x, [f"{i + 1}" for i in x])
    axes.set(xlabel="sensor", ylabel="reading [full scale]")


def _hidden(axes: Axes, pitch: float) -> None:
    """Where two equal points read as one, at two noises."""
    finger = _finger(np.array([-1.0, 0.0, 1.0]) * pitch)
    found = two_point_limen(finger, Touches(1.0, span=(-2.5, 2.5)), shares=0.5, positions=161, largest=2.0)
    # the square of a distance that passes through 0 is smooth there: drawn finer than it was computed
    square = (found.distance[:, :, 0, 0] / found.needed) ** 2
    step, position = (np.linspace(v[0], v[-1], 4 * v.size) for v in (np.log(found.step), found.position))
    square = RectBivariateSpline(np.log(found.step), found.position, square)(step, position)
    for factor, colour, name in ((10.0, "#CFE3F1", "noise 1 %"), (1.0, BLUE, "noise 0.1 %")):
        axes.contourf(position, np.exp(step), square / factor**2, levels=[-np.inf, 1.0], colors=[colour])
        axes.fill_between([], [], color=colour, linewidth=0, label=f"read as one, {name} of full scale")
    axes.plot(finger.array.y, [0.035] * 3, "o", ms=4, mfc="white", mec=BLACK, mew=0.9, label="sensors")
    axes.set_yscale("log")
    plain(axes.yaxis, [0.05, 0.1, 0.2, 0.5, 1.0, 2.0])
    axes.set(xlim=(-2.5, 2.5), ylim=(0.028, 2.0), xticks=[-2, -1, 0, 1, 2])
    axes.set_xlabel("middle of two equal points [depths]")
    axes.set_title(f"Pitch {pitch:g}", fontweight="normal")
