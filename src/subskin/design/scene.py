"""A finger and touches of it drawn at random: what `outside.py` draws its wrong contacts from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Fix, Noun, Whole
from ..contact import Contact, LocalContact
from ..errors import GeometryError
from ..finger import Finger, finger_needed
from .touches import Touches

__all__ = ["Drawn", "Scene"]

Sensors: TypeAlias = npt.NDArray[np.intp]
_MOST = 10**8


class Drawn(NamedTuple):
    """Readings (m, n) with noise, and where they come from: positions (m, k, d) of which any is right, normal (m,) [N].

    The normal force of line loads is per length [N/m]; NaN where it is not to be judged.
    """

    readings: FloatArray
    positions: FloatArray
    normal: FloatArray


@dataclass(frozen=True)
class Scene(Noun):
    """A finger, the touches that it is made for, and the draws of `count` of them.

    Parameters
    ----------
    finger : Finger
        As its estimators take it to be.
    touches : Touches
        Force, cone, and span or area.
    count : int
        Number of touches.
    rng : numpy.random.Generator
        The random generator.

    Raises
    ------
    InvalidValueError, GeometryError
        Another thing, here and below; arrays of another shape.
    """

    finger: Finger
    touches: Touches
    count: Annotated[int, Whole(1, _MOST, "count=1000")]
    rng: Annotated[np.random.Generator, Fix("rng=np.random.default_rng(0)")]

    def _shaped(self, name: str, value: npt.ArrayLike, tail: tuple[int, ...]) -> FloatArray:
        """Numbers of the shape (m, *tail)."""
        array = _check.real(name, value)
        if array.shape != (self.count, *tail):
            raise GeometryError(f"{name} of shape {array.shape}", f"{(self.count, *tail)} is needed, a row a touch")
        return array

    @property
    def dim(self) -> int:
        """Coordinates of a position: 1 of line loads, 2 on an area."""
        return self.touches.dim

    @property
    def depth(self) -> float:
        """Mean depth of the sensors [m]."""
        return float(np.asarray(self.finger.array.depth).mean())

    def between(self, low: float, high: float) -> FloatArray:
        """One number a touch, evenly from `low` to `high`."""
        return self.rng.uniform(_check.scalar("low", low), _check.scalar("high", high), self.count)

    def leaning(self, angle: FloatArray) -> FloatArray:
        """Components (m, d + 1) of loads at angles (m,) to the normal; on an area to any side."""
        turn = self._shaped("angle", angle, ())
        parts = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        if self.dim == 2:
            parts = np.concatenate([parts[:, :1], parts[:, 1:] * self.sides()], axis=1)
        return self.touches.force * parts

    def sides(self) -> FloatArray:
        """Directions along the surface, (m, d): to either side, or on an area to all."""
        if self.dim == 1:
            return self.rng.choice([-1.0, 1.0], self.count)[:, None]
        turn = self.between(-np.pi, np.pi)
        return np.stack([np.cos(turn), np.sin(turn)], axis=-1)

    def loads(self) -> FloatArray:
        """Components of the touches, (m, d + 1), evenly over the cone."""
        return self.leaning(self.between(-self.touches.cone, self.touches.cone))

    def positions(self) -> FloatArray:
        """Positions of the touches, (m, d), evenly over the span or the area [m]."""
        if self.dim == 1:
            return self.between(*self.touches.span_on(self.finger))[:, None]
        box = np.asarray(self.touches.area)
        return self.rng.uniform(box[:, 0], box[:, 1], (self.count, 2))

    def touch(self, load: FloatArray, position: FloatArray) -> Contact | LocalContact:
        """A touch of the model with components (m, d + 1) at positions (m, d)."""
        at = self._shaped("position", position, (self.dim,))
        return self.touches.contact(load, at[:, 0] if self.dim == 1 else at)

    def model(self) -> Contact | LocalContact:
        """The touches that the model describes."""
        load = self.loads()
        return self.touch(load, self.positions())

    def read(
        self, contact: Contact | LocalContact, finger: Finger | None = None, also: FloatArray | None = None
    ) -> Drawn:
        """What `contact` reads on `finger`, or on the scene's own; its resultant's position, and those of `also`."""
        _check.noun("contact", contact, (Contact, LocalContact), "scene.model()")
        made = self.finger if finger is None else finger
        finger_needed(made)
        positions = None if also is None else _check.real("also", also, unit="m", finite=False)
        if positions is None:
            at = np.asarray(getattr(contact, "position", np.nan), dtype=np.float64).reshape(-1, self.dim)
            positions = np.broadcast_to(at, (self.count, self.dim))[:, None]
        normal = np.broadcast_to(contact.normal_force, contact.shape)
        return Drawn(made.read(contact, rng=self.rng), positions, normal)

    def with_fault(self, fault: Callable[[FloatArray, Sensors], FloatArray]) -> Drawn:
        """Good touches, of which `fault(readings, one of n sensors a touch)` makes those of a faulty finger."""
        drawn = self.read(self.model())
        live = np.flatnonzero(self.finger.array.live)
        made = fault(drawn.readings, self.rng.choice(live, self.count))
        return drawn._replace(readings=_check.returned("fault", made, drawn.readings.shape, exactly=True))
