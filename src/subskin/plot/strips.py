"""Answers frame by frame along time: contacts on the skin, and how probable each kind of contact is."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..decide import TypeDecision
from ..errors import GeometryError
from ..estimate.estimate import Estimate, Status
from .style import BLACK, BLUE, GREEN, GREY, ORANGE, PINK, SINGLE, SKY, VERMILLION, house_style, new_figure, settled

__all__ = ["contact_strip", "probability_strip"]

_MM = 1e3
_COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PINK, SKY)


def contact_strip(found: Estimate, *, origin: float = 0.0) -> Figure:
    """Where each frame's contact lies on the skin, as wide as it is, and how hard it presses.

    Frames that are OK are drawn full, ambiguous ones pale; the others have no contact to draw.

    Parameters
    ----------
    found : Estimate, shape (m,)
        What `Finger.fit` found in frames in the order of time.
    origin : float, optional
        The finger's y = 0 on the axis of the figure [m].

    Returns
    -------
    matplotlib.figure.Figure
        84 mm wide; write it with `subskin.plot.save`.

    Raises
    ------
    GeometryError
        Not a row of frames.
    """
    if len(found.shape) != 1 or not found.shape[0]:
        raise GeometryError(f"frames of shape {found.shape}", "a row of at least one frame is needed")
    frames = np.arange(found.shape[0])
    with house_style():
        figure = new_figure(SINGLE, 80.0)
        position, force = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        centre, half = _MM * (found.position + origin), _MM * found.half_width
        for status, alpha, name in ((Status.OK, 1.0, "ok"), (Status.AMBIGUOUS, 0.35, "ambiguous")):
            chosen = found.status == status
            if chosen.any():
                position.bar(
                    frames[chosen], 2 * half[chosen], 1.0, centre[chosen] - half[chosen], color=SKY, alpha=alpha,
                    linewidth=0, label=f"contact, {name}",
                )  # fmt: skip
                position.plot(frames[chosen], centre[chosen], ".", color=BLUE, markersize=2.5, alpha=alpha)
        _marks(position, frames, found.status)
        position.set_ylabel("place along the skin, $y$ [mm]")
        normal, drag = found.force * np.cos(found.angle), found.force * np.sin(found.angle)
        force.plot(frames, normal, ".", color=BLACK, markersize=2.5, label="normal")
        force.plot(frames, drag, ".", color=VERMILLION, markersize=2.5, label="drag")
        force.legend(loc="best")
        force.set_ylabel("force [N/m]")
        force.set_xlabel("frame")
        force.set_xlim(-0.5, frames[-1] + 0.5)
        figure.legend(*position.get_legend_handles_labels(), loc="outside upper left", ncols=3)
        return settled(figure)


def _marks(axes: Axes, frames: npt.NDArray[np.intp], status: npt.NDArray[np.int8]) -> None:
    """Frames that have nothing to draw: along the upper edge."""
    for kind, colour, name in (
        (Status.UNEXPLAINED, VERMILLION, "unexplained"),
        (Status.NO_CONTACT, GREY, "no contact"),
        (Status.INCOMPLETE, PINK, "incomplete"),
    ):
        chosen = status == kind
        if chosen.any():
            at = np.full(int(chosen.sum()), 1.03)
            axes.plot(
                frames[chosen], at, "|", color=colour, markersize=5, transform=axes.get_xaxis_transform(),
                clip_on=False, label=name,
            )  # fmt: skip


def probability_strip(said: TypeDecision) -> Figure:
    """How probable each kind of contact is in each frame, stacked, and what was decided.

    Parameters
    ----------
    said : TypeDecision, shape (m,)
        What `decide.contact_type` said of frames in the order of time.

    Returns
    -------
    matplotlib.figure.Figure
        84 mm wide; write it with `subskin.plot.save`.

    Raises
    ------
    GeometryError
        Not a row of frames.
    """
    if len(said.shape) != 1 or not said.shape[0]:
        raise GeometryError(f"frames of shape {said.shape}", "a row of at least one frame is needed")
    share = np.nan_to_num(said.probability)
    frames = np.arange(said.shape[0])
    base = np.zeros(frames.size)
    with house_style():
        figure = new_figure(SINGLE, 62.0)
        axes = figure.subplots()
        for i, name in enumerate(said.names):
            axes.bar(frames, share[:, i], 1.0, base, color=_COLOURS[i % len(_COLOURS)], linewidth=0, label=name)
            base += share[:, i]
        axes.axhline(said.sure, color=BLACK, linewidth=0.6, linestyle="--", label=f"{said.sure:g}: decided")
        unsure = said.status == Status.AMBIGUOUS
        if unsure.any():
            at = np.full(int(unsure.sum()), 1.04)
            axes.plot(frames[unsure], at, "v", color=GREY, markersize=3, label="cannot tell")
        axes.set_ylim(0, 1.08)
        axes.set_xlim(-0.5, frames[-1] + 0.5)
        axes.set_ylabel("probability")
        axes.set_xlabel("frame")
        _marks(axes, frames, said.status)
        handles, names = axes.get_legend_handles_labels()
        order = sorted(range(len(names)), key=lambda i: names[i] not in said.names)  # the kinds first
        figure.legend([handles[i] for i in order], [names[i] for i in order], loc="outside upper left", ncols=3)
        return settled(figure)
