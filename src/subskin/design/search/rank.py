"""From the grid to the fingers to build: refined, looked at, ranked; where none will do, which change would let one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import islice
from threading import Event
from typing import Annotated, Literal, NamedTuple

import numpy as np

from ..._check import FloatArray
from ..._declared import Fix, checked
from ..._tasks import threads
from ...errors import ConvergenceError
from ..placement import Arrangement, layouts
from .choices import SkinChoice
from .goals import Goals, Row
from .grid import DEEPEST, DesignGrid, fits, loaded, studied
from .look import Check, DesignedFinger, explained, finished, freed_from, looked_at

__all__ = ["DesignStudy", "Remedy", "rank_fingers", "remedies"]


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


@dataclass(frozen=True, eq=False)
class DesignStudy:
    """What `rank_fingers` found.

    Attributes
    ----------
    grid : DesignGrid
        All designs that were tried.
    fingers : tuple of DesignedFinger
        Ranked: those that meet the goals first, the fewest sensors first among them; then by how far they fall short.
    looked : dict of (int, int, int) to tuple of Check
        Every design that was looked at closely, by the indices of its skin, kind and count.
    remedies : tuple of Remedy
        Where no design of the grid will do: which single change would let one.
    """

    grid: DesignGrid
    fingers: tuple[DesignedFinger, ...]
    looked: dict[tuple[int, int, int], tuple[Check, ...]]
    remedies: tuple[Remedy, ...] = ()

    @property
    def goals(self) -> Goals:
        """What was wanted."""
        return self.grid.goals


@checked
def rank_fingers(
    grid: Annotated[DesignGrid, Fix("design.search_grid(goals)")],
    *,
    workers: int | None = None,
    progress: Callable[[], object] | None = None,
) -> DesignStudy:
    """Refine the best designs of the grid, look at each closely, and rank them.

    For each skin and kind the fewest sensors that meet the goals are found by halving the counts; one more and one less
    are looked at too. One depth and pitch, the best, stands for each count.

    Parameters
    ----------
    grid : DesignGrid
        From `search_grid`.
    workers : int, optional
        How many skins and kinds at a time; as many as there are cores if left out. The result does not depend on it.
    progress : callable, optional
        Called after each skin and kind.

    Raises
    ------
    ConvergenceError
        No design of the grid has room, or notices the touches.

    Examples
    --------
    >>> import subskin as ss
    >>> from subskin.design.search import Accuracy, Effort, Room, SensorKind, SkinChoice
    >>> goals = ss.design.Goals(
    ...     ss.design.Touches(force=20.0, friction=0.0, span=(-1e-3, 1e-3)), strongest=100.0,
    ...     accuracy=Accuracy(position=0.1e-3), sensors=(SensorKind("gauge", ss.NormalStrain(), noise=2e-4),),
    ...     skins=(SkinChoice("silicone", ss.HalfPlane(ss.Material(young=0.4e6))),),
    ...     room=Room(count=(3, 4), depth=(2e-3, 2e-3), least_pitch=1e-3), effort=Effort(1, 3, touches=200),
    ... )
    >>> study = ss.design.rank_fingers(ss.design.search_grid(goals))
    >>> [(f.row.count, f.meets) for f in study.fingers]  # three see too little of touches outside the model
    [(4, True), (3, False)]
    """
    pairs = [(int(k), int(m)) for k, m in np.argwhere(np.isfinite(grid.excess).any(axis=(2, 3, 4)))]
    if not pairs:
        if np.isnan(grid.excess).all():
            rule = "sensors overlap, go round the finger, or take more than the longest row at every pitch tried"
            raise ConvergenceError("no row has room", rule, "narrower sensors, fewer of them, or a longer row")
        rule = "at the weakest force noise hides them"
        raise ConvergenceError("no row notices the touches", rule, "less noise or a larger force")
    stopped = Event()
    found: list[DesignedFinger] = []
    pool = ThreadPoolExecutor(threads(workers))
    try:
        look = _fewest_on_area if grid.goals.on_area else _fewest
        for fingers in pool.map(lambda pair: look(grid, pair[0], pair[1], stopped), pairs):
            found += fingers
            if progress is not None:
                progress()
        kept = sorted(found, key=_rank)[: grid.goals.effort.keep]
        best = sorted(pool.map(lambda f: finished(grid, f), kept), key=_rank)
    finally:
        stopped.set()
        pool.shutdown(wait=True, cancel_futures=True)
    best[0] = explained(grid, best[0])
    looked = {f.row.which(grid.goals): f.checks for f in (*found, *best) if not f.row.free}
    would = () if (grid.excess <= 1).any() else remedies(grid)
    return DesignStudy(grid, tuple(best), looked, would)


_LOOKS = 3
"""Arrangements of one skin and kind on an area that are looked at closely at most."""


def _rank(finger: DesignedFinger) -> tuple[bool, int, float]:
    return not finger.meets, finger.row.count if finger.meets else 0, finger.excess


def _fewest(grid: DesignGrid, k: int, m: int, stopped: Event) -> list[DesignedFinger]:
    """Close looks at rows of one skin and kind: the fewest sensors that meet the goals, and their neighbours."""
    excess = np.where(np.isfinite(grid.excess[k, m]), grid.excess[k, m], np.inf).min(axis=(0, 1))
    looked: dict[int, DesignedFinger] = {}

    def meets(n: int) -> bool:
        if n not in looked and not stopped.is_set():
            looked[n] = looked_at(grid, (k, m, n))
        return n in looked and looked[n].meets

    would = np.flatnonzero(excess <= 1)
    if would.size:
        low, high = int(would[0]), int(would[-1]) + 1
        while low < high:
            middle = (low + high) // 2
            low, high = (low, middle) if excess[middle] <= 1 and meets(middle) else (middle + 1, high)
    else:
        low = int(np.argmin(excess))
    for n in (low - 1, low, low + 1):
        if 0 <= n < excess.size and np.isfinite(excess[n]):
            meets(n)
    return _and_free(grid, [looked[n] for n in sorted(looked)], stopped)


def _fewest_on_area(grid: DesignGrid, k: int, m: int, stopped: Event) -> list[DesignedFinger]:
    """Close looks at arrays of one skin and kind: those of fewest sensors first, until one more after one that meets.

    Of layouts that meet no goals on the grid the nearest are looked at.
    """
    excess = np.where(np.isfinite(grid.excess[k, m]), grid.excess[k, m], np.inf).min(axis=(0, 1))
    order = sorted(np.flatnonzero(np.isfinite(excess)).tolist(), key=lambda n: (excess[n] > 1, _few(grid, excess, n)))
    found: list[DesignedFinger] = []
    for n in order[:_LOOKS]:
        if stopped.is_set() or (found and found[-1].meets and len(found) > 1):
            break
        found.append(looked_at(grid, (k, m, n)))
    return _and_free(grid, found, stopped)


def _and_free(grid: DesignGrid, found: list[DesignedFinger], stopped: Event) -> list[DesignedFinger]:
    """With the best of them at free positions, where these are asked for and better."""
    if "free" not in grid.goals.room.layouts or not found or stopped.is_set():
        return found
    best = min(found, key=_rank)
    moved = freed_from(grid, best)
    return found if moved is None or not moved.excess < best.excess else [*found, moved]


def _few(grid: DesignGrid, excess: FloatArray, n: int) -> tuple[float, float]:
    """Sensors and excess of a layout, whichever comes first: of those that would do the sensors."""
    own = float(grid.counts[n]), float(excess[n])
    return own if excess[n] <= 1 else own[::-1]


_LOADED = ("strain", "range")
_TRIED = 3
"""Depths at which each kind in each skin is tried, the likeliest first; on an area that alone."""
_FURTHER, _STEPS = 3.0, 6
"""Depths outside the room go to so many times its ends, in so many steps."""
_TOUCHES = 2000


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
