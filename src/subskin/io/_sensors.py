"""[sensors] of a finger.toml: from its table to an array."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import StrictBool, StrictInt, StrictStr

from .._check import FloatArray
from ..array import SensorArray
from ..errors import GeometryError, InvalidValueError
from ..lattice import even_grid, even_row
from ..transducer import Transducer, VolumeResistance, class_of, kind_of, transducer_of
from ._tables import Count, FingerTable, Given, Lengths
from ._toml_errors import short, under
from .units import quantity, si_unit

__all__ = [
    "IN_READINGS",
    "SensorsTable",
    "build_array",
    "in_readings",
    "reading_unit",
    "said_of",
    "transducer_said",
    "unit_of_readings",
]

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
        columns = tuple(f"s{i}" for i in range(len(array)))
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
