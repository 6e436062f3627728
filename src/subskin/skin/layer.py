"""A layer of a skin, and stacks of layers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

from .._declared import Noun, Real, Ruled
from ..errors import GeometryError, InvalidValueError
from ..material import Material

__all__ = ["LAYERS", "SOME_LAYERS", "Layer", "layers_of"]

_MOST = 40  # layers
_SPAN = 1e4
"""Most by which the thicknesses of a stack's layers may differ."""


@dataclass(frozen=True)
class Layer(Noun):
    """A layer of a skin.

    Parameters
    ----------
    material : Material
        Young's modulus and Poisson's ratio.
    thickness : float
        Thickness [m], > 0.
    bond : {"bonded", "frictionless"}, optional
        How it holds to what lies beneath it: it sticks, or it slides without friction and does not lift.

    Raises
    ------
    InvalidValueError
        A thickness that is not > 0, a bond of another name.

    Examples
    --------
    >>> import subskin as ss
    >>> print(ss.Layered(Layer(ss.Material(young=0.4e6), thickness=6e-3)))
    6 mm (0.4 MPa, nu 0.5) on a rigid base
    """

    material: Material
    thickness: Annotated[float, Real("m", above=0.0, fix="leave out a layer that is not there")]
    bond: Literal["bonded", "frictionless"] = "bonded"

    LOOSE: ClassVar = {"bonded": "", "frictionless": ", sliding"}

    def __str__(self) -> str:
        return f"{1e3 * self.thickness:.6g} mm ({self.material}{self.LOOSE[self.bond]})"


def layers_of(given: Any, least: int = 0) -> tuple[Layer, ...]:
    """One layer, or a sequence of `least` layers or more, as a tuple.

    Raises
    ------
    InvalidValueError, GeometryError
        Something that is no layer, or more than 40; a layer 10,000 times as thick as another.
    """
    listed = isinstance(given, Sequence) and not isinstance(given, str)
    layers = (given,) if isinstance(given, Layer) else tuple(given) if listed else ()
    if not (layers or (listed and not least)) or not all(isinstance(layer, Layer) for layer in layers):
        fix = "Layer(Material(young=0.4e6), thickness=4e-3)"
        raise InvalidValueError(f"layers = {given!r}", "one Layer or more are needed", fix)
    if len(layers) > _MOST:
        raise InvalidValueError(f"{len(layers)} layers", f"at most {_MOST} are handled", "join those that are alike")
    thin, thick = (extreme((layer.thickness for layer in layers), default=1.0) for extreme in (min, max))
    if thick > _SPAN * thin:
        seen = f"layers of {thin:.3g} and {thick:.3g} m"
        rule = f"one may be {_SPAN:.0e} times as thick as another: their waves are summed together"
        raise GeometryError(seen, rule, "leave out the thin one, or take the thick one at the bottom for base=")
    return layers


LAYERS = Ruled(lambda name, value: layers_of(value))
SOME_LAYERS = Ruled(lambda name, value: layers_of(value, least=1))
