"""The tables of `goals.toml` as pydantic models."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, PlainValidator, StrictBool, StrictInt, StrictStr

from ._schema import Length, Lengths, Number, SkinTable, StrictTable, one

__all__ = ["GoalsDocument"]

_Force = Annotated[float, one("N/m")]
_Forces = Annotated[Any, PlainValidator(lambda value: value)]  # in N where the length of the contact is known
_Angle = Annotated[float, one("rad")]
_Measured = Annotated[Any, PlainValidator(lambda value: value)]  # in the unit of what the sensor measures
_Counts = StrictInt | Annotated[list[StrictInt], Field(min_length=2, max_length=2)]
_Name = Annotated[StrictStr, Field(min_length=1)]


class TouchTable(StrictTable):
    """[touch]: what the finger is to feel."""

    force: _Forces
    length: Length | None = None
    friction: Number = 1.0
    span: Length | None = None
    area: Lengths | None = None
    half_width: Length | None = None
    edge: Length | None = None
    feature: Length | None = None
    largest_strain: Number = 0.1


class AccuracyTable(StrictTable):
    """[accuracy]: the errors that 95 % of the weakest touches keep."""

    position: Length | None = None
    angle: _Angle | None = None
    force: Number | None = None
    radius: Length | None = None
    edge: _Angle | None = None
    unsure: Number = 0.01
    blind_spots: Number | None = None
    calibrated: StrictStr = "known"


class RoomTable(StrictTable):
    """[room]: where sensors can be put."""

    count: _Counts
    depth: Lengths
    least_pitch: Length
    longest_row: Length | None = None
    area: Lengths | None = None
    layouts: list[StrictStr] | None = None


class SensorTable(StrictTable):
    """[[sensor]]: a kind of sensor that is at hand."""

    name: _Name
    kind: Any
    noise: _Measured
    width: Length = 0.0
    largest: _Measured = None
    resolution: _Measured = 0.0


class MixTable(StrictTable):
    """[[mix]]: several of the kinds in one array on an area."""

    name: _Name
    kinds: list[StrictStr]
    together: StrictBool = True


class SkinChoiceTable(SkinTable):
    """[[skin]]: a skin that could be moulded, with the keys of [skin] in a finger.toml."""

    name: _Name


class EffortTable(StrictTable):
    """[search]: how finely."""

    depths: StrictInt = 20
    pitches: StrictInt = 30
    touches: StrictInt | None = None
    seed: StrictInt = 0
    keep: StrictInt = 5


class GoalsDocument(StrictTable):
    """The whole file."""

    title: StrictStr = "Finger"
    touch: TouchTable
    accuracy: AccuracyTable
    room: RoomTable
    sensor: Annotated[list[SensorTable], Field(min_length=1)]
    skin: Annotated[list[SkinChoiceTable], Field(min_length=1)]
    mix: list[MixTable] = Field(default_factory=list)
    tolerances: dict[str, Any] | None = None
    search: EffortTable = EffortTable()
