"""What every skin answers: the stress and strain beneath a contact."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..contact.base import Contact
from ..errors import InvalidValueError
from ..material import Material
from ..tensor import State, Strain, Stress

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

    @abstractmethod
    def surface_compliance(self, k: npt.ArrayLike) -> FloatArray:
        """Displacement of the surface per traction at the wavenumbers k > 0 [1/m], shape (..., 2, 2) [m/Pa].

        p = cos(k y) gives u_x = C[0, 0] cos(k y), u_y = C[1, 0] sin(k y); q = sin(k y) gives u_x = C[0, 1] cos(k y),
        u_y = C[1, 1] sin(k y). u_x points into the skin.
        """

    @abstractmethod
    def surface_influence(self, step: float, count: int) -> FloatArray:
        """Displacement [m/Pa] at the distances j * step from the centre of a unit hat, shape (2, 2, count).

        A hat is a traction that falls linearly from 1 Pa to 0 within one step on either side. First index: u_x, u_y;
        second: of pressure, of shear; j = 0 ... count - 1 towards +y. Where the skin is not `grounded`, u_x of pressure
        and u_y of shear lack a constant.
        """

    @property
    def thickness(self) -> float:
        """Depth of the rigid base or core [m]; infinite where there is none."""
        return np.inf

    @property
    def grounded(self) -> bool:
        """Whether displacements are absolute; on a half plane they are known up to a constant."""
        return False

    @property
    def period(self) -> float:
        """Distance along the surface after which it repeats [m]; infinite for a flat skin."""
        return np.inf

    def changed(self, *, poisson: float | None = None, thickness: float | None = None) -> Skin:
        """The same skin with another Poisson's ratio or thickness [m]: what `calibrate` can fit of it.

        Raises
        ------
        InvalidValueError
            Where the skin has no one number of that name.
        """
        name, value = ("poisson", poisson) if poisson is not None else ("thickness", thickness)
        raise InvalidValueError(
            f"{name} = {value:.6g}", f"a {type(self).__name__} has no single {name} to change"
        )

    @property
    def single_material(self) -> Material | None:
        """The one material of which the skin is made; None where there are several."""
        return None

    def surface_drop(self, y: npt.ArrayLike) -> FloatArray:
        """How far the undeformed surface lies beneath its tangent at y = 0 [m]; 0 for a flat skin."""
        return np.zeros_like(_check.real("y", y, unit="m"))
