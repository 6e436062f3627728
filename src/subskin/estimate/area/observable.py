"""What a finger's sensors can tell of a local load: which of (y, z, N, Ty, Tz), how well, and which combination not.

At nu = 1/2 every stress and strain beneath a point load is (F.r) times a function of position, r from the load to the
sensor; so F is seen only as far as the r span space. Sensors on one straight line see four of the five unknowns,
however many there are, and the same holds at any nu for a normal strain, a normal stress or a pressure
(docs/locating_area.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._frozen import Frozen
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...prepared import prepared

__all__ = ["Observable", "observable", "refuse_blind"]

NAMES = ("y", "z", "N", "Ty", "Tz")
_STEP = 1e-3
_NOTHING = 1e-5
"""Share of the best seen combination below which another is not seen at all."""
_SHOWN = 0.15
_TRIAL = np.array([1.0, 0.25, 0.15])
_OFF = ((0.1, 0.3), (-0.2, -0.15), (0.35, -0.05))
"""Where loads are tried, in shares of the array's extent about its middle; none stands on an axis of it."""


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
    if position is None:
        at = _middle(finger) + np.array(_OFF[0]) * np.maximum(np.ptp(array.points, axis=0), 2 * depth)
    else:
        at = _check.real("position", position, unit="m")
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
        array, tried = finger.array, []
        extent = np.maximum(np.ptp(array.points, axis=0), 2 * float(np.asarray(array.depth).min()))
        for off in _OFF:
            tried.append(observable(finger, _middle(finger) + np.array(off) * extent))
        return max(tried, key=lambda told: told.rank)

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


def _middle(finger: Finger) -> FloatArray:
    points = finger.array.points
    return np.asarray(0.5 * (points.min(axis=0) + points.max(axis=0)))
