"""What presses, as a vector: where, how much inwards, how much along the surface, and how surely."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from ._frozen import Frozen
from ._shown import lines, span
from .errors import GeometryError

__all__ = ["Load"]


@dataclass(frozen=True, eq=False)
class Load(Frozen):
    """A load on the surface: its position and its components, normal first.

    With d the number of coordinates of a position, d = 1 is a load per length of a long contact, (N, T) in N/m; d = 2
    is a local contact's, (N, Ty, Tz) in N. N presses inwards, T drags the surface. Force, angle and azimuth follow
    (docs/conventions.md).

    Parameters
    ----------
    position : array_like, shape (...) for d = 1, (..., 2) for d = 2
        Where it acts: y, or (y, z) [m].
    components : array_like, shape (..., d + 1)
        Normal force, then the drag [N/m or N].
    covariance : array_like, shape (..., 2 d + 1, 2 d + 1), optional
        Of (position, components) [products of m, N/m or N]; None where it is not known. With a moment of
        (position, components, moment), shape (..., 6, 6).
    moment : array_like, shape (...), optional
        Of a local load, the moment about the inward normal, positive from +y to +z [N m]; None where it is not known.
    relative : bool, optional
        Whether forces are multiples of the load of a calibration's touches, and no newtons.

    Raises
    ------
    InvalidValueError, GeometryError
        Something that is no number; shapes that do not belong together.

    Examples
    --------
    >>> import subskin as ss
    >>> load = ss.Load(position=1e-3, components=[30.0, 40.0])
    >>> float(load.force), round(float(load.angle), 3)
    (50.0, 0.927)
    >>> load = ss.Load(position=[1e-3, -2e-3], components=[4.0, 0.0, -3.0])
    >>> float(load.force), round(float(load.angle), 4), round(float(load.azimuth), 4)
    (5.0, 0.6435, -1.5708)
    """

    position: FloatArray
    components: FloatArray
    covariance: FloatArray | None = None
    moment: FloatArray | None = None
    relative: bool = False

    def __post_init__(self) -> None:
        parts = _array("components", self.components)
        d = parts.shape[-1] - 1 if parts.ndim else 0
        if d not in (1, 2):
            seen = f"components of shape {parts.shape}"
            raise GeometryError(seen, "the last axis is (N, T), or (N, Ty, Tz) of a local load", "[40.0, 0.0]")
        position = _array("position", self.position)
        batch = position.shape if d == 1 else position.shape[:-1]
        if batch != parts.shape[:-1] or (d == 2 and position.shape[-1:] != (2,)):
            seen = f"position of shape {position.shape}, components of shape {parts.shape}"
            raise GeometryError(
                seen,
                f"position has to have the shape {parts.shape[:-1] + (2,) * (d - 1)}",
                "one position for each load",
            )
        object.__setattr__(self, "position", position)
        object.__setattr__(self, "components", parts)
        k = 2 * d + 1
        if self.moment is not None:
            moment, k = _array("moment", self.moment), k + 1
            if d == 1 or moment.shape != batch:
                seen = f"moment of shape {moment.shape}, components of shape {parts.shape}"
                raise GeometryError(seen, "each local load has one, a long one has none", "leave out moment")
            object.__setattr__(self, "moment", moment)
        if self.covariance is not None:
            square = _array("covariance", self.covariance)
            if square.shape != (*batch, k, k):
                seen = f"covariance of shape {square.shape}"
                raise GeometryError(seen, f"{(*batch, k, k)} is needed", "leave out covariance")
            object.__setattr__(self, "covariance", square)

    def __repr__(self) -> str:
        rows = self._shown()
        if not self.shape:
            return f"Load({', '.join(f'{name} {value}' for name, value in rows)})"
        return lines(f"Load of shape {self.shape}", rows)

    def _shown(self) -> list[tuple[str, str]]:
        """Each quantity's least and largest, in the units of people."""
        at = [self.position] if self.dim == 1 else np.moveaxis(self.position, -1, 0)
        rows = [(name, span(1e3 * where, "mm", 4)) for name, where in zip("yz", at, strict=False)]
        unit = force_unit(self.dim == 2, self.relative)
        rows.append(("force", span(self.force, unit, 4)))
        rows.append(("angle", span(np.rad2deg(self.angle), "deg", 4)))
        if self.dim == 2:
            rows.append(("azimuth", span(np.rad2deg(self.azimuth), "deg", 4)))
        if self.moment is not None:
            rows.append(("moment", span(1e3 * self.moment, f"{unit} mm", 4)))
        return rows

    @property
    def dim(self) -> int:
        """Coordinates of a position: 1 of a long contact, 2 of a local one."""
        return int(self.components.shape[-1]) - 1

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch."""
        return self.components.shape[:-1]

    def __getitem__(self, index: object) -> Load:
        """Some loads of the batch."""
        at, d = np.arange(self.normal.size).reshape(self.shape)[index], self.dim  # type: ignore[call-overload]
        square, moment = self.covariance, self.moment
        return Load(
            self.position.reshape(-1, *(2,) * (d - 1))[at],
            self.components.reshape(-1, d + 1)[at],
            None if square is None else square.reshape(-1, *square.shape[-2:])[at],
            None if moment is None else moment.reshape(-1)[at],
            self.relative,
        )

    @property
    def normal(self) -> FloatArray:
        """Force that presses inwards, N [N/m or N], shape (...)."""
        return self.components[..., 0]

    @property
    def tangential(self) -> FloatArray:
        """Drag along the surface: T [N/m], shape (...), positive towards +y; or (Ty, Tz) [N], shape (..., 2)."""
        return self.components[..., 1] if self.dim == 1 else self.components[..., 1:]

    @property
    def drag(self) -> FloatArray:
        """Magnitude of the drag [N/m or N], shape (...)."""
        return np.abs(self.tangential) if self.dim == 1 else np.hypot(*np.moveaxis(self.tangential, -1, 0))

    @property
    def force(self) -> FloatArray:
        """Magnitude [N/m or N], shape (...)."""
        return np.hypot(self.normal, self.drag)

    @property
    def angle(self) -> FloatArray:
        """Angle from the inward normal [rad], shape (...): of a long contact with the drag's sign, else >= 0."""
        return np.arctan2(self.tangential if self.dim == 1 else self.drag, self.normal)

    @property
    def azimuth(self) -> FloatArray:
        """Direction of the drag [rad], shape (...), from +y towards +z; of a long contact 0 or pi."""
        across = np.zeros(self.shape) if self.dim == 1 else self.components[..., 2]
        return np.arctan2(across, self.components[..., 1])

    @property
    def polar(self) -> FloatArray:
        """Covariance of (position, force, angle[, azimuth, moment]); NaN where none is known.

        Its shape is (..., 2 d + 1, 2 d + 1), with a moment (..., 6, 6). The components' covariance carried over to
        first order; readings are linear in the components, so that errors are Gaussian there.
        """
        k = 2 * self.dim + 1 + (self.moment is not None)
        if self.covariance is None:
            return np.full((*self.shape, k, k), np.nan)
        return polar_covariance(self.components, self.covariance)

    @property
    def std(self) -> FloatArray:
        """Standard deviations of (position, force, angle[, azimuth, moment]), shape (..., 2 d + 1) or (..., 6)."""
        return np.sqrt(np.diagonal(self.polar, axis1=-2, axis2=-1))

    def within(self, friction: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Whether the load presses within the cone of `friction` mu [-], abs(T) <= mu N, shape (...)."""
        mu = _check.real("friction", friction, at_least=0.0, finite=False)
        _check.broadcast(friction=mu, loads=self.normal)
        return (self.normal >= 0) & (self.drag <= mu * self.normal)


def polar_covariance(components: FloatArray, covariance: FloatArray) -> FloatArray:
    """Covariance of (position, force, angle[, azimuth], more) from that of (position, components, more).

    components (..., d + 1); covariance (..., k, k), k >= 2 d + 1: what comes after the components stays as it is.
    """
    d = components.shape[-1] - 1
    turn = np.empty((*components.shape[:-1], d + 1, d + 1))
    normal, along = components[..., 0], components[..., 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        if d == 1:
            force = np.hypot(normal, along)
            cos, sin = normal / force, along / force
            turn[..., 0, 0], turn[..., 0, 1] = cos, sin
            turn[..., 1, 0], turn[..., 1, 1] = -sin / force, cos / force
        else:
            across = components[..., 2]
            drag = np.hypot(along, across)
            force = np.hypot(normal, drag)
            turn[..., 0, :] = components / force[..., None]
            turn[..., 1, 0] = -drag / force**2
            turn[..., 1, 1], turn[..., 1, 2] = (normal * t / (drag * force**2) for t in (along, across))
            turn[..., 2, 0] = 0.0
            turn[..., 2, 1], turn[..., 2, 2] = -across / drag**2, along / drag**2
        # only the components turn: what is infinite elsewhere stays there
        out, forces = np.array(covariance), slice(d, 2 * d + 1)
        out[..., forces, :] = turn @ covariance[..., forces, :]
        out[..., :, forces] = out[..., :, forces] @ np.swapaxes(turn, -1, -2)
    return out


def force_unit(local: bool, relative: bool = False) -> str:
    """What forces that were found are in; nothing else decides that.

    Parameters
    ----------
    local : bool
        Those of a local load, in N; of a long one they are in N/m.
    relative : bool, optional
        By a finger calibrated on touches whose force nobody measured: in loads of these touches.

    Examples
    --------
    >>> force_unit(local=False), force_unit(local=True), force_unit(local=True, relative=True)
    ('N/m', 'N', 'touch loads')
    """
    return "touch loads" if relative else "N" if local else "N/m"


def _array(name: str, value: npt.ArrayLike) -> FloatArray:
    """A read-only array; NaN and infinity say that nothing was found there."""
    if type(value) is np.ndarray and value.dtype == np.float64 and not value.flags.writeable:
        return value
    return _check.real(name, value, finite=False)
