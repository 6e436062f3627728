"""From the grid to the fingers to build: refined, looked at closely, ranked."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Event
from typing import Annotated

import numpy as np

from ..._check import FloatArray
from ..._declared import Fix, checked
from ..._tasks import threads
from ...errors import ConvergenceError
from .grid import DesignGrid
from .look import DesignedFinger, DesignStudy, explained, finished, freed_from, looked_at
from .remedy import remedies

__all__ = ["rank_fingers"]


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
    return [looked[n] for n in sorted(looked)]


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
    if "free" in grid.goals.room.layouts and found and not stopped.is_set():
        best = min(found, key=_rank)
        moved = freed_from(grid, best)
        found += [] if moved is None or not moved.excess < best.excess else [moved]
    return found


def _few(grid: DesignGrid, excess: FloatArray, n: int) -> tuple[float, float]:
    """Sensors and excess of a layout, whichever comes first: of those that would do the sensors."""
    own = float(grid.counts[n]), float(excess[n])
    return own if excess[n] <= 1 else own[::-1]
