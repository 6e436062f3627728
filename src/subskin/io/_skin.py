"""[skin] of a finger.toml: from its table to a skin."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InvalidValueError, SubskinError
from ..material import Material
from ..skin import HalfPlane, Layer, Layered, Round, Skin

if TYPE_CHECKING:
    from . import _schema

__all__ = ["Misplaced", "build_skin", "key_of"]

_KEYS = {
    "half_plane": ("young", "poisson", "plane"),
    "layers": ("layers", "base"),
    "round": ("young", "poisson", "radius", "core_radius"),
}
_NEEDED = {"half_plane": ("young",), "layers": ("layers",), "round": ("young", "radius", "core_radius")}
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
    """The skin that the table at `at` describes.

    Raises
    ------
    Misplaced
        A key that the kind does not have or lacks, a value out of range.
    """
    kind, known = table.kind, _KEYS[table.kind]
    mechanics = {key for keys in _KEYS.values() for key in keys}
    given = [key for key in type(table).model_fields if key in table.model_fields_set & mechanics]
    for key in given:
        if key in known:
            continue
        fix = ", ".join(f'"{k}"' for k in _KEYS if key in _KEYS[k])
        seen, rule = f'{key} beside kind = "{kind}"', f"such a skin has {', '.join(known)}"
        raise Misplaced(InvalidValueError(seen, rule, f"leave out {key}, or kind = {fix}"), *at, key)
    for key in _NEEDED[kind]:
        if not getattr(table, key):
            seen, rule = f'"{key}" is missing', f'kind = "{kind}" needs it'
            raise Misplaced(InvalidValueError(seen, rule, _EXAMPLE[key]), *at, "")
    if kind == "layers":
        return _layered(table, at)
    material = _material(table, *at)
    if kind == "half_plane":
        return HalfPlane(material, table.plane or "strain")
    try:
        return Round(material, _given(table.radius), _given(table.core_radius))
    except SubskinError as error:
        raise Misplaced(error, *at, key_of(error)) from None


def _layered(table: _schema.SkinTable, at: tuple[str, ...]) -> Skin:
    layers = []
    for i, row in enumerate(table.layers or ()):
        path = (*at, "layers", str(i))
        material = _material(row, *path)
        try:
            layers.append(Layer(material, row.thickness, row.bond))
        except SubskinError as error:
            raise Misplaced(error, *path, key_of(error)) from None
    base = None if table.base is None else _material(table.base, *at, "base")
    return Layered(layers, base)


def _material(table: _schema.MaterialTable | _schema.SkinTable, *path: str) -> Material:
    try:
        return Material(_given(table.young), 0.5 if table.poisson is None else table.poisson)
    except SubskinError as error:
        raise Misplaced(error, *path, key_of(error)) from None


def _given(value: float | None) -> float:
    """What has been seen to be there."""
    return np.nan if value is None else value


def key_of(error: SubskinError) -> str:
    """The key that an error of the model is about: its message begins with it."""
    found = re.match(r"[a-z_]+", error.seen)
    return {"transducer": "kind"}.get(found[0], found[0]) if found else ""
