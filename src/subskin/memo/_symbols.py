"""What the memo's equations share: its symbols, what each stands for and may be, and integrals over a contact."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError

__all__ = ["SYMBOLS", "Symbol", "described", "given", "off_origin", "over_contact"]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


def over_contact(
    function: Callable[[FloatArray], FloatArray],
    a1: float,
    a2: float,
    near: Iterable[float] = (),
    closest: float = 1e-6,
) -> float:
    """Integral of `function` from a1 to a2: Gauss's rule on panels that shrink towards each position in `near`.

    The substitution s = centre + half * sin(phi) takes away square roots at the edges. `closest` is the
    distance on which the function varies near those positions.

    Raises
    ------
    GeometryError
        a2 <= a1.
    """
    if not a2 > a1:
        seen = f"a1 = {a1:.6g}, a2 = {a2:.6g}"
        raise GeometryError(seen, "the right edge has to lie right of the left one", "swap them")
    centre, half = 0.5 * (a1 + a2), 0.5 * (a2 - a1)
    levels = int(np.clip(np.ceil(np.log(16 * half / closest) / np.log(4)), 3, 60))
    reach = np.pi * 0.25 ** np.arange(levels)
    cuts = {-0.5 * np.pi, 0.5 * np.pi, 0.0}
    for position in near:
        foot = float(np.arcsin(np.clip((position - centre) / half, -1, 1)))
        cuts |= {foot, *(float(foot + side * r) for r in reach for side in (-1, 1))}
    edges = np.array(sorted(c for c in cuts if abs(c) <= 0.5 * np.pi))
    width = 0.5 * np.diff(edges)[:, None]
    phi = 0.5 * (edges[1:] + edges[:-1])[:, None] + width * _NODES
    values = np.asarray(function(centre + half * np.sin(phi)))
    return float((width * _WEIGHTS * values * half * np.cos(phi)).sum())


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
