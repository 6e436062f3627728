"""A response on an area to round contacts of some half width: radial tables, and how they change with the width.

A round contact reads as a point load does, by functions of the distance alone (`radial.py`); its half width changes the
functions. They are even in it, as its spectrum is, so each is a Chebyshev sum over the square of the half width.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from ._declared import Length, Ruled, checked
from ._frozen import Frozen
from .contact import RoundContact
from .errors import InvalidValueError
from .finger import Finger
from .prepared import prepared
from .radial import RadialResponse, sampled, shared, tabulate_radial

__all__ = ["RoundResponse", "tabulate_moment", "tabulate_round"]

WIDTHS = 14
"""Chebyshev nodes in the square of the half width."""
_MOST_WIDE = 2.0
"""Depths up to which half widths are tabulated."""
_FELT, _HIGHER = 1e-9, 2
"""Share of the readings under a force, per depth, below which a moment is not felt; how many harmonics more it has."""


def _round(name: str, family: Any) -> Any:
    if not isinstance(family, type) or not issubclass(family, RoundContact):
        seen = f"{name} = {_check.shown(family)}"
        raise InvalidValueError(seen, "a subclass of RoundContact is needed", "family=ss.RoundHertz")
    return family


_Family: TypeAlias = Annotated[type[RoundContact], Ruled(_round)]


@dataclass(frozen=True, eq=False)
class RoundResponse(Frozen):
    """Readings under a unit normal force and unit drags of a round contact, at any position and half width.

    Parameters
    ----------
    table : RadialResponse
        All but the coefficients.
    sums : ndarray, shape (widths, kinds, cells, functions, 6)
        Chebyshev sums of these over 2 (a / widest)^2 - 1, a being the half width [1/N/m^order].
    widest : float
        Largest half width [m].
    error : float
        Largest error seen between the nodes, of distance and of width, relative to the largest reading.
    """

    table: RadialResponse
    sums: FloatArray
    widest: float
    error: float = 0.0

    def __repr__(self) -> str:
        return f"RoundResponse({self.sensors} sensors, half widths to {self.widest:.4g} m)"

    @property
    def sensors(self) -> int:
        """Number of sensors."""
        return self.table.sensors

    def select(self, sensors: npt.ArrayLike) -> RoundResponse:
        """The response of some of the `sensors`, given by a mask or by indices."""
        return replace(self, table=self.table.select(sensors))

    def separate(self) -> RoundResponse:
        """As `RadialResponse.separate`."""
        table = self.table.separate()
        return self if table is self.table else replace(self, table=table, sums=self.table.lifted(self.sums)[1])

    def at(self, half_width: float) -> RadialResponse:
        """The response to contacts of one `half_width` [m], from 0 to the widest.

        Raises
        ------
        InvalidValueError
            Another half width.
        """
        half_width = _check.scalar("half_width", half_width, unit="m", at_least=0.0, at_most=self.widest * (1 + 1e-9))
        shares = np.polynomial.chebyshev.chebvander(2 * (half_width / self.widest) ** 2 - 1, len(self.sums) - 1)[0]
        return replace(self.table, coefficients=np.tensordot(shares, self.sums, 1), error=self.error)

    def cubics(self) -> tuple[FloatArray, float]:
        """The sums in cells where a cubic does, (kinds, cells, functions, 4, widths), and their error as of `error`."""
        widths, kinds = self.sums.shape[:2]
        flat = replace(self.table, coefficients=self.sums.reshape(widths * kinds, *self.sums.shape[2:]))
        finer, _ = flat.cubics()
        _, error = self.at(0.0).cubics()
        return np.moveaxis(finer.reshape(widths, kinds, *finer.shape[1:]), 0, -1), error


@checked
def tabulate_round(finger: Finger, family: _Family, radius: Length, widest: Length) -> RoundResponse:
    """A finger's response to round contacts of a family, to the distance `radius` from a sensor; tables are kept.

    Parameters
    ----------
    finger : Finger
        The forward model, of a skin that takes local contacts.
    family : subclass of RoundContact
        The shape.
    radius : float
        Largest distance along the surface [m].
    widest : float
        Largest half width [m].

    Raises
    ------
    InvalidValueError
        Half widths that are too large for the sensors' depths; no shape of a round contact.
    NotLinearError, ConvergenceError
        As in `tabulate_radial`.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfSpace(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.grid(shape=(2, 2), pitch=2e-3, depth=2e-3))
    >>> table = tabulate_round(finger, ss.RoundHertz, 4e-3, widest=3e-3)
    >>> touch = ss.RoundHertz(force=2.0, position=(0.3e-3, 1e-3), half_width=1.7e-3)
    >>> bool(np.allclose(2 * table.at(1.7e-3)((0.3e-3, 1e-3))[:, 0], finger.measure(touch), rtol=1e-6))
    True
    """
    depth = float(np.asarray(finger.array.depth).min())
    if widest > _MOST_WIDE * depth * (1 + 1e-12):
        rule = f"up to {_MOST_WIDE:g} depths of the shallowest sensor, {_MOST_WIDE * depth:.6g} m, can be fitted"
        raise InvalidValueError(
            f"half widths up to {widest:.6g} m", rule, f"half_width=(0.0, {_MOST_WIDE * depth:.3g})"
        )

    def make() -> RoundResponse:
        point = tabulate_radial(finger, radius)
        angles = 2 * int(point.terms[:, 1].max()) + 2
        every = [
            sampled(finger, sensor, point.coefficients.shape[1], partial(family, half_width=a), angles)
            for a in widest * _roots()
            for sensor in _one_of_each(point)
        ]
        return _over_widths(point, every, widest)

    return prepared(finger).get(("round", family, float(radius), float(widest)), make)


@checked
def tabulate_moment(finger: Finger, family: _Family, radius: Length, widest: Length) -> RoundResponse | None:
    """A finger's response to a unit moment about the normal on round contacts, in place of N; None where it has none.

    Normal strain, pressure and normal stress do not see a moment; nor is one known of a family whose drag under it is
    not.

    Parameters
    ----------
    finger, family, radius, widest
        As of `tabulate_round`; readings are per N m.

    Raises
    ------
    InvalidValueError, NotLinearError, ConvergenceError
        As `tabulate_round`.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin, gauge = ss.HalfSpace(ss.Material(young=0.4e6)), ss.transducer.ShearStrain("xy")
    >>> finger = ss.Finger(skin, ss.SensorArray.grid(shape=(2, 2), pitch=2e-3, depth=2e-3, transducer=gauge))
    >>> table = tabulate_moment(finger, ss.RoundHertz, 4e-3, widest=3e-3)
    >>> turn = ss.RoundHertz(components=(0.0, 0.0, 0.0), moment=1e-3, position=(0.3e-3, 1e-3), half_width=1.7e-3)
    >>> bool(np.allclose(1e-3 * table.at(1.7e-3)((0.3e-3, 1e-3))[:, 0], finger.measure(turn), rtol=1e-6))
    True
    """

    def make() -> RoundResponse | None:
        point, every = tabulate_radial(finger, radius), []
        angles = 2 * (int(point.terms[:, 1].max()) + _HIGHER) + 2
        peaks = np.abs(point.coefficients[..., 0] * point.weights).max(axis=(1, 2)) / point.depth.min()
        for a in widest * _roots():
            load = partial(_moment, family, half_width=float(a))
            for kind, sensor in enumerate(_one_of_each(point)):
                cells = point.coefficients.shape[1]
                try:
                    every.append(sampled(finger, sensor, cells, load, angles, floor=_FELT * float(peaks[kind])))
                except InvalidValueError:  # the family does not say how a moment drags
                    return None
            if not any(functions.any() for functions, *_ in every):
                return None
        return _over_widths(replace(point, lift=0.0), every, widest)  # a moment presses nothing

    return prepared(finger).get(("moment", family, float(radius), float(widest)), make)


def _moment(
    family: type[RoundContact], *, components: FloatArray, position: npt.ArrayLike, half_width: float
) -> RoundContact:
    """A contact with a unit moment and nothing else, in place of the contacts of unit `components`."""
    return family(components=np.zeros_like(components[:1]), moment=1.0, position=position, half_width=half_width)


def _roots() -> FloatArray:
    """Chebyshev's nodes of the square of the half width on (0, 1), as half widths."""
    return np.sqrt(0.5 * (1 + np.cos(np.pi * (np.arange(WIDTHS) + 0.5) / WIDTHS)))


def _one_of_each(point: RadialResponse) -> list[int]:
    """The first sensor of each kind."""
    return [int(np.flatnonzero(point.kind == kind)[0]) for kind in range(point.coefficients.shape[0])]


def _over_widths(point: RadialResponse, every: list[tuple[FloatArray, float, float]], widest: float) -> RoundResponse:
    """Chebyshev sums over the squares of the half widths at whose nodes `every` kind of sensor was sampled."""
    terms, tables, error = shared(every)
    matrix = np.polynomial.chebyshev.chebvander(2 * _roots() ** 2 - 1, WIDTHS - 1)
    sums = np.linalg.solve(matrix, tables.reshape(WIDTHS, -1))
    each = _check.read_only(sums.reshape(WIDTHS, len(point.coefficients), *tables.shape[1:]))
    table = replace(point, terms=terms, coefficients=each[0])
    size = np.abs(each[..., 0] * table.weights).max(axis=(1, 2, 3))
    return RoundResponse(table, each, widest, error + float(size[-1] / size[0]))
