"""What a sensor reports of the stress and strain at its position."""

from __future__ import annotations

import difflib
from abc import ABC, abstractmethod
from dataclasses import dataclass
from importlib import import_module
from inspect import isabstract
from operator import attrgetter
from typing import ClassVar

import numpy as np

from ._check import FloatArray
from ._registry import Named
from .errors import InvalidValueError, NotLinearError
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
    "kind_of",
    "kinds",
    "transducer_of",
]


@dataclass(frozen=True)
class Transducer(Named, ABC):
    """What is measured at a point of the skin.

    One of your own gives `unit` and `measure`; defined with a name, `class Tilt(Transducer, name="tilt")`, it is found
    by it in files. One that is not proportional to the load sets `linear = False`.

    Attributes
    ----------
    component : str
        The component of the field that a picture of the skin shows beside it, such as "strain.xx".

    Examples
    --------
    >>> import subskin as ss
    >>> class Stretch(ss.Transducer):
    ...     unit = ""
    ...     def measure(self, state):
    ...         return state.strain.yy
    >>> skin, load = ss.HalfPlane(ss.Material(young=0.4e6)), ss.LineLoad(force=40.0)
    >>> round(float(Stretch().measure(skin.state(load, x=2e-3, y=0.0))), 6)
    0.023873
    """

    component: ClassVar[str] = "strain.xx"

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
        """The quantity, in `unit`, at each point of `state`.

        Parameters
        ----------
        state : State
            Stress [Pa] and strain [-] at points of shape (...).

        Returns
        -------
        ndarray, shape (...)
        """

    def linearise(self, measured: FloatArray) -> FloatArray:
        """A quantity proportional to the load, from a measured one.

        Parameters
        ----------
        measured : ndarray, shape (...)
            What `measure` returns [`unit`].

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


class _Quantity(Transducer):
    """What is one quantity of the state, of the name `_of`."""

    _of: ClassVar[str]

    def measure(self, state: State) -> FloatArray:
        quantity: FloatArray = attrgetter(self._of)(state)
        return quantity


@dataclass(frozen=True)
class NormalStrain(_Quantity, name="normal_strain"):
    """Strain along the depth, eps_x [-] (memo eq. 8): a strain gauge standing in the skin."""

    unit, _of = "", "strain.xx"


@dataclass(frozen=True)
class LateralStrain(_Quantity, name="lateral_strain"):
    """Strain along the surface, eps_y [-]: a gauge lying in the skin.

    At nu = 1/2 in plane strain it is -eps_x (memo eq. 7).
    """

    unit, component, _of = "", "strain.yy", "strain.yy"


@dataclass(frozen=True)
class ShearStrain(_Quantity, name="shear_strain"):
    """Engineering shear strain gamma_xy = 2 eps_xy [-]."""

    unit, component, _of = "", "strain.xy", "strain.gamma_xy"


@dataclass(frozen=True)
class NormalStress(_Quantity, name="normal_stress"):
    """Stress along the depth, sigma_x [Pa], negative under a press."""

    unit, component, _of = "Pa", "stress.xx", "stress.xx"


@dataclass(frozen=True)
class MeanPressure(_Quantity, name="mean_pressure"):
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
    >>> from subskin.tensor import Strain, Stress
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
class EnergyDensity(_Quantity, name="energy_density"):
    """Strain energy density [J/m^3], one of the quantities fitted to slowly adapting receptors. Not linear."""

    unit, linear, _of = "J/m^3", False, "energy_density"


@dataclass(frozen=True)
class MaxCompressiveStrain(Transducer, name="max_compressive_strain"):
    """Largest compressive principal strain [-], >= 0 (after Phillips and Johnson 1981). Not linear."""

    unit, linear = "", False

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        return np.maximum(-state.strain.principal[..., -1], 0.0)


def kinds() -> dict[str, type[Transducer]]:
    """The transducers by the names that files use, one's own among them.

    Examples
    --------
    >>> kinds()["mean_pressure"].__name__
    'MeanPressure'
    """
    return dict(Transducer._by_name)


def kind_of(transducer: Transducer) -> str:
    """The name by which `transducer_of` finds the class of `transducer`: that of `kinds`, else "module:Class".

    Examples
    --------
    >>> kind_of(MeanPressure())
    'mean_pressure'
    """
    own = type(transducer)
    named = (name for name, kind in kinds().items() if kind is own)
    return next(named, f"{own.__module__}:{own.__qualname__}")


def transducer_of(kind: str) -> Transducer:
    """The transducer of a name of `kinds`, or of a class of one's own by its dotted name.

    Parameters
    ----------
    kind : str
        "mean_pressure", or "mypackage.mymodule:MyGauge" or "mypackage.mymodule.MyGauge", whose module is imported.

    Raises
    ------
    InvalidValueError
        An unknown name; a module that cannot be imported; something that is no Transducer, or needs arguments.

    Examples
    --------
    >>> transducer_of("mean_pressure"), transducer_of("subskin.transducer:MeanPressure")
    (MeanPressure(), MeanPressure())
    """
    known, seen = kinds(), f'kind = "{kind}"'
    if kind in known:
        return known[kind]()
    module, _, name = kind.partition(":") if ":" in kind else kind.rpartition(".")
    if not (module and name):
        close = difflib.get_close_matches(kind, list(known), n=1)
        fix = f'did you mean "{close[0]}"' if close else f"known: {', '.join(known)}, or mypackage.mymodule:MyGauge"
        raise InvalidValueError(seen, "no such kind of sensor is known", fix)
    try:
        home = import_module(module)
    except Exception as error:  # what a module of one's own does when it is imported is not ours to foresee
        fix = "install it, or put its folder on PYTHONPATH"
        raise InvalidValueError(seen, f"{module} cannot be imported ({error})", fix) from error
    try:
        found = attrgetter(name)(home)
    except AttributeError:
        raise InvalidValueError(seen, f"{module} has no {name}", "mypackage.mymodule:MyGauge") from None
    if not (isinstance(found, type) and issubclass(found, Transducer)):
        raise InvalidValueError(seen, "it is no Transducer", f"class {name}(subskin.Transducer)")
    if isabstract(found):
        raise InvalidValueError(seen, f"it lacks {', '.join(sorted(found.__abstractmethods__))}", "define them")
    try:
        return found()
    except TypeError as error:
        rule = f"it needs arguments ({error})"
        raise InvalidValueError(seen, rule, "a subclass or defaults that give them") from None
