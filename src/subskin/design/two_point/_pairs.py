"""Two-point touches of one finger, and how far their readings are from those of any one contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...array import SensorArray
from ...contact import Hertz
from ...estimate import Locator
from ...finger import Finger
from ...response import Response, tabulate
from ..touches import Touches

_WIDER = 1.25
_MOST_WIDE = 4.0
"""Half width of a wide contact: up to that many of the largest separation, and at most that many depths."""


class Pairs:
    """Pairs of points over positions of the middle, shares of the lower one, and angles; as of `two_point_limen`.

    With `wide` the one contact that they might be taken for is Hertz's, of free width, and not a point.
    """

    def __init__(
        self,
        finger: Finger,
        touches: Touches,
        *,
        wide: bool,
        angle: str,
        positions: int,
        angles: int,
        share: FloatArray,
        largest: float,
    ) -> None:
        position, _ = touches.grid(positions, 1, finger)
        single = angle == "normal" or angles == 1
        # the ends of the cone among them, for it is there that two points are told worst
        cone = np.zeros(1) if single else touches.cone * np.linspace(-1.0, 1.0, angles)
        first, second = np.meshgrid(cone, cone, indexing="ij") if angle == "free" else (cone, cone)
        self.position, self.share = _check.read_only(position), _check.read_only(share)
        self.lean = _check.read_only(np.stack([first.ravel(), second.ravel()], axis=-1))
        self._force, self._known = touches.force, angle != "free"
        self._friction = 0.0 if self._known else touches.friction
        self._live, self._period = finger.array.live, finger.skin.period
        self.spare = int(self._live.sum()) - 2 - bool(self._friction) - wide
        low, high = touches.span_on(finger)
        self._table = tabulate(finger, _search(finger, low - 0.5 * largest, high + 0.5 * largest))
        if self.spare >= 0:
            live = finger.array.select(self._live)
            # fields are those of the transducers' linear parts, gain included, and there is no offset
            self._array = SensorArray(live.y, live.depth, noise=live.noise)
            widest = min(_WIDER * largest, _MOST_WIDE * float(np.asarray(finger.array.depth).min()))
            ends = self._table.start, self._table.stop
            self._rival = Response.of(finger, Hertz, ends, widest) if wide else self._table

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of positions, shares and pairs of angles."""
        return self.position.size, self.share.size, len(self.lean)

    def distance(self, separation: FloatArray, pairs: npt.NDArray[np.intp]) -> FloatArray:
        """Distance to the nearest one contact, of some pairs (k,) at separations (s, k) [m], shape (s, k).

        Pairs are numbered as `shape` is read. In standard deviations of the noise; 0 where there are fewer readings
        than unknowns, for then one contact explains them all.
        """
        out = np.zeros(separation.shape)
        if self.spare < 0:
            return out
        position, share, lean = np.unravel_index(pairs, self.shape)
        middle, part, angles = self.position[position], self.share[share, None], self.lean[lean]
        lower = self._line(middle - 0.5 * separation, angles[:, 0])
        upper = self._line(middle + 0.5 * separation, angles[:, 1])
        readings = self._force * (part * lower + (1 - part) * upper)
        for angle in np.unique(angles[:, 0]) if self._known else (0.0,):
            chosen = angles[:, 0] == angle if self._known else slice(None)
            # along a known angle, and square to it: what is normal to an estimator
            c, s = np.cos(angle), np.sin(angle)
            turned = self._rival.coefficients[..., self._live, :] @ np.array([[c, -s], [s, c]])
            locator = Locator(replace(self._rival, coefficients=turned), self._array, friction=self._friction)
            out[:, chosen] = np.sqrt(locator(readings[:, chosen]).residual)
        return out

    def _line(self, position: FloatArray, angle: FloatArray) -> FloatArray:
        """Readings of the live sensors under unit points at `position` and `angle`, broadcast to (..., n)."""
        start = self._table.start
        inside = start + (position - start) % self._period if np.isfinite(self._period) else position
        field = self._table(inside)[..., self._live, :]
        return np.asarray(np.cos(angle)[..., None] * field[..., 0] + np.sin(angle)[..., None] * field[..., 1])


def _search(finger: Finger, low: float, high: float) -> tuple[float, float] | None:
    """Where the one contact is looked for [m]: all around the points and the sensors, once round a finger."""
    usual = tabulate(finger)
    low, high = min(usual.start, low), max(usual.stop, high)
    if (low, high) == (usual.start, usual.stop):
        return None
    middle, half = 0.5 * (low + high), 0.5 * min(high - low, finger.skin.period)
    return middle - half, middle + half
