"""The tables of `finger.toml`: structure, names, units and bounds, and what each means to a `FingerFile`.

A new table is a class here, a key of `FingerDocument`, and a field of `FingerFile` where it tells one.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, StrictBool, StrictInt, StrictStr

from .. import _check
from ..errors import InvalidValueError, SubskinError
from ..finger import DEEPEST, SOFTEST, Finger
from ..spread import Spread
from ..stream.presses import Column, RecordingFormat
from ..stream.relaxation import Relaxation
from ..tolerances import Tolerances
from ._parts import SensorsTable, SkinTable, in_readings, reading_unit, unit_of_readings
from ._recorded import LiveFormat, check_held
from ._tables import (
    LONGEST,
    Above0,
    Angle,
    At,
    Columns,
    Doubt,
    FingerTable,
    Given,
    Length,
    Names,
    Number,
    Numbers,
    Search,
    StrictTable,
    Time,
    UnitText,
    doubt_sizes,
    one,
)
from .toml_errors import Misplaced, key_of, under
from .units import line_load, line_load_scale, quantity, si_unit, unit_scale

__all__ = ["FingerDocument"]

_Share = Annotated[float, one("", at_least=0.0)]
_Contact = Annotated[float, one("m", above=0.0, fix='length = "20 mm"')]


class LocateTable(FingerTable):
    """[locate]: options of `Finger.locate`."""

    friction: _Share | None = None
    search: Search = None
    load: Literal["line", "point", "either"] | None = None
    beside: Length | None = None
    normal_force: Any = None
    false_alarm: Annotated[float, one("", above=0.0, at_most=0.5, fix="leave out false_alarm")] | None = None
    ambiguity: _Share | None = None

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        chosen = {name: getattr(self, name) for name in ("friction", "false_alarm", "ambiguity")}
        options = {name: value for name, value in chosen.items() if value is not None}
        force = None if self.normal_force is None else self._forces(file, made["array"].on_area)
        return {
            "options": options, "normal_force": force, "search": self.search, "load": self.load, "beside": self.beside,
        }  # fmt: skip

    def _forces(self, file: Any, on_area: bool) -> tuple[float, float]:
        """Ends of the normal force [N/m], on an area [N]; plain numbers where forces are relative."""
        given, length = self.normal_force, file.touch.length
        unit, name = "N" if on_area else "N/m", "normal_force"
        several = isinstance(given, list)
        if file.calibration.relative_forces and several and any(isinstance(v, str) for v in given):
            rule = "forces of this finger are multiples of the load of the touches it was calibrated on, and no newtons"
            raise InvalidValueError(f"{name} = {given!r}", rule, "normal_force = [0.1, 2.0], or leave it out")
        fix = f'normal_force = ["1 {unit}", "2 {unit}"]'
        if not several or len(given) != 2:
            raise InvalidValueError(f"{name} = {given!r}", "the least and the largest are needed", fix)
        low, high = (quantity(v, "N", name) if on_area else line_load(v, length, name) for v in given)
        if not 0 <= low <= high:
            raise InvalidValueError(f"{name} = {given!r}", "the first has to be >= 0 and <= the second", fix)
        return low, high


class ColumnTable(StrictTable):
    """A column of a recording and what one count of it is worth."""

    column: StrictStr = Field(min_length=1)
    unit: UnitText | None = None

    def scaled(self, key: str, unit: str) -> Column:
        """The column and its scale; `unit` is that of `key`, whose column it is."""
        with under("recording", key, of="unit"):
            return Column(self.column, 1.0 if self.unit is None else unit_scale(self.unit, unit, "unit"))

    def of_force(self, length: float | None, on_area: bool) -> Column:
        """The column of forces [N/m], on an area [N]; those in N are divided by the `length` of a long contact [m]."""
        if on_area:
            return self.scaled("force", "N")
        with under("recording", "force", of="unit"):
            if length is not None and self.unit is None:
                fix = f'force = {{ column = "{self.column}", unit = "N" }}'
                raise InvalidValueError("no unit beside [touch] length", "it may be in N or in N/m", fix)
            return Column(self.column, 1.0 if self.unit is None else line_load_scale(self.unit, length))


class RecordingTable(FingerTable):
    """[recording]: how to read a raw recording."""

    sensors: Names
    unit: UnitText | None = None
    time: ColumnTable | None = None
    position: Annotated[list[ColumnTable] | None, Columns] = None
    press: ColumnTable | None = None
    force: ColumnTable | None = None
    early: Number = 0.4
    before: Time = 0.3
    hold: Time = 0.5

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        count, on_area = len(made["array"]), made["array"].on_area
        if len(self.sensors) != count:
            rule = f"one for each of the {count} sensors of [sensors] is needed"
            fix = "one name for each sensor, in the order of the row"
            raise InvalidValueError(f"sensors names {len(self.sensors)} columns", rule, fix)
        along = 0 if self.position is None else len(self.position)
        if along and along != 1 + on_area:
            rule = "sensors on an area need two columns, y and z" if on_area else "a row needs one column"
            each = '{column = "y", unit = "mm"}'
            fix = f"position = [{each}, {each.replace('y', 'z')}]" if on_area else f"position = {each}"
            raise InvalidValueError(f"position of {along} columns", rule, fix)
        scale = 1.0 if self.unit is None else unit_scale(self.unit, si_unit(self.unit, "unit"), "unit")
        columns: dict[str, Any] = {
            "time": Column("time") if self.time is None else self.time.scaled("time", "s"),
            "press": None if self.press is None else self.press.scaled("press", "m"),
            "force": None if self.force is None else self.force.of_force(file.touch.length, on_area),
        }
        where: Any = tuple(column.scaled("position", "m") for column in self.position or ())
        columns["position"] = (where if on_area else where[0]) if where else None
        more: dict[str, Any] = {key: getattr(self, key) for key in ("early", "before", "hold")}
        how = RecordingFormat(sensors=tuple(self.sensors), scale=scale, **columns, **more)
        return {"names": tuple(self.sensors), "recording": how}


class LiveTable(FingerTable):
    """[live]: the board that the sensors are read by."""

    port: StrictStr | None = None
    driver: StrictStr | dict[str, Any] | None = None
    channels: Names | None = None
    unit: UnitText | list[UnitText] | None = None

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        count, how, si = len(made["array"]), made.get("recording"), reading_unit(file.recording)
        driver = {"name": self.driver} if isinstance(self.driver, str) else dict(self.driver or {})
        if driver and not (isinstance(driver.get("name"), str) and driver["name"]):
            fix = 'driver = {name = "lines", sensors = 4}'
            raise InvalidValueError("driver without a name", "a name is needed", fix)
        if driver and driver["name"].endswith(".toml"):
            driver["name"] = str(made["folder"] / driver["name"])
        for key, given in (("channels", self.channels), ("unit", self.unit if isinstance(self.unit, list) else None)):
            if given is not None and len(given) != count:
                rule = f"one for each of the {count} sensors of [sensors] is needed"
                fix = "one for each sensor, in the order of the row"
                raise InvalidValueError(f"{key} lists {len(given)}", rule, fix)
        units = self.unit if isinstance(self.unit, list) else [] if self.unit is None else count * [self.unit]
        worth = [unit_scale(unit, si_unit(unit, "unit") if si is None else si, "unit") for unit in units]
        scales = _check.read_only(worth or count * [1.0 if how is None else how.scale])
        return {"live": LiveFormat(self.port or "", driver, tuple(self.channels or ()), scales)}


class RelaxationTable(FingerTable):
    """[relaxation]: what touches that are held lose, and how fast, as `fit_relaxation` finds it."""

    share: list[Number | list[Number]]
    time: list[Time]
    doubt: Number | list[Number] = 0.0

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        held = Relaxation(self.share, self.time, doubt=self.doubt)
        check_held(held, made["array"])
        return {"relaxation": held}


class TareTable(FingerTable):
    """[tare]: how drift is taken off."""

    drift: Given = None
    noise: Given = None

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        unit = unit_of_readings(file, made["array"].transducers)
        drift, noise = in_readings(self.drift, f"{unit or 1}/s", "drift"), in_readings(self.noise, unit, "noise")
        return {
            "drift": None if drift is None else _check.real("drift", drift, at_least=0.0),
            "stirring": None if noise is None else _check.real("noise", noise, above=0.0),
        }


class ContactTable(FingerTable):
    """[touch] of a finger.toml: what is known of the contacts."""

    length: Annotated[_Contact | None, Doubt(LONGEST, "length of [touch]")] = None

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        return {"length": self.length}


class SpreadTable(StrictTable):
    """[calibration.spread]: how far positions are off along the row, over what independent noise would make of them."""

    y: Annotated[list[Length], Field(min_length=1)]
    straight: list[Above0]
    leaning: list[Above0]


class TipTable(FingerTable):
    """[tip]: what flat layers are bent to."""

    radius: Annotated[float, one("m", above=0.0, fix='radius = "9 mm"'), Doubt(LONGEST, "radius of [tip]")]
    shape: Literal["cylinder", "sphere"] | None = None

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        return {"tip": (self.radius, self.shape)}


class TolerancesTable(FingerTable):
    """[tolerances]: how far the finger may be from what the file says, as `Tolerances`."""

    gain: Numbers = 0.0
    depth: Numbers = 0.0
    position: Numbers = 0.0
    poisson: Number = 0.0
    offset: Given = 0.0
    noise: Number = 1.0
    common: Number = 0.25

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        offset = in_readings(self.offset, unit_of_readings(file, made["array"].transducers), "offset")
        found = Tolerances(**{**self.model_dump(), "offset": offset})
        for name in ("gain", "depth", "position", "offset"):
            found.of(name, len(made["array"]))
        return {"tolerances": found}


class CalibrationTable(FingerTable):
    """[calibration]: what `calibrate` wrote."""

    origin: At = None
    turn: Angle = 0.0
    response: Annotated[str, Field(pattern="^[0-9a-f]{64}$")] | None = None
    differences: StrictBool = False
    source: StrictStr = ""
    fit: list[StrictStr] = Field(default_factory=list)
    touches: StrictInt = 0
    load: Literal["line", "point"] | None = None
    blind: StrictBool = False
    misfit: Number | None = None
    spread: SpreadTable | None = None
    accepted_misfit: StrictBool = False
    relative_forces: StrictBool = False
    r2: Number | None = None
    r2_held_out: Number | None = None
    dead: list[StrictStr] = Field(default_factory=list)
    weak: list[StrictStr] = Field(default_factory=list)
    std: dict[str, Any] = Field(default_factory=dict)

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        origin = self._origin(made["array"].on_area)
        spread = None if self.spread is None else Spread(**self.spread.model_dump())
        trusted = not self.accepted_misfit
        with under("sensors"):
            finger = Finger(
                made["skin"], made["array"], spread, trusted, relative=self.relative_forces,
                tolerances=made.get("tolerances"),
            )  # fmt: skip
        told = {"turn": self.turn, "differences": self.differences, "response": self.response}
        return {"finger": finger, "origin": origin, **told}

    def _origin(self, on_area: bool) -> Any:
        """Where the finger's zero lies: y, or on an area (y, z) [m]."""
        if self.origin is None:
            return np.zeros(2) if on_area else 0.0
        if np.shape(self.origin) != (2,) * on_area:
            rule, fix = ("y and z are needed", '["5 mm", "5 mm"]') if on_area else ("one position is needed", '"5 mm"')
            raise InvalidValueError(f"origin of shape {np.shape(self.origin)}", rule, f"origin = {fix}")
        if self.turn and not on_area:
            raise InvalidValueError(f"turn = {self.turn:g} rad", "a row of sensors knows no turn", "leave it out")
        return np.array(self.origin) if on_area else self.origin


