"""finger.toml as a whole: from its tables to what a `FingerFile` holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _check
from ..errors import InvalidValueError, SubskinError
from ..finger import Finger
from ..spread import Spread
from ..stream.presses import Column, RecordingFormat
from ._live import live_of
from ._sensors import build_array, in_readings, reading_unit, unit_of_readings
from ._sizes import doubt_sizes
from ._skin import Misplaced, build_skin, key_of
from .units import format_quantity, line_load, line_load_scale, quantity, si_unit, unit_scale

if TYPE_CHECKING:
    from ..array import SensorArray
    from ..stream.relaxation import Relaxation
    from . import _schema

__all__ = ["check_held", "model_facts", "said"]


def said(document: _schema.FingerDocument, name: str) -> dict[str, Any]:
    """What the file `name` says, by the names of the fields of `FingerFile`.

    Raises
    ------
    Misplaced
        A value out of range, or one that does not go with another.
    """
    recording, told, given, length = document.recording, document.calibration, document.locate, document.touch.length
    at = "skin"
    try:
        skin = build_skin(document.skin)
        at = "sensors"
        array = build_array(document)
        if told.differences:
            array.refuse_offset()
        at = "calibration"
        origin = _origin(told, array.on_area)
        spread = None if told.spread is None else Spread(**told.spread.model_dump())
        at = "sensors"
        finger = Finger(skin, array, spread, not told.accepted_misfit, relative=told.relative_forces)
        at = "recording"
        count = np.size(array.y)
        names = tuple(f"s{i}" for i in range(count)) if recording is None else tuple(recording.sensors)
        if len(names) != count:
            rule = f"one for each of the {count} sensors of [sensors] is needed"
            fix = "one name for each sensor, in the order of the row"
            raise InvalidValueError(f"sensors names {len(names)} columns", rule, fix)
        at = "locate"
        options = {k: v for k in ("friction", "false_alarm", "ambiguity") if (v := getattr(given, k)) is not None}
        for key, value in options.items():
            if value < 0 or (key == "false_alarm" and not 0 < value <= 0.5):
                rule = "has to be >= 0" if key != "false_alarm" else "has to be in (0, 0.5]"
                raise InvalidValueError(f"{key} = {value:g}", rule, f"leave out {key}")
        force = _forces(given.normal_force, array.on_area, length, told.relative_forces)
        at = "touch"
        if length is not None and not length > 0:
            raise InvalidValueError(f"length = {length:g} m", "has to be > 0", 'length = "20 mm"')
        at = "tip"
        tip = document.tip
        if tip is not None and not tip.radius > 0:
            raise InvalidValueError(f"radius = {tip.radius:g} m", "has to be > 0", 'radius = "9 mm"')
        at = "relaxation"
        relaxation = None
        if document.relaxation is not None:
            from ..stream.relaxation import Relaxation

            held = document.relaxation
            relaxation = Relaxation(held.share, held.time, doubt=held.doubt)
            check_held(relaxation, array)
        at = "recording"
        how = None if recording is None else _recording(recording, length, array.on_area)
        at = "live"
        si, given_live = reading_unit(recording), document.live
        live = None if given_live is None else live_of(given_live, count, how, si, Path(name).parent)
        at = "tare"
        drift, stirring = document.tare.drift, document.tare.noise
        if drift is not None:
            drift = in_readings(drift, f"{unit_of_readings(document, array.transducers) or 1}/s", "drift")
            drift = _check.real("drift", drift, at_least=0.0)
        if stirring is not None:
            stirring = in_readings(stirring, unit_of_readings(document, array.transducers), "noise")
            stirring = _check.real("noise", stirring, above=0.0)
    except SubskinError as error:
        raise Misplaced(error, at, key_of(error)) from None
    doubt_sizes(document, finger)
    return {
        "finger": finger,
        "names": names,
        "search": given.search,
        "load": given.load,
        "beside": given.beside,
        "options": options,
        "normal_force": force,
        "recording": how,
        "live": live,
        "relaxation": relaxation,
        "drift": drift,
        "stirring": stirring,
        "origin": origin,
        "turn": told.turn,
        "limits": (array.low, array.high),
        "differences": told.differences,
        "length": length,
        "tip": None if tip is None else (tip.radius, tip.shape),
    }


def check_held(relaxation: Relaxation, array: SensorArray) -> None:
    """Raise where a relaxation does not go with the sensors.

    Raises
    ------
    GeometryError, InvalidValueError
        Shares of another number of sensors; a doubt of sensors on an area.
    """
    relaxation.of_sensors(len(array))
    if array.on_area and np.any(relaxation.doubt):
        rule = "only the search on a row weighs each frame by noise of its own"
        raise InvalidValueError("doubt of sensors on an area", rule, "leave out doubt")


def _origin(told: _schema.CalibrationTable, on_area: bool) -> Any:
    """Where the finger's zero lies: y, or on an area (y, z) [m]."""
    if told.origin is None:
        return np.zeros(2) if on_area else 0.0
    if np.shape(told.origin) != (2,) * on_area:
        rule, fix = ("y and z are needed", '["5 mm", "5 mm"]') if on_area else ("one position is needed", '"5 mm"')
        raise InvalidValueError(f"origin of shape {np.shape(told.origin)}", rule, f"origin = {fix}")
    if told.turn and not on_area:
        raise InvalidValueError(f"turn = {told.turn:g} rad", "a row of sensors knows no turn", "leave it out")
    return np.array(told.origin) if on_area else told.origin


