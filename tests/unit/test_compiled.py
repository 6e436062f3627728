"""Machine code that numba keeps is made anew when what it was made of changes.

Numba looks at the text of the file that a function stands in, and not at the files it imports compiled functions from:
code that was kept would go on calling what they were. So such a file names what it is built on.
"""

import ast
import hashlib
from pathlib import Path

import pytest

import subskin

ROOT = Path(subskin.__file__).parent
COMPILED = {path for path in ROOT.rglob("*.py") if "njit" in path.read_text()}


def imported(path):
    """The compiled modules that the one at `path` imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            folder = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            found |= {folder.with_suffix(".py"), *(folder / f"{name.name}.py" for name in node.names)}
    return sorted(found & COMPILED)


def stamp(paths):
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()[:12]


@pytest.mark.parametrize("path", sorted(COMPILED), ids=lambda path: str(path.relative_to(ROOT)))
def test_says_what_it_is_built_on(path):
    needed = imported(path)
    said = [line for line in path.read_text().splitlines() if line.startswith("BUILT_ON")]
    expected = [f'BUILT_ON = "{stamp(needed)}"'] if needed else []
    assert [line.split("  #")[0] for line in said] == expected, f"put it into {path.name}"


def test_there_are_such_modules():
    kernel = ROOT / "estimate" / "shape" / "_evidence_kernel.py"
    assert {path.name for path in imported(kernel)} >= {"_kernel.py"}
