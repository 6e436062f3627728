"""What is prescribed of a body that presses on an area, checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._frozen import Frozen
from ...errors import InvalidValueError
from ..body import pressing

__all__ = ["Asked", "asked"]

Pair = FloatArray | None
_UNITS = {"force": "N", "depth": "m", "torsion": "N m", "twist": "rad"}
_PAIRS = {"moment": "N m", "tilt": "rad", "tangential": "N", "slide": "m"}


@dataclass(frozen=True)
class Asked(Frozen):
    """As `Prescribed` in a plane, of an area: force or depth [N, m], and of (y, z) moment or tilt, drag or slide.

    `torsion` or `twist` [N m, rad] are the moment and the turn about +x, from y towards z. None for what is found;
    without friction nothing is dragged.
    """

    force: float | None
    depth: float | None
    moment: Pair
    tilt: FloatArray
    tangential: Pair
    slide: Pair
    torsion: float | None
    twist: float | None
    friction: float | None


def asked(friction: float | None, **given: Any) -> Asked:
    """`given` are the other fields, each None where it is left out.

    Raises
    ------
    InvalidValueError
        Values that are not numbers or pairs of them, or that exclude each other.
    """
    values: dict[str, float | None] = {}
    pairs: dict[str, Pair] = {}
    if (given["force"] is None) == (given["depth"] is None):
        seen = f"force = {given['force']}, depth = {given['depth']}"
        raise InvalidValueError(seen, "one of the two has to be given", "force=1.5, or depth=0.1e-3")
    for one, other in (("moment", "tilt"), ("tangential", "slide"), ("torsion", "twist")):
        if given[one] is not None and given[other] is not None:
            seen = f"{one} = {given[one]}, {other} = {given[other]}"
            raise InvalidValueError(seen, "one of the two can be given", "leave out one of them")
    for name, unit in _UNITS.items():
        value = given[name]
        values[name] = None if value is None else _check.scalar(name, value, unit=unit)
        if name in ("force", "depth"):
            pressing(name, values[name], unit)
    for name, unit in _PAIRS.items():
        pairs[name] = None if given[name] is None else pair(name, given[name], unit)
    tilt = pairs.pop("tilt")
    upright = np.zeros(2) if tilt is None else tilt
    if friction is None:
        for name in ("tangential", "slide", "torsion", "twist"):
            if np.any(given[name]):
                seen = f"{name} = {given[name]}"
                raise InvalidValueError(seen, "nothing is dragged without friction", "give friction=, e.g. 0.5")
        force, depth = values["force"], values["depth"]
        return Asked(force, depth, pairs["moment"], upright, None, None, None, None, None)
    grip = _check.scalar("friction", friction, at_least=0.0)
    if pairs["tangential"] is None and pairs["slide"] is None:
        pairs["tangential"] = np.zeros(2)
    if values["torsion"] is None and values["twist"] is None:
        values["twist" if pairs["slide"] is not None else "torsion"] = 0.0
    moment, tangential, slide = (pairs[name] for name in ("moment", "tangential", "slide"))
    force, depth, torsion, twist = (values[name] for name in _UNITS)
    return Asked(force, depth, moment, upright, tangential, slide, torsion, twist, grip)


def pair(name: str, value: Any, unit: str) -> FloatArray:
    """Two numbers along (y, z)."""
    both = _check.real(name, value, unit=unit)
    if both.shape != (2,):
        seen = f"{name} of shape {both.shape}"
        raise InvalidValueError(seen, "on an area it has two components, along y and z", f"{name}=(1e-3, 0.0)")
    return both