def _forces(given: Any, on_area: bool, length: float | None, relative: bool) -> tuple[float, float] | None:
    """Ends of the normal force [N/m], on an area [N]; plain numbers where forces are `relative`."""
    if given is None:
        return None
    unit = "N" if on_area else "N/m"
    if relative and isinstance(given, list) and any(isinstance(v, str) for v in given):
        rule = "forces of this finger are multiples of the load of the touches it was calibrated on, and no newtons"
        raise InvalidValueError(f"normal_force = {given!r}", rule, "normal_force = [0.1, 2.0], or leave it out")
    if not isinstance(given, list) or len(given) != 2:
        fix = f'normal_force = ["1 {unit}", "2 {unit}"]'
        raise InvalidValueError(f"normal_force = {given!r}", "the least and the largest are needed", fix)
    low, high = (quantity(v, "N", "normal_force") if on_area else line_load(v, length, "normal_force") for v in given)
    if not 0 <= low <= high:
        rule = "the first has to be >= 0 and <= the second"
        raise InvalidValueError(f"normal_force = {given!r}", rule, f'normal_force = ["1 {unit}", "2 {unit}"]')
    return low, high


def _recording(table: _schema.RecordingTable, length: float | None, on_area: bool) -> RecordingFormat:
    """The format that [recording] describes; forces in N are divided by the `length` of the contact [m]."""
    count = 0 if table.position is None else len(table.position)
    if count and count != 1 + on_area:
        rule = "sensors on an area need two columns, y and z" if on_area else "a row needs one column"
        each = '{column = "y", unit = "mm"}'
        fix = f"position = [{each}, {each.replace('y', 'z')}]" if on_area else f"position = {each}"
        raise Misplaced(InvalidValueError(f"position of {count} columns", rule, fix), "recording", "position")

    def column(key: str, unit: str, entry: Any) -> Column | None:
        if entry is None:
            return None
        try:
            if key == "force" and not on_area and length is not None and entry.unit is None:
                fix = f'force = {{ column = "{entry.column}", unit = "N" }}'
                raise InvalidValueError("no unit beside [touch] length", "it may be in N or in N/m", fix)
            if key == "force" and not on_area:
                return Column(entry.column, 1.0 if entry.unit is None else line_load_scale(entry.unit, length))
            return Column(entry.column, 1.0 if entry.unit is None else unit_scale(entry.unit, unit, "unit"))
        except SubskinError as error:
            raise Misplaced(error, "recording", key, "unit") from None

    scale = 1.0 if table.unit is None else unit_scale(table.unit, si_unit(table.unit, "unit"), "unit")
    units = {"time": "s", "press": "m", "force": "N"}
    time, press, force = (column(key, unit, getattr(table, key)) for key, unit in units.items())
    where: Any = tuple(column("position", "m", entry) for entry in table.position or ())
    return RecordingFormat(
        sensors=tuple(table.sensors), scale=scale, time=time or Column("time"), press=press, force=force,
        position=(where if on_area else where[0]) if where else None,
        early=table.early, before=table.before, hold=table.hold,
    )  # fmt: skip


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
