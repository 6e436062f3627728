"""Where a key stands in a TOML text: parsers tell it for a syntax error, and for nothing else."""

from __future__ import annotations

import re

__all__ = ["key_line"]

_HEADER = re.compile(r"\s*(\[\[?)\s*([^\[\]]+?)\s*\]\]?\s*(#.*)?$")
_KEY = re.compile(r"""\s*((?:"[^"]*"|'[^']*'|[A-Za-z0-9_-]+)(?:\s*\.\s*(?:"[^"]*"|'[^']*'|[A-Za-z0-9_-]+))*)\s*=""")
_PART = re.compile(r'"[^"]*"|\'[^\']*\'|[A-Za-z0-9_-]+')


def _parts(dotted: str) -> tuple[str, ...]:
    return tuple(part.strip("\"'") for part in _PART.findall(dotted))


def key_line(text: str, path: tuple[str, ...]) -> int | None:
    r"""Line, from 1, on which the key `path` or, failing that, its nearest parent is set; None for neither.

    Examples
    --------
    >>> key_line("[skin]\nyoung = 1\n\n[sensors]\ndepth = -1\n", ("sensors", "depth"))
    5
    >>> key_line("[[skin.layers]]\nyoung = 1\n[[skin.layers]]\nyoung = 2\n", ("skin", "layers", "1", "young"))
    4
    >>> key_line("[[skin]]\nyoung = 1\n[[skin]]\n[[skin.layers]]\nyoung = 2\n", ("skin", "1", "layers", "0", "young"))
    5
    """
    seen: dict[tuple[str, ...], int] = {}
    best, line_of_best = 0, None
    table: tuple[str, ...] = ()
    for number, line in enumerate(text.split("\n"), start=1):
        header, key = _HEADER.match(line), _KEY.match(line)
        if header:
            table = ()
            *outer, last = _parts(header[2]) or ("",)
            for part in outer:  # a table within an array's belongs to the last of these
                table = (*table, part)
                table = (*table, str(seen[table])) if table in seen else table
            table = (*table, last)
            if header[1] == "[[":
                seen[table] = seen.get(table, -1) + 1
                table = (*table, str(seen[table]))
            here = table
        elif key:
            here = (*table, *_parts(key[1]))
        else:
            continue
        shared = len(here) if here == path[: len(here)] else 0
        if shared > best:
            best, line_of_best = shared, number
    return line_of_best
