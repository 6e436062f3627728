"""Hands to compare with: one that squeezes, and two that know in simulation what no skin tells exactly."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import _check
from .._check import FloatArray
from ..finger import Finger
from .hand import Hand, HandCommand, Phase

__all__ = ["ConeHand", "FixedHand", "ForceHand"]


class ForceHand(Hand):
    """A hand that is told the true force and torsion on each pad, and learns friction as `Hand` does.

    It shows what errors of the readings cost. Parameters as of `Hand`.

    Examples
    --------
    >>> from subskin.grasp import ForceHand, pad_finger
    >>> ForceHand([pad_finger()] * 2).step([[0.0] * 4] * 2).phase.name
    'TARE'
    """

    sees_forces = True

    def _rest(self) -> list[FloatArray]:
        return [np.zeros(4) for _ in self.fingers]

    def warm_up(self) -> None:
        """Nothing has to be prepared."""

    def _felt(self) -> FloatArray:
        return np.asarray(np.array(self._smooth) / [1.0, 1.0, 1.0, self.arm])


class ConeHand(ForceHand):
    """A hand that is told the true forces, and the true coefficient of friction before it grips.

    Parameters
    ----------
    fingers, rate, **options
        As of `Hand`.

    Examples
    --------
    >>> from subskin.grasp import ConeHand, pad_finger
    >>> hand = ConeHand([pad_finger()] * 2)
    >>> hand.knows(0.5)
    >>> hand.friction
    0.5
    """

    _known = 0.0

    def knows(self, friction: float) -> None:
        """Tell the friction of what is lifted next.

        Parameters
        ----------
        friction : float
            Coulomb's coefficient [-], > 0.

        Raises
        ------
        InvalidValueError
            A value out of range.
        """
        self._known = self.friction = _check.scalar("friction", friction, above=0.0)

    def restart(self) -> None:
        """Forget everything but the friction."""
        super().restart()
        self.friction, self._slid = self._known, True


class FixedHand(Hand):
    """A hand that grips with one force, whatever it holds.

    Parameters
    ----------
    fingers, rate, **options
        As of `Hand`.
    grip : float
        [N]

    Examples
    --------
    >>> from subskin.grasp import FixedHand, pad_finger
    >>> FixedHand([pad_finger()] * 2, grip=9.2).grip
    9.2
    """

    def __init__(self, fingers: Sequence[Finger], rate: float = 500.0, *, grip: float, **options: Any) -> None:
        super().__init__(fingers, rate, **options)
        self.grip = _check.scalar("grip", grip, unit="N", above=0.0)

    def _decide(self, parts: FloatArray) -> HandCommand:
        if self.phase == Phase.LOAD:
            self._next(Phase.HOLD)
        command = super()._decide(parts)
        return command._replace(force=0.0 if self.phase == Phase.OPEN else self.grip)

    def _least(self, drag: float) -> float:
        return self.grip
