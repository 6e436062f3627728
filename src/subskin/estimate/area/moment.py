"""Whether a finger's sensors tell the moment about the normal of a round contact."""

from __future__ import annotations

import numpy as np

from ... import _check
from ..._check import FloatArray
from ...contact import RoundContact
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...radial_round import RoundResponse, tabulate_moment, tabulate_round

__all__ = ["moment_of"]

_FEWEST = 8
"""Readings from which a moment is fitted if nothing is said: one more than unknowns."""
_ALIKE = 1e-3
"""Share of a moment's readings that nothing else explains, below which the sensors do not tell it."""
_TRIAL = np.array([1.0, 0.25, 0.15])
_AT = ((0.1, 0.3), (-0.2, -0.15), (0.35, -0.05))
_WIDTH, _STEP = 0.5, 1e-3
"""Half width of the trial, in the largest one; steps of differences, in depths."""


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
    if made is not None and enough and _share(finger, tabulate_round(finger, family, radius, widest), made) > _ALIKE:
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
    array = finger.array
    points, h = array.points, _STEP * float(np.asarray(array.depth).min())
    extent = np.maximum(np.ptp(points, axis=0), 2 * float(np.asarray(array.depth).min()))
    a = _WIDTH * response.widest
    scale = (1 / np.where(np.asarray(array.noise) > 0, array.noise, np.inf))[array.live]

    def read(at: FloatArray, width: float) -> FloatArray:
        return np.asarray((response.at(width)(at) @ _TRIAL)[array.live] * scale)

    best = 0.0
    for off in _AT:
        at = 0.5 * (points.min(axis=0) + points.max(axis=0)) + np.array(off) * extent
        turned = moment.at(a)(at)[array.live, 0] * scale
        slopes = [read(at + step, a) - read(at - step, a) for step in (np.array([h, 0]), np.array([0, h]))]
        others = [*slopes, read(at, a + h) - read(at, a - h), *(response.at(a)(at)[array.live] * scale[:, None]).T]
        matrix = np.column_stack([each / max(float(np.linalg.norm(each)), 1e-300) for each in others])
        rest = turned - matrix @ np.linalg.lstsq(matrix, turned, rcond=1e-9)[0]
        best = max(best, float(np.linalg.norm(rest) / max(float(np.linalg.norm(turned)), 1e-300)))
    return best
