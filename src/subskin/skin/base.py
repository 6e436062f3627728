"""What every skin answers: the stress and strain beneath a contact."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy.typing as npt

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
