"""The memo's figures on line loads: the strain beneath one (Figs. 2, 3), its position found again (Fig. 6)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..contact import LineLoad
from ..material import Material
from ..memo import FIGURE_6, eq13
from ..memo.three_sensors import Root, Verdict, three_sensor
from ..skin import HalfPlane
from .parts import stacked, zero_line
from .style import BLACK, BLUE, DASHED, DOUBLE, GREEN, GREY, ORANGE, SINGLE, VERMILLION, new_figure

__all__ = ["figure_2", "figure_3", "figure_6"]

# Modulus, load and length of reference are 1: strains come out in units of P / (E d), positions in units of d.
UNIT_SKIN = HalfPlane(Material(young=1.0, poisson=0.5))

_DEPTHS = {1.0: BLACK, 1.5: BLUE, 2.0: VERMILLION, 3.0: GREEN}
_REACH, _DEEPEST, _ABOVE = 6.0, 3.3, 1.9
_PANELS = ((_DEEPEST + _ABOVE) / (2 * _REACH), 0.78)
_ARROW = {"arrowstyle": "-|>", "color": BLACK, "shrinkA": 0, "shrinkB": 0, "linewidth": 1.4, "mutation_scale": 9}


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
        axes.plot([0.0, position], [0.0, _DEEPEST], color=GREY, linewidth=0.7, linestyle=DASHED)
    for depth, colour in _DEPTHS.items():
        axes.axhline(depth, color=colour)
        _mark(axes, _blind_positions(depth, angle), depth, colour)
    axes.axhline(0.0, color=BLACK, linewidth=0.8)
    axes.annotate("", (0.0, 0.0), (-_ABOVE * np.sin(angle), -_ABOVE * np.cos(angle)), arrowprops=_ARROW)
    axes.text(-0.97 * _REACH, -0.2, "surface", fontsize=7, color=GREY)
    axes.text(0.97 * _REACH, -0.2, "○ reads 0", fontsize=7, color=GREY, ha="right")
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
    Verdict.ACCEPTED: ("o", GREEN, "accepted"),
    Verdict.PULLS: ("v", VERMILLION, "pulls"),
    Verdict.SLIPS: ("s", ORANGE, "slips"),
    Verdict.NOT_A_SOLUTION: ("X", GREY, "no solution"),
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
    curve.plot(y, eq13(readings, y, x, b) / (x**2 + y**2) ** 4, color=BLACK)
    zero_line(curve)
    curve.set_title("Three readings, four roots, one load")
    low, high = curve.get_ylim()
    curve.set(xlim=(left, right), ylim=(low, high), ylabel=r"$f(y)\,/\,(x^2 + y^2)^4$")
    sketch.axhspan(0.0, below, color="#F2F2F2", linewidth=0)
    sketch.axhline(0.0, color=BLACK, linewidth=0.9)
    for root in found.roots:
        marker, colour, _ = _VERDICTS[root.verdict]
        for axes, ends in ((curve, [0.0, low]), (sketch, [-above, 0.0])):
            axes.plot([root.position] * 2, ends, color=colour, linewidth=0.7, linestyle=(0, (2, 2)), zorder=1)
        curve.plot(root.position, 0.0, marker, color=colour, ms=6, zorder=3)
        _root(sketch, root)
    for position, reading, index in zip(sensors, readings, "123", strict=True):
        sketch.plot(position, x, "o", ms=5, mfc="white", mec=BLACK, mew=0.9)
        text = rf"$\varepsilon_{{x{index}}} = {reading:+g}$"
        sketch.text(position, x + 0.62, text, fontsize=7, ha="center", va="center")
    note = "grey: where a load comes from\nthat presses and, with friction 1,\ndoes not slip"
    sketch.text(left + 0.15, 0.9 * below, note, fontsize=7, color=GREY, va="bottom")
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
