"""[skin] and [sensors] of a finger.toml: from their tables to a skin and an array, and what files say of both."""

from __future__ import annotations

import difflib
from dataclasses import MISSING, fields
from functools import lru_cache
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import StrictBool, StrictInt, StrictStr

from .._check import FloatArray
from ..array import SensorArray
from ..errors import GeometryError, InvalidValueError
from ..finger import LARGEST
from ..lattice import even_grid, even_row
from ..material import Material
from ..skin import KINDS, Layer, Ridged, Skin
from ..transducer import Transducer, VolumeResistance, class_of, kind_of, transducer_of
from ._tables import LONGEST, RIDGE, Count, Doubt, FingerTable, Given, Length, Lengths, Number, Pressure, StrictTable
from .toml_errors import Misplaced, short, under
from .units import quantity, si_unit

__all__ = [
    "IN_READINGS",
    "SensorsTable",
    "SkinTable",
    "build_array",
    "build_skin",
    "in_readings",
    "is_written",
    "numbers",
    "reading_unit",
    "said_of",
    "transducer_said",
    "unit_of_readings",
]

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
    """[skin]: what is pressed. Which keys are needed depends on the kind (see `build_skin`)."""

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


@lru_cache(maxsize=64)
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


IN_READINGS = ("offset", "lift", "noise", "low", "high", "resolution")


class SensorsTable(FingerTable):
    """[sensors]: where they are and how each turns what it measures into a reading."""

    layout: Literal["row", "grid", "hexagonal"] = "row"
    count: Annotated[StrictInt | None, Count] = None
    shape: list[StrictInt] | None = None
    pitch: Lengths | None = None
    centre: Lengths = 0.0
    y: Lengths | None = None
    z: Lengths = 0.0
    depth: Lengths
    sensor: StrictStr | None = None
    kind: Any = "normal_strain"
    channels: Any = None
    exact: StrictBool = False
    width: Lengths = 0.0
    gain: Given = 1.0
    offset: Given = 0.0
    lift: Given = 0.0
    noise: Given = 0.0
    low: Given = None
    high: Given = None
    resolution: Given = 0.0

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        array = build_array(file)
        if file.calibration.differences:
            array.refuse_offset()
        columns = tuple([f"s{i}" for i in range(len(array))])
        return {"array": array, "names": columns, "limits": (array.low, array.high)}


def build_array(document: Any) -> SensorArray:
    """The array that [sensors] describes.

    Raises
    ------
    SubskinError
        A key that is missing, a value out of range, lists that do not match.
    """
    table = document.sensors
    points = _points(table)
    preset = {} if table.sensor is None else SensorArray.preset(table.sensor)
    usual = preset.pop("transducer", None)
    own = usual is None or {"kind", "channels"} & table.model_fields_set
    kinds, channels = _transducers(table, len(points)) if own else (usual, None)
    parameters = preset | _parameters(
        document, channels or (kinds if isinstance(kinds, tuple) else (kinds,)), area=bool(points[:, 1].any())
    )
    return SensorArray.at(points, table.depth, kinds, channels, width=table.width, **parameters)


def _points(table: SensorsTable) -> FloatArray:
    """Positions (y, z) of the sensors, or of their channels [m], shape (n, 2)."""
    even, own = {"count", "shape", "pitch", "centre", "layout"}, {"y", "z"}
    said = table.model_fields_set
    if table.y is not None:
        for key in sorted(even & said):
            fix = f"leave out y or {key}"
            raise InvalidValueError(f"{key} beside y", "y already says where the sensors are", fix)
        y, z = np.atleast_1d(table.y), np.atleast_1d(table.z)
        if z.shape not in ((1,), y.shape):
            rule = f"one value, or one for each of the {y.size} positions y, is needed"
            raise GeometryError(f"z lists {z.size} positions", rule, 'z = "0 mm"')
        return np.stack(np.broadcast_arrays(y, z), axis=-1)
    row = table.layout == "row"
    for key in sorted((own | {"shape" if row else "count"}) & said):
        fix = {"z": "give y and z of each sensor", "shape": 'layout = "grid"', "count": "shape = [4, 4]"}[key]
        raise InvalidValueError(f'{key} beside layout = "{table.layout}"', f"a {table.layout} has no {key}", fix)
    if (table.count if row else table.shape) is None or table.pitch is None:
        if row:
            fix = 'give count = 4 and pitch = "6 mm", or y = ["-3 mm", "3 mm"]'
            raise InvalidValueError("y, or count and pitch, is missing", "the sensors need a position", fix)
        seen = f'layout = "{table.layout}" without {"pitch" if table.shape else "shape"}'
        raise InvalidValueError(seen, "the sensors need a position", 'give shape = [4, 4] and pitch = "3 mm"')
    if row:
        y = even_row(table.count, table.pitch, table.centre)  # type: ignore[arg-type]
        return np.stack([y, np.zeros_like(y)], axis=-1)
    middle = table.centre if "centre" in said else (0.0, 0.0)
    return even_grid(table.shape, table.pitch, middle, table.layout)  # type: ignore[arg-type]


