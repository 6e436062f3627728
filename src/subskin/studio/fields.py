"""What a page can draw in the skin, where, and the field of it under a touch, quick enough to follow a hand.

A skin is the same at every position, and its field is linear in the components of the load. So the field of each unit
load is worked out once, on points that are fixed to the contact; under any load, at any position, it is their sum.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from functools import lru_cache
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..finger import Finger
from ..skin import Skin
from ..tensor import State
from .state import Look, Touch, Window, pressing

__all__ = [
    "QUANTITIES",
    "RANGE",
    "FieldDrawing",
    "FieldGrid",
    "FieldKind",
    "UnitFields",
    "coarse_of",
    "deep_of",
    "grids",
    "held",
    "inside",
    "nice",
    "offered",
    "quantised",
    "quantity_of",
    "seen_of",
    "window_of",
]

_KEPT = 96
"""Fields of unit loads that are kept."""
RANGE = 30.0
"""A colour bar is linear within 1 / 30 of its end, and logarithmic beyond."""
_MANY = 10_000
"""Points of a map from above beyond which Fourier transforms are quicker."""
_NICE = np.array([1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0])


class FieldKind(NamedTuple):
    """A field that can be drawn."""

    name: str
    label: str
    unit: str
    scale: float
    of: Callable[[State], FloatArray]


def _made() -> dict[str, FieldKind]:
    every = [FieldKind("mean_pressure", "mean pressure", "kPa", 1e-3, attrgetter("stress.mean_pressure"))]
    for what, letter, shear, unit, scale in (("strain", "ε", "ε", "%", 100.0), ("stress", "σ", "τ", "kPa", 1e-3)):
        for c in ("xx", "yy", "zz", "xy", "xz", "yz"):
            plain = c[0] == c[1]
            sign = f"{letter}{c[0]}" if plain else f"{shear}{c}"
            words = f"{what} {sign}" if plain else f"shear {what} {sign}"
            every.append(FieldKind(f"{what}.{c}", words, unit, scale, attrgetter(f"{what}.{c}")))
    for c in "xyz":
        every.append(FieldKind(f"displacement.{c}", f"displacement u{c}", "µm", 1e6, attrgetter(f"displacement.{c}")))
    return {quantity.name: quantity for quantity in every}


QUANTITIES = _made()
"""All of them, by name."""


@lru_cache(maxsize=2)
def offered(*, local: bool) -> dict[str, FieldKind]:
    """Those that are not nothing, by name: under a long contact no shear along z; its displacements are not known.

    Parameters
    ----------
    local : bool
        Whether the contact ends along z.
    """
    hidden = () if local else ("xz", "yz")
    return {k: q for k, q in QUANTITIES.items() if local or not (k.endswith(hidden) or k.startswith("displ"))}


class FieldGrid(NamedTuple):
    """Points fixed to the contact: distances from it along y, and depths x or distances along z [m]."""

    along: tuple[float, float, int]
    """First distance, step and count along y."""
    down: tuple[float, float, int]
    """The same of depths x, or of distances along z."""
    depth: float | None = None
    """Depth of a map from above; None for a section."""

    @property
    def points(self) -> tuple[FloatArray, FloatArray]:
        """The values along y, and those down."""
        return tuple(first + step * np.arange(count) for first, step, count in (self.along, self.down))  # type: ignore[return-value]


class FieldDrawing(NamedTuple):
    """What is to be drawn: which field, under which touch, at which points about it."""

    skin: Skin
    touch: Touch
    shown: FieldKind
    grid: FieldGrid

    def values(self, components: FloatArray, *, there: bool = False) -> FloatArray:
        """Values in their unit for people, shape (down, along), under such a touch of some components.

        Parameters
        ----------
        components : ndarray
            As of `state.pressing` [N/m, on an area N].
        there : bool, optional
            Where the touch lies: of a skin that is not the same at every position, such as one with ridges.
        """
        touch, (along, down), depth = self.touch, self.grid.points, self.grid.depth
        y, z = (*touch.position, 0.0)[:2] if there else (0.0, 0.0)
        pressed: Any = pressing(touch.family, components, (y, z), touch.half_width if touch.wide else None)
        if depth is not None and touch.wide and not there and along.size * down.size > _MANY:
            return self.shown.scale * np.nan_to_num(self.shown.of(self.skin.map(pressed, depth, along, down)).T)
        points: Any = (down[:, None], y + along) if depth is None else (depth, y + along, z + down[:, None])
        if touch.local and depth is None:
            points = (*points, z)
        return self.shown.scale * np.nan_to_num(self.shown.of(self.skin.state(pressed, *points)))

    def parts(self) -> list[int]:
        """Which components of the touch are not zero."""
        sizes = np.abs(self.touch.components)
        return [int(i) for i in np.flatnonzero(sizes > 1e-12 * sizes.max())]


class UnitFields:
    """Fields of unit loads, kept for as long as there is room."""

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[Any, ...], FloatArray] = OrderedDict()

    def drawn(
        self, finger: Finger, touch: Touch, shown: FieldKind, window: Window, how: Look
    ) -> tuple[list[dict[str, Any]], list[npt.NDArray[np.uint8]], bool]:
        """The fields of the section and, on an area, from above; whether they are still coarse.

        Parameters
        ----------
        finger, touch, shown, window, how
            What is to be drawn, of which finger, and how it is looked at.
        """
        metas, fields, coarse = [], [], False
        for name, grid in grids(finger, window).items():
            ridged = finger.skin.ridges is not None  # not the same at every position
            picture = FieldDrawing(finger.skin, touch, shown, grid)
            missing = 0 if ridged else len(self.missing(picture))
            if missing and how.refine and not coarse:
                self.prepare(picture)
                missing -= 1
            if missing and not (how.moving or how.refine) and not touch.local and finger.skin.endless:
                missing = 0  # a whole field is a matter of milliseconds
            if ridged or missing:
                # the map from above changes with the depth of the sensors
                every = 3 if missing and how.moving and grid.depth is not None else 2
                coarse, grid = coarse or not ridged, coarse_of(grid, touch, window, every)
                values = picture._replace(grid=grid).values(touch.components, there=ridged)
            else:
                values = self.field(picture)
            most = nice(float(np.abs(deep_of(values, grid, finger)).max()))
            values, grid = seen_of(values, grid, touch, window)
            along, down = grid.along, grid.down
            across = 0.0 if grid.depth is None else touch.position[1]
            metas.append(
                {
                    "name": name,
                    "shape": [down[2], along[2]],
                    "most": most,
                    "range": RANGE,
                    "unit": shown.unit,
                    "label": shown.label,
                    "x": [touch.position[0] + along[0] - 0.5 * along[1], along[1] * along[2]],
                    "y": [across + down[0] - 0.5 * down[1], down[1] * down[2]],
                }
            )
            fields.append(quantised(values, most))
        return metas, fields, coarse

    def field(self, picture: FieldDrawing) -> FloatArray:
        """Values of what is shown at the grid's points, in its unit for people, shape (down, along).

        Parameters
        ----------
        picture : FieldDrawing
            What is to be drawn.
        """
        components = picture.touch.components
        return np.asarray(sum(components[i] * self._unit(picture, i) for i in picture.parts()))

    def missing(self, picture: FieldDrawing) -> list[int]:
        """Components whose fields have to be worked out for `field`.

        Parameters
        ----------
        picture : FieldDrawing
            What is to be drawn.
        """
        return [i for i in picture.parts() if _key(picture, i) not in self._kept]

    def prepare(self, picture: FieldDrawing) -> None:
        """Work out one field that is missing, if any.

        Parameters
        ----------
        picture : FieldDrawing
            What is to be drawn.
        """
        for component in self.missing(picture)[:1]:
            self._unit(picture, component)

    def _unit(self, picture: FieldDrawing, component: int) -> FloatArray:
        key = _key(picture, component)
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        made = picture.values(np.eye(3 if picture.touch.local else 2)[component])
        self._kept[key] = made
        if len(self._kept) > _KEPT:
            self._kept.popitem(last=False)
        return made


def _key(picture: FieldDrawing, component: int) -> tuple[Any, ...]:
    """What a unit field depends on: not on where the touch lies, nor how hard it presses."""
    skin, touch, shown, grid = picture
    return skin, touch.family, touch.half_width if touch.wide else 0.0, touch.local, shown.name, grid, component


def nice(value: float) -> float:
    """The next round number above `value`: the end of a colour bar, which then seldom moves."""
    if not (np.isfinite(value) and value > 0):
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(f"{power * _NICE[np.searchsorted(_NICE, 0.999 * value / power)]:.3g}")


def quantised(values: FloatArray, most: float) -> npt.NDArray[np.uint8]:
    """Bytes 0 ... 255 for -most ... most: asinh, so that what is weak is seen beside what is strong."""
    steep = np.arcsinh(RANGE * values / most) / np.arcsinh(RANGE)
    made: npt.NDArray[np.uint8] = np.rint(127.5 + 127.5 * np.clip(steep, -1.0, 1.0)).astype(np.uint8)
    return made


_ALONG, _DOWN = 200, 80
"""Points of a field that are seen along the skin, and downwards."""
_MARGIN = 2.2
"""What is seen on both sides of the sensors, in depths."""
_BOTTOM, _TALL, _NEAR_BASE = 2.0, 0.26, 1.6
"""How deep is seen: in depths of the sensors, in widths of what is seen, and up to a base which is not much deeper."""
_NEAR = 0.3
"""The bar's end is the largest value deeper than this share of the shallowest sensor's depth."""


def window_of(finger: Finger) -> Window:
    """What is seen of a finger: its sensors and what is around them.

    Parameters
    ----------
    finger : Finger
        Which one.
    """
    points, depth = finger.array.points, float(np.asarray(finger.array.depth).max())
    margin = _MARGIN * depth
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    bottom, base = max(_BOTTOM * depth, _TALL * float(high[0] - low[0])), float(finger.skin.thickness)
    bottom = base if base < _NEAR_BASE * bottom else bottom
    if finger.skin.curvature:
        middle, half = 0.5 * (low[0] + high[0]), 0.45 * finger.skin.period
        low[0], high[0] = max(low[0], middle - half), min(high[0], middle + half)
    return Window(float(low[0]), float(high[0]), float(low[1]), float(high[1]), bottom, depth)


def held(window: Window, finger: Finger) -> Window:
    """A window that a page holds, as far as the skin reaches."""
    usual = window_of(finger)
    sane = window.left < window.right and window.front < window.back and 0 < window.bottom < 1e3 * usual.bottom
    return (
        window._replace(bottom=min(window.bottom, float(finger.skin.thickness)), level=usual.level) if sane else usual
    )


def grids(finger: Finger, window: Window) -> dict[str, FieldGrid]:
    """Points fixed to the contact which cover what is seen, wherever it lies."""
    step = (window.right - window.left) / _ALONG
    half = _ALONG if not finger.skin.curvature else int(min(_ALONG, 0.49 * finger.skin.period / step))
    along = (-half * step, step, 2 * half + 1)
    deep = window.bottom / _DOWN
    out = {"section": FieldGrid(along, (0.5 * deep, deep, _DOWN))}
    if finger.array.on_area:
        down = (window.back - window.front) / _DOWN
        out["above"] = FieldGrid(along, (-_DOWN * down, down, 2 * _DOWN + 1), window.level)
    return out


def coarse_of(grid: FieldGrid, touch: Touch, window: Window, every: int = 2) -> FieldGrid:
    """Every second or third point, of what is seen alone."""
    step, down, rows = every * grid.along[1], every * grid.down[1], round(_DOWN / every)
    first = window.left - touch.position[0]
    along = (first + 0.5 * step, step, round((window.right - window.left) / step))
    if grid.depth is None:
        return FieldGrid(along, (0.5 * down, down, rows))
    return FieldGrid(along, (window.front - touch.position[1] + 0.5 * down, down, rows), grid.depth)


def seen_of(values: FloatArray, grid: FieldGrid, touch: Touch, window: Window) -> tuple[FloatArray, FieldGrid]:
    """The part of a field that is seen."""

    def part(axis: tuple[float, float, int], low: float, high: float) -> tuple[slice, tuple[float, float, int]]:
        first, step, count = axis
        begin = int(np.clip(np.floor((low - first) / step), 0, count - 1))
        end = int(np.clip(np.ceil((high - first) / step) + 1, begin + 1, count))
        return slice(begin, end), (first + begin * step, step, end - begin)

    columns, along = part(grid.along, window.left - touch.position[0], window.right - touch.position[0])
    rows, down = slice(None), grid.down
    if grid.depth is not None:
        rows, down = part(grid.down, window.front - touch.position[1], window.back - touch.position[1])
    return values[rows, columns], FieldGrid(along, down, grid.depth)


def deep_of(values: FloatArray, grid: FieldGrid, finger: Finger) -> FloatArray:
    """The values by which the colour bar is chosen."""
    if grid.depth is not None:
        return values
    first, step, count = grid.down
    deep = first + step * np.arange(count) >= _NEAR * float(np.asarray(finger.array.depth).min())
    return values[deep] if deep.any() else values  # a window that is held while sensors go deeper than it shows


def inside(touch: Touch, window: Window) -> Touch:
    """The touch where it can be seen, and no wider than what is seen."""
    ends = ((window.left, window.right), (window.front, window.back))
    where = [float(np.clip(at, *end)) for at, end in zip(touch.position, ends)]
    width = min(touch.half_width, 0.25 * (window.right - window.left))
    return touch.model_copy(update={"position": where, "half_width": width})


def quantity_of(name: str | None, finger: Finger, touch: Touch) -> FieldKind:
    """What is shown: what was chosen, or what the first sensor feels."""
    known = offered(local=touch.local)
    felt = finger.array.transducers[0].component
    return known.get(name or "", known.get(felt or "", QUANTITIES["strain.xx"]))
