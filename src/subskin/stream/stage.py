"""A stage, one thing that is done to a stream, which goes on where it was left; and stages one after the other."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._cold import at_once
from .._frozen import Frozen
from ..errors import GeometryError, InvalidValueError

__all__ = ["CHUNK", "Arrays", "Pipeline", "Stage", "behind", "both_of", "check_state", "in_order", "join", "since"]

State = TypeVar("State")
Out = TypeVar("Out")
_Part = TypeVar("_Part")

CHUNK = 100_000
"""Frames of a whole recording that are handled at once: memory stays small, and progress shows."""


class Stage(Frozen, ABC, Generic[State, Out]):
    """One thing that is done to a stream of frames, in the order of time.

    A stage itself never changes. What it remembers of a stream is a state: a value that goes in and comes out, and that
    pickles. However a stream is cut into batches, all that comes out is the same to the last bit.

    Examples
    --------
    >>> class Peak(Stage[FloatArray, FloatArray]):
    ...     '''The largest reading of each sensor so far.'''
    ...     def step(self, state, readings, time):
    ...         frames = np.atleast_2d(readings)
    ...         peak = np.maximum.accumulate(frames if state is None else np.vstack([state, frames]))[-len(frames) :]
    ...         return peak[-1], peak.reshape(np.shape(readings))
    >>> Peak()([[1.0], [3.0], [2.0]], time=[0.0, 0.1, 0.2])[:, 0].tolist()
    [1.0, 3.0, 3.0]
    """

    takes_doubt = False
    """Whether `step` takes, as `doubt`, how far each reading is in doubt where a stage before says it; as `Undone`."""

    @abstractmethod
    def step(self, state: State | None, readings: npt.ArrayLike, time: npt.ArrayLike | None) -> tuple[State, Out]:
        """Take the next frames of a stream.

        Parameters
        ----------
        state : State or None
            What the frames before left; None where the stream begins.
        readings : array_like, shape (m, n) or (n,)
            The next frames, any number of them, or one frame; NaN is a missing reading.
        time : array_like, shape (m,) or (), or None
            Time of each frame [s], not decreasing; steps may differ. None where no stage asks for it.

        Returns
        -------
        state : State
            What the next frames need; the state that was given is left as it was.
        out : Out
            What the stage makes of these frames. Where it has `readings`, the next stage takes these.

        Raises
        ------
        GeometryError, InvalidValueError
            Shapes that do not match, times that are not finite or go back.
        """

    def prepare(self) -> None:
        """Make now what the first frames of a stream, or a rare one, would wait for; it changes no answer."""
        return

    def resumed(self, state: State | None) -> State | None:
        """The state for a stream that begins anew on the same sensors, its times too: what was learnt is kept.

        Parameters
        ----------
        state : State or None
            What was left of the stream before.

        Returns
        -------
        State or None
            None, unless the stage has learnt something that outlives a break.
        """
        return None

    def __call__(
        self,
        readings: npt.ArrayLike,
        time: npt.ArrayLike | None = None,
        *,
        progress: Callable[[int], object] | None = None,
    ) -> Out:
        """What the stage makes of a whole recording, from its beginning.

        Parameters
        ----------
        readings, time : array_like
            As in `step`.
        progress : callable, optional
            Called with the number of frames after each part of a long recording.

        Returns
        -------
        Out
            As in `step`, whose errors it raises.
        """
        frames, clock = _check.readings(readings), None if time is None else _check.real("time", time, unit="s")
        if frames.ndim < 2:
            only: Out = both_of(self, self.step(None, frames, clock))[1]
            return only
        if clock is not None and clock.shape != frames.shape[:1]:
            rule = f"one for each frame, {frames.shape[:1]}, is needed"
            raise GeometryError(f"time of shape {clock.shape}", rule, "a time for each frame")
        state, parts = None, []
        for first in range(0, max(len(frames), 1), CHUNK):
            part = slice(first, first + CHUNK)
            state, out = both_of(self, self.step(state, frames[part], None if clock is None else clock[part]))
            parts.append(out)
            if progress is not None:
                progress(len(frames[part]))
        joined: Out = join(parts) if len(parts) > 1 else parts[0]
        return joined


def join(parts: Sequence[Any]) -> Any:
    """What came out of successive steps as if it were of one: arrays, what has a `join` of its own, and dicts of these.

    The dicts are used up: what has been joined is let go, so that memory does not hold all of it twice.

    Examples
    --------
    >>> join([{"a": np.zeros(2)}, {"a": np.ones(1)}])["a"].tolist()
    [0.0, 0.0, 1.0]
    """
    first = parts[0]
    if isinstance(first, np.ndarray):
        joined = np.concatenate(parts)
        joined.flags.writeable = False
        return joined
    if isinstance(first, dict):
        return {name: join([part.pop(name) for part in parts]) for name in list(first)}
    return type(first).join(parts)


def some_of(parts: object, kind: type[_Part]) -> tuple[_Part, ...]:
    """Parts of a stream of that kind, at least one."""
    each = _check.several("parts", parts, kind, "the parts that steps gave, in their order")
    if not each:
        raise InvalidValueError("no parts", f"at least one {kind.__name__} is needed to be joined", "parts=[part]")
    return each


def check_state(state: object, kind: type) -> None:
    """Refuse what is no state of that kind, nor None, with which a stream begins."""
    if state is not None and not isinstance(state, kind):
        rule = f"a {kind.__name__} is needed, as the step before gave it, or None to start"
        raise InvalidValueError(f"state = {_check.shown(state)}", rule, "state=None")


def both_of(stage: object, stepped: Any) -> tuple[Any, Any]:
    """The state and what came out, as `step` of a stage has to give them."""
    if not isinstance(stepped, tuple) or len(stepped) != 2:
        seen = f"{type(stage).__name__}.step gave {_check.shown(stepped)}"
        raise InvalidValueError(seen, "a state and what comes out are needed", "return state, out")
    return stepped[0], stepped[1]


def in_order(
    readings: npt.ArrayLike, time: npt.ArrayLike | None, last: float = np.nan, sensors: int | None = None
) -> tuple[FloatArray, FloatArray]:
    """Readings (m, n) or (n,) and their times (m,), checked: none before `last`, as many `sensors` as are wanted."""
    if type(readings) is np.ndarray and type(time) is np.ndarray and _fine(readings, time, last, sensors):
        data, clock = readings.view(), time.view()
        data.flags.writeable = clock.flags.writeable = False
        return data, clock
    data = _check.readings(readings).view()
    data.flags.writeable = False
    if data.ndim not in (1, 2) or not data.shape[-1] or sensors not in (None, data.shape[-1]):
        rule = f"frames of {'some' if sensors is None else f'the {sensors}'} sensors, (m, n), are needed"
        raise GeometryError(f"readings of shape {data.shape}", rule, "readings[:, None] for a single sensor")
    if time is None:
        seen = "time is missing"
        raise InvalidValueError(seen, "a stream needs the time of each frame [s]", "time=np.arange(frames) / rate")
    clock = _check.real("time", time, unit="s")
    if clock.shape != data.shape[:-1]:
        seen = f"time of shape {clock.shape}"
        raise GeometryError(seen, f"one for each frame, {data.shape[:-1]}, is needed", "a time for each frame")
    clock = clock.reshape(-1)
    before = np.concatenate([[last], clock[:-1]])
    back = np.flatnonzero(clock < before)
    if back.size:
        k = int(back[0])
        rule = f"time must not go back (it was {before[k]:.6g} s)"
        raise InvalidValueError(f"time[{k}] = {clock[k]:.6g} s", rule, "sort the frames by time")
    return data, clock


def _fine(readings: npt.NDArray[Any], time: npt.NDArray[Any], last: float, sensors: int | None) -> bool:
    """Whether nothing is to be said of frames (m, n) and their times: seen at once, for each step of a live loop."""
    shape = readings.shape
    if len(shape) != 2 or time.shape != shape[:1] or not shape[0] or not shape[1] or sensors not in (None, shape[1]):
        return False
    if readings.dtype != np.float64 or time.dtype != np.float64:
        return False
    first, end = time.item(0), time.item(-1)
    rising = shape[0] == 1 or bool((time[1:] >= time[:-1]).all())  # not where one is NaN
    return rising and not first < last and -math.inf < first and end < math.inf


@dataclass(frozen=True, eq=False)
class Pipeline(Stage[dict[str, Any], dict[str, Any]]):
    """Stages, each of which takes what the one before it makes of the frames.

    The usual order is: readings in SI units, relaxation undone, drift taken off, and an answer (a `Locator`, say).
    `subskin.io.FingerFile.pipeline` makes one from a finger file. A pipeline is a stage itself: `step` goes on with a
    stream, a call takes a whole recording. Both give what came out of each stage, by its name.

    Where a stage gives each reading a doubt, as `Relaxation.undoing` does, what follows takes it as `doubt` if its
    `takes_doubt` says so, as of `Tare` and of a `Locator` of a row; other answers get the readings alone.

    Parameters
    ----------
    stages : mapping of str to Stage or callable
        The stages by their names, in their order. What is called with readings alone is a stage without a state.

    Raises
    ------
    InvalidValueError
        No stage, or something that is none.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=5, pitch=1.5e-3, depth=2e-3, noise=1e-4))
    >>> time = np.arange(0.0, 4.0, 0.01)
    >>> raw = finger.read(ss.LineLoad(40.0 * (time > 2.0), position=0.3e-3), np.random.default_rng(0)) + 0.07
    >>> pipeline = ss.Pipeline({"tare": ss.Tare(finger), "found": finger.locator()})
    >>> out = pipeline(raw, time)
    >>> out["tare"].free[[0, -1]].tolist(), f"{1e3 * np.median(out['found'].position[-100:]):.2f} mm"
    ([True, False], '0.30 mm')
    >>> state, first = pipeline.step(None, raw[:150], time[:150])  # the same, as the frames come
    >>> state, second = pipeline.step(state, raw[150], time[150])
    >>> bool(second["tare"].offset[0] == out["tare"].offset[150, 0])
    True
    """

    stages: Mapping[str, Stage[Any, Any] | Callable[[Any], Any]]

    def __post_init__(self) -> None:
        if not isinstance(self.stages, Mapping) or not self.stages:
            seen = f"stages = {_check.shown(self.stages)}"
            raise InvalidValueError(seen, "stages by their names are needed", 'Pipeline({"found": locator})')
        for name, stage in self.stages.items():
            if not callable(stage):
                seen = f'stage "{name}" = {_check.shown(stage)}'
                raise InvalidValueError(seen, "a Stage, or a call on readings, is needed", "finger.locator()")
        object.__setattr__(self, "stages", dict(self.stages))

    def step(
        self, state: dict[str, Any] | None, readings: npt.ArrayLike, time: npt.ArrayLike | None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Take the next frames of a stream through all stages; as `Stage.step`, by the names of the stages."""
        self._check(state)
        left: dict[str, Any] = {}
        out: dict[str, Any] = {}
        given: Any = readings
        doubt: Any = None
        with at_once():  # however a stream is cut, it gives the same bits
            for name, stage in self.stages.items():
                more = {"doubt": doubt} if doubt is not None and getattr(stage, "takes_doubt", False) else {}
                if isinstance(stage, Stage):
                    stepped = stage.step(None if state is None else state[name], given, time, **more)
                    left[name], out[name] = both_of(stage, stepped)
                else:
                    left[name], out[name] = None, stage(given, **more)
                made = given = out[name]
                left_over = getattr(made, "readings", None)
                if left_over is not None:
                    given, doubt = left_over, getattr(made, "doubt", doubt)
        return left, out

    def _check(self, state: dict[str, Any] | None) -> None:
        """Refuse what is no state of these stages."""
        check_state(state, dict)
        if state is not None and state.keys() != self.stages.keys():
            seen, rule = f"a state of {', '.join(map(str, state))}", f"this pipeline has {', '.join(self.stages)}"
            raise InvalidValueError(seen, rule, "a state of this pipeline, or None to start")

    def prepare(self) -> None:
        """Prepare each stage; as `Stage.prepare`."""
        with at_once():
            for stage in self.stages.values():
                if isinstance(stage, Stage):
                    stage.prepare()

    def resumed(self, state: dict[str, Any] | None) -> dict[str, Any] | None:
        """The state of each stage for a stream that begins anew; as `Stage.resumed`."""
        self._check(state)
        if state is None:
            return None
        left: dict[str, Any] = {}
        for name, stage in self.stages.items():
            left[name] = stage.resumed(state[name]) if isinstance(stage, Stage) else None
        return left


