"""How long it takes to begin: imports, the command line, the first `locate`.

    python benchmarks/bench_start.py [--repeats 15] [--json FILE]

The processes take turns, so that a busy machine slows all of them. Asked for: `import subskin` at most 1.6 times
`import numpy`, `subskin --help` 0.3 s, and 1.5 s for a second process that locates.
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

FIRST = "import subskin as ss; ss.HalfPlane, ss.Material, ss.SensorArray, ss.Finger, ss.Hertz"
LOCATE = """
import subskin as ss
finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(4, 2e-3, 2e-3, noise=1e-4))
finger.locate(finger.read(ss.LineLoad(40.0, 0.1, 1e-3)))
"""


def run(command: list[str], **environment: str) -> tuple[float, str]:
    """Wall time of a process and what it said on stderr."""
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=True, env={**os.environ, **environment})
    return time.perf_counter() - start, done.stderr.strip()


def modules(command: list[str]) -> int:
    """How many modules a process imports."""
    return run([command[0], "-X", "importtime", *command[1:]])[1].count("import time:") - 1


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, repeats=15)
    python = sys.executable
    subskin = str(Path(python).with_name("subskin"))
    commands = {
        "python -c pass": [python, "-c", "pass"],
        "import numpy": [python, "-c", "import numpy"],
        "import subskin": [python, "-c", "import subskin"],
        "the names of a first program": [python, "-c", FIRST],
        "subskin --help": [python, subskin, "--help"],
        "subskin locate --help": [python, subskin, "locate", "--help"],
    }
    times = np.array([[run(command)[0] for command in commands.values()] for _ in range(options.repeats)])
    medians = np.median(times, axis=0)
    ratios = np.median(times / times[:, [1]], axis=0)
    rows = [
        [name, f"{seconds:.3f}", f"{ratio:.2f}", str(modules(command)), ""]
        for (name, command), seconds, ratio in zip(commands.items(), medians, ratios)
    ]
    with tempfile.TemporaryDirectory() as folder:
        locate = [python, "-c", LOCATE]
        for name, repeats in (("first process that locates", 1), ("second process that locates", options.repeats)):
            seen = [run(locate, NUMBA_CACHE_DIR=folder) for _ in range(repeats)]
            seconds = float(np.median([seconds for seconds, _ in seen]))
            rows.append([name, f"{seconds:.3f}", f"{seconds / medians[1]:.2f}", str(modules(locate)), seen[-1][1]])
    show("Beginning", ["", "s, whole process", "times numpy", "modules", "it says"], rows, options.json)


if __name__ == "__main__":
    main()
