"""The tables of a file of touches to learn from, as pydantic models."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, StrictInt, StrictStr

from ._schema import Number, StrictTable

__all__ = ["TouchesDocument"]

_Ends = Annotated[Any, PlainValidator(lambda value: value)]  # one value or two; the unit follows from other keys


class LoadTable(StrictTable):
    """[load]: how the finger is touched."""

    force: _Ends
    position: _Ends = None
    across: _Ends = None
    angle: _Ends = None
    azimuth: _Ends = None
    noise: _Ends = None


class ContactShareTable(StrictTable):
    """[[contact]]: a family that touches."""

    family: StrictStr
    share: Number = 1.0
    half_width: _Ends = None


class FaultTable(StrictTable):
    """[fault]: shares of the touches in which one sensor has it."""

    dead: Number = 0.0
    weak: Number = 0.0
    shifted: Number = 0.0


class TouchesDocument(StrictTable):
    """The whole file."""

    title: StrictStr = "Touches"
    finger: Annotated[StrictStr, Field(min_length=1)]
    touches: StrictInt
    shard: StrictInt = 100_000
    seed: StrictInt = 0
    precision: Literal["single", "double"] = "single"
    load: LoadTable
    contact: Annotated[list[ContactShareTable], Field(min_length=1)]
    fault: FaultTable = FaultTable()
