"""Equal rows of one kind of sensor at one depth: the piece that a study is made of."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...errors import GeometryError
from ...skin import Skin
from ...transducer import Transducer
from ..touches import Touches
from ._table import (
    AMBIGUITY,
    GRID,
    MAPS,
    MARGIN,
    PLACEMENT_MEASURES,
    SHARES,
    OneSensor,
    check_span,
    checked_counts,
    checked_margin,
    checked_samples,
    jittered,
    judged,
    searched,
)

__all__ = ["study_row"]

SAMPLES = 100_000


def study_row(
    skin: Skin,
    transducer: Transducer,
    depth: float,
    pitches: npt.ArrayLike,
    counts: npt.ArrayLike,
    touches: Touches,
    *,
    noise: float,
    width: float = 0.0,
    rng: np.random.Generator | int = 0,
    samples: int = SAMPLES,
    grid: tuple[int, int] = GRID,
    margin: float = MARGIN,
    ambiguity: float = AMBIGUITY,
    progress: Callable[[], object] | None = None,
) -> dict[str, FloatArray]:
    """How well equal rows of sensors locate touches, and how often they cannot, at every pitch and count.

    The row stands in the middle of `touches.span`, all of which counts; without a span each row stands about 0 and is
    touched from its first sensor to its last. Bounds are those of Cramer and Rao, on a closed grid of positions and
    angles. Shares are means of the probabilities that noise makes of a touch what is named, over `samples` touches, one
    at random in each of as many equal cells of position and angle (docs/placement.md).

    Parameters
    ----------
    skin : Skin
        Any.
    transducer : Transducer
        What each sensor measures; one with a linear part.
    depth : float
        Depth of the sensors [m], > 0.
    pitches : array_like, shape (s,)
        Distances of neighbours [m], > 0.
    counts : array_like, shape (c,)
        Numbers of sensors, >= 3, or >= 2 where `touches.friction` is 0.
    touches : Touches
        What is to be located; its friction bounds the search as well.
    noise : float
        Standard deviation of a reading [unit of the transducer], > 0.
    width : float, optional
        Width of each sensor [m].
    rng : Generator or int, optional
        Random generator of the touches, or its seed. Every design meets the same touches.
    samples : int, optional
        Touches a design, at least.
    grid, margin, ambiguity
        As in `placement_quality`.
    progress : callable, optional
        Called after each design.

    Returns
    -------
    dict of str to ndarray, shape (s, c)
        One of each `PLACEMENT_MEASURES`. The largest, the 95 % quantile and the mean of standard deviations:
        `position_worst`, `position_95`, `position_mean` [m], `angle_...` [rad] and `force_...`, relative to the force;
        infinite where a touch is not determined, which in a mean counts as known from `touches` alone. `ambiguous`,
        `wrong`, `unfelt` [-]: shares of touches that `locate` calls AMBIGUOUS, for which another load more than a
        tenth of a depth away fits better, and that it calls NO_CONTACT. `log_det`: mean logarithm of the determinant of
        the Fisher information of position [m], logarithm of the force, and angle [rad]. NaN where sensors of that width
        would overlap, or the row would go round the skin.

    Raises
    ------
    InvalidValueError, GeometryError
        Values out of range, a depth beyond the skin, a span longer than the skin is about.
    NotLinearError
        A transducer with no linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> found = ss.design.placement.study_row(
    ...     skin, ss.NormalStrain(), 2e-3, [1e-3, 2e-3], [4], ss.design.Touches(force=40.0), noise=5e-5, samples=2000
    ... )
    >>> (found["position_worst"] * 1e6).round(0).ravel().tolist()
    [21.0, 210.0]
    """
    _check.function("progress", progress)
    deep = _check.scalar("depth", depth, unit="m", above=0.0)
    steps = np.atleast_1d(_check.real("pitches", pitches, unit="m", above=0.0))
    numbers = checked_counts(counts, touches)
    sigma = _check.scalar("noise", noise, above=0.0)
    wide = _check.scalar("width", width, unit="m", at_least=0.0)
    beyond = checked_margin(margin)
    most = _check.scalar("ambiguity", ambiguity, at_least=0.0)
    amount = checked_samples(samples)
    if steps.ndim != 1:
        raise GeometryError(f"pitches of shape {steps.shape}", "a list is needed", "pitches=[1e-3, 2e-3]")
    check_span(skin, touches)
    unit_positions, unit_angles = jittered(amount, _check.random(rng))
    angles = touches.cone * (2 * unit_angles - 1)
    out = {name: np.full((steps.size, numbers.size), np.nan) for name in PLACEMENT_MEASURES}
    rows = [
        (i, j, equal_row(int(n), float(s), touches))
        for i, s in enumerate(steps)
        for j, n in enumerate(numbers)
        if n * s <= skin.period * (1 + 1e-12) and wide <= s * (1 + 1e-12)
    ]
    if not rows:
        return out
    ends = [searched(y, deep, skin, touches.span, beyond) for *_, y in rows]
    reach = max(max(high - y[0], y[-1] - low) for (*_, y), (low, high) in zip(rows, ends, strict=True))
    one = OneSensor(skin, transducer, deep, sigma, wide, reach)
    for (i, j, y), search in zip(rows, ends, strict=True):
        field = one.row(y, search)
        span = touches.span or (float(y[0]), float(y[-1]))
        *_, values = judged(field, touches, span, grid, most)
        sampled = field.survey(touches, span[0] + (span[1] - span[0]) * unit_positions, angles, most, bounds=False)
        values |= {name: float(sampled[MAPS.index(name)].mean()) for name in SHARES}
        for name, value in values.items():
            out[name][i, j] = value
        if progress is not None:
            progress()
    return out


def equal_row(count: int, pitch: float, touches: Touches) -> FloatArray:
    """Positions of `count` sensors [m] in the middle of the span, or about 0."""
    middle = 0.0 if touches.span is None else 0.5 * (touches.span[0] + touches.span[1])
    return np.asarray(middle + pitch * (np.arange(count) - (count - 1) / 2))
