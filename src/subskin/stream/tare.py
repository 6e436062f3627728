"""Drift: each sensor's offset, followed while nothing touches the skin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.special import chdtri

from .. import _check
from .._check import FloatArray
from .._declared import Noun, Real
from .._frozen import Frozen, Result
from .._shown import lines
from ..errors import GeometryError, InvalidValueError
from ..estimate.frames import check_noise
from ..finger import Finger
from . import _tare_kernel as kernel
from ._held import Held
from .stage import Arrays, Stage, behind, check_state, in_order, join, since, some_of

__all__ = ["Tare", "TareState", "Tared"]

_Time: TypeAlias = Annotated[float, Real("s", above=0.0)]

_DRIFT = 0.3  # fastest drift believed, of the noise, a second
_FAR = 0.5  # of the free skin's reading, and
_FAR_NOISE = 100.0  # of the noise: an offset that is off by more is not one of the free skin


@dataclass(frozen=True, eq=False)
class TareState(Result):
    """All that is carried from one batch of a stream to the next, by `Tare.step`.

    Parameters
    ----------
    rows : ndarray, shape (10, n)
        What is known of each sensor: its offset, sums over the last frames, and its last readings [reading].
    numbers : ndarray, shape (4,)
        Whether the skin is free, and clocks [s].
    frames, time : ndarray, shape (k, n) and (k,)
        The last `guard` seconds [reading], [s].
    """

    rows: FloatArray
    numbers: FloatArray
    frames: FloatArray
    time: FloatArray

    @cached_property
    def _room(self) -> list[Arrays]:
        """Room behind the last frames, which whoever goes on first takes; a copy has none."""
        return []

    @property
    def offset(self) -> FloatArray:
        """The offsets, shape (n,)."""
        return np.asarray(self.rows[kernel.OFFSET])

    @property
    def std(self) -> FloatArray:
        """How surely they are known, shape (n,); infinite where none has been seen yet."""
        return np.asarray(self.rows[kernel.SPREAD])


@dataclass(frozen=True, eq=False)
class Tared(Frozen):
    """A stream with its drift taken off.

    Parameters
    ----------
    readings : ndarray, shape (m, n)
        Readings as if the offsets were the finger's own, in units of each gain: `Finger.locate` takes them as they are.
        NaN where a sensor is frozen, or its offset not known yet.
    offset : ndarray, shape (m, n)
        The offset that was taken for each frame's [reading]; NaN where it is not known yet.
    free : ndarray of bool, shape (m,)
        Which frames are free of contact.
    frozen : ndarray of bool, shape (m, n)
        Which sensors have stopped to move at all.
    own, noise : ndarray, shape (n,)
        The offsets that the readings are given back with, and the finger's noise [reading].
    differences : bool
        The readings are differences from the free skin: `own` is 0.
    doubt : ndarray, shape (m, n), or None
        How far each reading is in doubt, by what a stage before says and by its offset [reading]; None where no stage
        before says it.
    """

    readings: FloatArray
    offset: FloatArray
    free: npt.NDArray[np.bool_]
    frozen: npt.NDArray[np.bool_]
    own: FloatArray
    noise: FloatArray
    differences: bool = False
    doubt: FloatArray | None = None

    def __repr__(self) -> str:
        free, frozen = int(np.sum(self.free)), int(np.atleast_2d(self.frozen).any(axis=0).sum())
        known = np.isfinite(self.offset.reshape(-1, self.own.size)).any(axis=0)
        rows = [("free of contact", f"{free} frames"), ("offsets known", f"{int(known.sum())} of {known.size} sensors")]
        return lines(f"Tared of {np.size(self.free)} frames", [*rows, ("frozen at times", f"{frozen} sensors")])

    @classmethod
    def join(cls, parts: Sequence[Tared]) -> Tared:
        """Successive `parts` of one stream as one."""
        parts = some_of(parts, cls)
        frames = ("readings", "offset", "free", "frozen") + ("doubt",) * (parts[0].doubt is not None)
        return replace(parts[0], **{name: join([getattr(part, name) for part in parts]) for name in frames})

    @property
    def doubts(self) -> tuple[str, ...]:
        """What speaks against reading this stream with this finger, in words; nothing, usually."""
        offset = self.offset.reshape(-1, self.own.size)
        known = np.isfinite(offset).any(axis=0)
        if self.differences or not known.any():
            return ()
        free, own = np.nanmedian(offset[:, known], axis=0), self.own[known]
        far = np.abs(free - own) > np.maximum(_FAR * np.abs(free), _FAR_NOISE * self.noise[known])
        differs = (
            f"the free skin reads {free[0]:.4g}, and the finger's offset is {own[0]:.4g}: a finger calibrated on "
            "presses cut out by segment knows differences. Fix: differences = true under [calibration] says so"
        )
        return (differs,) if far.all() else ()


@dataclass(frozen=True, eq=False)
class Tare(Stage[TareState, Tared], Noun):
    """Follows each sensor's offset while the skin is free, frame by frame, and takes it off.

    A scalar Kalman filter a sensor: the standard deviation of its offset grows by `drift` a second, and each free frame
    lessens it. A frame is free where neither it nor the mean over the last `guard` seconds departs from the offsets by
    more than noise and `drift` allow, by a chi-square test over all sensors, on medians of three readings. A touch has
    ended when that mean has changed and has then been within half the limit for `settle` seconds. Offsets are learnt
    from frames that were still free `guard` seconds later, so that a touch's beginning is not.

    What no touch can be is a change of offset: a step of one sensor that no load explains, or a state of all of them
    that only a pull could make, is taken up when it has stayed the same for `patience` seconds. Anything else that
    stays is held for a touch, however long. A sensor whose reading does not change at all for `patience` seconds (and
    20 frames) is frozen: it is neither followed nor trusted.

    Parameters
    ----------
    finger : Finger
        Its noise and range are those of the readings, its offsets what readings are given back with.
    drift : array_like, optional
        Fastest drift that is believed [reading/s]; 0.3 noise a second if left out. Faster drift is taken for a touch;
        touches so light and slow are taken for drift.
    noise : array_like, optional
        Standard deviation of a reading [reading], where not the finger's.
    known : array_like, optional
        Standard deviation of the finger's own offsets at first [reading]. Infinite if left out: the stream then has to
        begin with the skin free, and its first frame is the first offset.
    differences : bool, optional
        The finger reads differences from the free skin, as presses cut out by `segment` are, and has no offset:
        readings are given back as such differences.
    guard, settle, patience : float, optional
        Times [s], > 0.
    false_alarm : float, optional
        Probability with which noise makes a frame a touch.

    Raises
    ------
    InvalidValueError, GeometryError
        A sensor without noise, a value out of range or not one a sensor; a finger of differences with an offset.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=1e-4))
    >>> time = np.arange(0.0, 20.0, 0.01)
    >>> pressed = (time > 10.0) & (time < 15.0)
    >>> raw = finger.read(ss.LineLoad(40.0 * pressed), np.random.default_rng(0)) + 2e-5 * time[:, None]
    >>> found = ss.Tare(finger, drift=2e-5)(raw, time)
    >>> int(found.free[pressed].sum()), found.offset[-1].round(4).tolist()  # one frame to tell, by medians of three
    (1, [0.0004, 0.0004, 0.0004, 0.0004])
    """

    finger: Finger
    drift: npt.ArrayLike | None = None
    noise: npt.ArrayLike | None = None
    known: Annotated[npt.ArrayLike, Real(at_least=0.0, finite=False)] = np.inf
    differences: bool = False
    guard: _Time = 0.25
    settle: _Time = 0.25
    patience: _Time = 3.0
    false_alarm: Annotated[float, Real(above=0.0, at_most=0.5)] = 1e-6

    def __post_init__(self) -> None:
        super().__post_init__()
        array = self.finger.array
        n = len(array)
        noise = _check.real("noise", array.noise if self.noise is None else self.noise, at_least=0.0)
        drift = _check.real("drift", _DRIFT * noise if self.drift is None else self.drift, at_least=0.0)
        known = np.asarray(self.known)
        for name, value in (("noise", noise), ("drift", drift), ("known", known)):
            if value.shape not in ((), (n,)):
                rule = f"one value, or one for each of the {n} sensors, is needed"
                raise GeometryError(f"{name} of shape {value.shape}", rule, f"{name}=1e-4")
            object.__setattr__(self, name, _check.read_only(np.broadcast_to(value, n).copy()))
        if np.isnan(known).any():
            raise InvalidValueError("known = nan", "a standard deviation is needed", "known = np.inf")
        if self.differences:
            array.refuse_offset()
        check_noise(array, "a touch is known by the sensors' noise", "Tare(finger, noise=1e-4)", self.noise)

    @cached_property
    def _sensors(self) -> FloatArray:
        """What the compiled loop is told of the sensors, shape (7, n)."""
        array = self.finger.array
        # a sensor that is rounded to more than its noise may well stand still
        lively = np.asarray(array.resolution) <= np.asarray(self.noise)
        rows = [self.noise, self.drift, array.low, array.high, array.live, lively, array.offset]
        return np.stack([np.asarray(row, dtype=np.float64) for row in rows])

    @cached_property
    def _told(self) -> dict[str, Any]:
        """What `Tared` says of the sensors."""
        told = {"own": self._sensors[kernel.OWN], "noise": self.noise, "differences": self.differences}
        return {**told, "doubt": None}

    @cached_property
    def _none(self) -> FloatArray:
        """What the compiled loop is given where no reading is in doubt."""
        return np.empty((0, len(self.finger.array)))

    @cached_property
    def _limits(self) -> FloatArray:
        """Chi-square that noise exceeds with the chance `false_alarm`, by the number of sensors from 0."""
        return np.array([np.inf, *chdtri(np.arange(1, len(self.finger.array) + 1), self.false_alarm)])

    takes_doubt = True

    def step(
        self,
        state: TareState | None,
        readings: npt.ArrayLike,
        time: npt.ArrayLike | None,
        doubt: FloatArray | None = None,
    ) -> tuple[TareState, Tared]:
        """Take the drift off the next frames of a stream; as `Stage.step`.

        To a `doubt` is added how surely each offset is known, as variances are.
        """
        n = self._sensors.shape[1]
        check_state(state, TareState)
        before = self._beginning() if state is None else state
        if before.rows.shape[1] != n:
            seen = f"a state of {before.rows.shape[1]} sensors, a finger of {n}"
            raise GeometryError(seen, "they have to match", "a state of this finger, or None to start")
        rows, numbers = before.rows.copy(), before.numbers.copy()
        data, clock = in_order(readings, time, numbers.item(kernel.CLOCK), n)
        frames = data.reshape(-1, n).copy()  # the loop is compiled for arrays that can be written
        many = len(frames)
        kept = len(before.time)
        end = kept + many
        arrays = behind(before.frames, before.time, before._room, many)
        smooth, clocks = arrays[0][:end], arrays[1][:end]
        clocks[kept:] = clock
        given, offset = np.empty((2, many, n))
        free: npt.NDArray[np.bool_] = np.empty(many, dtype=bool)
        frozen: npt.NDArray[np.bool_] = np.empty((many, n), dtype=bool)
        more = self._none
        if doubt is not None:
            more = _check.real("doubt", doubt, at_least=0.0, finite=False)
            if more.shape != data.shape:
                seen = f"doubt of shape {more.shape}, readings of shape {data.shape}"
                raise GeometryError(seen, "one is needed for each reading", "doubt=None")
            more = more.reshape(-1, n).copy()
        filled = kernel.TaredFrames(given, offset, free, frozen, more)
        at = head = 0
        while at < many:
            at, head, question = kernel.follow(
                frames, smooth, clocks, at, head, self._sensors, self._times, self._limits, rows, numbers, filled
            )  # fmt: skip
            if question:
                self._held.ask(rows, frozen[at - 1])
        last, times, room = since(arrays, head, end)
        left = {"rows": rows, "numbers": numbers, "frames": last, "time": times, "_room": room}
        if data.ndim == 1:
            given, offset, free, frozen = given[0], offset[0], free.reshape(()), frozen[0]
        for part in (given, offset, free, frozen, rows, numbers):
            part.setflags(write=False)
        out = {"readings": given, "offset": offset, "free": free, "frozen": frozen, **self._told}
        if doubt is not None:
            out["doubt"] = more.reshape(given.shape)
            out["doubt"].setflags(write=False)
        return TareState.filled(left), Tared.filled(out)

    def prepare(self) -> None:
        """Tabulate what a touch that lasts is judged by; as `Stage.prepare`."""
        self._held.prepare()

    def resumed(self, state: TareState | None) -> TareState | None:
        """The state for a stream that begins anew: offsets and how surely they are known are kept; as `Stage.resumed`.

        Whether the skin was free is kept too. The last frames, and their times, are forgotten.
        """
        check_state(state, TareState)
        if state is None:
            return None
        start = self._beginning()
        rows, numbers = np.array(start.rows), np.array(start.numbers)
        rows[[kernel.OFFSET, kernel.SPREAD]] = state.rows[[kernel.OFFSET, kernel.SPREAD]]
        numbers[kernel.FREE] = state.numbers[kernel.FREE]
        return TareState(rows, numbers, start.frames, start.time)

    def zeroed(self, state: TareState | None) -> TareState | None:
        """The state after "zero now": nothing touches, and what was read in the last `guard` seconds are the offsets.

        Parameters
        ----------
        state : TareState or None
            As of `step`. Before the first frame there is nothing to do: that frame is the first offset.

        Returns
        -------
        TareState or None
            For the next frames. A sensor without a reading in these seconds takes its offset from its next one.

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
        >>> tare = ss.Tare(ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=1e-4)))
        >>> time = np.arange(0.0, 2.0, 0.01)
        >>> state, _ = tare.step(None, np.where(time[:, None] < 1.0, 0.0, 0.02) * np.ones(4), time)
        >>> tare.zeroed(state).offset.round(6).tolist()
        [0.02, 0.02, 0.02, 0.02]
        """
        check_state(state, TareState)
        if state is None:
            return None
        rows, numbers = state.rows.copy(), state.numbers.copy()
        count, noise = rows[kernel.COUNT], self._sensors[kernel.NOISE]
        seen, many = count > 0, np.maximum(count, 1.0)
        rows[kernel.OFFSET] = np.where(seen, rows[kernel.BASE] + rows[kernel.SUM] / many, rows[kernel.OFFSET])
        rows[kernel.SPREAD] = np.where(seen, noise / np.sqrt(many), np.inf)
        rows[kernel.HELD] = np.nan
        numbers[kernel.FREE], numbers[kernel.QUIET] = 1.0, np.inf
        return TareState(rows, numbers, state.frames, state.time)

    @cached_property
    def _times(self) -> FloatArray:
        return np.array([self.guard, self.settle, self.patience])

    @cached_property
    def _held(self) -> Held:
        """Judges touches that last."""
        noise, drift = np.asarray(self.noise), np.asarray(self.drift)
        own = self._sensors[kernel.OWN]
        return Held(self.finger, own, noise, drift, self.patience, self._limits, self.false_alarm)

    def _beginning(self) -> TareState:
        n = len(self.finger.array)
        rows, numbers = np.zeros((kernel.ROWS, n)), np.zeros(kernel.NUMBERS)
        rows[kernel.OFFSET], rows[kernel.SPREAD] = self.finger.array.offset, self.known
        rows[[kernel.BASE, kernel.BEFORE, kernel.LAST, kernel.HELD]] = np.nan
        numbers[[kernel.FREE, kernel.QUIET, kernel.CLOCK]] = 1.0, np.inf, np.nan
        return TareState(rows, numbers, np.empty((0, n)), np.empty(0))
