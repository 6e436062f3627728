"""The memo's figures on contacts of some width: vertices (9), a cylinder (11, 13), drag (12)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from .._check import FloatArray
from ..contact import Contact, FlatPunch, Hertz, LineLoad, PressureProfile, Wedge
from ..memo import eq17, eq17_corrected, eq21, eq21_corrected
from .memo_lines import UNIT_SKIN
from .parts import heading, legend, stacked, zero_line
from .style import BLACK, BLUE, DASHED, DOUBLE, GREEN, GREY, SINGLE, SKY, VERMILLION, new_figure

__all__ = ["figure_9", "figure_11", "figure_12", "figure_13"]

# Load, half width and modulus are 1: stresses come out in units of P/a, strains in units of P/(E a).
_PLACE = "position along the skin $y/a$"
_STRAIN = r"strain $\varepsilon_x\, E a/P$"


def figure_9() -> Figure:
    """A flat punch's edges and a wedge's tip: pressure on the surface, and strain at two depths."""
    punch, wedge = FlatPunch(1.0, half_width=1.0), Wedge(1.0, half_width=1.0)
    looks: dict[str, tuple[Contact, str, Any]] = {
        "flat punch, its edges at ±a": (punch, BLUE, "solid"),
        "wedge, its tip at 0": (wedge, VERMILLION, "solid"),
        "line load": (LineLoad(1.0), BLACK, DASHED),
    }
    figure = new_figure(DOUBLE, 76.0)
    surface, near, far = figure.subplots(1, 3)
    # nodes that crowd towards the edges and the tip, and miss both: the pressure is infinite there
    inside = np.sin(np.linspace(-0.5, 0.5, 800)[1:-1] * np.pi)
    surface.plot(inside, punch.pressure(inside), color=BLUE)
    surface.plot(inside, wedge.pressure(inside), color=VERMILLION)
    _strains(near, 0.5, 3, looks)
    _strains(far, 2.0, 6, looks)
    _along(surface, 2, "pressure on the surface $p\\,a/P$")
    surface.set_ylim(0.0, 1.6)
    titles = ("Surface", "Depth $a/2$", "Depth $2\\,a$")
    _finish(figure, "Vertices: flat punch and wedge", (surface, near, far), titles, near)
    return figure


def figure_11() -> Figure:
    """A cylinder: stress and strain beneath it; dashed, the pressure if eq. (17) were the half width."""
    same: dict[str, Any] = {"P": 1.0, "R": 1.0, "E": 1.0, "nu": 0.5}
    touch, too_wide = Hertz(1.0, half_width=1.0), float(eq17(**same) / eq17_corrected(**same))
    figure = new_figure(DOUBLE, 82.0)
    left, right = figure.subplots(1, 2)
    edge = np.sin(np.linspace(-0.5, 0.5, 401) * np.pi)
    left.plot(edge, UNIT_SKIN.stress(touch, x=0.0, y=edge).xx, color=BLACK, label="surface")
    y = np.linspace(-4.0, 4.0, 801)
    for depth, colour in {0.5: BLUE, 1.0: GREEN, 2.0: VERMILLION}.items():
        state = UNIT_SKIN.state(touch, x=depth, y=y)
        left.plot(y, state.stress.xx, color=colour, label=_times_a(depth))
        right.plot(y, state.strain.xx, color=colour)
    taken = -Hertz(1.0, half_width=too_wide).pressure(too_wide * edge)
    label = "surface, eq. (17) taken for the half width"
    left.plot(too_wide * edge, taken, color=GREY, linestyle=DASHED, label=label)
    _along(left, 4, r"stress $\sigma_x\, a/P$")
    _along(right, 4, _STRAIN)
    _finish(figure, "Cylinder", (left, right), ("Stress", "Strain"), left)
    return figure


def figure_12() -> Figure:
    """Tangential stress proportional to the normal stress: a pressure pattern and its traction."""
    angle = np.deg2rad(25.0)
    y = np.linspace(-1.0, 1.0, 201)
    shape = np.sqrt(1 - y**2) * (1.1 + 0.5 * np.sin(4.5 * y) + 0.2 * y)
    p = shape / shape.max()
    contact = PressureProfile(y, p, shear=np.tan(angle) * p)
    above, below, reach, inner = 1.15, 1.1, 1.5, SINGLE - 13.0 - 3.0
    scale = inner / (2 * reach)
    figure, (axes,) = stacked(SINGLE, [scale * (above + below)], left=13.0, right=3.0, top=6.0, foot=18.5)
    axes.axhspan(-below, 0.0, color="#F2F2F2", linewidth=0)
    axes.plot(y, contact.pressure(y), color=BLACK, label="pressure $p$")
    axes.plot(y, contact.shear(y), color=VERMILLION, linestyle=DASHED, label=r"shear $q = p\,\tan\alpha$")
    for position in np.linspace(-0.9, 0.9, 13):
        tip = (position + float(contact.shear(position)), -float(contact.pressure(position)))
        arrow = {"arrowstyle": "-|>", "color": BLUE, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 6}
        axes.annotate("", tip, (position, 0.0), arrowprops=arrow)
    axes.plot([], [], color=BLUE, label="traction on the skin")
    axes.axhline(0.0, color=BLACK, linewidth=0.9)
    axes.set(xlim=(-reach, reach), ylim=(-below, above), yticks=[0, 0.5, 1])
    axes.set(xlabel=_PLACE, ylabel="traction / largest $p$")
    axes.set_title(r"Drag in proportion to pressure, $\alpha = 25°$")
    axes.spines["left"].set_bounds(0.0, above)
    legend(figure, axes, loc="lower center", ncols=2, columnspacing=1.2)
    return figure


def figure_13() -> Figure:
    """A cylinder dragged at several angles: strain at two depths, and its slope beneath the centre."""
    figure = new_figure(DOUBLE, 80.0)
    far, near, slopes = figure.subplots(1, 3)
    colours = {0: SKY, 15: BLUE, 30: GREEN, 45: VERMILLION}
    dragged = {f"α = {a}°": (Hertz(1.0, np.deg2rad(a), half_width=1.0), c, "solid") for a, c in colours.items()}
    for axes, depth, reach in ((far, 2.0, 6), (near, 0.4, 3)):
        _strains(axes, depth, reach, dragged)
        _tangents(axes, np.deg2rad(45.0), depth, reach)
    x = np.linspace(0.0, 4.0, 401)
    right, printed = _slopes(x)
    slopes.plot(x, right, color=BLACK, label="slope under the centre")
    slopes.plot(x, printed, color=BLACK, linestyle=DASHED, label="by eq. (21) as printed")
    slopes.plot(BLIND_DEPTH, 0.0, "o", color=BLACK, ms=4.5)
    note: dict[str, Any] = {"arrowstyle": "-", "linewidth": 0.6, "shrinkB": 3}
    text = f"blind depth ${BLIND_DEPTH:.3f}\\,a$"
    slopes.annotate(text, (BLIND_DEPTH, 0.0), (1.2, 0.3), fontsize=7, arrowprops=note)
    slopes.set(xlim=(0, 4), xlabel="depth $x/a$", xticks=range(5))
    slopes.set_ylabel(r"slope $(d\varepsilon_x/dy)\, E a^2 / (P\, \sin\alpha)$")
    zero_line(slopes)
    titles = ("Depth $2\\,a$", "Depth $0.4\\,a$", "Slope against depth")
    _finish(figure, "Cylinder dragged to +y at angle α", (far, near, slopes), titles, far, slopes)
    return figure


def _strains(axes: Axes, depth: float, reach: int, touches: Mapping[str, tuple[Contact, str, Any]]) -> None:
    """The strain at a depth under touches, by their names, each in its colour and dashes."""
    y = np.linspace(-reach, reach, 601)
    for name, (contact, colour, dash) in touches.items():
        axes.plot(y, UNIT_SKIN.strain(contact, x=depth, y=y).xx, color=colour, linestyle=dash, label=name)
    _along(axes, reach, _STRAIN)


def _along(axes: Axes, reach: int, label: str) -> None:
    axes.set(xlim=(-reach, reach), xlabel=_PLACE, ylabel=label)
    axes.xaxis.set_major_locator(MultipleLocator(1 if reach < 4 else 2))
    zero_line(axes)


def _finish(figure: Figure, title: str, panels: Sequence[Axes], titles: Sequence[str], *labelled: Axes) -> None:
    """Titles over the figure and its panels, and one legend below them all, where it covers nothing."""
    for axes, text in zip(panels, titles, strict=True):
        axes.set_title(text, fontweight="normal")
    heading(figure, title)
    legend(figure, *labelled, ncols=6, columnspacing=1.2, handlelength=1.6)


def _times_a(multiple: float) -> str:
    return "depth $a$" if multiple == 1 else f"depth ${multiple:g}\\,a$"


BLIND_DEPTH = float(np.sqrt((np.sqrt(5.0) - 1.0) / 2.0))
"""Depth / half width at which the slope beneath a dragged cylinder is zero at every angle (nu = 1/2)."""


def _slopes(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Slope under the centre at half width 1 and sin(angle) = 1: right, and as eq. (21) prints it.

    The memo's alpha drags towards -y, and its a is here the full width.
    """
    memo: dict[str, Any] = {"P": 1.0, "x": x, "alpha": -np.pi / 2, "E": 1.0}
    return eq21_corrected(half_width=1.0, **memo), eq21(a=2.0, **memo)


def _tangents(axes: Axes, angle: float, depth: float, reach: float) -> None:
    """The slope under the centre, right and as printed, through the curve's own value there."""
    touch = Hertz(1.0, angle, half_width=1.0)
    height = float(UNIT_SKIN.strain(touch, x=depth, y=0.0).xx)
    ends = np.array([-0.2, 0.2]) * reach
    for slope, dash in zip(_slopes(np.array(depth)), ("solid", DASHED), strict=True):
        rise = float(slope) * np.sin(angle)
        axes.plot(ends, height + rise * ends, color=BLACK, linestyle=dash, linewidth=1.0, zorder=3)
    axes.plot(0.0, height, "o", color=BLACK, ms=3, zorder=3)
