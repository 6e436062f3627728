"""The touches that a finger is made for: how hard, how oblique, and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, TypeAlias

import numpy as np

from .. import _check
from .._check import FloatArray
from .._declared import Fix, Friction, Length, Noun, Real, Whole, checked
from ..contact import Contact, LineLoad, LocalContact, PointLoad, RoundHertz
from ..errors import GeometryError, InvalidValueError
from ..finger import Finger

__all__ = ["Touches"]

_POSITIONS = 36
_Rng: TypeAlias = Annotated[np.random.Generator, Fix("rng=np.random.default_rng(0)")]
_Count: TypeAlias = Annotated[int, Whole(1, 10**7)]
_GOLDEN = np.pi * (3 - np.sqrt(5))
"""The golden angle [rad]: turned by it from one to the next, directions never come to lie close."""


@dataclass(frozen=True)
class Touches(Noun):
    """Loads of one strength, spread evenly over positions and over the angles of the friction cone.

    With an `area` they are local, anywhere on it; else they are line loads across a row of sensors. State the weakest
    force that has to be noticed: relative to the noise all others are located better.

    Parameters
    ----------
    force : float
        Magnitude of the load, > 0 [N/m]; of a local one [N].
    friction : float, optional
        Coefficient of friction, >= 0: angles lie within +-atan(friction). On an area they lie between 0 and that, and
        loads lean towards all sides alike.
    span : (float, float), optional
        Positions y that are touched [m]; without it, from the finger's first sensor to its last.
    length : float, optional
        Length of the contacts, > 0 [m]: what is said of the force is then said in N too.
    area : ((float, float), (float, float)), optional
        Ends of the positions y and of the positions z that are touched [m].
    half_width : float, optional
        On an area: radius of the touches, > 0 [m], which press as a sphere does (`RoundHertz`) and whose radius is to
        be found as well; points if left out.

    Raises
    ------
    InvalidValueError, GeometryError
        A force not > 0, a negative friction, a span or an area that does not ascend, or both.

    Examples
    --------
    >>> touches = Touches(force=20.0, friction=0.5, span=(-4e-3, 4e-3))
    >>> position, angle = touches.grid(4, 3)
    >>> (position * 1e3).round(6).tolist(), angle.round(4).tolist()
    ([-3.0, -1.0, 1.0, 3.0], [-0.3091, 0.0, 0.3091])
    """

    force: Annotated[float, Real("N/m", above=0.0)]
    friction: Friction = 1.0
    span: Annotated[tuple[float, float] | None, Real("m", fix="span=(-5e-3, 5e-3)")] = None
    length: Length | None = None
    area: tuple[tuple[float, float], tuple[float, float]] | None = None
    half_width: Length | None = None

    EXAMPLE: ClassVar = "design.Touches(force=20.0)"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not np.isfinite(self.friction):
            raise InvalidValueError("friction = inf", "touches are spread over a cone", "friction=1.0")
        if self.span is not None and not self.span[0] < self.span[1]:
            raise GeometryError(f"span = {self.span!r} m", "has to ascend", "span=(-5e-3, 5e-3)")
        fix = "area=((-5e-3, 5e-3), (-5e-3, 5e-3))"
        if self.area is None:
            if self.half_width is not None:
                seen = f"half_width = {self.half_width!r}"
                raise InvalidValueError(seen, "touches that have one are on an area", fix)
            return
        box = _check.real("area", self.area, unit="m")
        if box.shape != (2, 2) or not (box[:, 0] < box[:, 1]).all():
            raise GeometryError(f"area = {self.area!r}", "the ends of y and those of z are needed, ascending", fix)
        if self.span is not None or self.length is not None:
            wrong = "span" if self.span is not None else "length"
            raise InvalidValueError(f"an area, and a {wrong}", f"a {wrong} is of line loads", f"leave out the {wrong}")
        (a, b), (c, d) = box.tolist()
        object.__setattr__(self, "area", ((a, b), (c, d)))

    @property
    def dim(self) -> int:
        """Coordinates of a position: 1 along a row, 2 on an area."""
        return 1 if self.area is None else 2

    @property
    def middle(self) -> tuple[float, float]:
        """About which placements for these touches stand, (y, z) [m]; 0 where no span says."""
        y, z = self.area or (self.span or (0.0, 0.0), (0.0, 0.0))
        return 0.5 * (y[0] + y[1]), 0.5 * (z[0] + z[1])

    @property
    def unit(self) -> str:
        """Unit of the force: that of a line load, or of a local one."""
        return "N/m" if self.area is None else "N"

    @property
    def cone(self) -> float:
        """Largest angle of the load to the normal, atan(friction) [rad]."""
        return float(np.arctan(self.friction))

    @checked
    def span_on(self, finger: Finger | None = None) -> tuple[float, float]:
        """Positions that are touched [m]: `span`, or from the first sensor of `finger` to its last.

        Raises
        ------
        GeometryError
            No span, and no finger with sensors at more than one position; touches on an area.
        """
        if self.area is not None:
            rule = "this is worked out for line loads across a row of sensors"
            raise GeometryError("touches on an area", rule, "touches with a span")
        if self.span is not None:
            return self.span
        y = np.zeros(1) if finger is None else np.asarray(finger.array.y)
        if not y.min() < y.max():
            rule = "a span is needed, or a finger with sensors at two positions or more"
            raise GeometryError("touches without a span", rule, "span=(-2e-3, 2e-3)")
        return float(y.min()), float(y.max())

    @checked
    def grid(self, positions: _Count, angles: _Count, finger: Finger | None = None) -> tuple[FloatArray, FloatArray]:
        """Middles of equal parts of the span [m], shape (`positions`,), and of the cone [rad], shape (`angles`,).

        The span is that of `span_on` the `finger`.
        """
        low, high = self.span_on(finger)
        position = low + (high - low) * (np.arange(positions) + 0.5) / positions
        return position, self.cone * (2 * np.arange(angles) + 1 - angles) / angles

    @checked
    def loads(self, positions: _Count, angles: _Count, finger: Finger | None = None) -> tuple[FloatArray, FloatArray]:
        """Positions, (p,) or on an area (p, 2) [m], and components of the loads at each, (a, d + 1) [N/m or N].

        Those of `grid`; on an area the middles of cells, about so many and as square as they can be, and directions
        spread evenly over angles and azimuths.

        Parameters
        ----------
        positions, angles : int
            How many of each.
        finger : Finger, optional
            As in `span_on`.
        """
        if self.area is None:
            position, angle = self.grid(positions, angles, finger)
            return position, self.force * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        y, z = _cells(np.ptp(np.asarray(self.area), axis=1), positions)
        shares = np.meshgrid((np.arange(y) + 0.5) / y, (np.arange(z) + 0.5) / z, indexing="ij")
        i = np.arange(angles)
        return self._at(np.stack(shares, axis=-1).reshape(-1, 2)), self.leaning(
            self.cone * (i + 0.5) / angles, i * _GOLDEN
        )

    def usual_positions(self, of_a_row: int) -> int:
        """How many positions stand for all where none is stated: `of_a_row`, or 36 on an area."""
        return of_a_row if self.area is None else _POSITIONS

    @checked
    def presses(self, count: _Count, finger: Finger | None = None) -> FloatArray:
        """Positions of presses that cover the span from end to end, (`count`,) [m]; on an area a grid, (p, 2).

        On an area there are about `count`, as `finger` has no say there.
        """
        if self.area is None:
            return np.linspace(*self.span_on(finger), count)
        axes = [np.linspace(0.0, 1.0, n) for n in _cells(np.ptp(np.asarray(self.area), axis=1), count)]
        return self._at(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2))

    def _at(self, shares: FloatArray) -> FloatArray:
        """Positions [m] that lie at `shares` (..., 2) of the sides of the area."""
        box = np.asarray(self.area)
        return np.asarray(box[:, 0] + shares * np.ptp(box, axis=1))

    def leaning(self, angle: FloatArray, azimuth: FloatArray) -> FloatArray:
        """Components (..., 3) [N] of loads on an area.

        Parameters
        ----------
        angle : ndarray, shape (...)
            From the inward normal [rad].
        azimuth : ndarray, shape (...)
            Of the drag, from +y towards +z [rad].
        """
        side = np.sin(angle)
        return self.force * np.stack([np.cos(angle), side * np.cos(azimuth), side * np.sin(azimuth)], axis=-1)

    def contact(self, components: FloatArray, position: FloatArray) -> Contact | LocalContact:
        """Touches of this kind.

        Parameters
        ----------
        components : ndarray, shape (..., d + 1)
            N and T of each [N/m], on an area N, Ty and Tz [N].
        position : ndarray, shape (...) or (..., 2)
            Where each presses, y or (y, z) [m].
        """
        if self.area is None:
            return LineLoad.of_components(components, position)
        if self.half_width is None:
            return PointLoad(components=components, position=position)
        return RoundHertz(components=components, position=position, half_width=self.half_width)

    @checked
    def sample(
        self, count: Annotated[int, Whole(0, 10**9, "count=1000")], rng: _Rng, finger: Finger | None = None
    ) -> Any:
        """`count` touches drawn at random by `rng`, a batch of shape (count,), over the span or the area.

        Line loads over `span_on` the `finger`; on an area what `contact` makes.
        """
        if self.area is not None:
            angle, azimuth = rng.uniform(0.0, self.cone, count), rng.uniform(-np.pi, np.pi, count)
            return self.contact(self.leaning(angle, azimuth), self._at(rng.uniform(size=(count, 2))))
        low, high = self.span_on(finger)
        angle = rng.uniform(-1.0, 1.0, count) * self.cone
        return LineLoad(self.force, angle, rng.uniform(low, high, count))


def _cells(sides: FloatArray, count: int) -> tuple[int, int]:
    """About so many cells along y and z, as square as they can be."""
    along = max(round(float(np.sqrt(count * sides[0] / sides[1]))), 1)
    return along, max(round(count / along), 1)
