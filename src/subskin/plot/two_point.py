"""Two points or one: the least separation that is told; what two sensors confuse, what a third adds (Figs. 18, 19)."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import RectBivariateSpline

from .._check import FloatArray
from ..array import SensorArray
from ..design import Touches, metamers, two_point_limen
from ..design.two_point import TwoPointLimen, TwoPointStudy
from ..errors import GeometryError
from ..finger import Finger
from .memo_lines import UNIT_SKIN
from .style import DASHED, DOUBLE, MM, Ink, finished, heading, legend, new_figure, plain, zero_line

__all__ = ["figure_18", "figure_19", "two_point_figure", "two_point_study_figure"]

_COLOURS = (Ink.VERMILLION, Ink.ORANGE, Ink.GREEN, Ink.SKY, Ink.BLUE, Ink.PINK, Ink.BLACK)
_RIVAL = {"point": "one point", "wide": "one wide contact"}


@finished
def two_point_figure(found: TwoPointLimen) -> Figure:
    """The least separation that reads as two over the position, and the share of touches that do at each separation.

    Parameters
    ----------
    found : TwoPointLimen
        From `subskin.design.two_point_limen`.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=2e-5)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    >>> found = ss.design.two_point_limen(finger, ss.design.Touches(force=40.0), shares=0.5, positions=5)
    >>> [axes.get_ylabel() for axes in two_point_figure(found).axes]
    ['least separation read as two [mm]', 'touches read as two [%]']
    """
    figure = new_figure(DOUBLE, 72.0)
    over_position, told = figure.subplots(1, 2, width_ratios=[1.25, 1.0])
    _over_position(over_position, found)
    _told(told, found)
    title = f"Two points or {_RIVAL[found.against]}, angle {found.angle}"
    heading(figure, title)
    legend(figure, over_position, ncols=4)
    return figure


def _over_position(axes: Axes, found: TwoPointLimen) -> None:
    worst, position = MM * found.separation.max(axis=2), MM * found.position
    order = np.argsort(np.abs(found.share - 0.5), kind="stable")
    equal = worst[:, order[0]]
    ceiling = MM * float(found.step[-1])
    low, high = np.minimum(worst.min(axis=1), ceiling), np.minimum(worst.max(axis=1), ceiling)
    shares = f"shares {found.share.min():.2g} to {found.share.max():.2g} of the force"
    axes.fill_between(position, low, high, color=Ink.SKY, alpha=0.4, linewidth=0, label=shares)
    told = np.where(np.isfinite(equal), equal, np.nan)
    axes.plot(position, told, "o-", color=Ink.BLUE, ms=2.5, label=_split(float(found.share[order[0]])))
    never = position[np.isinf(worst).any(axis=1)]
    if never.size:
        label = f"some read as one within {ceiling:.3g} mm"
        axes.plot(never, np.full(never.size, ceiling), "^", color=Ink.VERMILLION, label=label)
    sensors = MM * np.asarray(found.finger.array.y)[found.finger.array.live]
    axes.set_yscale("log")
    finite = worst[np.isfinite(worst)]
    least = float(finite.min()) if finite.size else ceiling / 10
    axes.set_ylim(0.5 * least, 1.3 * ceiling if never.size or not finite.size else 1.5 * float(finite.max()))
    axes.plot(
        sensors, np.full(sensors.size, 0.58 * least), "o", ms=4, mfc="white", mec=Ink.BLACK, mew=0.9, label="sensors"
    )
    plain(axes.yaxis)
    axes.set(xlabel="middle of the two points [mm]", ylabel="least separation read as two [mm]")


def _split(share: float) -> str:
    return "equal points" if share == 0.5 else f"{share:.2g} of the force on the left"


def _told(axes: Axes, found: TwoPointLimen) -> None:
    """Share of the touches that read as two from each separation on."""
    values = MM * np.sort(found.separation.reshape(-1))
    ends = MM * found.step[[0, -1]]
    x = np.concatenate([ends[:1], values[np.isfinite(values)], ends[1:]])
    y = np.concatenate([[0.0], np.arange(1, x.size - 1), [np.isfinite(values).sum()]]) * 100 / values.size
    axes.step(x, y, where="post", color=Ink.BLUE)
    least = max(0.5 * float(values[0]), float(ends[0])) if np.isfinite(values[0]) else float(ends[1]) / 10
    axes.set(xscale="log", xlim=(least, float(ends[1])), ylim=(0, 105))
    axes.set(xlabel="separation [mm]", ylabel="touches read as two [%]")
    plain(axes.xaxis)


@finished
def two_point_study_figure(study: TwoPointStudy, depth: int = 0, noise: int | None = None) -> Figure:
    """The worst separation against the pitch, a line a count, and against the noise at each one's best pitch.

    Parameters
    ----------
    study : TwoPointStudy
        From `subskin.design.two_point_study`.
    depth : int, optional
        Which of its depths.
    noise : int, optional
        Which of its noises for the left panel; the middle one if left out.

    Raises
    ------
    GeometryError
        More counts than there are colours.

    Examples
    --------
    >>> import subskin as ss
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray(y=[0.0], depth=2e-3))
    >>> touches = ss.design.Touches(force=20.0, span=(-2e-3, 2e-3))
    >>> study = ss.design.two_point_study(finger, touches, count=6, pitch=[0.5, 1.0], noise=1e-3, shares=0.5)
    >>> two_point_study_figure(study).axes[0].get_xlabel()
    'pitch of the sensors [depths]'
    """
    if study.count.size > len(_COLOURS):
        raise GeometryError(
            f"{study.count.size} counts", f"up to {len(_COLOURS)} can be drawn", "a study of fewer counts"
        )
    m = study.noise.size // 2 if noise is None else noise
    relative = study.worst[:, depth] / study.depth[depth]
    figure = new_figure(DOUBLE, 76.0)
    left, right = figure.subplots(1, 2, sharey=True)
    least = relative.min(axis=1)
    relative, least = (
        np.where(np.isfinite(v), v, np.nan) for v in (relative, least)
    )  # lines break where all read as one
    for c, count in enumerate(study.count):
        left.plot(study.pitch, relative[c, :, m], "o-", color=_COLOURS[c], ms=3.0, label=f"{count} sensors")
        right.plot(100 * study.noise, least[c], "o-", color=_COLOURS[c], ms=3.0)
    for axes, x, name in (
        (left, study.pitch, "pitch of the sensors [depths]"),
        (right, 100 * study.noise, "noise [% of full scale]"),
    ):
        axes.set(xscale="log", yscale="log", xlim=(x[0] / 1.1, x[-1] * 1.1), xlabel=name)
        plain(axes.xaxis, _few(x))
        plain(axes.yaxis)
    left.set_ylabel("worst least separation [depths]")
    left.set_title(f"noise {100 * study.noise[m]:.3g} %", fontweight="normal")
    right.set_title("at the best pitch", fontweight="normal")
    title = f"Two points or {_RIVAL[study.against]}"
    heading(figure, title)
    legend(figure, left, ncols=7)
    return figure


def _few(values: FloatArray) -> list[float]:
    """Of the values those that have room for a number beside each other on a logarithmic axis."""
    kept: list[float] = []
    for value in values.tolist():
        if not kept or value > 1.3 * kept[-1]:
            kept.append(value)
    return kept


# One full scale: the strain right beneath a unit point at unit depth; readings are compression in shares of it.
_GAIN = -2 * np.pi / 3
_APART = 0.5
_SENSOR_COLOURS = (Ink.BLUE, Ink.VERMILLION, Ink.GREEN)
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
    for i, colour in zip(range(field.shape[1]), _SENSOR_COLOURS, strict=False):
        axes.plot(y, field[:, i], color=colour, label=f"sensor {i + 1}")
        axes.plot(np.asarray(finger.array.y)[i], -0.28, "o", ms=4, mfc="white", mec=colour, mew=1.0)
    for position, size in zip(_POINTS, _FORCES, strict=True):
        _arrow(axes, float(position), float(size), Ink.BLACK)
    _arrow(axes, one, force, Ink.ORANGE)
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
    axes.plot(*curve.T, color=Ink.GREY)
    marks = np.arange(-1.0, 1.01, 0.5)
    at = finger.receptive_field(marks)[..., 0]
    axes.plot(*at.T, "o", ms=2.5, color=Ink.GREY)
    for mark, (a, b), (da, db) in zip(marks, at, _BESIDE, strict=True):
        axes.text(a + da, b + db, f"{mark:g}", fontsize=6.5, color=Ink.GREY, ha="center", va="center")
    tips = _FORCES[:, None] * finger.receptive_field(_POINTS)[..., 0]
    whole = tips.sum(axis=0)
    for tip, tail in ((tips[0], (0.0, 0.0)), (whole, tips[0])):
        axes.annotate("", tip, tail, arrowprops={**_ARROW, "color": Ink.BLACK, "mutation_scale": 7})
    axes.plot([0.0, 1.15 * whole[0]], [0.0, 1.15 * whole[1]], color=Ink.ORANGE, linestyle=DASHED, zorder=1)
    axes.plot(*(finger.receptive_field(one)[..., 0]), "o", color=Ink.ORANGE, ms=5, zorder=3)
    zero_line(axes)
    axes.axvline(0.0, color=Ink.GREY, linewidth=0.5, zorder=0.5)
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
    for shift, values, colour in ((-0.18, two, Ink.BLACK), (0.18, single, Ink.ORANGE)):
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
    for factor, colour, name in ((10.0, "#CFE3F1", "noise 1 %"), (1.0, Ink.BLUE, "noise 0.1 %")):
        axes.contourf(position, np.exp(step), square / factor**2, levels=[-np.inf, 1.0], colors=[colour])
        axes.fill_between([], [], color=colour, linewidth=0, label=f"read as one, {name} of full scale")
    axes.plot(finger.array.y, [0.035] * 3, "o", ms=4, mfc="white", mec=Ink.BLACK, mew=0.9, label="sensors")
    axes.set_yscale("log")
    plain(axes.yaxis, [0.05, 0.1, 0.2, 0.5, 1.0, 2.0])
    axes.set(xlim=(-2.5, 2.5), ylim=(0.028, 2.0), xticks=[-2, -1, 0, 1, 2])
    axes.set_xlabel("middle of two equal points [depths]")
    axes.set_title(f"Pitch {pitch:g}", fontweight="normal")
