"""How well one finger on an area locates local touches: maps over position and load."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._frozen import Result
from ...errors import InvalidValueError
from ...finger import Finger, finger_needed
from ...radial import tabulate_radial
from ..touches import Touches
from ._area import (
    AREA_STDS,
    AreaField,
    AskedTouches,
    check_area,
    compiled_tables,
    judged_area,
    searched_area,
    tables_of,
)
from ._table import AMBIGUITY, MARGIN, SHARES, checked_grid, checked_margin
from .area import AREA_SAMPLES

__all__ = ["AreaQuality", "area_quality"]

_FINE = (17, 6)


@dataclass(frozen=True, eq=False)
class AreaQuality(Result):
    """What `area_quality` found: maps of shape (p, p, d) over positions y, z and loads.

    Attributes
    ----------
    finger : Finger
    touches : Touches
    search : ((float, float), (float, float))
        Where loads are looked for [m]: the `search` with which `finger.locate` does what is foretold here.
    y, z : ndarray, shape (p,)
        Positions of the touches [m], from end to end.
    load : ndarray, shape (d, 3)
        Their components [N]: straight down, and leaning towards all sides.
    weight : ndarray, shape (p, p, d)
        Share of the touches that each stands for.
    covariance : ndarray, shape (p, p, d, u, u)
        Bound of Cramer and Rao for (y, z, N, Ty, Tz), the radius third where the touches have one [m, N]; infinite
        where the readings do not determine all of them.
    rank : ndarray of int, shape (p, p, d)
        How many of them they determine.
    std : dict of ndarray
        "position" in its worst direction [m], "angle" [rad], "force", relative to it, and "radius" [m].
    ambiguous : ndarray, shape (p, p)
        Probability that `locate` says AMBIGUOUS, over all loads there.
    values : dict of str to float
        The maps in one number each: `AREA_MEASURES`, described at `study_area`. Also by index, `quality["wrong"]`.
    """

    finger: Finger
    touches: Touches
    search: tuple[tuple[float, float], tuple[float, float]]
    y: FloatArray
    z: FloatArray
    load: FloatArray
    weight: FloatArray
    covariance: FloatArray
    rank: npt.NDArray[np.intp]
    std: dict[str, FloatArray]
    ambiguous: FloatArray
    values: dict[str, float]

    def __getitem__(self, measure: str) -> float:
        return self.values[measure]


def area_quality(
    finger: Finger,
    touches: Touches,
    *,
    grid: tuple[int, int] = _FINE,
    samples: int = 2 * AREA_SAMPLES,
    rng: np.random.Generator | int = 0,
    margin: float = MARGIN,
    ambiguity: float = AMBIGUITY,
) -> AreaQuality:
    """How well a finger on an area locates local touches, and how probably it takes one for another.

    For any skin that takes local contacts, linear transducers, and positions and depths of the sensors; as
    `placement_quality` is for rows.

    Parameters
    ----------
    finger : Finger
        With the noise of its sensors.
    touches : Touches
        What is to be located, on an area; its friction bounds the search as well.
    grid : (int, int), optional
        Numbers of positions along each side, and of azimuths.
    samples : int, optional
        Touches drawn at random by which shares are found, at least.
    rng : Generator or int, optional
        Random generator of these, or its seed.
    margin, ambiguity
        As in `placement_quality`.

    Raises
    ------
    InvalidValueError, GeometryError
        Sensors without noise, a skin solved in a plane, touches without an area.
    NotLinearError
        A transducer with no linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> from subskin.design.placement import area_quality
    >>> array = ss.SensorArray.grid((3, 3), pitch=2e-3, depth=2e-3, noise=1e-3)
    >>> touches = ss.design.Touches(force=1.0, friction=0.5, area=((-2e-3, 2e-3), (-2e-3, 2e-3)))
    >>> found = area_quality(ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array), touches, grid=(9, 6), samples=50)
    >>> found.covariance.shape, round(1e3 * found["position_95"], 3)
    ((9, 9, 13, 5, 5), 0.053)
    """
    finger_needed(finger)
    check_area(finger.skin, touches)
    array = finger.array.select(finger.array.live)
    if not (np.asarray(array.noise) > 0).all():
        raise InvalidValueError("noise = 0", "the answer depends on the noise of the sensors", "noise=1e-4")
    grid = checked_grid(grid)
    beyond = checked_margin(margin)
    most = _check.scalar("ambiguity", ambiguity, at_least=0.0)
    box = searched_area(array.points, float(np.asarray(array.depth).max()), touches, beyond)
    field = field_of(replace(finger, array=array, measured=None), touches, box)
    asked = AskedTouches.of(touches, grid, samples, _check.random(rng))
    told, values = judged_area(field, touches, asked, box, most)
    p, d = grid[0], len(asked.load)
    y, z = asked.position.reshape(p, p, 2)[:, 0, 0], asked.position.reshape(p, p, 2)[0, :, 1]
    ambiguous = np.ones(p * p)
    if np.isfinite(values["unfelt"]):
        every = np.repeat(asked.position, d, axis=0), np.tile(asked.load, (p * p, 1))
        c = told.covariance.reshape(p * p * d, *told.covariance.shape[2:])
        spread = np.stack([c[:, 0, 0], c[:, 0, 1], c[:, 1, 1]], axis=-1)
        shares = field.survey(touches, *every, spread, box, most)[:, SHARES.index("ambiguous")].reshape(p * p, d)
        own = asked.weight / asked.weight.sum(axis=1, keepdims=True)
        ambiguous = (shares * own).sum(axis=1)
    read = _check.read_only
    stds = {name: read(v.reshape(p, p, d)) for name, v in told.stds(asked.load).items() if name in AREA_STDS}
    (a, b), (e, f) = box.tolist()
    return AreaQuality(
        finger, touches, ((a, b), (e, f)), read(y.copy()), read(z.copy()), read(asked.load),
        read(asked.weight.reshape(p, p, d)), read(told.covariance.reshape(p, p, d, *told.covariance.shape[2:])),
        told.rank.reshape(p, p, d), stds, read(ambiguous.reshape(p, p)), values,
    )  # fmt: skip


def field_of(finger: Finger, touches: Touches, box: FloatArray) -> AreaField:
    """The whitened tables of any finger on an area; its sensors are live."""
    points = finger.array.points
    reach = float(np.hypot(*np.abs(box[None] - points[:, :, None]).max(axis=(0, 2))))
    noise = np.asarray(finger.array.noise)
    wider, tables = tables_of(finger, tabulate_radial(finger, reach), touches)
    whitened = tuple(replace(table, gain=table.gain / noise) for table in tables)
    return AreaField(whitened, wider, *compiled_tables(whitened[len(whitened) // 2]))
