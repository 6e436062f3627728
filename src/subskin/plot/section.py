"""A cross-section of the finger: the load, the field that it makes, the sensors, and the load found."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Polygon
from matplotlib.ticker import MaxNLocator

from .. import _check
from .._check import FloatArray
from ..array import SensorArray
from ..contact.base import Contact, ContactSum
from ..contact.line import LineLoad
from ..errors import GeometryError, InvalidValueError
from ..estimate.estimate import Estimate, Status
from ..field import State
from ..finger import Finger
from .style import BLACK, DOUBLE, NORMAL_95, VERMILLION, house_style, new_figure, zero_line

__all__ = ["finger_section"]

_MM = 1e3
_LEFT, _RIGHT, _GAP, _FOOT = 12.0, 18.0, 3.0, 18.0
"""Margins [mm]: beside the panels, between them, and below them for the label and the legend."""
_UNITS = {"": (100.0, "measured [%]"), "Pa": (1e-3, "measured [kPa]")}


class _Component(NamedTuple):
    of: Callable[[State], FloatArray]
    scale: float
    label: str


COMPONENTS = {
    "strain.xx": _Component(lambda s: s.strain.xx, 100.0, r"strain $\varepsilon_x$ [%]"),
    "strain.yy": _Component(lambda s: s.strain.yy, 100.0, r"strain $\varepsilon_y$ [%]"),
    "strain.xy": _Component(lambda s: s.strain.xy, 100.0, r"shear strain $\varepsilon_{xy}$ [%]"),
    "stress.xx": _Component(lambda s: s.stress.xx, 1e-3, r"stress $\sigma_x$ [kPa]"),
    "stress.yy": _Component(lambda s: s.stress.yy, 1e-3, r"stress $\sigma_y$ [kPa]"),
    "stress.xy": _Component(lambda s: s.stress.xy, 1e-3, r"shear stress $\tau_{xy}$ [kPa]"),
    "mean_pressure": _Component(lambda s: s.stress.mean_pressure, 1e-3, "mean pressure [kPa]"),
}
"""What can be drawn in the skin, by name."""


class _Force(NamedTuple):
    """A resultant on the surface: place [mm], magnitude [N/m], angle [rad]."""

    place: float
    size: float
    angle: float


def finger_section(
    finger: Finger,
    contact: Contact,
    estimate: Estimate | None = None,
    *,
    readings: npt.ArrayLike | None = None,
    component: str = "strain.xx",
    title: str = "",
    width: float = DOUBLE,
) -> Figure:
    """The finger cut open: pressure above its surface, the field within, the sensors, and the load found.

    Parameters
    ----------
    finger : Finger
        The skin and its sensors.
    contact : Contact
        What presses; a single contact, not a batch.
    estimate : Estimate, optional
        The load found from one frame, drawn with its 95 % interval (a wedge for the angle, a bar for the
        place).
    readings : array_like, shape (n,), optional
        The frame itself, drawn below against what the contact and the load found would give.
    component : str, optional
        What is drawn in the skin, a name of `COMPONENTS`: "strain.xx" (the default), "mean_pressure", ...
    title : str, optional
        Heading.
    width : float, optional
        Width of the figure [mm].

    Returns
    -------
    matplotlib.figure.Figure
        Write it with `subskin.plot.save`.

    Raises
    ------
    InvalidValueError, GeometryError
        An unknown component; a batch of contacts or estimates; readings that are not one for each sensor.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-4))
    >>> touch = ss.LineLoad(force=40.0, angle=0.3, position=0.8e-3)
    >>> finger_section(finger, touch).axes[0].get_ylabel()
    'depth x [mm]'
    """
    if component not in COMPONENTS:
        raise InvalidValueError(f"component = {component!r}", f"has to be one of {', '.join(COMPONENTS)}")
    if contact.shape:
        raise GeometryError(
            f"contact of shape {contact.shape}", "a single contact is needed", "draw them one by one"
        )
    if estimate is not None and np.size(estimate.status) != 1:
        raise GeometryError(f"estimate of shape {estimate.shape}", "the estimate of a single frame is needed")
    frame = None if readings is None else _check.real("readings", readings, finite=False)
    if frame is not None and frame.shape != (len(finger.array),):
        raise GeometryError(
            f"readings of shape {frame.shape}", f"one for each of the {len(finger.array)} sensors"
        )

    forces = _resultants(contact)
    left, right, bottom = _window(finger, forces)
    top = 0.5 * bottom
    with house_style():
        inner = width - _LEFT - _RIGHT
        heights = [inner * (bottom + top) / (right - left)] + ([0.2 * inner] if frame is not None else [])
        figure, panels, bar = _sheet(width, heights, 6.0 if title else 1.5)
        panels[0].set(xlim=(left, right), ylim=(bottom, -top), ylabel="depth x [mm]")
        _field(panels[0], bar, finger, contact, COMPONENTS[component], (left, right, bottom))
        _above(panels[0], contact, forces, top)
        _sensors(panels[0], finger, estimate)
        if estimate is not None:
            _found(panels[0], estimate, max(force.size for force in forces), top)
        if frame is not None:
            _readings(panels[1], finger, contact, estimate, frame)
        panels[-1].set_xlabel("place along the skin y [mm]")
        figure.text(_LEFT / width, 1.0, title, va="top", fontweight="bold")
        handles, labels = panels[0].get_legend_handles_labels()
        spot: dict[str, Any] = {
            "loc": "lower left",
            "bbox_to_anchor": (_LEFT / width, 0.0),
            "borderaxespad": 0.0,
        }
        figure.legend(handles, labels, ncols=2, columnspacing=1.5, **spot)
    return figure


def _sheet(width: float, heights: list[float], title: float) -> tuple[Figure, list[Axes], Axes]:
    """A figure with panels of the given heights [mm] one below the other, a colour bar beside the first.

    Laid out by hand: the panels have to be equally wide and the section to scale.
    """
    figure = new_figure(width, sum(heights) + _GAP * (len(heights) - 1) + _FOOT + title, layout="none")
    high = figure.get_figheight() * 25.4
    inner, y = width - _LEFT - _RIGHT, high - title
    panels: list[Axes] = []
    for height in heights:
        y -= height
        box = (_LEFT / width, y / high, inner / width, height / high)
        panels.append(figure.add_axes(box, sharex=panels[0] if panels else None))
        y -= _GAP
    panels[0].tick_params(labelbottom=len(heights) == 1)
    box = ((_LEFT + inner + 2.5) / width, 1 - (title + heights[0]) / high, 2.2 / width, heights[0] / high)
    return figure, panels, figure.add_axes(box)


def _resultants(contact: Contact) -> list[_Force]:
    """The force of each part of the contact, at the part's place."""
    parts = contact.parts if isinstance(contact, ContactSum) else (contact,)
    forces = []
    for part in parts:
        normal, tangential = float(part.normal_force), float(part.tangential_force)
        place = float(np.asarray(getattr(part, "position", 0.0)))
        forces.append(
            _Force(_MM * place, float(np.hypot(normal, tangential)), float(np.arctan2(tangential, normal)))
        )
    return forces


