"""The reference names everything that is public, and the check against remote loads sees what it has to."""

from __future__ import annotations

import importlib
import re
import sys
from functools import cached_property, reduce
from pathlib import Path
from types import ModuleType

import pytest
from numpydoc.docscrape import NumpyDocString

import subskin

ROOT = Path(__file__).parents[2]
PAGES = ["subskin.memo.three_sensors", "subskin.memo", "subskin.plot"]
LISTED = re.compile(r"^   ((?:\w+\.)*\w+)$", re.MULTILINE)


def rooms(package: ModuleType) -> dict[str, ModuleType]:
    """The rooms without a page of their own, by their way from the top; design has rooms within."""
    folder = Path(package.__file__).parent
    names = {path.stem for path in folder.iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()}
    hidden = {name for name in names if name.startswith("_")} | {"cli", "studio"}  # commands and a page
    found = {name: importlib.import_module(f"{package.__name__}.{name}") for name in names - hidden}
    found = {name: room for name, room in found.items() if room.__name__ not in PAGES}
    if package is subskin:
        found |= {f"design.{name}": room for name, room in rooms(subskin.design).items()}
    return found


def ways() -> set[str]:
    """The way to every public name: the shortest, for a name that stands in its room and at the top of all."""
    known = {id(getattr(subskin, name)): name for name in subskin.__all__}
    for room, module in sorted(rooms(subskin).items(), key=lambda item: item[0].count(".")):
        for name in module.__all__:
            known.setdefault(id(getattr(module, name)), f"{room}.{name}")
    return set(known.values()) - {"decide", "design"}


def test_every_public_name_is_in_the_reference() -> None:
    assert ways() >= {"Finger", "pressing.Cylinder", "design.Goals", "design.search.Row", "errors.FileError"}
    page, _, _ = (ROOT / "docs/api/index.rst").read_text("utf-8").partition(".. toctree::")
    listed = LISTED.findall(page)
    assert sorted(listed) == sorted(ways())


@pytest.mark.parametrize("name", PAGES)
def test_modules_with_a_page_say_what_is_public(name: str) -> None:
    module = importlib.import_module(name)
    assert module.__all__
    pages = [page.read_text("utf-8") for page in (ROOT / "docs/api").glob("*.rst")]
    assert sum(f"automodule:: {name}\n" in page for page in pages) == 1


def test_every_key_of_the_finger_file_is_on_the_page_of_the_command_line() -> None:
    schema = importlib.import_module("subskin.io._schema")
    page = (ROOT / "docs/cli.md").read_text("utf-8")
    tables = {name: field.annotation for name, field in schema.FingerDocument.model_fields.items()}
    assert len(tables) >= 5
    for name, annotation in tables.items():
        assert f"[{name}]" in page
        model = next(m for m in (annotation, *getattr(annotation, "__args__", ())) if hasattr(m, "model_fields"))
        assert [key for key in model.model_fields if f"`{key}`" not in page] == [], name


def test_no_attribute_is_described_twice() -> None:
    """In the list of the class and at its property: Sphinx says so, but only a minute into the docs."""
    classes = [kind for way in ways() if isinstance(kind := named(way), type)]
    listed = {kind: {field.name for field in NumpyDocString(kind.__doc__ or "")["Attributes"]} for kind in classes}
    twice = [f"{kind.__name__}.{name}" for kind in classes for name in listed[kind] if described(kind, name)]
    assert sum(map(len, listed.values())) > 100
    assert twice == []


def named(way: str) -> object:
    return reduce(getattr, way.split("."), subskin)


def described(kind: type, name: str) -> bool:
    member = vars(kind).get(name)
    return isinstance(member, property | cached_property) and bool(member.__doc__)


@pytest.fixture
def offline(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    pytest.importorskip("sphinx", reason="the docs extra is not installed")
    monkeypatch.syspath_prepend(str(ROOT / "docs/_ext"))
    monkeypatch.delitem(sys.modules, "offline", raising=False)
    return importlib.import_module("offline")


@pytest.mark.parametrize(
    "markup",
    [
        '<script async="async" src="https://cdn.example/x.js"></script>',
        "<img alt='a' src='//cdn.example/x.png'>",
        '<link href="https://fonts.example/css" rel="stylesheet">',
        '<link rel="preconnect" href="https://fonts.example">',
        "@font-face { src: url(https://fonts.example/a.woff2); }",
        '@import "http://cdn.example/a.css";',
    ],
)
def test_remote_loads_are_seen(offline: ModuleType, markup: str) -> None:
    assert len(offline.remote_loads(markup)) == 1


@pytest.mark.parametrize(
    "markup",
    [
        '<a href="https://example.org">a link is not a load</a>',
        '<script src="_static/x.js"></script>',
        '<link rel="stylesheet" href="_static/x.css">',
        '<link rel="canonical" href="https://example.org/page.html">',
        '<svg xmlns="http://www.w3.org/2000/svg"></svg>',
    ],
)
def test_links_and_local_files_are_left_alone(offline: ModuleType, markup: str) -> None:
    assert offline.remote_loads(markup) == []
