"""Where no design of the grid will do: which single change of the goals would let one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Literal, NamedTuple

import numpy as np

from ..._check import FloatArray
from ..placement import Arrangement, layouts
from .choices import SkinChoice
from .goals import Goals, Row
from .grid import DEEPEST, DesignGrid, fits, loaded, studied

__all__ = ["Remedy", "remedies"]

_LOADED = ("strain", "range")
_TRIED = 3
"""Depths at which each kind in each skin is tried, the likeliest first; on an area that alone."""
_FURTHER, _STEPS = 3.0, 6
"""Depths outside the room go to so many times its ends, in so many steps."""
_TOUCHES = 2000


@dataclass(frozen=True)
class Remedy:
    """One thing that could be changed while all else stays.

    Parameters
    ----------
    what : {"borne", "force", "young", "depth", "count"}
        "borne": the largest force that a design within the limits bears [N/m], whatever else it misses; "force": the
        largest with which the rest is met too; "young": all moduli of the skin, as a multiple; "depth": of the sensors,
        outside the room [m]; "count": sensors, more than there are to be.
    value : float
        In SI [N/m, Pa or a factor, m, -]; NaN where no such change by itself would do, as far as was tried.
    row : Row or None
        A design that it would take.
    """

    what: Literal["borne", "force", "young", "depth", "count"]
    value: float
    row: Row | None = None


def remedies(grid: DesignGrid) -> tuple[Remedy, ...]:
    """What would do, each change by itself, judged as the grid is: noise alone, and one touch.

    Strains and readings are in proportion to the force. Of other moduli, the softest skin is tried that keeps to the
    largest strain, at each of the few depths where it has to change least.

    Parameters
    ----------
    grid : DesignGrid
        From `search_grid`.

    Examples
    --------
    >>> import subskin as ss
    >>> from subskin.design.search import Accuracy, Effort, Goals, Room, SensorKind, SkinChoice
    >>> goals = Goals(
    ...     ss.design.Touches(force=20.0, friction=0.0, span=(-1e-3, 1e-3)), strongest=400.0,
    ...     accuracy=Accuracy(position=0.1e-3), sensors=(SensorKind("pressure", ss.MeanPressure(), noise=20.0),),
    ...     skins=(SkinChoice("silicone", ss.HalfPlane(ss.Material(young=0.4e6))),),
    ...     room=Room(count=(4, 4), depth=(2e-3, 2e-3), least_pitch=1e-3), effort=Effort(1, 3, touches=200),
    ... )
    >>> found = {remedy.what: remedy.value for remedy in remedies(ss.design.search_grid(goals))}
    >>> round(found["borne"]), round(found["young"], 2)  # eps = 3 P / (2 pi E x) is 10 % at most
    (168, 2.39)
    """
    return *_forces(grid), _moduli(grid), _depths(grid), _counts(grid)


def _forces(grid: DesignGrid) -> Iterator[Remedy]:
    ratios = {c.name: grid.values[c.name] / c.wanted for c in grid.criteria}
    load = np.max([value for name, value in ratios.items() if name in _LOADED], axis=0)
    rest = np.max([value for name, value in ratios.items() if name not in _LOADED], axis=0)
    parts: tuple[tuple[Literal["borne", "force"], FloatArray], ...]
    parts = ("borne", load), ("force", np.where(rest <= 1, load, np.nan))
    for what, ratio in parts:
        least = np.where(np.isfinite(ratio) & (ratio > 0), ratio, np.inf)
        at = np.unravel_index(int(np.argmin(least)), least.shape)
        value = grid.goals.strongest / float(least[at])
        if not value >= grid.goals.touches.force * (what == "force"):
            value = np.nan
        yield Remedy(what, value if value > 0 else np.nan, grid.row(*map(int, at)))


class Change(NamedTuple):
    """A change of some `size`, its `value`, and the goals and the depth with which designs are then looked for."""

    size: float
    value: float
    goals: Goals
    depth: float


def _moduli(grid: DesignGrid) -> Remedy:
    """The change of all moduli that is nearest to none."""
    goals = grid.goals

    def tried(k: int, m: int) -> Iterator[Change]:
        own = goals.skins[k]
        strains = [loaded(goals, k, m, float(depth))["strain"] / goals.largest_strain for depth in grid.depths[k]]
        for d in np.argsort(np.abs(np.log(strains)), kind="stable").tolist():
            factor = float(strains[d]) * (1 + 1e-9)
            stiff = own.skin.with_(materials=[replace(x, young=factor * x.young) for x in own.skin.materials])
            skins = tuple(SkinChoice(c.name, stiff) if i == k else c for i, c in enumerate(goals.skins))
            yield Change(abs(np.log(factor)), factor, replace(goals, skins=skins), float(grid.depths[k, d]))

    return _least(grid, "young", tried)


def _depths(grid: DesignGrid) -> Remedy:
    """The depth outside the room that is nearest to it."""
    goals, (shallow, deep) = grid.goals, grid.goals.room.depth
    steps = np.geomspace(1.0, _FURTHER, _STEPS + 1)[1:]
    outside = sorted([*zip(steps, shallow / steps), *zip(steps, deep * steps)], key=lambda one: one[0])

    def tried(k: int, m: int) -> Iterator[Change]:
        deepest = DEEPEST * goals.skins[k].skin.thickness
        for far, depth in outside:
            if depth <= deepest and _bears(grid, goals, k, m, float(depth)):
                yield Change(float(far), float(depth), goals, float(depth))

    return _least(grid, "depth", tried)


def _least(grid: DesignGrid, what: Literal["young", "depth"], tried: Callable[[int, int], Iterator[Change]]) -> Remedy:
    """The least change that lets a design meet the goals, of those `tried` of a skin and kind, the least first."""
    best, least = Remedy(what, np.nan), np.inf
    for k, m in np.ndindex(grid.excess.shape[:2]):
        for change in islice(tried(k, m), _most_tried(grid.goals)):
            if change.size >= least:
                break
            row = _meeting(grid, change.goals, k, m, change.depth, grid.goals.layouts)
            if row is not None:
                best, least = Remedy(what, change.value, row), change.size
                break
    return best


def _most_tried(goals: Goals) -> int:
    return 1 if goals.on_area else _TRIED


def _counts(grid: DesignGrid) -> Remedy:
    """The fewest sensors beyond those allowed, up to twice as many."""
    goals, most = grid.goals, int(grid.counts[-1])
    best = Remedy("count", np.nan)
    more: tuple[Arrangement, ...]
    if goals.on_area:
        sides = goals.extent.tolist()
        patterns = [name for name in goals.room.layouts if name != "free"]
        more = layouts(patterns, (most + 1, 2 * most), sides[0] / sides[1])
    else:
        room = goals.room.longest_row / goals.room.least_pitch
        last = min(2 * most, int(min(room, 2 * most) + 1e-9) + 1)
        more = tuple(Arrangement("row", (n,)) for n in range(most + 1, last + 1))
    if not more:
        return best
    wider = replace(goals, room=replace(goals.room, count=(goals.room.count[0], 10 * most)))
    excess = np.where(np.isfinite(grid.excess), grid.excess, np.inf).min(axis=(3, 4))
    for k, m in np.ndindex(excess.shape[:2]):
        bear = [d for d in range(excess.shape[2]) if _bears(grid, goals, k, m, float(grid.depths[k, d]))]
        likeliest = np.array(bear, dtype=int)[np.argsort(excess[k, m, bear], kind="stable")]
        for d in likeliest[: _most_tried(goals)].tolist():
            row = _meeting(grid, wider, k, m, float(grid.depths[k, d]), more)
            if row is not None and not row.count >= best.value:
                best = Remedy("count", row.count, row)
    return best


def _bears(grid: DesignGrid, goals: Goals, k: int, m: int, depth: float) -> bool:
    found = loaded(goals, k, m, depth)
    return all(found[c.name] <= c.wanted for c in grid.criteria if c.name in _LOADED)


def _meeting(grid: DesignGrid, goals: Goals, k: int, m: int, depth: float, tried: Sequence[Arrangement]) -> Row | None:
    """The design of fewest sensors at a depth that meets all criteria of the grid, if any."""
    if not _bears(grid, goals, k, m, depth):
        return None
    values = studied(goals, k, m, depth, grid.pitches, tried, min(goals.counted, _TOUCHES))
    ratios = [values[c.name] / c.wanted for c in grid.criteria if c.name not in _LOADED]
    excess = np.where(fits(goals, m, grid.pitches, tried), np.nan_to_num(np.max(ratios, axis=0), nan=np.inf), np.inf)
    for n, layout in enumerate(tried):
        s = int(np.argmin(excess[:, n]))
        if excess[s, n] <= 1:
            return Row(k, m, layout, depth, float(grid.pitches[s]))
    return None
