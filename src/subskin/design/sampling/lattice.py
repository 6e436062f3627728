"""The error that a lattice of sensors on an area makes between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._frozen import Result
from ...contact import LocalContact
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ._plane import EndlessLattice

__all__ = ["LatticeError", "lattice_error"]

_DENSEST = 0.02


@dataclass(frozen=True, eq=False)
class LatticeError(Result):
    """What `aliasing_error` found of a lattice on an area; of a contact, or of tractions that are white.

    Attributes
    ----------
    finger : Finger
        The skin, with the one sensor that the lattice repeats, at (0, 0).
    contact : LocalContact or None
        What presses; None for pressure and drags along y and along z that hold all waves alike.
    lattice : str
        "square" or "hexagonal".
    pitch : float
        Pitch of the sensors [m].
    beyond : float or ndarray, shape (3,)
        Root mean square of what is read of waves beyond the first zone, over that within it [-]; without a contact of
        the pressure and of each drag.
    """

    finger: Finger
    contact: LocalContact | None
    lattice: str
    pitch: float
    beyond: FloatArray

    @property
    def rms(self) -> FloatArray:
        """Root mean square error of the readings recovered between the sensors, over that of the readings [-].

        Over all positions, and all shifts of the lattice: the waves beyond the first zone are missing, and others are
        taken for them, so it is the root of 2 b^2 / (1 + b^2), b being `beyond`.
        """
        return _check.read_only(np.sqrt(2 / (1 + self.beyond**2)) * self.beyond)


def lattice_error(finger: Finger, contact: object, pitch: float | None, *, sensor: int, lattice: str) -> LatticeError:
    """`aliasing_error` of a square or hexagonal lattice."""
    if contact is not None and not isinstance(contact, LocalContact):
        seen, rule = f"a {type(contact).__name__} over a {lattice} lattice", "a local contact is needed, or none"
        raise InvalidValueError(seen, rule, "RoundHertz(force=1.0, half_width=2e-3)")
    if contact is not None and contact.shape != ():
        raise GeometryError(f"contacts of shape {contact.shape}", "a single one is needed", "give contacts one by one")
    sensors = EndlessLattice.of(finger, sensor)
    step = _check.scalar("pitch", _pitch(finger, lattice) if pitch is None else pitch, unit="m", above=0.0)
    if step < _DENSEST * sensors.depth:
        raise InvalidValueError(
            f"pitch = {step:.6g} m", f"sensors nearer than {_DENSEST:g} depths leave no error to find", "a larger pitch"
        )
    within, beyond = sensors.powers(lattice, step, contact)
    if not (within + beyond > 0).all():
        raise InvalidValueError(
            f"a sensor at {sensors.depth:.6g} m", "it reads nothing of the load", "another depth or transducer"
        )
    ratio = np.sqrt(beyond / within)
    return LatticeError(sensors.finger, contact, lattice, step, _check.read_only(ratio[0] if contact else ratio))


def _pitch(finger: Finger, lattice: str) -> float:
    """The pitch of the finger's own lattice."""
    layout, points = finger.array.layout, np.unique(finger.array.points, axis=0)
    own = "" if not layout or "along" in layout else "hexagonal" if "hexagonal" in layout else "square"
    if own != lattice or len(points) < 2:
        seen = f"sensors that are {f'a {layout}' if layout else 'not set out evenly'}"
        raise GeometryError(seen, f"no {lattice} lattice follows from them", "pitch=2e-3")
    return float(np.hypot(*(points[1:] - points[0]).T).min())
