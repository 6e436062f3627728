"""The reference names everything that is public, and the check against remote loads sees what it has to."""

from __future__ import annotations

import importlib
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

import subskin

ROOT = Path(__file__).parents[2]
LISTED = re.compile(r"^   (?:\w+\.)*(\w+)$", re.MULTILINE)


def test_every_public_name_is_in_the_reference() -> None:
    public = {n for n, v in vars(subskin).items() if not n.startswith("_") and not isinstance(v, ModuleType)}
    assert "Finger" in public
    listed = set(LISTED.findall((ROOT / "docs/api/index.rst").read_text("utf-8")))
    assert public - listed == set()


@pytest.mark.parametrize("name", ["subskin.estimate.three_sensor", "subskin.memo", "subskin.plot"])
def test_modules_with_a_page_say_what_is_public(name: str) -> None:
    module = importlib.import_module(name)
    assert module.__all__
    pages = [page.read_text("utf-8") for page in (ROOT / "docs/api").glob("*.rst")]
    assert sum(f"automodule:: {name}\n" in page for page in pages) == 1


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
