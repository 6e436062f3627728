"""The least separation at which two points do not read like one contact (memo section 7)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._frozen import Result
from ...errors import InvalidValueError
from ...finger import Finger, finger_needed
from .._common import whole
from ..touches import Touches
from ._pairs import Pairs, from_which_on

__all__ = ["Against", "Angle", "Test", "TwoPointLimen", "two_point_limen"]

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
class TwoPointLimen(Result):
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

    def with_noise(self, factor: float) -> TwoPointLimen:
        """The same with the noise of all sensors times a `factor` > 0: distances are in proportion to 1 / noise."""
        ratio = _check.scalar("factor", factor, above=0.0)
        array = replace(self.finger.array, noise=ratio * np.asarray(self.finger.array.noise))
        # in units of the noise that the pairs were made with
        distance = self._scale * self.distance.reshape(self.step.size, -1)
        told = from_which_on(self.step, distance, self._scale * ratio * self.needed, self._pairs.distance)
        return replace(
            self,
            finger=replace(self.finger, array=array),
            distance=_check.read_only(self.distance / ratio),
            separation=_check.read_only(told.reshape(self.separation.shape)),
            _scale=self._scale * ratio,
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


def two_point_limen(
    finger: Finger,
    touches: Touches,
    *,
    against: Against = "point",
    angle: Angle = "normal",
    power: float = 0.9,
    false_alarm: float = 0.01,
    test: Test = "fit",
    positions: int = 17,
    shares: npt.ArrayLike = _SHARES,
    angles: int = 3,
    largest: float | None = None,
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
    finger_needed(finger)
    _check.noun("touches", touches, Touches, "design.Touches(force=20.0)")
    for name, value, known in (("against", against, Against), ("angle", angle, Angle), ("test", test, Test)):
        _check.choice(name, value, get_args(known))
    share = np.atleast_1d(_check.real("shares", shares, above=0.0))
    if share.ndim != 1 or not (share < 1).all():
        raise InvalidValueError(f"shares = {shares!r}", "shares between 0 and 1 are needed", "shares=[0.5]")
    shallowest = float(np.asarray(finger.array.depth).min())
    far = _LARGEST * shallowest if largest is None else _check.scalar("largest", largest, unit="m", above=0.0)
    pairs = Pairs(
        finger, touches, wide=against == "wide", angle=angle, positions=whole("positions", positions),
        angles=whole("angles", angles), share=share, largest=far,
    )  # fmt: skip
    needed = _needed(pairs.spare, power, false_alarm, test)
    least = _LEAST[against]
    step = np.geomspace(least * far, far, int(np.ceil(np.log(1 / least) / np.log(_RATIO))) + 1)
    everyone = np.arange(np.prod(pairs.shape))
    distance = pairs.distance(np.broadcast_to(step[:, None], (step.size, everyone.size)), everyone)
    separation = from_which_on(step, distance, needed, pairs.distance)
    return TwoPointLimen(
        finger, touches, against, angle, test, float(power), float(false_alarm), needed,
        pairs.position, pairs.share, pairs.lean, _check.read_only(step),
        _check.read_only(distance.reshape(step.size, *pairs.shape)),
        _check.read_only(separation.reshape(pairs.shape)), pairs,
    )  # fmt: skip


def _needed(spare: int, power: float, false_alarm: float, test: Test) -> float:
    """Distance at which two points are found with probability `power`."""
    from scipy.special import chdtri, chndtrinc, ndtri

    chance = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
    found = _check.scalar("power", power, above=chance, at_most=1 - 1e-9)
    if test == "best":
        return float(ndtri(found) - ndtri(chance))
    # no reading to spare: only the bounds of what one contact may be leave a residual, of one degree
    degrees = max(spare, 1)
    return float(np.sqrt(chndtrinc(chdtri(degrees, chance), degrees, 1 - found)))
