"""Walls of the house that an import alone does not show (test_imports.py has the arrows)."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterable
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import subskin
from subskin import skin as media

ROOT = Path(subskin.__file__).parent
MODULES = sorted(path.relative_to(ROOT) for path in ROOT.rglob("*.py"))
SKINS = {name for name in media.__all__ if isinstance(of := getattr(media, name), type) and of is not media.Skin}


@pytest.fixture(scope="module")
def trees() -> dict[Path, list[ast.AST]]:
    """The nodes of every file of subskin, parsed and walked through once."""
    return {path: list(ast.walk(ast.parse((ROOT / path).read_text()))) for path in MODULES}


def names_in(node: ast.AST) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)} | {
        n.attr for n in ast.walk(node) if isinstance(n, ast.Attribute)
    }


def type_switches(nodes: Iterable[ast.AST], classes: set[str]) -> list[int]:
    """Lines that ask which of the `classes` something is: isinstance, issubclass, match, type(...) is or ==."""
    lines = []
    for node in nodes:
        if isinstance(node, ast.Call) and names_in(node.func) & {"isinstance", "issubclass"}:
            asked = names_in(node.args[1])
        elif isinstance(node, ast.MatchClass):
            asked = names_in(node.cls)
        elif isinstance(node, ast.Compare) and "type" in names_in(node):
            asked = names_in(node)
        else:
            continue
        if asked & classes:
            lines.append(node.lineno)
    return lines


def test_nothing_outside_asks_which_skin_it_is(trees):
    assert {"HalfPlane", "Layered", "Round"} <= SKINS
    asking = [
        f"{path}:{line}" for path in MODULES if path.parts[0] != "skin" for line in type_switches(trees[path], SKINS)
    ]
    assert asking == []


@pytest.mark.parametrize(
    "source",
    [
        "isinstance(skin, HalfPlane)",
        "isinstance(finger.skin, (skins.HalfPlane, Round))",
        "assert isinstance(skin, HalfPlane | Round)",
        "issubclass(kind, Layered)",
        "type(skin) is Round",
        "Round == type(finger.skin)",
        "match skin:\n    case ss.Layered(layers=one):\n        pass",
    ],
)
def test_the_walk_sees_a_question_for_the_class(source):
    assert len(type_switches(ast.walk(ast.parse(source)), SKINS)) == 1


@pytest.mark.parametrize("source", ["isinstance(skin, Skin)", "HalfPlane(material)", "skin == HalfPlane(material)"])
def test_the_walk_passes_what_is_allowed(source):
    assert type_switches(ast.walk(ast.parse(source)), SKINS) == []


VERBS = Path("finger.py")
"""`finger.locate(...)` has the types of `subskin.locate`, which takes a finger: for the type checker alone a circle."""


def imported(path: Path, nodes: Iterable[ast.AST]) -> set[Path]:
    """Files of subskin that the one at `path` imports by relative imports, under any condition."""
    found, unread = set(), set()
    for node in nodes:
        if path == VERBS and isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            unread |= set(node.body)
        if isinstance(node, ast.ImportFrom) and node.level and node not in unread:
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            tried = [base, *(base / alias.name for alias in node.names)]
            files = {Path(f"{t}.py") for t in tried if (ROOT / f"{t}.py").is_file()}
            found |= files or {base / "__init__.py"}
    return found


def circle(graph: dict[Path, set[Path]]) -> list[str]:
    """The files of a circle, or none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return [str(path) for path in error.args[1]]
    return []


def test_no_circle_between_files(trees):
    graph = {path: imported(path, nodes) for path, nodes in trees.items()}
    assert sum(len(files) for files in graph.values()) > 2 * len(graph)  # the walk sees imports
    assert circle(graph) == []


def test_the_walk_sees_a_circle():
    a, b, c = Path("a.py"), Path("b.py"), Path("c.py")
    assert circle({a: {b}, b: {c}, c: {a}})
    assert circle({a: {b, c}, b: {c}}) == []


def room_of(path: Path) -> str:
    return path.parts[0].removesuffix(".py")


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def taken(path: Path, nodes: Iterable[ast.AST]) -> list[str]:
    """What the file at `path` takes from another room that is private there: a file, or a name in one."""
    found = []
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node.level:
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            for alias in node.names:
                parts = (*base.parts, alias.name)
                own = parts[0] == room_of(path) or len(parts) == 1
                if not own and any(is_private(part) for part in parts[1:]):
                    found.append("/".join(parts))
    return found


def test_what_is_private_stays_in_its_room(trees):
    assert [f"{path} takes {what}" for path, nodes in trees.items() for what in taken(path, nodes)] == []


@pytest.mark.parametrize(
    "source", ["from ..skin._points import points", "from ..skin.base import _helper", "from ..skin import _points"]
)
def test_the_walk_sees_what_is_private(source):
    assert len(taken(Path("contact/line.py"), ast.walk(ast.parse(source)))) == 1


@pytest.mark.parametrize(
    "source", ["from ._points import points", "from .._check import real", "from .. import _check"]
)
def test_the_walk_passes_what_is_the_rooms_own(source):
    assert taken(Path("skin/round.py"), ast.walk(ast.parse(source))) == []


def test_a_class_has_a_name_of_its_own(trees):
    names = Counter(
        node.name
        for nodes in trees.values()
        for node in nodes
        if isinstance(node, ast.ClassDef) and not is_private(node.name)
    )
    assert [name for name, count in names.items() if count > 1] == []


OLD_WORDS = re.compile(r"\b(spacings?|spots?|places?)\b", re.IGNORECASE)
IDIOMS = re.compile(
    r"\bin (the )?place\b|\btakes? (the|its|their) place\b|\bbeside its place\b|\bblind spots?\b", re.IGNORECASE
)


def test_one_word_a_thing():
    """Position, not place or spot; pitch, not spacing: in names, messages, labels and docstrings alike."""
    said = [
        f"{path}:{number}: {line.strip()}"
        for path in sorted(p for p in ROOT.rglob("*") if p.suffix in {".py", ".pyi", ".toml", ".css"})
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if OLD_WORDS.search(IDIOMS.sub("", line))
    ]
    assert said == []


def test_each_benchmark_stands_in_their_list():
    folder = Path(__file__).parents[2] / "benchmarks"
    programs = {path.name for kind in ("bench", "study") for path in folder.glob(f"{kind}_*.py")}
    assert (
        set(re.findall(r"`python benchmarks/((?:bench|study)_\w+\.py)", (folder / "README.md").read_text())) == programs
    )
