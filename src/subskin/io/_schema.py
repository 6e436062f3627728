"""The tables of `finger.toml` as pydantic models: structure, names, and units that do not depend on each other."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    StrictBool,
    StrictInt,
    StrictStr,
    ValidationInfo,
)

from ..errors import InvalidValueError
from .units import of_field, quantity, unit_scale

__all__ = [
    "CalibrationTable",
    "ColumnTable",
    "ContactTable",
    "FingerDocument",
    "Length",
    "Lengths",
    "LiveTable",
    "LocateTable",
    "Number",
    "RecordingTable",
    "RelaxationTable",
    "SensorsTable",
    "SkinTable",
    "StrictTable",
    "TareTable",
    "TipTable",
    "one",
    "one_or_each",
]


def one(unit: str) -> PlainValidator:
    """A quantity in the SI unit `unit`."""
    return PlainValidator(of_field(unit))


def one_or_each(unit: str) -> PlainValidator:
    """One quantity for all sensors, or a list with one for each."""
    return PlainValidator(of_field(unit, lists=True))


def _unit_text(value: object, info: ValidationInfo) -> str:
    unit_scale(value, None, str(info.field_name))
    return str(value)


def _search(value: object, info: ValidationInfo) -> Any:
    """The ends of y, or those of y and of z."""
    if isinstance(value, list) and len(value) == 2 and all(isinstance(each, list) for each in value):
        return tuple(_range(each, info) for each in value)
    return _range(value, info)


def _range(value: object, info: ValidationInfo) -> tuple[float, float]:
    name = str(info.field_name)
    if not isinstance(value, list) or len(value) != 2:
        raise InvalidValueError(f"{name} = {value!r}", "two positions are needed", f'write {name} = ["-5 mm", "5 mm"]')
    low, high = (quantity(item, "m", f"{name}[{i}]") for i, item in enumerate(value))
    if not low < high:
        raise InvalidValueError(f"{name} = {value!r}", "the first has to be < the second", "swap them")
    return low, high


def _names(value: object, info: ValidationInfo) -> list[str]:
    name = str(info.field_name)
    if not isinstance(value, list) or not all(isinstance(item, str) and item for item in value) or not value:
        raise InvalidValueError(f"{name} = {value!r}", "a list of names is needed", f'write {name} = ["s0", "s1"]')
    twice = next((item for item in value if value.count(item) > 1), None)
    if twice is not None:
        raise InvalidValueError(f'{name} holds "{twice}" twice', "each name may stand once", "leave one out")
    return list(value)


def _at(value: object, info: ValidationInfo) -> Any:
    """A position: y, or on an area [y, z]."""
    name = str(info.field_name)
    if isinstance(value, list) and len(value) == 2:
        return tuple(quantity(item, "m", f"{name}[{i}]") for i, item in enumerate(value))
    return quantity(value, "m", name)


def _count(value: object) -> object:
    """The sensors of a row; two counts are those of a grid."""
    if isinstance(value, list) and len(value) == 2:
        fix = f'layout = "grid" and shape = {value!r}'
        raise InvalidValueError(f"count = {value!r}", "a row has one count, a grid a shape", fix)
    return value


def _columns(value: object) -> Any:
    """One column, or on an area two: y and z."""
    each = value if isinstance(value, list) else [value]
    return each if len(each) in (1, 2) else value


Length = Annotated[float, one("m")]
Angle = Annotated[float, one("rad")]
Pressure = Annotated[float, one("Pa")]
Time = Annotated[float, one("s")]
Number = Annotated[float, one("")]
Above0 = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Lengths = Annotated[float | list[float], one_or_each("m")]
UnitText = Annotated[str, PlainValidator(_unit_text)]
Names = Annotated[list[str], PlainValidator(_names)]
Readings = Any  # units follow from other keys, so they wait


class StrictTable(BaseModel):
    """A table that takes no key but its own."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class MaterialTable(StrictTable):
    """[skin.base]: the half plane beneath the layers; [skin.core]: what the core of a round finger is made of."""

    material: StrictStr | None = None
    young: Pressure | None = None
    poisson: Number = 0.5


class LayerTable(MaterialTable):
    """[[skin.layers]]: one layer, the first at the surface."""

    thickness: Length
    bond: Literal["bonded", "frictionless"] = "bonded"


class RidgesTable(StrictTable):
    """[skin.ridges]: ridges on the skin."""

    pitch: Length
    height: Length
    width: Length | None = None
    crest: Length = 0.0


