"""The memo's figures of line loads and of contacts: 2, 3, 6, 9, 11 to 13."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from .._check import FloatArray
from ..contact import Contact, FlatPunch, Hertz, LineLoad, PressureProfile, Wedge
from ..material import Material
from ..memo import FIGURE_6, eq13, eq17, eq17_corrected, eq21, eq21_corrected
from ..memo.three_sensors import Root, Verdict, three_sensor
from ..skin import HalfPlane
from .style import DASHED, DOUBLE, SINGLE, Ink, heading, legend, new_figure, stacked, zero_line

__all__ = ["figure_2", "figure_3", "figure_6", "figure_9", "figure_11", "figure_12", "figure_13"]

# Modulus, load and length of reference are 1: strains come out in units of P / (E d), positions in units of d.
UNIT_SKIN = HalfPlane(Material(young=1.0, poisson=0.5))

_DEPTHS = {1.0: Ink.BLACK, 1.5: Ink.BLUE, 2.0: Ink.VERMILLION, 3.0: Ink.GREEN}
_REACH, _DEEPEST, _ABOVE = 6.0, 3.3, 1.9
_PANELS = ((_DEEPEST + _ABOVE) / (2 * _REACH), 0.78)
_ARROW = {"arrowstyle": "-|>", "color": Ink.BLACK, "shrinkA": 0, "shrinkB": 0, "linewidth": 1.4, "mutation_scale": 9}


def figure_2() -> Figure:
    """Strain beneath a line load normal to the surface."""
    return _strain_beneath(0.0, "Line load normal to the surface")


def figure_3() -> Figure:
    """Strain beneath a line load inclined by 30 degrees, dragging towards +y."""
    return _strain_beneath(np.deg2rad(30.0), "Line load inclined 30°, dragging to +y")


def _strain_beneath(angle: float, title: str) -> Figure:
    figure = new_figure(SINGLE, 98.0)
    sketch, curves = figure.subplots(2, 1, sharex=True, height_ratios=_PANELS)
    for axes, ratio in zip((sketch, curves), _PANELS, strict=True):
        axes.set_box_aspect(ratio)  # the same width for both, and a sketch to scale
    sketch.set_title(title)
    _sketch(sketch, angle)

    load = LineLoad(force=1.0, angle=angle)
    y = np.linspace(-_REACH, _REACH, 601)
    zero_line(curves)
    for depth, colour in _DEPTHS.items():
        curves.plot(y, UNIT_SKIN.strain(load, x=depth, y=y).xx, color=colour, label=_times_d(depth))
        _mark(curves, _blind_positions(depth, angle), 0.0, colour)
    curves.legend(title="depth of the sensor $x$", loc="lower right", title_fontsize=7)
    curves.set(xlim=(-_REACH, _REACH), ylim=(-0.5, 0.14), xlabel="position of the sensor, from the load, $y/d$")
    curves.set_ylabel(r"strain $\varepsilon_x\, E d/P$  ($-$ compressed)")
    return figure


def _sketch(axes: Axes, angle: float) -> None:
    """The skin to scale: the sensors' depths, and the rays along which a sensor reads nothing."""
    for position in _blind_positions(_DEEPEST, angle):
        axes.plot([0.0, position], [0.0, _DEEPEST], color=Ink.GREY, linewidth=0.7, linestyle=DASHED)
    for depth, colour in _DEPTHS.items():
        axes.axhline(depth, color=colour)
        _mark(axes, _blind_positions(depth, angle), depth, colour)
    axes.axhline(0.0, color=Ink.BLACK, linewidth=0.8)
    axes.annotate("", (0.0, 0.0), (-_ABOVE * np.sin(angle), -_ABOVE * np.cos(angle)), arrowprops=_ARROW)
    axes.text(-0.97 * _REACH, -0.2, "surface", fontsize=7, color=Ink.GREY)
    axes.text(0.97 * _REACH, -0.2, "○ reads 0", fontsize=7, color=Ink.GREY, ha="right")
    axes.set(ylim=(_DEEPEST, -_ABOVE), yticks=[0, 1, 2, 3], ylabel="depth $x/d$")
    axes.tick_params(axis="x", bottom=False)
    axes.spines["bottom"].set_visible(False)
    axes.spines["left"].set_bounds(_DEEPEST, 0.0)


