"""What is prescribed of a body that presses, checked: along a row, or on an area."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..errors import InvalidValueError

__all__ = ["Asked", "along_axes", "asked"]

_LEAST, _MOST = 1e-30, 1e30
"""Forces and depths between which no product of them overflows."""
_UNITS = {
    "force": ("N/m", "N"), "depth": ("m", "m"), "torsion": ("", "N m"), "twist": ("", "rad"), "moment": ("N", "N m"),
    "tilt": ("rad", "rad"), "tangential": ("N/m", "N"), "slide": ("m", "m"),
}  # fmt: skip
"""Units of a long body and of one on an area."""
_ALONG = ("moment", "tilt", "tangential", "slide")
"""What has a component along each axis of the surface."""
_EITHER = (("moment", "tilt"), ("tangential", "slide"), ("torsion", "twist"))


@dataclass(frozen=True, eq=False)
class Asked(Frozen):
    """What is prescribed, None for what is found; components along the axes of the surface have the shape (d,).

    Units as in `press`. Without friction, which is None then, nothing is dragged. A long body does not turn about x:
    its `twist` is 0.
    """

    force: float | None
    depth: float | None
    moment: FloatArray | None
    tilt: FloatArray
    tangential: FloatArray | None
    slide: FloatArray | None
    torsion: float | None
    twist: float | None
    friction: float | None


def asked(axes: int, *, friction: float | None, **given: Any) -> Asked:
    """`given` are the other fields, each None where it is left out, of a body on a surface of so many `axes`.

    Raises
    ------
    InvalidValueError
        Values that are not numbers or pairs of them, or that exclude each other.
    """
    if (given["force"] is None) == (given["depth"] is None):
        seen, fix = f"force = {given['force']}, depth = {given['depth']}", ("force=40.0", "force=1.5")[axes - 1]
        raise InvalidValueError(seen, "one of the two has to be given", f"{fix}, or depth=0.1e-3")
    values: dict[str, Any] = {}
    for name, value in given.items():
        read, unit = along_axes if name in _ALONG else _number, _UNITS[name][axes - 1]
        if axes == 1 and name in _EITHER[2] and value is not None:
            raise InvalidValueError(f"{name} = {value}", "a long body does not turn about x", f"leave out {name}")
        values[name] = None if value is None else read(name, value, unit, axes)
    values["tilt"] = np.zeros(axes) if values["tilt"] is None else values["tilt"]
    for one, other in _EITHER:
        if given[one] is not None and given[other] is not None and (other != "tilt" or values["tilt"].any()):
            seen = f"{one} = {given[one]}, {other} = {given[other]}"
            raise InvalidValueError(seen, "one of the two can be given", "leave out one of them")
    if friction is None:
        for name in (*_EITHER[1], *_EITHER[2]):
            if given[name] is not None and np.any(values[name]):
                seen, rule = f"{name} = {given[name]}", "nothing is dragged without friction"
                raise InvalidValueError(seen, rule, "give friction=, e.g. 0.5")
            values[name] = None
        return Asked(**values, friction=None)
    grip = _check.scalar("friction", friction, at_least=0.0, finite=axes == 2)
    for name in ("tangential", "torsion"):
        if grip == 0 and np.any(values[name]):
            seen = f"{name} = {given[name]} {_UNITS[name][axes - 1]} at friction = 0"
            raise InvalidValueError(seen, "nothing holds that drag", "friction > 0")
    if values["tangential"] is None and values["slide"] is None:
        values["tangential"] = np.zeros(axes)
    if values["torsion"] is None and values["twist"] is None:
        values["twist" if axes == 1 or values["slide"] is not None else "torsion"] = 0.0
    return Asked(**values, friction=grip)


def along_axes(name: str, value: Any, unit: str, axes: int, **limits: Any) -> FloatArray:
    """One number of a long body, or two along (y, z), as an array (d,)."""
    if axes == 1:
        return np.array([_check.scalar(name, value, unit=unit, **limits)])
    both = _check.real(name, value, unit=unit, **limits)
    if both.shape != (2,):
        seen = f"{name} of shape {both.shape}"
        raise InvalidValueError(seen, "on an area it has two components, along y and z", f"{name}=(1e-3, 0.0)")
    return both


def _number(name: str, value: Any, unit: str, axes: int) -> float:
    number = _check.scalar(name, value, unit=unit)
    if name not in ("force", "depth"):
        return number
    if not number > 0:
        seen = f"{name} = {number:.6g} {unit}"
        raise InvalidValueError(seen, "the indenter never touches the skin", f"give a {name} > 0")
    return _check.scalar(name, value, unit=unit, at_least=_LEAST, at_most=_MOST)
