"""What presses on an area: rigid bodies by the height of their surface above the skin."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check, _hooks
from .._check import FloatArray
from .._declared import Angle, Extent, Length, Noun, Positive
from .indenter import beyond, tip

__all__ = ["ANYWHERE", "ConeTip", "Ellipsoid", "Ends", "LocalIndenter", "Roller", "Sphere", "points", "turned"]

Ends = tuple[tuple[float, float], tuple[float, float]]
ANYWHERE = (-np.inf, np.inf)


class LocalIndenter(Noun, ABC):
    """A rigid body that presses on an area. Its height is that of its surface above the skin, 0 at the lowest point.

    y and z count from its own centre. Slopes are taken to be small, as everywhere in the theory; a warning comes with
    an answer in which they are not.
    """

    EXAMPLE = "Sphere(radius=8e-3)"

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        _hooks.check_members(cls, _MEMBERS)

    @abstractmethod
    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:
        """Height [m] at `y`, `z` [m], which broadcast; infinite where the body has ended."""

    @property
    def ends(self) -> Ends:
        """Positions along y and along z [m] beyond which there is no body."""
        return ANYWHERE, ANYWHERE

    @property
    def centre(self) -> tuple[float, float]:
        """Where to look for the first touch [m]."""
        return 0.0, 0.0


_NUMBER = _hooks.numbers("a single one [m]", ndim=0)
_ENDS = _hooks.each_of((_NUMBER, _NUMBER), "two ends")
_MEMBERS = {
    "ends": _hooks.each_of((_ENDS, _ENDS), "the ends along y and those along z"),
    "centre": _hooks.each_of((_NUMBER, _NUMBER), "y and z"),
}


def points(y: npt.ArrayLike, z: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Both as arrays [m] that broadcast."""
    ys, zs = _check.real("y", y, unit="m"), _check.real("z", z, unit="m")
    _check.broadcast(y=ys, z=zs)
    return ys, zs


@dataclass(frozen=True)
class Sphere(LocalIndenter):
    """A sphere, as Hertz takes it: the paraboloid r^2 / (2 R).

    Parameters
    ----------
    radius : float
        Radius R [m], > 0.

    Examples
    --------
    >>> float(Sphere(radius=8e-3).height(0.8e-3, 0.0))
    4e-05
    """

    radius: Length

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys, zs = points(y, z)
        return np.asarray((ys**2 + zs**2) / (2 * self.radius))


@dataclass(frozen=True)
class Ellipsoid(LocalIndenter):
    """A body of two radii of curvature: y^2 / (2 R_y) + z^2 / (2 R_z), turned about x.

    Parameters
    ----------
    radius_y, radius_z : float
        Radii of curvature along its own two axes [m], > 0.
    azimuth : float, optional
        Turn from y towards z [rad].

    Examples
    --------
    >>> Ellipsoid(radius_y=8e-3, radius_z=2e-3).height([0.4e-3, 0.0], [0.0, 0.4e-3]).round(9).tolist()
    [1e-05, 4e-05]
    """

    radius_y: Length
    radius_z: Length
    azimuth: Angle = 0.0

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys, zs = turned(*points(y, z), self.azimuth)
        return np.asarray(ys**2 / (2 * self.radius_y) + zs**2 / (2 * self.radius_z))


@dataclass(frozen=True)
class Roller(LocalIndenter):
    """A cylinder of finite length that lies along z, or along any azimuth; its ends are sharp or rounded.

    Parameters
    ----------
    radius : float
        Radius [m], > 0.
    half_length : float
        Half its length [m], > 0, without the rounding.
    end_radius : float, optional
        Radius of its ends [m], >= 0: beyond the length the surface rises as distance^2 / (2 end_radius). 0 is sharp.
    azimuth : float, optional
        Turn from y towards z of the direction across it [rad].

    Examples
    --------
    >>> Roller(radius=4e-3, half_length=3e-3).height([0.4e-3, 0.0], [0.0, 3.1e-3]).round(9).tolist()
    [2e-05, inf]
    """

    radius: Length
    half_length: Length
    end_radius: Extent = 0.0
    azimuth: Angle = 0.0

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys, zs = turned(*points(y, z), self.azimuth)
        return np.asarray(ys**2 / (2 * self.radius) + beyond(np.abs(zs) - self.half_length, self.end_radius))

    @property
    def ends(self) -> Ends:  # noqa: D102
        # turned, it ends somewhere else for each z
        return ANYWHERE, ANYWHERE if self.end_radius or self.azimuth else (-self.half_length, self.half_length)


@dataclass(frozen=True)
class ConeTip(LocalIndenter):
    """A cone of small slope with a rounded tip.

    Parameters
    ----------
    slope : float
        Rise of its side [-], > 0.
    tip_radius : float, optional
        Radius of the tip [m], >= 0: the paraboloid that touches the side at the radius slope * tip_radius. 0 is sharp.

    Examples
    --------
    >>> ConeTip(slope=0.2).height([0.0, 3e-3], [0.0, 4e-3]).round(9).tolist()
    [0.0, 0.001]
    """

    slope: Positive
    tip_radius: Extent = 0.0

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return tip(np.hypot(*points(y, z)), self.slope, self.tip_radius)


def turned(y: FloatArray, z: FloatArray, azimuth: float) -> tuple[FloatArray, FloatArray]:
    """Positions along axes that are turned from y towards z."""
    if not azimuth:
        return y, z
    c, s = np.cos(azimuth), np.sin(azimuth)
    return np.asarray(c * y + s * z), np.asarray(c * z - s * y)
