"""Frames along time: contacts on the skin, how probable each kind is, readings and the offset that was followed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from .. import _check
from .._check import FloatArray
from ..decide import TypeDecision
from ..errors import GeometryError, InvalidValueError
from ..estimate import Estimate, Status
from .style import DOUBLE, MM, SINGLE, Ink, finished, legend, new_figure

__all__ = ["contact_strip", "drift_figure", "probability_strip"]

_COLOURS = (Ink.BLUE, Ink.VERMILLION, Ink.GREEN, Ink.ORANGE, Ink.PINK, Ink.SKY)


@finished
def contact_strip(found: Estimate, *, origin: float = 0.0) -> Figure:
    """Where each frame's contact lies on the skin, as wide as it is, and how hard it presses.

    Frames that are OK are drawn full, ambiguous ones pale; the others have no contact to draw.

    Parameters
    ----------
    found : Estimate, shape (m,)
        What `Finger.fit` found in frames in the order of time.
    origin : float, optional
        The finger's y = 0 on the axis of the figure [m].

    Raises
    ------
    GeometryError
        Not a row of frames.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.line(count=7, pitch=1e-3, depth=2e-3, noise=2e-5)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    >>> rolling = ss.Hertz(force=40.0, half_width=2e-3, position=np.linspace(-1e-3, 1e-3, 5))
    >>> figure = contact_strip(finger.fit(finger.read(rolling), "hertz"))
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['position along the skin, $y$ [mm]', 'force [N/m]']
    """
    frames = _row(found.shape)
    figure = new_figure(SINGLE, 80.0)
    position, force = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    centre, half = MM * (found.position + origin), MM * found.half_width
    for status, alpha, name in ((Status.OK, 1.0, "ok"), (Status.AMBIGUOUS, 0.35, "ambiguous")):
        chosen = found.status == status
        if chosen.any():
            at, middle, wide = frames[chosen], centre[chosen], half[chosen]
            look: dict[str, Any] = {"color": Ink.SKY, "alpha": alpha, "linewidth": 0, "label": f"contact, {name}"}
            position.bar(at, 2 * wide, 1.0, middle - wide, **look)
            position.plot(at, middle, ".", color=Ink.BLUE, markersize=2.5, alpha=alpha)
    _marks(position, frames, found.status)
    position.set_ylabel("position along the skin, $y$ [mm]")
    normal, drag = found.force * np.cos(found.angle), found.force * np.sin(found.angle)
    force.plot(frames, normal, ".", color=Ink.BLACK, markersize=2.5, label="normal")
    force.plot(frames, drag, ".", color=Ink.VERMILLION, markersize=2.5, label="drag")
    force.legend(loc="best")
    force.set(xlabel="frame", ylabel=f"force [{found.force_unit}]", xlim=(-0.5, frames[-1] + 0.5))
    legend(figure, position, loc="outside upper left", ncols=3)
    return figure


def _row(shape: tuple[int, ...]) -> npt.NDArray[np.intp]:
    """The numbers of the frames."""
    if len(shape) != 1 or not shape[0]:
        fix = "readings[None]" if not shape else "found[0]" if shape[0] else "readings of some frames"
        raise GeometryError(f"frames of shape {shape}", "a row of at least one frame is needed", fix)
    return np.arange(shape[0])


def _marks(axes: Axes, frames: npt.NDArray[np.intp], status: npt.NDArray[np.int8]) -> None:
    """Frames that have nothing to draw: along the upper edge."""
    for kind, colour, name in (
        (Status.UNEXPLAINED, Ink.VERMILLION, "unexplained"),
        (Status.NO_CONTACT, Ink.GREY, "no contact"),
        (Status.INCOMPLETE, Ink.PINK, "incomplete"),
    ):
        at = frames[status == kind]
        if at.size:
            edge: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "clip_on": False}
            axes.plot(at, np.full(at.size, 1.03), "|", color=colour, markersize=5, label=name, **edge)


@finished
def probability_strip(said: TypeDecision) -> Figure:
    """How probable each kind of contact is in each frame, stacked, and what was decided.

    Parameters
    ----------
    said : TypeDecision, shape (m,)
        What `decide.contact_type` said of frames in the order of time.

    Raises
    ------
    GeometryError
        Not a row of frames.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.line(count=7, pitch=1e-3, depth=2e-3, noise=2e-5)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    >>> rolling = ss.Hertz(force=40.0, half_width=2e-3, position=np.linspace(-1e-3, 1e-3, 5))
    >>> figure = probability_strip(ss.decide.contact_type(finger, finger.read(rolling)))
    >>> figure.axes[0].get_ylabel()
    'probability'
    """
    frames = _row(said.shape)
    share, base = np.nan_to_num(said.probability), np.zeros(frames.size)
    figure = new_figure(SINGLE, 62.0)
    axes = figure.subplots()
    for i, name in enumerate(said.names):
        axes.bar(frames, share[:, i], 1.0, base, color=_COLOURS[i % len(_COLOURS)], linewidth=0, label=name)
        base += share[:, i]
    axes.axhline(said.sure, color=Ink.BLACK, linewidth=0.6, linestyle="--", label=f"{said.sure:g}: decided")
    unsure = frames[said.status == Status.AMBIGUOUS]
    if unsure.size:
        axes.plot(unsure, np.full(unsure.size, 1.04), "v", color=Ink.GREY, markersize=3, label="cannot tell")
    axes.set(xlabel="frame", ylabel="probability", xlim=(-0.5, frames[-1] + 0.5), ylim=(0, 1.08))
    _marks(axes, frames, said.status)
    legend(figure, axes, first=said.names, loc="outside upper left", ncols=3)
    return figure


if TYPE_CHECKING:
    from ..stream import Tared


_FREE = "#E3F1EA"


@finished
def drift_figure(
    readings: npt.ArrayLike,
    time: npt.ArrayLike,
    tared: Tared,
    *,
    sensor: int = 0,
    truth: npt.ArrayLike | None = None,
    unit: str = "",
) -> Figure:
    """One sensor's readings and its offset as `Tare` followed it; below, the offset alone, enlarged.

    Parameters
    ----------
    readings : array_like, shape (m, n)
        The stream as it came [units of the transducers].
    time : array_like, shape (m,)
        Time of each frame [s].
    tared : Tared
        What `Tare` made of it.
    sensor : int, optional
        Which sensor, from 0.
    truth : array_like, shape (m,), optional
        The sensor's true offset, where known [unit of its transducer].
    unit : str, optional
        Unit of a reading, for the axes.

    Raises
    ------
    GeometryError
        Shapes that do not match.
    InvalidValueError
        A sensor that is not there.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=1e-4))
    >>> time = np.arange(0.0, 10.0, 0.01)
    >>> raw = finger.read(ss.LineLoad(40.0 * (time > 5.0)), np.random.default_rng(0))
    >>> figure = drift_figure(raw, time, ss.Tare(finger)(raw, time))
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['reading', 'offset']
    """
    data = _check.real("readings", _check.readings(readings), finite=False)
    clock = _check.real("time", time, unit="s")
    if data.ndim != 2 or tared.offset.shape != data.shape or clock.shape != data.shape[:1] or not clock.size:
        raise GeometryError(
            f"readings of shape {data.shape}, time {clock.shape}, offsets {tared.offset.shape}",
            "a stream of at least a frame and what Tare made of it are needed",
            "drift_figure(readings, time, tare(readings, time))",
        )
    if not 0 <= sensor < data.shape[1]:
        raise InvalidValueError(f"sensor = {sensor}", f"the stream has sensors 0 to {data.shape[1] - 1}", "sensor=0")
    true = None if truth is None else _check.real("truth", truth)
    if true is not None and true.shape != clock.shape:
        raise GeometryError(
            f"truth of shape {true.shape}", f"one for each of the {clock.size} frames", "leave out truth"
        )
    followed = tared.offset[:, sensor]
    figure = new_figure(DOUBLE, 84.0)
    panels = figure.subplots(2, 1, sharex=True, height_ratios=(1.0, 1.0))
    panels[0].plot(clock, data[:, sensor], color=Ink.BLUE, lw=0.6, label="read")
    for axes in panels:
        _shade(axes, clock, tared.free)
        axes.plot(clock, followed, color=Ink.VERMILLION, lw=1.2, label="offset, followed", zorder=3)
        if true is not None:
            axes.plot(clock, true, color=Ink.BLACK, lw=0.8, ls=(0, (3, 2)), label="offset, true", zorder=4)
    seen = np.concatenate([followed[np.isfinite(followed)], np.empty(0) if true is None else true])
    if seen.size and np.ptp(seen) > 0:
        margin = 0.15 * float(np.ptp(seen))
        panels[1].set_ylim(float(seen.min()) - margin, float(seen.max()) + margin)
    of = f" [{unit}]" if unit else ""
    panels[0].set(ylabel=f"reading{of}", xlim=(clock[0], clock[-1] if clock[-1] > clock[0] else clock[0] + 1))
    panels[1].set(ylabel=f"offset{of}", xlabel="time [s]")
    panels[0].set_title(f"sensor {sensor}", fontweight="normal")
    handles, _ = panels[0].get_legend_handles_labels()
    handles.append(Patch(facecolor=_FREE, label="taken for free of contact"))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


def _shade(axes: Axes, clock: FloatArray, free: npt.NDArray[np.bool_]) -> None:
    """A band over each stretch of free skin."""
    edges = np.diff(np.concatenate([[0], free.astype(np.int8), [0]]))
    ends = np.append(clock, clock[-1])
    for a, b in zip(clock[edges[:-1] == 1], ends[edges == -1], strict=True):
        axes.axvspan(float(a), float(b), color=_FREE, lw=0, zorder=0)
