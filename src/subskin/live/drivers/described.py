"""A board described by a table of its fields: one more needs no code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields as fields_of
from typing import Any

from ... import _check
from ...errors import InvalidValueError, UnknownOptionError
from .fields import Field
from .fixed import Fixed

__all__ = ["Described"]

_MOST = 4096
_KEYS = {field.name: str if field.name in ("name", "type", "use") else float for field in fields_of(Field)}


class Described(Fixed, name="fixed"):
    """Frames of one length, described by a table of a file.

    Parameters
    ----------
    fields : sequence of mapping
        What lies between the marks, in its order: tables with `name` and `type`, and any of `use`, `scale`, `offset`,
        `low` and `high`, as of a `Field`. With `count`, so many of it follow each other, numbered from 0. A list of
        names is a group: with `count` it is the group that is repeated.
    start, end : str
        Marks, in hexadecimal digits: "0d 0a".
    check, covers
        As of `Fixed`.
    byte_order : {"little", "big"}
        Which byte of a number comes first.

    Raises
    ------
    InvalidValueError, UnknownOptionError
        As `Fixed`; a key that a field has not got, a mark that is not in hexadecimal digits.

    Examples
    --------
    >>> skin = Described([{"name": ["t_C", "x_uT", "y_uT", "z_uT"], "type": "f32", "count": 2}], end="0d 0a")
    >>> skin.channels
    ('t0_C', 'x0_uT', 'y0_uT', 'z0_uT', 't1_C', 'x1_uT', 'y1_uT', 'z1_uT')
    """

    def __init__(
        self,
        fields: Sequence[Mapping[str, Any]],
        start: str = "",
        end: str = "",
        check: str = "",
        covers: str = "fields",
        byte_order: str = "little",
    ) -> None:
        _check.choice("byte_order", byte_order, ("little", "big"))
        marks = [_mark(key, text) for key, text in (("start", start), ("end", end))]
        if not isinstance(fields, Sequence) or isinstance(fields, str):
            raise InvalidValueError("fields", "a table for each is needed", 'fields = [{name = "p0", type = "u16"}]')
        each = [field for table in fields for field in _fields(table)]
        if len(each) > _MOST:
            raise InvalidValueError(f"{len(each)} fields", f"at most {_MOST} are handled", "a smaller count")
        names = [field.name for field in each if field.use == "value"]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise InvalidValueError(f'two fields named "{twice}"', "each channel has a name of its own", "rename one")
        super().__init__(
            each, start=marks[0], end=marks[1], check=check, covers=covers, big_endian=byte_order == "big"
        )  # fmt: skip


def _mark(key: str, text: str) -> bytes:
    try:
        return bytes.fromhex(text)
    except ValueError:
        fix = f'{key} = "0d 0a"'
        raise InvalidValueError(f'{key} = "{text}"', "a mark is written in pairs of hexadecimal digits", fix) from None


def _fields(table: Any) -> list[Field]:
    """The fields of one table."""
    fix = '{name = "p0", type = "u16"}'
    if not isinstance(table, Mapping):
        raise InvalidValueError(f"fields: {table!r}", "a table for each is needed", fix)
    told = dict(table)
    count, names = told.pop("count", None), told.pop("name", None)
    group = names if isinstance(names, list) else [names]
    if not group or not all(isinstance(name, str) and name for name in group) or "type" not in told:
        raise InvalidValueError(f"field {names!r}", "a field has a name and a type", fix)
    if count is not None and (type(count) is not int or not 1 <= count <= _MOST):
        raise InvalidValueError(f"count = {count!r} of {group[0]}", f"a whole number from 1 to {_MOST} is needed", fix)
    for key, value in told.items():
        if key not in _KEYS:
            known = ", ".join([*_KEYS, "count"])
            raise UnknownOptionError(f'key "{key}" of field {group[0]}', "no such key is known", f"known: {known}")
        if not isinstance(value, str if _KEYS[key] is str else int | float) or isinstance(value, bool):
            rule = "a text is needed" if _KEYS[key] is str else "a number is needed"
            raise InvalidValueError(f"{key} = {value!r} of field {group[0]}", rule, fix)
    if count is None:
        return [Field(name, **told) for name in group]
    return [Field(_numbered(name, i), **told) for i in range(count) for name in group]


def _numbered(name: str, i: int) -> str:
    """x_uT becomes x0_uT."""
    head, mark, unit = name.partition("_")
    return f"{head}{i}{mark}{unit}"
