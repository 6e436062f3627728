"""How the surface of a skin gives way: what pressing asks."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import InvalidValueError
from ..tensor import Wave

__all__ = ["PressedSurface", "distances", "grid_of"]


_MOST_DISTANCES, _MOST_SIDE = 1 << 24, 1 << 13


def distances(step: float, count: int) -> tuple[float, int]:
    """The step [m] and the number of the distances at which an influence is asked for."""
    known = _check.whole("count", count, at_least=1, at_most=_MOST_DISTANCES, fix="count=64")
    return _check.scalar("step", step, unit="m", above=0.0), known


def grid_of(step: float, shape: object, drag: object) -> tuple[float, tuple[int, int]]:
    """The step [m] and the shape of the grid at which an influence is asked for."""
    if not isinstance(shape, tuple | list) or len(shape) != 2:
        raise InvalidValueError(f"shape = {_check.shown(shape)}", "two whole numbers are needed", "shape=(32, 32)")
    _check.flag("drag", drag)
    rows, columns = (_check.whole("shape", n, at_least=1, at_most=_MOST_SIDE, fix="shape=(32, 32)") for n in shape)
    return _check.scalar("step", step, unit="m", above=0.0), (rows, columns)


class PressedSurface(ABC):
    """The surface of a `Skin`, under hats of traction and under waves of it."""

    @property
    @abstractmethod
    def curvature(self) -> float:
        """1 over the radius of the surface [1/m]."""

    @abstractmethod
    def wave(self, k: npt.ArrayLike, x: npt.ArrayLike) -> Wave:
        """As `Skin.wave`."""

    @abstractmethod
    def surface_influence(self, step: float, count: int) -> FloatArray:
        """Displacement of the surface at the distances j * step from the centre of a unit hat.

        A hat is a traction that falls linearly from 1 Pa to 0 within one step on either side. Where the skin is not
        `grounded`, u_x of a pressure and u_y of a drag lack a constant.

        Parameters
        ----------
        step : float
            Half the width of the hat, and the step of the distances [m].
        count : int
            Number of distances: j = 0 ... count - 1 towards +y.

        Returns
        -------
        ndarray, shape (2, 2, count)
            Displacement [m/Pa]: first index u_x (into the skin), u_y; second of a pressure, of a drag.

        Raises
        ------
        GeometryError
            Distances that go nearly round a finger.

        Examples
        --------
        >>> import subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=1e6, poisson=0.5))
        >>> influence = skin.surface_influence(step=1e-4, count=3)
        >>> (influence[0, 0] * 1e10).round(4).tolist()
        [5.1138, 4.4519, 4.0772]
        """

    def area_influence(self, step: float, shape: tuple[int, int], drag: bool = False) -> FloatArray:
        """Displacement of the surface at (i, j) * step along y and z from a hat: 1 Pa at a node, 0 at the next ones.

        Parameters
        ----------
        step : float
            Step of the grid [m].
        shape : tuple of int
            Numbers of distances (n, k), from 0 on.
        drag : bool
            Also what drags do.

        Returns
        -------
        ndarray, shape (1 or 6, n, k)
            Displacement [m/Pa]: u_x of a pressure; with `drag` then u_y of q_y, u_z of q_z, u_y of q_z (or u_z of q_y),
            u_x of q_y, u_x of q_z. The last two change sign for u_y and u_z of a pressure.

        Raises
        ------
        InvalidValueError, GeometryError
            A skin of a plane; drags on layers of which one slides; a step far wider than the first layer is thick.

        Examples
        --------
        >>> import subskin as ss
        >>> skin = ss.HalfSpace(ss.Material(young=1e6, poisson=0.5))
        >>> (1e12 * skin.area_influence(step=1e-4, shape=(2, 2))).round(3).tolist()
        [[[70.98, 26.55], [26.55, 17.88]]]
        """
        rule = "an area is pressed, and this skin is solved in a plane"
        raise InvalidValueError(f"a {type(self).__name__}", rule, "HalfSpace or Layered, or a long body as Cylinder")

    def surface_compliance(self, k: npt.ArrayLike) -> FloatArray:
        """Displacement of the surface per traction: that of `wave` at x = 0.

        Parameters
        ----------
        k : array_like, shape (...)
            Wavenumbers [rad/m], > 0; on a round finger, whose `curvature` they are multiples of, also 0.

        Returns
        -------
        ndarray, shape (..., 2, 2)
            C [m/Pa]. p = cos(k y) gives u_x = C[0, 0] cos(k y), u_y = C[1, 0] sin(k y); q = sin(k y) gives u_x =
            C[0, 1] cos(k y), u_y = C[1, 1] sin(k y). u_x points into the skin.

        Raises
        ------
        InvalidValueError
            As `wave`; k = 0 on a flat skin.

        Examples
        --------
        >>> import subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=1e6, poisson=0.0))
        >>> skin.surface_compliance(1e3).round(11).tolist()
        [[2e-09, -1e-09], [-1e-09, 2e-09]]
        """
        waves = _check.real("k", k, unit="rad/m", at_least=0.0, above=None if self.curvature else 0.0)
        wave = self.wave(waves.reshape(-1), np.zeros(1))
        return np.stack([wave.ux[:, 0], wave.uy[:, 0]], axis=-2).reshape(*waves.shape, 2, 2)
