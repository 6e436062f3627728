"""What the tables of this project's TOML files are made of: pydantic models that check themselves.

A table says of each key its unit and its bounds; from what length on a value was probably meant in mm (`Doubt`); and by
`told` what it means. Whatever is wrong in it names the key, and the line of the file.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainValidator, StrictStr, ValidationInfo

from .. import _check
from .._declared import Real
from ..errors import InvalidValueError
from .units import line_load, of_field, quantity, unit_scale

__all__ = ["Doubt", "FingerTable", "StrictTable", "doubt_sizes", "ends_of", "one"]

LONGEST, RIDGE = 1.0, 0.1
"""Metres from which on a radius or a contact, and a ridge or what is to be told apart, is doubted."""


def one(unit: str, **bounds: Any) -> PlainValidator:
    """A quantity in the SI unit `unit`, within the bounds that `Real` has."""
    if not bounds:
        return PlainValidator(of_field(unit))
    real = Real(unit, **bounds)

    def convert(value: object, info: ValidationInfo) -> float:
        name = str(info.field_name)
        return real.one(name, quantity(value, unit, name))

    return PlainValidator(convert)


def ends_of(value: object, unit: str, name: str, length: float | None = None) -> tuple[float, float]:
    """One value, or the two ends of a range, in SI; forces in N are divided by the `length` of the contact [m]."""
    each = value if isinstance(value, list) else [value, value]
    if len(each) != 2:
        rule, example = (
            "one value, or the two ends of a range, are needed",
            f'"1 {unit}", "2 {unit}"' if unit else "1, 2",
        )
        raise InvalidValueError(f"{name} lists {len(each)}", rule, f"{name} = [{example}]")
    low, high = (line_load(v, length, name) if unit == "N/m" else quantity(v, unit, name) for v in each)
    if low > high:
        raise InvalidValueError(f"{name} = {value!r}", "the first has to be <= the second", "swap them")
    return low, high


def _unit_text(value: object, info: ValidationInfo) -> str:
    unit_scale(value, None, str(info.field_name))
    return str(value)


def _names(value: object, info: ValidationInfo) -> list[str]:
    name = str(info.field_name)
    if not isinstance(value, list) or not all(isinstance(item, str) and item for item in value) or not value:
        raise InvalidValueError(f"{name} = {value!r}", "a list of names is needed", f'write {name} = ["s0", "s1"]')
    twice = next((item for item in value if value.count(item) > 1), None)
    if twice is not None:
        raise InvalidValueError(f'{name} holds "{twice}" twice', "each name may stand once", "leave one out")
    return list(value)


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
Numbers = Annotated[float | list[float], PlainValidator(of_field("", lists=True))]
Lengths = Annotated[float | list[float], PlainValidator(of_field("m", lists=True))]
UnitText = Annotated[str, PlainValidator(_unit_text)]
Names = Annotated[list[str], PlainValidator(_names)]
Search = Annotated[Any, PlainValidator(_search)]
Count, Columns = BeforeValidator(_count), BeforeValidator(_columns)
At = Annotated[Any, PlainValidator(_at)]
Name = Annotated[StrictStr, Field(min_length=1)]
Given = Annotated[Any, PlainValidator(lambda value: value)]
"""A value whose unit follows from other keys, so that it waits."""


@dataclass(frozen=True)
class Doubt:
    """From which length on mm was probably meant [m], and what the message calls it, if not by its key."""

    largest: float
    said: str = ""


class StrictTable(BaseModel):
    """A table that takes no key but its own."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class FingerTable(StrictTable):
    """A table of the file, which tells fields of the `FingerFile` by what it says and what those before it `made`."""

    def told(self, file: Any, made: dict[str, Any]) -> dict[str, Any]:
        """The fields; `file` is the whole `FingerDocument`, and "array" and "skin" are for the tables that follow."""
        return {}


def doubt_sizes(table: StrictTable) -> None:
    """Warn of lengths of a table, and of the tables in it, that were probably meant in mm."""
    for key, field in type(table).model_fields.items():
        value = getattr(table, key)
        several = value if isinstance(value, list) else [value]
        for inner in several:
            if isinstance(inner, StrictTable):
                doubt_sizes(inner)
        for doubt in field.metadata:
            if isinstance(doubt, Doubt) and value is not None and max(several) > doubt.largest:
                _check.doubt(doubt.said or key, max(several), "m", 1e-3, "mm")
