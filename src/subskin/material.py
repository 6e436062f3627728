"""The elastic material of a skin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Self

from ._declared import Noun, Real
from ._presets import RUBBERS, named
from ._shown import Presets

__all__ = ["Material"]

_YOUNG = Real("Pa", above=0.0, fix="a soft silicone has about 0.05e6 to 2e6 Pa")
_POISSON = Real(at_least=0.0, at_most=0.5, fix="rubber and silicone: 0.5; gelatin 0.5; foam about 0.1 to 0.3")


@dataclass(frozen=True)
class Material(Noun):
    """A linear elastic, isotropic material; every other modulus follows from these two numbers.

    Parameters
    ----------
    young : float
        Young's modulus E [Pa], > 0.
    poisson : float, optional
        Poisson's ratio nu [-], in [0, 0.5]; 0.5 (the default) is incompressible, exactly.

    Raises
    ------
    InvalidValueError
        Where either number is outside its range.

    Examples
    --------
    >>> rubber = Material(young=0.4e6, poisson=0.5)
    >>> round(rubber.shear)
    133333
    >>> rubber.bulk
    inf
    """

    young: Annotated[float, _YOUNG]
    poisson: Annotated[float, _POISSON] = 0.5

    EXAMPLE: ClassVar = "Material(young=0.4e6)"

    @classmethod
    def preset(cls, name: str, poisson: float = 0.5) -> Self:
        """A rubber by its name; `Material.presets()` lists them, with their spread and sources.

        Young's modulus of a rubber depends on how it was mixed, cured and tested, by a factor of two at times. The
        preset is a start for a design. A calibration, or a test of one's own, replaces it.

        Parameters
        ----------
        name : str
            E.g. "Ecoflex 00-30", "Dragon Skin 20", "Sylgard 184".
        poisson : float, optional
            Poisson's ratio nu [-].

        Raises
        ------
        InvalidValueError
            A name that is not known.

        Examples
        --------
        >>> print(Material.preset("Dragon Skin 20"))
        0.4423 MPa, nu 0.5
        """
        return cls(named(name, RUBBERS, "material").young, poisson)

    @staticmethod
    def presets() -> Presets:
        """The rubbers that `preset` knows: Young's modulus [Pa], what tests find, Shore hardness, source; a table.

        Examples
        --------
        >>> Material.presets()["Sylgard 184"]["high"]
        2970000.0
        """
        rows: dict[str, dict[str, Any]] = {name: {**vars(rubber)} for name, rubber in RUBBERS.items()}
        return Presets(rows, {"young": (1e-6, "MPa"), "low": (1e-6, "MPa"), "high": (1e-6, "MPa")})

    def __str__(self) -> str:
        e = self.young
        size, unit = (1e9, "GPa") if e >= 1e9 else (1e6, "MPa") if e >= 1e5 else (1e3, "kPa")
        return f"{e / size:.4g} {unit}, nu {self.poisson:.4g}"

    @property
    def shear(self) -> float:
        """Shear modulus, by definition G = E / (2 (1 + nu)) [Pa]."""
        return self.young / (2 * (1 + self.poisson))

    @property
    def bulk(self) -> float:
        """Bulk modulus, by definition K = E / (3 (1 - 2 nu)) [Pa]; infinite at nu = 1/2."""
        slack = 1 - 2 * self.poisson
        return self.young / (3 * slack) if slack > 0 else float("inf")

    @property
    def plane_strain_modulus(self) -> float:
        """E* = E / (1 - nu^2) [Pa], the modulus of a contact in plane strain."""
        return self.young / (1 - self.poisson**2)
