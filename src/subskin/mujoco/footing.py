"""What a body of MuJoCo is beneath its lowest point: two curvatures, and the outline within which it may touch."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._check import FloatArray
from ..errors import InvalidValueError
from .installed import engine

__all__ = ["Footing", "clipped", "footing_of"]

_LEVEL = np.sin(np.deg2rad(3.0))
"""Sine of the angle up to which a face lies flat, and an edge lies along the skin: soft contacts of MuJoCo lean."""
_ROUND = 48
"""Corners of the polygon that stands for a disc."""
_NEAR = 0.02
"""Of a mesh's size: vertices so near beneath its lowest one tell its curvature."""
_FITS = 0.1
"""Share of their heights that a paraboloid may leave, where a mesh is taken to be curved."""
_FEWEST = 8
"""Vertices that tell a curvature."""
_WIDE = 1e3
"""Of a length, what stands for no limit."""


class Footing(NamedTuple):
    """A body near its lowest point, in axes y and z of the skin.

    curvature (2, 2) [1/m], symmetric, positive or 0; outline (k, 2) [m]: the corners of a convex polygon, in order, or
    None where the body has no end nearby.
    """

    curvature: FloatArray
    outline: FloatArray | None


def footing_of(model: Any, geom: int, axes: FloatArray, centre: FloatArray, edge_radius: float) -> Footing:
    """The footing of a geom that presses towards +x.

    Parameters
    ----------
    model : mujoco.MjModel
        Of it the type, sizes and vertices.
    geom : int
        Its number.
    axes : ndarray, shape (3, 3)
        Its axes as columns, in the axes of the skin.
    centre : ndarray, shape (3,)
        Its centre there [m].
    edge_radius : float
        Of edges and corners, which are sharp in MuJoCo [m].

    Raises
    ------
    InvalidValueError
        A geom of a type that has no shape of its own.

    Examples
    --------
    >>> import mujoco, numpy as np
    >>> ball = '<mujoco><worldbody><geom type="sphere" size=".02"/></worldbody></mujoco>'
    >>> model = mujoco.MjModel.from_xml_string(ball)
    >>> footing_of(model, 0, np.eye(3), np.zeros(3), 0.5e-3).curvature.tolist()
    [[50.0, 0.0], [0.0, 50.0]]
    """
    kind, size, types = int(model.geom_type[geom]), model.geom_size[geom], engine().mjtGeom
    if kind in (types.mjGEOM_PLANE, types.mjGEOM_HFIELD):
        return Footing(np.zeros((2, 2)), None)
    if kind == types.mjGEOM_SPHERE:
        return Footing(np.eye(2) / size[0], None)
    if kind == types.mjGEOM_ELLIPSOID:
        return Footing(_ellipsoid(axes, size), None)
    if kind == types.mjGEOM_CAPSULE:
        if abs(axes[0, 2]) <= _LEVEL:
            return _edge(axes[:, 2], centre, size[1], size[0])
        return Footing(np.eye(2) / size[0], None)
    if kind == types.mjGEOM_CYLINDER:
        return _cylinder(axes, centre, size, edge_radius)
    if kind == types.mjGEOM_BOX:
        return _box(axes, centre, size, edge_radius)
    if kind == types.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first = model.mesh_vertadr[mesh]
        vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
        return _vertices(centre + vertices @ axes.T, edge_radius)
    name = types(kind).name.removeprefix("mjGEOM_").lower()
    rule = "plane, hfield, sphere, ellipsoid, capsule, cylinder, box and mesh press on a skin"
    raise InvalidValueError(f"geom {model.geom(geom).name!r} of type {name}", rule, 'type="mesh"')


def _ellipsoid(axes: FloatArray, size: FloatArray) -> FloatArray:
    """Curvature at the point whose normal is x: of the support function h(u) = |s u| the Hessian is its inverse."""
    square = size**2
    u = axes[0]
    h, tangent = np.sqrt(square @ u**2), axes[1:]
    slope = square * u
    radii = tangent @ (np.diag(square) / h - np.outer(slope, slope) / h**3) @ tangent.T
    return np.asarray(np.linalg.inv(radii))


def _edge(axis: FloatArray, centre: FloatArray, half_length: float, radius: float) -> Footing:
    """A cylinder of a radius that lies along the skin."""
    along = axis[1:] / np.hypot(*axis[1:])
    across = np.array([-along[1], along[0]])
    half = half_length * along, max(_WIDE * radius, half_length) * across
    corners = np.array([half[0] + half[1], half[1] - half[0], -half[0] - half[1], half[0] - half[1]])
    return Footing(np.outer(across, across) / radius, centre[1:] + corners)


