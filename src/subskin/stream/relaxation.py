"""Relaxation: what rubber forgets of a touch that is held, put into a stream or taken off it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Noun, Real, Whole, checked
from .._frozen import Frozen, Result
from ..errors import GeometryError
from .stage import Stage, check_state, in_order, join, some_of

__all__ = ["Relaxation", "RelaxationState", "Relaxing", "Undone"]


@dataclass(frozen=True, eq=False)
class RelaxationState(Result):
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

    @property
    def rest(self) -> FloatArray:
        """The readings at rest, shape (n,)."""
        return np.asarray(self.rows[0])


@dataclass(frozen=True, eq=False)
class Relaxation(Noun):
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
    doubt : array_like, shape () or (n,), optional
        How far what the terms take of a reading may be wrong [-]: its standard deviation over its size.

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

    share: Annotated[npt.ArrayLike, Real(at_least=0.0)]
    time: Annotated[npt.ArrayLike, Real("s", above=0.0)]
    rest: npt.ArrayLike | None = None
    doubt: Annotated[npt.ArrayLike, Real(at_least=0.0)] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        time, share, doubt = np.atleast_1d(self.time), np.atleast_1d(self.share), np.asarray(self.doubt)
        if time.ndim != 1 or share.ndim not in (1, 2) or len(share) != len(time):
            seen = f"share of shape {share.shape}, time of shape {time.shape}"
            raise GeometryError(seen, "one of each a term is needed", "share=[0.1], time=[1.5]")
        _check.real("share in all", share.sum(axis=0), at_most=0.999, fix="a skin keeps some of its stress")
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "share", share)
        if doubt.ndim > 1:
            raise GeometryError(f"doubt of shape {doubt.shape}", "one value, or one for each sensor, is needed", "0.1")

    @property
    def apply(self) -> Relaxing:
        """The stage that makes of an elastic skin's readings what this one would have read."""
        return Relaxing(self, backwards=False)

    @property
    def undo(self) -> Relaxing:
        """The stage that makes of the readings those of an elastic skin: of a touch that is held, constant ones."""
        return Relaxing(self, backwards=True)

    @property
    def undoing(self) -> Relaxing:
        """The stage that does what `undo` does, and says how far each reading is in doubt."""
        return Relaxing(self, backwards=True, doubted=True)

    @checked
    def of_sensors(self, count: Annotated[int, Whole(1, 10**9, "count=8")]) -> tuple[FloatArray, FloatArray]:
        """Shares (k, n) and doubts (n,) of so many sensors.

        Parameters
        ----------
        count : int
            How many sensors there are.

        Raises
        ------
        InvalidValueError, GeometryError
            What is no number of sensors; another number of them, or of readings at rest.
        """
        share = np.asarray(self.share)
        wide = share[:, None] if share.ndim == 1 else share
        given = (("share", wide.shape[1]), ("rest", np.asarray(self.rest).size), ("doubt", np.asarray(self.doubt).size))
        for name, size in given:
            if size not in (1, count):
                rule, fix = f"there are {count} sensors", "one value, or one for each sensor"
                raise GeometryError(f"{name} of {size} sensors", rule, fix)
        return np.broadcast_to(wide, (len(wide), count)), np.broadcast_to(np.asarray(self.doubt), count)


@dataclass(frozen=True, eq=False)
class Undone(Frozen):
    """Readings with their relaxation taken off, and how far that may be wrong.

    Parameters
    ----------
    readings : ndarray, shape (m, n)
        As an elastic skin would have read them [reading].
    doubt : ndarray, shape (m, n)
        Standard deviation of each, from what rubber forgets otherwise than the series says [reading].

    Examples
    --------
    >>> import numpy as np
    >>> second = Undone(readings=np.ones((2, 3)), doubt=np.zeros((2, 3)))
    >>> Undone.join([second, second]).readings.shape
    (4, 3)
    """

    readings: FloatArray
    doubt: FloatArray

    @classmethod
    def join(cls, parts: Sequence[Self]) -> Self:
        """Successive `parts` of one stream as one."""
        parts = some_of(parts, cls)
        return cls(*(join([getattr(part, name) for part in parts]) for name in ("readings", "doubt")))