def _transducers(
    table: SensorsTable, count: int
) -> tuple[Transducer | tuple[Transducer, ...] | None, tuple[Transducer, ...] | None]:
    """What is measured: by each sensor, or by each of the channels at a position; one of the two is None."""
    if table.channels is not None:
        if "kind" in table.model_fields_set:
            raise InvalidValueError("kind beside channels", "each says what is measured", "leave out kind or channels")
        if not isinstance(table.channels, list) or not table.channels:
            fix = 'channels = ["normal_strain", "mean_pressure"]'
            raise InvalidValueError(f"channels = {short(table.channels)}", "a list of kinds of sensors is needed", fix)
        return None, tuple(transducer_said(item, table.exact, "channels") for item in table.channels)
    if not isinstance(table.kind, list):
        return transducer_said(table.kind, table.exact, "kind"), None
    if len(table.kind) != count:
        rule = f"one kind, or one for each of the {count} sensors, is needed"
        raise InvalidValueError(f"kind lists {len(table.kind)}", rule, 'kind = "normal_strain"')
    return tuple(transducer_said(item, table.exact, "kind") for item in table.kind), None


def transducer_said(said: object, exact: bool, key: str) -> Transducer:
    """A transducer by its name, or by a table of its name and its arguments, which may have units."""
    if isinstance(said, dict) and isinstance(said.get("name"), str):
        with under("sensors", of=key):
            return _with_arguments(said["name"], {k: v for k, v in said.items() if k != "name"})
    if not isinstance(said, str):
        rule = "the name of a kind of sensor is needed"
        one, other = '"normal_strain"', '{name = "displacement", axis = "x"}'
        fix = f"kind = {one}, or {other}" if key == "kind" else f"channels = [{one}, {other}]"
        raise InvalidValueError(f"{key} = {short(said)}", rule, fix)
    return VolumeResistance(exact=exact) if said == "volume_resistance" else transducer_of(said)


def said_of(transducer: Transducer) -> str | dict[str, object]:
    """What a file says of a transducer: its name, or a table of that and of the arguments that are not as usual."""
    own = {f.name: getattr(transducer, f.name) for f in fields(transducer)}
    usual = {f.name: f.default for f in fields(transducer)}
    told = {key: value for key, value in own.items() if usual[key] is MISSING or value != usual[key]}
    return {"name": kind_of(transducer), **told} if told else kind_of(transducer)


def _with_arguments(name: str, given: dict[str, Any]) -> Transducer:
    known = {f.name: f.metadata.get("unit") for f in fields(class_of(name))}
    for argument in given:
        if known and argument not in known:
            rule = f"{name} has no such argument"
            raise InvalidValueError(f'argument "{argument}"', rule, f"known: {', '.join(known)}")
    units = {argument: known.get(argument) for argument in given}
    values = {k: v if units[k] is None else quantity(v, str(units[k]), k) for k, v in given.items()}
    return transducer_of(name, **values)


def _parameters(document: Any, transducers: tuple[Transducer, ...], *, area: bool) -> dict[str, Any]:
    """Of gain, offset, lift, noise, range and resolution those given: plain numbers, or in a unit of readings."""
    table, unit, felt = document.sensors, unit_of_readings(document, transducers), {t.unit for t in transducers}
    per = felt.pop() if len(felt) == 1 else unit
    units = {"gain": "" if unit == per else f"{unit or 1}/({per})" if per else unit}
    units["lift"] = f"{unit or 1}/({'N' if area else 'N/m'})"
    given = [key for key in ("gain", *IN_READINGS) if key in table.model_fields_set]
    try:
        return {key: in_readings(getattr(table, key), units.get(key, unit), key) for key in given}
    except InvalidValueError as error:
        if unit or not per or not error.rule.endswith("is needed"):
            raise
        fix = 'unit = "mV" under [recording] says in what the sensors are read; or a plain number'
        raise InvalidValueError(error.seen, "with a gain, the unit of the readings has to be known", fix) from None


def unit_of_readings(document: Any, transducers: tuple[Transducer, ...]) -> str:
    """SI unit of the readings: that of [recording]; without one, and without a gain, what the sensors feel is read."""
    felt = {t.unit for t in transducers}
    usual = felt.pop() if len(felt) == 1 and "gain" not in document.sensors.model_fields_set else ""
    return reading_unit(document.recording) or usual


def reading_unit(recording: Any) -> str | None:
    """SI unit of the readings; None where the file does not give one."""
    return None if recording is None or recording.unit is None else si_unit(recording.unit, "unit")


def in_readings(value: Any, unit: str, name: str) -> Any:
    """A quantity, or a list of them; low and high may be infinite, as they are where they are not given."""
    if isinstance(value, list):
        return [in_readings(item, unit, f"{name}[{i}]") for i, item in enumerate(value)]
    infinite = name.startswith(("low", "high")) and isinstance(value, float) and abs(value) == np.inf
    return value if value is None or infinite else quantity(value, unit, name)
