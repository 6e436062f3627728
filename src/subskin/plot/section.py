"""A cross-section of the finger: the load, the field that it makes, the sensors, the load found, and the readings."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from .._check import FloatArray
from ..array import SensorArray
from ..contact import Contact, ContactSum, LineLoad
from ..errors import GeometryError
from ..estimate import Either, Estimate, Status
from ..finger import Finger
from ..skin import Skin
from . import pieces
from .style import DOUBLE, MM, NORMAL_95, Ink, finished, frame_of, single, stacked, unit_of, zero_line

__all__ = ["cut_open", "draw_found", "finger_section"]

_NARROW = 130.0
"""A figure below this width [mm] has its legend in one column."""
_UNITS = {"": (100.0, "measured [%]"), "Pa": (1e-3, "measured [kPa]")}


def finger_section(
    finger: Finger,
    contact: Contact | None,
    estimate: Estimate | Either | None = None,
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
    contact : Contact or None
        What presses; a single contact, not a batch. None where only the estimate is known: its load's field is drawn.
    estimate : Estimate or Either, optional
        The load found from one frame, drawn with its 95 % interval (a wedge for the angle, a bar for the
        position); of an `Either` its line.
    readings : array_like, shape (n,), optional
        The frame itself [units of the transducers], drawn below against what contact and load found would give.
    component : str, optional
        What is drawn in the skin, a name of `COMPONENTS`: "strain.xx" (the default), "mean_pressure", ...
    title : str, optional
        Heading.
    width : float, optional
        Width of the figure [mm].

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
    chosen = pieces.component_of(component)
    if estimate is not None and np.size(estimate.status) != 1:
        raise GeometryError(
            f"estimate of shape {estimate.shape}", "the estimate of a single frame is needed", "found[0]"
        )
    estimate = estimate.line if isinstance(estimate, Either) else estimate
    name = "" if contact is None else "load" if estimate is None else "true"
    contact = _load_of(estimate) if contact is None else contact
    single("contact", contact.shape)
    frame = frame_of(finger, readings)
    window, shallowest = window_of(finger, _resultants(contact)), MM * float(np.asarray(finger.array.depth).min())
    return cut_open(
        finger.skin, window, contact, chosen, near=0.3 * shallowest, room=0.5, name=name, finger=finger,
        estimate=estimate, frame=frame, title=title, width=width,
    )  # fmt: skip


@finished
def cut_open(
    skin: Skin,
    window: tuple[float, float, float],
    contact: Contact | None = None,
    component: pieces.Component | None = None,
    *,
    near: float = 0.0,
    room: float = 0.0,
    name: str = "load",
    finger: Finger | None = None,
    estimate: Estimate | None = None,
    frame: FloatArray | None = None,
    title: str = "",
    width: float = DOUBLE,
) -> Figure:
    """A skin in a window [mm], left, right and bottom, to scale, with what presses and what it holds.

    The levels of the field are those of what lies deeper than `near` [mm]. Above the skin there is `room`, in shares
    of the bottom, for the contact, which is drawn by its `name` if it has one.
    """
    left, right, bottom = window
    top, foot, inner = room * bottom, pieces.foot_of(skin, bottom), width - pieces.LEFT - pieces.RIGHT
    heights = [inner * (foot + top) / (right - left)] + ([] if frame is None else [max(0.2 * inner, 20.0)])
    figure, panels = stacked(
        width, heights, left=pieces.LEFT, right=pieces.RIGHT, top=7.0 if title else 1.5, foot=pieces.FOOT
    )
    axes, gap, columns = panels[0], *(("\n", 1) if width < _NARROW else (" ", 2))
    axes.set(xlim=(left, right), ylim=(foot, -top), ylabel="depth x [mm]")
    forces = [] if contact is None else _resultants(contact)
    scale = pieces.Scale(top, max([force.size for force in forces], default=1.0) or 1.0, min(1.0, inner / 140.0))
    if contact is None or component is None:
        axes.axhspan(0.0, min(bottom, MM * skin.thickness), color="#F3E9DC", linewidth=0, zorder=0.1)
        axes.axhline(0.0, color=Ink.BLACK, linewidth=0.9, clip_on=False)
    else:
        box = axes.get_position()
        bar = figure.add_axes((box.x1 + 2.5 / width, box.y0, 2.2 / width, box.height))
        pieces.colour_bar(bar, _field(axes, skin, contact, component, window, near), component.label, heights[0])
    pieces.inside(axes, skin, foot)
    if contact is not None and name:
        _above(axes, contact, forces, scale, name)
    if finger is not None:
        pieces.sensors(axes, finger, estimate)
    if estimate is not None:
        draw_found(axes, estimate, scale, gap)
    if finger is not None and contact is not None and frame is not None:
        _readings(panels[1], finger, contact, estimate, frame)
    panels[-1].set_xlabel(f"position along the skin y [mm]{', unrolled' if skin.curvature else ''}")
    pieces.legend_below(figure, axes, columns)
    if title:
        high = figure.get_figheight() * 25.4
        figure.text(pieces.LEFT / width, 1 - 1.5 / high, title, va="top", fontweight="bold")
    return figure


def _load_of(estimate: Estimate | None) -> LineLoad:
    """The load that was found in a single frame."""
    if estimate is None or not np.isfinite(estimate.force).all():
        seen = "neither a contact" if estimate is None else "neither a contact nor a frame with a load"
        raise GeometryError(seen, "one of them has a field to draw", "contact=ss.LineLoad(force=40.0)")
    return LineLoad.of_components(np.reshape(estimate.components, 2), np.reshape(estimate.position, ()))


def window_of(finger: Finger, forces: list[pieces.Force]) -> tuple[float, float, float]:
    """Left, right and bottom of the picture [mm]."""
    y, depth = MM * np.asarray(finger.array.y), MM * np.asarray(finger.array.depth)
    positions = [*y, *(force.position for force in forces)]
    margin = 1.2 * float(depth.max())
    return min(positions) - margin, max(positions) + margin, pieces.shown_depth(finger)


def _resultants(contact: Contact) -> list[pieces.Force]:
    """The force of each part of the contact, where its line of action meets the surface."""
    forces = []
    for part in contact.parts if isinstance(contact, ContactSum) else (contact,):
        normal, tangential = float(part.normal_force), float(part.tangential_force)
        # far away F = -(N + M/z + ...)/z with M the first moment; a kilometre is far from any finger
        far = np.array([1e3j], dtype=np.complex128)
        t = part.transforms(far)
        first, load = (t.p, normal) if normal else (t.q, tangential)
        position = 1e3 * float((first * far).imag[0]) / load if load else 0.0
        size, angle = float(np.hypot(normal, tangential)), float(np.arctan2(tangential, normal))
        forces.append(pieces.Force(MM * position, size, angle))
    return forces


def _field(
    axes: Axes,
    skin: Skin,
    contact: Contact,
    component: pieces.Component,
    window: tuple[float, float, float],
    near: float,
) -> ContourSet:
    """The field in the window [mm]; its levels are those of what lies deeper than `near` [mm]."""
    left, right, bottom = window
    y = np.linspace(left, right, 481)
    # the first row lies just beneath the surface, on which a contact's edge may be singular
    x = np.linspace(0.0, bottom, 241)
    x[0] = 0.02 * x[1]
    values = component.scale * component.of(skin.state(contact, x[:, None] / MM, y / MM))
    levels = pieces.levels_of(np.abs(values[x >= near]))
    x[0] = 0.0
    pieces.depths(axes, bottom)
    return pieces.bands(axes, y, x, values, levels)


def _above(axes: Axes, contact: Contact, forces: list[pieces.Force], scale: pieces.Scale, name: str) -> None:
    """The pressure as a hump on the surface, and each part's force."""
    y = np.linspace(*axes.get_xlim(), 4001)
    pressure = contact.pressure(y / MM)
    finite = pressure[np.isfinite(pressure)]
    if finite.size and finite.max() > 0:
        positions = [p for p in contact.singular_points() if np.isfinite(p)]
        infinite = any(np.isinf(contact.pressure(position)) for position in positions)
        peak = float(np.quantile(finite[finite > 0], 0.9)) if infinite else float(finite.max())
        height = 0.42 * scale.top * np.clip(np.nan_to_num(pressure / peak, posinf=9.0), -0.5, 1.9)
        label = "pressure" if infinite else f"pressure, at most {peak / 1e3:.3g} kPa"
        grey: dict[str, Any] = {"color": "#C9C9C9", "linewidth": 0, "zorder": 1.5, "label": label}
        axes.fill_between(y, -height, 0.0, where=height != 0, **grey)
    axes.axhline(0.0, color=Ink.BLACK, linewidth=0.9, zorder=2)
    thick: dict[str, Any] = {"color": Ink.BLACK, "linewidth": 3.6 * scale.weight}
    for force in forces:
        pieces.arrow(axes, force, scale.length(force.size), mutation_scale=14 * scale.weight, zorder=3, **thick)
        where = f"{np.degrees(force.angle):z.1f}°, y = {force.position:z.2f} mm".replace("-", "−")
        axes.plot([], [], label=f"{name}: {force.size:.3g} N/m at {where}", **thick)


