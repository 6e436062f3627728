"""The memo's symbols: what each stands for, its unit, and what it may be."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import NamedTuple, TypeVar

from numpy.typing import ArrayLike

from .. import _check
from .._check import FloatArray
from ..errors import InvalidValueError

__all__ = ["SYMBOLS", "Symbol", "described", "given", "off_origin"]

_Equation = TypeVar("_Equation", bound=Callable[..., object])


class Symbol(NamedTuple):
    """What a symbol stands for (`meaning`), its `unit`, and whether only `positive` values make sense.

    Examples
    --------
    >>> SYMBOLS["d"]
    Symbol(meaning='depth of the sensors', unit='m', positive=True)
    """

    meaning: str
    unit: str
    positive: bool = False


SYMBOLS = {
    "P": Symbol("force per length of contact", "N/m"),
    "E": Symbol("modulus of elasticity", "Pa", True),
    "nu": Symbol("Poisson's ratio", ""),
    "r": Symbol("distance from the load", "m", True),
    "theta": Symbol("angle from the inward normal to the field point, or vertex angle of a wedge", "rad"),
    "alpha": Symbol("inclination of the force", "rad"),
    "x": Symbol("depth", "m"),
    "y": Symbol("position along the surface", "m"),
    "y0": Symbol("position along the surface", "m"),
    "z": Symbol("length along the contact", "m", True),
    "a": Symbol("half width of the contact in (14) to (17), its width in (18) to (22)", "m", True),
    "a1": Symbol("left edge of the contact", "m"),
    "a2": Symbol("right edge of the contact", "m"),
    "half_width": Symbol("half the width of the contact", "m", True),
    "b": Symbol("pitch of the sensors", "m", True),
    "d": Symbol("depth of the sensors", "m", True),
    "R": Symbol("radius of the cylinder", "m", True),
    "K": Symbol("constant of the wedge's pressure, E / (pi (1 - nu^2))", "Pa", True),
    "rho": Symbol("resistivity", "ohm m", True),
    "s": Symbol("spatial frequency", "1/m"),
    "f": Symbol("spatial frequency times 2 pi d", "", True),
    "attenuation": Symbol("ratio of the largest response to that at f", "", True),
    "sigma_r": Symbol("radial stress", "Pa"),
    "sigma_x": Symbol("stress along the depth", "Pa"),
    "sigma_y": Symbol("stress along the surface", "Pa"),
    "sigma_z": Symbol("stress along the contact", "Pa"),
    "eps_x": Symbol("strain along the depth", ""),
    "eps_y": Symbol("strain along the surface", ""),
    "eps_z": Symbol("strain along the contact", ""),
}


def described(equation: _Equation) -> _Equation:
    """The same function, its docstring completed by what `SYMBOLS` says of its parameters."""
    head, _, examples = inspect.cleandoc(equation.__doc__ or "").partition("\n\nExamples\n")
    head += "\n\nParameters\n----------"
    for name in inspect.signature(equation).parameters:
        if name in SYMBOLS:
            meaning, unit, positive = SYMBOLS[name]
            bound = ", > 0" if positive else ""
            head += f"\n{name} : array_like\n    {meaning[0].upper()}{meaning[1:]} [{unit or '-'}]{bound}."
    head += "\n\nRaises\n------\nInvalidValueError, GeometryError\n    "
    head += "A value that its symbol cannot have; shapes that do not broadcast."
    equation.__doc__ = f"{head}\n\nExamples\n{examples}"
    return equation


def given(**values: ArrayLike) -> tuple[FloatArray, ...]:
    """The values as float arrays in the order given, each checked by what its symbol stands for.

    Raises
    ------
    InvalidValueError
        A value that is no number, not finite, or not positive where its symbol has to be.
    GeometryError
        Shapes that do not broadcast.
    """
    arrays = {
        name: _check.real(name, value, unit=SYMBOLS[name].unit, above=0.0 if SYMBOLS[name].positive else None)
        for name, value in values.items()
    }
    _check.broadcast(**arrays)
    return tuple(arrays.values())


def off_origin(x: FloatArray, y: FloatArray) -> FloatArray:
    """r^2 = x^2 + y^2, refused where it is 0: the stress of a line load is infinite there."""
    r2 = x**2 + y**2
    if not (r2 > 0).all():
        raise InvalidValueError("x = 0, y = 0", "the stress is infinite where the load acts", "take a point off it")
    return r2
