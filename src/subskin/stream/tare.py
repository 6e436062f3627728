"""Drift: each sensor's offset, followed while nothing touches the skin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.special import chdtri

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..errors import GeometryError, InvalidValueError, NotLinearError
from ..estimate.estimate import Status
from ..estimate.frames import check_noise
from ..estimate.search import Locator
from ..finger import Finger
from ..response import tabulate
from . import _tare_kernel as kernel
from .stage import Stage, in_order, join

__all__ = ["Tare", "TareState", "Tared"]

_DRIFT = 0.3  # fastest drift believed, of the noise, a second
_STILL = 1e-2  # chance with which noise alone makes a step that stays look as if it moved
_WRONG = 0.03  # of the largest departure: by so much the finger's model may be wrong in each
_REACH = 4.0  # depths beyond the row at which a touch is still thought of
_TOUCHES = (Status.OK, Status.AMBIGUOUS)
_FAR = 0.5  # of the free skin's reading, and
_FAR_NOISE = 100.0  # of the noise: an offset that is off by more is not one of the free skin


@dataclass(frozen=True, eq=False)
class TareState(Frozen):
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
    """

    readings: FloatArray
    offset: FloatArray
    free: npt.NDArray[np.bool_]
    frozen: npt.NDArray[np.bool_]
    own: FloatArray
    noise: FloatArray
    differences: bool = False

    @classmethod
    def join(cls, parts: Sequence[Tared]) -> Tared:
        """Successive `parts` of one stream as one."""
        frames = ("readings", "offset", "free", "frozen")
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
class Tare(Stage[TareState, Tared]):
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
        The finger's offsets are of differences from the free skin, as presses cut out by `segment` are: readings are
        given back as such differences.
    guard, settle, patience : float, optional
        Times [s], > 0.
    false_alarm : float, optional
        Probability with which noise makes a frame a touch.

    Raises
    ------
    InvalidValueError, GeometryError
        A sensor without noise, a value out of range or not one a sensor.

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
    known: npt.ArrayLike = np.inf
    differences: bool = False
    guard: float = 0.25
    settle: float = 0.25
    patience: float = 3.0
    false_alarm: float = 1e-6

    def __post_init__(self) -> None:
        array = self.finger.array
        n = len(array)
        noise = _check.real("noise", array.noise if self.noise is None else self.noise, at_least=0.0)
        drift = _check.real("drift", _DRIFT * noise if self.drift is None else self.drift, at_least=0.0)
        known = _check.real("known", self.known, at_least=0.0, finite=False)
        for name, value in (("noise", noise), ("drift", drift), ("known", known)):
            if value.shape not in ((), (n,)):
                rule = f"one value, or one for each of the {n} sensors, is needed"
                raise GeometryError(f"{name} of shape {value.shape}", rule, f"{name}=1e-4")
            object.__setattr__(self, name, _check.read_only(np.broadcast_to(value, n).copy()))
        if np.isnan(known).any():
            raise InvalidValueError("known = nan", "a standard deviation is needed", "known = np.inf")
        check_noise(array, "a touch is told from the sensors' noise", "Tare(finger, noise=1e-4)", self.noise)
        for name in ("guard", "settle", "patience"):
            _check.scalar(name, getattr(self, name), unit="s", above=0.0)
        _check.scalar("false_alarm", self.false_alarm, above=0.0, at_most=0.5)

    @cached_property
    def _sensors(self) -> FloatArray:
        """What the compiled loop is told of the sensors, shape (6, n)."""
        array = self.finger.array
        # a sensor that is rounded to more than its noise may well stand still
        lively = np.asarray(array.resolution) <= np.asarray(self.noise)
        rows = [self.noise, self.drift, array.low, array.high, array.live, lively]
        return np.stack([np.asarray(row, dtype=np.float64) for row in rows])

    @cached_property
    def _limits(self) -> FloatArray:
        """Chi-square that noise exceeds with the chance `false_alarm`, by the number of sensors from 0."""
        return np.array([np.inf, *chdtri(np.arange(1, len(self.finger.array) + 1), self.false_alarm)])

    def step(
        self, state: TareState | None, readings: npt.ArrayLike, time: npt.ArrayLike | None
    ) -> tuple[TareState, Tared]:
        """Take the drift off the next frames of a stream; as `Stage.step`."""
        array = self.finger.array
        n = len(array)
        before = self._beginning() if state is None else state
        if before.rows.shape[1] != n:
            seen = f"a state of {before.rows.shape[1]} sensors, a finger of {n}"
            raise GeometryError(seen, "they have to match", "a state of this finger, or None to start")
        rows, numbers = before.rows.copy(), before.numbers.copy()
        data, clock = in_order(readings, time, numbers[kernel.CLOCK], n)
        frames, first = data.reshape(-1, n), len(before.time)
        every = np.concatenate([np.empty_like(before.frames), frames])
        smooth = np.concatenate([before.frames, np.empty_like(frames)])
        clocks = np.concatenate([before.time, clock])
        offset, frozen = np.empty_like(every), np.zeros(every.shape, dtype=bool)
        free = np.zeros(len(every), dtype=bool)
        options = np.array([self.guard, self.settle, self.patience])
        at, head, question = first, 0, False
        while at < len(every):
            at, head, question = kernel.follow(
                every, clocks, at, head, self._sensors, options, self._limits, rows, numbers,
                smooth, offset, free, frozen,
            )  # fmt: skip
            if question:
                self._ask(rows, frozen[at - 1])
        own = np.zeros(n) if self.differences else np.asarray(array.offset)
        given = np.where(array.live, frames - offset[first:] + own, frames)
        given[array.live & ~array.inside(frames)] = np.nan  # saturated, wherever its offset has gone
        given[frozen[first:]] = np.nan
        left = TareState(rows, numbers, smooth[head:].copy(), clocks[head:].copy())
        for part in (given, offset, free, frozen, *vars(left).values()):
            part.flags.writeable = False
        each, shape = data.shape, data.shape[:-1]
        out = Tared(
            given.reshape(each), offset[first:].reshape(each), free[first:].reshape(shape),
            frozen[first:].reshape(each), own, np.asarray(self.noise), self.differences,
        )  # fmt: skip
        return left, out

    def _beginning(self) -> TareState:
        n = len(self.finger.array)
        rows, numbers = np.zeros((kernel.ROWS, n)), np.zeros(kernel.NUMBERS)
        rows[kernel.OFFSET], rows[kernel.SPREAD] = self.finger.array.offset, self.known
        rows[[kernel.BASE, kernel.BEFORE, kernel.LAST, kernel.HELD]] = np.nan
        numbers[[kernel.FREE, kernel.QUIET, kernel.CLOCK]] = 1.0, np.inf, np.nan
        return TareState(rows, numbers, np.empty((0, n)), np.empty(0))

    def _ask(self, rows: FloatArray, frozen: npt.NDArray[np.bool_]) -> None:
        """Is what has lasted a touch? If it cannot be, the offsets in `rows` are changed to what is read now."""
        array = self.finger.array
        noise = np.where(array.live, np.asarray(self.noise), 1.0)
        spread, count = rows[kernel.SPREAD], np.maximum(rows[kernel.COUNT], 1)
        told = array.live & (rows[kernel.COUNT] > 0) & ~frozen & np.isfinite(spread)
        spread = np.where(told, spread, 0.0)
        mean = rows[kernel.BASE] + rows[kernel.SUM] / count
        variance = noise**2 / count
        # what still moves is no offset: a touch that goes on, or rubber that comes back from one
        moved = np.where(told, mean - rows[kernel.HELD], 0.0)
        moved2 = moved**2 / (2 * variance + (np.asarray(self.drift) * self.patience) ** 2)
        rows[kernel.HELD] = mean
        if told.sum() < 2 or not moved2.sum() <= chdtri(told.sum(), _STILL):
            return
        away = np.where(told, mean - rows[kernel.OFFSET], np.nan)
        if self._may_be_touch(away, spread, variance):
            return
        score = np.where(told, away**2 / (variance + spread**2), 0.0)
        one = int(np.argmax(score))
        if score.sum() - score[one] <= self._limits[told.sum() - 1]:
            taken = np.arange(len(array)) == one
        elif self._status(-away, np.hypot(noise, spread), friction=1.0) in _TOUCHES:
            taken = told
        else:
            return
        rows[kernel.OFFSET, taken] = mean[taken]
        rows[kernel.SPREAD, taken] = np.sqrt(variance)[taken]
        rows[kernel.HELD] = np.nan

    def _may_be_touch(self, away: FloatArray, spread: FloatArray, variance: FloatArray) -> bool:
        """Whether some pressing load, however it leans, makes these departures, by a model that is somewhat wrong."""
        wrong = _WRONG * float(np.nanmax(np.abs(away)))
        status = self._status(away, np.sqrt(np.asarray(self.noise) ** 2 + spread**2 + wrong**2), friction=np.inf)
        # too little for a touch by a single frame and the drift meanwhile: by the mean, and without?
        if status == Status.NO_CONTACT:
            status = self._status(away, np.sqrt(variance + wrong**2), friction=np.inf)
        return status not in (Status.UNEXPLAINED, Status.NO_CONTACT)

    def _status(self, away: FloatArray, noise: FloatArray, friction: float) -> Status:
        """Of the load that departures from the offsets would have."""
        array, y = self.finger.array, np.asarray(self.finger.array.y)
        reach = _REACH * float(np.asarray(array.depth).max())
        middle, half = 0.5 * (y.min() + y.max()), 0.5 * np.ptp(y) + reach
        half = min(half, 0.5 * self.finger.skin.period)
        try:
            table = tabulate(self.finger, (middle - half, middle + half))
        except NotLinearError:  # no estimate can be made: anything may be a touch
            return Status.INCOMPLETE
        wide = replace(array, noise=np.maximum(noise, 1e-300), low=-np.inf, high=np.inf)
        locator = Locator(table, wide, friction=friction, false_alarm=self.false_alarm)
        return Status(int(locator(np.asarray(array.offset) + away).status))
