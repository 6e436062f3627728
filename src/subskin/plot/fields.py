"""The receptive fields of a finger: what each sensor reads of a load, wherever it presses."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .. import _check
from ..errors import InvalidValueError
from ..finger import Finger
from .parts import heading, unit_of, zero_line
from .style import DOUBLE, MM, finished, new_figure

__all__ = ["receptive_fields"]


@finished
def receptive_fields(finger: Finger, span: tuple[float, float] | None = None, *, title: str = "") -> Figure:
    """Change of each reading under a normal and a tangential line load of 1 N/m, against the load's position.

    Parameters
    ----------
    finger : Finger
        The skin and its sensors.
    span : (float, float), optional
        Positions of the load y [m]; the default reaches three depths beyond the outermost sensors.
    title : str, optional
        Heading.

    Raises
    ------
    InvalidValueError
        A span that is not two ascending positions.
    NotLinearError
        A transducer that has no linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3))
    >>> [axes.get_title(loc="left") for axes in receptive_fields(finger).axes]
    ['Normal load', 'Tangential load']
    """
    y, depth = np.asarray(finger.array.y), np.asarray(finger.array.depth)
    reach = 3.0 * float(depth.max())
    ends = _check.real("span", (y.min() - reach, y.max() + reach) if span is None else span, unit="m")
    if ends.shape != (2,) or not ends[0] < ends[1]:
        raise InvalidValueError(f"span = {span!r}", "two ascending positions are needed", "span=(-5e-3, 5e-3)")
    left, right = ends.tolist()
    position = np.linspace(left, right, 801)
    fields = finger.receptive_field(position)
    power = 3 * int(np.floor(np.log10(np.abs(fields).max() or 1.0) / 3))
    unit = unit_of(finger, otherwise="each its own unit")
    per_load = " ".join(filter(None, (rf"$10^{{{power}}}$" if power else "", unit, "/ (N/m)")))
    fields = fields / 10.0**power
    colours = colormaps["cividis"](np.linspace(0.0, 0.92, y.size))  # ordered as the sensors are
    figure = new_figure(DOUBLE, 66.0 if not title else 71.0)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, kind, name in zip(panels, range(2), ("Normal load", "Tangential load"), strict=True):
        for field, colour in zip(fields[..., kind].T, colours, strict=True):
            axes.plot(MM * position, field, color=colour)
        zero_line(axes)
        axes.set_title(name, fontweight="normal")
        axes.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 5, 10]))
        axes.set(xlim=(MM * left, MM * right), xlabel="position of the load y [mm]   (▲ sensors)")
    lowest = panels[0].get_ylim()[0]
    for axes in panels:
        axes.scatter(MM * y, np.full(y.size, lowest), c=colours, marker="^", s=14, clip_on=False, zorder=3)
        axes.set_ylim(bottom=lowest)
    panels[0].set_ylabel(f"reading per load [{per_load}]")
    heading(figure, title)
    return figure
