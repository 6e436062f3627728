"""[sensors] of a finger.toml: from its table to an array."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..array import SensorArray, even_row
from ..errors import InvalidValueError
from ..transducer import Transducer, VolumeResistance, transducer_of
from ._toml_errors import short
from .units import quantity, si_unit

if TYPE_CHECKING:
    from . import _schema

__all__ = ["build_array", "in_readings", "reading_unit"]

_IN_READINGS = ("offset", "noise", "low", "high", "resolution")


def build_array(document: _schema.FingerDocument) -> SensorArray:
    """The array that [sensors] describes.

    Raises
    ------
    SubskinError
        A key that is missing, a value out of range, lists that do not match.
    """
    table = document.sensors
    positions = _positions(table)
    preset = {} if table.sensor is None else SensorArray.preset(table.sensor)
    usual = preset.pop("transducer", None)
    own = usual is None or "kind" in table.model_fields_set
    transducers = _transducers(table.kind, table.exact, len(positions)) if own else usual
    parameters = preset | _parameters(document, transducers)
    return SensorArray(y=positions, depth=table.depth, width=table.width, transducer=transducers, **parameters)


def _positions(table: _schema.SensorsTable) -> list[float]:
    """Positions of the sensors along the row [m]."""
    if table.y is not None:
        for key in ("count", "pitch", "centre"):
            if key in table.model_fields_set:
                fix = f"leave out y or {key}"
                raise InvalidValueError(f"{key} beside y", "y already says where the sensors are", fix)
        return table.y if isinstance(table.y, list) else [table.y]
    if table.count is None or table.pitch is None:
        fix = 'give count = 4 and pitch = "6 mm", or y = ["-3 mm", "3 mm"]'
        raise InvalidValueError("y, or count and pitch, is missing", "the sensors need a position", fix)
    return [float(y) for y in even_row(table.count, table.pitch, table.centre)]


def _transducers(kind: object, exact: bool, count: int) -> Transducer | tuple[Transducer, ...]:
    def one(name: object) -> Transducer:
        if not isinstance(name, str):
            rule = "the name of a kind of sensor is needed"
            raise InvalidValueError(f"kind = {short(name)}", rule, 'kind = "normal_strain"')
        return VolumeResistance(exact=exact) if name == "volume_resistance" else transducer_of(name)

    if isinstance(kind, list):
        if len(kind) != count:
            seen, rule = (f"kind lists {len(kind)}", f"one kind, or one for each of the {count} sensors, is needed")
            raise InvalidValueError(seen, rule, 'kind = "normal_strain"')
        return tuple(one(name) for name in kind)
    return one(kind)


def _parameters(document: _schema.FingerDocument, transducers: Transducer | tuple[Transducer, ...]) -> dict[str, Any]:
    """Those of gain, offset, noise, range and resolution that are given: plain numbers, or in a unit of readings."""
    table, unit = document.sensors, reading_unit(document.recording) or ""
    measured = {t.unit for t in (transducers if isinstance(transducers, tuple) else (transducers,))}
    per = measured.pop() if len(measured) == 1 else unit
    units = {"gain": "" if unit == per else f"{unit or 1}/({per})" if per else unit}
    given = [key for key in ("gain", *_IN_READINGS) if key in table.model_fields_set]
    return {key: in_readings(getattr(table, key), units.get(key, unit), key) for key in given}


def reading_unit(recording: _schema.RecordingTable | None) -> str | None:
    """SI unit of the readings; None where the file does not give one."""
    return None if recording is None or recording.unit is None else si_unit(recording.unit, "unit")


def in_readings(value: Any, unit: str, name: str) -> Any:
    """A quantity, or a list of them; low and high may be infinite, as they are where they are not given."""
    if isinstance(value, list):
        return [in_readings(item, unit, f"{name}[{i}]") for i, item in enumerate(value)]
    infinite = name.startswith(("low", "high")) and isinstance(value, float) and abs(value) == np.inf
    return value if value is None or infinite else quantity(value, unit, name)
