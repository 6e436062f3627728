"""A TOML file against its model: what is wrong with it in the words of this project, with the line."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, TypeVar

from ..errors import FileError, SubskinError
from .files import read_bytes

__all__ = ["Misplaced", "key_line", "key_of", "located", "read_document", "read_text", "short", "under", "wrong_in"]

_Model = TypeVar("_Model")
_Made = TypeVar("_Made")

_LONGEST = 1_000_000
_MOST_ERRORS = 100  # that are looked through for the first
_MORE_SHOWN = 5  # errors beside the first
_HEADER = re.compile(r"\s*(\[\[?)\s*([^\[\]]+?)\s*\]\]?\s*(#.*)?$")
_KEY = re.compile(r"""\s*((?:"[^"]*"|'[^']*'|[A-Za-z0-9_-]+)(?:\s*\.\s*(?:"[^"]*"|'[^']*'|[A-Za-z0-9_-]+))*)\s*=""")
_NEEDED = {
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text in quotation marks",
    "bool_type": "true or false",
    "list_type": "a list, as [...],",
}
"""What pydantic misses, by its kind of error."""
_PART = re.compile(r'"[^"]*"|\'[^\']*\'|[A-Za-z0-9_-]+')


def read_text(path: object) -> str:
    """The text of the file at `path`.

    Raises
    ------
    FileError
        A file that cannot be read, or is not in UTF-8.
    """
    data = read_bytes(str(path))
    try:
        return data.decode("utf-8-sig")  # some editors put a mark before the first letter
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise FileError(f"{path}, line {line}", "the file has to be text in UTF-8", "save it as UTF-8") from None


def _validated(text: str, name: str, model: type[_Model], needs: str) -> _Model:
    """What `text` says, as `model`."""
    from pydantic import ValidationError

    if not isinstance(text, str):
        raise FileError(f"{name} is a {type(text).__name__}", "a text is needed", "the text of the file")
    if not text.strip():
        raise FileError(f"{name} is empty", needs)
    if len(text) > _LONGEST:
        raise FileError(f"{name} has {len(text)} letters", f"at most {_LONGEST} are handled", "is it the right file")
    try:
        raw = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        found = re.search(r"(.*?)\s*\(at (?:line (\d+), column \d+|end of document)\)", str(error))
        line = found[2] or str(len(text.splitlines())) if found else None
        rule, fix = _not_toml(found[1] if found else str(error)[:80])
        raise FileError(f"{name}, line {line}" if line else name, rule, fix) from None
    try:
        document: _Model = model.model_validate(raw)  # type: ignore[attr-defined]
    except ValidationError as invalid:
        raise _explained(text, name, model, invalid.errors(include_url=False)) from None
    return document


def _not_toml(what: str) -> tuple[str, str]:
    """The rule and the fix for what the parser of Python says."""
    if "overwrite" in what or "twice" in what:
        return "each key, and each table, may stand once", "leave out one of the two"
    if "recursion" in what:
        return "not TOML: its brackets are nested too deep", "is it the right file"
    return f"not TOML: {what[:1].lower()}{what[1:]}", 'write key = "value"'


class Misplaced(Exception):
    """An error and the key that it is about."""

    def __init__(self, error: SubskinError, *path: str) -> None:
        self.error, self.path = error, path


@contextmanager
def under(*table: str, of: str | None = None, keys: Mapping[str, tuple[str, ...]] | None = None) -> Iterator[None]:
    """What goes wrong within is wrong in the table: with the key by whose name the message begins, or the key `of`.

    `keys` says where the keys stand that are in other tables. What is placed already stays where it is.
    """
    try:
        yield
    except SubskinError as error:
        key = key_of(error)
        raise Misplaced(error, *(keys or {}).get(key, (*table, key if of is None else of))) from None


def key_of(error: SubskinError) -> str:
    """The key that an error of the model is about: its message begins with it."""
    found = re.match(r"[a-z_]+", error.seen)
    return {"transducer": "kind"}.get(found[0], found[0]) if found else ""


def read_document(text: str, name: str, model: type[_Model], needs: str, make: Callable[[_Model], _Made]) -> _Made:
    """What `make` makes of `text` as `model`; `needs` is what an empty file is told.

    Raises
    ------
    FileError
        No TOML, a key or value that the model does not allow, or one out of which `make` can make nothing.
    """
    document = _validated(text, name, model, needs)
    try:
        return make(document)
    except Misplaced as wrong:
        error, path = wrong.error, wrong.path
        raise located(text, name, path, _as_written(error.seen, text, path), error.rule, error.fix) from None


def _as_written(seen: str, text: str, path: tuple[str, ...]) -> str:
    """`depth = -0.005` as the file has it: `depth = "-5 mm"`."""
    value: Any = tomllib.loads(text)
    for part in path:
        if isinstance(value, list) and part.isdigit():
            value = value[int(part)]
        else:
            value = value.get(part) if isinstance(value, dict) else None
    known = isinstance(value, str) and re.fullmatch(r"\w+ = \S+", seen)
    return f"{path[-1]} = {short(value)}" if known else seen


def located(text: str, name: str, path: tuple[str, ...], seen: str, rule: str, fix: str) -> FileError:
    """An error at the line on which the key `path` stands."""
    line = key_line(text, path)
    position = f"{name}, line {line}" if line else name
    table = f"[{_dotted(path[:-1])}] " if len(path) > 1 else ""
    return FileError(f"{position}: {table}{seen}", rule, fix)


def _dotted(path: tuple[str, ...]) -> str:
    """The name of a table; which one of an array of tables, the line tells."""
    return ".".join(part for part in path if not part.isdigit())


def _explained(text: str, name: str, model: Any, errors: Any) -> FileError:
    """The first of pydantic's errors by line, in the words of this project."""
    found = []
    for error in errors[:_MOST_ERRORS]:
        path = tuple(str(part) for part in error["loc"])
        keys = path
        while keys and keys[-1].isdigit():
            keys = keys[:-1]
        key = keys[-1] if keys else name
        seen = f"{key} = {short(error['input'])}"
        context = error.get("ctx", {}).get("error")
        if isinstance(context, SubskinError):
            seen, rule, fix = _as_written(context.seen, text, path), context.rule, context.fix
        elif error["type"] == "extra_forbidden":
            known = _keys(model, keys[:-1])
            close = difflib.get_close_matches(key, known, n=1)
            what = "table" if len(keys) == 1 else "key"
            seen, rule = f'{what} "{key}"', f"no such {what} is known"
            fix = f'did you mean "{close[0]}"' if close else f"known here: {', '.join(known)}"
        elif error["type"] == "missing":
            seen, rule = f'"{key}" is missing', "it is needed"
            keys = keys[:-1]
            fix = f"add a table [{key}]" if len(path) == 1 else f"add {key} = ... to [{_dotted(keys)}]"
        elif error["type"] == "list_type" and isinstance(error["input"], dict):
            seen, rule = f"[{_dotted(keys)}]", "there may be several, so each is headed by twice the brackets"
            fix = f"[[{_dotted(keys)}]]"
        elif error["type"] in _NEEDED:
            rule, fix = f"{_NEEDED[error['type']]} is needed", _unquoted(key, error)
        elif error["type"] in ("model_type", "model_attributes_type", "dict_type"):
            first, *more = _keys(model, keys)
            held = f"{first} = {short(error['input'])}, " if isinstance(error["input"], str) else f"{first} = ..., "
            rule = f"a table of {', '.join((first, *more))} is needed"
            fix = f"{key} = {{ {held}... }}" if len(path) > 1 else f"[{key}]"
        else:
            what = error["msg"][:1].lower() + error["msg"][1:]
            rule, fix = what.replace("input should be", "it has to be"), ""
        found.append((error["type"] != "extra_forbidden", key_line(text, keys) or 0, keys, seen, rule, fix))
    # a key that is not known comes first: it is often the misspelt name of one that is missing
    found.sort(key=lambda item: item[:2])
    _, line, keys, seen, rule, fix = found[0]
    others = {item[1]: f"line {item[1]}: {item[3]}: {item[4]}" for item in found if item[1] not in (0, line)}
    if others:
        also = f"Also {'; '.join(list(others.values())[:_MORE_SHOWN])}"
        rule, fix = (rule, f"{fix}. {also}") if fix else (f"{rule}. {also}", "")
    return located(text, name, keys if len(keys) > 1 or not seen.endswith("missing") else (*keys, ""), seen, rule, fix)


def _unquoted(key: str, error: Any) -> str:
    """The fix for a whole number that was written as text or with a point."""
    try:
        number = float(error["input"])
    except (TypeError, ValueError):
        return ""
    return f"write {key} = {number:.0f}" if error["type"].startswith("int") and number.is_integer() else ""


def _keys(model: Any, path: tuple[str, ...]) -> list[str]:
    """Keys known in the table at `path`."""
    for part in path:
        if part.isdigit():  # which of the tables of an array
            continue
        options = [model.model_fields[part].annotation]
        while any(hasattr(o, "__args__") for o in options):  # Optional, list
            options = [inner for o in options for inner in getattr(o, "__args__", (o,))]
        model = next((o for o in options if hasattr(o, "model_fields")), model)
    return list(model.model_fields)


def short(value: object) -> str:
    """A value as it may stand in a message."""
    try:
        text = f'"{value}"' if isinstance(value, str) else repr(value)
    except (RecursionError, ValueError):  # nested thousands deep, or an int of thousands of digits
        text = f"a {type(value).__name__}"
    return text if len(text) <= 60 else text[:57] + "..."


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
    index = _key_lines(text)
    return next((index[path[:n]] for n in range(len(path), 0, -1) if path[:n] in index), None)


@lru_cache(maxsize=2)
def _key_lines(text: str) -> dict[tuple[str, ...], int]:
    """The line on which each key is set first."""
    seen: dict[tuple[str, ...], int] = {}
    lines: dict[tuple[str, ...], int] = {}
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
            lines.setdefault(table, number)
        elif key:
            lines.setdefault((*table, *_parts(key[1])), number)
    return lines


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
