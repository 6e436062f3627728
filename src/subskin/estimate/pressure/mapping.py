"""What a mapper of the pressure is told and keeps, along a row and on an area."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ... import _check
from ...errors import InvalidValueError
from ...finger import Finger
from ...prepared import Prepared
from ..frames import Framewise
from ._operator import Factors
from .columns import STATUS
from .prior import Prior

__all__ = ["RULES", "SHEARS", "SurfaceMapper", "free_only_where_seen", "known"]

RULES = ("evidence", "discrepancy", "gcv")
"""Rules for the weight of smoothness."""

SHEARS = ("none", "proportional", "free")
"""What the shear may be."""


class SurfaceMapper(Framewise):
    """A mapper of the pressure: its options.

    Parameters
    ----------
    finger : Finger
        The skin and the sensors in it.
    prior : Prior
        The smoothness of a traction of the elements.
    drags : int
        Directions of a drag: 1 along a row, 2 on an area.
    columns : int
        Of a row of the table of results.
    shear, friction, rule, least_force, false_alarm
        As in `PressureMapper`.
    """

    def __init__(
        self,
        finger: Finger,
        prior: Prior,
        *,
        drags: int,
        columns: int,
        shear: str,
        friction: float,
        rule: str,
        least_force: float,
        false_alarm: float,
    ) -> None:
        self.finger, self.shear, self.rule = finger, shear, rule
        self.friction = _check.scalar("friction", friction, above=0.0, fix='shear="none" for presses without a drag')
        self.least_force = _check.scalar("least_force", least_force, at_least=0.0)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        self._prior = prior
        super().__init__(finger.array, needed=3 + drags * (shear != "none"), columns=columns, status=STATUS)
        self._factors = Prepared(64)

    @abstractmethod
    def factors(self, used: npt.NDArray[np.bool_]) -> Sequence[Factors]:
        """The factors for the sensors `used` (n,), one for each drag at which they are known."""


def known(shear: str, rule: str) -> None:
    """Refuse a kind of shear or a rule of another name."""
    for name, value, names in (("shear", shear, SHEARS), ("rule", rule, RULES)):
        _check.choice(name, value, names)


def free_only_where_seen(seen: float, least: float, needed: str, other: str) -> None:
    """Refuse a free shear for sensors that see too little of it; needed: functions of what; other: sensors to take."""
    if not seen >= least:
        raise InvalidValueError(
            f'shear = "free" for sensors that see {seen:.2f} of the shear beside an unknown pressure',
            f"at least {least} is needed: sensors of one kind and depth read one function of {needed}",
            f'shear="proportional", or {other}',
        )
