"""What friction and a side say: how close to slipping touches are, and the angle of a side that is touched."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from .. import _check
from .._check import FloatArray
from ..array import SensorArray
from ..contact import Hertz
from ..decide import Slip, SlipVerdict, least_force
from ..errors import GeometryError
from ..estimate import Status, side_angle, side_angle_from_gradients
from ..estimate.side.row import Changes
from ..finger import Finger
from ..memo import eq20, eq20_corrected, eq21, eq21_corrected, eq22
from .memo_lines import BLIND_DEPTH, UNIT_SKIN
from .style import DASHED, DOUBLE, NORMAL_95, Ink, finished, legend, new_figure, plain, zero_line

__all__ = ["side_angle_figure", "slip_figure"]

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
        axes.plot(n, side * middle * n, color=Ink.BLACK, lw=1.0, label=label)
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
        axes.contour(n, t, chance, [level], colors=Ink.VERMILLION, linewidths=0.9, linestyles=[line])
        axes.plot([], [], color=Ink.VERMILLION, lw=0.9, ls=line, label=f"slips with {100 * level:.3g} %")
    values, vectors = np.linalg.eigh(covariance)
    width, height = 2 * np.sqrt(_CHI2_95 * np.maximum(values[::-1], 0.0))
    turn = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
    ring: dict[str, Any] = {"facecolor": Ink.BLUE, "alpha": 0.25, "lw": 0, "zorder": 3}
    axes.add_patch(Ellipse((normal, tangential), float(width), float(height), angle=turn, **ring))
    axes.plot(normal, tangential, "o", color=Ink.BLUE, zorder=4, label="load found, 95 %")
    edge = np.sign(tangential or 1.0) * float(judged.margin[index] + abs(tangential))
    axes.plot([normal, normal], [tangential, edge], color=Ink.BLUE, lw=0.9, ls=":", zorder=3)
    beside = 0.5 * np.sqrt(_CHI2_95 * covariance[0, 0]) + 0.02 * most
    margin = f"{judged.margin[index]:.2g}".replace("-", "−")
    text = f"margin {margin} ± {NORMAL_95 * float(judged.margin_std[index]):.2g} {judged.estimate.force_unit}"
    white = {"facecolor": "w", "alpha": 0.75, "lw": 0, "pad": 1.0}
    note: dict[str, Any] = {"fontsize": 7, "bbox": white, "zorder": 3.2}
    axes.text(normal - beside, 0.5 * (tangential + edge), text, color=Ink.BLUE, ha="right", va="center", **note)
    if reach:
        arrow: dict[str, Any] = {"arrowstyle": "-|>", "color": Ink.GREEN, "lw": 1.2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=(least, tangential), xytext=(normal, tangential), arrowprops=arrow, zorder=3.5)
        up = tangential < 0
        position = tangential + (0.06 if up else -0.06) * (top - bottom)
        text = f"least for {100 * bound:.3g} %: {least:.3g} {judged.estimate.force_unit}"
        ha, away = ("left", beside) if least > normal else ("right", -beside)
        axes.text(normal + away, position, text, color=Ink.GREEN, ha=ha, va="bottom" if up else "top", **note)
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
        axes.plot(y, held, color=Ink.GREY, lw=0.9, ls="--", label="what friction holds, $\\mu\\,p$")
        axes.plot(y, drag, color=Ink.BLACK, label="shear, $|q|$")
        axes.legend(loc="upper right", bbox_to_anchor=(1.0, 1.1))
    low, high = judged.stick_interval[index]
    axes.barh(-0.25, 2, 0.22, left=-1, color=Ink.VERMILLION, alpha=0.55, lw=0)
    axes.barh(-0.25, 2 * stick, 0.22, left=-stick, color=Ink.GREEN, lw=0)
    axes.plot([[-high, -low, low, high]] * 2, [[-0.4] * 4, [-0.1] * 4], color=Ink.BLACK, lw=0.9)
    axes.text(1.03, -0.25, "slips", color=Ink.VERMILLION, va="center", fontsize=7)
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


# Load, half width and modulus are 1, and the memo's alpha is minus the angle.
_DEPTH, _REACH = 0.4, 2.5
_TRUE = np.deg2rad(10.0)
_FULL_SCALE = 3 / (2 * np.pi)  # strain beneath a unit line load at unit depth
_KNOWN = 0.01


@finished
def side_angle_figure(noise: float = 1e-3) -> Figure:
    """What the memo says of the angle on a side, what is right, and how well three ways estimate it.

    Above, its Fig. 13: strain beneath a dragged cylinder at a depth of 0.4 half widths and the slope beneath its
    centre, by (20) and (21) as printed, and corrected. Below, that slope against depth, (21) and (22) in units of half
    the width; the angle that (21) makes of the true slope under a force that leans by 10 degrees, which depends on the
    unit of length and is nothing where its sine exceeds 1; and the standard deviation of the angle of a force that
    leans by 0.3 rad, where the depth is given and the half width varies: for 7 sensors half a depth apart, and for two
    rows of 9, a quarter depth apart, at 0.9 and 1.1 depths.

    Parameters
    ----------
    noise : float, optional
        Of each sensor, as a share of the strain right beneath a normal line load of the same force.

    Raises
    ------
    InvalidValueError
        noise <= 0.

    Examples
    --------
    >>> figure = side_angle_figure()
    >>> figure.axes[2].get_xlabel()
    'depth $x/a$'
    """
    share = _check.scalar("noise", noise, above=0.0)
    figure = new_figure(DOUBLE, 140.0)
    (upper,), (lower,) = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.0, 1.15))
    _profiles(*upper.subplots(1, 2, sharey=True))
    legend(upper, upper.axes[0], ncols=5)
    (parts,) = lower.subfigures(1, 3, squeeze=False)
    panels: list[Callable[[Axes], None]] = [_slopes, _published, partial(_spread, noise=share)]
    for part, draw in zip(parts, panels, strict=True):
        axes = part.subplots()
        draw(axes)
        legend(part, axes, loc="outside lower left")
    return figure


def _profiles(printed: Axes, right: Axes) -> None:
    y = np.linspace(-_REACH, _REACH, 201)
    for axes, law, slope, title in (
        (printed, eq20, eq21(1.0, 2.0, _DEPTH, -np.pi / 2, 1.0), "As printed: eqs. (20) and (21)"),
        (right, eq20_corrected, eq21_corrected(1.0, 1.0, _DEPTH, -np.pi / 2, 1.0), "Corrected"),
    ):
        press, drag = (law(1.0, _DEPTH, y, alpha, 1.0, -1.0, 1.0) for alpha in (0.0, -np.pi / 2))
        for degrees, colour in {0: Ink.SKY, 15: Ink.BLUE, 30: Ink.GREEN, 45: Ink.VERMILLION}.items():
            angle = np.deg2rad(degrees)
            axes.plot(y, press * np.cos(angle) + drag * np.sin(angle), color=colour, label=f"α = {degrees}°")
            height = press[y.size // 2] * np.cos(angle)
            ends = np.array([-0.5, 0.5])
            axes.plot(ends, height + float(slope) * np.sin(angle) * ends, color=Ink.BLACK, linewidth=0.9, zorder=3)
            axes.plot(0.0, height, "o", color=Ink.BLACK, ms=2.2, zorder=3)
        axes.plot([], [], color=Ink.BLACK, linewidth=0.9, label="slope beneath the centre")
        axes.set(xlim=(-_REACH, _REACH), xlabel="position along the skin $y/a$")
        axes.set_title(title, fontweight="normal")
        zero_line(axes)
    printed.set_ylabel(r"strain $\varepsilon_x\, E a/P$ at depth $0.4\,a$")


def _slopes(axes: Axes) -> None:
    x = np.linspace(0.0, 4.0, 801)
    wrong = float(eq22(1.0, 2.0, -np.pi / 2, 1.0))
    axes.plot(x, eq21_corrected(1.0, 1.0, x, -np.pi / 2, 1.0), color=Ink.BLACK, label="corrected")
    axes.plot(x, eq21(1.0, 2.0, x, -np.pi / 2, 1.0), color=Ink.VERMILLION, linestyle=DASHED, label="(21) as printed")
    axes.plot([0.0, 0.5], [wrong, wrong], color=Ink.ORANGE, linewidth=1.6, label="(22) as printed, wide contacts")
    text = f"zero at every angle: ${BLIND_DEPTH:.3f}\\,a$"
    axes.plot(BLIND_DEPTH, 0.0, "o", color=Ink.BLACK, ms=4.0, linestyle="none", label=text)
    axes.set(xlim=(0, 4), xlabel="depth $x/a$", xticks=range(5))
    axes.set_ylabel(r"slope $(d\varepsilon_x/dy)\, E a^2 / (P\, \sin\alpha)$")
    axes.set_title("Slope beneath the centre", fontweight="normal")
    zero_line(axes)


def _published(axes: Axes) -> None:
    x = np.linspace(0.02, 4.0, 2000)
    slope = eq21_corrected(1.0, 1.0, x, -_TRUE, 1.0)
    axes.axhline(np.rad2deg(_TRUE), color=Ink.BLACK, label="the force")
    for unit, width, colour, dash in (
        ("half the width", 2.0, Ink.VERMILLION, DASHED),
        ("the width", 1.0, Ink.BLUE, (0, (1, 1))),
    ):
        # in units in which the half width is width / 2, the same slope is so much larger
        per_sine = eq21(1.0, width, x * width / 2, -np.pi / 2, 1.0) * (width / 2) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            sine = slope / per_sine
        told = np.rad2deg(np.arcsin(np.where(np.abs(sine) <= 1, sine, np.nan)))
        axes.plot(x, told, color=colour, linestyle=dash, label=f"(21), unit of length {unit}")
    axes.axvline(BLIND_DEPTH, color=Ink.GREY, linewidth=0.6, zorder=0.5, label="blind depth")
    axes.set(xlim=(0, 4), ylim=(-90, 90), xlabel="depth $x/a$", xticks=range(5), yticks=range(-90, 91, 30))
    axes.set_ylabel("angle from the slope [degrees]")
    axes.set_title("Angle by eq. (21)", fontweight="normal")
    zero_line(axes)


def _spread(axes: Axes, noise: float) -> None:
    ratio = np.geomspace(0.4, 4.0, 241)
    touch = Hertz(np.ones(ratio.size), 0.3, half_width=1 / ratio)
    sigma = noise * _FULL_SCALE
    row = Finger(UNIT_SKIN, SensorArray.line(7, pitch=0.5, depth=1.0, noise=sigma))
    y = np.tile(0.25 * np.arange(-4, 5), 2)
    pair = Finger(UNIT_SKIN, SensorArray(y=y, depth=np.repeat([0.9, 1.1], 9), noise=sigma))
    known: dict[str, Any] = {"position": 0.0, "half_width": 1 / ratio, "most_std": np.inf}
    exact = side_angle(row, row.read(touch), **known)
    near = side_angle(row, row.read(touch), position_std=_KNOWN, **known)
    gradient = side_angle_from_gradients(pair, pair.read(touch), position=0.0, most_std=np.inf)
    for std, label, style in (
        (_bound(row, touch), "full fit: nothing known", {"color": Ink.BLACK}),
        (exact.std, "slope: centre and width known", {"color": Ink.BLUE}),
        (near.std, "slope: centre to 1 % of depth", {"color": Ink.BLUE, "linestyle": DASHED}),
        (gradient.std, "gradients, two depths: centre known", {"color": Ink.GREEN}),
    ):
        axes.plot(ratio, np.rad2deg(std), label=label, **style)
    axes.axvline(BLIND_DEPTH, color=Ink.GREY, linewidth=0.6, zorder=0.5)
    axes.set(xscale="log", yscale="log", xlim=(0.4, 4), ylim=(0.05, 100), xlabel="depth / half width $x/a$")
    plain(axes.xaxis, [0.5, 1, 2, 4], small=True)
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_ylabel("standard deviation [degrees]")
    axes.set_title(f"Accuracy at {100 * noise:g} % noise", fontweight="normal")


def _bound(finger: Finger, touch: Hertz) -> FloatArray:
    """Cramer-Rao bound of the angle [rad] where position, width, force and angle are unknown."""
    force = np.array([np.cos(0.3), np.sin(0.3)])
    made = Changes.of(finger, Hertz, np.zeros(touch.shape), np.asarray(touch.half_width))
    turned = made.unit @ np.array([-force[1], force[0]])
    columns = [turned, made.unit @ force, made.by_position @ force, made.by_width @ force]
    jacobian = np.stack(columns, axis=-1) / np.asarray(finger.array.noise)[:, None]
    information = np.swapaxes(jacobian, -1, -2) @ jacobian
    return np.asarray(np.sqrt(np.linalg.inv(information)[..., 0, 0]))
