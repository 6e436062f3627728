"""Elements of one size, as the compiled loops of an area want them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from .hats import AT_ONCE, Hats
from .prior import Membrane

__all__ = ["Level", "level_of"]


class Level(NamedTuple):
    """Elements of one size (`_on_area.py`)."""

    parts: FloatArray
    start: npt.NDArray[np.int64]
    gain: FloatArray
    length: int
    stencil: FloatArray
    sizes: npt.NDArray[np.int64]
    cost: FloatArray
    area: float
    largest: float


def level_of(hats: Hats, components: int, prior: Membrane, pull: float, rim: int, friction: float) -> Level:
    """Elements with a pressure, and with drags along y and z where there are 3 components, not 1."""
    parts, start, length = hats.flat(components)
    more = -start.size % AT_ONCE
    start, gain = np.pad(start, (0, more)), np.pad(hats.gain, (0, more))
    sizes, cost = np.array([*prior.shape, rim], dtype=np.int64), np.full(prior.shape[0] * prior.shape[1], pull)
    norms = sum(np.linalg.norm(hats.columns(i), axis=1) for i in range(components))
    largest = float(np.max(norms)) * max(1.0, friction)
    return Level(parts, start, gain, length, prior.stencil, sizes, cost, prior.steps[0] * prior.steps[1], largest)
