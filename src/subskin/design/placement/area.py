"""Arrays of one pitch and depth on an area: the piece that a search on an area is made of."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...errors import InvalidValueError
from ...skin import Skin
from ..touches import Touches
from ._area import AREA_GRID, AREA_MEASURES, AskedTouches, Channel, OneArea, check_area, judged_area, searched_area
from ._table import AMBIGUITY, MARGIN, checked_margin
from .layout import Arrangement

__all__ = ["AREA_SAMPLES", "channels_of", "study_area"]

AREA_SAMPLES = 300


def study_area(
    skin: Skin,
    kinds: Sequence[Channel],
    depth: float,
    pitches: npt.ArrayLike,
    layouts: Sequence[Arrangement],
    touches: Touches,
    *,
    together: bool = True,
    rng: np.random.Generator | int = 0,
    samples: int = AREA_SAMPLES,
    grid: tuple[int, int] = AREA_GRID,
    margin: float = MARGIN,
    ambiguity: float = AMBIGUITY,
    progress: Callable[[], object] | None = None,
) -> dict[str, FloatArray]:
    """How well arrays on an area locate local touches, and how often they cannot, at every pitch and layout.

    Each array stands about the middle of `touches.area`, all of which counts. Bounds are those of Cramer and Rao for
    (y, z, N, Ty, Tz), and for the radius of touches that have one, on a closed grid of positions and directions. Shares
    are means of probabilities over `samples` touches drawn at random (docs/placement.md).

    Parameters
    ----------
    skin : Skin
        One that takes local contacts.
    kinds : sequence of Channel
        What the channels measure; of several, all are at each position.
    depth : float
        Depth of the sensors [m], > 0.
    pitches : array_like, shape (s,)
        Distances of neighbours [m], > 0.
    layouts : sequence of c Arrangements
        How the positions are set out.
    touches : Touches
        What is to be located, on an area.
    together : bool, optional
        Whether all `kinds` are at each position; else they take turns from one position to the next.
    rng : Generator or int, optional
        Random generator of the touches, or its seed. Every design meets the same touches.
    samples : int, optional
        Touches by which shares are found, at least.
    grid : (int, int), optional
        Positions along y, and along z; azimuths.
    margin, ambiguity
        As in `placement_quality`.
    progress : callable, optional
        Called after each design.

    Returns
    -------
    dict of str to ndarray, shape (s, c)
        One of each `AREA_MEASURES`. Largest on the grid, 95 % quantile and mean of standard deviations: `position_...`
        in the direction in which it is worst [m], `angle_...` of the force's direction [rad], `force_...` relative to
        the force, `radius_...` [m], 0 for points. They are infinite where an unknown is open, and all of the touch
        then. `rank`: unknowns that the readings tell at most. `ambiguous`, `wrong`, `unfelt`, `log_det`: as in
        `study_row`; where the rank is too low all touches are ambiguous, and the other two NaN. NaN everywhere where
        sensors of their width would overlap.

    Raises
    ------
    InvalidValueError, GeometryError
        Values out of range, touches without an area, a skin solved in a plane, a depth beyond the skin.
    NotLinearError
        A transducer with no linear part.

    Examples
    --------
    Strain gauges on one line see four of the five unknowns, however many there are.

    >>> import subskin as ss
    >>> from subskin.design.placement import Channel, Arrangement, study_area
    >>> skin = ss.HalfSpace(ss.Material(young=0.4e6))
    >>> touches = ss.design.Touches(force=1.0, friction=0.5, area=((-2e-3, 2e-3), (-2e-3, 2e-3)))
    >>> both = [Arrangement("row", (6,)), Arrangement("grid", (3, 3, 3))]
    >>> found = study_area(skin, [Channel(ss.NormalStrain(), 1e-3)], 2e-3, [1.5e-3], both, touches, samples=50)
    >>> found["rank"].tolist(), (1e3 * found["position_95"]).round(3).tolist()
    ([[4.0, 5.0]], [[inf, 0.121]])
    """
    _check.function("progress", progress)
    check_area(skin, touches)
    deep = _check.scalar("depth", depth, unit="m", above=0.0)
    steps = np.atleast_1d(_check.real("pitches", pitches, unit="m", above=0.0))
    beyond = checked_margin(margin)
    most = _check.scalar("ambiguity", ambiguity, at_least=0.0)
    kinds = _check.several("kinds", kinds, Channel, "[Channel(NormalStrain(), 1e-3)]")
    layouts = _check.several("layouts", layouts, Arrangement, '[Arrangement("grid", (3, 3))]')
    if not kinds or not layouts:
        seen = f"{len(kinds)} kinds, {len(layouts)} layouts"
        raise InvalidValueError(seen, "one of each at least is needed", 'layouts=[Arrangement("grid", (3, 3))]')
    _check.flag("together", together)
    asked = AskedTouches.of(touches, grid, samples, _check.random(rng))
    out = {name: np.full((steps.size, len(layouts)), np.nan) for name in AREA_MEASURES}
    middle = tuple(np.mean(np.asarray(touches.area), axis=1).tolist())
    wide = max(kind.width for kind in kinds)
    designs = [
        (i, j, layout.points(float(s), middle))
        for i, s in enumerate(steps)
        for j, layout in enumerate(layouts)
        if wide <= s * (1 + 1e-12)
    ]
    if not designs:
        return out
    boxes = [searched_area(points, deep, touches, beyond) for *_, points in designs]
    reach = max(
        float(np.hypot(*np.abs(box[None] - p[:, :, None]).max(axis=(0, 2)))) for (*_, p), box in zip(designs, boxes)
    )
    one = OneArea(skin, kinds, deep, touches, reach)
    for (i, j, points), box in zip(designs, boxes, strict=True):
        at, which = channels_of(layouts[j], len(kinds), together)
        _, values = judged_area(one.field(points[at], which), touches, asked, box, most)
        for name, value in values.items():
            out[name][i, j] = value
        if progress is not None:
            progress()
    return out


def channels_of(layout: Arrangement, kinds: int, together: bool) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Position and kind of each channel of a layout, (n,) both.

    Parameters
    ----------
    layout : Arrangement
        How the positions are set out.
    kinds : int
        How many kinds of channel there are.
    together : bool
        Whether all are at each position; else they take turns.

    Examples
    --------
    >>> [v.tolist() for v in channels_of(Arrangement("row", (2,)), 2, True)]
    [[0, 0, 1, 1], [0, 1, 0, 1]]
    """
    if together:
        return np.repeat(np.arange(layout.count), kinds), np.tile(np.arange(kinds), layout.count)
    return np.arange(layout.count), layout.colours(kinds)