def _blind_positions(depth: float, angle: float) -> list[float]:
    """Where eps_x is zero: at y^2 = x^2, and where the ray is square to the load, x cos + y sin = 0."""
    third = [-depth / np.tan(angle)] if angle else []
    return [-depth, depth, *third]


def _mark(axes: Axes, positions: list[float], height: float, colour: str) -> None:
    inside = [y for y in positions if abs(y) <= _REACH]
    axes.plot(inside, [height] * len(inside), "o", ms=3.2, mfc="white", mec=colour, mew=0.9, zorder=3)


def _times_d(multiple: float) -> str:
    return "$d$" if multiple == 1 else f"${multiple:g}\\,d$"


_VERDICTS = {
    Verdict.ACCEPTED: ("o", Ink.GREEN, "accepted"),
    Verdict.PULLS: ("v", Ink.VERMILLION, "pulls"),
    Verdict.SLIPS: ("s", Ink.ORANGE, "slips"),
    Verdict.NOT_A_SOLUTION: ("X", Ink.GREY, "no solution"),
}


def figure_6() -> Figure:
    """Finding the position of a load from three readings: the roots of eq. (13) and what becomes of each."""
    x, b = FIGURE_6.depth, FIGURE_6.pitch
    readings = -np.array(FIGURE_6.printed)  # printed with compression positive
    sensors = np.array([-b, 0.0, b])
    found = three_sensor(readings, sensors, x, young=1.0)
    left, right, above, below = -8.0, 8.0, 2.3, x + 1.0
    inner = DOUBLE - 15.0 - 3.0
    heights = [40.0, inner * (above + below) / (right - left)]
    figure, (curve, sketch) = stacked(DOUBLE, heights, left=15.0, right=3.0, top=6.0, foot=11.0)

    y = np.linspace(left, right, 801)
    # f itself spans six decades; over (x^2 + y^2)^4 it has the same roots, and is bounded
    curve.plot(y, eq13(readings, y, x, b) / (x**2 + y**2) ** 4, color=Ink.BLACK)
    zero_line(curve)
    curve.set_title("Three readings, four roots, one load")
    low, high = curve.get_ylim()
    curve.set(xlim=(left, right), ylim=(low, high), ylabel=r"$f(y)\,/\,(x^2 + y^2)^4$")
    sketch.axhspan(0.0, below, color="#F2F2F2", linewidth=0)
    sketch.axhline(0.0, color=Ink.BLACK, linewidth=0.9)
    for root in found.roots:
        marker, colour, _ = _VERDICTS[root.verdict]
        for axes, ends in ((curve, [0.0, low]), (sketch, [-above, 0.0])):
            axes.plot([root.position] * 2, ends, color=colour, linewidth=0.7, linestyle=(0, (2, 2)), zorder=1)
        curve.plot(root.position, 0.0, marker, color=colour, ms=6, zorder=3)
        _root(sketch, root)
    for position, reading, index in zip(sensors, readings, "123", strict=True):
        sketch.plot(position, x, "o", ms=5, mfc="white", mec=Ink.BLACK, mew=0.9)
        text = rf"$\varepsilon_{{x{index}}} = {reading:+g}$"
        sketch.text(position, x + 0.62, text, fontsize=7, ha="center", va="center")
    note = "grey: where a load comes from\nthat presses and, with friction 1,\ndoes not slip"
    sketch.text(left + 0.15, 0.9 * below, note, fontsize=7, color=Ink.GREY, va="bottom")
    sketch.set(ylim=(below, -above), yticks=[0, 1, 2, 3], ylabel="depth $x$")
    sketch.set_xlabel(f"position of the load $y$  (depth {x:g}, pitch {b:g})")
    sketch.spines["left"].set_bounds(below, 0.0)
    return figure


def _root(axes: Axes, root: Root) -> None:
    """The load of a root on the skin: the cone from which a load may come, its arrow, and the verdict."""
    length = 2.0
    _, colour, verdict = _VERDICTS[root.verdict]
    rim = np.linspace(-np.pi / 4, np.pi / 4, 31)
    cone = np.column_stack([root.position - length * np.sin(rim), -length * np.cos(rim)])
    axes.fill(*np.vstack([[root.position, 0.0], cone]).T, color="#DDDDDD", linewidth=0, zorder=0.5)
    along, into = length * np.sin(root.angle), length * np.cos(root.angle)  # the force on the skin
    here = (root.position, 0.0)
    tail, head = (here, (root.position + along, into)) if into < 0 else ((root.position - along, -into), here)
    axes.annotate("", head, tail, arrowprops={**_ARROW, "color": colour, "linewidth": 1.8}, zorder=3)
    side = "right" if abs(root.position) < 1 else "center" if abs(root.position) > 3 else "left"
    shift = {"right": 0.25, "center": 0.0, "left": -0.25}[side]
    text = f"$y = {root.position:+.3f}$\n${np.degrees(root.angle):+.1f}$°\n{verdict}"
    axes.text(root.position + shift, 0.25, text, fontsize=7, ha=side, va="top", linespacing=1.3)


