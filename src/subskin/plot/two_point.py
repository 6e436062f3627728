"""Two points or one: the least separation that is told, over the place, and over spacing, count and noise."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, LogLocator, NullLocator

from .._check import FloatArray
from ..design.two_point import TwoPointLimen, TwoPointStudy
from ..errors import GeometryError
from .style import BLACK, BLUE, DOUBLE, GREEN, ORANGE, PINK, SKY, VERMILLION, house_style, new_figure, settled

__all__ = ["two_point_figure", "two_point_study_figure"]

_COLOURS = (VERMILLION, ORANGE, GREEN, SKY, BLUE, PINK, BLACK)
_RIVAL = {"point": "one point", "wide": "one wide contact"}


def two_point_figure(found: TwoPointLimen) -> Figure:
    """The least separation that is told over the place, and the share of touches told at each separation.

    Parameters
    ----------
    found : TwoPointLimen
        From `subskin.design.two_point_limen`.
    """
    with house_style():
        figure = new_figure(DOUBLE, 72.0)
        over_position, told = figure.subplots(1, 2, width_ratios=[1.25, 1.0])
        _over_position(over_position, found)
        _told(told, found)
        title = f"Two points told from {_RIVAL[found.against]}, angle {found.angle}"
        figure.suptitle(title, fontsize=8, fontweight="bold", x=0.01, ha="left")
        figure.legend(*over_position.get_legend_handles_labels(), loc="outside lower center", ncols=4)
        return settled(figure)


def _over_position(axes: Axes, found: TwoPointLimen) -> None:
    mm = 1e3
    worst, position = found.separation.max(axis=2) * mm, found.position * mm
    order = np.argsort(np.abs(found.share - 0.5), kind="stable")
    equal = worst[:, order[0]]
    ceiling = float(found.step[-1]) * mm
    axes.fill_between(
        position,
        np.minimum(worst.min(axis=1), ceiling),
        np.minimum(worst.max(axis=1), ceiling),
        color=SKY,
        alpha=0.4,
        linewidth=0,
        label=f"shares {found.share.min():.2g} to {found.share.max():.2g} of the force",
    )
    axes.plot(
        position,
        np.where(np.isfinite(equal), equal, np.nan),
        color=BLUE,
        marker="o",
        ms=2.5,
        label=_split(found, order[0]),
    )
    never = np.isinf(worst).any(axis=1)
    if never.any():
        axes.plot(
            position[never],
            np.full(int(never.sum()), ceiling),
            "^",
            color=VERMILLION,
            label=f"some not told within {ceiling:.3g} mm",
        )
    sensors = np.asarray(found.finger.array.y)[found.finger.array.live] * mm
    axes.set_yscale("log")
    finite = worst[np.isfinite(worst)]
    low = float(finite.min()) if finite.size else ceiling / 10
    axes.set_ylim(0.5 * low, 1.3 * ceiling if never.any() or not finite.size else 1.5 * float(finite.max()))
    axes.plot(sensors, np.full(sensors.size, 0.58 * low), "o", ms=4, mfc="white", mec=BLACK, mew=0.9, label="sensors")
    _plain(axes)
    axes.set(xlabel="middle of the two points [mm]", ylabel="least separation told [mm]")


def _split(found: TwoPointLimen, at: int) -> str:
    share = float(found.share[at])
    return "equal points" if share == 0.5 else f"{share:.2g} of the force on the left"


def _told(axes: Axes, found: TwoPointLimen) -> None:
    """Share of the touches told from each separation on."""
    values = np.sort(found.separation.reshape(-1)) * 1e3
    ends = found.step[[0, -1]] * 1e3
    x = np.concatenate([ends[:1], values[np.isfinite(values)], ends[1:]])
    y = np.concatenate([[0.0], np.arange(1, x.size - 1), [np.isfinite(values).sum()]]) * 100 / values.size
    axes.step(x, y, where="post", color=BLUE)
    least = max(0.5 * float(values[0]), float(ends[0])) if np.isfinite(values[0]) else float(ends[1]) / 10
    axes.set_xscale("log")
    axes.set_xlim(least, float(ends[1]))
    _plain(axes, axis="x")
    axes.set_ylim(0, 105)
    axes.set(xlabel="separation [mm]", ylabel="touches told [%]")


def two_point_study_figure(study: TwoPointStudy, depth: int = 0, noise: int | None = None) -> Figure:
    """The worst separation against the spacing, a line a count, and against the noise at each one's best spacing.

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
    """
    if study.count.size > len(_COLOURS):
        raise GeometryError(f"{study.count.size} counts", f"up to {len(_COLOURS)} can be told apart")
    m = study.noise.size // 2 if noise is None else noise
    relative = study.worst[:, depth] / study.depth[depth]
    with house_style():
        figure = new_figure(DOUBLE, 76.0)
        left, right = figure.subplots(1, 2, sharey=True)
        for c, count in enumerate(study.count):
            look = {"color": _COLOURS[c], "marker": "o", "ms": 3.0}
            _line(left, study.pitch, relative[c, :, m], f"{count} sensors", look)
            _line(right, 100 * study.noise, relative[c].min(axis=0), "", look)
        for axes, x, name in (
            (left, study.pitch, "spacing of the sensors [depths]"),
            (right, 100 * study.noise, "noise [% of full scale]"),
        ):
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_xlim(x[0] / 1.1, x[-1] * 1.1)
            axes.set_xlabel(name)
            _plain(axes)
        left.xaxis.set_major_locator(FixedLocator(_few(study.pitch)))
        right.xaxis.set_major_locator(FixedLocator(_few(100 * study.noise)))
        for axes in (left, right):
            axes.xaxis.set_minor_locator(NullLocator())
            axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        left.set_ylabel("worst least separation [depths]")
        left.set_title(f"noise {100 * study.noise[m]:.3g} %", fontweight="normal")
        right.set_title("at the best spacing", fontweight="normal")
        title = f"Two points told from {_RIVAL[study.against]}"
        figure.suptitle(title, fontsize=8, fontweight="bold", x=0.01, ha="left")
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=7)
        return settled(figure)


def _line(axes: Axes, x: FloatArray, y: FloatArray, name: str, look: dict[str, object]) -> None:
    """A line that breaks where nothing is told."""
    axes.plot(x, np.where(np.isfinite(y), y, np.nan), label=name or None, **look)  # type: ignore[arg-type]


def _few(values: FloatArray) -> list[float]:
    """Of the values those that have room for a number beside each other on a logarithmic axis."""
    kept: list[float] = []
    for value in values.tolist():
        if not kept or value > 1.3 * kept[-1]:
            kept.append(value)
    return kept


def _plain(axes: Axes, axis: str = "y") -> None:
    """Numbers, not powers of ten, at 1, 2 and 5."""
    one = axes.yaxis if axis == "y" else axes.xaxis
    one.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    one.set_minor_locator(NullLocator())
    one.set_major_formatter(lambda value, _: f"{value:g}")
