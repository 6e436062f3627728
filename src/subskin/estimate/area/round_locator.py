"""The estimator of round contacts of some half width: prepared once for a response on an area, called on frames."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ...array import SensorArray
from ...errors import InvalidValueError
from ...radial_round import RoundResponse
from ..frames import sensor_rows
from ..layout import ROUND, TWIST, Layout
from . import point
from .locator import AreaLocator
from .round_contact import RoundModel
from .round_project import RoundSearch
from .settings import plain

__all__ = ["RoundLocator", "model_of"]

_SCANNED = 5
"""Half widths at which the scan looks."""


class RoundLocator(AreaLocator):
    """Finds the round contact of a family in frames of readings: position, forces and half width.

    The search is global in all three coordinates; readings know the square of the half width, so that its interval
    begins at 0 where they cannot tell the contact from a point (docs/fitting_area.md).

    Parameters
    ----------
    response : RoundResponse
        Readings under unit forces; it has to reach as that of an `AreaLocator`.
    array, search
        As of `AreaLocator`.
    half_width : (float, float)
        Least and largest half width [m]; twice the same where it is known.
    moment : RoundResponse, optional
        Readings under a unit moment about the normal, in place of N: then a moment is fitted as well.
    options
        `beyond`, `friction`, `scan_step`, `false_alarm`, `ambiguity`, `outliers`, as of `AreaLocator`.

    Raises
    ------
    InvalidValueError, GeometryError
        As of `AreaLocator`; half widths that the response does not reach.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid((2, 4), pitch=2e-3, depth=2e-3, noise=1e-4)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> locator = finger.locator("round_punch", search=((-3e-3, 3e-3), (-4e-3, 4e-3)))
    >>> locator.half_width, locator.unknowns
    ((0.0, 0.003), 6)
    """

    layout: Layout = ROUND
    response: RoundResponse  # type: ignore[assignment]

    def __init__(
        self,
        response: RoundResponse,
        array: SensorArray,
        search: tuple[tuple[float, float], tuple[float, float]],
        half_width: tuple[float, float],
        *,
        moment: RoundResponse | None = None,
        **options: Any,
    ) -> None:
        low, high = (_check.scalar("half_width", value, unit="m", at_least=0.0) for value in half_width)
        if not low <= high <= response.widest * (1 + 1e-12):
            rule = f"ascending half widths up to {response.widest:.6g} m are needed"
            raise InvalidValueError(f"half_width = {half_width!r}", rule, "half_width=(0.0, 2e-3)")
        self.moment = moment
        if moment is not None:
            self.layout = TWIST
        self.half_width, self.wide = (low, min(high, response.widest)), high > low
        super().__init__(response, array, search, **options)  # type: ignore[arg-type]

    def _kernel(self) -> Any:
        from .round_project import project_round

        return project_round

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        array, response = self.array.select(pattern), self.response.select(pattern).separate()
        contact, error = _model(response, array)
        low, high = np.square(self.half_width)
        widths = np.linspace(low, high, _SCANNED) if self.wide else np.array([low])
        parts = [partial(self.response.at, float(np.sqrt(q))) for q in widths]
        cells = int(contact.first[-1]) + 1
        terms = contact.terms if response.table.pair is None else contact.terms[:0]
        shares = np.polynomial.chebyshev.chebvander(2 * widths / contact.most - 1, contact.sums.shape[-1] - 1)
        tables = np.ascontiguousarray(np.einsum("rnj,wj->wrn", contact.sums, shares))
        far = [0, -1] if self.wide else [0]
        narrowest = response.at(float(np.sqrt(low)))
        points = point.model_of(narrowest, np.asarray(array.noise), cells, tables[0], terms)
        tiles, beyond, sizes = self._looked_at(points, parts, far, pattern)
        if self.moment is not None:
            part = self.moment.select(pattern)
            turns, wrong = part.cubics()
            turns = np.ascontiguousarray(turns.reshape(turns.shape[0] * cells, -1, turns.shape[-1]))
            turned = np.ascontiguousarray(part.table.terms).astype(np.int64)
            contact, error = contact._replace(turns=turns, turned=turned), max(error, wrong)
        settings = self._settings(array, narrowest, error)
        search = RoundSearch(contact, points, tables, widths, widths[far], np.array([low, high]), tiles, settings)
        return sensor_rows(array), plain(search), plain(beyond), sizes


def model_of(response: RoundResponse, array: SensorArray) -> RoundModel:
    """What climbs over round contacts go by, without a moment.

    Parameters
    ----------
    response : RoundResponse
        Readings under unit forces of the sensors of `array`.
    array : SensorArray
        Their noise.
    """
    return _model(response, array)[0]


def _model(response: RoundResponse, array: SensorArray) -> tuple[RoundModel, float]:
    """As `model_of`, and the error of the tables."""
    response = response.separate()
    (sums, error), table = response.cubics(), response.table
    pair, cells, harmonics = table.pair, sums.shape[1], table.terms
    if pair is not None:
        sums = np.stack([sign * sums[:, :, function] for function, sign in pair], axis=2)
        harmonics = np.array([[0, 0, 0, 0, 1], [1, 1, 0, 1, 1], [2, 1, 1, 1, 1]])
    sums = np.ascontiguousarray(sums.reshape(sums.shape[0] * cells, -1, sums.shape[-1]))
    scale = 1 / np.asarray(array.noise)
    sensors = np.ascontiguousarray(np.stack([*table.points.T, table.depth**-2.0, table.gain * scale]))
    first = np.append(table.kind * cells, cells - 1).astype(np.int64)
    harmonics, none = np.ascontiguousarray(harmonics).astype(np.int64), np.empty((0, 0))
    return RoundModel(
        sensors, first, sums, harmonics, response.widest**2, sums[:0], harmonics[:0], none, none, none
    ), error  # fmt: skip