# Load, half width and modulus are 1: stresses come out in units of P/a, strains in units of P/(E a).
_PLACE = "position along the skin $y/a$"
_STRAIN = r"strain $\varepsilon_x\, E a/P$"


def figure_9() -> Figure:
    """A flat punch's edges and a wedge's tip: pressure on the surface, and strain at two depths."""
    punch, wedge = FlatPunch(1.0, half_width=1.0), Wedge(1.0, half_width=1.0)
    looks: dict[str, tuple[Contact, str, Any]] = {
        "flat punch, its edges at ±a": (punch, Ink.BLUE, "solid"),
        "wedge, its tip at 0": (wedge, Ink.VERMILLION, "solid"),
        "line load": (LineLoad(1.0), Ink.BLACK, DASHED),
    }
    figure = new_figure(DOUBLE, 76.0)
    surface, near, far = figure.subplots(1, 3)
    # nodes that crowd towards the edges and the tip, and miss both: the pressure is infinite there
    inside = np.sin(np.linspace(-0.5, 0.5, 800)[1:-1] * np.pi)
    surface.plot(inside, punch.pressure(inside), color=Ink.BLUE)
    surface.plot(inside, wedge.pressure(inside), color=Ink.VERMILLION)
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
    left.plot(edge, UNIT_SKIN.stress(touch, x=0.0, y=edge).xx, color=Ink.BLACK, label="surface")
    y = np.linspace(-4.0, 4.0, 801)
    for depth, colour in {0.5: Ink.BLUE, 1.0: Ink.GREEN, 2.0: Ink.VERMILLION}.items():
        state = UNIT_SKIN.state(touch, x=depth, y=y)
        left.plot(y, state.stress.xx, color=colour, label=_times_a(depth))
        right.plot(y, state.strain.xx, color=colour)
    taken = -Hertz(1.0, half_width=too_wide).pressure(too_wide * edge)
    label = "surface, eq. (17) taken for the half width"
    left.plot(too_wide * edge, taken, color=Ink.GREY, linestyle=DASHED, label=label)
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
    axes.plot(y, contact.pressure(y), color=Ink.BLACK, label="pressure $p$")
    axes.plot(y, contact.shear(y), color=Ink.VERMILLION, linestyle=DASHED, label=r"shear $q = p\,\tan\alpha$")
    for position in np.linspace(-0.9, 0.9, 13):
        tip = (position + float(contact.shear(position)), -float(contact.pressure(position)))
        arrow = {"arrowstyle": "-|>", "color": Ink.BLUE, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 6}
        axes.annotate("", tip, (position, 0.0), arrowprops=arrow)
    axes.plot([], [], color=Ink.BLUE, label="traction on the skin")
    axes.axhline(0.0, color=Ink.BLACK, linewidth=0.9)
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
    colours = {0: Ink.SKY, 15: Ink.BLUE, 30: Ink.GREEN, 45: Ink.VERMILLION}
    dragged = {f"α = {a}°": (Hertz(1.0, np.deg2rad(a), half_width=1.0), c, "solid") for a, c in colours.items()}
    for axes, depth, reach in ((far, 2.0, 6), (near, 0.4, 3)):
        _strains(axes, depth, reach, dragged)
        _tangents(axes, np.deg2rad(45.0), depth, reach)
    x = np.linspace(0.0, 4.0, 401)
    right, printed = _slopes(x)
    slopes.plot(x, right, color=Ink.BLACK, label="slope under the centre")
    slopes.plot(x, printed, color=Ink.BLACK, linestyle=DASHED, label="by eq. (21) as printed")
    slopes.plot(BLIND_DEPTH, 0.0, "o", color=Ink.BLACK, ms=4.5)
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
        axes.plot(ends, height + rise * ends, color=Ink.BLACK, linestyle=dash, linewidth=1.0, zorder=3)
    axes.plot(0.0, height, "o", color=Ink.BLACK, ms=3, zorder=3)
