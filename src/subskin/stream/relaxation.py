"""Relaxation: what rubber forgets of a touch that is held, put into a stream or taken off it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError

__all__ = ["Relaxation", "RelaxationState", "Relaxed", "beginning", "relaxed", "stream"]


@dataclass(frozen=True, eq=False)
class RelaxationState:
    """What is carried from one chunk of a stream to the next; `rows` has shape (3 + terms, n)."""

    rows: FloatArray


@dataclass(frozen=True, eq=False)
class Relaxed:
    """A stream with relaxation put in or taken off.

    Parameters
    ----------
    readings : ndarray, shape (m, n) or (n,)
        NaN where the reading was not finite.
    state : RelaxationState
        For the next chunk.
    """

    readings: FloatArray
    state: RelaxationState


@dataclass(frozen=True, eq=False)
class Relaxation:
    """How the reading of a touch that is held falls: 1 - sum of share (1 - exp(-t / time)), a Prony series.

    Parameters
    ----------
    share : array_like, shape (k,) or (k, n)
        Share of the reading that each term loses in the end, >= 0, less than 1 in all; of the whole skin, or of each
        sensor.
    time : array_like, shape (k,)
        Time constant of each term [s], > 0.

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range, shapes that do not match.

    Examples
    --------
    >>> import numpy as np
    >>> rubber = Relaxation(share=[0.1, 0.05], time=[0.5, 5.0])
    >>> t = np.linspace(0.0, 30.0, 301)
    >>> held = np.where(t < 1.0, 0.0, 2.0)[:, None]
    >>> felt = rubber.apply(held, t).readings
    >>> round(float(felt[-1, 0]), 3), bool(np.allclose(rubber.undo(felt, t).readings, held))
    (1.7, True)
    """

    share: npt.ArrayLike
    time: npt.ArrayLike

    def __post_init__(self) -> None:
        time = _check.real(
            "time", np.atleast_1d(np.asarray(self.time, dtype=np.float64)), unit="s", above=0.0
        )
        share = _check.real("share", np.atleast_1d(np.asarray(self.share, dtype=np.float64)), at_least=0.0)
        if time.ndim != 1 or share.ndim not in (1, 2) or len(share) != len(time):
            raise GeometryError(
                f"share of shape {share.shape}, time of shape {time.shape}", "one of each a term is needed"
            )
        _check.real(
            "the sum of share", share.sum(axis=0), at_most=0.999, fix="a skin keeps some of its stress"
        )
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "share", share)

    def apply(
        self,
        readings: npt.ArrayLike,
        time: npt.ArrayLike,
        *,
        rest: npt.ArrayLike | None = None,
        state: RelaxationState | None = None,
    ) -> Relaxed:
        """Readings of an elastic skin as this one would have given them; arguments as those of `undo`."""
        return self._run(readings, time, rest, state, backwards=False)

    def undo(
        self,
        readings: npt.ArrayLike,
        time: npt.ArrayLike,
        *,
        rest: npt.ArrayLike | None = None,
        state: RelaxationState | None = None,
    ) -> Relaxed:
        """Readings as an elastic skin would have given them: a touch that is held reads constant.

        Causal, frame by frame, and exact where the elastic reading changes linearly from each frame to the next.
        However a stream is cut into chunks, the results are the same.

        Parameters
        ----------
        readings : array_like, shape (m, n) or (n,)
            Frames in the order of time, or one; NaN is a missing reading.
        time : array_like, shape (m,) or ()
            Time of each [s], not decreasing; steps may differ.
        rest : array_like, optional
            Readings of the untouched skin: a finger's offsets. The first reading of each sensor if left out. An offset
            that is wrong by d ends as d / (1 - sum of share): take drift off afterwards, not before (docs/robust.md).
        state : RelaxationState, optional
            What the frames before left; `rest` is in it.

        Raises
        ------
        GeometryError, InvalidValueError
            Shapes that do not match, times that are not finite or go back.
        """
        return self._run(readings, time, rest, state, backwards=True)

    def _run(
        self,
        readings: npt.ArrayLike,
        time: npt.ArrayLike,
        rest: npt.ArrayLike | None,
        state: RelaxationState | None,
        *,
        backwards: bool,
    ) -> Relaxed:
        data, clock, frames = stream(readings, time)
        n = frames.shape[1]
        share, constants = self._arrays(n)
        if state is None:
            rows = beginning(frames, rest, constants.size)
        else:
            rows = state.rows.copy()
            if rows.shape != (3 + constants.size, n):
                raise GeometryError(
                    f"a state of shape {rows.shape}", f"({3 + constants.size}, {n}) is needed"
                )
            last = np.nanmax(rows[1]) if np.isfinite(rows[1]).any() else -np.inf
            if clock.size and clock[0] < last:
                raise InvalidValueError(
                    f"time = {clock[0]:.6g} s", f"time must not go back (it was {last:.6g})"
                )
            # a sensor that has not been seen yet finds its rest in its first reading
            fresh = beginning(frames, rest, constants.size)
            rows[0] = np.where(np.isnan(rows[0]), fresh[0], rows[0])
        out = relaxed(frames, clock, share, constants, backwards, rows)
        rows.flags.writeable = False
        return Relaxed(_check.read_only(out.reshape(data.shape)), RelaxationState(rows))

    def _arrays(self, sensors: int) -> tuple[FloatArray, FloatArray]:
        share, constants = np.asarray(self.share), np.asarray(self.time)
        wide = share[:, None] if share.ndim == 1 else share
        if wide.shape[1] not in (1, sensors):
            raise GeometryError(
                f"share of shape {share.shape}",
                f"it belongs to {wide.shape[1]} sensors; the readings have {sensors}",
            )
        return np.ascontiguousarray(np.broadcast_to(wide, (len(wide), sensors))), constants


def stream(readings: npt.ArrayLike, time: npt.ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Readings, times (m,) and frames (m, n), checked."""
    data = _check.real("readings", readings, finite=False)
    seconds = _check.real("time", time, unit="s")
    if data.ndim not in (1, 2) or not data.shape[-1]:
        raise GeometryError(f"readings of shape {data.shape}", "one frame a row, one sensor a column")
    if seconds.shape != data.shape[:-1]:
        raise GeometryError(
            f"time of shape {seconds.shape}", f"one for each frame, {data.shape[:-1]}, is needed"
        )
    clock = seconds.reshape(-1)
    back = np.flatnonzero(np.diff(clock) < 0)
    if back.size:
        raise InvalidValueError(
            f"time[{back[0] + 1}] = {clock[back[0] + 1]:.6g} s",
            "time must not go back",
            "sort the frames by time",
        )
    return data, clock, data.reshape(-1, data.shape[-1])


def beginning(frames: FloatArray, rest: npt.ArrayLike | None, terms: int) -> FloatArray:
    """The state before the first frame, shape (3 + terms, n)."""
    n = frames.shape[1]
    rows = np.full((3 + terms, n), np.nan)
    if rest is None:
        seen = np.isfinite(frames)
        first = seen.argmax(axis=0) if len(frames) else np.zeros(n, dtype=np.intp)
        if len(frames):
            rows[0] = np.where(seen.any(axis=0), frames[first, np.arange(n)], np.nan)
    else:
        level = _check.real("rest", rest)
        if level.shape not in ((), (n,)):
            raise GeometryError(
                f"rest of shape {level.shape}", f"one value, or one for each of the {n} sensors, is needed"
            )
        rows[0] = level
    return rows


def relaxed(
    frames: FloatArray,
    clock: FloatArray,
    share: FloatArray,
    constants: FloatArray,
    backwards: bool,
    rows: FloatArray,
) -> FloatArray:
    """Frames (m, n) forwards or backwards through the series; `rows`, the state, changes in place."""
    from ._relaxation_kernel import relax

    out = np.empty(frames.shape)
    relax(frames, clock, share, constants, backwards, rows, out)
    return out
