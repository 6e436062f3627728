"""What a finger's sensors can tell of a local load: which of (y, z, N, Ty, Tz), how well, and which combination not.

At nu = 1/2 every stress and strain beneath a point load is (F.r) times a function of position, r from the load to the
sensor; so F is seen only as far as the r span space. Sensors on one straight line see four of the five unknowns,
however many there are, and the same holds at any nu for a normal strain, a normal stress or a pressure
(docs/locating_area.md). Whether they tell a moment about the normal, and a load from another one close by.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._frozen import Frozen
from ...contact import RoundContact
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...prepared import prepared
from ...radial_round import RoundResponse, tabulate_moment, tabulate_round
from ..cone import eliminate_three
from .tiles import Seen

__all__ = ["Observable", "least_told_apart", "moment_of", "observable", "refuse_blind"]

NAMES = ("y", "z", "N", "Ty", "Tz")
_STEP = 1e-3
_NOTHING = 1e-5
"""Share of the best seen combination below which another is not seen at all."""
_SHOWN = 0.15
_TRIAL = np.array([1.0, 0.25, 0.15])
_OFF = ((0.1, 0.3), (-0.2, -0.15), (0.35, -0.05))
"""Where loads are tried, in shares of the array's extent about its middle; none stands on an axis of it."""
_FEWEST = 8
"""Readings from which a moment is fitted if nothing is said: one more than unknowns."""
_UNTOLD = 1e-3
"""Share of a moment's readings that nothing else explains, below which the sensors do not tell it."""
_WIDTH = 0.5
"""Half width of the trial, in the largest one."""
_AWAY = (0.25, 0.4, 0.55)
"""Depths from a load to the one that reads like it: nearer ones are one top, farther ones the scan tells apart."""
_TURNS = 2 * np.pi * np.arange(12) / 12
_OVER = np.array([0.2, 0.4, 0.6, 0.8])
"""Where loads stand, in shares of the sensors' box."""
_LEANS = 0.5
"""Drag over the normal force, or the friction where that is less."""


@dataclass(frozen=True, eq=False, repr=False)
class Observable(Frozen):
    """What the sensors tell of (y, z, N, Ty, Tz) of one load; its `repr` says it in words.

    Parameters
    ----------
    position : ndarray, shape (2,)
        Where the load presses [m].
    components : ndarray, shape (3,)
        Its (N, Ty, Tz) [N].
    rank : int
        How many of the five unknowns, or of their combinations, the readings determine.
    std : ndarray, shape (5,)
        Standard deviation of each [m, m, N, N, N]; infinite where the readings do not determine it.
    blind : ndarray, shape (5 - rank, 5)
        Combinations of which they say nothing: changes of y, z [depths] and of N, Ty, Tz [shares of the force].
    """

    position: FloatArray
    components: FloatArray
    rank: int
    std: FloatArray
    blind: FloatArray

    @property
    def words(self) -> str:
        """What the readings leave open, as a sentence; empty where nothing."""
        said = []
        for row in self.blind:
            lead = row / row[np.argmax(np.abs(row))]
            parts = [f"{value:+.2g} {name}" for name, value in zip(NAMES, lead, strict=True) if abs(value) > _SHOWN]
            said.append(" ".join(parts).lstrip("+").replace("1 ", "", 1) if len(parts) == 1 else " ".join(parts))
        return "; ".join(said)

    def __repr__(self) -> str:
        told = [
            f"{name} +- {1e3 * s:.2g} mm" if name in "yz" else f"{name} +- {s:.2g} N"
            for name, s in zip(NAMES, self.std, strict=True)
            if np.isfinite(s)
        ]
        blind = f"; not determined: {self.words}" if self.words else ""
        return f"Observable({self.rank} of 5 unknowns: {', '.join(told) or 'none by itself'}{blind})"


