"""A stage: one thing that is done to a stream, which goes on where it was left."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..errors import GeometryError, InvalidValueError

__all__ = ["CHUNK", "Stage", "both_of", "check_state", "in_order", "join"]

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
        raise InvalidValueError(
            "time is missing", "a stream needs the time of each frame [s]", "time=np.arange(frames) / rate"
        )
    clock = _check.real("time", time, unit="s")
    if clock.shape != data.shape[:-1]:
        raise GeometryError(
            f"time of shape {clock.shape}", f"one for each frame, {data.shape[:-1]}, is needed", "a time for each frame"
        )
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
