"""Which tests are nearest to a line of the sources, by names alone, and which files a file imports."""

from __future__ import annotations

import ast
from collections import Counter, defaultdict
from pathlib import Path

STEPS = 8  # from name to name


def imported(path: Path) -> set[Path]:
    """The files of its package that a file imports from."""
    found: set[Path] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            folder = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            found |= {folder.with_suffix(".py"), *(folder / f"{name.name}.py" for name in node.names)}
    return found


def parts(node: ast.AST) -> list[tuple[str, ast.AST]]:
    """What a statement defines; of a class its methods and fields one by one, with a dot."""
    if isinstance(node, ast.ClassDef):
        inner = [(f"{node.name}.{name}", n) for part in node.body for name, n in parts(part)]
        return [*inner, *((node.name, part) for part in [*node.bases, *node.decorator_list])]
    if isinstance(node, ast.FunctionDef):
        return [(node.name, node)]
    targets = getattr(node, "targets", [getattr(node, "target", None)])
    names = [n.id for t in targets if t for n in ast.walk(t) if isinstance(n, ast.Name)]
    return [(name, node) for name in names if name != "__all__"]


def words(node: ast.AST) -> set[str]:
    """All names in a piece of code, also those in quotes."""
    found = {getattr(n, key, None) for n in ast.walk(node) for key in ("id", "attr", "arg", "value", "name")}
    return {word for word in found if isinstance(word, str) and word.isidentifier()}


class Nearest:
    """Who mentions whom in the sources and tests of a tree.

    A definition is a file and a name in it. It mentions a word; a word that the same file defines means that one, any
    other whatever has that name. From what stands around a line a unit of interest flows to those that mention it,
    in equal shares, and on to those that mention them: rare words carry most, and words that all use nearly nothing.
    """

    def __init__(self, tree: Path):
        self.tree = tree
        self.who: dict[object, set[tuple[Path, str]]] = defaultdict(set)
        for path in sorted([*(tree / "src").rglob("*.py"), *(tree / "tests").rglob("*.py")]):
            text = path.read_text()
            if "subskin.__file__" in text:
                continue  # a test of how the sources are written, not of what they do
            made = [part for node in ast.parse(text).body for part in parts(node)]
            local = {name.split(".")[-1] for name, _ in made}
            for name, node in made:
                for word in words(node):
                    self.who[(path, word) if word in local else word].add((path, name))

    def tests(self, path: Path, line: int, most: int) -> list[str]:
        """Tests as pytest names them, most interested first; those that start processes last.

        One counts for more in a file that is interested, and in one that is named like the file or folder of the line.
        """
        text = path.read_text()
        made = [part for node in ast.parse(text).body for part in parts(node)]
        around = [name for name, node in made if node.lineno <= line <= node.end_lineno]
        flow = Counter({(path, name): 1.0 for name in around or [name for name, _ in made]})
        seen, score, files = set(flow), Counter(), Counter()
        for _ in range(STEPS):
            fresh: Counter[tuple[Path, str]] = Counter()
            for (at, name), share in flow.items():
                method = name.split(".")
                for word in method if len(seen) == len(flow) or method[-1].startswith("_") else method[-1:]:
                    for key in ((at, word),) if at.name.startswith("test_") else ((at, word), word):
                        for one in self.who[key] - seen:
                            fresh[one] += share / len(self.who[key])
            seen |= set(fresh)
            flow = fresh
            for (at, name), share in fresh.items():
                if name.split(".")[-1].startswith("test_"):
                    score[at, name] += share
                    files[at] += share
        slow, about = self.who["subprocess"], {word.strip("_") for word in path.with_suffix("").parts[-3:]}
        near = {at: share * 9 ** sum(word in at.stem for word in about) for at, share in files.items()}
        order = sorted(score, key=lambda one: (one in slow, -score[one] * near[one[0]], one))
        doctests = [(path, "")] if ">>> " in text else []
        ids = [(at.relative_to(self.tree), *filter(None, name.split("."))) for at, name in [*doctests, *order]]
        return ["::".join(map(str, name)) for name in ids[:most]]
