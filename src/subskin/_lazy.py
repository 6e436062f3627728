"""Names that load when they are first used (PEP 562): `__init__.pyi` says which, for people, checkers and Python."""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

__all__ = ["attach", "np"]


class _Later:
    """A module that is imported when something of it is first used."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        value = getattr(import_module(self._name), name)
        setattr(self, name, value)
        return value


if TYPE_CHECKING:
    import numpy as np
else:
    np = _Later("numpy")


def attach(package: str, path: str) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """What a package needs so that its names load when used.

    Parameters
    ----------
    package : str
        Its `__name__`.
    path : str
        Its `__file__`; the stub lies beside it.

    Returns
    -------
    tuple
        Its `__getattr__`, `__dir__` and `__all__`. What the stub imports can be reached; what its `__all__` holds
        is public, and listed by `dir`.
    """
    stub = _parsed(Path(path).with_suffix(".pyi"))
    origin = {alias.name: node.module for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names}

    def load(name: str) -> object:
        if name not in origin:
            raise AttributeError(f"module {package!r} has no attribute {name!r}{_hint(package, path, name)}")
        if origin[name] is None:
            return import_module(f"{package}.{name}")
        value = getattr(import_module(f"{package}.{origin[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    return load, lambda: sorted(_public(stub)), _public(stub)


def _hint(package: str, path: str, name: str) -> str:
    """In which room of the package the name is public; nothing is imported for it."""
    if name.startswith("_"):  # public nowhere, and asked for by each tool that looks into modules
        return ""
    for parts, file in _files(Path(path).parent):
        if f'"{name}"' in file.read_text("utf-8") and name in _public(_parsed(file)):
            return f": it is public in another room. Fix: {'.'.join((package, *parts, name))}"
    return ""


@cache
def _files(folder: Path) -> list[tuple[tuple[str, ...], Path]]:
    """The public files of a package as parts of their dotted names, the rooms before what they hold."""
    files = [file for file in folder.rglob("*.py*") if file.suffix in {".py", ".pyi"}]
    parts = [file.relative_to(folder).with_suffix("").parts for file in files]
    rooms = [p[:-1] if p[-1] == "__init__" else p for p in parts]
    shown = [(room, file) for room, file in zip(rooms, files, strict=True) if not any(p[0] == "_" for p in room)]
    return sorted(shown, key=lambda each: (len(each[0]), each[1]))


def _parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text("utf-8"))


def _public(tree: ast.Module) -> list[str]:
    """What `__all__` holds, where it is written out."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return list(ast.literal_eval(node.value)) if isinstance(node.value, ast.List) else []
    return []
