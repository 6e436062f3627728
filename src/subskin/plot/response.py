"""The skin as a filter: the response to waves, the density of sensors that follows, and the error between them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from ..design.response import SpatialResponse
from ..design.sampling import AliasingError, SensorDensity
from ..errors import GeometryError
from .style import DASHED, DOUBLE, MM, SINGLE, Ink, finished, legend, new_figure, unit_of, zero_line

__all__ = ["aliasing_figure", "decades", "density_figure", "response_figure"]

LOADS = ("pressure", "shear")
COLOURS = (Ink.BLUE, Ink.VERMILLION)
_FLOOR = 1e-4
_KINDS = 3
_LINES = ("-", (0, (5, 2)), (0, (1.5, 1.5)))


@finished
def response_figure(found: SpatialResponse) -> Figure:
    """Size and phase of the readings under waves of pressure and of shear, against their frequency.

    Sensors that differ in depth, transducer, width or gain have lines of their own, up to three kinds of them. Where
    the row is even the wave of two pitches, the shortest that it can sample, is marked. A round finger has dots, for
    only whole numbers of waves close round it.

    Parameters
    ----------
    found : SpatialResponse, shape (m,)
        From `subskin.design.spatial_response`, at three wavenumbers or more.

    Raises
    ------
    GeometryError
        Wavenumbers that are no row of three or more.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3))
    >>> figure = response_figure(ss.design.spatial_response(finger))
    >>> [axes.get_title(loc="left") for axes in figure.axes[:2]]
    ['Pressure', 'Shear']
    """
    k = np.asarray(found.wavenumber)
    if k.ndim != 1 or k.size < 3:
        raise GeometryError(f"wavenumbers of shape {k.shape}", "a row of three or more is drawn", "k[:, 0]")
    order = np.argsort(k)
    frequency = found.frequency[order] / MM
    kinds = _kinds(found)
    magnitude, phase = found.magnitude[order] * 1e3, np.degrees(found.phase[order])
    phase = np.where(phase < -170, phase + 360, phase)  # half a turn is drawn as +180
    top = float(magnitude.max())
    dots = found.finger.skin.curvature > 0
    figure = new_figure(DOUBLE, 92.0)
    panels = figure.subplots(2, 2, sharex=True, sharey="row", height_ratios=(3, 2))
    lines = []
    for load, (upper, lower) in enumerate(panels.T):
        for i, sensor in enumerate(kinds):
            style: dict[str, Any] = {"color": COLOURS[load], "ls": "" if dots else _LINES[i]}
            style |= {"marker": "osD"[i] if dots else "", "ms": 2.6}
            size = magnitude[:, sensor, load]
            lines += upper.plot(frequency, np.where(size > 0, size, np.nan), label=_named(found, sensor), **style)
            angle = np.where(size > _FLOOR * top, phase[:, sensor, load], np.nan)
            if not (dots or i) and len(kinds) > 1:
                style |= {"lw": 3.5, "alpha": 0.35}  # the others lie upon it
            lower.plot(frequency, angle if dots else _broken(angle), **style)
        upper.set_title(LOADS[load].capitalize())
        decades(upper, _FLOOR * top, 2 * top)
        lower.set_ylim(-105, 195)
        lower.yaxis.set_major_locator(FixedLocator([-90, 0, 90, 180]))
        lower.set_xlabel("spatial frequency [1/mm]")
        _nyquist(upper, lower, found)
    upper.set_xlim(0, frequency[-1])
    unit = unit_of(found.finger, otherwise="each its own unit") or "1"
    panels[0, 0].set_ylabel(f"reading [{unit}/kPa]")
    panels[1, 0].set_ylabel("phase [degrees]")
    if len(kinds) > 1:
        figure.legend(handles=lines[: len(kinds)], loc="outside upper center", ncols=3)
    return figure


def decades(axes: Axes, low: float, high: float) -> None:
    """A vertical axis of powers of ten, each with its number, and no ticks that a further draw could add."""
    axes.set(yscale="log", ylim=(low, high))
    powers = np.arange(np.ceil(np.log10(low) - 1e-9), np.floor(np.log10(high) + 1e-9) + 1)
    axes.yaxis.set_major_locator(FixedLocator((10.0**powers).tolist()))
    axes.yaxis.set_minor_locator(NullLocator())


def _kinds(found: SpatialResponse) -> list[int]:
    """The first sensor of each kind."""
    array = found.finger.array
    names = ("depth", "width", "gain")
    rows = zip(array.transducers, *(np.asarray(getattr(array, n)).tolist() for n in names), strict=True)
    first: dict[object, int] = {}
    for sensor, kind in enumerate(rows):
        first.setdefault(kind, sensor)
    return list(first.values())[:_KINDS]


def _named(found: SpatialResponse, sensor: int) -> str:
    array = found.finger.array
    depth, width = (MM * float(np.asarray(v)[sensor]) for v in (array.depth, array.width))
    wide = f", {width:.3g} mm wide" if width else ""
    return f"{type(array.transducers[sensor]).__name__}, {depth:.3g} mm deep{wide}"


def _broken(angle: np.ndarray) -> np.ndarray:
    """A gap where the phase jumps, that no upright line is drawn there."""
    jumps = np.abs(np.diff(angle, prepend=angle[:1])) > 60
    return np.where(jumps, np.nan, angle)


def _nyquist(upper: Axes, lower: Axes, found: SpatialResponse) -> None:
    """The shortest wave that an even row can sample."""
    gaps = np.diff(np.sort(np.asarray(found.finger.array.y)))
    if gaps.size and gaps.min() > 0 and np.ptp(gaps) < 1e-9 * gaps.max():
        at = 0.5 / (MM * float(gaps.mean()))
        for axes in (upper, lower):
            axes.axvline(at, color=Ink.GREY, lw=0.7, ls=(0, (2, 2)), zorder=0.6)
        if 0.1 < at * MM / float(found.frequency.max()) < 0.95:  # within the panel, along the line
            note: dict[str, Any] = {"ha": "right", "va": "bottom", "rotation": 90, "fontsize": 7, "color": Ink.GREY}
            upper.annotate("two pitches", (at, 0.04), (-1, 0), ("data", "axes fraction"), "offset points", **note)


@finished
def density_figure(found: SensorDensity) -> Figure:
    """What is read of each wave, against its largest, and where the row has to reach for each attenuation.

    Parameters
    ----------
    found : SensorDensity, shape () or (a,)
        From `subskin.design.sensor_density`.

    Raises
    ------
    GeometryError
        Attenuations of more than one axis.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray(y=[0.0], depth=2e-3))
    >>> figure = density_figure(ss.design.sensor_density(finger, [100, 1000]))
    >>> figure.axes[0].get_xlabel()
    'spatial frequency [1/mm]'
    """
    if found.attenuation.ndim > 1:
        raise GeometryError(
            f"attenuations of shape {found.attenuation.shape}", "a row of them is drawn", "attenuation=[10, 100, 1000]"
        )
    wanted = np.atleast_1d(found.attenuation)
    pitch = found.pitch.reshape(wanted.size, 2)
    last = 1.25 * np.pi / float(np.nanmin(pitch))
    turn = found.finger.skin.curvature
    dots = turn > 0
    k = turn * np.arange(np.ceil(last / turn) + 1) if dots else np.linspace(last / 1200, last, 1200)
    sizes = found.relative(k)
    lowest = 0.1 / float(wanted.max())
    figure = new_figure(SINGLE, 76.0)
    axes = figure.subplots()
    for load in (0, 1):
        if not np.isfinite(found.largest[load]):
            continue
        size = np.where(sizes[:, load] > 0, sizes[:, load], np.nan)
        axes.plot(k / (2 * np.pi * MM), size, "o" if dots else "-", color=COLOURS[load], ms=2.6, label=LOADS[load])
        ends = 0.5 / (MM * pitch[:, load])
        axes.plot(ends, 1 / wanted, ls="", marker="o", ms=4.5, mfc="white", mec=COLOURS[load], zorder=3)
    for ratio in wanted:
        axes.axhline(1 / ratio, color=Ink.GREY, lw=0.5, zorder=0.5)
    decades(axes, lowest, 2.0)
    axes.set(xlim=(0, last / (2 * np.pi * MM)), xlabel="spatial frequency [1/mm]")
    axes.set_ylabel("read of a wave / of the wave read most")
    above = axes.twiny()  # the same frequencies, as the pitch of which each is the Nyquist frequency
    above.spines["top"].set_visible(True)
    above.set(xlim=axes.get_xlim(), xlabel="pitch of the sensors [mm]")
    pitches = _round_pitches(last)
    above.set_xticks([0.5 / b for b in pitches], [f"{b:g}" for b in pitches])
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _round_pitches(last: float) -> list[float]:
    """Round numbers of mm, wide apart enough on the axis."""
    least = MM * np.pi / last
    numbers = [m * 10.0**p for p in range(-4, 5) for m in (1, 1.5, 2, 3, 5)]
    chosen: list[float] = []
    for number in sorted(n for n in numbers if n >= least):
        if not chosen or 1 / chosen[-1] - 1 / number > 0.1 / least:
            chosen.append(number)
    return chosen


@finished
def aliasing_figure(found: AliasingError, shift: int | None = None) -> Figure:
    """The reading along the skin, the samples of a row, what is recovered from them, and its error with the bound.

    Parameters
    ----------
    found : AliasingError
        From `subskin.design.aliasing_error`.
    shift : int, optional
        Which shift of the row is drawn in full; the one with the largest error if left out.

    Raises
    ------
    GeometryError
        A shift that is not there.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray(y=[0.0], depth=2e-3))
    >>> found = ss.design.aliasing_error(finger, ss.LineLoad(force=40.0), pitch=2e-3)
    >>> [axes.get_ylabel() for axes in aliasing_figure(found).axes]
    ['reading [% of largest]', 'error [% of largest]']
    """
    worst = int(np.unravel_index(np.argmax(np.abs(found.error)), found.error.shape)[0])
    row = worst if shift is None else shift
    if not 0 <= row < found.shift.size:
        raise GeometryError(f"shift = {shift!r}", f"there are 0 to {found.shift.size - 1}", "shift=0")
    y, scale = MM * found.position, 100 / found.full_scale
    centre = 0.5 * (y[0] + y[-1])
    first = centre + MM * found.shift[row]
    step = MM * found.pitch
    at = first + step * np.arange(np.ceil((y[0] - first) / step), np.floor((y[-1] - first) / step) + 1)
    recovered = scale * (found.reading + found.error[row])
    figure = new_figure(SINGLE, 92.0)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    upper.plot(y, scale * found.reading, color=Ink.BLACK, label="true reading")
    upper.plot(y, recovered, color=Ink.ORANGE, ls=DASHED, label="recovered")
    samples = scale * np.interp(at, y, found.reading)
    upper.plot(at, samples, "o", ms=4, mfc="white", mec=Ink.BLUE, label="sensors")
    upper.set_ylabel("reading [% of largest]")
    band = scale * np.abs(found.error).max(axis=0)
    lower.fill_between(y, -band, band, color=Ink.ORANGE, alpha=0.2, lw=0, label="any shift of the row")
    lower.plot(y, scale * found.error[row], color=Ink.ORANGE, label="error")
    for side in (-100, 100):
        lower.axhline(side * found.bound, color=Ink.GREEN, lw=0.8, ls=DASHED, label="bound" * (side > 0))
    lower.set(xlabel="position along the skin $y$ [mm]", ylabel="error [% of largest]")
    lower.set(xlim=(y[0], y[-1]), ylim=(-115 * found.bound, 115 * found.bound))
    zero_line(upper)
    zero_line(lower)
    legend(figure, upper, lower, ncols=3)
    return figure
