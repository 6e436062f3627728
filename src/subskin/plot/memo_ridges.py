"""The memo's figure on ridges (Fig. 16): the strain beneath a smooth and beneath a ridged skin."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .._check import FloatArray
from ..array import SensorArray
from ..contact import Hertz
from ..design import Ridges, best_ridge_pitch, ridge_gain
from ..design.ridges import RidgeGain, read_ridged
from ..finger import Finger
from .memo_lines import UNIT_SKIN
from .parts import zero_line
from .style import BLACK, BLUE, DASHED, DOUBLE, GREY, VERMILLION, new_figure

__all__ = ["figure_16"]

# Depth, modulus and peak pressure are 1: positions come out in units of d, strains in units of p0/E.
_HALF_WIDTH = 10.0
_REACH = 13.0
_NODES = 261


def figure_16() -> Figure:
    """Effect of ridges on strain amplitude: a cylinder on a smooth skin, and on ridges of the best pitch."""
    one = Finger(UNIT_SKIN, SensorArray(y=[0.0], depth=1.0))
    ridges = Ridges(best_ridge_pitch(one).pitch[0], shape="abs_cos")
    touch = Hertz(0.5 * np.pi * _HALF_WIDTH, half_width=_HALF_WIDTH)
    found = ridge_gain(one, touch, ridges)
    y = np.linspace(-_REACH, _REACH, _NODES)
    row = Finger(UNIT_SKIN, SensorArray(y=y, depth=1.0))
    pressure = touch.pressure(y)
    strains = row.read(touch), read_ridged(row, touch, ridges)
    figure = new_figure(DOUBLE, 92.0)
    panels = figure.subplots(2, 2, sharex=True, sharey="row", height_ratios=[1.0, 1.5])
    for (above, below), load, strain in zip(panels.T, (pressure, ridges.share(y) * pressure), strains, strict=True):
        above.fill_between(y, load, color=VERMILLION, alpha=0.25, linewidth=0)
        above.plot(y, load, color=VERMILLION)
        zero_line(below)
        below.plot(y, strain, color=BLUE)
        below.set_xlabel("position along the skin, in depths, $y/d$")
    panels[0, 1].plot(y, pressure, color=GREY, linewidth=0.7, linestyle=DASHED)
    panels[0, 0].set_ylim(0.0, 1.1)
    panels[1, 0].set(xlim=(-_REACH, _REACH), ylim=(-0.34, 0.32))
    panels[0, 0].set_ylabel("pressure $p/p_0$")
    panels[1, 0].set_ylabel(r"strain at depth $d$, $\varepsilon_x E/p_0$")
    gain = float(found.equal_peak.peak)
    panels[0, 0].set_title(f"Smooth: {float(found.load_ratio):.2f} times the load")
    panels[0, 1].set_title(rf"Ridges $2\pi d$ apart: {gain:.2f} times the strain")
    _sensors(panels[1, 1], found, y, strains[1])
    for axes in panels[1]:
        for side in (-1, 1):
            axes.axhline(side * float(found.smooth), color=GREY, linewidth=0.7, linestyle=DASHED)
    text = "largest strain, here and dashed on the right"
    panels[1, 0].text(0.0, -1.1 * float(found.smooth), text, fontsize=7, color=GREY, ha="center", va="top")
    return figure


def _sensors(axes: Axes, found: RidgeGain, y: FloatArray, strain: FloatArray) -> None:
    """The sensors of section 6.1: beneath the ridges, and between them."""
    pitch = float(found.pitch)
    last = int(_HALF_WIDTH / (0.5 * pitch))
    number = np.arange(-last, last + 1)
    for odd, mark, face, label in ((0, "o", BLACK, "sensor beneath a ridge"), (1, "s", "white", "between two")):
        at = 0.5 * pitch * number[number % 2 == odd]
        look: dict[str, Any] = {"ms": 4, "mfc": face, "mec": BLACK, "mew": 0.9, "zorder": 3, "label": label}
        axes.plot(at, np.interp(at, y, strain), mark, **look)
    axes.legend(loc="upper center", ncols=2, columnspacing=1.0)
