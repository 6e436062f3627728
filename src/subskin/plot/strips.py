"""Answers frame by frame along time: contacts on the skin, and how probable each kind of contact is."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..decide import TypeDecision
from ..errors import GeometryError
from ..estimate import Estimate, Status
from .parts import legend
from .style import BLACK, BLUE, GREEN, GREY, MM, ORANGE, PINK, SINGLE, SKY, VERMILLION, finished, new_figure

__all__ = ["contact_strip", "probability_strip"]

_COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PINK, SKY)


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
            look: dict[str, Any] = {"color": SKY, "alpha": alpha, "linewidth": 0, "label": f"contact, {name}"}
            position.bar(at, 2 * wide, 1.0, middle - wide, **look)
            position.plot(at, middle, ".", color=BLUE, markersize=2.5, alpha=alpha)
    _marks(position, frames, found.status)
    position.set_ylabel("position along the skin, $y$ [mm]")
    normal, drag = found.force * np.cos(found.angle), found.force * np.sin(found.angle)
    force.plot(frames, normal, ".", color=BLACK, markersize=2.5, label="normal")
    force.plot(frames, drag, ".", color=VERMILLION, markersize=2.5, label="drag")
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
        (Status.UNEXPLAINED, VERMILLION, "unexplained"),
        (Status.NO_CONTACT, GREY, "no contact"),
        (Status.INCOMPLETE, PINK, "incomplete"),
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
    axes.axhline(said.sure, color=BLACK, linewidth=0.6, linestyle="--", label=f"{said.sure:g}: decided")
    unsure = frames[said.status == Status.AMBIGUOUS]
    if unsure.size:
        axes.plot(unsure, np.full(unsure.size, 1.04), "v", color=GREY, markersize=3, label="cannot tell")
    axes.set(xlabel="frame", ylabel="probability", xlim=(-0.5, frames[-1] + 0.5), ylim=(0, 1.08))
    _marks(axes, frames, said.status)
    legend(figure, axes, first=said.names, loc="outside upper left", ncols=3)
    return figure