class OrientedTable(FingerTable):
    """[oriented]: when `subskin orient` found the sensors to be connected as the file says, by so many presses."""

    date: StrictStr
    presses: StrictInt

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        return {"oriented": self.date}


class FingerDocument(StrictTable):
    """The whole file; a table tells what it means after those above it."""

    skin: SkinTable
    sensors: SensorsTable
    tolerances: TolerancesTable | None = None
    calibration: CalibrationTable = CalibrationTable()
    recording: RecordingTable | None = None
    locate: LocateTable = LocateTable()
    touch: ContactTable = ContactTable()
    tip: TipTable | None = None
    relaxation: RelaxationTable | None = None
    live: LiveTable | None = None
    tare: TareTable = TareTable()
    oriented: OrientedTable | None = None

    def told(self, folder: Path) -> dict[str, Any]:
        """What the file says, by the names of the fields of `FingerFile`; other files are looked for in `folder`.

        Raises
        ------
        Misplaced
            A value out of range, or one that does not go with another.
        """
        made: dict[str, Any] = {"folder": folder}
        for name in type(self).model_fields:
            table: FingerTable | None = getattr(self, name)
            try:
                made |= {} if table is None else table.told(self, made)
            except SubskinError as error:
                raise Misplaced(error, name, key_of(error)) from None
        young = min(material.young for material in made["skin"].materials)
        deepest = float(np.asarray(made["array"].depth).max())
        if young >= SOFTEST:
            doubt_sizes(self)
        elif young != 1.0 and deepest >= DEEPEST:  # a finger in units of its own, in Python; in a file both forgotten
            _check.doubt("young", young, "Pa", 1e6, "MPa")
            _check.doubt("the largest depth", deepest, "m", 1e-3, "mm")
        return {name: value for name, value in made.items() if name not in ("folder", "skin", "array", "tolerances")}
