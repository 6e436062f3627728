"""Points of a skin: checked, made complex, and blanked where the stress is infinite."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from ..contact import Contact, LocalContact
from ..errors import GeometryError, InvalidValueError, SingularPointWarning

__all__ = ["blank_local", "blank_singular", "complex_points", "local_points", "not_local", "points", "wave_points"]


def points(
    x: npt.ArrayLike, y: npt.ArrayLike, thickness: float = np.inf, z: npt.ArrayLike | None = None
) -> tuple[FloatArray, FloatArray]:
    """Points of a skin, broadcast against each other, and against z where a field is the same at every z.

    Raises
    ------
    GeometryError
        A point above the surface or beneath the skin, or shapes that do not broadcast.
    """
    xs, ys = _check.real("x", x, unit="m"), _check.real("y", y, unit="m")
    shape = _check.broadcast(x=xs, y=ys)
    if (xs < 0).any():
        raise GeometryError(f"x = {float(xs.min()):.6g} m", "points lie in the skin, x >= 0 is the depth", "use -x")
    if (xs > thickness * (1 + 1e-12)).any():
        seen = f"x = {float(xs.max()):.6g} m"
        raise GeometryError(seen, f"the skin is only {thickness:.6g} m thick", "a smaller depth")
    if z is not None:
        return local_points(xs, ys, z)[:2]
    return np.broadcast_to(xs, shape), np.broadcast_to(ys, shape)


def local_points(
    x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None, thickness: float = np.inf
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points of a skin on an area, broadcast against each other; z is 0 where it is not given. Raises as `points`."""
    xs, ys = points(x, y, thickness)
    zs = _check.real("z", 0.0 if z is None else z, unit="m")
    shape = _check.broadcast(**{"x and y": xs}, z=zs)
    return np.broadcast_to(xs, shape), np.broadcast_to(ys, shape), np.broadcast_to(zs, shape)


def not_local(contact: LocalContact, skin: object) -> InvalidValueError:
    """The error of a local contact on a skin that is solved in a plane."""
    seen = f"a {type(contact).__name__} on a {type(skin).__name__}"
    rule = "it acts on an area, and this skin is solved in a plane, for contacts that do not change along z"
    return InvalidValueError(seen, rule, "HalfSpace or Layered for it, or a long contact such as LineLoad")


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
            _check.warn(message, SingularPointWarning)
            for component in components:
                component[bad] = np.nan


def blank_local(
    contact: LocalContact, x: FloatArray, y: FloatArray, z: FloatArray, *components: FloatArray | ComplexArray
) -> None:
    """NaN, and a warning, where the stress of a local contact is infinite."""
    bad = (x == 0) & contact.singular(y, z)
    if bad.any():
        at = tuple(float(np.broadcast_to(a, bad.shape)[bad][0]) for a in (y, z))
        message = (
            f"the stress is infinite on the surface at (y, z) = ({at[0]:.6g}, {at[1]:.6g}) m; NaN is returned there"
        )
        _check.warn(message, SingularPointWarning)
        for component in components:
            nan = complex(np.nan, np.nan) if np.iscomplexobj(component) else np.nan
            component[np.broadcast_to(bad, component.shape)] = nan
