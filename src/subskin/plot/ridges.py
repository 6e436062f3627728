"""The gain by ridges: over pitch and width of the contact, as they are pressed, and the memo's Fig. 16."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .._check import FloatArray
from ..array import SensorArray
from ..contact import Hertz
from ..design import Ridges, best_ridge_pitch, ridge_gain
from ..design.ridges import PressedRidges, RidgeGain, read_ridged
from ..errors import GeometryError
from ..finger import Finger
from .memo_lines import UNIT_SKIN
from .style import DASHED, DOUBLE, Ink, finished, legend, new_figure, plain, zero_line

__all__ = ["figure_16", "pressed_ridges_figure", "ridge_figure"]

_LINES = {
    "peak": ("largest anywhere", "#BBBBBB", "-"),
    "beneath": ("beneath a ridge", Ink.BLUE, "-"),
    "between": ("between two", Ink.VERMILLION, "-"),
    "ripple": ("the ridges' part", Ink.GREEN, DASHED),
}
_LEVELS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.1, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0)
_TITLES = ("At the same peak pressure", "At the same load")
_PITCH, _WIDTH = "pitch / depth", "half width of the contact / depth"


@finished
def ridge_figure(found: RidgeGain) -> Figure:
    """Gains at equal peak pressure (left) and at equal load (right).

    Against the pitch or the contact's half width, whichever changes; of both, as a map of the gain of the largest
    reading.

    Parameters
    ----------
    found : RidgeGain
        From `subskin.design.ridge_gain`, of shape (m,), or (w, m) with half widths along the first axis and pitches
        along the second; three or more of each.

    Raises
    ------
    GeometryError
        Another shape, or nothing that changes along an axis.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray(y=[0.0], depth=0.5e-3))
    >>> ridges = ss.design.Ridges(pitch=np.array([1e-3, 2e-3, 3e-3]))
    >>> figure = ridge_figure(ss.design.ridge_gain(finger, ss.Hertz(force=40.0, half_width=5e-3), ridges))
    >>> figure.axes[0].get_xlabel()
    'pitch / depth'
    """
    shape = found.pitch.shape
    if len(shape) not in (1, 2) or min(shape) < 3:
        rule = "a row of three or more is needed, or a table of half widths and pitches"
        fix = "Hertz(40.0, half_width=widths[:, None]), Ridges(pitches)"
        raise GeometryError(f"gains of shape {shape}", rule, fix)
    figure = new_figure(DOUBLE, 78.0 if len(shape) == 2 else 70.0)
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    draw = _map if len(shape) == 2 else _curves
    for axes, equal, title in zip(panels, ("equal_peak", "equal_load"), _TITLES, strict=True):
        draw(axes, found, equal)
        axes.set_title(title)
    if len(shape) == 1:
        panels[0].set_ylim(0.0, 1.05 * max(float(np.nanmax(g)) for g in (*found.equal_peak, *found.equal_load)))
    legend(figure, panels[0], ncols=4)
    return figure


def _curves(axes: Axes, found: RidgeGain, equal: str) -> None:
    along, label = found.pitch / found.depth, _PITCH
    if np.ptp(along) == 0:
        along, label = found.half_width / found.depth, _WIDTH
    if np.ptp(along) == 0:
        raise GeometryError(
            "one pitch and one half width", "one of the two has to change along the row", "Ridges(pitches)"
        )
    for name, (text, colour, dash) in _LINES.items():
        wide = 3.0 if name == "peak" else 1.2  # it shows where another line lies on it
        values = getattr(getattr(found, equal), name)
        axes.plot(along, values, color=colour, linestyle=dash, linewidth=wide, label=text)
    axes.axhline(1.0, color=Ink.GREY, linewidth=0.5, zorder=0.5)
    axes.set_xlabel(label)
    if equal == "equal_peak":
        axes.set_ylabel("gain over a smooth skin")
    _log(axes, along)


def _log(axes: Axes, values: FloatArray) -> None:
    """A logarithmic axis where the values span it."""
    if values.max() > 8 * values.min():
        axes.set_xscale("log")
        plain(axes.xaxis, small=True)
    axes.set_xlim(values.min(), values.max())


def _map(axes: Axes, found: RidgeGain, equal: str) -> None:
    pitch, width = found.pitch / found.depth, found.half_width / found.depth
    if np.ptp(pitch, axis=0).any() or np.ptp(width, axis=1).any():
        raise GeometryError(
            "a table of gains with mixed axes",
            "half widths go along the first axis, pitches along the second",
            "Hertz(40.0, half_width=widths[:, None]), Ridges(pitches)",
        )
    gain = np.ma.masked_invalid(getattr(found, equal).peak)
    filled = axes.contourf(pitch, width, np.log(gain), levels=np.log(_LEVELS), cmap="PuOr", extend="both")
    filled.set_clim(-np.log(4.0), np.log(4.0))
    lines = axes.contour(pitch, width, gain, levels=_LEVELS, colors=Ink.BLACK, linewidths=0.5)
    axes.clabel(lines, fmt=lambda level: f"{level:g}", fontsize=7)
    axes.set_yscale("log")
    plain(axes.yaxis, small=True)
    ends, text = np.array([pitch.min(), pitch.max()]), "a contact as wide as the pitch"
    axes.plot(ends, 0.5 * ends, color=Ink.VERMILLION, linewidth=1.0, linestyle=DASHED, label=text)
    axes.set(ylim=(width.min(), width.max()), xlabel=_PITCH)
    if equal == "equal_peak":
        axes.set_ylabel(_WIDTH)
    _log(axes, pitch[0])


@finished
def pressed_ridges_figure(found: PressedRidges) -> Figure:
    """Gain, and how far the ridges touch, against their height over that which the load presses flat.

    Parameters
    ----------
    found : PressedRidges
        From `subskin.design.press_ridges`, of shape (m,), m >= 3: several amplitudes (> 0), or several forces.

    Raises
    ------
    GeometryError
        Another shape; ridges of no height.

    Examples
    --------
    >>> import subskin as ss
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray(y=[0.0], depth=0.5e-3))
    >>> found = ss.design.ridges.press_ridges(finger, 3e-3, [5e-6, 20e-6, 60e-6], force=200.0, radius=50e-3)
    >>> pressed_ridges_figure(found).axes[0].get_xlabel()
    'closing pressure / greatest smooth pressure'
    """
    if found.pitch.ndim != 1 or found.pitch.size < 3 or not (found.amplitude > 0).all():
        raise GeometryError(
            f"presses of shape {found.pitch.shape}",
            "a row of three or more, of ridges that have a height, is needed",
            "press_ridges(finger, pitch, heights, ...)",
        )
    order = np.argsort(found.filling)[::-1]
    along = (1 / found.filling)[order]
    figure = new_figure(DOUBLE, 70.0)
    gains, touches = figure.subplots(1, 2, sharex=True)
    gains.plot(along, found.solved.peak[order], "o-", color=Ink.BLACK, ms=3, label="solved")
    assumed = f"smooth pressure times {found.shape}"
    gains.plot(along, found.assumed.peak[order], color=Ink.GREY, linestyle=DASHED, label=assumed)
    gains.set_ylim(0.0, 1.15 * float(max(found.solved.peak.max(), found.assumed.peak.max())))
    gains.set_ylabel("gain of the largest reading")
    gains.set_title("At the same load")
    touches.plot(along, found.touching[order], "o-", color=Ink.BLUE, ms=3, label="share of the width that touches")
    valley = "pressure in the valley / at the crest"
    touches.plot(along, found.valley[order], "s-", color=Ink.VERMILLION, ms=3, label=valley)
    touches.set(ylabel="share", ylim=(-0.03, 1.25))
    touches.set_title("How far the ridges touch")
    for axes in (gains, touches):
        axes.axvline(1.0, color=Ink.GREY, linewidth=0.5, zorder=0.5)
        axes.set_xlabel("closing pressure / greatest smooth pressure")
        _log(axes, along)
        axes.set_xlim(along.min() / 1.1, along.max() * 1.1)
    legend(figure, gains, touches, ncols=2)
    return figure


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
        above.fill_between(y, load, color=Ink.VERMILLION, alpha=0.25, linewidth=0)
        above.plot(y, load, color=Ink.VERMILLION)
        zero_line(below)
        below.plot(y, strain, color=Ink.BLUE)
        below.set_xlabel("position along the skin, in depths, $y/d$")
    panels[0, 1].plot(y, pressure, color=Ink.GREY, linewidth=0.7, linestyle=DASHED)
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
            axes.axhline(side * float(found.smooth), color=Ink.GREY, linewidth=0.7, linestyle=DASHED)
    text = "largest strain, here and dashed on the right"
    panels[1, 0].text(0.0, -1.1 * float(found.smooth), text, fontsize=7, color=Ink.GREY, ha="center", va="top")
    return figure


def _sensors(axes: Axes, found: RidgeGain, y: FloatArray, strain: FloatArray) -> None:
    """The sensors of section 6.1: beneath the ridges, and between them."""
    pitch = float(found.pitch)
    last = int(_HALF_WIDTH / (0.5 * pitch))
    number = np.arange(-last, last + 1)
    for odd, mark, face, label in ((0, "o", Ink.BLACK, "sensor beneath a ridge"), (1, "s", "white", "between two")):
        at = 0.5 * pitch * number[number % 2 == odd]
        look: dict[str, Any] = {"ms": 4, "mfc": face, "mec": Ink.BLACK, "mew": 0.9, "zorder": 3, "label": label}
        axes.plot(at, np.interp(at, y, strain), mark, **look)
    axes.legend(loc="upper center", ncols=2, columnspacing=1.0)
