"""A touch on an area seen from above: marks of loads, discs of readings, a finger or a skin with a section below."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.colorbar import Colorbar
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, FancyArrowPatch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from .. import _check
from .._check import FloatArray
from ..contact import Contact, LocalContact, LocalSum
from ..errors import GeometryError, InvalidValueError
from ..estimate import Estimate
from ..finger import Finger
from ..loads import Load
from ..skin import Skin
from ..transducer import Transducer
from . import pieces
from .style import DOUBLE, MM, SINGLE, Ink, finished, frame_of, heading, new_figure, single, stacked

__all__ = ["area_map", "finger_above", "heat_maps", "mark_drag", "mark_found", "told"]

_HALO = [withStroke(linewidth=2.6, foreground="white")]
"""Marks stand out from a dark field."""
_ELLIPSE_95 = 2.447747
"""Half axes of a 95 % ellipse in standard deviations: sqrt(-2 ln 0.05)."""


def told(load: Load) -> str:
    """A load in words: 1.5 N, 28.6° towards 46°, at (1.00, -2.00) mm."""
    (y, z), force, angle = MM * load.position, float(load.force), float(np.degrees(load.angle))
    towards = f" towards {float(np.degrees(load.azimuth)):z.0f}°" if angle > 1e-9 else ""
    return f"{force:.3g} N, {angle:.1f}°{towards}, at ({y:z.2f}, {z:z.2f}) mm".replace("-", "−")


def mark_drag(axes: Axes, position: FloatArray, components: FloatArray, length: float, colour: str) -> None:
    """A dot where a load stands, and its drag as an arrow: `length` [mm] where it is as large as the force."""
    y, z = MM * np.asarray(position)
    axes.plot([y], [z], "o", color=colour, markersize=3.2, zorder=4, path_effects=_HALO)
    shift = length * np.asarray(components)[1:] / (np.linalg.norm(components) or 1.0)
    if np.hypot(*shift) > 0.02 * length:
        arrow = FancyArrowPatch((y, z), (y + shift[0], z + shift[1]), arrowstyle="-|>", shrinkA=0, shrinkB=0)
        arrow.set(color=colour, linewidth=1.6, mutation_scale=9, zorder=4, path_effects=_HALO)
        axes.add_patch(arrow)


def mark_found(axes: Axes, load: Load, length: float) -> None:
    """The load that was found, and the 95 % ellipse of its position."""
    mark_drag(axes, load.position, load.components, length, Ink.VERMILLION)
    if load.covariance is not None and np.isfinite(load.covariance[:2, :2]).all():
        values, vectors = np.linalg.eigh(load.covariance[:2, :2])
        wide, high = 2 * _ELLIPSE_95 * MM * np.sqrt(np.maximum(values, 0.0))
        turn = float(np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0])))
        ellipse = Ellipse(tuple(MM * np.asarray(load.position)), wide, high, angle=turn, zorder=3.5)
        ellipse.set(facecolor="none", edgecolor=Ink.VERMILLION, linewidth=1.2, path_effects=_HALO)
        axes.add_patch(ellipse)


_TALLEST = 88.0
"""Height of a map [mm], at most."""
_BESIDE = 30.0
"""Room beside a map, for its labels and its bar [mm]."""
_UNITS = {"": (100.0, "%"), "Pa": (1e-3, "kPa"), "m": (1e6, "µm"), "T": (1e3, "mT")}


def heat_maps(finger: Finger, contact: LocalContact | None, load: Load | None, frame: FloatArray, title: str) -> Figure:
    """What each kind of sensor measures, freed of offset and gain, as discs from above: a panel for each kind."""
    array = finger.array
    kinds = list(dict.fromkeys(array.transducers))
    columns = 2 if len(kinds) == 4 else min(len(kinds), 3)
    rows = -(-len(kinds) // columns)
    points = MM * array.points
    near = _nearest(points)
    low, high = points.min(axis=0) - 0.75 * near, points.max(axis=0) + 0.75 * near
    aspect = float((high - low)[1] / (high - low)[0])
    wide = (SINGLE if columns == 1 else DOUBLE) / columns
    inner = min(wide - _BESIDE, _TALLEST / aspect)
    tall, head = aspect * inner + 14.5, 5.5 if title else 0.0
    figure = new_figure(wide * columns, tall * rows + head, layout="none")
    measured = (frame - np.asarray(array.offset)) / np.where(array.live, array.gain, np.nan)
    for k, kind in enumerate(kinds):
        x, y = wide * (k % columns) + 11.0, tall * (rows - 1 - k // columns) + 9.0
        size = np.array([wide * columns, tall * rows + head] * 2)
        axes = figure.add_axes(tuple(np.array([x, y, inner, aspect * inner]) / size))
        bar = figure.add_axes(tuple(np.array([x + inner + 2.5, y, 2.2, aspect * inner]) / size))
        own = np.array([other == kind for other in array.transducers])
        _discs(axes, bar, points[own], measured[own], 0.84 * near, kind)
        if contact is not None:
            mark_drag(axes, contact.position, contact.components, 0.2 * float((high - low)[0]), Ink.BLACK)
        if load is not None:
            mark_found(axes, load, 0.2 * float((high - low)[0]))
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="y [mm]", ylabel="z [mm]")
        axes.set_title(repr(kind).removesuffix("()"), fontweight="normal", pad=3)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    if title:
        heading(figure, title)
    return figure


def _nearest(points: FloatArray) -> float:
    """Distance of the closest two of some points that are not the same; 1 where there is one alone."""
    unique = np.unique(points, axis=0)
    gaps = np.hypot(*(unique[:, None] - unique).T) + np.diag(np.full(len(unique), np.inf))
    return float(gaps.min()) if len(unique) > 1 else 1.0


def _discs(axes: Axes, bar: Axes, points: FloatArray, measured: FloatArray, size: float, kind: Transducer) -> None:
    """What sensors of one kind measure, each as a disc of `size` [mm], with their bar; a cross where there is none."""
    scale, unit = _UNITS.get(kind.unit, (1.0, kind.unit))
    known = np.isfinite(measured)
    most = scale * float(np.abs(measured[known]).max(initial=0.0)) or 1.0
    each = np.full(int(known.sum()), size)
    look: dict[str, Any] = {"cmap": "RdBu_r", "edgecolor": Ink.GREY, "linewidth": 0.4}
    discs = EllipseCollection(each, each, 0 * each, units="xy", offsets=points[known], **look)
    discs.set_offset_transform(axes.transData)
    discs.set_array(scale * measured[known])
    discs.set_clim(-most, most)
    axes.add_collection(discs)
    axes.plot(*points[~known].T, "x", color=Ink.GREY)
    Colorbar(bar, discs, label=f"measured [{unit}]" if unit else "measured")
    bar.tick_params(labelsize=6)


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
    section.axhline(0.0, color=Ink.BLACK, linewidth=0.9, clip_on=False)
    pieces.depths(section, bottom)
    if finger is not None:
        _points(plan, finger)
        pieces.sensors(section, finger, None)
    if load is not None:
        mark_found(plan, load, 0.2 * (right - left))
        section.plot([], [], color=Ink.VERMILLION, linewidth=2.0, label=f"found: {told(load)}")
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
    plan.axhline(cut, color=Ink.GREY, linewidth=0.6, linestyle=(0, (5, 3)))
    section.axhline(level, color=Ink.GREY, linewidth=0.6, linestyle=(0, (5, 3)))
    return drawn


def _pressed(plan: Axes, section: Axes, contact: LocalContact, window: _Window, scale: pieces.Scale) -> None:
    """Where it presses, its resultant, the drag of it as an arrow from above, the pressure as a hump on the section."""
    low, high = (MM * np.asarray(end) for end in contact.support)
    if (low < high).all():
        margin = 0.05 * (high - low)
        y, z = (np.linspace(a - m, b + m, 241) for a, b, m in zip(low, high, margin, strict=True))
        pressed = contact.pressure(y / MM, z[:, None] / MM) != 0
        plan.contour(y, z, pressed.astype(float), [0.5], colors=[Ink.BLACK], linewidths=0.8)
    along = np.linspace(window.left, window.right, 2001)
    pressure = np.nan_to_num(contact.pressure(along / MM, window.cut / MM), posinf=0.0)
    if pressure.max() > 0:
        hump = 0.5 * scale.top * np.clip(pressure / np.quantile(pressure[pressure > 0], 0.9), 0.0, 1.6)
        section.fill_between(along, -hump, 0.0, where=hump > 0, color="#C9C9C9", linewidth=0, zorder=1.5)
    thick: dict[str, Any] = {"color": Ink.BLACK, "linewidth": 3.0 * scale.weight}
    for part in contact.parts if isinstance(contact, LocalSum) else (contact,):
        normal, along_y, _ = part.components
        force = pieces.Force(
            MM * float(part.position[0]), float(np.hypot(normal, along_y)), float(np.arctan2(along_y, normal))
        )
        pieces.arrow(section, force, scale.length(force.size), mutation_scale=12 * scale.weight, zorder=3, **thick)
        mark_drag(plan, part.position, part.components, 0.2 * (window.right - window.left), Ink.BLACK)
        section.plot([], [], label=f"load: {told(Load(part.position, part.components))}", **thick)


def _points(axes: Axes, finger: Finger) -> None:
    """The sensors from above, those that are dead crossed out; channels of one position are one mark."""
    array = finger.array
    dot: dict[str, Any] = {"mfc": "white", "mec": Ink.BLACK, "mew": 0.9, "ms": 4.5, "zorder": 2.8, "linestyle": "none"}
    for live, mark in ((True, "o"), (False, "X")):
        at = MM * np.unique(array.points[array.live == live], axis=0)
        axes.plot(*at.T, marker=mark, **dot)
