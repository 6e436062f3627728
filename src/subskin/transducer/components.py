"""What is one quantity of stress or strain: along the depth, or the same in all directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._check import FloatArray
from ..tensor import State
from .base import Quantity, Transducer

__all__ = ["EnergyDensity", "MaxCompressiveStrain", "MeanPressure", "NormalStrain", "NormalStress", "VolumeResistance"]


@dataclass(frozen=True)
class NormalStrain(Quantity, name="normal_strain"):
    """Strain along the depth, eps_x [-] (memo eq. 8): a strain gauge standing in the skin."""

    unit, _of = "", "strain.xx"


@dataclass(frozen=True)
class NormalStress(Quantity, name="normal_stress"):
    """Stress along the depth, sigma_x [Pa], negative under a press."""

    unit, component, _of = "Pa", "stress.xx", "stress.xx"


@dataclass(frozen=True)
class MeanPressure(Quantity, name="mean_pressure"):
    """Hydrostatic pressure -(sigma_x + sigma_y + sigma_z)/3 [Pa]: a barometer cast in rubber."""

    unit, component, _of = "Pa", "mean_pressure", "stress.mean_pressure"


@dataclass(frozen=True)
class VolumeResistance(Transducer, name="volume_resistance"):
    """Relative change of resistance, R/R0 - 1 [-], of a conductive block with electrodes above and below (memo Fig. 4).

    R = rho L / A = rho L^2 / V, so with the block's length L0 (1 + eps_x) and volume V0 (1 + tr eps)

        exact:        R/R0 - 1 = (1 + eps_x)^2 / (1 + tr eps) - 1
        first order:  R/R0 - 1 = eps_x - eps_y - eps_z

    At nu = 1/2 the volume is kept and these are (1 + eps_x)^2 - 1 and 2 eps_x, in plane strain and in plane stress
    alike. (The memo's (1 + eps_x)/(1 - eps_x), eq. 10, keeps the volume only to first order; see `subskin.memo`.)

    Parameters
    ----------
    exact : bool, optional
        False (the default) for the first order, which is linear in the load.

    Examples
    --------
    >>> import numpy as np
    >>> from subskin.tensor import State, Strain, Stress
    >>> zero, e = np.array(0.0), np.array(-0.1)
    >>> state = State(Stress(zero, zero, zero, zero), Strain(e, -e, zero, zero))
    >>> float(VolumeResistance(exact=True).measure(state).round(12)), float(VolumeResistance().measure(state))
    (-0.19, -0.2)
    """

    exact: bool = False

    unit = ""

    @property
    def linear(self) -> bool:  # noqa: D102
        return not self.exact

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        e = state.strain
        if self.exact:
            return (1 + e.xx) ** 2 / (1 + e.volume) - 1
        return e.xx - e.yy - e.zz

    def linearise(self, measured: FloatArray) -> FloatArray:
        """2 eps_x = 2 (sqrt(R/R0) - 1), exact where the volume is kept (nu = 1/2); NaN where R < 0.

        Parameters
        ----------
        measured : ndarray, shape (...)
            R/R0 - 1 [-].
        """
        if self.linear:
            return measured
        with np.errstate(invalid="ignore"):
            return 2 * (np.sqrt(1 + measured) - 1)

    @property
    def linear_part(self) -> Transducer:  # noqa: D102
        return VolumeResistance(exact=False)


@dataclass(frozen=True)
class EnergyDensity(Quantity, name="energy_density"):
    """Strain energy density [J/m^3], one of the quantities fitted to slowly adapting receptors. Not linear."""

    unit, linear, _of = "J/m^3", False, "energy_density"


@dataclass(frozen=True)
class MaxCompressiveStrain(Transducer, name="max_compressive_strain"):
    """Largest compressive principal strain [-], >= 0 (after Phillips and Johnson 1981). Not linear."""

    unit, linear = "", False

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        return np.maximum(-state.strain.principal[..., -1], 0.0)
