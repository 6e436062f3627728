"""The angle of force on a side: the memo's Fig. 13 and (21), (22) beside what is right; where each way is blind."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import _check
from .._check import FloatArray
from ..array import SensorArray
from ..contact import Hertz
from ..estimate import side_angle, side_angle_from_gradients
from ..estimate.side.row import Changes
from ..finger import Finger
from ..memo import eq20, eq20_corrected, eq21, eq21_corrected, eq22
from .memo_contacts import BLIND_DEPTH
from .memo_lines import UNIT_SKIN
from .parts import legend, plain, zero_line
from .style import BLACK, BLUE, DASHED, DOUBLE, GREEN, GREY, ORANGE, SKY, VERMILLION, finished, new_figure

__all__ = ["side_angle_figure"]

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
        for degrees, colour in {0: SKY, 15: BLUE, 30: GREEN, 45: VERMILLION}.items():
            angle = np.deg2rad(degrees)
            axes.plot(y, press * np.cos(angle) + drag * np.sin(angle), color=colour, label=f"α = {degrees}°")
            height = press[y.size // 2] * np.cos(angle)
            ends = np.array([-0.5, 0.5])
            axes.plot(ends, height + float(slope) * np.sin(angle) * ends, color=BLACK, linewidth=0.9, zorder=3)
            axes.plot(0.0, height, "o", color=BLACK, ms=2.2, zorder=3)
        axes.plot([], [], color=BLACK, linewidth=0.9, label="slope beneath the centre")
        axes.set(xlim=(-_REACH, _REACH), xlabel="position along the skin $y/a$")
        axes.set_title(title, fontweight="normal")
        zero_line(axes)
    printed.set_ylabel(r"strain $\varepsilon_x\, E a/P$ at depth $0.4\,a$")


def _slopes(axes: Axes) -> None:
    x = np.linspace(0.0, 4.0, 801)
    wrong = float(eq22(1.0, 2.0, -np.pi / 2, 1.0))
    axes.plot(x, eq21_corrected(1.0, 1.0, x, -np.pi / 2, 1.0), color=BLACK, label="corrected")
    axes.plot(x, eq21(1.0, 2.0, x, -np.pi / 2, 1.0), color=VERMILLION, linestyle=DASHED, label="(21) as printed")
    axes.plot([0.0, 0.5], [wrong, wrong], color=ORANGE, linewidth=1.6, label="(22) as printed, wide contacts")
    text = f"zero at every angle: ${BLIND_DEPTH:.3f}\\,a$"
    axes.plot(BLIND_DEPTH, 0.0, "o", color=BLACK, ms=4.0, linestyle="none", label=text)
    axes.set(xlim=(0, 4), xlabel="depth $x/a$", xticks=range(5))
    axes.set_ylabel(r"slope $(d\varepsilon_x/dy)\, E a^2 / (P\, \sin\alpha)$")
    axes.set_title("Slope beneath the centre", fontweight="normal")
    zero_line(axes)


def _published(axes: Axes) -> None:
    x = np.linspace(0.02, 4.0, 2000)
    slope = eq21_corrected(1.0, 1.0, x, -_TRUE, 1.0)
    axes.axhline(np.rad2deg(_TRUE), color=BLACK, label="the force")
    for unit, width, colour, dash in (
        ("half the width", 2.0, VERMILLION, DASHED),
        ("the width", 1.0, BLUE, (0, (1, 1))),
    ):
        # in units in which the half width is width / 2, the same slope is so much larger
        per_sine = eq21(1.0, width, x * width / 2, -np.pi / 2, 1.0) * (width / 2) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            sine = slope / per_sine
        told = np.rad2deg(np.arcsin(np.where(np.abs(sine) <= 1, sine, np.nan)))
        axes.plot(x, told, color=colour, linestyle=dash, label=f"(21), unit of length {unit}")
    axes.axvline(BLIND_DEPTH, color=GREY, linewidth=0.6, zorder=0.5, label="blind depth")
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
        (_bound(row, touch), "full fit: nothing known", {"color": BLACK}),
        (exact.std, "slope: centre and width known", {"color": BLUE}),
        (near.std, "slope: centre to 1 % of depth", {"color": BLUE, "linestyle": DASHED}),
        (gradient.std, "gradients, two depths: centre known", {"color": GREEN}),
    ):
        axes.plot(ratio, np.rad2deg(std), label=label, **style)
    axes.axvline(BLIND_DEPTH, color=GREY, linewidth=0.6, zorder=0.5)
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
