"""Machine code that Numba keeps is made anew when what it was made of changes.

Numba looks at the text of the file that a function stands in, and not at the files it imports compiled functions from:
code that was kept would go on calling what they were. So such a loop names what it is built on.
"""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

import subskin
from subskin._compiled import is_cached

ROOT = Path(subskin.__file__).parent
COMPILED = {path for path in ROOT.rglob("*.py") if "@compiled(" in path.read_text() and path.name != "_compiled.py"}


def imported(path):
    """The compiled modules from which the one at `path` imports functions."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            folder = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            found |= {folder.with_suffix(".py")} & COMPILED
            found |= {folder / f"{alias.name}.py" for alias in node.names} & COMPILED
    return sorted(module.stem for module in found)


def named(path):
    """The modules that the loops at `path` are built on."""
    tree = ast.parse(path.read_text())
    aliases = {
        alias.asname or alias.name: alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.level
        for alias in node.names
    }
    names = {
        element.id
        for node in ast.walk(tree)
        if isinstance(node, ast.keyword) and node.arg == "built_on"
        for element in node.value.elts
    }
    return sorted(aliases[name] for name in names)


@pytest.mark.parametrize("path", sorted(COMPILED), ids=lambda path: str(path.relative_to(ROOT)))
def test_names_what_it_is_built_on(path):
    assert named(path) == imported(path)


def test_some_are_built_on_others():
    assert imported(ROOT / "estimate" / "project.py") == ["climb", "ends", "scan"]


def test_a_loop_in_plain_python_need_not_be_compiled():
    assert is_cached(lambda: None)


def test_what_was_kept_is_thrown_away_when_what_it_is_built_on_changes(tmp_path):
    (tmp_path / "below.py").write_text(
        "from subskin._compiled import compiled\n\n@compiled()\ndef number():\n    return 1\n"
    )
    (tmp_path / "above.py").write_text(
        "import below\nfrom below import number\nfrom subskin._compiled import compiled\n\n"
        "@compiled(built_on=(below,))\ndef twice():\n    return 2 * number()\n\nprint(twice())\n"
    )

    def run():
        made = subprocess.run([sys.executable, "above.py"], cwd=tmp_path, capture_output=True, text=True, check=True)
        return made.stdout.strip()

    assert run() == "2"
    text = (tmp_path / "below.py").read_text()
    (tmp_path / "below.py").write_text(text.replace("return 1", "return 5"))
    later = (tmp_path / "below.py").stat().st_mtime + 5  # clocks of files are coarse
    os.utime(tmp_path / "below.py", (later, later))
    assert run() == "10"