def observable(
    finger: Finger, position: npt.ArrayLike | None = None, components: npt.ArrayLike = (1.0, 0.25, 0.15)
) -> Observable:
    """Which of (y, z, N, Ty, Tz) a finger's sensors determine, how well, and which combination not.

    Parameters
    ----------
    finger : Finger
        The forward model, of a skin that takes local contacts; its sensors' noise sets the standard deviations.
    position : array_like, shape (2,), optional
        Where the load presses (y, z) [m]; off the middle of the array, on none of its axes, if left out.
    components : array_like, shape (3,), optional
        Its (N, Ty, Tz) [N].

    Returns
    -------
    Observable
        Rank, standard deviations and blind combinations; a moment about the normal is no unknown here: normal strain,
        normal stress and pressure never see it.

    Raises
    ------
    InvalidValueError, GeometryError
        A skin solved in a plane, a position or components of another shape.

    Examples
    --------
    >>> import subskin as ss
    >>> from subskin.estimate.area import observable
    >>> skin = ss.HalfSpace(ss.Material(young=0.4e6))
    >>> row = ss.SensorArray(y=[-4e-3, -2e-3, 0.0, 2e-3, 4e-3], z=1e-3, depth=2e-3, noise=1e-4)
    >>> observable(ss.Finger(skin, row)).rank
    4
    >>> observable(ss.Finger(skin, ss.SensorArray.grid((2, 3), pitch=2e-3, depth=2e-3, noise=1e-4))).rank
    5
    """
    array = finger.array
    depth = float(np.asarray(array.depth).min())
    at = _trials(finger)[0] if position is None else _check.real("position", position, unit="m")
    force = _check.real("components", components, unit="N")
    if at.shape != (2,) or force.shape != (3,):
        seen = f"position of shape {at.shape}, components of shape {force.shape}"
        raise GeometryError(seen, "one load is needed: (y, z) and (N, Ty, Tz)", "position=(0.0, 1e-3)")
    if not finger.skin.takes_local:
        rule = "it is solved in a plane and knows no touch on an area"
        raise InvalidValueError(f"the skin {finger.skin}", rule, "HalfSpace(material)")
    h = _STEP * depth
    moves = np.array([[0, 0], [h, 0], [-h, 0], [0, h], [0, -h], [2 * h, 0], [-2 * h, 0], [0, 2 * h], [0, -2 * h]])
    fields = finger.receptive_field(at + moves, "point")  # (9, n, 3)
    if not np.isfinite(fields[:, array.live]).all():
        kinds = ", ".join(sorted({type(kind).__name__ for kind in array.transducers}))
        raise InvalidValueError(
            f"readings of {kinds} that are no numbers", "each load has a reading", "numbers from measure"
        )
    noise = np.where(np.asarray(array.noise) > 0, array.noise, np.inf if np.any(array.noise) else 1.0)
    fields = (fields / noise[:, None])[:, array.live]
    felt = fields @ force
    by_y, by_z = (
        (8 * (felt[i] - felt[i + 1]) - (felt[i + 4] - felt[i + 5])) / (12 * h) for i in (1, 3)
    )  # fmt: skip
    size = float(np.linalg.norm(force))
    units = np.array([depth, depth, size, size, size])
    jacobian = np.column_stack([by_y, by_z, fields[0]]) * units
    _, values, rows = np.linalg.svd(jacobian, full_matrices=True)
    values = np.concatenate([values, np.zeros(5 - values.size)])
    seen_rows = values > _NOTHING * values.max()
    rank = int(seen_rows.sum())
    blind = rows[~seen_rows]
    with np.errstate(divide="ignore"):
        std = units * np.sqrt(((rows[seen_rows] / values[seen_rows, None]) ** 2).sum(axis=0))
    std[(np.abs(blind) > 1e-3).any(axis=0)] = np.inf
    return Observable(_check.real("position", at), force, rank, _check.real("std", std, finite=False), blind)


def refuse_blind(finger: Finger) -> None:
    """Refuse a finger whose sensors leave one of the five unknowns open wherever a load stands.

    Raises
    ------
    GeometryError
        With the combination that cannot be told.
    """

    def best() -> Observable:
        return max((observable(finger, at) for at in _trials(finger)), key=lambda told: told.rank)

    told = prepared(finger).get(("observable",), best)
    if told.rank < 5:
        points = finger.array.points
        straight = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        line = straight.size < 2 or straight[1] <= 1e-9 * max(straight[0], 1e-300)
        why = "sensors on one straight line" if line else f"{len(points)} sensors"
        raise GeometryError(
            f"{why} that tell {told.rank} of the five unknowns (y, z, N, Ty, Tz)",
            f"a load may change by this without a reading that changes: {told.words}",
            "sensors off that line, at least 2 x 3; or locate the load as a line on a row with z = 0",
        )


def _trials(finger: Finger) -> FloatArray:
    """Where loads are tried, (3, 2)."""
    points, depth = finger.array.points, float(np.asarray(finger.array.depth).min())
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return np.asarray(middle + np.array(_OFF) * np.maximum(np.ptp(points, axis=0), 2 * depth))


