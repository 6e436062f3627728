"""The one contact that two points might be taken for: how far its readings stay from theirs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..._check import FloatArray
from ...array import SensorArray
from ...contact import Hertz
from ...estimate import Locator
from ...finger import Finger
from ...response import Response, tabulate

__all__ = ["OneContact"]

_WIDER = 1.25
_MOST_WIDE = 4.0
"""Half width of a wide contact: up to that many of the largest separation, and at most that many depths."""


class OneContact:
    """The nearest single contact to given readings of one finger, searched globally.

    Parameters
    ----------
    finger : Finger
        With its noise.
    span : (float, float)
        Positions at which the two points may lie [m].
    wide : bool
        Whether the one contact is Hertz's, of free width, and not a point.
    friction : float or None
        The cone of its angles; None where its angle is known.
    largest : float
        Largest separation of the two points [m].
    """

    def __init__(
        self, finger: Finger, span: tuple[float, float], wide: bool, friction: float | None, largest: float
    ) -> None:
        self._finger, self._wide, self._friction = finger, wide, friction
        self._live = finger.array.live
        shallowest = float(np.asarray(finger.array.depth).min())
        self._widest = min(_WIDER * largest, _MOST_WIDE * shallowest)
        self._table = tabulate(finger, _search(finger, span))
        self.unknowns = 2 + bool(friction) + wide
        self.spare = int(self._live.sum()) - self.unknowns
        if self.spare >= 0:
            live = finger.array.select(self._live)
            # fields are those of the transducers' linear parts, gain included, and there is no offset
            self._array = SensorArray(live.y, live.depth, noise=live.noise)
            if wide:
                self._field = Response.of(finger, Hertz, (self._table.start, self._table.stop), self._widest)

    def line(self, position: FloatArray, angle: FloatArray) -> FloatArray:
        """Readings of the live sensors under unit points at `position` and `angle`, broadcast to (..., n)."""
        start, period = self._table.start, self._finger.skin.period
        inside = start + (position - start) % period if np.isfinite(period) else position
        field = self._table(inside)[..., self._live, :]
        return np.asarray(np.cos(angle)[..., None] * field[..., 0] + np.sin(angle)[..., None] * field[..., 1])

    def distance(self, readings: FloatArray, angle: float) -> FloatArray:
        """Distance of readings (..., n) to the nearest contact's, shape (...), in standard deviations of the noise.

        `angle` is that of the contact where it is known.
        """
        known = angle if self._friction is None else 0.0
        friction = self._friction or 0.0
        table = self._field if self._wide else self._table
        turned = replace(table, coefficients=self._turned(table.coefficients, known))
        return np.asarray(np.sqrt(Locator(turned, self._array, friction=friction)(readings).residual))

    def _turned(self, coefficients: FloatArray, angle: float) -> FloatArray:
        """Of the live sensors, for loads along `angle` [..., 0] and square to it: what is normal to an estimator."""
        c, s = np.cos(angle), np.sin(angle)
        return np.asarray(coefficients[..., self._live, :] @ np.array([[c, -s], [s, c]]))


def _search(finger: Finger, span: tuple[float, float]) -> tuple[float, float] | None:
    """Where the one contact is looked for [m]: all around the points and the sensors, once round a finger."""
    usual = tabulate(finger)
    low, high = min(usual.start, span[0]), max(usual.stop, span[1])
    if (low, high) == (usual.start, usual.stop):
        return None
    middle, half = 0.5 * (low + high), 0.5 * min(high - low, finger.skin.period)
    return middle - half, middle + half