def draw_found(axes: Axes, estimate: Estimate, scale: pieces.Scale, gap: str) -> None:
    """The load found: its arrow, the wedge of its angle and the bar of its position, both 95 %."""
    position, size, angle = (float(np.squeeze(v)) for v in (estimate.position, estimate.force, estimate.angle))
    status = Status(int(np.squeeze(estimate.status))).name.lower().replace("_", " ")
    if not np.isfinite([position, size, angle]).all():
        axes.plot([], [], " ", label=f"found: {status}")
        return
    half = NORMAL_95 * np.nan_to_num(np.reshape(estimate.std[..., :3], 3))
    force, length = pieces.Force(MM * position, size, angle), scale.length(size)
    turn = np.linspace(angle - half[2], angle + half[2], 31)
    rim = np.column_stack([force.position - length * np.sin(turn), -length * np.cos(turn)])
    wedge = Polygon(np.vstack([[force.position, 0.0], rim]), color=Ink.VERMILLION, alpha=0.3, linewidth=0, zorder=3.5)
    axes.add_patch(wedge)
    thin: dict[str, Any] = {"color": Ink.VERMILLION, "linewidth": 1.6 * scale.weight}
    pieces.arrow(axes, force, length, mutation_scale=8 * scale.weight, zorder=4, **thin)
    axes.errorbar(force.position, 0.0, xerr=MM * half[0], color=Ink.VERMILLION, capsize=2.5, elinewidth=1.6, zorder=4)
    degrees, where = _pm(np.degrees(angle), np.degrees(half[2])), _pm(force.position, MM * half[0])
    text = f"found ({status}): {_pm(size, half[1])} {estimate.force_unit} at {degrees}°,{gap}y = {where} mm"
    axes.plot([], [], label=text, **thin)


