"""Placements of one depth, at every pitch and layout."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Fix, Length, Ruled, checked
from ...errors import GeometryError, InvalidValueError
from ...skin import Skin
from .._common import Seed, listed
from ..touches import Touches
from ._field import AreaField, OneSensor
from .asked import (
    AMBIGUITY,
    AREA_MEASURES,
    MARGIN,
    PLACEMENT_MEASURES,
    AskedTouches,
    Margin,
    check_count,
    check_where,
    reach_of,
    searched,
    touched,
)
from .layout import Arrangement, Channel, channels_of

__all__ = ["study_at_depth"]

_MOST_SENSORS = 10**4


def _channels(name: str, given: Any) -> tuple[Channel, ...]:
    """Kinds of channel with a noise."""
    fix = "Channel(NormalStrain(), 1e-3)"
    kinds = (given,) if isinstance(given, Channel) else _check.several(name, given, Channel, f"[{fix}]")
    if not kinds:
        raise InvalidValueError("0 channels", "one at least is needed", fix)
    for kind in kinds:
        _check.scalar("noise", kind.noise, above=0.0)
        _check.scalar("width", kind.width, unit="m", at_least=0.0)
    return kinds


def _layouts(name: str, given: Any) -> tuple[Arrangement, ...]:
    """Layouts, rows among them by their numbers of sensors."""
    fix, out = "layouts=[4, 6, 8]", []
    for one in given if isinstance(given, list | tuple | np.ndarray) else (given,):
        if isinstance(one, Arrangement):
            out.append(one)
            continue
        number = _check.real(name, one)
        if number.ndim or number != np.round(number) or not 1 <= number <= _MOST_SENSORS:
            rule = f"a list of whole numbers up to {_MOST_SENSORS} is needed, or of Arrangements"
            raise InvalidValueError(f"{name} = {_check.shown(given)}", rule, fix)
        out.append(Arrangement("row", (int(number),)))
    if not out:
        raise InvalidValueError(f"{name} = []", "one at least is needed", fix)
    return tuple(out)


def _check_row(kinds: tuple[Channel, ...], layouts: tuple[Arrangement, ...], touches: Touches) -> None:
    """Refuses several kinds over line loads, and what is no row, or one of fewer sensors than a touch has unknowns."""
    if touches.area is not None:
        return
    if len(kinds) > 1:
        rule = "one kind of sensor is needed"
        raise InvalidValueError(f"{len(kinds)} channels", rule, "Channel(NormalStrain(), 1e-3)")
    for layout in layouts:
        check_count(layout.count, touches)
        if layout.pattern != "row":
            rule = "line loads across a row of sensors are judged"
            raise GeometryError(f"a {layout.text}", rule, "touches on an area, or numbers of sensors")


@checked
def study_at_depth(
    skin: Annotated[Skin, Fix("HalfPlane(Material(young=0.4e6))")],
    channels: Annotated[Channel | Sequence[Channel], Ruled(_channels)],
    depth: Length,
    pitches: npt.ArrayLike,
    layouts: Annotated[Sequence[Arrangement | int], Ruled(_layouts)],
    touches: Touches,
    *,
    together: bool = True,
    rng: Seed = 0,
    samples: int | None = None,
    grid: tuple[int, int] | None = None,
    margin: Margin = MARGIN,
    ambiguity: float = AMBIGUITY,
    progress: Callable[[], object] | None = None,
) -> dict[str, FloatArray]:
    """How well placements of one depth locate touches, and how often they cannot, at every pitch and layout.

    Each stands about the middle of what is touched, the span or the area, all of which counts; without a span a row
    stands about 0 and is touched from its first sensor to its last. Bounds are those of Cramer and Rao, on a closed
    grid of positions and directions. Shares are means of the probabilities that noise makes of a touch what is named,
    over touches at random: of a row one in each of as many equal cells of position and angle (docs/placement.md).

    Parameters
    ----------
    skin : Skin
        Any; on an area one that takes local contacts.
    channels : Channel or sequence of Channel
        What the sensors measure; one kind in a row. On an area several are all at each position.
    depth : float
        Depth of the sensors [m], > 0.
    pitches : array_like, shape (s,)
        Distances of neighbours [m], > 0.
    layouts : sequence of c Arrangements, or of whole numbers
        How the sensors stand; a number is a row of so many, >= 3, or >= 2 where `touches.friction` is 0.
    touches : Touches
        What is to be located; its friction bounds the search as well.
    together : bool, optional
        Whether all `channels` are at each position; else they take turns from one position to the next.
    rng : Generator or int, optional
        Random generator of the touches, or its seed. Every design meets the same touches.
    samples : int, optional
        Touches by which shares are found, at least: 100,000, and 300 on an area.
    grid : (int, int), optional
        Positions and angles of a row; on an area positions along y, and along z, and azimuths.
    margin, ambiguity
        As in `placement_quality`.
    progress : callable, optional
        Called after each design.

    Returns
    -------
    dict of str to ndarray, shape (s, c)
        One of each `PLACEMENT_MEASURES`, on an area of `AREA_MEASURES`. The largest, the 95 % quantile and the mean of
        standard deviations: `position_worst`, `position_95`, `position_mean` [m], on an area in the direction in which
        it is worst; `angle_...` of the force's direction [rad]; `force_...`, relative to the force; `radius_...` [m],
        0 for points. They are infinite where a touch is not determined, which in a mean counts as known from `touches`
        alone. `ambiguous`, `wrong`, `unfelt` [-]: shares of touches that `locate` calls AMBIGUOUS, for which another
        load more than a tenth of a depth away fits better, and that it calls NO_CONTACT. `log_det`: mean logarithm of
        the determinant of the Fisher information, of a row of position [m], logarithm of the force, and angle [rad].
        `rank`: unknowns that the readings tell at most; where it is too low all touches are ambiguous, and the other
        two shares NaN. All are NaN where sensors of their width would overlap, or the row would go round the skin.

    Raises
    ------
    InvalidValueError, GeometryError
        Values out of range, a depth beyond the skin, a span longer than the skin is about, an area on a skin that is
        solved in a plane; several kinds in a row, or layouts that are none.
    NotLinearError
        A transducer with no linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> from subskin.design.placement import Arrangement, Channel, study_at_depth
    >>> gauge = Channel(ss.NormalStrain(), noise=5e-5)
    >>> rubber = ss.Material(young=0.4e6)
    >>> touches = ss.design.Touches(force=40.0)
    >>> found = study_at_depth(ss.HalfPlane(rubber), gauge, 2e-3, [1e-3, 2e-3], [4], touches, samples=2000)
    >>> (found["position_worst"] * 1e6).round(0).ravel().tolist()
    [21.0, 210.0]

    Strain gauges on one line see four of the five unknowns of a touch on an area, however many there are.

    >>> touches = ss.design.Touches(force=1.0, friction=0.5, area=((-2e-3, 2e-3), (-2e-3, 2e-3)))
    >>> both, gauge = [Arrangement("row", (6,)), Arrangement("grid", (3, 3, 3))], gauge._replace(noise=1e-3)
    >>> found = study_at_depth(ss.HalfSpace(rubber), gauge, 2e-3, [1.5e-3], both, touches, samples=50)
    >>> found["rank"].tolist(), (1e3 * found["position_95"]).round(3).tolist()
    ([[4.0, 5.0]], [[inf, 0.121]])
    """
    check_where(skin, touches)
    steps = listed("pitches", pitches, "m", above=0.0)
    kinds: Any = channels  # made tuples of them by their declarations
    arrangements: Any = layouts
    _check_row(kinds, arrangements, touches)
    asked = AskedTouches.of(touches, grid, samples, rng, ambiguity)
    wide, row = max(kind.width for kind in kinds), touches.area is None
    middle, units = np.array(middle_of(touches)), [layout.unit for layout in arrangements]
    designs = []
    for i, j in np.ndindex(steps.size, len(arrangements)):
        step = float(steps[i])
        if wide <= step * (1 + 1e-12) and not (row and len(units[j]) * step > skin.period * (1 + 1e-12)):
            points = (middle + step * units[j])[:, : touches.dim]
            designs.append((i, j, points, searched(points, depth, skin, touches, margin)))
    names = PLACEMENT_MEASURES if row else AREA_MEASURES
    out = {name: np.full((steps.size, len(arrangements)), np.nan) for name in names}
    if not designs:
        return out
    reach = max(reach_of(points, box) for *_, points, box in designs)
    one: OneSensor | AreaField
    one = OneSensor(skin, kinds[0], depth, reach) if row else AreaField.of_each(skin, kinds, depth, touches, reach)
    for i, j, points, box in designs:
        at, which = channels_of(arrangements[j], len(kinds), together)
        found = one.moved(points[at], which, box).judged(asked, touched(touches, points), maps=False)
        for name, value in found.values.items():
            out[name][i, j] = value
        if progress is not None:
            progress()
    return out


def middle_of(touches: Touches) -> tuple[float, float]:
    """About which placements for such touches stand, (y, z) [m]."""
    if touches.area is not None:
        y, z = np.mean(np.asarray(touches.area), axis=1).tolist()
        return y, z
    return (0.0 if touches.span is None else 0.5 * (touches.span[0] + touches.span[1])), 0.0
