"""Where in a TOML file the value stands that another room finds wrong."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from ..errors import FileError, SubskinError
from ._toml_errors import located, read_text

__all__ = ["read_text", "wrong_in"]


def wrong_in(text: str, name: str, path: tuple[str, ...], table: object, error: SubskinError) -> FileError:
    r"""An error that a table of a file made, as one of the file, with the line.

    Parameters
    ----------
    text, name : str
        The file, and what messages call it.
    path : tuple of str
        Keys by which the table is reached.
    table : mapping
        What the table says.
    error : SubskinError
        What was found wrong; the line is that of the key that it names, the one with the value that it names if there
        are several, or else that of the table.

    Examples
    --------
    >>> error = SubskinError('type = "u17"', "no such type is known", 'type = "u16"')
    >>> text = 'name = "fixed"\n[[fields]]\ntype = "u8"\n[[fields]]\ntype = "u17"\n'
    >>> print(wrong_in(text, "board.toml", (), {"fields": [{"type": "u8"}, {"type": "u17"}]}, error))
    board.toml, line 5: [fields] type = "u17": no such type is known. Fix: type = "u16".
    """
    words = set(re.findall(r"[\w.+-]+", error.seen))
    found = [each for each in _values(table, ()) if each[0][-1] in words]
    exact = [at for at, value in found if set(re.findall(r"[\w.+-]+", str(value))) <= words]
    at = next(iter(exact), found[0][0] if found else ())
    return located(text, name, (*path, *at), error.seen, error.rule, error.fix)


def _values(table: object, path: tuple[str, ...]) -> list[tuple[tuple[str, ...], Any]]:
    """Every key of a table and of those in it, the innermost first."""
    items = table.items() if isinstance(table, Mapping) else enumerate(table) if isinstance(table, list) else ()
    found = []
    for key, value in items:
        at = (*path, str(key))
        found += _values(value, at)
        if isinstance(table, Mapping):
            found.append((at, value))
    return found
