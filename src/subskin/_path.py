"""Paths checked at the door, without NumPy: commands begin by it."""

from __future__ import annotations

import os
from pathlib import Path

from .errors import InvalidValueError

__all__ = ["path_of"]


def path_of(value: object) -> Path:
    """The path that is given: a text or a `Path`, not an open file, nor a number, which Python takes for one."""
    if not isinstance(value, str | os.PathLike) or isinstance(os.fspath(value), bytes):
        seen, rule = f"a {type(value).__name__} for a path", "a text or a pathlib.Path is needed"
        raise InvalidValueError(seen, rule, '"finger.toml"')
    return Path(value)
