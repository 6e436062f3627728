"""finger.toml as a whole: from its tables to what a `FingerFile` holds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _check
from ..errors import InvalidValueError, SubskinError
from ..finger import Finger
from ..spread import Spread
from ..stream.presses import Column, RecordingFormat
from ._live import live_of
from ._sensors import build_array, in_readings, reading_unit
from ._skin import Misplaced, build_skin, key_of
from .units import format_quantity, line_load_scale, si_unit, unit_scale

if TYPE_CHECKING:
    from . import _schema

__all__ = ["model_facts", "said"]


def said(document: _schema.FingerDocument) -> dict[str, Any]:
    """What the file says, by the names of the fields of `FingerFile`.

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
        at = "calibration"
        spread = None if told.spread is None else Spread(**told.spread.model_dump())
        at = "sensors"
        finger = Finger(skin, array, spread, not told.accepted_misfit)
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
        at = "touch"
        if length is not None and not length > 0:
            raise InvalidValueError(f"length = {length:g} m", "has to be > 0", 'length = "20 mm"')
        at = "relaxation"
        relaxation = None
        if document.relaxation is not None:
            from ..stream.relaxation import Relaxation

            relaxation = Relaxation(document.relaxation.share, document.relaxation.time)
        at = "recording"
        how = None if recording is None else _recording(recording, length)
        at = "live"
        live = None if document.live is None else live_of(document.live, count, 1.0 if how is None else how.scale)
        at = "tare"
        drift = document.tare.drift
        if drift is not None:
            drift = in_readings(drift, f"{reading_unit(recording) or 1}/s", "drift")
            drift = _check.real("drift", drift, at_least=0.0)
    except SubskinError as error:
        raise Misplaced(error, at, key_of(error)) from None
    return {
        "finger": finger,
        "names": names,
        "search": given.search,
        "load": given.load,
        "beside": given.beside,
        "options": options,
        "recording": how,
        "live": live,
        "relaxation": relaxation,
        "drift": drift,
        "origin": told.origin,
        "limits": (array.low, array.high),
        "differences": told.differences,
        "length": length,
    }


def _recording(table: _schema.RecordingTable, length: float | None) -> RecordingFormat:
    """The format that [recording] describes; forces in N are divided by the `length` of the contact [m]."""

    def column(key: str, unit: str) -> Column | None:
        entry = getattr(table, key)
        if entry is None:
            return None
        try:
            if key == "force":
                return Column(entry.column, 1.0 if entry.unit is None else line_load_scale(entry.unit, length))
            return Column(entry.column, 1.0 if entry.unit is None else unit_scale(entry.unit, unit, "unit"))
        except SubskinError as error:
            raise Misplaced(error, "recording", key, "unit") from None

    scale = 1.0 if table.unit is None else unit_scale(table.unit, si_unit(table.unit, "unit"), "unit")
    units = {"time": "s", "position": "m", "press": "m", "force": "N/m"}
    time, position, press, force = (column(key, unit) for key, unit in units.items())
    return RecordingFormat(
        sensors=tuple(table.sensors), scale=scale, time=time or Column("time"), position=position, press=press,
        force=force, early=table.early, before=table.before, hold=table.hold,
    )  # fmt: skip


def model_facts(finger: Finger) -> dict[str, Any]:
    """What [calibration] says of how far the finger's model is that of the skin; nothing where all is usual."""
    if finger.measured is not None:
        rule = "a finger file has no room for a response measured in place"
        fix = "pickle the finger, or dataclasses.replace(finger, measured=None)"
        raise InvalidValueError(f"measured = {finger.measured!r}", rule, fix)
    facts: dict[str, Any] = {} if finger.trusted else {"accepted_misfit": True}
    if finger.spread is not None:
        y, of = finger.spread.y, finger.spread
        ratios = {name: getattr(of, name).round(3).tolist() for name in ("straight", "leaning")}
        facts["spread"] = {"y": [format_quantity(float(v), "m") for v in y], **ratios}
    return facts
