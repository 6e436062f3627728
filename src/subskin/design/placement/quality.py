"""How well one finger locates touches: maps over positions and loads."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._declared import checked
from ...finger import Finger
from .._common import Found, Seed
from ..touches import Touches
from ._field import AreaField, RowField
from .asked import AMBIGUITY, AREA_SAMPLES, MARGIN, AskedTouches, Margin, check_count, check_where, reach_of, searched

__all__ = ["PlacementQuality", "placement_quality"]

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
        Probabilities that `locate` says AMBIGUOUS, that another load more than a tenth of a depth away fits better than
        the true one, and that `locate` says NO_CONTACT. On an area that does not see a touch it is ambiguous, and the
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
