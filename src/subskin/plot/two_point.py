"""Two points or one: the least separation that is told, over the position, and over pitch, count and noise."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .._check import FloatArray
from ..design.two_point import TwoPointLimen, TwoPointStudy
from ..errors import GeometryError
from .parts import heading, legend, plain
from .style import BLACK, BLUE, DOUBLE, GREEN, MM, ORANGE, PINK, SKY, VERMILLION, finished, new_figure

__all__ = ["two_point_figure", "two_point_study_figure"]

_COLOURS = (VERMILLION, ORANGE, GREEN, SKY, BLUE, PINK, BLACK)
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
    axes.fill_between(position, low, high, color=SKY, alpha=0.4, linewidth=0, label=shares)
    told = np.where(np.isfinite(equal), equal, np.nan)
    axes.plot(position, told, "o-", color=BLUE, ms=2.5, label=_split(float(found.share[order[0]])))
    never = position[np.isinf(worst).any(axis=1)]
    if never.size:
        label = f"some read as one within {ceiling:.3g} mm"
        axes.plot(never, np.full(never.size, ceiling), "^", color=VERMILLION, label=label)
    sensors = MM * np.asarray(found.finger.array.y)[found.finger.array.live]
    axes.set_yscale("log")
    finite = worst[np.isfinite(worst)]
    least = float(finite.min()) if finite.size else ceiling / 10
    axes.set_ylim(0.5 * least, 1.3 * ceiling if never.size or not finite.size else 1.5 * float(finite.max()))
    axes.plot(sensors, np.full(sensors.size, 0.58 * least), "o", ms=4, mfc="white", mec=BLACK, mew=0.9, label="sensors")
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
    axes.step(x, y, where="post", color=BLUE)
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
