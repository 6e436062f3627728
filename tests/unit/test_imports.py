"""Data flows one way, and so do imports."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import subskin

ROOT = Path(subskin.__file__).parent
# A module imports only what stands to the left of it, or what stands beside it in its own package.
ORDER = (
    "_lazy",
    "errors",
    "_check",
    "_presets",
    "_shown",
    "_cold",
    "_compiled",
    "_lanes",
    "_compiling",
    "_frozen",
    "_declared",
    "_hooks",
    "_axes",
    "_verb",
    "_tasks",
    "material",
    "tensor",
    "loads",
    "contact",
    "skin",
    "transducer",
    "lattice",
    "array",
    "spread",
    "measured",
    "tolerances",
    "faults",
    "finger",
    "prepared",
    "_cell",
    "response",
    "_radial_kernel",
    "radial",
    "radial_round",
    "reader",
    "pressing",
    "estimate",
    "calibration",
    "decide",
    "stream",
    "synthetic",
    "memo",
    "design",
    "afferents",
    "io",
    "mujoco",
    "grasp",
    "plot",
    "report",
    "live",
    "studio",
    "cli",
    "__main__",
)
MODULES = sorted(path.relative_to(ROOT) for path in ROOT.rglob("*.py"))


def part_of(path: Path) -> str:
    return path.parts[0].removesuffix(".py")


def targets(node: ast.Import | ast.ImportFrom, path: Path) -> list[str]:
    """Parts of subskin that an import statement of the module at `path` names."""
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    elif node.level == 0:
        names = [node.module or ""]
    else:
        package = ("subskin", *path.parts[:-1])
        base = ".".join(package[: len(package) - node.level + 1])
        names = [f"{base}.{node.module}"] if node.module else [f"{base}.{alias.name}" for alias in node.names]
    parts = [name.split(".")[1] for name in names if name.startswith("subskin.")]
    return [part for part in parts if (ROOT / part).is_dir() or (ROOT / f"{part}.py").is_file()]  # else a name in it


def imports(path: Path, source: str) -> list[tuple[str, int]]:
    """(part imported, line), without what is imported for the type checker alone."""
    found: list[tuple[str, int]] = []

    def visit(node: ast.AST) -> None:
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            return
        if isinstance(node, ast.Import | ast.ImportFrom):
            found.extend((part, node.lineno) for part in targets(node, path))
        for child in ast.iter_child_nodes(node):
            if not isinstance(child, ast.expr):  # most of the tree, and never with an import in it
                visit(child)

    visit(ast.parse(source))
    return found


def back_arrows(path: Path, source: str) -> list[str]:
    here = part_of(path)
    wrong = []
    for part, line in imports(path, source):
        if part != here and (part not in ORDER or ORDER.index(part) > ORDER.index(here)):
            wrong.append(f"{path}:{line} imports {part}")
    return wrong


@pytest.mark.parametrize("path", [m for m in MODULES if m != Path("__init__.py")], ids=str)
def test_imports_run_one_way(path):
    assert part_of(path) in ORDER, f"give {path} its place in ORDER"
    assert back_arrows(path, (ROOT / path).read_text()) == []


@pytest.mark.parametrize(
    ("path", "source"),
    [
        ("contact/line.py", "from ..skin import HalfPlane"),
        ("contact/line.py", "from .. import finger"),
        ("material.py", "def f():\n    from .contact.base import Contact"),
        ("array.py", "import subskin.finger"),
        ("finger.py", "from .estimate.search import Locator"),
        ("finger.py", "def read():\n    from .estimate.search import Locator"),
        ("estimate/locate.py", "from ..plot import style"),
        ("io/files.py", "from ..cli.main import main"),
    ],
)
def test_the_walk_sees_an_arrow_that_runs_back(path, source):
    assert len(back_arrows(Path(path), source)) == 1


@pytest.mark.parametrize(
    ("path", "source"),
    [
        ("finger.py", "if TYPE_CHECKING:\n    from .estimate.search import Locator"),
        ("contact/line.py", "from .base import Contact\nfrom .. import _check\nfrom ..material import Material"),
    ],
)
def test_the_walk_passes_what_is_allowed(path, source):
    assert back_arrows(Path(path), source) == []


def test_only_plot_imports_matplotlib():
    naming = {path: text for path in MODULES if "matplotlib" in (text := (ROOT / path).read_text())}
    users = {
        part_of(path)
        for path, text in naming.items()
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in ([a.name for a in node.names] if isinstance(node, ast.Import) else [node.module or ""])
        if name.split(".")[0] == "matplotlib"
    }
    assert users <= {"plot"}


HEAVY = ("numba", "matplotlib", "pint", "pydantic", "pandas", "pyarrow", "scipy", "rich", "tomlkit")


def loaded(code: str) -> set[str]:
    """Modules that a fresh process has loaded after `code`."""
    code += "\nimport sys; print('\\n' + ' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


def test_import_is_light():
    """What is slow to load is loaded by the call that needs it, and a room by the name that is used."""
    modules = loaded("import subskin")
    assert modules.isdisjoint(HEAVY)
    assert {m for m in modules if m.startswith("subskin")} == {"subskin", "subskin._lazy"}


def test_a_finger_is_light():
    """The first use of a name loads its room and what that stands on."""
    modules = loaded("import subskin as ss; ss.Finger, ss.SensorArray, ss.HalfPlane, ss.design")
    assert {"subskin.skin", "subskin.design"} <= modules
    assert modules.isdisjoint({*HEAVY, "subskin.estimate", "subskin.plot", "subskin.memo", "subskin.design.search"})


def test_recordings_are_simulated_without_a_compiler():
    assert "numba" not in loaded("import subskin.synthetic.recording")


@pytest.mark.parametrize("command", ["locate", "figures"])
def test_a_command_loads_no_other(command):
    code = f"from subskin.cli import main\ntry: main(['{command}', '--help'])\nexcept SystemExit: pass"
    modules = loaded(code)
    assert f"subskin.cli.{command}" in modules
    assert modules.isdisjoint({*HEAVY, "numpy", "subskin.cli.calibrate", "subskin.cli.design", "subskin.finger"})
