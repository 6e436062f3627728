"""Readings -> the pressure along the surface or on an area, and the shear where the array can see it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from .band import deviations
from .image import PressureImage
from .map import PressureMap
from .mapping import SurfaceMapper

__all__ = ["ImageMapper", "PressureMapper"]


class PressureMapper(SurfaceMapper):
    """Finds the pressure along the surface in frames of readings; prepared once, then called on a frame or on many.

    The surface is cut into elements much finer than the sensors are deep, and the pressure p at their nodes is the one
    that minimises

        chi-square + weight * integral (dp/dy)^2 dy + 2 least_force * (normal force) / (its least standard deviation)

    over all p >= 0 that are 0 at the ends of the search. The weight follows from each frame by `rule`; the minimum is
    unique and found exactly (docs/pressure.md).

    Parameters
    ----------
    finger : Finger
        The skin, of any kind, and the sensors in it.
    search : (float, float), optional
        Stretch of the surface that is mapped, y [m]; 1.5 depths beyond the outermost sensors if left out.
    step : float, optional
        Largest distance of the nodes [m]; a twelfth of the shallowest sensor's depth if left out.
    shear : {"proportional", "none", "free"}, optional
        Shear q = p tan(angle) with one unknown angle; none, for contacts that are known not to drag (drag would be
        taken for pressure elsewhere); or any shear with |q| <= friction * p, which asks for sensors of two kinds, or in
        two depths.
    friction : float, optional
        Bound of |q| / p [-]; of no account without shear.
    rule : {"evidence", "discrepancy", "gcv"}, optional
        The weight: most probable; the one that leaves a chi-square of n; or generalised cross-validation. Each for the
        smoothest p without regard to its sign, and the largest such weight.
    least_force : float, optional
        How far a line load's force is pulled down, in its standard deviations. Without it a wide and faint pressure, of
        which the sensors read nothing, is added for the sake of smoothness.
    false_alarm : float, optional
        Probability with which an untouched skin, or a pressure >= 0, is called a contact, or unexplained.

    Attributes
    ----------
    y : ndarray
        The nodes [m], (m,).
    shear_seen : float
        Share of the shear's components that are seen beside an unknown pressure; "free" needs 0.2.

    Raises
    ------
    InvalidValueError
        An option out of range; shear "free" where the array cannot separate it from pressure; a sensor without noise.
    GeometryError
        More elements than can be solved for.
    NotLinearError
        A transducer without a linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=25, pitch=0.5e-3, depth=2e-3, noise=2e-5))
    >>> mapper = PressureMapper(finger, shear="none")
    >>> mapper(finger.read(ss.Hertz(force=40.0, half_width=2e-3))).pressure.shape == mapper.y.shape
    True
    """

    def __call__(self, readings: npt.ArrayLike) -> PressureMap:
        """The pressure in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            As in `Locator`.

        Returns
        -------
        PressureMap
            Numbers of shape (...), and what lies along the surface of shape (..., m).

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        return PressureMap(*self._frames(readings), self)


class ImageMapper(SurfaceMapper):
    """Finds the pressure on an area in frames of readings; prepared once, then called on a frame or on many.

    As `PressureMapper`, in bilinear elements: the pressure p at their nodes is the one that minimises

        chi-square + weight * integral |grad p|^2 + 2 least_force * (normal force) / (its least standard deviation)

    over all p >= 0 that are 0 on the border of the search. The minimum is unique and found exactly (docs/pressure.md).

    Parameters
    ----------
    finger : Finger
        The skin, of any kind that takes local contacts, and the sensors on it.
    search : ((float, float), (float, float)), optional
        Ends of y and of z that are mapped [m]; about 1.5 depths beyond the outermost sensors if left out.
    step : float, optional
        Largest distance of the nodes [m]; if left out about a third of the shallowest sensor's depth, such that the
        sensors' distances are multiples of it.
    shear : {"proportional", "none", "free"}, optional
        Drag q = p tan(angle) in one unknown direction; none; or at every node its own, (q_y, q_z) with |q| <= friction
        * p, which asks for sensors of three kinds or directions at each position.
    friction : float, optional
        Bound of |q| / p [-]; of no account without shear.
    rule, least_force, false_alarm
        As in `PressureMapper`.

    Attributes
    ----------
    y, z : ndarray
        The nodes along y and along z [m], (ny,) and (nz,).

    Raises
    ------
    InvalidValueError
        An option out of range; shear "free" where the array cannot separate it from pressure; a sensor without noise;
        a finger that goes by a response measured in place.
    GeometryError
        More elements than can be solved for.
    NotLinearError
        A transducer without a linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid(shape=(6, 6), pitch=2e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=20.0)
    >>> mapper = ImageMapper(ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array), shear="none")
    >>> len(mapper.y), len(mapper.z)
    (25, 25)
    """

    @property
    def z(self) -> FloatArray:
        """Nodes along z [m], shape (nz,)."""
        return self._surface.z

    def __call__(self, readings: npt.ArrayLike) -> PressureImage:
        """The pressure in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            As in `Locator`.

        Returns
        -------
        PressureImage
            Numbers of shape (...), and images of shape (..., ny, nz).

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        return PressureImage(*self._frames(readings), self)

    def std(self, used: npt.NDArray[np.bool_], drag: FloatArray, weight: float, heights: FloatArray) -> FloatArray:
        """Standard deviations of the `heights` found with the sensors `used`, at a `drag` (2,) and a `weight`.

        Heights and deviations [Pa]: of the pressure (1, m), or where the drag is free of this and both drags (3, m).
        0 more than one element away from those that press.
        """
        from scipy.ndimage import binary_dilation
        from scipy.sparse import block_diag

        prior: Any = self._surface.prior
        near = np.flatnonzero(binary_dilation((heights[0] > 0).reshape(prior.shape), np.ones((3, 3), dtype=bool)))
        parts = self._hats(used).among(near, 1 if self.shear == "none" else 3)
        form, out = weight * prior.form[near][:, near], np.zeros(heights.shape)
        if self.shear == "free":
            scales = self._scales[:, None]
            every = (scales[..., None] * parts).reshape(1, -1, parts.shape[2]), block_diag(3 * [form], format="csr")
            found = deviations(every[0], drag, every[1], (heights[:, near] / scales).reshape(-1))
            out[:, near] = scales * found.reshape(3, -1)
        else:
            out[0, near] = deviations(parts, drag, form, heights[0, near])
        return out
