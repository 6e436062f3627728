"""How well one finger locates touches, as maps; and placements of one depth, at every pitch and layout, as numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Fix, Length, Ruled, checked
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...skin import Skin
from .._common import Found, Seed, listed
from ..touches import Touches
from ._field import AreaField, OneSensor, RowField
from .asked import (
    AMBIGUITY,
    AREA_MEASURES,
    AREA_SAMPLES,
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

__all__ = ["PlacementQuality", "placement_quality", "study_at_depth"]

_FINE, _FINE_AREA = (401, 161), (17, 6)
"""Fine enough to show the lines along which four sensors are ambiguous, a hundredth of a depth wide; and on an area."""


@dataclass(frozen=True, eq=False)
class PlacementQuality(Found):
    """What `placement_quality` found: maps of shape (p, k) over position and angle, or (p, p, k) over y, z and load.

    Attributes
    ----------
    finger : Finger
    touches : Touches
    search : (float, float) or ((float, float), (float, float))
        Where loads are looked for [m]: the `search` with which `finger.locate` does what is foretold here.
    position : ndarray, shape (p,) or (p, p, 2)
        Positions of the touches [m], from end to end.
    load : ndarray, shape (k, 2) or (k, 3)
        Their components [N/m]: from one side of the cone to the other; on an area [N]: straight down, and leaning
        towards all sides.
    weight : ndarray
        Share of the touches that each stands for.
    std : dict of ndarray
        Standard deviations that no unbiased estimate falls below (Cramer and Rao), infinite where the readings do not
        determine the load: "position" [m], on an area in its worst direction, "angle" [rad], "force", relative to it,
        and on an area "radius" [m].
    ambiguous, wrong, unfelt : ndarray
        Probabilities that another load leaves `locate` AMBIGUOUS, that one more than a tenth of a depth away fits
        better than the true one, and that `locate` says NO_CONTACT. With no reading to spare every touch is AMBIGUOUS;
        the share is then of those that two loads explain. On an area that does not see a touch it is ambiguous, and the
        others NaN.
    values : dict of str to float
        The maps in one number each: `PLACEMENT_MEASURES`, or `AREA_MEASURES`, described at `study_at_depth`. Also by
        name, `quality["wrong"]`.
    covariance : ndarray, shape (p, p, k, u, u), or None
        On an area the bound of Cramer and Rao for (y, z, N, Ty, Tz), the radius third where the touches have one
        [m, N].
    rank : ndarray of int, shape (p, p, k), or None
        On an area: how many of these the readings determine.
    """

    finger: Finger
    touches: Touches
    search: tuple[float, float] | tuple[tuple[float, float], tuple[float, float]]
    position: FloatArray
    load: FloatArray
    weight: FloatArray
    std: dict[str, FloatArray]
    ambiguous: FloatArray
    wrong: FloatArray
    unfelt: FloatArray
    values: dict[str, float]
    covariance: FloatArray | None = None
    rank: npt.NDArray[np.intp] | None = None

    def __getitem__(self, measure: str) -> float:
        return self.values[measure]

    @property
    def angle(self) -> FloatArray:
        """Angle of each load to the normal [rad], shape (k,); on a row negative towards -y."""
        side = self.load[:, 1] if self.touches.dim == 1 else np.hypot(self.load[:, 1], self.load[:, 2])
        return np.asarray(np.arctan2(side, self.load[:, 0]))


@checked
def placement_quality(
    finger: Finger,
    touches: Touches,
    *,
    grid: tuple[int, int] | None = None,
    samples: int = 2 * AREA_SAMPLES,
    rng: Seed = 0,
    margin: Margin = MARGIN,
    ambiguity: float = AMBIGUITY,
) -> PlacementQuality:
    """How well a finger locates touches, and how probably it takes one for another.

    For any skin, linear transducers, and positions of the sensors: in a row for line loads, on an area, with a skin
    that takes them, for local touches. The noise is that of the sensors; their range and resolution are left out of it.
    Probabilities follow from the chi-square of each touch's rivals on readings free of noise (docs/placement.md).

    Parameters
    ----------
    finger : Finger
        With the noise of its sensors.
    touches : Touches
        What is to be located; its friction bounds the search as well.
    grid : (int, int), optional
        Numbers of positions and of angles, (401, 161); with odd ones the middle is among them. On an area numbers of
        positions along each side and of azimuths, (17, 6).
    samples : int, optional
        On an area: touches drawn at random by which shares are found, at least.
    rng : Generator or int, optional
        Random generator of these, or its seed.
    margin : float, optional
        How far beyond the sensors loads are looked for [depths of the deepest]; 1.5, as by `finger.locate`.
    ambiguity : float, optional
        That of `Locator` [-].

    Raises
    ------
    InvalidValueError, GeometryError
        Sensors without noise; fewer live ones than unknowns; a span that goes round the finger; touches on an area and
        sensors in a row, or a skin that is solved in a plane.
    NotLinearError
        A transducer with no linear part.

    Examples
    --------
    Three sensors lose the position of a normal touch right above the middle sensor: the Jacobian is
    singular there.

    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=3, pitch=2e-3, depth=2e-3, noise=5e-5))
    >>> found = ss.design.placement_quality(finger, ss.design.Touches(force=40.0))
    >>> found.std["position"].shape, float(found["position_worst"])
    ((401, 161), inf)

    And nine on an area:

    >>> array = ss.SensorArray.grid((3, 3), pitch=2e-3, depth=2e-3, noise=1e-3)
    >>> pad = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> touches = ss.design.Touches(force=1.0, friction=0.5, area=((-2e-3, 2e-3), (-2e-3, 2e-3)))
    >>> found = ss.design.placement_quality(pad, touches, grid=(9, 6), samples=50)
    >>> found.covariance.shape, round(1e3 * found["position_95"], 3)
    ((9, 9, 13, 5, 5), 0.053)
    """
    check_where(finger.skin, touches)
    array, row = finger.array.select(finger.array.live), touches.dim == 1
    check_count(len(array), touches)
    fine = _FINE if row else _FINE_AREA
    asked = AskedTouches.of(touches, fine if grid is None else grid, samples, rng, ambiguity, draws=not row)
    box = np.array([touches.span_on(finger)]) if row else np.asarray(touches.area)
    points = array.points[:, : touches.dim]
    search = searched(points, float(np.asarray(array.depth).max()), finger.skin, touches, margin)
    if row:
        field: RowField | AreaField = RowField.of(finger, (float(search[0, 0]), float(search[0, 1])))
    else:
        bare = replace(finger, array=array, measured=None)
        field = AreaField.of(bare, touches, search, reach_of(points, search))
    found = field.judged(asked, box, maps=True)
    (low, high), *other = search.tolist()
    where = ((low, high), tuple(other[0])) if other else (low, high)
    return PlacementQuality(
        finger, touches, where, found.position, found.load, found.weight, found.std, **found.maps,
        values=found.values, covariance=found.covariance, rank=found.rank,
    )  # fmt: skip


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
        if layout.unit[:, 1].any():
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
        alone. `ambiguous`, `wrong`, `unfelt` [-]: shares of touches that another load leaves AMBIGUOUS, for which one
        more than a tenth of a depth away fits better, and that `locate` calls NO_CONTACT. `log_det`: mean logarithm of
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
    >>> both, gauge = [Arrangement("row", (6,)), Arrangement("grid", (3, 3))], gauge._replace(noise=1e-3)
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
    middle, units = np.array(touches.middle), [layout.unit for layout in arrangements]
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
