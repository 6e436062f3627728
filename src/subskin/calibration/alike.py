"""Gains of sensors of one kind are alike: what is known of them before any touch."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from ..array import SensorArray

__all__ = ["AlikeGains"]

_ROUNDS = 3
"""Of the common gain, whose errors depend on it; they settle at once."""
_OWN = 3.0
"""Standard deviations off the others from which a gain is one of its own: a dead sensor, one wired the other way."""


class AlikeGains(Frozen):
    """The gains of a kind are its drawn ones times a common factor, each off by `error` [of itself].

    A normal distribution about a mean that nothing is known of: Gelman et al., Bayesian Data Analysis (2013), section
    5.4. A gain of which the touches say nothing has the mean; one of which they say all has what they say; and one that
    they show to be far from the others is none of them. Where `error` is infinite, or a kind has fewer than two
    sensors, nothing is known. Of no gain anything is known before `judged`.
    """

    def __init__(self, array: SensorArray, error: float, groups: tuple[npt.NDArray[np.intp], ...] = ()) -> None:
        self._array, self._error, self._groups = array, error, groups
        self._drawn = np.asarray(array.gain)

    def judged(self, gain: FloatArray, information: FloatArray) -> AlikeGains:
        """The same, of gains that are alike, where touches alone say `gain` (n,) with `information` (1/variance)."""
        groups, kinds = [], self._array.transducers
        for kind in {*kinds} if np.isfinite(self._error) else ():
            each = np.array([k == kind for k in kinds]) & (self._drawn != 0) & (information >= 0)
            known = np.where(each, information * self._drawn**2, 0.0)
            if not known.any():
                continue
            said = gain / np.where(each, self._drawn, 1.0)
            sure = known > 0
            middle = _median(said[sure], 1.0 / (self._error**2 + 1.0 / (known * said**2 + 1e-300))[sure])
            off = (said - middle) ** 2 * known  # of no information, anything is alike
            each &= off <= _OWN**2 * (1.0 + known * (self._error * middle) ** 2)
            if each.sum() > 1:
                groups.append(np.flatnonzero(each))
        return AlikeGains(self._array, self._error, tuple(groups))

    @property
    def known(self) -> npt.NDArray[np.bool_]:
        """Of which gains something is known, shape (n,)."""
        out = np.zeros(self._drawn.size, dtype=bool)
        for each in self._groups:
            out[each] = True
        return out

    def settled(self, gain: FloatArray, information: FloatArray) -> FloatArray:
        """Gains (n,) that are likeliest, where touches alone say `gain` with this `information` (1/variance)."""
        out = gain.copy()
        for each in self._groups:
            drawn = self._drawn[each]
            said, known = gain[each] / drawn, information[each] * drawn**2
            if not known.any():
                continue
            common = float(known @ said / known.sum())
            for _ in range(_ROUNDS):
                weight = known / (1.0 + known * (self._error * common) ** 2)
                common = float(weight @ said / weight.sum())
            own = known * (self._error * common) ** 2
            out[each] = drawn * (own * said + common) / (own + 1.0)
        return out

    def rest(self, gain: FloatArray) -> FloatArray:
        """How far gains (n,) are off their common one, in errors; one number for each gain of which this is known."""
        return np.asarray(self.slopes(gain) @ gain)

    def slopes(self, gain: FloatArray) -> FloatArray:
        """Change of `rest` with the gains, shape (known, n), at these."""
        rows: list[FloatArray] = [np.zeros((0, gain.size))]
        for each in self._groups:
            share: Any = np.zeros((each.size, gain.size))
            share[:, each] = (np.eye(each.size) - 1.0 / each.size) / self._drawn[each]
            common = abs(float(np.mean(gain[each] / self._drawn[each])))
            rows.append(share / max(self._error * common, 1e-300))
        return np.concatenate(rows)


def _median(values: FloatArray, weights: FloatArray) -> float:
    """The weighted median."""
    order = np.argsort(values)
    half = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(half, 0.5 * half[-1])])