def _window(finger: Finger, forces: list[_Force]) -> tuple[float, float, float]:
    """Left, right and bottom of the picture [mm]."""
    y, depth = _MM * np.asarray(finger.array.y), _MM * np.asarray(finger.array.depth)
    places = [*y, *(force.place for force in forces)]
    margin = 1.2 * float(depth.max())
    return min(places) - margin, max(places) + margin, 1.7 * float(depth.max())


def _levels(values: FloatArray) -> FloatArray:
    """Levels 1, 2, 5, 10, ... on both sides of zero, over two decades: the far field shows as well."""
    most = float(values.max()) or 1.0
    steps = np.array([m * 10.0**e for e in range(-18, 13) for m in (1, 2, 5)])
    last = int(np.searchsorted(steps, most * 0.999))
    side = steps[max(last - 6, 0) : last + 1]
    return np.concatenate([-side[::-1], side])


def _field(
    axes: Axes,
    bar: Axes,
    finger: Finger,
    contact: Contact,
    component: _Component,
    window: tuple[float, float, float],
) -> None:
    left, right, bottom = window
    y = np.linspace(left, right, 481)
    # the first row lies just beneath the surface, on which a contact's edge may be singular
    x = np.linspace(0.0, bottom, 241)
    x[0] = 0.02 * x[1]
    values = component.scale * component.of(finger.skin.state(contact, x[:, None] / _MM, y / _MM))
    shallowest = _MM * float(np.asarray(finger.array.depth).min())
    levels = _levels(np.abs(values[x >= 0.3 * shallowest]))
    colours = colormaps["RdBu_r"].resampled(levels.size + 1)
    x[0] = 0.0
    norm = BoundaryNorm(levels, colours.N, extend="both")
    drawn = axes.contourf(y, x, values, levels, cmap=colours, norm=norm, extend="both")
    drawn.set_edgecolor("face")  # no hairlines between the bands in SVG
    scale = Colorbar(bar, drawn, label=component.label, ticks=levels.tolist())
    scale.ax.set_yticklabels([f"{v:g}".replace("-", "−") for v in levels], fontsize=6)
    axes.set_yticks([t for t in MaxNLocator(4, steps=[1, 2, 5, 10]).tick_values(0.0, bottom) if t <= bottom])
    axes.spines["left"].set_bounds(bottom, 0.0)
    axes.set_ylim(bottom, axes.get_ylim()[1])