Arrays: TypeAlias = tuple[FloatArray, FloatArray]
"""Frames (m, n) and their times (m,)."""

_LEAST = 64
_WIDE = 8
"""Where the frames that are kept fill less than one part in so many of the arrays, they leave these."""


def behind(frames: FloatArray, time: FloatArray, room: list[Arrays], many: int) -> Arrays:
    """Arrays that begin with the frames of a state, and have room for `many` more.

    A state ends where its own frames end. What lies behind belongs to no one until a step takes it, so frames are
    copied only where no room is left, or where a state is gone on with for the second time.

    Parameters
    ----------
    frames, time : ndarray, shape (k, n) and (k,)
        Those of the state.
    room : list
        The arrays that they lie at the beginning of, where nobody has taken them yet.
    many : int
        How many are to come.
    """
    kept = len(time)
    size = kept + many
    try:
        arrays = room.pop()  # at once: of two threads one gets it
        if size <= len(arrays[1]):
            return arrays
    except IndexError:
        pass
    most = size + max(size, _LEAST)
    arrays = np.empty((most, frames.shape[1])), np.empty(most)
    arrays[0][:kept], arrays[1][:kept] = frames, time
    return arrays


def since(arrays: Arrays, head: int, end: int) -> tuple[FloatArray, FloatArray, list[Arrays]]:
    """The frames and times from `head` to `end`, closed to writing, and the room behind them."""
    frames, time = arrays[0][head:end], arrays[1][head:end]
    room = [(arrays[0][head:], arrays[1][head:])]
    if _WIDE * (end - head + _LEAST) < len(arrays[1]):
        frames, time, room = frames.copy(), time.copy(), []
    frames.setflags(write=False)
    time.setflags(write=False)
    return frames, time, room
