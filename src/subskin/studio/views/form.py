"""The numbers of a finger that a page offers to change, and how its file is changed: comments and layout stay."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InvalidValueError
from ...io.finger_file import FingerFile, parse_finger
from ...io.units import format_quantity, quantity, rounded
from ...skin import KINDS
from ...transducer import kinds

if TYPE_CHECKING:
    import tomlkit

__all__ = ["edited", "finger_of", "form_of"]

_SKINS = {
    "half_plane": "half plane",
    "half_space": "half space",
    "layers": "layers on a rigid base",
    "round": "round, on a core",
}
_NOISE = 0.005
"""Noise over the largest reading of a kind of sensor that is chosen."""
_MM, _MPA = (1e3, "mm"), (1e-6, "MPa")
_MOST_ROW, _MOST_SIDE = 128, 24
_LENGTH_KEYS = {"sensors.pitch", "sensors.depth", "skin.radius", "skin.core_radius"}
_WHOLE_KEYS = {"sensors.count", "sensors.rows", "sensors.columns"}


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


def _document(text: str) -> tomlkit.TOMLDocument:
    import tomlkit

    return tomlkit.parse(text)


def form_of(text: str, known: FingerFile | None = None) -> list[dict[str, Any]]:
    """What can be changed: for each its key, what it is called, its value in SI, its unit and limits.

    Parameters
    ----------
    text : str
        A finger.toml.
    known : FingerFile, optional
        The finger itself, where a part of it lies in a file beside the text.
    """
    file, document = finger_of(text) if known is None else known, _document(text)
    skin, sensors = _table(document, "skin"), _table(document, "sensors")
    kind, area = skin.get("kind", "half_plane"), file.finger.array.on_area
    skins = {k: v for k, v in _SKINS.items() if k in KINDS and not (area and k in ("half_plane", "round"))}
    out = [_choice("skin.kind", "skin", kind, {**skins, kind: _SKINS.get(kind, kind)}, "Skin")]
    layers = list(skin.get("layers", ()))
    for i, table in enumerate(layers or [skin]):
        prefix, name = (f"skin.layers.{i}", f"layer {i + 1} " if len(layers) > 1 else "") if layers else ("skin", "")
        material = file.finger.skin.materials[i]
        if layers:
            thick = quantity(table["thickness"], "m", "thickness")
            out.append(_number(f"{prefix}.thickness", f"{name}thickness", thick, _MM, 0.05, "Skin"))
        if table.get("material") is None:
            out.append(_number(f"{prefix}.young", f"{name}modulus", material.young, _MPA, 0.01, "Skin"))
            out.append(
                _number(f"{prefix}.poisson", f"{name}Poisson’s ratio", material.poisson, (1.0, ""), 0.01, "Skin")
            )
    for key, name in (("radius", "radius"), ("core_radius", "radius of the core")):
        if key in skin:
            out.append(_number(f"skin.{key}", name, quantity(skin[key], "m", key), _MM, 0.1, "Skin"))
    layout = sensors.get("layout", "row")
    if "y" not in sensors:
        layouts = {"row": "a row", "grid": "a grid", "hexagonal": "a hexagonal grid"}
        out.append(_choice("sensors.layout", "layout", layout, layouts, "Sensors"))
    if "count" in sensors:
        out.append(_count("sensors.count", "count", int(sensors["count"])))
    if "shape" in sensors:
        for key, name, value in zip(("sensors.rows", "sensors.columns"), ("along y", "along z"), sensors["shape"]):
            out.append(_count(key, f"count {name}", int(value)))
    for key, name in (("pitch", "pitch"), ("depth", "depth")):
        value = sensors.get(key)
        if isinstance(value, str | float | int):
            out.append(_number(f"sensors.{key}", name, quantity(value, "m", key), _MM, 0.05, "Sensors"))
    if isinstance(sensors.get("kind", "normal_strain"), str) and "channels" not in sensors and "sensor" not in sensors:
        offer = {name: name.replace("_", " ") for name in kinds() if not _needs(name)}
        felt = sensors.get("kind", "normal_strain")
        out.append(_choice("sensors.kind", "measure", felt, {**offer, felt: felt.replace("_", " ")}, "Sensors"))
    noise = np.asarray(file.finger.array.noise)
    if np.ptp(noise) == 0 and not isinstance(sensors.get("noise"), list) and "sensor" not in sensors:
        unit = file.finger.array.transducers[0].unit
        out.append(_number("sensors.noise", "noise", float(noise[0]), (1.0, unit), 0.0, "Sensors", least=0.0))
    return out


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
    known = {entry["key"]: entry for entry in form_of(text)}
    document = _document(text)
    skin, sensors = _table(document, "skin"), _table(document, "sensors")
    if key not in known:
        raise InvalidValueError(f"{key}", "this finger has no such number to change", "a key that the page offers")
    entry = known[key]
    if entry["kind"] == "choice":
        if value not in entry["choices"]:
            raise InvalidValueError(f"{key} = {value!r}", f"one of {', '.join(entry['choices'])} is needed", "")
        _CHOOSE[key](document, skin, sensors, finger_of(text), str(value))
    else:
        number = float(value) if isinstance(value, int | float) else float("nan")
        if not entry["least"] <= number <= entry["most"]:
            rule = f"it has to lie between {entry['least']:g} and {entry['most']:g}"
            raise InvalidValueError(f"{entry['label']} = {value}", rule, "")
        _write(skin, sensors, key, number)
    return _dumped(document)


def _write(skin: Any, sensors: Any, key: str, value: float) -> None:
    """Write a number."""
    if key in ("sensors.rows", "sensors.columns"):
        shape = [int(n) for n in sensors["shape"]]
        shape[key == "sensors.columns"] = round(value)
        sensors["shape"] = shape
        return
    room, *path, name = key.split(".")
    table = skin if room == "skin" else sensors
    for part in path:
        table = table[int(part)] if part.isdigit() else table[part]
    if key in _WHOLE_KEYS:
        table[name] = round(value)
    elif key in _LENGTH_KEYS or name == "thickness":
        table[name] = format_quantity(rounded(value), "m")
    elif name == "young":
        table[name] = format_quantity(rounded(value), "Pa")
    else:
        table[name] = rounded(value)


def _skin_kind(document: Any, skin: Any, sensors: Any, file: FingerFile, kind: str) -> None:
    """Another skin of the material at the surface, as thick as such fingers are."""
    material, depth = file.finger.skin.materials[0], float(np.asarray(file.finger.array.depth).max())
    for name in list(skin):
        del skin[name]
    stuff = {"young": format_quantity(material.young, "Pa"), "poisson": rounded(material.poisson)}
    skin["kind"] = kind
    if kind == "layers":
        skin["layers"] = _layers([{"thickness": _length(3 * depth), **stuff}])
    else:
        for name, value in stuff.items():
            skin[name] = value
    if kind == "round":
        skin["radius"], skin["core_radius"] = _length(4 * depth), _length(2 * depth)


def _layout(document: Any, skin: Any, sensors: Any, file: FingerFile, layout: str) -> None:
    """The same pitch and depth in another order; a skin that takes sensors on an area where they are on one."""
    before, count = sensors.get("layout", "row"), len(file.finger.array)
    if layout != "row" and not file.finger.skin.takes_local:
        _skin_kind(document, skin, sensors, file, "half_space" if file.finger.skin.endless else "layers")
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


def _sensor_kind(document: Any, skin: Any, sensors: Any, file: FingerFile, kind: str) -> None:
    """Another kind of sensor, with noise of some share of what it reads of the first touch."""
    from .touch import first_touch

    sensors["kind"] = kind
    for name in ("gain", "offset", "low", "high", "resolution"):
        sensors.pop(name, None)
    sensors["noise"] = 1.0
    changed = parse_finger(_dumped(document)).finger
    read = np.abs(changed.measure(first_touch(changed).contact()))
    sensors["noise"] = float(f"{_NOISE * float(read.max()) or 1.0:.1g}")


_CHOOSE: Mapping[str, Callable[[Any, Any, Any, FingerFile, str], None]] = {
    "skin.kind": _skin_kind,
    "sensors.layout": _layout,
    "sensors.kind": _sensor_kind,
}


def _table(document: Any, name: str) -> Any:
    return document[name]


def _layers(rows: list[dict[str, Any]]) -> Any:
    import tomlkit

    made = tomlkit.aot()
    for row in rows:
        table = tomlkit.table()
        for name, value in row.items():
            table.add(name, value)
        made.append(table)
    return made


def _dumped(document: Any) -> str:
    import tomlkit

    return tomlkit.dumps(document)


def _length(value: float) -> str:
    return format_quantity(float(f"{value:.2g}"), "m")


def _needs(kind: str) -> bool:
    """Whether a kind of sensor needs arguments, or is the memo's own curiosity."""
    try:
        kinds()[kind]()
    except TypeError:
        return True
    return False


def _number(
    key: str, label: str, value: float, unit: tuple[float, str], step: float, group: str, least: float = 1e-12
) -> dict[str, Any]:
    most = 0.5 if key.endswith("poisson") else 1e9 if unit[1] not in ("mm",) else 0.2
    least = -0.99 if key.endswith("poisson") else least
    return {
        "key": key,
        "label": label,
        "kind": "number",
        "value": value,
        "scale": unit[0],
        "unit": unit[1],
        "step": step,
        "least": least,
        "most": most,
        "group": group,
    }


def _count(key: str, label: str, value: int) -> dict[str, Any]:
    most = _MOST_SIDE if key != "sensors.count" else _MOST_ROW
    return {
        "key": key,
        "label": label,
        "kind": "count",
        "value": value,
        "scale": 1.0,
        "unit": "",
        "step": 1,
        "least": 1 if key != "sensors.count" else 2,
        "most": most,
        "group": "Sensors",
    }


def _choice(key: str, label: str, value: str, choices: Mapping[str, str], group: str) -> dict[str, Any]:
    return {"key": key, "label": label, "kind": "choice", "value": value, "choices": dict(choices), "group": group}
