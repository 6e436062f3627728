"""What a mapper of the pressure is told and keeps, along a row and on an area."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...errors import InvalidValueError
from ...finger import Finger
from ...prepared import Prepared
from ..frames import Framewise
from ._operator import Factors, shear_seen
from .columns import STATUS
from .prior import Prior

__all__ = ["RULES", "SHEARS", "SurfaceMapper"]

RULES = ("evidence", "discrepancy", "gcv")
"""Rules for the weight of smoothness."""

SHEARS = ("none", "proportional", "free")
"""What the shear may be."""

_LEAST_SEEN = (0.2, 0.3)
"""By the number of drags. On an area an array that saw 0.21 gave images that left their band (docs/pressure.md)."""


class SurfaceMapper(Framewise):
    """A mapper of the pressure: its options, and what the sensors read of each element of the surface.

    Parameters
    ----------
    finger : Finger
        The skin and the sensors in it.
    reading : ndarray, shape (m, n, d + 1)
        Reading per Pa of the pressure and of each of the d drags, of each element.
    prior : Prior
        The smoothness of a traction of these elements.
    blocks : int
        Unknowns >= 0 of an element: 1, and 2 d where the shear is free.
    columns : int
        Of a row of the table of results.
    shear, friction, rule, least_force, false_alarm
        As in `PressureMapper`.
    """

    def __init__(
        self,
        finger: Finger,
        reading: FloatArray,
        prior: Prior,
        *,
        blocks: int,
        columns: int,
        shear: str,
        friction: float,
        rule: str,
        least_force: float,
        false_alarm: float,
    ) -> None:
        self.finger, self.shear, self.rule = finger, shear, rule
        self.friction = _check.scalar("friction", friction, above=0.0)
        self.least_force = _check.scalar("least_force", least_force, at_least=0.0)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        self._reading, self._prior, self._blocks = reading, prior, blocks
        d = reading.shape[-1] - 1
        super().__init__(finger.array, needed=3 + d * (shear != "none"), columns=columns, status=STATUS)
        normal, *drags = self._columns_of(finger.array.live)
        self.shear_seen = shear_seen(normal, drags, prior)
        if shear == "free" and not self.shear_seen >= _LEAST_SEEN[d - 1]:
            one = "one function of y, not two" if d == 1 else "one function of (y, z), not three"
            raise InvalidValueError(
                f'shear = "free" for sensors that see {self.shear_seen:.2f} of the shear beside an unknown pressure',
                f"at least {_LEAST_SEEN[d - 1]} is needed: sensors of one kind and depth read {one}",
                'shear="proportional", or sensors of another kind or depth as well',
            )
        self._factors = Prepared(64)

    @abstractmethod
    def factors(self, used: npt.NDArray[np.bool_]) -> Sequence[Factors]:
        """The factors for the sensors `used` (n,), one for each drag at which they are known."""

    def _columns_of(self, used: npt.NDArray[np.bool_]) -> FloatArray:
        """Whitened readings per Pa of the used sensors, of the pressure and of each drag, (d + 1, m, n)."""
        part = self._reading[:, used] / np.asarray(self.finger.array.noise)[used, None]
        return np.ascontiguousarray(np.moveaxis(part, -1, 0))


def known(shear: str, rule: str) -> None:
    """Refuse a kind of shear or a rule of another name."""
    for name, value, names in (("shear", shear, SHEARS), ("rule", rule, RULES)):
        if value not in names:
            raise InvalidValueError(
                f"{name} = {value!r}", f"has to be one of {', '.join(names)}", f'{name}="{names[0]}"'
            )
