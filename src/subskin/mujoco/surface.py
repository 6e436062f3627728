"""The surface of a geom that carries a skin: where its axes point, how it is curved, and where it ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..errors import InvalidValueError
from .installed import engine

__all__ = ["FACES", "GeomSurface", "surface_of"]

FACES = ("+x", "-x", "+y", "-y", "+z", "-z")


@dataclass(frozen=True, eq=False)
class GeomSurface(Frozen):
    """A face, a side or a cap, in the axes of its geom.

    Parameters
    ----------
    axes : ndarray, shape (3, 3)
        Rows: x of the skin, inwards, y and z, at the middle of the skin.
    origin : ndarray, shape (3,)
        The middle of the skin [m].
    half : ndarray, shape (2,)
        Half lengths along y and z [m]; of what is round, arc lengths.
    radius : float
        Radius of a sphere or a cylinder [m]; infinite of a flat face.
    bends : ndarray of bool, shape (2,)
        Whether the surface is curved along y, and along z.
    """

    axes: FloatArray
    origin: FloatArray
    half: FloatArray
    radius: float
    bends: FloatArray

    @property
    def curvature(self) -> FloatArray:
        """Curvature along y and z, a diagonal matrix [1/m]."""
        return np.asarray(np.diag(self.bends / self.radius))

    @property
    def outline(self) -> FloatArray:
        """Corners of the skin, counterclockwise, shape (4, 2) [m]."""
        return np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]) * self.half

    def frame(self, point: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Origin (3,) [m] and axes (3, 3), rows, of the surface beneath a point of the geom, and where it is (2,) [m].

        A flat face has one origin and no other position than (0, 0). On what is round the axes turn with the normal,
        the shortest way from the middle, and positions are arc lengths.
        """
        if not self.bends.any():
            return self.origin, self.axes, np.zeros(2)
        from_centre = self.axes @ (point - self.origin) - np.array([self.radius, 0.0, 0.0])
        flat = np.where(self.bends, 0.0, from_centre[1:])
        out = np.array([from_centre[0], *np.where(self.bends, from_centre[1:], 0.0)])
        out /= np.linalg.norm(out)
        # out = (-cos a, sin a e), e a direction along the surface
        level = np.hypot(out[1], out[2])
        angle = np.arctan2(level, -out[0])
        along = np.array([0.0, *(out[1:] / level if level > 0 else (1.0, 0.0))])
        normal = np.array([1.0, 0.0, 0.0])
        axes = np.eye(3)
        axes[0] = -out
        for i in (1, 2):  # what lies along e turns with the normal
            axes[i] += along[i] * ((np.cos(angle) - 1) * along + np.sin(angle) * normal)
        centre = self.origin + self.radius * self.axes[0]
        at = centre + self.axes.T @ (self.radius * out + np.array([0.0, *flat]))
        return at, axes @ self.axes, self.radius * angle * along[1:] + flat


def surface_of(model: Any, geom: int, face: str) -> GeomSurface:
    """The surface of a geom on the side of `face`, as in `GeomSkin`.

    Parameters
    ----------
    model : mujoco.MjModel
        The compiled model.
    geom : int
        Its number.
    face : str
        The outward normal at the middle of the skin: "+x" to "-z".

    Raises
    ------
    InvalidValueError
        Another face; a geom that takes no skin there.

    Examples
    --------
    >>> import mujoco
    >>> pad = '<mujoco><worldbody><geom type="box" size=".005 .01 .02"/></worldbody></mujoco>'
    >>> surface = surface_of(mujoco.MjModel.from_xml_string(pad), 0, "+x")
    >>> (surface.axes + 0.0).tolist(), surface.half.tolist()
    ([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]], [0.01, 0.02])
    """
    _check.choice("face", face, FACES)
    types, kind, size = engine().mjtGeom, int(model.geom_type[geom]), model.geom_size[geom]
    normal = "xyz".index(face[1])
    out = (1.0 if face[0] == "+" else -1.0) * np.eye(3)[normal]
    z = np.eye(3)[2 if normal != 2 else 1]
    axes = np.array([-out, np.cross(z, -out), z])
    if kind == types.mjGEOM_BOX:
        return GeomSurface(axes, out * size, np.abs(axes[1:]) @ size, np.inf, np.zeros(2, bool))
    radius, half = float(size[0]), float(size[1])
    quarter = 0.5 * np.pi * radius
    both = np.ones(2, bool)
    if kind == types.mjGEOM_SPHERE:
        return GeomSurface(axes, radius * out, np.full(2, quarter), radius, both)
    if kind == types.mjGEOM_CAPSULE and normal == 2:
        return GeomSurface(axes, (half + radius) * out, np.full(2, quarter), radius, both)
    if kind in (types.mjGEOM_CAPSULE, types.mjGEOM_CYLINDER) and normal != 2:
        return GeomSurface(axes, radius * out, np.array([quarter, half]), radius, np.array([True, False]))
    seen = f"geom {model.geom(geom).name!r} of type {types(kind).name.removeprefix('mjGEOM_').lower()}, face {face}"
    rule = "a skin lies on a face of a box, on a sphere, on the side of a capsule or cylinder, or on a capsule's end"
    raise InvalidValueError(seen, rule, 'a box of the skin\'s size: type="box" size="0.005 0.01 0.01"')
