"""How many small faults the tests would notice: a random sample of mutants, each against the tests nearest to it.

    python benchmarks/study_mutants.py [--minutes 20] [--seed 1] [--budget 20] [--tree FOLDER] [--json FILE]

Lines are drawn at random, none twice, from the rooms of physics and of statuses and from all compiled code. Each gets
one fault, made by an operator of cosmic-ray (`pip install -e ".[study]"`). Left out are faults that change nothing
(annotations, decorators, messages, the compiler's options) and those that stop whatever comes by (bits of floats).
The nearest tests run until one fails, or until they have used `--budget` seconds of processor time (numba's compiling
not counted). So the score is a lower bound: of a survivor no more is known than that these tests let it pass. What
fails or hangs must do so because of the fault: it is run without it too, unless it has passed before. All this is done
in a copy of the tree and within `--minutes`; the last mutant is finished. Ctrl-C ends early, with the tables. It forks,
so it needs Linux or macOS.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
os.environ.pop("NUMBA_CACHE_DIR", None)  # compiled code is kept beside its source, and so comes with the copy

from rich.markup import escape
from scipy.stats import binomtest

from _common import arguments, show
from _forked import run
from _nearest import Nearest, imported

if importlib.util.find_spec("cosmic_ray"):
    from _mutants import Mutant, mutants

# A room that a tree lacks is passed over: trees from before and after a move can be compared.
PHYSICS = {"material", "tensor", "field", "load", "contact", "skin", "transducer", "array", "pressing"}
ROOMS = PHYSICS | {"receptive_field", "response", "estimate", "calibrate", "calibration", "decide"}
KERNEL = re.compile(r"^ *@(\w+\.)?(njit|_?compiled)\b", re.MULTILINE)
TESTS, SLOW = 40, 2.0  # the nearest for each mutant; those that have taken longer come last [s]


class Study:
    """A tree, and what is known of its tests."""

    def __init__(self, tree: Path, budget: float):
        self.tree, self.budget, self.nearest = tree, budget, Nearest(tree)
        self.good: dict[str, float] = {}  # tests that have passed, and their time
        self.bad: set[str] = set()  # tests that fail or hang without a fault
        self.needs = cache(imported)

    def files(self) -> list[Path]:
        """Those of the rooms, and those that numba compiles."""
        files = sorted((self.tree / "src").rglob("*.py"))
        return [path for path in files if self.room(path) in ROOMS or KERNEL.search(path.read_text())]

    def room(self, path: Path) -> str:
        """The folder or file directly under src/subskin."""
        return path.relative_to(self.tree).parts[2].removesuffix(".py")

    def compiled(self, path: Path) -> list[Path]:
        """What numba keeps of this file, and of compiled files that are built on it."""
        sources = {p: p.parents[1] / f"{p.name.split('.')[0]}.py" for p in (self.tree / "src").rglob("*.nb[ic]")}
        stale = {path}
        while more := {source for source in sources.values() if self.needs(source) & stale} - stale:
            stale |= more
        return [p for p, source in sources.items() if source in stale]

    @contextmanager
    def applied(self, mutant: Mutant) -> Iterator[None]:
        """The fault put in; numba notices that the text of a file changes, not that what it calls does."""
        old, times = mutant.path.read_text(), mutant.path.stat()
        kept = [p.rename(f"{p}.kept") for p in self.compiled(mutant.path)]
        mutant.path.write_text(mutant.text)
        try:
            yield
        finally:
            mutant.path.write_text(old)
            os.utime(mutant.path, ns=(times.st_atime_ns, times.st_mtime_ns))
            for p in self.compiled(mutant.path):
                p.unlink()
            for p in kept:
                p.rename(p.with_suffix(""))

    def run(self, tests: list[str], budget: float) -> tuple[str, str, int]:
        """Survived, killed or timed out; the test that did it; how many passed."""
        verdict, test, passed = run(self.tree, tests, budget)
        for name, seconds in passed.items():
            function = name.split("[")[0]
            self.good[function] = max(seconds, self.good.get(function, 0.0))
        return verdict, test, len(passed)

    def judge(self, mutant: Mutant) -> tuple[str, str, int]:
        """What the nearest tests that pass without the fault say of it."""
        tests = self.nearest.tests(mutant.path, mutant.line, TESTS)
        tests.sort(key=lambda test: self.good.get(test, 0.0) > SLOW)
        while tests := [test for test in tests if test not in self.bad]:
            with self.applied(mutant):
                verdict, test, passed = self.run(tests, self.budget)
            name = test.split("[")[0]
            if verdict == "survived" or name in self.good:
                return verdict, test, passed
            if self.run([test] if test else tests, self.budget if "::" in test else 0)[0] == "survived":
                self.good.setdefault(name, 0.0)
                return verdict, test, passed
            if not test:
                raise RuntimeError(f"the tests of {mutant.path} do not start without a fault either: {tests}")
            self.bad |= {name, name.split("::")[0]}  # of a module's examples, all
        return "survived", "", 0


def score(counts: Counter) -> list[str]:
    """A row of the table: numbers, and the share that was noticed with its 95 % interval (Wilson)."""
    total, noticed = counts.total(), counts["killed"] + counts["timed out"]
    low, high = binomtest(noticed, total).proportion_ci(method="wilson")
    numbers = [str(counts[key]) for key in ("killed", "timed out", "survived")]
    return [str(total), *numbers, f"{noticed / total:.0%}", f"{low:.0%} to {high:.0%}"]


def main() -> None:
    """Copy, draw and judge until the time is up; then the tables."""
    args = arguments(__doc__, minutes=20, seed=1, budget=20, tree=Path(__file__).resolve().parents[1])
    if not importlib.util.find_spec("cosmic_ray"):
        print('cosmic-ray is not installed: pip install -e ".[study]"')
        return
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # the copy goes, as with Ctrl-C
    end, rooms, survivors, out = time.monotonic() + 60 * args.minutes, {}, [], args.tree.resolve()
    with tempfile.TemporaryDirectory() as folder, suppress(KeyboardInterrupt):
        tree = Path(folder).resolve() / "tree"
        shutil.copytree(out, tree, ignore=shutil.ignore_patterns(".*", "out", "_build", "gallery"))
        if (out.parent / "shared").exists():
            (tree.parent / "shared").symlink_to(out.parent / "shared")
        study = Study(tree, args.budget)
        for number, mutant in enumerate(mutants(study.files(), args.seed), 1):
            begun = time.monotonic()
            if begun > end:
                break
            verdict, test, passed = study.judge(mutant)
            where = f"{mutant.path.relative_to(tree / 'src/subskin')}:{mutant.line}"
            kind = study.room(mutant.path) + (", compiled" if KERNEL.search(mutant.text) else "")
            rooms.setdefault(kind, Counter())[verdict] += 1
            survivors += [[where, escape(mutant.change), str(passed)]] if verdict == "survived" else []
            took, left = time.monotonic() - begun, max(0, end - time.monotonic()) / 60
            by = f"by {test}" if verdict != "survived" else f"{passed} tests"
            said = f"{number:3}  {verdict} in {took:.0f} s, {left:.1f} min left  {where}  {mutant.change}  ({by})"
            print(said, flush=True)
    if rooms:
        rows = [[name, *score(rooms[name])] for name in sorted(rooms)]
        rows.append(["all", *score(sum(rooms.values(), Counter()))])
        columns = ["room", "mutants", "killed", "timed out", "survived", "noticed", "95 % interval"]
        show(f"Mutants of random lines, seed {args.seed}, {args.minutes} min", columns, rows, args.json)
    if survivors:
        show("Survivors", ["line", "change", "tests passed"], survivors, args.json)


if __name__ == "__main__":
    main()
