"""What has lasted on a skin: is it a touch, or may the offsets be changed to it? Asked by `Tare`."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import chdtri

from .._check import FloatArray
from .._frozen import Frozen
from ..errors import SubskinError
from ..estimate.answer import Status
from ..estimate.locate import locator
from ..estimate.search import Locator
from ..finger import Finger
from ..response import tabulate
from . import _tare_kernel as kernel

__all__ = ["Held"]

_STILL = 1e-2  # chance with which noise alone makes a step that stays look as if it moved
_WRONG = 0.03  # of the largest departure: by so much the finger's model may be wrong in each
_REACH = 4.0  # depths beyond the row at which a touch is still thought of
_TOUCHES = (Status.OK, Status.AMBIGUOUS)
_ANY, _RUBBER = np.inf, 1.0  # cones of friction: any pressing load; one that a skin can have


class Held(Frozen):
    """Judges departures from the offsets that have lasted, by the finger's response.

    The response is tabulated once, over a wider range than a finger's own locator searches: by `prepare`, or by the
    first question, which a layered skin then answers 0.7 s late.

    Parameters
    ----------
    finger : Finger
        The forward model.
    own : ndarray, shape (n,)
        What a departure of 0 reads [reading]: the finger's offsets, or 0 where readings are differences.
    noise, drift : ndarray, shape (n,)
        Standard deviation of a reading [reading], and fastest drift [reading/s].
    patience : float
        Time between two questions [s].
    limits : ndarray, shape (n + 1,)
        Chi-square that noise exceeds with the chance `false_alarm`, by the number of sensors from 0.
    false_alarm : float
        As of `Tare`.
    """

    def __init__(
        self,
        finger: Finger,
        own: FloatArray,
        noise: FloatArray,
        drift: FloatArray,
        patience: float,
        limits: FloatArray,
        alarm: float,
    ) -> None:
        # departures have no range, and a touch that is doubtful is a touch all the same
        array = replace(finger.array, low=-np.inf, high=np.inf, noise=noise)
        self._finger, self._own = replace(finger, array=array, spread=None, trusted=True), own
        self._noise, self._drift, self._patience, self._limits, self._alarm = noise, drift, patience, limits, alarm

    def prepare(self) -> None:
        """Tabulate, and ask once, so that no question of a stream waits for either."""
        n = len(self._finger.array)
        away = np.where(self._finger.array.live, 50.0 * self._noise * (np.arange(n) % 2), np.nan)
        self._may_be_touch(away, np.zeros(n), self._noise**2)
        self._status(-away, self._noise, _RUBBER)

    def ask(self, rows: FloatArray, frozen: npt.NDArray[np.bool_]) -> None:
        """Is what has lasted a touch? If it cannot be, the offsets in `rows` are changed to what is read now."""
        array = self._finger.array
        noise = np.where(array.live, self._noise, 1.0)
        spread, count = rows[kernel.SPREAD], np.maximum(rows[kernel.COUNT], 1)
        told = array.live & (rows[kernel.COUNT] > 0) & ~frozen & np.isfinite(spread)
        spread = np.where(told, spread, 0.0)
        mean = rows[kernel.BASE] + rows[kernel.SUM] / count
        variance = noise**2 / count
        # what still moves is no offset: a touch that goes on, or rubber that comes back from one
        moved = np.where(told, mean - rows[kernel.HELD], 0.0)
        moved2 = moved**2 / (2 * variance + (self._drift * self._patience) ** 2)
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
        elif self._status(-away, np.hypot(noise, spread), _RUBBER) in _TOUCHES:
            taken = told
        else:
            return
        rows[kernel.OFFSET, taken] = mean[taken]
        rows[kernel.SPREAD, taken] = np.sqrt(variance)[taken]
        rows[kernel.HELD] = np.nan

    def _may_be_touch(self, away: FloatArray, spread: FloatArray, variance: FloatArray) -> bool:
        """Whether some pressing load, however it leans, makes these departures, by a model that is somewhat wrong."""
        wrong = _WRONG * float(np.nanmax(np.abs(away)))
        status = self._status(away, np.sqrt(self._noise**2 + spread**2 + wrong**2), _ANY)
        # too little for a touch by a single frame and the drift meanwhile: by the mean, and without?
        if status == Status.NO_CONTACT:
            status = self._status(away, np.sqrt(variance + wrong**2), _ANY)
        return status not in (Status.UNEXPLAINED, Status.NO_CONTACT)

    def _status(self, away: FloatArray, noise: FloatArray, friction: float) -> Status:
        """Of the load that departures from the offsets would have, each as uncertain as `noise` [reading]."""
        array = self._finger.array
        try:
            if array.on_area:
                # preparing for other noises takes a third of a second: departures are measured in those of the array
                told = np.isfinite(away)
                unit = np.sqrt(np.mean((noise[told] / self._noise[told]) ** 2))
                return _status_of(self._on_area[friction == _RUBBER], self._own + away / unit)
            table = tabulate(self._finger, self._ends)
        except SubskinError:  # no estimate can be made: anything may be a touch
            return Status.INCOMPLETE
        wide = replace(array, noise=np.maximum(noise, 1e-300))
        asked = Locator(table, wide, friction=friction, false_alarm=self._alarm)
        return _status_of(asked, self._own + away)

    @cached_property
    def _ends(self) -> tuple[float, float]:
        """Where a touch is thought of, on a row."""
        y = np.asarray(self._finger.array.y)
        reach = _REACH * float(np.asarray(self._finger.array.depth).max())
        middle, half = 0.5 * (y.min() + y.max()), 0.5 * np.ptp(y) + reach
        half = min(half, 0.5 * self._finger.skin.period)
        return float(middle - half), float(middle + half)

    @cached_property
    def _on_area(self) -> tuple[Any, Any]:
        """Locators on an area for any pressing load, and for those that rubber can have."""
        any_load, rubber = (locator(self._finger, friction=f, false_alarm=self._alarm) for f in (_ANY, _RUBBER))
        return any_load, rubber


def _status_of(asked: Any, frame: FloatArray) -> Status:
    return Status(int(asked(frame).status))
