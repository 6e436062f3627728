"""The pieces of a picture of a skin: field and colour bar, base and layers, arrows of forces, sensors, legend."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.colors import BoundaryNorm
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch
from matplotlib.ticker import MaxNLocator

from .. import _check
from .._check import FloatArray
from ..errors import InvalidValueError
from ..estimate import Estimate
from ..finger import Finger
from ..skin import Skin
from ..tensor import State
from .style import MM, Ink

LEFT, RIGHT, FOOT = 13.5, 18.0, 9.5
"""Margins [mm]: beside the panels, and below them for the label."""
_TICK = 4
"""Minus and digits of a tick of the colour bar that there is room for."""
_BASE = 0.12
"""Thickness of the base as it is drawn, in thicknesses of the skin."""
_NEAR_BASE = 1.6
"""A base that lies no deeper than this many times the picture's usual depth is drawn."""


class Component(NamedTuple):
    """What is drawn in a skin: the numbers of a state, what they are multiplied by, and the label."""

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


_TENSORS = {
    "strain": (100.0, "%", r"strain $\varepsilon_{}$", r"shear strain $\varepsilon_{{{}}}$"),
    "stress": (1e-3, "kPa", r"stress $\sigma_{}$", r"shear stress $\tau_{{{}}}$"),
}
COMPONENTS = {
    f"{kind}.{c}": Component(
        attrgetter(f"{kind}.{c}"), scale, f"{along.format(c[0]) if c[0] == c[1] else shear.format(c)} [{unit}]"
    )
    for kind, (scale, unit, along, shear) in _TENSORS.items()
    for c in ("xx", "yy", "zz", "xy", "xz", "yz")
}
COMPONENTS["mean_pressure"] = Component(attrgetter("stress.mean_pressure"), 1e-3, "mean pressure [kPa]")
COMPONENTS |= {f"displacement.{c}": Component(_moved(c), 1e3, f"displacement $u_{c}$ [mm]") for c in "xyz"}
"""What can be drawn in the skin, by name."""


class Force(NamedTuple):
    """A resultant on the surface: position [mm], magnitude [N/m], angle [rad]."""

    position: float
    size: float
    angle: float


class Scale(NamedTuple):
    """How arrows are drawn: the room above the skin [mm of skin], the largest force, the thickness."""

    top: float
    force: float
    weight: float

    def length(self, size: float) -> float:
        """Length of the arrow of a force [mm of skin]: in proportion, but long enough to see its angle."""
        return 0.85 * self.top * float(np.clip(size / self.force, 0.35, 1.1))


def component_of(name: str) -> Component:
    """What can be drawn of a name; refuses others."""
    _check.choice("component", name, COMPONENTS)
    return COMPONENTS[name]


def shown_depth(finger: Finger) -> float:
    """How deep a picture of a finger goes [mm]: well below its sensors, or to the base where that is near."""
    usual, base = 1.7 * MM * float(np.asarray(finger.array.depth).max()), MM * finger.skin.thickness
    return base if base < _NEAR_BASE * usual else usual


def foot_of(skin: Skin, bottom: float) -> float:
    """Where a picture that shows the skin down to `bottom` ends [mm]: with some of the base, where it reaches that."""
    base = MM * skin.thickness
    return bottom if bottom < base else base + _BASE * base


def depths(axes: Axes, bottom: float) -> None:
    """Ticks of the depth, and its axis, from the surface to `bottom` [mm]."""
    axes.set_yticks([t for t in MaxNLocator(4, steps=[1, 2, 5, 10]).tick_values(0.0, bottom) if t <= bottom])
    axes.spines["left"].set_bounds(bottom, 0.0)


def bands(axes: Axes, x: FloatArray, y: FloatArray, values: FloatArray, levels: FloatArray) -> ContourSet:
    """A field in bands of colour between the levels."""
    colours = colormaps["RdBu_r"].resampled(levels.size + 1)
    norm = BoundaryNorm(levels, colours.N, extend="both")
    drawn = axes.contourf(x, y, values, levels, cmap=colours, norm=norm, extend="both")
    drawn.set_edgecolor("face")  # no hairlines between the bands in SVG
    return drawn


def levels_of(values: FloatArray) -> FloatArray:
    """Levels 1, 2, 5, 10, ... on both sides of zero, over two decades: the far field shows as well."""
    most = float(values.max()) or 1.0
    steps = np.array([m * 10.0**e for e in range(-18, 13) for m in (1, 2, 5)])
    last = int(np.searchsorted(steps, most * 0.999))
    side = steps[max(last - 6, 0) : last + 1]
    return np.concatenate([-side[::-1], side])


def inside(axes: Axes, skin: Skin, foot: float) -> None:
    """The rigid base, where it is in the picture, and the interfaces between layers."""
    if MM * skin.thickness < foot:
        grey: dict[str, Any] = {"facecolor": "#DDDDDD", "edgecolor": Ink.GREY, "hatch": "////", "label": "rigid base"}
        axes.axhspan(MM * skin.thickness, foot, linewidth=0, **grey)
        axes.axhline(MM * skin.thickness, color=Ink.BLACK, linewidth=0.9)
    for depth in skin.interfaces:
        axes.axhline(MM * depth, color=Ink.BLACK, linewidth=0.6, linestyle=(0, (5, 2)))


def colour_bar(axes: Axes, drawn: ContourSet, label: str, height: float) -> None:
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


def arrow(axes: Axes, force: Force, length: float, **style: Any) -> None:
    """The force on the skin: an arrow that ends on the surface, or leaves it where the force pulls."""
    away = (length * np.sin(force.angle), length * np.cos(force.angle))
    here, pulls = (force.position, 0.0), force.angle**2 > (np.pi / 2) ** 2
    ends = (here, (force.position + away[0], away[1])) if pulls else ((force.position - away[0], -away[1]), here)
    axes.add_patch(FancyArrowPatch(*ends, arrowstyle="-|>", shrinkA=0, shrinkB=0, **style))


def sensors(axes: Axes, finger: Finger, estimate: Estimate | None) -> None:
    """The sensors in a section, those that were left out crossed."""
    array = finger.array
    y, depth, half = (MM * np.asarray(a) for a in (array.y, array.depth, 0.5 * np.asarray(array.width)))
    used = array.live if estimate is None else np.reshape(estimate.used, -1)
    for i in np.flatnonzero(half > 0):
        axes.plot([y[i] - half[i], y[i] + half[i]], [depth[i]] * 2, color=Ink.BLACK, linewidth=2.4, zorder=2.6)
    dot: dict[str, Any] = {"mfc": "white", "mec": Ink.BLACK, "mew": 0.9, "ms": 5.0, "zorder": 2.8, "clip_on": False}
    axes.plot(y[used], depth[used], "o", label="sensor", **dot)
    if not used.all():
        axes.plot(y[~used], depth[~used], "X", label="sensor left out", **dot)


def legend_below(figure: Figure, axes: Axes, columns: int) -> None:
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
    figure.legend(handles, labels, ncols=columns, bbox_to_anchor=(LEFT / width, 0.0), **look)
