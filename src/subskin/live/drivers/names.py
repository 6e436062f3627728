"""Drivers by the names that files use."""

from __future__ import annotations

import difflib
import inspect
import json
from typing import Any

from ...errors import InvalidValueError, UnknownOptionError
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
    known = kinds()
    if name not in known:
        close = difflib.get_close_matches(str(name), list(known), n=1)
        fix = f'did you mean "{close[0]}"' if close else f"known: {', '.join(known)}"
        raise InvalidValueError(f'driver "{name}"', "no such driver is known", fix)
    takes = inspect.signature(known[name]).parameters
    for option in options:
        if option not in takes:
            rule = f"the driver {name} has no such option"
            raise UnknownOptionError(f'option "{option}"', rule, f"known: {', '.join(takes) or 'none'}")
        usual = takes[option].default
        if isinstance(usual, str | bool | int) and type(options[option]) is not type(usual):
            rule = "a text" if isinstance(usual, str) else "true or false" if isinstance(usual, bool) else "a number"
            fix = f"{option} = {json.dumps(usual)}"
            raise InvalidValueError(f"{option} = {options[option]!r} of driver {name}", f"{rule} is needed", fix)
    missing = [key for key, one in takes.items() if one.default is one.empty and key not in options]
    if missing:
        raise InvalidValueError(f"driver {name} without {missing[0]}", "it is needed", f"{missing[0]} = ...")
    return known[name](**options)
