"""How long it takes to begin: imports, the command line, the first `locate`.

    python benchmarks/bench_start.py [--repeats 7] [--json FILE]

Asked for: `import subskin` 0.25 s, `subskin --help` 0.3 s, and 1.5 s for a second process that locates.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from _common import arguments, show

LOCATE = """
import subskin as ss
finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(4, 2e-3, 2e-3, noise=1e-4))
finger.locate(finger.read(ss.LineLoad(40.0, 0.1, 1e-3)))
"""


def run(command: list[str], repeats: int, **environment: str) -> tuple[float, str]:
    """Median wall time of a process and what it said on stderr the last time."""
    times, said = [], ""
    for _ in range(repeats):
        start = time.perf_counter()
        done = subprocess.run(
            command, capture_output=True, text=True, check=True, env={**os.environ, **environment}
        )
        times.append(time.perf_counter() - start)
        said = done.stderr.strip()
    return float(np.median(times)), said


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, repeats=7)
    python = sys.executable
    rows = []
    for name, command in (
        ("python -c pass", [python, "-c", "pass"]),
        ("import numpy", [python, "-c", "import numpy"]),
        ("import subskin", [python, "-c", "import subskin"]),
        ("subskin --help", [str(Path(python).with_name("subskin")), "--help"]),
    ):
        rows.append([name, f"{run(command, options.repeats)[0]:.2f}", ""])
    with tempfile.TemporaryDirectory() as folder:
        seconds, said = run([python, "-c", LOCATE], 1, NUMBA_CACHE_DIR=folder)
        rows.append(["first process that locates", f"{seconds:.2f}", said])
        seconds, said = run([python, "-c", LOCATE], options.repeats, NUMBA_CACHE_DIR=folder)
        rows.append(["second process that locates", f"{seconds:.2f}", said])
    show("Beginning", ["", "s, whole process", "it says"], rows, options.json)


if __name__ == "__main__":
    main()
