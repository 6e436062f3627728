"""A cross-section of the finger: the load, the field that it makes, the sensors, and the load found."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.colors import BoundaryNorm
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Polygon
from matplotlib.ticker import MaxNLocator

from .. import _check
from .._check import FloatArray
from ..contact import Contact, ContactSum, LineLoad
from ..errors import GeometryError, InvalidValueError
from ..estimate import Estimate, Status
from ..finger import Finger
from ..skin import Skin
from ..tensor import State
from .measured import draw_readings
from .parts import stacked
from .style import BLACK, DOUBLE, GREY, MM, NORMAL_95, VERMILLION, finished

__all__ = ["finger_section"]

_LEFT, _RIGHT, _FOOT = 13.5, 18.0, 9.5
_TICK = 4
"""Minus and digits of a tick of the colour bar that there is room for."""
"""Margins [mm]: beside the panels, and below them for the label."""
_BASE = 0.12
"""Thickness of the base as it is drawn, in thicknesses of the skin."""
_NEAR_BASE = 1.6
"""A base that lies no deeper than this many times the picture's usual depth is drawn."""
_NARROW = 130.0
"""A figure below this width [mm] has its legend in one column."""


class _Component(NamedTuple):
    of: Callable[[State], FloatArray]
    scale: float
    label: str


def _moved(axis: str) -> Callable[[State], FloatArray]:
    """The displacement along an axis, of a state that knows it."""

    def of(state: State) -> FloatArray:
        if state.displacement is None:
            rule = "under a contact that does not end along z it is known only up to a constant"
            raise InvalidValueError(f'component = "displacement.{axis}"', rule, "a local contact, or a strain")
        moved: FloatArray = getattr(state.displacement, axis)
        return moved

    return of


COMPONENTS = {
    **{
        f"strain.{c}": _Component(attrgetter(f"strain.{c}"), 100.0, rf"strain $\varepsilon_{c[0]}$ [%]")
        for c in ("xx", "yy", "zz")
    },
    **{
        f"strain.{c}": _Component(attrgetter(f"strain.{c}"), 100.0, rf"shear strain $\varepsilon_{{{c}}}$ [%]")
        for c in ("xy", "xz", "yz")
    },
    **{
        f"stress.{c}": _Component(attrgetter(f"stress.{c}"), 1e-3, rf"stress $\sigma_{c[0]}$ [kPa]")
        for c in ("xx", "yy", "zz")
    },
    **{
        f"stress.{c}": _Component(attrgetter(f"stress.{c}"), 1e-3, rf"shear stress $\tau_{{{c}}}$ [kPa]")
        for c in ("xy", "xz", "yz")
    },
    "mean_pressure": _Component(attrgetter("stress.mean_pressure"), 1e-3, "mean pressure [kPa]"),
    **{f"displacement.{c}": _Component(_moved(c), 1e3, f"displacement $u_{c}$ [mm]") for c in "xyz"},
}
"""What can be drawn in the skin, by name."""


class _Force(NamedTuple):
    """A resultant on the surface: position [mm], magnitude [N/m], angle [rad]."""

    position: float
    size: float
    angle: float


