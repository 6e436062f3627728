"""finger.toml as a whole: from its tables to what a `FingerFile` holds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..errors import InvalidValueError
from ..finger import Finger
from ..spread import Spread
from ._recording import build_drift, build_recording
from ._sensors import build_array
from ._skin import Misplaced, about, build_skin
from .units import format_quantity

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
    recording, told = document.recording, document.calibration
    skin, array = build_skin(document.skin), build_array(document)
    with about("calibration"):
        spread = None if told.spread is None else Spread(**told.spread.model_dump())
    with about("sensors"):
        finger = Finger(skin, array, spread, not told.accepted_misfit)
    names = tuple(f"s{i}" for i in range(len(array))) if recording is None else tuple(recording.sensors)
    if len(names) != len(array):
        seen = f"sensors names {len(names)} columns"
        rule = f"one for each of the {len(array)} sensors of [sensors] is needed"
        raise Misplaced(
            InvalidValueError(seen, rule, "one name for each sensor, in the order of the row"), "recording", "sensors"
        )
    given = document.locate
    options = {k: v for k in ("friction", "false_alarm", "ambiguity") if (v := getattr(given, k)) is not None}
    for key, value in options.items():
        if value < 0 or (key == "false_alarm" and not 0 < value <= 0.5):
            rule = "has to be >= 0" if key != "false_alarm" else "has to be in (0, 0.5]"
            raise Misplaced(InvalidValueError(f"{key} = {value:g}", rule, f"leave out {key}"), "locate", key)
    relaxation, length = None, document.touch.length
    if document.relaxation is not None:
        from ..stream.relaxation import Relaxation

        with about("relaxation"):
            relaxation = Relaxation(document.relaxation.share, document.relaxation.time)
    if length is not None and not length > 0:
        raise Misplaced(
            InvalidValueError(f"length = {length:g} m", "has to be > 0", 'length = "20 mm"'), "touch", "length"
        )
    return {
        "finger": finger,
        "names": names,
        "search": given.search,
        "load": given.load,
        "beside": given.beside,
        "options": options,
        "recording": build_recording(recording, length),
        "relaxation": relaxation,
        "drift": build_drift(document),
        "origin": told.origin,
        "limits": (array.low, array.high),
        "differences": told.differences,
        "length": length,
    }


def model_facts(finger: Finger) -> dict[str, Any]:
    """What [calibration] says of how far the finger's model is that of the skin; nothing where all is usual."""
    facts: dict[str, Any] = {} if finger.trusted else {"accepted_misfit": True}
    if finger.spread is not None:
        y, of = finger.spread.y, finger.spread
        ratios = {name: getattr(of, name).round(3).tolist() for name in ("straight", "leaning")}
        facts["spread"] = {"y": [format_quantity(float(v), "m") for v in y], **ratios}
    return facts