@dataclass(frozen=True, eq=False)
class Relaxing(Stage[RelaxationState, Any]):
    """Relaxation put into a stream, or taken off it: `Relaxation.apply`, `Relaxation.undo` and `Relaxation.undoing`.

    Causal, frame by frame, and exact where the elastic reading changes linearly from each frame to the next. What comes
    out are readings of the same shape, NaN where one was not finite; where they are `doubted`, `Undone`. A reading's
    doubt is the series' `doubt` times what the terms make of it, sum of |share (u - h)|: h is what a term remembers. So
    it grows while a touch is held, is largest against the reading when the touch has gone, and fades with the slowest
    term.

    Parameters
    ----------
    relaxation : Relaxation
        How much, how fast, and how surely.
    backwards : bool
        Whether it is taken off.
    doubted : bool, optional
        Whether each reading gets a doubt.

    Examples
    --------
    >>> import numpy as np
    >>> rubber = Relaxation(share=[0.1], time=[2.0], doubt=0.3)
    >>> t = np.arange(0.0, 20.0, 0.1)
    >>> touch = np.where((t > 1.0) & (t < 11.0), 5.0, 0.0)[:, None]
    >>> out = rubber.undoing(rubber.apply(touch, t), t)
    >>> out.doubt[[5, 105, 112, -1], 0].round(2).tolist()  # before, held, after, long after
    [0.0, 0.15, 0.13, 0.0]
    """

    relaxation: Relaxation
    backwards: bool
    doubted: bool = False

    def resumed(self, state: RelaxationState | None) -> RelaxationState | None:
        """The state for a stream that begins anew: the readings at rest are kept; as `Stage.resumed`."""
        check_state(state, RelaxationState)
        if state is None:
            return None
        rows = np.full_like(state.rows, np.nan)
        rows[0] = state.rest
        rows.flags.writeable = False
        return RelaxationState(rows, np.nan)

    def step(
        self, state: RelaxationState | None, readings: npt.ArrayLike, time: npt.ArrayLike | None
    ) -> tuple[RelaxationState, Any]:
        """Take the next frames of a stream; as `Stage.step`."""
        from ._relaxation_kernel import MEMORY, relax  # here, so that whoever relaxes nothing need not load a compiler

        check_state(state, RelaxationState)
        data, clock = in_order(readings, time, np.nan if state is None else state.time)
        n, constants, rest = data.shape[-1], np.asarray(self.relaxation.time), self.relaxation.rest
        share, doubt = self.relaxation.of_sensors(n)
        if state is None:
            rows = np.full((MEMORY + constants.size, n), np.nan)
            rows[0] = np.nan if rest is None else rest
        else:
            rows = state.rows.copy()
        if rows.shape != (MEMORY + constants.size, n):
            rule, fix = f"({MEMORY + constants.size}, {n}) is needed", "a state of this stage, or None to start"
            raise GeometryError(f"a state of shape {rows.shape}", rule, fix)
        out, taken = np.empty(data.shape), np.empty(data.shape if self.doubted else (0, n))
        # views that are alike in memory, however the arrays came: the loop is compiled once
        given = (data.reshape(-1, n), clock.reshape(-1), share, constants[:])
        alike = _check.each_read_only(*map(np.ascontiguousarray, given))
        relax(*alike, self.backwards, rows, out.reshape(-1, n), taken.reshape(-1, n))
        rows.flags.writeable = out.flags.writeable = False
        last = float(clock[-1]) if clock.size else np.nan if state is None else state.time
        left = RelaxationState(rows, last)
        return left, Undone(out, _check.read_only(taken * doubt)) if self.doubted else out
