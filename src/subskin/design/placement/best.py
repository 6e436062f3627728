"""The sensors of a row moved to free positions, to see whether that pays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._declared import Real, checked
from ...array import SensorArray
from ...errors import InvalidValueError
from ...finger import Finger
from .._common import Count, Seed, noise_of
from ..touches import Touches
from ._field import OneSensor
from .asked import AMBIGUITY, MARGIN, PLACEMENT_MEASURES, AskedTouches, Margin, check_count, searched
from .layout import Channel
from .study import PlacementQuality, placement_quality

__all__ = ["BestPositions", "best_positions"]


_ROUGH = (61, 21)
_STARTS = 4


@dataclass(frozen=True, eq=False)
class BestPositions:
    """What `best_positions` found.

    Attributes
    ----------
    finger : Finger
        With its sensors at the best positions.
    measure : str
        What they are best at.
    before, after : PlacementQuality
        Quality of the finger as given, and of this finger.
    gain : float
        How many times smaller the measure has become; for `log_det`, by how much larger.
    tried : int
        Placements looked at.
    """

    finger: Finger
    measure: str
    before: PlacementQuality
    after: PlacementQuality
    gain: float
    tried: int


@checked
def best_positions(
    finger: Finger,
    touches: Touches,
    measure: str = "position_worst",
    *,
    ambiguous: Annotated[float, Real(at_least=0.0)] = 0.01,
    gap: float | None = None,
    symmetric: bool = True,
    rng: Seed = 0,
    tries: Count = 1500,
    grid: tuple[int, int] = _ROUGH,
    margin: Margin = MARGIN,
    ambiguity: float = AMBIGUITY,
) -> BestPositions:
    """Moves the sensors of a finger along the row until one measure is least and few touches are ambiguous.

    Nelder and Mead's search, from the positions given and from positions jittered about them. It is local: a
    better position far from all starts is not found. What is found is never worse than the finger given.

    Parameters
    ----------
    finger : Finger
        With equal sensors, at their positions to begin with: those of the best even row.
    touches : Touches
        With a span, or the finger's own row is the span, whatever becomes of it.
    measure : str, optional
        One of `PLACEMENT_MEASURES`; the least is best, of `log_det` the largest. A `worst` that is infinite, as with
        three sensors, cannot be improved: take the `95`.
    ambiguous : float, optional
        Largest share of touches that may be ambiguous or unfelt; or the finger's own, if that is more.
    gap : float, optional
        Least distance of neighbours [m]; the sensors' width, or a tenth of their depth if that is more.
    symmetric : bool, optional
        Whether the positions mirror each other about the middle of the span.
    rng : Generator or int, optional
        Random generator of the jitter, or its seed.
    tries : int, optional
        Placements to look at, about.
    grid, margin, ambiguity
        As in `placement_quality`; the search itself looks at this grid.

    Raises
    ------
    InvalidValueError
        Sensors that are not alike, have no noise, or are nearer than `gap`; an unknown measure; a measure that is
        infinite to begin with.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.2e-3, depth=2e-3, noise=5e-5))
    >>> found = ss.design.best_positions(finger, ss.design.Touches(40.0, span=(-4e-3, 4e-3)), tries=200)
    >>> found.gain > 10, np.round(1e3 * found.finger.array.y[-1], 1).tolist()
    (True, 4.6)
    """
    _check.choice("measure", measure, PLACEMENT_MEASURES, 'measure="position_worst"')
    array = _alike(finger)
    check_count(len(array), touches)
    span = touches.span_on(finger)
    own = replace(touches, span=span)
    middle = 0.5 * (span[0] + span[1])
    depth, width, noise, unit = (float(np.asarray(v)[0]) for v in (array.depth, array.width, array.noise, array.gain))
    least = max(width, 0.1 * depth) if gap is None else _check.scalar("gap", gap, unit="m", at_least=width)
    start = np.sort(np.asarray(array.y))
    closest = float(np.diff(start).min())
    if closest < least * (1 - 1e-9):
        seen, fix = f"sensors {closest:.6g} m apart", "begin with a row that keeps the gap"
        raise InvalidValueError(seen, f"gap = {least:.6g} m is more", fix)
    asked, box = AskedTouches.of(own, grid, None, 0, ambiguity, draws=False), np.array([span])
    before = placement_quality(finger, own, margin=margin, ambiguity=ambiguity)
    if not np.isfinite(before[measure]):
        rule = "what is infinite cannot be improved"
        raise InvalidValueError(f"{measure} = {before[measure]}", rule, 'measure="position_95"')
    allowed = max(ambiguous, before["ambiguous"] + before["unfelt"])
    # as far as sensors may come, half the span and two depths beyond it
    most = max(0.5 * (span[1] - span[0]) + 2 * depth, float(np.abs(start - middle).max()))
    kind = Channel(array.transducers[0], abs(noise / unit), width)
    which = np.zeros(len(array), dtype=np.intp)
    one = OneSensor(finger.skin, kind, depth, 2 * most + margin * depth)
    tried = 0

    def cost(y: FloatArray) -> float:
        nonlocal tried
        tried += 1
        outside = float(np.maximum(np.abs(y - middle) - most, 0.0).sum()) / depth
        tight = float(np.maximum(least - np.diff(y), 0.0).sum()) / depth
        if outside > 0 or tight > 1e-12 or y[-1] - y[0] + least > finger.skin.period:
            return 1e3 * (1 + outside + tight)
        points = y[:, None]
        field = one.moved(points, which, searched(points, depth, finger.skin, own, margin))
        values = field.judged(asked, box, maps=True).values
        size = -values["log_det"] if measure == "log_det" else float(np.log(max(values[measure], 1e-300)))
        excess = max(values["ambiguous"] + values["unfelt"] - allowed, 0.0)
        return min(size, 1e2) + (1e2 * excess + 0.1 if excess > 0 else 0.0)

    best = _searched(cost, start, middle, symmetric, 0.25 * depth, _check.random(rng), tries)
    moved = Finger(finger.skin, replace(array, y=best))
    after = placement_quality(moved, own, margin=margin, ambiguity=ambiguity)
    if measure == "log_det":
        gain, none = after[measure] - before[measure], 0.0
    else:
        gain, none = before[measure] / after[measure] if after[measure] > 0 else 1.0, 1.0
    if gain < none:  # finer, the grid tells the other way
        moved, after, gain = finger, before, none
    return BestPositions(moved, measure, before, after, float(gain), tried)


def _alike(finger: Finger) -> SensorArray:
    """The live sensors, which have to be of one kind, depth, noise and width."""
    array = finger.array.select(finger.array.live)
    for name in ("depth", "noise", "width", "gain"):
        values = np.asarray(getattr(array, name))
        if np.ptp(values) > 0:
            seen = f"{name} from {values.min():.6g} to {values.max():.6g}"
            raise InvalidValueError(seen, "sensors that are alike are needed", "one value for all sensors")
    if len(set(array.transducers)) > 1:
        rule = "sensors that are alike are needed"
        raise InvalidValueError("several kinds of sensor", rule, "transducer=NormalStrain()")
    noise_of(array)
    return array


def _searched(
    cost: Callable[[FloatArray], float],
    start: FloatArray,
    middle: float,
    symmetric: bool,
    scale: float,
    rng: np.random.Generator,
    tries: int,
) -> FloatArray:
    """Positions of least cost, from the start and from jittered ones, by turns."""
    from scipy.optimize import minimize

    count, half = start.size, start.size // 2

    def positions(free: FloatArray) -> FloatArray:
        if not symmetric:
            return np.sort(free)
        out = np.full(count, middle)
        offsets = np.sort(np.abs(free))
        out[count - half :] += offsets
        out[:half] -= offsets[::-1]
        return out

    free = 0.5 * (start - start[::-1])[count - half :] if symmetric else start
    best, least = start, cost(start)
    for turn in range(_STARTS):
        begin = free if turn == 0 else free + scale * rng.uniform(-1, 1, free.size)
        options = {
            "initial_simplex": np.vstack([begin, begin + scale * np.eye(free.size)]),
            "maxfev": max(tries // _STARTS, free.size + 2),
            "xatol": 1e-4 * scale,
            "fatol": 1e-4,
            "adaptive": free.size > 4,
        }
        found = minimize(  # type: ignore[call-overload]
            lambda x: cost(positions(x)), begin, method="Nelder-Mead", options=options
        )
        if found.fun < least:
            best, least, free = positions(found.x), float(found.fun), found.x
    return best
