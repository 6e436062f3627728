"""Another finger's numbers written into a finger.toml, comments and layout kept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .._check import FloatArray
from ..errors import InvalidValueError
from ..finger import Finger
from ..skin import KINDS, Skin
from ._parts import IN_READINGS, in_readings, is_written, numbers
from .units import format_quantity, rounded

__all__ = ["edited", "model_facts", "per_sensor", "with_table"]

_PER_SENSOR = {"depth": "m", "width": "m", "gain": "", "offset": "", "lift": "", "noise": ""}
_SAME = 1e-9


def edited(
    text: str, old: Finger, new: Finger, origin: Any, turn: float, facts: Mapping[str, Any], stirs: bool = False
) -> str:
    """`text`, which describes `old`, changed to describe `new`; [calibration] is written anew.

    stirs: keep the old noise in [tare], since the new one counts how wrong the model is, which no reading stirs by.
    """
    import tomlkit

    document = tomlkit.parse(text)
    skin: Any = document["skin"]
    sensors: Any = document["sensors"]
    _edit_skin(skin, old.skin, new.skin)
    felt = {kind.unit for kind in old.array.transducers}
    unsaid = document.get("recording", {}).get("unit") is None and len(felt) == 1
    if unsaid and "gain" not in sensors and not _same(np.asarray(old.array.gain), np.asarray(new.array.gain)):
        _without_units(document, felt.pop(), "N" if old.array.on_area else "N/m")
    moved = not _same(old.array.points, new.array.points)
    for name in ("layout", "count", "shape", "pitch", "centre") if moved else ():
        sensors.pop(name, None)
    alone = moved and "channels" in sensors  # channels of one position may have moved apart
    if alone:
        channels = sensors.pop("channels")
        sensors.add("kind", [*channels] * (len(new.array) // len(channels)))
    for name, unit in _PER_SENSOR.items():
        before, after = (np.asarray(getattr(f.array, name)) for f in (old, new))
        if not _same(before, after) or (alone and name in sensors):
            _set(sensors, name, per_sensor(after, unit))
    for name in ("low", "high", "resolution") if alone else ():
        if name in sensors:
            _set(sensors, name, per_sensor(np.asarray(getattr(new.array, name))))
    if moved:
        _set(sensors, "y", [format_quantity(float(v), "m") for v in np.asarray(new.array.y)])
        if new.array.on_area or "z" in sensors:
            _set(sensors, "z", [format_quantity(float(v), "m") for v in np.asarray(new.array.z)])
    before, after = (np.asarray(finger.array.noise) for finger in (old, new))
    if stirs and (before > 0).all() and (after > before).any():
        if "tare" not in document:
            document.add(tomlkit.nl())
            document.add("tare", tomlkit.table())
        _set(document["tare"], "noise", per_sensor(before))
    if new.tolerances is None and "tolerances" in document:  # of the drawing
        del document["tolerances"]
    if "calibration" in document:
        del document["calibration"]
    table = tomlkit.table()
    if new.array.on_area:
        table.add("origin", [format_quantity(float(v), "m") for v in np.broadcast_to(origin, 2)])
        table.add("turn", format_quantity(turn, "rad"))
    else:
        table.add("origin", format_quantity(origin, "m"))
    for name, value in sorted(facts.items(), key=lambda fact: isinstance(fact[1], Mapping)):  # tables come last
        if isinstance(value, Mapping):
            inner = tomlkit.table()
            for key, item in value.items():
                inner.add(key, _plain(item))
            table.add(name, inner)
        else:
            table.add(name, _plain(value))
    if not text.endswith("\n\n"):
        document.add(tomlkit.nl())
    document.add("calibration", table)
    return tomlkit.dumps(document)


def model_facts(finger: Finger) -> dict[str, Any]:
    """What [calibration] says of how far the finger's model is that of the skin, and of its forces."""
    facts: dict[str, Any] = {} if finger.trusted else {"accepted_misfit": True}
    if finger.relative:
        facts["relative_forces"] = True
    if finger.spread is not None:
        y, of = finger.spread.y, finger.spread
        ratios = {name: getattr(of, name).round(3).tolist() for name in ("straight", "leaning")}
        facts["spread"] = {"y": [format_quantity(float(v), "m") for v in y], **ratios}
    return facts


def with_table(text: str, name: str, values: Mapping[str, Any]) -> str:
    """`text` with the table `name` as `values` say; one that was there goes, the new one comes before [calibration]."""
    import tomlkit

    document = tomlkit.parse(text)
    document.pop(name, None)
    table = tomlkit.table()
    for key, value in values.items():
        table.add(key, value)
    last = document.pop("calibration", None)
    if not tomlkit.dumps(document).endswith("\n\n"):
        document.add(tomlkit.nl())
    document.add(name, table)
    if last is not None:
        document.add(tomlkit.nl())
        document.add("calibration", last)
    return tomlkit.dumps(document)


def _without_units(document: Any, unit: str, force: str) -> None:
    """Readings in `unit` as plain numbers: once there is a gain, the file does not say what they are in."""
    units = dict.fromkeys(IN_READINGS, unit) | {"lift": f"{unit or 1}/({force})", "drift": f"{unit or 1}/s"}
    for table in (document["sensors"], document.get("tare", {})):
        for key in units.keys() & table.keys():
            value = in_readings(table[key].unwrap(), units[key], key)
            table[key] = [rounded(v) for v in value] if isinstance(value, list) else rounded(value)


def _edit_skin(table: Any, old: Skin, new: Skin) -> None:
    """The numbers that differ; a skin of another kind, or with other layers, would be another file."""
    before, after = (numbers(skin) if is_written(skin) else {} for skin in (old, new))
    if type(old) is not type(new) or not after.keys() == before.keys() != set():
        seen, rule = f"a finger whose skin is {new}", f"the file describes {old}, of which only numbers can change"
        raise InvalidValueError(seen, rule, f"files know {', '.join(KINDS)}; start from a file with this kind of skin")
    for path, value in after.items():
        if value != before[path]:
            inner = table
            for part in path[:-1]:
                inner = inner[part]
            unit = {"young": "Pa", "poisson": ""}.get(str(path[-1]), "m")
            _set(inner, str(path[-1]), format_quantity(value, unit) if unit else rounded(value))


def _set(table: Any, name: str, value: Any) -> None:
    """Set a key; a new one goes below the last that has a value, not below the comments that end the table.

    It is text that trails the last value, so values are set after all keys that go.
    """
    import tomlkit

    if name in table:
        table[name] = value
        return
    keys = [key for key in table if not isinstance(table[key], dict | tomlkit.items.AoT)]
    if table.is_inline_table() or table.is_super_table() or not keys:
        table.add(name, value)
        return
    last = table.value.item(keys[-1]).trivia
    last.trail = f"{last.trail.rstrip()}\n" if not last.trail.endswith("\n") else last.trail
    last.trail += f"{last.indent}{name} = {tomlkit.item(value).as_string()}\n"


def _same(a: FloatArray, b: FloatArray) -> bool:
    return a.shape == b.shape and bool((np.abs(a - b) <= _SAME * np.maximum(np.abs(a), np.abs(b))).all())


def per_sensor(values: FloatArray, unit: str = "") -> Any:
    """One value where all sensors have the same, a list otherwise."""
    texts = [format_quantity(float(v), unit) if unit else rounded(float(v)) for v in values]
    return texts[0] if len(set(texts)) == 1 else texts


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return rounded(value)
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value
