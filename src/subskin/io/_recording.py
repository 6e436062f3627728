"""[recording] and [tare] of a finger.toml: how a raw recording is read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy.typing as npt

from .. import _check
from ..errors import SubskinError
from ..stream.presses import Column, RecordingFormat
from ._sensors import in_readings
from ._skin import Misplaced, about
from .units import line_load_scale, si_unit, unit_scale

if TYPE_CHECKING:
    from . import _schema

__all__ = ["build_drift", "build_recording"]


def build_recording(table: _schema.RecordingTable | None, length: float | None) -> RecordingFormat | None:
    """The format that [recording] describes; forces in N are divided by the `length` of the contact [m].

    Raises
    ------
    Misplaced
        A unit of the wrong kind, a force in N over a contact of unknown length, a value out of range.
    """
    if table is None:
        return None

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
    with about("recording"):
        return RecordingFormat(
            sensors=tuple(table.sensors), scale=scale, time=time or Column("time"), position=position, press=press,
            force=force, early=table.early, before=table.before, hold=table.hold,
        )  # fmt: skip


def build_drift(document: _schema.FingerDocument) -> npt.ArrayLike | None:
    """The fastest drift of [tare] [reading/s].

    Raises
    ------
    Misplaced
        A drift below 0, or in another unit.
    """
    from ._schema import reading_unit

    with about("tare"):
        drift = in_readings(document.tare.drift, f"{reading_unit(document.recording) or 1}/s", "drift")
        return None if drift is None else _check.real("drift", drift, at_least=0.0)
