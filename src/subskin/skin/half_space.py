"""The half space: a skin thick and flat compared with a touch on an area and the sensors' depth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray, each_read_only
from ..contact import Contact, LocalContact
from ..material import Material
from ..tensor import Deferred, State, Tilt, Wave
from ._area_influence import of_half_space
from ._points import local_points, wave_points
from ._riesz import displacements_of, tensors_of, turns_of
from .base import Materials, Skin
from .half_plane import HalfPlane
from .surface import grid_of

__all__ = ["HalfSpace", "in_space"]


@dataclass(frozen=True)
class HalfSpace(Skin):
    """An infinite elastic half space, x >= 0 being the depth; y and z run along its surface.

    The field of any traction is built from the contact's families W_m (docs/local_contacts.md). Under a long contact it
    is the field of a half plane in plane strain, the same at every z.

    Parameters
    ----------
    material : Material
        Young's modulus and Poisson's ratio.

    Raises
    ------
    InvalidValueError
        What is no material.

    Examples
    --------
    A finger tip's force of 1 N on a point, felt 2 mm beneath: -3 N / (2 pi x^2), Johnson (1985), section 3.2.

    >>> import subskin as ss
    >>> skin = ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.5))
    >>> round(float(skin.stress(ss.PointLoad(force=1.0), x=2e-3, y=0.0, z=0.0).xx))
    -119366
    """

    material: Material

    @property
    def materials(self) -> tuple[Material, ...]:  # noqa: D102
        return (self.material,)

    def with_(  # noqa: D102
        self, *, materials: Materials = None, thickness: float | None = None, radius: float | None = None
    ) -> Self:
        super().with_(thickness=thickness, radius=radius)
        return replace(self, material=self._one_each(materials)[0])

    def __str__(self) -> str:
        return f"a half space ({self.material})"

    @property
    def takes_local(self) -> bool:  # noqa: D102
        return True

    @cached_property
    def _plane(self) -> HalfPlane:
        """What it is for a contact that does not change along z."""
        return HalfPlane(self.material)

    def wave(self, k: npt.ArrayLike, x: npt.ArrayLike) -> Wave:  # noqa: D102
        return self._plane.wave(k, x)

    def wave_across(self, k: npt.ArrayLike, x: npt.ArrayLike) -> FloatArray:  # noqa: D102
        waves, depths = wave_points(k, x)
        fall = np.exp(-waves[:, None] * depths)
        return np.stack([-fall, fall / (self.material.shear * waves[:, None])])

    def surface_influence(self, step: float, count: int) -> FloatArray:
        """As `Skin.surface_influence`, for hats that do not change along z."""
        return self._plane.surface_influence(step, count)

    def area_influence(  # noqa: D102
        self, step: float, shape: tuple[int, int], drag: bool = False
    ) -> FloatArray:
        return of_half_space(self.material, *grid_of(step, shape, drag), drag)

    def at(  # noqa: D102
        self, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None = None
    ) -> Callable[[Contact | LocalContact], State]:
        xs, ys, zs = local_points(x, y, z)
        long = self._plane.at(xs, ys)
        material = self.material

        def state(contact: Contact | LocalContact) -> State:
            if not isinstance(contact, LocalContact):
                return long(contact)
            stress, strain = tensors_of(contact, material, xs, ys, zs)
            moved = partial(displacements_of, contact, material, xs, ys, zs)

            def tilt() -> Tilt:
                turned = turns_of(contact, material.poisson, xs, ys, zs) / (2 * material.shear)
                return Tilt(*each_read_only(turned.real, turned.imag))

            return Deferred(stress, strain, moved, tilt)

        return state


def in_space(skin: Skin) -> Skin | None:
    """The same skin for touches on a point or an area; None where nobody knows it.

    A half plane in plane strain is a half space under contacts that have no end; a slice and a round finger are solved
    in their plane alone.

    Parameters
    ----------
    skin : Skin
        Any skin.

    Examples
    --------
    >>> import subskin as ss
    >>> print(in_space(ss.HalfPlane(ss.Material(young=0.4e6))))
    a half space (0.4 MPa, nu 0.5)
    """
    _check.noun("skin", skin, Skin, "HalfPlane(Material(young=0.4e6))")
    if skin.takes_local:
        return skin
    return HalfSpace(skin.material) if isinstance(skin, HalfPlane) and skin.plane == "strain" else None
