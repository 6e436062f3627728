"""Two-point touches of one finger, how far their readings are from any one contact's, and from where on far enough."""

from __future__ import annotations

from collections.abc import Callable
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

_CLOSER = 17
"""Separations in a closer look."""
_LOOKS = 3
"""Closer looks, each at the least of the one before."""

Look = Callable[[FloatArray, npt.NDArray[np.intp]], FloatArray]


class Pairs:
    """Pairs of points over positions of the middle, shares of the lower one, and angles; as in `two_point_limen`.

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
        at, which = np.unique(inside, return_inverse=True)  # pairs of all shares and angles lie at the same positions
        field = self._table(at)[:, self._live][which.reshape(inside.shape)]
        return np.asarray(np.cos(angle)[..., None] * field[..., 0] + np.sin(angle)[..., None] * field[..., 1])


def _search(finger: Finger, low: float, high: float) -> tuple[float, float] | None:
    """Where the one contact is looked for [m]: all around the points and the sensors, once round a finger."""
    usual = tabulate(finger)
    low, high = min(usual.start, low), max(usual.stop, high)
    if (low, high) == (usual.start, usual.stop):
        return None
    middle, half = 0.5 * (low + high), 0.5 * min(high - low, finger.skin.period)
    return middle - half, middle + half


def from_which_on(step: FloatArray, distance: FloatArray, needed: float, look: Look) -> FloatArray:
    """Separation beyond which every distance (s, k) is enough, shape (k,); infinite where the last is not.

    `look(separation (s, j), which (j,))` gives more distances. Two points that are told may be one's metamer again
    farther apart: the distance then falls to 0 and rises again, perhaps between two steps.
    """
    tiny = 1e-9 * needed
    # below the first step the distance goes on as a power of the separation
    ratio = np.log(step[1] / step[0])
    power = ratio / np.maximum(np.log(np.maximum(distance[1], tiny) / np.maximum(distance[0], tiny)), ratio)
    out = step[0] * np.minimum(needed / np.maximum(distance[0], needed), 1.0) ** power
    never = distance[-1] < needed
    out[never] = np.inf
    suspect = distance < needed
    suspect[1:-1] |= _dips(distance)
    left_over = np.flatnonzero(~never & suspect.any(axis=0))
    while left_over.size:
        last = step.size - 1 - np.argmax(suspect[::-1, left_over], axis=0)
        low, high = step[np.maximum(last - 1, 0)], step[last + 1]
        for _ in range(_LOOKS):
            closer = np.geomspace(low, high, _CLOSER)
            seen = np.maximum(look(closer, left_over), tiny)
            short = seen < needed
            found = short.any(axis=0)
            at = np.clip(np.argmin(seen, axis=0), 1, _CLOSER - 2)
            low = np.where(found, low, _at(closer, at - 1))
            high = np.where(found, high, _at(closer, at + 1))
            if found.all():
                break
        k = np.minimum(_CLOSER - 1 - np.argmax(short[::-1], axis=0), _CLOSER - 2)
        before, after, under, over = _at(closer, k), _at(closer, k + 1), _at(seen, k), _at(seen, k + 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            between = before * (after / before) ** (np.log(needed / under) / np.log(over / under))
        out[left_over[found]] = between[found]
        suspect[last, left_over] = False
        left_over = left_over[~found & suspect[:, left_over].any(axis=0)]
    return np.asarray(out)


def _dips(distance: FloatArray) -> npt.NDArray[np.bool_]:
    """Inner steps beside which the distance may go through 0: its square is about a parabola there."""
    left, here, right = distance[:-2] ** 2, distance[1:-1] ** 2, distance[2:] ** 2
    bend = left - 2 * here + right
    least = here - (right - left) ** 2 / np.where(bend > 0, 8 * bend, np.inf)
    return np.asarray((here <= left) & (here <= right) & (least < 0.5 * here))


def _at(values: FloatArray, index: npt.NDArray[np.intp]) -> FloatArray:
    """Of each column (s, k) the value of its own row (k,)."""
    return np.asarray(np.take_along_axis(values, index[None], axis=0)[0])
