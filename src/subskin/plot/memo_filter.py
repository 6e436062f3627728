"""The memo's figures on the skin as a filter: strain at discrete positions (Fig. 14), the response (Fig. 15)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import FixedLocator

from ..array import SensorArray
from ..contact import Hertz
from ..design import aliasing_error, sensor_density, spatial_response
from ..finger import Finger
from ..material import Material
from ..skin import HalfPlane, Layer, Layered
from .response import COLOURS, LOADS, decades
from .style import DASHED, DOUBLE, Ink, legend, new_figure, zero_line

__all__ = ["figure_14", "figure_15"]

# Modulus and depth are 1: frequencies come out in waves per depth, amplitudes in 1 / E.
_RUBBER = Material(young=1.0, poisson=0.5)
_SENSOR = SensorArray(y=[0.0], depth=1.0)
_FINGER = Finger(HalfPlane(_RUBBER), _SENSOR)
_THICKNESS = 3.0

_HEIGHT = 74.0
_SIGNAL = (25.0, 23.0)
"""Width and height of a signal's panel [mm]; those of filters are wider and lower."""
_FILTER = (27.0, 17.0)
_LEFT, _TOP, _STEP = 13.0, 45.0, 40.3
_NODE = (9.0, 8.0)
_PITCH = 1.0
_ARROW = {"arrowstyle": "-|>", "color": Ink.BLACK, "shrinkA": 0, "shrinkB": 0, "lw": 0.9, "mutation_scale": 8}


def figure_14() -> Figure:
    """Strain measured by a row of sensors: pressure, skin, samples, low pass, and what is recovered."""
    contact = Hertz(1.0, position=-0.9, half_width=1.0) + Hertz(0.45, position=1.4, half_width=0.3)
    found = aliasing_error(_FINGER, contact, _PITCH)
    y, strain = found.position, found.reading
    middle = 0.5 * (y[0] + y[-1])
    worst = int(np.unravel_index(np.argmax(np.abs(found.error)), found.error.shape)[0])
    first = middle + found.shift[worst]
    sensors = first + _PITCH * np.arange(-6, 7)
    sensors = sensors[np.abs(sensors) < 4.2]
    samples = np.interp(sensors, y, strain)

    figure = new_figure(DOUBLE, _HEIGHT, layout="none")
    signals = [_panel(figure, _LEFT + i * _STEP, _TOP, *_SIGNAL) for i in range(4)]
    centres = [_LEFT + i * _STEP + 0.5 * (_SIGNAL[0] + _STEP) for i in range(3)]
    filters = [_panel(figure, c - 0.5 * _FILTER[0], 10.0, *_FILTER) for c in centres]
    names = ("pressure $p(y)$", "strain", "samples", "strain recovered")
    for axes, name in zip(signals, names, strict=True):
        axes.set_title(name, fontweight="normal")
        axes.set(xlim=(-4.2, 4.2), xlabel="position $y/d$", xticks=[-4, 0, 4])
    fine = np.linspace(-4.2, 4.2, 1401)
    signals[0].fill_between(fine, contact.pressure(fine), color=Ink.BLUE, alpha=0.25, lw=0)
    signals[0].plot(fine, contact.pressure(fine), color=Ink.BLUE)
    signals[0].set(ylabel="$p\\,d/N$", ylim=(0, None))
    signals[1].plot(y, strain, color=Ink.BLACK)
    signals[2].vlines(sensors, 0, samples, color=Ink.BLACK, lw=0.8)
    signals[2].plot(sensors, samples, "o", ms=3, color=Ink.BLACK)
    signals[3].plot(y, strain, color=Ink.GREY, lw=0.9)
    signals[3].plot(y, strain + found.error[worst], color=Ink.ORANGE)
    signals[3].text(0.97, 0.06, "grey: true", transform=signals[3].transAxes, ha="right", fontsize=7, color=Ink.GREY)
    low, high = 1.15 * strain.min(), 2.2 * strain.max()
    for axes in signals[1:]:
        axes.set_ylim(low, high)
        zero_line(axes)
    for axes in signals[1:3]:
        axes.sharey(signals[3])
        axes.tick_params(labelleft=False)
    signals[3].yaxis.tick_right()
    signals[3].yaxis.set_label_position("right")
    signals[3].spines[["left", "right"]].set_visible(False)
    signals[3].spines["right"].set_visible(True)
    signals[3].set_ylabel(r"$\varepsilon_x E\,d/N$")

    s = np.linspace(0, 1.2, 601)
    response = spatial_response(_FINGER, 2 * np.pi * s).magnitude[:, 0, 0]
    read = np.abs(contact.spectrum(2 * np.pi * s).p) * response
    filters[0].plot(s, response, color=Ink.BLUE)
    filters[0].set(ylabel="$|H|\\,E$", ylim=(0, 0.65), yticks=[0, 0.5])
    filters[1].vlines(sensors, 0, 1, color=Ink.BLACK, lw=0.8)
    filters[1].set(xlim=(-4.2, 4.2), ylim=(0, 1.5), yticks=[0, 1], ylabel="weight")
    filters[1].set(xlabel="position $y/d$", xticks=[-4, 0, 4])
    filters[1].text(0, 1.22, "a depth apart", ha="center", va="center", fontsize=7)
    filters[2].fill_between(s, read / read.max(), color=Ink.GREY, alpha=0.35, lw=0)
    edge = 0.5 / _PITCH
    filters[2].plot([0, edge, edge, 1.2], [1, 1, 0, 0], color=Ink.VERMILLION)
    filters[2].set(ylabel="gain", ylim=(0, 1.5), yticks=[0, 1])
    filters[2].text(1.2, 1.22, "grey: what is read", ha="right", va="center", fontsize=7, color=Ink.GREY)
    for axes in (filters[0], filters[2]):
        axes.set(xlim=(0, 1.2), xlabel="waves per depth $s\\,d$", xticks=[0, 0.5, 1])
    for centre, axes, name in zip(centres, filters, ("$H(s)$", "×", "low\npass"), strict=True):
        _node(figure, centre, axes, name)
    return figure


