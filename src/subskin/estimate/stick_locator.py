"""The estimator of round contacts that stick in their middle and slip at their edges."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..array import SensorArray
from ..errors import InvalidValueError
from ..response import Response
from .frames import Framewise, packed
from .search import Locator

__all__ = ["StickLocator", "checked_stick"]

_START = 0.9
"""Share of slip |T| / (mu N) that the global search takes all contacts to have."""
_MOST = 100.0


class StickLocator(Locator):
    """Finds round contacts that stick where |y - position| < c = a sqrt(1 - |T| / (mu N)), as `PartialSlip` does.

    The search is the `Locator`'s, with the shear of a contact close to slipping; the best contact and its rival
    are then climbed to with that of Cattaneo and Mindlin at their own |T| / (mu N). Beyond mu N the contact slides and
    the drag is in proportion to the pressure; how far beyond a load may lean is what `friction` says.

    Parameters
    ----------
    response : Response
        Readings under Hertz contacts of unit forces, the drag in proportion to the pressure.
    array : SensorArray
        As in `Locator`.
    stick : float or (float, float)
        Coefficient of friction mu between skin and body [-]: known, or a range, all of it as likely.
    **options
        As in `Locator`; friction > 0.

    Raises
    ------
    InvalidValueError, GeometryError
        As in `Locator`; `stick` out of range, a `friction` of 0.
    """

    def __init__(
        self, response: Response, array: SensorArray, stick: float | tuple[float, float], **options: Any
    ) -> None:
        self.stick = checked_stick(stick)
        super().__init__(response, array, **options)
        if self.friction == 0:
            rule = "a contact without drag has no zone that sticks"
            raise InvalidValueError("friction = 0 with stick", rule, "leave one of them out")
        self._searched = _slipping(response, _START)

    takes_doubt = False

    _doubted = Framewise._doubted

    def _fill(self, frames: FloatArray, arrays: tuple[Any, ...], out: FloatArray) -> None:
        from .stick import stick_frames

        search, own = arrays
        super()._fill(frames, search, out)
        stick_frames(frames, search[0], *own, self.layout.named(out))

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        *arrays, searched = super()._prepare(pattern)
        response = self.response.select(pattern)
        told = searched.copy()
        told["start"], told["step"], told["widest"] = response.start, response.step, response.widest
        searched["largest"] = np.inf  # what the search leaves unexplained, the climb may explain
        guess, spread = 0.5 * sum(self.stick), (self.stick[1] - self.stick[0]) / np.sqrt(12)
        (first, last), (least, most), (low, high) = self._search_ends, self.normal_force, np.square(self.half_width)
        low, high = ([first, least, -np.inf, low, self.stick[0]], [last, most, np.inf, high, self.stick[1]])
        table = packed(response, 1 / np.asarray(self.array.noise)[pattern])
        ends = np.array(low, float), np.array(high, float), guess, 1 / spread if spread else 0.0
        return (*arrays, searched), (table, told, np.unique([*self.stick, guess]), *ends)


def _slipping(response: Response, slip: float) -> Response:
    """The response with the shear of contacts that slip by a set share |T| / (mu N): the mean of G' (`stick`)."""
    from .stick import NODES, WEIGHTS

    chebyshev = np.polynomial.chebyshev
    widths = len(response.coefficients)
    shares = 0.5 * (1 + np.cos(np.pi * (np.arange(widths) + 0.5) / widths))
    below = shares[:, None] * (1 - slip * NODES)
    rising = np.stack([chebyshev.chebval(2 * below - 1, chebyshev.chebder(row)) for row in np.eye(widths)], axis=-1)
    means = WEIGHTS @ (chebyshev.chebvander(2 * below - 1, widths - 1) + 2 * below[..., None] * rising)
    mixed = np.linalg.solve(chebyshev.chebvander(2 * shares - 1, widths - 1), means)
    coefficients = response.coefficients.copy()
    coefficients[..., 1] = np.einsum("vw,wckn->vckn", mixed, response.coefficients[..., 1])
    return replace(response, coefficients=coefficients)


def checked_stick(stick: Any) -> tuple[float, float]:
    """The least and the largest coefficient of friction that `stick` states."""
    rule = "a coefficient of friction, or two that ascend, are needed [-]"
    values = _check.real("stick", stick, above=0.0, at_most=_MOST, fix="rubber on glass: 1; a dry finger: 0.5")
    if values.shape not in ((), (2,)) or (values.size == 2 and values[0] > values[1]):
        raise InvalidValueError(f"stick = {stick!r}", rule, "stick=0.5 or stick=(0.4, 0.8)")
    low, high = np.broadcast_to(values, 2).tolist()
    return low, high