def _above(axes: Axes, contact: Contact, forces: list[_Force], top: float) -> None:
    """The pressure as a hump on the surface, and each part's force."""
    left, right = axes.get_xlim()
    y = np.linspace(left, right, 4001)
    pressure = contact.pressure(y / _MM)
    finite = pressure[np.isfinite(pressure)]
    if finite.size and finite.max() > 0:
        singular = bool(contact.singular_points())
        peak = float(np.quantile(finite[finite > 0], 0.98)) if singular else float(finite.max())
        height = 0.42 * top * np.clip(np.nan_to_num(pressure / peak, posinf=9.0), -0.5, 1.9)
        label = "pressure" if singular else f"pressure, at most {peak / 1e3:.3g} kPa"
        axes.fill_between(
            y, -height, 0.0, where=height != 0, color="#C9C9C9", linewidth=0, zorder=1.5, label=label
        )
    axes.axhline(0.0, color=BLACK, linewidth=0.9, zorder=2)
    strongest = max(force.size for force in forces)
    for force in forces:
        text = f"true: {force.size:.3g} N/m at {np.degrees(force.angle):.1f}°, y = {force.place:.2f} mm"
        _arrow(
            axes, force, force.size / strongest, top, color=BLACK, linewidth=3.2, mutation_scale=15, zorder=3
        )
        axes.plot([], [], color=BLACK, linewidth=4.0, label=text)


def _arrow(axes: Axes, force: _Force, relative: float, top: float, **style: Any) -> None:
    length = 0.85 * top * min(relative, 1.1)
    tail = (force.place - length * np.sin(force.angle), -length * np.cos(force.angle))
    axes.add_patch(FancyArrowPatch(tail, (force.place, 0.0), arrowstyle="-|>", shrinkA=0, shrinkB=0, **style))


def _found(axes: Axes, estimate: Estimate, strongest: float, top: float) -> None:
    """The load found: its arrow, the wedge of its angle and the bar of its place, both 95 %."""
    place, size, angle = (float(np.squeeze(v)) for v in (estimate.position, estimate.force, estimate.angle))
    status = Status(int(np.squeeze(estimate.status))).name.lower().replace("_", " ")
    if not np.isfinite([place, size, angle]).all():
        axes.plot([], [], " ", label=f"found: {status}")
        return
    half = NORMAL_95 * np.nan_to_num(np.reshape(estimate.std, 3))
    force = _Force(_MM * place, size, angle)
    length = 0.85 * top * min(size / strongest, 1.1)
    turn = np.linspace(angle - half[2], angle + half[2], 31)
    rim = np.column_stack([force.place - length * np.sin(turn), -length * np.cos(turn)])
    axes.add_patch(
        Polygon(np.vstack([[force.place, 0.0], rim]), color=VERMILLION, alpha=0.3, linewidth=0, zorder=3.5)
    )
    _arrow(axes, force, size / strongest, top, color=VERMILLION, linewidth=1.6, mutation_scale=8, zorder=4)
    axes.errorbar(
        force.place, 0.0, xerr=_MM * half[0], color=VERMILLION, capsize=2.5, elinewidth=1.6, zorder=4
    )
    text = (
        f"found ({status}): {_pm(size, half[1])} N/m at {_pm(np.degrees(angle), np.degrees(half[2]))}°, "
        f"y = {_pm(force.place, _MM * half[0])} mm"
    )
    axes.plot([], [], color=VERMILLION, linewidth=1.2, label=text)