class SkinTable(StrictTable):
    """[skin]: what is pressed. Which keys are needed depends on the kind (see `_skin`)."""

    kind: StrictStr = "half_plane"
    material: StrictStr | None = None
    young: Pressure | None = None
    poisson: Number | None = None
    plane: Literal["strain", "stress"] | None = None
    radius: Length | None = None
    core_radius: Length | None = None
    layers: list[LayerTable] | None = None
    base: MaterialTable | None = None
    core: MaterialTable | None = None
    bond: Literal["bonded", "frictionless"] | None = None
    ridges: RidgesTable | None = None


class SensorsTable(StrictTable):
    """[sensors]: where they are and how each turns what it measures into a reading."""

    layout: Literal["row", "grid", "hexagonal"] = "row"
    count: Annotated[StrictInt | None, BeforeValidator(_count)] = None
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
    gain: Readings = 1.0
    offset: Readings = 0.0
    lift: Readings = 0.0
    noise: Readings = 0.0
    low: Readings = None
    high: Readings = None
    resolution: Readings = 0.0


class LocateTable(StrictTable):
    """[locate]: options of `Finger.locate`."""

    friction: Number | None = None
    search: Annotated[Any, PlainValidator(_search)] = None
    load: Literal["line", "point", "either"] | None = None
    beside: Length | None = None
    normal_force: Any = None
    false_alarm: Number | None = None
    ambiguity: Number | None = None


class ColumnTable(StrictTable):
    """A column of a recording and what one count of it is worth."""

    column: StrictStr = Field(min_length=1)
    unit: UnitText | None = None


class RecordingTable(StrictTable):
    """[recording]: how to read a raw recording."""

    sensors: Names
    unit: UnitText | None = None
    time: ColumnTable | None = None
    position: Annotated[list[ColumnTable] | None, BeforeValidator(_columns)] = None
    press: ColumnTable | None = None
    force: ColumnTable | None = None
    early: Number = 0.4
    before: Time = 0.3
    hold: Time = 0.5


class LiveTable(StrictTable):
    """[live]: the board that the sensors are read by."""

    port: StrictStr | None = None
    driver: StrictStr | dict[str, Any] | None = None
    channels: Names | None = None
    unit: UnitText | list[UnitText] | None = None


class RelaxationTable(StrictTable):
    """[relaxation]: what touches that are held lose, and how fast, as `fit_relaxation` finds it."""

    share: list[Number | list[Number]]
    time: list[Time]
    doubt: Number | list[Number] = 0.0


class TareTable(StrictTable):
    """[tare]: how drift is taken off."""

    drift: Readings = None
    noise: Readings = None


class ContactTable(StrictTable):
    """[touch] of a finger.toml: what is known of the contacts."""

    length: Length | None = None


class SpreadTable(StrictTable):
    """[calibration.spread]: how far positions are off along the row, over what independent noise would make of them."""

    y: Annotated[list[Length], Field(min_length=1)]
    straight: list[Above0]
    leaning: list[Above0]


class TipTable(StrictTable):
    """[tip]: what flat layers are bent to."""

    radius: Length
    shape: Literal["cylinder", "sphere"] | None = None


class CalibrationTable(StrictTable):
    """[calibration]: what `calibrate` wrote."""

    origin: Annotated[Any, PlainValidator(_at)] = None
    turn: Angle = 0.0
    response: Annotated[str, Field(pattern="^[0-9a-f]{64}$")] | None = None
    differences: StrictBool = False
    source: StrictStr = ""
    fit: list[StrictStr] = []
    touches: StrictInt = 0
    blind: StrictBool = False
    misfit: Number | None = None
    spread: SpreadTable | None = None
    accepted_misfit: StrictBool = False
    relative_forces: StrictBool = False
    r2: Number | None = None
    r2_held_out: Number | None = None
    dead: list[StrictStr] = []
    weak: list[StrictStr] = []
    std: dict[str, Any] = {}


class FingerDocument(StrictTable):
    """The whole file."""

    skin: SkinTable
    sensors: SensorsTable
    locate: LocateTable = LocateTable()
    recording: RecordingTable | None = None
    live: LiveTable | None = None
    relaxation: RelaxationTable | None = None
    tare: TareTable = TareTable()
    touch: ContactTable = ContactTable()
    tip: TipTable | None = None
    calibration: CalibrationTable = CalibrationTable()
