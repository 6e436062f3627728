"""Stress and strain at points of a skin, and what follows from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ._check import FloatArray
from ._frozen import Frozen

__all__ = ["Deferred", "State", "Strain", "Stress", "SurfaceGradient", "Wave"]


@dataclass(frozen=True, eq=False)
class _Tensor(Frozen):
    """A symmetric tensor of a plane problem: x is depth, y runs along the surface, z out of the plane."""

    xx: FloatArray
    yy: FloatArray
    zz: FloatArray
    xy: FloatArray

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of each component."""
        return self.xx.shape

    @property
    def principal(self) -> FloatArray:
        """The three principal values, largest (most tensile) first, shape (..., 3)."""
        centre, radius = 0.5 * (self.xx + self.yy), np.hypot(0.5 * (self.xx - self.yy), self.xy)
        values = np.stack([centre + radius, centre - radius, np.broadcast_to(self.zz, centre.shape)], axis=-1)
        return np.sort(values, axis=-1)[..., ::-1]

    @property
    def trace(self) -> FloatArray:
        """Xx + yy + zz."""
        return self.xx + self.yy + self.zz


@dataclass(frozen=True, eq=False)
class Stress(_Tensor):
    """Stress [Pa], positive in tension: `xx`, `yy`, `zz` and `xy`, the shear stress tau_xy, arrays of one shape.

    Examples
    --------
    >>> import numpy as np
    >>> s = Stress(xx=np.array(-3.0), yy=np.array(-1.0), zz=np.array(-2.0), xy=np.array(0.0))
    >>> float(s.mean_pressure)
    2.0
    >>> s.principal.tolist()
    [-1.0, -2.0, -3.0]
    """

    @property
    def mean_pressure(self) -> FloatArray:
        """Hydrostatic pressure -(xx + yy + zz) / 3 [Pa], positive in compression."""
        return -self.trace / 3


@dataclass(frozen=True, eq=False)
class Strain(_Tensor):
    """Strain [-], positive in extension: `xx`, `yy`, `zz` and `xy`, half the engineering shear `gamma_xy`.

    Examples
    --------
    >>> import numpy as np
    >>> e = Strain(xx=np.array(-0.01), yy=np.array(0.01), zz=np.array(0.0), xy=np.array(0.002))
    >>> float(e.gamma_xy), float(e.volume)
    (0.004, 0.0)
    """

    @property
    def gamma_xy(self) -> FloatArray:
        """Engineering shear strain 2 eps_xy [-]."""
        return 2 * self.xy

    @property
    def volume(self) -> FloatArray:
        """Relative change of volume, the trace [-]."""
        return self.trace


@dataclass(frozen=True, eq=False)
class State(Frozen):
    """Stress and strain at the same points: `stress` [Pa] and `strain` [-]."""

    stress: Stress
    strain: Strain

    @property
    def energy_density(self) -> FloatArray:
        """Strain energy per volume, half of stress : strain [J/m^3].

        Examples
        --------
        >>> import numpy as np
        >>> zero = np.array(0.0)
        >>> s, e = Stress(np.array(-2.0), zero, zero, zero), Strain(np.array(-0.5), zero, zero, zero)
        >>> float(State(s, e).energy_density)
        0.5
        """
        s, e = self.stress, self.strain
        return 0.5 * (s.xx * e.xx + s.yy * e.yy + s.zz * e.zz) + s.xy * e.xy


class Deferred(State):
    """A state whose `stress` and `strain` are worked out when they are asked for, by functions of no argument.

    Examples
    --------
    >>> import numpy as np
    >>> stress = Stress(*np.zeros((4, 3)))
    >>> Deferred(lambda: stress, lambda: 1 / 0).stress.shape
    (3,)
    """

    def __init__(self, stress: Callable[[], Stress], strain: Callable[[], Strain]) -> None:
        self.__dict__.update(_stress=stress, _strain=strain)

    def __reduce__(self) -> tuple[type[State], tuple[Stress, Strain]]:
        """It travels as what it has to say: functions stay behind."""
        return State, (self.stress, self.strain)

    @cached_property
    def stress(self) -> Stress:
        """Stress [Pa]."""
        made: Stress = self.__dict__["_stress"]()
        return made

    @cached_property
    def strain(self) -> Strain:
        """Strain [-]."""
        made: Strain = self.__dict__["_strain"]()
        return made


@dataclass(frozen=True, eq=False)
class Wave(State):
    """Amplitudes under a wave of traction, cos(k y) of pressure or sin(k y) of drag; components have any one shape.

    What is even in y goes with cos(k y): `ux`, all strains and stresses but xy. `uy` and xy are odd and go with
    sin(k y).

    Parameters
    ----------
    stress, strain : Stress, Strain
        Per Pa of traction [-], [1/Pa].
    ux, uy : ndarray
        Displacement along the depth and along the surface [m/Pa].
    """

    ux: FloatArray
    uy: FloatArray

    @property
    def halves(self) -> tuple[State, State]:
        """The state that goes with cos(k y), and that which goes with sin(k y)."""
        zero = np.zeros(self.stress.shape)
        s, e = self.stress, self.strain
        even = State(Stress(s.xx, s.yy, s.zz, zero), Strain(e.xx, e.yy, e.zz, zero))
        return even, State(Stress(zero, zero, zero, s.xy), Strain(zero, zero, zero, e.xy))


@dataclass(frozen=True, eq=False)
class SurfaceGradient(Frozen):
    """How the displacement changes along y [-]: `ux` = du_x/dy (the tilt of the surface), `uy` = du_y/dy."""

    ux: FloatArray
    uy: FloatArray
