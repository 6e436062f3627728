"""Relaxation: what rubber forgets of a touch that is held, put into a stream or taken off it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..errors import GeometryError
from .stage import Stage, in_order

__all__ = ["Relaxation", "RelaxationState", "Relaxing"]


@dataclass(frozen=True, eq=False)
class RelaxationState(Frozen):
    """What is carried from one batch of a stream to the next, by `Relaxing.step`.

    Parameters
    ----------
    rows : ndarray, shape (3 + terms, n)
        Of each sensor its rest [reading], the time of its last reading [s], and what it remembers [reading].
    time : float
        Time of the last frame [s].
    """

    rows: FloatArray
    time: float


@dataclass(frozen=True, eq=False)
class Relaxation(Frozen):
    """How the reading of a touch that is held falls: 1 - sum of share (1 - exp(-t / time)), a Prony series.

    Parameters
    ----------
    share : array_like, shape (k,) or (k, n)
        Share of the reading that each term loses in the end, >= 0, less than 1 in all; of the whole skin, or of each
        sensor.
    time : array_like, shape (k,)
        Time constant of each term [s], > 0.
    rest : array_like, shape () or (n,), optional
        Readings of the untouched skin: a finger's offsets. The first reading of each sensor if left out. An offset that
        is wrong by d ends as d / (1 - sum of share): take drift off afterwards, not before (docs/robust.md).

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
    >>> felt = rubber.apply(held, t)
    >>> round(float(felt[-1, 0]), 3), bool(np.allclose(rubber.undo(felt, t), held))
    (1.7, True)
    """

    share: npt.ArrayLike
    time: npt.ArrayLike
    rest: npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        time = np.atleast_1d(_check.real("time", self.time, unit="s", above=0.0))
        share = np.atleast_1d(_check.real("share", self.share, at_least=0.0))
        if time.ndim != 1 or share.ndim not in (1, 2) or len(share) != len(time):
            raise GeometryError(
                f"share of shape {share.shape}, time of shape {time.shape}",
                "one of each a term is needed",
                "share=[0.1], time=[1.5]",
            )
        _check.real("share in all", share.sum(axis=0), at_most=0.999, fix="a skin keeps some of its stress")
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "share", share)
        if self.rest is not None:
            object.__setattr__(self, "rest", _check.real("rest", self.rest))

    @property
    def apply(self) -> Relaxing:
        """The stage that makes of an elastic skin's readings what this one would have read."""
        return Relaxing(self, backwards=False)

    @property
    def undo(self) -> Relaxing:
        """The stage that makes of the readings those of an elastic skin: of a touch that is held, constant ones."""
        return Relaxing(self, backwards=True)


@dataclass(frozen=True, eq=False)
class Relaxing(Stage[RelaxationState, FloatArray]):
    """Relaxation put into a stream, or taken off it: `Relaxation.apply` and `Relaxation.undo`.

    Causal, frame by frame, and exact where the elastic reading changes linearly from each frame to the next. What comes
    out are readings of the same shape, NaN where one was not finite.

    Parameters
    ----------
    relaxation : Relaxation
        How much, and how fast.
    backwards : bool
        Whether it is taken off.
    """

    relaxation: Relaxation
    backwards: bool

    def step(
        self, state: RelaxationState | None, readings: npt.ArrayLike, time: npt.ArrayLike | None
    ) -> tuple[RelaxationState, FloatArray]:
        """Take the next frames of a stream; as `Stage.step`."""
        from ._relaxation_kernel import relax  # here, so that whoever relaxes nothing need not load a compiler

        data, clock = in_order(readings, time, np.nan if state is None else state.time)
        n = data.shape[-1]
        share, constants = np.asarray(self.relaxation.share), np.asarray(self.relaxation.time)
        wide, rest = share[:, None] if share.ndim == 1 else share, self.relaxation.rest
        for name, size in (("share", wide.shape[1]), ("rest", np.asarray(rest).size)):
            if size not in (1, n):
                raise GeometryError(
                    f"{name} of {size} sensors", f"the readings have {n}", "one value, or one for each sensor"
                )
        if state is None:
            rows = np.full((3 + constants.size, n), np.nan)
            rows[0] = np.nan if rest is None else rest
        else:
            rows = state.rows.copy()
        if rows.shape != (3 + constants.size, n):
            raise GeometryError(
                f"a state of shape {rows.shape}",
                f"({3 + constants.size}, {n}) is needed",
                "a state of this stage, or None to start",
            )
        out = np.empty(data.shape)
        # views that are alike in memory, however the arrays came: the loop is compiled once
        given = (data.reshape(-1, n), clock.reshape(-1), np.broadcast_to(wide, (constants.size, n)), constants[:])
        alike = _check.each_read_only(*map(np.ascontiguousarray, given))
        relax(*alike, self.backwards, rows, out.reshape(-1, n))
        rows.flags.writeable = out.flags.writeable = False
        last = float(clock[-1]) if clock.size else np.nan if state is None else state.time
        return RelaxationState(rows, last), out

    def resumed(self, state: RelaxationState | None) -> RelaxationState | None:
        """The state for a stream that begins anew: the readings at rest are kept; as `Stage.resumed`."""
        from ._relaxation_kernel import REST

        if state is None:
            return None
        rows = np.full_like(state.rows, np.nan)
        rows[REST] = state.rows[REST]
        rows.flags.writeable = False
        return RelaxationState(rows, np.nan)
