"""What a sensor reports of the stress and strain at its place."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from ._check import FloatArray
from .errors import NotLinearError
from .tensor import State

__all__ = [
    "EnergyDensity",
    "LateralStrain",
    "MaxCompressiveStrain",
    "MeanPressure",
    "NormalStrain",
    "NormalStress",
    "ShearStrain",
    "Transducer",
    "VolumeResistance",
]


@dataclass(frozen=True)
class Transducer(ABC):
    """What is measured at a point. `linear` tells whether it is proportional to the load; `unit` is its unit."""

    @property
    @abstractmethod
    def unit(self) -> str:
        """Unit of the measured quantity; "" for a strain or a ratio."""

    @property
    def linear(self) -> bool:
        """Whether the measured quantity is proportional to the load."""
        return True

    @abstractmethod
    def measure(self, state: State) -> FloatArray:
        """The quantity at each point of `state`."""

    def linearise(self, measured: FloatArray) -> FloatArray:
        """A quantity proportional to the load, from a measured one.

        Raises
        ------
        NotLinearError
            Where no such quantity follows from this transducer alone.
        """
        if self.linear:
            return measured
        raise NotLinearError(
            f"transducer {type(self).__name__}",
            "its reading is not proportional to the load and cannot be made so",
            "simulate with it, but locate with a linear one such as NormalStrain() or MeanPressure()",
        )

    @property
    def linear_part(self) -> Transducer:
        """The transducer that measures what `linearise` returns."""
        return self


@dataclass(frozen=True)
class NormalStrain(Transducer):
    """Strain along the depth, eps_x [-] (memo eq. 8): a strain gauge standing in the skin."""

    @property
    def unit(self) -> str:  # noqa: D102
        return ""

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        return state.strain.xx


@dataclass(frozen=True)
class LateralStrain(Transducer):
    """Strain along the surface, eps_y [-]: a gauge lying in the skin. At nu = 1/2 in plane strain it is -eps_x."""

    @property
    def unit(self) -> str:  # noqa: D102
        return ""

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        return state.strain.yy


@dataclass(frozen=True)
class ShearStrain(Transducer):
    """Engineering shear strain gamma_xy = 2 eps_xy [-]."""

    @property
    def unit(self) -> str:  # noqa: D102
        return ""

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        return state.strain.gamma_xy


@dataclass(frozen=True)
class NormalStress(Transducer):
    """Stress along the depth, sigma_x [Pa], negative under a press."""

    @property
    def unit(self) -> str:  # noqa: D102
        return "Pa"

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        return state.stress.xx


@dataclass(frozen=True)
class MeanPressure(Transducer):
    """Hydrostatic pressure -(sigma_x + sigma_y + sigma_z)/3 [Pa]: a barometer cast in rubber."""

    @property
    def unit(self) -> str:  # noqa: D102
        return "Pa"

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        return state.stress.mean_pressure


@dataclass(frozen=True)
class VolumeResistance(Transducer):
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
    >>> from subskin.tensor import Strain, Stress
    >>> zero, e = np.array(0.0), np.array(-0.1)
    >>> state = State(Stress(zero, zero, zero, zero), Strain(e, -e, zero, zero))
    >>> float(VolumeResistance(exact=True).measure(state).round(12)), float(VolumeResistance().measure(state))
    (-0.19, -0.2)
    """

    exact: bool = False

    @property
    def unit(self) -> str:  # noqa: D102
        return ""

    @property
    def linear(self) -> bool:  # noqa: D102
        return not self.exact

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        e = state.strain
        if self.exact:
            return (1 + e.xx) ** 2 / (1 + e.volume) - 1
        return e.xx - e.yy - e.zz

    def linearise(self, measured: FloatArray) -> FloatArray:
        """2 eps_x = 2 (sqrt(R/R0) - 1), exact where the volume is kept (nu = 1/2); NaN where R < 0."""
        if self.linear:
            return measured
        with np.errstate(invalid="ignore"):
            return 2 * (np.sqrt(1 + measured) - 1)

    @property
    def linear_part(self) -> Transducer:  # noqa: D102
        return VolumeResistance(exact=False)


@dataclass(frozen=True)
class EnergyDensity(Transducer):
    """Strain energy density [J/m^3], one of the quantities fitted to slowly adapting receptors. Not linear."""

    @property
    def unit(self) -> str:  # noqa: D102
        return "J/m^3"

    @property
    def linear(self) -> bool:  # noqa: D102
        return False

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        return state.energy_density


@dataclass(frozen=True)
class MaxCompressiveStrain(Transducer):
    """Largest compressive principal strain [-], >= 0 (after Phillips and Johnson 1981). Not linear."""

    @property
    def unit(self) -> str:  # noqa: D102
        return ""

    @property
    def linear(self) -> bool:  # noqa: D102
        return False

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        return np.maximum(-state.strain.principal[..., -1], 0.0)
