"""A finger, or a skin, under a touch on an area: seen from above, with a section through the touch below."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .. import _check
from ..contact import Contact, LocalContact, LocalSum
from ..errors import GeometryError, InvalidValueError
from ..estimate import Estimate
from ..finger import Finger
from ..loads import Load
from ..skin import Skin
from . import pieces
from .marks import heat_maps, mark_drag, mark_found, told
from .parts import frame_of, heading, single, stacked
from .style import BLACK, DOUBLE, GREY, MM, VERMILLION, finished, new_figure

__all__ = ["area_map", "finger_above"]

_TALLEST = 88.0
"""Height of the map from above [mm], at most."""
_WIDE = 0.45
"""Height over width of a map below which the section stands below it."""
_MARGIN = 21.0
"""Room beside the panels for the bar and its labels [mm]."""


class _Window(NamedTuple):
    """What is seen [mm]: ends along y and z, how deep the section goes, the depth of the map, z of the section."""

    left: float
    right: float
    front: float
    back: float
    bottom: float
    level: float
    cut: float


@finished
def finger_above(
    finger: Finger,
    contact: Contact | LocalContact | None = None,
    estimate: Estimate | Load | None = None,
    *,
    readings: npt.ArrayLike | None = None,
    component: str | None = None,
    title: str = "",
) -> Figure:
    """A finger whose sensors are on an area, from above and cut open; with `readings`, a map of them for each kind.

    Parameters
    ----------
    finger : Finger
        The skin and its sensors.
    contact : LocalContact, optional
        What presses; a single contact, not a batch. Its field is drawn at the depth of the deepest sensors.
    estimate : Estimate or Load, optional
        The load found from one frame, with the 95 % ellipse of its position.
    readings : array_like, shape (n,), optional
        The frame itself, drawn as a disc for each sensor [units of the transducers].
    component : str, optional
        What is drawn in the skin, a name of `COMPONENTS`; that of the first sensor's transducer if left out.
    title : str, optional
        Heading.

    Raises
    ------
    InvalidValueError, GeometryError
        An unknown component, a long contact, a batch; readings that are not one for each sensor.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> [axes.get_ylabel() for axes in finger_above(finger, ss.PointLoad(force=1.0)).axes[:2]]
    ['z [mm]', 'depth x [mm]']
    """
    if contact is not None and not isinstance(contact, LocalContact):
        rule = "it does not end along z, and a figure from above is drawn of a local contact"
        raise InvalidValueError(f"a {type(contact).__name__}", rule, "ss.PointLoad(force=1.0)")
    chosen = pieces.component_of(component or finger.array.transducers[0].component)
    load = _single(contact, estimate)
    frame = frame_of(finger, readings)
    if frame is not None:
        return heat_maps(finger, contact, load, frame, title)
    points, depth = MM * finger.array.points, MM * float(np.asarray(finger.array.depth).max())
    seen = [points, *(MM * np.reshape(c.position, (1, 2)) for c in (contact, load) if c is not None)]
    low, high = np.min(np.vstack(seen), axis=0) - 1.2 * depth, np.max(np.vstack(seen), axis=0) + 1.2 * depth
    middle = 0.5 * (low[1] + high[1]) if contact is None else MM * _cut(contact)
    window = _Window(low[0], high[0], low[1], high[1], pieces.shown_depth(finger), depth, middle)
    return _drawn(finger.skin, contact, chosen, window, finger, load, title)


def area_map(
    skin: Skin, contact: LocalContact, component: str, span: tuple[float, float] | None, depth: float | None
) -> Figure:
    """The field of a local contact from above and cut open; parameters as in `field_map`, [m].

    Raises
    ------
    InvalidValueError, GeometryError
        As in `field_map`.

    Examples
    --------
    >>> import subskin as ss
    >>> touch, skin = ss.PointLoad(force=1.0, angle=0.4), ss.HalfSpace(ss.Material(young=0.4e6))
    >>> [axes.get_ylabel() for axes in area_map(skin, touch, "stress.xx", None, None).axes[:2]]
    ['z [mm]', 'depth x [mm]']
    """
    chosen = pieces.component_of(component)
    _single(contact, None)
    low, high = (np.asarray(end, dtype=np.float64) for end in contact.support)
    reach = 2.0 * float((high - low).max()) or min(float(skin.thickness), 5e-3)
    ends = _check.ends("span", span, "span=(-5e-3, 5e-3)") or (float(low[0]) - reach, float(high[0]) + reach)
    if not ends[0] < ends[1]:
        raise InvalidValueError(f"span = {span!r}", "has to ascend", "span=(-5e-3, 5e-3)")
    most, across = float(skin.thickness), 0.5 * (ends[1] - ends[0])
    bottom = min(across, most) if depth is None else _check.scalar("depth", depth, unit="m", above=0.0, at_most=most)
    z = float(contact.position[1])
    window = _Window(*(MM * v for v in (*ends, z - across, z + across, bottom, 0.3 * bottom, _cut(contact))))
    return _drawn(skin, contact, chosen, window, None, None, "")


def _cut(contact: LocalContact) -> float:
    """The z of the section [m]: through the contact, or that of several with the largest force."""
    parts = contact.parts if isinstance(contact, LocalSum) else (contact,)
    return float(max(parts, key=lambda part: float(part.force)).position[1])


def _single(contact: LocalContact | None, estimate: Estimate | Load | None) -> Load | None:
    """The load of one frame that was found; refuses batches, and loads that are not on an area."""
    single("contact", () if contact is None else contact.shape)
    load = estimate.load if isinstance(estimate, Estimate) else estimate
    if load is None:
        return None
    if np.shape(load.position) != (2,):
        rule = "the load of a single frame, at a position (y, z), is needed"
        raise GeometryError(f"a load whose position has the shape {np.shape(load.position)}", rule, "found[0]")
    return load if np.isfinite(load.position).all() else None


@finished
def _drawn(
    skin: Skin,
    contact: LocalContact | None,
    component: pieces.Component,
    window: _Window,
    finger: Finger | None,
    load: Load | None,
    title: str,
) -> Figure:
    left, right, front, back, bottom, level, cut = window
    base, top = MM * skin.thickness, 0.0 if contact is None else 0.4 * bottom
    foot, margin = pieces.foot_of(skin, bottom), 4.0 if contact is None else _MARGIN
    aspects = (back - front) / (right - left), (foot + top) / (right - left)
    figure, (plan, section) = _panels(aspects, margin, 10.0 if title else 5.5)
    plan.set(xlim=(left, right), ylim=(front, back), ylabel="z [mm]", xlabel="y [mm]")
    section.set(xlim=(left, right), ylim=(foot, -top), ylabel="depth x [mm]", xlabel="y [mm]")
    for axis in (plan.xaxis, plan.yaxis, section.xaxis):
        axis.set_major_locator(MaxNLocator(7, steps=[1, 2, 5, 10]))
    if contact is not None:
        drawn = _fields(plan, section, skin, contact, component, window)
        box = plan.get_position()
        bar = figure.add_axes((1 - (margin - 2.5) / DOUBLE, box.y0, 2.2 / DOUBLE, box.height))
        pieces.colour_bar(bar, drawn, component.label, box.height * figure.get_figheight() * 25.4)
        _pressed(plan, section, contact, window, pieces.Scale(top, float(contact.force) or 1.0, 0.8))
    else:
        for axes, ends in ((plan, (front, back)), (section, (0.0, min(bottom, base)))):
            axes.axhspan(*ends, color="#F3E9DC", linewidth=0, zorder=0.1)
    pieces.inside(section, skin, foot)
    section.axhline(0.0, color=BLACK, linewidth=0.9, clip_on=False)
    pieces.depths(section, bottom)
    if finger is not None:
        _points(plan, finger)
        pieces.sensors(section, finger, None)
    if load is not None:
        mark_found(plan, load, 0.2 * (right - left))
        section.plot([], [], color=VERMILLION, linewidth=2.0, label=f"found: {told(load)}")
    seen = "from above" if contact is None else f"from above, {level:.3g} mm deep"
    for axes, text in ((plan, seen), (section, f"section at z = {cut + 0.0:.3g} mm" if contact else "from the side")):
        axes.set_title(text.replace("-", "−"), fontweight="normal", pad=3)
    pieces.legend_below(figure, section, columns=1)
    if title:
        heading(figure, title)
    return figure


def _panels(aspects: tuple[float, float], margin: float, top: float) -> tuple[Figure, tuple[Axes, Axes]]:
    """The map and the section, to one scale: beside each other, or below each other where the map is wide."""
    if aspects[0] < _WIDE:
        inner = DOUBLE - pieces.LEFT - margin
        look: dict[str, Any] = {"left": pieces.LEFT, "right": margin, "top": top, "foot": pieces.FOOT, "gap": 15.0}
        figure, (plan, section) = stacked(DOUBLE, [inner * aspect for aspect in aspects], **look)
        plan.tick_params(labelbottom=True)
        return figure, (plan, section)
    inner = 0.5 * (DOUBLE - 2 * pieces.LEFT - margin)
    inner *= min(1.0, _TALLEST / (inner * max(aspects)))
    high = top + inner * max(aspects) + pieces.FOOT
    figure = new_figure(DOUBLE, high, layout="none")
    boxes = ((x / DOUBLE, pieces.FOOT / high, inner / DOUBLE, inner * aspect / high)
             for x, aspect in zip((pieces.LEFT, DOUBLE - margin - inner), aspects, strict=True))  # fmt: skip
    plan, section = (figure.add_axes(box) for box in boxes)
    return figure, (plan, section)


def _fields(
    plan: Axes, section: Axes, skin: Skin, contact: LocalContact, component: pieces.Component, window: _Window
) -> ContourSet:
    """The field from above and in the section, with the same levels: those of what is seen from above."""
    left, right, front, back, bottom, level, cut = window
    y, z, x = np.linspace(left, right, 221), np.linspace(front, back, 221), np.linspace(0.0, bottom, 161)
    x[0] = 0.02 * x[1]  # just beneath the surface, on which a contact's edge may be singular
    above = component.scale * component.of(skin.state(contact, level / MM, y / MM, z[:, None] / MM))
    beside = component.scale * component.of(skin.state(contact, x[:, None] / MM, y / MM, cut / MM))
    levels = pieces.levels_of(np.abs(above))
    x[0] = 0.0
    drawn = pieces.bands(plan, y, z, above, levels)
    pieces.bands(section, y, x, beside, levels)
    plan.axhline(cut, color=GREY, linewidth=0.6, linestyle=(0, (5, 3)))
    section.axhline(level, color=GREY, linewidth=0.6, linestyle=(0, (5, 3)))
    return drawn


def _pressed(plan: Axes, section: Axes, contact: LocalContact, window: _Window, scale: pieces.Scale) -> None:
    """Where it presses, its resultant, the drag of it as an arrow from above, the pressure as a hump on the section."""
    low, high = (MM * np.asarray(end) for end in contact.support)
    if (low < high).all():
        margin = 0.05 * (high - low)
        y, z = (np.linspace(a - m, b + m, 241) for a, b, m in zip(low, high, margin, strict=True))
        pressed = contact.pressure(y / MM, z[:, None] / MM) != 0
        plan.contour(y, z, pressed.astype(float), [0.5], colors=[BLACK], linewidths=0.8)
    along = np.linspace(window.left, window.right, 2001)
    pressure = np.nan_to_num(contact.pressure(along / MM, window.cut / MM), posinf=0.0)
    if pressure.max() > 0:
        hump = 0.5 * scale.top * np.clip(pressure / np.quantile(pressure[pressure > 0], 0.9), 0.0, 1.6)
        section.fill_between(along, -hump, 0.0, where=hump > 0, color="#C9C9C9", linewidth=0, zorder=1.5)
    thick: dict[str, Any] = {"color": BLACK, "linewidth": 3.0 * scale.weight}
    for part in contact.parts if isinstance(contact, LocalSum) else (contact,):
        normal, along_y, _ = part.components
        force = pieces.Force(
            MM * float(part.position[0]), float(np.hypot(normal, along_y)), float(np.arctan2(along_y, normal))
        )
        pieces.arrow(section, force, scale.length(force.size), mutation_scale=12 * scale.weight, zorder=3, **thick)
        mark_drag(plan, part.position, part.components, 0.2 * (window.right - window.left), BLACK)
        section.plot([], [], label=f"load: {told(Load(part.position, part.components))}", **thick)


def _points(axes: Axes, finger: Finger) -> None:
    """The sensors from above, those that are dead crossed out; channels of one position are one mark."""
    array = finger.array
    dot: dict[str, Any] = {"mfc": "white", "mec": BLACK, "mew": 0.9, "ms": 4.5, "zorder": 2.8, "linestyle": "none"}
    for live, mark in ((True, "o"), (False, "X")):
        at = MM * np.unique(array.points[array.live == live], axis=0)
        axes.plot(*at.T, marker=mark, **dot)
