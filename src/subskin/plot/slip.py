"""How close to slipping: the load in the friction cone, and what of the contact sticks."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from .. import _check
from .._check import FloatArray
from ..decide import Slip, SlipVerdict, least_force
from ..errors import GeometryError
from ..estimate import Status
from .parts import zero_line
from .style import BLACK, BLUE, GREEN, GREY, NORMAL_95, VERMILLION, finished, new_figure

__all__ = ["slip_figure"]

_CHI2_95 = 5.991465
"""Chi-square of two unknowns that 95 % stay below."""
_HOLDS, _SLIDES = "#E6F2EC", "#FBE9E0"
_GRID = 121


@finished
def slip_figure(judged: Slip, frame: int | tuple[int, ...] = (), probability: float = 1e-3) -> Figure:
    """The load found in the plane of (N, T), with the friction cone, and the zones of stick and slip beneath.

    Shaded: the cone, by the 2.5 %, 50 % and 97.5 % quantiles of friction. Contours: the probability of slip that a load
    found there would have. The arrow: to the least normal force that keeps it at `probability`.

    Parameters
    ----------
    judged : Slip
        From `subskin.decide.slip`.
    frame : int or tuple of int, optional
        Which frame of a batch.
    probability : float, optional
        The probability of slip that the least normal force is for.

    Raises
    ------
    GeometryError
        A frame that is not in the batch, or none given for a batch.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=2e-4)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    >>> found = finger.locate(finger.read(ss.LineLoad(force=40.0, angle=0.1), np.random.default_rng(1)))
    >>> figure = slip_figure(ss.decide.slip(found, ss.decide.Friction.between(0.4, 0.6)))
    >>> figure.axes[0].get_xlabel()
    'normal force $N$ [N/m]'
    """
    index = (frame,) if isinstance(frame, int) else tuple(frame)
    if len(index) != len(judged.shape) or any(not -n <= i < n for i, n in zip(index, judged.shape, strict=True)):
        raise GeometryError(f"frame = {frame!r} of a batch of shape {judged.shape}", "one frame is drawn", "frame=0")
    bound = _check.scalar("probability", probability, above=0.0, at_most=0.5)
    figure = new_figure(130, 110)
    plane, zone = figure.subplots(2, 1, height_ratios=(2.6, 1.0))
    if np.isnan(judged.probability[index]):
        status = Status(int(judged.status[index])).name.lower().replace("_", " ")
        plane.set_title(f"cannot tell: {status}")
        _cone(plane, judged, index, 40.0, 20.0)
        zone.axis("off")
    else:
        _plane(plane, judged, index, bound)
        _zone(zone, judged, index)
    unit = judged.estimate.force_unit
    plane.set(xlabel=f"normal force $N$ [{unit}]", ylabel=f"tangential force $T$ [{unit}]")
    return figure


def _quantiles(judged: Slip, index: tuple[int, ...]) -> FloatArray:
    """Of the friction of one frame: 2.5, 50 and 97.5 %."""
    values = judged.friction.quantile([0.025, 0.5, 0.975])
    return np.asarray(np.broadcast_to(values, (*judged.shape, 3))[index])


def _cone(axes: Axes, judged: Slip, index: tuple[int, ...], most: float, high: float) -> None:
    low, middle, steep = _quantiles(judged, index)
    n = np.array([0.0, most])
    axes.fill_between(n, -low * n, low * n, color=_HOLDS, lw=0, zorder=0)
    for side in (1, -1):
        axes.fill_between(n, side * steep * n, side * max(high, steep * most), color=_SLIDES, lw=0, zorder=0)
        label = "cone, by its median" if side > 0 else None
        axes.plot(n, side * middle * n, color=BLACK, lw=1.0, label=label)
    axes.set(xlim=(0, most), ylim=(-high, high))
    zero_line(axes)


def _plane(axes: Axes, judged: Slip, index: tuple[int, ...], bound: float) -> None:
    normal, tangential = float(judged.normal[index]), float(judged.tangential[index])
    found = replace(judged.estimate, friction=np.inf)  # drawn on the cone's edge as well
    least = float(np.asarray(least_force(found, judged.friction, bound))[index])
    covariance = judged.covariance[index]
    half = 2.5 * np.sqrt(np.diag(covariance))
    reach = least if np.isfinite(least) and least < 4 * normal else 0.0
    most = 1.25 * max(normal + half[0], reach)
    high = 1.2 * max(abs(tangential) + half[1], float(_quantiles(judged, index)[1]) * normal)
    low = -0.35 * high
    _cone(axes, judged, index, most, high)
    axes.set_ylim((low, high) if tangential >= 0 else (-high, -low))
    bottom, top = axes.get_ylim()
    n, t = np.meshgrid(np.linspace(0, most, _GRID), np.linspace(bottom, top, _GRID))
    chance = judged.probability_at(index, n, t)
    for level, line in ((0.1, "-."), (bound, "--")):
        axes.contour(n, t, chance, [level], colors=VERMILLION, linewidths=0.9, linestyles=[line])
        axes.plot([], [], color=VERMILLION, lw=0.9, ls=line, label=f"slips with {100 * level:.3g} %")
    values, vectors = np.linalg.eigh(covariance)
    width, height = 2 * np.sqrt(_CHI2_95 * np.maximum(values[::-1], 0.0))
    turn = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
    ring: dict[str, Any] = {"facecolor": BLUE, "alpha": 0.25, "lw": 0, "zorder": 3}
    axes.add_patch(Ellipse((normal, tangential), float(width), float(height), angle=turn, **ring))
    axes.plot(normal, tangential, "o", color=BLUE, zorder=4, label="load found, 95 %")
    edge = np.sign(tangential or 1.0) * float(judged.margin[index] + abs(tangential))
    axes.plot([normal, normal], [tangential, edge], color=BLUE, lw=0.9, ls=":", zorder=3)
    beside = 0.5 * np.sqrt(_CHI2_95 * covariance[0, 0]) + 0.02 * most
    margin = f"{judged.margin[index]:.2g}".replace("-", "−")
    text = f"margin {margin} ± {NORMAL_95 * float(judged.margin_std[index]):.2g} {judged.estimate.force_unit}"
    white = {"facecolor": "w", "alpha": 0.75, "lw": 0, "pad": 1.0}
    note: dict[str, Any] = {"fontsize": 7, "bbox": white, "zorder": 3.2}
    axes.text(normal - beside, 0.5 * (tangential + edge), text, color=BLUE, ha="right", va="center", **note)
    if reach:
        arrow: dict[str, Any] = {"arrowstyle": "-|>", "color": GREEN, "lw": 1.2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=(least, tangential), xytext=(normal, tangential), arrowprops=arrow, zorder=3.5)
        up = tangential < 0
        position = tangential + (0.06 if up else -0.06) * (top - bottom)
        text = f"least for {100 * bound:.3g} %: {least:.3g} {judged.estimate.force_unit}"
        ha, away = ("left", beside) if least > normal else ("right", -beside)
        axes.text(normal + away, position, text, color=GREEN, ha=ha, va="bottom" if up else "top", **note)
    axes.legend(loc="upper left" if tangential >= 0 else "lower left")
    verdict = SlipVerdict(int(judged.verdict[index])).name.lower().replace("_", " ")
    axes.set_title(f"{verdict}: probability of slip {_percent(float(judged.probability[index]))}")


def _zone(axes: Axes, judged: Slip, index: tuple[int, ...]) -> None:
    """Pressure times friction, and shear, in units of the mean of the first; the zones as a bar beneath."""
    stick = float(judged.stick[index])
    if np.isnan(stick):
        axes.axis("off")
        axes.set_title("no stick zone: a line, or a solver that did not settle")
        return
    y = np.linspace(-1, 1, 1602)[1:-1]  # not at 0, where a wedge's pressure is infinite
    if judged.bodies is None:
        held, drag = _tractions(judged.contact, y, stick, float(np.minimum(judged.ratio[index], 1.0)))
        axes.plot(y, held, color=GREY, lw=0.9, ls="--", label="what friction holds, $\\mu\\,p$")
        axes.plot(y, drag, color=BLACK, label="shear, $|q|$")
        axes.legend(loc="upper right", bbox_to_anchor=(1.0, 1.1))
    low, high = judged.stick_interval[index]
    axes.barh(-0.25, 2, 0.22, left=-1, color=VERMILLION, alpha=0.55, lw=0)
    axes.barh(-0.25, 2 * stick, 0.22, left=-stick, color=GREEN, lw=0)
    axes.plot([[-high, -low, low, high]] * 2, [[-0.4] * 4, [-0.1] * 4], color=BLACK, lw=0.9)
    axes.text(1.03, -0.25, "slips", color=VERMILLION, va="center", fontsize=7)
    if stick > 0.15:
        axes.text(0, -0.25, "sticks", color="w", ha="center", va="center", fontsize=7)
    axes.set(xlim=(-1.45, 1.45), ylim=(-0.45, 2.0), yticks=[0, 1, 2])
    axes.set(xlabel="position in the contact, $y/a$", ylabel="traction / mean")
    sticks = f"sticks over {stick:.2f} of the contact, 95 % in {low:.2f} to {high:.2f}"
    axes.set_title("slides all over" if stick == 0 else sticks, fontweight="normal")


def _tractions(contact: str, y: FloatArray, stick: float, ratio: float) -> tuple[FloatArray, FloatArray]:
    """What friction holds and |q| along the contact, in units of the mean of the first."""

    def hertz(a: float) -> FloatArray:
        return np.asarray(4 / np.pi * np.sqrt(np.maximum(a * a - y * y, 0.0)))

    def wedge(a: float) -> FloatArray:
        return np.asarray(2 / np.pi * np.arccosh(np.maximum(a / np.maximum(np.abs(y), 1e-12), 1.0)))

    if contact == "punch":
        held = 2 / (np.pi * np.sqrt(1 - y * y))
        return held, ratio * held
    shape = hertz if contact == "hertz" else wedge
    return shape(1.0), shape(1.0) - shape(stick)


def _percent(share: float) -> str:
    """A probability for people: never 1e+02 %."""
    return f"{100 * share:.2g} %" if share < 0.1 else "> 99.9 %" if share > 0.999 else f"{100 * share:.0f} %"