def _panel(figure: Figure, left: float, foot: float, width: float, height: float) -> Axes:
    return figure.add_axes((left / DOUBLE, foot / _HEIGHT, width / DOUBLE, height / _HEIGHT))


def _node(figure: Figure, centre: float, beneath: Axes, name: str) -> None:
    """A box between two signals, the arrows into it and out of it, and one from the filter that it stands for."""
    level = _TOP + 0.5 * _SIGNAL[1]
    width, height = _NODE
    corner = ((centre - 0.5 * width) / DOUBLE, (level - 0.5 * height) / _HEIGHT)
    look: dict[str, Any] = {"facecolor": "white", "edgecolor": Ink.BLACK, "linewidth": 0.9}
    box = Rectangle(corner, width / DOUBLE, height / _HEIGHT, transform=figure.transFigure, **look)
    figure.add_artist(box)
    figure.text(centre / DOUBLE, level / _HEIGHT, name, ha="center", va="center", fontsize=8, linespacing=1.0)
    top = beneath.get_position().y1
    for tail, head in (
        ((centre - 0.5 * width - 2.5, level), (centre - 0.5 * width, level)),
        ((centre + 0.5 * width, level), (centre + 0.5 * width + 2.5, level)),
        ((centre, _HEIGHT * top + 1.0), (centre, level - 0.5 * height)),
    ):
        ends = [(x / DOUBLE, y / _HEIGHT) for x, y in (head, tail)]
        beneath.annotate(
            "", ends[0], ends[1], xycoords="figure fraction", textcoords="figure fraction",
            arrowprops=_ARROW, annotation_clip=False,
        )  # fmt: skip


def figure_15() -> Figure:
    """Response of the skin to waves of pressure and of shear: signed amplitude and phase, and the steep skirts."""
    layer = Finger(Layered(Layer(_RUBBER, _THICKNESS)), _SENSOR)
    figure = new_figure(DOUBLE, 90.0)
    grid = figure.add_gridspec(2, 2, height_ratios=(3, 2), width_ratios=(6, 5))
    amplitude = figure.add_subplot(grid[0, 0])
    phase = figure.add_subplot(grid[1, 0], sharex=amplitude)
    skirts = figure.add_subplot(grid[:, 1])
    s = np.linspace(0, 0.7, 701)
    far = np.linspace(0, 2.0, 2001)[1:]
    for finger, name, style in ((_FINGER, "half plane", "-"), (layer, "bonded, 3 depths thick", DASHED)):
        near, long = (spatial_response(finger, 2 * np.pi * v) for v in (s, far))
        # the part in phase with the pressure, and that a quarter of a wave off the shear
        signed = np.stack([near.amplitude[:, 0, 0].real, near.amplitude[:, 0, 1].imag], axis=-1)
        for load, colour in enumerate(COLOURS):
            amplitude.plot(s, signed[:, load], color=colour, ls=style, label=f"{LOADS[load]}, {name}")
            skirts.plot(far, long.magnitude[:, 0, load], color=colour, ls=style)
            if finger is _FINGER:
                angle = np.degrees(near.phase[:, 0, load])
                jump = np.flatnonzero(np.abs(np.diff(angle)) > 90)
                angle[[*jump, *(jump + 1)]] = np.nan
                angle[near.magnitude[:, 0, load] == 0] = np.nan
                phase.plot(s, angle, color=colour)
    peak = 1 / (2 * np.pi)
    zero_line(amplitude)
    for axes in (amplitude, phase):
        axes.axvline(peak, color=Ink.GREY, lw=0.6, ls=(0, (2, 2)), zorder=0.6)
    amplitude.plot([peak, peak], [-1.5 / math.e, 0], "o", ms=4, mfc="white", mec=Ink.BLACK, zorder=3)
    amplitude.text(peak + 0.015, -0.66, "pressure: $-3/2e$, at $\\lambda = 2\\pi d$", va="top", fontsize=7)
    amplitude.text(peak + 0.015, -0.06, "shear: 0", va="top", fontsize=7)
    amplitude.set(ylabel="amplitude $E\\,H$, signed", ylim=(-1.65, 0.3), xlim=(0, 0.7))
    amplitude.tick_params(labelbottom=False)
    phase.set(xlabel="waves per depth $s\\,d$", ylabel="phase [degrees]", ylim=(-115, 200))
    phase.yaxis.set_major_locator(FixedLocator([-90, 0, 90, 180]))
    density = sensor_density(_FINGER, 1e3)
    for load, colour in enumerate(COLOURS):
        edge, level = float(density.nyquist[load]) / (2 * np.pi), float(density.largest[load]) / 1e3
        skirts.plot(edge, level, "o", ms=4.5, mfc="white", mec=colour, zorder=3)
        side, align = ((8, 4), "left") if not load else ((-8, -4), "right")
        look: dict[str, Any] = {"fontsize": 7, "color": colour, "ha": align, "va": "center"}
        skirts.annotate(f"{edge:.3f}", (edge, level), side, textcoords="offset points", **look)
    decades(skirts, 2e-4, 3.0)
    skirts.set(xlim=(0, 2.0), xlabel="waves per depth $s\\,d$", ylabel="size $E\\,|H|$")
    skirts.set_title("○ a thousandth of the peak", fontweight="normal", fontsize=7)
    legend(figure, amplitude, loc="outside upper center", ncols=4)
    return figure
