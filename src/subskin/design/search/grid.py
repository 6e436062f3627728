"""Every design that the goals allow, judged: a grid over skins, kinds of sensor, depths, pitches and counts."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, Protocol

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Fix, checked
from ..._frozen import Frozen
from ..._tasks import Executor, run_tasks
from ...contact import Contact, LineLoad, LocalContact
from ...errors import GeometryError, InvalidValueError
from ...transducer import MaxCompressiveStrain
from ..placement import Arrangement, study_at_depth
from .goals import WIDEST, Goals, Row

__all__ = ["DEEPEST", "Criterion", "DesignGrid", "Store", "fits", "loaded", "search_grid", "studied"]

DEEPEST = 0.98
"""A sensor lies no deeper than this share of the skin: at a rigid base little is to be felt."""
_LOOKED_AT = np.linspace(-4.0, 4.0, 161)
"""Positions at which the largest strain and reading are looked for, in depths."""


class Store(Protocol):
    """Where finished rows of the grid are kept, so that a search that was stopped can go on.

    Examples
    --------
    >>> class Memory(dict):
    ...     put = dict.__setitem__
    >>> store: Store = Memory()
    """

    def get(self, key: str) -> Mapping[str, FloatArray] | None:
        """What was put under `key`, if anything."""

    def put(self, key: str, row: Mapping[str, FloatArray]) -> None:
        """Keep `row` under `key`."""


@dataclass(frozen=True)
class Criterion:
    """One thing that is wanted of a finger.

    Attributes
    ----------
    name : str
        Key of the grid's values.
    label, unit : str
        What it is called, and the SI unit.
    wanted : float
        Largest value that will do [`unit`].
    """

    name: str
    label: str
    unit: str
    wanted: float


@dataclass(frozen=True, eq=False)
class DesignGrid(Frozen):
    """What every design of the grid can do. Arrays of shape (skins, kinds, depths, pitches, counts).

    The kinds are `Goals.choices`, mixes among them; the counts are those of `Goals.layouts`, on an area several of one.

    Attributes
    ----------
    goals : Goals
    depths : ndarray, shape (skins, depths)
        [m]
    pitches : ndarray, shape (pitches,)
        [m]
    counts : ndarray of int, shape (counts,)
    values : dict of ndarray
        The measures of `study_at_depth`; "unsure": the share of touches that are ambiguous or not noticed; "strain":
        compressive strain at the sensors under the strongest force; "range": largest reading over the largest that can
        be read [m, rad, -]. NaN where a row has no room.
    criteria : tuple of Criterion
        What is wanted, of these values.
    """

    goals: Goals
    depths: FloatArray
    pitches: FloatArray
    counts: np.ndarray[Any, np.dtype[np.intp]]
    values: dict[str, FloatArray]
    criteria: tuple[Criterion, ...]

    @property
    def excess(self) -> FloatArray:
        """Largest ratio of a value to what is wanted; at most 1 where a design meets the goals, NaN without room."""
        ratios = [self.values[c.name] / c.wanted for c in self.criteria]
        return np.asarray(np.max(ratios, axis=0))

    def columns(self) -> dict[str, Any]:
        """Every design as a line of a table: names, lengths [m], and `values`; those without room are left out."""
        k, m, d, s, n = np.nonzero(~np.isnan(self.excess))
        skins, kinds = self.goals.skins, self.goals.choices
        layouts = {"layout": [self.goals.layouts[i].text for i in n]} if self.goals.on_area else {}
        digits = np.vectorize(lambda value: float(f"{value:.6g}"), otypes=[float])
        chosen = {name: digits(value[k, m, d, s, n]) for name, value in self.values.items()}
        return {
            "skin": [skins[i].name for i in k],
            "sensor": [kinds[i].name for i in m],
            **layouts,
            "count": self.counts[n],
            "depth": digits(self.depths[k, d]),
            "pitch": digits(self.pitches[s]),
            **chosen,
            "excess": digits(self.excess[k, m, d, s, n]),
        }

    def row(self, k: int, m: int, d: int, s: int, n: int) -> Row:
        """The design of some indices.

        Parameters
        ----------
        k, m, d, s, n : int
            Which skin, kind, depth, pitch and count.
        """
        return Row(k, m, self.goals.layouts[n], float(self.depths[k, d]), float(self.pitches[s]))


def criteria_of(goals: Goals) -> tuple[Criterion, ...]:
    """What the goals ask of every design of the grid."""
    accuracy = goals.accuracy
    asked = [
        Criterion("position_95", "error of the position", "m", accuracy.position or np.inf),
        Criterion("angle_95", "error of the angle", "rad", accuracy.angle or np.inf),
        Criterion("force_95", "error of the force", "", accuracy.force or np.inf),
        Criterion("radius_95", "error of the radius", "m", accuracy.radius or np.inf),
        Criterion("unsure", "touches ambiguous, not noticed or lost", "", accuracy.unsure),
        Criterion("strain", "strain at the sensors, strongest force", "", goals.largest_strain),
    ]
    if any(np.isfinite(kind.largest) for choice in goals.choices for kind in choice.kinds):
        asked.append(Criterion("range", "largest reading over the range", "", 1.0))
    return tuple(c for c in asked if np.isfinite(c.wanted))


@checked
def search_grid(
    goals: Annotated[Goals, Fix('io.load_goals("goals.toml").goals')],
    *,
    store: Store | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[], object] | None = None,
) -> DesignGrid:
    """Judge every design of the grid, on all cores; `rank_fingers` has an example.

    Parameters
    ----------
    goals : Goals
        What is wanted, and what there is to choose from.
    store : Store, optional
        Rows found there are not worked out again, and finished ones are put there.
    workers : int, optional
        How many rows at a time; as many as there are cores if left out. The result does not depend on it.
    executor : executor, optional
        Works out the rows instead of threads of this process: anything with `submit` (docs/scale.md). `store` is
        asked and filled in this process. The result does not depend on it.
    progress : callable, optional
        Called after each of the skins x kinds x depths rows.

    Raises
    ------
    InvalidValueError
        No goals; a store without get and put.
    GeometryError
        No depth lies within a skin.
    WorkersError
        The executor has lost its workers; finished rows are in the store.
    """
    if store is not None and not all(callable(getattr(store, name, None)) for name in ("get", "put")):
        seen, rule = f"store = {_check.shown(store)}", "something with get and put is needed"
        raise InvalidValueError(seen, rule, 'store=io.FolderStore("rows")')
    depths = np.stack([_depths(goals, k) for k in range(len(goals.skins))])
    pitches = _pitches(goals)
    counts = np.array([layout.count for layout in goals.layouts])
    shape = (len(goals.skins), len(goals.choices), depths.shape[1], pitches.size, counts.size)
    tasks = list(np.ndindex(shape[:3]))
    rows: dict[tuple[int, ...], Mapping[str, FloatArray]] = {}
    asked: list[tuple[tuple[int, ...], str, Callable[[], Mapping[str, FloatArray]]]] = []

    def passed(*_: object) -> None:
        if progress is not None:
            progress()

    def keep(number: int, row: Mapping[str, FloatArray]) -> None:
        task, key, _ = asked[number]
        rows[task] = row
        if store is not None:
            store.put(key, row)

    for task in tasks:
        k, m, d = task
        depth = float(depths[k, d])
        question = question_of(goals, k, m, depth, pitches)
        key = hashlib.sha256(repr(question).encode()).hexdigest()[:24]
        row = None if store is None else store.get(key)
        if row is not None:
            rows[task] = row
            passed()
            continue
        asked.append((task, key, partial(studied, goals, k, m, depth, pitches, goals.layouts)))
    run_tasks([work for *_, work in asked], keep, executor=executor, workers=workers, passed=passed)
    values = {name: np.stack([rows[task][name] for task in tasks]).reshape(shape) for name in rows[tasks[0]]}
    values |= {name: np.zeros(shape) for name in ("strain", "range")}
    for k, m, d in tasks:
        for name, value in loaded(goals, k, m, float(depths[k, d])).items():
            values[name][k, m, d] = value
    room = np.stack([fits(goals, m, pitches, goals.layouts) for m in range(shape[1])])[:, None]
    values = {name: np.where(room, value, np.nan) for name, value in values.items()}
    return DesignGrid(goals, depths, pitches, counts, values, criteria_of(goals))


_VERSION = 4
"""Of what is kept in a store: to be raised where `study_at_depth` comes to give other numbers."""


def question_of(goals: Goals, k: int, m: int, depth: float, pitches: FloatArray) -> tuple[object, ...]:
    """All that the numbers of a row of designs depend on."""
    where = depth, pitches.tolist(), [(layout.pattern, layout.rows) for layout in goals.layouts]
    channels, together = goals.channels(m), goals.choices[m].together
    return (
        _VERSION, goals.skins[k].skin, channels, together, *where, goals.touches, goals.counted, goals.effort.seed
    )  # fmt: skip


def studied(
    goals: Goals,
    k: int,
    m: int,
    depth: float,
    pitches: FloatArray,
    layouts: Sequence[Arrangement],
    samples: int | None = None,
) -> dict[str, FloatArray]:
    """`study_at_depth` of a skin and kind, arrays of shape (pitches, layouts), and the share of touches `unsure`."""
    found = study_at_depth(
        goals.skins[k].skin, goals.channels(m), depth, pitches, layouts, goals.touches,
        together=goals.choices[m].together, rng=goals.effort.seed, samples=samples or goals.counted,
    )  # fmt: skip
    # where the readings do not tell a touch at all it is ambiguous, and nothing else
    unnoticed = np.where(found["ambiguous"] < 1, found["unfelt"], 0.0)
    return found | {"unsure": found["ambiguous"] + unnoticed}


def fits(goals: Goals, m: int, pitches: FloatArray, layouts: Sequence[Arrangement]) -> npt.NDArray[np.bool_]:
    """Which pitches and layouts the room allows, shape (pitches, layouts); on an area by the number of readings too."""
    sizes = np.array([layout.size for layout in layouts])
    inside = (pitches[:, None, None] * sizes <= goals.extent * (1 + 1e-9)).all(axis=-1)
    if not goals.on_area:
        return np.asarray(inside)
    readings, (fewest, most) = np.array([goals.readings(m, layout.count) for layout in layouts]), goals.room.count
    return np.asarray(inside & (readings >= fewest) & (readings <= most))


def _depths(goals: Goals, k: int) -> FloatArray:
    shallow, deep = goals.room.depth
    choice = goals.skins[k]
    deepest = min(deep, DEEPEST * choice.skin.thickness)
    if deepest < shallow:
        seen = f'skin "{choice.name}" is {choice.skin.thickness:.6g} m thick'
        rule = f"the shallowest sensors are to lie {shallow:.6g} m deep"
        raise GeometryError(seen, rule, "a thicker skin or shallower sensors")
    return np.geomspace(shallow, deepest, goals.effort.depths)


def _pitches(goals: Goals) -> FloatArray:
    room = goals.room
    longest = max(float((goals.extent / np.maximum(layout.size, 1e-9)).min()) for layout in goals.layouts)
    widest = min(longest, WIDEST * room.depth[1])
    return np.geomspace(room.least_pitch, max(widest, room.least_pitch), goals.effort.pitches)


def loaded(goals: Goals, k: int, m: int, depth: float) -> dict[str, float]:
    """Largest strain at `depth` in the k-th skin under the strongest force; largest reading over the range."""
    angles, at = goals.touches.cone * np.linspace(-1.0, 1.0, 9)[:, None], _LOOKED_AT * depth
    if goals.on_area:
        normal, side = np.broadcast_arrays(np.cos(angles), np.sin(angles))
        where = np.stack([at, np.zeros(at.size)], axis=-1)
        for_all = goals.strongest * np.stack([normal, side, np.zeros(angles.shape)], axis=-1)
        load: Contact | LocalContact = goals.touches.contact(for_all, where)
    else:
        load = LineLoad(goals.strongest, angles, at)
    state = goals.skins[k].skin.state(load, depth, 0.0)
    readings = [
        float(np.abs(kind.transducer.linear_part.measure(state)).max()) / kind.largest
        for kind in goals.choices[m].kinds
    ]
    return {"strain": float(MaxCompressiveStrain().measure(state).max()), "range": max(readings)}