@finished
def finger_section(
    finger: Finger,
    contact: Contact | None,
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
    contact : Contact or None
        What presses; a single contact, not a batch. None where only the estimate is known: its load's field is drawn.
    estimate : Estimate, optional
        The load found from one frame, drawn with its 95 % interval (a wedge for the angle, a bar for the
        position).
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
    _check.choice("component", component, COMPONENTS)
    if estimate is not None and np.size(estimate.status) != 1:
        raise GeometryError(
            f"estimate of shape {estimate.shape}", "the estimate of a single frame is needed", "found[0]"
        )
    known = contact is not None
    contact = _load_of(estimate) if contact is None else contact
    if contact.shape:
        raise GeometryError(f"contact of shape {contact.shape}", "a single contact is needed", "draw them one by one")
    frame = None if readings is None else _check.real("readings", _check.readings(readings), finite=False)
    if frame is not None and frame.shape != (len(finger.array),):
        raise GeometryError(
            f"readings of shape {frame.shape}", f"one for each of the {len(finger.array)} sensors", "readings[0]"
        )

    forces = _resultants(contact)
    left, right, bottom = _window(finger, forces)
    top, base = 0.5 * bottom, MM * finger.skin.thickness
    foot = bottom if bottom < base else base + _BASE * base
    inner = width - _LEFT - _RIGHT
    heights = [inner * (foot + top) / (right - left)]
    heights += [max(0.2 * inner, 20.0)] if frame is not None else []
    figure, panels = stacked(width, heights, left=_LEFT, right=_RIGHT, top=7.0 if title else 1.5, foot=_FOOT)
    panels[0].set(xlim=(left, right), ylim=(foot, -top), ylabel="depth x [mm]")
    box = panels[0].get_position()
    bar = figure.add_axes((box.x1 + 2.5 / width, box.y0, 2.2 / width, box.height))
    shallowest = MM * float(np.asarray(finger.array.depth).min())
    drawn = _field(panels[0], finger.skin, contact, COMPONENTS[component], (left, right, bottom), 0.3 * shallowest)
    _inside(panels[0], finger.skin, foot)
    _colour_bar(bar, drawn, COMPONENTS[component].label, heights[0])
    scale = _Scale(top, max(force.size for force in forces) or 1.0, min(1.0, inner / 140.0))
    if known:
        _above(panels[0], contact, forces, scale, "load" if estimate is None else "true")
    _sensors(panels[0], finger, estimate)
    if estimate is not None:
        _found(panels[0], estimate, scale, "\n" if width < _NARROW else " ")
    if frame is not None:
        draw_readings(panels[1], finger, contact, estimate, frame)
    arc = ", unrolled" if finger.skin.curvature else ""
    panels[-1].set_xlabel(f"position along the skin y [mm]{arc}")
    _legend(figure, panels[0], columns=1 if width < _NARROW else 2)
    if title:
        high = figure.get_figheight() * 25.4
        figure.text(_LEFT / width, 1 - 1.5 / high, title, va="top", fontweight="bold")
    return figure


def _load_of(estimate: Estimate | None) -> LineLoad:
    """The load that was found in a single frame."""
    if estimate is None or not np.isfinite(estimate.force).all():
        seen = "neither a contact" if estimate is None else "neither a contact nor a frame with a load"
        raise GeometryError(seen, "one of them has a field to draw", "contact=ss.LineLoad(force=40.0)")
    return LineLoad.of_components(np.reshape(estimate.components, 2), np.reshape(estimate.position, ()))


class _Scale(NamedTuple):
    """How arrows are drawn: the room above the skin [mm of skin], the largest force, the thickness."""

    top: float
    force: float
    weight: float

    def length(self, size: float) -> float:
        """Length of the arrow of a force [mm of skin]: in proportion, but long enough to see its angle."""
        return 0.85 * self.top * float(np.clip(size / self.force, 0.35, 1.1))


def _legend(figure: Figure, axes: Axes, columns: int) -> None:
    """The legend in a foot added to the figure for it; the panels keep their size."""
    handles, labels = axes.get_legend_handles_labels()
    lines = [1 + label.count("\n") for label in labels]
    rows = -(-len(lines) // columns)
    extra = 1.0 + 3.9 * max(sum(lines[c * rows : (c + 1) * rows]) for c in range(columns))
    width, height = figure.get_figwidth() * 25.4, figure.get_figheight() * 25.4
    figure.set_size_inches(width / 25.4, (height + extra) / 25.4)
    for panel in figure.axes:
        x, y, w, h = panel.get_position().bounds
        panel.set_position((x, (y * height + extra) / (height + extra), w, h * height / (height + extra)))
    look: dict[str, Any] = {"loc": "lower left", "borderaxespad": 0.0, "borderpad": 0.2, "columnspacing": 1.5}
    figure.legend(handles, labels, ncols=columns, bbox_to_anchor=(_LEFT / width, 0.0), **look)


def _resultants(contact: Contact) -> list[_Force]:
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
        forces.append(_Force(MM * position, size, angle))
    return forces


def _window(finger: Finger, forces: list[_Force]) -> tuple[float, float, float]:
    """Left, right and bottom of the picture [mm]."""
    y, depth = MM * np.asarray(finger.array.y), MM * np.asarray(finger.array.depth)
    positions = [*y, *(force.position for force in forces)]
    margin = 1.2 * float(depth.max())
    bottom, base = 1.7 * float(depth.max()), MM * finger.skin.thickness
    if base < _NEAR_BASE * bottom:
        bottom = base
    return min(positions) - margin, max(positions) + margin, bottom


def _levels(values: FloatArray) -> FloatArray:
    """Levels 1, 2, 5, 10, ... on both sides of zero, over two decades: the far field shows as well."""
    most = float(values.max()) or 1.0
    steps = np.array([m * 10.0**e for e in range(-18, 13) for m in (1, 2, 5)])
    last = int(np.searchsorted(steps, most * 0.999))
    side = steps[max(last - 6, 0) : last + 1]
    return np.concatenate([-side[::-1], side])


def _field(
    axes: Axes, skin: Skin, contact: Contact, component: _Component, window: tuple[float, float, float], near: float
) -> ContourSet:
    """The field in the window [mm]; its levels are those of what lies deeper than `near` [mm]."""
    left, right, bottom = window
    y = np.linspace(left, right, 481)
    # the first row lies just beneath the surface, on which a contact's edge may be singular
    x = np.linspace(0.0, bottom, 241)
    x[0] = 0.02 * x[1]
    values = component.scale * component.of(skin.state(contact, x[:, None] / MM, y / MM))
    levels = _levels(np.abs(values[x >= near]))
    colours = colormaps["RdBu_r"].resampled(levels.size + 1)
    x[0] = 0.0
    norm = BoundaryNorm(levels, colours.N, extend="both")
    drawn = axes.contourf(y, x, values, levels, cmap=colours, norm=norm, extend="both")
    drawn.set_edgecolor("face")  # no hairlines between the bands in SVG
    axes.set_yticks([t for t in MaxNLocator(4, steps=[1, 2, 5, 10]).tick_values(0.0, bottom) if t <= bottom])
    axes.spines["left"].set_bounds(bottom, 0.0)
    return drawn


def _inside(axes: Axes, skin: Skin, foot: float) -> None:
    """The rigid base, where it is in the picture, and the interfaces between layers."""
    if MM * skin.thickness < foot:
        grey: dict[str, Any] = {"facecolor": "#DDDDDD", "edgecolor": GREY, "hatch": "////", "label": "rigid base"}
        axes.axhspan(MM * skin.thickness, foot, linewidth=0, **grey)
        axes.axhline(MM * skin.thickness, color=BLACK, linewidth=0.9)
    for depth in skin.interfaces:
        axes.axhline(MM * depth, color=BLACK, linewidth=0.6, linestyle=(0, (5, 2)))


def _colour_bar(axes: Axes, drawn: ContourSet, label: str, height: float) -> None:
    """Bar beside the section, `height` [mm]: if that is too low, only some levels are labelled."""
    levels = np.asarray(drawn.levels)
    half = levels.size // 2
    step = 1 if height / levels.size > 2.7 else 2 if height / levels.size > 1.7 else 3
    kept = np.arange(half if step == 1 else half - 1)[::step]  # the two around zero stand close
    ticks = levels[np.concatenate([kept, levels.size - 1 - kept[::-1]])]
    # the power of ten nearest to 1 that leaves room for the label beside the ticks
    power = min(
        range(-12, 13, 3), key=lambda p: (max(len(t.replace(".", "")) for t in _written(ticks, p)) > _TICK, abs(p))
    )
    unit = label.replace("[", f"[$10^{{{power}}}$ ") if power else label
    bar = Colorbar(axes, drawn, label=unit, ticks=ticks.tolist())
    bar.ax.set_yticklabels(_written(ticks, power), fontsize=6)
    bar.ax.yaxis.labelpad -= 1.5 * (power != 0)  # a power stands higher than its line
    bar.minorticks_off()


def _written(ticks: FloatArray, power: int) -> list[str]:
    """The ticks in units of a power of ten."""
    return [f"{v / 10.0**power:g}".replace("-", "−") for v in ticks]


def _above(axes: Axes, contact: Contact, forces: list[_Force], scale: _Scale, name: str) -> None:
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
    axes.axhline(0.0, color=BLACK, linewidth=0.9, zorder=2)
    thick: dict[str, Any] = {"color": BLACK, "linewidth": 3.6 * scale.weight}
    for force in forces:
        _arrow(axes, force, scale.length(force.size), mutation_scale=14 * scale.weight, zorder=3, **thick)
        where = f"{np.degrees(force.angle):z.1f}°, y = {force.position:z.2f} mm".replace("-", "−")
        axes.plot([], [], label=f"{name}: {force.size:.3g} N/m at {where}", **thick)


def _arrow(axes: Axes, force: _Force, length: float, **style: Any) -> None:
    """The force on the skin: an arrow that ends on the surface, or leaves it where the force pulls."""
    away = (length * np.sin(force.angle), length * np.cos(force.angle))
    here, pulls = (force.position, 0.0), force.angle**2 > (np.pi / 2) ** 2
    ends = (here, (force.position + away[0], away[1])) if pulls else ((force.position - away[0], -away[1]), here)
    axes.add_patch(FancyArrowPatch(*ends, arrowstyle="-|>", shrinkA=0, shrinkB=0, **style))


def _found(axes: Axes, estimate: Estimate, scale: _Scale, gap: str) -> None:
    """The load found: its arrow, the wedge of its angle and the bar of its position, both 95 %."""
    position, size, angle = (float(np.squeeze(v)) for v in (estimate.position, estimate.force, estimate.angle))
    status = Status(int(np.squeeze(estimate.status))).name.lower().replace("_", " ")
    if not np.isfinite([position, size, angle]).all():
        axes.plot([], [], " ", label=f"found: {status}")
        return
    half = NORMAL_95 * np.nan_to_num(np.reshape(estimate.std[..., :3], 3))
    force, length = _Force(MM * position, size, angle), scale.length(size)
    turn = np.linspace(angle - half[2], angle + half[2], 31)
    rim = np.column_stack([force.position - length * np.sin(turn), -length * np.cos(turn)])
    wedge = Polygon(np.vstack([[force.position, 0.0], rim]), color=VERMILLION, alpha=0.3, linewidth=0, zorder=3.5)
    axes.add_patch(wedge)
    thin: dict[str, Any] = {"color": VERMILLION, "linewidth": 1.6 * scale.weight}
    _arrow(axes, force, length, mutation_scale=8 * scale.weight, zorder=4, **thin)
    axes.errorbar(force.position, 0.0, xerr=MM * half[0], color=VERMILLION, capsize=2.5, elinewidth=1.6, zorder=4)
    degrees, where = _pm(np.degrees(angle), np.degrees(half[2])), _pm(force.position, MM * half[0])
    text = f"found ({status}): {_pm(size, half[1])} {estimate.force_unit} at {degrees}°,{gap}y = {where} mm"
    axes.plot([], [], label=text, **thin)


def _pm(value: float, half: float) -> str:
    """`value` with its 95 % interval, to two digits of the latter."""
    digits = int(np.clip(1 - np.floor(np.log10(half)), 0, 9)) if half > 0 else 3
    return f"{value:z.{digits}f} ± {half:.{digits}f}".replace("-", "−")


def _sensors(axes: Axes, finger: Finger, estimate: Estimate | None) -> None:
    array = finger.array
    y, depth, half = (MM * np.asarray(a) for a in (array.y, array.depth, 0.5 * np.asarray(array.width)))
    used = array.live if estimate is None else np.reshape(estimate.used, -1)
    for i in np.flatnonzero(half > 0):
        axes.plot([y[i] - half[i], y[i] + half[i]], [depth[i]] * 2, color=BLACK, linewidth=2.4, zorder=2.6)
    dot: dict[str, Any] = {"mfc": "white", "mec": BLACK, "mew": 0.9, "ms": 5.0, "zorder": 2.8, "clip_on": False}
    axes.plot(y[used], depth[used], "o", label="sensor", **dot)
    if not used.all():
        axes.plot(y[~used], depth[~used], "X", label="sensor left out", **dot)
