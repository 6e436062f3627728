"""What is seen of a finger, and which of its points are drawn."""

from __future__ import annotations

import numpy as np

from ..._check import FloatArray
from ...finger import Finger
from .fields import QUANTITIES, FieldGrid, FieldKind, offered
from .state import Touch, Window

__all__ = ["coarse_of", "deep_of", "grids", "held", "inside", "quantity_of", "seen_of", "window_of"]

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
