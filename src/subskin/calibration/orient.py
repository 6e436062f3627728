"""Which way round: what symmetry hides from every status, confirmed by presses at told positions.

A cable in reversed order, a mirrored board, swapped axes or the wrong sign of all readings give answers that are OK and
far off, since a touch elsewhere reads the same. Only a press whose position is known tells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from .._shown import Tabled, with_error
from ..errors import GeometryError
from ..finger import Finger, finger_needed
from .calibration import checked_readings

__all__ = ["Orientation", "orient", "telling", "ways"]

_TURNS = (
    ("as drawn", (1, 0, 0, 1)),
    ("in reversed order, or turned by 180 degrees", (-1, 0, 0, -1)),
    ("mirrored: y has the wrong sign", (-1, 0, 0, 1)),
    ("mirrored: z has the wrong sign", (1, 0, 0, -1)),
    ("y and z are swapped", (0, 1, 1, 0)),
    ("y and z are swapped, and both have the wrong sign", (0, -1, -1, 0)),
    ("turned by 90 degrees", (0, -1, 1, 0)),
    ("turned by 270 degrees", (0, 1, -1, 0)),
)
"""What a board may be, and the positions that its sensors then have, of those drawn: (yy, yz, zy, zz)."""
_NEAR = 0.1
"""Share of the least distance between sensors within which positions are the same."""
_SURE, _POSSIBLE, _CLEAR = 0.99, 0.01, 20.0
"""Probabilities of what is sure and of what cannot be left out; and the chi-square that tells swapped neighbours."""
_EXPLAINED = 1e-4
"""Probability with which the right order is said to explain nothing."""
_NOTHING = 1e12
"""Chi-square of readings that no load explains at all."""


@dataclass(frozen=True, eq=False, repr=False)
class Orientation(Tabled, Frozen):
    """What `orient` found.

    Parameters
    ----------
    name : str
        How the sensors are connected, in words: "as drawn".
    order : ndarray of int, shape (n,)
        The channel that each sensor is read by: `readings[:, order]` are those of the finger as drawn.
    sign : int
        1, or -1 where all readings have the wrong sign.
    probability : float
        Of this one [-], among all that a symmetry of the board allows; 0 where no order explains the presses.
    scale, scale_std : float
        The force found over the force told [-], and its standard deviation; NaN where no force was told.
    open : tuple of (int, int)
        Neighbouring channels that might be swapped for all that these presses say.
    press : int or None
        The sensor to press next where it is not sure; None where it is.
    """

    name: str
    order: npt.NDArray[np.intp]
    sign: int
    probability: float
    scale: float
    scale_std: float
    open: tuple[tuple[int, int], ...]
    press: int | None

    @property
    def sure(self) -> bool:
        """Whether the presses leave no other choice."""
        return self.press is None

    @property
    def as_drawn(self) -> bool:
        """Whether it is sure that order and sign are those of the finger."""
        return self.sure and self.sign > 0 and bool((self.order == np.arange(self.order.size)).all())

    def _title(self) -> str:
        doubted = not self.sure and self.probability > 0
        return f"Orientation: {'not sure, perhaps ' if doubted else ''}{self.name}"

    def _shown(self) -> list[tuple[str, str]]:
        rows = [("probability", f"{self.probability:.4g}")]
        if not (self.order == np.arange(self.order.size)).all():
            rows.append(("order", "readings[:, [" + ", ".join(map(str, self.order)) + "]]"))
        rows += [("sign", "all readings have the wrong sign")] if self.sign < 0 else []
        if np.isfinite(self.scale):
            rows.append(("force", f"{with_error(self.scale, self.scale_std, '')} times what was told"))
        if self.open:
            rows.append(("open", "neighbours that may be swapped: " + ", ".join(f"s{i} s{j}" for i, j in self.open)))
        return rows + ([] if self.press is None else [("next", f"press near s{self.press}")])


def orient(
    finger: Finger,
    readings: npt.ArrayLike,
    near: npt.ArrayLike,
    *,
    force: npt.ArrayLike | None = None,
    reach: float | None = None,
    error: float = 0.06,
    friction: float = 0.5,
) -> Orientation:
    """How the sensors are connected, from one to three presses at told positions.

    Each way that a symmetry of the positions allows, of either sign, is tried: the presses are located within `reach`
    of what was told, by readings in that order. The chi-squares of all presses give probabilities. Then neighbouring
    channels are swapped, one pair after the other.

    Parameters
    ----------
    finger : Finger
        The finger as it is drawn, with the sensors' noise.
    readings : array_like, shape (presses, n)
        Raw readings while the skin is pressed [reading].
    near : array_like, shape (presses,) or (presses, 2)
        Where it was pressed: y, or y and z [m]. `telling` says where a press tells most.
    force : array_like, shape () or (presses,), optional
        How hard [N/m], on an area [N], where somebody knows.
    reach : float, optional
        How far from the told position a press may have been, along y and z [m]; half the depth of the shallowest sensor
        if left out.
    error : float, optional
        Error of readings, of the largest of a press, beside the noise [-]: no finger is exactly its drawing.
    friction : float, optional
        Largest coefficient of friction: presses lean a little.

    Raises
    ------
    GeometryError, InvalidValueError
        Readings, positions or forces of another number; a sensor without noise; an option out of range.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, noise=4e-5)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> at = array.points[ss.calibration.telling(finger, 2)]
    >>> touch = ss.PointLoad(force=1.0, position=at + 0.8e-3)
    >>> found = orient(finger, finger.read(touch)[:, ::-1], at)  # the cable is the wrong way round
    >>> found.name, found.sure, found.order[:3].tolist()
    ('in reversed order, or turned by 180 degrees', True, [15, 14, 13])
    """
    from scipy.special import chdtri

    finger_needed(finger)
    array = finger.array
    data, where = checked_readings(readings, len(array)), _check.real("near", near, unit="m")
    if where.shape != ((len(data), 2) if array.on_area else (len(data),)) or not len(data):
        rule = "one position for each press is needed, on an area y and z"
        raise GeometryError(f"near of shape {where.shape}, readings of {data.shape}", rule, "near=[[1e-3, 2e-3]]")
    told = None if force is None else np.broadcast_to(_check.real("force", force, above=0.0), len(data))
    depth = float(np.asarray(array.depth).min())
    away = 0.5 * depth if reach is None else _check.scalar("reach", reach, unit="m", above=0.0)
    share = _check.scalar("error", error, at_least=0.0, at_most=1.0)
    offset, gain = np.asarray(array.offset), np.where(array.live, array.gain, 1.0)
    bare = (data - offset) / gain
    kinds: list[dict[str, Any]] = [{"family": "point" if array.on_area else "line"}]
    if not array.on_area and finger.skin.takes_local:
        kinds.append({"family": "point", "beside": 0.0})
    of_kind: list[list[Any]] = [[] for _ in kinds]
    for at, press in zip(where, bare * gain, strict=True):
        noisy = replace(array, noise=np.hypot(array.noise, share * np.nanmax(np.abs(press))), low=-np.inf, high=np.inf)
        ends = np.stack([at - away, at + away], axis=-1).tolist()
        search: Any = tuple(map(tuple, ends)) if array.on_area else tuple(ends)
        part = replace(finger, array=noisy, tolerances=None)
        for kind, made in zip(kinds, of_kind, strict=True):
            made.append(part.locator(**kind, search=search, friction=friction))

    def tried(order: npt.NDArray[np.intp], sign: int) -> tuple[float, FloatArray]:
        """Chi-square that is left of all presses, and the normal force of each with its standard deviation."""
        return min((of_one(locators, order, sign) for locators in of_kind), key=lambda each: each[0])

    def of_one(locators: list[Any], order: npt.NDArray[np.intp], sign: int) -> tuple[float, FloatArray]:
        """The same where all press alike: lines, or points."""
        found = [one(offset + gain * sign * press[order]) for one, press in zip(locators, bare, strict=True)]
        left = [float(np.nan_to_num(f.residual, nan=np.inf)) for f in found]
        k = 2 if array.on_area else 1
        force = [(float(f.load.components[0]), float(np.sqrt(f.load.covariance[k, k]))) for f in found]
        return min(float(np.sum(left)), _NOTHING), np.array(force)

    possible_ways = [(name, order, sign) for name, order in ways(array.points) for sign in (1, -1)]
    left = np.array([tried(order, sign)[0] for _, order, sign in possible_ways])
    chance = np.exp(-0.5 * (left - left.min()))
    chance /= chance.sum()
    best = int(np.argmin(left))
    (name, order, sign), base = possible_ways[best], float(left[best])
    others = [np.where(order == i, i + 1, np.where(order == i + 1, i, order)) for i in range(len(array) - 1)]
    more = np.array([tried(other, sign)[0] - base for other in others])
    if more.size and more.min() < -_CLEAR:
        i = int(np.argmin(more))
        order, name, base = others[i], f"{name}, but channels s{i} and s{i + 1} are swapped", base + float(more[i])
        more = more - more[i]
        more[i] = np.inf
    spare = len(data) * max(len(array) - of_kind[0][0].unknowns, 1)
    explained = base <= float(chdtri(spare, _EXPLAINED))
    if not explained:
        none = np.empty(0, dtype=np.intp), np.arange(len(array)), "no order explains the presses"
        possible, (more, order, name), sign, probability = [], none, 1, 0.0
    else:
        probability = float(chance[best])
        possible = [way[1] for way, p in zip(possible_ways, chance, strict=True) if p >= _POSSIBLE]
    ratio = np.full((len(data), 2), np.nan)
    if explained and told is not None:
        ratio = tried(order, sign)[1] / told[:, None]
    return Orientation(
        name=name + ("" if sign > 0 else ", of the wrong sign"), order=order, sign=sign, probability=probability,
        scale=float(ratio[:, 0].mean()), scale_std=float(np.sqrt((ratio[:, 1] ** 2).sum()) / len(data)),
        open=tuple((i, i + 1) for i in np.flatnonzero(more < _CLEAR).tolist()),
        press=None if probability >= _SURE else _most_telling(array.points, possible)[0],
    )  # fmt: skip


def telling(finger: Finger, presses: int = 1) -> list[int]:
    """The sensors near which presses tell most of which way round they are.

    Parameters
    ----------
    finger : Finger
        The finger as it is drawn.
    presses : int, optional
        How many.

    Raises
    ------
    InvalidValueError
        No press, or more than there are sensors.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=2e-3, depth=2e-3)
    >>> telling(ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array), 2)
    [1, 7]
    """
    finger_needed(finger)
    count = int(_check.scalar("presses", presses, at_least=1, at_most=len(finger.array)))
    return _most_telling(finger.array.points, [], count)


def _most_telling(points: FloatArray, possible: Sequence[npt.NDArray[np.intp]], presses: int = 1) -> list[int]:
    """Sensors that the possible orders, or all, move furthest apart; of such the ones furthest from each other."""
    orders = possible if len(possible) > 1 else [order for _, order in ways(points)]
    sites = np.stack([points[np.argsort(order)] for order in orders])  # of each channel
    pairs = np.triu_indices(len(orders), 1)
    apart = ((sites[:, None] - sites[None]) ** 2).sum(axis=-1)[pairs]
    far = ((points[:, None] - points) ** 2).sum(axis=-1)
    chosen: list[int] = []
    for _ in range(presses):
        told = apart + apart[:, chosen].sum(axis=1, keepdims=True)
        score = told.min(axis=0) if len(told) else np.zeros(len(points))
        beside = far[:, chosen].min(axis=1) if chosen else np.zeros(len(points))
        chosen.append(int(np.argmax(np.where(np.isin(np.arange(len(points)), chosen), -1.0, score + 1e-3 * beside))))
    return chosen


def ways(points: FloatArray) -> list[tuple[str, npt.NDArray[np.intp]]]:
    """Orders that symmetries of the positions allow, each once, with their names; the drawn one comes first."""
    centred = points - 0.5 * (points.min(axis=0) + points.max(axis=0))
    apart = np.linalg.norm(centred[:, None] - centred, axis=-1)
    close = _NEAR * float(apart[apart > 0].min()) if (apart > 0).any() else 0.0
    found: list[tuple[str, npt.NDArray[np.intp]]] = []
    for name, (yy, yz, zy, zz) in _TURNS:
        really = centred @ np.array([[yy, yz], [zy, zz]]).T
        away = np.linalg.norm(really[:, None] - centred, axis=-1)
        if (away.min(axis=1) > close).any():
            continue
        # of several channels at one position each keeps its own, by their order
        rank = np.array([np.count_nonzero(apart[i, :i] <= close) for i in range(len(points))])
        sensor = np.array([np.flatnonzero(away[i] <= close)[rank[i]] for i in range(len(points))])
        order = np.argsort(sensor)
        if not any((order == known).all() for _, known in found):
            found.append((name, order))
    return found
