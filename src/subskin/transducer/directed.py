"""What has a direction: gauges that lie in the skin, shear in a plane, displacement along an axis."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Angle
from ..tensor import State
from .base import Transducer

__all__ = ["Displacement", "LateralStrain", "ShearStrain", "rosette"]


@dataclass(frozen=True, repr=False)
class LateralStrain(Transducer, name="lateral_strain"):
    """Strain along a direction of the surface [-]: a gauge lying in the skin, along y if no direction is given.

    eps = eps_y cos^2 t + eps_z sin^2 t + 2 eps_yz sin t cos t (Timoshenko and Goodier, Theory of Elasticity, section
    12). Along y at nu = 1/2 in plane strain it is -eps_x (memo eq. 7).

    Parameters
    ----------
    direction : float, optional
        Angle t of the gauge from +y towards +z [rad].

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin, load = ss.HalfSpace(ss.Material(young=0.4e6)), ss.PointLoad(force=1.0)
    >>> felt = skin.state(load, x=2e-3, y=0.0, z=1.5e-3)
    >>> [round(float(LateralStrain(t).measure(felt)), 4) for t in (0.0, np.pi / 2)]
    [0.0764, -0.0061]
    """

    direction: Angle = field(default=0.0, metadata={"unit": "rad"})

    unit, component = "", "strain.yy"

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        e = state.strain
        if not self.direction:
            return e.yy
        c, s = np.cos(self.direction), np.sin(self.direction)
        return np.asarray(c * c * e.yy + s * s * e.zz + 2 * c * s * e.yz)


def rosette(directions: npt.ArrayLike = (0.0, np.pi / 4, np.pi / 2)) -> tuple[LateralStrain, ...]:
    """Gauges that lie in the skin at one position, along several directions: the channels of a strain rosette.

    Parameters
    ----------
    directions : array_like, shape (k,), optional
        Their angles from +y towards +z [rad]; 0, 45 and 90 degrees if left out.

    Raises
    ------
    InvalidValueError
        An angle that is no number.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid(shape=(2, 2), pitch=2e-3, depth=1e-3, channels=rosette())
    >>> len(array), array.transducers[:2]
    (12, (LateralStrain(), LateralStrain(direction=0.7853981633974483)))
    """
    return tuple(LateralStrain(float(t)) for t in np.atleast_1d(_check.real("directions", directions, unit="rad")))


@dataclass(frozen=True, repr=False)
class ShearStrain(Transducer, name="shear_strain"):
    """Engineering shear strain [-], twice the tensor's component, in the plane of two axes: gamma_xy = 2 eps_xy.

    Parameters
    ----------
    plane : {"xy", "xz", "yz"}, optional
        The two axes.

    Raises
    ------
    InvalidValueError
        Another plane.

    Examples
    --------
    >>> import subskin as ss
    >>> skin, load = ss.HalfSpace(ss.Material(young=0.4e6)), ss.PointLoad(force=1.0)
    >>> felt = skin.state(load, x=2e-3, y=0.0, z=1.5e-3)
    >>> [round(float(ShearStrain(plane).measure(felt)) + 0.0, 4) for plane in ("xy", "xz", "yz")]
    [0.0, -0.22, 0.0]
    """

    plane: Literal["xy", "xz", "yz"] = "xy"

    unit = ""

    @property
    def component(self) -> str:  # type: ignore[override]
        """The component of the field that a picture of the skin shows beside it."""
        return f"strain.{self.plane}"

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        shear: FloatArray = getattr(state.strain, self.plane)
        return 2 * shear


@dataclass(frozen=True, repr=False)
class Displacement(Transducer, name="displacement"):
    """How far the skin moves along one axis [m]: a marker seen by a camera, a rod, an optical gauge.

    Known where the skin knows it: under local contacts (`Skin.displacement`).

    Parameters
    ----------
    axis : {"x", "y", "z"}, optional
        x, into the skin, if left out.

    Raises
    ------
    InvalidValueError
        Another axis; on measuring, a displacement that is not known.

    Examples
    --------
    >>> import subskin as ss
    >>> skin, load = ss.HalfSpace(ss.Material(young=0.4e6)), ss.PointLoad(force=1.0)
    >>> felt = skin.state(load, x=2e-3, y=1e-3, z=0.0)
    >>> [round(1e6 * float(Displacement(axis).measure(felt)), 2) for axis in "xyz"]
    [480.44, 106.76, 0.0]
    """

    axis: Literal["x", "y", "z"] = "x"

    unit = "m"

    @property
    def component(self) -> str:  # type: ignore[override]
        """The component of the field that a picture of the skin shows beside it."""
        return f"displacement.{self.axis}"

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        moved: FloatArray = getattr(state.moved(f"{self!r} under such a contact"), self.axis)
        return moved
