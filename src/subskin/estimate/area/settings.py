"""What the compiled loops of sensors on an area go by: settings, where is looked, and scratch, each by its name."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..varpro import Limits
from .point import PointModel
from .tiles import Tiles

__all__ = ["Beyond", "Scratch", "Search", "Settings", "plain"]


def plain(value: Any) -> Any:
    """A named tuple as one without names, and so its parts: Numba takes these in a third of the time.

    A loop gives them their names again, part by part.
    """
    return tuple(plain(part) for part in value) if isinstance(value, tuple) else value


class Settings(NamedTuple):
    """Thresholds of a search.

    detection: least chi-square explained by a contact; largest: most that may be left; ambiguity: chi-square by which
    the second-best has to be worse; apart: two tops nearer than this are one [m]; broad: a profile wider than this may
    be ambiguous [m]; strong: noises from which the strongest reading names a tile; curved: standard deviation from
    which S need be no parabola [m]; smallest: least step of a climb [m]; box (4,): ends of y, then of z; error: chi-
    square of a unit force, squared, by the table's error; told: least share of a load by which others near it differ,
    infinite where that is large.
    """

    limits: Limits
    detection: float
    largest: float
    ambiguity: float
    apart: float
    broad: float
    strong: float
    curved: float
    smallest: float
    box: FloatArray
    error: float
    told: float


class Beyond(NamedTuple):
    """What lies at the sides of the search and beyond: four boxes, their nodes (nodes, 4), and the tiles of these.

    held, members: the nodes of each region, as of `far.nodes_of`.
    """

    tiles: Tiles
    nodes: FloatArray
    boxes: FloatArray
    held: npt.NDArray[np.int64]
    members: npt.NDArray[np.int64]


class Search(NamedTuple):
    """Where point loads are looked for, and what sensors read of them."""

    model: PointModel
    tiles: Tiles
    settings: Settings


class Scratch(NamedTuple):
    """Scratch of a search.

    lead: numbers before the nodes of `heights`; score (most,), at (most, 2): the highest nodes; fits: of these, one to
    try in and five more, then four of other purposes; lanes: as of `fall.LANES`; ratio (8,), root (3,), more (3,).
    """

    lead: int
    heights: npt.NDArray[np.float32]
    part: FloatArray
    score: FloatArray
    at: FloatArray
    fits: npt.NDArray[np.void]
    trials: npt.NDArray[np.void]
    lanes: FloatArray
    ratio: FloatArray
    root: FloatArray
    more: FloatArray
