"""The least separation of two points over count, depth and pitch of the sensors, and over their noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._declared import Real, checked
from ...array import SensorArray
from ...errors import InvalidValueError
from ...finger import Finger
from ...response import tabulate
from .._common import Found, listed, stretch
from ..touches import Touches
from .limen import Against, two_point_limen

__all__ = ["TwoPointStudy", "two_point_study"]

_PITCHES = (0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0, 1.25, 1.5, 2.0)


@dataclass(frozen=True, eq=False)
class TwoPointStudy(Found):
    """What `two_point_study` found. Arrays of shape (c, k, s, m): count, depth, pitch, noise.

    Attributes
    ----------
    finger : Finger
        Whose skin and kind of sensor it is.
    touches : Touches
    against : {"point", "wide"}
    count : ndarray of int, shape (c,)
        Numbers of sensors.
    depth : ndarray, shape (k,)
        Their depths [m].
    pitch : ndarray, shape (s,)
        Their pitches, in depths [-].
    noise : ndarray, shape (m,)
        Noise, as a share of the largest reading under one point of the whole force, square to the skin [-].
    worst, median : ndarray, shape (c, k, s, m)
        Least separation that reads as two, the worst and the median over the touches [m]; infinite where none does.
    """

    finger: Finger
    touches: Touches
    against: Against
    count: npt.NDArray[np.int_]
    depth: FloatArray
    pitch: FloatArray
    noise: FloatArray
    worst: FloatArray
    median: FloatArray

    @checked
    def best(self, slack: Annotated[float, Real(at_least=0.0)] = 0.25) -> FloatArray:
        """The best pitch, and the range around it that is nearly as good, in depths, shape (c, k, m, 3).

        Best pitch, least and largest of those pitches, without a gap, whose worst separation is larger by a share
        of `slack` at most; NaN where no pitch serves.
        """
        worst = np.moveaxis(self.worst, 2, -1)
        out = np.full((*worst.shape[:-1], 3), np.nan)
        for index in np.ndindex(worst.shape[:-1]):
            row = worst[index]
            at = int(np.argmin(row))
            if np.isfinite(row[at]):
                out[index] = self.pitch[[at, *stretch(row <= (1 + slack) * row[at], at)]]
        return out


@checked
def two_point_study(
    finger: Finger,
    touches: Touches,
    *,
    count: npt.ArrayLike = (3, 4, 5, 6, 8),
    pitch: npt.ArrayLike = _PITCHES,
    depth: npt.ArrayLike | None = None,
    noise: npt.ArrayLike = (1e-4, 1e-3, 1e-2),
    against: Against = "point",
    progress: Callable[[], object] | None = None,
    **options: Any,
) -> TwoPointStudy:
    """`two_point_limen` of even rows in one skin, over their count, depth and pitch, and over the noise.

    On a half plane lengths scale with the depth, and the noise counts as a share of the largest reading: one depth says
    all. Layers and a round finger have lengths of their own.

    Parameters
    ----------
    finger : Finger
        The skin; transducer, gain and width of the first sensor, and the middle of the row, are those of each row.
    touches : Touches
        As in `two_point_limen`. Without a span each row is tried from its own first sensor to its last.
    count : array_like of int, shape (c,), optional
        Numbers of sensors, >= 2.
    pitch : array_like, shape (s,), optional
        Pitches, ascending [depths].
    depth : array_like, shape (k,), optional
        Depths [m]; the mean of the finger's own if left out.
    noise : array_like, shape (m,), optional
        Noise as a share of the largest reading under one point of the whole force, square to the skin.
    against : {"point", "wide"}, optional
        The rival of two points.
    progress : callable, optional
        Called after each row.
    **options
        Others of `two_point_limen`.

    Raises
    ------
    InvalidValueError, GeometryError, NotLinearError
        As in `two_point_limen`; a count < 2.

    Examples
    --------
    >>> import subskin as ss
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray(y=[0.0], depth=2e-3))
    >>> touches = ss.design.Touches(force=20.0, span=(-2e-3, 2e-3))
    >>> study = ss.design.two_point_study(
    ...     finger, touches, count=6, pitch=[0.25, 0.5, 1.0, 2.0], noise=1e-3, shares=[0.5]
    ... )
    >>> (study.worst[0, 0, :, 0] * 1e3).round(2).tolist(), study.best()[0, 0, 0].tolist()
    ([0.41, 0.21, 0.4, 0.91], [0.5, 0.5, 0.5])
    """
    counts = listed("count", count, at_least=2.0)
    if not (counts == np.round(counts)).all():
        raise InvalidValueError(f"count = {count!r}", "whole numbers are needed", "count=(3, 4, 6)")
    ratios = listed("pitch", pitch, above=0.0)
    if not (np.diff(ratios) > 0).all():
        raise InvalidValueError(f"pitch = {pitch!r}", "has to ascend", "pitch=(0.25, 0.5, 1.0)")
    own = float(np.asarray(finger.array.depth).mean())
    depths = listed("depth", own if depth is None else depth, "m", above=0.0)
    shares = listed("noise", noise, above=0.0)
    worst = np.empty((counts.size, depths.size, ratios.size, shares.size))
    median = np.empty_like(worst)
    for k, at in enumerate(depths):
        full = touches.force * _largest(finger, float(at))
        for c, s in np.ndindex(counts.size, ratios.size):
            row = _row(finger, int(counts[c]), float(ratios[s] * at), float(at), full * float(shares[0]))
            found = two_point_limen(row, touches, against=against, **options)
            for m, share in enumerate(shares):
                there = found if m == 0 else found.with_noise(float(share / shares[0]))
                worst[c, k, s, m], median[c, k, s, m] = there.worst, there.median
            if progress is not None:
                progress()
    return TwoPointStudy(finger, touches, against, counts.astype(int), depths, ratios, shares, worst, median)


def _row(finger: Finger, count: int, pitch: float, depth: float, noise: float) -> Finger:
    """An even row of sensors like the finger's first, in its skin."""
    a = finger.array
    array = SensorArray.line(
        count, pitch, depth, centre=float(np.asarray(a.y).mean()), transducer=a.transducers[0],
        gain=np.asarray(a.gain)[0], width=np.asarray(a.width)[0], noise=noise,
    )  # fmt: skip
    return Finger(finger.skin, array)


def _largest(finger: Finger, depth: float) -> float:
    """Largest reading of such a sensor under a unit normal line load."""
    one = _row(finger, 1, 1.0, depth, 0.0)
    table = tabulate(one)
    positions = np.linspace(table.start, table.stop, 4 * len(table.coefficients) + 1)
    return float(np.abs(table(positions)[..., 0]).max())