def _pm(value: float, half: float) -> str:
    """`value` with its 95 % interval, to two digits of the latter."""
    digits = int(np.clip(1 - np.floor(np.log10(half)), 0, 9)) if half > 0 else 3
    return f"{value:z.{digits}f} ± {half:.{digits}f}".replace("-", "−")


def _readings(axes: Axes, finger: Finger, contact: Contact, estimate: Estimate | None, frame: FloatArray) -> None:
    """The frame, freed of offset and gain, against what the contact and the load found would give."""
    array = finger.array
    live, gain = array.live, np.where(array.live, array.gain, np.nan)
    measured = (frame - np.asarray(array.offset)) / gain
    half = NORMAL_95 * np.asarray(array.noise) / np.abs(gain)
    scale, label = _UNITS.get(unit_of(finger, otherwise="?"), (1.0, "measured"))

    loads: list[tuple[Contact, dict[str, Any]]] = [(contact, {"color": Ink.BLACK, "linewidth": 3.2, "alpha": 0.25})]
    if estimate is not None and np.isfinite(np.squeeze(estimate.position)):
        found = LineLoad(*(float(np.squeeze(v)) for v in (estimate.force, estimate.angle, estimate.position)))
        loads.append((found, {"color": Ink.VERMILLION, "linewidth": 1.1}))
    dense = _alike(finger, np.linspace(*axes.get_xlim(), 401) / MM)
    for load, style in loads:
        if dense is not None:
            axes.plot(MM * np.asarray(dense.array.y), scale * dense.measure(load), **style)
        else:
            at, size = MM * np.asarray(array.y)[live], scale * finger.measure(load)[live]
            axes.plot(at, size, "_", ms=10, color=style["color"], mew=style["linewidth"])
    bars: dict[str, Any] = {
        "ms": 4.5,
        "mfc": "white",
        "mec": Ink.BLACK,
        "mew": 0.9,
        "ecolor": Ink.BLACK,
        "elinewidth": 0.8,
    }
    axes.errorbar(MM * np.asarray(array.y), scale * measured, yerr=scale * half, fmt="o", zorder=3, **bars)
    zero_line(axes)
    axes.margins(y=0.12)
    axes.set_ylabel(label)


def _alike(finger: Finger, y: FloatArray) -> Finger | None:
    """Sensors like those of the finger all along it; None where they differ from each other."""
    array = finger.array
    depth, width = np.asarray(array.depth), np.asarray(array.width)
    if np.ptp(depth) or np.ptp(width) or len(set(array.transducers)) > 1:
        return None
    return Finger(finger.skin, SensorArray(y, depth[0], array.transducers[0], width=width[0]))
