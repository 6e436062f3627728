"""What the members of a skin of one's own have to give (`_hooks.py`)."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _hooks
from ..material import Material
from ..tensor import State, Strain, Stress, Wave

__all__ = ["MEMBERS"]


def _materials(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> tuple[Material, ...]:
    if not isinstance(given, tuple | list) or not given or not all(isinstance(one, Material) for one in given):
        raise _hooks.wrong(
            said, given, "a tuple of Material is needed, from the surface down", "return (self.material,)"
        )
    return tuple(given)


def _one_number(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> float:
    return float(_hooks.numbers("a single one", ndim=0)(said, own, given, args))


def _length(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> float:
    found = _one_number(said, own, given, args)
    if not found > 0:
        raise _hooks.wrong(said, given, "has to be > 0 [m]; infinite without a base", "thickness = 6e-3")
    return found


def _crests(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> tuple[float, float] | None:
    if given is None:
        return None
    crest, pitch = _hooks.each_of((_one_number, _length), "the position of a crest and the pitch")(said, own, given, ())
    return crest, pitch


def _over_area(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
    shape = (6 if args[2:] and args[2] else 1, *args[1])
    found = _hooks.numbers(f"of the shape {shape}", ndim=3)(said, own, given, args)
    if found.shape != shape:
        raise _hooks.wrong(said, given, f"numbers of the shape {shape} are needed")
    return found


def _depths(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> tuple[float, ...]:
    return tuple(_hooks.numbers("a row of depths [m]", ndim=1)(said, own, given, args).tolist())


def _at(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
    if not callable(given):
        raise _hooks.wrong(said, given, "a function of the contact is needed", "return lambda contact: State(...)")

    def state(contact: Any) -> Any:
        found = given(contact)
        if not isinstance(found, State):
            raise _hooks.wrong(f"{said}(...)(contact)", found, "a State is needed", "tensor.State(stress, strain)")
        return found

    return state


def _wave(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
    if not isinstance(given, Wave):
        raise _hooks.wrong(said, given, "a Wave is needed", "tensor.Wave(stress, strain, ux, uy)")
    shape = (*(np.size(arg) for arg in args[:2]), 2)
    for name, part, kind in (("stress", given.stress, Stress), ("strain", given.strain, Strain)):
        if not isinstance(part, kind) or part.shape != shape:
            raise _hooks.wrong(f"{said}.{name}", part, f"a {kind.__name__} of the shape {shape} is needed")
    for name in ("ux", "uy"):
        if np.shape(getattr(given, name)) != shape:
            raise _hooks.wrong(f"{said}.{name}", getattr(given, name), f"numbers of the shape {shape} are needed")
    return given


def _influence(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
    found = _hooks.numbers("(2, 2, count)", ndim=3)(said, own, given, args)
    if found.shape != (2, 2, args[1]):
        raise _hooks.wrong(said, given, f"the shape (2, 2, {args[1]}) is needed")
    return found


MEMBERS: dict[str, _hooks.Rule] = {
    "materials": _materials,
    "at": _at,
    "wave": _wave,
    "surface_influence": _influence,
    "interfaces": _depths,
    "thickness": _length,
    "ridges": _crests,
    "takes_local": _hooks.instance((bool, np.bool_), "True or False"),
    "area_influence": _over_area,
    "curvature": _one_number,
}
