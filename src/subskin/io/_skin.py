"""[skin] of a finger.toml: from its table to a skin, and the numbers of a skin as such a table has them."""

from __future__ import annotations

import difflib
import re
from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Any

from ..errors import InvalidValueError, SubskinError
from ..material import Material
from ..skin import KINDS, Layer, Ridged, Skin

if TYPE_CHECKING:
    from . import _schema

__all__ = ["Misplaced", "build_skin", "is_written", "key_of", "numbers"]

_EXAMPLE = {
    "young": 'young = "0.4 MPa"',
    "radius": 'radius = "8 mm"',
    "core_radius": 'core_radius = "4 mm"',
    "layers": "add [[skin.layers]] with young and thickness, one a layer, the first at the surface",
}


class Misplaced(Exception):
    """An error and the key that it is about."""

    def __init__(self, error: SubskinError, *path: str) -> None:
        self.error, self.path = error, path


def build_skin(table: _schema.SkinTable, at: tuple[str, ...] = ("skin",)) -> Skin:
    """The skin that the table at `at` describes: a key for each field of its class, a material being two.

    Raises
    ------
    Misplaced
        A kind that is not known, a key that it does not have or lacks, a value out of range.
    """
    kind = table.kind
    if kind not in KINDS:
        close = difflib.get_close_matches(kind, KINDS, n=1)
        fix = f'did you mean "{close[0]}"' if close else f"known: {', '.join(KINDS)}"
        wrong = InvalidValueError(f'kind = "{kind}"', "no such kind of skin is known", fix)
        raise Misplaced(wrong, *at, "kind")
    keys = {name: _keys(of) for name, of in KINDS.items()}
    mechanics = {key for of in keys.values() for key in of}
    for key in type(table).model_fields:
        if key in mechanics - keys[kind].keys() and key in table.model_fields_set:
            fix = ", ".join(f'"{k}"' for k in KINDS if key in keys[k])
            seen, rule = f'{key} beside kind = "{kind}"', f"such a skin has {', '.join(keys[kind])}"
            raise Misplaced(InvalidValueError(seen, rule, f"leave out {key}, or kind = {fix}"), *at, key)
    if table.material is not None and "young" not in keys[kind]:
        seen, rule = f'material beside kind = "{kind}"', "each layer has its own"
        raise Misplaced(InvalidValueError(seen, rule, "write material in [[skin.layers]]"), *at, "material")
    for key, needed in keys[kind].items():
        if needed and getattr(table, key) in (None, []) and not (key == "young" and table.material is not None):
            seen, rule = f'"{key}" is missing', f'kind = "{kind}" needs it'
            raise Misplaced(InvalidValueError(seen, rule, _EXAMPLE.get(key, f"{key} = ...")), *at, "")
    skin: Skin = _made(KINDS[kind], table, at)
    if table.ridges is None:
        return skin
    try:
        return Ridged(skin, **table.ridges.model_dump())
    except SubskinError as error:
        raise Misplaced(error, *at, "ridges", key_of(error)) from None


def _keys(kind: type[Skin]) -> dict[str, bool]:
    """The keys of a kind of skin, and whether each has to be there."""
    out: dict[str, bool] = {}
    for field in fields(kind):  # type: ignore[arg-type]  # those of KINDS are dataclasses
        needed = field.default is MISSING
        out |= {"young": needed, "poisson": False} if field.name == "material" else {field.name: needed}
    return out


def _made(kind: Any, table: Any, path: tuple[str, ...]) -> Any:
    """A skin, a layer or a material from its table."""
    values: dict[str, Any] = {}
    for field in fields(kind):
        name = field.name
        value = _made(Material, table, path) if name == "material" else getattr(table, name)
        if isinstance(value, list):
            value = [_made(Layer, row, (*path, name, str(i))) for i, row in enumerate(value)]
        elif hasattr(type(value), "model_fields"):
            value = _made(Material, value, (*path, name))
        if value is not None:
            values[name] = value
    if kind is Material and "young" not in values and table.material is None:
        wrong = InvalidValueError('"young" is missing', "a material needs it", 'young = "0.4 MPa", or material = "..."')
        raise Misplaced(wrong, *path, "")
    try:
        if kind is Material and table.material is not None:
            values = {"young": Material.preset(table.material).young} | values
        return kind(**values)
    except SubskinError as error:
        raise Misplaced(error, *path, key_of(error)) from None


def is_written(skin: Skin) -> bool:
    """Whether a file can describe a skin, with or without ridges."""
    return type(skin if skin.ridges is None else getattr(skin, "skin", None)) in KINDS.values()


def numbers(skin: Any, *path: str | int) -> dict[tuple[str | int, ...], Any]:
    """What the table of a skin says, in SI: each value by its path in the table."""
    out: dict[tuple[str | int, ...], Any] = {}
    for field in fields(skin):
        name, value = field.name, getattr(skin, field.name)
        if isinstance(value, Skin):  # what stands on it is in a table of its own
            return numbers(value, *path) | {
                (*path, "ridges", f.name): v for f in fields(skin)[1:] if (v := getattr(skin, f.name)) is not None
            }
        if isinstance(value, tuple):
            for i, row in enumerate(value):
                out |= numbers(row, *path, name, i)
        elif isinstance(value, Material):
            out |= numbers(value, *path, *(() if name == "material" else (name,)))
        elif value is not None:
            out[(*path, name)] = value
    return out


def key_of(error: SubskinError) -> str:
    """The key that an error of the model is about: its message begins with it."""
    found = re.match(r"[a-z_]+", error.seen)
    return {"transducer": "kind"}.get(found[0], found[0]) if found else ""
