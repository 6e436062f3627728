"""Drivers by the names that files use."""

from __future__ import annotations

from typing import Any

from ..options import made, named_among
from .base import Driver

__all__ = ["kinds", "named"]


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
