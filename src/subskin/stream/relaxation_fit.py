"""How much, and how fast, the rubber of a skin relaxes: fitted from touches that are held."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Real, Whole, checked
from .._frozen import Frozen
from ..errors import ConvergenceError, GeometryError, InvalidValueError
from .relaxation import Relaxation
from .stage import in_order

__all__ = ["RelaxationFit", "fit_relaxation"]

_FEWEST = 5  # frames of a held stretch
_SAME, _SIGMA = 0.1, 4.0
"""Sensors share a kernel where each one's amount is within this of 1, or within so many standard errors."""


@dataclass(frozen=True, eq=False)
class RelaxationFit(Frozen):
    """What `fit_relaxation` found.

    Parameters
    ----------
    relaxation : Relaxation
        The kernel common to all sensors.
    share_std, time_std : ndarray, shape (k,)
        Standard errors [-], [s]; of residuals that are independent from frame to frame, so rather too small.
    scale, scale_std : ndarray, shape (n,)
        How many times the common shares each sensor loses, and the standard error; NaN for a sensor that the touches do
        not move.
    before, after : ndarray, shape (n,)
        By how much a held reading changes, rms about its mean, in units of each sensor's noise: as read, and with the
        common kernel undone. 1 is what noise leaves.
    own : Relaxation
        A series with each sensor's own shares, in the same ratio for all its terms, and time constants fitted with
        them; for a sensor that the touches do not move the common shares. Its `doubt` is by how much what it takes of a
        reading is wrong, over what it takes, rms over the sensors, the held stretches and, as much again, the free skin
        after them: of rubber that is not linear, and of shares that differ from touch to touch.
    """

    relaxation: Relaxation
    share_std: FloatArray
    time_std: FloatArray
    scale: FloatArray
    scale_std: FloatArray
    before: FloatArray
    after: FloatArray
    own: Relaxation

    @property
    def common(self) -> bool:
        """Whether one kernel serves all sensors: each one's `scale` is within 10 %, or 4 standard errors, of 1."""
        told = np.isfinite(self.scale)
        return bool((np.abs(self.scale - 1)[told] <= np.maximum(_SAME, _SIGMA * self.scale_std[told])).all())


@checked
def fit_relaxation(
    readings: npt.ArrayLike,
    time: npt.ArrayLike,
    held: Annotated[npt.ArrayLike, Real("s")],
    *,
    terms: Annotated[int, Whole(1, 3, "terms=2")] = 2,
    rest: npt.ArrayLike | None = None,
    free: npt.ArrayLike | None = None,
) -> RelaxationFit:
    """Fit a Prony series to a recording in which touches are held.

    The kernel is the one whose inverse makes each held stretch constant, by least squares over all sensors, each in
    units of its noise. So nothing need be known of how the touches came. Stretches of free skin count as held ones: it
    is there that the rubber recovers.

    Parameters
    ----------
    readings : array_like, shape (m, n)
        The whole recording, each sensor in units of its gain, from its beginning at rest; NaN is a missing reading.
    time : array_like, shape (m,)
        Time of each frame [s], not decreasing.
    held : array_like, shape (k, 2)
        First and last time of each stretch over which the touch does not change [s], as `start` and `stop` of
        `segment`.
    terms : {1, 2, 3}, optional
        Terms of the series.
    rest : array_like, optional
        As in `Relaxation`.
    free : array_like, shape (k, 4), optional
        Of each touch the first and last time of a stretch of free skin before it, and of one soon after it [s]. Both
        should read the same once the series is undone: how far they do not tells `own.doubt`. Without it the held
        stretches alone do, which say little of what a skin has not given back.

    Returns
    -------
    RelaxationFit

    Raises
    ------
    InvalidValueError, GeometryError
        Shapes that do not match, stretches without frames, a number of terms out of range.
    ConvergenceError
        A fit that did not settle.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0.0, 40.0, 0.02)
    >>> touch = 1.0 * ((t > 2.0) & (t < 12.0) | (t > 20.0) & (t < 30.0))
    >>> felt = Relaxation([0.15], [1.5]).apply(touch[:, None] * [1.0, -0.4], t)
    >>> noise = 1e-3 * np.random.default_rng(0).standard_normal(felt.shape)
    >>> found = fit_relaxation(felt + noise, t, [(2.1, 11.9), (20.1, 29.9)], terms=1)
    >>> found.relaxation.share.round(3).tolist(), found.relaxation.time.round(2).tolist(), found.common
    ([0.15], [1.5], True)
    """
    data, clock = in_order(readings, time)
    ends = np.asarray(held)
    if data.ndim != 2 or ends.ndim != 2 or ends.shape[1] != 2 or not len(ends):
        seen, rule = f"readings of shape {data.shape}, held of shape {ends.shape}", "(m, n) and (k, 2) are needed"
        raise GeometryError(seen, rule, "readings of shape (frames, sensors), held=[(1.0, 3.0)]")
    first = np.searchsorted(clock, ends[:, 0], side="left")
    stop = np.searchsorted(clock, ends[:, 1], side="right")
    short = np.flatnonzero(stop - first < _FEWEST)
    if short.size:
        a, b = ends[short[0]]
        seen = f"held[{short[0]}] = ({a:.6g}, {b:.6g}) s"
        raise InvalidValueError(seen, f"at least {_FEWEST} frames have to lie in it", "leave it out")
    return _Series(data, clock, first, stop, terms, rest, _frames_of(clock, free)).result()


