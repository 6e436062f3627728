"""What every skin answers: the stress and strain beneath a contact."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..contact.base import Contact
from ..field import State, Strain, Stress

__all__ = ["Skin"]


class Skin(ABC):
    """An elastic medium with a surface at depth x = 0."""

    @abstractmethod
    def state(self, contact: Contact, x: npt.ArrayLike, y: npt.ArrayLike) -> State:
        """Stress and strain beneath `contact` (broadcast) at depth x >= 0 [m] and place y [m]."""

    def stress(self, contact: Contact, x: npt.ArrayLike, y: npt.ArrayLike) -> Stress:
        """Stress [Pa] beneath `contact` at depth x >= 0 [m] and place y [m]."""
        return self.state(contact, x, y).stress

    def strain(self, contact: Contact, x: npt.ArrayLike, y: npt.ArrayLike) -> Strain:
        """Strain [-] beneath `contact` at depth x >= 0 [m] and place y [m]."""
        return self.state(contact, x, y).strain

    @property
    def thickness(self) -> float:
        """Depth of the rigid base or core [m]; infinite where there is none."""
        return np.inf

    @property
    def grounded(self) -> bool:
        """Whether displacements are absolute; on a half plane they are known up to a constant."""
        return False

    def surface_drop(self, y: npt.ArrayLike) -> FloatArray:
        """How far the undeformed surface lies beneath its tangent at y = 0 [m]; 0 for a flat skin."""
        return np.zeros_like(_check.real("y", y, unit="m"))
