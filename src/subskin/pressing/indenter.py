"""What presses: rigid profiles, by the height of their surface above the skin's tangent plane."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Annotated, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Extent, Length, Noun, Positive, Real
from ..errors import GeometryError

__all__ = [
    "Cylinder",
    "Edge",
    "Flat",
    "Indenter",
    "ParticleOnFlat",
    "RoundedFlat",
    "RoundedWedge",
    "SineRidges",
    "beyond",
    "tip",
    "waves",
]

_Endless: TypeAlias = Annotated[float, Real("m", above=0.0, finite=False)]


class Indenter(Noun, ABC):
    """A rigid body. Its height is that of its surface above the skin, 0 at the lowest point; y from its own centre.

    Slopes are taken to be small, as everywhere in the theory; a warning comes with an answer in which they are not.
    """

    @abstractmethod
    def height(self, y: npt.ArrayLike) -> FloatArray:
        """Height [m] at `y` [m], of the same shape; infinite where the body has ended."""

    @property
    def ends(self) -> tuple[float, float]:
        """Positions y [m] beyond which there is no body."""
        return -np.inf, np.inf

    def check_period(self, period: float) -> None:
        """Raise where the body cannot be repeated every `period` [m].

        Raises
        ------
        GeometryError
            A body that is wider than that.
        """
        low, high = self.ends
        if np.isfinite(high - low) and high - low > period * (1 + 1e-9):
            seen = f"period = {period:.6g} m"
            raise GeometryError(seen, f"the body itself is {high - low:.6g} m wide", "a longer period")


def _positions(y: npt.ArrayLike) -> FloatArray:
    return _check.real("y", y, unit="m")


def beyond(distance: FloatArray, radius: float) -> FloatArray:
    """Height beyond an end, where it is rounded with `radius`."""
    out = np.maximum(distance, 0.0)
    return np.asarray(out**2 / (2 * radius) if radius else np.where(distance > 0, np.inf, 0.0))


def tip(distance: FloatArray, slope: float, radius: float) -> FloatArray:
    """Height of a side of this slope, whose tip is rounded with `radius`."""
    reach = slope * radius
    side = slope * (distance - 0.5 * reach)
    return np.asarray(np.where(distance < reach, distance**2 / (2 * radius), side) if radius else side)


def waves(across: FloatArray, pitch: float, amplitude: float) -> FloatArray:
    """Height of ridges, amplitude (1 - cos(2 pi across / pitch))."""
    return np.asarray(2 * amplitude * np.sin(np.pi * across / pitch) ** 2)


@dataclass(frozen=True)
class Cylinder(Indenter):
    """A cylinder along z, as Hertz takes it: the parabola y^2 / (2 R).

    A circle lies above the parabola by y^4 / (8 R^3), 1 % of the height at y = 0.2 R: less than what small slopes leave
    out.

    Parameters
    ----------
    radius : float
        Radius R [m], > 0.

    Examples
    --------
    >>> float(Cylinder(radius=8e-3).height(0.8e-3))
    4e-05
    """

    radius: Length

    def height(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return np.asarray(_positions(y) ** 2 / (2 * self.radius))


@dataclass(frozen=True)
class Flat(Indenter):
    """A rigid plane without end, as a table; for a round finger pressed on it.

    Examples
    --------
    >>> Flat().height([0.0, 1e-3]).tolist()
    [0.0, 0.0]
    """

    def height(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return np.zeros_like(_positions(y))


@dataclass(frozen=True)
class Edge(Indenter):
    """A rigid plane that ends, as a table's edge: flat for y < 0, nothing for y > 0 (memo Fig. 8).

    Parameters
    ----------
    edge_radius : float, optional
        Radius of the edge [m], >= 0: beyond y = 0 the surface then rises as y^2 / (2 edge_radius). 0 is sharp.

    Examples
    --------
    >>> Edge().height([-1e-3, 0.0, 1e-3]).tolist()
    [0.0, 0.0, inf]
    """

    edge_radius: Extent = 0.0

    def height(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return beyond(_positions(y), self.edge_radius)

    @property
    def ends(self) -> tuple[float, float]:  # noqa: D102
        return -np.inf, np.inf if self.edge_radius else 0.0


@dataclass(frozen=True)
class RoundedFlat(Indenter):
    """A bar with a flat face and rounded edges; with sharp ones it is the flat punch.

    Parameters
    ----------
    half_width : float
        Half the width of the flat part [m], > 0.
    edge_radius : float, optional
        Radius of the edges [m], >= 0: beyond the flat the surface rises as distance^2 / (2 edge_radius). 0 is sharp.

    Examples
    --------
    >>> RoundedFlat(half_width=1e-3, edge_radius=0.5e-3).height([0.0, 1e-3, 1.1e-3]).round(9).tolist()
    [0.0, 0.0, 1e-05]
    """

    half_width: Length
    edge_radius: Extent = 0.0

    def height(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return beyond(np.abs(_positions(y)) - self.half_width, self.edge_radius)

    @property
    def ends(self) -> tuple[float, float]:  # noqa: D102
        end = np.inf if self.edge_radius else self.half_width
        return -end, end


@dataclass(frozen=True)
class RoundedWedge(Indenter):
    """A wedge of small slope with a rounded tip.

    Parameters
    ----------
    slope : float
        Rise of either side [-], > 0; cot(theta / 2) for a wedge of vertex angle theta.
    tip_radius : float, optional
        Radius of the tip [m], >= 0: the parabola that touches both sides at y = +-slope * tip_radius. 0 is sharp.

    Examples
    --------
    >>> RoundedWedge(slope=0.2, tip_radius=1e-3).height([0.0, 0.2e-3, 1e-3]).round(9).tolist()
    [0.0, 2e-05, 0.00018]
    """

    slope: Positive
    tip_radius: Extent = 0.0

    def height(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return tip(np.abs(_positions(y)), self.slope, self.tip_radius)


@dataclass(frozen=True)
class SineRidges(Indenter):
    """Ridges amplitude (1 - cos(2 pi y / pitch)), on a flat or on a cylinder.

    Parameters
    ----------
    pitch : float
        From crest to crest [m], > 0; a crest is at y = 0.
    amplitude : float
        Half the height from trough to crest [m], >= 0.
    radius : float, optional
        Radius [m] of the cylinder on which the ridges are, > 0; none for a flat.

    Examples
    --------
    >>> SineRidges(pitch=0.5e-3, amplitude=10e-6).height([0.0, 0.25e-3]).round(9).tolist()
    [0.0, 2e-05]
    """

    pitch: Length
    amplitude: Extent
    radius: _Endless = np.inf

    def height(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys = _positions(y)
        return waves(ys, self.pitch, self.amplitude) + ys**2 / (2 * self.radius)

    def check_period(self, period: float) -> None:  # noqa: D102
        count = period / self.pitch
        if not np.isclose(count, round(count), rtol=0.0, atol=1e-6) or round(count) < 1:
            seen, rule = f"period = {period:.6g} m", f"ridges repeat every {self.pitch:.6g} m"
            raise GeometryError(seen, rule, f"a whole number of pitches, e.g. {max(round(count), 1) * self.pitch:.6g}")


@dataclass(frozen=True)
class ParticleOnFlat(Indenter):
    """A particle on a flat: a round cap of a given width and height, its top at y = 0 (memo Fig. 17).

    Parameters
    ----------
    half_width : float
        Half the particle's width where it meets the flat [m], > 0.
    protrusion : float
        How far it stands out of the flat [m], > 0.
    flat_half_width : float, optional
        Half the width of the flat [m], > half_width; none for a flat without end.

    Raises
    ------
    GeometryError
        A flat that is narrower than the particle.

    Examples
    --------
    >>> particle = ParticleOnFlat(half_width=0.2e-3, protrusion=20e-6)
    >>> particle.height([0.0, 0.1e-3, 1e-3]).round(9).tolist()
    [0.0, 5e-06, 2e-05]
    """

    half_width: Length
    protrusion: Length
    flat_half_width: _Endless = np.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.flat_half_width > self.half_width:
            seen = f"half_width = {self.half_width:.6g} m, flat_half_width = {self.flat_half_width:.6g} m"
            raise GeometryError(seen, "the flat has to be wider than the particle on it", "a larger flat_half_width")

    def height(self, y: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys = _positions(y)
        cap = self.protrusion * np.minimum((ys / self.half_width) ** 2, 1.0)
        return np.asarray(np.where(np.abs(ys) > self.flat_half_width, np.inf, cap))

    @property
    def ends(self) -> tuple[float, float]:  # noqa: D102
        return -self.flat_half_width, self.flat_half_width
