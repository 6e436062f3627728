"""The memo's figures on line loads: the strain beneath one (Figs. 2, 3), its place found again (Fig. 6)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..contact.line import LineLoad
from ..material import Material
from ..skin.half_plane import HalfPlane
from .style import BLACK, BLUE, GREEN, GREY, SINGLE, VERMILLION, new_figure, zero_line

__all__ = ["figure_2", "figure_3"]

# Modulus, load and length of reference are 1: strains come out in units of P / (E d), places in units of d.
UNIT_SKIN = HalfPlane(Material(young=1.0, poisson=0.5))

_DEPTHS = {1.0: BLACK, 1.5: BLUE, 2.0: VERMILLION, 3.0: GREEN}
_REACH, _DEEPEST, _ABOVE = 6.0, 3.3, 1.9
_PANELS = ((_DEEPEST + _ABOVE) / (2 * _REACH), 0.78)
_ARROW = {
    "arrowstyle": "-|>",
    "color": BLACK,
    "shrinkA": 0,
    "shrinkB": 0,
    "linewidth": 1.4,
    "mutation_scale": 9,
}


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
        _mark(curves, _blind_places(depth, angle), 0.0, colour)
    curves.legend(title="depth of the sensor $x$", loc="lower right", title_fontsize=7)
    curves.set(xlim=(-_REACH, _REACH), xlabel="place of the sensor, from the load, $y/d$")
    curves.set_ylabel(r"strain $\varepsilon_x E d/P$  ($-$ compressed)")
    return figure


def _sketch(axes: Axes, angle: float) -> None:
    """The skin to scale: the sensors' depths, and the rays along which a sensor reads nothing."""
    for place in _blind_places(_DEEPEST, angle):
        axes.plot([0.0, place], [0.0, _DEEPEST], color=GREY, linewidth=0.7, linestyle=(0, (4, 2)))
    for depth, colour in _DEPTHS.items():
        axes.axhline(depth, color=colour)
        _mark(axes, _blind_places(depth, angle), depth, colour)
    axes.axhline(0.0, color=BLACK, linewidth=0.8)
    axes.annotate("", (0.0, 0.0), (-_ABOVE * np.sin(angle), -_ABOVE * np.cos(angle)), arrowprops=_ARROW)
    axes.text(-0.97 * _REACH, -0.2, "surface", fontsize=7, color=GREY)
    axes.text(0.97 * _REACH, -0.2, "○ reads 0", fontsize=7, color=GREY, ha="right")
    axes.set(ylim=(_DEEPEST, -_ABOVE), yticks=[0, 1, 2, 3], ylabel="depth $x/d$")
    axes.tick_params(axis="x", bottom=False)
    axes.spines["bottom"].set_visible(False)
    axes.spines["left"].set_bounds(_DEEPEST, 0.0)


def _blind_places(depth: float, angle: float) -> list[float]:
    """Where eps_x is zero: at y^2 = x^2, and where the ray is square to the load, x cos + y sin = 0."""
    third = [-depth / np.tan(angle)] if angle else []
    return [-depth, depth, *third]


def _mark(axes: Axes, places: list[float], height: float, colour: str) -> None:
    inside = [y for y in places if abs(y) <= _REACH]
    axes.plot(inside, [height] * len(inside), "o", ms=3.2, mfc="white", mec=colour, mew=0.9, zorder=3)


def _times_d(multiple: float) -> str:
    return "$d$" if multiple == 1 else f"${multiple:g}\\,d$"
