"""Points of a skin: checked, made complex, and blanked where the stress is infinite."""

from __future__ import annotations

import warnings

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from ..contact.base import Contact
from ..errors import GeometryError, SingularPointWarning

__all__ = ["blank_singular", "complex_points", "points", "wave_points"]


def points(x: npt.ArrayLike, y: npt.ArrayLike, thickness: float = np.inf) -> tuple[FloatArray, FloatArray]:
    """Points of a skin, broadcast against each other.

    Raises
    ------
    GeometryError
        A point above the surface or beneath the skin, or shapes that do not broadcast.
    """
    xs, ys = _check.real("x", x, unit="m"), _check.real("y", y, unit="m")
    if (xs < 0).any():
        raise GeometryError(f"x = {float(xs.min()):.6g} m", "points lie in the skin, x >= 0 is the depth", "use -x")
    if (xs > thickness * (1 + 1e-12)).any():
        seen = f"x = {float(xs.max()):.6g} m"
        raise GeometryError(seen, f"the skin is only {thickness:.6g} m thick", "a smaller depth")
    shape = _check.broadcast(x=xs, y=ys)
    return np.broadcast_to(xs, shape), np.broadcast_to(ys, shape)


def wave_points(k: npt.ArrayLike, x: npt.ArrayLike, thickness: float = np.inf) -> tuple[FloatArray, FloatArray]:
    """Wavenumbers k >= 0, shape (m,), and depths, shape (d,); raises as `points`, and where there are more axes."""
    both = _check.real("k", k, unit="rad/m", at_least=0.0), points(x, 0.0, thickness)[0]
    for name, values in zip("kx", both, strict=True):
        if values.ndim > 1:
            raise GeometryError(f"{name} of shape {values.shape}", "a row of them is needed", f"{name}.ravel()")
    return np.atleast_1d(both[0]), np.atleast_1d(both[1])


def complex_points(x: FloatArray, y: FloatArray) -> ComplexArray:
    """The point z = y + i x, with x = -0.0 made +0.0: branch cuts are approached from inside the body."""
    z = np.empty(np.broadcast_shapes(x.shape, y.shape), dtype=np.complex128)
    z.real, z.imag = y, x + 0.0
    return z


def blank_singular(contact: Contact, x: FloatArray, y: FloatArray, *components: FloatArray) -> None:
    """NaN, and a warning, where the stress is infinite."""
    if (x > 0).all():
        return
    for position in contact.singular_points():
        bad = (x == 0) & (y == position)
        if bad.any():
            where = float(np.broadcast_to(position, bad.shape)[bad][0])
            message = f"the stress is infinite on the surface at y = {where:.6g} m; NaN is returned there"
            warnings.warn(message, SingularPointWarning, stacklevel=5)
            for component in components:
                component[bad] = np.nan
