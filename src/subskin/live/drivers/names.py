"""Drivers by the names that files use, and as files have them: a table, or a file that describes a board."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...errors import FileError, InvalidValueError, SubskinError
from ...io.toml_errors import read_text, wrong_in
from ..options import made, named_among
from .base import Driver

__all__ = ["from_table", "kinds", "load", "named"]


def kinds() -> dict[str, type[Driver]]:
    """The drivers by the names that files use, one's own among them.

    Examples
    --------
    >>> kinds()["anyskin"].__name__
    'AnySkin'
    """
    return dict(Driver._by_name)


def named(name: str, **options: Any) -> Driver:
    """The driver of a name of `kinds`.

    Parameters
    ----------
    name : str
        Such as "anyskin" or "lines".
    **options
        What the driver takes: number of sensors, names of columns.

    Raises
    ------
    InvalidValueError
        An unknown name; an option out of range, or one that is missing.
    UnknownOptionError
        An option that the driver has not got.

    Examples
    --------
    >>> named("anyskin", sensors=2).channels[-1]
    'z1_uT'
    """
    kind = named_among(kinds(), name, f'driver "{name}"', "driver")
    return made(kind, f"driver {name}", options)


def from_table(table: Mapping[str, Any]) -> Driver:
    """The driver that a table of a file describes: its `name`, and its options.

    Parameters
    ----------
    table : mapping
        The driver's name under "name"; the rest as in `named`. A name that ends with .toml is a file, as by `load`.

    Raises
    ------
    InvalidValueError, UnknownOptionError, FileError
        As `named` and `load`; a table without a name; a file with options beside it.

    Examples
    --------
    >>> len(from_table({"name": "anyskin", "sensors": 2}).channels)
    8
    """
    options = dict(table)
    name = options.pop("name", None)
    if not isinstance(name, str):
        raise InvalidValueError("a driver without a name", "a name is needed", 'name = "anyskin"')
    if name.endswith(".toml"):
        if options:
            rule = "the file has all that the driver takes"
            raise InvalidValueError(f"{next(iter(options))} beside {name}", rule, f'driver = "{name}"')
        return load(name)
    return named(name, **options)


def load(path: str | Path) -> Driver:
    r"""The driver that a file describes: a table with the driver's `name` and its options.

    Parameters
    ----------
    path : str or pathlib.Path
        A TOML file.

    Raises
    ------
    FileError
        A file that cannot be read, is no TOML, or describes no driver.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "board.toml")
    ...     _ = file.write_text('name = "lines"\ncolumns = ["p0", "p1"]')
    ...     load(file).channels
    ('p0', 'p1')
    """
    text = read_text(path)
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(str(path), f"not TOML: {str(error)[:100]}", 'write key = "value"') from None
    if str(table.get("name", "")).endswith(".toml"):
        raise FileError(f'{path}: name = "{table["name"]}"', "a file cannot name another", 'name = "fixed"')
    try:
        return from_table(table)
    except SubskinError as error:
        raise wrong_in(text, str(path), (), table, error) from None
