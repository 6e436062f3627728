"""Equal rows over kind, depth, pitch and count, on all cores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import partial
from threading import Event

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._frozen import Result
from ..._tasks import Executor, run_tasks
from ...array import SensorArray
from ...errors import GeometryError
from ...finger import Finger
from ...skin import Skin
from ...transducer import Transducer
from ..touches import Touches
from ._table import AMBIGUITY, GRID, MARGIN, PLACEMENT_MEASURES, checked_counts, checked_margin
from .row import SAMPLES, equal_row, study_row

__all__ = ["PlacementStudy", "placement_study"]


@dataclass(frozen=True, eq=False)
class PlacementStudy(Result):
    """What `placement_study` found: arrays of shape (k, d, s, c) over kind, depth, pitch and count.

    Attributes
    ----------
    skin : Skin
    transducers : tuple of k Transducers
    depth : ndarray, shape (d,)
        [m].
    pitch : ndarray, shape (d, s)
        At each depth [m].
    count : ndarray of int, shape (c,)
    touches : Touches
    noise : ndarray, shape (k,)
        Noise of a reading of each kind [its unit].
    width : float
        Width of a sensor [m].
    values : dict of str to ndarray, shape (k, d, s, c)
        One of each `PLACEMENT_MEASURES`, described at `study_row`. Also by index, `study["ambiguous"]`.
    """

    skin: Skin
    transducers: tuple[Transducer, ...]
    depth: FloatArray
    pitch: FloatArray
    count: npt.NDArray[np.int_]
    touches: Touches
    noise: FloatArray
    width: float
    values: dict[str, FloatArray]

    def __getitem__(self, measure: str) -> FloatArray:
        _check.choice("measure", measure, self.values, 'study["position_worst"]')
        return self.values[measure]

    def finger(self, index: tuple[int, int, int, int]) -> Finger:
        """The finger at an `index` of the arrays: kind, depth, pitch, count."""
        k, d, s, c = index
        y = equal_row(int(self.count[c]), float(self.pitch[d, s]), self.touches)
        kind, noise = self.transducers[k], float(self.noise[k])
        return Finger(self.skin, SensorArray(y, float(self.depth[d]), kind, noise=noise, width=self.width))


def placement_study(
    skin: Skin,
    transducers: Sequence[Transducer] | Transducer,
    depths: npt.ArrayLike,
    pitches: npt.ArrayLike,
    counts: npt.ArrayLike,
    touches: Touches,
    *,
    noise: npt.ArrayLike,
    width: float = 0.0,
    rng: np.random.Generator | int = 0,
    samples: int = SAMPLES,
    grid: tuple[int, int] = GRID,
    margin: float = MARGIN,
    ambiguity: float = AMBIGUITY,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[], object] | None = None,
) -> PlacementStudy:
    """Every kind of sensor at every depth, pitch and count. The numbers do not depend on who works them out.

    Parameters
    ----------
    skin : Skin
        Any.
    transducers : Transducer, or sequence of k of them
        Kinds of sensor.
    depths : array_like, shape (d,)
        Depths of the sensors [m].
    pitches : array_like, shape (s,) or (d, s)
        Distances of neighbours [m]: the same at all depths, or a list for each.
    counts : array_like, shape (c,)
        Numbers of sensors.
    touches : Touches
        What is to be located.
    noise : array_like, shape () or (k,)
        Standard deviation of a reading of each kind [its unit].
    width, rng, samples, grid, margin, ambiguity
        As in `study_row`.
    workers : int, optional
        Threads; as many as there are cores if left out.
    executor : executor, optional
        Works out the rows, one a kind and depth, instead of threads: anything with `submit` (docs/scale.md).
    progress : callable, optional
        Called after each design, from any thread; with an executor for all designs of a row when it is finished. What
        it raises ends the study.

    Raises
    ------
    InvalidValueError, GeometryError, NotLinearError
        As by `study_row`; lists that do not match.
    WorkersError
        The executor has lost its workers.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> depths = np.array([1e-3, 2e-3])
    >>> found = ss.design.placement_study(
    ...     skin, ss.NormalStrain(), depths, np.multiply.outer(depths, [0.5, 0.75, 2.0]), [4, 6],
    ...     ss.design.Touches(force=40.0), noise=5e-5, samples=1000,
    ... )
    >>> found["ambiguous"].shape, bool((found["ambiguous"][..., 2, :] > 0.05).all())
    ((1, 2, 3, 2), True)
    """
    _check.function("progress", progress)
    single = isinstance(transducers, Transducer)
    kinds = (transducers,) if single else _check.several("transducers", transducers, Transducer, "[NormalStrain()]")
    depth = np.atleast_1d(_check.real("depths", depths, unit="m", above=0.0))
    steps = np.atleast_1d(_check.real("pitches", pitches, unit="m", above=0.0))
    shapes = (steps.shape[-1:], (depth.size, steps.shape[-1]))
    if not kinds or not depth.size or not steps.size or depth.ndim != 1 or steps.shape not in shapes:
        raise GeometryError(
            f"{len(kinds)} kinds, depths of shape {depth.shape}, pitches of shape {steps.shape}",
            "kinds, a list of depths, and pitches of shape (s,) or (depths, s) are needed",
            "depths=[2e-3], pitches=[1e-3, 2e-3]",
        )
    sigma = _check.real("noise", noise, above=0.0)
    if sigma.shape not in ((), (1,), (len(kinds),)):
        raise GeometryError(f"noise of shape {sigma.shape}", f"one, or one of each of {len(kinds)} kinds", "noise=1e-4")
    sigma = _check.read_only(np.broadcast_to(sigma, (len(kinds),)).copy())
    steps = _check.read_only(np.broadcast_to(steps, (depth.size, steps.shape[-1])).copy())
    touched = _check.random(rng)
    checked_margin(margin)
    width = _check.scalar("width", width, unit="m", at_least=0.0)
    numbers = checked_counts(counts, touches)
    numbers.flags.writeable = False
    threads = None if workers is None else int(_check.scalar("workers", workers, at_least=1))
    stop = Event()

    def passed() -> None:
        if stop.is_set():
            raise _StoppedError
        if progress is not None:
            progress()

    rows: dict[int, dict[str, FloatArray]] = {}

    def row_passed(_: int, row: dict[str, FloatArray]) -> None:
        if executor is not None and progress is not None:
            for _ in range(np.count_nonzero(~np.isnan(row["ambiguous"]))):  # those with room
                progress()

    cells = list(np.ndindex(len(kinds), depth.size))
    tasks = [
        partial(
            study_row, skin, kinds[k], float(depth[d]), steps[d], numbers, touches,
            noise=float(sigma[k]), width=width, rng=deepcopy(touched), samples=samples, grid=grid, margin=margin,
            ambiguity=ambiguity, progress=passed if executor is None else None,
        )
        for k, d in cells
    ]  # fmt: skip
    run_tasks(tasks, rows.__setitem__, executor=executor, workers=threads, passed=row_passed, stopping=stop.set)
    shape = (len(kinds), *steps.shape, numbers.size)
    found = [rows[i] for i in range(len(cells))]
    values = {name: _check.read_only(np.stack([r[name] for r in found]).reshape(shape)) for name in PLACEMENT_MEASURES}
    return PlacementStudy(skin, kinds, depth, steps, numbers, touches, sigma, float(width), values)


class _StoppedError(Exception):
    """Another thread has failed."""
