"""The field under a touch, quick enough to follow a hand: made of the fields of unit loads, which are kept.

A skin is the same at every position, and its field is linear in the components of the load. So the field of each unit
load is worked out once, on points that are fixed to the contact; under any load, at any position, it is their sum.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...contact import family_of, local_family_of
from ...skin import Skin
from .quantities import FieldKind
from .touch import Touch

__all__ = ["RANGE", "FieldGrid", "UnitFields", "nice", "quantised"]

_KEPT = 96
"""Fields of unit loads that are kept."""
RANGE = 30.0
"""A colour bar is linear within 1 / 30 of its end, and logarithmic beyond."""
_MANY = 10_000
"""Points of a map from above beyond which Fourier transforms are quicker."""
_NICE = np.array([1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0])


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


class UnitFields:
    """Fields of unit loads, kept for as long as there is room."""

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[Any, ...], FloatArray] = OrderedDict()

    def field(self, skin: Skin, touch: Touch, shown: FieldKind, grid: FieldGrid) -> FloatArray:
        """Values of what is shown at the grid's points, in its unit for people, shape (down, along).

        Parameters
        ----------
        skin : Skin
            What is pressed.
        touch : Touch
            What presses; where it lies does not matter.
        shown : FieldKind
            What is looked at.
        grid : FieldGrid
            Points about the contact.
        """
        parts = touch.contact().components
        least = 1e-12 * float(np.abs(parts).max())
        out = np.zeros((grid.down[2], grid.along[2]))
        for component, size in enumerate(parts.tolist()):
            if abs(size) > least:
                out += size * self._unit(skin, touch, shown, grid, component)
        return out

    def missing(self, skin: Skin, touch: Touch, shown: FieldKind, grid: FieldGrid) -> int:
        """How many fields of unit loads have to be worked out for `field`."""
        parts = np.abs(touch.contact().components)
        used = np.flatnonzero(parts > 1e-12 * parts.max()).tolist()
        return sum(self._key(skin, touch, shown, grid, component) not in self._kept for component in used)

    def prepare(self, skin: Skin, touch: Touch, shown: FieldKind, grid: FieldGrid) -> None:
        """Work out one field that is missing, if any."""
        parts = np.abs(touch.contact().components)
        for component in np.flatnonzero(parts > 1e-12 * parts.max()).tolist():
            if self._key(skin, touch, shown, grid, component) not in self._kept:
                self._unit(skin, touch, shown, grid, component)
                return

    @staticmethod
    def here(skin: Skin, touch: Touch, shown: FieldKind, grid: FieldGrid) -> FloatArray:
        """The same where the touch lies: of a skin that is not the same at every position, such as one with ridges."""
        along, down = grid.points
        y = touch.position[0] + along
        if not touch.local:
            state = skin.state(touch.contact(), down[:, None], y)
        elif grid.depth is None:
            state = skin.state(touch.contact(), down[:, None], y, touch.position[1])
        else:
            state = skin.state(touch.contact(), grid.depth, y, touch.position[1] + down[:, None])
        return shown.scale * np.nan_to_num(shown.of(state))

    @staticmethod
    def direct(skin: Skin, touch: Touch, shown: FieldKind, grid: FieldGrid) -> FloatArray:
        """The same without unit fields: for few points, where the touch changes its width at each step."""
        return _values(skin, touch, shown, grid, touch.contact().components)

    @staticmethod
    def _key(skin: Skin, touch: Touch, shown: FieldKind, grid: FieldGrid, component: int) -> tuple[Any, ...]:
        return skin, touch.family, touch.half_width if touch.wide else 0.0, touch.local, shown.name, grid, component

    def _unit(self, skin: Skin, touch: Touch, shown: FieldKind, grid: FieldGrid, component: int) -> FloatArray:
        key = self._key(skin, touch, shown, grid, component)
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        made = _values(skin, touch, shown, grid, np.eye(3 if touch.local else 2)[component])
        self._kept[key] = made
        if len(self._kept) > _KEPT:
            self._kept.popitem(last=False)
        return made


def _values(skin: Skin, touch: Touch, shown: FieldKind, grid: FieldGrid, components: FloatArray) -> FloatArray:
    """What is shown under such a touch of some components, at the grid's points about it."""
    along, down = grid.points
    wide = {"half_width": touch.half_width} if touch.wide else {}
    if not touch.local:
        long: Any = family_of(touch.family)
        state = skin.state(long.of_components(components, 0.0, **wide), down[:, None], along)
    else:
        local: Any = local_family_of(touch.family)
        pressed = local(components=components, position=(0.0, 0.0), **wide)
        if grid.depth is not None and wide and along.size * down.size > _MANY:
            return shown.scale * np.nan_to_num(shown.of(skin.map(pressed, grid.depth, along, down)).T)
        points = (down[:, None], along, 0.0) if grid.depth is None else (grid.depth, along, down[:, None])
        state = skin.state(pressed, *points)
    return shown.scale * np.nan_to_num(shown.of(state))


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
