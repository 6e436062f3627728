"""How long it takes to begin: imports, the command line, the first answers.

    python benchmarks/bench_start.py [--repeats 15] [--json FILE]

The processes take turns, so that a busy machine slows all of them. Asked for: `import subskin` at most 1.6 times
`import numpy`, `subskin --help` 0.3 s, 1.5 s for a second process that locates; and after an installation, a first
call less the next one, 4 s on a row and 6 s with a width or on an area. A first call goes in plain Python; "compiled"
is what the loop costs once its first 16 frames are over.
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
ROW = """
import subskin as ss
finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(8, 1.5e-3, 2e-3, noise=5e-4))
readings = finger.read(ss.Hertz(force=40.0, angle=0.3, position=0.8e-3, half_width=0.4e-3))
"""
AREA = """
import subskin as ss
array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=20.0)
finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
readings = finger.read(ss.PointLoad(force=1.5, angle=0.3, azimuth=0.8, position=(1e-3, -2e-3)))
"""
ANSWERS = {
    "locate, on a row": (ROW, "finger.locate(readings)"),
    "fit, on a row": (ROW, "finger.fit(readings)"),
    "contact_type, on a row": (ROW, "ss.decide.contact_type(finger, readings)"),
    "pressure_map, on a row": (ROW, "ss.pressure_map(finger, readings)"),
    "locate, on an area": (AREA, "finger.locate(readings)"),
    "fit of a round contact": (AREA, "finger.fit(readings, 'round_hertz')"),
    "contact_type, on an area": (AREA, "ss.decide.contact_type(finger, readings)"),
}
TIMED = """
import sys, time
from contextlib import nullcontext
from subskin import _compiled

def seconds(context):
    begin = time.process_time()
    with context:
        {call}
    return time.process_time() - begin

compiled = getattr(_compiled, "at_once", nullcontext)()
print(*(seconds(context) for context in (nullcontext(), nullcontext(), compiled)))
"""


def first_answers() -> list[list[str]]:
    """Seconds of a process with nothing kept: the first call, the next, and the loop compiled."""
    rows = []
    for name, (prepared, call) in ANSWERS.items():
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-c", prepared + TIMED.format(call=call)]
            environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
            said = subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout
        rows.append([name, *(f"{float(seconds):.2f}" for seconds in said.split())])
    return rows


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
    show("First answers, CPU s", ["", "first call", "the next", "compiled"], first_answers(), options.json)


if __name__ == "__main__":
    main()
