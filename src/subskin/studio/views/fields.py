"""What a page can draw in the skin, and the field of it under a touch, quick enough to follow a hand.

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

from ..._check import FloatArray
from ...skin import Skin
from ...tensor import State
from .state import Touch, pressing

__all__ = [
    "QUANTITIES",
    "RANGE",
    "FieldDrawing",
    "FieldGrid",
    "FieldKind",
    "UnitFields",
    "nice",
    "offered",
    "quantised",
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
