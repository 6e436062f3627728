"""The numbers of a finger that a page offers to change, and how its file is changed: comments and layout stay."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..errors import InvalidValueError
from ..io.finger_file import FingerFile, parse_finger
from ..io.units import format_quantity, quantity, rounded
from ..skin import KINDS
from ..transducer import kinds
from .state import first_touch

__all__ = ["edited", "finger_of", "form_of"]

_SKINS = {
    "half_plane": "half plane",
    "half_space": "half space",
    "layers": "layers on a rigid base",
    "round": "round, on a core",
}
_LAYOUTS = {"row": "a row", "grid": "a grid", "hexagonal": "a hexagonal grid"}
_NOISE = 0.005
"""Noise over the largest reading of a kind of sensor that is chosen."""


class Offer(NamedTuple):
    """How a kind of number is offered: its unit and limits, and how it is written into a file."""

    unit: str
    scale: float
    step: float
    least: float
    most: float
    written: Callable[[float], Any] = rounded
    kind: str = "number"


_LENGTH = Offer("mm", 1e3, 0.05, 1e-12, 0.2, lambda value: format_quantity(rounded(value), "m"))
_RADIUS = _LENGTH._replace(step=0.1)
_MODULUS = Offer("MPa", 1e-6, 0.01, 1e-12, 1e9, lambda value: format_quantity(rounded(value), "Pa"))
_POISSON = Offer("", 1.0, 0.01, -0.99, 0.5)
_SIZE = Offer("", 1.0, 0.0, 0.0, 1e9)
_COUNT = Offer("", 1.0, 1, 2, 128, round, "count")
_SIDE = _COUNT._replace(least=1, most=24)


class Entry(NamedTuple):
    """A number, or a choice, and where it stands in the file."""

    key: str
    label: str
    value: Any
    of: Offer | Mapping[str, str]

    def said(self) -> dict[str, Any]:
        """What a page is told of it."""
        told = {"key": self.key, "label": self.label, "value": self.value, "group": self.key.partition(".")[0].title()}
        if not isinstance(self.of, Offer):
            return {**told, "kind": "choice", "choices": dict(self.of)}
        more = self.of._asdict()
        del more["written"]
        return told | more


@lru_cache(maxsize=64)
def finger_of(text: str) -> FingerFile:
    """The finger that a text describes; kept, so that what was tabulated of it serves again.

    Parameters
    ----------
    text : str
        A finger.toml.

    Raises
    ------
    FileError
        As `subskin.io.parse_finger`.
    """
    return parse_finger(text)


def form_of(file: FingerFile) -> list[dict[str, Any]]:
    """What can be changed: for each its key, what it is called, its value in SI, its unit and limits.

    Parameters
    ----------
    file : FingerFile
        The finger.
    """
    return [entry.said() for entry in _entries(file, _document(file.text))]


def _entries(file: FingerFile, document: Any) -> Iterator[Entry]:
    yield from _of_skin(file, document["skin"])
    yield from _of_sensors(file, document["sensors"])


def _of_skin(file: FingerFile, skin: Any) -> Iterator[Entry]:
    kind, area = skin.get("kind", "half_plane"), file.finger.array.on_area
    offer = {k: v for k, v in _SKINS.items() if k in KINDS and not (area and k in ("half_plane", "round"))}
    yield Entry("skin.kind", "skin", kind, {**offer, kind: _SKINS.get(kind, kind)})
    layers = list(skin.get("layers", ()))
    for i, table in enumerate(layers or [skin]):
        at, name = ("skin", "") if not layers else (f"skin.layers.{i}", f"layer {i + 1} " if len(layers) > 1 else "")
        if layers:
            thick = quantity(table["thickness"], "m", "thickness")
            yield Entry(f"{at}.thickness", f"{name}thickness", thick, _LENGTH)
        if table.get("material") is None:
            material = file.finger.skin.materials[i]
            yield Entry(f"{at}.young", f"{name}modulus", material.young, _MODULUS)
            yield Entry(f"{at}.poisson", f"{name}Poisson’s ratio", material.poisson, _POISSON)
    for key, name in (("radius", "radius"), ("core_radius", "radius of the core")):
        if key in skin:
            yield Entry(f"skin.{key}", name, quantity(skin[key], "m", key), _RADIUS)


def _of_sensors(file: FingerFile, sensors: Any) -> Iterator[Entry]:
    array = file.finger.array
    if "y" not in sensors:
        yield Entry("sensors.layout", "layout", sensors.get("layout", "row"), _LAYOUTS)
    if "count" in sensors:
        yield Entry("sensors.count", "count", int(sensors["count"]), _COUNT)
    for i, value in enumerate(sensors.get("shape", ())):
        yield Entry(f"sensors.shape.{i}", f"count along {'yz'[i]}", int(value), _SIDE)
    for key in ("pitch", "depth"):
        if isinstance(sensors.get(key), str | float | int):
            yield Entry(f"sensors.{key}", key, quantity(sensors[key], "m", key), _LENGTH)
    felt = sensors.get("kind", "normal_strain")
    if isinstance(felt, str) and "channels" not in sensors and "sensor" not in sensors:
        choices = {name: name.replace("_", " ") for name in (*_plain_kinds(), felt)}
        yield Entry("sensors.kind", "measure", felt, choices)
    noise = np.asarray(array.noise)
    if np.ptp(noise) == 0 and not isinstance(sensors.get("noise"), list) and "sensor" not in sensors:
        yield Entry("sensors.noise", "noise", float(noise[0]), _SIZE._replace(unit=array.transducers[0].unit))


def edited(text: str, key: str, value: Any) -> str:
    """The text with another value, in SI, of a key of `form_of`.

    Parameters
    ----------
    text : str
        A finger.toml.
    key : str
        What changes.
    value : float or str
        To what.

    Raises
    ------
    InvalidValueError, FileError
        A key that is not offered, a value out of range; what such a finger cannot have.
    """
    file, document = finger_of(text), _document(text)
    entry = next((entry for entry in _entries(file, document) if entry.key == key), None)
    if entry is None:
        raise InvalidValueError(f"{key}", "this finger has no such number to change", "a key that the page offers")
    if not isinstance(entry.of, Offer):
        if value not in entry.of:
            raise InvalidValueError(f"{key} = {value!r}", f"one of {', '.join(entry.of)} is needed", "")
        _CHOOSE[key](document, file, str(value))
        return _dumped(document)
    number = float(value) if isinstance(value, int | float) else float("nan")
    if not entry.of.least <= number <= entry.of.most:
        rule = f"it has to lie between {entry.of.least:g} and {entry.of.most:g}"
        raise InvalidValueError(f"{entry.label} = {value}", rule, "")
    *path, last = (int(part) if part.isdigit() else part for part in key.split("."))
    table = document
    for part in path:
        table = table[part]
    table[last] = entry.of.written(number)
    return _dumped(document)


def _skin_kind(document: Any, file: FingerFile, kind: str) -> None:
    """Another skin of the material at the surface, as thick as such fingers are."""
    skin = document["skin"]
    material, depth = file.finger.skin.materials[0], float(np.asarray(file.finger.array.depth).max())
    for name in list(skin):
        del skin[name]
    stuff = {"young": format_quantity(material.young, "Pa"), "poisson": rounded(material.poisson)}
    skin["kind"] = kind
    if kind == "layers":
        skin["layers"] = _layer({"thickness": _length(3 * depth), **stuff})
    else:
        for name, value in stuff.items():
            skin[name] = value
    if kind == "round":
        skin["radius"], skin["core_radius"] = _length(4 * depth), _length(2 * depth)


def _layout(document: Any, file: FingerFile, layout: str) -> None:
    """The same pitch and depth in another order; a skin that takes sensors on an area where they are on one."""
    sensors, finger = document["sensors"], file.finger
    before, count = sensors.get("layout", "row"), len(finger.array)
    if layout != "row" and not finger.skin.takes_local:
        _skin_kind(document, file, "half_space" if finger.skin.endless else "layers")
    if layout == "row":
        sensors.pop("shape", None)
        sensors["count"] = min(count, 8)
    elif before == "row":
        sensors.pop("count", None)
        side = max(2, min(round(count**0.5), 8)) if count > 8 else 4
        sensors["shape"] = [side, side]
    sensors["layout"] = layout
    for name in ("locate", "recording"):  # what was said of the sensors that were
        if (before == "row") != (layout == "row"):
            document.pop(name, None)


def _sensor_kind(document: Any, file: FingerFile, kind: str) -> None:
    """Another kind of sensor, with noise of some share of what it reads of the first touch."""
    sensors = document["sensors"]
    sensors["kind"] = kind
    for name in ("gain", "offset", "low", "high", "resolution"):
        sensors.pop(name, None)
    sensors["noise"] = 1.0
    changed = parse_finger(_dumped(document)).finger
    read = np.abs(changed.measure(first_touch(changed).contact))
    sensors["noise"] = float(f"{_NOISE * float(read.max()) or 1.0:.1g}")


_CHOOSE: Mapping[str, Callable[[Any, FingerFile, str], None]] = {
    "skin.kind": _skin_kind,
    "sensors.layout": _layout,
    "sensors.kind": _sensor_kind,
}


def _plain_kinds() -> Iterator[str]:
    """Kinds of sensors that need no arguments, and are not the memo's own curiosity."""
    for name, kind in kinds().items():
        try:
            kind()
        except TypeError:
            continue
        yield name


def _document(text: str) -> Any:
    import tomlkit

    return tomlkit.parse(text)


def _dumped(document: Any) -> str:
    import tomlkit

    return tomlkit.dumps(document)


def _layer(row: Mapping[str, Any]) -> Any:
    import tomlkit

    table, made = tomlkit.table(), tomlkit.aot()
    for name, value in row.items():
        table.add(name, value)
    made.append(table)
    return made


def _length(value: float) -> str:
    return format_quantity(float(f"{value:.2g}"), "m")
