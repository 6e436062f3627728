"""[skin] of a finger.toml: from its table to a skin, and the numbers of a skin as such a table has them."""

from __future__ import annotations

import difflib
from dataclasses import MISSING, fields
from typing import Annotated, Any, Literal

from pydantic import StrictStr

from ..errors import InvalidValueError
from ..finger import LARGEST
from ..material import Material
from ..skin import KINDS, Layer, Ridged, Skin
from ._tables import LONGEST, RIDGE, Doubt, FingerTable, Length, Number, Pressure, StrictTable
from ._toml_errors import Misplaced, under

__all__ = ["SkinTable", "build_skin", "is_written", "numbers"]

_EXAMPLE = {
    "young": 'young = "0.4 MPa"',
    "radius": 'radius = "8 mm"',
    "core_radius": 'core_radius = "4 mm"',
    "layers": "add [[skin.layers]] with young and thickness, one a layer, the first at the surface",
}


class MaterialTable(StrictTable):
    """[skin.base]: the half plane beneath the layers; [skin.core]: what the core of a round finger is made of."""

    material: StrictStr | None = None
    young: Pressure | None = None
    poisson: Number = 0.5


class LayerTable(MaterialTable):
    """[[skin.layers]]: one layer, the first at the surface."""

    thickness: Annotated[Length, Doubt(LARGEST)]
    bond: Literal["bonded", "frictionless"] = "bonded"


class RidgesTable(StrictTable):
    """[skin.ridges]: ridges on the skin."""

    pitch: Annotated[Length, Doubt(RIDGE, "pitch of ridges")]
    height: Length
    width: Length | None = None
    crest: Length = 0.0


class SkinTable(FingerTable):
    """[skin]: what is pressed. Which keys are needed depends on the kind (see `_skin`)."""

    kind: StrictStr = "half_plane"
    material: StrictStr | None = None
    young: Pressure | None = None
    poisson: Number | None = None
    plane: Literal["strain", "stress"] | None = None
    radius: Annotated[Length | None, Doubt(LONGEST, "radius of [skin]")] = None
    core_radius: Length | None = None
    layers: list[LayerTable] | None = None
    base: MaterialTable | None = None
    core: MaterialTable | None = None
    bond: Literal["bonded", "frictionless"] | None = None
    ridges: RidgesTable | None = None

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        return {"skin": build_skin(self)}


def build_skin(table: SkinTable, at: tuple[str, ...] = ("skin",)) -> Skin:
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
    with under(*at, "ridges"):
        return Ridged(skin, **table.ridges.model_dump())


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
    with under(*path):
        if kind is Material and table.material is not None:
            values = {"young": Material.preset(table.material).young} | values
        return kind(**values)


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
