"""More of what presses on an area: flat faces, edges and corners, ridges, several bodies at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Angle, Extent, Length, Positive, Real
from ..errors import GeometryError, InvalidValueError
from .body import ANYWHERE, Ends, LocalIndenter, points, turned
from .indenter import beyond, tip, waves

__all__ = ["Box", "BoxCorner", "BoxEdge", "Pin", "RidgedBody", "Together"]


@dataclass(frozen=True)
class Pin(LocalIndenter):
    """A round pin with a flat end, of a sharp or a rounded rim.

    Parameters
    ----------
    radius : float
        Radius of the flat [m], > 0.
    edge_radius : float, optional
        Radius of the rim [m], >= 0: beyond the flat the surface rises as distance^2 / (2 edge_radius). 0 is sharp.

    Examples
    --------
    >>> Pin(radius=1e-3).height([0.0, 1e-3, 1.1e-3], 0.0).tolist()
    [0.0, 0.0, inf]
    """

    radius: Length
    edge_radius: Extent = 0.0

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return beyond(np.hypot(*points(y, z)) - self.radius, self.edge_radius)

    @property
    def ends(self) -> Ends:  # noqa: D102
        end = np.inf if self.edge_radius else self.radius
        return (-end, end), (-end, end)


@dataclass(frozen=True)
class Box(LocalIndenter):
    """A box that presses with a face, of sharp or rounded edges and corners.

    Parameters
    ----------
    half_width_y, half_width_z : float
        Half the sides of the flat part [m], > 0.
    edge_radius : float, optional
        Radius of edges and corners [m], >= 0: beyond the flat the surface rises as distance^2 / (2 edge_radius). 0 is
        sharp.
    azimuth : float, optional
        Turn from y towards z [rad].

    Examples
    --------
    >>> Box(half_width_y=1e-3, half_width_z=2e-3, edge_radius=0.5e-3).height([0.0, 1.1e-3], 0.0).round(9).tolist()
    [0.0, 1e-05]
    """

    half_width_y: Length
    half_width_z: Length
    edge_radius: Extent = 0.0
    azimuth: Angle = 0.0

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys, zs = turned(*points(y, z), self.azimuth)
        out = np.maximum(np.abs(ys) - self.half_width_y, 0.0), np.maximum(np.abs(zs) - self.half_width_z, 0.0)
        return beyond(np.hypot(*out), self.edge_radius)

    @property
    def ends(self) -> Ends:  # noqa: D102
        if self.edge_radius or self.azimuth:
            return ANYWHERE, ANYWHERE
        return (-self.half_width_y, self.half_width_y), (-self.half_width_z, self.half_width_z)


@dataclass(frozen=True)
class BoxEdge(LocalIndenter):
    """A box that presses with an edge, which lies along z, or along any azimuth.

    Parameters
    ----------
    slope : float
        Rise of either face [-], > 0.
    half_length : float
        Half the length of the edge [m], > 0.
    edge_radius : float, optional
        Radius of the edge, and of its ends [m], >= 0. 0 is sharp.
    azimuth : float, optional
        Turn from y towards z of the direction across it [rad].

    Examples
    --------
    >>> BoxEdge(slope=0.2, half_length=3e-3).height([0.0, 1e-3], [0.0, 0.0]).round(9).tolist()
    [0.0, 0.0002]
    """

    slope: Positive
    half_length: Length
    edge_radius: Extent = 0.0
    azimuth: Angle = 0.0

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys, zs = turned(*points(y, z), self.azimuth)
        end = beyond(np.abs(zs) - self.half_length, self.edge_radius)
        return tip(np.abs(ys), self.slope, self.edge_radius) + end

    @property
    def ends(self) -> Ends:  # noqa: D102
        return ANYWHERE, ANYWHERE if self.edge_radius or self.azimuth else (-self.half_length, self.half_length)


@dataclass(frozen=True)
class BoxCorner(LocalIndenter):
    """A box that presses with a corner: three faces of one slope, 120 degrees apart, of sharp or rounded edges.

    Parameters
    ----------
    slope : float
        Rise of each face [-], > 0.
    edge_radius : float, optional
        Radius of tip and edges [m], >= 0: a paraboloid of that radius rolls within the faces. 0 is sharp.
    azimuth : float, optional
        Direction in which one face rises, from y towards z [rad].

    Examples
    --------
    >>> corner = BoxCorner(slope=0.2)
    >>> corner.height([1e-3, -1e-3], 0.0).round(9).tolist()
    [0.0002, 0.0001]
    """

    slope: Positive
    edge_radius: Extent = 0.0
    azimuth: Angle = 0.0

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys, zs = turned(*points(y, z), self.azimuth)
        ys, zs = np.broadcast_arrays(ys, zs)
        turns = 2 * np.pi / 3 * np.arange(3)
        faces = self.slope * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        if not self.edge_radius:
            return np.asarray(np.max([a * ys + b * zs for a, b in faces], axis=0))
        # the rolling paraboloid is Moreau's envelope of the sharp body: the nearest slope to x / R that the faces span
        y0, z0 = ys / self.edge_radius, zs / self.edge_radius
        best, within = np.full(ys.shape, np.inf), np.ones(ys.shape, dtype=bool)
        v = np.stack([y0, z0])
        for (a, b), (c, d) in zip(faces, np.roll(faces, -1, axis=0), strict=True):
            t = np.clip(((y0 - a) * (c - a) + (z0 - b) * (d - b)) / ((c - a) ** 2 + (d - b) ** 2), 0.0, 1.0)
            p = np.stack([a + t * (c - a), b + t * (d - b)])
            away = (p[0] - y0) ** 2 + (p[1] - z0) ** 2
            within &= (c - a) * (z0 - b) - (d - b) * (y0 - a) >= 0
            v = np.where(away < best, p, v)
            best = np.minimum(away, best)
        v = np.where(within, np.stack([y0, z0]), v)
        return np.asarray(ys * v[0] + zs * v[1] - 0.5 * self.edge_radius * (v[0] ** 2 + v[1] ** 2))


@dataclass(frozen=True)
class RidgedBody(LocalIndenter):
    """A body with ridges on it: its height and amplitude (1 - cos(2 pi t / pitch)), t across the ridges.

    Parameters
    ----------
    body : LocalIndenter
        What the ridges are on.
    pitch : float
        From crest to crest [m], > 0; a crest is at the body's centre.
    amplitude : float
        Half the height from trough to crest [m], >= 0.
    azimuth : float, optional
        Turn from y towards z of the direction across the ridges [rad].

    Examples
    --------
    >>> from subskin.pressing import Sphere
    >>> RidgedBody(Sphere(8e-3), pitch=0.5e-3, amplitude=10e-6).height([0.0, 0.25e-3], 0.0).round(9).tolist()
    [0.0, 2.3906e-05]
    """

    body: LocalIndenter
    pitch: Length
    amplitude: Extent
    azimuth: Angle = 0.0

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        across, _ = turned(*points(y, z), self.azimuth)
        return np.asarray(self.body.height(y, z) + waves(across, self.pitch, self.amplitude))

    @property
    def ends(self) -> Ends:  # noqa: D102
        return self.body.ends

    @property
    def centre(self) -> tuple[float, float]:  # noqa: D102
        return self.body.centre


@dataclass(frozen=True)
class Together(LocalIndenter):
    """Several bodies that move as one.

    Parameters
    ----------
    bodies : sequence of LocalIndenter
        The bodies.
    positions : array_like, shape (m, 2)
        Where their centres are, (y, z) [m].
    raised : array_like, shape (m,), optional
        How much higher each is than the lowest [m], >= 0; none is if left out.

    Raises
    ------
    InvalidValueError, GeometryError
        Something that is no body on an area, or positions of another number.

    Examples
    --------
    >>> from subskin.pressing import Sphere
    >>> pair = Together([Sphere(4e-3), Sphere(4e-3)], [(-2e-3, 0), (2e-3, 0)], raised=[0, 1e-5])
    >>> pair.height([-2e-3, 2e-3], 0.0).round(9).tolist()
    [0.0, 1e-05]
    """

    bodies: Sequence[LocalIndenter]
    positions: Annotated[npt.ArrayLike, Real("m")]
    raised: Annotated[npt.ArrayLike, Real("m", at_least=0.0)] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.bodies:
            raise InvalidValueError("no body", "bodies that press on an area are needed", "Sphere(radius=8e-3)")
        at = np.asarray(self.positions)
        if at.shape != (len(self.bodies), 2):
            seen = f"positions of shape {at.shape} for {len(self.bodies)} bodies"
            raise GeometryError(seen, "each body has a position (y, z)", "[(-2e-3, 0.0), (2e-3, 0.0)]")
        high = _check.for_each("raised", np.asarray(self.raised), len(self.bodies), "body")
        object.__setattr__(self, "raised", _check.read_only(high - high.min()))

    @property
    def _each(self) -> list[tuple[LocalIndenter, FloatArray, float]]:
        at, high = np.asarray(self.positions, dtype=np.float64), np.asarray(self.raised, dtype=np.float64)
        return [(body, one, float(up)) for body, one, up in zip(self.bodies, at, high, strict=True)]

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        return np.asarray(self._heights(y, z).min(axis=0))

    def lowest(self, y: npt.ArrayLike, z: npt.ArrayLike) -> npt.NDArray[np.intp]:
        """Which of the bodies is the lowest, and so the one that touches.

        Parameters
        ----------
        y, z : array_like, shapes that broadcast
            Points [m].

        Returns
        -------
        ndarray of int, shape (...)
            Indices of `bodies`.

        Examples
        --------
        >>> from subskin.pressing import Sphere
        >>> Together([Sphere(4e-3), Sphere(4e-3)], [(-2e-3, 0), (2e-3, 0)]).lowest([-1e-3, 3e-3], 0.0).tolist()
        [0, 1]
        """
        return np.asarray(self._heights(y, z).argmin(axis=0))

    def _heights(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:
        """Of each body, (m, ...) [m]."""
        ys, zs = points(y, z)
        return np.array([body.height(ys - a, zs - b) + up for body, (a, b), up in self._each])

    @property
    def ends(self) -> Ends:  # noqa: D102
        limits = np.array([np.array(body.ends) + at[:, None] for body, at, _ in self._each])
        low, high = limits[:, :, 0].min(axis=0), limits[:, :, 1].max(axis=0)
        return (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))

    @property
    def centre(self) -> tuple[float, float]:  # noqa: D102
        lowest, at, _ = min(self._each, key=lambda one: one[2])
        return lowest.centre[0] + float(at[0]), lowest.centre[1] + float(at[1])