def _cylinder(axes: FloatArray, centre: FloatArray, size: FloatArray, edge_radius: float) -> Footing:
    axis, (radius, half) = axes[:, 2], size[:2]
    level = np.hypot(*axis[1:])
    if abs(axis[0]) <= _LEVEL:
        return _edge(axis, centre, half, radius)
    if level <= _LEVEL:
        turn = 2 * np.pi / _ROUND * np.arange(_ROUND)
        # a polygon of the disc's area
        reach = radius / np.sqrt(np.sinc(2 / _ROUND))
        end = centre[1:] + np.sign(axis[0]) * half * axis[1:]
        return Footing(np.zeros((2, 2)), end + reach * np.stack([np.cos(turn), np.sin(turn)], axis=-1))
    # the rim is a torus: along its ring it is curved by the cosine of the normal's height above the ring
    out = axis[1:] / level
    across = np.array([-out[1], out[0]])
    return Footing(np.outer(out, out) / edge_radius + np.outer(across, across) * level / radius, None)


def _box(axes: FloatArray, centre: FloatArray, size: FloatArray, edge_radius: float) -> Footing:
    u = axes[0]
    top, mid, low = np.argsort(-np.abs(u))
    if np.hypot(u[mid], u[low]) <= _LEVEL:
        middle = centre + np.sign(u[top]) * size[top] * axes[:, top]
        a, b = size[mid] * axes[:, mid], size[low] * axes[:, low]
        return Footing(np.zeros((2, 2)), (middle + np.array([a + b, b - a, -a - b, a - b]))[:, 1:])
    if abs(u[low]) <= _LEVEL:
        middle = centre + sum(np.sign(u[i]) * size[i] * axes[:, i] for i in (top, mid))
        return _edge(axes[:, low], middle, size[low], edge_radius)
    return Footing(np.eye(2) / edge_radius, None)


def _vertices(at: FloatArray, edge_radius: float) -> Footing:
    """Of a mesh: a paraboloid where its vertices lie on one, else the face, edge or corner beneath."""
    from scipy.spatial import ConvexHull

    high = at[:, 0].max() - at[:, 0]
    lowest = at[np.argmin(high), 1:]
    away = at[:, 1:] - lowest
    near = high <= _NEAR * np.ptp(at, axis=0).max()
    if near.sum() >= _FEWEST and high[near].max() > 0:
        y, z = away[near].T
        terms = np.stack([np.ones_like(y), y, z, y**2 / 2, y * z, z**2 / 2], axis=-1)
        found = np.linalg.lstsq(terms, high[near], rcond=None)[0]
        if np.abs(terms @ found - high[near]).max() <= _FITS * high[near].max():
            curvature = found[[3, 4, 4, 5]].reshape(2, 2)
            if np.linalg.eigvalsh(curvature)[0] > 0:
                return Footing(curvature, None)
    face = away[high <= _LEVEL * np.hypot(*away.T) + 1e-12]
    spread = np.linalg.svd(face - face.mean(axis=0))[1:] if len(face) > 1 else (np.zeros(2), np.eye(2))
    if len(face) > 2 and spread[0][1] > _LEVEL * spread[0][0]:
        return Footing(np.zeros((2, 2)), lowest + face[ConvexHull(face).vertices])
    if len(face) > 1 and spread[0][0] > 0:
        along = face @ spread[1][0]
        middle = lowest + 0.5 * (along.min() + along.max()) * spread[1][0]
        return _edge(np.array([0.0, *spread[1][0]]), np.array([0.0, *middle]), 0.5 * np.ptp(along), edge_radius)
    return Footing(np.eye(2) / edge_radius, None)


def clipped(outline: FloatArray, by: FloatArray) -> FloatArray:
    """What two convex polygons have in common (Sutherland and Hodgman 1974), shape (k, 2); none: (0, 2).

    Parameters
    ----------
    outline, by : ndarray, shapes (k, 2) and (m, 2)
        Their corners, in order.

    Examples
    --------
    >>> square = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
    >>> sorted(map(tuple, clipped(square, square + 1.0).tolist()))
    [(1.0, 1.0), (1.0, 2.0), (2.0, 1.0), (2.0, 2.0)]
    """
    y, z = by.T
    if (y * np.roll(z, -1) - z * np.roll(y, -1)).sum() < 0:
        by = by[::-1]
    for start, end in zip(by, np.roll(by, -1, axis=0), strict=True):
        (a, b), away = end - start, outline - start
        side = a * away[:, 1] - b * away[:, 0]
        kept = []
        for i, inside in enumerate(side >= 0):
            other = side[i - 1]
            if inside != (other >= 0):
                kept.append(outline[i - 1] + other / (other - side[i]) * (outline[i] - outline[i - 1]))
            if inside:
                kept.append(outline[i])
        outline = np.array(kept).reshape(-1, 2)
    return outline
