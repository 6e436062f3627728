"""Run benchmarks here and in another checkout by turns, and show the figures that differ.

    python benchmarks/beside.py TREE [bench_speed.py ...] [--rounds 3] [--above 5] [--options WORDS] [--json FILE]

TREE is a checkout of another version (`git worktree add ../before v0.1.0`); each runs its own scripts with its own
code. WORDS are options of the scripts. Shown are the medians over the rounds of each figure in their tables, and the
ratio here / there, where it is off 1 by more than `--above` percent. Without a name all `bench_*.py` that both have
are run.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from _common import show

HERE = Path(__file__).resolve().parents[1]
FIGURE = re.compile(r"^\s*([-+]?[\d,]*\.?\d+(?:e[-+]?\d+)?)")


def tables(tree: Path, script: str, options: list[str]) -> list[dict]:
    """What one run printed."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "tables.json"
        command = [sys.executable, f"benchmarks/{script}", "--json", str(target), *options]
        env = {**os.environ, "PYTHONPATH": "src"}
        run = subprocess.run(command, cwd=tree, env=env, capture_output=True, text=True, check=False)
        if run.returncode or not target.exists():
            raise SystemExit(f"{script} in {tree}:\n{run.stderr[-2000:]}")
        return json.loads(target.read_text())


def figures(printed: list[dict]) -> dict[tuple[int, int, int], float]:
    """Figures by table, row and column: words may have changed between versions."""
    return {
        (t, r, c): float(match[1].replace(",", ""))
        for t, table in enumerate(printed)
        for r, row in enumerate(table["rows"])
        for c, cell in enumerate(row)
        if c and (match := FIGURE.match(cell))
    }


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tree", type=Path, help="the other checkout")
    parser.add_argument("scripts", nargs="*", help="names of benchmarks (all that both have)")
    parser.add_argument("--rounds", type=int, default=3, help="turns (3)")
    parser.add_argument("--above", type=float, default=5.0, help="percent by which a figure shown has to differ (5)")
    parser.add_argument("--json", type=Path, help="append the tables to this file")
    parser.add_argument("--options", default="", help="words for the scripts, in one string")
    args = parser.parse_args()
    both = {path.name for path in HERE.glob("benchmarks/bench_*.py")} & {
        path.name for path in args.tree.glob("benchmarks/bench_*.py")
    }
    for script in args.scripts or sorted(both):
        trees = (HERE, args.tree.resolve())
        runs = [[tables(tree, script, args.options.split()) for tree in trees] for _ in range(args.rounds)]
        here, there = ([figures(pair[k]) for pair in runs] for k in (0, 1))
        rows = []
        for t, r, c in here[0]:
            if (t, r, c) not in there[0]:
                continue
            one, two = (float(np.median([found.get((t, r, c), np.nan) for found in side])) for side in (here, there))
            if two and abs(one / two - 1) > args.above / 100:
                table = runs[0][0][t]
                rows.append([table["rows"][r][0], table["columns"][c], f"{one:.4g}", f"{two:.4g}", f"{one / two:.2f}"])
        columns = ["row", "figure", "here", "there", "ratio"]
        show(f"{script}, medians of {args.rounds} turns, apart by more than {args.above:g} %", columns, rows, args.json)


if __name__ == "__main__":
    main()
