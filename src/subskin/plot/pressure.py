"""The pressure found along the surface: its band, what it is compared with, and how finely it is resolved."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .._check import FloatArray
from ..contact import Contact
from ..errors import GeometryError, InvalidValueError
from ..estimate import PressureMap, Status
from ..loads import force_unit
from .parts import legend, zero_line
from .style import BLACK, BLUE, GREEN, GREY, MM, NORMAL_95, SINGLE, VERMILLION, finished, new_figure

__all__ = ["pressure_figure"]

_SCALES = ((1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"))


@finished
def pressure_figure(found: PressureMap, *, truth: Contact | None = None, origin: float = 0.0) -> Figure:
    """The pressure of one frame along the surface with its 95 % band, the shear, and the resolution below.

    Full marks on the lower edge are the sensors that were used, hollow ones those that were not. The bar is as long as
    a narrow pressure at the centre looks wide.

    Parameters
    ----------
    found : PressureMap, shape ()
        What `pressure_map` found in one frame.
    truth : Contact, optional
        What pressed, drawn dashed.
    origin : float, optional
        The finger's y = 0 on the axis of the figure [m].

    Raises
    ------
    GeometryError
        More than one frame, or contacts.
    InvalidValueError
        A frame in which no pressure was found.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=13, pitch=1e-3, depth=2e-3, noise=2e-5))
    >>> roller = ss.Hertz(force=40.0, half_width=2e-3)
    >>> figure = pressure_figure(ss.pressure_map(finger, finger.read(roller)), truth=roller)
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['pressure and shear [kPa]', 'resolution [mm]']
    """
    if found.shape != ():
        raise GeometryError(f"maps of shape {found.shape}", "one frame is drawn", "pressure_map(finger, frames[0])")
    if truth is not None and truth.shape != ():
        raise GeometryError(f"contacts of shape {truth.shape}", "one is compared with one frame", "a single contact")
    if not np.isfinite(found.normal_force):
        status = Status(int(found.status)).name
        raise InvalidValueError(
            f"a frame of status {status}", "there is no pressure in it to draw", "a frame with status OK"
        )
    figure = new_figure(SINGLE, 88.0)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    _tractions(upper, found, truth, origin)
    _sensors(upper, found, origin)
    lower.plot(MM * (found.y + origin), MM * found.resolution, color=GREY)
    # where next to nothing is seen the width is any; what lies beyond four times the centre's is cut off
    there = float(np.interp(found.centre, found.y, found.resolution))
    lower.set_ylim(0, MM * min(1.1 * float(found.resolution.max()), 4 * there))
    lower.set(xlabel="position along the surface $y$ [mm]", ylabel="resolution [mm]")
    legend(figure, upper, loc="outside upper center", ncols=2)
    return figure


def _tractions(axes: Axes, found: PressureMap, truth: Contact | None, origin: float) -> None:
    y, fine = found.y, np.linspace(found.y[0], found.y[-1], 1601)
    largest = float(found.pressure.max())
    scale, unit = scale_of(largest, found.mapper.relative)
    dragged = found.mapper.shear != "none"
    curves = [("pressure", found.pressure, found.pressure_interval, BLUE)]
    if dragged:
        half = NORMAL_95 * found.shear_std
        curves.append(("shear", found.shear, np.stack([found.shear - half, found.shear + half], -1), VERMILLION))
    for name, values, band, colour in curves:
        look: dict[str, Any] = {"alpha": 0.2, "linewidth": 0, "label": f"{name}, 95 %"}
        axes.fill_between(MM * (y + origin), *band.T / scale, color=colour, **look)
        axes.plot(MM * (y + origin), values / scale, color=colour, label=f"{name} found")
    highest = 1.15 * float(found.pressure_interval.max())
    lowest = 1.15 * min(float(np.min(curves[-1][2])), 0.0)
    if truth is not None:
        for k, name in enumerate(("pressure", "shear")[: 1 + dragged]):
            real: FloatArray = np.array(getattr(truth, name)(fine))
            real[~np.isfinite(real)] = np.nan
            label = "what pressed" if k == 0 else None
            axes.plot(MM * (fine + origin), real / scale, color=BLACK, linestyle="--", linewidth=0.9, label=label)
            highest = max(highest, min(1.05 * float(np.nanmax(real)), 2 * highest))
    zero_line(axes)
    axes.set_ylim(lowest / scale - 0.08 * (highest - lowest) / scale, highest / scale)
    apart = "\n" if found.mapper.relative else " "  # a long unit is on a line of its own
    axes.set_ylabel(f"{'pressure and shear' if dragged else 'pressure'}{apart}[{unit}]")
    width = float(np.interp(found.centre, y, found.resolution))
    ends, label = MM * (found.centre + origin + width * np.array([-0.5, 0.5])), f"resolution {MM * width:.2g} mm"
    axes.plot(ends, np.full(2, 0.94 * highest / scale), color=GREY, lw=2.5, solid_capstyle="butt", label=label)


def _sensors(axes: Axes, found: PressureMap, origin: float) -> None:
    position, used = MM * (np.asarray(found.mapper.array.y) + origin), np.asarray(found.used)
    edge: dict[str, Any] = {"color": GREEN, "ms": 3, "transform": axes.get_xaxis_transform()}
    for at, face, name in ((position[used], GREEN, "sensors"), (position[~used], "none", "not used")):
        if at.size:
            axes.plot(at, np.full(at.size, 0.03), "^", mfc=face, label=name, **edge)


def scale_of(largest: float, relative: bool, per: str = "m") -> tuple[float, str]:
    """What pressures up to the `largest` [Pa] are divided by, and their unit; `relative` ones are loads `per` area."""
    if relative:
        return 1.0, f"{force_unit(local=False, relative=True)} / {per}"
    return next((s, u) for s, u in _SCALES if largest >= s or s == 1.0)