def moment_of(
    finger: Finger, family: type[RoundContact], radius: float, widest: float, wanted: object
) -> RoundResponse | None:
    """The response to a moment where it is to be fitted: if nothing is said, where the sensors tell it.

    Parameters
    ----------
    finger, family, radius, widest
        As of `tabulate_round`.
    wanted : bool or None
        Whether it is fitted; None: where it can be.

    Raises
    ------
    InvalidValueError, GeometryError
        Something that is no bool; a moment that is wanted and cannot be told.
    """
    if wanted is not None and not isinstance(wanted, bool | np.bool_):
        raise InvalidValueError(f"moment = {_check.shown(wanted)}", "has to be True, False or None", "moment=True")
    live = int(finger.array.live.sum())
    if wanted is False or (wanted is None and live < _FEWEST):
        return None
    made = tabulate_moment(finger, family, radius, widest)
    enough = made is not None and live > _FEWEST - 2
    if made is not None and enough and _share(finger, tabulate_round(finger, family, radius, widest), made) > _UNTOLD:
        return made
    if wanted:
        why = "no sensor reads it" if made is None else f"{live} sensors cannot tell it from the other unknowns"
        rule = (
            "normal strain, pressure and normal stress do not see a moment about the normal; seven unknowns need seven"
        )
        raise GeometryError(f"moment = True: {why}", rule, "sensors of shear or of displacement, or leave moment out")
    return None


def _share(finger: Finger, response: RoundResponse, moment: RoundResponse) -> float:
    """Share of a moment's readings, weighed by the noise, that no other unknown makes; the best of few."""
    array, best, a = finger.array, 0.0, _WIDTH * response.widest
    h = _STEP * float(np.asarray(array.depth).min())
    scale = (1 / np.where(np.asarray(array.noise) > 0, array.noise, np.inf))[array.live]

    def read(at: FloatArray, width: float) -> FloatArray:
        return np.asarray((response.at(width)(at) @ _TRIAL)[array.live] * scale)

    for at in _trials(finger):
        turned = moment.at(a)(at)[array.live, 0] * scale
        slopes = [read(at + step, a) - read(at - step, a) for step in (np.array([h, 0]), np.array([0, h]))]
        others = [*slopes, read(at, a + h) - read(at, a - h), *(response.at(a)(at)[array.live] * scale[:, None]).T]
        matrix = np.column_stack([each / max(float(np.linalg.norm(each)), 1e-300) for each in others])
        rest = turned - matrix @ np.linalg.lstsq(matrix, turned, rcond=1e-9)[0]
        best = max(best, float(np.linalg.norm(rest) / max(float(np.linalg.norm(turned)), 1e-300)))
    return best


def least_told_apart(seen: Seen, most: float) -> float:
    """The least share of a load's squared readings that no load about half a depth away explains; infinite over `most`.

    Loads press, and lie within the cone of friction.
    """
    low, high = seen.points.min(axis=0), seen.points.max(axis=0)
    at = np.stack(np.meshgrid(*(low[i] + (high[i] - low[i]) * _OVER for i in (0, 1))), axis=-1).reshape(-1, 2)
    ring = seen.depth * np.concatenate([r * np.stack([np.cos(_TURNS), np.sin(_TURNS)], axis=-1) for r in _AWAY])
    mu, parts = seen.friction, 3 if seen.friction > 0 else 1
    lean = min(_LEANS, mu)
    forces = np.array([(1, 0, 0), (1, lean, 0), (1, -lean, 0), (1, 0, lean), (1, 0, -lean)])
    felt = forces @ seen(at).swapaxes(1, 2)  # positions, forces, sensors
    near = seen((at[:, None] + ring).reshape(-1, 2)).reshape(len(at), len(ring), seen.sensors, 3)
    gram = near.swapaxes(2, 3) @ near
    along = np.einsum("prnk,pfn->prfk", near, felt) / np.linalg.norm(felt, axis=2)[:, None, :, None]
    # what a load that may pull or slide explains is the most
    inverse = np.linalg.pinv(gram[..., :parts, :parts], hermitian=True)
    load = (inverse[:, :, None] @ along[..., :parts, None])[..., 0]
    left = 1.0 - (along[..., :parts] * load).sum(axis=-1)
    inside = (load[..., 0] >= 0) & (np.linalg.norm(load[..., 1:], axis=-1) <= mu * load[..., 0])
    least = float(np.min(left, where=inside, initial=most))
    for p, r, f in np.argwhere((left < least) & ~inside):
        explained = eliminate_three(*gram[p, r][np.triu_indices(3)], *along[p, r, f], mu)[3]
        least = min(least, 1.0 - explained)
    return least if least < most else np.inf
