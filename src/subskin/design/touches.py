"""The touches that a finger is made for: how hard, how oblique, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import _check
from .._check import FloatArray
from ..contact import LineLoad
from ..errors import GeometryError, InvalidValueError
from ..finger import Finger

__all__ = ["Touches"]


@dataclass(frozen=True)
class Touches:
    """Line loads of one strength, spread evenly over positions and over the angles of the friction cone.

    State the weakest force that has to be noticed: relative to the noise all others are located better.

    Parameters
    ----------
    force : float
        Magnitude of the load, > 0 [N/m].
    friction : float, optional
        Coefficient of friction, >= 0: angles lie within +-atan(friction).
    span : (float, float), optional
        Positions y that are touched [m]; without it, from the finger's first sensor to its last.
    length : float, optional
        Length of the contacts, > 0 [m]: what is said of the force is then said in N too.

    Raises
    ------
    InvalidValueError, GeometryError
        A force not > 0, a negative friction, a span that does not ascend.

    Examples
    --------
    >>> touches = Touches(force=20.0, friction=0.5, span=(-4e-3, 4e-3))
    >>> position, angle = touches.grid(4, 3)
    >>> (position * 1e3).round(6).tolist(), angle.round(4).tolist()
    ([-3.0, -1.0, 1.0, 3.0], [-0.3091, 0.0, 0.3091])
    """

    force: float
    friction: float = 1.0
    span: tuple[float, float] | None = None
    length: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "force", _check.scalar("force", self.force, unit="N/m", above=0.0))
        friction = _check.friction(self.friction)
        if not np.isfinite(friction):
            raise InvalidValueError("friction = inf", "touches are spread over a cone", "friction=1.0")
        object.__setattr__(self, "friction", friction)
        span = _check.ends("span", self.span, "span=(-5e-3, 5e-3)")
        if span is not None and not (np.isfinite(span).all() and span[0] < span[1]):
            raise GeometryError(f"span = {self.span!r} m", "has to ascend", "span=(-5e-3, 5e-3)")
        object.__setattr__(self, "span", span)
        if self.length is not None:
            _check.scalar("length", self.length, unit="m", above=0.0)

    @property
    def cone(self) -> float:
        """Largest angle of the load to the normal, atan(friction) [rad]."""
        return float(np.arctan(self.friction))

    def span_on(self, finger: Finger | None = None) -> tuple[float, float]:
        """Positions that are touched [m]: `span`, or from the first sensor of `finger` to its last.

        Raises
        ------
        GeometryError
            No span, and no finger with sensors at more than one position.
        """
        if self.span is not None:
            return self.span
        y = np.zeros(1) if finger is None else np.asarray(finger.array.y)
        if not y.min() < y.max():
            raise GeometryError(
                "touches without a span",
                "a span is needed, or a finger with sensors at two positions or more",
                "span=(-2e-3, 2e-3)",
            )
        return float(y.min()), float(y.max())

    def grid(self, positions: int, angles: int, finger: Finger | None = None) -> tuple[FloatArray, FloatArray]:
        """Middles of equal parts of the span [m], shape (`positions`,), and of the cone [rad], shape (`angles`,).

        The span is that of `span_on` the `finger`.
        """
        low, high = self.span_on(finger)
        position = low + (high - low) * (np.arange(positions) + 0.5) / positions
        return position, self.cone * (2 * np.arange(angles) + 1 - angles) / angles

    def sample(self, count: int, rng: np.random.Generator, finger: Finger | None = None) -> LineLoad:
        """`count` touches drawn at random by `rng`, a batch of shape (count,), over `span_on` the `finger`."""
        low, high = self.span_on(finger)
        angle = rng.uniform(-1.0, 1.0, count) * self.cone
        return LineLoad(self.force, angle, rng.uniform(low, high, count))