class _Series:
    """Least squares over c = share / (1 - sum of share) and log(time): both free of the constraint."""

    def __init__(
        self,
        frames: FloatArray,
        clock: FloatArray,
        first: npt.NDArray[np.intp],
        stop: npt.NDArray[np.intp],
        terms: int,
        rest: npt.ArrayLike | None,
        free: npt.NDArray[np.intp],
    ) -> None:
        self.free = free
        self.frames, self.clock, self.terms = frames, clock, terms
        at_rest = Relaxation(np.zeros(1), np.ones(1), rest).undo.step(None, frames, clock)[0].rest
        self.rest = None if rest is None else at_rest
        self.spans = [slice(a, b) for a, b in zip(first, stop, strict=True)]
        jumps = np.concatenate([np.diff(frames[s], axis=0) for s in self.spans])
        pairs = np.maximum(np.isfinite(jumps).sum(axis=0), 1)
        self.noise = np.sqrt(0.5 * np.nansum(jumps**2, axis=0) / pairs)
        # a sensor that rounds away its noise, or a recording without any
        moved = np.abs(frames - at_rest)
        largest = float(moved[np.isfinite(moved)].max(initial=0.0))
        if not largest > 0:
            fix = "frames from before the touches on, and stretches within them"
            raise ConvergenceError("readings that never change, or are all missing", "held touches are needed", fix)
        self.noise = np.maximum(self.noise, 1e-9 * largest or 1.0)
        self.lengths = np.array([clock[s][-1] - clock[s][0] for s in self.spans])
        if not self.lengths.max() > 0:
            raise InvalidValueError("held stretches of no duration", "relaxation takes time", "longer stretches")

    def left(self, share: FloatArray, constants: FloatArray, sensors: slice = slice(None)) -> FloatArray:
        """What is left of the change in each held stretch, in units of the noise, shape (held frames, sensors)."""
        rest = None if self.rest is None else self.rest[sensors]
        out = Relaxation(share, constants, rest).undo(self.frames[:, sensors], self.clock)
        away = []
        for span in self.spans:
            seen = np.isfinite(out[span])
            count = np.maximum(seen.sum(axis=0), 1)
            mean = np.where(seen, out[span], 0.0).sum(axis=0) / count
            away.append(np.where(seen, out[span] - mean, 0.0))
        return np.asarray(np.concatenate(away) / self.noise[sensors])

    def kernel(self, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        c = p[: self.terms]
        return c / (1 + c.sum()), np.exp(p[self.terms :])

    def result(self) -> RelaxationFit:
        k, longest = self.terms, float(self.lengths.max())
        shortest = max(float(np.median(np.diff(self.clock))), 1e-3 * longest)
        low = np.concatenate([np.zeros(k), np.full(k, np.log(shortest))])
        high = np.concatenate([np.full(k, 20.0), np.full(k, np.log(10 * longest))])
        start = np.concatenate(
            [np.full(k, 0.1 / k), np.log(longest * np.array([0.2] if k == 1 else np.geomspace(0.05, 0.5, k)))]
        )
        found = _least(lambda p: self.left(*self.kernel(p)), start, (low, high))
        if not found.success:
            raise ConvergenceError("the fit did not settle", str(found.message), "fewer terms")
        order = np.argsort(found.x[k:])
        p = np.concatenate([found.x[:k][order], found.x[k:][order]])
        share, constants = self.kernel(p)
        jacobian = found.jac[:, np.concatenate([order, k + order])]
        degrees = max(found.fun.size - 2 * k, 1)
        covariance = np.linalg.pinv(jacobian.T @ jacobian) * (2 * found.cost / degrees)
        # share by c, time by its logarithm
        turn = (np.eye(k) - share[:, None]) / (1 + p[:k].sum())
        share_std = np.sqrt(np.diag(turn @ covariance[:k, :k] @ turn.T))
        time_std = constants * np.sqrt(np.diag(covariance)[k:])
        scales = [self._scale(share, constants, i) for i in range(self.frames.shape[1])]
        scale, scale_std = (np.array(column) for column in zip(*scales, strict=True))
        before, after = (np.sqrt((self.left(s, constants) ** 2).mean(axis=0)) for s in (np.zeros(k), share))
        for values in (share_std, time_std, scale, scale_std, before, after):
            values.setflags(write=False)
        own = self._own(p, scale, scale_std, (low, high))
        common = Relaxation(share, constants, self.rest)
        return RelaxationFit(common, share_std, time_std, scale, scale_std, before, after, own)

    def _own(
        self, p: FloatArray, scale: FloatArray, scale_std: FloatArray, ends: tuple[FloatArray, FloatArray]
    ) -> Relaxation:
        """The series of each sensor, from the common one `p` and how many times its shares each sensor loses."""
        told = np.isfinite(scale)
        known, free = np.where(told, scale, 1.0), told.copy()
        if told.any():
            free[np.nanargmin(scale_std)] = False  # only the product of the shares and of all scales is told

        def series(x: FloatArray) -> tuple[FloatArray, FloatArray]:
            share, constants = self.kernel(x[: p.size])
            known[free] = x[p.size :]
            return share[:, None] * np.clip(known, 0.0, 0.99 / max(float(share.sum()), 1e-300)), constants

        x, more = np.concatenate([p, known[free]]), int(free.sum())
        if more:
            low, high = np.append(ends[0], np.zeros(more)), np.append(ends[1], np.full(more, np.inf))
            x = _least(lambda x: self.left(*series(x)), np.clip(x, low, high), (low, high)).x
        share, constants = series(x)
        return Relaxation(share, constants, self.rest, self._doubt(share, constants, told))

    def _doubt(self, share: FloatArray, constants: FloatArray, told: npt.NDArray[np.bool_]) -> float:
        """What is wrong with the readings undone, over what was taken off them, rms over the sensors `told`."""
        left = self.left(share, constants)
        taken = left - self.left(np.zeros_like(share), constants)
        # of each stretch's frames one goes into their mean
        noise = (np.isfinite(np.concatenate([self.frames[s] for s in self.spans])).sum(axis=0)) - len(self.spans)
        squares = [_ratio2(np.maximum((left**2).sum(axis=0) - noise, 0.0), (taken**2).sum(axis=0), told)]
        if len(self.free):
            out = Relaxation(share, constants, self.rest, 1.0).undoing(self.frames, self.clock)
            before, after = (_means(out.readings, *self.free[:, k : k + 2].T) for k in (0, 2))
            size = _means(out.doubt, *self.free[:, 2:].T)
            seen = np.isfinite(before + after + size)
            wrong, size = (np.where(seen, v, 0.0) ** 2 for v in (after - before, size))
            first, stop = self.free[:, ::2], self.free[:, 1::2]
            frames = np.where(seen, (1.0 / (stop - first)).sum(axis=-1, keepdims=True), 0.0)
            wrong = np.maximum(wrong.sum(axis=0) - frames.sum(axis=0) * self.noise**2, 0.0)
            squares.append(_ratio2(wrong, size.sum(axis=0), told))
        return float(np.sqrt(np.mean(squares)))

    def _scale(self, share: FloatArray, constants: FloatArray, sensor: int) -> tuple[float, float]:
        """How much more one sensor relaxes, and its standard error."""
        total = float(share.sum())
        if total <= 0:
            return np.nan, np.nan
        part = slice(sensor, sensor + 1)
        ends = (np.zeros(1), np.full(1, 0.99 / total))
        found = _least(lambda s: self.left(s[0] * share, constants, part), np.ones(1), ends)
        information = float((found.jac**2).sum())
        if not information > 0:
            return np.nan, np.nan
        std = float(np.sqrt(2 * found.cost / max(found.fun.size - 1, 1) / information))
        return (float(found.x[0]), std) if std < 1.0 else (np.nan, np.nan)


def _frames_of(clock: FloatArray, free: npt.ArrayLike | None) -> npt.NDArray[np.intp]:
    """First and past-the-last frame of the stretches of free skin before and after each touch, (k, 4)."""
    if free is None:
        return np.zeros((0, 4), dtype=np.intp)
    ends = _check.real("free", free, unit="s")
    if ends.ndim != 2 or ends.shape[1] != 4:
        rule, fix = "two stretches of each touch, (k, 4), are needed", "free=[(0.0, 0.9, 4.1, 4.5)]"
        raise GeometryError(f"free of shape {ends.shape}", rule, fix)
    each = [np.searchsorted(clock, ends[:, k], side="right" if k % 2 else "left") for k in range(4)]
    empty = np.flatnonzero((each[1] <= each[0]) | (each[3] <= each[2]))
    if empty.size:
        seen = f"free[{empty[0]}] = {ends[empty[0]].tolist()} s"
        raise InvalidValueError(seen, "a frame has to lie in each stretch", "leave it out")
    return np.stack(each, axis=-1)


def _means(values: FloatArray, first: npt.NDArray[np.intp], stop: npt.NDArray[np.intp]) -> FloatArray:
    """Mean of each sensor over some stretches of frames, (k, n); NaN where one is missing."""
    return np.array([values[a:b].mean(axis=0) for a, b in zip(first, stop, strict=True)])


def _ratio2(wrong: FloatArray, size: FloatArray, told: npt.NDArray[np.bool_]) -> float:
    """Mean over the sensors `told` of wrong / size, both squares (n,)."""
    told = told & (size > 0)
    return float((wrong[told] / size[told]).mean()) if told.any() else 0.0


def _least(left: Callable[[FloatArray], FloatArray], start: FloatArray, ends: tuple[FloatArray, FloatArray]) -> Any:
    from scipy.optimize import least_squares

    def flat(p: FloatArray) -> FloatArray:
        return left(p).reshape(-1)

    return least_squares(flat, start, bounds=ends, x_scale=np.maximum(np.abs(start), 0.1))
