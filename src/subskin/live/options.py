"""What is named in a file or on the command line, made with the options that stand beside its name."""

from __future__ import annotations

import difflib
import inspect
import json
from collections.abc import Mapping
from typing import Any, TypeVar
from urllib.parse import parse_qsl

from ..errors import InvalidValueError, UnknownOptionError

__all__ = ["made", "named_among", "written"]

_Kind = TypeVar("_Kind")
_TEXTS = {str: "a text", bool: "true or false", int: "a number", float: "a number"}
_READ = {"int": (int, "a whole number"), "float": (float, "a number")}


def named_among(
    kinds: Mapping[str, type[_Kind]], name: str, seen: str, what: str, fix: str = "", form: str = '"{}"'
) -> type[_Kind]:
    """The class of a name.

    Parameters
    ----------
    kinds : mapping
        The classes by their names.
    name, seen : str
        What was asked for, and what an error shows of it.
    what : str
        What it is none of.
    fix : str, optional
        Where no name is like it; all names if left out.
    form : str, optional
        How a name is written.

    Raises
    ------
    InvalidValueError
        There is none of this name.
    """
    if name not in kinds:
        close = difflib.get_close_matches(str(name), list(kinds), n=1)
        meant = f"did you mean {form.format(close[0])}" if close else fix or f"known: {', '.join(kinds)}"
        raise InvalidValueError(seen, f"no such {what} is known", meant)
    return kinds[name]


def made(
    kind: type[_Kind],
    name: str,
    options: Mapping[str, Any],
    fixed: Mapping[str, Any] | None = None,
    texts: bool = False,
) -> _Kind:
    """One of a class, with options: those that it has not got, of another type, and those that are missing are refused.

    Parameters
    ----------
    kind : type
        The class.
    name : str
        What errors call it.
    options : mapping
        Arguments by their names.
    fixed : mapping, optional
        Arguments that are no options.
    texts : bool, optional
        The options are texts: numbers are read from them.

    Raises
    ------
    InvalidValueError, UnknownOptionError
        An option that cannot be.
    """
    takes, values = dict(inspect.signature(kind).parameters), dict(fixed or {})
    for argument in values:
        del takes[argument]
    for option, value in options.items():
        if option not in takes:
            known = f"known: {', '.join(takes) or 'none'}"
            raise UnknownOptionError(f'option "{option}"', f"{name} has no such option", known)
        values[option] = _read(name, takes[option], value) if texts else _right(name, takes[option], value)
    missing = [key for key, one in takes.items() if one.default is one.empty and key not in values]
    if missing:
        raise InvalidValueError(f"{name} without {missing[0]}", "it is needed", f"{missing[0]} = ...")
    return kind(**values)


def written(text: str) -> tuple[str, dict[str, str]]:
    """What stands before a question mark, and the options after it: `lines?sensors=4`.

    Examples
    --------
    >>> written("lines?sensors=4&check=xor8")
    ('lines', {'sensors': '4', 'check': 'xor8'})
    """
    head, _, query = text.partition("?")
    return head, dict(parse_qsl(query, keep_blank_values=True))


def _right(name: str, one: inspect.Parameter, value: Any) -> Any:
    """The value of an option, which has the type of the usual one."""
    usual = one.default
    if isinstance(usual, str | bool | int | float) and type(value) is not type(usual):
        fix = f"{one.name} = {json.dumps(usual)}"
        raise InvalidValueError(f"{one.name} = {value!r} of {name}", f"{_TEXTS[type(usual)]} is needed", fix)
    return value


def _read(name: str, one: inspect.Parameter, text: str) -> Any:
    """The value of an option that is annotated as a number, or the text itself."""
    kind = getattr(one.annotation, "__name__", str(one.annotation)).partition(" |")[0]
    reads, rule = _READ.get(kind, (str, ""))
    try:
        return reads(text)
    except ValueError:
        raise InvalidValueError(f"{name}?{one.name}={text}", f"{rule} is needed", f"{name}?{one.name}=1") from None
