"""How well one finger locates touches: maps over position and angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._frozen import Result
from ...finger import Finger, finger_needed
from ..touches import Touches
from ._table import (
    AMBIGUITY,
    MAPS,
    MARGIN,
    SHARES,
    RowField,
    check_span,
    checked_counts,
    checked_margin,
    judged,
    searched,
)

__all__ = ["PlacementQuality", "placement_quality"]

FINE_GRID = (401, 161)
"""Fine enough to show the lines along which four sensors are ambiguous, a hundredth of a depth wide."""


@dataclass(frozen=True, eq=False)
class PlacementQuality(Result):
    """What `placement_quality` found: maps of shape (p, k) over position and angle.

    Attributes
    ----------
    finger : Finger
    touches : Touches
    search : (float, float)
        Where loads are looked for [m]: the `search` with which `finger.locate` does what is foretold here.
    position, angle : ndarray, shapes (p,), (k,)
        Positions and angles of the touches [m, rad], from end to end.
    position_std, angle_std, force_std : ndarray
        Standard deviations that no unbiased estimate falls below (Cramer and Rao) [m, rad], and relative to the force
        [-]; infinite where the readings do not determine the load.
    ambiguous, wrong, unfelt : ndarray
        Probabilities that `locate` says AMBIGUOUS, that another load more than a tenth of a depth away fits better than
        the true one, and that `locate` says NO_CONTACT.
    values : dict of str to float
        The maps in one number each: `PLACEMENT_MEASURES`, described at `study_row`. Also by index, `quality["wrong"]`.
    """

    finger: Finger
    touches: Touches
    search: tuple[float, float]
    position: FloatArray
    angle: FloatArray
    position_std: FloatArray
    angle_std: FloatArray
    force_std: FloatArray
    ambiguous: FloatArray
    wrong: FloatArray
    unfelt: FloatArray
    values: dict[str, float]

    def __getitem__(self, measure: str) -> float:
        return self.values[measure]


def placement_quality(
    finger: Finger,
    touches: Touches,
    *,
    grid: tuple[int, int] = FINE_GRID,
    margin: float = MARGIN,
    ambiguity: float = AMBIGUITY,
) -> PlacementQuality:
    """How well a finger locates touches, and how probably it takes one for another.

    For any skin, linear transducers, and positions of the sensors. The noise is that of the sensors; their range and
    resolution are left out of it. Probabilities follow from the chi-square of each touch's rivals on readings free of
    noise (docs/placement.md).

    Parameters
    ----------
    finger : Finger
        With the noise of its sensors.
    touches : Touches
        What is to be located; its friction bounds the search as well.
    grid : (int, int), optional
        Numbers of positions and of angles. With odd ones the middle is among them.
    margin : float, optional
        How far beyond the sensors loads are looked for [depths of the deepest]; 1.5, as by `finger.locate`.
    ambiguity : float, optional
        That of `Locator` [-].

    Raises
    ------
    InvalidValueError, GeometryError
        Sensors without noise; fewer live ones than unknowns; a span that goes round the finger.
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
    >>> found.position_std.shape, float(found["position_worst"])
    ((401, 161), inf)
    """
    finger_needed(finger)
    live = finger.array.live
    checked_counts([int(live.sum())], touches)
    check_span(finger.skin, touches)
    array = finger.array.select(live)
    span = touches.span_on(finger)
    beyond = checked_margin(margin)
    most = _check.scalar("ambiguity", ambiguity, at_least=0.0)
    positions, deepest = np.asarray(array.y), float(np.asarray(array.depth).max())
    search = searched(positions, deepest, finger.skin, span, beyond)
    y, angle, maps, values = judged(RowField.of(finger, search), touches, span, grid, most)
    named = {name: _check.read_only(maps[k].copy()) for k, name in enumerate(MAPS)}
    return PlacementQuality(
        finger, touches, search, _check.read_only(y), _check.read_only(angle),
        named["position"], named["angle"], named["force"], **{name: named[name] for name in SHARES}, values=values,
    )  # fmt: skip
