"""The least separation at which two points do not read like one contact (memo section 7)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Length, Positive, checked
from ...array import SensorArray
from ...contact import Hertz
from ...errors import InvalidValueError
from ...estimate import Locator
from ...finger import Finger
from ...response import Response, tabulate
from .._common import Count, Found, listed
from ..touches import Touches

__all__ = ["Against", "Angle", "Test", "TwoPointLimen", "two_point_limen"]

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
        self.position, self.share = position, share
        self.lean = np.stack([first.ravel(), second.ravel()], axis=-1)
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


Against = Literal["point", "wide"]
Angle = Literal["normal", "known", "free"]
Test = Literal["fit", "best"]

_SHARES = (0.3, 0.4, 0.5, 0.6, 0.7)
_RATIO = 1.14
"""Of a separation tried to the one before."""
_LEAST = {"point": 1 / 500, "wide": 1 / 50}
"""Least separation tried, of the largest: a wide contact reads as two at larger ones."""
_LARGEST = 2.0
"""Largest separation tried, in depths."""


@dataclass(frozen=True, eq=False)
class TwoPointLimen(Found):
    """What `two_point_limen` found. Arrays of shape (p, q, l): middle of the points, split of the force, their angles.

    Attributes
    ----------
    finger : Finger
    touches : Touches
    against : {"point", "wide"}
    angle : {"normal", "known", "free"}
    test : {"fit", "best"}
    power, false_alarm : float
        Probabilities with which two points are found, and one contact is taken for two.
    needed : float
        Distance at which that is so [standard deviations].
    position : ndarray, shape (p,)
        Middles between the two points [m].
    share : ndarray, shape (q,)
        Share of the force that the point at lower y carries.
    lean : ndarray, shape (l, 2)
        Angles of the two points [rad], the one at lower y first.
    step : ndarray, shape (s,)
        Separations tried [m], ascending.
    distance : ndarray, shape (s, p, q, l)
        Between the readings of the two points and those of the one contact that comes nearest: root of the sum of
        squares, in standard deviations of the noise.
    separation : ndarray, shape (p, q, l)
        Separation from which on two points read as two [m], as at each larger one up to the last tried. Infinite where
        that is not.
    """

    finger: Finger
    touches: Touches
    against: Against
    angle: Angle
    test: Test
    power: float
    false_alarm: float
    needed: float
    position: FloatArray
    share: FloatArray
    lean: FloatArray
    step: FloatArray
    distance: FloatArray
    separation: FloatArray
    _pairs: Pairs = field(repr=False)
    _scale: float = field(default=1.0, repr=False)

    @property
    def worst(self) -> float:
        """The largest of `separation` [m]; infinite where two points somewhere always read as one."""
        return float(self.separation.max())

    @property
    def median(self) -> float:
        """The median of `separation` [m]."""
        return float(np.median(self.separation))

    @checked
    def with_noise(self, factor: Positive) -> TwoPointLimen:
        """The same with the noise of all sensors times a `factor` > 0: distances are in proportion to 1 / noise."""
        array = replace(self.finger.array, noise=factor * np.asarray(self.finger.array.noise))
        # in units of the noise that the pairs were made with
        distance = self._scale * self.distance.reshape(self.step.size, -1)
        told = from_which_on(self.step, distance, self._scale * factor * self.needed, self._pairs.distance)
        return replace(
            self,
            finger=replace(self.finger, array=array),
            distance=self.distance / factor,
            separation=told.reshape(self.separation.shape),
            _scale=self._scale * factor,
        )

    def summary(self) -> str:
        """The answer in a line."""
        one = {"point": "one point", "wide": "one wide contact"}[self.against]
        largest = f"{self.step[-1] * 1e3:.3g} mm"
        told = self.separation
        if np.isfinite(told).all():
            text = f"read as two from {self.worst * 1e3:.3g} mm on at worst, {self.median * 1e3:.3g} mm at half of them"
        else:
            text = f"read as one within {largest} in {np.isinf(told).mean():.0%} of touches"
        return f"two points against {one}, angle {self.angle}: {text}"


@checked
def two_point_limen(
    finger: Finger,
    touches: Touches,
    *,
    against: Against = "point",
    angle: Angle = "normal",
    power: float = 0.9,
    false_alarm: float = 0.01,
    test: Test = "fit",
    positions: Count = 17,
    shares: npt.ArrayLike = _SHARES,
    angles: Count = 3,
    largest: Length | None = None,
) -> TwoPointLimen:
    """How far apart two points have to be not to read like one contact.

    The readings of two points, free of noise, are fitted with one contact: its forces are eliminated exactly, its
    position, and width, searched globally (`Locator`). What is left, D in standard deviations of the noise, is
    what any test has to go by. "fit" is the test that `Finger.locate` and `Finger.fit` make: the residual of noisy
    readings against chi-square, non-central with D^2 under two points. It asks nothing about what else it might be.
    "best" is the Neyman-Pearson test between just these two points and just that contact: no test of any kind needs
    less than its D, the sum of the two normal quantiles. `TwoPointLimen.worst` is the one number. Source: memo section
    7; docs/two_points.md.

    Parameters
    ----------
    finger : Finger
        With the noise of its sensors. With fewer sensors than the one contact has unknowns nothing reads as two.
    touches : Touches
        `force` is that of both points together [N/m], `span` the positions of their middle, `friction` the cone of
        angles where these are not normal.
    against : {"point", "wide"}, optional
        One point, or one Hertz contact of any half width up to 1.25 times the largest separation, and 4 depths. Its
        table is good to some 5e-6 of the largest reading, so at a noise below 1e-5 of it distances are not exact.
    angle : {"normal", "known", "free"}, optional
        All loads are normal, and that is known; all are at one known angle; or the two points have angles of their own,
        and the one contact any in the cone. Unknowns of one point: 2, 2, 3; of a wide contact, one more.
    power, false_alarm : float, optional
        Probability to find two points, and to take one contact for two.
    test : {"fit", "best"}, optional
        Which test.
    positions : int, optional
        Number of positions of the middle.
    shares : array_like, shape (q,), optional
        Share of the force carried by the point at lower y, between 0 and 1.
    angles : int, optional
        Number of angles in the cone, its ends among them, for "known" and "free"; of each point, for the latter.
    largest : float, optional
        Largest separation tried [m]; two depths of the shallowest sensor if left out.

    Raises
    ------
    InvalidValueError
        Sensors without noise, an option out of range.
    GeometryError
        Touches without a span on a finger with sensors at one position.
    NotLinearError
        A transducer with no linear part.

    Examples
    --------
    Eight sensors, three quarters of a depth apart, their noise about a thousandth of the strain beneath the touch:

    >>> import subskin as ss
    >>> row = ss.SensorArray.line(count=8, pitch=1.5e-3, depth=2e-3, noise=1e-5)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), row)
    >>> touches = ss.design.Touches(force=20.0)
    >>> for rival in ("point", "wide"):
    ...     print(ss.design.two_point_limen(finger, touches, against=rival).summary())
    two points against one point, angle normal: read as two from 0.736 mm on at worst, 0.248 mm at half of them
    two points against one wide contact, angle normal: read as two from 2.69 mm on at worst, 1.02 mm at half of them
    """
    share = listed("shares", shares, above=0.0)
    if not (share < 1).all():
        raise InvalidValueError(f"shares = {shares!r}", "shares between 0 and 1 are needed", "shares=[0.5]")
    shallowest = float(np.asarray(finger.array.depth).min())
    far = _LARGEST * shallowest if largest is None else largest
    wide = against == "wide"
    pairs = Pairs(finger, touches, wide=wide, angle=angle, positions=positions, angles=angles, share=share, largest=far)
    needed = distance_needed(pairs.spare, power, false_alarm, test)
    least = _LEAST[against]
    step = np.geomspace(least * far, far, int(np.ceil(np.log(1 / least) / np.log(_RATIO))) + 1)
    everyone = np.arange(np.prod(pairs.shape))
    distance = pairs.distance(np.broadcast_to(step[:, None], (step.size, everyone.size)), everyone)
    separation = from_which_on(step, distance, needed, pairs.distance)
    return TwoPointLimen(
        finger, touches, against, angle, test, float(power), float(false_alarm), needed,
        pairs.position, pairs.share, pairs.lean, step, distance.reshape(step.size, *pairs.shape),
        separation.reshape(pairs.shape), pairs,
    )  # fmt: skip


def distance_needed(spare: int, power: float, false_alarm: float, test: Test) -> float:
    """Distance at which two points are found with probability `power`."""
    from scipy.special import chdtri, chndtrinc, ndtri

    chance = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
    found = _check.scalar("power", power, above=chance, at_most=1 - 1e-9)
    if test == "best":
        return float(ndtri(found) - ndtri(chance))
    # no reading to spare: only the bounds of what one contact may be leave a residual, of one degree
    degrees = max(spare, 1)
    return float(np.sqrt(chndtrinc(chdtri(degrees, chance), degrees, 1 - found)))