def _pm(value: float, half: float) -> str:
    """`value` with its 95 % interval, to two digits of the latter."""
    digits = int(np.clip(1 - np.floor(np.log10(half)), 0, 9)) if half > 0 else 3
    return f"{value:.{digits}f} ± {half:.{digits}f}"


def _sensors(axes: Axes, finger: Finger, estimate: Estimate | None) -> None:
    array = finger.array
    y, depth, half = (_MM * np.asarray(a) for a in (array.y, array.depth, 0.5 * np.asarray(array.width)))
    used = array.live if estimate is None else np.reshape(estimate.used, -1)
    for i in np.flatnonzero(half > 0):
        axes.plot([y[i] - half[i], y[i] + half[i]], [depth[i]] * 2, color=BLACK, linewidth=2.4, zorder=2.6)
    dot: dict[str, Any] = {
        "mfc": "white",
        "mec": BLACK,
        "mew": 0.9,
        "ms": 5.0,
        "zorder": 2.8,
        "clip_on": False,
    }
    axes.plot(y[used], depth[used], "o", label="sensor", **dot)
    if not used.all():
        axes.plot(y[~used], depth[~used], "X", label="sensor left out", **dot)


def _readings(
    axes: Axes, finger: Finger, contact: Contact, estimate: Estimate | None, frame: FloatArray
) -> None:
    """The frame, freed of offset and gain, against what the contact and the load found would give."""
    array = finger.array
    live, gain = array.live, np.where(array.live, array.gain, np.nan)
    measured, half = (
        (frame - np.asarray(array.offset)) / gain,
        NORMAL_95 * np.asarray(array.noise) / np.abs(gain),
    )
    units = {kind.unit for kind in array.transducers}
    scale, label = _UNITS.get(units.pop() if len(units) == 1 else "?", (1.0, "measured"))

    loads: list[tuple[Contact, dict[str, Any]]] = [
        (contact, {"color": BLACK, "linewidth": 3.2, "alpha": 0.25})
    ]
    if estimate is not None and np.isfinite(np.squeeze(estimate.position)):
        found = LineLoad(*(float(np.squeeze(v)) for v in (estimate.force, estimate.angle, estimate.position)))
        loads.append((found, {"color": VERMILLION, "linewidth": 1.1}))
    dense = _alike(finger, np.linspace(*axes.get_xlim(), 401) / _MM)
    for load, style in loads:
        if dense is not None:
            axes.plot(_MM * np.asarray(dense.array.y), scale * dense.measure(load), **style)
        else:
            at, size = _MM * np.asarray(array.y)[live], scale * finger.measure(load)[live]
            axes.plot(at, size, "_", ms=10, color=style["color"], mew=style["linewidth"])
    bars: dict[str, Any] = {
        "ms": 4.5,
        "mfc": "white",
        "mec": BLACK,
        "mew": 0.9,
        "ecolor": BLACK,
        "elinewidth": 0.8,
    }
    axes.errorbar(_MM * np.asarray(array.y), scale * measured, yerr=scale * half, fmt="o", zorder=3, **bars)
    zero_line(axes)
    axes.set_ylabel(label)


def _alike(finger: Finger, y: FloatArray) -> Finger | None:
    """Sensors like those of the finger all along it; None where they differ from each other."""
    array = finger.array
    depth, width = np.asarray(array.depth), np.asarray(array.width)
    if np.ptp(depth) or np.ptp(width) or len(set(array.transducers)) > 1:
        return None
    return Finger(finger.skin, SensorArray(y, depth[0], array.transducers[0], width=width[0]))
