"""A hand that holds by what its skins tell: how hard to grip, from frames of readings alone."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..decide import Friction
from ..errors import GeometryError
from ..estimate import Resultant, ResultantReader
from ..finger import Finger
from ..prepared import prepared

__all__ = ["Hand", "HandCommand", "Phase"]

_TARE, _SETTLE, _SURE = 0.1, 0.06, 0.03
"""How long the untouched skin is averaged, the first grip settles, and a drag has to stay the same [s]."""
_SMOOTH, _SLOW = 0.006, 0.03
"""Time constants of what readings, and the ratio of drag to force, are averaged over [s]."""
_COMES, _GROWS, _SOME, _SLIPS = 0.01, 0.02, 0.1, 0.95
"""A drag still comes where it is above its average by so much [N], and by such a share of it; the ratio of drag to
force from which there is a drag; and share of the friction from which the thing slips."""
_GROWTH, _FADE = 0.1, 1.0
"""Time constants with which the grip grows while the load comes, and falls when less is needed [s]."""
_DELAY = 0.015
"""What passes until a grip has followed; the drag may grow meanwhile as it just did [s]."""
_PULL, _LIFT = 2e-3, 0.1
"""Speed of the arm until the thing is held, and from then on [m/s]."""
_UNSURE = 0.06
"""Standard deviation of the friction that was learnt, over itself: it scatters so over a surface."""
_LET_GO = 0.3
"""Share of the drag that is left where a table has taken over."""


class Phase(IntEnum):
    """What a hand is doing."""

    TARE = 0
    CLOSE = 1
    LOAD = 2
    HOLD = 3
    LOWER = 4
    OPEN = 5


class HandCommand(NamedTuple):
    """What the hand wants.

    Parameters
    ----------
    force : float
        Normal force of each finger [N].
    speed : float
        Speed of the arm upwards, at most [m/s].
    phase : Phase
        What it is doing.
    """

    force: float
    speed: float
    phase: Phase


class Hand:
    """Grips, lifts, holds and lets go of what it does not know, at the rate of its frames.

    It grips lightly, and pulls: at first the thing slips, and drag over normal force is Coulomb's coefficient. The grip
    grows until the drag no longer follows, so the thing is held, and from then on is the least that holds the drag of
    the moment, `decide.least_force`, with the friction learnt.

    Parameters
    ----------
    fingers : sequence of Finger
        One for each pad.
    rate : float, optional
        Frames a second [Hz].
    touch : float, optional
        Force of the first grip [N].
    strongest : float, optional
        Largest force [N].
    probability : float, optional
        Of slip, that each grip may leave; at most 0.5 [-].
    arm : float, optional
        A torsion M counts as a drag M / arm; about 3/4 of a pad's half side [m].

    Attributes
    ----------
    phase : Phase
        What it is doing.
    force : float
        What it asked for last [N].
    loads : list of Resultant
        What each pad feels, of the last frame.
    friction : float
        What was learnt of the coefficient [-]; 0 as long as nothing was.

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; a finger without a resultant (`estimate.ResultantReader`).

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=4e-3, depth=2.5e-3, noise=2e-4)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> hand = Hand([finger, finger])
    >>> hand.step([[0.0] * 16, [0.0] * 16])
    HandCommand(force=0.0, speed=0.0, phase=<Phase.TARE: 0>)
    """

    sees_forces = False
    """Whether it is given true forces instead of frames, in simulation (`ForceHand`)."""

    def __init__(
        self, fingers: Sequence[Finger], rate: float = 500.0, *, touch: float = 0.25, strongest: float = 20.0,
        probability: float = 1e-3, arm: float = 6e-3,
    ) -> None:  # fmt: skip
        self.fingers = tuple(fingers)
        self._readers = [
            prepared(finger).get(("resultant",), partial(ResultantReader, finger)) for finger in self.fingers
        ]
        self._period = 1.0 / _check.scalar("rate", rate, unit="Hz", above=0.0)
        self._touch = _check.scalar("touch", touch, unit="N", above=0.0)
        self._strongest = _check.scalar("strongest", strongest, unit="N", at_least=self._touch)
        self._probability = _check.scalar("probability", probability, above=0.0, at_most=0.5)
        self.arm = _check.scalar("arm", arm, unit="m", above=0.0)
        self.restart()

    def restart(self) -> None:
        """Forget everything: the next frame is the first."""
        self.phase, self.friction, self.force = Phase.TARE, 0.0, 0.0
        self.loads: list[Resultant] = []
        self._since, self._steady, self._peak = 0.0, 0.0, 0.0  # seconds in a phase, with a steady drag; largest drag
        self._ratio, self._drag, self._slow_drag = 0.0, 0.0, 0.0
        self._slid = False
        self._sum, self._smooth, self._last = [0.0 * rest for rest in self._rest()], self._rest(), self._rest()

    def warm_up(self) -> None:
        """Prepare what the first frame would wait for, for seconds."""
        for reader, rest in zip(self._readers, self._rest(), strict=True):
            reader(rest)

    def lower(self) -> None:
        """The arm goes down: let go when a table has taken the thing over; at once where nothing is held yet."""
        self._next(Phase.LOWER if self.phase == Phase.HOLD else Phase.OPEN)

    def step(self, readings: Sequence[npt.ArrayLike]) -> HandCommand:
        """The command that a frame asks for.

        Parameters
        ----------
        readings : sequence of array_like, shapes (n,)
            The frame of each finger [reading]; NaN, where a reading is missing, stands for the one before.

        Raises
        ------
        GeometryError
            Other than one frame for each finger.
        """
        if len(readings) != len(self.fingers):
            rule = f"one for each of {len(self.fingers)} fingers is needed"
            raise GeometryError(f"{len(readings)} frames", rule, "hand.step([left, right])")
        frames = [np.asarray(frame, dtype=np.float64) for frame in readings]
        frames = [np.where(np.isnan(each), last, each) for each, last in zip(frames, self._last, strict=True)]
        self._last = frames
        self._since += self._period
        if self.phase == Phase.TARE:
            self._sum = [total + frame for total, frame in zip(self._sum, frames, strict=True)]
            if self._since >= _TARE:
                count = round(self._since / self._period)
                self._sum = [total / count - rest for total, rest in zip(self._sum, self._rest(), strict=True)]
                self._smooth = [frame - rest for frame, rest in zip(frames, self._sum, strict=True)]
                self._next(Phase.CLOSE)
            return HandCommand(0.0, 0.0, self.phase)
        share = self._period / (_SMOOTH + self._period)
        for i, (frame, rest) in enumerate(zip(frames, self._sum, strict=True)):
            self._smooth[i] = self._smooth[i] + share * (frame - rest - self._smooth[i])
        return self._decide(self._felt())

    def _rest(self) -> list[FloatArray]:
        """Frames of an untouched skin, as the fingers have it."""
        return [np.broadcast_to(finger.array.offset, len(finger.array)) for finger in self.fingers]

    def _felt(self) -> FloatArray:
        """What each pad feels of the smoothed frames: N, Ty, Tz and torsion over its arm, shape (pads, 4) [N]."""
        self.loads = [reader(frame) for reader, frame in zip(self._readers, self._smooth, strict=True)]
        return np.asarray(np.nan_to_num([(*load.components, load.torsion / self.arm) for load in self.loads]))

    def _decide(self, parts: FloatArray) -> HandCommand:
        """From the loads of the pads to a command."""
        normal, drag = parts[:, 0].mean(), np.sqrt((parts[:, 1:] ** 2).sum(axis=1)).mean()
        felt = bool((parts[:, 0] > 0.5 * self._touch).all())
        ratio = drag / normal if felt else 0.0
        self._ratio += self._period / (_SLOW + self._period) * (ratio - self._ratio)
        rise = max((drag - self._drag) / self._period * _DELAY, 0.0)
        self._drag = drag
        self._slow_drag += self._period / (_SLOW + self._period) * (drag - self._slow_drag)
        speed = 0.0
        if self.phase == Phase.CLOSE:
            self.force = self._touch
            if not felt:
                self._since = 0.0
            elif self._since >= _SETTLE:
                self._next(Phase.LOAD)
        elif self.phase == Phase.LOAD:
            speed = _PULL
            self.friction = max(self.friction, self._ratio)
            comes = drag > self._slow_drag + _COMES + _GROWS * drag
            self._steady = 0.0 if comes else self._steady + self._period
            self._slid |= self._steady >= _SURE and self._ratio > _SOME
            if self._slid:
                if not comes or self._ratio > _SLIPS * self.friction:  # it slips, or is held: the next frames tell
                    self.force = min(self.force * np.exp(self._period / _GROWTH), self._strongest)
                if self._steady >= _SURE and normal >= self._least(drag):
                    self._next(Phase.HOLD)
        elif self.phase in (Phase.HOLD, Phase.LOWER):
            speed = _LIFT if self.phase == Phase.HOLD else -_LIFT
            least = self._least(drag + rise)
            self.force = float(
                np.clip(max(least, self.force * np.exp(-self._period / _FADE)), self._touch, self._strongest)
            )
            self._peak = max(self._peak, drag)
            if self.phase == Phase.LOWER and drag < _LET_GO * self._peak:
                self._next(Phase.OPEN)
        elif self.phase == Phase.OPEN:
            self.force = 0.0
        return HandCommand(float(self.force), speed, self.phase)

    def _least(self, drag: float) -> float:
        """The least force that holds a drag, with the probability that is asked for [N]."""
        learnt = Friction.normal(self.friction, _UNSURE * self.friction)
        return drag / float(learnt.quantile(self._probability))

    def _next(self, phase: Phase) -> None:
        self.phase, self._since, self._steady, self._peak = phase, 0.0, 0.0, 0.0
